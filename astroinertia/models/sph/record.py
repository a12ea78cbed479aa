"""One row of the headline series: what a run records of its state, in code units, under the dataset's names."""

from typing import Any

import numpy as np

from astroinertia.effects.effect import Effect
from astroinertia.engines.pytree import mapped
from astroinertia.ledger.moments import centre_of_mass, moments, weighted_outer
from astroinertia.models.sph.evaluate import effect_accelerations, internal_energy, potential_energies, virial_tensors
from astroinertia.models.sph.extent import extent
from astroinertia.models.sph.limits import limiting, timestep_limits
from astroinertia.models.sph.points import system_record
from astroinertia.models.sph.resolution import resolution
from astroinertia.models.sph.state import Problem, State
from astroinertia.observables.quantities import (
    MODES,
    TIMESTEP_CRITERIA,
    BodyState,
    ledger_closure as closure,
    of_ledger,
    row,
)
from astroinertia.sph.kernels import KERNELS, neighbour_number
from astroinertia.sph.standard_volumes import DENSITY_FACTOR

RADIUS_BINS = 32
SHOWN = ("electron_fraction", DENSITY_FACTOR)  # of what effects evolve for themselves, what snapshots have
RING = (0.25, 0.75)  # of the mass, in the order of its distance from the axis


def series_record(problem: Problem, arrangement: Any, state: State, opening_potential: float | None) -> dict[str, Any]:
    """The record of a state; `opening_potential` is the static part of the energy at time 0 (None in the first record).

    virial_tensor is each effect's own route (pair loop or closed form); virial_mismatch is its distance from
    sum m x (x) a_e over sum m |x| |a_e|.
    """
    names = problem.effect_names
    mass, position, velocity = (np.asarray(a) for a in (state.mass, state.position, state.velocity))
    total_mass, momentum = mass.sum(), mass @ velocity
    centre, drift = (mass @ position) / total_mass, momentum / total_mass
    relative, fluid, ledger = position - centre, state.rates.fluid, state.ledger
    second, mixed, kinetic = moments(mass, position, velocity)
    tensors = virial_tensors(problem, arrangement, fluid)
    virial = np.array([np.asarray(tensors[name]) for name in names]).reshape(-1, 3, 3)
    accelerations = effect_accelerations(np, mapped(np.asarray, state.rates))
    mismatch = [
        _ratio(
            np.abs(tensor - weighted_outer(mass, relative, a)).max(),
            (mass * np.linalg.norm(relative, axis=1) * np.linalg.norm(a, axis=1)).sum(),
        )
        for tensor, a in zip(virial, accelerations, strict=True)
    ]
    energies = energy_budget(problem, state)
    condensed = getattr(problem.equation_of_state, "condensed", False)  # of no use to Jeans: it holds itself together
    work, heating = np.asarray(ledger.work.total), np.asarray(ledger.heating.total)
    potential = energies["static"]
    opening = potential if opening_potential is None else opening_potential
    inside = ~works_from_outside(problem, energies["potential"])
    body = BodyState(
        time=float(state.time), step=int(state.step), mass=total_mass, centre_of_mass=centre, momentum=momentum,
        second_moment=second, mixed_moment=mixed, kinetic_tensor=kinetic, virial_tensor=virial,
        force=np.array([mass @ a for a in accelerations]).reshape(-1, 3), impulse=np.asarray(ledger.impulse.total),
        work=work, heating=heating, kinetic_energy=energies["kinetic"],
        internal_energy=energies["internal"] if "pressure" in names else np.nan,
        gravitational_energy=energies["potential"].get("gravity", np.nan),
        potential_energy=potential, total_energy=energies["total"],
        integration_energy_error=float((work + heating)[inside].sum() + potential - opening),
    )  # fmt: skip
    return row(
        body,
        virial_mismatch=np.array(mismatch),
        **of_ledger(
            np.asarray(ledger.second_moment.total), second, ledger.largest_inertia,
            np.asarray(ledger.mixed_impulse.total),
        ),
        density_max=float(np.max(fluid.density)),
        timestep=float(state.rates.timestep),
        **timestep_limit(problem, state),
        **_profiles(mass, relative, velocity - drift, np.asarray(fluid.density)),
        **_modes(mass, relative, velocity - drift),
        **extent(mass, relative),
        **resolution(
            mass,
            np.asarray(fluid.density),
            np.asarray(fluid.pressure) if {"pressure", "gravity"} <= set(names) and not condensed else None,
            np.asarray(state.smoothing_length),
            second,
            neighbour_number(KERNELS[problem.kernel], problem.eta),
        ),
        **system_record(state),
        **{name: array for effect in problem.effects for name, array in effect.recorded(state).items()},
    )  # fmt: skip


def ledger_closure(state: State) -> float:
    """|I of the ledger - I by direct summation| over the largest |I| of the run."""
    second = moments(*(np.asarray(array) for array in (state.mass, state.position, state.velocity)))[0]
    return closure(np.asarray(state.ledger.second_moment.total), second, state.ledger.largest_inertia)


def timestep_limit(problem: Problem, state: State) -> dict[str, float]:
    """What sets the time step, numbered as effects and then TIMESTEP_CRITERIA, and where; NaN for all particles."""
    criterion, particle = limiting(timestep_limits(problem, state.rates))
    radius = density = float("nan")
    if particle is not None:
        mass, position = np.asarray(state.mass), np.asarray(state.position)
        radius = float(np.linalg.norm(position[particle] - centre_of_mass(mass, position)))
        density = float(state.rates.fluid.density[particle])
    return {
        "timestep_limit": float((*problem.effect_names, *TIMESTEP_CRITERIA).index(criterion)),
        "timestep_limit_radius": radius,
        "timestep_limit_density": density,
    }


