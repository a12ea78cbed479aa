"""Tables over temperature and electron fraction: read as they are, they make a fluid of exact thermodynamics."""

from typing import Any

import h5py
import numpy as np
import pytest
from scipy.optimize import brentq

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.build.assemble import prepare
from astroinertia.build.materials import equation
from astroinertia.effects.kinds import deleptonisation
from astroinertia.errors import SceneError
from astroinertia.matter.finite_temperature import is_finite_temperature, read_finite_temperature
from astroinertia.matter.isentropes import isentropes, tabulated
from astroinertia.scene import load
from astroinertia.scene.fluid_kinds.materials import Material
from astroinertia.scene.scales import code_units
from tests import synthetic_table as exact

FRACTION = 0.42  # a plane of the table, like 0.44; 0.43 is between
REFERENCE, HOTTEST = 1e13, 1e16  # kg/m^3, J/kg


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return exact.write(tmp_path_factory.mktemp("table") / "exact.h5")


@pytest.fixture(scope="module")
def fluid(path):
    """The equation of state in SI, and its coldest energy at the reference density."""
    table = read_finite_temperature(path, FRACTION)
    span, coldest = (table.density[0], table.density[-1]), table.coldest(REFERENCE)
    made = isentropes("it", table.function(), REFERENCE, 1e-4 * HOTTEST, span, HOTTEST, coldest)
    return tabulated([made]), coldest


def test_a_table_comes_back_as_it_was_written(path):
    """P, u and s at the nodes of a plane, and P as a function of u there, to 1e-10."""
    table = read_finite_temperature(path, FRACTION)
    rho, t = table.density[:, None], table.temperature
    np.testing.assert_allclose(table.pressure, exact.pressure(rho, t, FRACTION), rtol=1e-10)
    np.testing.assert_allclose(table.energy, exact.energy(rho, t, FRACTION), rtol=1e-10)
    np.testing.assert_allclose(table.entropy, exact.entropy(rho, t), rtol=1e-10)
    pressure = table.function()
    for density in table.density[::11]:
        found = pressure(density, exact.energy(density, t, FRACTION))
        np.testing.assert_allclose(found, exact.pressure(density, t, FRACTION), rtol=1e-10)


@pytest.mark.parametrize("fraction", [FRACTION, 0.43])
def test_pressures_between_nodes_are_those_of_the_matter(path, fraction):
    """To 2e-4 at nodes a quarter apart in density, 12 % in temperature and 0.02 in electron fraction; half to 2e-6."""
    table, random = read_finite_temperature(path, fraction), np.random.default_rng(3)
    off, pressure = [], table.function()
    for density in 1e3 * 10.0 ** random.uniform(5.0, 15.0, 40):
        t = 10.0 ** random.uniform(-2.0, 2.0, 100)
        found = pressure(density, exact.energy(density, t, fraction))
        off.append(np.abs(found / exact.pressure(density, t, fraction) - 1.0))
    assert np.max(off) < 2e-4
    assert np.median(off) < 2e-6


def test_matter_beyond_its_temperatures_is_no_colder_than_the_coldest_and_goes_on_linearly(path):
    table = read_finite_temperature(path, FRACTION)
    density = table.density[40]
    low, high = table.energy[40, [0, -1]]
    found = table.function()(density, np.array([0.5 * low, low, high, 1.1 * high, 1.2 * high]))
    assert found[0] == pytest.approx(found[1], rel=1e-11)
    assert found[4] - found[3] == pytest.approx(found[3] - found[2], rel=1e-9)
    assert (found[3] - found[2]) / (0.1 * high) == pytest.approx(density / 3.0, rel=1e-2)  # radiation


def test_electrons_that_leave_take_the_pressure_that_the_table_has_along_its_fractions(path):
    """Degenerate relativistic ones, as the effect deleptonisation has them: to 0.3 % from 1e10 g/cm^3 on.

    The table's are cold electrons of any speed; at 1e9 g/cm^3, where collapse does not begin yet, it is 1 %.
    """
    density = np.array([1e12, 1e13, 1e14, 1e15, 1e16, 1e17])
    for fraction in (0.44, 0.36, 0.28):
        before, after = (read_finite_temperature(path, each) for each in (0.5, fraction))
        pressures = [
            [table.function()(rho, np.array([exact.energy(rho, 1.0, own)]))[0] for rho in density]
            for table, own in ((before, 0.5), (after, fraction))
        ]
        taken = deleptonisation.ELECTRONS * density ** (4 / 3) * (fraction ** (4 / 3) - 0.5 ** (4 / 3))
        off = taken / np.subtract(pressures[1], pressures[0]) - 1.0
        assert 5e-3 < off[0] < 1e-2
        assert np.abs(off[1:]).max() < 3e-3


