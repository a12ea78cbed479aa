"""How fast the particles of a simulation move."""

import math

import pytest
import rebound

from astroinertia.errors import NumericalError
from astroinertia.orbits.states import shortest_time


@pytest.mark.parametrize("count", [0, 1])
def test_what_has_no_company_has_all_the_time(count: int) -> None:
    bodies = rebound.Simulation()
    for _ in range(count):
        bodies.add(m=1.0, vx=3.0)
    assert shortest_time(bodies) == math.inf


def test_the_shortest_time_is_that_of_the_nearest_pair_and_a_pair_at_one_place_is_refused() -> None:
    bodies = rebound.Simulation()
    bodies.add(m=3.0)
    bodies.add(m=1.0, x=2.0)
    assert shortest_time(bodies) == pytest.approx(math.sqrt(8.0 / 4.0))  # at rest to each other
    bodies.add(m=1.0, x=50.0, vx=1e3)
    assert shortest_time(bodies) == pytest.approx(48.0 / 1e3)
    bodies.add(m=1.0, x=2.0)
    with pytest.raises(NumericalError, match="two of the bodies are at one place"):
        shortest_time(bodies)
