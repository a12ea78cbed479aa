"""The search for the cheapest integration of a body without particles that has a wanted accuracy.

Two coarse pilots of the cheapest method tell how large its error is, and by theory what other methods (adaptive to a
tolerance; splittings of several orders) would take. The cheapest is climbed from coarse to fine until its own
differences tell an error below what is wanted, or until one more pilot would cost more than the run; then the rest is
extrapolated. Tests: tests/unit/accuracy/test_choice.py, tests/benchmarks/delivered.py.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field

from astroinertia.accuracy.estimates import Estimate
from astroinertia.accuracy.knobs import overridden
from astroinertia.accuracy.measuring import Measured
from astroinertia.accuracy.pilots import OutOfReach, Pilots, Settings, seconds_of
from astroinertia.costs import smooth
from astroinertia.errors import SceneError
from astroinertia.scene.schema import Scene

SHARE = 0.4  # of the wanted accuracy that the method may err, for the estimate has an error of its own
FEWEST_STEPS, MOST_STEPS = 4.0, 1e5  # in a rotation
FINEST_TOLERANCE = 1e-14
COARSER = 1e6  # times the accuracy, the coarsest tolerance: fine enough for an order, and cheap beside the run
OF_PAIR = 9.0  # steps of the adaptive pair go as the tolerance to minus one over this, as measured; 8 in theory
STAGES = 36.0  # of a splitting, that take as long as a step of that pair (costs/machine.py)
LOST = 0.3  # difference from the finest, beyond which a pilot is elsewhere and tells no order
ROUNDED = 100.0  # times the least error, above which rounding has taken over


@dataclass(frozen=True)
class Method:
    """A way to integrate, with one number that says how finely.

    values: from coarse to fine, each `growth` times finer in `step`, of which the error goes as the power `order`, or
    as another within `orders`; between: whether numbers between those are worth taking; stages: of a step.
    """

    name: str
    values: tuple[float, ...]
    overrides: Callable[[float], tuple[str, ...]]
    step: Callable[[float], float]
    value_at: Callable[[float], float]
    order: float
    orders: tuple[float, float]
    between: bool
    stages: float

    def steps(self, value: float) -> float:
        """How many there are, over any unit."""
        return value if self.between else value ** (-1.0 / OF_PAIR)

    def finer(self, value: float, times: float) -> float:
        """The value with so many times the steps, or at least these, within its bounds."""
        if self.between:
            return min(max(float(f"{value * times * 1.05:.2g}"), self.values[0]), self.values[-1])
        wanted = value * times**-OF_PAIR
        return next((one for one in self.values if one <= 1.01 * wanted), self.values[-1])


def methods(scene: Scene, accuracy: float) -> tuple[Method, ...]:
    """Those that a scene's model has, the cheapest of a step first; some of them a scene may refuse."""
    tolerances = [10.0 ** min(-2.0, math.ceil(math.log10(COARSER * accuracy)))]
    while tolerances[-1] > 1.5 * FINEST_TOLERANCE:
        tolerances.append(float(f"{tolerances[-1] / 10.0:.1e}"))
    rigid = scene.model == "rigid"
    adaptive = ("numerics.integrator='adaptive'",) if rigid else ()
    by_tolerance = Method(
        "tolerance", tuple(tolerances), lambda value: (*adaptive, f"numerics.tolerance={value!r}"),
        float, float, 1.0, (0.5, 1.0), between=False, stages=STAGES,
    )  # fmt: skip
    if not rigid:
        return (by_tolerance,)
    steps = [FEWEST_STEPS]
    while steps[-1] < MOST_STEPS:
        steps.append(min(2.0 * steps[-1], MOST_STEPS))
    return (
        *(
            Method(
                f"steps_per_rotation of order {order}", tuple(steps), _splitting(order),
                lambda value: 1.0 / value, lambda step: 1.0 / step, float(order), (1.0, order + 0.5), between=True,
                stages=float(stages),
            )
            for order, stages in smooth.STAGES.items()
        ),
        by_tolerance,
    )  # fmt: skip


