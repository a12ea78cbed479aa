"""How the size of a body changes when it keeps its profile: prescribed, at rest, or by the scalar virial theorem.

With x = s(t) x_0 for all matter, d2(tr Q)/dt2 / 2 = 2T + W + 3 Pi becomes

    tr Q_0 s s'' = 2T_0/s^2 + W_0/s + 3 Pi(s),    Pi = volume integral of the pressure,

Kepler's problem where Pi goes as s^-1 or s^-2 (exponents 4/3 and 5/3, or no pressure at all), solved here in closed
form; else it is integrated, once for a period of the pulsation. Units with G = 1. Tests:
tests/unit/models/scaling/test_homology.py.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from scipy.integrate import DOP853, solve_ivp

from astroinertia.errors import NumericalError
from astroinertia.inertia.prescribed import Change
from astroinertia.process.roots import root_between

SMALLEST = 1e-6  # of the opening size: a body that falls below this has collapsed to a point
_RELATIVE, _ABSOLUTE = 3e-14, 1e-16
_SERIES = 0.3  # of the argument of Stumpff's functions, below which their series is used
_MOST_STEPS = 200_000
_TOO_MANY = 10 * _MOST_STEPS  # expected from two turning points, whatever becomes of the motion
_LOOKED_AHEAD = 400  # steps, more than a pulsation takes
_AT_ONCE = 2000  # steps, after which the run looks at the clock and at what signals ask for


class Size(NamedTuple):
    """The scale s with its first and second derivative."""

    scale: float
    rate: float
    acceleration: float


class SizeLaw(Protocol):
    """What says how large a body is."""

    def at(self, time: float) -> Size:
        """The size at a time, always the same whatever was asked before; NumericalError where there is none."""
        ...


@dataclass(frozen=True)
class Fixed:
    """A size that stays."""

    scale: float = 1.0

    def at(self, time: float) -> Size:
        """The size."""
        return Size(self.scale, 0.0, 0.0)


@dataclass(frozen=True)
class Prescribed:
    """The square root of a prescribed factor of the inertia tensor, times the scale at the start."""

    change: Change
    scale: float = 1.0

    def at(self, time: float) -> Size:
        """The size; its second derivative jumps where pieces of the curve meet."""
        factor, first, second = self.change.derivatives(time)
        root = math.sqrt(factor)
        rate = 0.5 * first / root
        return Size(self.scale * root, self.scale * rate, self.scale * (0.5 * second / root - rate**2 / root))


@dataclass(frozen=True)
class Kepler:
    """s'' = repulsion/s^3 - attraction/s^2 from a scale and a rate at time 0, in closed form for any energy.

    A pulsation is Kepler's ellipse, from its least size on, so that hard bounces keep their digits. Else, in the
    variable ds with dt = s ds the motion is linear: s = s_0 G_0 + s_0 s_0' G_1 + attraction G_2 with the functions G_k
    of Stumpff of -2E. Cold and at rest it is the cycloid of free fall.
    Source: Stiefel & Scheifele 1971, Linear and Regular Celestial Mechanics, section 11.
    """

    repulsion: float
    attraction: float
    scale: float = 1.0
    rate: float = 0.0

    @property
    def energy(self) -> float:
        """s'^2/2 + repulsion/(2 s^2) - attraction/s."""
        return 0.5 * self.rate**2 + 0.5 * self.repulsion / self.scale**2 - self.attraction / self.scale

    @property
    def period(self) -> float:
        """Of the pulsation; infinite where there is none."""
        if not (self.energy < 0 < self.repulsion):
            return math.inf
        return 2 * math.pi * self.attraction / (-2 * self.energy) ** 1.5

    @property
    def collapse_time(self) -> float:
        """When the size reaches 0; infinite where it does not. Whatever repels stops the fall before."""
        if self.repulsion > 0 or self.attraction < 0:
            return math.inf
        if self.attraction == 0:
            return math.inf if self.rate >= 0 else -self.scale / self.rate
        step = self._collapse_step()
        return self._moved(step)[1] if math.isfinite(step) else math.inf

    def at(self, time: float) -> Size:
        """The size; NumericalError from the collapse on."""
        if time >= self.collapse_time * (1 - 1e-14):
            raise _collapsed(self.collapse_time)
        if self.attraction == 0:
            scale = math.hypot(self.scale + self.rate * time, math.sqrt(self.repulsion) * time / self.scale)
            momentum = (self.scale + self.rate * time) * self.rate + self.repulsion * time / self.scale**2
            return Size(scale, momentum / scale, self.repulsion / scale**3)
        if math.isfinite(self.period):
            return self._pulsating(time)
        step = self._step_at(time) if time > 0 else 0.0
        scale, _, momentum = self._moved(step)
        if not scale > 0:
            raise _collapsed(self.collapse_time)
        return Size(scale, momentum / scale, (self.repulsion / scale - self.attraction) / scale**2)

    def _pulsating(self, time: float) -> Size:
        # The eccentric anomaly runs from the least size, which is known to its last digit; so is s then.
        half = self.attraction / (-2 * self.energy)
        speed = math.sqrt(self.attraction * half)
        least = self._least(half)
        eccentricity, rest = 1 - least / half, least / half
        start = math.atan2(self.scale * self.rate / speed, 1 - self.scale / half)

        def mean(anomaly: float) -> float:
            return _excess_over_sine(anomaly) + rest * math.sin(anomaly)

        wanted = mean(start) + 2 * math.pi * math.fmod(time, self.period) / self.period
        wanted -= 2 * math.pi * round(wanted / (2 * math.pi))
        anomaly = root_between(lambda x: mean(x) - wanted, -3.2, 3.2, 1e-300, 1e-14)
        scale = least + 2 * half * eccentricity * math.sin(0.5 * anomaly) ** 2
        rate = speed * eccentricity * math.sin(anomaly) / scale
        return Size(scale, rate, (self.repulsion / scale - self.attraction) / scale**2)

    def _least(self, half: float) -> float:
        # The smaller root of 2 E s^2 + 2 attraction s - repulsion, without cancellation.
        return self.repulsion / (
            self.attraction * (1 + math.sqrt(max(0.0, 1 - self.repulsion / (self.attraction * half))))
        )

    def _step_at(self, time: float) -> float:
        """The linear variable at a time after 0, to the last digit: dt/ds is the size itself."""
        last = self._collapse_step() if self.repulsion == 0 and self.attraction > 0 else math.inf
        # Where the body flies apart, time goes with the exponential of the step: a longer one would have no number.
        slow = 1.0 / math.sqrt(2 * self.energy) if self.energy > 0 else math.inf
        low, high = 0.0, min(time / self.scale, last, slow)
        while self._moved(high)[1] < time and high < last:
            low, high = high, min(2 * high, last)
        step = root_between(lambda s: self._moved(s)[1] - time, low, high, 1e-300, 1e-14)
        for _ in range(2):
            scale, reached, _ = self._moved(step)
            if scale > SMALLEST * self.scale:
                step -= (reached - time) / scale
        return step

    def _collapse_step(self) -> float:
        # Without repulsion s touches 0 where it has its minimum by the linear variable.
        alpha, momentum = -2 * self.energy, self.scale * self.rate
        root = math.sqrt(abs(alpha))
        if alpha > 0:
            phase = math.atan2(momentum / root, self.scale - self.attraction / alpha)
            return ((phase + math.pi) % (2 * math.pi) or 2 * math.pi) / root
        if momentum >= 0:
            return math.inf
        if alpha == 0:
            return -momentum / self.attraction
        return math.atanh(-momentum / root / (self.scale - self.attraction / alpha)) / root

    def _moved(self, step: float) -> tuple[float, float, float]:
        """s, t and s s' at a step of the linear variable."""
        g0, g1, g2, g3 = _stumpff(-2 * self.energy, step)
        momentum = self.scale * self.rate
        return (
            self.scale * g0 + momentum * g1 + self.attraction * g2,
            self.scale * g1 + momentum * g2 + self.attraction * g3,
            momentum * g0 + (self.attraction + 2 * self.energy * self.scale) * g1,
        )


