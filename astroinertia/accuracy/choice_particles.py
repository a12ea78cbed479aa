"""The search for the cheapest particles that have a wanted accuracy.

A ladder of pilots, each with twice the particles of the one before, tells how the error falls with their number; it is
climbed until what is wanted lies no more than a factor of four beyond it, so that pilots cost a part of the run. Longer
time steps and coarser gravity are tried at a low rung, and taken as long as they err little beside the resolution.
Tests: tests/unit/accuracy/test_choice.py, tests/benchmarks/delivered.py.
"""

import math
from collections.abc import Callable

from astroinertia.accuracy import knobs
from astroinertia.accuracy.estimates import Estimate
from astroinertia.accuracy.knobs import Knob
from astroinertia.accuracy.measuring import Measured
from astroinertia.accuracy.pilots import OutOfReach, Pilots, Settings
from astroinertia.accuracy.words import duration
from astroinertia.costs import machine
from astroinertia.costs.prediction import predict

FEWEST = 250  # particles of the first pilot: four times the neighbours of one
GROWTH = 2.0  # of their number from pilot to pilot
BEYOND = 4.0  # times the particles of the last pilot that the estimate is trusted to reach
ORDERS = (1.2, 2.4)  # in h, that are believed of a ladder; where it tells none, theory's counts
TRUST = 0.3  # standard deviation of theory's order from scene to scene (tests/benchmarks/results/tradeoff.md)
OF_RESOLUTION, OF_STEPS, OF_GRAVITY = 0.7, 0.15, 0.15  # shares of the wanted accuracy
STEP_PILOT = 2  # the rung of the ladder on which time steps and gravity are tried
MOST = 10_000_000  # particles
UNSURE = 0.5  # of the error of the finest pilot, that of what the ladder tends to
COST = 4.0 / 3.0  # seconds go as this power of the number of particles: N passes over N^(1/3) times as many steps
LONGEST, SHORTEST = 4.0, 0.05  # factors of the time step
REFUSING = 0.1  # of the time allowed, that pilots may take before a cost is reported

Other = Callable[[Measured, float], Settings | None]


def search(pilots: Pilots, accuracy: float, seconds: float, other: Other) -> Settings | OutOfReach:
    """The cheapest number of particles, factor of the time steps and error of gravity for an accuracy.

    seconds: of wall time that the run may take. other: asked after every pilot with what the ladder tends to and how
    sure that is; where it finds something (a cheaper model that agrees), that is taken.
    """
    by_name = {knob.name: knob for knob in knobs.knobs(pilots.scene)}
    main, ladder = by_name["particles"], {}
    _announce(pilots, main)
    count, estimate = FEWEST, None
    while True:
        pilot = pilots.run(f"{count} particles", main.overrides(float(count)))
        if pilot.failure:
            if count >= FEWEST * GROWTH**STEP_PILOT:
                return OutOfReach(f"a pilot with {count} particles failed: {pilot.failure}")
        else:
            ladder[count] = pilot
        if len(ladder) >= 2:
            steps = {n ** (-1 / 3): run for n, run in ladder.items()}
            estimate = pilots.estimate(steps, main.order or 2.0, ORDERS, TRUST)
            cheaper = other(pilots.limit(steps, estimate.order), UNSURE * estimate.error)
            if cheaper is not None:
                return cheaper
        if estimate is not None and len(ladder) >= 3:
            wanted = _particles(estimate, max(ladder), OF_RESOLUTION * accuracy)
            cost = _cost(ladder, wanted)
            if wanted <= BEYOND * count and cost <= seconds:
                return _settled(pilots, by_name, ladder, estimate, wanted, accuracy)
            if cost > seconds and _cost(ladder, GROWTH * count) > REFUSING * seconds:
                return _refusal(ladder, estimate, wanted, cost, seconds)
        count = int(GROWTH * count)


def _announce(pilots: Pilots, main: Knob) -> None:
    """Say what the pilots will take that every search runs: three numbers of particles, and longer steps at one."""
    counts = [FEWEST * GROWTH**rung for rung in (0, 1, 2, STEP_PILOT - 1)]
    predictions = [
        predict(knobs.with_overrides(pilots.scene, main.overrides(count)), machine.current()) for count in counts
    ]
    times = [prediction.wall_time for prediction in predictions if prediction is not None]
    if len(times) == len(counts):
        pilots.listener(f"{len(counts)} pilots or more before the run, of about {duration(sum(times))} in all")


