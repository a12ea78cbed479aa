"""What a setting takes is counted in every model, whichever way it goes on."""

from types import SimpleNamespace

import pytest

from astroinertia.accuracy import measuring
from astroinertia.accuracy.measuring import measure
from astroinertia.accuracy.selected_observables import parsed
from astroinertia.errors import SceneError
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


def test_a_run_that_is_over_before_its_end_is_not_measured(tmp_path):
    with pytest.raises(SceneError, match=r"before its end, at which .*: time.max_steps is reached, after 1 steps\.$"):
        measure(
            load_file(SIMS / "core_to_pulsar_scaling.toml", ["time.max_steps=1"]), [parsed("mass")], tmp_path / "run"
        )


@pytest.mark.parametrize(
    "other",
    ["body.particles=1100", "effects.pressure.order='second'", "effects.gravity.force_error=1e-3"],
    ids=["no_longer_few", "order_of_pressure", "order_of_expansions"],
)
def test_what_another_setting_compiles_is_in_no_time(other, monkeypatch):
    """Times tell what more particles take: 20 s of compiling in one had 1.7e4 of them refused for 5 min, not 0.5."""
    base = ("numerics.precision='float64'", "effects.gravity.method='multipole'")
    first, second = (load_file(SIMS / "evrard.toml", ["body.particles=900", *base, *more]) for more in ((), (other,)))
    monkeypatch.setattr(measuring, "_warm", set())
    prepared = []

    def preparing(scene):
        prepared.append(scene)
        return SimpleNamespace(
            evolution=SimpleNamespace(record=lambda _: {"potential_energy": 0.0}, advance=lambda _: None),
            outputs=SimpleNamespace(end=1.0),
        )

    monkeypatch.setattr(measuring, "prepare", preparing)
    for scene in (first, first, second, first):
        measuring._compile(scene)
    assert prepared == [first, second]
