"""The affine body on its way from record to record."""

import jax
import pytest

from tests.coasting import coasting
from tests.evolve import advanced


@pytest.mark.slow
@pytest.mark.parametrize("times", [(10.0,), (1.0, 5.0, 5.0005, 5.001, 5.001 * (1.0 + 1e-15), 10.0)])
def test_steps_end_where_an_effect_begins_and_ends(times: tuple[float, ...]) -> None:
    """A push of a thousandth of a time: steps of a body that coasts are far longer."""
    with jax.enable_x64(True):
        body = coasting(7.0)
        for time in times:
            advanced(body, time)
            assert body.time == time
        assert body.record(None)["momentum"] == pytest.approx([7e-3, 0.0, 0.0], rel=1e-12)
        assert body.record(None)["centre_of_mass"][0] == pytest.approx(7e-3 * (10.0 - 5.0005), rel=1e-12)
