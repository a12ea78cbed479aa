"""A plan as it is shown. Printing is left to main.py."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich.console import RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    from astroinertia.scene.plan import EffectLine, Line, Plan


def parts(plan: "Plan") -> Iterator[RenderableType]:
    """What is printed one below the other."""
    yield Text.assemble((plan.name, "bold"), f": {plan.description}" if plan.description else "")
    for title, lines in plan.sections.items():
        yield Text(f"\n{title}", style="bold")
        yield _section(lines)
    listed = [effect for effect in plan.effects if effect.listed]
    yield Text("\neffects called for", style="bold")
    yield _effects(listed) if listed else Text("  none: particles move freely")
    yield Text("\nnot listed, so absent from what is compiled and run", style="bold")
    for effect in plan.effects:
        if not effect.listed:
            yield Padding(Text(f"{effect.kind}: {effect.text}", style="dim"), (0, 0, 0, 2), expand=False)
            if effect.size:
                yield Padding(Text(effect.size), (0, 0, 0, 4), expand=False)


def _section(lines: "tuple[Line, ...]") -> Table:
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    table.add_column(style="cyan", no_wrap=True, min_width=18)
    table.add_column()
    table.add_column(style="dim")
    for line in lines:
        table.add_row(Text(f"  {line.name}"), Text(line.value), Text(line.why))
    return table


def _effects(listed: "list[EffectLine]") -> Table:
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    table.add_column(style="green", no_wrap=True, min_width=18)
    table.add_column()
    for effect in listed:
        text = Text(effect.text)
        why = "a numerical device of particles: skipped" if effect.skipped else f"{effect.loop}; {effect.source}"
        text.append(f" ({why})", style="dim")
        text.append(f"\nfrom {effect.origin}" if effect.origin else "")
        text.append(f"\n{effect.options}" if effect.options else "")
        text.append(f"\n{effect.size}" if effect.size else "")
        table.add_row(Text(f"  {effect.kind}"), text)
    return table
