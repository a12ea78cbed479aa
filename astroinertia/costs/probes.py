"""What `calibrate` times, in an interpreter of its own: python -m astroinertia.costs.probes KIND LAUNCHED.

KIND is sph, ellipsoid or rigid, LAUNCHED the time at which it was started. It writes one line of JSON:
{"seconds": {name: [wall, processor]}, "memory": bytes of a run that does next to nothing, "last": bytes at the end,
"prepared": [wall, processor] since it was started}.
"""

import json
import math
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import numpy as np

from astroinertia import dataset
from astroinertia.build.assemble import metadata, model_description, prepare
from astroinertia.costs.evaluations import PASSES
from astroinertia.costs.machine import PRECISIONS, peak_memory
from astroinertia.costs.probe_scenes import CLOUD, COMPANION, ELLIPSOID, RIGID, SCALING
from astroinertia.models.sph.evaluate import pair_fields
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.process.stopwatch import Seconds, Stopwatch, less, now, since, total, watched
from astroinertia.rotation.ephemeris import ephemeris
from astroinertia.scene import load
from astroinertia.sph import placement, profiles
from astroinertia.storage.archive import Archive

FEWEST, FEW, MANY = 100, 1000, 5000  # particles: what a pass takes however few there are, and what each of them adds
BY_THEMSELVES = 400  # particles with steps of their own, beside MANY
WARM, STEPS = 3, 8  # steps before, and steps that are timed
EVALUATIONS = 3e4  # of particles, at least, in base steps of individual ones
GLASS = 2000
TURNS = 500.0  # of a companion
Pairs = dict[str, Seconds]


def cloud(particles: int, **settings: str) -> Any:
    """Evrard's cloud at time 0, under way; settings by their keys with __ for dots."""
    overrides = [f"{key.replace('__', '.')}={value}" for key, value in settings.items()]
    return prepare(load.loads(CLOUD, [f"body.particles={particles}", *overrides])).evolution


def steps_of(body: Any, count: int) -> Pairs:
    """What each part of one step takes, on average; "rest" is what no pass over pairs does."""
    watch = Stopwatch("rest")

    def sums(_: Any, __: Any, ___: Any, terms: Any, *____: Any, **_____: Any) -> str:
        return "forces" if any(term.effect == "pressure" for term in terms) else "gradients"

    attraction, engine = type(body.problem.effects[0]), type(body.problem.engine)
    parts = {"density": "density", "listed": "density", "neighbour_sums": sums}
    measured = []
    with watched(
        watch, {(engine, name): part for name, part in parts.items()} | {(attraction, "own_sums"): "multipole"}
    ):
        for _ in range(count):
            watch.seconds.clear()
            watch.timed("rest", lambda: body.advance(body.end))
            measured.append(dict(watch.seconds))
    return {name: middle([step[name] for step in measured]) for name in measured[0]} | {"direct": _direct(body)}


def _direct(body: Any) -> Seconds:
    """The attraction of all pairs by direct sums."""
    problem, fluid = body.problem, body.state.rates.fluid
    terms = replace(problem.effects[0], method="direct").all_pair_terms
    fields = pair_fields(problem, fluid)
    times = []
    for _ in range(4):
        begin = now()
        problem.engine.all_pair_sums(body.arrangement.pairs, problem.kernel, terms, fields)
        times.append(since(begin))
    return middle(times[1:])  # the first has compiled it


def middle(times: list[Seconds]) -> Seconds:
    """The median by the wall, which other work delays now and then, and the mean by the processor."""
    return Seconds(statistics.median(cost.wall for cost in times), statistics.fmean(cost.processor for cost in times))


def line(few: Seconds, many: Seconds, counts: tuple[int, int], power: int = 1) -> tuple[Seconds, Seconds]:
    """What so many particles take as (fixed, a particle or, with power 2, a pair)."""
    fewest, most = (count**power for count in counts)

    def fitted(a: float, b: float) -> tuple[float, float]:
        slope = max(0.0, (b - a) / (most - fewest))
        return max(0.0, a - slope * fewest), slope

    (fixed, slope), (fixed_cpu, slope_cpu) = fitted(few.wall, many.wall), fitted(few.processor, many.processor)
    return Seconds(fixed, fixed_cpu), Seconds(slope, slope_cpu)


