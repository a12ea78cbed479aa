"""What a scene says of its materials, and what their equations have of it."""

from pathlib import Path

import numpy as np
import pytest

from astroinertia.build.materials import equation
from astroinertia.scene.fluid_kinds.materials import Material

GAMMA, RHO, HEAT = 1.4, np.geomspace(500.0, 8000.0, 9), np.array([0.0, 1e5, 1e6, 1e7])
COLD = 2e6  # J/kg, of the coldest matter at any density


def material(**options) -> Material:
    return Material.model_validate(options)


def rock(folder: Path, **options) -> Material:
    rows = [f"{rho},{COLD + heat},{(GAMMA - 1) * rho * heat}\n" for rho in RHO for heat in HEAT]
    (folder / "t.csv").write_text("density,internal_energy,pressure\n" + "".join(rows))
    return material(name="rock", file="t.csv", reference_density="2000 kg/m3", **options)


def test_isentropes_of_a_file_reach_from_its_coldest_matter_to_its_hottest_or_to_what_the_scene_says(tmp_path) -> None:
    """By the energy above the coldest at the reference density."""
    made = equation(rock(tmp_path), str(tmp_path))
    assert (made.coldest, made.greatest_energy) == (pytest.approx(COLD), pytest.approx(1e7))
    assert made.reference_density == 2000.0
    assert made.densities == (pytest.approx(500.0), pytest.approx(8000.0))
    hot = equation(rock(tmp_path, hottest="3e6 J/kg"), str(tmp_path))
    assert (hot.coldest, hot.greatest_energy) == (pytest.approx(COLD), pytest.approx(3e6))


def test_matter_of_a_file_can_be_pulled_down_to_half_its_reference_density(tmp_path) -> None:
    assert equation(rock(tmp_path, tension=True), str(tmp_path)).densities[0] == pytest.approx(1000.0)


@pytest.mark.parametrize("substance", ["iron", "granite", "basalt", "ice"])
def test_cold_matter_of_tillotson_pulls_only_where_the_scene_says_so(substance: str) -> None:
    """A tenth less dense than at rest: the pressure is below zero, or there is none."""
    loose, tough = (equation(material(name="it", tillotson=substance, tension=pulls), None) for pulls in (False, True))
    rho = 0.9 * loose.reference_density
    assert loose.pressure(rho, np.zeros(1)) == pytest.approx(0.0, abs=1.0)
    assert tough.pressure(rho, np.zeros(1)) < -1e8
    assert tough.densities[0] == pytest.approx(0.5 * tough.reference_density)
    assert loose.densities[0] < 1e-4 * loose.reference_density
    hot = equation(material(name="it", tillotson=substance, hottest="2e8 J/kg"), None)
    assert (loose.greatest_energy, hot.greatest_energy) == (1e9, 2e8)
