"""The heat that neutrinos carry off, against the solutions of its two laws, and the numbers of the published rate."""

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from astroinertia.effects import catalogue
from astroinertia.models.sph.step import step
from tests.ball import ball, state_of

POSITION = ball(60)


def energy_of(state: Any) -> np.ndarray:
    return 1.5 * state.entropy * state.rates.fluid.density ** (2 / 3)


def cooled(options: dict[str, Any], steps: int, end: float = 1.0) -> tuple[Any, Any]:
    effect = catalogue.build("neutrino_loss", options)
    problem, first, arrangement = state_of(effect, position=POSITION, velocity=0.0 * POSITION)
    state = first
    for _ in range(steps):
        state = step(problem, arrangement, state, np.float64(end / steps))
    return first, state


@pytest.mark.slow
def test_captures_converge_to_their_solution_and_the_loss_is_in_the_ledger() -> None:
    """u^-5 grows linearly, to second order in the step."""
    options = {"rate": 0.4, "thermal_energy": 0.3, "trapping_density": 0.2}
    errors = []
    for steps in (20, 40, 80):
        first, last = cooled(options, steps)
        start = energy_of(first) / 0.3
        rate = 0.4 / 0.3 * np.exp(-first.rates.fluid.density / 0.2)
        exact = (start**-5 + 5.0 * rate) ** -0.2
        errors.append(np.abs(energy_of(last) / 0.3 / exact - 1.0).max())
        taken = first.mass @ (energy_of(first) - energy_of(last))
        assert float(last.ledger.heating.total[0]) == pytest.approx(-taken, rel=1e-13)
    assert (exact / start).min() < 0.9
    assert all(3.4 < a / b < 4.6 for a, b in itertools.pairwise(errors)), errors


def test_heat_leaks_out_above_a_density_alone() -> None:
    density = float(
        np.median(cooled({"law": "diffusion", "time_scale": 1.0, "density": 1.0}, 1)[0].rates.fluid.density)
    )
    first, last = cooled({"law": "diffusion", "time_scale": 0.4, "density": density}, 1)
    inside = first.rates.fluid.density > density
    assert 0.3 < inside.mean() < 0.7
    expected = np.where(inside, np.exp(-2.5), 1.0)
    assert np.allclose(last.entropy / first.entropy, expected, rtol=1e-13)


def test_the_rate_at_two_million_electron_volts_is_the_published_one() -> None:
    """1.399e20 erg/g/s at 2 MeV where nothing is trapped, 64 times that at 4 MeV, 1/e of it at the trapping density."""
    energy = 1.5 * 2.0 * 1.602176634e-13 / 1.66053907e-27
    options = {"rate": 1.399e16, "thermal_energy": energy, "trapping_density": 1e14}
    fluid = SimpleNamespace(density=np.array([0.0, 0.0, 1e14]), thermal_energy=energy * np.array([1.0, 2.0, 1.0]))
    gain, decay = catalogue.build("neutrino_loss", options).exchange(np, fluid)
    assert energy == pytest.approx(2.9e14, rel=5e-3)
    assert np.allclose(decay * fluid.thermal_energy, 1.399e16 * np.array([1.0, 64.0, np.exp(-1.0)]), rtol=1e-13)
    assert not gain.any()


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"rate": 1.0}, "needs rate, thermal_energy, trapping_density"),
        ({"law": "diffusion", "density": 1.0}, "needs time_scale, density"),
        ({"law": "diffusion", "density": 1.0, "time_scale": 1.0, "rate": 2.0}, "has no rate"),
    ],
)
def test_options_of_the_other_law_are_refused(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        catalogue.build("neutrino_loss", options)