def particle_costs() -> Pairs:
    """Costs of passes, records, individual steps and placing."""
    costs: Pairs = {}
    (fewest, _), (few, recorded) = (_measured(count, "float64") for count in (FEWEST, FEW))
    for name in few:
        fixed, slope = line(fewest[name], few[name], (FEWEST, FEW), _power(name))
        costs |= {f"fixed.{name}": fixed, f"few.{name}": slope}
    rests = []
    for precision in PRECISIONS:
        many, record = _measured(MANY, precision)
        for name, taken in many.items():
            slope = less(taken, costs[f"fixed.{name}"]) * (1.0 / MANY ** _power(name))
            if name == "rest":
                rests.append(slope)
            else:
                costs[f"{precision}.{name}"] = slope
        if precision == "mixed":
            costs["record"], costs["record.particle"] = line(recorded, record, (FEW, MANY))
    costs["rest"] = middle(rests)
    costs |= _individual(costs)
    begin = now()
    placement.glass(profiles.uniform(), GLASS, 1)
    return costs | {"place.particle": since(begin) * (1.0 / GLASS)}


def _measured(particles: int, precision: str) -> tuple[Pairs, Seconds]:
    """Of so many particles of the cloud, the parts of a step and a record."""
    body = cloud(particles, numerics__precision=precision)
    for _ in range(WARM):
        body.advance(body.end)
    step = steps_of(body, STEPS)
    return step, _record(body, step)


def _power(name: str) -> int:
    """Of the number of particles, that what a pass takes grows with."""
    return 2 if name == "direct" else 1


def _record(body: Any, step: Pairs) -> Seconds:
    """A record, less the forces that it sums once more for their virials."""
    body.record(0.0)
    times = []
    for _ in range(3):
        begin = now()
        body.record(0.0)
        times.append(since(begin))
    return less(middle(times), step["forces"] + step["multipole"])


def _individual(costs: Pairs) -> Pairs:
    """Of individual steps: what a base step takes to begin, the ends of intervals within it, and a particle there."""
    passes = total(costs[f"mixed.{name}"] for name in PASSES)
    plain, further = [], []
    counts = BY_THEMSELVES, MANY
    for particles in counts:
        body = cloud(particles, numerics__precision="mixed", numerics__timesteps="individual")
        # An eighth of them next to each other with an eighth of the interval, whether that pays or not; all with one.
        block, shortest = np.arange(particles) < particles // 8, float(body.state.rates.timestep)
        ends, evaluations, taken = _of_base_steps(body, np.where(block, 3, 0), passes, 4.0 * shortest, 20)
        *_, least = _of_base_steps(body, np.zeros(particles, np.int64), passes, 0.5 * shortest, STEPS)
        plain.append(least)
        further.append((ends - 1.0, evaluations - particles, less(taken, least)))
    matrix = np.array([row[:2] for row in further])
    solution = np.linalg.solve(matrix, np.array([[rest.wall, rest.processor] for *_, rest in further]))
    # A particle in a nested set may take less than its share of a plain pass over all of them.
    end, particle = (Seconds(*map(float, row)) for row in np.maximum(solution, 0.0))
    few, many = (less(least, end + count * particle) for count, least in zip(counts, plain, strict=True))
    base, base_particle = line(few, many, counts)
    return {
        "individual.base": base, "individual.base.particle": base_particle,
        "individual.end": end, "individual.particle": particle,
    }  # fmt: skip


def _of_base_steps(
    body: Any, rung: np.ndarray, passes: Seconds, length: float, times: int
) -> tuple[float, float, Seconds]:
    """Of a base step with those rungs: ends of intervals, evaluations, and what it takes beside its passes."""
    tallies, step = [], body.base_step
    body.base_step = lambda *arguments: _counted(step(*arguments, rung), tallies)
    body.advance(body.time + length)
    tallies.clear()
    begin, evaluations, ends = now(), 0, 0
    while evaluations < min(EVALUATIONS, times * len(body.state.mass)):
        body.advance(min(body.end, body.time + length))
        evaluations, ends = (sum(getattr(tally, name) for tally in tallies) for name in ("evaluations", "ends"))
    body.base_step, once = step, 1.0 / len(tallies)
    return once * ends, once * evaluations, once * less(since(begin), evaluations * passes)


def _counted(result: Any, tallies: list[Any]) -> Any:
    tallies.append(result[2])
    return result


