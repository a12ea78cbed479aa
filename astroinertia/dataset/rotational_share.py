"""T/|W| of a body that does not turn rigidly.

Tests: tests/unit/dataset/test_accessor.py.
"""

import numpy as np
import xarray as xr

DIFFERENTIAL = 0.01  # of the largest T/|W| of the shells: both are shown where the mean one is so far below


def rotational_share(data: xr.Dataset) -> np.ndarray:
    """T/|W| (time,), with T = sum L_k Omega_k/2 over the shells of equal mass, each turning as one about z.

    It is rotational_to_gravitational, that of the mean rotation, where this is more, as about another axis than z, or
    where there are no profiles. Of a body that does not turn rigidly the mean rotation has less energy.

    >>> print(f"{rotational_share(ds)[0]:.4f}")  # T/|W| shell by shell
    0.0028
    """
    mean = data["rotational_to_gravitational"].values
    if not {"specific_angular_momentum_profile", "rotation_profile"} <= set(data.data_vars):
        return mean
    spin = data["specific_angular_momentum_profile"] * data["rotation_profile"]
    energy = 0.5 * spin.mean("radius_bin") * data["mass"]
    return np.fmax((energy / np.abs(data["gravitational_energy"])).values, mean)


def differential(shells: np.ndarray, mean: np.ndarray) -> bool:
    """Whether T/|W| shell by shell (time,) is so far above that of the mean rotation that both are worth showing."""
    above = np.fmax(shells - mean, 0.0)
    return bool(np.any(above > DIFFERENTIAL * np.fmax(shells, 0.0).max()))
