"""Checks of each effect by itself: the closure of the ledger proves the accounting, these checks prove the physics.

(a) the virial tensor that an effect reports by its own route against sum m x (x) a_e;
(b) the symmetries it claims: no net force within the fluid, no torque of a central one, work and heat that cancel;
(c) its potential, which differentiates to its acceleration.

Each figure is relative to the sum of the sizes of its terms, so that round-off is about 1e-16 for any state. What
fails names its effect. tests/physics/test_effect_checks.py breaks each on purpose.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import jax
import numpy as np

Array = Any

TOLERANCE = 1e-11
"""Round-off of the sums over a few hundred thousand particles stays below it; any error of the physics does not."""

CENTRAL = {"gravity", "pressure", "viscosity", "shear_viscosity", "deleptonisation", "relativistic_potential"}
"""Kinds that act along the separation of particles, or from the centre of mass: their virial tensor is symmetric."""


@dataclass(frozen=True)
class EffectCheck:
    """The figures of one effect; None where the effect makes no such claim."""

    effect: str
    virial: float | None = None
    """|V_e - sum m x (x) a_e| / sum m |x| |a_e|."""
    net_force: float | None = None
    """|sum m a_e| / sum m |a_e| of an effect within the fluid."""
    torque: float | None = None
    """Antisymmetric part of sum m x (x) a_e over |V_e| of a central effect."""
    dissipation: float | None = None
    """|sum m (a_e.v + q_e)| over the sum of the sizes, of an effect within the fluid that heats."""
    potential: float | None = None
    """|dU_e + sum m a_e.dx| / sum m |a_e| |dx| of an effect with a potential, if it was differentiated."""

    def failures(self, tolerance: float = TOLERANCE) -> tuple[str, ...]:
        """Names of the figures that are above the tolerance, or not numbers."""
        figures = {f.name: getattr(self, f.name) for f in fields(self)[1:]}
        return tuple(name for name, figure in figures.items() if figure is not None and not figure <= tolerance)


def failing(checks: Sequence[EffectCheck], tolerance: float = TOLERANCE) -> dict[str, tuple[str, ...]]:
    """{effect: figures that fail}, of the effects that have any."""
    failures = {check.effect: check.failures(tolerance) for check in checks}
    return {effect: names for effect, names in failures.items() if names}


def effect_checks(
    effects: Sequence[Any],
    mass: Array,
    position: Array,
    velocity: Array,
    accelerations: Sequence[Array],
    virials: Mapping[str, Array],
    heatings: Sequence[Array | None],
) -> tuple[EffectCheck, ...]:
    """Checks (a) and (b) of every effect in a state.

    accelerations: (N, 3) of each effect, drag at `velocity` included; virials: {kind: (3, 3)} by the effects' own
    routes; heatings: (N,) du/dt or None.
    """
    mass, position, velocity = np.asarray(mass), np.asarray(position), np.asarray(velocity)
    relative = position - (mass @ position) / mass.sum()
    checks = []
    for effect, a, heating in zip(effects, accelerations, heatings, strict=True):
        a = np.asarray(a)
        figures = {"virial": virial_mismatch(mass, relative, a, virials[effect.kind])}
        if not effect.external:
            figures["net_force"] = net_force(mass, a)
            # Pressure's heat is what its work has beyond the change at constant entropy: the energy's account has both.
            if heating is not None and effect.kind != "pressure":
                figures["dissipation"] = energy_mismatch(mass, velocity, a, np.asarray(heating))
        if effect.kind in CENTRAL:
            figures["torque"] = torque_mismatch(mass, relative, a, virials[effect.kind])
        checks.append(EffectCheck(effect.kind, **figures))
    return tuple(checks)


def potential_checks(
    effects: Sequence[Any],
    mass: Array,
    accelerations: Sequence[Array],
    displacement: Array,
    changes: Mapping[str, float],
) -> tuple[EffectCheck, ...]:
    """Check (c) of every effect with a potential.

    accelerations: (N, 3) of each effect, without its drag; changes: {kind: dU} along `displacement` (N, 3), as
    `potential_changes` gives them.
    """
    mass = np.asarray(mass)
    return tuple(
        EffectCheck(e.kind, potential=potential_mismatch(mass, np.asarray(a), displacement, changes[e.kind]))
        for e, a in zip(effects, accelerations, strict=True)
        if e.kind in changes
    )


def virial_mismatch(mass: Array, relative: Array, acceleration: Array, virial: Array) -> float:
    """|V - sum m x (x) a| / sum m |x| |a|, with x relative to the centre of mass, (N, 3)."""
    direct = (mass[:, None] * relative).T @ acceleration
    return _ratio(np.abs(np.asarray(virial) - direct).max(), mass @ (_norm(relative) * _norm(acceleration)))


def net_force(mass: Array, acceleration: Array) -> float:
    """|sum m a| / sum m |a|."""
    return _ratio(np.linalg.norm(mass @ acceleration), mass @ _norm(acceleration))


def torque_mismatch(mass: Array, relative: Array, acceleration: Array, virial: Array) -> float:
    """Largest antisymmetric element of sum m x (x) a over |V|.

    A tensor that all but cancels, as viscosity's in a flow without compression, is taken as a thousandth of its terms.
    """
    direct = (mass[:, None] * relative).T @ acceleration
    terms = mass @ (_norm(relative) * _norm(acceleration))
    return _ratio(np.abs(direct - direct.T).max(), max(np.linalg.norm(np.asarray(virial)), 1e-3 * terms))


def energy_mismatch(mass: Array, velocity: Array, acceleration: Array, heating: Array) -> float:
    """|sum m (a.v + q)| / sum m (|a.v| + |q|): what an effect takes from the motion it must give as heat."""
    work = (acceleration * velocity).sum(axis=1)
    return _ratio(abs(mass @ (work + heating)), mass @ (np.abs(work) + np.abs(heating)))


def potential_mismatch(mass: Array, acceleration: Array, displacement: Array, change: float) -> float:
    """|dU + sum m a.dx| / sum m |a| |dx| for the change dU of a potential energy along dx."""
    displacement = np.asarray(displacement)
    work = mass @ (acceleration * displacement).sum(axis=1)
    return _ratio(abs(float(change) + work), mass @ (_norm(acceleration) * _norm(displacement)))


def potential_changes(
    energies: Callable[[Array], Mapping[str, Array]], position: Array, displacement: Array
) -> dict[str, float]:
    """Exact derivatives dU of {kind: potential energy of positions (N, 3)} along a displacement.

    `energies` must be traceable by jax, smoothing lengths and all.
    """
    _, changes = jax.jit(lambda x, dx: jax.jvp(energies, (x,), (dx,)))(position, displacement)
    return {kind: float(change) for kind, change in changes.items()}


def _norm(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=1)


def _ratio(error: Any, scale: Any) -> float:
    return float(error / scale) if scale > 0 else float(error)