def energy_budget(problem: Problem, state: State) -> dict[str, Any]:
    """Kinetic, internal, potential (by effect), its static part and total energy, by direct summation."""
    kinetic = 0.5 * float((np.asarray(state.mass)[:, None] * np.asarray(state.velocity) ** 2).sum())
    internal = float(internal_energy(problem, state))
    potential = {kind: float(energy) for kind, energy in potential_energies(problem, state).items()}
    return {
        "kinetic": kinetic,
        "internal": internal,
        "potential": potential,
        "static": sum(potential[e.kind] for e in problem.effects if e.kind in potential and not e.potential_moves),
        "total": kinetic + internal + sum(potential.values()),
    }


def works_from_outside(problem: Problem, potentials: dict[str, float]) -> np.ndarray:
    """Of which effects the work is not found again in the fluid's energies, (E,).

    Of those that work from outside without a static potential, or that heat a fluid that has no thermal content.
    """

    def loses(effect: Effect) -> bool:
        static = effect.kind in potentials and not effect.potential_moves
        heats = any(output.name == "heating" for term in effect.neighbour_terms for output in term.outputs)
        return (effect.external and not static) or (heats and not problem.equation_of_state.thermal)

    return np.array([loses(effect) for effect in problem.effects], dtype=bool)


def snapshot_record(problem: Problem, state: State) -> dict[str, Any]:
    """Per-particle arrays in the order of the particles' identities; the state of matter is that of their entropies.

    The fluid's own, with which forces were made, is that of the entropies predicted before the step's last kick.
    """
    order = np.argsort(np.asarray(state.identity))
    fluid = state.rates.fluid
    eos = problem.matter(state.material)
    pressure, _, internal_energy, *_ = eos.state(problem.engine.xp, fluid.density, state.entropy)
    arrays = {
        "position": state.position,
        "velocity": state.velocity,
        "mass": state.mass,
        "density": fluid.density,
        "smoothing_length": state.smoothing_length,
        "internal_energy": internal_energy,
        "entropy": state.entropy,
        "pressure": pressure,
        **({} if state.material is None else {"material": state.material}),
        **{name: state.memory[name] for name in SHOWN if name in state.memory},
    }
    ordered = {name: np.asarray(array)[order] for name, array in arrays.items()}
    if "sinks" in state.points:  # a snapshot has all particles that there ever were: those accreted are NaN
        identity, most = np.asarray(state.identity)[order], int(state.points["sinks"].particles)
        for name, array in ordered.items():
            ordered[name] = np.full((most, *array.shape[1:]), np.nan)
            ordered[name][identity] = array
    return {"time": float(state.time), **ordered}


def _profiles(mass: np.ndarray, position: np.ndarray, velocity: np.ndarray, density: np.ndarray) -> dict[str, Any]:
    # Shells of equal mass about the centre of mass; rotation about z.
    radius = np.linalg.norm(position, axis=1)
    order = np.argsort(radius)
    share = np.cumsum(mass[order]) / mass.sum()
    shell = np.empty(len(mass), int)
    shell[order] = np.minimum((share - 1e-9) * RADIUS_BINS, RADIUS_BINS - 1)
    (x, y, _), (u, v, _) = position.T, velocity.T

    def total(values: np.ndarray) -> np.ndarray:
        return np.bincount(shell, weights=mass * values, minlength=RADIUS_BINS)

    weight = np.bincount(shell, weights=mass, minlength=RADIUS_BINS)
    weight = np.where(weight > 0, weight, np.nan)
    spin, moment = total(x * v - y * u), total(x**2 + y**2)
    return {
        "radius_profile": total(radius) / weight,
        "density_profile": total(density) / weight,
        "rotation_profile": spin / np.where(moment > 0, moment, np.nan),
        "specific_angular_momentum_profile": spin / weight,
    }


def _modes(mass: np.ndarray, position: np.ndarray, velocity: np.ndarray) -> dict[str, Any]:
    # sum m exp(i k phi) / M about the z axis through the centre of mass, of all and of the ring; and how it turns.
    (x, y, _), (u, v, _) = position.T, velocity.T
    square = x**2 + y**2
    turning = np.divide(x * v - y * u, square, out=np.zeros_like(square), where=square > 0)
    wave = np.divide(x + 1j * y, np.sqrt(square), out=np.ones(len(mass), complex), where=square > 0)  # exp(i phi)
    waves = np.cumprod([wave] * max(MODES), axis=0)[np.array(MODES) - 1]
    modes = waves @ mass / mass.sum()
    rates = 1j * np.array(MODES) * (waves @ (mass * turning)) / mass.sum()
    size = np.abs(modes) ** 2
    speed = np.divide(
        (modes.conj() * rates).imag, np.array(MODES) * size, out=np.full(len(MODES), np.nan), where=size > 0
    )
    order = np.argsort(square)
    share = np.cumsum(mass[order]) / mass.sum()
    inside = order[(share > RING[0]) & (share <= RING[1])]
    ring = waves[:, inside] @ mass[inside] / mass[inside].sum() if len(inside) else np.full(len(MODES), np.nan)
    return {
        "mode_amplitude": np.abs(modes),
        "mode_phase": np.angle(modes),
        "mode_pattern_speed": speed,
        "ring_mode_amplitude": np.abs(ring),
        "ring_mode_phase": np.angle(ring),
    }


def _ratio(error: float, scale: float) -> float:
    return float(error / scale) if scale > 0 else float(error)
