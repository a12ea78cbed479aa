"""Steps of standard problems: signals as the effects have them, and flows as far as particles follow these."""

import math

import numpy as np
import pytest

from astroinertia.costs import flows
from astroinertia.costs.signals import agreement, fastest
from astroinertia.effects import pressure, viscosity
from astroinertia.scene import load
from astroinertia.sph.kernels import KERNELS, eta_for_neighbours
from astroinertia.test_problems import noh, sedov
from tests.sims import SIMS

OPTIONS = {"alpha_max": 1.0, "beta": 4.0, "limiter": "none"}


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
    assert agreement(np.array(1.0), np.array(rate)) == pytest.approx(viscosity.agreement(np, 1.0, rate))


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
    steps = flows.limits(scene, 0.01).shortest
    # The 60th neighbour of a lattice is in a shell of its own: kernels are that much off.
    assert steps[0] == pytest.approx(0.3 * length / (2.0 * math.sqrt(5 / 3 * 1000)), rel=0.1)
    alone = scene.model_copy(update={"effects": {"pressure": scene.effects["pressure"]}})
    without = flows.limits(alone, 0.01).shortest
    assert without[0] == pytest.approx(2.0 * steps[0], rel=1e-6)


def test_a_shock_that_compresses_shortens_the_steps_of_noh():
    """Gas of density 64 has a quarter of the spacing, and particles that fall on it at a speed of 1 the signal
    c + 1 + c + 4, c the mean of 0.745 (the square root of 5/9) behind the shock and of none before it.
    """
    scene = of("noh", "body.particles=20000", "time.end=0.6")
    steps = flows.limits(scene, 0.6).shortest
    spacing = (4 / 3 * math.pi / 20000) ** (1 / 3)
    length = eta_for_neighbours(KERNELS["quartic"], 60) * spacing
    exact = 0.3 * 0.25 * length / (5.0 + math.sqrt(5 / 9))
    assert exact < steps[-1] < 1.6 * exact  # tracers do not see all of the density that more particles see
    assert noh.exact(np.array([[0.1, 0.0, 0.0]]), 0.6, np.ones(3), 5 / 3).density == 64.0


def test_an_explosion_is_that_of_a_point_once_it_has_left_where_it_began():
    mass = 1 / 500
    begins = sedov.begins(mass, 5 / 3)
    assert 4 / 3 * math.pi * sedov.shock_radius(begins, 5 / 3) ** 3 == pytest.approx(sedov.INJECTED * mass)
    limits = flows.limits(of("sedov"), 0.05)
    times, steps = limits.times, limits.shortest
    early = steps[(times > 0.0) & (times < begins)]
    assert early == pytest.approx(steps[0])  # its matter is as it was placed
    assert steps[-1] > steps[times > begins][0]  # it slows down


def test_eight_times_the_particles_take_twice_the_steps():
    few, many = (flows.limits(of("sod", f"body.particles={count}"), 0.2).shortest for count in (2000, 16000))
    assert few == pytest.approx(2.0 * many)
