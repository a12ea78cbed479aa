"""Stars of one mass and entropy along their angular momentum."""

import numpy as np
import pytest

from astroinertia.bodies import maclaurin
from astroinertia.bodies.polytrope import Polytrope
from astroinertia.bodies.rotating_sequence import rotating_sequence
from astroinertia.errors import SceneError

pytestmark = pytest.mark.slow  # the end of a sequence takes seconds to find


@pytest.fixture(scope="module")
def half():
    return rotating_sequence(0.5, members=21)


def test_it_begins_with_the_star_at_rest(half):
    star = Polytrope(0.5)
    first = half.at(0.0)
    assert first["polar_moment"] == pytest.approx(star.moment_of_inertia, rel=1e-8)
    assert first["energy"] == pytest.approx(star.gravitational_energy * (1 - 0.5 / 3), rel=1e-8)  # U = n |W|/3
    assert first["axis_ratio"] == pytest.approx(1, abs=1e-9)
    assert abs(first["rotational_to_gravitational"]) < 1e-12


def test_energy_grows_by_omega_dl(half):
    """Wrong radii of the members would break it: entropy or mass would not be kept."""
    momenta = np.linspace(0.05, 0.85, 9) * half.angular_momentum[-1]
    step = 0.01 * half.angular_momentum[-1]
    slope = (half.at(momenta + step)["energy"] - half.at(momenta - step)["energy"]) / (2 * step)
    np.testing.assert_allclose(slope, half.at(momenta)["angular_velocity"], rtol=2e-4)


def test_a_stiff_star_is_nearly_maclaurins(half):
    """At the same axis ratio of second moments T/|W| is that of a liquid within 0.7 %, up to T/|W| = 0.157."""
    stars = half.at(np.linspace(0.1, 0.33, 5))
    liquid = [maclaurin.from_axis_ratio(ratio).rotational_to_gravitational for ratio in stars["axis_ratio"]]
    np.testing.assert_allclose(stars["rotational_to_gravitational"], liquid, rtol=7e-3)


def test_no_star_turns_beyond_the_last(half):
    with pytest.raises(ValueError, match=r"from 0 to 0\.36"):
        half.at(0.4)
    for index in (0.0, 3.0):
        with pytest.raises(ValueError, match="between 0 and 3"):
            rotating_sequence(index)


def test_a_sequence_has_two_ends():
    for members in (1, 0, -3):
        with pytest.raises(SceneError, match=f"has 2 members or more, not {members}"):
            rotating_sequence(1.5, members=members)
