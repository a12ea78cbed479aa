"""How many time steps particles will take, from the body as a sphere that stays similar to itself.

Its size a(t), 1 at the start, follows a'' = -W/a^2 + H/a^(3 gamma - 2) + S/a^3 (gravity, pressure, spin), with what the
profile says of W, H and S; its steps are those of the densest particles. What falls together against pressure is
followed as shells instead (costs.shells), to its bounce and beyond, standard problems by their exact flows
(costs.flows); planets of layers rest (costs.planets). That is exact of neither shocks nor shapes: a pilot run
(costs.pilot) counts. Tests: tests/unit/costs/test_course.py and test_costs.py.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from astroinertia.build.spin import rotation_amount
from astroinertia.costs import flows, shells, torn
from astroinertia.costs.crowding import neighbours
from astroinertia.costs.evaluations import BY_NEIGHBOURS, SHARES
from astroinertia.costs.limits import NOT_KNOWN, PARTS, Limits, passed
from astroinertia.effects.entries import DIFFUSION_PART, FREE_FALL_PART
from astroinertia.engines.few import FEW
from astroinertia.errors import AstroinertiaError
from astroinertia.scene.body_kinds.layered import LayeredPlanet
from astroinertia.scene.body_kinds.profile import ProfileBody
from astroinertia.scene.body_kinds.standard import StandardBody
from astroinertia.scene.fluids import MONATOMIC
from astroinertia.scene.further_pressure import further_pressure
from astroinertia.scene.plan import code_units, smoothing
from astroinertia.scene.schema import Scene
from astroinertia.sph import rung_costs
from astroinertia.sph.kernels import KERNELS
from astroinertia.sph.profiles import Profile
from astroinertia.units import pressure_constant_dimension

DEEPEST = 40  # rungs, more than any run has
CROWDED = 30  # moments, at which neighbours are counted
MOMENTS = 4000  # in which the sphere is followed
SMALLEST = 0.02  # of its size, at which a sphere that nothing holds up has become something else
SCATTERED = 1e6  # of its size, from which on a sphere that expands coasts
STABLE = 4.0 / 3.0  # exponent, below which pressure does not hold what collapses
LEAST_LEFT = 1e-9  # of a cooling time that falls to nothing
STILL = 1e-30  # a signal, below which nothing is
NOTICED = 1e-3  # of a cooling time, a change that makes moments dense
MIDDLES = 200  # of shells of equal mass, over which means are taken
HALVINGS = 60  # in which a size is looked for
FARTHEST = 1e30  # the largest size, whose powers are still numbers
STIRRED = 0.25  # of the greatest viscosity: as long as that are steps of planets that have met (sims/giant_impact.toml)
SHAKEN = 0.35  # of the size: to which a sphere that collapses settles after its shocks, at least (virial: a half)


@dataclass(frozen=True)
class Sphere:
    """What of a body sets its course, in code units with W, H and S as above.

    densest: density that particles see at the centre; densities: those that PARTS of the mass are within; sound: its
    speed in the centre; gamma: of the pressure. speed: a' at the start; smooth: whether it stays similar to itself
    without any shock. cooling_time, cooling_change: tau at first, in which it loses its heat, and the rate at which
    tau changes.
    """

    gravity: float
    pressure: float
    spin: float
    gamma: float
    densest: float
    densities: np.ndarray
    sound: float
    particle_mass: float
    size: float
    speed: float = 0.0
    smooth: bool = False
    cooling_time: float = math.inf
    cooling_change: float = 0.0

    def push(self, size: Any, entropy: Any = 1.0) -> Any:
        """a'' at that size, with so much of the entropy that it has at first."""
        heat = entropy * self.pressure
        return -self.gravity / size**2 + heat / size ** (3.0 * self.gamma - 2.0) + self.spin / size**3

    @property
    def pace(self) -> float:
        """The rate of what is fastest."""
        return math.sqrt(max(self.gravity, self.pressure, self.spin, 1e-30))

    @property
    def settled(self) -> bool:
        """Whether it rests in equilibrium, and heat that it loses is all that changes it."""
        return abs(self.push(1.0)) < 0.02 * self.pace**2 and not self.smooth

    def entropy(self, time: Any) -> Any:
        """What is left then of K of P = K rho^gamma: dK/dt = -K/tau, tau changing at its constant rate."""
        if self.cooling_change == 0.0:
            return np.exp(-time / self.cooling_time)
        left = np.maximum(1.0 + self.cooling_change * time / self.cooling_time, LEAST_LEFT)
        return left ** (-1.0 / self.cooling_change)


@dataclass(frozen=True)
class Done:
    """How many steps are done, (SHARES + 1,), when so many equal parts of the run's time are over: global ones, and
    where particles have steps of their own, base steps and ends of intervals.

    looked: share of steps, or base steps, in which it has to be looked at whether matter that is apart may meet.
    crowding: mean number of neighbours in them, over that at the start. work: as steps, each by what it takes. alike:
    share of base steps that are of one interval for all, if particles have their own.
    """

    steps: np.ndarray
    base: np.ndarray
    ends: np.ndarray
    looked: float
    crowding: float
    work: np.ndarray
    alike: float


def done(scene: Scene) -> Done | None:
    """The steps of a run; of several bodies those of the one that takes most, None where one's are not known."""
    stirred = _planets_meet(scene)
    counts = [_done_of(alone, stirred) for alone in scene.alone()]
    estimates = [count for count in counts if count is not None]
    if len(estimates) < len(counts):
        return None
    return max(estimates, key=lambda count: count.steps[-1])