def _stumpff(alpha: float, step: float) -> tuple[float, float, float, float]:
    """G_k(alpha, s) = s^k c_k(alpha s^2)."""
    z = alpha * step * step
    if abs(z) < _SERIES:
        terms = []
        for k in range(4):
            total, term = 0.0, 1.0 / math.factorial(k)
            for j in range(1, 14):
                total += term
                term *= -z / ((k + 2 * j - 1) * (k + 2 * j))
            terms.append(total)
        return terms[0], step * terms[1], step**2 * terms[2], step**3 * terms[3]
    root = math.sqrt(abs(alpha))
    if alpha > 0:
        g0, g1 = math.cos(root * step), math.sin(root * step) / root
    else:
        g0, g1 = math.cosh(root * step), math.sinh(root * step) / root
    half = _half_sine(alpha, root, step)
    return g0, g1, half, (step - g1) / alpha


def _excess_over_sine(x: float) -> float:
    # x - sin x, by its series where that would cancel
    if abs(x) > 0.5:
        return x - math.sin(x)
    total, term = 0.0, x**3 / 6
    for k in range(2, 12):
        total += term
        term *= -x * x / ((2 * k) * (2 * k + 1))
    return total


def _half_sine(alpha: float, root: float, step: float) -> float:
    # (1 - G_0)/alpha without cancellation
    sine = math.sin(0.5 * root * step) if alpha > 0 else math.sinh(0.5 * root * step)
    return 2 * (sine / root) ** 2


