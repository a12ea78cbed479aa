"""How `run` and `resume` learn of the other processes of the same run. Printing is left to main.py."""

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, redirect_stdout
from pathlib import Path

from astroinertia.cli.parser import Add, Options
from astroinertia.errors import SAID, SceneError
from astroinertia.process import starters

FOUND = "auto"
_TOGETHER = ("run", "resume", "sensitivity")  # the commands of runs, which MPI may start


def add_arguments(add: Add) -> None:
    """Add where the processes meet, how many they are and which of them this is."""
    add("--coordinator", metavar="HOST:PORT",
        help="do a run of the engine xla together with other processes, each started with the same arguments on a "
        f"device of its own and meeting here; numerics.devices is their number. '{FOUND}' within Slurm or MPI finds "
        "the rest, too. Runs of the engine numba_cpu that mpirun starts need none of this")  # fmt: skip
    add("--processes", type=int, metavar="N", help="how many processes there are, with --coordinator")
    add("--process", type=int, metavar="K", help="which of them this is, from 0 on, which writes")


def left_to_the_first(words: Sequence[str]) -> bool:
    """Whether a command is the plan of a run, and MPI has started this process beside the first, which says it."""
    return list(words[:1]) == ["plan"] and not starters.is_first()


@contextmanager
def parsed_alike(words: Sequence[str]) -> Iterator[None]:
    """Within it, what all processes of a run find wrong with its arguments is said by the first alone."""
    try:
        if list(words[:1]) == ["sensitivity"] and starters.started() > 1:
            raise SceneError("the runs of a sensitivity are not shared out by MPI: start it once, with --workers.")
        yield
    except SceneError as error:
        if words[:1] and words[0] in _TOGETHER and not starters.is_first():
            error.add_note(SAID)
        raise


@contextmanager
def joined(options: Options) -> Iterator[None]:
    """By MPI or with --coordinator, one of several processes, of which the first alone prints what goes well."""
    if not hasattr(options, "coordinator"):
        yield
        return
    where, count, number = options.coordinator, options.processes, options.process
    if where is None or where == FOUND:
        if count is not None or number is not None:
            raise SceneError("--processes and --process are for a --coordinator HOST:PORT.")
    elif count is None or number is None or not 0 <= number < count:
        raise SceneError("--coordinator HOST:PORT needs --processes N and --process K, a number from 0 to N - 1.")
    if where is None and starters.started() == 1:
        yield
        return
    from astroinertia.engines import mpi

    with ExitStack() as stack:
        if where is None:
            stack.enter_context(mpi.joined())  # before numba is imported, which learns of its threads here
        from astroinertia.engines import hosts

        if where is not None:
            stack.enter_context(hosts.joined(None if where == FOUND else where, count, number))
        if not hosts.is_first():
            stack.enter_context(redirect_stdout(stack.enter_context(Path(os.devnull).open("w"))))
        yield
