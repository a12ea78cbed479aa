"""The tide of a perturber: its orbit, its far field, and the force on the origin."""

import math
from types import SimpleNamespace

import numpy as np

from astroinertia.effects import catalogue
from tests.ball import ball
from tests.unit.points import at


def test_the_perturber_follows_keplers_laws() -> None:
    """Pericentre and apocentre, equal areas, and the force that an ellipse with that period and size belongs to."""
    e, period, pericentre = 0.6, 7.0, 2.0
    tide = catalogue.build(
        "tide",
        {
            "mass": 1.0,
            "position": (0.0, pericentre, 0.0),
            "period": period,
            "eccentricity": e,
            "normal": (3.0, 0.0, 0.0),
            "mean_anomaly": 0.4,
        },
    )

    def place(time: float) -> np.ndarray:
        return tide.place(np, SimpleNamespace(time=time))

    epoch, dt = -0.4 * period / (2 * math.pi), 0.01
    assert np.allclose(place(epoch), (0.0, pericentre, 0.0), atol=1e-14)
    axis = pericentre / (1 - e)
    assert np.allclose(place(epoch + period / 2), (0.0, -axis * (1 + e), 0.0), atol=1e-13)
    assert place(epoch + 0.1)[2] > 0  # pericentre, velocity and normal are right-handed: y, z, x
    gm = (2 * math.pi / period) ** 2 * axis**3
    for time in np.linspace(0.0, period, 9):
        far_back, back, here, on, far_on = (place(time + k * dt) for k in (-2, -1, 0, 1, 2))
        speed = (8.0 * (on - back) - (far_on - far_back)) / (12.0 * dt)
        change = (16.0 * (on + back) - (far_on + far_back) - 30.0 * here) / (12.0 * dt**2)
        assert np.allclose(np.cross(here, speed), [math.sqrt(gm * axis * (1 - e * e)), 0.0, 0.0], atol=1e-6)
        assert np.allclose(change, -gm * here / np.linalg.norm(here) ** 3, atol=1e-6)


def test_the_tide_far_away_is_the_textbook_one() -> None:
    """GM/D^3 (2 x, -y, -z) to first order, free of cancellation at any distance; the rest falls as 1/D."""
    position = ball(60)
    for distance in (1e2, 1e5, 1e8):
        tide = catalogue.build("tide", {"mass": distance**3, "position": (distance, 0.0, 0.0)})
        found = tide.acceleration(np, at(position))
        error = np.abs(found - position * (2.0, -1.0, -1.0)).max()
        assert error < 5.0 / distance
        energy = tide.potential_energy(np, at(position))
        textbook = -0.5 * np.mean((position**2) @ np.array([2.0, -1.0, -1.0]))
        assert abs(energy - textbook) < 5.0 / distance + 1e-15 * distance


def test_the_tidal_force_is_the_direct_one_less_that_on_the_origin() -> None:
    options = {"mass": 2.0, "position": (1.5, 0.3, -0.2), "softening": 0.2}
    position = ball(60)
    tidal = catalogue.build("tide", options).acceleration(np, at(position))
    direct = catalogue.build("tide", {**options, "frame": "direct"})
    separation = position - np.array(options["position"])
    wanted = -2.0 * separation / ((separation**2).sum(axis=1) + 0.04)[:, None] ** 1.5
    assert np.allclose(direct.acceleration(np, at(position)), wanted, rtol=1e-14)
    assert np.allclose(tidal, wanted - direct.acceleration(np, at(np.zeros((1, 3)))), rtol=1e-13, atol=1e-14)


def test_the_velocity_of_the_perturber_is_the_rate_of_its_place() -> None:
    """On an ellipse, a parabola and a hyperbola, by the difference quotient of sixth order; at rest it is none."""
    position, normal, dt = (0.3, 2.0, -0.1), (2.0, 0.0, 6.0), 1e-2
    orbits = (
        {"period": 7.0, "eccentricity": 0.6, "mean_anomaly": 0.4},
        {"pericentre_time": 0.5, "eccentricity": 1.0},
        {"pericentre_time": 0.5, "eccentricity": 3.0},
    )
    for orbit in orbits:
        tide = catalogue.build("tide", {"mass": 1.7, "position": position, "normal": normal, **orbit})
        for time in (-3.0, 0.5, 1.9):
            places = [tide.place(np, SimpleNamespace(time=time + k * dt)) for k in range(-3, 4)]
            weights = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / (60.0 * dt)
            assert np.allclose(tide.velocity(np, SimpleNamespace(time=time)), weights @ places, rtol=0, atol=1e-9)
    still = catalogue.build("tide", {"mass": 1.7, "position": position})
    assert not still.velocity(np, SimpleNamespace(time=1.0)).any()