def _planets_meet(scene: Scene) -> bool:
    """Whether two planets are on an orbit on which they touch."""
    if scene.orbit is None or not all(isinstance(body, LayeredPlanet) for body in scene.bodies):
        return False
    found = [_planet(alone) for alone in scene.alone()]
    reach = math.fsum(planet.radius for planet in found if planet is not None)
    return code_units(scene).to_code(scene.orbit.pericentre, "length") < reach


def _planet(scene: Scene) -> Any:
    from astroinertia.costs.planets import planet  # with its matter, which other bodies do without

    return planet(scene)


def _done_of(scene: Scene, stirred: bool) -> Done | None:
    from scipy.integrate import cumulative_trapezoid  # only here: other models do without it

    units, numerics = code_units(scene), scene.numerics
    end = float(units.to_code(scene.time.end, "time"))
    try:
        limits = flows.limits(scene, end) if isinstance(scene.body, StandardBody) else _limits(scene, end, stirred)
    except AstroinertiaError:
        return None
    times = limits.times
    if not len(times) or times[-1] < end * (1.0 - 1e-9):
        return None  # what it becomes is not in this picture
    longest = np.minimum(limits.longest, _limit_by_options(scene, times))
    if numerics.max_timestep is not None:
        longest = np.minimum(longest, float(units.to_code(numerics.max_timestep, "time")))
    step = np.minimum(limits.shortest, longest)
    finest = _rungs_that_pay(limits.below, step, scene.body.particles or 0)
    base = np.minimum(np.where(finest > 0.0, 2.0**rung_costs.BEYOND, 1.0) * step * 2.0**finest, longest)
    interval = base / 2.0 ** np.ceil(np.log2(base / step) - 1e-9)  # one that is cut short is still in powers of two

    def counted(step: np.ndarray, each: np.ndarray | float = 1.0) -> np.ndarray:
        until = cumulative_trapezoid(each / np.minimum(step, end), times, initial=0.0)
        return np.interp(np.linspace(0.0, end, SHARES + 1), times, until + times / end)  # the end cuts the last short

    whole = np.minimum(step if numerics.timesteps == "global" else base, end)
    looked, crowding = (_mean(each, 1.0 / whole, times) for each in (whole > limits.passing, limits.crowding))
    each = 1.0 - BY_NEIGHBOURS + BY_NEIGHBOURS * limits.crowding
    alike = _mean(finest == 0.0, 1.0 / whole, times)
    return Done(counted(step), counted(base), counted(interval), looked, crowding, counted(step, each), alike)


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


