"""Densities that are sums of standard volumes: sharp where materials meet, with forces that follow from energy."""

from pathlib import Path

import jax
import numpy as np
import pytest

from astroinertia.build import assemble, sph
from astroinertia.build.combine import together
from astroinertia.build.placing import Particles, particles
from astroinertia.build.planets import planet
from astroinertia.errors import SceneError
from astroinertia.models.sph.evaluate import effect_accelerations
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.record import energy_budget, ledger_closure
from astroinertia.scene import load
from astroinertia.scene.plan import code_units
from astroinertia.sph.standard_volumes import DENSITY_FACTOR

pytestmark = pytest.mark.usefixtures("steps_differ")

SCENE = Path(__file__).parents[3] / "sims" / "rocky_planet.toml"
SHARP = "equation_of_state.boundary_pressure='0 GPa'"
PLANET = ["body.particles=200", "body.relax=false"]


@pytest.fixture(scope="module")
def text():
    """The scene with smooth boundaries and surface."""
    lines = SCENE.read_text().splitlines(keepends=True)
    return "".join(line for line in lines if not line.startswith(("boundary_pressure", "surface")))


def placed(text, *settings):
    scene = load.loads(text, [*PLANET, *settings])
    units = code_units(scene)
    problem, initial = sph.problem_of(scene, units)
    return problem, particles(scene, units, initial, problem)


@pytest.mark.full
@pytest.mark.parametrize("order", ["second", "fourth"])
def test_forces_follow_from_the_energy(text, order):
    """m a . d is minus the slope of the energy along displacements d of all particles; no force is left over.

    Particles have factors of their own.
    """
    settings = [f"effects.{kind}.order={order}" for kind in ("pressure", "gravity")]
    rng = np.random.default_rng(3)
    with jax.enable_x64(True):
        problem, body = placed(text, SHARP, "numerics.smoothing_tolerance=1e-14", *settings)
        unit = np.ptp(body.position)
        # Denser than at rest, so that few particles are without pressure.
        position = 0.9 * body.position + 0.01 * unit * rng.normal(size=body.position.shape)
        push = 1e-5 * unit * rng.normal(size=position.shape)
        memory = {DENSITY_FACTOR: rng.uniform(0.8, 1.2, len(position))}

        def state_at(place):
            still = np.zeros_like(place)
            return initial_state(
                problem, body.mass, place, still, body.entropy, material=body.material, memory=memory
            )[0]  # fmt: skip

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
        record = assemble.prepare(scene).evolution.snapshot()
        ball = planet(scene, code_units(scene))
        distance = np.linalg.norm(record["position"], axis=1)
        exact = np.asarray(ball.solution.layered().density(distance))
    near = np.abs(distance - float(ball.solution.layer_radii[0])) < record["smoothing_length"]
    ratio = record["density"] / exact
    return [float(ratio[near & (record["material"] == number)].mean()) for number in (0, 1)]


@pytest.mark.slow
def test_the_density_is_sharp_where_materials_meet(text):
    """Particles in their places, at the pressure of this boundary: the error is the glass's, and does not jump."""
    smooth, sharp = (beside_the_boundary(text, *s) for s in ((), ("equation_of_state.boundary_pressure='160 GPa'",)))
    assert smooth[0] < 0.88
    assert smooth[1] > 1.07
    assert sharp == pytest.approx([1.0, 1.0], abs=0.06)
    assert sharp[0] / sharp[1] == pytest.approx(1.0, abs=0.03)


@pytest.mark.full
def test_a_full_surface_has_the_density_of_the_planet(text):
    """Only particles whose kernels reach out of the planet are changed; sums are short of a third there."""
    ratios = {}
    for surface in ("smoothed", "full"):
        scene = load.loads(text, [*PLANET, SHARP, f"body.surface={surface}"])
        with jax.enable_x64(True):
            record = assemble.prepare(scene).evolution.snapshot()
            ball = planet(scene, code_units(scene))
            distance = np.linalg.norm(record["position"], axis=1)
            exact = np.asarray(ball.solution.layered().density(np.minimum(distance, ball.radius)))
        ratios[surface] = record["density"] / exact
        changed = record[DENSITY_FACTOR] != 1.0
        assert changed.any() == (surface == "full")
    outside = distance > 0.75 * ball.radius
    assert changed[outside].all()
    np.testing.assert_array_equal(changed, distance + 2 * record["smoothing_length"] > ball.radius)
    assert ratios["smoothed"][outside].mean() < 0.8
    np.testing.assert_allclose(ratios["full"][outside], 1.0, rtol=1e-3)
    np.testing.assert_array_equal(ratios["full"][~changed], ratios["smoothed"][~changed])


@pytest.mark.slow
def test_a_snapshot_has_the_factors(text):
    scene = load.loads(text, [*PLANET, SHARP, "body.surface=full"])
    with jax.enable_x64(True):
        record = assemble.prepare(scene).evolution.snapshot()
        names = ("mass", "position", "velocity", "entropy", "time", "material", "density", DENSITY_FACTOR)
        known = {name: np.asarray(record[name]) for name in names}
        again = sph.of_snapshot(scene, code_units(scene), known).snapshot()
    np.testing.assert_allclose(again["density"], record["density"], rtol=1e-6)


def test_bodies_come_together_with_their_factors():
    def body(**known):
        nothing = np.zeros((2, 3))
        return Particles(np.ones(2), nothing, nothing, np.ones(2), None, np.zeros(2), known)

    both = together([body(), body(**{DENSITY_FACTOR: np.array([1.2, 1.4])})])
    np.testing.assert_array_equal(both.memory[DENSITY_FACTOR], [1.0, 1.0, 1.2, 1.4])
    assert together([body(), body()]).memory == {}


@pytest.mark.slow
@pytest.mark.parametrize("timesteps", ["global", "individual"])
def test_what_is_conserved_stays(text, timesteps):
    """Momenta and the ledger to rounding, energy to the step's error, of a planet that is let go as it is placed."""
    scene = load.loads(text, [*PLANET, SHARP, "body.surface=full", f"numerics.timesteps={timesteps}"])
    with jax.enable_x64(True):
        body = assemble.prepare(scene).evolution
        before = energy_budget(body.problem, body.state)
        while body.steps < 40:
            body.advance(float("inf"))
        after = energy_budget(body.problem, body.state)
        mass, position, velocity = (np.asarray(getattr(body.state, n)) for n in ("mass", "position", "velocity"))
        assert ledger_closure(body.state) < 1e-13
    momentum, spin = mass[:, None] * velocity, mass[:, None] * np.cross(position, velocity)
    assert np.linalg.norm(momentum.sum(axis=0)) < 1e-12 * np.abs(momentum).sum()
    assert np.linalg.norm(spin.sum(axis=0)) < 1e-12 * np.abs(spin).sum()
    assert after["kinetic"] > 1e-3 * abs(before["potential"]["gravity"])
    assert abs(after["total"] - before["total"]) < 3e-4 * abs(before["potential"]["gravity"])


@pytest.mark.full
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
    with pytest.raises(SceneError, match="boundary_pressure"):
        placed(text, "body.surface=full")
