"""What a pilot run reported on the steps of particles, and how they grow with their number: plain arrays, no engine.

Every limit of the time step has its power of the number of particles: sound crosses a smoothing length, h ~ N^(-1/3),
while free fall knows none. The pilot's limits, each carried over to the number that is asked about, give the steps that
many particles take through the same flow; what they resolve that few do not, they cannot tell. A pilot is kept in the
user's cache and serves every number of particles. Tests: tests/unit/costs/test_costs.py and
tests/physics/test_predicted_steps.py.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from astroinertia.costs.evaluations import SHARES, Counts
from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.scene.schema import Scene
from astroinertia.storage import cache

PILOT = "a pilot run"
PARTICLES = 300  # of a pilot, of all bodies
LAST = 0.25  # of the time that was followed: as it was last
_VERSION = 1  # part of the cache key: raise it when a pilot's outcome changes meaning
# Powers of the number of particles that limits fall with, as those of effects do (Entry.limit_power); others do not.
GROWTH = {"contact": 1.0 / 3.0, "acceleration": 1.0 / 6.0} | {
    kind: entry.limit_power for kind, entry in CATALOGUE.items()
}


@dataclass(frozen=True)
class Pilot:
    """A run with few particles: for each of its steps, (K,), what it took of the time.

    limits: (K, C), the shortest by each of the criteria; evaluations (K,) of particles over their number, and ends (K,)
    of intervals, both 1 with global steps; reached: share of the run that was followed; processor seconds of its
    steps.
    """

    particles: int
    length: np.ndarray
    criteria: tuple[str, ...]
    limits: np.ndarray
    evaluations: np.ndarray
    ends: np.ndarray
    reached: float
    seconds: float

    def counts(self, particles: int) -> Counts:
        """What a run of so many particles takes."""
        growing = np.array([GROWTH.get(name, 0.0) for name in self.criteria])
        scaled = self.limits * (particles / self.particles) ** -growing
        more = self.limits.min(axis=1) / scaled.min(axis=1)
        steps = np.ones_like(more)
        by_chunk = np.stack([steps, self.evaluations, self.ends]) * more
        totals, passed = by_chunk.sum(axis=1), np.cumsum(self.length)
        if self.reached < 1.0:
            last = passed > (1.0 - LAST) * passed[-1]
            pace = by_chunk[:, last].sum(axis=1) / self.length[last].sum()
            totals = totals + pace * passed[-1] * (1.0 / self.reached - 1.0)
        by = PILOT if self.reached >= 1.0 else f"{PILOT} of the first {self.reached:.0%}"
        work = np.cumsum(by_chunk[1]) / totals[1]
        over, done = np.array([0.0, *passed / passed[-1] * self.reached, 1.0]), np.array([0.0, *work, 1.0])
        shares = np.interp(np.linspace(0.0, 1.0, SHARES + 1), over, done)
        alike = float(more[self.ends == 1.0].sum() / more.sum())
        return Counts(*map(float, totals), by=by, done=tuple(map(float, shares)), alike=alike)


def kept(scene: Scene) -> Pilot | None:
    """A pilot of this scene that was run before, with whatever number of particles; None if there is none."""
    stored = cache.load("pilot", key(scene))
    try:
        return None if stored is None else _unpacked(stored)
    except (KeyError, ValueError, TypeError):
        return None


def with_particles(scene: Scene, particles: int) -> Scene:
    """The scene with so many particles in all, placed but not settled."""
    assert scene.particles is not None
    share = particles / scene.particles
    return scene.with_bodies(lambda body: {"particles": max(16, math.ceil(body.particles * share)), "relax": False})


def key(scene: Scene) -> str:
    """Under which the pilot of a scene is kept: all but its number of particles and what it writes."""
    few: Any = with_particles(scene, PARTICLES).model_dump(exclude={"output", "source", "overrides", "description"})
    return cache.content_key(scene=repr(sorted(few.items())), version=_VERSION)


def _unpacked(stored: dict[str, np.ndarray]) -> Pilot | None:
    arrays = {name: stored[name].astype(float) for name in ("length", "limits", "evaluations", "ends")}
    criteria = tuple(map(str, stored["criteria"]))
    count = len(arrays["length"])
    shapes = {name: array.shape for name, array in arrays.items()}
    wanted = {"length": (count,), "limits": (count, len(criteria)), "evaluations": (count,), "ends": (count,)}
    numbers = [float(stored[name]) for name in ("particles", "reached", "seconds")]
    sound = all((array > 0.0).all() for array in arrays.values()) and all(number > 0.0 for number in numbers)
    if shapes != wanted or not count or not sound:
        return None
    return Pilot(int(numbers[0]), arrays["length"], criteria, arrays["limits"], arrays["evaluations"], arrays["ends"],
                 min(1.0, numbers[1]), numbers[2])  # fmt: skip