def _splitting(order: int) -> Callable[[float], tuple[str, ...]]:
    return lambda value: (
        "numerics.integrator='splitting'", f"numerics.order={order}", f"numerics.steps_per_rotation={value!r}"
    )  # fmt: skip


@dataclass
class Ladder:
    """Pilots of a method by its first values, from coarse to fine; wanted: the error that it is to have."""

    pilots: Pilots
    method: Method
    wanted: float
    runs: dict[float, Measured] = field(default_factory=dict)
    ended: bool = False
    least: tuple[float, str] = (math.inf, "")
    failure: str = ""

    @property
    def following(self) -> float:
        """The next value to try."""
        return next(iter(self.method.values[len(self.runs) :]), math.nan)

    def climb(self) -> None:
        """One pilot more; the end of the ladder where it fails."""
        value = self.following
        label = f"{self.method.name.replace('_', ' ')} {value:g}"
        pilot = self.pilots.run(label, self.method.overrides(value), self.work(value), self.method.stages)
        if pilot.failure:
            self.ended, self.failure = True, pilot.failure
            return
        self.runs[value] = pilot
        error = self.estimate.error
        if error < self.least[0]:
            self.least = (error, label)
        rounded = len(self.runs) > 4 and error > ROUNDED * self.least[0]
        self.ended = rounded or math.isnan(self.following)

    @property
    def estimate(self) -> Estimate:
        """Of the finest; coarser ones than the last four, or far from it, say nothing of the order that counts."""
        kept = [*self.runs][:-5:-1]
        last = self.runs[self.finest]
        steps = {
            self.method.step(value): run for value in kept if self.pilots.apart(run := self.runs[value], last) < LOST
        }
        return self.pilots.estimate(steps, self.method.order, self.method.orders)

    @property
    def finest(self) -> float:
        """The finest value so far."""
        return next(reversed(self.runs))

    def work(self, value: float) -> float:
        """Stages that a pilot takes; 0 where nothing says so."""
        method = self.method
        if self.runs:
            last = self.finest
            return method.stages * self.runs[last].evaluations * method.steps(value) / method.steps(last)
        with suppress(ArithmeticError, ValueError, SceneError):
            return method.stages * smooth.steps(overridden(self.pilots.scene, method.overrides(value)), 2)
        return 0.0

    def of_run(self, value: float) -> float:
        """Stages that the run takes, which meets the times of its records."""
        return max(self.work(value), self.method.stages * self.pilots.met)

    @property
    def predicted(self) -> float:
        """Stages of the run that the method would choose; infinite where pilots tell nothing, or it has ended."""
        error = self.estimate.error
        if error <= self.wanted:
            return self.of_run(self.finest)
        return math.inf if self.ended or math.isnan(error) else self.of_run(self.reaching(self.method.order))

    def reaching(self, order: float) -> float:
        """The value with the wanted error, if errors fall with an order."""
        ratio = (self.wanted / self.estimate.error) ** (1.0 / order)
        return self.method.finer(self.finest, ratio ** (-1.0 if self.method.between else -1.0 / OF_PAIR))

    def by_theory(self, other: "Ladder") -> float:
        """Stages of the run that the method would choose if its steps erred as those of another one do."""
        method, estimate = self.method, other.estimate
        if not (method.between and other.method.between):
            # Errors of all steps add.
            error = self.wanted * method.stages / max(self.work(self.wanted), method.stages)
            value = min(max(error, method.values[-1]), method.values[0])
            return math.inf if method.between else self.of_run(value)
        coarse = other.finest * estimate.error ** (1.0 / estimate.order)
        return self.of_run(max(coarse / self.wanted ** (1.0 / method.order), FEWEST_STEPS))

    @property
    def beginning(self) -> float:
        """Stages of the first two pilots."""
        return sum(map(self.work, self.method.values[len(self.runs) : 2]))

    def seconds(self, value: float) -> float:
        """Of wall time, that the run is predicted to take."""
        return seconds_of(overridden(self.pilots.scene, self.method.overrides(value)))[0]


def first(scene: Scene) -> tuple[Scene, ...]:
    """What every search runs at first: two coarse settings of the method that is the cheapest of a step."""
    method = methods(scene, scene.accuracy or FINEST_TOLERANCE)[0]
    return tuple(overridden(scene, method.overrides(value)) for value in method.values[:2])


