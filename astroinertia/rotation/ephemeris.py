"""Where the companions of a body are at any time, for compiled code: polynomials through orbits, mostly of REBOUND.

Every segment of time has one polynomial of degree 17 a coordinate, in Chebyshev form, that meets REBOUND's positions
and velocities at nine points, the ends among them, as in the ephemerides of the Jet Propulsion Laboratory (Newhall
1989, Celestial Mechanics 45, 305): so positions and velocities are continuous. Segments are halved where the orbits
bend fast; eight more points in each of them measure the error.
"""

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from astroinertia.engines.pytree import pytree
from astroinertia.errors import NumericalError
from astroinertia.inertia.tensor import namespace
from astroinertia.process.quantities import with_quantities
from astroinertia.units import CodeUnits

Array = Any

_FITTED = 9  # points of a segment that its polynomials meet
_COEFFICIENTS = 2 * _FITTED
_MOST_HALVINGS = 24  # of the first segment: orbits with a pericentre at 1e-5 of the distance
_TOLERANCE = 1e-13
_TOLERANCE_WHFAST = 1e-8
_FINEST_WHFAST = 256  # pieces in one of its steps, which are bodies that meet: their orbits are not WHFast's to tell
_TOLERANCE_ARCHIVE = 1e-8  # between its snapshots
_ROUND_OFF = 1e-15  # of coefficients over the distance
_FIRST = 4.0  # of the first segment, in units of the shortest time of the orbits: about right where they are circles
_DOUBLINGS = 60  # of it at most, where orbits have no end of their own
_MOST_BYTES = 2e9  # of coefficients
_OTHER = 1e3  # times the tolerance, over a segment: velocities that are others than those of the positions
_SURE = 10.0  # times what the slopes of positions may err by
_CONVERGED = 1e-4  # of the largest coefficient but the first: below it the last ones bound what is left out
_CLOSELY = 1001  # points between two of the seventeen
# Of a segment's half length: the points of the fit and between them those of the check (Chebyshev's extrema).
_POINTS = -np.cos(np.pi * np.arange(2 * _FITTED - 1) / (2 * _FITTED - 2))
_SHARES = 0.5 * (1.0 + _POINTS)
_AT_FIT, _AT_CHECK = slice(0, None, 2), slice(1, None, 2)


@pytree
@dataclass(frozen=True, eq=False)
class Ephemeris:
    """Positions of companions relative to the body, and their masses (N,), from `start` to `end`.

    `segment` (T,) is the number of the segment at the beginning of each of T equal parts of the time, none of which
    meets more than two; `middle` and `half_length` (S,) are those of the segments, and `coefficients` (S, 18, N, 3)
    multiply Chebyshev polynomials of (t - middle)/half_length. `error` is the largest distance of a companion, at the
    points of the check, from where its orbit has it, over its distance from the body.
    """

    start: Array
    end: Array
    segment: Array
    middle: Array
    half_length: Array
    coefficients: Array
    mass: Array
    error: Array
    names: tuple[str, ...] = field(metadata={"static": True})

    @with_quantities()
    def position(self, time: Array) -> Array:
        """Positions (..., N, 3) relative to the body at times (...,); NaN outside the time that is covered."""
        place, coefficients, _ = self._located(time)
        return namespace(place).einsum("...k,...kni->...ni", _chebyshev(place)[0], coefficients)

    @with_quantities()
    def velocity(self, time: Array) -> Array:
        """Velocities (..., N, 3) relative to the body at times (...,); NaN outside the time that is covered."""
        place, coefficients, half_length = self._located(time)
        slopes = namespace(place).einsum("...k,...kni->...ni", _chebyshev(place)[1], coefficients)
        return slopes / half_length[..., None, None]

    def within(self, distance: float) -> tuple[float, int] | None:
        """The first time at which a companion comes nearer to the body than that, and which; None where none does.

        Looked at at seventeen points a segment, and closely before the first that is so near.
        """
        basis = _chebyshev(_POINTS)[0]
        for middle, half, coefficients in zip(self.middle, self.half_length, self.coefficients, strict=True):
            near = np.linalg.norm(np.tensordot(basis, coefficients, 1), axis=-1) < distance
            times = middle + half * _POINTS
            if (found := np.argwhere(near & (times <= self.end)[:, None])).size:
                point, number = map(int, found[0])
                closely = np.linspace(times[max(point - 1, 0)], times[point], _CLOSELY)
                there = np.linalg.norm(self.position(closely)[:, number], axis=-1) < distance
                return float(closely[np.argmax(there)]), number
        return None

    def _located(self, time: Array) -> tuple[Array, Array, Array]:
        xp = namespace(time, self.coefficients)
        time = xp.asarray(time)
        parts = self.segment.shape[0]
        part = xp.floor((time - self.start) / (self.end - self.start) * parts).astype(int)
        number = xp.asarray(self.segment)[xp.clip(part, 0, parts - 1)]
        middle, half_length = xp.asarray(self.middle), xp.asarray(self.half_length)
        late = time >= middle[number] + half_length[number]  # at an edge the later one, whatever the parts
        number = xp.where(late, xp.minimum(number + 1, middle.shape[0] - 1), number)
        half_length = half_length[number]
        place = (time - middle[number]) / half_length
        covered = (time >= self.start) & (time <= self.end)
        return xp.where(covered, place, xp.nan), xp.asarray(self.coefficients)[number], half_length


