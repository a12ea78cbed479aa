"""The search for the cheapest integration of a body without particles that has a wanted accuracy.

Every method that the scene allows (adaptive to a tolerance; splittings of several orders) is climbed from coarse to
fine until its own differences tell an error below what is wanted; the one that took the least time is chosen.
Tests: tests/unit/accuracy/test_choice.py, tests/benchmarks/delivered.py.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from astroinertia.accuracy.estimates import Estimate
from astroinertia.accuracy.knobs import Value
from astroinertia.accuracy.measuring import Measured
from astroinertia.accuracy.pilots import OutOfReach, Pilots, Settings
from astroinertia.accuracy.words import duration
from astroinertia.scene.schema import Scene

SHARE = 0.4  # of the wanted accuracy that the method may err, for the estimate has an error of its own
FEWEST_STEPS, MOST_STEPS = 4.0, 1e5  # in a rotation
FINEST_TOLERANCE = 1e-14
COSTLIER = 1.2  # times the cheapest so far, at which a method is given up
ORDERS = (6, 8, 4, 2)  # of splittings, the likeliest first: others are given up as soon as they cost more


@dataclass(frozen=True)
class Method:
    """A way to integrate, with one number that says how finely.

    values: from coarse to fine, each `growth` times finer in `step`, of which the error goes as the power `order`, or
    as another within `orders`; between: whether numbers between those are worth taking.
    """

    name: str
    values: tuple[float, ...]
    overrides: Callable[[float], tuple[str, ...]]
    step: Callable[[float], float]
    value_at: Callable[[float], float]
    order: float
    orders: tuple[float, float]
    between: bool


def methods(scene: Scene, accuracy: float) -> tuple[Method, ...]:
    """Those that a scene's model has; some of them a scene may refuse."""
    coarsest = 10.0 ** min(-2.0, math.ceil(math.log10(accuracy)))
    tolerances = [coarsest]
    while tolerances[-1] > 1.5 * FINEST_TOLERANCE:
        tolerances.append(float(f"{tolerances[-1] / 10.0:.1e}"))
    rigid = scene.model == "rigid"
    adaptive = ("numerics.integrator='adaptive'",) if rigid else ()
    by_tolerance = Method(
        "tolerance", tuple(tolerances), lambda value: (*adaptive, f"numerics.tolerance={value!r}"),
        float, float, 1.0, (0.5, 1.3), between=False,
    )  # fmt: skip
    if not rigid:
        return (by_tolerance,)
    steps = [FEWEST_STEPS]
    while steps[-1] < MOST_STEPS:
        steps.append(2.0 * steps[-1])
    return (
        *(
            Method(
                f"steps_per_rotation of order {order}", tuple(steps), _splitting(order),
                lambda value: 1.0 / value, lambda step: 1.0 / step, float(order), (1.0, order + 0.5), between=True,
            )
            for order in ORDERS
        ),
        by_tolerance,
    )  # fmt: skip


def _splitting(order: int) -> Callable[[float], tuple[str, ...]]:
    return lambda value: (
        "numerics.integrator='splitting'", f"numerics.order={order}", f"numerics.steps_per_rotation={value!r}"
    )  # fmt: skip


def search(pilots: Pilots, accuracy: float, seconds: float) -> Settings | OutOfReach:
    """The cheapest of all methods for an accuracy; seconds: of wall time that the run may take."""
    best: Settings | None = None
    finest: list[tuple[float, str]] = []  # the least error of the methods that do not reach it
    for method in methods(pilots.scene, accuracy):
        limit = seconds if best is None else min(seconds, COSTLIER * best.seconds)
        outcome = _climbed(pilots, method, SHARE * accuracy, limit)
        if isinstance(outcome, Settings):
            best = outcome if best is None or outcome.seconds < best.seconds else best
        elif outcome is not None:
            finest.append(outcome)
    if best is not None:
        return best
    error, reason = min(finest, default=(math.nan, "no method could be tried"))
    return OutOfReach(f"the least error found is {error:.1e}: {reason}")


def _climbed(pilots: Pilots, method: Method, wanted: float, limit: float) -> Settings | tuple[float, str] | None:
    """What a method takes; or the least error that it has, and with what; None where it fails from the start."""
    ladder: dict[float, Measured] = {}
    least: tuple[float, str] | None = None
    for value in method.values:
        label = f"{method.name.replace('_', ' ')} {value:g}"
        pilot = pilots.run(label, method.overrides(value))
        if pilot.failure:
            if ladder:
                return least
            continue
        ladder[value] = pilot
        if len(ladder) > 1:
            estimate = _estimated(pilots, method, ladder)
            error = estimate.error
            if error <= wanted and len(ladder) > 2:
                return _settled(pilots, method, ladder, estimate, wanted)
            if math.isfinite(error) and (least is None or error < least[0]):
                least = (error, f"{label}, in {duration(pilot.cpu_time)}")
            if len(ladder) > 2 and pilot.cpu_time * _finer(method, estimate, wanted) > limit:
                return least
            if len(ladder) > 4 and least is not None and error > 100.0 * least[0]:
                return least  # rounding has taken over
        if pilot.cpu_time > limit:
            return least
    return least


def _finer(method: Method, estimate: Estimate, wanted: float) -> float:
    """How many times as many steps as the finest pilot's an error takes."""
    steps_go_as = 1.0 if method.between else 1.0 / 8.0  # of a pair of order 8, as its tolerance^(-1/8)
    return 1.0 / estimate.ratio_for(wanted) ** steps_go_as if estimate.error > wanted else 1.0


def _estimated(pilots: Pilots, method: Method, ladder: dict[float, Measured]) -> Estimate:
    # Coarser ones than the last four say nothing of the order that counts.
    kept = sorted(ladder, key=method.step)[:4]
    return pilots.estimate({method.step(value): ladder[value] for value in kept}, method.order, method.orders)


def _settled(
    pilots: Pilots, method: Method, ladder: dict[float, Measured], estimate: Estimate, wanted: float
) -> Settings:
    """The coarsest value whose difference from the finest run, and those of all finer ones, are small enough."""
    ranked = sorted(ladder, key=method.step)
    finest = ranked[0]
    value, error = finest, estimate.error
    for coarser in ranked[1:]:
        apart = pilots.apart(ladder[coarser], ladder[finest]) + estimate.error
        if apart > wanted:
            break
        value, error = coarser, apart
    seconds = ladder[value].cpu_time
    if method.between:
        order = min(estimate.order, method.order)
        further = min((wanted / error) ** (1.0 / order), 2.0) if error > 0.0 else 2.0
        if further > 1.05 and value != method.values[0]:
            chosen = float(f"{method.value_at(further * method.step(value)):.2g}")
            seconds, error = seconds * chosen / value, error * (value / chosen) ** order
            value = chosen
    settings: dict[str, Value] = {method.name: value}
    why = (
        f"{method.name.replace('_', ' ')} {value:g}: runs up to {finest:g} tell an error of {estimate.error:.1e} "
        f"there, of order {estimate.order:.2g}"
    )
    return Settings(method.overrides(value), settings, {"integration": error}, seconds, (why,))