class Dynamic:
    """State equations y' = slope(t, y) with y[0] the size and y[1] its rate, integrated to round-off (DOP853).

    The steps are the same whatever times are asked for, so that a resumed run computes the same bits. Where
    `pulsates`, the equations do not depend on time and have a potential: one period is integrated, between two of its
    turning points, and repeated for ever. breaks: times at which the equations change their form; what holds at one is
    what holds after it.
    """

    def __init__(
        self,
        slope: Callable[[float, np.ndarray], np.ndarray],
        start: np.ndarray,
        end: float,
        pulsates: bool = False,
        breaks: tuple[float, ...] = (),
    ) -> None:
        self._equations, self._end, self._pulsates = slope, end, pulsates
        self._knots: list[tuple[float, np.ndarray]] = [(0.0, np.asarray(start, dtype=float))]
        self._turns: list[tuple[float, np.ndarray]] = []
        self._period = math.inf
        self._breaks = [time for time in sorted(breaks) if 0 < time < end] + [end]
        self._solver = self._started()

    def look_ahead(self) -> None:
        """NumericalError where the body pulsates far too often for each pulsation to be followed to the end."""
        turns: list[tuple[int, float]] = []
        try:
            while len(turns) < 2 and len(self._knots) < _LOOKED_AHEAD and self._knots[-1][0] < self._end:
                before = self._knots[-1][1][1]
                self._step()
                time, state = self._knots[-1]
                if before * state[1] < 0:
                    turns.append((len(self._knots), time))
        except NumericalError:  # reported when the run gets there
            self._solver = self._started()
        if len(turns) < 2:
            return
        (first, begin), (last, end) = turns
        if (self._end - end) * (last - first) > _TOO_MANY * (end - begin):
            times = 0.5 * (self._end - end) / (end - begin)
            raise NumericalError(
                f"the body pulsates {times:.1e} times in the run, and each pulsation would be followed: leave out the "
                "pressure or the equation of state, so that its size stays, or end the run sooner"
            )

    def reached(self, time: float) -> float:
        """The time, or how far towards it so many steps get; NumericalError as `state`."""
        for _ in range(_AT_ONCE):
            if self._knots[-1][0] >= time or math.isfinite(self._period):
                return time
            self._step()
        return min(time, self._knots[-1][0])

    def state(self, time: float) -> np.ndarray:
        """y at a time; NumericalError where the body collapses before, or where too many steps would be needed."""
        while self._knots[-1][0] < time and not math.isfinite(self._period):
            self._step()
        if math.isfinite(self._period) and time > self._knots[0][0] + self._period:
            time = math.fmod(time, self._period)
        place = max(0, int(np.searchsorted([knot[0] for knot in self._knots], time, side="right")) - 1)
        before, state = self._knots[place]
        return state if time == before else self._from(before, state, time)

    def _from_on(self, time: float) -> tuple[Callable[[float, np.ndarray], np.ndarray], float]:
        """The equations that hold from a time on, and until when they do."""
        bound = next((moment for moment in self._breaks if moment > time), self._end)
        # The last stage of a step that ends at a break belongs to what holds before it.
        last = math.nextafter(bound, 0.0)
        return lambda moment, state: self._equations(min(moment, last), state), bound

    def _started(self) -> DOP853:
        time, state = self._knots[-1]
        slope, bound = self._from_on(time)
        if not np.isfinite(slope(time, state)).all():  # of which the solver would try ever shorter steps
            raise NumericalError("the forces on the body are beyond what numbers hold", time=time)
        error: Any = _ABSOLUTE * np.maximum(np.abs(state), 1.0)
        return DOP853(slope, time, state, bound, rtol=_RELATIVE, atol=error)

    def _step(self) -> None:
        if self._solver.status != "running":
            self._solver = self._started()
        try:
            with np.errstate(all="ignore"):  # what is no number is reported below
                message = self._solver.step()
        except OverflowError:  # of a size whose powers are no numbers
            raise NumericalError("the size cannot be followed any further", time=self._knots[-1][0]) from None
        time, state = float(self._solver.t), np.array(self._solver.y)
        if message or not np.isfinite(state).all() or state[0] <= 0:
            raise NumericalError("the size cannot be followed any further", time=self._knots[-1][0])
        if state[0] < SMALLEST * self._knots[0][1][0]:
            raise _collapsed(time)
        if len(self._knots) > _MOST_STEPS:
            share = f"{_MOST_STEPS} steps reach {100 * time / self._end:.3g} % of the run"
            raise NumericalError(f"the body pulsates too often: {share}", time=time)
        before, old = self._knots[-1]
        self._knots.append((time, state))
        if self._pulsates and old[1] * state[1] < 0:
            self._turned(before, old, time)

    def _turned(self, before: float, old: np.ndarray, time: float) -> None:
        # Half a period lies between two turning points, by the symmetry of a motion in a potential.
        crossing = root_between(lambda t: self._from(before, old, t)[1], before, time, 1e-15 * time)
        self._turns.append((crossing, old))
        if len(self._turns) == 2:
            self._period = 2 * (self._turns[1][0] - self._turns[0][0])
            while self._knots[-1][0] < min(self._period, self._end):
                self._pulsates = False
                self._step()

    def _from(self, before: float, state: np.ndarray, time: float) -> np.ndarray:
        if time == before:
            return state
        scale = np.maximum(np.abs(state), 1.0)
        solution = solve_ivp(
            self._from_on(before)[0], (before, time), state, "DOP853", t_eval=[time], first_step=time - before,
            rtol=_RELATIVE, atol=_ABSOLUTE * scale,
        )  # fmt: skip
        return solution.y[:, -1]


def _collapsed(time: float) -> NumericalError:
    return NumericalError("the body collapses to a point: neither pressure nor spin stops it", time=time)
