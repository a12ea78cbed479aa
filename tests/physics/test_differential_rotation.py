"""What gradients from a matrix keep of the angular momentum of a star in differential rotation."""

import pytest

from tests.physics.test_stars_that_stay import DIFFERENTIAL, stayed


@pytest.mark.full
def test_gradients_from_a_matrix_keep_the_angular_momentum_of_the_inner_half():
    """500 particles, 300 neighbours, 20 dynamical times: 0.6 %, give or take 1 %; with the kernel's slope 5.3 %."""
    settings = "body.particles=500", "numerics.neighbours=300", 'effects.pressure.gradients="integral"'
    stay = stayed(20.0, *settings, *DIFFERENTIAL)
    assert stay.angular_momentum < 1e-13
    assert stay.centre < 1e-13
    assert stay.t_over_w < 0.06
    assert abs(1 - stay.inner_share[1] / stay.inner_share[0]) < 0.03
