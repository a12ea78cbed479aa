"""A falling core of tabulated matter that loses electrons: its pressure is the table's, of each particle's own."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from astroinertia.build.assemble import prepare
from astroinertia.build.effects import effects_of
from astroinertia.errors import SceneError
from astroinertia.models.sph.record import energy_budget
from astroinertia.scene import load
from astroinertia.scene.further_pressure import further_pressure
from astroinertia.scene.scales import code_units
from tests import synthetic_table as exact

FRACTION = 0.47
CORE = (
    exact.STAR.replace('"1800 km"', '"600 km"').replace("particles = 64", "particles = 80")
    .replace("electron_fraction = 0.42", "electron_fraction = 0.47").replace('"1 ms"', '"10 ms"')
    + "[effects.viscosity]\n[effects.deleptonisation]\nelectron_fraction = 0.47\n"
)  # fmt: skip
STEPS = 60


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    return CORE.replace("FILE", str(exact.write(tmp_path_factory.mktemp("table") / "exact.h5")))


@pytest.fixture(scope="module")
def fallen(text):
    """The core after some steps, its units, and how dense it was."""
    scene = load.loads(text)
    made: Any = prepare(scene).evolution
    before = float(np.max(made.state.rates.fluid.density))
    for _ in range(STEPS):
        made.advance(float("inf"))
    return made, code_units(scene), before


@pytest.mark.full
def test_the_pressure_is_that_of_the_table_at_each_particles_electron_fraction(fallen):
    """Equation of state and effect against the exact matter of the same warmth and of that fraction: to 1e-4."""
    made, units, before = fallen
    fluid = made.state.rates.fluid
    assert np.max(fluid.density) > 1.5 * before
    density = units.to_si(np.asarray(fluid.density), "density")
    fraction = np.asarray(fluid.memory["electron_fraction"])
    assert fraction.min() < 0.42 and np.ptp(fraction) > 0.03
    pressure = units.to_si(np.asarray(fluid.pressure + fluid.memory["further_pressure"]), "pressure")
    energy = units.to_si(np.asarray(fluid.internal_energy), "specific_energy")
    assert density.max() < 2e15  # nothing is trapped
    compared = 0
    for rho, y, u, p in zip(density, fraction, energy, pressure, strict=True):
        if u < exact.energy(rho, 0.05, FRACTION):
            continue  # as cold as the table, whose least temperature it keeps
        there = brentq(lambda t, rho=rho, u=u: exact.energy(rho, t, FRACTION) - u, 0.01, 100.0)
        assert p == pytest.approx(exact.pressure(rho, there, y), rel=1e-4)
        compared += 1
    assert compared > 40


@pytest.mark.slow
def test_its_energy_is_accounted_for_to_second_order(text):
    """With what neutrinos carry off, over 20 ms: 4e-4 of what electrons took, and a quarter with half the steps."""
    errors, half = [], ["numerics.courant=0.15", "numerics.free_fall_factor=0.05"]
    for settings in ([], half):
        scene = load.loads(text, settings)
        made: Any = prepare(scene).evolution
        end = float(code_units(scene).to_code(0.02, "time"))
        first = energy_budget(made.problem, made.state)
        while made.time < end:
            made.advance(end)
        last = energy_budget(made.problem, made.state)
        taken = last["potential"]["deleptonisation"] - first["potential"]["deleptonisation"]
        assert taken < -0.01
        errors.append(abs((last["total"] - first["total"]) / taken))
    assert errors[0] < 1e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)


def test_plans_know_the_same_pressure(text):
    scene = load.loads(text)
    units = code_units(scene)
    adds = further_pressure(scene)
    assert adds is not None
    density = np.array([1e14, 1e15])  # kg/m^3
    made = next(each for each in effects_of(scene, units) if each.kind == "deleptonisation")
    dense = units.to_code(density, "density")
    assert made.axis is not None
    np.testing.assert_array_equal(adds(dense), made.further_pressure(np, dense))
    fraction = made.initial_memory(np, type("Fluid", (), {"density": dense}))["electron_fraction"]
    wanted = exact.pressure(density, 1.0, fraction) - exact.pressure(density, 1.0, FRACTION)
    np.testing.assert_allclose(units.to_si(adds(dense), "pressure"), wanted, rtol=1e-4)


def test_without_electrons_that_leave_no_axis_is_read(text, monkeypatch):
    monkeypatch.setattr("astroinertia.scene.electron_axis._axis", None)
    scene = load.loads(text.replace("[effects.deleptonisation]\nelectron_fraction = 0.47\n", ""))
    assert further_pressure(scene) is None
    effects_of(scene, code_units(scene))


def test_one_table_alone_has_the_electrons(text):
    table = text[text.index("[[equation") : text.index("[effects.gravity]")]
    several = text.replace("[effects.gravity]", table.replace('"iron"', '"other"') + "[effects.gravity]")
    scene = load.loads(several)
    with pytest.raises(SceneError, match=r"deleptonisation\] follows the electrons of one material, not of 2"):
        effects_of(scene, code_units(scene))
