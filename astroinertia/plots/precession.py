"""How a planet's axis goes round and nods, what turns it by how much, and what makes up the period of its wobble.

For the Datasets of `studies.precession` and `studies.obliquity`.
"""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from astroinertia.errors import SceneError
from astroinertia.plots import style
from astroinertia.rotation.precession import ARCSECOND, JULIAN_YEAR

_DAY = 86400.0
_CENTURY = 100 * JULIAN_YEAR
_BAR = 0.62
_ROOM = 20.0  # days of a bar that has room for its own label
_BARS_APART = 3.0  # degrees between the widths of resonances beside a section


def precession_figure(dataset: xr.Dataset) -> Figure:
    """Nutation about the steady motion, its loops in space, and the rate by its parts, of `studies.precession`.

    SceneError for another Dataset.
    """
    _require(dataset, "precession_rate", "precession")
    with style.styled():
        figure = style.page(f"{dataset.attrs['body']}: precession and nutation, integrated", (12.0, 8.6))
        grid = figure.add_gridspec(2, 2, width_ratios=[1.35, 1.0], height_ratios=[1.0, 1.0])
        longitude, obliquity = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
        years, along, tilt, mean = _nutation(dataset)
        for axes, values, colour, title in (
            (longitude, along, style.BLUE, "In longitude: how far it is from the steady motion"),
            (obliquity, tilt, style.VERMILLION, "In obliquity: how far it is from the steady motion"),
        ):
            axes.axhline(0, color=style.GREY, linewidth=0.8)
            axes.plot(years, values, color=colour, linewidth=0.9)
            axes.set(title=title, ylabel=style.label("nutation", "arcsec"), xlim=(years[0], years[-1]))
        longitude.tick_params(labelbottom=False)
        obliquity.set_xlabel(style.label("time from J2000", "yr"))
        _loops(figure.add_subplot(grid[0, 1]), years, along * np.sin(mean), tilt, dataset.attrs["body"])
        _parts(figure.add_subplot(grid[1, 1]), dataset)
        return figure


def chandler_figure(dataset: xr.Dataset) -> Figure:
    """The period of the Earth's free wobble from cause to cause, of `studies.precession.chandler_wobble`.

    SceneError for another Dataset.

    >>> from astroinertia.studies.precession import chandler_wobble
    >>> print([text.get_text() for text in chandler_figure(chandler_wobble()).axes[0].texts][-1])
    observed 433 d
    """
    _require(dataset, "period_of_all", "chandler_wobble")
    with style.styled():
        figure = style.page("The Earth's free wobble: what makes its period", (9.6, 5.2))
        axes = figure.subplots()
        causes = [str(cause) for cause in dataset["cause"].values]
        period, change = dataset["period"].values / _DAY, dataset["change"].values / _DAY
        places = np.arange(len(causes))
        for k, (end, by) in enumerate(zip(period, change, strict=True)):
            colour = style.GREY if k == 0 else style.BLUE if by > 0 else style.VERMILLION
            axes.bar(k, by, _BAR, bottom=end - by, color=colour, alpha=0.9)
            if k:
                axes.plot([k - 1 + _BAR / 2, k - _BAR / 2], [end - by] * 2, color=style.GREY, linewidth=0.9)
            label = f"{end:.1f} d" if k == 0 else f"{by:+.1f}".replace("-", "\N{MINUS SIGN}")
            wide = k and abs(by) > _ROOM
            axes.annotate(
                label, (k, end - by / 2 if wide else max(end, end - by)), xytext=(0, 0 if wide else 4), ha="center",
                textcoords="offset points", va="center" if wide else "bottom", color="white" if wide else style.INK,
                fontsize=10, bbox=None if wide else {"facecolor": "white", "edgecolor": "none", "pad": 0.5},
            )  # fmt: skip
        observed = float(dataset["observed_period"]) / _DAY
        whole = float(dataset["period_of_all"]) / _DAY
        axes.axhline(observed, color=style.GREEN, linestyle=(0, (5, 2)), linewidth=1.3)
        axes.annotate(
            f"observed {observed:.0f} d", (-_BAR / 2, observed), xytext=(0, 4), textcoords="offset points", fontsize=9,
            color=style.GREEN,
        )  # fmt: skip
        axes.set_xticks(places, [name.replace("fluid core", "fluid core\nstays behind") for name in causes])
        axes.set(ylim=(250, 1.06 * period.max()), ylabel=style.label("period", "d"))
        axes.grid(axis="x", visible=False)
        axes.set_title(f"All causes together: {whole:.1f} d, and Q = {float(dataset['quality']):.0f} from anelasticity")
        return figure


