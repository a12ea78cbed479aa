"""Observed pulsars: `data/pulsars.csv`, with the source of each number. Tests: tests/unit/rotation/test_pulsars.py."""

import math
from dataclasses import dataclass
from functools import lru_cache

from astroinertia.errors import UnlistedError
from astroinertia.process.quantities import with_quantities
from astroinertia.storage.data_tables import data_rows

KINDS = ("ordinary", "recycled", "magnetar", "isolated")
_BY_1950 = {"b0531+21": "crab", "b0833-45": "vela", "b1913+16": "hulse-taylor", "b1257+12": "lich"}  # B1950 places


@dataclass(frozen=True)
class Pulsar:
    """One pulsar: period in s, its derivative as observed, kind, and the braking index where it is measured (else NaN).

    name is the one that people use, jname that of the catalogue.
    """

    jname: str
    name: str
    period: float
    period_derivative: float
    kind: str
    binary: bool
    braking_index: float
    braking_index_uncertainty: float
    braking_index_source: str
    source: str


@lru_cache(maxsize=1)
def pulsars() -> tuple[Pulsar, ...]:
    """Return all pulsars of the table.

    >>> print([star.name for star in pulsars() if star.period > 0.03 and star.period < 0.04 and star.name])
    ['J0348+0432', 'Crab', 'B1534+12', 'B1951+32']
    """
    return tuple(
        Pulsar(
            row["jname"],
            row["name"],
            float(row["period"]),
            float(row["period_derivative"]),
            row["kind"],
            row["binary"] == "yes",
            float(row["braking_index"] or math.nan),
            float(row["braking_index_uncertainty"] or math.nan),
            row["braking_index_source"],
            row["source"],
        )
        for row in data_rows("pulsars.csv")
    )


@with_quantities()
def pulsar(name: str) -> Pulsar:
    """Return a pulsar by any of its names, such as "Crab", "J0534+2200" or "PSR B0531+21"; UnlistedError for others.

    >>> print(f'{1e3 * pulsar("Crab").period:.1f} ms, n = {pulsar("Crab").braking_index}')
    33.4 ms, n = 2.51
    """
    wanted = name.lower().removeprefix("psr").strip()
    wanted = _BY_1950.get(wanted, wanted)
    for row in pulsars():
        if wanted in (row.name.lower(), row.jname.lower()):
            return row
    raise UnlistedError(f"the table has no pulsar {name!r}")