def ephemeris(bodies: Any, end: float, tolerance: float | None = None) -> Ephemeris:
    """The orbits of all particles of a `rebound.Simulation` relative to particle 0, from its time to `end`.

    A table to a later end has the same places to the bit, but for WHFast, whose segments are all as short as the
    hardest needs. The simulation stays as it is, and forces that a user added to it are left out. tolerance is the
    error allowed at the points of the check, over the distance: 1e-13 where none is given, and 1e-8 with WHFast, whose
    orbits are less smooth. ValueError where there is no companion or no time; NumericalError where the tolerance is
    not reached, or where the table would outgrow the memory. Checked by tests/unit/rotation/test_ephemeris.py.
    """
    start, span = float(bodies.t), float(end) - float(bodies.t)
    if bodies.N < 2:
        raise ValueError("an ephemeris needs a companion")
    if not span > 0.0:
        raise ValueError(f"the ephemeris ends at {end:g}, which is not after its start at {start:g}")
    from astroinertia.orbits import states  # only here: what reads an ephemeris does without REBOUND

    # Segments are parts of a time that the orbits give, and not of the table's: so they are those of any other end.
    whole = 2.0**_DOUBLINGS * _FIRST * states.shortest_time(bodies)
    fit = _segments(bodies, whole, span, _allowed(bodies, tolerance))
    return _of_bodies(bodies, start, end, start + fit.middle, fit.half_length, fit.coefficients, fit.error)


@with_quantities(start="s", end="s")
def ephemeris_of(
    states: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]], start: float, end: float,
    masses: Mapping[str, float], tolerance: float = _TOLERANCE_ARCHIVE,
) -> Ephemeris:  # fmt: skip
    """The orbits that a function knows: positions and velocities (T, N, 3) relative to the body at times (T,).

    masses: of the N companions, by their names. ValueError and NumericalError as in `ephemeris`; ValueError where a
    velocity is not the derivative of its position. Checked by tests/unit/rotation/test_ephemeris.py.

    >>> circle = lambda t: np.stack([np.cos(t), np.sin(t), 0 * t], -1)[:, None]
    >>> orbit = ephemeris_of(lambda t: (circle(t), circle(t + np.pi / 2)), 0.0, 20.0, {"moon": 0.01})
    >>> print(orbit.position(np.array([3.0])).round(6))
    [[[-0.989992  0.14112   0.      ]]]
    """
    if not masses:
        raise ValueError("an ephemeris needs a companion")
    if not start < end < math.inf:
        raise ValueError(f"the ephemeris ends at {end:g}, which is no time after its start at {start:g}")
    place, speed = (np.asarray(part, dtype=float) for part in states(np.array([start])))
    shape = (1, len(masses), 3)
    if place.shape != shape or speed.shape != shape:
        raise ValueError(f"states of {shape[1]} companions at one time are {shape}, not {place.shape}, {speed.shape}")
    distance, fast = np.linalg.norm(place, axis=-1), np.linalg.norm(speed, axis=-1)
    if not (np.isfinite(distance) & np.isfinite(fast) & (distance > 0.0)).all():
        raise ValueError("at its start all states must be finite, and no companion where the body is")
    level = math.ceil(math.log2(max(1.0, float(np.max((end - start) * fast / distance)) / _FIRST)))
    known = _Known(states, start, list(masses), tolerance)
    try:
        fit = _adapted(known, end - start, end - start, tolerance, level)
    except NumericalError:
        known.refuse_rounded_times()
        raise
    return _table(
        list(masses), np.array(list(masses.values())), start, end, start + fit.middle, fit.half_length,
        fit.coefficients, fit.error,
    )  # fmt: skip


