"""Particles against Goldreich and Weber's collapse, and its models without particles.

Measured, global steps, fourth order, 150 neighbours, to a tenth of the radius: I is too large by 0.035 % with 1000
particles and 0.022 % with 3000 (parabolic, critical rate), from rest by 0.16 % and 0.074 %, at half the critical rate
by 0.025 % with 3000. What settling leaves of the net acceleration grows: from rest 1.6, 0.47 and 0.16 % with 1000
particles where 1e-3, 5e-4 and 2.5e-4 of gravity are left.
"""

from pathlib import Path

import numpy as np
import pytest

from astroinertia.accuracy.exact import exact
from astroinertia.bodies.homologous_core import HomologousCore
from astroinertia.build.assemble import prepare
from astroinertia.scene import load
from astroinertia.sph import rung_costs
from tests.evolve import reached

pytestmark = pytest.mark.usefixtures("steps_differ")

SCENE = Path(__file__).parents[2] / "sims" / "homologous_collapse.toml"
FEW = ("body.particles=300", "numerics.neighbours=80")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where bodies are kept that these tests have settled: each once, and none from before."""
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(autouse=True)
def own_cache(folder, monkeypatch):
    monkeypatch.setenv("ASTROINERTIA_CACHE", str(folder))


def collapsed(*settings: str) -> tuple[float, float]:
    """The relative errors of I about an axis and of the density of the centre at the end of the scene."""
    scene = load.load_file(SCENE, settings)
    answer, core = exact(scene), HomologousCore(scene.body.collapse_rate, start=scene.body.start)
    assert answer is not None
    body = prepare(scene).evolution
    last = reached(body, scene.time.end)[-1]
    moment = float(np.trace(last["inertia_tensor"]) / np.trace(answer.values["inertia_tensor"]))
    density = core.central_density / float(core.scale_factor(scene.time.end)) ** 3
    return moment - 1.0, float(last["density_max"]) / density - 1.0


def test_few_settled_particles_follow_the_exact_collapse_to_a_tenth():
    """Measured: 0.03 % in I, 1.1 % in the density. Unsettled ones end 9 times too large."""
    moment, density = collapsed(*FEW)
    assert abs(moment) < 7e-4
    assert abs(density) < 0.03


@pytest.mark.full
@pytest.mark.parametrize(("settings", "bar"), [
    (("body.start=rest", "time.end=1.0953407700317674"), 3e-3),  # measured 0.14 %
    (("body.collapse_rate=0.5", "time.end=0.96817"), 1.6e-3),  # 0.08 %
])  # fmt: skip
def test_other_rates_and_starts_are_followed_as_well(settings, bar):
    """What settling leaves grows: from twice the residual I ends 0.45 and 0.24 % off."""
    moment, density = collapsed(*FEW, *settings)
    assert abs(moment) < bar
    assert abs(density) < 0.05


@pytest.mark.full
def test_unsettled_particles_do_not_follow_it():
    """The binding that smoothing takes away counts beside the 3 % of gravity that draw the body in."""
    moment, _ = collapsed(*FEW, "body.relax=false", "time.end=0.4")
    assert moment > 0.5


@pytest.mark.full(inputs=["sims/homologous_collapse.toml"])
@pytest.mark.parametrize(("settings", "bar"), [
    ((), 2e-3), (("body.start=rest", "time.end=1.0953407700317674"), 6e-3),
    (("body.collapse_rate=0.5", "time.end=0.96817"), 6e-3),
])  # fmt: skip
def test_three_thousand_particles_follow_it(settings, bar, result):
    moment, density = collapsed(*settings)
    result(moment=moment, density=density)
    assert abs(moment) < bar
    assert abs(density) < 0.03


INDIVIDUAL = "numerics.timesteps=individual"


@pytest.mark.full(inputs=["sims/homologous_collapse.toml"])
def test_individual_steps_follow_it_as_global_ones_do():
    """They would save a third of the evaluations, which does not pay: all take the shortest. Measured: 0.03 % in I."""
    moment, density = collapsed(*FEW, INDIVIDUAL)
    assert abs(moment) < 2e-3
    assert abs(density) < 0.03


@pytest.mark.full
def test_splitting_the_pressure_of_pairs_errs_by_the_square_of_the_steps(monkeypatch):
    """Where intervals differ nevertheless, I is too large by 25, 6.1 and 1.5 % at courant 0.3, 0.15 and 0.075.

    A pair whose intervals differ is kicked over the longer one. In between, what presses on the inner particles from
    outside and what they press against it are not in balance, and they are denser than they should be while forces are
    evaluated that the kick is not part of. The body is drawn in by no more than 3 % of its gravity. That it is pressure
    was seen with pairs that are kicked over each particle's own interval, at pressures of the moment, which does not
    keep momentum: -0.15 and 0.005 % at courant 0.3 and 0.15.
    """
    monkeypatch.setattr(rung_costs, "PAYS", 0.0)
    errors = [
        collapsed(*FEW, INDIVIDUAL, f"numerics.courant={c}", f"numerics.acceleration_factor={c}")[0]
        for c in (0.3, 0.15)
    ]
    assert errors[1] > 0.03
    assert 2.5 < errors[0] / errors[1] < 6.0


def test_without_particles_it_is_exact():
    scene = load.load_file(SCENE, ["model=scaling"])
    body = prepare(scene).evolution
    while body.time < scene.time.end:
        body.advance(scene.time.end)
    answer = exact(scene)
    assert answer is not None
    np.testing.assert_allclose(
        body.record(None)["inertia_tensor"], answer.values["inertia_tensor"], rtol=1e-9, atol=1e-12
    )
    scene = load.load_file(SCENE, ["model=ellipsoid"])
    body = prepare(scene).evolution
    assert "exact" in body.approximation
    while body.time < scene.time.end:
        body.advance(scene.time.end)
    np.testing.assert_allclose(
        body.record(None)["inertia_tensor"], answer.values["inertia_tensor"], rtol=1e-8, atol=1e-12
    )
