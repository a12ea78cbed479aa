"""How many time steps particles will take, from the body as spherical shells.

A body that keeps its profile is followed as one zone (effects.one_zone), whose size scales its shells: in equilibrium
it rests, or shrinks as it loses heat. What falls together against pressure is followed as shells that move by
themselves (costs.shells), to its bounce and beyond, standard problems by their exact flows (costs.flows); planets of
layers rest (costs.planets). That is exact of neither shocks nor shapes: a pilot run (costs.pilot) counts. Tests:
tests/unit/costs/test_course.py and test_costs.py.
"""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from astroinertia.build.flow import flow_of_shells, linear_flow
from astroinertia.build.spheres import Sphere, progenitor, stretched
from astroinertia.costs import flows, shells, torn
from astroinertia.costs.crowding import neighbours
from astroinertia.costs.evaluations import BY_NEIGHBOURS, SHARES, Counts
from astroinertia.costs.fields import fields
from astroinertia.costs.limits import Limits, Matter, length, limits
from astroinertia.costs.shells import Shells
from astroinertia.effects.one_zone import lasting
from astroinertia.engines.few import FEW
from astroinertia.errors import AstroinertiaError
from astroinertia.scene.body_kinds.layered import LayeredPlanet
from astroinertia.scene.body_kinds.profile import ProfileBody
from astroinertia.scene.body_kinds.standard import StandardBody
from astroinertia.scene.characteristic import added_weight, characteristic
from astroinertia.scene.fluids import MONATOMIC
from astroinertia.scene.further_pressure import further_pressure
from astroinertia.scene.plan import code_units, smoothing
from astroinertia.scene.schema import Scene
from astroinertia.sph import rung_costs
from astroinertia.sph.kernels import KERNELS
from astroinertia.units import pressure_constant_dimension

DEEPEST = 40  # rungs, more than any run has
CROWDED = 30  # moments, at which neighbours are counted
ACTIVE = 0.5  # of the particles, where intervals end within a base step (tests/benchmarks/results/individual_steps.md)
MOMENTS = 400  # in which a body that loses heat is followed
IN_BALANCE = 0.02  # departure from equilibrium, up to which a body rests
SHAKEN = 0.35  # of the size: what falls to it against pressure is followed as shells
STABLE = 4.0 / 3.0  # exponent, below which pressure does not hold what collapses
LEAST_LEFT = 1e-9  # of a cooling time that falls to nothing
NOTICED = 1e-3  # of a cooling time, a change that makes moments dense
SMALLEST = 0.02  # size: a body that nothing holds up becomes something else


def counted(scene: Scene) -> Counts | None:
    """The steps of a run; of several bodies those of the one that takes most, None where one's are not known."""
    counts = [_counted(alone) for alone in scene.alone()]
    known = [count for count in counts if count is not None]
    return max(known, key=lambda count: count.ends) if len(known) == len(counts) else None


def _counted(scene: Scene) -> Counts | None:
    from scipy.integrate import cumulative_trapezoid  # only here: other models do without it

    end = float(code_units(scene).to_code(scene.time.end, "time"))
    try:
        found, crowding = _limits(scene, end)
    except AstroinertiaError:
        return None
    if found is None or found.times[-1] < end * (1.0 - 1e-9):
        return None  # what it becomes is not in this picture
    times, longest = found.times, found.longest
    step, own = np.minimum(found.shortest, longest), scene.numerics.timesteps == "individual"
    finest = _rungs_that_pay(found.below, step, scene.body.particles or 0) if own else np.zeros_like(step)
    base = np.minimum(np.where(finest > 0.0, 2.0**rung_costs.BEYOND, 1.0) * step * 2.0**finest, longest)
    interval = base / 2.0 ** np.ceil(np.log2(base / step) - 1e-9)  # one that is cut short is still in powers of two

    def until(step: np.ndarray, each: np.ndarray | float = 1.0) -> np.ndarray:
        passed = cumulative_trapezoid(each / np.minimum(step, end), times, initial=0.0)
        return np.interp(np.linspace(0.0, end, SHARES + 1), times, passed + times / end)  # the end cuts the last short

    weight = 1.0 / np.minimum(base, end)
    work = until(step, 1.0 - BY_NEIGHBOURS + BY_NEIGHBOURS * crowding)
    steps, ends = float(until(base)[-1]), float(until(interval)[-1])
    return Counts(
        steps, steps + ACTIVE * (ends - steps), ends, "an estimate", tuple(map(float, work / work[-1])),
        _mean(crowding, weight, times), _mean(finest == 0.0, weight, times) if own else 0.0, found.first,
    )  # fmt: skip


