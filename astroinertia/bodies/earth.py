"""The Preliminary Reference Earth Model (PREM) of Dziewonski & Anderson 1981, from data/prem.csv.

Tests: tests/unit/bodies/test_layered.py (mass and moment of inertia), tests/unit/bodies/test_clairaut.py (flattening to
first order), tests/unit/bodies/test_figures.py (in full), tests/unit/bodies/test_love_numbers.py (moduli).
"""

import numpy as np

from astroinertia.bodies.figures import NODES, RotatingFigure, figure_of_layered_body
from astroinertia.bodies.layered import LayeredBody, polynomial_layers
from astroinertia.bodies.love_numbers import YieldingBody, seismic_body
from astroinertia.process.quantities import with_quantities
from astroinertia.storage.data_tables import data_rows
from astroinertia.units import GRAVITATIONAL_CONSTANT

EARTH_ROTATION_RATE = 7.292115e-5  # rad/s, nominal mean (Groten 2004, J. Geodesy 77, 724)


def prem_layer_names() -> tuple[str, ...]:
    """The names of PREM's 13 layers from the centre to the ocean.

    >>> print(len(prem_layer_names()))
    13
    """
    return tuple(row["name"] for row in data_rows("prem.csv"))


@with_quantities()
def prem(gravitational_constant: float = GRAVITATIONAL_CONSTANT) -> LayeredBody:
    """PREM's density with its jumps, in SI: 13 layers of cubic polynomials in r/R, mean radius R = 6371 km.

    Source: Dziewonski & Anderson 1981, PEPI 25, 297, table I. Checked by tests/unit/bodies/test_layered.py.

    >>> print(f"{float(prem().moment_ratio):.6f}")  # gravity and precession have 0.3307
    0.330799
    """
    radii = np.array([float(row["outer_radius_km"]) for row in data_rows("prem.csv")]) * 1e3
    coefficients = [[1e3 * float(row[f"a{k}"]) for k in range(4)] for row in data_rows("prem.csv")]
    return polynomial_layers(radii, coefficients, gravitational_constant)


def prem_shear_quality() -> tuple[float, ...]:
    """The quality factor of shear, infinite in fluids, of PREM's 13 layers from the centre to the ocean.

    Source: Dziewonski & Anderson 1981, PEPI 25, 297, table I. Checked by tests/unit/rotation/test_wobble.py.

    >>> print(*prem_shear_quality()[:3])
    84.6 inf 312.0
    """
    return tuple(float(row["shear_quality"]) for row in data_rows("prem.csv"))


def elastic_prem() -> YieldingBody:
    """PREM with its moduli at a period of 1 s, isotropic; in place of the ocean its upper crust reaches up to 6371 km.

    Source: Dziewonski & Anderson 1981, PEPI 25, 297, table I. Checked by tests/unit/bodies/test_love_numbers.py.

    >>> from astroinertia.bodies.love_numbers import love_numbers
    >>> print(*(f"{number:.4f}" for number in love_numbers(elastic_prem())))  # k2, h2, l2
    0.2983 0.6038 0.0840
    """
    *rows, crust, water = data_rows("prem.csv")
    rows.append(crust | {"outer_radius_km": water["outer_radius_km"]})
    radii = [1e3 * float(row["outer_radius_km"]) for row in rows]
    return seismic_body(
        radii, *([[1e3 * float(row[f"{name}{k}"]) for k in range(4)] for row in rows] for name in "aps")
    )


@with_quantities()
def prem_figure(
    angular_velocity: float = EARTH_ROTATION_RATE,
    gravitational_constant: float = GRAVITATIONAL_CONSTANT,
    harmonics: int | None = None,
    nodes: int = NODES,
) -> RotatingFigure:
    """The hydrostatic figure of PREM to all orders, in SI: 1/f = 299.779, J2 = 1.07177e-3 at the Earth's rate.

    PREM's density is that of the level surfaces by mean radius. harmonics and nodes: as in
    `figures.figure_of_layered_body`. Checked by tests/unit/bodies/test_figures.py.

    >>> print(f"{1 / float(prem_figure().flattening):.2f}")  # hydrostatic; measured 298.26
    299.78
    """
    body = prem(gravitational_constant)
    return figure_of_layered_body(body, angular_velocity=angular_velocity, harmonics=harmonics, nodes=nodes)
