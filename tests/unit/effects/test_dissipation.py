"""Velocity gradients, viscosity and conduction, against closed forms, on a few hundred particles."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import astroinertia
from astroinertia.build.assemble import prepare
from astroinertia.effects import catalogue
from astroinertia.effects.gradients import curl_size, flow_sums, linear_gradient, shear, trace
from astroinertia.effects.kinds.viscosity import isotropic_part
from astroinertia.engines import numba_cpu, xla
from astroinertia.engines.terms import argument_names, arguments
from astroinertia.errors import SceneError
from astroinertia.matter.cold_matter import Hybrid
from astroinertia.models.sph import block_step
from astroinertia.models.sph.evaluate import internal_energy
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.limits import limiting, particle_limits
from astroinertia.models.sph.step import step
from astroinertia.scene.load import loads
from astroinertia.sph.kernels import KERNELS
from tests.ball import ball, state_of
from tests.pairs import pair_sums

pytestmark = pytest.mark.usefixtures("steps_differ")

FALLING_IN = """
name = "falling_in"
units = { mass = "1 Msun", length = "1 Rsun" }
[body]
kind = "uniform"
mass = "1 Msun"
radius = "1 Rsun"
particles = 200
pressure_fraction = 0.1
velocity_gradient = [["-2e-4 1/s", "0 1/s", "0 1/s"], ["0 1/s", "-2e-4 1/s", "0 1/s"], ["0 1/s", "0 1/s", "-2e-4 1/s"]]
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
[effects]
gravity = {}
pressure = {}
viscosity = {}
conduction = { coefficient = 1e6 }
[time]
end = "0.1 s"
"""
SHARED = ("mass", "position", "velocity", "smoothing_length")
FLOW = np.array([[0.3, -0.7, 0.2], [0.5, -0.4, 0.9], [-0.1, 0.6, 0.25]])


def velocity_gradients(fluid: Any) -> np.ndarray:
    """(3, 3, N)."""
    return np.array(linear_gradient(np, *(np.moveaxis(sums, 0, -1) for sums in flow_sums(fluid))))


@pytest.mark.slow
def test_gradients_are_exact_in_linear_flows_at_the_surface_too() -> None:
    position = ball()
    viscosity = catalogue.build("viscosity", {"switch": "none"})
    _, state, _ = state_of(viscosity, position=position, velocity=position @ FLOW.T)
    flow = velocity_gradients(state.rates.fluid)
    assert np.abs(flow - FLOW[:, :, None]).max() < 1e-12
    assert np.allclose(trace(np, flow), np.trace(FLOW), atol=1e-12)
    vorticity = [FLOW[2, 1] - FLOW[1, 2], FLOW[0, 2] - FLOW[2, 0], FLOW[1, 0] - FLOW[0, 1]]
    assert np.allclose(curl_size(np, flow), np.linalg.norm(vorticity), atol=1e-12)
    sheared = 0.5 * (FLOW + FLOW.T) - np.trace(FLOW) / 3 * np.eye(3)
    assert np.allclose(shear(np, flow), (sheared**2).sum(), atol=1e-12)


def test_gradients_are_finite_without_neighbours_and_in_a_plane() -> None:
    random = np.random.default_rng(4)
    plane = random.normal(size=(40, 3)) * (1.0, 1.0, 0.0)
    position = np.concatenate([plane, [[1e3, 0.0, 0.0]]])
    fields = {
        "position": position,
        "mass": np.ones(41),
        "smoothing_length": np.full(41, 0.8),
        "velocity": position @ FLOW.T,
    }
    terms = catalogue.build("viscosity", {"switch": "none"}).gradient_terms
    found = velocity_gradients(SimpleNamespace(gradients=pair_sums(terms, fields, "cubic")))
    assert np.all(np.isfinite(found))
    assert np.array_equal(found[..., -1], np.zeros((3, 3)))


def heat_and_drag(velocity: np.ndarray, position: np.ndarray, steps: int = 0, **options: Any) -> dict[str, Any]:
    """Viscous figures of a flow after some steps of 1e-3 with pressure: total heating, and what it is made of."""
    listed = (catalogue.build("pressure"), catalogue.build("viscosity", options))
    problem, state, arrangement = state_of(*listed, position=position, velocity=velocity)
    for _ in range(steps):
        state = step(problem, arrangement, state, np.float64(1e-3))
    fluid = state.rates.fluid
    heating = fluid.sums["viscosity"]["heating"]
    force = fluid.sums["viscosity"]["acceleration"]
    return {
        "heating": fluid.mass @ heating,
        "each": heating,
        "work": fluid.mass @ (force * fluid.velocity).sum(axis=1),
        "kinetic": 0.5 * fluid.mass @ (fluid.velocity**2).sum(axis=1),
        "alpha": state.memory.get("viscosity_alpha"),
        "force": force,
        "fluid": fluid,
    }


@pytest.mark.parametrize("options", [{}, {"switch": "none"}, {"switch": "none", "limiter": "none"}], ids=str)
def test_rigid_rotation_dissipates_nothing(options: dict[str, Any]) -> None:
    """No pair closes in rigid rotation: what is left is round-off, 1e-14 of the kinetic energy in a rotation time."""
    position = ball()
    found = heat_and_drag(np.cross([0.0, 0.3, 1.0], position), position, **options)
    assert 0 <= found["heating"] < 1e-14 * found["kinetic"]


@pytest.mark.full
def test_the_switch_keeps_differential_rotation_almost_free_of_viscosity() -> None:
    """A flow that only shears turns on less than a hundredth of the constant viscosity without a limiter."""
    position = ball(500)
    spin = 1.0 / (1.0 + 4.0 * (position[:, 0] ** 2 + position[:, 1] ** 2))
    velocity = np.cross(np.stack([0 * spin, 0 * spin, spin], axis=1), position)
    heats = [
        heat_and_drag(velocity, position, **options)["heating"]
        for options in ({"switch": "none", "limiter": "none"}, {"switch": "none"}, {})
    ]
    assert heats[1] < 0.2 * heats[0]
    assert heats[2] < 0.01 * heats[0]


@pytest.mark.full
def test_viscosity_heats_every_particle_with_what_it_takes_from_the_motion() -> None:
    position, random = ball(), np.random.default_rng(5)
    for options in ({}, {"switch": "none"}, {"switch": "none", "limiter": "guarded_reconstruction"}):
        found = heat_and_drag(random.normal(size=position.shape) - 3 * position, position, 3, **options)
        assert found["each"].min() >= 0
        assert found["heating"] > 0
        assert abs(found["work"] + found["heating"]) < 1e-14 * found["heating"]
        mass = found["fluid"].mass
        assert np.abs(mass @ found["force"]).max() < 1e-14 * (mass @ np.linalg.norm(found["force"], axis=1))


def test_the_isotropic_part_of_a_stress_follows_from_its_heat() -> None:
    """Of eta (2 S + (div v) 1), whose heat is eta (2 S:S + (div v)^2), it is (5/3) eta |div v|, up to the pressure and
    the thermal energy in a volume.
    """
    flow, eta, density = FLOW - 0.6 * np.eye(3), 0.7, 2.0
    sheared, rate = (flow + flow.T) / 2, -np.trace(flow)
    stress = eta * (2 * sheared - rate * np.eye(3))
    heating = (stress * sheared).sum() / density
    moment = tuple(map(tuple, -2.0 * np.eye(3)))
    arguments_of = (moment, tuple(map(tuple, -2.0 * flow)), heating)
    exact = -np.trace(stress) / 3
    assert isotropic_part(np, density, 9.0, 9.0, *arguments_of)[0] == pytest.approx(exact, rel=1e-12)
    assert isotropic_part(np, density, 0.3, 9.0, *arguments_of)[0] == 0.3
    assert isotropic_part(np, density, 9.0, 0.1, *arguments_of)[0] == 0.1 * density
    assert isotropic_part(np, density, -0.3, 9.0, *arguments_of)[0] == 0.0
    expanding = tuple(map(tuple, 2.0 * flow))
    assert isotropic_part(np, density, 9.0, 9.0, moment, expanding, heating)[0] == 0.0


@pytest.mark.full
@pytest.mark.parametrize("limiter", ["reconstruction", "guarded_reconstruction"])
def test_a_trace_free_stress_draws_together_and_cools_by_what_it_is_less(limiter: str) -> None:
    """What is kept of the whole stress's heat is what whole pairs make of the same state, and the rest is conserved."""
    position, random = ball(), np.random.default_rng(5)
    velocity = random.normal(size=position.shape) - 3 * position
    found = heat_and_drag(velocity, position, 3, limiter=limiter, stress="trace_free")
    assert abs(found["work"] + found["heating"]) < 1e-14 * found["heating"]
    fluid, trace_free = found["fluid"], catalogue.build("viscosity", {"limiter": limiter, "stress": "trace_free"})
    fields = trace_free.fields(np, fluid) | {name: getattr(fluid, name) for name in SHARED}
    whole = pair_sums(catalogue.build("viscosity", {"limiter": limiter}).neighbour_terms, fields, "cubic")["viscosity"]
    kept = trace_free.remember_sums(np, fluid)["viscous_heating"]
    np.testing.assert_allclose(kept, whole["heating"], rtol=1e-10, atol=1e-12 * kept.max())
    pressure = fluid.memory["viscous_pressure"]
    assert 0.1 < (pressure > 0).mean() < 1.0
    assert np.all(pressure <= fluid.pressure)
    assert found["each"].mean() < 0.97 * whole["heating"].mean()
    drawn = fluid.mass @ ((found["force"] - whole["acceleration"]) * position).sum(axis=1)
    assert drawn < -0.03 * fluid.mass @ (whole["acceleration"] * position).sum(axis=1)


