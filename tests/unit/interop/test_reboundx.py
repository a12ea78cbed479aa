"""What is given to REBOUNDx; that its orbits follow is checked by tests/physics/test_reboundx.py."""

import pytest

from astroinertia.interop.reboundx import gravitational_harmonics
from astroinertia.process.quantities import InputTypeError


def test_what_is_no_field_is_refused_in_a_sentence():
    with pytest.raises(InputTypeError, match="field of gravitational_harmonics must be a GravityField, not"):
        gravitational_harmonics({"J2": 1e-3})