def written(scene: Any, body: Any) -> Pairs:
    """A checkpoint, the fixed part of it, and a byte of the segments and the final file."""
    with (
        tempfile.TemporaryDirectory() as folder,
        Archive.create(folder, metadata(scene) | model_description(body)) as archive,
    ):
        record = {**body.record(0.0), "wall_time": 0.0}
        archive.write_segment([record])
        begin = now()
        archive.write_checkpoint({}, {})
        archive.write_segment([record])
        fixed = since(begin)
        snapshot = {"time": 0.0, **{name: np.random.default_rng(1).normal(size=200_000) for name in "abcde"}}
        begin = now()
        archive.write_segment([record], [snapshot])
        dataset.finish(archive)
        taken = since(begin)
        size = sum(path.stat().st_size for path in Path(folder).iterdir())
    return {"write": fixed, "write.byte": taken * (1.0 / size)}


def of_particles() -> Pairs:
    """All costs of particles."""
    return particle_costs() | written(*_first("sph"))


def of_ellipsoid() -> Pairs:
    """A step of the affine body, and a record; one of the scaling laws, too."""
    scaling = prepare(load.loads(SCALING)).evolution
    body = prepare(load.loads(ELLIPSOID)).evolution
    body.advance(1.0)
    body.record(0.0)
    return {"step.ellipsoid": _stepped(body, 100.0), "record.ellipsoid": _recorded(body, 110.0),
            "record.scaling": _recorded(scaling, 0.5)}  # fmt: skip


def of_rigid() -> Pairs:
    """Steps, records and starts of both integrators; what a companion adds to the start."""
    costs, first = {}, {}
    for integrator, until in (("splitting", 3e3), ("adaptive", 300.0)):
        body = prepare(load.loads(RIGID, [f'numerics.integrator="{integrator}"'])).evolution
        first[integrator] = _timed(lambda body=body: body.advance(1.0))
        body.record(0.0)
        costs[f"step.{integrator}"] = _stepped(body, until)
        costs[f"record.{integrator}"] = _recorded_at_once(body, 1.1 * until)
    companion = _timed(_with_companion)
    return costs | {"prepare.adaptive": first["adaptive"], "companions": companion, "orbit": _turn()}


def _turn() -> Seconds:
    """Of a companion on a circle, to be tabulated."""
    pair = simulation(1.0, [Companion("moon", 0.0, period=1.0)])
    return _timed(lambda: ephemeris(pair, TURNS)) * (1.0 / TURNS)


def _with_companion() -> None:
    body = prepare(load.loads(RIGID + COMPANION)).evolution
    body.advance(1.0)
    body.record(0.0)


def _timed(action: Callable[[], Any]) -> Seconds:
    begin = now()
    action()
    return since(begin)


def _stepped(body: Any, until: float) -> Seconds:
    """Of one step on the way."""
    before, begin = body.steps, now()
    _go_to(body, until)
    return since(begin) * (1.0 / (body.steps - before))


def _go_to(body: Any, until: float) -> None:
    while body.time < until:
        body.advance(until)


def _recorded(body: Any, until: float) -> Seconds:
    """Of one record of many, and of coming to it: in no time at all."""
    times = []
    _go_to(body, until)
    for number in range(10):
        begin = now()
        body.advance(until * (1.0 + 1e-9 * (number + 1)))
        body.record(0.0)
        times.append(since(begin))
    return middle(times)


def _recorded_at_once(body: Any, until: float) -> Seconds:
    """The same of a body that goes through many outputs in one call."""
    _go_to(body, until)
    begin = now()
    rows = body.through([until * (1.0 + 1e-9 * (number + 1)) for number in range(200)], 0.0, math.inf)
    return since(begin) * (1.0 / len(rows))


PROBES = {"sph": of_particles, "ellipsoid": of_ellipsoid, "rigid": of_rigid}
TEXTS = {"sph": CLOUD, "ellipsoid": ELLIPSOID, "rigid": RIGID}
FIRST = {"sph": "body.particles=64", "rigid": 'numerics.integrator="splitting"'}


def _first(kind: str) -> tuple[Any, Any]:
    """A scene of the kind that does next to nothing, and its body after a step and a record."""
    scene = load.loads(TEXTS[kind], [FIRST[kind]] if kind in FIRST else [])
    body = prepare(scene).evolution
    body.advance(1e-3)
    body.record(0.0)
    return scene, body


def main(kind: str, launched: str) -> None:
    """Carry out one probe and tell."""
    with jax.enable_x64(True):
        written(*_first(kind))  # as a run does, so that memory is that of one
        prepared = Seconds(time.time() - float(launched), time.process_time())
        memory = peak_memory()
        seconds = PROBES[kind]()
        last = peak_memory()
    timings = {name: [cost.wall, cost.processor] for name, cost in seconds.items()}
    content = {"seconds": timings, "memory": memory, "last": last, "prepared": [prepared.wall, prepared.processor]}
    sys.stdout.write(json.dumps(content) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
