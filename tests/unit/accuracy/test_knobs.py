"""Accuracy knobs of scenes: every value is a scene that can be run, and the default is the scene itself."""

import pytest

from astroinertia.accuracy.companion_runs import companion_runs
from astroinertia.accuracy.knobs import knobs, overridden, shown
from astroinertia.build.assemble import metadata
from astroinertia.scene import load
from tests.tradeoff_scenes import CASES, SIMS

ADAPTIVE = 'numerics.integrator="adaptive"'


def by_name(scene):
    return {knob.name: knob for knob in knobs(scene)}


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_value_is_a_scene_and_the_default_is_what_the_scene_has(case):
    scene = case.scene()
    found = knobs(scene)
    assert found[0].order is not None and found[0].step is not None
    for knob in found:
        assert knob.default in knob.values or knob.alternative
        turned = [overridden(scene, knob.overrides(value)) for value in knob.values]
        assert len({repr((each.numerics, each.body, each.effects, each.model)) for each in turned}) == len(knob.values)
        if not knob.alternative and knob.name != "neighbours":  # which is rounded
            same = overridden(scene, knob.overrides(knob.default))
            assert (same.numerics, same.body, same.model) == (scene.numerics, scene.body, scene.model)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_finer_steps_cost_more_and_the_inverse_gives_the_value_back(case):
    for knob in knobs(case.scene()):
        if knob.step is None:
            continue
        steps = [knob.step(value) for value in knob.values]
        costs = [knob.cost(value) for value in knob.values]
        if knob.name != "smoothing_tolerance":
            assert [costs.index(cost) for cost in sorted(costs)] == [steps.index(s) for s in sorted(steps)[::-1]]
        assert [knob.value_at(step) for step in steps] == pytest.approx(list(knob.values))


def test_all_limits_of_the_time_step_turn_together():
    scene = load.load_file(SIMS / "cold_spheroid.toml")
    knob = by_name(scene)["timestep_factor"]
    halved = overridden(scene, knob.overrides(0.5)).numerics
    for name in ("courant", "acceleration_factor", "energy_factor", "max_timestep"):
        assert getattr(halved, name) == 0.5 * getattr(scene.numerics, name)


def test_a_force_error_is_a_knob_where_gravity_is_by_multipoles():
    few = load.load_file(SIMS / "static_star.toml", ["body.particles=500"])
    many = load.load_file(SIMS / "static_star.toml", ["body.particles=100000"])
    assert "force_error" not in by_name(few)
    assert "force_error" in by_name(many)
    assert "force_error" not in by_name(load.load_file(SIMS / "free_expansion.toml"))


def test_rungs_are_those_that_take_the_scene():
    assert by_name(load.load_file(SIMS / "one_star_three_models.toml"))["model"].values == (
        "scaling",
        "ellipsoid",
        "sph",
    )
    assert "sph" not in by_name(load.load_file(SIMS / "riemann_ellipsoid.toml"))["model"].values
    assert "model" not in by_name(load.load_file(SIMS / "tennis_racket.toml"))


def test_the_method_that_a_scene_does_not_have_is_an_alternative():
    splitting = by_name(load.load_file(SIMS / "tennis_racket.toml"))
    adaptive = by_name(load.load_file(SIMS / "tennis_racket.toml", [ADAPTIVE]))
    assert splitting["adaptive_tolerance"].alternative and not splitting["steps_per_rotation"].alternative
    assert adaptive["steps_per_rotation"].alternative and not adaptive["tolerance"].alternative


@pytest.mark.parametrize(("value", "text"), [(3000.0, "3000"), (1e-13, "1e-13"), (0.5, "0.5"), ("cubic", "cubic")])
def test_values_are_written_as_persons_do(value, text):
    assert shown(value) == text


def test_particles_on_lattices_count_as_those_that_there_are():
    """Sod's tube asked for 470 particles has 216, and for 490 it has 864."""
    scene = load.load_file(SIMS / "sod.toml", ["body.particles=470"])
    step = by_name(scene)["particles"].step
    assert [round(step(count) ** -3.0) for count in (470, 490, 1860)] == [216, 864, 1296]
    assert metadata(scene)["body_particles"] == [216]
    runs = companion_runs(overridden(scene, ("body.particles=1860", "output.error_bars=true")))
    counts = [round((step(1860) * run.step) ** -3.0) for run in runs if run.name.startswith("particles-")]
    assert len(counts) == len({*counts, 1296}) - 1 and min(counts) < 1296 / 2
