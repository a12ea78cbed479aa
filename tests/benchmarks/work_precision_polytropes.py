"""Polytropes: what the accuracy of their structure, Love numbers and modes costs.

`python tests/benchmarks/work_precision_polytropes.py` prints the tables; with --keep it writes them to results/, too.
Errors are against 32-digit values, an exact relation, or (where marked) the finest setting of all. Composite
polytropes are two zones, each at the cost of the first two tables. Modes are calculated at two neighbouring settings,
from the default on, until they agree.
"""

import json
import math
from pathlib import Path

import numpy as np
from precision_table import publish, table

from astroinertia.bodies import apsidal
from astroinertia.bodies.oscillations import RESOLUTIONS, nonradial_spectrum, radial_spectrum
from astroinertia.bodies.polytrope_elements import polytrope_elements

STEEP = json.loads((Path(__file__).parents[1] / "reference" / "steep_polytropes.json").read_text())
TOLERANCES = (1e-5, 1e-7, 1e-9, 1e-11, 1e-13, apsidal.ROUND_OFF)
POLYNOMIALS = (8, 12, 16, 20, 28, 40, 56)


def steep(name: str) -> float:
    return next(float(each["value"]) for each in STEEP if each["name"] == name and each["inputs"]["n"] == 4.9)


def zone_at(tolerance, index=4.9):
    return apsidal.core_zone(index, 0.0, 2, apsidal.DEGREES, tolerance)


def love_error(zone) -> float:
    values = [apsidal.love_from_complement(zone.delta[k - 2, -1], k) for k in (2, 8)]
    exact = [steep("polytrope.k2_fluid_Love"), steep("polytrope.k8_fluid_Love")]
    return float(np.max(np.abs(np.array(values) / exact - 1)))


def virial_error(zone) -> float:
    """W by two integrals against -3/(5 - n)."""
    scale = (5 - zone.index) / 3 * zone.r[-1] / zone.mass[-1] ** 2
    return max(abs(part[-1] * scale - 1) for part in (zone.binding, 3 * zone.volume_work))


def lowest(values, count=6):
    positive = values[values > 0.3]  # above the false modes of a neutral star near zero
    return positive[:count]


def radial_at(polynomials):
    return radial_spectrum(polytrope_elements(2.7, polynomials), 5 / 3).values[:4]


def nonradial_at(polynomials):
    return lowest(nonradial_spectrum(polytrope_elements(0.3, polynomials), 5 / 3, 2).values, 3)


def condensed_at(polynomials):
    values = nonradial_spectrum(polytrope_elements(3.0, polynomials), 5 / 3, 2).values
    return values[(values > 1.2) & (values < 60)][:8]


def against(finest):
    return lambda values: float(np.max(np.abs(values / finest - 1))) if len(values) == len(finest) else math.inf


def main() -> None:
    default = RESOLUTIONS[0]
    tables = [
        table(
            "Structure and k_2 to k_8, n = 4.9: relative tolerance of the integration",
            "tolerance",
            TOLERANCES,
            zone_at,
            love_error,
            apsidal.ROUND_OFF,
        ),
        table(
            "Structure and k_2 to k_8, n = 0.3 (error of W): relative tolerance of the integration",
            "tolerance",
            TOLERANCES,
            lambda tolerance: zone_at(tolerance, 0.3),
            virial_error,
            apsidal.ROUND_OFF,
        ),
    ]
    for title, action in (
        ("Four radial modes, n = 2.7, Gamma1 = 5/3", radial_at),
        ("f, p1, p2 of l = 2, n = 0.3, Gamma1 = 5/3", nonradial_at),
        ("Eight g, f and p modes of l = 2, n = 3, Gamma1 = 5/3", condensed_at),
    ):
        finest = action(80)
        knob = "polynomials an element (error against 80)"
        tables.append(table(title, knob, POLYNOMIALS, action, against(finest), default))
    publish("polytropes", tables)


if __name__ == "__main__":
    main()
