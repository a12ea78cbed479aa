"""The ledger of 3x3 matrices: how a kick and a drift change the moments of a body, and which effect did it.

With positions x and velocities v relative to the centre of mass,

    Q = sum m x (x) x      P = sum m x (x) v      K = sum m v (x) v      V_e = sum m x (x) a_e,

a drift by dt adds dt (P + P^T) + dt^2 K to Q and dt K to P; a kick leaves Q alone, adds sum m x (x) dv_e to P and
changes K by sum m (v' (x) v' - v (x) v). Both statements are exact, so the ledger follows a kick-drift-kick integration
to round-off. Sources: Chandrasekhar (1969), Ellipsoidal Figures of Equilibrium, sections 9-11, for the moments.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from astroinertia.engines.elementwise import totals
from astroinertia.engines.pytree import pytree, with_fields
from astroinertia.inertia.tensor import inertia_from_second_moment, namespace

Array = Any


@pytree
@dataclass(frozen=True)
class Compensated:
    """A sum that carries its own rounding error (Knuth's two-sum): `total` is good to one rounding."""

    value: Array
    carry: Array

    def add(self, increment: Array) -> "Compensated":
        """Add an increment of the same shape."""
        value = self.value + increment
        part = value - self.value
        lost = (self.value - (value - part)) + (increment - part)
        return Compensated(value, self.carry + lost)

    @property
    def total(self) -> Array:
        """The sum."""
        return self.value + self.carry


@pytree
@dataclass(frozen=True)
class Ledger:
    """Moments of a body, integrated beside its particles, and the share of each effect (leading axis E).

    second_moment, mixed_moment, kinetic_tensor: (3, 3), about the centre of mass.
    mixed_impulse (E, 3, 3): what each effect has added to P; impulse (E, 3): to the momentum; work (E,): to the kinetic
    energy; heating (E,): to the internal energy. largest_inertia: the largest norm of I so far.
    """

    second_moment: Compensated
    mixed_moment: Compensated
    kinetic_tensor: Compensated
    mixed_impulse: Compensated
    impulse: Compensated
    work: Compensated
    heating: Compensated
    largest_inertia: Array

    def inertia_tensor(self) -> Array:
        """I = tr(Q) 1 - Q as the ledger has it, (3, 3)."""
        return inertia_from_second_moment(self.second_moment.total)


def weighted_outer(mass: Array, left: Array, right: Array) -> Array:
    """sum_n m_n left_n (x) right_n for (N,), (N, 3), (N, 3): (3, 3)."""
    # Each component lies in one piece of memory, along which numpy adds pairwise: the round-off of a plain sum has the
    # same sign step after step in a body that hardly changes, and grows with the square of the time in the ledger.
    left, right = left.T.copy(), right.T.copy()
    return ((mass * left)[:, None, :] * right[None, :, :]).sum(axis=-1)


def inertia_size(xp: Any, second_moment: Array) -> Array:
    """The norm of I = tr(Q) 1 - Q, a scalar, from Q (3, 3): |I|^2 = tr(Q)^2 + |Q|^2."""
    trace = second_moment[0, 0] + second_moment[1, 1] + second_moment[2, 2]
    return xp.sqrt((second_moment * second_moment).sum() + trace * trace)


def centre_of_mass(mass: Array, vector: Array) -> Array:
    """Mass-weighted mean of (N, 3): (3,)."""
    return (mass @ vector) / mass.sum()


def moments(mass: Array, position: Array, velocity: Array) -> tuple[Array, Array, Array]:
    """Q, P and K of particles about their centre of mass, each (3, 3), by direct summation."""
    position = position - centre_of_mass(mass, position)
    velocity = velocity - centre_of_mass(mass, velocity)
    return (
        weighted_outer(mass, position, position),
        weighted_outer(mass, position, velocity),
        weighted_outer(mass, velocity, velocity),
    )


def open_ledger(xp: Any, mass: Array, position: Array, velocity: Array, effects: int) -> Ledger:
    """The ledger of a body at the start, with nothing yet entered for any of `effects` effects."""
    second, mixed, kinetic = moments(mass, position, velocity)

    def empty(*shape: int) -> Compensated:
        return Compensated(xp.zeros(shape), xp.zeros(shape))

    return Ledger(
        *(Compensated(tensor, xp.zeros((3, 3))) for tensor in (second, mixed, kinetic)),
        mixed_impulse=empty(effects, 3, 3),
        impulse=empty(effects, 3),
        work=empty(effects),
        heating=empty(effects),
        largest_inertia=inertia_size(xp, second),
    )


def after_drift(xp: Any, ledger: Ledger, dt: Array) -> Ledger:
    """The ledger after free motion over dt: Q += dt (P + P^T) + dt^2 K, P += dt K."""
    mixed, kinetic = ledger.mixed_moment, ledger.kinetic_tensor.total
    # In a steady rotation P + P^T is the small rest of large numbers: their carries count.
    spreading = (mixed.value + mixed.value.T) + (mixed.carry + mixed.carry.T)
    second_moment = ledger.second_moment.add(dt * spreading + dt**2 * kinetic)
    size = inertia_size(xp, second_moment.total)
    return with_fields(
        ledger,
        second_moment=second_moment,
        mixed_moment=ledger.mixed_moment.add(dt * kinetic),
        largest_inertia=xp.maximum(ledger.largest_inertia, size),
    )


class Whole(NamedTuple):
    """Mass of a body (a scalar), and place and velocity of its centre of mass, (3,)."""

    mass: Array
    centre: Array
    velocity: Array


def weighted(xp, mass, position, velocity):
    """m, m x and m v."""
    x, v = position, velocity
    return mass, (mass * x[0], mass * x[1], mass * x[2]), (mass * v[0], mass * v[1], mass * v[2])


def whole(xp: Any, mass: Array, position: Array, velocity: Array) -> Whole:
    """The mass and the centre of mass of particles (N,), (N, 3), (N, 3)."""
    total, place, momentum = (cases[0] for cases in totals(xp, weighted, mass, position, velocity))
    return Whole(total, place / total, momentum / total)


def outer(xp, a, b):
    """a (x) b."""
    return (
        (a[0] * b[0], a[0] * b[1], a[0] * b[2]),
        (a[1] * b[0], a[1] * b[1], a[1] * b[2]),
        (a[2] * b[0], a[2] * b[1], a[2] * b[2]),
    )


def entry(xp, mass, position, before, after, dt, x, y, z, vx, vy, vz, acceleration):
    """What dv = a dt of one particle adds: to P and the momentum, about a centre x, and its work at velocities - v."""
    push = (dt * mass * acceleration[0], dt * mass * acceleration[1], dt * mass * acceleration[2])
    work = (
        (0.5 * (before[0] + after[0]) - vx) * push[0]
        + (0.5 * (before[1] + after[1]) - vy) * push[1]
        + (0.5 * (before[2] + after[2]) - vz) * push[2]
    )
    return outer(xp, (position[0] - x, position[1] - y, position[2] - z), push), push, work


def gained(xp, mass, position, before, after, x, y, z, vx, vy, vz):
    """What one particle's velocity changes that became another: P and the momentum; its part of K before and after."""
    push = (mass * (after[0] - before[0]), mass * (after[1] - before[1]), mass * (after[2] - before[2]))
    old, new = (before[0] - vx, before[1] - vy, before[2] - vz), (after[0] - vx, after[1] - vy, after[2] - vz)
    middle = (0.5 * (old[0] + new[0]), 0.5 * (old[1] + new[1]), 0.5 * (old[2] + new[2]))
    weighted_new = (mass * new[0], mass * new[1], mass * new[2])
    return (
        outer(xp, (position[0] - x, position[1] - y, position[2] - z), push),
        push,
        outer(xp, middle, push),
        outer(xp, new, weighted_new),
    )


def after_kick(
    xp: Any, ledger: Ledger, mass: Array, position: Array, before: Array, after: Array,
    increments: Sequence[Array | None], dt: Array | float = 1.0, body: Whole | None = None,
    complete: bool = True,
) -> Ledger:  # fmt: skip
    """The ledger after velocities changed from `before` to `after` (N, 3), by dt times the increment of each effect.

    The increments (one (N, 3) for each effect, or None) times dt add up to after - before; work_e = sum m dv_e .
    (before + after)/2 then adds up exactly to the change of the kinetic energy. body: the whole body before the kick;
    complete: whether these are all of its particles.

    P and K are those of the velocities that came out, rounding and all: what rounding adds to K would grow with the
    square of the time in Q. For the same reason K is summed again where all particles are at hand.
    Tests: tests/unit/ledger/test_moments.py.
    """
    body = whole(xp, mass, position, before) if body is None else body
    pushes = [(increment,) for increment in increments if increment is not None]
    if not pushes:
        return ledger
    about = (*body.centre, *body.velocity)
    mixed, impulse, work = totals(xp, entry, mass, position, before, after, dt, *about, cases=pushes)
    gain, push, half, now = (cases[0] for cases in totals(xp, gained, mass, position, before, after, *about))
    # K is about the centre of mass, which moves faster or slower now.
    shift = push[:, None] * push[None, :] / body.mass
    kinetic = (
        Compensated(now - shift, xp.zeros((3, 3))) if complete else ledger.kinetic_tensor.add(half + half.T - shift)
    )
    rows = [increment is not None for increment in increments]
    return with_fields(
        ledger,
        mixed_moment=ledger.mixed_moment.add(gain),
        kinetic_tensor=kinetic,
        mixed_impulse=ledger.mixed_impulse.add(_in_rows(xp, mixed, rows)),
        impulse=ledger.impulse.add(_in_rows(xp, impulse, rows)),
        work=ledger.work.add(_in_rows(xp, work + impulse @ body.velocity, rows)),
    )


def misplaced(xp, mass, before, after, velocity, dt):
    """m, m x, m v of one particle and, with r = x' - x - dt v the rounding of its place, m r, x' (x) m r, m r (x) v."""
    error = (
        mass * ((after[0] - before[0]) - dt * velocity[0]),
        mass * ((after[1] - before[1]) - dt * velocity[1]),
        mass * ((after[2] - before[2]) - dt * velocity[2]),
    )
    return *weighted(xp, mass, after, velocity), error, outer(xp, after, error), outer(xp, error, velocity)


def after_rounding(
    xp: Any, ledger: Ledger, mass: Array, before: Array, after: Array, velocity: Array, dt: Array,
    body: Whole | None = None,
) -> Ledger:  # fmt: skip
    """The ledger, drifted by dt, with what rounding did to places that went from `before` to `after` (N, 3).

    A drift moves the body by dt v; particles end at the numbers next to that. body: the whole of it afterwards, where
    the particles given are not all. Tests: tests/unit/ledger/test_moments.py.
    """
    sums = totals(xp, misplaced, mass, before, after, velocity, dt)
    total, place, momentum, error, second, mixed = (cases[0] for cases in sums)
    if body is None:
        total = xp.where(total > 0.0, total, 1.0)
        body = Whole(total, place / total, momentum / total)
    second = second - xp.asarray(body.centre)[:, None] * error[None, :]
    mixed = mixed - error[:, None] * xp.asarray(body.velocity)[None, :]
    return with_fields(
        ledger, second_moment=ledger.second_moment.add(second + second.T), mixed_moment=ledger.mixed_moment.add(mixed)
    )


def _in_rows(xp: Any, values: Array, rows: Sequence[bool]) -> Array:
    """What was found for some effects, in the rows of all; zero in the others."""
    if all(rows):
        return values
    following = iter(values)
    return xp.stack([next(following) if present else xp.zeros(values.shape[1:]) for present in rows])


@pytree
@dataclass(frozen=True)
class Removed:
    """What a body has lost with matter that was taken from it: mass (), momentum (3,), and of Q, P and K, (3, 3)."""

    mass: Array
    momentum: Array
    second_moment: Array
    mixed_moment: Array
    kinetic_tensor: Array

    def __add__(self, other: "Removed") -> "Removed":
        return Removed(*(getattr(self, name) + getattr(other, name) for name in Removed.__dataclass_fields__))


def removed(body: Whole, mass: Array, position: Array, velocity: Array) -> Removed:
    """What a body loses with particles (n,), (n, 3), (n, 3), whatever becomes of them.

    sum m x (x) x of Q about the old centre of mass, and M' d (x) d for what is left, of mass M', whose centre of mass
    is at d = -sum m x/M' from there, at a velocity u = -sum m v/M'; so too of P and K.
    Tests: tests/unit/ledger/test_moments.py.
    """
    x, v = position - body.centre, velocity - body.velocity
    left = body.mass - mass.sum()
    d, u = -(mass @ x) / left, -(mass @ v) / left

    def of(one: Array, other: Array, shift: Array, pace: Array) -> Array:
        return weighted_outer(mass, one, other) + left * shift[:, None] * pace[None, :]

    return Removed(mass.sum(), mass @ velocity, of(x, x, d, d), of(x, v, d, u), of(v, v, u, u))


def after_removal(ledger: Ledger, lost: Removed, row: int, work: Array, heating: Array) -> Ledger:
    """The ledger after the effect of a row took matter away, of kinetic energy -work and internal energy -heating."""

    def entered(kept: Compensated, value: Array) -> Compensated:
        rows = [value if number == row else 0.0 * value for number in range(len(kept.value))]
        return kept.add(namespace(kept.value).stack(rows))

    return with_fields(
        ledger,
        second_moment=ledger.second_moment.add(-lost.second_moment),
        mixed_moment=ledger.mixed_moment.add(-lost.mixed_moment),
        kinetic_tensor=ledger.kinetic_tensor.add(-lost.kinetic_tensor),
        mixed_impulse=entered(ledger.mixed_impulse, -lost.mixed_moment),
        impulse=entered(ledger.impulse, -lost.momentum),
        work=entered(ledger.work, work),
        heating=entered(ledger.heating, heating),
    )


def after_heating(ledger: Ledger, energy: Array) -> Ledger:
    """The ledger after each effect added `energy` (E,) to the internal energy."""
    return with_fields(ledger, heating=ledger.heating.add(energy))


@dataclass(frozen=True)
class Ledgers:
    """The ledger of a body, and those of its regions, which take in the same kicks and drifts.

    regions: {name: ledger.regions.RegionLedger}; members: {region: 1 for members, 0 for the others, (n,)} of the
    particles that are kicked or drift.
    """

    body: Ledger
    regions: dict[str, Any]

    def drifted(self, xp: Any, dt: Array) -> "Ledgers":
        """After free motion over dt."""
        regions = {name: region.drifted(xp, dt) for name, region in self.regions.items()}
        return Ledgers(after_drift(xp, self.body, dt), regions)

    def rounded(
        self, xp: Any, mass: Array, members: dict[str, Array], before: Array, after: Array, velocity: Array, dt: Array,
        whole: Whole | None,
    ) -> "Ledgers":  # fmt: skip
        """Drifted by dt, with what rounding did to places: after_rounding."""
        ways = before, after, velocity, dt
        regions = {name: region.rounded(xp, mass * members[name], *ways) for name, region in self.regions.items()}
        return Ledgers(after_rounding(xp, self.body, mass, *ways, whole), regions)

    def kicked(
        self, xp: Any, mass: Array, members: dict[str, Array], position: Array, before: Array, after: Array,
        increments: Sequence[Array | None], length: Array | float, whole: Whole | None,
    ) -> "Ledgers":  # fmt: skip
        """After a kick: after_kick; whole: the body before it, where these are not all particles."""
        changes, complete = (position, before, after, increments, length), whole is None
        regions = {
            name: region.kicked(xp, mass * members[name], *changes, complete) for name, region in self.regions.items()
        }
        return Ledgers(after_kick(xp, self.body, mass, *changes, whole, complete), regions)

    def heated(self, energy: Array) -> "Ledgers":
        """After each effect added `energy` (E,) to the internal energy of the body."""
        return Ledgers(after_heating(self.body, energy), self.regions)
