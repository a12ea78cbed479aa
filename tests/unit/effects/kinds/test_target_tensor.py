"""The force towards a prescribed second moment turns with the scene."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from astroinertia.effects.kinds.target_tensor import ENTRY, TargetTensor

TURN = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
SPACE = {"first_axis": (1.0, 0.5, -0.3), "second_axis": (0.2, 1.0, 0.4), "orientation_stiffness": 0.5}
PLANE = {"normal": (0.3, -0.5, 2.0)}
DIRECTIONS = ("first_axis", "second_axis", "normal")


def accelerations(options: dict[str, Any], turn: np.ndarray) -> np.ndarray:
    """Of a body of a few particles, with it and all directions of the options turned."""
    random = np.random.default_rng(7)
    mass, place = random.uniform(0.5, 1.5, 20), random.normal(size=(20, 3)) * (1.0, 0.6, 1.7)
    turned = {name: tuple(turn @ value) if name in DIRECTIONS else value for name, value in options.items()}
    effect = TargetTensor.from_options(dict.fromkeys(ENTRY.options) | {"stiffness": 2.0} | turned)
    centre = mass @ place / mass.sum()
    fluid = SimpleNamespace(
        mass=mass, position=place @ turn.T, centre=turn @ centre, velocity=0.0 * place, centre_velocity=0.0
    )
    return effect.acceleration(np, fluid)


@pytest.mark.parametrize("target", [{"axis_ratios": (3.0, 1.5, 1.0)}, {"moments": (5.0, 7.0, 8.0)}])
@pytest.mark.parametrize("directions", [{}, SPACE, PLANE, SPACE | PLANE])
def test_the_force_turns_with_the_scene(target: dict[str, Any], directions: dict[str, Any]) -> None:
    options = target | directions
    as_it_is = accelerations(options, np.eye(3))
    assert np.abs(as_it_is).max() > 0.1
    np.testing.assert_allclose(accelerations(options, TURN), as_it_is @ TURN.T, atol=1e-13 * np.abs(as_it_is).max())


def test_without_given_axes_the_normal_is_the_third() -> None:
    """And so the third of the ratios is of no account, and the others are the first two in any plane."""
    ratios = {"axis_ratios": (3.0, 1.5, 1.0)}
    in_z = {"normal": (0.0, 0.0, 1.0), "first_axis": (1.0, 0.0, 0.0), "second_axis": (0.0, 1.0, 0.0)}
    free = accelerations(ratios | {"normal": (0.0, 0.0, 1.0)}, np.eye(3))
    given = accelerations(ratios | in_z | {"orientation_stiffness": 0.0}, np.eye(3))
    np.testing.assert_allclose(free, given, atol=1e-13)
    flat = accelerations({"axis_ratios": (3.0, 1.5, 0.1), "normal": (0.0, 0.0, 1.0)}, np.eye(3))
    np.testing.assert_allclose(free, flat, atol=1e-13)
