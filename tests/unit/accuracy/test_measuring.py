"""What a setting takes is counted in every model, whichever way it goes on."""

import pytest

from astroinertia.accuracy.measuring import measure
from astroinertia.accuracy.selected_observables import parsed
from astroinertia.scene.load import load_file
from tests.sims import SIMS


@pytest.mark.parametrize(
    ("name", "settings"),
    [("tennis_racket", ("time.end=2 s",)), ("core_to_pulsar_scaling", ())],
)
def test_the_time_of_the_steps_is_counted(name, settings, tmp_path):
    """Rigid bodies go through many records in one call, and not by `advance`."""
    measured = measure(load_file(SIMS / f"{name}.toml", settings), [parsed("angular_velocity")], tmp_path / "run")
    assert not measured.failure
    assert measured.cpu_time > 0.0
    assert 0.0 < measured.step_time < measured.wall_time
