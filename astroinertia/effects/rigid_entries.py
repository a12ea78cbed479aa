"""Effects that turn a rigid body, as the catalogue lists them, and how large each is in a scene.

Sizes are the torque times the run over the angular momentum, and what it moves: upper estimates of the change of the
axis' direction (rad) and of the rate (relative). Tests: tests/unit/effects/test_sizes.py.
"""

import math
from collections.abc import Mapping

from astroinertia.effects.characteristic import Characteristic, Neighbour, tidal_parameter
from astroinertia.effects.entries import Entry
from astroinertia.effects.measure import Found, Measure, Options, dot, size, within_all
from astroinertia.matter.rheology import dissipation
from astroinertia.units import LIGHT, REQUIRED, Option, choice, not_negative, positive

_FRAME = choice("the axes that it is given in", "inertial", "body")
_TURNS = ("moments", "spin")


def _momentum(body: Characteristic) -> float:
    assert body.moments is not None and body.spin is not None
    return body.moments[2] * body.spin


def _share(body: Characteristic, impulse: float) -> float:
    momentum = _momentum(body)
    return impulse / momentum if momentum > 0.0 else math.inf if impulse > 0.0 else 0.0


def _constant_torque(body: Characteristic, options: Options) -> Found:
    last = body.end if options["until"] is None else min(body.end, options["until"])
    share = _share(body, size(options["vector"]) * max(0.0, last - options["begin"]))
    return share, within_all(share)