@pytest.mark.full
def test_a_trace_free_stress_cools_no_cold_matter_by_more_than_it_has() -> None:
    """Matter without warmth that is driven together gains what effects bring: no entropy is held by a limit."""
    position, random = ball(), np.random.default_rng(5)
    velocity = 0.1 * random.normal(size=position.shape) - 0.5 * position
    effects = [catalogue.build("pressure", {}), catalogue.build("viscosity", {"stress": "trace_free"})]
    problem, state, _ = state_of(*effects, position=position, velocity=velocity, entropy=0.0)
    problem = replace(problem, equation_of_state=Hybrid(0.5, gamma_1=1.3, gamma_2=2.5, gamma_thermal=1.5, constant=3.0))
    state, arrangement = initial_state(problem, state.mass, position, velocity, state.entropy)
    before = internal_energy(problem, state)
    for _ in range(4):
        state = step(problem, arrangement, state, state.rates.timestep)
    gained = internal_energy(problem, state) - before
    assert state.memory["viscous_pressure"].max() > 0.0
    assert state.ledger.heating.total.sum() == pytest.approx(gained, rel=1e-12)


def test_a_trace_free_stress_is_for_matter_that_can_be_warm() -> None:
    polytropic = FALLING_IN.replace('"ideal"', '"polytropic"\nconstant = "from body"')
    trace_free = polytropic.replace("viscosity = {}", 'viscosity = { stress = "trace_free" }')
    prepare(loads(polytropic.replace("conduction = { coefficient = 1e6 }", "")))
    with pytest.raises(SceneError, match=r"\[effects.viscosity\] as it is set needs matter that can be warm"):
        prepare(loads(trace_free.replace("conduction = { coefficient = 1e6 }", "")))


