"""Figures of rotating bodies: error of J2 against time, by harmonics, nodes and the number of constant layers.

python tests/benchmarks/work_precision_figures.py [--keep]
"""

import sys
from pathlib import Path

import numpy as np
from precision_table import publish, table

sys.path.insert(0, str(Path(__file__).parents[2]))  # run as a script: the tests' own bodies are beside it

from astroinertia.bodies.earth import prem_figure
from astroinertia.bodies.figures import NODES, figure_of_density, figure_of_polytrope
from tests.exact_polytropes import exact_polytrope

AUTOMATIC = "as needed"


def harmonics_table(q: float) -> str:
    exact = exact_polytrope(rotation_parameter=q)
    return table(
        f"Polytrope of index 1, q = {q}: largest relative error of J2 and C/(M a^2) against its spectral solution",
        "harmonics",
        (3, 4, 6, 8, 10, 14, 18, AUTOMATIC),
        lambda count: figure_of_polytrope(
            1.0, rotation_parameter=q, harmonics=None if count == AUTOMATIC else count, accuracy=0.1
        ),
        lambda figure: max(
            abs(figure.zonal_harmonics[0] / exact.zonal_harmonics[0] - 1),
            abs(figure.polar_moment_ratio_equatorial / exact.polar_moment_ratio_equatorial - 1),
        ),
        AUTOMATIC,
    )


def nodes_table(index: float) -> str:
    fine = figure_of_polytrope(index, rotation_parameter=0.1, nodes=96, harmonics=10)
    return table(
        f"Polytrope of index {index}, q = 0.1: relative error of J2 against 96 nodes",
        "nodes",
        (12, 16, 24, 32, 48, 64),
        lambda count: figure_of_polytrope(index, rotation_parameter=0.1, nodes=count, harmonics=10, accuracy=0.1),
        lambda figure: abs(figure.zonal_harmonics[0] / fine.zonal_harmonics[0] - 1),
        NODES,
    )


def earth_table() -> str:
    fine = prem_figure(nodes=64, harmonics=14)
    return table(
        "PREM: relative error of the flattening against 64 nodes",
        "nodes",
        (6, 8, 12, 16, 24, 32),
        lambda count: prem_figure(nodes=count),
        lambda figure: abs(figure.flattening / fine.flattening - 1),
        NODES,
    )


def constant_layers_table() -> str:
    """What concentric Maclaurin spheroids would cost: the same body as steps of constant density."""
    smooth = figure_of_polytrope(1.0, rotation_parameter=0.089195487, harmonics=8)
    profile = np.polynomial.chebyshev.Chebyshev.fit(smooth.radius, smooth.density, NODES - 1, domain=[0, 1])

    def layered(count):
        edges = np.linspace(0, 1, count + 1)
        densities = np.maximum(profile((edges[1:] + edges[:-1]) / 2), 0.0)
        return figure_of_density(edges[1:], densities, rotation_parameter=0.089195487, harmonics=8)

    return table(
        "The same polytrope of index 1 as layers of constant density: relative error of J2",
        "layers",
        (8, 16, 32, 64, 128),
        layered,
        lambda figure: abs(figure.zonal_harmonics[0] / smooth.zonal_harmonics[0] - 1),
        None,
    )


if __name__ == "__main__":
    publish(
        "figures",
        [
            harmonics_table(0.089195487),
            harmonics_table(0.3),
            *(nodes_table(index) for index in (1.0, 1.3, 3.0)),
            earth_table(),
            constant_layers_table(),
        ],
    )