def _particles(estimate: Estimate, finest: int, error: float) -> float:
    """How many particles have an error, two digits, by what the finest pilot has."""
    wanted = min(finest * estimate.ratio_for(error) ** -3, MOST)
    if not wanted > FEWEST:
        return float(FEWEST)
    unit = 10.0 ** (math.floor(math.log10(wanted)) - 1)
    return math.ceil(wanted / unit) * unit


def _cost(ladder: dict[int, Measured], count: float) -> float:
    finest = max(ladder)
    return ladder[finest].wall_time * (count / finest) ** COST


def _settled(
    pilots: Pilots, by_name: dict[str, Knob], ladder: dict[int, Measured], estimate: Estimate, wanted: float,
    accuracy: float,
) -> Settings:  # fmt: skip
    finest = max(ladder)
    main = by_name["particles"]
    errors = {"resolution": estimate.at((wanted / finest) ** (-1 / 3))}
    reasons = [
        f"{wanted:.0f} particles: pilots with {', '.join(map(str, sorted(ladder)))} tell an error of "
        f"{estimate.error:.1e} at {finest}, which falls as h^{estimate.order:.2g}"
    ]
    overrides, chosen, seconds = main.overrides(wanted), {"particles": wanted}, _cost(ladder, wanted)
    tried = sorted(ladder)[min(STEP_PILOT, len(ladder)) - 1]
    plain = ladder[tried]
    factor, error, why = _timestep(pilots, by_name["timestep_factor"], tried, plain, OF_STEPS * accuracy)
    errors["time steps"] = error
    reasons.append(why)
    if factor != 1.0:
        overrides += by_name["timestep_factor"].overrides(factor)
        chosen["timestep_factor"], seconds = factor, seconds / factor
    if (gravity := _gravity_of(pilots, wanted)) is not None:
        value, error, why = _gravity(pilots, gravity, tried, plain, OF_GRAVITY * accuracy)
        errors["gravity"] = error
        reasons.append(why)
        if value != gravity.default:
            overrides, chosen["force_error"] = overrides + gravity.overrides(value), value
    return Settings(overrides, chosen, errors, seconds, tuple(reasons))


def _timestep(pilots: Pilots, knob: Knob, count: int, plain: Measured, share: float) -> tuple[float, float, str]:
    """The longest time steps whose error, by second order, stays below a share; that error; and why."""
    main = knobs.knobs(pilots.scene)[0]
    least, most = 1.0, math.inf
    for longer in sorted((multiple for multiple in map(float, knob.values) if 1.0 < multiple <= LONGEST), reverse=True):
        label = f"{count} particles, time steps {longer:g} times as long"
        apart = pilots.apart(pilots.run(label, (*main.overrides(float(count)), *knob.overrides(longer))), plain)
        if math.isfinite(apart):
            least, most = apart / (longer**2 - 1.0), longer
            break
    if not math.isfinite(most):
        return 1.0, 0.0, "time steps as they are: none longer can be tried"
    wanted = math.sqrt(share / least) if least > 0.0 else most
    factor = float(f"{min(max(wanted, SHORTEST), most):.2g}")
    why = (
        f"time steps {factor:g} times as long: {most:g} times as long they err {most**2 * least:.1e} "
        f"with {count} particles"
    )
    return factor, least * factor**2, why


def _gravity_of(pilots: Pilots, count: float) -> Knob | None:
    scene = knobs.with_overrides(pilots.scene, knobs.knobs(pilots.scene)[0].overrides(count))
    return next((knob for knob in knobs.knobs(scene) if knob.name == "force_error"), None)


def _gravity(pilots: Pilots, knob: Knob, count: int, plain: Measured, share: float) -> tuple[float, float, str]:
    """The coarsest gravity that is no coarser than a share, and whose error against the plain pilot is below it."""
    main = knobs.knobs(pilots.scene)[0]
    value, error = knob.default, math.nan
    for value in knob.values:  # from coarse to fine
        if float(value) > share and value != knob.values[-1]:
            continue
        label = f"{count} particles, gravity to {value:g}"
        error = pilots.apart(pilots.run(label, (*main.overrides(float(count)), *knob.overrides(value))), plain)
        if error <= share:
            break
    return float(value), error, f"gravity to {value:g} changes the pilot with {count} particles by {error:.1e}"


def _refusal(ladder: dict[int, Measured], estimate: Estimate, wanted: float, cost: float, seconds: float) -> OutOfReach:
    finest = max(ladder)
    most = finest * (seconds / ladder[finest].wall_time) ** (1.0 / COST)
    best = estimate.at((most / finest) ** (-1 / 3)) / OF_RESOLUTION
    return OutOfReach(
        f"it takes {wanted:.2g} particles and {duration(cost)}; in {duration(seconds)} some {most:.2g} "
        f"particles have {best:.1e}"
    )
