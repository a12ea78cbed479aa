"""Error against time of the structure of neutron stars with their answers to rotation and tides.

Run: python tests/benchmarks/work_precision_tov.py [--keep]
"""

import numpy as np
from precision_table import publish, table

from astroinertia.bodies.neutron_stars import NeutronStar, star
from astroinertia.bodies.tov import TOLERANCE
from astroinertia.matter.compact_stars import polytrope, read2009
from astroinertia.matter.compact_tables import tabulated

PROPERTIES = ("mass", "radius", "rest_mass", "moment_of_inertia", "tidal_love_number", "quadrupole_bar")
CENTRAL_DENSITY = 1.28e-3  # G = c = Msun = 1
TOLERANCES = (1e-5, 1e-7, 1e-9, 1e-11, 1e-12, 1e-13)


def largest_error(exact: NeutronStar):
    return lambda body: max(abs(getattr(body, name) / getattr(exact, name) - 1) for name in PROPERTIES)


def from_rows(rows: int) -> NeutronStar:
    """The star of gamma = 2 from a table by energy density over the range of its density."""
    smooth = polytrope(100.0, 2.0)
    eta = np.geomspace(1e-5, 2.0, rows)
    made = tabulated(smooth.pressure(eta), smooth.energy_density(eta))
    return star(made, central_pressure=100.0 * CENTRAL_DENSITY**2)


def main() -> None:
    tables = []
    for title, equation in (
        ("gamma = 2, K = 100", polytrope(100.0, 2.0)),
        ("SLy of Read et al. 2009", read2009("SLy")),
    ):

        def at(tolerance: float, equation=equation) -> NeutronStar:
            return star(equation, central_rest_density=CENTRAL_DENSITY, tolerance=tolerance)

        exact = at(3e-14)
        title = f"Star of {title}, C = {exact.compactness:.3f}: largest relative error of M, R, M_b, I, k2 and Q M/J^2"
        tables.append(table(title, "tolerance of a step", TOLERANCES, at, largest_error(exact), TOLERANCE))
    exact = star(polytrope(100.0, 2.0), central_rest_density=CENTRAL_DENSITY)
    title = "Star of a table by energy density, gamma = 2: the same errors, with the making of the table"
    tables.append(table(title, "rows of the table", (10, 20, 40, 80, 160), from_rows, largest_error(exact), None))
    publish("tov", tables)


if __name__ == "__main__":
    main()
