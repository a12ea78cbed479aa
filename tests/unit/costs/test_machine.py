"""What the package knows of a machine that was not calibrated."""

import tracemalloc

import pytest

from astroinertia.build.assemble import prepare
from astroinertia.costs.machine import SHIPPED_MEMORY
from astroinertia.costs.prediction import INDIVIDUAL
from astroinertia.scene import load
from tests.sims import SIMS

COUNT, STEPS = 6000, 3


def after(steps, scene):
    body = prepare(scene).evolution
    for _ in range(steps):
        body.advance(body.end)
    return body


@pytest.mark.slow  # compilation
@pytest.mark.parametrize(
    ("steps", "factor"), [("global", 1.0), pytest.param("individual", INDIVIDUAL, marks=pytest.mark.full)]
)
def test_arrays_of_a_step_take_most_of_the_memory_that_a_plan_reckons_with_and_no_more(steps, factor):
    """As long as nothing is kept that is needed no more. The rest is what the allocator loses between them."""
    settings = [f"body.particles={COUNT}", "body.placement=random", "numerics.precision=mixed"]
    scene = load.load_file(SIMS / "evrard.toml", [*settings, f"numerics.timesteps={steps}"])
    after(STEPS, scene)  # what is compiled is not to be traced
    tracemalloc.start()
    body = after(1, scene)
    tracemalloc.reset_peak()
    for _ in range(STEPS - 1):
        body.advance(body.end)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    reckoned = factor * COUNT * SHIPPED_MEMORY["particle.mixed"]
    assert 0.7 * reckoned < most < 0.95 * reckoned
