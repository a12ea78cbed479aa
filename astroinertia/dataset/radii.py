"""Radii of a body as it is now, and what refers to one of them: moment ratios, J2 and the coefficients of degree 2.

A model that keeps the profile of a body has its surface in the second moments; of particles it is the ellipsoid that
encloses 99 % of the mass, enlarged so that it has the radius of the initial body at the start. Pure functions of arrays
with time leading, in consistent units.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from astroinertia.dataset.schema import code_units
from astroinertia.inertia.gravity_field import degree_two_moments

Series = Mapping[str, np.ndarray]
Structure = Mapping[str, float]
"""What a run's description has of the body at the start (build.structure)."""

KEPT = "the profile of the start is kept, so that the surface follows from the second moments"
ENCLOSING = (
    "of the ellipsoid that encloses 99 % of the mass now, shaped as the outermost tenth is, over that at the start, "
    "times the mean radius of the initial body"
)
WITHOUT_SURFACE = "of the ellipsoid that encloses 99 % of the mass now, shaped as the outermost tenth is"
OF_SCENE = "radius that the scene gives, changed as the body changes its size"
MEAN, EQUATORIAL = "surface_mean_radius", "surface_equatorial_radius"
RATIOS = {
    "moment_ratio": MEAN,
    "moment_ratio_equatorial": EQUATORIAL,
    "moment_ratio_half_mass": "half_mass_radius",
    "moment_ratio_enclosing_99": "radius_enclosing_99",
}
"""The radius that each moment ratio refers to."""


class Surface(NamedTuple):
    """Mean, equatorial and polar radius (T,), NaN where they are not known."""

    mean: np.ndarray
    equatorial: np.ndarray
    polar: np.ndarray


def surface(series: Series, second: np.ndarray, axis: np.ndarray, structure: Structure) -> Surface | None:
    """The surface now, of a body with second moments (T, 3, 3) that turns about an axis (T, 3).

    None where the records tell nothing of it, as those of versions without this.
    """
    mass = series["mass"]
    unknown = np.full(len(mass), np.nan)
    if "enclosing_ellipsoid" in series:
        share = structure.get("enclosing_99", 1.0)
        shape = series["enclosing_ellipsoid"] / share**2
        along, across = along_and_across(shape, axis)
        known = np.asarray(np.isfinite(shape).all(axis=(1, 2)))
        volume = np.linalg.det(np.where(known[:, None, None], shape, 0.0))
        mean = np.where(known, np.maximum(volume, 0.0) ** (1 / 6), np.nan)
        return Surface(mean, np.sqrt(0.5 * across), np.sqrt(along))
    if "equatorial_second_moment" in structure:
        wide, high = structure["equatorial_second_moment"], structure["polar_second_moment"]
        along, across = along_and_across(second, axis)
        mean = (np.maximum(np.linalg.det(second), 0.0) / (wide**2 * high)) ** (1 / 6) / np.sqrt(mass)
        return Surface(mean, np.sqrt(0.5 * across / (mass * wide)), np.sqrt(along / (mass * high)))
    if "mean_second_moment" in structure:
        size = np.trace(second, axis1=1, axis2=2) / (3.0 * mass * structure["mean_second_moment"])
        return Surface(np.sqrt(size), unknown, unknown)
    return None


def with_radii(series: Series, now: Surface, structure: Structure) -> dict[str, np.ndarray]:
    """Radii of the surface, its flattening, and the radii that enclose shares of the mass."""
    radii = {
        MEAN: now.mean,
        EQUATORIAL: now.equatorial,
        "surface_polar_radius": now.polar,
        "surface_flattening": 1.0 - now.polar / np.where(now.equatorial > 0.0, now.equatorial, np.nan),
    }
    for name, share in (("half_mass_radius", "half_mass"), ("radius_enclosing_99", "enclosing_99")):
        if name in series:
            radii[name] = series[name]
        elif share in structure:
            radii[name] = structure[share] * now.mean
    return radii


