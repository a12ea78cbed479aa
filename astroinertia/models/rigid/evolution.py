"""A rigid body as the run loop sees it: by the splitting or adaptively, from one break of its torques to the next."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.engines import adaptive
from astroinertia.errors import NumericalError
from astroinertia.models import checkpoint
from astroinertia.models.protocol import Figures, Record
from astroinertia.models.rigid import body as rigid, passage, splitting, two_way
from astroinertia.models.rigid.body import Rigid
from astroinertia.models.rigid.passage import AT_ONCE, Course, Met, filled
from astroinertia.models.rigid.record import RIGIDITY, Ledger, dissipates, ledgers
from astroinertia.models.rigid.splitting import Rotor, in_body
from astroinertia.observables.quantities import BodyState, row
from astroinertia.rotation.ephemeris import Ephemeris

Array = Any

EXACT = "exact for a body that keeps its shape, or changes its size as prescribed"

SHORTEST = 1e-12  # of a stretch between two breaks, as a share of the time
FAR_TOO_MANY = (
    f"{adaptive.MOST_STEPS:.0e} steps of the adaptive integrator do not reach the next record: "
    "record more often, take the integrator splitting, or the model scaling if only the rate counts"
)
_UNIT = 1e-6  # from 1, the length of a quaternion that is an attitude but for round-off
_ATTITUDE = slice(1, 5)  # of what a branch began with: time, attitude, L in the principal axes
_BY_SIZE = 2  # sums that a change of size needs: the energy at size 1, and its own work


@dataclass(frozen=True)
class Settings:
    """How the motion is integrated."""

    integrator: str = "splitting"
    tolerance: float = 1e-12
    steps_per_rotation: float = 40.0
    order: int = 8


class RigidBody:
    """A rigid body under way (models.protocol.Evolution), from a quaternion (4,) and L in its principal axes (3,).

    companions: names of those that it acts on. further: the whole of known orbits, where those of the body end before
    the run does: asked for when it comes there.
    Runs under jax.enable_x64. Checked by tests/unit/models/rigid/test_evolution.py.
    """

    absent: ClassVar[Mapping[str, str]] = {}
    approximation: ClassVar[str] = EXACT
    meets_times: ClassVar[bool] = True
    resumable: ClassVar[bool] = True

    def __init__(
        self, body: Rigid, quaternion: Array, momentum: Array, settings: Settings, companions: Sequence[str] = (),
        further: Callable[[], Ephemeris] | None = None,
    ) -> None:  # fmt: skip
        if isinstance(body.companions, two_way.Companions):
            several = settings.steps_per_rotation < two_way.STEPS_PER_TURN
            body = replace(body, companions=replace(body.companions, substeps=1 if several else None))
        self.body, self.settings, self.companions, self._further = body, settings, companions, further
        self.effects = (*(effect.kind for effect in body.effects), RIGIDITY)
        self._begun: np.ndarray | None = None  # of a branch, the time, attitude and L that it began with
        self._start(0.0, quaternion, momentum)
        self.units = self._units_of_errors()

    def begin(self, other: Self) -> None:
        """Be where another body of the same shape is; what effects do is counted from there."""
        self._start_at(np.concatenate([[other.time], np.asarray(other.state.turning.total)]))

    def _start_at(self, begun: np.ndarray) -> None:
        self._begun = begun
        self._start(float(begun[0]), begun[1:5], begun[5:])

    def _start(self, time: float, quaternion: Array, momentum: Array) -> None:
        self._reach(time)
        body = self.body
        sized = _BY_SIZE if body.change is not None else 0
        self.state = splitting.rotor(quaternion, momentum, np.zeros(sized + len(body.effects)))
        if self.acts_back:
            self.state = replace(self.state, orbits=filled(jnp.asarray(body.companions.orbits)))
        self._time, self._steps, self._timestep, self._pace = time, 0, 0.0, 0.0
        self._way, self._refusal = adaptive.Way(), None
        if sized:
            at, m = jnp.asarray(time), self.state.momentum_in_body
            energy = rigid.rotational_energy(body, at, m) * rigid.size(body, at)
            self.state = replace(self.state, sums=filled(self.state.sums.value.at[0].set(energy)))
        opening = self._ledgers(self._present())
        kinetic, potential = self._energies(opening)
        self._opening = {
            "energy": kinetic[0],
            "total_energy": kinetic[0] + potential[0],
            "swelling": kinetic[0] - opening.spin_energy[0],
            "potentials": opening.potential[0],
            "velocity": opening.moments.velocity[0],
        }

    @property
    def acts_back(self) -> bool:
        """Whether the body acts on its companions."""
        return isinstance(self.body.companions, two_way.Companions)

    @property
    def time(self) -> float:
        """Now."""
        return self._time

    @property
    def steps(self) -> int:
        """Time steps since the start; those that the adaptive integrator tried in vain are counted too."""
        return self._steps

    def advance(self, until: float, most: float = math.inf) -> None:
        """Go to a time, meeting every break of the torques on the way, or as far towards it as so many steps go."""
        begun = self._steps
        for stop in sorted({until, *self.breaks(until)}):
            start, body = self._time, self.during(stop)
            if stop - start > SHORTEST * abs(stop):  # else two times that are meant to be the same
                met = self._go(body, [stop], most)
                if not len(met.time):
                    return
            else:
                self._time = stop
            for number, effect in enumerate(body.effects):
                if stop in effect.breaks(start, stop):
                    self.strike(number, effect)
            if self._steps > begun + passage.STEPS_AT_ONCE or self._steps >= most:
                return

    def through(
        self, times: Sequence[float] | np.ndarray, opening_potential: float | None, most: float
    ) -> list[Record]:
        """Go through output times, up to the next break of the torques, and give the record of each that was met."""
        times = np.asarray(times, dtype=float)[:AT_ONCE]
        times = times[times < min(self.breaks(times[-1]), default=math.inf)]
        if not len(times) or times[0] - self._time <= SHORTEST * abs(times[0]):
            return []
        times = times[: max(1, int((times <= self._known_until).sum()))]  # those to which orbits are known already
        return self._records(self._go(self.during(times[-1]), times, most))

    def record(self, opening_potential: float | None) -> Record:
        """One row of the headline series."""
        return self._records(self._present())[0]

    look = record

    def snapshot(self) -> None:
        """Nothing: there are no particles."""

    def arrays(self) -> dict[str, np.ndarray]:
        """The state, for a checkpoint."""
        leaves = jax.tree.leaves(self.state)
        numbers = {"time": self._time, "steps": self._steps, "timestep": self._timestep, "pace": self._pace}
        return {
            **{f"state_{number}": np.asarray(leaf) for number, leaf in enumerate(leaves)},
            **{name: np.asarray(value) for name, value in numbers.items()},
            **({} if self._begun is None else {"begun": self._begun}),
        }

    def resume(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from a checkpoint, bit for bit as if the run had never stopped; ValueError where it is of another body.

        Tests: tests/unit/models/test_checkpoint.py.
        """
        if "begun" in arrays:
            checkpoint.check(arrays, {"begun": (np.dtype(float), (_ATTITUDE.stop + 3,))}, {})
            _check_attitude(arrays, "begun", _ATTITUDE)
            self._start_at(arrays["begun"])
        limits = dict.fromkeys(("time", "timestep", "pace"), checkpoint.SIZE) | {"steps": checkpoint.COUNT}
        checkpoint.check(arrays, checkpoint.described(RigidBody.arrays(self)), limits)
        _check_attitude(arrays, "state_0", slice(0, 4))
        leaves, structure = jax.tree.flatten(self.state)
        self.state = jax.tree.unflatten(structure, [jnp.asarray(arrays[f"state_{k}"]) for k in range(len(leaves))])
        self._time, self._steps = float(arrays["time"]), int(arrays["steps"])
        self._timestep, self._pace = float(arrays["timestep"]), float(arrays["pace"])
        self._reach(self._time)

    def figures(self) -> Figures:
        """What the progress line shows."""
        record = self.record(0.0)
        scale = max(record["kinetic_energy"], abs(record["potential_energy"]), 1e-300)
        total = self._opening["total_energy"] + record["integration_energy_error"]
        return Figures(float(total), scale, math.nan, math.nan)

    def moved(self, state: Rotor, time: float, steps: int = 0, timestep: float | None = None) -> None:
        """Be in a state that an integration has come to after so many steps more, of that mean length."""
        self.state, self._time, self._steps = state, time, self._steps + steps
        self._timestep = self._timestep if timestep is None else timestep

    def breaks(self, until: float) -> set[float]:
        """Times from now on, up to one, at which a torque begins or ends, an impulse comes, or a change bends."""
        breaks = {time for effect in self.body.effects for time in effect.breaks(self._time, until)}
        if self.body.change is not None:  # whose curve has a bend at each of its points
            breaks |= {float(time) for time in self.body.change.times if self._time < time <= until}
        return breaks

    def during(self, stop: float) -> Rigid:
        """The body as it is from now to a time, with no break in between."""
        self._reach(stop)
        return replace(
            self.body, effects=tuple(effect.during(self._time, stop) for effect in self.body.effects)
        )  # fmt: skip

    @property
    def _known_until(self) -> float:
        """The time to which orbits are known without asking for more of them."""
        return math.inf if self._further is None else float(self.body.companions.end)

    def _reach(self, time: float) -> None:
        """Have known orbits that lead to a time."""
        if self._further is not None and time > self._known_until:
            self.body, self._further = replace(self.body, companions=self._further()), None

    def _go(self, body: Rigid, times: Sequence[float] | np.ndarray, most: float) -> Met:
        """Go through times and give the states at those that were met; NumericalError where it cannot go on."""
        if self._refusal is not None:
            raise self._refusal
        begun, chosen = self._time, self.settings
        padded = np.full(AT_ONCE, times[-1])
        padded[: len(times)] = times
        passed = passage.passage(
            body, self.units, self.course(), padded, len(times), int(min(most, passage.MOST_STEPS)), chosen.tolerance,
            chosen.steps_per_rotation, chosen.integrator, chosen.order,
        )  # fmt: skip
        number, trouble = int(passed.number), int(passed.trouble)
        self.state = passed.course.state
        self._time, self._pace, self._timestep = (float(value) for value in passed.course[1:4])
        self._steps = int(passed.course.steps)
        met = jax.tree.map(lambda rows: np.asarray(rows)[:number], passed.met)
        if number:
            begun, self._way = float(met.time[-1]), adaptive.Way()
        if trouble == passage.UNFINISHED:
            on = passed.course
            ended = map(jnp.asarray, (False, True, True))
            part = adaptive.Advanced(on.state, on.time, on.timestep, passed.since, *ended)
            if not self._way.goes_on(begun, part, float(times[number])):
                self._refusal = NumericalError(FAR_TOO_MANY, time=self._time)
        elif trouble >= passage.WITHIN:
            name = self.companions[trouble - passage.WITHIN]
            text = f"companion {name} comes within the rigid body, less than its radius from its centre: end it before"
            self._refusal = NumericalError(text, time=float(passed.figure))
        elif trouble:
            figure = float(passed.figure)
            self._refusal = {
                passage.NOT_FINITE: NumericalError("the attitude is no longer finite", time=figure),
                passage.TOO_FAST: too_fast(figure, self._time),
                passage.STUCK: NumericalError("the adaptive integrator does not come on", time=figure),
            }[trouble]
        if self._refusal is not None and not number:
            raise self._refusal
        return met

    def course(self) -> Course:
        """Where it is on its way."""
        time, pace, timestep = map(np.float64, (self._time, self._pace, self._timestep))
        return Course(self.state, time, pace, timestep, np.int64(self._steps))

    def _present(self) -> Met:
        """The present state, as the only one."""
        return jax.tree.map(lambda value: np.asarray(value)[None], passage.state_met(self.course()))

    def _records(self, met: Met) -> list[Record]:
        """Rows of the headline series, one of each state."""
        if not len(met.time):
            return []
        ledger, count = self._ledgers(met), len(met.time)
        moments, work = ledger.moments, self._work(met, ledger)
        energy, potential = self._energies(ledger)
        mass = float(self.body.mass)
        pushed = np.array([effect.kind == "pivot" for effect in self.body.effects] + [False])
        heats = np.array([*map(dissipates, self.body.effects), False])
        heat = -work[:, heats].sum(axis=-1)
        unexplained = energy - self._opening["energy"] - work.sum(axis=-1)
        for number, effect in enumerate(self.body.effects):
            if effect.conservative:
                unexplained += work[:, number] + ledger.potential[:, number] - self._opening["potentials"][number]
        gained = (moments.velocity - self._opening["velocity"])[:, None]
        unknown = np.full(count, np.nan)
        made: Any = BodyState  # of columns here, one number a state
        states = made(
            time=met.time, step=met.steps, mass=np.full(count, mass), centre_of_mass=moments.place,
            momentum=mass * moments.velocity, second_moment=moments.second, mixed_moment=moments.mixed,
            kinetic_tensor=moments.kinetic, virial_tensor=ledger.virial, force=ledger.force,
            impulse=mass * pushed[:, None] * gained, work=work, heating=np.where(heats, -work, 0.0),
            kinetic_energy=energy, internal_energy=heat if heats.any() else unknown, gravitational_energy=unknown,
            potential_energy=potential, total_energy=energy + potential + heat, integration_energy_error=unexplained,
        )  # fmt: skip
        columns = row(states, attitude=ledger.attitude, timestep=met.timestep) | self._orbits(met)
        if met.orbits is not None:
            momentum, of_orbits = two_way.totals(mass, self.body.companions.mass, met.orbits)
            columns["system_angular_momentum"] = momentum + met.momentum
            columns["system_energy"] = of_orbits + energy + potential
        rows = zip(*(column.tolist() if column.ndim == 1 else column for column in columns.values()), strict=True)
        return [dict(zip(columns, values, strict=True)) for values in rows]

    def _orbits(self, met: Met) -> dict[str, np.ndarray]:
        """Companions relative to the body in some states, and the orbit of each about it as of two points."""
        companions, body, times = self.body.companions, float(self.body.mass), met.time
        if companions is None:
            return {}
        mass = np.asarray(companions.mass)
        if met.orbits is not None:
            place, speed = np.moveaxis(met.orbits, 1, 0)
        else:
            place, speed = (
                np.broadcast_to(known(times), (len(times), len(mass), 3))
                for known in (companions.position, companions.velocity)
            )
        reduced = mass * body / (mass + body)
        return {
            "companion_position": place,
            "companion_velocity": speed,
            "companion_angular_momentum": reduced[:, None] * np.cross(place, speed),
            "companion_energy": 0.5 * reduced * (speed**2).sum(axis=-1) - mass * body / np.linalg.norm(place, axis=-1),
        }

    def strike(self, number: int, effect: Any) -> None:
        """An impulse of an effect: L jumps, and with it the energy at size 1 and the effect's work."""
        state, time = self.state, jnp.asarray(self._time)
        body = rigid.accompanied(self.body, None if state.orbits is None else state.orbits.value)
        m, momentum = state.momentum_in_body, state.angular_momentum.value
        blow = effect.impulse(rigid.view(body, time, state.quaternion, m))
        if blow is None:
            return
        before = rigid.rotational_energy(body, time, m)
        m = m + in_body(state.quaternion, blow)
        work = rigid.rotational_energy(body, time, m) - before
        sums, sized = jnp.asarray(state.sums.value), len(state.sums.value) - len(body.effects)
        sums = sums.at[sized + number].add(work)
        if sized:
            sums = sums.at[0].add(work * rigid.size(body, time))
        turning = jnp.concatenate([state.quaternion, m])
        self.state = Rotor(filled(turning), filled(momentum + blow), filled(sums), state.orbits)

    def _ledgers(self, met: Met) -> Ledger:
        """Of each state, as numpy arrays."""
        padded = [None if rows is None else np.concatenate([rows, np.zeros((AT_ONCE - len(rows), *rows.shape[1:]))])
                  for rows in (met.time, met.turning, met.orbits)]  # fmt: skip
        return jax.tree.map(lambda rows: np.asarray(rows)[: len(met.time)], ledgers(self.body, *padded, len(met.time)))

    def _energies(self, ledger: Ledger) -> tuple[np.ndarray, np.ndarray]:
        """Kinetic, of all motion, and potential, of each state."""
        motion = (ledger.moments.velocity**2).sum(axis=-1)
        kinetic = 0.5 * (np.trace(ledger.moments.kinetic, axis1=1, axis2=2) + float(self.body.mass) * motion)
        return kinetic, np.where(np.isfinite(ledger.potential), ledger.potential, 0.0).sum(axis=-1)

    def _work(self, met: Met, ledger: Ledger) -> np.ndarray:
        """What each effect, and rigidity, has done to the kinetic energy until each state."""
        sums = met.sums
        work = sums[:, sums.shape[1] - len(self.body.effects) :].copy()
        for number, effect in enumerate(self.body.effects):
            if hasattr(effect, "deformability"):
                work[:, number] = self._opening["potentials"][number] - ledger.potential[:, number]
        by_size = np.zeros(len(met.time))
        if self.body.change is not None:
            # What it does to the spin is summed up; its own motion is that of the prescribed size.
            by_size = sums[:, 1] + self._energies(ledger)[0] - ledger.spin_energy - self._opening["swelling"]
        return np.concatenate([work, by_size[:, None]], axis=1)

    def _units_of_errors(self) -> tuple[float, np.ndarray, float, np.ndarray | None]:
        """Of L, m, energy and orbits for the adaptive integrator: of the start, or of the pace that torques bring."""
        momentum = float(np.linalg.norm(self.state.angular_momentum.value))
        moment = float(np.max(self.body.moments))
        if momentum == 0.0:
            pace = float(passage.present_pace(self.body, self.course(), 0.0))
            momentum = moment * (pace or 1.0)
        shares = np.where(self.body.moments > 0.0, self.body.moments / moment, 1.0)
        orbits = two_way.unit_of_orbits(self.body.mass, self.body.companions) if self.acts_back else None
        return momentum, momentum * shares, momentum**2 / moment, orbits


def _check_attitude(arrays: Mapping[str, np.ndarray], name: str, place: slice) -> None:
    if abs(np.linalg.norm(arrays[name][place]) - 1.0) > _UNIT:
        raise ValueError(f"{name!r} has an attitude that is no rotation")


def too_fast(steps: float, time: float) -> NumericalError:
    """That so many steps were needed."""
    return NumericalError(f"the body turns so fast that {steps:.1e} steps were needed", time=time)
