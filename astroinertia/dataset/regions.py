"""The quantities of regions in a dataset: those that are recorded, and those that follow from them.

A region has its own mass, centre, moments and ledger, under the same names and definitions as the whole body, with
`region_` before them. Tests: tests/unit/ledger/test_regions.py, tests/physics/test_regions.py.
"""

from collections.abc import Mapping

import numpy as np

from astroinertia.dataset.derived import derived_quantities
from astroinertia.observables.quantities import (
    ANGULAR_MOMENTUM,
    DENSITY,
    ENERGY,
    LENGTH,
    MASS,
    MOMENT,
    NUMBER,
    PER_TIME,
    SPEED,
    Quantity,
)

_R, _RI, _RIJ = ("time", "region"), ("time", "region", "i"), ("time", "region", "i", "j")
_REIJ = ("time", "region", "effect", "i", "j")
_OWN = "about the region's own centre of mass"
_FLUX = "what particles that entered or left have changed since the start, membership being judged at each record"

RECORDED: dict[str, Quantity] = {
    "region_particles": Quantity(_R, NUMBER, "1", "number of particles in each region"),
    "region_mass": Quantity(_R, MASS, "kg", "mass of each region"),
    "region_centre": Quantity(_RI, LENGTH, "m", "centre of mass of each region"),
    "region_velocity": Quantity(_RI, SPEED, "m s-1", "velocity of the centre of mass of each region"),
    "region_second_moment": Quantity(_RIJ, MOMENT, "kg m2", f"second moment of each region {_OWN}"),
    "region_mixed_moment": Quantity(_RIJ, ANGULAR_MOMENTUM, "kg m2 s-1", f"mixed moment of each region {_OWN}"),
    "region_kinetic_tensor": Quantity(_RIJ, ENERGY, "J", f"kinetic tensor of each region {_OWN}"),
    "region_inertia_tensor": Quantity(
        _RIJ, MOMENT, "kg m2", f"inertia tensor of each region {_OWN}", "I = tr(Q) 1 - Q, summed directly"
    ),
    "region_inertia_tensor_evolved": Quantity(
        _RIJ, MOMENT, "kg m2", f"inertia tensor of each region {_OWN}, by its own evolution equation",
        "kicks and drifts of its matter, and the flux across its edge",
    ),
    "region_ledger_closure": Quantity(
        _R, NUMBER, "1", "difference between the evolved and the direct inertia tensor of each region",
        "Frobenius norm, divided by the largest norm of that tensor so far",
    ),
    "region_angular_momentum": Quantity(
        _RI, ANGULAR_MOMENTUM, "kg m2 s-1", f"angular momentum of each region {_OWN}"
    ),
    "region_virial_tensor": Quantity(
        _REIJ, ENERGY, "J", "virial tensor of each effect on each region",
        "V_ij = sum m x_i a_j over its particles, by all that acts on them; dP/dt = K + sum over effects of V + flux",
    ),
    "region_mixed_impulse": Quantity(
        _REIJ, ANGULAR_MOMENTUM, "kg m2 s-1", "what each effect has added to the mixed moment of each region"
    ),
    "region_flux_mass": Quantity(_R, MASS, "kg", "mass that has entered each region, less what has left", _FLUX),
    "region_flux_second_moment": Quantity(
        _RIJ, MOMENT, "kg m2", "flux row of the second moment of each region", _FLUX
    ),
    "region_flux_mixed_moment": Quantity(
        _RIJ, ANGULAR_MOMENTUM, "kg m2 s-1", "flux row of the mixed moment of each region", _FLUX
    ),
    "region_flux_angular_momentum": Quantity(
        _RI, ANGULAR_MOMENTUM, "kg m2 s-1", "flux row of the angular momentum of each region",
        f"{_FLUX}; the rest of the change of L is the antisymmetric part of region_mixed_impulse",
    ),
    "region_gravitational_energy": Quantity(
        _R, ENERGY, "J", "energy of the gravity of each region's matter on itself",
        "its particles alone, softened; the share in the body's energy is larger, for the rest attracts it too",
    ),
    "region_volume_radius": Quantity(
        _R, LENGTH, "m", "radius of the sphere of each region's volume", "(3/(4 pi) sum m/rho)^(1/3)"
    ),
    "region_density_max": Quantity(_R, DENSITY, "kg m-3", "largest density in each region"),
}  # fmt: skip

DERIVED: dict[str, Quantity] = {
    "region_principal_moments": Quantity(
        ("time", "region", "principal"), MOMENT, "kg m2", "principal moments of inertia of each region"
    ),
    "region_angular_velocity": Quantity(
        _RI, PER_TIME, "rad s-1", "mean angular velocity of each region", "Tisserand's I^-1 L of its matter"
    ),
    "region_rotational_energy": Quantity(
        _R, ENERGY, "J", "energy of the mean rotation of each region", "L . I^-1 L / 2"
    ),
    "region_rotational_to_gravitational": Quantity(
        _R, NUMBER, "1", "T/|W| of each region", "region_rotational_energy / |region_gravitational_energy|"
    ),
    "region_mean_radius": Quantity(
        _R, LENGTH, "m", "mean radius of the homogeneous ellipsoid with each region's mass and second moments"
    ),
    "region_moment_ratio": Quantity(
        _R, NUMBER, "1", "moment of inertia of each region about its spin axis over M R^2",
        "R is region_volume_radius",
    ),
}  # fmt: skip

QUANTITIES = RECORDED | DERIVED


def regional_quantities(series: Mapping[str, np.ndarray], tolerance: float) -> dict[str, np.ndarray]:
    """The derived quantities of regions, (T, R, ...), in the units of `series`; NaN while a region is empty."""
    mass = series["region_mass"]
    wanted = {name.removeprefix("region_"): name for name in DERIVED}
    regional: dict[str, np.ndarray] = {}
    for k in range(mass.shape[1]):
        there = np.flatnonzero(series["region_particles"][:, k] > 0)
        if not len(there):
            continue
        own = {
            name.removeprefix("region_"): series[name][there, k]
            for name in RECORDED
            if name in series and name != "region_virial_tensor"
        }
        derived = derived_quantities(own, tolerance, None)
        radius = own["volume_radius"]
        moment = np.einsum("ti,tij,tj->t", derived["spin_axis"], own["inertia_tensor"], derived["spin_axis"])
        derived["moment_ratio"] = moment / (own["mass"] * radius**2)
        for name, full in wanted.items():
            if name in derived:
                row = derived[name]
                regional.setdefault(full, np.full((*mass.shape, *row.shape[1:]), np.nan))[there, k] = row
    return regional