def search(pilots: Pilots, accuracy: float, seconds: float) -> Settings | OutOfReach:
    """The cheapest of all methods for an accuracy; seconds: of wall time that the run may take."""
    ladders = [Ladder(pilots, method, SHARE * accuracy) for method in methods(pilots.scene, accuracy)]
    while True:
        best = min((ladder for ladder in ladders if len(ladder.runs) > 1), key=lambda one: one.predicted, default=None)
        others = [ladder for ladder in ladders if len(ladder.runs) < 2 and not ladder.ended]
        if best is None or best.predicted == math.inf:
            further = [ladder for ladder in ladders if not ladder.ended]
            if not further:
                return _refusal(ladders)
            # Where the first method is lost, the highest order finds the way at the least cost, unless records ask for
            # so many steps that it goes on.
            highest = max(further, key=lambda one: one.method.order)
            first = further[0]
            goes_on = best is None or pilots.work + first.work(first.following) <= first.of_run(first.following)
            (first if goes_on else highest).climb()
            continue
        cheaper = {
            cost: ladder for ladder in others
            if (cost := ladder.by_theory(best)) < best.predicted and pilots.work + ladder.beginning <= best.predicted
        }  # fmt: skip
        if cheaper:
            cheaper[min(cheaper)].climb()
        elif best.estimate.error <= best.wanted and len(best.runs) > 2:
            return _settled(best) if best.seconds(best.finest) <= seconds else _refusal(ladders)
        elif best.ended or pilots.work + best.work(best.following) > best.predicted:
            settings = _settled(best)
            reached = min(settings.error, best.estimate.error) <= 1.01 * best.wanted and settings.seconds <= seconds
            return settings if reached else _refusal(ladders)
        elif best.seconds(best.following) > seconds:
            return _refusal(ladders)
        else:
            best.climb()


def _refusal(ladders: list[Ladder]) -> OutOfReach:
    error, label = min(ladder.least for ladder in ladders)
    if not label:
        failure = next((ladder.failure for ladder in ladders if ladder.failure), "no two of them agree")
        return OutOfReach(f"pilots give no error: {failure.removesuffix('.')}")
    return OutOfReach(f"the least error found is {error:.1e}: {label}")


def _settled(ladder: Ladder) -> Settings:
    """The coarsest value whose difference from the finest run, and those of all finer ones, are small enough.

    Where the finest is not, what has the wanted error by how it falls; none whose run would cost less than the pilots.
    """
    method, wanted, estimate = ladder.method, ladder.wanted, ladder.estimate
    ranked = [*reversed(ladder.runs)]
    value, error = ranked[0], estimate.error
    why = f"runs up to {value:g} give an error of {error:.1e} there, of order {estimate.order:.2g}"
    if error > wanted:
        value, why = ladder.reaching(estimate.order), f"{why}, by which finer ones are taken to err"
        error = estimate.at(method.step(value) / method.step(ranked[0]))
    for coarser in ranked[1:]:
        apart = ladder.pilots.apart(ladder.runs[coarser], ladder.runs[ranked[0]]) + estimate.error
        if apart > wanted:
            break
        value, error = coarser, apart
    if method.between and value in ranked and value != method.values[0]:
        order = method.order
        further = min((wanted / error) ** (1.0 / order), 2.0) if error > 0.0 else 2.0
        if further > 1.05:
            chosen = float(f"{method.value_at(further * method.step(value)):.2g}")
            value, error = chosen, error * (value / chosen) ** order
    if (least := ladder.pilots.work) > ladder.of_run(value):
        chosen, why = (
            method.finer(value, least / ladder.work(value)),
            f"{why}; a coarser run would cost less than the pilots",
        )
        value, error = chosen, error * (method.step(chosen) / method.step(value)) ** estimate.order
    name = method.name.replace("_", " ")
    return Settings(
        method.overrides(value), {method.name: value}, {"integration": error}, ladder.seconds(value),
        (f"{name} {value:g}: {why}",), ladder.of_run(value),
    )  # fmt: skip