def _limits(scene: Scene, end: float, stirred: bool) -> Limits:
    """The limits of a body as a sphere or as shells; up to no time where nothing is known of it."""
    body: Any = scene.body
    if isinstance(body, LayeredPlanet):
        return _limits_of_planet(scene, end, stirred)
    initial = _initial(scene)
    if initial is None or body.particles is None:
        return NOT_KNOWN
    sphere = sphere_of(scene)
    if sphere.settled:
        tide, index = scene.effects.get("tide"), getattr(body, "index", None)
        torn_apart = torn.grown(tide, code_units(scene), index, initial.mass, sphere.size, end)
        times, sizes = contraction(sphere, end) if torn_apart is None else torn_apart
        sizes = np.minimum(sizes, FARTHEST)
    else:
        times, sizes = course(sphere, end)
        falls = sizes.min() <= SHAKEN or (sphere.gamma < STABLE and sizes[-1] < 1.0)
        if sphere.pressure > 0.0 and falls and not sphere.smooth:
            return _limits_of_shells(scene, sphere, end)
    sounds = sphere.sound * (sphere.densities / sphere.densest) ** (0.5 * (sphere.gamma - 1.0))
    outwards = zip(sphere.densities, sounds, strict=True)
    below = [_steps_at(scene, replace(sphere, densest=there, sound=sound), times, sizes) for there, sound in outwards]
    factor, densest = scene.numerics.free_fall_factor, sphere.densest / sizes**3
    longest = np.full_like(sizes, math.inf) if factor is None else factor / np.sqrt(densest)
    speed = sphere.size * np.hypot(
        _turning(scene, sphere) / sizes, np.gradient(sizes, times) if len(times) > 1 else 0.0
    )
    passing = passed(_length(scene, sphere, sphere.densest / sizes**3), speed)
    return Limits(times, _steps_at(scene, sphere, times, sizes), np.array(below), longest, passing)


class Initial(NamedTuple):
    """The sphere that a body is before axes stretch it, in code units.

    shells: those of a star from a table, in SI; tabulated: pressure and density (K,) there at distances (K,) over the
    radius.
    """

    profile: Profile
    mass: float
    radius: float
    shells: Any = None
    tabulated: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]] | None = None


def _initial(scene: Scene) -> Initial | None:
    """That of a scene; None where its body has no profile."""
    body: Any = scene.body
    units = code_units(scene)
    if isinstance(body, ProfileBody):
        from astroinertia.build.spheres import progenitor  # with stars that turn, which other bodies do without

        star = progenitor(scene, units)
        return Initial(star.profile, star.mass, star.radius, star.shells, star.tabulated)
    profile = body.profile()
    if profile is None:
        return None
    return Initial(profile, float(units.to_code(body.mass, "mass")), float(units.to_code(body.radius, "length")))