def _rungs_that_pay(below: np.ndarray, step: np.ndarray, particles: int) -> np.ndarray:
    """How many rungs there are below the longest interval, (K,), with limits that PARTS of the matter are below."""
    above = np.floor(np.log2(np.clip(below / step, 1.0, 2.0**DEEPEST)) + 1e-9).astype(np.int64)
    kinds, kind = np.unique(above, axis=1, return_inverse=True)  # few, of thousands of moments
    each = particles / len(below)
    found = [rung_costs.that_pay(each * np.bincount(powers), rung_costs.BEYOND, DEEPEST, False) for powers in kinds.T]
    return np.array(found, float)[kind.reshape(-1)]


def _mean(of: np.ndarray | float, weight: np.ndarray, times: np.ndarray) -> float:
    """The weighted mean over times, (K,)."""
    return float(np.trapezoid(of * weight, times) / np.trapezoid(weight, times))


def _limits(scene: Scene, end: float) -> tuple[Limits | None, np.ndarray | float]:
    """The limits of a body, None where nothing is known of it, and its mean number of neighbours over that at first."""
    body: Any = scene.body
    if isinstance(body, StandardBody):
        return limits(scene, flows.matter(scene, end)), 1.0
    if isinstance(body, LayeredPlanet):
        from astroinertia.costs.planets import planet  # with its matter, which other bodies do without

        found = planet(scene) if scene.has_equilibrium else None
        return (None if found is None else limits(scene, [replace(found, time=time) for time in (0.0, end)])), 1.0
    start = None if scene.sinks else at_start(scene)  # what falls onto a star or goes round it is in no picture here
    if start is None:
        return None, 1.0
    course = similar(scene, start, end)
    settled = body.relax and body.settles  # what it settles to is not these shells, but has as much room
    keeps = course is not None and (settled or body.homologous or start.field is not None or start.evenly_driven)
    moments = [] if keeps else shells.followed(start, end)
    if course is not None and (keeps or not moments or moments[-1].time < end):
        return limits(scene, course.matter(scene, start)), 1.0
    if not moments:
        return None, 1.0
    # Of few particles every one is looked at as a neighbour anyhow.
    crowding = 1.0 if body.particles <= FEW else _crowding(scene, start, moments)
    return limits(scene, _moving(scene, start, moments)), crowding


class Course(NamedTuple):
    """Of a body that keeps its profile: times, sizes over that at first, their rates, what is left of entropy, (K,)."""

    times: np.ndarray
    sizes: np.ndarray
    speeds: np.ndarray
    entropy: np.ndarray

    def matter(self, scene: Scene, start: Shells) -> list[Matter]:
        """The shells of the start at those times, as they have grown."""
        zone = start.zone
        sound, support, whole = start.sound, KERNELS[scene.numerics.kernel].support, float(start.mass.sum())
        found = []
        for time, size, speed, entropy in zip(*self, strict=True):
            density = start.density / size**3
            signal = sound * math.sqrt(entropy) * size ** (-1.5 * (zone.gamma - 1.0))
            if zone.pressure > 0.0:  # which the signals are of
                signal = signal + abs(speed) / size * support * length(scene, whole, density)
            pulled = zone.frequency**2 * start.radius / size**2
            found.append(Matter(time, start.mass, density, signal, pulled, size * start.radius, speed * start.radius))
        return found


