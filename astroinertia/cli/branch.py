"""The command `branch`: what it takes. Printing is left to main.py."""

from pathlib import Path

from astroinertia.cli.parser import Add, add_settings
from astroinertia.cli.stop import EXIT_CODES

HELP = f"""\
The run is carried on as it was from the last state that it has at or before the time (a checkpoint, a snapshot, or its
start) to the time itself; from there the branch goes its own way, in a folder of its own, with a ledger that begins
there. Its dataset says in `history` and `branched_from` where it comes from and what is changed. Body, equation of
state, companions, units and model stay as they are.

{EXIT_CODES}
examples: astroinertia branch runs/star --at "2 h" --set effects.damping.time_scale="20 min" --output runs/damped
          astroinertia branch runs/star --at "2 h" --set "effects={{gravity={{}}, pressure={{}}}}" --output runs/ideal
          astroinertia branch runs/star --set "time.end=6 h" --set numerics.neighbours=120 --output runs/smoother
"""


def add_arguments(add: Add) -> None:
    """Add the run, the time, what is changed and the folder of the branch."""
    add("run", metavar="RUN", type=Path, help="folder of the run to branch from; it is only read")
    add("--at", metavar="TIME", help='when the branch begins, such as "2 h", in code units a plain number '
        "(default: at the last state that the run has)")  # fmt: skip
    add_settings(add, "change a key of its scene, such as time.end, an effect's option, or effects as a whole; may be "
        "repeated")  # fmt: skip
    add("--output", type=Path, metavar="DIR", required=True, help="folder of the branch, without another run in it")
