"""The command `astroinertia`. A signal ends it without a word while the modules of the command line are loaded."""

import signal
import sys


def main() -> int:
    """Run one command and return its exit code."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    from astroinertia.cli import main as cli

    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
