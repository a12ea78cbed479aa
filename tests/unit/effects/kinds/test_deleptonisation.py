"""Electrons lost to neutrinos: the fits, what the matter is worth, and where the energy goes that captures free.

The neutrinos' pressure has the constant 4 pi/3 MeV^4/(hc)^3, 3.52127727e24 erg/cm^3 in GR1D (O'Connor & Ott 2010); the
Fermi energy of relativistic electrons is hc (3 n/(8 pi))^(1/3), hc = 1239.84198 MeV fm (Shapiro & Teukolsky 1983).
"""

import itertools
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from astroinertia.build import sph
from astroinertia.build.effects import effects_of
from astroinertia.effects import catalogue
from astroinertia.effects.kinds import deleptonisation as leptons
from astroinertia.errors import SceneError
from astroinertia.matter.electron_axis import electron_axis
from astroinertia.models.sph.record import energy_budget, snapshot_record
from astroinertia.models.sph.step import step
from astroinertia.scene.load import loads
from astroinertia.scene.plan import code_units, plan
from astroinertia.studies.core_collapse import core_scene
from astroinertia.units import DIMENSIONLESS, GRAVITATIONAL_CONSTANT
from tests import synthetic_table as exact
from tests.ball import ball, state_of

MASS, LENGTH = 2e30, 1e6
DENSITY, SPECIFIC = MASS / LENGTH**3, GRAVITATIONAL_CONSTANT * MASS / LENGTH
MEV = leptons.MEV / leptons.ATOMIC_MASS / SPECIFIC  # of a baryon, in code units of energy per mass


def effect(**options: Any) -> Any:
    return catalogue.build("deleptonisation", {"mass_unit": MASS, "length_unit": LENGTH, **options})


