"""Variables as xarray takes them, each with its unit and what it is."""

from collections.abc import Hashable, Iterable, Mapping
from typing import Any

Dims = Hashable | tuple[Hashable, ...]
Column = tuple[Any, str, str]
"""Values, their unit and what they are."""


def variables(dims: Dims, columns: Mapping[str, Column]) -> dict[str, tuple[Dims, Any, dict[str, str]]]:
    """Variables along the same dimensions, by name."""
    return {
        name: (dims, values, {"units": units, "long_name": long_name})
        for name, (values, units, long_name) in columns.items()
    }


def of_rows(
    dim: str, rows: Iterable[Mapping[str, Any]], heads: Mapping[str, tuple[str, str]]
) -> dict[str, tuple[Dims, Any, dict[str, str]]]:
    """The columns of a table as variables along its rows; heads: unit and what it is, by the name of each."""
    rows = list(rows)
    return variables(dim, {name: ([row[name] for row in rows], *head) for name, head in heads.items()})
