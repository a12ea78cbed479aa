"""The search for the cheapest particles that have a wanted accuracy, by pilots that cost no more than the run.

Costs are evaluations of a particle, and processor seconds of the machine that the package's figures are of
(costs.reference): of few particles an evaluation takes several times as long, and bodies have to settle.

A ladder of pilots, each with twice the particles of the one before and time steps twice as long as the scene's, tells
how the error falls with their number. It is climbed until what is wanted lies no more than a factor of four beyond it,
or until one more pilot would cost more than the run has; then the rest is extrapolated. Shorter time steps and coarser
gravity are tried at a low rung, and taken by what they err beside the resolution.
Tests: tests/unit/accuracy/test_choice.py, tests/benchmarks/delivered.py.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

from astroinertia.accuracy import knobs, measuring
from astroinertia.accuracy.estimates import Estimate, worst
from astroinertia.accuracy.knobs import Knob, Setting
from astroinertia.accuracy.measuring import Measured
from astroinertia.accuracy.pilots import OutOfReach, Pilots, Settings
from astroinertia.costs import reference
from astroinertia.costs.evaluations import Counts
from astroinertia.process.words import duration
from astroinertia.scene.plan import smoothing
from astroinertia.scene.schema import Scene

FEWEST = 1.5  # particles of the first pilot, over the neighbours of one
LEAST = 250  # particles of a run
GROWTH = 2.0  # of their number from pilot to pilot
LAST = 4  # pilots that tell the error: coarser ones say nothing of the order that counts
FAILING = 4.0  # times the fewest particles, from which on a pilot that fails is the end
BEYOND = 4.0  # times the particles of the last pilot that the estimate is trusted to reach
ORDERS = (1.2, 2.4)  # in h, that are believed of a ladder; where it tells none, theory's counts
TRUST = 0.3  # standard deviation of theory's order from scene to scene (tests/benchmarks/results/tradeoff.md)
OF_RESOLUTION, OF_STEPS, OF_GRAVITY = 0.7, 0.15, 0.15  # shares of the wanted accuracy
TRIED = 600  # particles, the most on which time steps and gravity are tried
MOST = 10_000_000  # particles of a run: more are not chosen
UNSURE = 0.5  # of the error of the finest pilot, that of what the ladder tends to
COST = 4.0 / 3.0  # seconds go as this power of the number of particles: N passes over N^(1/3) times as many steps
LONGER, SHORTEST = 2.0, 0.05  # factors of the time step
SURE = 0.8  # of the processor time of a run, what its pilots may take: both are known to a fifth
FINER = 1.05  # from one number of particles to the next, until the run costs what its pilots did
REFUSING = 0.1  # of the time allowed, that one more pilot may take before a cost is reported
PATIENCE = 30.0  # s, that it may take at most for that, whatever the run may take: those before it take as much in all

Other = Callable[[Measured, float, Callable[[float], bool]], Settings | None]


@dataclass
class Ladder:
    """Pilots by their number of particles, all with the same factor of the time step.

    counts: how their steps follow from each other; settled: the numbers of particles whose bodies are placed already.
    """

    pilots: Pilots
    main: Knob
    timestep: Knob
    factor: float
    counts: Counts
    runs: dict[int, Measured] = field(default_factory=dict)
    settled: set[int] = field(default_factory=set)

    @property
    def finest(self) -> int:
        """The most particles so far."""
        return max(self.runs)

    def step(self, count: float) -> float:
        """The distance of so many particles, of the kind that numbers fall with."""
        assert self.main.step is not None
        return self.main.step(count)

    def run(self, count: int, factor: float, more: tuple[str, ...] = (), what: str = "") -> Measured:
        """A pilot with so many particles, and other settings if need be."""
        steps = "" if factor == 1.0 else f", time steps {factor:g} times as long"
        settings = (*self.main.overrides(float(count)), *self.timestep.overrides(factor), *more)
        work, earlier = self.work(count, factor), settings in self.pilots.done
        pilot = self.pilots.run(f"{count} particles{steps}{what}", settings, work)
        if not earlier:
            self.pilots.processor += self.processor(count, factor, pilot.evaluations or work, more)
            self.settled.add(count)
        return pilot

    def work(self, count: float, factor: float) -> float:
        """Evaluations of particles that so many will take."""
        if not self.runs:
            return reference.estimated(self.quiet(int(count), factor)).evaluations * count
        last = self.runs[self.finest]
        return last.evaluations * (count / self.finest) ** self.power * self.factor / factor

    def of_run(self, count: float, factor: float) -> float:
        """The same of the run, which meets the times of its records."""
        return max(self.work(count, factor), count * self.pilots.met)

    @property
    def power(self) -> float:
        """Of the number of particles, that evaluations go as: by the two finest pilots."""
        if len(self.runs) < 2:
            return COST
        fine, coarse = sorted(self.runs, reverse=True)[:2]
        ratio = self.runs[fine].evaluations / self.runs[coarse].evaluations
        return min(max(math.log(ratio) / math.log(fine / coarse), 1.0), COST)

    def seconds(self, count: float) -> float:
        """Of wall time, that preparing so many and their steps will take."""
        last = self.runs[self.finest]
        return (last.preparation_time + last.step_time) * (count / self.finest) ** COST

    def processor(self, count: int, factor: float, evaluations: float, more: tuple[str, ...] = ()) -> float:
        """Processor seconds of a pilot, of the reference machine."""
        scene = self.quiet(count, factor, more)
        return reference.of_particles(scene, evaluations, self.counts, placed=count in self.settled)

    def processor_of_run(self, count: float, factor: float) -> float:
        """The same of the run in a process of its own."""
        settings = (*self.main.overrides(count), *self.timestep.overrides(factor))
        scene = knobs.overridden(self.pilots.scene, settings)
        return reference.of_particles(scene, self.of_run(count, factor), self.counts, alone=True)

    def affords(self, more: Sequence[tuple[int, float]], count: float, factor: float, processor: float = 0.0) -> bool:
        """Whether pilots cost no more than a run of so many particles.

        more: further pilots, their numbers of particles and factors; processor: seconds of what else is run.
        """
        works = [self.work(*pilot) for pilot in more]
        if self.pilots.work + sum(works) > self.of_run(count, factor):
            return False
        if count > MOST:
            return True
        processor += sum(self.processor(*pilot, work) for pilot, work in zip(more, works, strict=True))
        return self.pilots.processor + processor <= SURE * self.processor_of_run(count, factor)

    def quiet(self, count: int, factor: float, more: tuple[str, ...] = ()) -> Scene:
        """The scene of a pilot."""
        settings = (*self.main.overrides(float(count)), *self.timestep.overrides(factor), *more)
        return measuring.scene_of(self.pilots.scene, Setting("pilot", count, settings), self.pilots.observables)


def search(pilots: Pilots, accuracy: float, seconds: float, other: Other) -> Settings | OutOfReach:
    """The cheapest number of particles, factor of the time steps and error of gravity for an accuracy.

    seconds: of wall time that the run may take. other: asked after every pilot with what the ladder tends to, how
    unsure that is and which processor seconds the particles' run affords; where it finds something (a cheaper model
    that agrees), that is taken in place of the particles' run, which pilots cost no more than.
    """
    main, timestep, fewest, factor = _opening(pilots.scene)
    count = fewest
    few = knobs.overridden(pilots.scene, (*main.overrides(float(fewest)), *timestep.overrides(factor)))
    ladder = Ladder(pilots, main, timestep, factor, reference.estimated(few))
    while True:
        pilot = ladder.run(count, ladder.factor)
        if not pilot.failure:
            ladder.runs[count] = pilot
        elif ladder.factor > 1.0:
            ladder.factor, ladder.runs, count = 1.0, {}, fewest
            continue
        elif count >= FAILING * fewest:
            return OutOfReach(f"a pilot with {count} particles failed: {pilot.failure}")
        following = int(GROWTH * count)
        steps = {ladder.step(n): ladder.runs[n] for n in sorted(ladder.runs)[-LAST:]}
        if len(steps) >= 2:
            estimates = pilots.estimates(steps, main.order or 2.0, ORDERS, TRUST)
            estimate = worst([*estimates.values()])
            limit = pilots.limit(steps, estimate.order)
            wanted = _particles(ladder, estimate, OF_RESOLUTION * accuracy)
            affords = partial(ladder.affords, ((fewest, 1.0),), wanted, ladder.factor)
            cheaper = other(limit, UNSURE * estimate.error, affords)
            if cheaper is not None:
                return cheaper
            further = ((following, ladder.factor), (fewest, 1.0))
            if wanted > MOST or ladder.seconds(wanted) > seconds:
                telling = ladder.seconds(following) > min(REFUSING * seconds, PATIENCE) or following > MOST
                if len(ladder.runs) > 2 and telling:
                    errs_most = max(estimates, key=lambda name: estimates[name].error)
                    return _refusal(ladder, estimate, wanted, seconds, errs_most if len(estimates) > 1 else "")
            elif not ladder.affords(further, wanted, ladder.factor):
                return _settled(ladder, estimate, wanted, accuracy)
            elif len(ladder.runs) > 2 and wanted <= BEYOND * count and other(limit, 0.0, affords) is None:
                return _settled(ladder, estimate, wanted, accuracy)  # else a finer pilot may tell that it agrees
        count = following


def first(scene: Scene) -> tuple[Scene, ...]:
    """What every search runs, about: two numbers of particles with long steps, and shorter ones at the fewer."""
    main, timestep, fewest, longer = _opening(scene)
    pilots = ((fewest, longer), (int(GROWTH * fewest), longer), (fewest, 1.0))
    return tuple(
        knobs.overridden(scene, (*main.overrides(float(count)), *timestep.overrides(factor)))
        for count, factor in pilots
    )


def _opening(scene: Scene) -> tuple[Knob, Knob, int, float]:
    """The knobs of particles and of time steps, and with how many particles and which steps the first pilot is run."""
    by_name = {knob.name: knob for knob in knobs.knobs(scene)}
    main, timestep = by_name["particles"], by_name["timestep_factor"]
    neighbours = smoothing(knobs.overridden(scene, main.overrides(1000.0)))[1]  # they may rise from a thousand on
    return main, timestep, round(FEWEST * neighbours), LONGER if LONGER in timestep.values else 1.0


def _particles(ladder: Ladder, estimate: Estimate, error: float) -> float:
    """How many particles have an error, by what the finest pilot has."""
    wanted = ladder.finest * estimate.ratio_for(error) ** -3
    return _rounded(wanted) if wanted > LEAST else float(LEAST)


def _rounded(count: float) -> float:
    """Up, to two digits."""
    unit = 10.0 ** (math.floor(math.log10(count)) - 1)
    return math.ceil(count / unit) * unit


def _settled(ladder: Ladder, estimate: Estimate, wanted: float, accuracy: float) -> Settings:
    finest = ladder.finest
    tried = max(
        (n for n in ladder.runs if n <= TRIED and ladder.affords(((n, 1.0),), wanted, ladder.factor)),
        default=min(ladder.runs),
    )
    factor, of_steps, steps = _timestep(ladder, tried, OF_STEPS * accuracy)
    gravity = _gravity(ladder, tried, wanted, factor, OF_GRAVITY * accuracy)
    least = wanted
    while not ladder.affords((), least, factor):
        least = _rounded(FINER * least)
    why = (
        f"pilots with {', '.join(map(str, sorted(ladder.runs)))} give an error of {estimate.error:.1e} at {finest}, "
        f"which falls as h^{estimate.order:.2g}{'' if len(ladder.runs) > 2 else ', assumed of two pilots'}"
    )
    if wanted < least:
        wanted, why = least, f"{why}; fewer would cost less than the pilots"
    overrides, chosen = ladder.main.overrides(wanted), {"particles": wanted}
    errors = {"resolution": estimate.at(ladder.step(wanted) / ladder.step(finest)), "time steps": of_steps}
    reasons = [f"{wanted:.0f} particles: {why}", steps]
    if factor != 1.0:
        overrides += ladder.timestep.overrides(factor)
        chosen["timestep_factor"] = factor
    if gravity is not None:
        knob, value, errors["gravity"], why = gravity
        reasons.append(why)
        if value != knob.default:
            overrides, chosen["force_error"] = overrides + knob.overrides(value), value
    seconds = ladder.seconds(wanted) * ladder.factor / factor
    processor = ladder.processor_of_run(wanted, factor)
    return Settings(overrides, chosen, errors, seconds, tuple(reasons), ladder.of_run(wanted, factor), processor)


def _timestep(ladder: Ladder, count: int, share: float) -> tuple[float, float, str]:
    """The longest time steps whose error, by second order, stays below a share; that error; and why."""
    longer = ladder.factor
    if longer == 1.0:
        return 1.0, 0.0, "time steps as they are: none longer can be tried"
    apart = ladder.pilots.apart(ladder.runs[count], ladder.run(count, 1.0))
    if not math.isfinite(apart):
        return 1.0, 0.0, "time steps as they are: a pilot with them failed"
    least = apart / (longer**2 - 1.0)
    wanted = math.sqrt(share / least) if least > 0.0 else longer
    factor = float(f"{min(max(wanted, SHORTEST), longer):.2g}")
    why = (
        f"time steps {factor:g} times as long: {longer:g} times as long they err {longer**2 * least:.1e} "
        f"with {count} particles"
    )
    return factor, least * factor**2, why


def _gravity(
    ladder: Ladder, count: int, wanted: float, factor: float, share: float
) -> tuple[Knob, float, float, str] | None:
    """The coarsest gravity that is no coarser than a share, and whose error against the plain pilot is below it.

    None where gravity is not by multipoles; as it is where the pilots would cost more than the run.
    """
    scene = knobs.overridden(ladder.pilots.scene, ladder.main.overrides(wanted))
    knob = next((knob for knob in knobs.knobs(scene) if knob.name == "force_error"), None)
    if knob is None:
        return None
    value, error, why = float(knob.default), math.nan, ""
    for tried in map(float, knob.values):  # from coarse to fine
        if tried > share and tried != knob.values[-1]:
            continue
        if not ladder.affords(((count, ladder.factor),), wanted, factor):
            value = error = float(knob.default)  # motion is linear in it
            why = f"gravity to {value:g}, as it is: one more pilot would cost more than the run"
            break
        pilot = ladder.run(count, ladder.factor, knob.overrides(tried), f", gravity to {tried:g}")
        value, error = tried, ladder.pilots.apart(pilot, ladder.runs[count])
        why = f"gravity to {value:g} changes the pilot with {count} particles by {error:.1e}"
        if error <= share:
            break
    return knob, value, error, why


def _refusal(ladder: Ladder, estimate: Estimate, wanted: float, seconds: float, errs_most: str) -> OutOfReach:
    finest = ladder.finest
    most = finest * (seconds / ladder.seconds(finest)) ** (1.0 / COST)
    takes = f"it takes {wanted:.2g} particles and {duration(ladder.seconds(wanted))}"
    takes += f" for {errs_most}, which errs most" if errs_most else ""
    if most < MOST:
        within, advice = f"in {duration(seconds)} some {most:.2g} particles", "ask for no less, or allow more --minutes"
    else:
        most, within, advice = MOST, f"no more than {MOST:.2g} are chosen, which", "ask for no less"
    best = estimate.at(ladder.step(most) / ladder.step(finest)) / OF_RESOLUTION
    return OutOfReach(f"{takes}; {within} have {best:.1e}: {advice}")
