"""What a step of particles is made of, and what its parts take on a machine."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from astroinertia.costs import experience
from astroinertia.costs.machine import REFERENCE_NEIGHBOURS, Machine
from astroinertia.process.stopwatch import Seconds, total
from astroinertia.scene import gravity_costs
from astroinertia.scene.plan import gravity_method, smoothing
from astroinertia.scene.schema import Scene

# Of the pass over neighbours that gravity's softening, pressure and viscosity share, each one's part, as measured on
# the cloud of `calibrate`; gravity has none where all pairs are summed.
FORCE_SHARES = {"gravity": 0.25, "pressure": 0.4}
BY_NEIGHBOURS = 0.6  # of a pass, what goes with the number of neighbours; lists and whole leaves do not
FURTHER_SHARE = 0.35  # viscosity's, and that of any other effect between neighbours
SHARES = 50  # equal parts of a run's time, after which it is known how much of its work is done
EVENLY_DONE = tuple(share / SHARES for share in range(SHARES + 1))  # of work that goes on at one pace
ACCURACY = (
    0.05  # relative, of the number of steps from one time to the next: it is one more where that is just too much
)
# Intervals in powers of two of any base step over what their limits ask for, less a margin of 5 %, on average.
ROUNDED = 1.0 / (0.95 * math.log(2.0))
EFFECTS_IN_REST = 3.5  # that the calibration's "rest" is of, viscosity counted as BY_GRADIENTS
REST_OF_EFFECT = 0.14  # of that rest: each effect's accelerations and its ledger
BY_GRADIENTS, OF_WHOLE_BODY = 1.5, 3.0  # over that, of what gradients are used by, and of what sorts the whole body
REST_OF_REGION = 0.35  # over that rest: a ledger of its own
REST_OF_MATTER = 0.2  # over that rest: pressures of several pieces, or from tables
# Over the same, of a periodic box: images are made, chosen and put in order, and each of them is summed over.
REST_OF_BOX, REST_OF_IMAGE = 0.5, 2.0
IMAGES_REACH = 1.1  # times that of kernels, that images are made for (engines.periodic)
# Over the fixed part of that rest: limits of each particle and what several rungs would cost, where one interval is
# chosen for all.
REST_OF_CHOICE = 0.25
PASSES = "density", "gradients", "forces", "multipole"  # of an evaluation of the calibration's cloud


@dataclass(frozen=True)
class Counts:
    """Steps of a run; evaluations of particles over their number; ends of intervals. All alike with global steps.

    done: share of them that is over after each part of the run's time, (SHARES + 1,) from 0 to 1. crowding: the mean
    number of neighbours over that at the start. alike: of individual steps, the share of base steps that are of one
    interval for all. first: what the first step may be at most by each criterion, in code units, where it is known.
    """

    steps: float
    evaluations: float
    ends: float
    by: str
    done: tuple[float, ...]
    crowding: float = 1.0
    alike: float = 0.0
    first: Mapping[str, float] = field(default_factory=dict)

    def at_most(self, steps: float) -> "Counts":
        """The same run, ended after so many steps."""
        part = min(1.0, steps / self.steps)
        done = tuple(min(1.0, share / part) for share in self.done)
        own, evaluations, ends = part * self.steps, part * self.evaluations, part * self.ends
        return replace(self, steps=own, evaluations=evaluations, ends=ends, done=done)

    def meeting(self, times: float) -> "Counts":
        """The same run, in which steps are shortened to meet so many times, equally far apart.

        From one time to the next steps are rounded up to a whole number: by a half, or to one where they are longer.
        """
        if not times > 0.0:
            return self
        own, work, ends = (count * np.diff(self.done) for count in (self.steps, self.evaluations, self.ends))
        apart = times / SHARES
        steps = own + apart * (rounded_up(own / apart) - own / apart)
        within, met = self.ends - self.steps, steps
        if within > 0.0:
            # A base step that ends elsewhere is still divided in powers of two.
            met = np.maximum(steps, (1.0 + (ROUNDED - 1.0) * np.minimum(1.0, apart / steps)) * ends)
            # Some particles are evaluated where intervals end within a base step, all where that ends.
            active = (self.evaluations - self.steps) / within
            work = work + active * ((met - steps) - (ends - own))
        work = work + (steps - own)
        done = (0.0, *map(float, np.cumsum(work) / work.sum()))
        totals = {"steps": float(steps.sum()), "evaluations": float(work.sum()), "ends": float(met.sum())}
        return replace(self, done=done, **totals)


def rounded_up(steps: np.ndarray) -> np.ndarray:
    """The least whole number (K,) that is not less, in the mean over what steps (K,) may be within their accuracy."""

    def integral(x: np.ndarray) -> np.ndarray:
        return (np.floor(x) + 1.0) * (x - 0.5 * np.floor(x))

    few = np.minimum(steps, 1e6)  # to more of them half a step is added as well; their squares could overflow
    width = 2.0 * ACCURACY * few
    spread = integral((1.0 + ACCURACY) * few) - integral((1.0 - ACCURACY) * few)
    return np.where(width > 0.0, spread / np.where(width > 0.0, width, 1.0), 1.0) + (steps - few)


def evaluation(scene: Scene, particles: int, machine: Machine, crowding: float = 1.0) -> dict[str, Seconds]:
    """What one evaluation of all particles takes, by its parts; those of effects under their kinds.

    crowding: how many times more neighbours they have than a fluid of even density.
    """
    costs, neighbours = machine.seconds, crowding * smoothing(scene)[1]
    few = experience.few(scene)
    more = 1.0 - BY_NEIGHBOURS + BY_NEIGHBOURS * neighbours / REFERENCE_NEIGHBOURS
    by = "few" if few else scene.precision

    def passed(name: str) -> Seconds:
        return costs[f"fixed.{name}"] + more * particles * costs[f"{by}.{name}"]

    parts = {"density": passed("density")}
    rest = costs["fixed.rest"] + particles * costs["few.rest" if few else "rest"]
    for kind, options in scene.effects.items():
        entry = scene.entries[kind]
        uses_gradients = entry.gradients is not None and entry.gradients(options)
        times = BY_GRADIENTS if uses_gradients else OF_WHOLE_BODY if entry.cost == "body" else 1.0
        part = times * REST_OF_EFFECT * rest
        if kind == "gravity" and gravity_method(scene, particles) == "direct":
            part = part + gravity(scene, particles, machine)
        elif near(scene, kind):
            part = part + FORCE_SHARES.get(kind, FURTHER_SHARE) * passed("forces")
            part = part + gravity(scene, particles, machine) if kind == "gravity" else part
        parts[kind] = part + passed("gradients") if uses_gradients else part
    fluid = scene.equation_of_state
    if "pressure" in parts and fluid is not None and (fluid.pieces or fluid.made_by):
        parts["pressure"] = parts["pressure"] + REST_OF_MATTER * rest
    if scene.regions:
        parts["regions"] = len(scene.regions) * REST_OF_REGION * rest
    if scene.box is not None:
        of_images = REST_OF_IMAGE * images(scene, particles) * costs["rest"]
        parts["images beyond the box"] = REST_OF_BOX * costs["fixed.rest"] + of_images
    return parts | {"drift, ledger and time step": (1.0 - EFFECTS_IN_REST * REST_OF_EFFECT) * rest}


def images(scene: Scene, particles: int) -> float:
    """How many images so many particles have that fill a box evenly: those within reach of what is in it."""
    box: Any = scene.box
    lengths = np.array(box.lengths)
    reach = (lengths.prod() / particles * smoothing(scene)[1] * 3.0 / (4.0 * math.pi)) ** (1.0 / 3.0)
    along = 1.0 + 2.0 * IMAGES_REACH * reach / lengths[np.array(box.repeats)]
    return particles * (float(along.prod()) - 1.0)


def gravity(scene: Scene, particles: int, machine: Machine) -> Seconds:
    """The attraction of all pairs."""
    costs, by = machine.seconds, "few" if experience.few(scene) else scene.precision
    if gravity_method(scene, particles) == "direct":
        return costs["fixed.direct"] + float(particles) ** 2 * costs[f"{by}.direct"]
    error = scene.effects["gravity"]["force_error"]
    growth = gravity_costs.COSTS["numba_cpu", scene.precision].growth
    costlier = (gravity_costs.FORCE_ERROR / error) ** growth
    return costs["fixed.multipole"] + costlier * particles * costs[f"{by}.multipole"]


def run_of_steps(scene: Scene, particles: int, counts: Counts, machine: Machine) -> dict[str, Seconds]:
    """What all steps of a run take, by their parts."""
    plain = evaluation(scene, particles, machine, counts.crowding)
    if scene.numerics.timesteps == "global":
        return {name: counts.steps * cost for name, cost in plain.items()}
    # A few active particles take their share of every pass, and nested sets are summed over again; each base step takes
    # what it does to begin, and each end of an interval what it takes by itself.
    costs = machine.seconds
    nested = _over(costs["individual.particle"], total(costs[f"mixed.{name}"] for name in PASSES))
    alike = counts.alike * counts.steps  # base steps that are global ones
    steps, evaluations, within = (count - alike for count in (counts.steps, counts.evaluations, counts.ends))
    parts = {
        name: evaluations * Seconds((1.0 + nested.wall) * cost.wall, (1.0 + nested.processor) * cost.processor)
        + alike * plain[name]
        for name, cost in evaluation(scene, particles, _without_fixed(machine), counts.crowding).items()
    }
    begun = steps * (costs["individual.base"] + particles * costs["individual.base.particle"])
    begun = begun + alike * REST_OF_CHOICE * costs["fixed.rest"]
    ends = within * costs["individual.end"]
    if scene.regions:
        ends = ends + within * len(scene.regions) * REST_OF_REGION * costs["fixed.rest"]
    return parts | {"beginnings of base steps": begun, "ends of intervals": ends}


def near(scene: Scene, kind: str) -> bool:
    """Whether an effect acts between neighbours; gravity does by its softening."""
    return kind == "gravity" or scene.entries[kind].cost == "neighbours"


def _over(part: Seconds, whole: Seconds) -> Seconds:
    """The two over each other; nothing of nothing."""
    return Seconds(part.wall / (whole.wall or math.inf), part.processor / (whole.processor or math.inf))


def _without_fixed(machine: Machine) -> Machine:
    free = {name: Seconds() if name.startswith("fixed.") else cost for name, cost in machine.seconds.items()}
    return Machine(free, machine.memory, machine.calibrated, machine.description)


def settling_steps(particles: int) -> float:
    """Steps of the descent in which a body settles, about (models.sph.relaxation)."""
    return 120.0 * max(1.0, math.log10(particles / 100.0))
