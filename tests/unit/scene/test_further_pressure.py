"""What effects add to the pressure: captured electrons as their fit says, an effect of one's own as it does."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from astroinertia.costs import course, shells
from astroinertia.effects.effect import Effect
from astroinertia.engines.pytree import pytree
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.further_pressure import further_pressure
from astroinertia.scene.load import load_file, loads, with_effects
from astroinertia.scene.scales import code_units

CORE = Path(__file__).parents[3] / "sims" / "deleptonising_core.toml"
STAR = """
name = "star"
body = {kind = "polytrope", index = 1.5, particles = 300, mass = "1 Msun", radius = "1 Rsun"}
equation_of_state = {kind = "polytropic", gamma = "5/3"}
effects.gravity = {}
effects.pressure = {}
time.end = "1 h"
"""


def test_captured_electrons_lack_in_the_pressure_as_the_fit_says():
    """P = 4.897e14 (2 Y/0.9942 rho)^(4/3) in cgs, Liebendoerfer 2005 with his numbers of G15, below trapping."""
    scene = load_file(CORE)
    units, adds = code_units(scene), further_pressure(scene)
    assert adds is not None
    density = np.array([1e8, 1e9, 1e10, 1e11, 1e12])  # g/cm3
    x = np.clip((2 * np.log10(density) - np.log10(2e13 * 3e7)) / np.log10(2e13 / 3e7), -1, 1)
    size = abs(x)
    left = 0.5 * (0.278 + 0.5) + x / 2 * (0.278 - 0.5) + 0.035 * (1 - size + 4 * size * (size - 0.5) * (size - 1))
    full = 4.897e13 * density ** (4 / 3)  # Pa
    expected = full * ((np.minimum(left, 0.4971) / 0.4971) ** (4 / 3) - 1)
    dense = units.to_code(1e3 * density, "density")
    found = units.to_si(adds(dense), "pressure")
    assert found / full == pytest.approx(expected / full, abs=2e-4)
    assert found[-1] / full[-1] < -0.2  # a fifth and more is gone by then


def test_a_core_that_they_leave_is_predicted_to_fall_to_nuclear_density():
    without = [line for line in CORE.read_text().splitlines() if line != "[effects.deleptonisation]"]
    assert course.at_start(loads("\n".join(without))).zone.imbalance < course.IN_BALANCE
    scene = load_file(CORE)
    start, units = course.at_start(scene), code_units(scene)
    assert start.zone.imbalance > course.IN_BALANCE
    moments = shells.followed(start, float(units.to_code(0.1, "time")))
    densest = max(float(moment.density.max()) for moment in moments)
    assert 2e17 < units.to_si(densest, "density") < 6e17  # kg/m3: matter is stiff from 2e17 on


def test_a_core_that_they_leave_is_predicted_to_take_the_steps_of_its_bounce():
    """1084, as its run took with a bounce at 95.6 ms of 100; 46 of a core that rests."""
    done = course.counted(load_file(CORE))
    assert done is not None and 1084 / 1.5 < done.steps < 1.5 * 1084


def test_no_effect_of_a_plain_star_adds_any():
    assert further_pressure(loads(STAR)) is None


@pytree
@dataclass(frozen=True, eq=False)
class Stiffer(Effect):
    """Matter that presses more, by half of its density."""

    kind: ClassVar[str] = "stiffer"

    def further_pressure(self, xp, density):
        return 0.5 * density


def test_an_effect_of_ones_own_is_asked_too():
    scene = with_effects(loads(STAR), [Stiffer()])
    adds = further_pressure(scene)
    assert adds is not None
    assert np.array_equal(adds(np.array([1.0, 4.0])), [0.5, 2.0])
    assert characteristic(scene).further_pressure == pytest.approx(
        1.5 * code_units(scene).to_si(1.0, "mass") * code_units(scene).to_si(1.0, "specific_energy")
    )
