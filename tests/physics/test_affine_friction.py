"""Affine bodies that lose energy: a bar by viscosity, and by gravitational waves, against figures of equilibrium."""

from pathlib import Path

import jax
import numpy as np
import pytest

from astroinertia.bodies import jacobi, maclaurin
from astroinertia.build.assemble import prepare
from astroinertia.inertia.evolution import second_moment_acceleration
from astroinertia.scene import load
from tests import affine_scenes
from tests.affine_scenes import semi_axes, started
from tests.evolve import advanced

SIMS = Path(__file__).parent.parent.parent / "sims"
SPIN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


def of_sims(name):
    with jax.enable_x64(True):
        return prepare(load.load_file(SIMS / f"{name}.toml")).evolution


@pytest.mark.full
def test_viscosity_takes_a_maclaurin_spheroid_to_the_jacobi_ellipsoid_of_equal_spin():
    body = of_sims("maclaurin_to_jacobi")
    first = body.record(None)
    advanced(body, 60.0)
    early = body.record(0.0)["mode_amplitude"][1]
    advanced(body, 80.0)
    growth = np.log(body.record(0.0)["mode_amplitude"][1] / early) / 20.0
    assert growth == pytest.approx(1 / 27.4, rel=1e-3)
    advanced(body, 500.0)
    last, figure = body.record(0.0), jacobi.from_angular_momentum(maclaurin.from_eccentricity(0.9).angular_momentum)
    np.testing.assert_allclose(semi_axes(body), figure.axes, rtol=1e-9)
    assert last["total_energy"] == pytest.approx(figure.kinetic_energy + figure.gravitational_energy, rel=1e-11)
    assert last["angular_momentum"][2] == pytest.approx(first["angular_momentum"][2], rel=1e-11)
    assert last["total_energy"] - first["total_energy"] == pytest.approx(last["work"][2], rel=1e-9)


def test_a_riemann_ellipsoid_of_type_s_keeps_its_shape_and_turns_at_its_rate():
    body = of_sims("riemann_ellipsoid")
    first = semi_axes(body)
    advanced(body, 100.0)
    np.testing.assert_allclose(semi_axes(body), first, rtol=1e-12)
    left = np.linalg.svd(np.array(body.state.deformation))[0][:, 0]
    turned = np.arctan2(left[1], left[0]) - 0.52747394593072656 * 100.0
    assert abs(np.sin(turned)) < 1e-11


@pytest.mark.full
def test_what_viscosity_takes_heats_the_gas():
    text = affine_scenes.compressible([1.2, 1.0, 0.8], 0.3 * SPIN, 5 / 3, 0.45)
    body = started(text + "\n", "effects.shear_viscosity={kinematic_viscosity=0.05}")
    first = body.record(None)
    advanced(body, 10.0)
    last = body.record(first["potential_energy"])
    names = list(body.effects)
    heat = last["heating"][names.index("shear_viscosity")]
    assert heat > 1e-3 and heat == pytest.approx(-last["work"][names.index("shear_viscosity")], rel=1e-12)
    assert last["total_energy"] == pytest.approx(first["total_energy"], rel=1e-12)


@pytest.mark.full
def test_waves_take_the_energy_and_the_spin_of_the_quadrupole_formula():
    """A Jacobi ellipsoid: dE/dt = -(32/5) G/c^5 Omega^6 (Q_1 - Q_2)^2 = Omega dL/dt.

    Chandrasekhar 1970, Physical Review Letters 24, 611.
    """
    figure, light = jacobi.from_axis_ratio(0.5), 30.0
    text = affine_scenes.incompressible(figure.axes, figure.angular_velocity * SPIN)
    body = started(text, f"effects.radiation_reaction={{speed_of_light={light!r}}}")
    first, span = body.record(None), 2 * np.pi / figure.angular_velocity
    advanced(body, span)
    last = body.record(first["potential_energy"])
    power = 6.4 * light**-5 * figure.angular_velocity**6 * (0.2 * (figure.axes[0] ** 2 - figure.axes[1] ** 2)) ** 2
    lost = first["total_energy"] - last["total_energy"]
    assert lost == pytest.approx(power * span, rel=2e-5)
    spin = first["angular_momentum"][2] - last["angular_momentum"][2]
    assert spin * figure.angular_velocity == pytest.approx(power * span, rel=2e-5)
    assert abs(last["integration_energy_error"]) < 1e-12 and last["virial_mismatch"].max() < 1e-9
    acceleration = second_moment_acceleration(first["kinetic_tensor"], first["virial_tensor"].sum(axis=0))
    turning = 2 * figure.angular_velocity**2 * 0.2 * (figure.axes[1] ** 2 - figure.axes[0] ** 2)
    np.testing.assert_allclose(np.diag(acceleration), [turning, -turning, 0.0], atol=1e-7)
