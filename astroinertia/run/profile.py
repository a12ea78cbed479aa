"""Where the time of a run went: seconds of its parts, for its file. Runs without a profile import nothing of this.

Parts are timed as they are called: passes of particles by the engine that carries them out, what an effect does by
itself by its name, ledger, records and writing; what is left of the whole run is between parts. Compiling within any
part is counted as compiling. The programs of the xla engine, and of models without particles, hold whole steps, which
have no parts that could be timed.
"""

import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, Self

from astroinertia.build.assemble import Prepared
from astroinertia.effects.parts import ParticleParts
from astroinertia.ledger.moments import Ledgers
from astroinertia.process import activity
from astroinertia.process.stopwatch import Places, Stopwatch, less, now, since, total, watched

START, PREPARING, COMPILING = "start", "preparing", "compiling"
DENSITY, GRADIENTS, FORCES, OTHER_SUMS = "density", "gradients", "forces", "other sums"
LEDGER, SORTING, REST, RECORDS, WRITING = "ledger", "sorting", "rest of steps", "records", "writing"
BETWEEN = "between parts"
# What an effect of particles does by itself.
OF_EFFECTS = ("own_sums", "acceleration", "exchange", "remember", "remember_sums")
OF_LEDGERS = ("drifted", "rounded", "kicked", "heated")


class Profile:
    """The times of one run, from when it is made until it is closed; `begun`: of time.monotonic(), as in run_scene."""

    def __init__(self, begun: float | None = None) -> None:
        self.watch, self.threads = Stopwatch(REST), 1
        self._stack, self._compiling, self._compiled_since = ExitStack(), 0, now()
        wall, processor = self._begin = now()
        if begun is not None:
            wall -= time.monotonic() - begun  # importing, by one thread
            self._begin = wall, max(0.0, processor - (self._begin[0] - wall))
            self.watch.seconds[START] += since(self._begin)

    def __enter__(self) -> Self:
        activity.listeners.append(self._compiles)
        self._stack.callback(activity.listeners.remove, self._compiles)
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def preparing(self, action: Callable[[], Any]) -> Any:
        """What an action returns that prepares the run."""
        return self.watch.timed(PREPARING, action)

    def attend(self, prepared: Prepared, archive: type) -> None:
        """Watch what carries out the run from now on."""
        body = prepared.evolution
        problem = getattr(body, "problem", None)
        engine = getattr(problem, "engine", None)
        self.threads = getattr(engine, "workers", 1)
        apart = engine is not None and engine.name != "xla"
        places = _places(type(body), archive) | (_of_particles(problem) if apart else {})
        self._stack.enter_context(watched(self.watch, places))

    def attributes(self) -> dict[str, Any]:
        """Of the run's dataset: names of parts, and as many seconds by the clock on the wall and of all threads.

        profile_threads: how many threads passes over particles are shared out over.
        """
        named = self.watch.seconds | {BETWEEN: less(since(self._begin), total(self.watch.seconds.values()))}
        parts = sorted(named.items(), key=lambda part: -part[1].wall)
        return {
            "profile_parts": ", ".join(name for name, _ in parts),
            "profile_wall_time": [seconds.wall for _, seconds in parts],
            "profile_processor_time": [seconds.processor for _, seconds in parts],
            "profile_threads": self.threads,
        }

    # A program is compiled within another one's compiling, and by whichever thread comes first, while others wait.
    def _compiles(self, more: int) -> None:
        if self._compiling == 0:
            self._compiled_since = now()
        self._compiling += more
        if self._compiling == 0:
            self.watch.seconds[COMPILING] += since(self._compiled_since)


def _places(body: type, archive: type) -> Places:
    """What every model has."""
    steps: Places = {(body, name): REST for name in ("advance", "through") if hasattr(body, name)}
    records: Places = {(body, name): RECORDS for name in ("record", "look", "snapshot", "figures")}
    return steps | records | {(archive, name): WRITING for name in ("write_segment", "write_checkpoint")}


def _of_particles(problem: Any) -> Places:
    from astroinertia.models.sph import evolution  # which is loaded where there are particles

    forces, before = (set(problem.terms(name)) for name in ("neighbour_terms", "gradient_terms"))

    def sums(_: Any, __: Any, ___: Any, terms: Any, *____: Any, **_____: Any) -> str:
        asked = set(terms)
        return FORCES if asked & forces else GRADIENTS if asked & before else OTHER_SUMS

    def over_all(_: Any, __: Any, ___: Any, terms: Any, *____: Any, **_____: Any) -> str:
        return " and ".join(sorted({term.effect for term in terms}))

    engine = type(problem.engine)
    passes: Places = {(engine, name): DENSITY for name in ("density", "listed") if hasattr(engine, name)}
    sorting: Places = {(evolution, name): SORTING for name in ("rearranged", "stale")}
    if hasattr(engine, "outgrown"):
        from astroinertia.models.sph import listed_step  # only here: numba lists within the step

        sorting[listed_step, "rearranged"] = SORTING
    own: Places = {
        (type(effect), name): effect.kind
        for effect in problem.effects
        for name in OF_EFFECTS
        if getattr(type(effect), name) is not getattr(ParticleParts, name)
    }
    ledger: Places = {(Ledgers, name): LEDGER for name in OF_LEDGERS}
    pairs: Places = {(engine, "neighbour_sums"): sums, (engine, "all_pair_sums"): over_all}
    return passes | sorting | own | ledger | pairs
