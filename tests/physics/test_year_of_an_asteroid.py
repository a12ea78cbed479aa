"""A year of hourly records of a tumbling asteroid: its calls and steps are counted, which no busy machine changes.

What it takes in seconds is in tests/benchmarks/results/rigid_records.md.
"""

from collections import Counter

import numpy as np
import pytest

import astroinertia
from astroinertia.models.rigid.evolution import RigidBody
from astroinertia.run import loop
from astroinertia.scene import load
from tests.benchmarks import rigid_records

SCENE = rigid_records.SCENE.replace("INTEGRATOR", "splitting")
HOURS = 8766


@pytest.mark.full
def test_hours_are_met_many_in_one_call_and_in_one_step_each(tmp_path, monkeypatch):
    calls = Counter()

    def counted(name):
        method = getattr(RigidBody, name)

        def call(self, *arguments):
            calls[name] += 1
            return method(self, *arguments)

        monkeypatch.setattr(RigidBody, name, call)

    for name in ("through", "advance", "record"):
        counted(name)
    found = astroinertia.open(loop.run_scene(load.loads(SCENE), tmp_path / "run"))
    np.testing.assert_allclose(found["time"], 3600.0 * np.arange(HOURS + 1), rtol=1e-12)
    assert calls["through"] <= HOURS / loop.OUTPUTS_AT_ONCE + 2
    assert calls["advance"] <= 1 and calls["record"] <= 2  # the first record, and one where a call meets no output
    assert found["step"][-1] == HOURS  # 130 of them in a rotation are fine enough: the records ask for no more
