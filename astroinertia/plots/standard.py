"""A standard problem beside its exact flow: density, velocity and pressure at the end of the run."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from astroinertia.dataset.absent import with_absent
from astroinertia.errors import SceneError
from astroinertia.plots import style
from astroinertia.scene import load
from astroinertia.test_problems.matter import Solution, l1_errors, standard

_POINTS = 2000  # of an exact flow
_STRIP = 0.1  # of the box
ALONG = {"sod": "x", "strong_tube": "x", "square": "x", "sedov": "r", "noh": "r", "gresho": "s"}
LABELS = {"x": "x", "r": "distance from the centre", "s": "distance from the axis"}


@with_absent
def standard_figure(dataset: xr.Dataset, snapshots: xr.Dataset) -> Figure | None:
    """Particles and the exact flow along a line, with the L1 errors of all particles; None for what has no exact flow.

    >>> print(standard_figure(ds, ds.inertia.snapshots))  # a star has no exact flow
    None
    """
    if "scene" not in dataset.attrs or "standard" not in dataset.attrs["scene"]:
        return None
    try:
        scene = load.loads(dataset.attrs["scene"])
    except SceneError:  # of an effect that is not here
        return None
    fluid: Any = scene.equation_of_state  # ideal, as such problems need
    problem: str = getattr(scene.body, "problem", "")
    chosen = standard(problem) if problem else None
    if chosen is None or chosen.exact is None:
        return None
    lengths = scene.box_lengths
    last = snapshots.isel(snapshot_time=-1).load()
    time, position = float(last["snapshot_time"]), last["position"].transpose("particle", "i").values
    velocity = last["velocity"].transpose("particle", "i").values
    computed = Solution(last["density"].values, velocity, last["pressure"].values)
    exact, inside = chosen.exact(position, time, lengths, fluid.gamma), chosen.compared(position, time, lengths)
    errors = l1_errors(computed, exact, inside)
    place = position - np.where(np.isfinite(lengths), lengths, 1.0) * np.round(position / lengths)
    where = _coordinate(ALONG[problem], place)[inside]
    # Of a flow that also varies across x the particles of a strip are drawn.
    dots = abs(place[inside, 1]) < _STRIP * lengths[1] if problem == "square" else slice(None)
    along = np.linspace(where.min(), where.max(), _POINTS)
    line = np.zeros((_POINTS, 3))
    line[:, 0] = along
    smooth, known = chosen.exact(line, time, lengths, fluid.gamma), chosen.compared(line, time, lengths)
    with style.styled():
        figure = style.begin(dataset, f"the exact flow at time {time:.3g}", (11.0, 3.6))
        for panel, (name, error) in zip(figure.subplots(1, 3), errors.items(), strict=True):
            values = _size(getattr(computed, name)[inside])
            panel.plot(where[dots], values[dots], ".", markersize=1.5, alpha=0.5, rasterized=True, label="particles")
            right = np.where(known, _size(getattr(smooth, name)), np.nan)
            panel.plot(along, right, "k-", linewidth=1.0, label="exact")
            panel.set(xlabel=LABELS[ALONG[problem]], title=f"{name}, L1 error {error:.2g}")
        figure.axes[0].legend(fontsize=8, markerscale=4)
    return figure


def _coordinate(kind: str, position: np.ndarray) -> np.ndarray:
    if kind == "x":
        return position[:, 0]
    return np.linalg.norm(position if kind == "r" else position[:, :2], axis=1)


def _size(values: np.ndarray) -> np.ndarray:
    return np.linalg.norm(values, axis=1) if values.ndim == 2 else values