def archive_ephemeris(
    path: str | Path, end: float, body: str | int | None = None, units: CodeUnits | None = None,
    tolerance: float = _TOLERANCE_ARCHIVE,
) -> Ephemeris:  # fmt: skip
    """The orbits that a REBOUND SimulationArchive holds, relative to a body, from its first snapshot (time 0) to `end`.

    body and units are those of `orbits.rebound_archive.snapshots`. From each snapshot REBOUND goes on to the next;
    there both must meet within the tolerance, over the distance: so forces that the archive does not know are noticed.
    ValueError for what is no such archive, goes back in time or ends before `end`; NumericalError where snapshots do
    not meet. Checked by tests/unit/orbits/test_rebound_archive.py.
    """
    from astroinertia.orbits import rebound_archive, states

    every = rebound_archive.snapshots(path, body, units)
    first, last = every[0], every[-1]
    if first.N < 2:
        raise ValueError("an ephemeris needs a companion")
    if not 0.0 < end <= last.t:
        times = (last.t, end) if units is None else (units.to_si(time, "time") for time in (last.t, end))
        reached, asked = (f"{time:g}" if units is None else f"{time:g} s" for time in times)
        raise ValueError(f"the archive goes from time 0 to {reached} of this run, which does not reach {asked}")
    if any(following.t < now.t for now, following in pairwise(every)):
        raise ValueError("the snapshots of the archive go back in time")
    # A moment may be saved at the end of an interval and by hand: of several of one time, the last.
    stored = [*(now for now, following in pairwise(every) if now.t < following.t), last]
    pieces, starts, worst = [], [], 0.0
    for now, following in pairwise(stored):
        if now.t >= end:
            break
        piece = _segments(now, following.t - now.t, following.t - now.t, _TOLERANCE)
        stood = states.present(following)[0]
        apart = np.max(np.linalg.norm(piece.end - stood, axis=1) / np.linalg.norm(stood, axis=1))
        if not apart <= tolerance:
            raise NumericalError(
                f"the archive's next snapshot is {apart:.1e} of the distance from where gravity alone leads", time=now.t
            )
        pieces.append(piece)
        starts.append(now.t)
        worst = max(worst, piece.error, apart)
    middle = np.concatenate([start + piece.middle for start, piece in zip(starts, pieces, strict=True)])
    half_length, coefficients = (
        np.concatenate([getattr(piece, name) for piece in pieces]) for name in ("half_length", "coefficients")
    )
    return _of_bodies(first, 0.0, end, middle, half_length, coefficients, worst)


