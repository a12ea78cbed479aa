"""The largest size of a quantity: what is not known counts for nothing, what is infinite is the largest."""

import numpy as np
import pytest

from astroinertia.dataset.sizes import largest_size


@pytest.mark.parametrize(
    ("values", "expected"),
    [([[1.0, -3.0], [np.nan, 2.0]], 3.0), ([-np.inf, 1.0], np.inf), ([np.nan], 0.0), ([], 0.0), (None, 0.0)],
)
def test_the_largest_size_skips_what_is_unknown(values, expected):
    assert largest_size(values) == expected


def test_what_is_unknown_throughout_is_what_the_caller_says():
    assert np.isnan(largest_size(np.full((2, 3), np.nan), unknown=np.nan))
    assert largest_size([0.0, np.nan], unknown=np.nan) == 0.0
