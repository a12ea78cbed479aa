"""Gravity fields as variables of a dataset, and those of a run: of the particles of its snapshots, or of its layers."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.dataset import open as opened, radii
from astroinertia.dataset.by_member import source_of
from astroinertia.dataset.snapshots import present
from astroinertia.errors import AbsentError, ArchiveError
from astroinertia.inertia.gravity_field import GravityField, ellipsoid_field, particle_field
from astroinertia.inertia.principal import principal_frame
from astroinertia.inertia.tensor import second_moment_from_inertia

_RADII = (radii.EQUATORIAL, radii.MEAN, "equatorial_radius")
_ROUNDED = 1e-12  # of the largest time: those of a sweep's members are one, which differ from a snapshot's by round-off


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
    """Times, and the fields about the centre of mass: at the snapshots, or at all records of a body of similar layers.

    radius: the reference radius, or at each time the one that J2 of the dataset refers to. AbsentError where a run has
    neither particles nor layers that it keeps, ValueError beyond the degree to which layers are known.
    """
    noted = {name: dataset[name].attrs for name in dataset.data_vars}  # older files have none of these two
    moments = noted.get("gravity_coefficient", {}).get("radial_moments", ())
    if snapshots is None and not np.size(moments):
        moments = _of_member(dataset)
    if snapshots is None and not np.size(moments):
        raise AbsentError(
            "the gravity field above degree 2 needs snapshots of particles, or a body that keeps its layers; degree 2"
            " is in gravity_coefficient."
        )
    recorded = dataset["time"].values
    if snapshots is not None:
        taken, room = snapshots["snapshot_time"].values, _ROUNDED * abs(recorded).max()
        within = (taken >= recorded.min() - room) & (taken <= recorded.max() + room)
        snapshots = snapshots.isel(snapshot_time=within)
        if not snapshots.sizes["snapshot_time"]:
            raise AbsentError("no snapshot was taken at the times of this dataset.")
    times = dataset["time"] if snapshots is None else snapshots["snapshot_time"]
    if radius is None:
        known = {name: dataset[name].values for name in _RADII if name in dataset}
        usual = radii.reference_radius(known) if _RADII[-1] in known else _RADII[-1]
        chosen = noted.get("zonal_harmonic_2", {}).get("radius", usual)  # which xarray may have lost
        if chosen not in dataset:
            raise AbsentError(f"this dataset has no {chosen}, which its gravity field refers to; give a radius.")
        order = np.argsort(recorded)
        sizes = np.interp(times.values, recorded[order], dataset[chosen].values[order]).tolist()
    else:
        sizes = [radius] * times.size
    if snapshots is not None:
        fields = [_of_snapshot(snapshots.isel(snapshot_time=k), degree, size) for k, size in enumerate(sizes)]
        return times.variable, fields
    if degree > 2 * np.size(moments):
        raise ValueError(f"the gravity field of layers goes to degree {2 * np.size(moments)}, not {degree}")
    inertia = dataset["inertia_tensor"].transpose("time", "i", "j").values.astype(float)
    masses = dataset["mass"].values.tolist()
    means = np.append(1.0, moments)
    return times.variable, [_of_layers(*each, degree, means) for each in zip(masses, inertia, sizes, strict=True)]


def _of_member(dataset: xr.Dataset) -> Any:
    """What the run of a member of a sweep notes of its layers, where the sweep has members with others."""
    try:
        source = source_of(dataset) if "member" in dataset.coords else None
        own = {} if source is None else opened(source).data_vars
    except (ArchiveError, OSError):
        return ()
    return own["gravity_coefficient"].attrs.get("radial_moments", ()) if "gravity_coefficient" in own else ()


def _of_snapshot(particles: xr.Dataset, degree: int, radius: float) -> GravityField:
    particles = present(particles)
    position = particles["position"].transpose("particle", "i").values
    return particle_field(particles["mass"].values, position, degree, radius)


def _of_layers(mass: float, inertia: np.ndarray, radius: float, degree: int, means: np.ndarray) -> GravityField:
    """The field of similar layers: that of the homogeneous ellipsoid of their surface times (l + 3)/3 <s^l>.

    means: <s^l> over the mass, l = 0, 2, ..., s the size of a layer over that of the surface; Q = M <s^2> a (x) a/3.
    """
    axes = principal_frame(inertia)[1]
    squares = np.diag(axes @ second_moment_from_inertia(inertia) @ axes.T) * (3.0 / (mass * means[1]))
    field = ellipsoid_field(mass, np.sqrt(np.maximum(squares, 0.0)), degree, radius).rotated(axes.T)
    degrees = np.arange(degree + 1)
    shares = (degrees + 3) / 3 * means[degrees // 2]  # odd degrees are 0 anyway
    return replace(field, coefficients=field.coefficients * shares[:, None])
