"""Figures of precession and wobble: they say what the Dataset has in it, and refuse another."""

import numpy as np
import pytest
import xarray as xr

from astroinertia.errors import SceneError
from astroinertia.plots import precession as plots
from astroinertia.rotation.spin_orbit import surface_of_section
from astroinertia.studies.obliquity import obliquity_history
from astroinertia.studies.precession import chandler_wobble

MINUS = "\N{MINUS SIGN}"
ARCSECOND, YEAR = np.pi / 648000, 31557600.0


def words(figure):
    return " ".join(text.get_text() for axes in figure.axes for text in axes.texts) + " ".join(
        axes.get_title(loc="left") for axes in figure.axes
    )


def nodding():
    """A Dataset as of studies.precession.precession, of an axis that goes back and nods with one period."""
    times = np.linspace(-30.0, 30.0, 400) * YEAR
    phase, rate = times / (3 * YEAR), 50 * ARCSECOND / YEAR
    steady, mean = rate * times, np.full_like(times, 0.41)
    return xr.Dataset(
        {
            "longitude": ("time", steady + 17 * ARCSECOND * np.sin(phase)),
            "obliquity": ("time", mean + 9 * ARCSECOND * np.cos(phase)),
            "steady_longitude": ("time", steady),
            "steady_obliquity": ("time", mean),
            "precession_rate": ("part", [rate, 0.3 * rate, 0.7 * rate]),
            "correction_rate": ("correction", [-0.02 * ARCSECOND / YEAR]),
            "corrected_rate": 49.98 * ARCSECOND / YEAR,
            "published_rate": 49.97 * ARCSECOND / YEAR,
            "difference": -6.6e-6,
        },
        {"time": times, "part": ["all", "Sun", "Moon"], "correction": ["geodesic precession"]},
        {"body": "Earth"},
    )


def test_precession():
    figure = plots.precession_figure(nodding())
    texts = words(figure)
    for what in (
        "torque of the Sun",
        "1 500.000",
        "5 000.000",
        MINUS + "2.000",
        "4 998.000",
        "4 997.000",
        f"1 {MINUS} 6.6 × 10⁻⁶",
    ):
        assert what in texts
    longitude, obliquity = figure.axes[0].lines[-1].get_ydata(), figure.axes[1].lines[-1].get_ydata()
    assert np.abs(longitude).max() == pytest.approx(17, rel=1e-3)
    assert np.abs(obliquity).max() == pytest.approx(9, rel=1e-3)


def test_the_wobble():
    figure = plots.chandler_figure(chandler_wobble())
    texts = words(figure)
    for what in ("303.6 d", "+140.3", "\N{MINUS SIGN}50.5", "+29.7", "+9.1", "observed 433 d", "433.2 d"):
        assert what in texts
    bars = figure.axes[0].patches
    assert bars[2].get_y() + bars[2].get_height() == pytest.approx(393.4, abs=0.1)  # a bar that hangs


@pytest.mark.slow
def test_sections_and_histories():
    section = surface_of_section(0.1, 0.2, np.zeros(5), np.linspace(0.5, 2.0, 5), 20, 24)
    figure = plots.section_figure(section, 0.1, 0.2, (1, 1.5))
    assert len(figure.axes[0].lines) == 7 and "1.5" in words(figure)
    figure = plots.obliquity_figure(obliquity_history("Mars", 1e6, samples=200))
    assert "Myr" in figure.axes[0].get_xlabel() and "Mars" in figure.get_suptitle()
    assert "Between 17.1" in words(figure)


def test_other_datasets_are_refused():
    for draw in (plots.precession_figure, plots.chandler_figure, plots.obliquity_figure):
        with pytest.raises(SceneError, match="this figure is of"):
            draw(xr.Dataset())
