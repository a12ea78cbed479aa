"""Steps of standard problems: signals as the effects have them, and flows as far as particles follow these."""

import math

import numpy as np
import pytest

from astroinertia.costs import flows
from astroinertia.costs.limits import limits
from astroinertia.costs.signals import fastest
from astroinertia.effects.kinds import pressure, viscosity
from astroinertia.scene import load
from astroinertia.sph.kernels import KERNELS, eta_for_neighbours
from astroinertia.test_problems import noh, sedov
from astroinertia.test_problems.matter import standard
from tests.sims import SIMS

OPTIONS = {"alpha_max": 1.0, "beta": 4.0, "limiter": "none"}


def _placed(scene):
    return scene.body.placed(scene, scene.body.particles)


def limits_of(scene, end):
    return limits(scene, flows.matter(scene, end))


def of(problem: str, *settings: str):
    return load.load_file(SIMS / f"{problem}.toml", ["body.particles=500", *settings])


@pytest.mark.parametrize("rate", [-3.0, -0.1, 0.0, 0.4, 5.0])
def test_signals_of_pairs_are_those_of_the_effects(rate):
    sound, alpha = 0.7, 0.8
    side = viscosity.Side(1.0, -1.0, sound, alpha * sound, alpha * OPTIONS["beta"])
    of_pressure = pressure.pressure_pair(np, rate, -1.0, -1.0, 1.0, 1.0, sound, sound)[-1]
    of_viscosity = viscosity.viscosity_pair(np, rate, side, side)[-1]
    assert fastest(np.array(rate), np.array(sound), None) == pytest.approx(of_pressure)
    assert fastest(np.array(rate), np.array(sound), OPTIONS, alpha) == pytest.approx(max(of_pressure, of_viscosity))


def test_reconstruction_takes_out_a_smooth_flow_and_leaves_a_jump():
    options, rate, sound = OPTIONS | {"limiter": "reconstruction"}, np.array(-1.0), np.array(0.5)
    assert fastest(rate, sound, options, 1.0, rate, 1.0) == pytest.approx(2.0)
    assert fastest(rate, sound, options, 1.0, rate, 0.0) == fastest(rate, sound, OPTIONS, 1.0) == pytest.approx(6.0)


def test_a_gas_at_rest_is_crossed_by_its_sound():
    """Of a strong tube before its wall breaks: sound of (5/3 1000)^(1/2), and as fast a viscosity."""
    scene = of("strong_tube")
    spacing = (0.125 / 320) ** (1 / 3)  # of the 320 particles that its lattice has
    kernel = KERNELS["quartic"]
    length = eta_for_neighbours(kernel, 60) * spacing
    steps = limits_of(scene, 0.01).shortest
    # The 60th neighbour of a lattice is in a shell of its own: kernels are that much off.
    assert steps[0] == pytest.approx(0.3 * length / (2.0 * math.sqrt(5 / 3 * 1000)), rel=0.1)
    alone = scene.model_copy(update={"effects": {"pressure": scene.effects["pressure"]}})
    without = limits_of(alone, 0.01).shortest
    assert without[0] == pytest.approx(2.0 * steps[0], rel=1e-6)


def test_a_shock_that_compresses_shortens_the_steps_of_noh():
    """Gas of density 64 has a quarter of the spacing, and particles that fall on it at a speed of 1 the signal
    c + 1 + c + 4, c the mean of 0.745 (the square root of 5/9) behind the shock and of none before it.
    """
    scene = of("noh", "body.particles=20000", "time.end=0.6")
    steps = limits_of(scene, 0.6).shortest
    spacing = (4 / 3 * math.pi / 20000) ** (1 / 3)
    length = eta_for_neighbours(KERNELS["quartic"], 60) * spacing
    exact = 0.3 * 0.25 * length / (5.0 + math.sqrt(5 / 9))
    assert exact < steps[-1] < 1.6 * exact  # tracers do not see all of the density that more particles see
    assert noh.exact(np.array([[0.1, 0.0, 0.0]]), 0.6, np.ones(3), 5 / 3).density == 64.0


def test_an_explosion_is_that_of_a_point_once_it_has_left_where_it_began():
    mass = 1 / 500
    begins = sedov.begins(mass, 5 / 3)
    assert 4 / 3 * math.pi * sedov.shock_radius(begins, 5 / 3) ** 3 == pytest.approx(sedov.INJECTED * mass)
    found = limits_of(of("sedov"), 0.05)
    times, steps = found.times, found.shortest
    early = steps[(times > 0.0) & (times < begins)]
    assert early == pytest.approx(steps[0])  # its matter is as it was placed
    assert steps[-1] > steps[times > begins][0]  # it slows down


@pytest.mark.parametrize("problem", ["sod", "noh", "kelvin_helmholtz"])
def test_as_many_particles_are_counted_as_are_placed(problem):
    scene = of(problem)
    lengths = np.full(3, np.inf) if scene.box is None else np.array(scene.box.lengths)
    assert scene.body.placed(scene, 500) == len(standard(problem).place(500, lengths, 5 / 3).mass) != 500
    many = of(problem, "body.particles=50000000")
    assert many.body.placed(many, 50_000_000) == 50_000_000  # which are not placed for that


def test_viscosity_is_spared_in_layers_that_slide_slower_than_sound():
    """Of Kelvin and Helmholtz: with the full viscosity the shear of 1 is a signal of c + 1/2 + c + 4/2 at least."""
    scene = of("kelvin_helmholtz")
    effects = scene.effects | {"viscosity": scene.effects["viscosity"] | {"limiter": "none"}}
    limited, plain = (limits_of(one, 1.5).shortest[0] for one in (scene, scene.model_copy(update={"effects": effects})))
    quiet = (
        0.3 * eta_for_neighbours(KERNELS["quartic"], 60) * (0.125 / 400 * 1.5) ** (1 / 3) / (2.0 * math.sqrt(25 / 6))
    )
    assert plain < 0.7 * quiet
    assert limited == pytest.approx(quiet, rel=0.15)


@pytest.mark.slow
def test_more_particles_take_more_steps_by_the_cube_root_of_how_many_are_placed():
    few, many = (of("sod", f"body.particles={count}") for count in (2000, 16000))
    more = (_placed(many) / _placed(few)) ** (1 / 3)
    assert 1.7 < more < 2.3
    assert limits_of(few, 0.2).shortest == pytest.approx(more * limits_of(many, 0.2).shortest)