def test_a_trace_free_stress_is_for_flows_that_are_reconstructed() -> None:
    with pytest.raises(ValueError, match="needs one of the limiters reconstruction and guarded_reconstruction"):
        catalogue.build("viscosity", {"limiter": "balsara", "stress": "trace_free"})


def test_a_smooth_collapse_is_not_viscous() -> None:
    """A linear inflow leaves no jump to dissipate: round-off, where the plain form heats at the rate of the inflow."""
    position = ball()
    plain = heat_and_drag(-(position @ FLOW.T @ FLOW), position, switch="none", limiter="balsara")
    found = heat_and_drag(-(position @ FLOW.T @ FLOW), position, switch="none")
    assert plain["heating"] > 0.05 * plain["kinetic"]
    assert 0 <= found["heating"] < 1e-12 * found["kinetic"]


def test_gas_that_expands_is_not_viscous() -> None:
    position = ball()
    found = heat_and_drag(2.0 * position, position)
    assert found["heating"] == 0
    assert np.all(found["force"] == 0)


@pytest.mark.slow
def test_alpha_jumps_where_the_flow_steepens_and_decays_afterwards() -> None:
    """Two streams meet in a bar of 31 spacings: alpha is up at the interface, before any particle has moved by a tenth
    of a spacing, and zero where its neighbours do not see it.
    """
    position = np.stack(np.meshgrid(np.arange(-15.0, 16), *2 * [np.arange(4.0)]), axis=-1).reshape(-1, 3)
    velocity = np.stack([-np.tanh(position[:, 0]), *2 * [0 * position[:, 0]]], axis=1)
    listed = (catalogue.build("pressure"), catalogue.build("viscosity"))
    problem, state, arrangement = state_of(*listed, position=position, velocity=velocity, entropy=1.0)
    for _ in range(4):
        state = step(problem, arrangement, state, np.float64(0.02))
    alpha, x = state.memory["viscosity_alpha"], np.abs(position[:, 0])
    assert alpha[x == 0].mean() > 0.5
    assert alpha[x >= 6].max() < 1e-4
    assert 0 <= alpha.min() <= alpha.max() <= 1
    # The same particles in a flow that no longer steepens: alpha decays as exp(-dt v_sig/(10 h)).
    viscosity, fluid = listed[1], state.rates.fluid
    still = jax.tree.map(np.zeros_like, fluid.gradients)
    still["common"]["position"] = fluid.gradients["common"]["position"]
    signal = still["viscosity"]["signal"] = fluid.gradients["viscosity"]["signal"]
    quiet = SimpleNamespace(**{**vars(fluid), "gradients": still, "memory": state.memory})
    h, signal = fluid.smoothing_length, np.maximum(signal, fluid.sound_speed)
    later = viscosity.remember(np, quiet, 0.05)["viscosity_alpha"]
    assert np.allclose(later, alpha * np.exp(-0.05 * signal / (10.0 * h)), rtol=1e-12, atol=1e-30)


