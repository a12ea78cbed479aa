"""Quantities of the headline series: each declared once, with what it is, how it follows, and why models lack it.

A model says what it knows of its body (BodyState) and what it has of its own; all that follows from the former is
worked out here, for all models alike. Tests: tests/unit/observables/test_quantities.py.
"""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any, NamedTuple, Self

import numpy as np

from astroinertia.inertia.tensor import axial_vector, inertia_from_second_moment
from astroinertia.units import Dimension

Array = Any

EQUIVALENT = "of the homogeneous ellipsoid with the same mass and the same second moments (a_k^2 = 5 Q_k / M)"
SPIN_AXIS = "n is the direction of the angular momentum, or the axis of the largest moment where there is none"


@dataclass(frozen=True)
class BodyState:
    """What every model says of its body at one moment, in code units (G = 1); E is the number of effects.

    Moments are about the centre of mass. Energies are NaN where the model has no such thing. Each is recorded under its
    own name. particles: arrays of particles by name, as a snapshot has them, for observables of the model sph alone.
    """

    time: float
    step: int
    mass: float
    centre_of_mass: Array  # (3,)
    momentum: Array  # (3,)
    second_moment: Array  # (3, 3), Q
    mixed_moment: Array  # (3, 3), P
    kinetic_tensor: Array  # (3, 3), K
    virial_tensor: Array  # (E, 3, 3), V
    force: Array  # (E, 3)
    impulse: Array  # (E, 3)
    work: Array  # (E,)
    heating: Array  # (E,)
    kinetic_energy: float
    internal_energy: float
    gravitational_energy: float
    potential_energy: float
    total_energy: float
    integration_energy_error: float
    particles: Mapping[str, Array] | None = None


# What limits the time step of particles, besides the effects of a scene, as `timestep_limit` numbers it after these.
TIMESTEP_CRITERIA = ("acceleration", "energy", "longest", "contact")
SAID = tuple(field.name for field in fields(BodyState) if field.name != "particles")
"""What of it is recorded."""


def row(body: BodyState, **own: Any) -> dict[str, Any]:
    """One row of the headline series: what every model says, what follows from it, and what a model has of its own.

    own: by name; it goes before what would follow, where a model knows a number by another way.
    """
    follows = {name: quantity.of(body) for name, quantity in RECORDED.items() if quantity.of and name not in own}
    return {name: getattr(body, name) for name in SAID} | follows | own


def of_ledger(evolved: Array, second_moment: Array, largest: float, mixed_impulse: Array) -> dict[str, Any]:
    """What a model records that integrates a ledger beside its body.

    evolved: Q by its own evolution equation (3, 3), beside that of the body. largest: the largest |I| of the run.
    mixed_impulse: what each effect has added to P, (E, 3, 3).
    """
    return {
        "inertia_tensor_evolved": inertia_from_second_moment(evolved),
        "ledger_closure": ledger_closure(evolved, second_moment, largest),
        "mixed_impulse": mixed_impulse,
    }


def ledger_closure(evolved: Array, second_moment: Array, largest: float) -> float:
    """|I of the ledger - I of the body| over the largest |I| of the run, from Q of both."""
    difference = inertia_from_second_moment(evolved) - inertia_from_second_moment(second_moment)
    return float(np.linalg.norm(difference) / largest)


class Quantity(NamedTuple):
    """One variable: its dimensions in the file, exponents of (mass, length, time), SI unit, long name, comment.

    `dimension` is None where the numbers are not converted: wall time, counts, ratios. absent: why models lack it, by
    model; all others have it. of: how it follows from what every model says of its body, where it does.
    """

    dims: tuple[str, ...]
    dimension: Dimension | None
    unit: str
    long_name: str
    comment: str = ""
    absent: Mapping[str, str] = MappingProxyType({})
    of: Callable[[BodyState], Array] | None = None

    def described(self) -> dict[str, Any]:
        """What a run's description keeps of it, as plain data."""
        dimension = None if self.dimension is None else list(self.dimension)
        return {**dict(zip(self._fields[:5], self, strict=False)), "dims": list(self.dims), "dimension": dimension}

    @classmethod
    def of_description(cls, said: Mapping[str, Any]) -> Self:
        """The quantity of such a description."""
        dimension = None if said["dimension"] is None else Dimension(*said["dimension"])
        return cls(tuple(said["dims"]), dimension, said["unit"], said["long_name"], said["comment"])