def similar(scene: Scene, start: Shells, end: float) -> Course | None:
    """The course of a body that keeps its profile; None of one that falls together and is shocked."""
    body: Any = scene.body
    zone = start.zone
    if body.homologous:
        times = np.linspace(0.0, end, MOMENTS)
        sizes = body.core(float(start.mass.sum()), float(start.radius[-1])).scale_factor(times)
        return Course(times, sizes, np.gradient(sizes, times), np.ones_like(times))
    if zone.imbalance < IN_BALANCE and not zone.expansion:
        times, entropy = _cooled(scene, end)
        sizes = np.ones_like(times)
        if zone.gamma > STABLE:
            sizes = entropy ** (1.0 / (3.0 * zone.gamma - 4.0))  # of what P = K rho^gamma holds up
        index, mass, radius = getattr(body, "index", None), float(start.mass.sum()), float(start.radius[-1])
        grown = torn.grown(scene.effects.get("tide"), code_units(scene), index, mass, radius, end)
        if grown is not None:
            times, sizes, entropy = *grown, np.ones_like(grown[0])
        sizes = np.minimum(sizes, shells.FARTHEST)
        return Course(times, sizes, np.gradient(sizes, times), entropy)
    if start.field is not None and zone.pressure > 0.0:
        return None  # whose pull goes with the size otherwise than gravity's
    path = lasting(zone, end)
    falls = path.size.min() <= SHAKEN or (zone.gamma < STABLE and path.size[-1] < 1.0)
    if zone.pressure > 0.0 and falls:
        return None
    times, sizes, speeds = path.time, np.maximum(path.size, SMALLEST), path.speed
    if times[-1] < end:  # it has fallen together, or nothing acts any more
        last = max(float(speeds[-1]), 0.0) if sizes[-1] > 1.0 else 0.0
        sizes = np.append(sizes, min(sizes[-1] + last * (end - times[-1]), shells.FARTHEST))
        times, speeds = np.append(times, end), np.append(speeds, last)
    return Course(times, sizes, speeds, np.ones_like(times))