def sphere_of(scene: Scene) -> Sphere:
    """The body of a scene, which has a profile, as a sphere of the same volume."""
    units, initial = code_units(scene), _initial(scene)
    assert initial is not None
    body: Any = scene.body
    profile, mass = initial.profile, initial.mass
    size = initial.radius * body.volume_ratio ** (1.0 / 3.0)
    if getattr(body, "quickly_known", False):  # its outer parts are thin: a sphere that is as dense in the middle
        greatest = float(body.equilibrium(units.gravitational_constant).max_density)
        size = (float(profile.density(np.array(0.0))) * mass / float(units.to_code(greatest, "density"))) ** (1.0 / 3.0)
    square = 3.0 * profile.second_moment * size**2  # mean of r^2
    seen = 0.5 * min(1.0, smoothing(scene)[1] / body.particles)  # of the mass: what the innermost kernel is full of
    densest, *densities = profile.density(profile.radius(np.array([seen, *PARTS]))) * mass / size**3
    fraction = body.pressure_fraction or 1.0
    has_gravity, has_pressure = "gravity" in scene.effects, "pressure" in scene.effects
    weight = abs(profile.gravitational_energy) * mass / size / square
    weight = weight if math.isfinite(weight) else mass / size**3
    fluid: Any = scene.equation_of_state
    gamma = MONATOMIC if fluid is None else fluid.first_gamma
    if fluid is not None and fluid.thermal_gamma and (body.specific_internal_energy or body.entropy) is not None:
        gamma = fluid.thermal_gamma  # what is hot holds it up
    shells_at = profile.radius((np.arange(MIDDLES) + 0.5) / MIDDLES)
    spin = float(np.average(_spin(scene, initial, shells_at), weights=shells_at**2))
    if body.spin is body:
        spin = 0.0  # in equilibrium with it: gravity and pressure below are what is left
    if not has_pressure:
        heat, sound = 0.0, 0.0
    elif body.specific_internal_energy is not None:
        energy = float(units.to_code(body.specific_internal_energy, "specific_energy"))
        heat, sound = 3.0 * (gamma - 1.0) * energy / square, math.sqrt(gamma * (gamma - 1.0) * energy)
    elif (constant := _stated_constant(scene, initial, gamma)) is not None:
        sound = math.sqrt(gamma * constant * densest ** (gamma - 1.0))
        heat = 3.0 * constant * np.mean((profile.density(shells_at) * mass / size**3) ** (gamma - 1.0)) / square
    elif initial.tabulated is not None:
        pressure, density = initial.tabulated(shells_at)
        ratio = fraction * pressure / density
        heat, sound = 3.0 * float(ratio.mean()) / square, math.sqrt(gamma * ratio[0])
    else:
        heat = fraction * body.support * (weight - spin) if has_gravity else fraction * weight
        central = float(profile.density(np.array(0.0))) * mass / size**3
        sound = math.sqrt(fraction * _central_sound(profile, mass / size, gamma))
        sound *= (densest / central) ** (0.5 * (gamma - 1.0))
    adds = further_pressure(scene) if has_pressure else None
    if adds is not None:
        dense = profile.density(shells_at) * mass / size**3
        heat += 3.0 * float(np.mean(adds(dense) / dense)) / square
    alone = body.expansion(mass, size), body.homologous
    return Sphere(weight if has_gravity else 0.0, max(heat, 0.0), spin, gamma, densest, np.array(densities), sound,
                  mass / body.particles, size, *alone, *_cooling(scene))  # fmt: skip


def _limits_of_shells(scene: Scene, sphere: Sphere, end: float) -> Limits:
    """The limits of a body that falls together as shells."""
    numerics = scene.numerics
    body = _shells(scene, sphere)
    moments = shells.followed(body, end)
    if not moments:
        return NOT_KNOWN
    support = KERNELS[numerics.kernel].support
    viscosity: Any = scene.effects.get("viscosity")
    every, longest, passing, time = [], [], [], 0.0
    signal, alpha = np.zeros(shells.SHELLS), np.zeros(shells.SHELLS)
    for moment in moments:
        length = _length(scene, sphere, moment.density)
        reach = support * length
        alpha, signal = alpha[-len(length) :], signal[-len(length) :]  # of those that no sink has taken
        if viscosity is not None:
            wanted = np.minimum(viscosity["alpha_max"], (2.0 / support) ** 2 * shells.steepening(moment, reach))
            kept = np.exp(-(moment.time - time) * signal / (viscosity["decay_length"] * length))
            alpha = np.maximum(wanted, wanted + kept * (alpha - wanted))
            if viscosity["switch"] == "none":
                alpha = np.full_like(length, viscosity["alpha_max"])
        signal, time = shells.signals(moment, reach, viscosity, alpha), moment.time
        every.append(_allowed(scene, moment.density, length, signal, np.abs(moment.acceleration)))
        longest.append((numerics.free_fall_factor or math.inf) / math.sqrt(moment.density.max()))
        turning = np.sqrt(1.5 * body.turning[-len(length) :]) / moment.radius
        passing.append(passed(length.min(), np.hypot(moment.speed, turning).max()))
    below = [np.interp(PARTS, *_sorted(limits, body.mass[-len(limits) :])) for limits in every]
    times = np.array([moment.time for moment in moments])
    shortest = np.array([limits.min() for limits in every])
    # Of few particles every one is looked at as a neighbour anyhow.
    crowding = 1.0 if scene.body.particles <= FEW else _crowding(scene, sphere, body.mass, moments)
    return Limits(times, shortest, np.transpose(below), np.array(longest), np.array(passing), crowding)


