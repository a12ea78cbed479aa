"""A hard case of particles: what is done to them, what stable means there, and how it is judged."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import jax
import numpy as np

from astroinertia.build.sph import base_step_of, problem_of
from astroinertia.errors import NumericalError
from astroinertia.models.sph.evolution import Particles
from astroinertia.models.sph.first_state import initial_state
from astroinertia.scene import load
from astroinertia.units import DIMENSIONLESS
from astroinertia.verify.hard.clouds import Cloud

SCENE = """
name = "hard_case"
units = "code"

[body]
kind = "table"
file = "particles.npz"

[equation_of_state]
kind = "ideal"

[effects.gravity]
[effects.pressure]
[effects.viscosity]

[time]
end = 1.0
"""
"""One set of effects for all cases, so that each engine compiles it once."""

MODES = {
    "global": ('numerics.engine="numba_cpu"', 'numerics.timesteps="global"'),
    "individual": ('numerics.engine="numba_cpu"', 'numerics.timesteps="individual"'),
    "xla": ('numerics.engine="xla"', 'numerics.timesteps="global"'),
}
BARS: Mapping[str, float] = MappingProxyType(
    {
        "not_finite": 0.0,
        "mass": 0.0,
        "momentum": 1e-13,
        "angular_momentum": 1e-12,
        "energy": 0.01,
        "ledger_closure": 1e-12,
        "negative_entropy": 0.0,
    }
)
"""What every case keeps: see `judged`. With float32 pairs, FLOAT32 for the momenta."""
KEPT = "finite; momentum, angular momentum and the ledger kept to round-off, energy to 1 %"
"""What `BARS` say, in words."""
FLOAT32 = 1e-7
NOT_ALWAYS = (
    "timestep_limit_radius", "timestep_limit_density", "internal_energy", "gravitational_energy",
    "smoothing_to_thickness", "enclosing_ellipsoid",  # of what has no thickness
)  # fmt: skip
PROFILES = "_profile"  # shells without particles have none


@dataclass(frozen=True)
class Case:
    """A cloud, evolved to a time or for so many steps with default numerics but for `settings` (--set style).

    stable: what it means here, in words. bars: its own, of figures in `BARS` or found by `finding`. ends: words of the
    NumericalError that must end it. own_program: needs code that no other case compiles; long: takes many minutes.
    """

    name: str
    cloud: Callable[[], Cloud]
    stable: str = KEPT
    until: float = 1.0
    steps: int = 100
    settings: tuple[str, ...] = ()
    bars: Mapping[str, float] = field(default_factory=dict)
    finding: Callable[[Particles, Mapping, Mapping], dict[str, float]] | None = None
    ends: str = ""
    own_program: bool = False
    long: bool = False

    def scene_text(self, mode: str) -> tuple[str, tuple[str, ...]]:
        """The scene and its settings."""
        return SCENE, (f"time.end={self.until!r}", *self.settings, *MODES[mode])


@dataclass(frozen=True)
class Verdict:
    """How a case went: figures with their bars, steps taken, and the error that ended it, if one did."""

    case: Case
    mode: str
    figures: Mapping[str, float]
    bars: Mapping[str, float]
    steps: int
    error: str = ""

    @property
    def worst(self) -> str:
        """The figure that is closest to its bar, or furthest beyond."""
        return max(self.figures, key=lambda name: _over(self.figures[name], self.bars[name]), default="")

    @property
    def holds(self) -> bool:
        """Whether the case was stable in its own sense."""
        if self.case.ends:
            return self.case.ends in self.error
        return not self.error and all(self.figures[name] <= bar for name, bar in self.bars.items())


def _over(figure: float, bar: float) -> float:
    return float("inf") if np.isnan(figure) else figure / bar if bar > 0.0 else float(figure > 0.0)


def tried(case: Case, mode: str) -> Verdict:
    """Evolve a case in a mode (one of MODES) and judge it; other errors than NumericalError are not expected."""
    mixed = 'numerics.precision="mixed"' in case.settings
    bars = {**BARS, **(dict.fromkeys(("momentum", "angular_momentum"), FLOAT32) if mixed else {}), **case.bars}
    steps = 0
    try:
        with jax.enable_x64(True), np.errstate(all="ignore"):
            body = started(case, mode)
            before = body.record(None)
            opening = [np.asarray(a) for a in (body.state.mass, body.state.position, body.state.velocity)]
            while body.time < case.until * (1.0 - 1e-14) and body.steps < case.steps:
                body.advance(case.until)
                steps = body.steps
            after = body.record(before["potential_energy"])
            figures = judged(body, before, after, opening)
            if case.finding is not None:
                figures |= case.finding(body, before, after)
    except NumericalError as error:
        return Verdict(case, mode, {}, bars, steps, str(error))
    return Verdict(case, mode, figures, bars, steps)


def started(case: Case, mode: str) -> Particles:
    """The particles of a case at time 0."""
    text, settings = case.scene_text(mode)
    scene, cloud = load.loads(text, settings), case.cloud()
    problem, _ = problem_of(scene, DIMENSIONLESS, len(cloud.mass))
    state, arrangement = initial_state(
        problem, cloud.mass, cloud.position, cloud.velocity, internal_energy=cloud.internal_energy
    )
    return Particles(problem, state, arrangement, case.until, base_step_of(scene))


def judged(body: Particles, before: Mapping[str, Any], after: Mapping[str, Any], opening: list) -> dict[str, float]:
    """The figures of `BARS`: values that are no numbers; relative changes of mass, momentum (of sum m|v|), angular
    momentum (of sum m|x||v|) and total energy (of the largest of the energies); the ledger's closure; and the
    entropy function below 0 of its largest value.
    """
    state = body.state
    mass, position, velocity = (np.asarray(a) for a in (state.mass, state.position, state.velocity))
    rush = max(_sum(mass, velocity), _sum(opening[0], opening[2]))
    swing = max(_swing(mass, position, velocity), _swing(*opening))
    energies = ("kinetic_energy", "internal_energy", "potential_energy")
    largest = max(abs(record[name]) for record in (before, after) for name in energies)
    spun = np.abs(after["angular_momentum"] - before["angular_momentum"]).max()
    entropy = np.asarray(state.entropy)
    return {
        "not_finite": float(_not_finite(after)),
        "mass": _ratio(abs(after["mass"] - before["mass"]), before["mass"]),
        "momentum": _ratio(np.abs(after["momentum"] - before["momentum"]).max(), rush),
        "angular_momentum": _ratio(spun, swing),
        "energy": _ratio(abs(after["total_energy"] - before["total_energy"]), largest),
        "ledger_closure": float(after["ledger_closure"]),
        "negative_entropy": _ratio(max(0.0, -float(entropy.min())), float(np.abs(entropy).max())),
    }


def _not_finite(record: Mapping[str, Any]) -> int:
    return sum(
        int((~np.isfinite(np.asarray(value, dtype=float))).sum())
        for name, value in record.items()
        if name not in NOT_ALWAYS and not name.endswith(PROFILES)
    )


def _sum(mass: np.ndarray, vector: np.ndarray) -> float:
    return float(mass @ np.linalg.norm(vector, axis=1))


def _swing(mass: np.ndarray, position: np.ndarray, velocity: np.ndarray) -> float:
    centred = [a - mass @ a / mass.sum() for a in (position, velocity)]
    return float(mass @ (np.linalg.norm(centred[0], axis=1) * np.linalg.norm(centred[1], axis=1)))


def _ratio(part: float, whole: float) -> float:
    return float(part / whole) if whole > 0.0 else float(part)
