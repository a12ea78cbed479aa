"""The theory of figures against the self-consistent field: two methods without a common integral, beyond n = 1."""

import numpy as np
import pytest

from astroinertia.bodies.figures import figure_of_polytrope
from astroinertia.bodies.rotating_star import rotating_star
from astroinertia.matter.barotropes import polytropic_matter


@pytest.mark.parametrize(
    ("index", "axis_ratio", "tolerance"),
    [(0.5, 0.85, 1e-6), (1.5, 0.95, 1e-8), (1.5, 0.85, 1e-8), (2.0, 0.9, 1e-8), (3.0, 0.9, 1e-8)],
)
def test_both_give_one_body(index, axis_ratio, tolerance):
    star = rotating_star(polytropic_matter(index), axis_ratio)
    figure = figure_of_polytrope(index, rotation_parameter=star.rotation_parameter)
    assert 1 - figure.flattening == pytest.approx(axis_ratio, rel=tolerance)
    np.testing.assert_allclose(figure.zonal_harmonics[:3], star.zonal_harmonics[:3], rtol=tolerance)
    assert figure.polar_moment_ratio_equatorial == pytest.approx(star.polar_moment_ratio_equatorial, rel=tolerance)
    assert figure.rotational_to_gravitational == pytest.approx(star.rotational_to_gravitational, rel=tolerance)
