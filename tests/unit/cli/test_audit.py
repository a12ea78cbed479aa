"""The table of `plan --audit` as it is read."""

from rich.console import Console

from astroinertia.audit.absence import Audit, Share
from astroinertia.cli.audit import table
from astroinertia.effects.catalogue import CATALOGUE


def test_no_name_and_no_head_is_cut_on_a_terminal_of_eighty_columns():
    shares = tuple(Share(kind, True, 1083, 66, 10, 1, 1e-3) for kind in CATALOGUE)
    console = Console(width=80)
    with console.capture() as shown:
        console.print(table(Audit(shares, 4579, 158, "", (), seconds=1e-2)))
    assert "…" not in shown.get() and all(kind in shown.get() for kind in CATALOGUE)
