"""Figures of tops are legible for every kind of motion, and their paths stay within the limits that they draw."""

import numpy as np
import pytest

from astroinertia.plots import tops
from astroinertia.rotation.free_top import free_top
from astroinertia.rotation.heavy_top import heavy_top
from tests.unit.plots.test_plots import assert_legible

pytestmark = pytest.mark.slow

MOTIONS = {
    "racket": ([1.0, 2.0, 3.0], [0.1, 1.0, 0.1]),
    "separatrix": ([1.0, 1.5, 3.0], [3.0, 0.6, 1.0]),
    "prolate": ([2.0, 2.0, 1.0], [0.3, 0.4, 1.0]),
    "rod": ([0.0, 2.0, 2.0], [0.3, 0.4, 1.0]),
    "sphere": ([2.0, 2.0, 2.0], [0.3, 0.4, 1.0]),
    "at rest": ([1.0, 2.0, 3.0], [0.0, 0.0, 0.0]),
}


@pytest.mark.full
@pytest.mark.parametrize("name", MOTIONS)
def test_figures_of_free_tops_are_legible(name):
    assert_legible(tops.free_top_figure(free_top(*MOTIONS[name]), name))


def test_the_axis_of_a_heavy_top_stays_between_its_least_and_greatest_tilt():
    shown = {
        "loops": heavy_top(1.0, 0.6, 0.8, 0.7, (0.0, -0.5, 5.0)),
        "cusps: let go": heavy_top(1.0, 0.6, 0.8, 0.7, (0.0, 0.0, 5.0)),
        "waves": heavy_top(1.0, 0.6, 0.8, 0.7, (0.0, 0.12, 5.0)),
        "sleeping": heavy_top(1.0, 0.6, 0.8, 0.0, (0.0, 0.0, 5.0)),
    }
    figure = tops.heavy_top_figure(shown, "gyroscope")
    assert_legible(figure)
    for panel in figure.axes:
        low, high = (np.hypot(*line.get_data()).max() for line in panel.lines[:2])
        out = np.hypot(*panel.lines[2].get_data())
        np.testing.assert_allclose([out.min(), out.max()], [low, high], rtol=1e-5, atol=1e-12)