def _crowding(scene: Scene, sphere: Sphere, mass: np.ndarray, moments: list[shells.Moment]) -> np.ndarray:
    """How many neighbours particles in shells of those masses have at those moments, over how many at first, (K,)."""
    kernel, eta = KERNELS[scene.numerics.kernel], smoothing(scene)[0]
    chosen = np.unique(np.linspace(0, len(moments) - 1, CROWDED).astype(int))
    means = []
    for moment in (moments[number] for number in chosen):
        own = mass[-len(moment.radius) :]
        found = neighbours(own, moment.middle, sphere.particle_mass, kernel, eta)
        means.append(np.average(found, weights=own))
    return np.interp(np.arange(len(moments)), chosen, np.array(means) / means[0])


def _limits_of_planet(scene: Scene, end: float, stirred: bool) -> Limits:
    """The limits of a planet in balance, or that another one meets and stirs; up to no time where it finds none."""
    body: Any = scene.body
    found = _planet(scene) if {"gravity", "pressure"} <= set(scene.effects) else None
    if found is None or body.particles is None:
        return NOT_KNOWN
    viscosity: Any = scene.effects.get("viscosity")
    alpha = 0.0 if viscosity is None or not stirred else STIRRED * viscosity["alpha_max"]
    length = smoothing(scene)[0] * (found.mass.sum() / body.particles / found.density) ** (1.0 / 3.0)
    limits = _allowed(scene, found.density, length, (1.0 + alpha) * found.sound, 0.0)
    limits = found.agreed(limits, KERNELS[scene.numerics.kernel].support * length)
    shortest, *below = np.interp([0.0, *PARTS], *_sorted(limits, found.mass))
    longest = (scene.numerics.free_fall_factor or math.inf) / math.sqrt(found.density.max())
    known = np.repeat(np.array(below)[:, None], 2, axis=1)
    return Limits(np.array([0.0, end]), np.full(2, shortest), known, np.full(2, longest))


