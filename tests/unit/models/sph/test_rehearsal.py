"""What is compiled ahead: a step of every kind, which changes nothing."""

import numpy as np
import pytest

from astroinertia.build.assemble import prepare
from astroinertia.models.checkpoint import flattened
from astroinertia.models.sph import active, block_step, subcycle
from astroinertia.models.sph.rehearsal import nested
from astroinertia.scene import load
from tests.sims import SIMS

SETTINGS = ["body.particles=100", "body.placement=random", "numerics.precision=float64"]


def test_sets_of_all_sizes_lie_within_each_other_and_the_last_is_worth_taking_out() -> None:
    assert np.bincount(nested(400)).tolist() == [300, 75, 19, 0, 0, 6]
    assert nested(3).tolist() == [0, 0, 0]


@pytest.mark.slow
def test_a_step_of_several_intervals_is_taken_whatever_pays_and_the_state_stays(monkeypatch) -> None:
    body = prepare(load.load_file(SIMS / "evrard.toml", [*SETTINGS, "numerics.timesteps=individual"])).evolution
    before = {name: array.copy() for name, array in body.arrays().items()}
    done = set()
    for module, name in ((block_step, "_split"), (subcycle, "part_of"), (active, "_sums_of")):
        plain = getattr(module, name)
        monkeypatch.setattr(module, name, lambda *given, name=name, plain=plain: done.add(name) or plain(*given))
    body.rehearse()
    assert done == {"_split", "part_of", "_sums_of"}
    assert body.steps == 0
    for name, array in flattened(body.state).items():
        np.testing.assert_array_equal(array, before[name], err_msg=name)
