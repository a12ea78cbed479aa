"""One row of the headline series of an affine body, in code units, under the dataset's names."""

from typing import Any

import numpy as np

from astroinertia.models.ellipsoid import affine_body
from astroinertia.models.ellipsoid.affine_body import Observed
from astroinertia.observables.quantities import MODES, BodyState, ledger_closure as closure, of_ledger, row

VANISHING = 1e-6  # of the largest force
KINETIC, INTERNAL = "kinetic", "internal"


def energies(seen: Observed) -> dict[str, float]:
    """Kinetic and internal energy, and the potential energy of each effect that has one, by its kind."""
    arrays = {KINETIC: seen.kinetic, INTERNAL: seen.internal, **seen.potentials}
    return {name: float(energy) for name, energy in arrays.items()}


def ledger_closure(body: Any) -> float:
    """|I of the ledger - I of the deformation| over the largest |I| of the run."""
    moment, deformation = float(body.problem.second_moment), np.asarray(body.state.deformation)
    return closure(np.asarray(body.state.second_moment), moment * deformation @ deformation.T, body.largest_inertia)


def series_record(body: Any) -> dict[str, Any]:
    """The record of an affine body (models.ellipsoid.evolution.Ellipsoid).

    virial_mismatch compares each effect's own virial tensor with F G^T of its force. integration_energy_error is what
    kinetic, internal and static potential energy changed by beyond what the effects' work and heating account for.
    """
    problem, state, time = body.present, body.state, body.time
    seen = affine_body.observed(problem, np.float64(time), state)
    moment, mass = float(problem.second_moment), float(problem.mass)
    deformation, rate = np.asarray(state.deformation), np.asarray(state.rate)
    forces, pushes, virial = np.asarray(seen.forces), np.asarray(seen.pushes), np.asarray(seen.virials)
    energy = energies(seen)
    potentials = {name: value for name, value in energy.items() if name not in (KINETIC, INTERNAL)}
    direct = moment * deformation @ deformation.T
    described = BodyState(
        time=time, step=body.steps, mass=mass, centre_of_mass=np.asarray(state.centre),
        momentum=mass * np.asarray(state.velocity), second_moment=0.5 * (direct + direct.T),
        mixed_moment=moment * deformation @ rate.T, kinetic_tensor=moment * rate @ rate.T, virial_tensor=virial,
        force=pushes, impulse=np.asarray(state.impulse), work=np.asarray(state.work), heating=np.asarray(state.heating),
        kinetic_energy=energy[KINETIC], internal_energy=np.nan if problem.matter is None else energy[INTERNAL],
        gravitational_energy=potentials.get("gravity", np.nan), potential_energy=sum(potentials.values()),
        total_energy=sum(energy.values()), integration_energy_error=unaccounted_energy(body, energy),
    )  # fmt: skip
    return row(
        described,
        virial_mismatch=np.array(
            [_mismatch(tensor, deformation, force, forces) for tensor, force in zip(virial, forces, strict=True)]
        ),
        **of_ledger(np.asarray(state.second_moment), direct, body.largest_inertia, np.asarray(state.mixed_impulse)),
        density_max=body.density_now(),
        timestep=body.timestep,
        **_modes(described.second_moment),
    )


def unaccounted_energy(body: Any, now: dict[str, float]) -> float:
    """What energies `now` differ by from those of the start beyond what effects have done."""
    opening, work = body.opening, dict(zip(body.problem.effect_names, np.asarray(body.state.work), strict=True))
    error = now[KINETIC] - opening[KINETIC] - sum(work.values())
    error += now[INTERNAL] - opening[INTERNAL] - float(np.asarray(body.state.heating).sum())
    for effect in body.problem.effects:
        # Of a potential that changes by itself the energy of the body says nothing: its work alone counts.
        if effect.kind in now and not effect.potential_moves:
            error += now[effect.kind] - opening[effect.kind] + work[effect.kind]
    return error


def _mismatch(tensor: np.ndarray, deformation: np.ndarray, force: np.ndarray, forces: np.ndarray) -> float:
    # Over the effect's own size, unless that has all but vanished, as the viscosity of a body that turns rigidly.
    largest = np.linalg.norm(forces, axis=(1, 2)).max()
    size = np.linalg.norm(deformation) * max(np.linalg.norm(force), VANISHING * largest)
    error = np.abs(tensor - deformation @ force.T).max()
    return float(error / size) if size > 0 else float(error)


def _modes(second: np.ndarray) -> dict[str, np.ndarray]:
    # Projected along z the shells are similar ellipses with semi-axes a and b, of which the sector at phi has a mass in
    # proportion to the square of its length: |sum m exp(i k phi)|/M = ((a - b)/(a + b))^(k/2) for even k.
    moments, axes = np.linalg.eigh(second[:2, :2])
    short, long = np.sqrt(np.maximum(moments, 0.0))
    ratio = (long - short) / (long + short) if long > 0 else 0.0
    phase = np.arctan2(axes[1, 1], axes[0, 1])
    modes = [ratio ** (k // 2) * np.exp(1j * k * phase) if k % 2 == 0 else 0.0 for k in MODES]
    return {"mode_amplitude": np.abs(modes), "mode_phase": np.angle(modes)}
