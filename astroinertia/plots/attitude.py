"""How a rigid body turns: its rates about its own axes, its Euler angles, the polhode, and what should be conserved."""

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from astroinertia.dataset.absent import with_absent
from astroinertia.inertia.principal import EQUAL_MOMENTS
from astroinertia.plots import style
from astroinertia.plots.axis_scales import angular_impulse, angular_momentum_scale, energy_scale
from astroinertia.plots.ellipsoid import AXES, LEAST_MOMENT, draw_inertia_ellipsoid, view_of
from astroinertia.rotation.attitude import euler_angles

SPARSE = 0.7  # rad that something turns by from output to output: beyond it, lines would join what is not joined
FASTEST = 2.5  # rad of precession from output to output beyond which turns cannot be counted
STEADY = 1e-6  # change of the direction of L, rad, below which it counts as fixed, and angles are measured from it
SLIGHT_WOBBLE = 1e-4  # of the rate: a wobble that is smaller is drawn by itself
NO_WOBBLE = 1e-12  # of the rate: what is smaller is round-off
_STILL, _SLIGHT = 1e-6, 1e-2  # deg of nutation: below the first none is shown, below the second in mas
_MAS = 1.0 / 3.6e6  # deg


class Motion(NamedTuple):
    """A rigid body's motion: moments (3,) ascending, axes (time, 3, 3) with rows in inertial axes, rates (time, 3)."""

    moments: np.ndarray
    axes: np.ndarray
    rates: np.ndarray


def has_attitude(dataset: xr.Dataset) -> bool:
    """Whether the dataset is of a rigid body that turns.

    >>> print(has_attitude(ds))  # a star of fluid
    False
    """
    return dataset.attrs.get("model") == "rigid" and angular_momentum_scale(dataset)[1]


def motion(dataset: xr.Dataset) -> Motion:
    """The principal axes, continuous in time, and the angular velocity along them.

    They are the attitude where the model records one (which a slight deformation leaves where it is), else the tracked
    axes of the inertia tensor. The moments
    are those of the start: a prescribed size multiplies all of them.
    """
    inertia = dataset["inertia_tensor"].transpose("time", "i", "j").values
    spin = dataset["angular_velocity"].transpose("time", "i").values
    if "attitude" in dataset and np.isfinite(dataset["attitude"].values).all():
        axes = dataset["attitude"].transpose("time", "principal", "i").values
        moments = np.einsum("ki,ij,kj->k", axes[0], inertia[0], axes[0])
        order = np.argsort(moments, kind="stable")
        moments, axes = moments[order], axes[:, order]
    else:
        order = np.argsort(dataset["principal_moments"].transpose("time", "principal").values[0], kind="stable")
        moments = dataset["principal_moments"].transpose("time", "principal").values[0][order]
        axes = dataset["principal_axes"].transpose("time", "principal", "i").values[:, order]
    axes = _oriented(axes, spin[0])
    return Motion(moments, axes, np.einsum("tki,ti->tk", axes, spin))


