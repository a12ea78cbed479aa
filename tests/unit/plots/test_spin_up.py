"""Pictures of spin-up: what stands in them, at the right place."""

import numpy as np
import pytest

from astroinertia.plots.spin_up import period_radius_figure, pulsar_diagram
from astroinertia.rotation import pulsars
from astroinertia.rotation.pulsar_table import pulsar, pulsars as observed
from astroinertia.studies.spinup import cases, period_against_radius


def _texts(figure) -> str:
    return "\n".join(text.get_text() for axes in figure.axes for text in axes.texts)


def _heights(axes, x: float) -> list[float]:
    """Where the lines of a panel stand at x."""
    found = []
    for line in axes.lines:
        across, up = np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)
        if len(across) > 50 and across.min() <= x <= across.max():
            order = np.argsort(across)
            found.append(float(np.exp(np.interp(np.log(x), np.log(across[order]), np.log(up[order])))))
    return found


def test_period_against_radius_shows_every_case_and_its_end():
    figure = period_radius_figure(period_against_radius())
    texts = _texts(figure)
    for case in cases():
        assert case.name in texts
    assert "100 s to 29.7 ms" in texts and "39.7 h to 9.9 h" in texts
    crosses = [line for axes in figure.axes for line in axes.lines if line.get_marker() == "X"]
    assert len(crosses) == 1  # the cloud, which stops at its barrier
    assert float(crosses[0].get_xdata()[0]) == pytest.approx(4.23e9, rel=0.1)  # km
    only = period_against_radius([case for case in cases() if case.radius_after < 1e5])
    assert len(period_radius_figure(only).axes) == 1


def test_the_pulsar_diagram_has_its_lines_where_they_belong():
    crab = pulsar("Crab")
    figure = pulsar_diagram(tracks=[("Crab", crab.period, crab.period_derivative, 2.51)])
    axes = figure.axes[0]
    points = {
        (float(x), float(y))
        for line in axes.lines
        if line.get_linestyle() == "None"
        for x, y in zip(line.get_xdata(), line.get_ydata(), strict=True)
    }
    assert all((star.period, star.period_derivative) in points for star in observed())
    heights = np.array(_heights(axes, 0.1))
    for expected in (
        pulsars.dipole_period_derivative(0.1, 1e8),  # 1e12 G
        0.1 / (2 * 1e5 * 365.25 * 86400),  # 100 kyr
        1e28 * 0.1**3 / (4 * np.pi**2 * 1e38),
        crab.period_derivative * (0.1 / crab.period) ** (2 - 2.51),
    ):
        assert np.abs(heights / expected - 1).min() < 1e-3
    assert "Crab, n = 2.51" in _texts(figure) and "spin-up line" in _texts(figure)
