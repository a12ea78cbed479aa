"""The references of the cross-checks: a cited table, one row for each quantity that the package is held to."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, cast, get_args

from astroinertia.storage.data_tables import data_rows

Measure = Literal["relative", "absolute", "below"]
BESIDE = "beside"  # in the column `reference`: the other side is computed, too, by the program that `source` names


@dataclass(frozen=True)
class Reference:
    """What a quantity should be, to what tolerance, why that one, and who says so.

    value is NaN where the other side is computed beside. measure: the difference is relative to the reference,
    absolute, or the quantity itself has to stay below the tolerance (an error, a drift).
    """

    section: str
    key: str
    quantity: str
    unit: str
    value: float
    tolerance: float
    measure: Measure
    reason: str
    source: str


@lru_cache(maxsize=1)
def references() -> dict[str, tuple[Reference, ...]]:
    """All references by section, in the order of data/verify.csv. Checked by tests/unit/verify/test_comparison.py."""
    sections: dict[str, list[Reference]] = {}
    for row in data_rows("verify.csv"):
        sections.setdefault(row["section"], []).append(_reference(row))
    return {section: tuple(rows) for section, rows in sections.items()}


def _reference(row: dict[str, str]) -> Reference:
    measure = row["measure"]
    if measure not in get_args(Measure):
        raise ValueError(f"verify.csv: {row['key']} has the measure '{measure}'")
    return Reference(
        section=row["section"],
        key=row["key"],
        quantity=row["quantity"],
        unit=row["unit"],
        value=math.nan if row["reference"] == BESIDE else float(row["reference"]),
        tolerance=float(row["tolerance"]),
        measure=cast(Measure, measure),
        reason=row["reason"],
        source=row["source"],
    )