def _oriented(axes: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """The axes with signs such that they are right-handed and the two that turn fastest at the start do so forwards."""
    rates = axes[0] @ spin
    signs = np.where(rates < 0, -1.0, 1.0)
    signs[np.argmin(abs(rates))] *= np.sign(np.linalg.det(axes[0] * signs[:, None]))
    return axes * signs[:, None]


@with_absent
def attitude_figure(dataset: xr.Dataset) -> Figure:
    """Body rates, nutation and precession, the polhode on the inertia ellipsoid, and conservation.

    >>> import tempfile
    >>> from astroinertia import load, open, run_scene
    >>> scene = load("sims/tennis_racket.toml", ["time.end='3 s'"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     figure = attitude_figure(open(run_scene(scene, folder + "/run")))
    >>> rates = figure.axes[0].lines[1].get_ydata()  # about the axis across the head: the racket flips
    >>> print(bool(rates.min() < 0 < rates.max()))
    True
    """
    rotation = motion(dataset)
    with style.styled():
        figure = style.begin(dataset, "attitude", (12.6, 9.0))
        if not rotation.rates.any():
            style.note(figure.subplots(), "the body does not turn")
            return figure
        grid = figure.add_gridspec(2, 2, width_ratios=[1.25, 1.0], height_ratios=[1.25, 1.0])
        rates, angles = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
        _rates(rates, dataset, rotation)
        _angles(angles, dataset, rotation)
        _polhode(figure.add_subplot(grid[0, 1]), dataset, rotation)
        errors = figure.add_subplot(grid[1, 1])
        _errors(errors, dataset)
        for axes in (rates, angles, errors):
            style.time_axis(axes, dataset, last=axes is not rates)
        return figure


def _sparse(rotation: Motion) -> bool:
    """Whether outputs are too far apart to be joined by lines."""
    size = np.linalg.norm(rotation.rates, axis=1)
    if len(size) < 2 or not (size > 0).all():
        return False
    unit = rotation.rates / size[:, None]
    return bool(np.quantile(np.linalg.norm(np.diff(unit, axis=0), axis=1), 0.9) > SPARSE)


def _gaps(moments: np.ndarray) -> np.ndarray:
    return np.diff(moments) > EQUAL_MOMENTS * moments[2]


def _names(moments: np.ndarray) -> list[str]:
    lower, upper = _gaps(moments)
    names = ["least" if lower else "equal", "middle" if lower and upper else "equal", "greatest" if upper else "equal"]
    return [f"{name} moment" for name in names]


def _rates(axes, dataset: xr.Dataset, rotation: Motion) -> None:
    times, _, _ = style.shown_times(dataset)
    unit = style.unit_of(dataset["angular_velocity"])
    scale, unit = style.scale_of(unit, rotation.rates)
    dots, names = _sparse(rotation), _names(rotation.moments)
    size = abs(rotation.rates).max(axis=0)
    others = np.delete(np.arange(3), np.argmax(size))
    if NO_WOBBLE < size[others].max() / size.max() < SLIGHT_WOBBLE:
        _pole(axes, times, rotation, int(np.argmax(size)), others, names)
        return
    for k in (1, 0, 2):
        how = {"marker": ".", "markersize": 2.5, "linestyle": ""} if dots else {"linewidth": 1.4}
        style.curve(axes, times, rotation.rates[:, k] / scale, color=AXES[k], label=f"axis {k + 1}, {names[k]}", **how)
    axes.axhline(0, color=style.GREY, linewidth=0.8)
    axes.set_ylabel(style.label(r"$\omega_k$", unit))
    axes.set_title("Angular velocity along the body's principal axes" + ("; outputs are far apart" if dots else ""))
    handles, texts = axes.get_legend_handles_labels()
    order = np.argsort(texts)
    style.legend(axes, [handles[k] for k in order], [texts[k] for k in order], loc="upper left", columnspacing=1.2)


def _pole(axes, times: np.ndarray, rotation: Motion, main: int, others: np.ndarray, names: list[str]) -> None:
    """A wobble too small to be seen beside the rotation: where the pole of rotation stands in the body."""
    angles = np.degrees(rotation.rates[:, others] / rotation.rates[:, main, None])
    unit, name = (1.0 / 3600.0, "arcsec") if abs(angles).max() > 1.0 / 3600.0 else (_MAS, "mas")
    for k, angle in zip(others, angles.T, strict=True):
        style.curve(axes, times, angle / unit, color=AXES[k], linewidth=1.4, label=f"axis {k + 1}, {names[k]}")
    axes.axhline(0, color=style.GREY, linewidth=0.8)
    axes.set_ylabel(rf"$\omega_k/\omega_{main + 1}$ ({name})")
    axes.set_title(f"Wobble: the pole of rotation in the body, from axis {main + 1}")
    style.legend(axes, loc="upper left")


def reference_direction(dataset: xr.Dataset) -> tuple[np.ndarray, str]:
    """Where angles are measured from: the angular momentum at the start where its direction stays, else z; its name."""
    momentum = dataset["angular_momentum"].transpose("time", "i").values
    size = np.linalg.norm(momentum, axis=1)
    unit = momentum[size > 0] / size[size > 0, None]  # a brake may stop it altogether
    if np.linalg.norm(unit - unit[0], axis=1).max() < STEADY:
        return unit[0], "the angular momentum"
    return np.array([0.0, 0.0, 1.0]), "$z$"


def nutation_and_precession(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray, int, str]:
    """Angle from the reference direction and angle around it, (time,), of the principal axis nearest to L, its number.

    The precession is continuous; both in radians.
    """
    rotation = motion(dataset)
    direction, name = reference_direction(dataset)
    momentum = rotation.rates * rotation.moments
    figure = int(np.argmax(np.sum(momentum**2, axis=0)))
    order = [(figure + 1) % 3, (figure + 2) % 3, figure]
    helper = np.eye(3)[np.argmin(abs(direction))]
    across = np.cross(direction, helper) / np.linalg.norm(np.cross(direction, helper))
    basis = np.stack([across, np.cross(direction, across), direction])
    angles = euler_angles(rotation.axes[:, order] @ basis.T)
    return angles[:, 1], np.unwrap(angles[:, 0]), figure, name


def _angles(axes, dataset: xr.Dataset, rotation: Motion) -> None:
    times, _, _ = style.shown_times(dataset)
    nutation, precession, figure, name = nutation_and_precession(dataset)
    across = np.sqrt(np.sum(rotation.rates**2, axis=1) - rotation.rates[:, figure] ** 2)
    moved = float(np.median(across)) * float(np.max(np.diff(dataset["time"].values), initial=0.0))  # rad an output
    angle, unit, text = np.degrees(nutation), "deg", "nutation"
    still, slight = np.ptp(angle) < _STILL, _STILL < angle.max() < _SLIGHT  # slight: as a planet's wobble
    if _STILL < np.ptp(angle) < _SLIGHT or slight:
        opening = angle[0] if angle[0] > _SLIGHT else 0.0
        text = f"nutation \N{MINUS SIGN} {opening:.4f} deg" if opening else "nutation"
        angle, unit = (angle - opening) / _MAS, "mas"
    how = {"marker": ".", "markersize": 2.5, "linestyle": ""} if moved > SPARSE else {"linewidth": 1.5}
    style.curve(axes, times, angle, color=style.BLUE, **how)
    if still:
        middle = float(angle.mean())
        axes.set_ylim(middle - max(0.2 * middle, 0.1), middle + max(0.2 * middle, 0.1))
    axes.set_ylabel(f"{text} ({unit})", color=style.BLUE)
    axes.set_title(f"Axis {figure + 1}: its angle from {name}, and around it")
    tilt = float(np.median(np.sin(nutation)))
    if tilt < 1e-9 or moved / tilt > FASTEST:
        return
    around = axes.twinx()
    turns = (precession - precession[0]) / (2 * np.pi)
    small = np.ptp(turns) < 0.5
    around.plot(times, turns * (360.0 if small else 1.0), color=style.VERMILLION, linewidth=1.4, linestyle=(0, (5, 2)))
    around.set_ylabel("precession (deg)" if small else "precession (turns)", color=style.VERMILLION)
    around.grid(False)
    around.spines["right"].set_visible(True)


def _polhode(panel, dataset: xr.Dataset, rotation: Motion) -> None:
    moments = np.maximum(rotation.moments, LEAST_MOMENT * rotation.moments[2])
    gaps = _gaps(moments)
    defined = np.array([gaps[0], gaps.all(), gaps[1]])
    view = view_of(np.eye(3))
    reach = draw_inertia_ellipsoid(panel, moments, np.eye(3), defined, view)
    _track(panel, dataset, rotation, moments, view, reach)
    panel.set_title("Polhode: the tip of $\\omega$ on the inertia ellipsoid")
    text = "dots: start (white), end (black)\n" + ("black line: separatrix" if gaps.all() else "equal moments: circles")
    panel.text(0.03, 0.03, text, transform=panel.transAxes, fontsize=9, color=style.GREY)


def _track(panel, dataset: xr.Dataset, rotation: Motion, moments: np.ndarray, view: np.ndarray, reach: float) -> None:
    """The run's own path, coloured by time, faint behind the ellipsoid."""
    sizes = np.sqrt(np.einsum("tk,k,tk->t", rotation.rates, moments, rotation.rates))
    path = rotation.rates[sizes > 0] / sizes[sizes > 0, None]
    times, _, text = style.shown_times(dataset)
    times = times[sizes > 0]
    u, v = view[:2] @ path.T / reach
    front = (path * moments) @ view[2] > 0
    if _sparse(rotation):
        panel.scatter(u, v, s=np.where(front, 9, 3), c=times, cmap=style.TIME_MAP, linewidth=0, zorder=5)
    else:
        ends = np.stack([np.stack([u, v], axis=-1)[:-1], np.stack([u, v], axis=-1)[1:]], axis=1)
        seen = front[:-1] & front[1:]
        for part, width, alpha in ((seen, 2.4, 1.0), (~seen, 1.2, 0.35)):
            drawn = LineCollection(list(ends[part]), linewidths=width, alpha=alpha, cmap=style.TIME_MAP, zorder=5)
            drawn.set_array(times[:-1][part])
            drawn.set_clim(times[0], times[-1])
            panel.add_collection(drawn)
    for end, filled in ((0, False), (-1, True)):
        if front[end]:
            colour = style.INK if filled else "white"
            panel.plot(u[end], v[end], "o", markersize=5, color=colour, markeredgecolor=style.INK, zorder=8)
    from mpl_toolkits.axes_grid1.inset_locator import inset_axes  # only here: other pictures do without it

    place = inset_axes(panel, width="42%", height="2.5%", loc="lower right", borderpad=2.6)
    norm = Normalize(times[0], max(times[-1], np.nextafter(times[0], np.inf)))
    bar = panel.figure.colorbar(ScalarMappable(norm, style.TIME_MAP), cax=place, orientation="horizontal")
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=8, length=2)
    bar.set_label(text, fontsize=8)