@pytest.mark.full
@pytest.mark.parametrize("temperature", [0.3, 1.0, 5.0])
def test_the_fluid_of_a_table_has_the_isentropes_of_the_matter(fluid, temperature):
    """u where the exact entropy is that of the reference density, over five decades: to 3e-5, its heat to 1e-3."""
    matter, coldest = fluid
    label = exact.energy(REFERENCE, temperature, FRACTION) - coldest
    wanted = exact.entropy(REFERENCE, temperature)
    for density in np.array([1e12, 1e14, 1e15, 1e16, 1e17]):
        there = brentq(lambda t, density=density: exact.entropy(density, t) - wanted, 1e-8, 1e4)
        found = matter.energy(np, np.array([density]), np.array([label]))[0]
        u, cold = (exact.energy(density, t, FRACTION) for t in (there, 1e-9))
        assert found == pytest.approx(u, rel=3e-5)
        assert found - u == pytest.approx(0.0, abs=1e-3 * (u - cold))


@pytest.mark.slow
def test_a_cycle_of_compression_heating_expansion_and_cooling_gives_its_energy_back(fluid):
    """To 1e-8 of the heat: the integral of P drho/rho^2, taken by itself, is the change of u on both isentropes."""
    matter, _ = fluid
    low, high = 1e11, 3e17
    points, weights = np.polynomial.legendre.leggauss(4)
    edges = matter.numbers[0] + np.arange(matter.rows) / matter.numbers[1]
    edges = np.concatenate([[np.log(low)], edges[(edges > np.log(low)) & (edges < np.log(high))], [np.log(high)]])
    width = np.diff(edges)
    x = (edges[:-1, None] + width[:, None] * (points + 1.0) / 2.0).ravel()

    def work(label):
        pressure = matter.pressure(np, np.exp(x), np.full_like(x, label)) / np.exp(x)
        return float((pressure.reshape(-1, 4) @ weights * width / 2.0).sum())

    def energy(density, label):
        return float(matter.energy(np, np.array([density]), np.array([label]))[0])

    cold, hot = 2e13, 3e15
    heat, cooling = (energy(density, hot) - energy(density, cold) for density in (high, low))
    assert work(cold) == pytest.approx(energy(high, cold) - energy(low, cold), rel=1e-10)
    assert work(cold) + heat - work(hot) - cooling == pytest.approx(0.0, abs=1e-8 * heat)


def test_what_has_a_pressure_is_found_by_it(fluid):
    matter, _ = fluid
    density, label = np.geomspace(1e11, 1e17, 7), np.full(7, 4e14)
    found = matter.entropy_at_pressure(np, density, matter.pressure(np, density, label))
    np.testing.assert_allclose(found, label, rtol=1e-6)


def test_how_far_a_table_is_from_consistent_is_stated(path, tmp_path):
    """1e-6 in half the nodes of the exact one; where energies are 5 % too large, as much of u/(P/rho) more."""
    exactly = read_finite_temperature(path, FRACTION).maxwell()
    assert exactly.median < 2e-6
    assert exactly.almost < 5e-4
    wrong = exact.arrays()
    energy = 10.0 ** wrong["logenergy"] - 1e4 * exact.SHIFT
    wrong["logenergy"] = np.log10(1.05 * energy + 1e4 * exact.SHIFT)
    found = read_finite_temperature(exact.write(tmp_path / "wrong.h5", wrong), FRACTION)
    assert found.maxwell().median == pytest.approx(0.05, rel=0.3)
    assert "MeV; Maxwell's relation of P and u holds to 0.05 in half" in found.description


@pytest.mark.slow
def test_a_star_on_a_table_has_the_share_of_its_equilibrium_that_the_scene_says(path):
    """P/rho^(4/3) is that share of the polytrope's, where that is more than cold matter has."""
    scene = load.loads(exact.STAR.replace("FILE", str(path)))
    made: Any = prepare(scene).evolution
    state, matter = made.state, made.problem.equation_of_state
    star = Polytrope(3.0, 1.0, 1800e3 / code_units(scene).unit("length"))
    density = star.density(np.linalg.norm(state.position, axis=1))
    warm = np.asarray(state.entropy) > 1e-12
    assert warm.sum() > 48
    found = matter.pressure(np, density, np.asarray(state.entropy)) / density ** (4 / 3)
    np.testing.assert_allclose(found[warm], 0.9 * star.constant, rtol=3e-5)


def without(name):
    return {key: values for key, values in exact.arrays((5, 6, 7)).items() if key != name}


def changed(name, function):
    content = exact.arrays((5, 6, 7))
    content[name] = function(content[name])
    return content


def with_one(values, value):
    values.flat[40] = value
    return values


