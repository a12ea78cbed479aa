"""The matter of a snapshot as pictures need it: where it is, how far it reaches, and how its principal axes lie."""

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.patheffects import withStroke

from astroinertia.dataset.derived import PARTICLE_GAP_TOLERANCE
from astroinertia.dataset.snapshots import present
from astroinertia.errors import ArchiveError
from astroinertia.inertia import principal, tensor

SIDE_ON, POLE_ON = (0, 2), (0, 1)  # what is to the right and upwards in a picture
AXES = ("#8fe3ff", "#8dffb0", "#ffffff")  # of the least, the intermediate and the greatest moment, on dark ground
UNDEFINED = "#b8b8b8"
SHARE_SHOWN = 0.9  # of the mass, which the width of a picture follows
DENSE = 0.1  # of the greatest density: what is denser, such as a second body, is in the picture
CORE = 3.0  # radii of half the mass, which the width follows where matter is so condensed that its core would be a dot
_EDGE = 0.93  # of the half width, where an axis that reaches out of the picture has its number
SINKS = "#ffb454"
_SUPPORT = 2.0  # of the kernel that pictures are drawn with, in smoothing lengths
_OF_PARTICLES = ("position", "velocity", "mass", "size")
_SHORTEST = 0.05  # of the picture's half width: an axis that is seen more end on than this has no number


@dataclass(frozen=True)
class Matter:
    """Particles about the middle of a picture: position and velocity (N, 3), mass and smoothing length (N,).

    sinks: their positions (S, 3) about the same middle. box (3,): lengths after which all repeats itself, or infinite.
    """

    position: np.ndarray
    velocity: np.ndarray
    mass: np.ndarray
    size: np.ndarray
    sinks: np.ndarray
    box: np.ndarray

    def repeated(self, axes: Iterable[int]) -> "Matter":
        """With what lies beyond the faces of the box along some axes and reaches into it."""
        seen = self
        for axis in axes:
            side = self.box[axis]
            if math.isfinite(side):
                moved = [replace(seen, position=seen.position + shift * np.eye(3)[axis]) for shift in (-side, side)]
                near = [abs(each.position[:, axis]) < 0.5 * side + _SUPPORT * each.size for each in moved]
                parts = [seen, *(each.of(there) for each, there in zip(moved, near, strict=True))]
                joined = (np.concatenate([getattr(part, name) for part in parts]) for name in _OF_PARTICLES)
                seen = replace(seen, **dict(zip(_OF_PARTICLES, joined, strict=True)))
        return seen

    def of(self, chosen: np.ndarray) -> "Matter":
        """Some of the particles."""
        return replace(self, **{name: getattr(self, name)[chosen] for name in _OF_PARTICLES})


@dataclass(frozen=True)
class Triad:
    """Principal axes: where they meet (3,), directions as rows (3, 3), semi-axes (3,), and whether each is defined."""

    centre: np.ndarray
    axes: np.ndarray
    lengths: np.ndarray
    defined: np.ndarray


def completed(dataset: xr.Dataset, snapshots: xr.Dataset) -> xr.Dataset:
    """Snapshots with the positions of sinks at their times, and the box that repeats itself, where a run has them."""
    if "box" in dataset.attrs:
        sides = json.loads(str(dataset.attrs["box"]))
        snapshots = snapshots.assign_attrs(box=[math.inf if side is None else float(side) for side in sides])
    if "sink_position" not in dataset:
        return snapshots
    then = dataset["sink_position"].sel(time=snapshots["snapshot_time"], method="nearest")
    return snapshots.assign(sink_position=then.drop_vars("time"))


def matter(snapshot: xr.Dataset, densest: bool = False) -> Matter:
    """The particles about their centre of mass, or about the middle of the densest matter, which is where a body is.

    With the sinks and the box of a snapshot that `completed` made: what has left the box is where it comes in again.
    """
    snapshot = present(snapshot)
    mass = snapshot["mass"].values
    position = snapshot["position"].transpose("particle", "i").values
    velocity = snapshot["velocity"].transpose("particle", "i").values
    weight = mass * snapshot["density"].values if densest else mass
    box = np.array(snapshot.attrs.get("box", [math.inf] * 3))
    filled = np.isfinite(box)
    position = position - np.where(filled, box, 1.0) * np.round(position / box)
    middle = np.where(filled, 0.0, weight @ position / weight.sum())
    sinks = snapshot["sink_position"].transpose("sink", "i").values if "sink_position" in snapshot else np.empty((0, 3))
    return Matter(
        position - middle,
        velocity - mass @ velocity / mass.sum(),
        mass,
        snapshot["smoothing_length"].values,
        sinks[np.isfinite(sinks).all(axis=1)] - middle,
        box,
    )


