"""How large every effect is in a scene: a dimensionless number, and by what part I and spin would change without it.

Upper estimates, within a factor of MARGIN: what is secular grows with the run, what a collapse makes large counts as
soon as the run is as long as the fall. Nothing here imports an effect. Tests: tests/unit/effects/test_sizes.py.
"""

import math
from dataclasses import dataclass, replace

from astroinertia.bodies.bar_limits import SECULAR
from astroinertia.effects.characteristic import Characteristic, tidal_parameter
from astroinertia.effects.measure import Found, Measure, Options, size, within_all
from astroinertia.effects.one_zone import braked, difference

MARGIN = 3.0  # by which estimates may be wrong: an effect counts from a third of the accuracy on
BULGE = 5.0  # of a liquid sphere in a tide, over its tidal parameter: twice 5/2, for a tide that comes suddenly
ROCHE = 0.05  # tidal parameter beyond which a liquid is torn: 1/2.455^3 = 0.068
HEAVIER = 4.0  # times its compactness a star is heavier for relativity: Gamma, pressure and energy in the mean
CAPTURES, LEFT = (3e10, 2e16), 0.56  # kg/m3 between which electrons are captured, and what is left of them
DENSER = 8.0  # that a body that does not collapse may become, by half its radius


@dataclass(frozen=True)
class Size:
    """An effect's number and its name, the change if it were left out, how that is found, and what is not known.

    change is None where `unknown` says what the scene does not tell, and number where it means nothing.
    """

    name: str
    number: float | None
    change: float | None
    formula: str
    source: str
    unknown: str = ""

    def counts(self, accuracy: float) -> bool:
        """Whether leaving the effect out could cost that accuracy; so it is, too, where that is not known."""
        return self.change is None or self.change * MARGIN > accuracy


def effect_size(measure: Measure | None, body: Characteristic, options: Options | None = None) -> Size:
    """The size of an effect with these options (None: it is not listed, and has none).

    measure: the effect's; without one its size is not known.
    """
    if measure is None:
        return Size("", None, None, "", "", "the effect states no size")
    if "zone" in measure.needs and not body.deforms:
        return Size(measure.name, None, 0.0, "what keeps its size or shape does not yield to it", measure.source)
    missing = [name for name in measure.needs if getattr(body, name) is None]
    if not missing and options is None and measure.options:
        return _unknown(measure, "it needs numbers of its own")
    values = {} if options is None else options
    missing += [name for name in measure.options if values.get(name) is None]
    if missing:
        return _unknown(measure, f"the scene does not tell its {missing[0].replace('_', ' ')}")
    try:
        number, change = measure.function(body, values)
    except (TypeError, KeyError, ZeroDivisionError, OverflowError):  # options that contradict: said when it is built
        return _unknown(measure, "its options do not tell")
    return Size(measure.name, number, change, measure.formula, measure.source)


def _unknown(measure: Measure, what: str) -> Size:
    return Size(measure.name, None, None, measure.formula, measure.source, what)


def _gravity(body: Characteristic, options: Options) -> Found:
    zone = body.zone
    assert zone is not None
    weight_over_heat = zone.weight / (zone.pressure + zone.turning) if zone.pressure + zone.turning > 0.0 else math.inf
    if body.held:
        return weight_over_heat, within_all(zone.weight * body.end**2)
    return weight_over_heat, difference(zone, body.end, weight=0.0)


def _pressure(body: Characteristic, options: Options) -> Found:
    zone = body.zone
    assert zone is not None
    share = body.thermal_to_gravitational
    number = zone.pressure / zone.weight if share is None and zone.weight > 0.0 else share or 0.0
    if body.held:
        return number, 1.0
    if zone.pressure == 0.0:
        return number, 0.0
    return number, max(difference(zone, body.end, pressure=0.0), within_all(body.fallen))


def _viscosity(body: Characteristic, options: Options) -> Found:
    zone = body.zone
    assert zone is not None and body.mass is not None and body.radius is not None
    if zone.pressure == 0.0:
        return 0.0, 0.0
    if body.bodies > 1 or body.touching:
        return math.inf, 1.0
    sound = math.sqrt(body.gamma * zone.pressure / 3.0)
    mach = braked(zone, body.end) / sound if sound > 0.0 else 0.0
    periods = max(1.0, body.end * zone.frequency / (2.0 * math.pi))
    heat = min(1.0, mach) ** 2 * min(1.0, mach * periods)  # waves of Mach number m steepen within 1/m periods
    return mach, max(within_all(heat), 0.0 if body.homologous else body.falling)


