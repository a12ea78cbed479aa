"""A page that shows the body of a run to turn about: its particles or its ellipsoid, with the principal axes."""

import base64
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.colors import to_hex

from astroinertia.dataset.absent import with_absent
from astroinertia.pages.page import HERE, data_block, filled, name_of, policy, text, write_page
from astroinertia.plots import film, style
from astroinertia.plots.axis_scales import angular_momentum_scale
from astroinertia.plots.matter import Triad, matter, reach, triads, triads_of_series
from astroinertia.plots.shown_units import raised, written

MOST_PARTICLES = 4000  # that a browser turns smoothly; all are kept below, a random choice above
MOST_FRAMES = 48
FARTHEST = 4.0  # half widths of the picture, beyond which particles are left at its edge
_COLOURS, _DARKEST = 64, 0.18  # of the map, whose darkest part is not seen on black
_LARGEST = 32767
_DOT = 0.7  # half widths, over the root of the number of particles
_LASTS, _LONGEST = 6.0, 0.25  # seconds of a film, and of one picture


@with_absent
def write_view(dataset: xr.Dataset, snapshots: xr.Dataset | None, path: Path) -> int:
    """Write the page; how many times it shows. ArchiveError where it cannot be written.

    Tests: tests/unit/pages/test_pages.py.
    """
    numbers = film.chosen(dataset, snapshots)
    numbers = numbers[np.linspace(0, len(numbers) - 1, min(len(numbers), MOST_FRAMES)).round().astype(int)]
    frames = list(_of_series(dataset, numbers) if snapshots is None else _of_particles(snapshots, numbers))
    for frame, caption in zip(frames, _captions(dataset, snapshots, numbers), strict=True):
        frame["caption"] = caption
    shown = 1 if snapshots is None else min(snapshots.sizes["particle"], MOST_PARTICLES)
    colours = matplotlib.colormaps[style.DENSITY_MAP](np.linspace(_DARKEST, 1.0, _COLOURS))
    data = {
        "frames": frames,
        "map": [to_hex(colour) for colour in colours],
        "dot": _DOT * frames[0]["width"] / shown**0.5,
        "pause": min(_LASTS / len(frames), _LONGEST),
        "lengths": _length_units(dataset, [frame["width"] for frame in frames]),
    }
    script = (HERE / "view.js").read_text(encoding="utf-8")
    page = filled(
        "view.html", policy=text(policy(script)), name=text(name_of(dataset)), legend=_legend(snapshots, data["map"]),
        data=data_block(data), script=script,
    )  # fmt: skip
    write_page(path, page)
    return len(frames)


def _of_particles(snapshots: xr.Dataset, numbers: np.ndarray) -> Iterator[dict[str, Any]]:
    count = snapshots.sizes["particle"]
    kept = np.random.default_rng(0).permutation(count) < MOST_PARTICLES
    low, high = _densities(snapshots, numbers)

    def at(number: int):
        return matter(snapshots.isel(snapshot_time=int(number)).load())

    axes = triads(at(number) for number in numbers)
    widths = film.camera(np.array([reach(at(number)) for number in numbers]))
    for number, triad, width in zip(numbers, axes, widths, strict=True):
        density = snapshots["density"].isel(snapshot_time=int(number)).values
        there = np.isfinite(density)  # what sinks have accreted is NaN
        density, seen = density[there & kept], kept[there]
        share = np.log(np.maximum(density, low) / low) / np.log(high / low)
        order = np.argsort(share, kind="stable")  # the densest are drawn last, and seen through what lies before them
        span = FARTHEST * width
        places = np.clip(at(number).position[seen][order] / span, -1.0, 1.0)
        colours = np.clip(share[order] * (_COLOURS - 1), 0, _COLOURS - 1).round().astype(np.uint8)
        yield _frame(triad, width) | {
            "span": float(span),
            "points": _coded((places * _LARGEST).round().astype("<i2")),
            "colours": _coded(colours),
        }


def _densities(snapshots: xr.Dataset, numbers: np.ndarray) -> tuple[float, float]:
    """The densities that the darkest and the brightest colour stand for."""
    extremes = []
    for number in numbers:  # one at a time: all together may be larger than memory
        density = snapshots["density"].isel(snapshot_time=int(number)).values
        extremes.append((float(np.nanpercentile(density, 5.0)), float(np.nanmax(density))))
    low, high = min(low for low, _ in extremes), max(high for _, high in extremes)
    return low, max(high, 1.01 * low)


def _of_series(dataset: xr.Dataset, numbers: np.ndarray) -> Iterator[dict[str, Any]]:
    axes = triads_of_series(dataset, numbers)
    widths = film.camera(np.array([film.MARGIN * triad.lengths.max() for triad in axes]))
    for triad, width in zip(axes, widths, strict=True):
        yield _frame(triad, width)


def _frame(triad: Triad, width: float) -> dict[str, Any]:
    return {
        "width": float(width),
        "axes": triad.axes.round(6).tolist(),
        "lengths": [float(f"{length:.6g}") for length in triad.lengths],
        "defined": np.broadcast_to(triad.defined, 3).tolist(),
    }


def _captions(dataset: xr.Dataset, snapshots: xr.Dataset | None, numbers: np.ndarray) -> Iterator[str]:
    """What is said at each time: the time, the moment of inertia and the spin."""
    time = dataset["time"].values
    times = time[numbers] if snapshots is None else snapshots["snapshot_time"].values[numbers]
    shown = [("time", dataset["time"], times), ("moment about z", dataset.inertia.about_axis("z"), None)]
    if angular_momentum_scale(dataset)[1]:
        shown.append(("mean angular velocity", dataset.inertia.spin_rate(), None))
    columns = []
    for name, series, values in shown:
        factor, unit = style.scale_of(style.unit_of(series), series.values)
        sampled = np.interp(times, time, series.values) if values is None else values
        columns.append([raised(f"{name} {written(value, factor, unit)}") for value in sampled])
    return ("\n".join(lines) for lines in zip(*columns, strict=True))


def _length_units(dataset: xr.Dataset, widths: list[float]) -> list[tuple[float, str]]:
    """Sizes and names of the units that a scale may be in, the smallest first."""
    own = style.unit_of(dataset["mean_radius"])
    tried = np.geomspace(1e-3 * min(widths), 10.0 * max(widths), 200)
    units = dict.fromkeys(style.readable(own, width) or (1.0, "" if own == "1" else own) for width in tried)
    return [(factor, raised(name)) for factor, name in sorted(units)]


def _legend(snapshots: xr.Dataset | None, colours: list[str]) -> str:
    if snapshots is None:
        return "drawn as the homogeneous ellipsoid<br>that has its inertia tensor"
    low, high = _densities(snapshots, np.arange(snapshots.sizes["snapshot_time"]))
    unit = style.unit_of(snapshots["density"])
    named = raised(f"density {_power(low)} to {_power(high)} {unit}".removesuffix(" 1"))
    count = snapshots.sizes["particle"]
    kept = f"<br>{MOST_PARTICLES} of {count} particles" if count > MOST_PARTICLES else ""
    return f'{text(named)}<div style="background:linear-gradient(90deg,{",".join(colours[::9])})"></div>{kept}'


def _power(value: float) -> str:
    digits, exponent = f"{value:.1e}".split("e")
    return f"{digits} × 10^{int(exponent)}"


def _coded(values: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()
