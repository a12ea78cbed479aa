"""Densities that are sums of standard volumes: sharp where materials meet, with forces that follow from energy."""

from pathlib import Path

import jax
import numpy as np
import pytest

from astroinertia.build import assemble, sph
from astroinertia.build.placing import particles
from astroinertia.build.planets import planet
from astroinertia.errors import SceneError
from astroinertia.models.sph.evaluate import effect_accelerations
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.record import energy_budget, ledger_closure, snapshot_record
from astroinertia.scene import load
from astroinertia.scene.plan import code_units

SCENE = Path(__file__).parents[3] / "sims" / "rocky_planet.toml"
SHARP = "equation_of_state.boundary_pressure='0 GPa'"
PLANET = ["body.particles=200", "body.relax=false"]


@pytest.fixture(scope="module")
def text():
    """The scene with smooth boundaries."""
    lines = SCENE.read_text().splitlines(keepends=True)
    return "".join(line for line in lines if not line.startswith("boundary_pressure"))


def placed(text, *settings):
    scene = load.loads(text, [*PLANET, *settings])
    units = code_units(scene)
    problem, initial = sph.problem_of(scene, units)
    return problem, particles(scene, units, initial, problem)


@pytest.mark.parametrize("order", ["second", "fourth"])
def test_forces_follow_from_the_energy(text, order):
    """m a . d is minus the slope of the energy along displacements d of all particles; no force is left over."""
    settings = [f"effects.{kind}.order={order}" for kind in ("pressure", "gravity")]
    rng = np.random.default_rng(3)
    with jax.enable_x64(True):
        problem, body = placed(text, SHARP, "numerics.smoothing_tolerance=1e-14", *settings)
        unit = np.ptp(body.position)
        # Denser than at rest, so that few particles are without pressure.
        position = 0.9 * body.position + 0.01 * unit * rng.normal(size=body.position.shape)
        push = 1e-5 * unit * rng.normal(size=position.shape)

        def state_at(place):
            still = np.zeros_like(place)
            return initial_state(problem, body.mass, place, still, body.entropy, material=body.material)[0]

        def energies(place):
            budget = energy_budget(problem, state_at(place))
            return np.array([budget["potential"]["gravity"], budget["internal"]])

        state = state_at(position)
        back = np.argsort(np.asarray(state.identity))
        found = dict(zip(problem.effect_names, effect_accelerations(np, state.rates), strict=True))
        once = energies(position + push) - energies(position - push)
        twice = energies(position + 2 * push) - energies(position - 2 * push)
    for kind, slope in zip(("gravity", "pressure"), (8 * once - twice) / 12, strict=True):
        force = body.mass[:, None] * np.asarray(found[kind])[back]
        assert abs((force * push).sum() + slope) < 1e-10 * np.linalg.norm(force) * np.linalg.norm(push), kind
        assert np.linalg.norm(force.sum(axis=0)) < 1e-13 * np.abs(force).sum(), kind
        assert np.linalg.norm(np.cross(position, force).sum(axis=0)) < 1e-13 * np.abs(force).sum() * unit, kind


def beside_the_boundary(text, *settings):
    """Mean density over the exact one of the particles within a smoothing length of it, below and above."""
    scene = load.loads(text, ["body.particles=500", "body.relax=false", *settings])
    with jax.enable_x64(True):
        record = snapshot_record(assemble.prepare(scene).evolution.state)
        ball = planet(scene, code_units(scene))
        distance = np.linalg.norm(record["position"], axis=1)
        exact = np.asarray(ball.solution.layered().density(distance))
    near = np.abs(distance - float(ball.solution.layer_radii[0])) < record["smoothing_length"]
    ratio = record["density"] / exact
    return [float(ratio[near & (record["material"] == number)].mean()) for number in (0, 1)]


def test_the_density_is_sharp_where_materials_meet(text):
    """Particles in their places, at the pressure of this boundary: the error is the glass's, and does not jump."""
    smooth, sharp = (beside_the_boundary(text, *s) for s in ((), ("equation_of_state.boundary_pressure='160 GPa'",)))
    assert smooth[0] < 0.88
    assert smooth[1] > 1.07
    assert sharp == pytest.approx([1.0, 1.0], abs=0.06)
    assert sharp[0] / sharp[1] == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("timesteps", ["global", "individual"])
def test_what_is_conserved_stays(text, timesteps):
    """Momenta and the ledger to rounding; energy as well as without."""
    changes = {}
    for settings in ((), (SHARP,)):
        scene = load.loads(text, [*PLANET, f"numerics.timesteps={timesteps}", *settings])
        with jax.enable_x64(True):
            body = assemble.prepare(scene).evolution
            before = energy_budget(body.problem, body.state)
            while body.steps < 40:
                body.advance(float("inf"))
            after = energy_budget(body.problem, body.state)
            mass, position, velocity = (np.asarray(getattr(body.state, n)) for n in ("mass", "position", "velocity"))
            assert ledger_closure(body.problem, body.state) < 1e-13
        momentum, spin = mass[:, None] * velocity, mass[:, None] * np.cross(position, velocity)
        assert np.linalg.norm(momentum.sum(axis=0)) < 1e-12 * np.abs(momentum).sum()
        assert np.linalg.norm(spin.sum(axis=0)) < 1e-12 * np.abs(spin).sum()
        changes[settings] = abs(after["total"] - before["total"]) / abs(before["potential"]["gravity"])
    assert changes[SHARP,] < max(2 * changes[()], 1e-7)


def test_one_material_has_no_boundaries(text):
    """The option changes nothing there, and costs nothing."""
    rock = text.replace('[[body.layers]]\nmaterial = "iron"\nmass_fraction = 0.3\n', "")
    rock = rock.replace("mass_fraction = 0.7", "mass_fraction = 1.0")
    rock = rock.replace('[[equation_of_state.materials]]\nname = "iron"\ntillotson = "iron"\n', "")
    states = []
    for settings in ((), (SHARP,)):
        with jax.enable_x64(True):
            body = assemble.prepare(load.loads(rock, [*PLANET, *settings])).evolution
        assert not any(getattr(effect, "volumes", False) for effect in body.problem.effects)
        assert body.state.rates.fluid.standard_density is None
        states.append(body.arrays())
    assert states[0].keys() == states[1].keys()
    for name, array in states[0].items():
        np.testing.assert_array_equal(states[1][name], array, err_msg=name)


def test_what_has_no_sharp_boundaries_is_refused(text):
    with pytest.raises(SceneError, match="boundary_pressure"):
        placed(text, SHARP, "effects.pressure.gradients=integral")
