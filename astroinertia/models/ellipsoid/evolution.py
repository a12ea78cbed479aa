"""The affine body as the run loop sees it: an ordinary differential equation, integrated from output to output."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, Self

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.effects.effect import acting
from astroinertia.engines import adaptive
from astroinertia.errors import NumericalError
from astroinertia.models import checkpoint
from astroinertia.models.ellipsoid import affine_body
from astroinertia.models.ellipsoid.affine_body import Problem, State
from astroinertia.models.ellipsoid.record import energies, ledger_closure, series_record, unaccounted_energy
from astroinertia.models.protocol import SAME_TIME, Figures, Record

AT_ONCE = 2**8  # steps, of up to some 20 ms, after which the run looks at the clock and at what signals ask for
ABSOLUTE = 0.1  # absolute error over the relative one, of numbers of order 1
COLLAPSED = 1e-8  # of the smallest semi-axis at the start: what is thinner counts as a pancake, a spindle or a point
STEEP = 1e4  # times that thickness, below which steps that grow too short tell of a collapse too
FIRST_STEP = 1e-3  # over the time in which the body changes
SMALL = 0.03  # semi-axes below this share of the largest are those that have collapsed


class Ellipsoid:
    """An affine body under way (models.protocol.Evolution).

    tolerance is the relative error of a step, density the largest one of the sphere F = 1 (NaN where it has none).
    """

    meets_times: ClassVar[bool] = True
    resumable: ClassVar[bool] = True

    def __init__(
        self, problem: Problem, state: State, tolerance: float, density: float, approximation: str, time: float = 0.0
    ) -> None:
        self.effects = problem.effect_names
        self.approximation = approximation
        self.absent: dict[str, str] = {}
        if problem.incompressible:
            self.absent["internal_energy"] = "the fluid is incompressible"
        if not np.isfinite(density):
            self.absent["density_max"] = "the density has no largest value: it rises without bound to the centre"
        self.tolerance, self.density = tolerance, density
        self.time, self.steps = time, 0
        self.timestep = FIRST_STEP * float(problem.scale.deformation.max() / problem.scale.rate.max())
        with jax.enable_x64(True):
            self.problem, self.state = as_arrays(problem), as_arrays(state)
        self.opening = energies(self._seen())
        self.largest_inertia = 0.0
        self._way = adaptive.Way()
        self._note_inertia()

    def breaks(self, until: float) -> set[float]:
        """Times from now on, up to one, at which an effect begins or ends."""
        return {float(time) for effect in self.problem.effects for time in effect.breaks(self.time, until)}

    def stretch(self, until: float) -> tuple[float, Problem]:
        """Up to when, `until` at most, all effects are what they are now, and the physics up to then, ends included."""
        stop = min(self.breaks(until), default=until)
        return stop, as_arrays(acting(self.problem, self.time, stop))

    @property
    def present(self) -> Problem:
        """The physics from now on, as at a break."""
        return as_arrays(acting(self.problem, self.time))

    def advance(self, until: float, most: float = math.inf) -> None:
        """To `until` or where an effect begins or ends before, or as far as so many steps go.

        NumericalError where the body collapses, is torn apart, or steps grow too short or too many for one record.
        """
        with jax.enable_x64(True):
            stop, problem = self.stretch(until)
            if stop - self.time <= SAME_TIME * abs(stop):
                self.time = stop
                return
            advanced = adaptive.advance(
                affine_body.scaled_rate, problem, affine_body.measured(problem, self.state), self.time, stop,
                min(self.timestep, stop - self.time), self.tolerance, ABSOLUTE * self.tolerance, affine_body.ended,
                int(min(AT_ONCE, adaptive.MOST_STEPS, most - self.steps)),
            )  # fmt: skip
            goes_on = self._way.goes_on(self.time, advanced, stop)
            self.moved(affine_body.unmeasured(problem, advanced.state), advanced)
            if not goes_on:
                if bool(advanced.stopped) or bool(advanced.failed):
                    raise self.diagnosis()
                self.time = stop

    def moved(self, state: State, advanced: adaptive.Advanced) -> None:
        """Be in a state that an integration has come to."""
        self.state = state
        self.time, self.steps = float(advanced.time), self.steps + int(advanced.steps)
        self.timestep = float(advanced.timestep)
        self._note_inertia()

    def record(self, opening_potential: float | None) -> Record:
        """One row of the headline series; the energies of the start are the body's own to remember."""
        with jax.enable_x64(True):
            return series_record(self)

    look = record

    def snapshot(self) -> None:
        """There are no particles."""
        return

    def arrays(self) -> dict[str, np.ndarray]:
        """The state, and what goes with it."""
        named = {name: np.asarray(value) for name, value in self.state._asdict().items()}
        named |= {f"opening {name}": np.asarray(value) for name, value in self.opening.items()}
        numbers = {"time": self.time, "steps": self.steps, "timestep": self.timestep, "largest": self.largest_inertia}
        return named | {name: np.asarray(value) for name, value in numbers.items()}

    def resume(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Take up the state of a checkpoint; ValueError, in a sentence, where it is none of this body's."""
        limits = dict.fromkeys(("time", "timestep", "largest"), checkpoint.SIZE) | {"steps": checkpoint.COUNT}
        checkpoint.check(arrays, checkpoint.described(self.arrays()), limits)
        if not np.linalg.det(arrays["deformation"]) > 0.0:
            raise ValueError("'deformation' turns the body inside out")
        with jax.enable_x64(True):
            self.state = as_arrays(State(*(arrays[name] for name in State._fields)))
        self.opening = {name: float(arrays[f"opening {name}"]) for name in self.opening}
        self.time, self.steps = float(arrays["time"]), int(arrays["steps"])
        self.timestep, self.largest_inertia = float(arrays["timestep"]), float(arrays["largest"])

    def begin(self, other: Self) -> None:
        """Be where another body of the same matter is, with a ledger that begins there."""
        moment, there = float(self.problem.second_moment), other.state
        with jax.enable_x64(True):
            self.state = self.state._replace(
                second_moment=moment * there.deformation @ there.deformation.T,
                mixed_moment=moment * there.deformation @ there.rate.T,
                **{name: getattr(there, name) for name in ("deformation", "rate", "centre", "velocity", "heat")},
            )
        self.time, self.timestep = other.time, other.timestep
        self.opening, self.largest_inertia = energies(self._seen()), 0.0
        self._note_inertia()

    def figures(self) -> Figures:
        """What the progress line shows."""
        energy = energies(self._seen())
        scale = max(*map(abs, energy.values()), 1e-300)
        total = sum(self.opening.values()) + unaccounted_energy(self, energy)
        return Figures(total, scale, ledger_closure(self), self.density_now())

    def density_now(self) -> float:
        """The largest density."""
        volume = float(np.linalg.det(np.asarray(self.state.deformation)))
        return self.density / volume if volume > 0.0 else np.inf  # as flat as rounding

    def _seen(self) -> affine_body.Observed:
        with jax.enable_x64(True):
            return affine_body.observed(self.present, np.float64(self.time), self.state)

    def _note_inertia(self) -> None:
        moment = float(self.problem.second_moment)
        second = moment * np.asarray(self.state.deformation) @ np.asarray(self.state.deformation).T
        self.largest_inertia = max(self.largest_inertia, float(np.linalg.norm(np.trace(second) * np.eye(3) - second)))

    def diagnosis(self) -> NumericalError:
        """Why it cannot go on."""
        deformation, rate = np.asarray(self.state.deformation), np.asarray(self.state.rate)
        if not (np.isfinite(deformation).all() and np.isfinite(rate).all()):
            return NumericalError("the state is no longer finite", time=self.time)
        for kind, reach in self._seen().reaches.items():
            if float(reach) >= 1.0:
                message = "the body is torn apart: it reaches out to the perturber, where an ellipsoid means nothing"
                return NumericalError(message, effect=kind, time=self.time)
        # A body that goes to a point does so ever faster: the steps end before it is as thin as that.
        if float(affine_body.thickness(self.state.deformation)) < STEEP * float(self.problem.smallest):
            return self._collapse(deformation, rate)
        shown = ", ".join(f"{stretch:.3g}" for stretch in np.linalg.svd(deformation, compute_uv=False))
        message = (
            f"the steps of the integration grew too short or too many, with semi-axes {shown} in radii of the sphere"
        )
        return NumericalError(message, time=self.time)

    def _collapse(self, deformation: np.ndarray, rate: np.ndarray) -> NumericalError:
        left, stretch, right = np.linalg.svd(deformation)
        # The thinnest axis goes to nothing at this rate; a step may have gone beyond.
        arrival = self.time - stretch[2] / (left[:, 2] @ rate @ right[2])
        flat = int((stretch < SMALL * stretch[0]).sum())
        shape = ("a point", "a pancake, flat across one axis", "a spindle, thin across two axes")[flat]
        size = stretch[0] / float(self.problem.scale.deformation.max())
        return NumericalError(
            f"the body has collapsed to {shape}, where its density has no bound and matter would have to pass through "
            f"itself; its largest semi-axis is {size:.6g} of that at the start",
            time=float(arrival),
        )


def as_arrays(tree: Any) -> Any:
    """The same problem or state with numbers that are arrays, so that one compiled program serves all."""
    return jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype=float), tree)


