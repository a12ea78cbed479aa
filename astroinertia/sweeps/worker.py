"""The program of a worker of sweeps.workers: runs the members that come through a pipe, and says what came of them.

It ends, at once or once the member under way is saved, when the pipe says so, and at once when the process at the
other end is gone.
"""

import os
import signal
import sys
import threading
from contextlib import suppress
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import Any, NoReturn

from astroinertia.process import interrupts


def main() -> None:
    """Run members until asked to stop; the number of the pipe's descriptor is the program's argument."""
    connection = Connection(int(sys.argv[1]))
    tasks: SimpleQueue[tuple[Any, ...] | None] = SimpleQueue()
    with interrupts.watched(_end):
        threading.Thread(target=_listen, args=(connection, tasks), daemon=True).start()
        from astroinertia.sweeps.members import Task, carry_out

        while (task := tasks.get()) is not None:
            try:
                outcome = carry_out(Task(*task))
            except Exception as error:
                outcome = error
            with suppress(OSError):  # the process at the other end is gone
                connection.send(outcome)


def _listen(connection: Any, tasks: "SimpleQueue[tuple[Any, ...] | None]") -> None:
    try:
        while True:
            task = connection.recv()
            if task is None:
                interrupts.ask(signal.SIGTERM)  # comes back where there is something to save
            tasks.put(task)
    except (EOFError, OSError):
        os._exit(1)


def _end(how: interrupts.Ended) -> NoReturn:
    interrupts.discard_leftovers()
    os._exit(how.code)


if __name__ == "__main__":
    main()
