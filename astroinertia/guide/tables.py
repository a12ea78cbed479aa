"""Tables in Markdown, and how limits and numbers are written in them."""

from collections.abc import Iterable, Sequence


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown; bars in its cells are escaped.

    >>> print(table(["key", "meaning"], [["t", "T/|W|"]]))
    | key | meaning |
    |---|---|
    | t | T/\\|W\\| |
    """
    lines = [_row(head), "|" + "---|" * len(head), *map(_row, rows)]
    return "\n".join(lines)


def bounds(least: float | None, most: float | None, above: bool = False, below: bool = False) -> str:
    """Limits of a number in words; `above` and `below`: the limits themselves are not allowed.

    >>> bounds(0.0, 0.5, below=True), bounds(1.0, None, above=True), bounds(None, None)
    ('from 0 to below 0.5', 'above 1', '')
    """
    lower = "" if least is None else f"{'above' if above else 'from'} {number(least)}"
    if most is None:
        return lower if above or not lower else f"at least {number(least)}"
    if not lower:
        return f"{'below' if below else 'at most'} {number(most)}"
    return f"{lower} {'and below' if below and above else 'to below' if below else 'to'} {number(most)}"


def number(value: float | None) -> str:
    """A number as short as it is exact.

    >>> number(50_000_000), number(5 / 3), number(1e-08)
    ('50000000', '1.66667', '1e-08')
    """
    return str(value) if isinstance(value, int) else f"{value:g}"


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"