def _impulses(body: Characteristic, options: Options) -> Found:
    number = 0.0
    if body.end >= options["time"]:
        every = options["every"]
        number = 1.0 if every is None else min(options["number"], 1.0 + (body.end - options["time"]) // every)
    share = _share(body, number * size(options["angular_momentum"]))
    return share, within_all(share)


def _pivot(body: Characteristic, options: Options) -> Found:
    assert body.mass is not None and body.moments is not None
    torque = body.mass * size(options["gravity"]) * size(options["arm"])
    if not body.spin:
        swing = torque / max(body.moments[2], 1e-300) * body.end**2
        return swing, within_all(swing)
    return torque / (_momentum(body) * body.spin), within_all(_share(body, torque * body.end))


def _dipole_braking(body: Characteristic, options: Options) -> Found:
    assert body.moments is not None and body.spin is not None
    index = options["index"]
    if options["field"] is not None and options["radius"] is not None:
        light = options["speed_of_light"]
        field = 8.0 * math.pi / 3.0 * options["field"] ** 2 * options["radius"] ** 6 / light**3
        decay = field * body.spin**2 / body.moments[2]
    else:
        rate = 2.0 * math.pi / options["period"]
        decay = options["period_derivative"] / options["period"] * (body.spin / rate) ** (index - 1.0)
    if abs(index - 1.0) < 1e-9:
        change = -math.expm1(-decay * body.end)
    else:
        base = 1.0 + (index - 1.0) * decay * body.end
        change = 1.0 - base ** (-1.0 / (index - 1.0)) if base > 0.0 else 1.0
    return decay / body.spin if body.spin else 0.0, within_all(change)


def _internal_dissipation(body: Characteristic, options: Options) -> Found:
    assert body.spin is not None
    scale = options["time_scale"]
    if options["rate"] is not None and body.spin > 0.0:
        scale *= (options["rate"] / body.spin) ** 3
    gone = -math.expm1(-body.end / scale)
    return body.end / scale, within_all(body.wobble * gone)


def gradient_turn(body: Characteristic, other: Neighbour) -> float:
    """The angle, in rad, by which the torque of another body on the figure moves the axis in the run.

    A figure that turns about its largest moment is averaged over its rotation: (3/2) (G M'/(a^3 (1 - e^2)^(3/2)))
    (H/omega) sin eps cos eps t with H = 1 - (A + B)/(2 C), and the rest, of B - A, acts as long as the body shows the
    other one the same side, 1/(2 |omega - n|). One that tumbles is not averaged.
    """
    assert body.moments is not None and body.spin is not None
    least, middle, largest = body.moments
    strength = 1.5 * body.gravitational_constant * other.mass
    strength /= other.distance**3 * (1.0 - other.eccentricity**2) ** 1.5
    if not body.spin:
        return strength * (largest - least) / largest * body.end**2
    cosine = min(1.0, abs(dot(body.spin_axis, other.normal)) / (size(body.spin_axis) * size(other.normal)))
    oblique = cosine * math.sqrt(1.0 - cosine**2)
    if body.wobble > 0.1:
        return strength / body.spin * (largest - least) / largest * body.end * max(oblique, body.wobble)
    relative = 2.0 * abs(body.spin - other.rate)
    lasts = body.end if relative * body.end < 1.0 else 1.0 / relative
    steady = (1.0 - (least + middle) / (2.0 * largest)) * oblique * body.end
    return strength / body.spin * (steady + (middle - least) / largest * lasts)


def _gravity_gradient(body: Characteristic, options: Options) -> Found:
    if not body.neighbours:
        return 0.0, 0.0
    assert body.spin is not None
    turn = sum(gradient_turn(body, other) for other in body.neighbours)
    return turn / max(body.spin * body.end, 1e-300), within_all(turn)


def tidal_spin_down(body: Characteristic, other: Neighbour, options: Options) -> float:
    """The share of the spin that the torque on the lagging tide takes in the run: 3 k2 G M'^2 R^5 lag/a^6 over C omega.

    k2 times the lag angle is k2/(2 Q), -Im k2/2, or k2 times the time lag times |omega - n|; eccentricity as
    (1 - e)^-6, an upper bound.
    """
    rate = max(abs((body.spin or 0.0) - other.rate), other.rate)
    number, time = options["love_number"], options["relaxation_time"]
    if time is not None:
        lagging = 0.5 * dissipation(number, options["fluid_love_number"], 2.0 * rate, time, options["exponent"])
    elif options["quality"] is not None:
        lagging = 0.5 * number / options["quality"]
    else:
        lagging = number * options["time_lag"] * rate
    strength = 3.0 * body.gravitational_constant * other.mass**2 * options["radius"] ** 5
    return _share(body, strength * lagging / (other.distance * (1.0 - other.eccentricity)) ** 6 * body.end)


def _tidal_torque(body: Characteristic, options: Options) -> Found:
    if not body.neighbours:
        return 0.0, 0.0
    share = sum(tidal_spin_down(body, other, options) for other in body.neighbours)
    tide = 0.0
    if body.radius is not None:
        tide = sum(tidal_parameter(body, other.mass, other.distance) for other in body.neighbours)
    return tide, within_all(share)


def _rotational_deformation(body: Characteristic, options: Options) -> Found:
    assert body.moments is not None and body.spin is not None
    per_square = options["love_number"] * options["radius"] ** 5 / (3.0 * body.gravitational_constant)
    bulge = per_square * body.spin**2 / body.moments[2]
    grown = 2.0 / 3.0 * per_square * abs(body.spin**2 - options["rate"] ** 2) / body.moments[2]
    return bulge, within_all(grown + body.wobble * min(1.0, bulge * body.spin * body.end))


RIGID: Mapping[str, Entry] = {
    "constant_torque": Entry(
        "a constant torque, in space or in the body",
        {
            "vector": Option("torque", REQUIRED, "the torque", shape=(3,)),
            "frame": _FRAME,
            "begin": not_negative("time", 0.0, "when it begins"),
            "until": not_negative("time", None, "when it ends; never without it"),
        },
        "body", "Goldstein, Poole & Safko 2002, section 5.5", ("rigid", "scaling"), colour="yellow",
        size=Measure(
            "torque times run over L",
            "torque times the time that it acts, over L",
            "Goldstein, Poole & Safko 2002, 1.1", _constant_torque, _TURNS, ("vector",),
        ),
    ),
    "impulses": Entry(
        "angular momentum that is added at once, one or many times",
        {
            "angular_momentum": Option("angular_momentum", REQUIRED, "what is added each time", shape=(3,)),
            "time": positive("time", REQUIRED, "the first time"),
            "every": positive("time", None, "how long after each the next comes; only one without it"),
            "number": Option("dimensionless", 1e9, "how many come at most", minimum=1.0),
            "frame": _FRAME,
        },
        "body", "Goldstein, Poole & Safko 2002, section 1.1", ("rigid",), colour="purple",
        size=Measure(
            "impulses over L",
            "the sum of all impulses over L",
            "Goldstein, Poole & Safko 2002, 1.1", _impulses, _TURNS, ("angular_momentum", "time"),
        ),
    ),
    "pivot": Entry(
        "uniform gravity on a body that turns about a fixed point, such as a top or a pendulum",
        {
            "gravity": Option("acceleration", REQUIRED, "the acceleration of gravity", shape=(3,)),
            "arm": Option("length", REQUIRED, "from the fixed point to the centre of mass, in body axes", shape=(3,)),
        },
        "body", "Goldstein, Poole & Safko 2002, section 5.7", ("rigid",), colour="vermillion",
        size=Measure(
            "M g l/(L omega)",
            "angle of precession M g l t/L",
            "Goldstein, Poole & Safko 2002, 5.7", _pivot, (*_TURNS, "mass"), ("gravity", "arm"),
        ),
    ),
    "dipole_braking": Entry(
        "the torque by which a pulsar slows down: of a magnetic dipole, or of any braking index",
        {
            "field": positive("magnetic_field", None, "field at the magnetic equator; or give period_derivative"),
            "radius": positive("length", None, "where the field is that"),
            "speed_of_light": positive("velocity", LIGHT, "c"),
            "magnetic_axis": Option(
                "dimensionless", None, "in body axes; at right angles to the spin without it", shape=(3,),
                models=("rigid", "scaling"),
            ),
            "period": positive("time", None, "rotation period at which the period grows by period_derivative"),
            "period_derivative": positive("dimensionless", None, "dP/dt, instead of a field"),
            "index": Option("dimensionless", 3.0, "braking index n: the torque goes with the n-th power of the spin"),
        },
        "body", "Goldreich 1970; Davis & Goldstein 1970; Michel & Goldwire 1970", ("sph", "rigid", "scaling"),
        colour="purple",
        size=Measure(
            "torque over L omega",
            "1 - (1 + (n - 1) t/tau)^(-1/(n - 1)) with the age tau of the torque of now",
            "Goldreich 1970", _dipole_braking, _TURNS,
        ),
    ),
    "internal_dissipation": Entry(
        "heat from the wobble of a body that is not quite rigid, which settles to its largest moment at fixed L",
        {
            "time_scale": positive("time", REQUIRED, "in which a small wobble falls by a factor e"),
            "rate": positive(
                "angular_velocity", None, "spin that this holds at, going with its power -3; at any spin without it",
            ),
        },
        "body", "Bloch, Krishnaprasad, Marsden & Ratiu 1996; Burns & Safronov 1973", ("rigid",), colour="orange",
        size=Measure(
            "run over time scale",
            "angle of the wobble times 1 - exp(-t/tau)",
            "Burns & Safronov 1973", _internal_dissipation, ("spin",), ("time_scale",),
        ),
    ),
    "gravity_gradient": Entry(
        "the torque of companions on a body that is no sphere, to its quadrupole",
        {},
        "body", "Murray & Dermott 1999, section 5.2", ("rigid",), colour="blue", auto="always",
        size=Measure(
            "torque over L omega",
            "(3/2) (G M'/a^3) (H/omega) sin eps cos eps t, and what of B - A is not averaged out",
            "Murray & Dermott 1999, 5.2; Goldreich 1966", _gravity_gradient, (*_TURNS, "neighbours"),
        ),
    ),
    "tidal_torque": Entry(
        "the torque of companions on the tides that they raise, which lag behind",
        {
            "love_number": positive("dimensionless", REQUIRED, "k_2"),
            "radius": positive("length", REQUIRED, "equatorial radius of the body"),
            "time_lag": positive("time", None, "by which tides lag, the same at all frequencies; or give quality"),
            "quality": positive("dimensionless", None, "Q, the same at all frequencies; or give relaxation_time"),
            "relaxation_time": positive("time", None, "viscosity over rigidity of a body that flows as Maxwell's"),
            "exponent": Option(
                "dimensionless", None, "alpha of Andrade's creep on top of it", minimum=0.0, maximum=1.0,
                exclusive=True,
            ),
            "fluid_love_number": positive(
                "dimensionless", 1.5, "k_2 were it fluid; love_number is then the elastic one",
            ),
        },
        "body", "Mignard 1979; Goldreich & Soter 1966; Efroimsky 2012", ("rigid",), colour="green",
        size=Measure(
            "(M'/M) (R/a)^3",
            "torque on the lagging tide times the run, over L",
            "Goldreich & Soter 1966", _tidal_torque, (*_TURNS, "neighbours"), ("love_number", "radius"),
        ),
    ),
    "rotational_deformation": Entry(
        "the bulge of an elastic body, which follows its rotation at once and so slows its wobble",
        {
            "love_number": positive("dimensionless", REQUIRED, "k_2"),
            "radius": positive("length", REQUIRED, "equatorial radius of the body"),
            "rate": not_negative(
                "angular_velocity", 0.0, "rotation about the largest moment at which the body has its moments",
            ),
        },
        "body", "Munk & MacDonald 1960, chapter 6; Love 1909", ("rigid",), colour="vermillion",
        size=Measure(
            "bulge k2 R^5 omega^2/(3 G C)",
            "what the bulge adds to C, and the wobble where its phase has changed",
            "Munk & MacDonald 1960, 6", _rotational_deformation, _TURNS, ("love_number", "radius"),
        ),
    ),
}  # fmt: skip
