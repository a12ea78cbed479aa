"""Gravity fields as variables of a dataset, and those of a run: of the particles of its snapshots, or of its ellipsoid.

Tests: tests/unit/dataset/test_gravity_field.py.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.dataset.radii import KEPT
from astroinertia.errors import AbsentError
from astroinertia.inertia.gravity_field import GravityField, ellipsoid_field, particle_field
from astroinertia.inertia.principal import principal_frame
from astroinertia.inertia.tensor import second_moment_from_inertia

_HOMOGENEOUS = 1e-9  # relative difference of the surface from the homogeneous ellipsoid of the same second moments


def field_variables(
    fields: Sequence[GravityField], dims: tuple[str, ...], normalization: str, csphase: int
) -> dict[str, tuple]:
    """Variables (dims, values, attributes) of one field, where dims are empty, or of several along one dimension.

    harmonic_coefficient (..., part, degree, order): C_lm and S_lm, NaN for m > l; zonal_harmonic (..., degree): J_l.
    """
    phase = "without" if csphase == 1 else "with"
    degrees = np.arange(fields[0].degree + 1)
    coefficients = np.stack([field.normalized(normalization, csphase) for field in fields])
    coefficients[..., degrees[:, None] < degrees] = np.nan
    zonal = np.array([[field.zonal_harmonic(degree) for degree in degrees.tolist()] for field in fields])
    text = "coefficient of the gravity field"
    convention = {"normalization": normalization, "csphase": csphase}
    comment = f"C_lm and S_lm, normalised {normalization}, {phase} the phase of Condon and Shortley"
    return {
        "harmonic_coefficient": (
            (*dims, "part", "degree", "order"), coefficients if dims else coefficients[0],
            {"units": "1", "long_name": text, "comment": comment, **convention},
        ),
        "zonal_harmonic": (
            (*dims, "degree"), zonal if dims else zonal[0],
            {"units": "1", "long_name": "J_l", "comment": "-C_l0, not normalised, about z"},
        ),
    }  # fmt: skip


def field_labels(degree: int) -> dict[str, Any]:
    """Labels of the dimensions of `field_variables`."""
    numbers = np.arange(degree + 1)
    return {"part": ["C", "S"], "degree": numbers, "order": numbers}


def run_fields(
    dataset: xr.Dataset, snapshots: xr.Dataset | None, degree: int, radius: float | None
) -> tuple[xr.Variable, list[GravityField]]:
    """Times, and the fields about the centre of mass: at the snapshots, or at all records of a homogeneous ellipsoid.

    radius: the reference radius, or at each time the one that J2 of the dataset refers to. AbsentError where a run has
    neither particles nor a homogeneous body.
    """
    if snapshots is None and not _is_homogeneous(dataset):
        raise AbsentError(
            "the gravity field above degree 2 needs snapshots of particles or a homogeneous body; degree 2 is in"
            " gravity_coefficient."
        )
    times = dataset["time"] if snapshots is None else snapshots["snapshot_time"]
    chosen = dataset["zonal_harmonic_2"].attrs.get("radius", "equatorial_radius")
    series = np.interp(times.values, dataset["time"].values, dataset[chosen].values)
    radii = (series if radius is None else np.full(times.size, radius)).tolist()
    if snapshots is not None:
        fields = [_of_snapshot(snapshots.isel(snapshot_time=k), degree, size) for k, size in enumerate(radii)]
        return times.variable, fields
    inertia = dataset["inertia_tensor"].transpose("time", "i", "j").values
    masses = dataset["mass"].values.tolist()
    return times.variable, [_of_ellipsoid(*each, degree) for each in zip(masses, inertia, radii, strict=True)]


def _of_snapshot(particles: xr.Dataset, degree: int, radius: float) -> GravityField:
    mass, position = particles["mass"].values, particles["position"].transpose("particle", "i").values
    present = np.isfinite(mass)  # those that sinks have accreted are NaN
    return particle_field(mass[present], position[present], degree, radius)


def _is_homogeneous(dataset: xr.Dataset) -> bool:
    surface = dataset.get("surface_mean_radius")
    if surface is None or surface.attrs.get("radius_convention") != KEPT:
        return False
    return bool((abs(surface / dataset["mean_radius"] - 1) < _HOMOGENEOUS).all())


def _of_ellipsoid(mass: float, inertia: np.ndarray, radius: float, degree: int) -> GravityField:
    axes = principal_frame(inertia)[1]
    squares = np.diag(axes @ second_moment_from_inertia(inertia) @ axes.T) * (5.0 / mass)
    return ellipsoid_field(mass, np.sqrt(np.maximum(squares, 0.0)), degree, radius).rotated(axes.T)
