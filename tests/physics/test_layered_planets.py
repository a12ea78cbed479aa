"""Planets of several materials: they rest as the hydrostatic solver has them, and their runs keep what runs keep."""

from pathlib import Path

import jax
import numpy as np
import pytest

from astroinertia.build import assemble, sph
from astroinertia.build.planets import planet
from astroinertia.models.sph.record import energy_budget
from astroinertia.scene import load
from astroinertia.scene.plan import code_units

pytestmark = pytest.mark.usefixtures("steps_differ")

SCENE = Path(__file__).parents[2] / "sims" / "rocky_planet.toml"
UNSETTLED = ["body.particles=200", "body.relax=false"]


def scene_of(*settings):
    return load.load_file(SCENE, settings)


def after(body, steps):
    for _ in range(steps):
        body.advance(float("inf"))
    return body


@pytest.fixture(scope="module")
def solved():
    with jax.enable_x64(True):
        scene = scene_of(*UNSETTLED)
        return planet(scene, code_units(scene))


def test_layers_hold_their_share_of_particles_of_their_own_material(solved):
    with jax.enable_x64(True):
        record = assemble.prepare(scene_of(*UNSETTLED)).evolution.snapshot()
    assert (np.bincount(record["material"]) == [60, 140]).all()  # 0.3 of 200 are of the first, iron
    distance = np.linalg.norm(record["position"], axis=1)
    assert distance[record["material"] == 0].max() < distance[record["material"] == 1].min()
    core = float(solved.solution.layer_radii[0])
    assert distance[record["material"] == 0].max() == pytest.approx(core, rel=0.02)


@pytest.mark.full
def test_both_engines_move_the_same_planet():
    """Particles that carry their material through sorting: sums in another order is all that differs, 2e-14.

    Omega, which either engine takes at another iterate of the smoothing length, is as exact as that.
    """
    states = []
    text = SCENE.read_text()
    for engine in ("numba_cpu", "xla"):
        settings = [*UNSETTLED, f'numerics.engine="{engine}"', "numerics.smoothing_tolerance=1e-13"]
        with jax.enable_x64(True):
            body = assemble.prepare(load.loads(text, settings)).evolution
            states.append(after(body, 3).snapshot())
    for name in ("position", "velocity", "density", "pressure", "internal_energy", "entropy", "material"):
        scale = np.abs(states[0][name]).max()
        np.testing.assert_allclose(states[1][name], states[0][name], rtol=0, atol=1e-12 * scale, err_msg=name)


@pytest.mark.parametrize("timesteps", [pytest.param("global", marks=pytest.mark.full), "individual"])
def test_a_checkpoint_goes_on_bit_for_bit(timesteps):
    scene = scene_of(*UNSETTLED, f"numerics.timesteps={timesteps}")
    with jax.enable_x64(True):
        body = assemble.prepare(scene).evolution
        after(body, 16)
        assert body.resumable
        again = sph.resumed(scene, code_units(scene), {name: array.copy() for name, array in body.arrays().items()})
        one, other = (after(each, 3).arrays() for each in (body, again))
    assert one.keys() == other.keys()
    assert ".material" in one
    for name, array in one.items():
        np.testing.assert_array_equal(array, other[name], err_msg=name)


def pressure_errors(body, ball):
    """Mean relative error of the pressure within 0.8 smoothing lengths of the boundary, of the iron and of the rock."""
    record = body.snapshot()
    mass, position, material = (record[name] for name in ("mass", "position", "material"))
    distance = np.linalg.norm(position - mass @ position / mass.sum(), axis=1)
    error = record["pressure"] / np.asarray(ball.solution.layered().pressure(distance)) - 1
    boundary = 0.5 * (distance[material == 0].max() + distance[material == 1].min())
    near = np.abs(distance - boundary) < 0.8 * record["smoothing_length"]
    return [float(error[near & (material == number)].mean()) for number in (0, 1)]


def settled(count, dynamical_times, *settings):
    """Relative differences of I and of the pressure beside the iron from the solver's, and changes of I and energy."""
    scene = scene_of(f"body.particles={count}", *settings)
    with jax.enable_x64(True):
        prepared = assemble.prepare(scene)
        ball, body = planet(scene, prepared.units), prepared.evolution
        exact, unit = float(ball.solution.mean_moment), (ball.radius**3 / ball.mass) ** 0.5

        def moment():
            mass, position = (np.asarray(a) for a in (body.state.mass, body.state.position))
            return 2 / 3 * mass @ ((position - mass @ position / mass.sum()) ** 2).sum(axis=1)

        before, first, pressure = energy_budget(body.problem, body.state), moment(), pressure_errors(body, ball)
        farthest = 0.0
        while body.time < dynamical_times * unit:
            body.advance(float("inf"))
            farthest = max(farthest, abs(moment() / first - 1))
        energy, later = energy_budget(body.problem, body.state), pressure_errors(body, ball)
    binding = abs(before["potential"]["gravity"])
    return {
        "particles": count,
        "dynamical_times": dynamical_times,
        "moment_error": first / exact - 1,
        "moment_change": farthest,
        "pressure_errors": pressure,
        "pressure_errors_later": later,
        "energy_change": (energy["total"] - before["total"]) / binding,
        "kinetic": energy["kinetic"] / binding,
        "steps": body.steps,
    }


@pytest.mark.full
def test_a_small_planet_rests():
    """Measured at 1000: I 0.85% below the solver's, held to 5e-5 over 24 dynamical times, with 3e-9 of the energy.

    Pressure is 5.2% too low in the iron and 3.3% in the rock beside it; at 500 by 5.0 and 1.5%, and I the same.
    """
    found = settled(500, 2.0)
    assert abs(found["moment_error"]) < 0.012
    assert found["moment_change"] < 5e-4
    assert max(abs(error) for error in found["pressure_errors"]) < 0.07
    assert found["pressure_errors_later"] == pytest.approx(found["pressure_errors"], abs=0.01)
    assert abs(found["energy_change"]) < 1e-7
    assert found["kinetic"] < 2e-4


@pytest.mark.full(inputs=["sims/rocky_planet.toml"])
@pytest.mark.parametrize("count", [3000, 10000])
def test_a_planet_rests_at_full_size(count, result):
    found = settled(count, 24.0)
    result(**found)
    assert abs(found["moment_error"]) < 0.01
    assert found["moment_change"] < 5e-4
    assert max(abs(error) for error in found["pressure_errors"]) < 0.05
    assert found["pressure_errors_later"] == pytest.approx(found["pressure_errors"], abs=0.01)
    assert abs(found["energy_change"]) < 1e-6
    assert found["kinetic"] < 2e-4


@pytest.mark.full
def test_smooth_boundaries_and_surfaces_are_what_they_were():
    """Without the options pressure is off by a third beside the iron, and I is 3.0% too small."""
    text = SCENE.read_text().replace('boundary_pressure = "5 GPa"\n', "").replace('surface = "full"\n', "")
    scene = load.loads(text, ["effects.gravity.order=second"])
    with jax.enable_x64(True):
        prepared = assemble.prepare(scene)
        errors = pressure_errors(prepared.evolution, planet(scene, prepared.units))
    assert errors == pytest.approx([-0.37, 0.30], abs=0.03)
