"""Brings placed particles to the equilibrium of their own discrete equations: a descent in energy, no evolution.

At fixed entropy functions the particle fluid has an energy E(x), and equilibrium, also in rotation, is where

    a_pressure + a_gravity + a_centrifugal = -(1/m) dE/dx = 0.

It is found by damped motion with inertia. The inertia builds up as in accelerated gradient descent with restarts
(O'Donoghue & Candes 2015, Found. Comput. Math. 15, 715), to a limit that damps the slowest oscillation of the body
about critically at ten thousand particles, and the motion is quenched whenever it points uphill. Every particle has a
time step of its own, so that a dense centre does not hold up the envelope. The centre of mass is held, for steps that
differ push on it.

A homologous collapse (bodies.homologous_core), x'' = -k x at first, is an equilibrium of f a_pressure + a_gravity +
k x. Its gas of exponent 4/3 has no size of its own: the descent keeps the rms radius, and at every step takes the
factor f of all pressures at which the virial sum m x . a of that vanishes. Particles that are let go with entropies f A
then collapse as the exact body does, as long as their noise allows.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace

import numpy as np

from astroinertia.bodies.rotation_laws import Law
from astroinertia.errors import NumericalError
from astroinertia.models.sph.evaluate import evaluated, potential_energies
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.sorting import STEPS_BETWEEN_SORTS, rearranged, stale
from astroinertia.models.sph.state import Problem, State
from astroinertia.sph.rotation import law_of, rotation_velocity
from astroinertia.storage import cache

APART = 10.0  # times its size at the start: a body that is larger does not come back
FAR = 3.0
_COURANT = 0.8  # of h/(c + sqrt(h |a|)); twice as much is unstable
_COURANT_OF_FOURTH_ORDER = 0.55  # with densities of fourth order, which are stiffer: 0.65 is stable, 0.8 is not
_MOST_INERTIA = 0.9  # share of a move that is kept for the next
_LARGEST_MOVE = 0.15  # of a smoothing length a step
_ALLOWED_TO_ROTATION = 12.0  # T/|W| of density error besides: the target is that of the body at rest
_VERSION = 5  # part of the cache key: raise it when the outcome changes


@dataclass(frozen=True)
class Rotation:
    """Rotation to be in equilibrium with: one measure, its value, and the law with its scale (as in sph.rotation).

    Beyond `edge` from the axis the specific angular momentum is constant: a particle that pressure throws out of a fast
    star comes back, while with the law itself centrifugal force would carry it away for ever.
    """

    measure: str
    value: float
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    scale: float | None = None
    law: str | Law = "rigid"
    edge: float | None = None


@dataclass(frozen=True)
class Report:
    """How far from equilibrium a body is, and what it took.

    residual: rms net acceleration over rms gravity; density_error: rms relative difference from the target density over
    the inner half of the mass (NaN without a target); centre_shift: of the centre of mass, over the rms radius; virial:
    |2T + W + 3 sum m P/rho + k sum m r^2| / |W|; rate: the rotation rate on the axis; growth: of the rms radius since
    the start; pressure: the factor f of the entropies of a collapse; gone: share of the mass that is farther from the
    centre than FAR times as far as any was at the start, once the body has flown apart.
    """

    steps: int
    residual: float
    density_error: float
    centre_shift: float
    virial: float
    rate: float
    growth: float = 1.0
    pressure: float = 1.0
    gone: float = 0.0


@dataclass(frozen=True)
class Tolerances:
    """What a relaxed body must meet; every one of them is checked at the end, and the residual while it goes.

    Without a density_error of its own it is 0.25 (1000/N)^0.4: what smoothing and the surface do to polytropes up to
    n = 4, measured, and two thirds as much again.
    """

    residual: float = 2e-3
    density_error: float | None = None
    centre_shift: float = 1e-9
    virial: float = 0.02


@dataclass(frozen=True)
class Relaxed:
    """Positions (N, 3) and velocities (N, 3) at equilibrium, in the order given, and the report on them."""

    position: np.ndarray
    velocity: np.ndarray
    report: Report
    cached: bool


Listener = Callable[[Report], None]


def relax(
    problem: Problem,
    mass: np.ndarray,
    position: np.ndarray,
    entropy: np.ndarray,
    target_density: Callable[[np.ndarray], np.ndarray] | None = None,
    rotation: Rotation | None = None,
    tolerances: Tolerances = Tolerances(),
    max_steps: int = 2000,
    listener: Listener | None = None,
    use_cache: bool = True,
    material: np.ndarray | None = None,
    infall: float | None = None,
    memory: Mapping[str, np.ndarray] | None = None,
) -> Relaxed:
    """Return the body at equilibrium under the problem's pressure and gravity; NumericalError where there is none.

    mass (N,), position (N, 3), entropy (N,), in code units; target_density(m) is the density on the shell that encloses
    the mass m; material (N,), where the equation of state has several; infall: the k of a homologous collapse, for
    which the report has the factor of the entropies; memory: what effects know of particles beforehand, (N,) each.
    Entropies stay with their particles. The outcome is kept in the user's cache.
    """
    key = cache.content_key(
        mass=mass, position=position, entropy=entropy, rotation=None if rotation is None else asdict(rotation),
        equation=repr(problem.equation_of_state), kernel=problem.kernel, eta=float(problem.eta),
        smoothing=problem.smoothing_tolerance, engine=[problem.engine.name, problem.engine.precision],
        effects=[repr(effect) for effect in problem.effects], residual=tolerances.residual, version=_VERSION,
        **({} if material is None else {"material": material}), **({} if infall is None else {"infall": infall}),
        **(memory or {}),
    )  # fmt: skip
    stored = cache.load("relaxed", key) if use_cache else None
    if stored is not None and stored["position"].shape == position.shape:
        steps, *figures = (float(value) for value in stored["report"])
        report = Report(int(steps), *figures)
        relaxed = Relaxed(stored["position"], stored["velocity"], report, cached=True)
    else:
        still = np.zeros_like(position)
        start = initial_state(problem, mass, position, still, entropy, material=material, memory=memory)
        wanted = None if target_density is None else _last_kept(target_density)
        relaxed = _descend(problem, *start, wanted, rotation, tolerances, max_steps, listener, infall)
    complaint = verdict(relaxed.report, tolerances, len(mass), _rotational_share(mass, relaxed))
    if complaint:
        raise NumericalError(f"the body was not brought to equilibrium: {complaint}")
    if use_cache and not relaxed.cached:
        arrays = {"position": relaxed.position, "velocity": relaxed.velocity}
        cache.save("relaxed", key, arrays | {"report": np.array(list(asdict(relaxed.report).values()), dtype=float)})
    return relaxed


def _last_kept(function: Callable[[np.ndarray], np.ndarray]) -> Callable[[np.ndarray], np.ndarray]:
    """The function, which finds what it was asked for last: particles of one mass ask for the same at every step."""
    asked, found = np.empty(0), np.empty(0)

    def kept(argument: np.ndarray) -> np.ndarray:
        nonlocal asked, found
        if not np.array_equal(asked, argument):
            asked, found = argument, function(argument)
        return found

    return kept


def verdict(report: Report, tolerances: Tolerances, count: int, rotational_share: float = 0.0) -> str:
    """Return what is wrong with a relaxed body of `count` particles, in a few words, or "" if nothing is."""
    if not report.growth < APART:
        gone = f"{100 * report.gone:.0f} % of its mass went farther than {FAR:g} times its size at the start"
        if rotational_share > 0.0:
            return (
                f"it flies apart: {gone}; it turns too fast for gravity to hold it, and slower rotation would be right"
            )
        return f"it flies apart: {gone}; gravity does not hold it against its pressure, and less would be right"
    density = 0.25 * (1000 / count) ** 0.4 if tolerances.density_error is None else tolerances.density_error
    density += _ALLOWED_TO_ROTATION * rotational_share
    limits = {
        "residual": (report.residual, tolerances.residual, "the net acceleration is still {:.2g} of gravity"),
        "virial": (report.virial, tolerances.virial, "the virial theorem is off by {:.2g}"),
        "density": (report.density_error, density, "its density is off by {:.0%} from the body asked for"),
        "centre": (report.centre_shift, tolerances.centre_shift, "its centre of mass moved by {:.2g} of its size"),
    }
    wrong = [text.format(value) for value, limit, text in limits.values() if value > limit or math.isinf(value)]
    if math.isnan(report.residual):
        wrong.append("its accelerations are not finite")
    return " and ".join(wrong) + (f" after {report.steps} steps" if wrong else "")


def _descend(
    problem, state, arrangement, target_density, rotation, tolerances, max_steps, listener, infall
) -> Relaxed:  # fmt: skip
    order = np.asarray(state.identity)
    centre = _centre(state)
    size, reach = _size(state), float(np.linalg.norm(np.asarray(state.position) - centre, axis=1).max())
    move, since = np.zeros_like(state.position), 0
    report, still = None, np.float64(0.0)
    for step in range(max_steps + 1):
        forces = _forces(problem, state, centre, rotation, infall)
        moved = np.linalg.norm(_centre(state) - centre) / size
        report = _report(step, state, forces, target_density, float(moved), _size(state) / size, infall or 0.0)
        if listener is not None:
            listener(report)
        if report.residual < tolerances.residual or not math.isfinite(report.residual) or step == max_steps:
            break
        if not report.growth < APART:
            break
        if np.einsum("i,ij,ij->", state.mass, move, forces.net) < 0:
            move, since = np.zeros_like(move), 0
        since += 1
        move = _next_move(state, forces, move, min(since / (since + 3), _MOST_INERTIA))
        state = replace(state, position=state.position + move)
        if infall is not None:
            state = replace(state, position=centre + (state.position - centre) * (size / _size(state)))
        if step % STEPS_BETWEEN_SORTS == 0 or stale(problem, arrangement, state, still):
            before = np.asarray(state.identity)
            state, arrangement = rearranged(problem, state, still)
            order = np.asarray(state.identity)
            back = np.empty_like(before)
            back[before] = np.arange(len(before))
            move = move[back[order]]
        state = evaluated(problem, arrangement, state, still)
    assert report is not None
    if not report.growth < APART:
        gone = np.linalg.norm(np.asarray(state.position) - centre, axis=1) > FAR * reach
        report = replace(report, gone=float(state.mass[gone].sum() / state.mass.sum()))
    positions, velocities = np.empty_like(state.position), np.empty_like(state.position)
    positions[order] = state.position
    velocities[order] = forces.velocity
    return Relaxed(positions, velocities, report, cached=False)


@dataclass(frozen=True)
class _Forces:
    net: np.ndarray
    gravity: np.ndarray
    velocity: np.ndarray
    rate: float
    pressure: float


def _centre(state: State) -> np.ndarray:
    return np.asarray(state.mass @ state.position / state.mass.sum())


def _size(state: State) -> float:
    """The rms distance from the centre of mass."""
    squared = ((np.asarray(state.position) - _centre(state)) ** 2).sum(axis=1)
    return math.sqrt(state.mass @ squared / state.mass.sum())


def _forces(
    problem: Problem, state: State, centre: np.ndarray, rotation: Rotation | None, infall: float | None
) -> _Forces:
    parts = dict(zip(problem.effect_names, state.rates.acceleration, strict=True))
    gravity = np.asarray(parts.get("gravity", np.zeros_like(state.position)))
    net = np.zeros_like(gravity)
    for part in state.rates.acceleration:
        net = net if part is None else net + np.asarray(part)
    factor = 1.0
    if infall is not None:
        x, push = np.asarray(state.position) - centre, np.asarray(parts["pressure"])
        others = net - push + infall * x
        factor = -np.einsum("i,ij,ij->", state.mass, x, others) / np.einsum("i,ij,ij->", state.mass, x, push)
        net = factor * push + others
    velocity, rate = np.zeros_like(net), 0.0
    if rotation is not None:
        velocity, rate, centrifugal = _rotation(problem, state, centre, rotation)
        net = net + centrifugal
    return _Forces(net, gravity, velocity, rate, float(factor))


def _rotation(problem: Problem, state: State, centre: np.ndarray, rotation: Rotation):
    x, axis = state.position - centre, np.asarray(rotation.axis) / np.linalg.norm(rotation.axis)
    energy = potential_energies(problem, state).get("gravity")
    velocity = rotation_velocity(
        state.mass,
        x,
        rotation.law,
        rotation.axis,
        rotation.scale,
        energy,
        rotation.edge,
        **{rotation.measure: rotation.value},
    )
    outwards = x - (x @ axis)[:, None] * axis
    squared = (outwards**2).sum(axis=1)
    rates = np.sqrt((velocity**2).sum(axis=1) / np.maximum(squared, 1e-300))
    on_axis = rates / law_of(rotation.law, rotation.scale).rate(np.sqrt(squared))  # of the half within the edge
    return velocity, float(np.median(on_axis)), rates[:, None] ** 2 * outwards


def _next_move(state: State, forces: _Forces, move: np.ndarray, inertia: float) -> np.ndarray:
    fluid = state.rates.fluid
    h = np.asarray(fluid.smoothing_length)
    speed = np.asarray(fluid.sound_speed) + np.sqrt(h * np.linalg.norm(forces.gravity, axis=1))
    step = (_COURANT if fluid.contrast is None else _COURANT_OF_FOURTH_ORDER) * h / speed
    move = inertia * move + (step**2)[:, None] * forces.net
    length = np.linalg.norm(move, axis=1)
    move = move * np.minimum(1.0, _LARGEST_MOVE * h / np.maximum(length, 1e-300))[:, None]
    return move - state.mass @ move / state.mass.sum()


def _report(step, state, forces, target_density, moved, growth, infall) -> Report:
    mass, fluid = np.asarray(state.mass), state.rates.fluid
    rms = [math.sqrt(mass @ (a**2).sum(axis=1)) for a in (forces.net, forces.gravity)]
    error = math.nan
    if target_density is not None:
        x = np.asarray(state.position) - _centre(state)
        outwards = np.argsort((x**2).sum(axis=1), kind="stable")
        enclosed = np.cumsum(mass[outwards]) - 0.5 * mass[outwards]
        inner = enclosed < 0.5 * mass.sum()
        chosen = outwards[inner]
        ratio = np.asarray(fluid.density)[chosen] / target_density(enclosed[inner])
        error = math.sqrt(mass[chosen] @ (ratio - 1) ** 2 / mass[chosen].sum())
    kinetic = 0.5 * mass @ (forces.velocity**2).sum(axis=1)
    weight = mass @ np.einsum("ij,ij->i", forces.gravity, np.asarray(state.position) - _centre(state))
    pressure = 3 * forces.pressure * mass @ (np.asarray(fluid.pressure) / np.asarray(fluid.density))
    left = infall * mass.sum() * _size(state) ** 2
    return Report(
        steps=step,
        residual=rms[0] / rms[1],
        density_error=error,
        centre_shift=moved,
        virial=abs(2 * kinetic + weight + pressure + left) / abs(weight),
        rate=forces.rate,
        growth=growth,
        pressure=forces.pressure,
    )


def _rotational_share(mass: np.ndarray, relaxed: Relaxed) -> float:
    """T over (3/5) M^2/R with R from the rms radius of a uniform sphere: a scale of T/|W|, not its value."""
    x = relaxed.position - mass @ relaxed.position / mass.sum()
    radius = math.sqrt(5 / 3 * mass @ (x**2).sum(axis=1) / mass.sum())
    return float(0.5 * mass @ (relaxed.velocity**2).sum(axis=1) / (0.6 * mass.sum() ** 2 / radius))
