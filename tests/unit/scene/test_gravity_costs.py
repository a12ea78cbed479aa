"""Which way of gravity a scene gets: as it asks, or direct sums where they cost less; `plan` shows both costs."""

import re

import numpy as np
import pytest

from astroinertia.build import sph as start_sph
from astroinertia.build.assemble import prepare
from astroinertia.build.effects import effects_of
from astroinertia.models.sph.state import Problem
from astroinertia.scene import gravity_costs, load
from astroinertia.scene.plan import plan
from astroinertia.scene.schema import Scene
from astroinertia.units import DIMENSIONLESS

SCENE = """
name = "cloud"
units = "code"
[body]
kind = "power_law"
exponent = 1.0
mass = 1.0
radius = 1.0
relax = false
placement = "random"
particles = 300
specific_internal_energy = 0.05
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
[effects.gravity]
[effects.pressure]
[time]
end = 1.0
"""


def plan_entries(*settings: str) -> dict[str, tuple[str, str]]:
    """The plan's lines of model and numerics for SCENE with these settings: {name: (value, why)}."""
    return plan_entries_of(load.loads(SCENE, settings))


def plan_entries_of(scene: Scene) -> dict[str, tuple[str, str]]:
    return {line.name: (line.value, line.why) for line in plan(scene).sections["model and numerics"]}


def crossing(precision: str) -> int:
    return next(n for n in range(16, 10**6) if gravity_costs.cheaper(n, "numba_cpu", precision, 2e-4) == "multipole")


@pytest.mark.parametrize("precision", ["mixed", "float64"])
def test_the_cheaper_method_is_taken_and_reported_with_both_costs(precision: str) -> None:
    edge = crossing(precision)
    for particles, words in ((edge - 1, "direct sums"), (edge, "multipoles, forces to 0.0002")):
        value, why = plan_entries(f"body.particles={particles}", f'numerics.precision="{precision}"')["gravity"]
        assert value == words
        costs = r"direct sums take about [\d.]+ ms a step on two cores, multipoles [\d.]+ ms"
        assert re.fullmatch(rf"cheaper with {particles} particles: {costs}", why)


def test_a_method_that_is_asked_for_is_taken() -> None:
    value, why = plan_entries('effects.gravity.method="multipole"', "effects.gravity.force_error=1e-5")["gravity"]
    assert value == "multipoles, forces to 1e-05"
    assert why.startswith("as asked for: ")
    assert plan_entries("body.particles=1000000", 'effects.gravity.method="direct"')["gravity"][0] == "direct sums"


def test_a_smaller_error_costs_more_and_moves_the_crossing_up() -> None:
    costs = [gravity_costs.seconds("multipole", 10**5, "numba_cpu", "mixed", error) for error in (1e-3, 1e-4, 1e-6)]
    assert costs == sorted(costs)
    assert gravity_costs.seconds("direct", 10**5, "numba_cpu", "mixed", 1e-3) == gravity_costs.seconds(
        "direct", 10**5, "numba_cpu", "mixed", 1e-6
    )


@pytest.mark.parametrize(("asked", "passes"), [("auto", 1), ("direct", 1), ("multipole", 0)])
def test_a_run_takes_what_the_plan_says(asked: str, passes: int) -> None:
    gravity = effects_of(load.loads(SCENE, [f'effects.gravity.method="{asked}"']), DIMENSIONLESS, 300)[0]
    assert len(gravity.all_pair_terms) == passes


class Chosen(Exception):
    """The physics and numerics are there, and the first sums would begin."""


def test_a_table_is_counted_before_the_method_is_chosen(tmp_path, monkeypatch) -> None:
    def refuse(problem: Problem, *_: object, **__: object) -> None:
        raise Chosen(problem.effects[0].method)

    monkeypatch.setattr(start_sph, "initial_state", refuse)  # compiles for a minute, and chooses nothing
    particles = crossing("float64")
    position = np.random.default_rng(1).normal(size=(particles, 3))
    np.savez(tmp_path / "body.npz", mass=np.full(particles, 1 / particles), **dict(zip("xyz", position.T, strict=True)))
    body = '[body]\nkind = "table"\nfile = "body.npz"\nspecific_internal_energy = 0.05\n'
    text = SCENE[: SCENE.index("[body]")] + body + SCENE[SCENE.index("[equation_of_state]") :]
    scene = load.loads(text, origin=str(tmp_path))
    assert plan_entries_of(scene)["gravity"] == ("auto", "by the number of particles in the table")
    with pytest.raises(Chosen, match=r"^multipole$"):
        prepare(scene)


def test_other_models_than_particles_do_without_the_method() -> None:
    text = SCENE.replace('name = "cloud"', 'name = "cloud"\nmodel = "ellipsoid"').replace('placement = "random"\n', "")
    scene = load.loads(text)
    assert "gravity" not in plan_entries_of(scene)
    (line,) = (line for line in plan(scene).effects if line.kind == "gravity")
    assert line.options == ""
    assert effects_of(scene, DIMENSIONLESS)[0].kind == "gravity"
