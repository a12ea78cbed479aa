"""What errors and shares are judged against."""

import numpy as np
import xarray as xr

from astroinertia.dataset.derived import SPINLESS
from astroinertia.units import SPEED_OF_LIGHT

FROM_PAIRS = 1e-7  # of the largest angular momentum: what single-precision pairs give to a body that has none (4e-9)
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


def angular_momentum_scale(dataset: xr.Dataset) -> tuple[float, bool]:
    """The largest angular momentum of the run, and whether the body spins.

    For one that does not, it is the largest that its motion could carry, 2 (tr Q tr K)^(1/2). One that began without
    spin spins when it has more than round-off gives it, which depends on the precision of the run.
    """
    momentum = np.linalg.norm(dataset["angular_momentum"].transpose("time", "i").values, axis=1)
    second, kinetic = (
        np.einsum("tii->t", dataset[name].transpose("time", "i", "j").values)
        for name in ("second_moment", "kinetic_tensor")
    )
    largest = float(np.max(np.sqrt(second * kinetic), where=np.isfinite(second * kinetic), initial=0.0)) * 2.0
    largest_momentum = float(np.max(momentum, where=np.isfinite(momentum), initial=0.0))
    exact = momentum[0] > SPINLESS * largest or dataset.attrs.get("precision") == "float64"
    least = SPINLESS if exact else FROM_PAIRS
    return (largest_momentum, True) if largest_momentum > least * largest else (largest or 1.0, False)