@pytest.fixture(scope="module")
def of_table(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The effect in matter of a table that is exact."""
    path = exact.write(tmp_path_factory.mktemp("table") / "exact.h5")
    made = effect(electron_fraction=0.47)
    units = code_units(loads(core_scene("G15", 100)))  # of any scene: masses of MASS, lengths of LENGTH below
    units = replace(units, mass=MASS, length=LENGTH)
    return made.on_axis(electron_axis(path, 1e13, made.electron_fractions), units)


def cgs(density: Any) -> Any:
    """In code units, of g/cm^3."""
    return 1e3 * np.asarray(density) / DENSITY


def fluid(density: Any, made: Any = None, **memory: Any) -> Any:
    here = SimpleNamespace(density=np.atleast_1d(density), grad_h=np.ones(np.size(density)), contrast=None)
    here.mass = here.smoothing_length = np.ones(len(here.density))
    here.sound_speed = 0.3 * here.mass  # steps of 1 are then a sound crossing's Courant steps
    here.memory = memory or (made or effect()).initial_memory(np, here)
    return here


@pytest.mark.parametrize(("fit", "first", "dense"), [("G15", 3e7, 0.278), ("N13", 2e7, 0.285)])
def test_the_fits_go_through_their_points(fit: str, first: float, dense: float) -> None:
    """Both ends; the middle, which is Y_c above the mean; halfway to it, where the cubic is Y_c/2 above the line."""
    span = np.log10(2e13 / first)
    at = cgs(first * 10 ** (span * np.array([-0.2, 0.0, 0.25, 0.5, 0.75, 1.0, 1.2])))
    fall = 0.5 - dense
    expected = [
        0.5,
        0.5,
        0.5 - 0.25 * fall + 0.0175,
        0.5 - 0.5 * fall + 0.035,
        0.5 - 0.75 * fall + 0.0175,
        dense,
        dense,
    ]
    assert leptons.fitted(np, at, *effect(fit=fit).law(np)) == pytest.approx(expected, abs=1e-12)
    fine = leptons.fitted(np, cgs(np.geomspace(1e7, 1e14, 2000)), *effect(fit=fit).law(np))
    assert np.diff(fine).max() <= 1e-15


def test_units_do_not_matter() -> None:
    for density in (1e10, 3e12, 1e14):
        found = []
        for mass, length in ((MASS, LENGTH), (5e28, 3e7)):
            made = catalogue.build("deleptonisation", {"mass_unit": mass, "length_unit": length})
            unit, energy = mass / length**3, GRAVITATIONAL_CONSTANT * mass / length
            here = SimpleNamespace(
                density=np.array([1e3 * density / unit]), grad_h=np.ones(1), contrast=None, gradients={}
            )
            here.memory = made.initial_memory(np, here)
            slope = made.fields(np, here)["lepton_slope"][0] * energy / unit
            found.append((here.memory["electron_fraction"][0], slope, made.escape * energy))
        assert found[0] == pytest.approx(found[1], rel=1e-12)


def test_electrons_and_neutrinos_are_those_of_the_textbooks() -> None:
    made = effect()
    electrons, _ = made.electrons
    for density, fraction in ((1e10, 0.44), (1e14, 0.278)):
        potential = 4 * electrons * (cgs(density) * fraction) ** (1 / 3) / MEV
        number = 1e6 * density / 1.66053907e-24 * fraction  # of electrons in a cubic metre
        assert potential == pytest.approx(1239.84198e-15 * (3 * number / (8 * math.pi)) ** (1 / 3), rel=1e-6)
    # K rho^(4/3) of the initial composition is 4.897e14 in cgs
    pressure = electrons * (cgs(1.0) * 0.4971) ** (4 / 3) * DENSITY * SPECIFIC
    assert 10 * pressure == pytest.approx(4.897e14, rel=1e-4)
    neutrinos = made.trapped(np)[0]
    assert 10 * neutrinos * (30 * MEV) ** 4 * DENSITY * SPECIFIC == pytest.approx(3.52127727e24 * 30**4 / 4, rel=1e-6)


def test_thin_cold_matter_is_iron() -> None:
    """Without electrons nuclei of the best size, A = 12.5/Y^2, are stable at 0.452 and 61: iron has 0.464 and 56."""
    energy = minimize_scalar(lambda y: leptons.energy(np, 0.0, y, 0.0, 1.0), bounds=(0.3, 0.6), method="bounded")
    assert energy.x == pytest.approx(26 / 56, abs=0.013)
    assert leptons.B2 / (2 * leptons.B5 * energy.x**2) == pytest.approx(56, abs=6)


@pytest.mark.slow
def test_pressure_and_chemical_potential_are_slopes_of_the_energy() -> None:
    """rho^2 du/drho and du/dY, by differentiation, with nothing trapped."""
    made = effect(trapping_density=1e30)
    with jax.enable_x64(True):
        for density, fraction in ((cgs(1e10), 0.43), (cgs(1e14), 0.28)):
            by_density, by_fraction = jax.grad(lambda r, y: leptons.energy(jnp, r, y, *made.electrons), argnums=(0, 1))(
                jnp.asarray(density), jnp.asarray(fraction)
            )
            initial = jax.grad(lambda r: leptons.energy(jnp, r, 0.4971, *made.electrons))(jnp.asarray(density))
            here = made.further(np, np.array([density]), np.array([fraction]), made.trapped(np))["further_pressure"][0]
            assert here == pytest.approx(float(density**2 * (by_density - initial)), rel=1e-12)
            assert leptons.chemical_potential(np, density, fraction, *made.electrons) == pytest.approx(
                float(by_fraction), rel=1e-12
            )


def test_only_what_becomes_denser_loses_electrons() -> None:
    made, memory = effect(), None
    fractions = []
    for density in (1e10, 1e12, 1e11, 1e12, 3e12):
        here = fluid(cgs(density), **(memory or {}))
        memory = made.remember(np, here, 0.1)
        fractions.append(memory["electron_fraction"][0])
    assert fractions[1] == fractions[2] == fractions[3]
    assert fractions[0] > fractions[1] > fractions[4]
    assert fractions[4] == leptons.fitted(np, cgs(3e12), *made.law(np))


def compressed(first: float, last: float, steps: int, made: Any = None) -> SimpleNamespace:
    """One particle that becomes denser from g/cm^3 to g/cm^3, with uneven steps, as a run takes it along.

    work: of its pressure, by Simpson's rule between evaluations; heat: what kicks have given it.
    """
    made = made or effect()
    turns = (np.arange(steps + 1) + 0.3 * np.sin(np.arange(steps + 1))) / steps
    turns[0], turns[-1] = 0.0, 1.0
    path = lambda s: cgs(first * (last / first) ** s)  # noqa: E731
    here = fluid(path(0.0), made)
    here.memory = made.remember(np, here, 0.0)
    start, work, heat = float(made.potential_energy(np, here)), 0.0, 0.0

    for before, after in itertools.pairwise(turns):
        heat += 0.5 * (after - before) * made.exchange(np, here)[0][0]
        here = fluid(path(after), **here.memory)
        here.memory = made.remember(np, here, after - before)
        heat += 0.5 * (after - before) * made.exchange(np, here)[0][0]
    edges = cgs(np.geomspace(first, last, 4001))
    values = made.further_pressure(np, edges) / edges
    work = float(np.trapezoid(values, np.log(edges)))
    memory = here.memory
    return SimpleNamespace(
        gained=float(made.potential_energy(np, here)) - start, work=work, heat=heat,
        owed=memory["capture_heat"][0], neutrinos=memory["neutrino_energy"][0],
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("first", "last"), [(1e10, 1.9e12), (2.1e12, 2e14), (1e10, 2e14)])
def test_all_energy_is_accounted_for_to_second_order(first: float, last: float) -> None:
    """What is gained, neutrinos and debts included, is the work of the pressure less the heat that was given."""
    errors = []
    for steps in (50, 400):
        found = compressed(first, last, steps)
        errors.append(abs(found.gained + found.heat - found.work) / abs(found.work))
    assert errors[-1] < 1e-4
    assert math.log(errors[0] / errors[1]) / math.log(8.0) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize(("first", "last"), [(1e10, 1.9e12), (1e10, 2e14)])
def test_a_table_keeps_the_same_account(of_table: Any, first: float, last: float) -> None:
    errors = []
    for steps in (50, 400):
        found = compressed(first, last, steps, of_table)
        errors.append(abs(found.gained + found.heat - found.work) / abs(found.work))
    assert errors[-1] < 2e-4
    assert math.log(errors[0] / errors[1]) / math.log(8.0) == pytest.approx(2.0, abs=0.15)


@pytest.mark.full
def test_a_table_has_its_own_pressure_and_potential(of_table: Any) -> None:
    """Of electrons of any speed and no nuclei: P lost to 1e-5, and neutrinos in balance with the Fermi energy alone."""
    density = np.array([1e8, 1e10, 1e12, 1e14])  # g/cm^3
    fraction = np.array([0.45, 0.43, 0.34, 0.28])
    _, pressure, potential = of_table.worth(np, cgs(density), fraction)
    lost = pressure - of_table.worth(np, cgs(density), 0.47)[1]
    wanted = exact.pressure(1e3 * density, 1.0, fraction) - exact.pressure(1e3 * density, 1.0, 0.47)
    np.testing.assert_allclose(lost * DENSITY * SPECIFIC, wanted, rtol=1e-5)
    x = exact._momentum(1e3 * density, fraction)
    np.testing.assert_allclose(potential / MEV, 0.51099895 * (np.sqrt(1 + x**2) - 1), rtol=1e-4)
    found = of_table.further(np, cgs(density), fraction, of_table.trapped(np))["further_pressure"]
    np.testing.assert_allclose(found[:3], lost[:3], rtol=1e-12)  # below trapping density
    with jax.enable_x64(True):
        there = jnp.asarray(cgs(density)), jnp.asarray(fraction)
        traced = of_table.further(jnp, *there, of_table.trapped(jnp))["further_pressure"]
    np.testing.assert_allclose(traced, found, rtol=1e-12)
    free = leptons.fitted(np, cgs(2e12), *of_table.law(np))
    momenta = exact._momentum(1e17, 0.28), exact._momentum(2e15, free)
    levels = [0.51099895 * (math.sqrt(1 + x**2) - 1) for x in momenta]
    push = 3.52127727e23 / 4 * (levels[0] ** 4 - levels[1] ** 4)  # Pa
    assert (found[3] - lost[3]) * DENSITY * SPECIFIC == pytest.approx(push, rel=1e-3)


def test_neutrinos_carry_off_ten_million_electron_volts_each_and_the_rest_is_heat() -> None:
    made = effect()
    found = compressed(1e10, 1.9e12, 800)
    low, high = (float(leptons.fitted(np, cgs(rho), *made.law(np))) for rho in (1.9e12, 1e10))
    x = np.linspace(math.log(1e10), math.log(1.9e12), 20001)
    fraction = leptons.fitted(np, cgs(np.exp(x)), *made.law(np))
    potential = leptons.chemical_potential(np, cgs(np.exp(x)), fraction, *made.electrons)
    heat = -np.trapezoid(np.maximum(potential - 10 * MEV, 0.0), fraction)
    carried = -np.trapezoid(np.minimum(potential, 10 * MEV), fraction)
    assert found.neutrinos == pytest.approx(carried, rel=2e-3)
    assert found.heat + found.owed == pytest.approx(heat, rel=2e-3)
    assert 6 * MEV < carried / (high - low) < 10 * MEV


def test_the_heat_is_given_in_time_and_never_taken() -> None:
    """Steps that become ten times longer give more than is owed: the next ones wait."""
    made, here = effect(), fluid(cgs(5e11))
    here.memory = made.remember(np, here, 0.0)
    given, density = 0.0, 5e11
    for length in (1.0, 1.0, 1.0, 10.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0):
        density *= 1.0 + 0.01 * length
        rate = here.memory["capture_rate"][0]
        here = fluid(cgs(density), **here.memory)
        here.memory = made.remember(np, here, length)
        after = here.memory["capture_rate"][0]
        assert after >= 0.0
        given += 0.5 * length * (rate + after)
    freed = given + here.memory["capture_heat"][0]
    assert abs(here.memory["capture_heat"][0]) < 0.1 * freed


@pytest.mark.parametrize("share", [1e-2, 1e-4, 1e-6])
def test_a_short_step_as_between_outputs_at_nearly_the_same_time_gives_no_heat_ahead_of_time(share: float) -> None:
    """What was owed was given at the rate of the short step, over the long one after it: 1/share times as much."""
    made = effect()
    here = fluid(cgs(5e11))
    here.memory = made.initial_memory(np, here)
    given, density = 0.0, 5e11
    for number in range(60):
        for length in (1.0,) if number % 10 else (1.0 - share, share):
            density *= 1.0 + 0.001 * length
            rate = here.memory["capture_rate"][0]
            here = fluid(cgs(density), **here.memory)
            here.memory = made.remember(np, here, length)
            given += 0.5 * length * (rate + here.memory["capture_rate"][0])
        owed = here.memory["capture_heat"][0]
        assert abs(owed) <= 1.1 * here.memory["capture_rate"][0]  # what a step captures, at most
    assert given > 30.0 * abs(owed)


def test_trapped_neutrinos_push_from_nothing_on() -> None:
    made = effect()
    low, high = (
        leptons.trapped_pressure(np, cgs(d), made.worth(np, cgs([d]), 0.3232)[2][0], *made.trapped(np))
        for d in (1.999e12, 2.001e12)
    )
    electrons = made.electrons[0] * (cgs(2e12) * 0.3232) ** (4 / 3)
    assert low == 0.0 and 0.0 <= high < 1e-4 * electrons


def test_units_are_asked_for_where_a_scene_has_none_and_refused_where_it_has() -> None:
    scene = loads(core_scene("G15", 100), ["effects.deleptonisation.mass_unit='1 kg'"])
    with pytest.raises(SceneError, match="are for scenes in code units"):
        effects_of(scene, code_units(scene))
    with pytest.raises(ValueError, match="the scene has no units"):
        catalogue.build("deleptonisation").in_units(DIMENSIONLESS)
    scene = loads(core_scene("G15", 100))
    made = next(each for each in effects_of(scene, code_units(scene)) if each.kind == "deleptonisation")
    assert made.escape * code_units(scene).unit("specific_energy") == pytest.approx(
        10 * leptons.MEV / leptons.ATOMIC_MASS
    )


def fallen(steps: int) -> SimpleNamespace:
    """A ball of 3e11 g/cm^3 that turns, falls to three times that density and loses electrons, with uneven steps."""
    position = ball(60)
    made = catalogue.build("deleptonisation", {"mass_unit": 2e30, "length_unit": 1.166e5})
    velocity = -0.9 * position + 0.3 * np.cross((0.0, 0.0, 1.0), position)
    parts = (catalogue.build("pressure"), made)
    problem, state, arrangement = state_of(*parts, position=position, velocity=velocity)
    begun = SimpleNamespace(state=state, energy=energy_budget(problem, state)["total"])
    for number in range(steps):
        length = 0.4 / steps * (1.0 + 0.3 * math.cos(math.pi * number))
        state = step(problem, arrangement, state, np.float64(length))
    gained = energy_budget(problem, state)["total"] - begun.energy
    return SimpleNamespace(problem=problem, begun=begun.state, state=state, gained=gained, taken=made.recorded(state))


@pytest.mark.slow
def test_a_falling_ball_keeps_energy_to_second_order_and_momenta_to_rounding() -> None:
    runs = [fallen(steps) for steps in (80, 320)]
    first, last = (abs(run.gained) for run in runs)
    found, begun = runs[-1].state, runs[-1].begun
    assert math.log(first / last) / math.log(4.0) == pytest.approx(2.0, abs=0.3)
    heat = float(found.ledger.heating.total[1])
    assert last < 1e-4 * heat
    assert heat > 0.0 and runs[-1].taken["neutrino_energy"] > 0.0
    assert runs[-1].taken["least_electron_fraction"] < begun.memory["electron_fraction"].min() - 0.02
    momentum = found.mass @ (found.velocity - begun.velocity)
    assert np.abs(momentum).max() < 1e-14
    spin = [each.mass @ np.cross(each.position, each.velocity) for each in (begun, found)]
    assert np.abs(spin[1] - spin[0]).max() < 1e-14
    shown = snapshot_record(runs[-1].problem, found)["electron_fraction"]
    assert (shown[np.asarray(found.identity)] == found.memory["electron_fraction"]).all()


@pytest.mark.slow
def test_a_state_of_a_snapshot_keeps_its_electron_fractions() -> None:
    """Of matter that was denser once, not those of its density; the pressure goes with them."""
    scene = loads(core_scene("G15", 100))
    units = code_units(scene)
    begun = sph.evolution(scene, units)
    shown = dict(begun.snapshot().items())
    arrays = {name: np.asarray(array) for name, array in shown.items()}
    fitted = arrays["electron_fraction"].copy()
    arrays["electron_fraction"] = fitted - np.linspace(0.0, 0.05, len(fitted))
    found = sph.of_snapshot(scene, units, arrays).state
    order = np.argsort(np.asarray(found.identity))
    memory = {name: np.asarray(array)[order] for name, array in found.memory.items()}
    np.testing.assert_array_equal(memory["electron_fraction"], arrays["electron_fraction"])
    fluid_density = np.asarray(found.rates.fluid.density)[order]
    cold = leptons.ELECTRONS * 0.4971 ** (4 / 3) * (fluid_density * units.unit("density")) ** (4 / 3)
    share = (memory["electron_fraction"] / 0.4971) ** (4 / 3)
    expected = cold * (share - 1.0) / units.unit("pressure")
    np.testing.assert_allclose(memory["further_pressure"], expected, rtol=1e-6)
    again = sph.of_snapshot(scene, units, {name: arrays[name] for name in arrays if name != "electron_fraction"}).state
    order = np.argsort(np.asarray(again.identity))
    np.testing.assert_allclose(np.asarray(again.memory["electron_fraction"])[order], fitted, rtol=1e-6)
    for bad in (-arrays["electron_fraction"], arrays["electron_fraction"][:50]):
        with pytest.raises(ValueError, match="electron_fraction"):
            sph.of_snapshot(scene, units, {**arrays, "electron_fraction": bad})


def test_the_plan_names_the_fit_as_the_scene_does() -> None:
    assert "fit N13" in plan(loads(core_scene("N13", 100))).text()
