"""The option `plan --audit`: a table of what the program holds of each effect. Printing is left to main.py."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from rich.table import Table
from rich.text import Text

from astroinertia.cli.parser import Add
from astroinertia.cli.screen import titled

if TYPE_CHECKING:
    from astroinertia.audit.absence import Audit
    from astroinertia.scene.schema import Scene


def add_arguments(add: Add) -> None:
    """Add the options of `plan --audit`."""
    add("--audit", action="store_true",
        help="prove absence: run one step in an interpreter of its own and count the operations, arrays and objects of "
        "every effect; with particles also what a step takes without each one, which compiles again")  # fmt: skip


def audited(scene: "Scene", begin: Callable[[str], None]) -> "Audit":
    """The audit of a scene with costs; `begin` hears what is done next."""
    from astroinertia.audit.absence import audited, with_costs

    begin("one step, in an interpreter of its own")
    audit = audited(scene)
    return with_costs(audit, scene, lambda what: begin(f"timing {what}"))


def table(audit: "Audit") -> Table:
    """The audit as it is shown: effects called for first."""
    shown = titled("\nwhat the program of a step holds: operations traced and compiled, arrays, objects")
    columns = ("effect", "used", "traced", "compiled", "arrays", "objects", "time")
    for number, name in enumerate(columns):
        shown.add_column(name, justify="left" if number < 2 else "right", no_wrap=not number)
    for share in sorted(audit.shares, key=lambda share: not share.listed):
        style = "green" if share.listed else "dim" if not share.present else "bold red"
        cost = "" if share.seconds is None or not audit.seconds else f"{100.0 * share.seconds / audit.seconds:.0f} %"
        counts = (str(share.traced), str(share.compiled), str(share.arrays), str(share.objects))
        shown.add_row(Text(share.kind, style=style), "yes" if share.listed else "no", *counts, cost)
    shown.add_row("every scene", "", str(audit.common_traced), str(audit.common_compiled), "", "", "")
    return shown


def verdict(audit: "Audit") -> str:
    """What the table means, in a sentence or two."""
    present = [share.kind for share in audit.shares if share.present and not share.listed]
    if present:
        return f"NOT ABSENT, though not called for: {', '.join(present)}."
    left = sum(not share.listed for share in audit.shares)
    summary = f"Of the {left} effects that are not called for there is no operation, no array and no object."
    if audit.seconds is None:
        return summary
    step = f"A step takes {1e3 * audit.seconds:.3g} ms"
    return f"{summary} {step}; the time of an effect is what it takes less without."
