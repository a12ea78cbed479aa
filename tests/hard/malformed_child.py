"""Reads files that may be malformed, one after the other, in a process of its own, and says what became of each.

    python -m tests.hard.malformed_child      a line of JSON in, {"kind": ..., "path": ...}; a line of JSON out

What a reader does is everything that the package does with such a
file before numbers are computed from it. Figures of each file: processor time, and the most memory above that before.
"""

import io
import json
import os
import resource
import sys
import time
import traceback
import warnings
from contextlib import redirect_stderr, suppress
from pathlib import Path

from astroinertia import dataset
from astroinertia.cli.main import UNCLOSED, main as main_of_commands
from astroinertia.errors import ArchiveError, ArchiveWarning, AstroinertiaError, SceneWarning
from astroinertia.interop.snapshots import snapshots_of
from astroinertia.matter.table_equation import read_equation
from astroinertia.orbits import rebound_archive as orbits
from astroinertia.run import loop as runs
from astroinertia.scene import load, sweep
from astroinertia.sph.progenitor import read_progenitor
from astroinertia.sph.table import read_table
from astroinertia.storage.archive import Archive
from astroinertia.studies.moments import moments, read_matter
from astroinertia.sweeps import combined, folder as sweeps

HANG = 30  # seconds of processor time after which the system ends the process


def of_result(path):
    dataset.open(path)
    for _ in snapshots_of(path, "all"):
        pass
    read_matter(path)


def of_run(path):
    dataset.open(path)
    dataset.open_snapshots(path)
    with Archive.open(path) as archive:
        archive.read_checkpoint()
    runs.resume(path)


def of_sweep(path):
    sweeps.waiting(path, len(sweeps.read(path).members))
    combined.open_members(path)
    dataset.open(path)


def of_scene(path):
    if sweep.load_file(path) is None:
        load.load_file(path)


def of_command(*arguments):
    """The sentence of a command that refuses; what it writes to the screen is not looked at.

    A run that goes on from an altered state ends, and says by its exit code that its ledger does not close.
    """
    said = io.StringIO()
    with warnings.catch_warnings(), redirect_stderr(said):
        warnings.simplefilter("ignore")
        if main_of_commands(arguments) not in (0, UNCLOSED):
            raise ArchiveError(said.getvalue().removesuffix("\n"))


def of_orbits(path):
    """The snapshots of an archive that can be read; that others cannot is a warning, in one sentence."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        orbits.snapshots(path)
    if wrong := [one for one in said if one.category is not SceneWarning or "\n" in str(one.message)]:
        raise RuntimeError(str(wrong[0].message))


READERS = {
    "resume": lambda path: of_command("resume", str(path)),
    "show": lambda path: of_command("show", str(path)),
    "report": lambda path: of_command("report", str(path)),
    "result": of_result,
    "run": of_run,
    "sweep": of_sweep,
    "scene": of_scene,
    "table": read_table,
    "matter": lambda path: moments(read_matter(path)),
    "equation": read_equation,
    "profile": lambda path: read_progenitor(path, 1.3),
    "orbits": of_orbits,
}
# The sentence of a reader whose callers make it one of the package's errors.
OWN = {"orbits": ValueError, "matter": ValueError}


def outcome(kind, path):
    """What became of a file: ("read" or "refused" or "foreign", what was said)."""
    try:
        READERS[kind](path)
    except (AstroinertiaError, OWN.get(kind, AstroinertiaError)) as error:
        said = str(error)
        return ("refused" if said.strip() and "\n" not in said else "foreign"), said
    except Exception:
        return "foreign", traceback.format_exc()
    return "read", ""


def processor_time():
    """Of this process and of those that it has waited for."""
    others = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + others.ru_utime + others.ru_stime


def limited(seconds):
    """Let the system end this process after so many more seconds of processor time."""
    used = time.process_time()
    hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
    resource.setrlimit(resource.RLIMIT_CPU, (int(used + seconds) + 1, hard))


def peak_since_now():
    Path("/proc/self/clear_refs").write_text("5")


def memory(name):
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * int(next(line for line in lines if line.startswith(name)).split()[1])


def main():
    with suppress(ImportError):
        import sarracen  # noqa: F401  an extra that takes seconds: what is measured is reading
    warnings.simplefilter("error")
    warnings.simplefilter("ignore", ArchiveWarning)
    pipe = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what libraries print is no answer
    print("{}", file=pipe, flush=True)
    for line in sys.stdin:
        asked = json.loads(line)
        limited(HANG)
        peak_since_now()
        before, begun = memory("VmRSS"), processor_time()
        became, said = outcome(asked["kind"], Path(asked["path"]))
        figures = {"seconds": processor_time() - begun, "bytes": memory("VmHWM") - before}
        print(json.dumps({"became": became, "said": said[-3000:], **figures}), file=pipe, flush=True)


if __name__ == "__main__":
    main()