NUMBER = None
MASS, LENGTH, TIME = Dimension(1, 0, 0), Dimension(0, 1, 0), Dimension(0, 0, 1)
SPEED, PER_TIME, DENSITY = Dimension(0, 1, -1), Dimension(0, 0, -1), Dimension(1, -3, 0)
MOMENTUM, FORCE, ENERGY = Dimension(1, 1, -1), Dimension(1, 1, -2), Dimension(1, 2, -2)
MASS_RATE = Dimension(1, 0, -1)
MOMENT, ANGULAR_MOMENTUM, AREA = Dimension(1, 2, 0), Dimension(1, 2, -1), Dimension(0, 2, 0)
SPECIFIC_ANGULAR_MOMENTUM, SPECIFIC_ENERGY, PRESSURE = Dimension(0, 2, -1), Dimension(0, 2, -2), Dimension(1, -1, -2)

_T, _TI, _TIJ = ("time",), ("time", "i"), ("time", "i", "j")
_TE, _TEI, _TEIJ = ("time", "effect"), ("time", "effect", "i"), ("time", "effect", "i", "j")
_TR, _TP, _TM = ("time", "radius_bin"), ("time", "principal"), ("time", "mode")
_CENTRE = "about the centre of mass"
_SPHERE = "of a sphere about the centre of mass; mean radius of a similar ellipsoid where the profile is kept"

ENCLOSED = 0.99
LAYERS_DEGREE = 20  # of the gravity field of a body of similar layers
"""Share of the mass of particles that the ellipsoid of their surface encloses."""

UNRECORDED = "this model does not record it"
_NO_STEPS = "the model goes from record to record without steps"
_CLOSED = "the model's moments are in closed form: nothing is evolved beside them"
_FOLLOWS = "the inertia tensor follows from the attitude, and is not integrated"
_FEW = "the body is known by its mass and moments alone"
_SYMMETRIC = "the body is symmetric about its axis"
_EVOLVED = {"rigid": _FOLLOWS, "scaling": _CLOSED}
_NO_LIMIT: dict[str, str] = dict.fromkeys(("ellipsoid", "rigid", "scaling"), "no particles limit the time step")
_NO_PARTICLES: dict[str, str] = dict.fromkeys(("ellipsoid", "rigid", "scaling"), "there are no particles")
_NO_AXES: dict[str, str] = dict.fromkeys(("sph", "ellipsoid", "scaling"), "only a rigid body has axes of its own")
_NO_SHELLS = {"ellipsoid": "the shells of an affine body are similar ellipsoids, not spheres", "rigid": _FEW}
_NO_PROFILE: dict[str, str] = dict.fromkeys(("ellipsoid", "rigid", "scaling"), "the profile of the body is not known")
_OF_PARTICLES = {"ellipsoid": UNRECORDED, "rigid": _FEW, "scaling": UNRECORDED}

