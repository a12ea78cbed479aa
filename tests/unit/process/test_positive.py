"""Numbers that must be above zero."""

import math

import numpy as np
import pytest

from astroinertia.process.positive import refuse_negative, require_positive


@pytest.mark.parametrize("wrong", [0.0, -1.0, math.nan, math.inf, np.array([1.0, 0.0]), [[2.0], [-3.0]]], ids=str)
def test_what_is_not_positive_and_finite_is_named(wrong):
    first = next(number for number in np.ravel(wrong) if not 0 < number < math.inf)
    with pytest.raises(ValueError, match=rf"^mass must be positive and finite, not {first:g}$"):
        require_positive(radius=1.0, mass=wrong, length=-1.0)


def test_what_is_positive_passes():
    require_positive(mass=5e-324, radius=np.array([1.0, 1e308]), count=3, empty=[])


def test_what_is_negative_is_named_and_what_is_not_known_passes():
    refuse_negative(mass=0.0, radius=np.array([1.0, math.nan, math.inf]), empty=[])
    with pytest.raises(ValueError, match=r"^radius must not be negative, not -3$"):
        refuse_negative(mass=1.0, radius=np.array([math.nan, -3.0]))