def started(problem: Problem, deformation: np.ndarray, rate: np.ndarray, heat: float, **chosen: Any) -> Ellipsoid:
    """An affine body at time 0 with F and dF/dt (3, 3) and its heat, at rest at the origin.

    problem.scale, smallest and restoring are set here: sizes are measured by the semi-axes at the start, times by the
    rates and accelerations there. `chosen` are tolerance, density and approximation of Ellipsoid.
    """
    count, moment = len(problem.effects), float(problem.second_moment)
    deformation, rate = np.asarray(deformation, dtype=float), np.asarray(rate, dtype=float)
    zeros = (np.zeros((count, 3, 3)), np.zeros((count, 3)), np.zeros(count), np.zeros(count))
    state = State(
        deformation, rate, np.zeros(3), np.zeros(3), np.asarray(float(heat)),
        moment * deformation @ deformation.T, moment * deformation @ rate.T, *zeros,
    )  # fmt: skip
    sizes = np.sqrt((deformation**2).sum(axis=0))
    with jax.enable_x64(True):
        # Compiled here as the records will need it; only its numbers change.
        seen = affine_body.observed(as_arrays(problem), np.float64(0.0), as_arrays(state))
        thin = float(affine_body.thickness(jnp.asarray(deformation)))
    # Of each force by itself: in equilibrium they add up to nothing.
    accelerations = np.asarray(seen.forces) / (moment * sizes)
    pace = max(np.abs(rate / sizes).max(), np.sqrt(np.abs(accelerations).max(initial=0.0)))
    pace = pace if pace > 0.0 else float(problem.mass / problem.radius**3) ** 0.5
    large = moment * sizes.max() ** 2
    length = float(problem.radius) * sizes.max()
    scale = State(
        np.tile(sizes, (3, 1)), np.tile(sizes * pace, (3, 1)), length, length * pace,
        heat if heat > 0.0 else large * pace**2, large, large * pace, large * pace,
        float(problem.mass) * length * pace, large * pace**2, large * pace**2,
    )  # fmt: skip
    problem = replace(
        problem, restoring=pace, smallest=COLLAPSED * thin, scale=State(*(np.asarray(unit, float) for unit in scale))
    )
    return Ellipsoid(problem, state, **chosen)
