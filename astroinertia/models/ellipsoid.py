"""The affine body as the run loop sees it: an ordinary differential equation, integrated from output to output."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.errors import NumericalError
from astroinertia.integrate import adaptive
from astroinertia.models import affine_body
from astroinertia.models.affine_body import Problem, State
from astroinertia.models.ellipsoid_record import energies, ledger_closure, series_record
from astroinertia.models.evolution import Figures, Record

ABSOLUTE = 0.1  # absolute error over the relative one, of numbers of order 1
COLLAPSED = 1e-6  # of the smallest semi-axis at the start: what is thinner counts as a pancake, a spindle or a point
FIRST_STEP = 1e-3  # over the time in which the body changes
SMALL = 0.03  # semi-axes below this share of the largest are those that have collapsed
_SPHERES = "the shells of an affine body are similar ellipsoids, not spheres"


class Ellipsoid:
    """An affine body under way (models.evolution.Evolution).

    tolerance is the relative error of a step, density the largest one of the sphere F = 1 (NaN where it has none).
    """

    meets_times: ClassVar[bool] = True
    resumable: ClassVar[bool] = True

    def __init__(
        self, problem: Problem, state: State, tolerance: float, density: float, approximation: str, time: float = 0.0
    ) -> None:
        self.effects = problem.effect_names
        self.approximation = approximation
        self.absent = dict.fromkeys(
            ("radius_profile", "density_profile", "rotation_profile", "specific_angular_momentum_profile"), _SPHERES
        )
        if problem.incompressible:
            self.absent["internal_energy"] = "the fluid is incompressible"
        if not np.isfinite(density):
            self.absent["density_max"] = "the density has no largest value: it rises without bound to the centre"
        self.tolerance, self.density = tolerance, density
        assert problem.scale is not None
        self.time, self.steps = time, 0
        self.timestep = FIRST_STEP * float(problem.scale.deformation.max() / problem.scale.rate.max())
        with jax.enable_x64(True):
            self.problem = jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype=float), problem)
            self.state = State(*(jnp.asarray(value, dtype=float) for value in state))
            self.opening = energies(self.problem, self.time, self.state)
        self.largest_inertia = 0.0
        self._note_inertia()

    def advance(self, until: float) -> None:
        """All the way to `until`; NumericalError where the body collapses, is torn apart, or steps grow too short."""
        with jax.enable_x64(True):
            found = adaptive.advance(
                affine_body.scaled_rate, self.problem, affine_body.measured(self.problem, self.state), self.time, until,
                min(self.timestep, until - self.time), self.tolerance, ABSOLUTE * self.tolerance, affine_body.ended,
            )  # fmt: skip
            self.state = affine_body.unmeasured(self.problem, found.state)
            self.time, self.steps = float(found.time), self.steps + int(found.steps)
            self.timestep = float(found.timestep)
            if bool(found.stopped) or bool(found.failed):
                raise self._diagnosis()
        self.time = until
        self._note_inertia()

    def record(self, opening_potential: float | None) -> Record:
        """One row of the headline series; the energies of the start are the body's own to remember."""
        with jax.enable_x64(True):
            return series_record(self, opening_potential)

    def snapshot(self) -> None:
        """There are no particles."""
        return

    def arrays(self) -> dict[str, np.ndarray]:
        """The state, and what goes with it."""
        named = {name: np.asarray(value) for name, value in self.state._asdict().items()}
        named |= {f"opening {name}": np.asarray(value) for name, value in self.opening.items()}
        told = {"time": self.time, "steps": self.steps, "timestep": self.timestep, "largest": self.largest_inertia}
        return named | {name: np.asarray(value) for name, value in told.items()}

    def resume(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Take up the state of a checkpoint."""
        with jax.enable_x64(True):
            self.state = State(*(jnp.asarray(arrays[name]) for name in State._fields))
        self.opening = {name: float(arrays[f"opening {name}"]) for name in self.opening}
        self.time, self.steps = float(arrays["time"]), int(arrays["steps"])
        self.timestep, self.largest_inertia = float(arrays["timestep"]), float(arrays["largest"])

    def figures(self) -> Figures:
        """What the progress line shows."""
        with jax.enable_x64(True):
            found = energies(self.problem, self.time, self.state)
        scale = max(*map(abs, found.values()), 1e-300)
        return Figures(sum(found.values()), scale, ledger_closure(self), self.density_now())

    def density_now(self) -> float:
        """The largest density."""
        return self.density / float(np.linalg.det(np.asarray(self.state.deformation)))

    def _note_inertia(self) -> None:
        moment = float(self.problem.second_moment)
        second = moment * np.asarray(self.state.deformation) @ np.asarray(self.state.deformation).T
        self.largest_inertia = max(self.largest_inertia, float(np.linalg.norm(np.trace(second) * np.eye(3) - second)))

    def _diagnosis(self) -> NumericalError:
        deformation, rate = np.asarray(self.state.deformation), np.asarray(self.state.rate)
        if not (np.isfinite(deformation).all() and np.isfinite(rate).all()):
            return NumericalError("the state is no longer finite", time=self.time)
        for kind, reach in affine_body.reaches(self.problem, jnp.asarray(self.time), self.state).items():
            if float(reach) >= 1.0:
                told = "the body is torn apart: it reaches out to the perturber, where an ellipsoid means nothing"
                return NumericalError(told, effect=kind, time=self.time)
        axes = float(self.problem.radius) * np.linalg.svd(deformation, compute_uv=False)
        if float(affine_body.thickness(self.state.deformation)) < float(self.problem.smallest):
            return NumericalError(self._collapse(axes, deformation, rate), time=self.time)
        shown = ", ".join(f"{axis:.3g}" for axis in axes)
        told = f"the steps of the integration grew too short or too many, with semi-axes {shown}"
        return NumericalError(told, time=self.time)

    def _collapse(self, axes: np.ndarray, deformation: np.ndarray, rate: np.ndarray) -> str:
        flat = int((axes < SMALL * axes[0]).sum())
        shape = ("a point", "a pancake, flat across one axis", "a spindle, thin across two axes")[flat]
        # Along the thinnest axis, where matter moves at its rate of stretch.
        left, stretch, right = np.linalg.svd(deformation)
        speed = left[:, 2] @ rate @ right[2]
        arrival = self.time - stretch[2] / speed if speed < 0.0 else self.time
        largest = f"the largest semi-axis is {axes[0]:.6g} then" if flat else f"its semi-axes are {axes[0]:.3g}"
        return (
            f"the body has collapsed to {shape} at time {arrival:.12g}, where its density has no bound and matter "
            f"would have to pass through itself; {largest}"
        )


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
        first = affine_body.rate_of_change(jnp.zeros(()), State(*map(jnp.asarray, state)), problem)
        thin = float(affine_body.thickness(jnp.asarray(deformation)))
    pace = max(np.abs(rate / sizes).max(), np.sqrt(np.abs(np.asarray(first.rate) / sizes).max()))
    pace = pace if pace > 0.0 else float(problem.mass / problem.radius**3) ** 0.5
    large = moment * sizes.max() ** 2
    length = float(problem.radius) * sizes.max()
    scale = State(
        np.broadcast_to(sizes, (3, 3)), np.broadcast_to(sizes * pace, (3, 3)), length, length * pace,
        heat if heat > 0.0 else large * pace**2, large, large * pace, large * pace,
        float(problem.mass) * length * pace, large * pace**2, large * pace**2,
    )  # fmt: skip
    problem = replace(
        problem, restoring=pace, smallest=COLLAPSED * thin, scale=State(*(np.asarray(unit, float) for unit in scale))
    )
    return Ellipsoid(problem, state, **chosen)
