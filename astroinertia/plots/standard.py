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

ALONG = {"sod": "x", "strong_tube": "x", "square": "x", "sedov": "r", "noh": "r", "gresho": "s"}
LABELS = {"x": "x", "r": "distance from the centre", "s": "distance from the axis"}


@with_absent
def standard_figure(dataset: xr.Dataset, snapshots: xr.Dataset) -> Figure | None:
    """Particles and the exact flow where they are, with the L1 errors; None for what has no exact flow.

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
    lengths = np.full(3, np.inf) if scene.box is None else np.array(scene.box.lengths)
    last = snapshots.isel(snapshot_time=-1).load()
    time, position = float(last["snapshot_time"]), last["position"].transpose("particle", "i").values
    velocity = last["velocity"].transpose("particle", "i").values
    computed = Solution(last["density"].values, velocity, last["pressure"].values)
    exact, inside = chosen.exact(position, time, lengths, fluid.gamma), chosen.compared(position, time, lengths)
    errors = l1_errors(computed, exact, inside)
    place = position - np.where(np.isfinite(lengths), lengths * np.round(position / lengths), 0.0)
    where = _coordinate(ALONG[problem], place)[inside]
    order = np.argsort(where)
    with style.styled():
        figure = style.begin(dataset, f"the exact flow at time {time:.3g}", (11.0, 3.6))
        for panel, (name, error) in zip(figure.subplots(1, 3), errors.items(), strict=True):
            dots, line = (_size(getattr(flow, name)[inside]) for flow in (computed, exact))
            panel.plot(where, dots, ".", markersize=1.5, alpha=0.5, rasterized=True, label="particles")
            panel.plot(where[order], line[order], "k-", linewidth=1.0, label="exact")
            panel.set(xlabel=LABELS[ALONG[problem]], title=f"{name}, L1 error {error:.2g}")
        figure.axes[0].legend(fontsize=8, markerscale=4)
    return figure


def _coordinate(kind: str, position: np.ndarray) -> np.ndarray:
    if kind == "x":
        return position[:, 0]
    return np.linalg.norm(position if kind == "r" else position[:, :2], axis=1)


def _size(values: np.ndarray) -> np.ndarray:
    return np.linalg.norm(values, axis=1) if values.ndim == 2 else values
