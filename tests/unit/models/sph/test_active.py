"""What an end of an interval of few particles makes again, beside the work on these."""

import numpy as np
import pytest

from astroinertia.models.sph import block_step
from astroinertia.models.sph.block_step import Taken
from astroinertia.sph.fluid import Fluid
from tests.evolve import prepared
from tests.few_with_steps import MANY_RUNGS


@pytest.mark.slow
@pytest.mark.usefixtures("steps_differ")
def test_an_end_of_an_interval_makes_few_fluids_and_arrays_of_zeros(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fluids whose memories change alone, and no array that is there already: Python takes as long as the sums."""
    body, steps, fluids, zeros = prepared(MANY_RUNGS), [], [], []
    body.advance(body.end)

    def base_step(*arguments) -> tuple:
        found = block_step.step(*arguments)
        steps.append(found[2])
        return found

    made, empty = Fluid.__init__, np.zeros
    body.base_step = base_step
    monkeypatch.setattr(
        Fluid, "__init__", lambda self, *given, **named: fluids.append(1) or made(self, *given, **named)
    )
    monkeypatch.setattr(np, "zeros", lambda *given, **named: zeros.append(given[0]) or empty(*given, **named))
    body.advance(body.end)
    taken: Taken = steps[0]
    assert taken.ends > 30
    assert len(fluids) < 7 * taken.ends  # of 11 where every effect's memories made one
    assert len(zeros) < 24 * taken.ends  # of 30 where those that are there already were made besides