def reach(particles: Matter) -> float:
    """Half the width of a picture that shows nearly all of the mass and a margin, or the core of condensed matter.

    Of matter that fills a box, half of the box's longest side.
    """
    if np.isfinite(particles.box).all():
        return 0.5 * float(particles.box.max())
    radius = np.linalg.norm(particles.position, axis=1)
    order = np.argsort(radius)
    mass = np.cumsum(particles.mass[order])
    inside = np.minimum(np.searchsorted(mass, np.array([0.5, SHARE_SHOWN]) * mass[-1]), len(order) - 1)
    half, most = radius[order[inside]]
    outermost = radius.max()
    widest = 1.05 * outermost if 1.2 * most < outermost < 1.6 * most else min(1.3 * most, 1.25 * outermost)
    if half == 0.0:
        return float(widest)
    packed = particles.mass / particles.size**3  # as the density
    dense = 1.1 * radius[packed > DENSE * packed.max()].max()
    return float(min(widest, max(np.sqrt(CORE * half * widest), dense)))  # the middle of core and envelope


def triads(states: Iterable[Matter]) -> list[Triad]:
    """Principal axes of particles at several times, each continuous in number and sign.

    They are as long as the semi-axes of the homogeneous ellipsoid with the particles' tensor.
    """
    rows = [
        (tensor.inertia_tensor(particles.mass, particles.position), particles.mass.sum(),
         tensor.centre_of_mass(particles.mass, particles.position))
        for particles in states
    ]  # fmt: skip
    inertia, mass, centres = (np.array(values) for values in zip(*rows, strict=True))
    moments, axes = principal.tracked_frame(inertia, PARTICLE_GAP_TOLERANCE)
    lengths = tensor.equivalent_semi_axes(mass, moments)
    defined = ~principal.undefined_axes(moments, PARTICLE_GAP_TOLERANCE)
    return [Triad(*fields) for fields in zip(centres, axes, lengths, defined, strict=True)]


def triads_of_series(dataset: xr.Dataset, chosen: np.ndarray) -> list[Triad]:
    """The same from the tensors of some outputs; the axes of a rigid body are those that are fixed in it.

    ArchiveError where the tensor is not known.
    """
    if bool(dataset["inertia_tensor"].isnull().any()):
        raise ArchiveError("this run has neither particles nor an inertia tensor: there is no shape to draw.")
    second = tensor.second_moment_from_inertia(dataset["inertia_tensor"].transpose("time", "i", "j").values[chosen])
    fixed = bool(dataset["attitude"].notnull().all())
    axes = dataset["attitude" if fixed else "principal_axes"].transpose("time", "principal", "i").values[chosen]
    squares = 5.0 * np.einsum("tki,tij,tkj->tk", axes, second, axes) / dataset["mass"].values[chosen, None]
    gap = dataset["principal_gap"]
    defined = fixed | (gap.transpose("time", "principal").values[chosen] > float(gap.attrs.get("tolerance", 0.0)))
    lengths = np.sqrt(np.maximum(squares, 0.0))
    return [Triad(np.zeros(3), *triad) for triad in zip(axes, lengths, defined, strict=True)]


def draw_triad(panel: Any, triad: Triad, plane: tuple[int, int], scale: float, half_width: float) -> None:
    """Draw the axes from end to end as they are seen, numbered by moment; dashed and grey where one is undefined."""
    middle = triad.centre[list(plane)]
    outline = [withStroke(linewidth=3.4, foreground="#000000a0")]
    for k in range(3):
        end = triad.lengths[k] * triad.axes[k][list(plane)]
        colour = AXES[k] if triad.defined[k] else UNDEFINED
        dashes = "-" if triad.defined[k] else (0, (3, 2))
        ends = np.stack([middle - end, middle + end], axis=1) / scale
        panel.plot(*ends, color=colour, linewidth=1.7, linestyle=dashes, path_effects=outline, zorder=4)
        size = np.linalg.norm(end)
        if size < _SHORTEST * half_width:
            continue
        room = (_EDGE * half_width - np.sign(end) * middle) / np.maximum(abs(end), 1e-9 * half_width)
        beyond = (middle + end * min(1.0 + 0.075 * half_width / size, float(room.min()))) / scale
        panel.text(
            *beyond, f"{k + 1}", color=colour, fontsize=9, fontweight="bold", ha="center", va="center", zorder=5,
            clip_on=True, path_effects=[withStroke(linewidth=2.4, foreground="black")],
        )  # fmt: skip


def draw_sinks(panel: Any, sinks: np.ndarray, plane: tuple[int, int], scale: float) -> None:
    """Draw sinks (S, 3) as stars."""
    if len(sinks):
        places = sinks[:, list(plane)].T / scale
        panel.plot(*places, "*", color=SINKS, markersize=11, markeredgecolor="black", markeredgewidth=0.7, zorder=4.5)
