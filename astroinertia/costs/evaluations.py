"""What a step of particles is made of, and what its parts take on a machine."""

import math
from dataclasses import dataclass

import numpy as np

from astroinertia.costs.machine import REFERENCE_NEIGHBOURS, Machine, Seconds
from astroinertia.scene import gravity_costs
from astroinertia.scene.plan import gravity_method, smoothing
from astroinertia.scene.schema import Scene

# Of the pass over neighbours that gravity's softening, pressure and viscosity share, each one's part: an apportionment,
# not measured, with which runs of one, two and three of them come out (tests/benchmarks/results/predictions.md).
FORCE_SHARES = {"gravity": 0.25, "pressure": 0.4}
BY_NEIGHBOURS = 0.6  # of a pass, what goes with the number of neighbours; lists and whole leaves do not
FURTHER_SHARE = 0.35  # viscosity's, and that of any other effect between neighbours
SHARES = 50  # equal parts of a run's time, after which it is known how much of its work is done
EFFECTS_IN_REST = 3  # that the calibration's "rest" is of
REST_OF_EFFECT = 0.15  # of that rest: each effect's accelerations and its ledger


@dataclass(frozen=True)
class Counts:
    """Steps of a run; evaluations of particles over their number; ends of intervals. All alike with global steps.

    done: share of them that is over after each part of the run's time, (SHARES + 1,) from 0 to 1.
    """

    steps: float
    evaluations: float
    ends: float
    by: str
    done: tuple[float, ...]

    def at_most(self, steps: float) -> "Counts":
        """The same run, ended after so many steps."""
        part = min(1.0, steps / self.steps)
        done = tuple(min(1.0, share / part) for share in self.done)
        return Counts(part * self.steps, part * self.evaluations, part * self.ends, self.by, done)

    def meeting(self, times: float, evaluations: float = 1.0, ends: float = 1.0) -> "Counts":
        """The same run, in which steps are shortened to meet so many times, equally far apart.

        From one time to the next it takes half a step more, as steps are rounded up, or one where they are longer.
        evaluations, ends: that each further step takes.
        """
        of_steps, of_work = self.steps * np.diff(self.done), np.diff(self.done)
        apart = times / SHARES
        more = np.maximum(0.5 * apart, apart - of_steps)
        further, work = float(more.sum()), self.evaluations * of_work + evaluations * more
        done = (0.0, *map(float, np.cumsum(work) / work.sum()))
        return Counts(self.steps + further, float(work.sum()), self.ends + ends * further, self.by, done)


def evaluation(scene: Scene, particles: int, machine: Machine) -> dict[str, Seconds]:
    """What one evaluation of all particles takes, by its parts; those of effects under their kinds."""
    costs = machine.seconds
    more = particles * (1.0 - BY_NEIGHBOURS + BY_NEIGHBOURS * smoothing(scene)[1] / REFERENCE_NEIGHBOURS)

    def passed(name: str) -> Seconds:
        return costs[f"fixed.{name}"] + more * costs[f"{scene.precision}.{name}"]

    near = [kind for kind in scene.effects if kind == "gravity" or scene.entries[kind].cost == "neighbours"]
    parts = {"density": passed("density")}
    for kind in near:
        part = FORCE_SHARES.get(kind, FURTHER_SHARE) * passed("forces")
        asks = scene.entries[kind].gradients
        if asks is not None and asks(scene.effects[kind]):
            part = part + passed("gradients")
        parts[kind] = part
    if "gravity" in scene.effects:
        parts["gravity"] = parts["gravity"] + gravity(scene, particles, machine)
    rest = costs["fixed.rest"] + particles * costs["rest"]
    common = 1.0 - EFFECTS_IN_REST * REST_OF_EFFECT
    for kind in scene.effects:
        parts[kind] = parts.get(kind, Seconds()) + REST_OF_EFFECT * rest
    return parts | {"drift, ledger and time step": common * rest}


def gravity(scene: Scene, particles: int, machine: Machine) -> Seconds:
    """The attraction of all pairs."""
    costs, precision = machine.seconds, scene.precision
    if gravity_method(scene, particles) == "direct":
        return costs["fixed.direct"] + float(particles) ** 2 * costs[f"{precision}.direct"]
    error = scene.effects["gravity"]["force_error"]
    growth = gravity_costs.COSTS["numba_cpu", precision].growth
    costlier = (gravity_costs.FORCE_ERROR / error) ** growth
    return costs["fixed.multipole"] + costlier * particles * costs[f"{precision}.multipole"]


def run_of_steps(scene: Scene, particles: int, counts: Counts, machine: Machine) -> dict[str, Seconds]:
    """What all steps of a run take, by their parts."""
    plain = evaluation(scene, particles, machine)
    if scene.numerics.timesteps == "global":
        return {name: counts.steps * cost for name, cost in plain.items()}
    # A few active particles take their share of every pass, and each end of an interval what it takes by itself.
    by_particle = evaluation(scene, particles, _without_fixed(machine))
    costs = machine.seconds
    parts = {name: counts.evaluations * cost for name, cost in by_particle.items()}
    ends = counts.ends * costs["individual.end"]
    return parts | {"ends of intervals": ends + counts.evaluations * particles * costs["individual.particle"]}


def _without_fixed(machine: Machine) -> Machine:
    free = {name: Seconds() if name.startswith("fixed.") else cost for name, cost in machine.seconds.items()}
    return Machine(free, machine.memory, machine.calibrated, machine.description)


def settling_steps(particles: int) -> float:
    """Steps of the descent in which a body settles, about (models.sph.relaxation)."""
    return 120.0 * max(1.0, math.log10(particles / 100.0))