def _conduction(body: Characteristic, options: Options) -> Found:
    return (1.0, 1.0) if body.touching else (0.0, 0.0)


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
    return min(pericentre / (1.0 - e) * (1.0 - e * math.cos(_eccentric(m, e))) for m in (first, last))


def _eccentric(mean: float, e: float) -> float:
    reduced = math.remainder(mean, 2.0 * math.pi)
    low, high = (-math.pi, 0.0) if reduced < 0.0 else (0.0, math.pi)
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if middle - e * math.sin(middle) < reduced else (low, middle)
    return 0.5 * (low + high)


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


def _shear_viscosity(body: Characteristic, options: Options) -> Found:
    assert body.radius is not None
    decay = 5.0 * options["kinematic_viscosity"] * body.end / body.radius**2
    zone = body.zone
    steady = body.shear == 0.0 and body.expansion == 0.0 and zone is not None and body.bodies == 1
    if steady and zone is not None and (body.rotational_to_gravitational or 0.0) < SECULAR:
        return decay, within_all(decay * zone.imbalance)  # rigid rotation has no friction: what moves is what swings
    return decay, within_all(decay)


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


def _deleptonisation(body: Characteristic, options: Options) -> Found:
    zone, dense = body.zone, body.central_density
    assert zone is not None and dense is not None
    if options["mass_unit"] is not None:
        dense *= options["mass_unit"] / options["length_unit"] ** 3
    elif body.gravitational_constant == 1.0:
        raise KeyError("mass_unit")
    first, last = CAPTURES
    reached = 1.0 if body.falling > 0.0 else min(max(math.log(dense / first) / math.log(last / first), 0.0), 1.0)
    left = 1.0 - (1.0 - LEFT) * reached
    return 1.0 - left, difference(zone, body.end, pressure=zone.pressure * left ** (4.0 / 3.0))


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


def _cooling(body: Characteristic, options: Options) -> Found:
    assert body.thermal_energy is not None and body.mass is not None
    specific = body.thermal_energy / body.mass
    if specific == 0.0 and not options["heating_rate"]:
        return 0.0, 0.0
    times = 0.0
    if options["law"] == "beta":
        times = (body.spin or 0.0) * body.end / options["beta"]
    elif options["time_scale"] is not None:
        scale = options["time_scale"]
        if options["law"] == "power_law":
            dense = (body.central_density or 0.0) / options["reference_density"]
            warm = specific / options["reference_energy"]
            scale *= dense ** -options["density_exponent"] * warm ** (1.0 - options["energy_exponent"])
        change = options["time_scale_change"] or 0.0
        left = 1.0 + change * body.end / scale
        times = body.end / scale if change == 0.0 else math.log(left) / change if left > 0.0 else math.inf
    if options["floor"] is not None and specific <= options["floor"]:
        times = 0.0
    if options["heating_rate"]:
        times += options["heating_rate"] * body.end / specific if specific > 0.0 else math.inf
    return times, _heat_change(body, times)


def _heat_change(body: Characteristic, share: float) -> float:
    """What a share of the heat means to the size: R ~ A^(1/(3 gamma - 4)) of what is bound; no more than pressure."""
    zone = body.zone
    bound = zone is not None and zone.weight > zone.pressure
    steep = 2.0 / max(3.0 * body.gamma - 4.0, 0.5) if bound or zone is None or zone.imbalance < 0.5 else 2.0
    return within_all(min(1.0, steep * share) * _pressure(body, {})[1])


def _neutrino_loss(body: Characteristic, options: Options) -> Found:
    assert body.thermal_energy is not None and body.mass is not None and body.central_density is not None
    if options["law"] == "diffusion":
        reached = body.central_density * DENSER > options["density"] or body.falling > 0.0
        share = body.end / options["time_scale"] if reached else 0.0
    else:
        specific = body.thermal_energy / body.mass
        warm = specific / options["thermal_energy"]
        share = options["rate"] * warm**6 * body.end / specific if specific > 0.0 else 0.0
        share = math.inf if body.falling > 0.0 else share
    return share, _heat_change(body, share)


