"""What errors and shares are judged against."""

import numpy as np
import xarray as xr

from astroinertia.dataset.derived import SPINLESS
from astroinertia.dataset.sizes import largest_size
from astroinertia.inertia.tensor import axial_vector
from astroinertia.units import SPEED_OF_LIGHT

FROM_PAIRS = 1e-7  # of an effect's virial tensor: a torque that single-precision pairs give where there is none (4e-9)
ENERGIES = ("kinetic_energy", "internal_energy", "gravitational_energy")


def has_values(dataset: xr.Dataset, *names: str) -> bool:
    """Whether the dataset has a number for one of these quantities, at any time."""
    return any(bool(dataset[name].notnull().any()) for name in names)


def moved(dataset: xr.Dataset, *names: str) -> bool:
    """Whether one of these quantities is known and not zero throughout."""
    return any(bool((abs(dataset[name]) > 0).any()) for name in names)


def known_effects(dataset: xr.Dataset, quantity: str) -> list[str]:
    """The effects that have numbers for a quantity; a model may skip others that the scene lists."""
    rows = dataset[quantity].notnull().any([dim for dim in dataset[quantity].dims if dim != "effect"])
    return [str(name) for name in dataset["effect"].values[rows.values]]


def energy_scale(dataset: xr.Dataset) -> float:
    """The largest energy of any kind at any time; NaN if none is known."""
    sizes = [np.nanmax(abs(dataset[name].values)) for name in ENERGIES if has_values(dataset, name)]
    return float(max(sizes)) if sizes else np.nan


def wave_scale(dataset: xr.Dataset) -> float:
    """G/c^4 times the largest sum of |tr K| and of all |tr V|: what cancels in the strain times distance, in m."""
    shares = abs(dataset.inertia.virial_shares()).sum("share")
    return float(shares.max()) * float(dataset.attrs["gravitational_constant"]) / SPEED_OF_LIGHT**4


def angular_impulse(dataset: xr.Dataset) -> np.ndarray:
    """The angular momentum (time, effect, 3) that each effect has given so far."""
    return axial_vector(dataset["mixed_impulse"].transpose("time", "effect", "i", "j").values)


def angular_momentum_scale(dataset: xr.Dataset) -> tuple[float, bool]:
    """The largest angular momentum of the run, and whether the body spins.

    For one that does not, it is the largest that its motion could carry, (tr Q tr K)^(1/2) (Cauchy and Schwarz). One
    spins that has more than round-off gives it, beside what only errors have given: those of single-precision pairs,
    and of multipoles.
    """
    momenta = dataset["angular_momentum"].transpose("time", "i").values
    second, kinetic = (
        np.einsum("tii->t", dataset[name].transpose("time", "i", "j").values)
        for name in ("second_moment", "kinetic_tensor")
    )
    most = largest_size(np.sqrt(second * kinetic))
    own = largest_size(np.linalg.norm(momenta - _given_by_errors(dataset), axis=1))
    return (largest_size(np.linalg.norm(momenta, axis=1)), True) if own > SPINLESS * most else (most or 1.0, False)


def _given_by_errors(dataset: xr.Dataset) -> np.ndarray | float:
    """The angular momentum (time, i) that came from effects whose own virial tensors have no torque.

    Such are forces between particles; the sum of what they do to the particles has a torque only by its errors.
    """
    if not all(name in dataset for name in ("torque", "virial_tensor", "mixed_impulse")):
        return 0.0
    torque = dataset["torque"].transpose("effect", "time", "i").values
    virial = dataset["virial_tensor"].transpose("effect", "time", "i", "j").values
    inner = [
        bool(np.isfinite(turning).any()) and largest_size(turning) <= FROM_PAIRS * largest_size(pull)
        for turning, pull in zip(torque, virial, strict=True)
    ]
    impulse = angular_impulse(dataset)
    return np.nansum(impulse[:, inner], axis=1)
