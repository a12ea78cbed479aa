"""Rotating stars from self-consistent fields, as particles: they stay what they were."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from astroinertia.bodies.rotating_star import RotatingStar, rotating_star
from astroinertia.bodies.rotation_laws import RotationLaw
from astroinertia.matter.barotropes import polytropic_matter
from tests.evolve import evolve, prepared

SCENE = (Path(__file__).parents[2] / "sims" / "rotating_star.toml").read_text()
FREE_FALLS = 10
# index, axis ratio and law of each star; the scale of a law is in equatorial radii, which are 15440 km in the scene
STARS = {
    "rigid": (1.5, 0.75, RotationLaw()),
    "j_constant": (1.0, 0.6, RotationLaw("j_constant", 1.0)),
}


def settings(index: float, axis_ratio: float, law: RotationLaw, particles: int) -> list[str]:
    chosen = [f"body.index={index}", f"body.axis_ratio={axis_ratio}", f"body.particles={particles}",
              f"equation_of_state.gamma={1 + 1 / index}", f'body.law="{law.kind}"']  # fmt: skip
    return chosen if law.scale is None else [*chosen, f'body.scale="{15440 * law.scale} km"']


def figures(record: dict[str, Any]) -> np.ndarray:
    """I_zz, T/|W|, and the axis ratio: the root of the least principal second moment over the mean of the others."""
    least, *others = np.linalg.eigvalsh(record["second_moment"])
    share = record["kinetic_energy"] / -record["gravitational_energy"]
    return np.array([record["inertia_tensor"][2, 2], share, math.sqrt(least / np.mean(others))])


def exact(star: RotatingStar) -> np.ndarray:
    """The same of the star itself, in units of its mass and equatorial radius."""
    across, along = star.polar_moment / 2, star.equatorial_moment - star.polar_moment / 2
    return np.array([star.polar_moment, star.rotational_to_gravitational, math.sqrt(along / across)])


def history(name: str, particles: int) -> tuple[np.ndarray, np.ndarray]:
    """Figures (21, 3) over ten central free-fall times, and those of the exact star (3,)."""
    index, axis_ratio, law = STARS[name]
    star = rotating_star(polytropic_matter(index), axis_ratio, law)
    fall = math.sqrt(3 * math.pi / (32 * star.max_density))
    start = prepared(SCENE, *settings(index, axis_ratio, law, particles))
    records = evolve(start, list(np.linspace(0.0, FREE_FALLS * fall, 21)))
    return np.array([figures(record) for record in records]), exact(star)


@pytest.mark.full
def test_a_rotating_star_stays_as_it_is() -> None:
    """3000 particles: settled within 0.5 %, 1.2 % and 0.9 % of the exact star; they drift by less than 0.1 %."""
    found, star = history("rigid", 3000)
    assert np.abs(found / found[0] - 1).max() < 0.002
    assert (np.abs(found / star - 1).max(axis=0) < [0.008, 0.018, 0.014]).all()


@pytest.mark.full(inputs=["sims/rotating_star.toml"])
@pytest.mark.parametrize("name", STARS)
def test_a_rotating_star_stays_as_it_is_at_full_size(name: str, result) -> None:
    """30,000 particles: I_zz, T/|W| and axis ratio within 1 % of the exact star, and of the start, all the time."""
    found, star = history(name, 30000)
    names = ("I_zz", "t_over_w", "axis_ratio")
    worst, drift = np.abs(found / star - 1).max(axis=0), np.abs(found / found[0] - 1).max(axis=0)
    for number, quantity in enumerate(names):
        result(**{f"{quantity}_exact": star[number], f"{quantity}_start": found[0, number],
                  f"{quantity}_error": worst[number], f"{quantity}_drift": drift[number]})  # fmt: skip
    assert worst.max() < 0.01
    assert drift.max() < 0.01
