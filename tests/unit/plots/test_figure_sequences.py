"""The picture of homogeneous figures: what its lines and its map say."""

import math

import numpy as np
import pytest

from astroinertia.bodies import maclaurin, riemann
from astroinertia.bodies.ellipsoid_stability import spectrum
from astroinertia.plots.figure_sequences import figure_sequences


@pytest.mark.full
def test_picture_of_homogeneous_figures(tmp_path):
    figure = figure_sequences(8)
    figure.savefig(tmp_path / "sequences.png")
    panels = figure.get_axes()
    map_, spins, growth = (
        next(panel for panel in panels if panel.get_title(loc="left").startswith(title))
        for title in ("Where", "How", "What")
    )
    mesh = map_.collections[0]
    corners, values = mesh.get_coordinates(), np.asarray(mesh.get_array()).reshape(mesh.get_coordinates().shape[:2])
    row, column = 3, 0  # a slender figure with Omega = -Lambda
    body = riemann.from_rate_ratio(float(corners[row, column, 0]), -1.0)
    assert corners[row, column, 1] == pytest.approx(body.c_over_a, rel=1e-12)
    unit = math.sqrt(math.pi * body.density)
    assert (
        values[row, column] == pytest.approx(spectrum(body).growth_rate / unit, rel=1e-9) and values[row, column] > 0.1
    )
    assert (values[-2] == 0).all()  # nearly round about the axis: stable
    sequences = spins.get_lines()
    assert sequences[0].get_xydata()[-1] == pytest.approx(
        [maclaurin.bifurcation().angular_momentum, maclaurin.bifurcation().omega2], rel=1e-12
    )
    curves = {line.get_label(): line.get_xydata() for line in growth.get_lines()}
    dynamical = curves["without friction"]
    assert (np.diff(dynamical[:3, 1]) > 0).all() and dynamical[0, 0] > 0.27382
    viscous = next(line for name, line in curves.items() if name.startswith("viscosity"))
    assert 0.1375 < viscous[0, 0] < 0.142 and (viscous[:, 1] > 0).all()


def test_too_few_points_are_refused():
    with pytest.raises(ValueError, match="at least 8"):
        figure_sequences(2)
