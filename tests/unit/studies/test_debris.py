"""Debris of a tidal disruption: energies about the perturber, and what holds together."""

import numpy as np
import pytest
from astropy import units

from astroinertia.effects import catalogue
from astroinertia.errors import SceneError
from astroinertia.studies.debris import bound_to_itself, orbital_energies
from astroinertia.units import GRAVITATIONAL_CONSTANT


@pytest.mark.slow
@pytest.mark.parametrize(
    ("eccentricity", "time"), [(1.0, -3.0), (1.0, 0.5), pytest.param(1.8, 2.0, marks=pytest.mark.full)]
)
def test_what_rests_at_the_origin_has_the_energy_of_the_orbit(eccentricity: float, time: float) -> None:
    """M (e - 1)/(2 q), and for what moves the difference of kinetic energies."""
    options = {"mass": 50.0, "position": (0.0, 3.0, 0.0), "eccentricity": eccentricity, "pericentre_time": 0.2}
    tide = catalogue.build("tide", options)
    still, moving = np.zeros((1, 3)), np.array([[0.0, 0.0, 2.0]])
    expected = 50.0 * (eccentricity - 1.0) / 6.0
    assert orbital_energies(tide, time, still, still)[0] == pytest.approx(expected, abs=1e-12)
    assert orbital_energies(tide, time, still, moving)[0] == pytest.approx(expected + 2.0, abs=1e-12)


def test_a_cluster_holds_together_and_what_flies_off_does_not_help_it() -> None:
    random = np.random.default_rng(1)
    core = random.normal(size=(60, 3)) * 0.1
    position = np.concatenate([core, [[0.3, 0.0, 0.0], [40.0, 0.0, 0.0]]])
    velocity = np.concatenate([np.full((60, 3), 5.0), [[30.0, 0.0, 0.0], [5.0, 5.0, 5.4]]])
    mass, density = np.full(62, 1.0 / 62), np.concatenate([np.full(60, 10.0), [1.0, 1e-6]])
    held = bound_to_itself(mass, position, velocity, density, np.zeros(62))
    assert held[:60].all() and not held[60:].any()
    assert not bound_to_itself(mass, position, velocity, density, np.full(62, 1e3)).any()


def test_what_is_bound_is_so_in_any_units():
    x, v = np.array([[0.0, 0, 0], [1.0, 0, 0], [9.0, 0, 0]]), np.array([[0.0, 0, 0], [0, 1.0, 0], [0, 3.0, 0]])
    mass, density, heat = np.array([1.0, 0.1, 0.1]), np.array([9.0, 1.0, 1.0]), np.array([0.0, 0.0, 0.0])
    plain = bound_to_itself(mass, x, v, density, heat)
    speed = (GRAVITATIONAL_CONSTANT * units.Msun.to("kg") / units.Rsun.to("m")) ** 0.5 * units.m / units.s
    solar = mass * units.Msun, x * units.Rsun, v * speed, density, heat * units.J / units.kg
    np.testing.assert_array_equal(bound_to_itself(*solar), plain)
    assert plain.tolist() == [True, True, False] == bound_to_itself(mass, x, v, density, [0.0, 0.0, 0.0]).tolist()
    tide = catalogue.build("tide", {"mass": 100.0, "position": (5.0, 0.0, 0.0)})
    with pytest.raises(SceneError, match="position: must be a plain number"):
        orbital_energies(tide, 0.0, x * units.km, v)
