"""Error against time of the rotating polytrope of index 1: by degree, and by the tolerance asked for."""

from precision_table import publish, table

from astroinertia.bodies import spectral_polytrope
from astroinertia.bodies.spectral_polytrope import rotating_polytrope

DEGREES = (8, 12, 16, 20, 28, 40, 56)
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
DEFAULT_TOLERANCE = 1e-10
WISDOM_HUBBARD = (0.089195487, 0.01398851089834702)  # q and J_2 of Wisdom & Hubbard 2016, Table 3


def solved(q, **setting):
    spectral_polytrope._solution.cache_clear()
    return rotating_polytrope(q, **setting)


def error(exact):
    return lambda body: abs(body.zonal_harmonics[0] / exact - 1)


def by_degree(q, exact, against, degrees=DEGREES):
    name = f"J_2 at q = {q}, against {against}"
    return table(name, "degree", degrees, lambda degree: solved(q, degree=degree), error(exact), None)


def by_tolerance(q, exact, tolerances=TOLERANCES):
    name = f"J_2 at q = {q}, by tolerance"
    action = lambda tolerance: solved(q, tolerance=tolerance)  # noqa: E731
    return table(name, "tolerance", tolerances, action, error(exact), DEFAULT_TOLERANCE)


converged = {q: solved(q, degree=degree).zonal_harmonics[0] for q, degree in ((0.25, 30), (0.6, 44), (0.9, 80))}
publish(
    "spectral_polytrope",
    [
        by_degree(*WISDOM_HUBBARD, "Wisdom & Hubbard 2016"),
        by_degree(0.25, converged[0.25], "degree 30"),
        by_degree(0.6, converged[0.6], "degree 44"),
        by_degree(0.9, converged[0.9], "degree 80"),
        by_tolerance(*WISDOM_HUBBARD),
        by_tolerance(0.6, converged[0.6], TOLERANCES[:4]),
    ],
)