def _cooled(scene: Scene, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (K,), dense where they matter, and what is left of K of P = K rho^gamma where heat is lost everywhere
    alike: dK/dt = -K/tau, tau changing at its constant rate.
    """
    options = scene.effects.get("cooling", {})
    tau, change = options.get("time_scale"), options.get("time_scale_change") or 0.0
    if options.get("law") != "time_scale" or tau is None or options["heating_rate"] or options["floor"]:
        return np.array([0.0, end]), np.ones(2)
    tau = float(code_units(scene).to_code(tau, "time"))
    if abs(change) * end < NOTICED * tau:
        times = np.linspace(0.0, end, MOMENTS)
        return times, np.exp(-times / tau)
    left = np.geomspace(1.0, max(1.0 + change * end / tau, LEAST_LEFT), MOMENTS)
    return (left - 1.0) * tau / change, left ** (-1.0 / change)


def _moving(scene: Scene, start: Shells, moments: list[shells.Moment]) -> list[Matter]:
    """Shells that move by themselves, with the signals that viscosity makes of it."""
    support, viscosity = KERNELS[scene.numerics.kernel].support, scene.effects.get("viscosity")
    found, whole = [], float(start.mass.sum())
    signal, alpha, time = np.zeros_like(start.mass), np.zeros_like(start.mass), 0.0
    for moment in moments:
        of_length = length(scene, whole, moment.density)
        left, reach = len(of_length), support * of_length
        alpha, signal = alpha[-left:], signal[-left:]  # of those that no sink has taken
        if viscosity is not None:
            wanted = np.minimum(viscosity["alpha_max"], (2.0 / support) ** 2 * shells.steepening(moment, reach))
            kept = np.exp(-(moment.time - time) * signal / (viscosity["decay_length"] * of_length))
            alpha = np.maximum(wanted, wanted + kept * (alpha - wanted))
            if viscosity["switch"] == "none":
                alpha = np.full_like(of_length, viscosity["alpha_max"])
        signal, time = shells.signals(moment, reach, viscosity, alpha), moment.time
        pulled = np.abs(moment.acceleration)
        found.append(Matter(time, start.mass[-left:], moment.density, signal, pulled, moment.radius, moment.speed))
    return found


def _crowding(scene: Scene, start: Shells, moments: list[shells.Moment]) -> np.ndarray:
    """How many neighbours particles in the shells have at those moments, over how many at first, (K,)."""
    kernel, eta = KERNELS[scene.numerics.kernel], smoothing(scene)[0]
    particle = float(start.mass.sum()) / (scene.particles or 1)
    chosen = np.unique(np.linspace(0, len(moments) - 1, CROWDED).astype(int))
    means = []
    for moment in (moments[number] for number in chosen):
        own = start.mass[-len(moment.radius) :]
        means.append(np.average(neighbours(own, moment.middle, particle, kernel, eta), weights=own))
    return np.interp(np.arange(len(moments)), chosen, np.array(means) / means[0])


def at_start(scene: Scene) -> Shells | None:
    """The body of a scene as shells of a sphere of the same volume, in code units; None of one without a profile."""
    units = code_units(scene)
    body: Any = scene.body
    fluid: Any = scene.equation_of_state
    if body.particles is None or (not isinstance(body, ProfileBody) and body.profile() is None):
        return None
    initial = progenitor(scene, units) if isinstance(body, ProfileBody) else stretched(scene, units)
    size = initial.radius * body.volume_ratio ** (1.0 / 3.0)
    if body.quickly_known:  # its outer parts are thin: a sphere that is as dense in the middle
        greatest = units.to_code(body.equilibrium(units.gravitational_constant).max_density, "density")
        size = initial.radius * (initial.density(np.zeros(1))[0] / float(greatest)) ** (1.0 / 3.0)
    # The innermost is as much as a particle at the centre sees: 1/W(0) of the density.
    seen = smoothing(scene)[0] ** 3 / KERNELS[scene.numerics.kernel].w(np, 0.0) / body.particles
    steep = max(1.0, math.log(seen) / math.log(1.0 / shells.SHELLS))
    within = np.linspace(0.0, 1.0, shells.SHELLS + 1)[1:] ** min(steep, 3.0)
    places = initial.profile.radius(within)
    mass, radius = initial.mass * np.diff(within, prepend=0.0), size * places
    thermal = MONATOMIC if fluid is None else fluid.thermal_gamma
    hot = (body.specific_internal_energy or body.entropy) is not None and thermal  # what is hot holds it up
    gamma = thermal if hot or fluid is None else fluid.first_gamma
    turning = _turning(scene, initial, mass, places, radius)
    stiffer = () if fluid is None else fluid.pieces
    pieces = tuple((float(units.to_code(beyond, "density")), exponent) for beyond, exponent in stiffer)
    sinks, sink = scene.effects.get("sinks"), None
    if sinks is not None:
        forms = math.inf if sinks["density"] is None else float(units.to_code(sinks["density"], "density"))
        sink = forms, float(units.to_code(sinks["radius"], "length"))
    weight = 1.0 if "gravity" in scene.effects else 0.0
    given = fields(scene)
    placed = () if given is None else [effect.kind for effect in given.effects]  # which are followed as they are
    weighing = [kind for kind in scene.effects if scene.entries[kind].added_weight and kind not in placed]
    if weighing:
        weight *= 1.0 + added_weight(scene, characteristic(scene), weighing)
    growth = float(np.trace(linear_flow(scene, units, np.eye(3)))) / 3.0
    found = Shells(
        mass, radius, shells.in_balance(mass, radius), gamma, pieces, thermal, turning, sink, None, weight, growth
    )
    if "pressure" not in scene.effects:
        found = replace(found, pressure=np.zeros_like(mass))
    else:
        found = replace(found, pressure=_pressure(scene, initial, found, places), further=further_pressure(scene))
    own = found.zone.frequency**2 * radius
    if given is not None and (np.abs(given.inward(radius)) > IN_BALANCE * own).any():
        return replace(found, field=given.inward)
    return found


def _pressure(scene: Scene, initial: Sphere, balanced: Shells, places: np.ndarray) -> np.ndarray:
    """The pressure (K,) of the scene's matter in shells whose own holds them up, at distances over the radius."""
    units = code_units(scene)
    body: Any = scene.body
    fluid, density, gamma = scene.equation_of_state, balanced.density, balanced.gamma
    if body.specific_internal_energy is not None:
        return (gamma - 1.0) * float(units.to_code(body.specific_internal_energy, "specific_energy")) * density
    held = body.support * balanced.pressure
    share, stretch = body.pressure_fraction or 1.0, initial.radius / balanced.radius[-1]
    if initial.tabulated is not None:
        held = initial.tabulated(places)[0]
    stated = None if fluid is None else fluid.stated_constant
    if (sound_speed := getattr(fluid, "sound_speed", None)) is not None:  # of one temperature
        return float(units.to_code(sound_speed, "velocity")) ** 2 * density
    if stated is None:
        constant = body.entropy if body.isentropic else None
    elif isinstance(stated, float):
        constant = float(units.to_code(stated, pressure_constant_dimension(gamma)))
    else:  # the one that the body's centre has
        pressure, dense = initial.densest()
        constant = share * pressure * stretch**4 / (dense * stretch**3) ** gamma
    return share * held if constant is None else constant * density**gamma


def _turning(scene: Scene, initial: Sphere, mass: np.ndarray, places: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """The mean square of the specific angular momentum (K,) of shells, as six points on each have it."""
    units = code_units(scene)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    points = (radius[:, None, None] * axes).reshape(-1, 3)
    velocity = flow_of_shells(scene, units, initial, np.repeat(mass / 6.0, 6), points, np.repeat(places, 6))
    return radius**2 * (velocity**2).sum(axis=1).reshape(-1, 6).mean(axis=1)