def test_the_signal_velocity_covers_sound_approach_and_viscosity() -> None:
    position = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])
    fields = {
        "position": position,
        "velocity": np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]),
        "mass": np.ones(2),
        "smoothing_length": np.full(2, 0.2),
        "density": np.ones(2),
        "sound_speed": np.array([0.5, 0.7]),
        "viscosity_linear": np.array([0.5, 0.7]),
        "viscosity_quadratic": np.full(2, 2.0),
    }
    terms = catalogue.build("viscosity", {"limiter": "balsara"}).neighbour_terms
    found = pair_sums(terms, fields, "cubic")["viscosity"]
    assert np.allclose(found["signal"], 0.6 + 2.0 + 0.6 + 2.0 * 2.0)


@pytest.mark.full
def test_reconstruction_leaves_a_smooth_collapse_alone() -> None:
    """A homologous contraction is no shock: what Balsara's factor leaves in full, reconstruction all but removes."""
    position = ball(500)
    heats = [
        heat_and_drag(-position, position, switch="none", limiter=limiter)["heating"]
        for limiter in ("balsara", "reconstruction")
    ]
    assert heats[1] < 1e-10 * heats[0]


def test_guarded_reconstruction_trusts_linear_flow_no_nearer_than_the_spacing() -> None:
    """A pair in a homologous inflow: no push at the spacing, all of it where particles meet, and between them what the
    Gaussian of Frontiere et al. (2017) says, to 7 % of the whole (three terms of its series stand for it).
    """
    apart = np.linspace(0.01, 1.5, 150)
    side = {"dW": -1.0, "density": 1.0, "sound_speed": 1.0, "viscosity_linear": 1.0, "viscosity_quadratic": 0.0}
    side |= {
        f"strain_{axes}": -1.0 if axes in ("xx", "yy", "zz") else 0.0 for axes in ("xx", "yy", "zz", "xy", "xz", "yz")
    }
    pair = {f"{name}_{end}": value for name, value in side.items() for end in "ij"}
    pair |= {"r": apart, "v_r": -apart, "x_ij": apart, "y_ij": 0.0, "z_ij": 0.0, "spacing_i": 1.0, "spacing_j": 0.8}

    def push(limiter: str) -> np.ndarray:
        (term,) = catalogue.build("viscosity", {"limiter": limiter}).neighbour_terms
        return term.pair(np, *arguments(term.pair, pair))[0]

    share = push("guarded_reconstruction") / push("none")
    assert np.abs(push("reconstruction")).max() < 1e-12
    assert np.abs(share[apart >= 1.0]).max() < 1e-12
    closer = np.maximum(1.0 - apart, 0.0) / 0.2
    assert np.abs(share - (1.0 - np.exp(-(closer**2)))).max() < 0.07
    assert share[0] > 0.995
    assert np.all(np.diff(share) < 1e-12)