RECORDED: dict[str, Quantity] = {
    "step": Quantity(_T, NUMBER, "1", "number of time steps since the start"),
    "mass": Quantity(_T, MASS, "kg", "total mass"),
    "centre_of_mass": Quantity(_TI, LENGTH, "m", "centre of mass"),
    "momentum": Quantity(_TI, MOMENTUM, "kg m s-1", "total momentum"),
    "angular_momentum": Quantity(
        _TI, ANGULAR_MOMENTUM, "kg m2 s-1", f"angular momentum {_CENTRE}", "L_i = eps_ijk P_jk, P the mixed moment",
        of=lambda body: axial_vector(body.mixed_moment),
    ),
    "second_moment": Quantity(_TIJ, MOMENT, "kg m2", f"second moment of mass {_CENTRE}", "Q_ij = sum m x_i x_j"),
    "mixed_moment": Quantity(
        _TIJ, ANGULAR_MOMENTUM, "kg m2 s-1", f"mixed moment {_CENTRE}", "P_ij = sum m x_i v_j; dQ/dt = P + P^T"
    ),
    "kinetic_tensor": Quantity(
        _TIJ, ENERGY, "J", f"kinetic tensor {_CENTRE}", "K_ij = sum m v_i v_j; its trace is twice the energy"
    ),
    "virial_tensor": Quantity(
        _TEIJ, ENERGY, "J", "virial tensor of each effect",
        "V_ij = sum m x_i a_j by the effect's own route; dP/dt = K + sum over effects of V (Chandrasekhar 1969, "
        "Ellipsoidal Figures of Equilibrium, section 11)",
    ),
    "virial_mismatch": Quantity(
        _TE, NUMBER, "1", "difference between the virial tensor by the effect's own route and sum m x_i a_j",
        "divided by sum m |x| |a|; the ledger of the effect that this is large for is wrong",
        absent={
            "rigid": "a rigid body has no particles to sum over",
            "scaling": "the model has no second route to a virial tensor",
        },
    ),
    "mixed_impulse": Quantity(
        _TEIJ, ANGULAR_MOMENTUM, "kg m2 s-1", "what each effect has added to the mixed moment",
        absent={
            "rigid": "the mixed moment follows from attitude and spin, and is not summed up",
            "scaling": "the model goes from record to record without adding up what each effect has done",
        },
    ),
    "inertia_tensor": Quantity(
        _TIJ, MOMENT, "kg m2", f"inertia tensor {_CENTRE}", "I = tr(Q) 1 - Q, summed directly over the body",
        of=lambda body: inertia_from_second_moment(body.second_moment),
    ),
    "attitude": Quantity(
        ("time", "principal", "i"), NUMBER, "1", "axes fixed in a rigid body, unit vectors",
        "the principal axes, one a row, in the order in which the scene gives the moments",
        absent=_NO_AXES,
    ),
    "inertia_tensor_evolved": Quantity(
        _TIJ, MOMENT, "kg m2", f"inertia tensor {_CENTRE}, by its own evolution equation",
        "integrated from d2Q/dt2 = 2 K + sum over effects of (V + V^T), kick by kick and drift by drift",
        absent=_EVOLVED,
    ),
    "ledger_closure": Quantity(
        _T, NUMBER, "1", "difference between the evolved and the direct inertia tensor",
        "Frobenius norm, divided by the largest norm of the inertia tensor in the run so far",
        absent=_EVOLVED,
    ),
    "torque": Quantity(
        _TEI, ENERGY, "N m", f"torque of each effect {_CENTRE}", "tau_i = eps_ijk V_jk",
        of=lambda body: axial_vector(body.virial_tensor),
    ),
    "force": Quantity(_TEI, FORCE, "N", "net force of each effect"),
    "impulse": Quantity(_TEI, MOMENTUM, "kg m s-1", "momentum that each effect has given since the start"),
    "work": Quantity(_TE, ENERGY, "J", "kinetic energy that each effect has given since the start"),
    "heating": Quantity(_TE, ENERGY, "J", "internal energy that each effect has given since the start"),
    "kinetic_energy": Quantity(_T, ENERGY, "J", "kinetic energy", "the motion of the centre of mass is included"),
    "internal_energy": Quantity(_T, ENERGY, "J", "internal energy", absent={"rigid": "nothing heats the body"}),
    "gravitational_energy": Quantity(
        _T, ENERGY, "J", "energy of self-gravity", "of the softened potential where gravity is softened",
        absent={"rigid": "the body keeps its shape, whatever holds it"},
    ),
    "potential_energy": Quantity(
        _T, ENERGY, "J", "potential energy of all effects that have one, but for potentials that move by themselves",
        "with all energy of point masses that move with the fluid",
    ),
    "total_energy": Quantity(_T, ENERGY, "J", "total energy"),
    "integration_energy_error": Quantity(
        _T, ENERGY, "J", "energy that no effect accounts for: the error of the integration in time"
    ),
    "density_max": Quantity(_T, DENSITY, "kg m-3", "largest density", absent={"rigid": _FEW}),
    "timestep": Quantity(_T, TIME, "s", "time step", absent={"scaling": _NO_STEPS}),
    "timestep_limit": Quantity(
        _T, NUMBER, "1", "what limits the time step", "a number for each effect, then for each further criterion",
        _NO_LIMIT,
    ),
    "timestep_limit_radius": Quantity(
        _T, LENGTH, "m", "distance of the particle that limits the time step from the centre of mass", absent=_NO_LIMIT
    ),
    "timestep_limit_density": Quantity(
        _T, DENSITY, "kg m-3", "density of the particle that limits the time step", absent=_NO_LIMIT
    ),
    "core_particles": Quantity(
        _T, NUMBER, "1", "number of particles in the core", "denser than a tenth of the greatest density", _NO_PARTICLES
    ),
    "jeans_ratio": Quantity(
        _T, NUMBER, "1", "least Jeans mass over that of two neighbourhoods",
        "of the denser half of the particles; below 1 fragments may be artificial (Bate & Burkert 1997, MNRAS 288, "
        "1060); of gas alone",
        _NO_PARTICLES,
    ),
    "smoothing_to_thickness": Quantity(
        _T, NUMBER, "1", "median smoothing length over the smallest semi-axis",
        "of the homogeneous ellipsoid with the same mass and second moments",
        _NO_PARTICLES,
    ),
    "wall_time": Quantity(_T, NUMBER, "s", "time that the computation has taken", "of the computer's clock"),
    "radius_profile": Quantity(_TR, LENGTH, "m", "mean radius of each shell of equal mass", absent=_NO_SHELLS),
    "density_profile": Quantity(_TR, DENSITY, "kg m-3", "mean density of each shell", absent=_NO_SHELLS),
    "rotation_profile": Quantity(
        _TR, PER_TIME, "rad s-1", "angular velocity of each shell about z", "sum m j_z / sum m (x^2 + y^2)", _NO_SHELLS
    ),
    "specific_angular_momentum_profile": Quantity(
        _TR, SPECIFIC_ANGULAR_MOMENTUM, "m2 s-1", "mean specific angular momentum of each shell about z",
        absent=_NO_SHELLS,
    ),
    "half_mass_radius": Quantity(_T, LENGTH, "m", "radius that encloses half of the mass", _SPHERE, _NO_PROFILE),
    "radius_enclosing_99": Quantity(_T, LENGTH, "m", "radius that encloses 99 % of the mass", _SPHERE, _NO_PROFILE),
    "enclosing_ellipsoid": Quantity(
        _TIJ, AREA, "m2", "matrix A of the ellipsoid x A^-1 x = 1 that encloses 99 % of the mass",
        "shaped as the outermost tenth of the mass is", _NO_PARTICLES,
    ),
    "mode_amplitude": Quantity(
        _TM, NUMBER, "1", "amplitude of azimuthal modes about z", "|sum m exp(i k phi)| / M for k = 1 to 4",
        {"rigid": _FEW},
    ),
    "mode_phase": Quantity(
        _TM, NUMBER, "rad", "phase of azimuthal modes about z", "arg sum m exp(i k phi)",
        {"rigid": _FEW, "scaling": _SYMMETRIC},
    ),
    "mode_pattern_speed": Quantity(
        _TM, PER_TIME, "rad s-1", "rate at which azimuthal modes turn about z, now",
        "d/dt arg(sum m exp(i k phi)) / k from positions and velocities; over a time, the slope of mode_phase / k",
        _OF_PARTICLES,
    ),
    "ring_mode_amplitude": Quantity(
        _TM, NUMBER, "1", "amplitude of azimuthal modes in a ring about z",
        "of the middle half of the mass in the order of its distance from the axis, divided by that mass",
        _OF_PARTICLES,
    ),
    "ring_mode_phase": Quantity(
        _TM, NUMBER, "rad", "phase of azimuthal modes in that ring", absent=_OF_PARTICLES
    ),
}  # fmt: skip
"""What a run records, in code units, under the same names."""

