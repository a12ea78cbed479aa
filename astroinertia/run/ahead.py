"""The program of the process that compiles beside a run (run.beside): what the run needs last, it compiles first.

It ends with the process that holds the other end of its standard input.
"""

import json
import os
import sys
import threading
import warnings
from typing import NoReturn

from astroinertia.process import interrupts


def main() -> None:
    """Compile what is left to compile for a scene.

    The program's argument is the number of a file's descriptor, by which programs are claimed; in it stand the text of
    the scene and its origin.
    """
    threading.Thread(target=_end_with_the_run, daemon=True).start()
    from astroinertia.engines.numba_claims import compile_once, shared
    from astroinertia.run.programs import programs
    from astroinertia.scene import load

    descriptor = int(sys.argv[1])
    text, origin = json.loads(os.pread(descriptor, os.fstat(descriptor).st_size, 0))
    warnings.simplefilter("ignore")  # nothing is made of the numbers
    with shared(descriptor, lambda: None):
        for function, signature in reversed(programs(load.loads(text, origin=origin))):
            compile_once(descriptor, function, signature, patient=False)


def _end_with_the_run() -> NoReturn:
    os.read(0, 1)  # nothing is ever written to it
    interrupts.discard_leftovers()
    os._exit(0)


if __name__ == "__main__":
    main()
