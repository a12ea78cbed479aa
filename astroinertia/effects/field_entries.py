"""What acts on a body from outside, or as a whole: effects as the catalogue lists them, and how large each is."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from astroinertia.effects.characteristic import Characteristic, tidal_parameter
from astroinertia.effects.entries import AXIS, Entry
from astroinertia.effects.measure import ZONE, Found, Measure, Options, size, within_all
from astroinertia.effects.one_zone import difference
from astroinertia.orbits.kepler import eccentric_anomaly
from astroinertia.units import LIGHT, REQUIRED, Option, choice, not_negative, positive

BULGE = 5.0  # of a liquid sphere in a tide, over its tidal parameter: twice 5/2, for a tide that comes suddenly
ROCHE = 0.05  # tidal parameter beyond which a liquid is torn: 1/2.455^3 = 0.068
HEAVIER = 4.0  # times its compactness a star is heavier for relativity: Gamma, pressure and energy in the mean


def _damping(body: Characteristic, options: Options) -> Found:
    last = body.end if options["until"] is None else min(body.end, options["until"])
    gone = -math.expm1(-last / options["time_scale"])
    return last / options["time_scale"], within_all(gone)


def _rotating_frame(body: Characteristic, options: Options) -> Found:
    turn = abs(options["rate"]) * body.end
    return turn, within_all(turn)


def tidal_change(body: Characteristic, parameter: float) -> float:
    """What a tide does: a bulge of five tidal parameters q to what is bound, q (t/t_dyn)^2 before that; all if torn."""
    assert body.run_length is not None
    if parameter > ROCHE and body.run_length > 1.0:
        return 1.0
    zone = body.zone
    bound = zone is not None and zone.weight >= zone.pressure + zone.turning - 1e-3 * zone.weight
    grown = parameter * body.run_length**2
    change = min(grown, BULGE * parameter) if bound else grown
    if not body.spin or body.moments is None:
        return within_all(change)
    largest = body.moments[2]
    turn = 1.5 * parameter / body.dynamical_time**2 / body.spin  # type: ignore[operator]
    return within_all(change + turn * (largest - body.moments[0]) / largest * min(body.end, 1.0 / body.spin))


def _tide(body: Characteristic, options: Options) -> Found:
    parameter = tidal_parameter(body, options["mass"], nearest_approach(body.end, options))
    return parameter, tidal_change(body, parameter)


def nearest_approach(end: float, options: Options) -> float:
    """The least distance of a perturber in the run; of an open orbit that of its pericentre, an upper estimate."""
    pericentre, e = size(options["position"]), options["eccentricity"]
    if options["period"] is None:
        return pericentre
    first = options["mean_anomaly"]
    last = first + 2.0 * math.pi * end / options["period"]
    if math.floor(last / (2.0 * math.pi)) > math.floor(first / (2.0 * math.pi)) or first == 0.0:
        return pericentre
    return min(pericentre / (1.0 - e) * (1.0 - e * float(np.cos(eccentric_anomaly(np, m, e)))) for m in (first, last))


def _companions(body: Characteristic, options: Options) -> Found:
    parameters = [tidal_parameter(body, other.mass, other.nearest) for other in body.neighbours or ()]
    return max(parameters, default=0.0), within_all(sum(tidal_change(body, parameter) for parameter in parameters))


def _sinks(body: Characteristic, options: Options) -> Found:
    dense = (body.central_density or 0.0) / options["density"]
    return dense, 1.0 if dense >= 1.0 else within_all(body.falling)


def _external_field(body: Characteristic, options: Options) -> Found:
    assert body.dynamical_time is not None
    pull, away = 0.0, size(options["origin"])
    if options["quadratic"] is not None:
        pull += max(abs(entry) for row in options["quadratic"] for entry in row)
    if options["circular_speed"] is not None:
        near = max(away, options["core"] or 0.0)
        pull += options["circular_speed"] ** 2 / near**2 if near > 0.0 else math.inf
    parameter = pull * body.dynamical_time**2
    if options["point_mass"] is not None:
        parameter += tidal_parameter(body, options["point_mass"], max(away, options["softening"] or 0.0))
    return parameter, tidal_change(body, parameter)


def _target_tensor(body: Characteristic, options: Options) -> Found:
    assert body.dynamical_time is not None
    number = options["stiffness"] * body.dynamical_time**2
    return number, within_all(options["stiffness"] * min(body.end, body.dynamical_time) ** 2)


def inspiral_time(constant: float, light: float, masses: tuple[float, float], distance: float) -> float:
    """The time in which waves bring two points on a circle together, (5/256) c^5 a^4/(G^3 m1 m2 M) (Peters 1964)."""
    one, other = masses
    return 5.0 / 256.0 * light**5 * distance**4 / (constant**3 * one * other * (one + other))


def _lit(body: Characteristic, options: Options) -> Characteristic:
    """The body with the speed of light of the options."""
    light = options.get("speed_of_light") or body.speed_of_light
    if light is None:
        raise KeyError("speed_of_light")
    return replace(body, speed_of_light=light)


def _relativistic_potential(body: Characteristic, options: Options) -> Found:
    zone, compact = body.zone, _lit(body, options).compactness
    assert zone is not None and compact is not None
    return compact, difference(zone, body.end, weight=zone.weight * (1.0 + HEAVIER * compact))


def _radiation_reaction(body: Characteristic, options: Options) -> Found:
    body = _lit(body, options)
    light, compact = body.speed_of_light, body.compactness
    assert body.mass is not None and body.radius is not None and body.moments is not None
    assert light is not None and compact is not None
    if body.pair is not None:
        share = body.end / inspiral_time(body.gravitational_constant, light, body.pair.masses, body.pair.distance)
        return compact, within_all(share)
    least, middle, largest = body.moments
    if largest == 0.0:
        return compact, 0.0
    # a figure that turns, and one that swings through what it is from round, with its dynamical rate
    motion = (body.spin or 0.0) * (body.dynamical_time or 0.0)
    uneven = (middle - least) / largest
    zone = body.zone
    swings = 0.0 if zone is None else (largest - least) / largest * zone.imbalance
    strength = 6.4 * compact**2.5 * largest / (body.mass * body.radius**2) * (body.run_length or 0.0)
    return compact, within_all(strength * ((uneven * motion**2) ** 2 + swings**2))


FIELDS: Mapping[str, Entry] = {
    "damping": Entry(
        "drag towards rest or rigid rotation, for relaxation",
        {
            "time_scale": positive("time", REQUIRED, "time over which velocities decay by a factor e"),
            "rate": Option("angular_velocity", None, "rotation rate that velocities decay to; to rest without it"),
            "rate_change": Option("angular_acceleration", None, "constant change of that rate with time, from time 0"),
            "axis": Option("dimensionless", AXIS, "axis of that rotation", shape=(3,)),
            "until": not_negative("time", None, "when the damping ends; never without it"),
            "frame": choice("what the velocities are relative to", "centre_of_mass", "inertial"),
        },
        "particles", "Gingold & Monaghan 1977", ("sph", "ellipsoid"), colour="purple",
        size=Measure(
            "run over time scale",
            "1 - exp(-t/tau)",
            "Gingold & Monaghan 1977", _damping, (), ("time_scale",),
        ),
        pace=lambda options: (options["time_scale"], options["until"]),
    ),
    "rotating_frame": Entry(
        "centrifugal, Coriolis and Euler forces of a frame that rotates about its origin",
        {
            "rate": Option("angular_velocity", REQUIRED, "rotation rate of the frame at time 0"),
            "rate_change": Option("angular_acceleration", None, "constant change of that rate with time"),
            "axis": Option("dimensionless", AXIS, "axis of the rotation", shape=(3,)),
        },
        "particles", "Landau & Lifshitz 1976, Mechanics, eq. 39.7", ("sph", "ellipsoid"), colour="yellow",
        size=Measure(
            "turn of the frame in the run",
            "the angle that it turns by",
            "Landau & Lifshitz 1976, eq. 39.7", _rotating_frame, (), ("rate",),
        ),
    ),
    "tide": Entry(
        "a point mass nearby, fixed or on a Kepler orbit about the origin (ellipse, parabola or hyperbola)",
        {
            "mass": positive("mass", REQUIRED, "mass of the perturber"),
            "position": Option("length", REQUIRED, "where it is: fixed, or at its pericentre", shape=(3,)),
            "period": positive("time", None, "orbital period; without it the perturber stays where it is"),
            "eccentricity": Option("dimensionless", 0.0, "of the orbit", minimum=0.0, maximum=100.0),
            "normal": Option("dimensionless", AXIS, "normal of the orbit", shape=(3,)),
            "mean_anomaly": Option("dimensionless", 0.0, "at time 0, in radians from the pericentre"),
            "pericentre_time": Option("time", None, "when a parabola or hyperbola (eccentricity >= 1) is nearest"),
            "softening": not_negative("length", 0.0, "Plummer softening of the perturber"),
            "frame": choice(
                "tidal: relative to the acceleration of the origin, which falls freely; direct: the whole attraction",
                "tidal", "direct",
            ),
        },
        "particles", "Murray & Dermott 1999, chapter 2", ("sph", "ellipsoid"), colour="sky",
        size=Measure(
            "(M'/M) (R/d)^3 at the nearest",
            "five times that if bound, times (t/t_dyn)^2 at first; all beyond Roche",
            "Murray & Dermott 1999, section 4.2", _tide, ("mass", "radius"), ("mass", "position"),
        ),
    ),
    "companions": Entry(
        "the scene's [[companions]] as point masses beside the fluid",
        {
            "motion": choice(
                "orbit: on the orbits that REBOUND finds, where the body is a point mass; live: they feel the fluid's "
                "gravity, and move with it",
                "orbit", "live",
            ),
            "frame": choice(
                "direct: inertial, with the centre of mass of all at rest; tidal: the body is at the origin, which "
                "falls freely",
                "tidal", "direct", default="direct",
            ),
            "softening": not_negative("length", 0.0, "Plummer softening of the companions"),
        },
        "particles", "Rein & Liu 2012; Hernquist & Katz 1989", auto="companions",
        size=Measure(
            "(M'/M) (R/d)^3 at the nearest",
            "five times that if bound, times (t/t_dyn)^2 at first; all beyond Roche",
            "Murray & Dermott 1999, section 4.2", _companions, ("mass", "radius", "neighbours"),
        ),
    ),
    "sinks": Entry(
        "point masses that take the place of collapsing matter, and accrete what falls into them",
        {
            "density": positive("density", REQUIRED, "above which bound, converging matter becomes a sink"),
            "radius": positive("length", REQUIRED, "within which a sink accretes what is bound to it"),
            "softening": not_negative("length", 0.0, "Plummer softening of the sinks"),
            "number": Option("dimensionless", 16.0, "of sinks, at most", minimum=1.0, maximum=1000.0),
        },
        "particles", "Bate, Bonnell & Price 1995",
        size=Measure(
            "central density over the sinks'",
            "all once the density is reached; the mass whose free fall ends before",
            "Bate, Bonnell & Price 1995", _sinks, ("central_density",), ("density",),
        ),
    ),
    "external_field": Entry(
        "a given gravitational field: uniform, quadratic, logarithmic or of a softened point mass, or their sum",
        {
            "uniform": Option("acceleration", None, "uniform acceleration g", shape=(3,)),
            "quadratic": Option(
                "inverse_time_squared", None, "symmetric matrix A of the potential (x - o).A.(x - o)/2", shape=(3, 3),
            ),
            "circular_speed": positive("velocity", None, "v of the potential v^2/2 ln(|x - o|^2 + core^2)"),
            "core": positive("length", None, "core radius of that potential"),
            "point_mass": positive("mass", None, "M of the potential -M/sqrt(|x - o|^2 + softening^2)"),
            "softening": positive("length", None, "softening of that potential"),
            "origin": Option("length", (0.0, 0.0, 0.0), "origin o of all of them", shape=(3,)),
        },
        "particles", "Binney & Tremaine 2008, sections 2.2 and 2.3", ("sph", "ellipsoid"), colour="purple",
        size=Measure(
            "tidal field times R^3/(G M)",
            "as a tide of that size",
            "Binney & Tremaine 2008, section 8.2", _external_field, ("mass", "radius"), ("origin",),
        ),
    ),
    "target_tensor": Entry(
        "a force that drives the body's inertia tensor to a given elongation, orientation or size",
        {
            "stiffness": positive(
                "inverse_time_squared", REQUIRED, "acceleration per distance, of size and elongation",
            ),
            "axis_ratios": Option(
                "dimensionless", None, "ratios of the semi-axes that the body is to have, at any size", shape=(3,),
                minimum=0.0, exclusive=True,
            ),
            "moments": Option(
                "moment_of_inertia", None, "principal moments that it is to have; give these or axis_ratios",
                shape=(3,), minimum=0.0,
            ),
            "first_axis": Option(
                "dimensionless", None, "where the first of them is to point; without it any orientation will do",
                shape=(3,),
            ),
            "second_axis": Option("dimensionless", None, "where the second is, what is across the first", shape=(3,)),
            "orientation_stiffness": positive(
                "inverse_time_squared", None, "of the orientation; as stiffness without it",
            ),
            "normal": Option(
                "dimensionless", None, "of the plane that alone is driven; all space without it", shape=(3,),
            ),
        },
        "particles", "Zajac, Jones & Glazier 2003; Merks et al. 2006", colour="orange",
        size=Measure(
            "stiffness times R^3/(G M)",
            "stiffness times t^2, or t_dyn^2",
            "Zajac, Jones & Glazier 2003", _target_tensor, ("mass", "radius"), ("stiffness",),
        ),
    ),
    "radiation_reaction": Entry(
        "loss of energy and angular momentum to gravitational waves, by the quadrupole",
        {"speed_of_light": positive("velocity", LIGHT, "c; smaller than it is, all goes faster")},
        "body", "Burke & Thorne 1970; Misner, Thorne & Wheeler 1973, eq. 36.8", ("sph", "ellipsoid"), colour="orange",
        auto="always",
        size=Measure(
            "G M/(R c^2)",
            "6.4 (G M/(R c^2))^(5/2) ((B - A)/C)^2 (omega t_dyn)^4 t/t_dyn; t over inspiral",
            "Peters 1964; Misner, Thorne & Wheeler 1973, eq. 36.8", _radiation_reaction, ("mass", "radius", "moments"),
        ),
    ),
    "relativistic_potential": Entry(
        "general relativity's stronger gravity in the mean over spheres, beside Newton's (one round body)",
        {"speed_of_light": positive("velocity", LIGHT, "c; smaller than it is, the body is more compact")},
        "body", "Marek, Dimmelmeier, Janka, Mueller & Buras 2006, case A", colour="sky", needs=("gravity",),
        size=Measure(
            "G M/(R c^2)",
            "I of one zone by the virial theorem, with a weight larger by four times that",
            "Chandrasekhar 1969, section 14; Marek et al. 2006", _relativistic_potential, ZONE,
        ),
    ),
}  # fmt: skip