class _Known:
    """Orbits of a function of time, as `_adapted` asks for them: see orbits.dense."""

    def __init__(
        self, states: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]], start: float, names: list[str],
        allowed: float,
    ) -> None:  # fmt: skip
        self._states, self._start, self._names, self._allowed = states, start, names, allowed

    def at(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        place, speed = (np.asarray(part, dtype=float) for part in self._states(self._start + times))
        self._refuse_other_velocities(times, place, speed)
        return place, speed

    def leave(self, time: float) -> None:
        self._start += time

    def refuse_rounded_times(self) -> None:
        """NumericalError where a companion now moves by more than is allowed within the last digit of the time."""
        place, speed = (np.linalg.norm(part[0], axis=-1) for part in self._states(np.array([self._start])))
        moved = np.spacing(abs(self._start)) * speed / place
        worst = int(np.argmax(moved))
        if moved[worst] > self._allowed:
            raise NumericalError(
                f"the orbits cannot be tabulated to {self._allowed:.1e} of the distance: within the last digit of a "
                f"time of {self._start:g}, {self._names[worst]} moves by {moved[worst]:.1e} of its own; count time "
                "from nearer"
            ) from None

    def _refuse_other_velocities(self, times: np.ndarray, place: np.ndarray, speed: np.ndarray) -> None:
        """ValueError where velocities are not how the positions change, which no shorter segment would mend.

        That is seen where a polynomial through the positions alone has converged: its last coefficients, times the
        square of their order, bound the error of its slopes. About a close pericentre amid a long segment they do not.
        """
        half_length = 0.5 * (times[-1] - times[0])
        coefficients = np.einsum("km,m...->k...", _THROUGH, place)
        slopes = np.einsum("mk,k...->m...", _SLOPES, coefficients) / half_length
        apart = half_length * np.linalg.norm(speed - slopes, axis=-1)
        size = np.linalg.norm(coefficients, axis=-1)
        last = size[-3:].max(axis=0)
        unsure = np.where(last < _CONVERGED * size[1:].max(axis=0), len(times) ** 2 * last, np.inf)
        certain = apart > np.maximum(_OTHER * self._allowed * np.linalg.norm(place, axis=-1), _SURE * unsure)
        if certain.any():
            at, number = np.unravel_index(np.argmax(np.where(certain, apart, 0.0)), apart.shape)
            given, found = (f"({', '.join(f'{part:.6g}' for part in each[at, number])})" for each in (speed, slopes))
            raise ValueError(
                f"the velocity of {self._names[number]} at {self._start + times[at]:g} is {given}, and its position "
                f"changes by {found} a unit of time there: velocities must be the derivatives of the positions"
            )


class _Segments(NamedTuple):
    """Polynomials from a simulation's time on, the largest error, and the positions (N, 3) at their end."""

    middle: np.ndarray
    half_length: np.ndarray
    coefficients: np.ndarray
    error: float
    end: np.ndarray


def _allowed(bodies: Any, tolerance: float | None) -> float:
    if tolerance is not None:
        return tolerance
    return _TOLERANCE_WHFAST if str(bodies.integrator) == "whfast" else _TOLERANCE


def _segments(bodies: Any, span: float, until: float, allowed: float) -> _Segments:
    """Segments that are parts of a span, as many as it takes to a time."""
    # Only here: what reads an ephemeris does without REBOUND.
    from astroinertia.orbits import states
    from astroinertia.orbits.dense import DenseOrbits

    level = math.ceil(math.log2(max(1.0, span / (_FIRST * states.shortest_time(bodies)))))
    if str(bodies.integrator) == "whfast":
        return _alike(bodies, span, until, allowed, level)
    return _adapted(DenseOrbits(bodies), span, until, allowed, level)


def _alike(bodies: Any, span: float, until: float, allowed: float, level: int) -> _Segments:
    """Segments of one length, for WHFast: a change of its step on the way would not be symplectic."""
    from astroinertia.orbits import states

    for halvings in range(_MOST_HALVINGS + 2):
        length = span / 2 ** (level + halvings)
        if _FINEST_WHFAST * length < bodies.dt:
            raise NumericalError(
                f"WHFast does not follow these orbits: pieces of 1/{_FINEST_WHFAST} of its step of {bodies.dt:.3g} are "
                f"not smooth to {allowed:.1e} of the distance (bodies that meet); take ias15"
            )
        now, worst, parts = bodies.copy(), 0.0, []
        while len(parts) * length < until:
            now.t = 0.0  # of the segment: late times are too coarse for the points
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("error", RuntimeWarning)  # REBOUND's, of steps longer than an orbit
                    met = states.states(now, length * _SHARES)
            except RuntimeWarning as warning:
                raise NumericalError(f"WHFast does not follow these orbits: {warning} So take ias15") from None
            coefficients, error = _fitted(*met, 0.5 * length)
            if not error <= allowed:
                break
            parts.append((len(parts), level + halvings, coefficients))
            worst = max(worst, error)
            _refuse_more(len(parts) * coefficients.nbytes, halvings, error, allowed)
        else:
            return _joined(parts, span, worst, states.present(now)[0])
        _refuse_more(0.0, halvings + 1, error, allowed)
    raise AssertionError  # _refuse_more has raised


def _adapted(orbits: Any, span: float, until: float, allowed: float, first: int) -> _Segments:
    """Segments that are halved and doubled on the way."""
    level = first
    number, worst, parts = 0, 0.0, []
    place = np.empty((1, 0, 3))
    while number * (length := span / 2**level) < until:
        place, speed = orbits.at(length * _SHARES)
        coefficients, error = _fitted(place, speed, 0.5 * length)
        if error <= allowed:
            parts.append((number, level, coefficients))
            number, worst = number + 1, max(worst, error)
            orbits.leave(length)
            if level > 0 and number % 2 == 0 and _error_if_doubled(coefficients) < allowed:
                number, level = number // 2, level - 1
        else:
            number, level = 2 * number, level + 1
        _refuse_more(len(parts) * coefficients.nbytes, level - first, error, allowed)
    return _joined(parts, span, worst, place[-1])


def _joined(parts: list[tuple[int, int, np.ndarray]], span: float, worst: float, end: np.ndarray) -> _Segments:
    half_length = np.array([0.5 * span / 2**level for _, level, _ in parts])
    middle = half_length * [2 * number + 1 for number, _, _ in parts]
    return _Segments(middle, half_length, np.array([coefficients for *_, coefficients in parts]), worst, end)


def _of_bodies(bodies: Any, *fitted: Any) -> Ephemeris:
    from astroinertia.orbits import states

    return _table(states.names(bodies)[1:], states.masses(bodies)[1:], *fitted)


def _table(
    names: list[str], mass: np.ndarray, start: float, end: float, middle: np.ndarray, half_length: np.ndarray,
    coefficients: np.ndarray, error: float,
) -> Ephemeris:  # fmt: skip
    parts = max(1, math.ceil((end - start) / (2.0 * half_length.min()) * (1.0 - 1e-9)))
    _refuse_more(8.0 * parts, 0, error, error)
    opening = start + (end - start) / parts * np.arange(parts)
    return Ephemeris(
        start=np.float64(start),
        end=np.float64(end),
        segment=np.searchsorted((middle + half_length)[:-1], opening, side="right"),
        middle=middle,
        half_length=half_length,
        coefficients=coefficients,
        mass=mass,
        error=np.float64(error),
        names=tuple(names),
    )


def _refuse_more(size: float, halvings: int, error: float, allowed: float) -> None:
    if halvings > _MOST_HALVINGS or not np.isfinite(error):
        raise NumericalError(
            f"the orbits cannot be tabulated to {allowed:.1e} of the distance: even pieces of 1/{2**halvings} of those "
            "that usually suffice are not smooth enough (bodies that meet, or a shortest period far below the others)"
        )
    if size > _MOST_BYTES:
        raise NumericalError(f"the table of the orbits would outgrow {_MOST_BYTES:.0e} bytes: take a shorter time")


def _fitted(position: np.ndarray, velocity: np.ndarray, half_length: float) -> tuple[np.ndarray, float]:
    """Coefficients (18, N, 3) from positions and velocities (17, N, 3), and the error at the points of the check."""
    met = np.concatenate([position[_AT_FIT], half_length * velocity[_AT_FIT]])
    coefficients = np.einsum("km,m...->k...", _FIT, met)
    missed = np.einsum("mk,k...->m...", _CHECK, coefficients) - position[_AT_CHECK]
    distance = np.linalg.norm(position[_AT_CHECK], axis=-1)
    return coefficients, float(np.max(np.linalg.norm(missed, axis=-1) / distance))


def _error_if_doubled(coefficients: np.ndarray) -> float:
    """About what the error would be in a segment twice as long, over the distance.

    The coefficients of orders 6 and 7, and 10 and 11, give the ratio of one order to the next; those of a segment twice
    as long are 2^k as large. The orders beyond, in round-off, are not looked at.
    """
    size = np.linalg.norm(coefficients, axis=-1)
    low, high = size[6:8].max(axis=0) / size[0], size[10:12].max(axis=0) / size[0]
    ratio = np.where(high > _ROUND_OFF, high / np.maximum(low, _ROUND_OFF), 0.0) ** 0.25
    return float(np.max(high * 2.0**11 * (2.0 * ratio) ** (_COEFFICIENTS - 11)))


def _chebyshev(place: Array) -> tuple[Array, Array]:
    """Chebyshev polynomials of orders 0 to 17 at (...,) and their derivatives, each (..., 18)."""
    xp = namespace(place)
    values, slopes = [xp.ones_like(place), place], [xp.zeros_like(place), xp.ones_like(place)]
    for _ in range(_COEFFICIENTS - 2):
        values.append(2.0 * place * values[-1] - values[-2])
        slopes.append(2.0 * (values[-2] + place * slopes[-1]) - slopes[-2])
    return xp.stack(values, axis=-1), xp.stack(slopes, axis=-1)


def _matrices() -> tuple[np.ndarray, ...]:
    """From nine positions and nine velocities to coefficients, (18, 18), and from these to the check, (8, 18).

    Then from seventeen positions to the polynomial through them, (17, 17), and from that to its slopes there.
    """
    values, slopes = _chebyshev(_POINTS.astype(np.longdouble))
    met = np.concatenate([values[_AT_FIT], slopes[_AT_FIT]])
    inverse = np.linalg.inv(met.astype(float)).astype(np.longdouble)
    inverse = inverse @ (2.0 * np.eye(_COEFFICIENTS) - met @ inverse)  # Newton's step: the inverse alone costs 5e-15
    through = np.linalg.inv(values[:, :-1].astype(float))
    return inverse.astype(float), values[_AT_CHECK].astype(float), through, slopes[:, :-1].astype(float)


_FIT, _CHECK, _THROUGH, _SLOPES = _matrices()