def moment_ratios(moment: np.ndarray, mass: np.ndarray, radii: Series) -> dict[str, np.ndarray]:
    """I/(M R^2) of a moment (T,), by the convention of the radius."""
    return {
        name: moment / (mass * np.where(radii[radius] > 0.0, radii[radius], np.nan) ** 2)
        for name, radius in RATIOS.items()
        if radius in radii
    }


def degree_two(inertia: np.ndarray, moments: np.ndarray, mass: np.ndarray, radius: np.ndarray) -> dict[str, np.ndarray]:
    """J2 of principal moments (T, 3) and C20, C21, S21, C22, S22 (T, 5) of a tensor (T, 3, 3), for a radius (T,).

    Not normalised: V = -(G M/r) (1 + (R/r)^2 sum of P_2m(sin latitude) (C_2m cos m longitude + S_2m sin m longitude)).
    """
    size = mass * np.where(radius > 0.0, radius, np.nan) ** 2
    least, middle, largest = np.moveaxis(np.sort(moments, axis=-1), -1, 0)
    return {
        "zonal_harmonic_2": (largest - 0.5 * (least + middle)) / size,
        "gravity_coefficient": degree_two_moments(inertia) / size[:, None],
    }


def reference_radius(radii: Series) -> str:
    """The radius that J2 refers to: the equator's, where it is known, or else that of the sphere or of the moments."""
    choice = (EQUATORIAL, MEAN, "equatorial_radius")
    return next(name for name in choice if name in radii and (np.isfinite(radii[name]).any() or name == choice[-1]))


def conventions(variables: Mapping[str, tuple], metadata: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Attributes of the variables (dims, values, attributes) that refer to a radius: which one, and where from."""
    of_surface = _origin(variables, metadata)
    known = {name: np.isfinite(variables[name][1]).any() for name in (*RATIOS, *RATIOS.values(), EQUATORIAL)}
    noted: dict[str, dict[str, Any]] = {
        name: {"radius": radius} | ({"radius_convention": of_surface} if radius in (MEAN, EQUATORIAL) else {})
        for name, radius in RATIOS.items()
        if known[name]
    }
    if known["moment_ratio"] and not known[MEAN]:
        length = code_units(metadata).length
        convention = metadata.get("reference_radius_convention", "reference radius of the initial body")
        noted["moment_ratio"] = {
            "radius": "reference_radius", "reference_radius": metadata["reference_radius"] * length,
            "radius_convention": f"{convention}, of the start",
        }  # fmt: skip
    for name in (MEAN, EQUATORIAL, "surface_polar_radius", "surface_flattening"):
        if np.isfinite(variables[name][1]).any():
            noted[name] = {"radius_convention": of_surface}
    chosen = next((name for name in (EQUATORIAL, MEAN) if known[name]), "equatorial_radius")
    noted |= {name: {"radius": chosen} for name in ("zonal_harmonic_2", "gravity_coefficient")}
    structure = metadata.get("structure", {})
    radial = [structure[name] for name in structure if name.startswith("radial_moment_")]
    if radial and of_surface == KEPT:
        noted["gravity_coefficient"]["radial_moments"] = radial  # of s^2, s^4 and so on: for dataset.gravity_field
    return noted


def _origin(variables: Mapping[str, tuple], metadata: Mapping[str, Any]) -> str:
    structure = metadata.get("structure", {})
    if np.isfinite(variables["enclosing_ellipsoid"][1]).any():
        return ENCLOSING if "enclosing_99" in structure else WITHOUT_SURFACE
    return KEPT if "equatorial_second_moment" in structure else OF_SCENE


def along_and_across(matrix: np.ndarray, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of second moments (T, 3, 3), that along an axis (T, 3) and the sum of the two across it, (T,)."""
    along = np.einsum("ti,tij,tj->t", axis, matrix, axis)
    across = np.trace(matrix, axis1=1, axis2=2) - along
    return np.maximum(along, 0.0), np.maximum(across, 0.0)
