"""How near the body of a run is to orbits at its equator, to the loss of mass, and to bars.

Tests: tests/unit/dataset/test_accessor.py.
"""

from typing import Any

import numpy as np
import xarray as xr

from astroinertia.bodies.bar_limits import DYNAMICAL, SECULAR
from astroinertia.bodies.break_up import break_up, orbit_at_equator
from astroinertia.dataset.arranged import gravitational_constant
from astroinertia.dataset.rotational_share import rotational_share


def rotation_limits(data: xr.Dataset, shedding: str) -> dict[str, tuple[Any, str, str]]:
    """Values along time, unit and meaning of what `InertiaAccessor.rotation_limits` describes, by name."""
    size, spin = data["mean_radius"].values, np.linalg.norm(data["angular_velocity"].transpose("time", "i"), axis=1)
    convention = data["moment_ratio"].attrs
    first = int(np.argmax(np.isfinite(size)))  # records before it were masked
    at_start = data[convention["radius"]].values[first] if convention.get("radius") in data.data_vars else size[first]
    with np.errstate(invalid="ignore"):  # a flat body has no mean radius, and no limits
        radius = float(convention.get("reference_radius", at_start)) * size / size[first]
    if "surface_mean_radius" in data and data["surface_mean_radius"].notnull().any():
        radius = data["surface_mean_radius"].values
    period = np.divide(2 * np.pi, spin, out=np.where(np.isnan(spin), np.nan, np.inf), where=spin > 0)
    gravity, ratio = gravitational_constant(data), rotational_share(data)
    limits = break_up(data["mass"].values, radius, period, shedding=shedding, gravitational_constant=gravity)
    sheds = limits.sheds_mass
    own: dict[str, Any] = {}
    reference = data["zonal_harmonic_2"].attrs.get("radius", "") if "zonal_harmonic_2" in data else ""
    if {"surface_equatorial_radius", reference} <= set(data.data_vars):
        equator = data["surface_equatorial_radius"].values
        j2 = data["zonal_harmonic_2"].values * (data[reference].values / equator) ** 2
        orbit = orbit_at_equator(data["mass"].values, equator, j2, gravity)
        text = "rate over that of an orbit at the equator of the body, with its J2"
        own["breakup_fraction"] = (spin / orbit, "1", text)
        sheds = spin >= orbit if data.attrs.get("model") in ("sph", "ellipsoid") else sheds
    return own | {
        "radius": (radius, "m", "radius"),
        "period": (period, "s", "period of the mean angular velocity"),
        "kepler_period": (limits.kepler_period, "s", "period of an orbit at the equator of the sphere"),
        "shedding_period": (limits.shedding_period, "s", f"shortest period without loss of mass ({shedding})"),
        "kepler_fraction": (limits.kepler_fraction, "1", "rate over that of an orbit at the equator"),
        "beyond_kepler": (limits.beyond_kepler, "1", "whether the equator turns faster than an orbit there"),
        "sheds_mass": (sheds, "1", "whether the body turns faster than it can without losing mass"),
        "secularly_unstable": (ratio > SECULAR, "1", "whether T/|W| lets friction make a bar"),
        "dynamically_unstable": (ratio > DYNAMICAL, "1", "whether T/|W| makes a bar"),
    }