@pytest.mark.parametrize("options", [{}, {"limiter": "shear"}, {"signal": "pressure_jump"}], ids=str)
def test_conduction_moves_heat_downhill_and_keeps_its_sum(options: dict[str, Any]) -> None:
    position, random = ball(), np.random.default_rng(6)
    hot = position[:, 0] > 0
    effect = catalogue.build("conduction", options)
    _, state, _ = state_of(
        catalogue.build("pressure"),
        effect,
        position=position,
        velocity=random.normal(size=position.shape),
        entropy=np.where(hot, 2.0, 0.5),
    )
    fluid = state.rates.fluid
    heating, hot = fluid.sums["conduction"]["heating"], fluid.position[:, 0] > 0
    assert abs(fluid.mass @ heating) < 1e-15 * (fluid.mass @ np.abs(heating))
    assert heating[hot].sum() < 0 < heating[~hot].sum()
    assert "acceleration" not in fluid.sums["conduction"]


def test_conduction_leaves_a_body_at_rest_alone() -> None:
    position = ball()
    entropy = 1.0 + position[:, 2] ** 2
    _, state, _ = state_of(
        catalogue.build("pressure"),
        catalogue.build("conduction"),
        position=position,
        velocity=np.zeros_like(position),
        entropy=entropy,
    )
    assert np.all(state.rates.fluid.sums["conduction"]["heating"] == 0)


def conducted(velocity: np.ndarray, position: np.ndarray, engine: Any = None, **options: Any) -> np.ndarray:
    """What particles gain of conduction, in their own order, in a ball whose one half is hot."""
    effects = catalogue.build("pressure"), catalogue.build("conduction", options)
    entropy = np.where(position[:, 0] > 0, 2.0, 0.5)
    _, state, _ = state_of(*effects, position=position, velocity=velocity, entropy=entropy, engine=engine)
    return np.asarray(state.rates.fluid.sums["conduction"]["heating"])[np.argsort(state.identity)]


@pytest.mark.full
def test_the_shear_limiter_spares_streams_that_slide_past_each_other_and_not_what_converges() -> None:
    """Gradients are exact in linear flows: no heat is exchanged in a shear, and as much as without the limiter where
    all converges. A flow that converges as fast as it turns, d = -1 and |curl v| = 1, exchanges half of that.
    """
    position = ball()
    stream = position[:, [1]] * [0.0, 0.0, 1.0]
    plain, limited = (np.abs(conducted(stream, position, limiter=name)).max() for name in ("none", "shear"))
    assert limited < 1e-12 * plain
    inward = -position
    assert conducted(inward, position, limiter="shear") == pytest.approx(conducted(inward, position), rel=1e-5)
    both = stream - position / 3.0
    assert conducted(both, position, limiter="shear") == pytest.approx(0.5 * conducted(both, position), rel=1e-5)


@pytest.mark.full
def test_the_shear_limiter_is_the_same_in_both_engines() -> None:
    """Rounding apart, on flows of which the limiter leaves between nothing and all."""
    position, random = ball(), np.random.default_rng(6)
    velocity = random.normal(size=position.shape) + position[:, [1]] * [0.0, 0.0, 3.0]
    found = [conducted(velocity, position, limiter="shear")]
    with jax.enable_x64(True):
        engines = numba_cpu.Engine("float64"), xla.Engine("float64", support=KERNELS["cubic"].support)
        found += [conducted(velocity, position, engine, limiter="shear") for engine in engines]
    assert np.abs(found[0]).max() > 1e-2
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], rtol=1e-9, atol=1e-12)


def test_effects_share_one_velocity_gradient() -> None:
    """Its sums are made once where two effects need them, and each effect finds what it finds alone."""
    position, random = ball(120), np.random.default_rng(6)
    kinds = {
        "pressure": catalogue.build("pressure"),
        "viscosity": catalogue.build("viscosity", {"switch": "none"}),
        "conduction": catalogue.build("conduction", {"limiter": "shear"}),
    }
    velocity, entropy = random.normal(size=position.shape), 1.0 + position[:, 0] ** 2
    inputs = {"position": position, "velocity": velocity, "entropy": entropy}
    problem, both, _ = state_of(*kinds.values(), **inputs)
    assert len(problem.terms("gradient_terms")) == 1
    assert set(both.rates.fluid.gradients) == {"common"}
    for kind in ("viscosity", "conduction"):
        _, alone, _ = state_of(kinds["pressure"], kinds[kind], **inputs)
        assert np.array_equal(alone.rates.fluid.sums[kind]["heating"], both.rates.fluid.sums[kind]["heating"])
        assert np.abs(both.rates.fluid.sums[kind]["heating"]).max() > 0


