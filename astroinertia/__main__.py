"""The command `astroinertia`. A signal ends it without a word while the modules of the command line are loaded."""

import gc
import signal
import sys


def main() -> int:
    """Run one command and return its exit code."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    from astroinertia.cli import main as cli

    code = cli.main()
    gc.freeze()  # the end of the process gives all memory back: looking through it for cycles takes a tenth of `show`
    return code


if __name__ == "__main__":
    sys.exit(main())
