"""A short run of particles, from the scene to the file, and what its ledger and its budgets say."""

import numpy as np
import xarray as xr

from astroinertia import dataset
from astroinertia.inertia.tensor import axial_vector
from astroinertia.run.loop import run_scene
from astroinertia.scene.load import loads
from astroinertia.storage.atomic import temporary_folder
from astroinertia.verify.comparison import Quantities

COLLAPSE = """
name = "cross_check"
units = "code"

[body]
kind = "uniform"
particles = 500
mass = 1.0
radius = 1.0
axes = [1.0, 0.9, 0.8]
placement = "lattice"
relax = false

[body.rotation]
rate = 0.3

[equation_of_state]
kind = "ideal"

[effects.gravity]
[effects.pressure]
[effects.viscosity]

[effects.tide]
mass = 1.0
position = [4.0, 3.0, 0.0]

[time]
end = 0.6

[output]
series_every = 0.05
"""
"""A triaxial rotating cloud that falls together in a tide: every effect of the ledger has something to do."""


def ledger_of_a_collapse() -> Quantities:
    """The largest closure and mismatch over the run, and what nobody accounts for of what should be conserved."""
    series = _run(COLLAPSE)
    largest = float(abs(series["kinetic_energy"]).max() + abs(series["gravitational_energy"]).max())
    momentum = series["angular_momentum"].transpose("time", "i").values
    spin = float(np.linalg.norm(momentum[0]))
    owned = axial_vector(_tensors(series["mixed_impulse"]).sum(axis=1))
    inner = series.sel(effect=["gravity", "pressure", "viscosity"])
    return {
        "ledger_closure": float(series["ledger_closure"].max()),
        "virial_mismatch": float(series["virial_mismatch"].max()),
        "internal_momentum": float(abs(inner["impulse"]).max()),
        "internal_angular_momentum": float(abs(axial_vector(_tensors(inner["mixed_impulse"]))).max()) / spin,
        "angular_momentum": float(abs(momentum - momentum[0] - owned).max()) / spin,
        "energy": float(abs(series["integration_energy_error"]).max()) / largest,
    }


def _tensors(variable: xr.DataArray) -> np.ndarray:
    return variable.transpose("time", "effect", "i", "j").values


def _run(text: str) -> xr.Dataset:
    with temporary_folder() as folder:
        return dataset.open(run_scene(loads(text), folder / "run"))


COMPUTATIONS = (ledger_of_a_collapse,)