def section_figure(section, eccentricity: float, asphericity: float, resonances: tuple[float, ...] = ()) -> Figure:
    """A surface of section of `rotation.spin_orbit`: angle of the long axis and rate at each pericentre.

    resonances: p of those whose width is drawn in the margin.

    >>> from astroinertia.rotation.spin_orbit import surface_of_section
    >>> section = surface_of_section(0.1, 0.2, np.zeros(5), np.linspace(0.5, 2.0, 5), 20, 24)
    >>> (axes,) = section_figure(section, 0.1, 0.2, (1, 1.5)).axes
    >>> print(axes.get_xlabel())
    angle of the long axis from the pericentre (deg)
    """
    # Only here: the other figures do without.
    from astroinertia.rotation.spin_orbit import resonance_half_width

    with style.styled():
        figure = style.page("Spin at the pericentre, orbit after orbit", (8.2, 7.2))
        axes = figure.subplots()
        angle, rate = (np.asarray(values).reshape(len(section.angle), -1) for values in section)
        size = 1.2 if angle.size < 40000 else 0.35
        colours = style.COLOURS[:-1]
        for k in range(angle.shape[1]):
            axes.plot(np.degrees(angle[:, k]), rate[:, k], ".", markersize=size, color=colours[k % len(colours)])
        for k, p in enumerate(resonances):
            width, place = resonance_half_width(p, eccentricity, asphericity), 93 + _BARS_APART * k
            axes.plot([place, place], [p - width, p + width], color=style.INK, linewidth=3, solid_capstyle="butt")
            axes.annotate(
                f"{p:g}", (place, p + width), xytext=(0, 3), textcoords="offset points", ha="center", fontsize=8.5
            )
        axes.set(xlim=(-90, 93 + _BARS_APART * len(resonances) if resonances else 90), xticks=range(-90, 91, 30))
        axes.set_xlabel(style.label("angle of the long axis from the pericentre", "deg"))
        axes.set_ylabel("spin over orbital rate")
        axes.set_title(rf"$e$ = {eccentricity:g}, $(3(B-A)/C)^{{1/2}}$ = {asphericity:.3g}")
        return figure


def obliquity_figure(dataset: xr.Dataset) -> Figure:
    """The obliquity against time, of `studies.obliquity.obliquity_history`.

    SceneError for another Dataset.

    >>> from astroinertia.studies.obliquity import obliquity_history
    >>> (axes,) = obliquity_figure(obliquity_history("Mars", 1e6, samples=200)).axes
    >>> print(axes.get_ylabel(), bool(np.ptp(axes.lines[0].get_ydata()) > 5.0))
    obliquity (deg) True
    """
    _require(dataset, "inclination", "obliquity_history")
    with style.styled():
        figure = style.page(f"{dataset.attrs['body']}: obliquity on a moving orbit", (10.0, 4.6))
        axes = figure.subplots()
        times, obliquity = dataset["time"].values, np.degrees(dataset["obliquity"].values)
        scale, unit = (1e9 * JULIAN_YEAR, "Gyr") if np.ptp(times) > 3e8 * JULIAN_YEAR else (1e6 * JULIAN_YEAR, "Myr")
        axes.plot(times / scale, obliquity, color=style.BLUE, linewidth=0.6)
        axes.set(xlim=(times[0] / scale, times[-1] / scale), xlabel=style.label("time from J2000", unit))
        axes.set_ylabel(style.label("obliquity", "deg"))
        axes.set_title(f"Between {obliquity.min():.2f} and {obliquity.max():.2f} degrees")
        return figure


def _require(dataset: xr.Dataset, variable: str, study: str) -> None:
    if variable not in dataset:
        raise SceneError(f"this figure is of the Dataset of {study}, which has {variable}")


def _nutation(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Years, longitude and obliquity less their steady parts in arc seconds, and the mean obliquity."""
    along, tilt = (
        (dataset[name] - dataset[f"steady_{name}"]).values / ARCSECOND for name in ("longitude", "obliquity")
    )
    return dataset["time"].values / JULIAN_YEAR, along, tilt, float(dataset["steady_obliquity"].mean())


def _loops(axes, years: np.ndarray, across: np.ndarray, tilt: np.ndarray, name: str) -> None:
    mesh = axes.scatter(across, tilt, c=years, s=1.6, cmap=style.TIME_MAP, linewidths=0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title(f"The pole of {'the ' if name == 'Earth' else ''}{name} about its mean place")
    axes.set(xlabel=style.label("longitude × sin(obliquity)", "arcsec"), ylabel=style.label("obliquity", "arcsec"))
    bar = axes.figure.colorbar(mesh, ax=axes, fraction=0.05, pad=0.02)
    bar.set_label(style.label("time from J2000", "yr"))


def _parts(axes, dataset: xr.Dataset) -> None:
    axes.set_axis_off()
    axes.set_title("What turns it: arc seconds a century")

    def value_text(value: float) -> str:
        return f"{value / ARCSECOND * _CENTURY:,.3f}".replace(",", " ").replace("-", "\N{MINUS SIGN}")

    rows = [
        (f"torque of the {part}" if part in ("Sun", "Moon", "planets") else "all together, integrated",
         float(dataset["precession_rate"].sel(part=part)))
        for part in [*(p for p in dataset["part"].values if p != "all"), "all"]
    ]  # fmt: skip
    rows += [
        (str(name), float(dataset["correction_rate"].sel(correction=name))) for name in dataset["correction"].values
    ]
    rows += [("corrected", float(dataset["corrected_rate"])), ("published", float(dataset["published_rate"]))]
    for k, (name, value) in enumerate(rows):
        y = 0.94 - 0.085 * k
        whole = name.startswith(("all", "corrected", "published"))
        weight = "bold" if whole else "normal"
        axes.text(0.0, y, name, transform=axes.transAxes, fontsize=9, fontweight=weight, va="center")
        axes.text(
            1.0, y, value_text(value), transform=axes.transAxes, fontsize=9, fontweight=weight, va="center", ha="right"
        )
    difference = float(dataset["difference"])
    sign = "\N{MINUS SIGN}" if difference < 0 else "+"
    axes.text(
        0.0, 0.94 - 0.085 * len(rows), f"corrected over published: 1 {sign} {style.number(abs(difference), 2)}",
        transform=axes.transAxes, fontsize=9, color=style.GREY, va="center",
    )  # fmt: skip