def _sorted(limits: np.ndarray, mass: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Shares of the mass that has no longer limit, (K,), and those limits, which rise."""
    order = np.argsort(limits)
    return np.cumsum(mass[order]) / mass.sum(), limits[order]


def _shells(scene: Scene, sphere: Sphere) -> shells.Shells:
    units, initial = code_units(scene), _initial(scene)
    assert initial is not None
    body: Any = scene.body
    fluid: Any = scene.equation_of_state
    total = sphere.particle_mass * body.particles
    # The innermost is as much as a particle at the centre sees: 1/W(0) of the density.
    seen = smoothing(scene)[0] ** 3 / KERNELS[scene.numerics.kernel].w(np, 0.0) / body.particles
    steep = max(1.0, math.log(seen) / math.log(1.0 / shells.SHELLS))
    within = np.linspace(0.0, 1.0, shells.SHELLS + 1)[1:] ** min(steep, 3.0)
    places = initial.profile.radius(within)
    radius = sphere.size * places
    mass = total * np.diff(within, prepend=0.0)
    density = mass / (4.0 / 3.0 * math.pi * np.diff(radius**3, prepend=0.0))
    constant = _stated_constant(scene, initial, sphere.gamma)
    if constant is None and getattr(fluid, "constant", None) is not None:  # the one that the body's centre has
        constant = sphere.sound**2 / (sphere.gamma * sphere.densest ** (sphere.gamma - 1.0))
    if body.specific_internal_energy is not None:
        energy = float(units.to_code(body.specific_internal_energy, "specific_energy"))
        pressure = (sphere.gamma - 1.0) * energy * density
    elif constant is not None:
        pressure = constant * density**sphere.gamma
    elif initial.tabulated is not None:
        pressure = (body.pressure_fraction or 1.0) * initial.tabulated(places)[0]
    else:
        pressure = (body.pressure_fraction or 1.0) * body.support * shells.in_balance(mass, radius)
    stiffer = () if fluid is None else fluid.pieces
    pieces = tuple((float(units.to_code(beyond, "density")), exponent) for beyond, exponent in stiffer)
    thermal = MONATOMIC if fluid is None else fluid.thermal_gamma
    sinks, sink = scene.effects.get("sinks"), None
    if sinks is not None:
        sink = float(units.to_code(sinks["density"], "density")), float(units.to_code(sinks["radius"], "length"))
    turning = (0.0 if body.spin is body else _spin(scene, initial, places)) * radius**4
    adds = further_pressure(scene)
    return shells.Shells(mass, radius, pressure, sphere.gamma, pieces, thermal, turning, sink, adds)


def _stated_constant(scene: Scene, initial: Initial, gamma: float) -> float | None:
    """K of P = K rho^gamma in code units, where the matter, the body of one entropy or a star's table states it; None
    elsewhere.
    """
    body: Any = scene.body
    if (sound_speed := getattr(scene.equation_of_state, "sound_speed", None)) is not None:  # of one temperature
        return float(code_units(scene).to_code(sound_speed, "velocity")) ** 2
    stated = getattr(scene.equation_of_state, "constant", None)
    if isinstance(stated, float):
        return float(code_units(scene).to_code(stated, pressure_constant_dimension(gamma)))
    if stated is not None and initial.tabulated is not None:
        pressure, density = initial.tabulated(np.zeros(1))
        return (body.pressure_fraction or 1.0) * float(pressure[0] / density[0] ** gamma)
    return float(body.entropy) if body.entropy is not None and body.isentropic else None


def _spin(scene: Scene, initial: Initial, s: np.ndarray) -> np.ndarray:
    """2/3 omega^2 (K,) at distances (K,) from the centre over the radius."""
    units = code_units(scene)
    body: Any = scene.body
    if initial.shells is not None and body.rotation is None and initial.shells.angular_velocity is not None:
        rate = initial.shells.at(units.to_code(initial.shells.angular_velocity, "angular_velocity"), s)
        return 2.0 / 3.0 * (body.rotation_factor * rate) ** 2
    return np.full_like(s, _uniform_spin(scene))


def _turning(scene: Scene, sphere: Sphere) -> float:
    """The rate at which a body turns at first, as a whole."""
    spin: Any = scene.body.spin
    share = getattr(spin, "t_over_w", None)
    # T is <r^2> omega^2/3 of the mass, and |W| is <r^2> times that of a sphere.
    return math.sqrt(1.5 * _uniform_spin(scene) if share is None else 3.0 * share * sphere.gravity)


def _uniform_spin(scene: Scene) -> float:
    """2/3 omega^2 where the scene gives the rate; 0 where it gives another measure."""
    return 2.0 / 3.0 * float(rotation_amount(scene, code_units(scene), True).get("rate", 0.0)) ** 2


def _cooling(scene: Scene) -> tuple[float, float]:
    """Its time scale at first and how that changes, where heat is lost everywhere alike; none elsewhere."""
    options = scene.effects.get("cooling", {})
    tau = options.get("time_scale")
    if options.get("law") != "time_scale" or tau is None or options["heating_rate"] or options["floor"]:
        return math.inf, 0.0
    return float(code_units(scene).to_code(tau, "time")), options["time_scale_change"] or 0.0


def _central_sound(profile: Profile, unit: float, gamma: float) -> float:
    """The square of the speed of sound at the centre, in equilibrium: gamma P/rho, P being the weight of the rest."""
    nodes = np.linspace(1e-3, 1.0, 2000)
    above = np.trapezoid(profile.density(nodes) * profile.enclosed(nodes) / nodes**2, nodes)
    return gamma * unit * float(above / profile.density(np.array(1e-3)))


def course(sphere: Sphere, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and sizes (K,) from the start to the end, times being dense where the sphere is small."""
    pace = sphere.pace
    times, sizes = [0.0], [1.0]
    time, a, speed = 0.0, 1.0, sphere.speed
    least = SHAKEN if sphere.pressure > 0.0 and not sphere.smooth else SMALLEST
    while time < end and len(times) < MOMENTS:
        dt = min(end - time, max(0.02 * a**1.5 / pace, 1.0 / MOMENTS * end if a > least else 0.0))
        speed += 0.5 * dt * sphere.push(a, sphere.entropy(time))
        a += dt * speed
        if a <= least:  # shocks have stopped it, or nothing is known of what it has become
            times += [time + dt, end]
            sizes += [least, least]
            break
        if a >= SCATTERED:  # nothing acts any more
            times += [time + dt, end]
            sizes += [min(a, FARTHEST), min(a + speed * (end - time - dt), FARTHEST)]
            break
        speed += 0.5 * dt * sphere.push(a, sphere.entropy(time))
        time += dt
        times.append(time)
        sizes.append(a)
    if times[-1] < end:
        times.append(end)
        sizes.append(sizes[-1])
    follows = np.diff(times, prepend=-1.0) > 0.0  # what is over at once leaves times that are the same number
    return np.array(times)[follows], np.array(sizes)[follows]


def contraction(sphere: Sphere, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and sizes (K,) of a body that stays in equilibrium while it loses heat, dense where that is fast."""
    if math.isinf(sphere.cooling_time) or sphere.gamma <= STABLE:
        return np.array([0.0, end]), np.ones(2)
    times = np.linspace(0.0, end, MOMENTS // 10)
    if sphere.cooling_change * end < -NOTICED * sphere.cooling_time:
        last = max(1.0 + sphere.cooling_change * end / sphere.cooling_time, LEAST_LEFT)
        times = (np.geomspace(1.0, last, MOMENTS // 10) - 1.0) * sphere.cooling_time / sphere.cooling_change
    small, large = np.full_like(times, SMALLEST**2), np.ones_like(times)
    for _ in range(HALVINGS):
        middle = np.sqrt(small * large)
        falls = sphere.push(middle, sphere.entropy(times)) < 0.0
        small, large = np.where(falls, small, middle), np.where(falls, middle, large)
    return times, large


def _limit_by_options(scene: Scene, times: np.ndarray) -> np.ndarray:
    """What effects allow at those times, (K,), whose limit follows from their options alone."""
    units, limits = code_units(scene), np.full_like(times, np.inf)
    for kind, options in scene.effects.items():
        if (pace := scene.entries[kind].pace) is not None:
            allowed, last = pace(options)
            until = np.inf if last is None else float(units.to_code(last, "time"))
            limit = scene.numerics.courant * float(units.to_code(allowed, "time"))
            limits = np.minimum(limits, np.where(times < until, limit, np.inf))
    return limits


def _steps_at(scene: Scene, sphere: Sphere, times: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The shortest limit at those times, when it has those sizes, (K,)."""
    density = sphere.densest / sizes**3
    length = _length(scene, sphere, density)
    signal = sphere.sound * np.sqrt(sphere.entropy(times)) * sizes ** (-1.5 * (sphere.gamma - 1.0))
    if sphere.sound > 0.0:
        rates = np.abs(np.gradient(sizes, times)) / sizes
        signal = signal + rates * KERNELS[scene.numerics.kernel].support * length
    pull = np.maximum(sphere.gravity, sphere.pressure) * sphere.size / sizes**2
    return _allowed(scene, density, length, signal, pull)


def _length(scene: Scene, sphere: Sphere, density: np.ndarray) -> np.ndarray:
    """Smoothing lengths (K,) at densities."""
    return smoothing(scene)[0] * (sphere.particle_mass / density) ** (1.0 / 3.0)


def _allowed(
    scene: Scene, density: np.ndarray, length: np.ndarray, signal: np.ndarray, pull: np.ndarray | float
) -> np.ndarray:
    """The shortest limit of matter of that density, smoothing length, fastest signal and acceleration, (K,)."""
    numerics = scene.numerics
    limits = [
        numerics.courant * length / np.maximum(signal, STILL),
        numerics.acceleration_factor * np.sqrt(length / np.maximum(pull, shells.LEAST)),
    ]
    if "gravity" in scene.effects:
        limits.append(numerics.courant * FREE_FALL_PART * np.sqrt(3.0 * math.pi / (32.0 * density)))
    if "shear_viscosity" in scene.effects:
        stated = scene.effects["shear_viscosity"]["kinematic_viscosity"]
        viscosity = float(code_units(scene).to_code(stated, "viscosity"))
        limits.append(numerics.courant * DIFFUSION_PART * length**2 / max(viscosity, shells.LEAST))
    return np.minimum.reduce(limits)