_RATIO = "moment of inertia about the spin axis over M R^2"
DERIVED: dict[str, Quantity] = {
    "inertia_rate": Quantity(
        _TIJ, ANGULAR_MOMENTUM, "kg m2 s-1", "rate of change of the inertia tensor",
        "dI/dt = tr(S) 1 - S with S = P + P^T",
    ),
    "inertia_acceleration": Quantity(
        _TIJ, ENERGY, "kg m2 s-2", "second time derivative of the inertia tensor",
        "d2I/dt2 = tr(S) 1 - S with S = 2 K + sum over effects of (V + V^T)",
    ),
    "principal_moments": Quantity(
        _TP, MOMENT, "kg m2", "principal moments of inertia",
        "in ascending order where the axes are first defined, and continuous in time from there, through crossings",
    ),
    "principal_axes": Quantity(
        ("time", "principal", "i"), NUMBER, "1", "principal axes, unit vectors",
        "right-handed, continuous in order and sign; undefined where principal_gap is below the tolerance",
    ),
    "principal_gap": Quantity(
        _TP, NUMBER, "1", "distance of each principal moment from the nearest other, over the largest",
        "about the relative difference of the semi-axes; 0 where the axis is undefined",
    ),
    "angular_velocity": Quantity(
        _TI, PER_TIME, "rad s-1", "mean angular velocity",
        "Tisserand's I^-1 L: the rigid rotation with this angular momentum",
    ),
    "angular_speed": Quantity(
        _T, PER_TIME, "rad s-1", "size of the mean angular velocity",
        "|I^-1 L|, of Tisserand's mean rotation (Munk & MacDonald 1960, The Rotation of the Earth)",
    ),
    "figure_rotation_rate": Quantity(
        _TP, PER_TIME, "rad s-1", "rate at which the principal axes turn, about each of themselves",
        "(e_k . dI/dt e_l) / (I_k - I_l) about e_m, (k, l, m) cyclic; NaN where I_k and I_l are equal "
        "within the tolerance",
        {"scaling": _SYMMETRIC},
    ),
    "rotational_energy": Quantity(
        _T, ENERGY, "J", "energy of the mean rotation", "L . I^-1 L / 2; a rotation that is not rigid has more energy"
    ),
    "rotational_to_gravitational": Quantity(_T, NUMBER, "1", "T/|W|", "rotational_energy / |gravitational_energy|"),
    "spin_axis": Quantity(_TI, NUMBER, "1", "axis that radii and flattening refer to", SPIN_AXIS),
    "mean_radius": Quantity(_T, LENGTH, "m", f"mean radius {EQUIVALENT}", "(a b c)^(1/3)"),
    "equatorial_radius": Quantity(
        _T, LENGTH, "m", f"equatorial radius {EQUIVALENT}", f"sqrt(5 (tr Q - n.Q.n) / (2 M)); {SPIN_AXIS}"
    ),
    "polar_radius": Quantity(_T, LENGTH, "m", f"polar radius {EQUIVALENT}", f"sqrt(5 n.Q.n / M); {SPIN_AXIS}"),
    "ellipsoid_flattening": Quantity(
        _T, NUMBER, "1", f"flattening {EQUIVALENT}", "1 - polar_radius / equatorial_radius"
    ),
    "surface_mean_radius": Quantity(_T, LENGTH, "m", "mean radius of the surface", "(a b c)^(1/3)"),
    "surface_equatorial_radius": Quantity(
        _T, LENGTH, "m", "equatorial radius of the surface", f"across the axis n; {SPIN_AXIS}"
    ),
    "surface_polar_radius": Quantity(_T, LENGTH, "m", "polar radius of the surface", f"along the axis n; {SPIN_AXIS}"),
    "surface_flattening": Quantity(
        _T, NUMBER, "1", "flattening of the surface", "1 - surface_polar_radius / surface_equatorial_radius"
    ),
    "moment_ratio": Quantity(
        _T, NUMBER, "1", f"{_RATIO}, R the mean radius of the surface now", f"n.I.n / (M R^2); {SPIN_AXIS}"
    ),
    "moment_ratio_equatorial": Quantity(
        _T, NUMBER, "1", f"{_RATIO}, R the equatorial radius of the surface now", f"n.I.n / (M R^2); {SPIN_AXIS}"
    ),
    "moment_ratio_half_mass": Quantity(
        _T, NUMBER, "1", f"{_RATIO}, R the radius that encloses half of the mass now", f"n.I.n / (M R^2); {SPIN_AXIS}"
    ),
    "moment_ratio_enclosing_99": Quantity(
        _T, NUMBER, "1", f"{_RATIO}, R the radius that encloses 99 % of the mass now", f"n.I.n / (M R^2); {SPIN_AXIS}"
    ),
    "zonal_harmonic_2": Quantity(
        _T, NUMBER, "1", "J2", "(C - (A + B)/2) / (M R^2), A, B and C the principal moments, C the largest"
    ),
    "gravity_coefficient": Quantity(
        ("time", "coefficient"), NUMBER, "1", "coefficient of degree 2 of the gravity field, not normalised",
        "over M R^2: C20 = Q_zz - (Q_xx + Q_yy)/2, C21 = Q_xz, S21 = Q_yz, C22 = (Q_xx - Q_yy)/4, S22 = Q_xy/2, in the "
        "axes x, y and z of the dataset (Hofmann-Wellenhof & Moritz 2006, Physical Geodesy, eq. 2-85)",
    ),
    "bar_strength": Quantity(
        _T, NUMBER, "1", "quadrupole distortion about z",
        "D = (D_+^2 + D_x^2)^(1/2) with D_+ = (Q_xx - Q_yy)/(Q_xx + Q_yy) and D_x = 2 Q_xy/(Q_xx + Q_yy) (Saijo, "
        "Shibata, Baumgarte & Shapiro 2001, ApJ 548, 919)",
    ),
    "bar_phase": Quantity(_T, NUMBER, "rad", "direction of that bar, from x", "arctan2(D_x, D_+) / 2"),
    "bar_pattern_speed": Quantity(
        _T, PER_TIME, "rad s-1", "rate at which that bar turns, now", "d/dt bar_phase, from dQ/dt = P + P^T"
    ),
    "gw_strain_plus": Quantity(
        ("time", "observer"), NUMBER, "m", "gravitational-wave strain times distance, plus polarisation",
        "(G/c^4) (A_theta,theta - A_phi,phi) with A = d2Q/dt2, the quadrupole formula; the observer is on the z axis "
        "(polar) or on the x axis (equatorial), with theta and phi the spherical directions there",
    ),
    "gw_strain_cross": Quantity(
        ("time", "observer"), NUMBER, "m", "gravitational-wave strain times distance, cross polarisation",
        "(2 G/c^4) A_theta,phi; see gw_strain_plus",
    ),
    "gw_luminosity": Quantity(
        _T, NUMBER, "W", "power of gravitational waves", "G/(5 c^5) A'_ij A'_ij, A = d2Q/dt2 without its trace"
    ),
    "gw_energy": Quantity(_T, NUMBER, "J", "energy that gravitational waves have carried away since the start"),
    "gw_angular_momentum": Quantity(
        _TI, NUMBER, "kg m2 s-1", "angular momentum that gravitational waves have carried away since the start",
        "the integral of 2 G/(5 c^5) eps_ijk A_jl A'_kl",
    ),
    "gw_energy_spectrum": Quantity(
        ("frequency",), NUMBER, "J Hz-1", "energy of gravitational waves per frequency",
        "2 G/(5 c^5) |A'_ij(f)|^2, of the whole run; its integral over f is the energy carried away",
    ),
    "gw_characteristic_strain": Quantity(
        ("frequency",), NUMBER, "m", "characteristic gravitational-wave strain times distance",
        "(2 G/(pi^2 c^3) dE/df)^(1/2) (Flanagan & Hughes 1998, Physical Review D 57, 4535)",
    ),
}  # fmt: skip
"""What follows from the recorded quantities; computed in code units, but for the waves, which are in SI already."""

