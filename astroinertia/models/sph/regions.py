"""Regions of a particle body under way: whose matter is whose, and one row of the headline series for each.

Membership is judged when a row is recorded; between two records a region is the matter that it then held, and its
ledger follow that. Only scenes with regions import this. Tests: tests/unit/ledger/test_regions.py,
tests/physics/test_regions.py.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from astroinertia.engines import numba_cpu
from astroinertia.gravity.direct import DIRECT_GRAVITY
from astroinertia.gravity.point_masses import specific_potential
from astroinertia.inertia.tensor import axial_vector, inertia_from_second_moment
from astroinertia.ledger.moments import centre_of_mass, weighted_outer
from astroinertia.ledger.regions import RegionLedger, open_region_ledger, region_moments
from astroinertia.models.sph import membership
from astroinertia.models.sph.evaluate import effect_accelerations
from astroinertia.models.sph.points import moving
from astroinertia.models.sph.state import Problem, State, member_key

FEW = 4096  # particles that plain sums over all pairs are quicker for
FORCE_ERROR = 1e-4  # of the expansions that more particles' potential is found by; energies are some 10 times better


@dataclass(frozen=True)
class Region:
    """What a region holds, in code units: exactly one of innermost_mass, density_above and bound.

    centre: what the innermost mass is about, "densest" or "centre_of_mass"; internal_energy: whether it counts against
    being bound.
    """

    name: str
    innermost_mass: float | None = None
    density_above: float | None = None
    bound: bool = False
    centre: str = "densest"
    internal_energy: bool = False


@dataclass(frozen=True)
class Regions:
    """The regions of a run and the physics of its body."""

    problem: Problem
    regions: Sequence[Region]

    def opened(self, state: State) -> State:
        """The state with members and ledger of every region."""
        mass, position, velocity = _arrays(state)
        members = {region.name: self._member(region, state) for region in self.regions}
        ledgers = {
            name: open_region_ledger(mass, position, velocity, member, len(self.problem.effects))
            for name, member in members.items()
        }
        return self._with(state, members, ledgers)

    def with_room(self, state: State) -> State:
        """A state with the structure that regions give it, empty: what a checkpoint is read into."""
        nothing = {region.name: np.zeros(state.mass.shape[0]) for region in self.regions}
        effects = len(self.problem.effects)
        ledgers = {name: open_region_ledger(*_arrays(state), none, effects) for name, none in nothing.items()}
        return self._with(state, nothing, ledgers)

    def updated(self, state: State) -> State:
        """The state with membership judged again, and what crossed an edge in the ledger."""
        arrays = _arrays(state)
        members = {region.name: self._member(region, state) for region in self.regions}
        ledgers = {
            name: state.regions[name].exchanged(*arrays, np.asarray(state.memory[member_key(name)]), member)
            for name, member in members.items()
        }
        return self._with(state, members, ledgers)

    def record(self, state: State) -> dict[str, np.ndarray]:
        """What is recorded of every region, in code units, with regions as the first axis."""
        rows = [self._row(state, region.name) for region in self.regions]
        return {name: np.stack([row[name] for row in rows]) for name in rows[0]}

    def _with(self, state: State, members: dict[str, np.ndarray], ledgers: dict[str, RegionLedger]) -> State:
        xp = self.problem.engine.xp
        memory = {**state.memory, **{member_key(name): xp.asarray(member) for name, member in members.items()}}
        return replace(state, memory=memory, regions=ledgers)

    def _member(self, region: Region, state: State) -> np.ndarray:
        mass, position, velocity = _arrays(state)
        density = np.asarray(state.rates.fluid.density)
        if region.innermost_mass is not None:
            densest = region.centre == "densest"
            centre = membership.densest_point(mass, position, density) if densest else centre_of_mass(mass, position)
            return membership.innermost(mass, position, centre, region.innermost_mass)
        if region.density_above is not None:
            return membership.dense(density, region.density_above)
        energy = np.asarray(state.rates.fluid.internal_energy) if region.internal_energy else 0.0
        stars = [group for group in moving(state.points) if group.of_body]
        pull = np.zeros_like(mass)
        for group in stars:
            pull += specific_potential(np, position, group.mass, group.position, group.softening**2)
        points = (
            np.concatenate([np.zeros(0), *(group.mass for group in stars)]),
            np.concatenate([np.zeros((0, 3)), *(group.velocity for group in stars)]),
        )
        potential = np.asarray(state.rates.fluid.sums["gravity"]["potential"]) + pull
        return membership.bound(
            mass, velocity, energy, lambda chosen: self._potential(state, chosen) + pull[chosen], potential, points
        )

    def _potential(self, state: State, chosen: np.ndarray) -> np.ndarray:
        """Softened potential, (n,), of the particles `chosen` (n,) by themselves."""
        mass, position, length = (
            np.asarray(array)[chosen] for array in (state.mass, state.position, state.smoothing_length)
        )
        if len(chosen) > FEW:
            from astroinertia.gravity import multipole  # only where there are many

            return multipole.gravity(mass, position, length, self.problem.kernel, FORCE_ERROR)[1]
        engine = numba_cpu.Engine(precision="float64")
        order, pairs = engine.arrange(position, length)
        fields = {"mass": mass[order], "position": position[order], "smoothing_length": length[order]}
        sums = engine.all_pair_sums(pairs, self.problem.kernel, (DIRECT_GRAVITY,), fields)
        potential = np.empty(len(chosen))
        potential[order] = sums["gravity"]["potential"]
        return potential

    def _row(self, state: State, name: str) -> dict[str, Any]:
        arrays, region = _arrays(state), state.regions[name]
        member = np.asarray(state.memory[member_key(name)])
        chosen = np.flatnonzero(member)
        mass, position, _ = (array[chosen] for array in arrays)
        second, mixed, kinetic = region_moments(*arrays, member)
        direct, evolved = inertia_from_second_moment(second), np.asarray(region.ledger.inertia_tensor())
        density = np.asarray(state.rates.fluid.density)[chosen]
        occupied = len(chosen) > 0
        centre = np.asarray(region.whole.centre) if occupied else np.full(3, np.nan)
        accelerations = [np.asarray(a)[chosen] for a in effect_accelerations(self.problem.engine.xp, state.rates)]
        attracts = occupied and "gravity" in self.problem.effect_names
        largest = float(region.ledger.largest_inertia)
        return {
            "region_particles": float(len(chosen)),
            "region_mass": mass.sum(),
            "region_centre": centre,
            "region_velocity": np.asarray(region.whole.velocity) if occupied else np.full(3, np.nan),
            "region_second_moment": second,
            "region_mixed_moment": mixed,
            "region_kinetic_tensor": kinetic,
            "region_inertia_tensor": direct,
            "region_inertia_tensor_evolved": evolved,
            "region_ledger_closure": np.linalg.norm(evolved - direct) / largest if len(chosen) > 1 else 0.0,
            "region_angular_momentum": axial_vector(mixed),
            "region_virial_tensor": np.array(
                [weighted_outer(mass, position - centre, a) for a in accelerations]
            ).reshape(-1, 3, 3)
            if occupied
            else np.zeros((len(accelerations), 3, 3)),
            "region_mixed_impulse": np.asarray(region.ledger.mixed_impulse.total),
            "region_flux_mass": float(region.flux.mass),
            "region_flux_second_moment": np.asarray(region.flux.second_moment),
            "region_flux_mixed_moment": np.asarray(region.flux.mixed_moment),
            "region_flux_angular_momentum": axial_vector(np.asarray(region.flux.mixed_moment)),
            "region_gravitational_energy": 0.5 * float(mass @ self._potential(state, chosen)) if attracts else np.nan,
            "region_volume_radius": (0.75 / np.pi * (mass / density).sum()) ** (1 / 3) if occupied else np.nan,
            "region_density_max": density.max() if occupied else np.nan,
        }


def _arrays(state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    mass, position, velocity = (np.asarray(array) for array in (state.mass, state.position, state.velocity))
    return mass, position, velocity