def _errors(axes, dataset: xr.Dataset) -> None:
    times, _, _ = style.shown_times(dataset)
    momentum = dataset["angular_momentum"].transpose("time", "i").values
    impulse = angular_impulse(dataset)
    owned = np.where(np.isfinite(impulse), impulse, 0.0).sum(axis=1)
    turned = abs(dataset["torque"].fillna(0.0).sum("effect")).max() * np.ptp(dataset["time"].values)
    size = angular_momentum_scale(dataset)[0]
    energy = dataset["integration_energy_error"].values
    if not np.isfinite(energy).any():
        energy = dataset["total_energy"].values - dataset["total_energy"].values[0]
    free = float(turned) < STEADY * size
    unowned = np.linalg.norm(momentum - momentum[0] - owned, axis=1) / size
    # Where torques act and the model does not sum what they give, nothing can be said of the angular momentum.
    unowned = unowned if free or np.isfinite(impulse).any() else np.zeros_like(unowned)
    lines = [
        (unowned, "angular momentum", {"color": style.BLUE}),
        (abs(energy) / energy_scale(dataset), "energy", {"color": style.VERMILLION}),
        (dataset["ledger_closure"].values, "ledger closure", {"color": style.GREEN}),
    ]
    axes.set_title("What no effect accounts for, over the largest")
    style.relative_sizes(axes, times, lines)
