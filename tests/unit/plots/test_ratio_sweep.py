"""Sweeps of ratios as pictures: curves over what was swept, in its own unit, with the published core."""

import numpy as np
import pytest

from astroinertia.errors import SceneError
from astroinertia.plots.ratio_sweep import ratio_sweep_figure
from astroinertia.studies.moment_ratio import two_layer_sweep

DENSITIES = np.linspace(5500.0, 8000.0, 6)


def panel(figure, words):
    return next(axes for axes in figure.axes if axes.get_ylabel().startswith(words))


def test_a_curve_is_over_the_density_that_was_swept():
    family = two_layer_sweep("Mars", {"core_density": DENSITIES})
    figure = ratio_sweep_figure(family)
    axes = panel(figure, "radius of the core (km)")
    curve = axes.get_lines()[0]
    np.testing.assert_allclose(curve.get_xdata(), DENSITIES)
    assert np.all(np.diff(curve.get_ydata()) < 0)
    assert 1500 < curve.get_ydata()[-1] < 1600
    assert axes.get_lines()[1].get_ydata()[0] == pytest.approx(1830.0)  # published
    names = [each.get_ylabel() for each in figure.axes if each.get_ylabel()]
    assert not [name for name in names if name.startswith(("density of the core", "I/(M R^2)"))]  # swept, and constant
    assert all("core" in each.get_xlabel() for each in figure.axes[-2:])


@pytest.mark.slow
@pytest.mark.parametrize("members", [3, 8])
def test_a_second_parameter_has_a_curve_for_each_value(members):
    ratios = np.linspace(0.36, 0.37, members)
    figure = ratio_sweep_figure(
        two_layer_sweep("Mars", {"moment_ratio": ratios, "core_density": np.linspace(6e3, 7e3, 9)})
    )
    axes = panel(figure, "radius of the core")
    lines = axes.get_lines()[:members]
    assert all(len(line.get_xdata()) == 9 for line in lines)
    assert lines[0].get_ydata()[0] > lines[-1].get_ydata()[0]
    if members == 3:
        legend = figure.legends[0]
        assert [text.get_text() for text in legend.get_texts()] == ["0.36", "0.365", "0.37"]
        figure.draw_without_rendering()
        covered = legend.get_window_extent()
        assert not any(covered.overlaps(each.get_tightbbox()) for each in figure.axes)
    else:
        assert figure.axes[-1].get_ylabel().startswith("I/(M R^2)")


def test_more_than_two_parameters_are_refused():
    values = {"core_density": [6e3, 7e3], "moment_ratio": [0.36, 0.37], "radius": [3.3e6, 3.4e6]}
    with pytest.raises(SceneError, match="one or two parameters, not 3"):
        ratio_sweep_figure(two_layer_sweep("Mars", values))
