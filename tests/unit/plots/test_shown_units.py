"""Round-off is shown as nothing, and nothing without a power of ten."""

import numpy as np
import pytest

from astroinertia.plots.shown_units import cleared, scale_of, written


def test_round_off_beside_what_it_is_of_is_nothing():
    values = np.array([2.2e-16, -4.4e-16, 1e-13, 1.0, np.nan])
    np.testing.assert_array_equal(cleared(values), [0.0, 0.0, 1e-13, 1.0, np.nan])
    np.testing.assert_array_equal(cleared(values, 1e3), [0.0, 0.0, 0.0, 1.0, np.nan])


@pytest.mark.parametrize(
    ("value", "series", "unit", "text"),
    [
        (0.0, 3e-8, "rad s-1", "0 rad s-1"),
        (-0.0, 3e-8, "1", "0"),
        (3e-8, 3e-8, "rad s-1", "3 × 10^-8 rad s-1"),
        (2.5e-8, 3e-8, "1", "2.5 × 10^-8"),
        (1.0, 1.0, "1", "1"),
        (1500.0, 1500.0, "m", "1.5 km"),
    ],
)
def test_a_value_in_running_text_has_the_unit_of_its_series(value, series, unit, text):
    assert written(value, *scale_of(unit, series)) == text