RENAMED = {"flattening": "ellipsoid_flattening", "mean_spin": "mean_angular_velocity"}
"""Series of before by their names of now: older files have them by both, and commands take both for a release."""


def present_name(name: str) -> str:
    """The name of a series, with a FutureWarning where it has another one now."""
    if name in RENAMED:
        warnings.warn(f"the series {name} is now {RENAMED[name]}.", FutureWarning, stacklevel=3)
    return RENAMED.get(name, name)


_TS, _TSI = ("time", "sink"), ("time", "sink", "i")
_SHIFTED = "the shift of the centre of mass is included"
_TC, _TCI = ("time", "companion"), ("time", "companion", "i")
_SYSTEM = "of the fluid and the point masses that move with it"
_TWO_POINTS = "of the companion and the body as two points at their centres of mass"
OF_EFFECTS: dict[str, Quantity] = {
    "system_momentum": Quantity(_TI, MOMENTUM, "kg m s-1", f"momentum {_SYSTEM}"),
    "system_angular_momentum": Quantity(
        _TI, ANGULAR_MOMENTUM, "kg m2 s-1", f"angular momentum {_SYSTEM}", "about their centre of mass, spins included"
    ),
    "companion_position": Quantity(_TCI, LENGTH, "m", "position of each companion"),
    "companion_velocity": Quantity(_TCI, SPEED, "m s-1", "velocity of each companion"),
    "companion_angular_momentum": Quantity(
        _TCI, ANGULAR_MOMENTUM, "kg m2 s-1", "angular momentum of each companion's orbit about the body", _TWO_POINTS
    ),
    "sink_number": Quantity(_T, NUMBER, "1", "number of sinks"),
    "sink_mass": Quantity(_TS, MASS, "kg", "mass of each sink"),
    "sink_position": Quantity(_TSI, LENGTH, "m", "position of each sink"),
    "sink_velocity": Quantity(_TSI, SPEED, "m s-1", "velocity of each sink"),
    "sink_spin": Quantity(
        _TSI, ANGULAR_MOMENTUM, "kg m2 s-1", "spin of each sink", "what it accreted, about its own centre of mass"
    ),
    "accreted_mass": Quantity(_T, MASS, "kg", "mass that sinks have taken from the fluid"),
    "accreted_momentum": Quantity(_TI, MOMENTUM, "kg m s-1", "momentum that sinks have taken from the fluid with it"),
    "accreted_second_moment": Quantity(
        _TIJ, MOMENT, "kg m2", f"second moment {_CENTRE} that the fluid has lost with it", _SHIFTED
    ),
    "accreted_mixed_moment": Quantity(
        _TIJ, ANGULAR_MOMENTUM, "kg m2 s-1", f"mixed moment {_CENTRE} that the fluid has lost with it",
        f"{_SHIFTED}; in mixed_impulse it is part of the row of the sinks",
    ),
    "sink_inner_energy": Quantity(
        _T, ENERGY, "J", "energy that went into sinks",
        "of the heat, the motion and the mutual attraction of what they accreted",
    ),
    "accretion_rate": Quantity(
        _T, MASS_RATE, "kg s-1", "mass that sinks take from the fluid in a time", "from one record to the next"
    ),
    "neutrino_energy": Quantity(
        _T, ENERGY, "J", "energy that neutrinos have taken from the matter",
        "what left and what is trapped, with what compresses it; total_energy and potential_energy have it",
    ),
    "least_electron_fraction": Quantity(_T, NUMBER, "1", "least electron fraction", "of any particle"),
    "companion_energy": Quantity(_TC, ENERGY, "J", "energy of each companion's orbit about the body", _TWO_POINTS),
}  # fmt: skip
"""What only scenes with certain effects have, and only then; recorded in code units, under the same names."""