BAD = {
    "no pressures": (without("logpress"), "lacks logpress"),
    "no shift": (without("energy_shift"), "lacks energy_shift"),
    "another shape": (changed("logpress", lambda v: v.T), "logpress is not of 5 x 6 x 7 numbers"),
    "not finite": (changed("logenergy", lambda v: with_one(v, np.nan)), "logenergy has values that are not finite"),
    "beyond numbers": (changed("logpress", lambda v: v + 400.0), "logpress has values that are not finite"),
    "text": (changed("logpress", lambda v: v.astype("S8")), "logpress is not of"),
    "an axis that falls": (changed("logrho", lambda v: v[::-1]), "logrho does not rise"),
    "an axis of two": (changed("ye", lambda v: v[:2]), "ye is not a row of 4 to 4096"),
    "an axis that is a plane": (changed("ye", lambda v: v[:, None]), "ye is not a row"),
    "energy that falls": (changed("logenergy", lambda v: v[:, ::-1]), "energy falls where temperature rises"),
    "a shift without end": (changed("energy_shift", lambda v: v * np.inf), "energy_shift is not a finite number"),
    "several shifts": (changed("energy_shift", lambda v: np.repeat(v, 2)), "energy_shift is not of 1 numbers"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_tables_get_one_sentence(tmp_path, name):
    content, message = BAD[name]
    with pytest.raises(SceneError, match=message) as caught:
        read_finite_temperature(exact.write(tmp_path / "bad.h5", content), 0.3)
    assert "\n" not in str(caught.value)


def test_tables_that_are_large_or_elsewhere_are_not_read(tmp_path, path):
    """A file of a few kB that says it has 150 MiB, data in another file, and a link to one."""
    axes = {name: np.linspace(0.0, 1.0, 270) for name in ("ye", "logtemp", "logrho")}
    with h5py.File(exact.write(tmp_path / "large.h5", axes), "a") as file:
        for name in ("logpress", "logenergy", "entropy"):
            file.create_dataset(name, (270, 270, 270), chunks=True, dtype="f8")
        file["energy_shift"] = np.ones(1)
    with pytest.raises(SceneError, match="150 MiB"):
        read_finite_temperature(tmp_path / "large.h5", 0.5)
    with h5py.File(exact.write(tmp_path / "huge.h5", without("logpress")), "a") as file:
        del file["ye"]
        file.create_dataset("ye", (10**9,), chunks=True, dtype="f8")
        file.create_dataset("logpress", (5, 6, 7), dtype="f8")
    with pytest.raises(SceneError, match="ye is not a row"):
        read_finite_temperature(tmp_path / "huge.h5", 0.3)
    with h5py.File(exact.write(tmp_path / "elsewhere.h5", without("logpress")), "a") as file:
        file.create_dataset("logpress", (5, 6, 7), dtype="f8", external=[(str(path), 0, 8 * 210)])
    with pytest.raises(SceneError, match="kept in another file"):
        read_finite_temperature(tmp_path / "elsewhere.h5", 0.3)
    with h5py.File(exact.write(tmp_path / "linked.h5", without("logpress")), "a") as file:
        file["logpress"] = h5py.ExternalLink(str(path), "logpress")
    with pytest.raises(SceneError, match="lacks logpress"):
        read_finite_temperature(tmp_path / "linked.h5", 0.3)
    (tmp_path / "text.h5").write_text("logrho")
    with pytest.raises(SceneError, match="not an HDF5 file"):
        is_finite_temperature(tmp_path / "text.h5")


def test_noise_of_a_table_is_smoothed_and_an_electron_fraction_must_be_in_it(tmp_path):
    """An energy lower than that of the temperature below by less than a thousandth of P/rho is as good as its equal."""
    content = exact.arrays((5, 6, 7))
    energy = content["logenergy"]
    energy[:, 1, 3] = energy[:, 0, 3] - 1e-9
    table = read_finite_temperature(exact.write(tmp_path / "noisy.h5", content), 0.3)
    assert (np.diff(table.energy, axis=1) > 0).all()
    with pytest.raises(SceneError, match=r"from 0\.1 to 0\.5, not 0\.6"):
        read_finite_temperature(tmp_path / "noisy.h5", 0.6)


def test_a_scene_says_the_electron_fraction_of_such_a_table_and_of_no_other(tmp_path, path):
    with pytest.raises(SceneError, match="needs an electron_fraction"):
        prepare(load.loads(exact.STAR.replace("FILE", str(path)).replace("electron_fraction = 0.42", "")))
    (tmp_path / "plain.csv").write_text("density,internal_energy,pressure\n")
    with pytest.raises(SceneError, match="is no table that has an electron_fraction"):
        prepare(load.loads(exact.STAR.replace("FILE", str(tmp_path / "plain.csv"))))


def test_isentropes_reach_a_hundred_mev_a_nucleon_or_as_far_as_the_scene_says(path):
    """The table itself goes on to energies that nothing leaves in a collapsing core."""
    given = {"name": "core", "file": str(path), "electron_fraction": FRACTION, "reference_density": "1e13 kg/m3"}
    made = equation(Material.model_validate(given), None)
    table = read_finite_temperature(path, FRACTION)
    assert table.hottest(REFERENCE) > 2.0 * HOTTEST
    assert (made.greatest_energy, made.coldest) == (HOTTEST, pytest.approx(table.coldest(REFERENCE), rel=1e-12))
    assert equation(Material.model_validate(given | {"hottest": "3e15 J/kg"}), None).greatest_energy == 3e15