_ZONE = ("mass", "radius", "zone")
GRAVITY = Measure(
    "|W| over 3 Pi + 2 T", "I of one zone by the virial theorem, with |W| and without",
    "Chandrasekhar 1969, section 14", _gravity, _ZONE,
)  # fmt: skip
PRESSURE = Measure(
    "U/|W|", "I of one zone with 3 Pi and without; mass whose free fall ends",
    "Chandrasekhar 1969, section 14", _pressure, _ZONE,
)  # fmt: skip
VISCOSITY = Measure(
    "Mach number of the braked fall", "M^2 of the heat, once waves of that Mach number have steepened; what falls",
    "Landau & Lifshitz 1987, Fluid Mechanics, section 101", _viscosity, _ZONE,
)  # fmt: skip
CONDUCTION = Measure(
    "contacts of materials", "all where matter of different kinds meets; a device without a size of its own else",
    "Price 2008", _conduction,
)  # fmt: skip
DAMPING = Measure(
    "run over time scale", "1 - exp(-t/tau)", "Gingold & Monaghan 1977", _damping, (), ("time_scale",),
)  # fmt: skip
ROTATING_FRAME = Measure(
    "turn of the frame in the run", "the angle that it turns by", "Landau & Lifshitz 1976, eq. 39.7",
    _rotating_frame, (), ("rate",),
)  # fmt: skip
TIDE = Measure(
    "(M'/M) (R/d)^3 at the nearest", "five times that if bound, times (t/t_dyn)^2 at first; all beyond Roche",
    "Murray & Dermott 1999, section 4.2", _tide, ("mass", "radius"), ("mass", "position"),
)  # fmt: skip
COMPANIONS = Measure(
    "(M'/M) (R/d)^3 at the nearest", "five times that if bound, times (t/t_dyn)^2 at first; all beyond Roche",
    "Murray & Dermott 1999, section 4.2", _companions, ("mass", "radius", "neighbours"),
)  # fmt: skip
SINKS = Measure(
    "central density over the sinks'", "all once the density is reached; the mass whose free fall ends before",
    "Bate, Bonnell & Price 1995", _sinks, ("central_density",), ("density",),
)  # fmt: skip
EXTERNAL_FIELD = Measure(
    "tidal field times R^3/(G M)", "as a tide of that size", "Binney & Tremaine 2008, section 8.2",
    _external_field, ("mass", "radius"), ("origin",),
)  # fmt: skip
TARGET_TENSOR = Measure(
    "stiffness times R^3/(G M)", "stiffness times t^2, or t_dyn^2", "Zajac, Jones & Glazier 2003",
    _target_tensor, ("mass", "radius"), ("stiffness",),
)  # fmt: skip
SHEAR_VISCOSITY = Measure(
    "5 nu t/R^2", "that, where the flow has shear; times the imbalance of forces in rigid rotation",
    "Lamb 1932, section 355; Chandrasekhar 1969, section 37", _shear_viscosity, ("radius",),
    ("kinematic_viscosity",),
)  # fmt: skip
RADIATION_REACTION = Measure(
    "G M/(R c^2)", "6.4 (G M/(R c^2))^(5/2) ((B - A)/C)^2 (omega t_dyn)^4 t/t_dyn; t over inspiral",
    "Peters 1964; Misner, Thorne & Wheeler 1973, eq. 36.8", _radiation_reaction, ("mass", "radius", "moments"),
)  # fmt: skip
RELATIVISTIC_POTENTIAL = Measure(
    "G M/(R c^2)", "I of one zone by the virial theorem, with a weight larger by four times that",
    "Chandrasekhar 1969, section 14; Marek et al. 2006", _relativistic_potential, _ZONE,
)  # fmt: skip
DELEPTONISATION = Measure(
    "share of electrons captured", "I of one zone with the pressure of those left to the power 4/3",
    "Liebendoerfer 2005", _deleptonisation, (*_ZONE, "central_density"),
)  # fmt: skip
COOLING = Measure(
    "run in cooling times", "2/(3 gamma - 4) of that, times what pressure does", "Chandrasekhar 1939, chapter 4",
    _cooling, (*_ZONE, "thermal_energy"), ("law",),
)  # fmt: skip
NEUTRINO_LOSS = Measure(
    "run in times of loss", "2/(3 gamma - 4) times that, of what pressure does", "Janka 2001",
    _neutrino_loss, (*_ZONE, "thermal_energy", "central_density"), ("law",),
)  # fmt: skip