OF_ATTITUDE: dict[str, Quantity] = {
    "obliquity": Quantity(
        _T, NUMBER, "rad", "obliquity", "angle of the angular momentum from z, the pole of the x-y plane"
    ),
    "precession_rate": Quantity(
        _T, PER_TIME, "rad s-1", "precession rate, of torques",
        "rate at which they turn the angular momentum about z, (L_x tau_y - L_y tau_x)/(L_x^2 + L_y^2); negative where "
        "it goes back; NaN where L is along z",
    ),
    "wobble_angle": Quantity(
        _T, NUMBER, "rad", "wobble",
        "angle between the angular momentum and the axis of the largest moment, whichever end of it is nearer",
    ),
    "wobble_period": Quantity(
        _T, TIME, "s", "wobble period",
        "time in which the angular momentum goes round an axis in the body, were it free from now on: 4 K(k)/rate of "
        "Jacobi's functions (Landau & Lifshitz, Mechanics, section 37); of a body that its rotation deforms, as its "
        "attitude has it",
    ),
    "free_precession_rate": Quantity(
        _T, PER_TIME, "rad s-1", "free precession rate",
        "rate at which the axis of the largest moment goes round the angular momentum, "
        "L (m_1^2/I_1 + m_2^2/I_2)/(m_1^2 + m_2^2) with m the angular momentum along the principal axes (Euler)",
    ),
}  # fmt: skip
"""What follows from the attitude of a rigid body, and only of one: dataset.attitude."""

LABELS: dict[str, tuple[list, str]] = {
    "i": (["x", "y", "z"], "Cartesian component"),
    "j": (["x", "y", "z"], "Cartesian component"),
    "principal": ([1, 2, 3], "number of the principal axis"),
    "mode": ([1, 2, 3, 4], "azimuthal wave number"),
    "coefficient": (["C20", "C21", "S21", "C22", "S22"], "coefficient of degree 2 of the gravity field"),
    "observer": (["polar", "equatorial"], "direction that a gravitational wave is seen from"),
}