def test_the_shear_limiter_is_for_relative_velocities() -> None:
    with pytest.raises(ValueError, match='limiter = "shear" is for signal = "relative_velocity"'):
        catalogue.build("conduction", {"limiter": "shear", "signal": "pressure_jump"})


@pytest.mark.parametrize("signal", ["relative_velocity", pytest.param("pressure_jump", marks=pytest.mark.full)])
def test_strong_conduction_limits_the_step_so_that_no_particle_leaves_the_range_of_temperatures(signal: str) -> None:
    """A stable explicit step makes each thermal energy a mean of those around: its range only shrinks."""
    position, random = ball(120), np.random.default_rng(6)
    problem, state, arrangement = state_of(
        catalogue.build("conduction", {"coefficient": 1e6, "signal": signal}),
        position=position,
        velocity=random.normal(size=position.shape),
        entropy=np.where(position[:, 0] > 0, 2.0, 0.5),
    )
    # Here densities hardly change, as steps are short.
    first = np.ptp(state.rates.fluid.thermal_energy)
    for _ in range(40):
        before = state.rates.fluid.thermal_energy
        state = step(problem, arrangement, state, state.rates.timestep)
        energy = state.rates.fluid.thermal_energy
        assert energy.max() < before.max() * (1 + 1e-4)
        assert energy.min() > before.min() * (1 - 1e-4)
    assert np.ptp(state.rates.fluid.thermal_energy) < 0.7 * first
    limits = particle_limits(problem, state.rates)
    assert limiting(limits)[0] == "conduction"
    assert np.array_equal(block_step.own_limits(problem, state.rates), limits["conduction"])


@pytest.mark.full
@pytest.mark.parametrize(("timesteps", "engine"), [("global", "xla"), ("individual", "numba_cpu")])
def test_scenes_with_strong_conduction_stay_finite(timesteps: str, engine: str, tmp_path: Path) -> None:
    scene = loads(FALLING_IN, (f'numerics.timesteps="{timesteps}"', f'numerics.engine="{engine}"'))
    with astroinertia.open(astroinertia.run_scene(scene, tmp_path / "run")) as ds:
        assert float(ds["time"][-1]) == 0.1
        assert float(abs(ds["integration_energy_error"]).max()) < 1e-6 * float(abs(ds["total_energy"]).max())


@pytest.mark.slow
def test_pair_functions_are_finite_with_their_gradients_where_particles_coincide() -> None:
    for kind, options in (
        ("viscosity", {}),
        ("viscosity", {"limiter": "balsara"}),
        ("viscosity", {"limiter": "guarded_reconstruction"}),
        ("viscosity", {"limiter": "guarded_reconstruction", "stress": "trace_free"}),
        ("conduction", {}),
        ("conduction", {"limiter": "shear"}),
        ("conduction", {"signal": "pressure_jump"}),
    ):
        effect = catalogue.build(kind, options)
        for term in (*effect.gradient_terms, *effect.neighbour_terms):
            zero = ("v_r", "dW_i", "dW_j", "r", "x_ij", "y_ij", "z_ij")
            values = {name: 0.0 if name in zero else 1.0 for name in argument_names(term.pair)}
            for number in range(len(term.outputs)):

                def output(values: Any, term: Any = term, number: int = number) -> Any:
                    return term.pair(jnp, *arguments(term.pair, values))[number]

                assert np.isfinite(output(values))
                assert all(np.isfinite(slope) for slope in jax.grad(output)(values).values())


FALLING = "velocity_gradient = [[-0.1, 0, 0], [0, -0.1, 0], [0, 0, -0.1]]"


@pytest.mark.parametrize(("motion", "trend"), [("rotation = { rate = 0.3 }", 0.0), (FALLING, -1.0)])
def test_a_body_that_only_turns_has_no_trend_of_round_off(motion: str, trend: float) -> None:
    """The sign of a divergence of 1e-16 would be another on every processor, and the first steps' heat with it."""
    scene = loads(f"""
name = "turning"
units = "code"
[body]
kind = "polytrope"
index = 1.5
particles = 64
mass = 1.0
radius = 1.0
relax = false
{motion}
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[effects.viscosity]
[time]
end = 1.0
""")
    found = np.asarray(prepare(scene).evolution.state.memory["viscosity_trend"])
    np.testing.assert_array_equal(found, trend)
