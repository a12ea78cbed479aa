"""Compressible Roche figures against the homogeneous ellipsoids, Love numbers and the virial theorem."""

import numpy as np
import pytest

from astroinertia.bodies import roche
from astroinertia.bodies.apsidal import love_number
from astroinertia.bodies.roche_polytrope import roche_limit, roche_polytrope

COARSE = {"radii": 96, "degrees": 8}


@pytest.mark.full
@pytest.mark.parametrize("index", [1.0, 1.5])
def test_small_tides_and_rotation_give_the_love_number(index: float) -> None:
    """Q_xx - Q_zz = 4/3 k2 R^5 mu to first order in mu; the next two are removed by doubling 1 - c/a twice."""
    found = []
    for c in (0.98, 0.96, 0.92):
        figure = roche_polytrope(index, c, radii=192, degrees=8)
        x, _, z = figure.second_moments
        found.append((x - z) / (4.0 / 3.0 * figure.tide))
    assert (8 * found[0] - 6 * found[1] + found[2]) / 3 == pytest.approx(love_number(index), rel=2e-3)


@pytest.mark.parametrize("index", [0.5, 1.0, 1.5])
def test_the_virial_theorem_holds(index: float) -> None:
    assert roche_polytrope(index, 0.6).virial <= 1e-4


@pytest.mark.full
def test_the_limit_tends_to_that_of_the_homogeneous_ellipsoid() -> None:
    """mu at the limit for n = 0.5 and 0.25, extrapolated to 0, against Chandrasekhar's 0.0901 pi rho."""
    indices = np.array([0.5, 0.25])
    limits = [roche_limit(float(n), **COARSE).tide for n in indices]
    at_zero = np.polynomial.Polynomial.fit(indices, limits, 1)(0.0)
    assert at_zero == pytest.approx(roche.limit(0.0).tide * 0.75, rel=0.015)


@pytest.mark.slow
def test_the_limit_is_the_largest_tide_and_has_converged() -> None:
    limit = roche_limit(0.5, **COARSE)
    for c in (limit.c_over_a - 0.05, limit.c_over_a + 0.05):
        assert roche_polytrope(0.5, c, **COARSE).tide < limit.tide
    assert limit.scaled_distance == pytest.approx(roche_limit(0.5).scaled_distance, rel=2e-3)


def test_an_index_without_such_a_limit_is_refused() -> None:
    with pytest.raises(ValueError, match=r"from 0.2 to 1.5"):
        roche_limit(2.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, 0.6), "0 < n < 3"),
        ((3.0, 0.6), "0 < n < 3"),
        ((np.nan, 0.6), "0 < n < 3"),
        ((1.0, 1.0), "0 < c/a < 1"),
        ((1.0, 1.2), "0 < c/a < 1"),  # its companion was at a complex distance
        ((1.0, -0.5), "0 < c/a < 1"),
        ((1.0, 0.8, 0), "16 radii or more"),
        ((1.0, 0.8, 64, 7), "even degree of 2 or more, not 64 and 7"),
    ],
)
def test_what_is_no_figure_is_refused(arguments: tuple[float, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        roche_polytrope(*arguments)  # type: ignore[arg-type]
