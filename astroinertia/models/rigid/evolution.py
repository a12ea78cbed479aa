"""A rigid body as the run loop sees it: by the splitting or adaptively, from one break of its torques to the next."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.errors import NumericalError
from astroinertia.integrate import adaptive, rigid_splitting
from astroinertia.integrate.rigid_splitting import Rotor, in_body
from astroinertia.ledger.moments import Compensated
from astroinertia.models import checkpoint
from astroinertia.models.protocol import Figures, Record
from astroinertia.models.rigid import body as rigid
from astroinertia.models.rigid.body import Rigid
from astroinertia.models.rigid.record import RIGIDITY, Ledger, dissipates, ledger
from astroinertia.observables.quantities import BodyState, row

Array = Any

EXACT = "exact for a body that keeps its shape, or changes its size as prescribed"

# Steps of the splitting between two looks at how fast the body turns, and the factor by which that may change before
# they take another length: within it they stay alike, as a symplectic method wants them.
_STEPS_BETWEEN_LOOKS = 4096
_STEPS_AT_ONCE = 2**17  # of the splitting, after which the run looks at the clock and at what signals ask for
_ADAPTIVE_AT_ONCE = 2**16  # of the adaptive integrator
_CHANGE_OF_PACE = 1.25
_SIZES_LOOKED_AT = 65  # between now and the next break, for the smallest
_FIRST_STEP = 0.05  # of the adaptive integrator, over one radian of the fastest turn
_MOST_STEPS = 1e12
_SHORTEST = 1e-12  # of a stretch between two breaks, as a share of the time
_MISALIGNED = 0.1  # up to which errors of the adaptive integrator in |m| and the direction of L are put right
_UNIT = 1e-6  # from 1, the length of a quaternion that is an attitude but for round-off
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

    Runs under jax.enable_x64. Checked by tests/unit/models/rigid/test_evolution.py.
    """

    absent: ClassVar[Mapping[str, str]] = {}
    approximation: ClassVar[str] = EXACT
    meets_times: ClassVar[bool] = True
    resumable: ClassVar[bool] = True

    def __init__(self, body: Rigid, quaternion: Array, momentum: Array, settings: Settings) -> None:
        self.body, self.settings = body, settings
        self.effects = (*(effect.kind for effect in body.effects), RIGIDITY)
        sized = _BY_SIZE if body.change is not None else 0
        self.state = rigid_splitting.rotor(quaternion, momentum, np.zeros(sized + len(body.effects)))
        self._time, self._steps, self._timestep, self._pace = 0.0, 0, 0.0, 0.0
        self._way = adaptive.Way()
        if sized:
            energy = rigid.rotational_energy(body, jnp.zeros(()), self.state.momentum_in_body)
            self.state = replace(self.state, sums=_filled(self.state.sums.value.at[0].set(energy)))
        opening = self._ledger()
        self._opening = {
            "energies": np.array(self._energies(opening)),
            "swelling": self._energies(opening)[0] - float(opening.spin_energy),
            "potentials": np.asarray(opening.potential),
            "velocity": np.asarray(opening.moments.velocity),
        }
        self._units = self._units_of_errors()

    @property
    def time(self) -> float:
        """Now."""
        return self._time

    @property
    def steps(self) -> int:
        """Time steps since the start; those that the adaptive integrator tried in vain are counted too."""
        return self._steps

    def advance(self, until: float) -> None:
        """Go to a time, meeting every break of the torques on the way, or as far towards it as so many steps go."""
        begun = self._steps
        breaks = {time for effect in self.body.effects for time in effect.breaks(self._time, until)}
        if self.body.change is not None:  # whose curve has a bend at each of its points
            breaks |= {float(time) for time in self.body.change.times if self._time < time <= until}
        for stop in sorted({until, *breaks}):
            start, body = self._time, self.body
            body = replace(body, effects=tuple(effect.during(start, stop) for effect in body.effects))
            if stop - start > _SHORTEST * abs(stop):  # else two times that are meant to be the same
                (self._split if self.settings.integrator == "splitting" else self._adapt)(body, stop)
                paused = self._time < stop
            else:
                self._time, paused = stop, False
            if not np.isfinite(np.asarray(self.state.turning.value)).all():
                raise NumericalError("the attitude is no longer finite", time=self._time)
            if paused:
                return
            for number, effect in enumerate(body.effects):
                if stop in effect.breaks(start, stop):
                    self._strike(number, effect)
            if self._steps - begun >= _STEPS_AT_ONCE:
                return

    def record(self, opening_potential: float | None) -> Record:
        """One row of the headline series."""
        ledger = self._ledger()
        moments, work = ledger.moments, self._work(ledger)
        energy, potential = self._energies(ledger)
        mass = float(self.body.mass)
        velocity = np.asarray(moments.velocity)
        pushed = np.array([effect.kind == "pivot" for effect in self.body.effects] + [False])
        heats = np.array([*map(dissipates, self.body.effects), False])
        heat = -work[heats].sum()
        unexplained = energy - self._opening["energies"][0] - work.sum()
        for number, effect in enumerate(self.body.effects):
            if effect.conservative:
                unexplained += work[number] + float(ledger.potential[number]) - self._opening["potentials"][number]
        state = BodyState(
            time=self._time, step=self._steps, mass=mass, centre_of_mass=np.asarray(moments.place),
            momentum=mass * velocity, second_moment=np.asarray(moments.second), mixed_moment=np.asarray(moments.mixed),
            kinetic_tensor=np.asarray(moments.kinetic), virial_tensor=np.asarray(ledger.virial),
            force=np.asarray(ledger.force), impulse=mass * np.outer(pushed, velocity - self._opening["velocity"]),
            work=work, heating=np.where(heats, -work, 0.0), kinetic_energy=energy,
            internal_energy=heat if heats.any() else np.nan, gravitational_energy=np.nan, potential_energy=potential,
            total_energy=energy + potential + heat, integration_energy_error=unexplained,
        )  # fmt: skip
        return row(state, attitude=np.asarray(ledger.attitude), timestep=self._timestep)

    def snapshot(self) -> None:
        """Nothing: there are no particles."""

    def arrays(self) -> dict[str, np.ndarray]:
        """The state, for a checkpoint."""
        leaves = jax.tree.leaves(self.state)
        numbers = {"time": self._time, "steps": self._steps, "timestep": self._timestep, "pace": self._pace}
        return {
            **{f"state_{number}": np.asarray(leaf) for number, leaf in enumerate(leaves)},
            **{name: np.asarray(value) for name, value in numbers.items()},
        }

    def resume(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from a checkpoint, bit for bit as if the run had never stopped; ValueError where it is of another body.

        Tests: tests/unit/models/test_checkpoint.py.
        """
        limits = dict.fromkeys(("time", "timestep", "pace"), checkpoint.SIZE) | {"steps": checkpoint.COUNT}
        checkpoint.check(arrays, checkpoint.described(RigidBody.arrays(self)), limits)
        if abs(np.linalg.norm(arrays["state_0"][:4]) - 1.0) > _UNIT:
            raise ValueError("'state_0' has an attitude that is no rotation")
        leaves, structure = jax.tree.flatten(self.state)
        self.state = jax.tree.unflatten(structure, [jnp.asarray(arrays[f"state_{k}"]) for k in range(len(leaves))])
        self._time, self._steps = float(arrays["time"]), int(arrays["steps"])
        self._timestep, self._pace = float(arrays["timestep"]), float(arrays["pace"])

    def figures(self) -> Figures:
        """What the progress line shows."""
        record = self.record(0.0)
        scale = max(record["kinetic_energy"], abs(record["potential_energy"]), 1e-300)
        total = self._opening["energies"].sum() + record["integration_energy_error"]
        return Figures(float(total), scale, math.nan, math.nan)

    def _split(self, body: Rigid, until: float) -> None:
        free = not body.effects and body.deformability is None
        begun, start, done, steps = self._steps, self._time, 0, self._steps_to(body, until)
        while done < steps and self._steps - begun < _STEPS_AT_ONCE:
            more = min(steps - done, _STEPS_AT_ONCE if free and body.change is None else _STEPS_BETWEEN_LOOKS)
            stop = until if done + more == steps else start + (until - start) * ((done + more) / steps)
            self.state = rigid_splitting.advance(
                self.state, body.rates, self._time, stop, more, self.settings.order, body,
                None if free else rigid.kick, None if body.change is None else rigid.size,
            )  # fmt: skip
            self._timestep, self._time = (stop - self._time) / more, stop
            self._steps, done = self._steps + more, done + more
            before = self._pace
            if done < steps and (wanted := self._steps_to(body, until)) and self._pace != before:
                start, done, steps = stop, 0, wanted

    def _steps_to(self, body: Rigid, until: float) -> int:
        pace = self._present_pace(body, until)
        if not pace / _CHANGE_OF_PACE <= self._pace <= pace * _CHANGE_OF_PACE:
            self._pace = pace
        steps = (until - self._time) * self._pace * self.settings.steps_per_rotation / (2.0 * math.pi)
        if not steps < _MOST_STEPS:
            raise NumericalError(f"the body turns so fast that {steps:.1e} steps were needed", time=self._time)
        return max(1, math.ceil(steps * (1.0 - 1e-9)))

    def _present_pace(self, body: Rigid, until: float) -> float:
        state = self.state
        pace = float(rigid.pace(body, self._time, state.turning.value, state.angular_momentum.value))
        if body.change is None:
            return pace
        sizes = np.asarray(body.change.factor(np.linspace(self._time, until, _SIZES_LOOKED_AT)))
        return pace * float(sizes[0] / sizes.min())

    def _adapt(self, body: Rigid, until: float) -> None:
        momentum_unit, body_unit, energy_unit = self._units
        turning, sums = self.state.turning.value, self.state.sums.value
        state = {
            "turning": jnp.concatenate([turning[:4], turning[4:] / body_unit]),
            "momentum": self.state.angular_momentum.value / momentum_unit,
            "accumulated": sums / energy_unit,
        }
        left = until - self._time
        first = min(left, self._timestep or _FIRST_STEP / max(self._present_pace(body, until), _FIRST_STEP / left))
        tolerance = self.settings.tolerance
        advanced = adaptive.advance(
            rigid.rate, (body, *self._units), state, self._time, until, first, tolerance, tolerance, None,
            min(_ADAPTIVE_AT_ONCE, adaptive.MOST_STEPS),
        )  # fmt: skip
        unfinished = self._way.goes_on(self._time, advanced, until)
        if bool(advanced.failed) and not unfinished:
            message = "the adaptive integrator does not come on"
            if bool(advanced.unfinished):
                message = (
                    f"{adaptive.MOST_STEPS:.0e} steps of the adaptive integrator do not reach the next record: "
                    "record more often, take the integrator splitting, or the model scaling if only the rate counts"
                )
            raise NumericalError(message, time=float(advanced.time))
        turning, momentum, sums = (advanced.state[name] for name in state)
        turning = jnp.concatenate([turning[:4] / jnp.linalg.norm(turning[:4]), body_unit * turning[4:]])
        state = Rotor(*map(_filled, (turning, momentum_unit * momentum, energy_unit * sums)))
        length = jnp.linalg.norm(state.momentum_in_body)
        right = jnp.linalg.norm(state.angular_momentum.value) / jnp.where(length > 0.0, length, 1.0)
        if abs(float(right) - 1.0) < _MISALIGNED:
            state = replace(state, turning=_filled(state.turning.value.at[4:].multiply(right)))
        for _ in range(3):  # from a tenth to round-off: the error left is the square of what it was
            state = _without_carry(rigid_splitting.put_right(state, _MISALIGNED))
        self.state, self._time = state, float(advanced.time) if unfinished else until
        self._timestep, self._steps = float(advanced.timestep), self._steps + int(advanced.steps)

    def _strike(self, number: int, effect: Any) -> None:
        """An impulse of an effect: L jumps, and with it the energy at size 1 and the effect's work."""
        body, state, time = self.body, self.state, jnp.asarray(self._time)
        m, momentum = state.momentum_in_body, state.angular_momentum.value
        blow = effect.impulse(rigid.view(body, time, state.quaternion, m, momentum))
        if blow is None:
            return
        before = rigid.rotational_energy(body, time, m)
        m = m + in_body(state.quaternion, blow)
        work = rigid.rotational_energy(body, time, m) - before
        sums, sized = state.sums.value, len(state.sums.value) - len(body.effects)
        sums = sums.at[sized + number].add(work)
        if sized:
            sums = sums.at[0].add(work * rigid.size(body, time))
        turning = jnp.concatenate([state.quaternion, m])
        self.state = Rotor(_filled(turning), _filled(momentum + blow), _filled(sums))

    def _ledger(self) -> Ledger:
        return ledger(self.body, self._time, self.state.turning.value, self.state.angular_momentum.value)

    def _energies(self, ledger: Ledger) -> tuple[float, float]:
        """Kinetic, of all motion, and potential."""
        velocity = np.asarray(ledger.moments.velocity)
        kinetic = 0.5 * (float(jnp.trace(ledger.moments.kinetic)) + float(self.body.mass * velocity @ velocity))
        potential = np.asarray(ledger.potential)
        return kinetic, float(potential[np.isfinite(potential)].sum())

    def _work(self, ledger: Ledger) -> np.ndarray:
        """What each effect, and rigidity, has done to the kinetic energy."""
        sums = np.asarray(self.state.sums.total)
        work = sums[len(sums) - len(self.body.effects) :].copy()
        for number, effect in enumerate(self.body.effects):
            if hasattr(effect, "deformability"):
                work[number] = self._opening["potentials"][number] - float(ledger.potential[number])
        by_size = 0.0
        if self.body.change is not None:
            # What it does to the spin is summed up; its own motion is that of the prescribed size.
            by_size = sums[1] + self._energies(ledger)[0] - float(ledger.spin_energy) - self._opening["swelling"]
        return np.append(work, by_size)

    def _units_of_errors(self) -> tuple[float, np.ndarray, float]:
        """Of L, m and energy for the adaptive integrator: those of the start, or of the pace that torques bring."""
        momentum = float(jnp.linalg.norm(self.state.angular_momentum.value))
        moment = float(np.max(self.body.moments))
        if momentum == 0.0:
            pace = self._present_pace(self.body, 0.0)
            momentum = moment * (pace or 1.0)
        shares = np.where(self.body.moments > 0.0, self.body.moments / moment, 1.0)
        return momentum, momentum * shares, momentum**2 / moment


def _filled(value: Array) -> Compensated:
    return Compensated(value, jnp.zeros_like(value))


def _without_carry(state: Rotor) -> Rotor:
    return replace(state, turning=_filled(state.turning.total))
