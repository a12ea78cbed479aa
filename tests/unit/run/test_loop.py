"""A run that takes far more steps than were planned says so while it goes."""

import io
import math
from pathlib import Path

import pytest
from rich.console import Console

from astroinertia.run import loop
from astroinertia.run.meter import Meter
from astroinertia.scene.load import load_file
from tests.sims import SIMS


@pytest.mark.slow
@pytest.mark.parametrize(("planned", "says"), [(1.0, True), (1e9, False)])
def test_a_run_that_leaves_its_plan_by_a_factor_of_ten_says_so(
    planned: float, says: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(loop, "_predicted", lambda _: {"predicted_steps": planned, "predicted_evolution_time": 1e6})
    seen: list[loop.Progress] = []
    loop.run_scene(load_file(SIMS / "tennis_racket.toml"), tmp_path / "run", seen.append)
    assert any(math.isfinite(each.planned_steps) for each in seen) == says
    for each in seen:
        assert math.isfinite(each.planned_steps) == (each.step > 10.0 * planned)
        # What was predicted of a plan that was wrong is no longer counted on.
        assert not (says and each.step > 10.0 and each.to_go > 1e4)


def test_what_is_left_is_as_predicted_at_first_and_by_the_pace_soon() -> None:
    assert loop.seconds_left(0.0, 0.0, 1.0, 100.0) == 100.0
    assert loop.seconds_left(0.05, 20.0, 0.9, 100.0) == pytest.approx(0.9 * (0.5 * 400.0 + 0.5 * 100.0))
    assert loop.seconds_left(0.2, 80.0, 0.8, 100.0) == pytest.approx(320.0)
    assert loop.seconds_left(0.01, 4.0, 0.99, math.nan) == pytest.approx(396.0)
    assert math.isnan(loop.seconds_left(0.0, 0.0, 1.0, math.nan))


def test_the_line_of_such_a_run_names_the_plan() -> None:
    text = io.StringIO()
    with Meter(Console(file=text)) as meter:
        meter.tell(loop.Progress(0.5, 1.0, 230, 20.0, 0.0, 0.0, 1.0, planned_steps=22.9))
        meter.tell(loop.Progress(0.6, 1.0, 240, 40.0, 0.0, 0.0, 1.0))
    warned, usual = text.getvalue().splitlines()
    assert "step 230" in warned
    assert "WARNING: the plan was about 22.9 steps" in warned
    assert "WARNING" not in usual
