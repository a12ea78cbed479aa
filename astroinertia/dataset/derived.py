"""Quantities that follow from the recorded ones: pure functions of arrays with time leading, in consistent units."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from astroinertia.bodies.bar_analysis import bar
from astroinertia.dataset import radii
from astroinertia.inertia import principal, tensor
from astroinertia.inertia.evolution import second_moment_acceleration
from astroinertia.inertia.spin import angular_velocity

Series = Mapping[str, np.ndarray]

BAR = ("bar_strength", "bar_phase", "bar_pattern_speed")

# Below this share of the largest possible angular momentum, (tr Q tr K)^(1/2), a body counts as not spinning.
SPINLESS = 1e-9
# Semi-axes of a particle body are uncertain by more than this; a model with exact moments may set less.
PARTICLE_GAP_TOLERANCE = 1e-3


def derived_quantities(
    series: Series, tolerance: float, reference_radius: float | None, structure: radii.Structure = MappingProxyType({})
) -> dict[str, np.ndarray]:
    """All of the schema's derived quantities but those of gravitational waves, in the units of `series`.

    tolerance: principal moments nearer than this share of the largest count as equal. reference_radius: what the moment
    ratio refers to in records that tell nothing of the surface; structure: of the body at the start (radii.Structure).
    Quantities whose ingredients were not recorded are left out.
    """
    derived: dict[str, np.ndarray] = {}
    if _has(series, "mixed_moment"):
        derived["inertia_rate"] = tensor.inertia_from_second_moment(tensor.twice_symmetric(series["mixed_moment"]))
    if _has(series, "kinetic_tensor", "virial_tensor"):
        acceleration = second_moment_acceleration(series["kinetic_tensor"], series["virial_tensor"].sum(axis=1))
        derived["inertia_acceleration"] = tensor.inertia_from_second_moment(acceleration)
    if _has(series, "second_moment", "mixed_moment"):
        derived |= dict(zip(BAR, bar(series["second_moment"], series["mixed_moment"]), strict=True))
    if _has(series, "accreted_mass", "time"):
        derived["accretion_rate"] = _rate(series["accreted_mass"], series["time"])
    if not _has(series, "inertia_tensor", "mass"):
        return derived
    inertia, mass = series["inertia_tensor"], series["mass"]
    moments, axes = principal.tracked_frame(inertia, tolerance)
    derived |= {"principal_moments": moments, "principal_axes": axes, "principal_gap": principal.principal_gap(moments)}
    if "inertia_rate" in derived:
        derived["figure_rotation_rate"] = principal.figure_rotation(moments, axes, derived["inertia_rate"], tolerance)
    axis = axes[:, 2]
    if _has(series, "angular_momentum"):
        angular_momentum = series["angular_momentum"]
        spin = angular_velocity(inertia, angular_momentum)
        energy = 0.5 * (angular_momentum * spin).sum(-1)
        speed = np.linalg.norm(spin, axis=-1)
        derived |= {"angular_velocity": spin, "angular_speed": speed, "rotational_energy": energy}
        if _has(series, "gravitational_energy"):
            bound = np.abs(series["gravitational_energy"])
            derived["rotational_to_gravitational"] = _ratio(energy, bound)
        axis = spin_axis(series, axis)
    second = tensor.second_moment_from_inertia(inertia)
    along, across = radii.along_and_across(second, axis)
    equatorial, polar = np.sqrt(2.5 * _ratio(across, mass)), np.sqrt(5.0 * _ratio(along, mass))
    derived |= {
        "spin_axis": axis,
        "mean_radius": tensor.equivalent_semi_axes(mass, moments).prod(-1) ** (1 / 3),
        "equatorial_radius": equatorial,
        "polar_radius": polar,
        "ellipsoid_flattening": 1.0 - _ratio(polar, equatorial),
    }
    now, moment = radii.surface(series, second, axis, structure), tensor.moment_about(inertia, axis)
    if now is not None:
        derived |= radii.with_radii(series, now, structure)
        derived |= radii.moment_ratios(moment, mass, derived)
    elif reference_radius is not None:
        derived["moment_ratio"] = moment / (mass * reference_radius**2)
    return derived | radii.degree_two(inertia, moments, mass, derived[radii.reference_radius(derived)])


def spin_axis(series: Series, otherwise: np.ndarray) -> np.ndarray:
    """The direction of the angular momentum (T, 3); `otherwise` (T, 3) where the body does not spin."""
    angular_momentum = series["angular_momentum"]
    size = np.linalg.norm(angular_momentum, axis=-1)
    if _has(series, "second_moment", "kinetic_tensor"):
        spread = np.einsum("tii->t", series["second_moment"]) * np.einsum("tii->t", series["kinetic_tensor"])
        spins = size > SPINLESS * np.sqrt(np.maximum(spread, 0.0))
    else:
        spins = size > 0.0
    return np.where(spins[:, None], angular_momentum / np.where(spins, size, 1.0)[:, None], otherwise)


def _rate(amount: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Its increase since the record before, over the time since; zero in the first."""
    since = np.diff(time, prepend=time[:1])
    return _ratio(np.diff(amount, prepend=amount[:1]), since) if len(time) > 1 else np.zeros_like(amount)


def _has(series: Series, *names: str) -> bool:
    return all(name in series for name in names)


def _ratio(numerator: np.ndarray, denominator: np.ndarray) -> np.ndarray:
    nonzero = denominator != 0
    return np.where(nonzero, numerator / np.where(nonzero, denominator, 1.0), np.nan)
