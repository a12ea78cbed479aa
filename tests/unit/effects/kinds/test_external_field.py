"""External fields: gradients of their potentials, and circular orbits."""

import math
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

from astroinertia.effects import catalogue
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.load import loads
from tests.ball import ball
from tests.unit.points import at

CLOUD = """
name = "cloud"
units = "code"
[body]
kind = "uniform"
particles = 2000
mass = 0.2
radius = 2.0
relax = false
specific_internal_energy = 0.06
position = [3.0, 0.0, 0.0]
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[effects.external_field]
point_mass = 1.0
softening = 0.2
origin = [3.0, 0.0, 0.0]
[time]
end = 3.0
"""


@pytest.mark.parametrize("softening", [0.02, 0.2, 1.0, 8.0, 2e6])
def test_a_point_mass_in_a_cloud_weighs_as_much_as_the_plan_says(softening: float) -> None:
    """Its virial over that of a uniform sphere's own gravity, by quadrature; the plan heeds it, and one outside not."""
    ratio = softening / 2.0
    own = mpmath.quad(lambda x: 3 * x**4 * (x**2 + ratio**2) ** -1.5, [0, 1]) / mpmath.mpf("0.6") / 0.2
    scene = loads(CLOUD, [f"effects.external_field.softening={softening}"])
    assert characteristic(scene).added_weight == pytest.approx(float(own), rel=1e-9)
    outer = characteristic(loads(CLOUD, ["body.position=[-3.0, 0.0, 0.0]"]))
    assert outer.added_weight == 0.0
    inside, outside = characteristic(scene).support, outer.support
    assert outside is not None and inside == pytest.approx(outside / (1.0 + float(own)), rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [
        {"uniform": (0.3, -0.2, 0.1)},
        {"quadratic": ((1.0, 0.2, 0.1), (0.2, 0.5, -0.3), (0.1, -0.3, -0.4)), "origin": (0.1, 0.2, 0.3)},
        {"circular_speed": 1.4, "core": 0.3, "origin": (0.5, 0.0, -0.5)},
        {"point_mass": 2.0, "softening": 0.1, "origin": (1.5, 0.0, 0.0)},
    ],
    ids=lambda options: next(iter(options)),
)
def test_each_given_field_is_the_gradient_of_its_potential(options: dict[str, Any]) -> None:
    effect, position = catalogue.build("external_field", options), ball(60)
    with jax.enable_x64(True):
        mass = jnp.full(len(position), 1.0 / len(position))

        def energy(x: Any) -> Any:
            return effect.potential_energy(jnp, SimpleNamespace(position=x, mass=mass))

        force = jax.grad(energy)(jnp.asarray(position))
    assert np.allclose(effect.acceleration(np, at(position)) / len(position), -force, rtol=1e-12, atol=1e-16)


@pytest.mark.parametrize("distance", [1e6, 2.0, 1e-3])
@pytest.mark.parametrize(
    ("options", "power"),
    [({"circular_speed": 1.4, "core": 0.3}, 1), ({"point_mass": 1.96, "softening": 0.3}, 1.5)],
    ids=["logarithmic", "point mass"],
)
def test_the_virial_tensor_of_a_central_field_is_that_of_its_pull_however_far_away(options, power, distance):
    """Sum m x (x) a by mpmath: written about the origin of the field it is off by 1e-4 a million sizes away."""
    position = ball(20)
    mass = np.linspace(0.5, 1.5, len(position))
    centre = mass @ position / mass.sum()
    origin = centre + distance * np.array([0.6, -0.48, 0.64])
    effect = catalogue.build("external_field", {**options, "origin": tuple(origin)})
    found = effect.virial(np, SimpleNamespace(mass=mass, position=position, centre=centre))
    with mpmath.workdps(40):
        particles = list(zip(mass.tolist(), position.tolist(), strict=True))
        middle = sum((m * mpmath.matrix(x) for m, x in particles), mpmath.zeros(3, 1)) / mpmath.fsum(mass)
        exact = mpmath.zeros(3)
        for m, x in particles:
            away = mpmath.matrix(x) - mpmath.matrix(origin)
            pull = -1.96 * away / (mpmath.fdot(away, away) + mpmath.mpf(0.3) ** 2) ** mpmath.mpf(power)
            exact += m * (mpmath.matrix(x) - middle) * pull.T
        wanted = np.array(exact.tolist(), dtype=float)
    assert np.abs(found - wanted).max() < 1e-14 * np.abs(wanted).max()


def test_circular_orbits_have_the_given_speed() -> None:
    """Far outside its core the logarithmic field holds a particle at the given speed at any radius."""
    effect = catalogue.build("external_field", {"circular_speed": 1.4, "core": 1e-6})
    for radius in (1.0, 10.0, 100.0):
        pull = effect.acceleration(np, at([[radius, 0.0, 0.0]]))[0, 0]
        assert math.isclose(math.sqrt(-pull * radius), 1.4, rel_tol=1e-11)


def test_the_potential_of_the_logarithmic_field_is_the_same_in_any_unit() -> None:
    """In another unit of length speeds and energies per mass are as they were for the same unit of velocity."""
    one = catalogue.build("external_field", {"circular_speed": 1.4, "core": 0.3})
    other = catalogue.build("external_field", {"circular_speed": 1.4, "core": 300.0})
    place = ball(60)
    energy, same = (
        effect.potential_energy(np, SimpleNamespace(position=x, mass=np.ones(len(x))))
        for effect, x in ((one, place), (other, 1000.0 * place))
    )
    assert math.isclose(energy, same, rel_tol=1e-14)
    at_the_core = catalogue.build("external_field", {"circular_speed": 1.4, "core": 1.0})
    found = at_the_core.potential_energy(np, SimpleNamespace(position=np.array([[1.0, 0.0, 0.0]]), mass=np.ones(1)))
    assert math.isclose(found, 0.98 * math.log(2.0), rel_tol=1e-14)


def test_what_flies_past_the_point_mass_takes_steps_that_resolve_it() -> None:
    """The time of the pass, distance over speed; and the orbital time of what does not fly, (d^3/M)^(1/2)."""
    effect = catalogue.build("external_field", {"point_mass": 2.0, "softening": 4.0, "origin": (1.0, 0.0, 0.0)})
    for speed, expected in ((50.0, 5.0 / 50.0), (0.0, math.sqrt(125.0 / 2.0))):
        fluid = at([[4.0, 0.0, 0.0]], velocity=[[0.0, speed, 0.0]])
        fluid.sound_speed = np.zeros(1)
        assert math.isclose(effect.timestep(np, fluid), expected, rel_tol=1e-12)
