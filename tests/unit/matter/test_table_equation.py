"""Equations of state from files: what is read, and how a file that cannot be one is refused."""

import h5py
import jax
import numpy as np
import pytest

from astroinertia.build.assemble import prepare
from astroinertia.errors import SceneError
from astroinertia.matter.isentropes import isentropes, tabulated
from astroinertia.matter.table_equation import read_equation
from astroinertia.scene.load import loads

GAMMA = 1.4
RHO, HEAT = np.meshgrid(np.geomspace(0.1, 10.0, 30), np.geomspace(0.2, 40.0, 40), indexing="ij")
U = HEAT * RHO**0.1  # a grid in another quantity than the energy, as those in temperature are
COLUMNS = {"density": RHO.ravel(), "internal_energy": U.ravel(), "pressure": ((GAMMA - 1) * RHO * U).ravel()}


def write(path, columns=COLUMNS, names=None):
    names = names or list(columns)
    rows = "\n".join(",".join(repr(float(v)) for v in row) for row in zip(*columns.values(), strict=True))
    path.write_text(",".join(names) + "\n" + rows + "\n")
    return path


CODE_SCENE = """\
name = "code"
model = "sph"
units = "code"
[body]
kind = "uniform"
mass = 1.0
radius = 1.0
specific_internal_energy = 1.0
particles = 100
[equation_of_state]
kind = "materials"
materials = [{name = "gas", file = "a.h5", reference_density = 0.5}]
[effects.pressure]
[time]
end = 0.1
"""


def test_a_table_that_states_units_is_in_si(tmp_path):
    units = {"density": "g/cm3", "internal_energy": "J/kg", "pressure": "MPa", "temperature": "K"}
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name, unit in units.items():
            file[name] = COLUMNS.get(name, COLUMNS["density"])
            file[name].attrs["units"] = unit
    heads = [f"{name} [{unit}]" for name, unit in units.items() if name in COLUMNS]
    write(tmp_path / "a.csv", COLUMNS | {"T": COLUMNS["density"]}, [*heads, "T"])
    for name in ("a.h5", "a.csv"):
        table = read_equation(tmp_path / name)
        assert table.density[0] == pytest.approx(100.0)
        with jax.enable_x64(True):
            assert float(table.function(tension=False)(100.0, 1.0)) == pytest.approx(0.04e6)
    with pytest.raises(SceneError, match="the file of gas states units, but the scene has none"):
        prepare(loads(CODE_SCENE, origin=str(tmp_path)))
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        del file["pressure"].attrs["units"]
    with pytest.raises(SceneError, match="pressure has no unit, but density has one"):
        read_equation(tmp_path / "a.h5")


def test_every_format_gives_the_pressure_of_the_gas(tmp_path):
    """P is exact, as P/rho of an ideal gas does not depend on the density."""
    shuffled = np.random.default_rng(1).permutation(RHO.size)
    mixed = {name: column[shuffled] for name, column in COLUMNS.items()}
    write(tmp_path / "a.csv", mixed, ["rho", "u", "P"])
    np.savez(tmp_path / "a.npz", **mixed)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name, column in mixed.items():
            file["eos/" + name] = column
    for name in ("a.csv", "a.npz", "a.h5"):
        table = read_equation(tmp_path / name)
        with jax.enable_x64(True):
            for rho, u in ((0.1, 1.0), (0.37, 5.0), (2.2, 50.0), (9.0, 0.1)):
                found = float(table.function(tension=False)(rho, u))
                assert found == pytest.approx((GAMMA - 1) * rho * u, rel=1e-12)


def test_cold_matter_between_two_densities_has_its_pressure(tmp_path):
    """P ~ rho^(5/3) of densities a third of a decade apart: to (2/3)^2 of the logarithmic step squared over 8."""
    rho, u = np.meshgrid(np.geomspace(0.1, 10.0, 7), np.linspace(0.0, 1.0, 4), indexing="ij")
    columns = (rho.ravel(), (1.5 * rho ** (2 / 3) + u).ravel(), (rho ** (5 / 3) + 2 / 3 * rho * u).ravel())
    table = read_equation(write(tmp_path / "a.csv", dict(zip(COLUMNS, columns, strict=True))))
    middle = np.sqrt(rho[2, 0] * rho[3, 0])
    found = table.function(False)(middle, 1.5 * middle ** (2 / 3) + 0.5)
    step = np.log(100) / 6
    assert found == pytest.approx(middle ** (5 / 3) + middle / 3, rel=(2 / 3 * step) ** 2 / 8)


@pytest.mark.slow
def test_the_fluid_of_a_table_is_the_gas(tmp_path):
    """Its isentropes, integrated from the table alone, are u ~ rho^(gamma - 1)."""
    table = read_equation(write(tmp_path / "a.csv"))
    coldest = table.coldest(1.0)
    made = isentropes("gas", table.function(False), 1.0, 0.4, (0.1, 10.0), 30.0, coldest, nodes=(200, 60))
    rho, label = np.array([0.2, 1.0, 5.0]), np.array([1.0, 4.0, 20.0])
    found = tabulated([made]).energy(np, rho, label)
    np.testing.assert_allclose(found, (label + coldest) * rho ** (GAMMA - 1), rtol=2e-3)


def without(name):
    return {key: column for key, column in COLUMNS.items() if key != name}


def with_one(name, row, value):
    changed = {key: column.copy() for key, column in COLUMNS.items()}
    changed[name][row] = value
    return changed


BAD = {
    "missing column": (without("pressure"), "lacks pressure"),
    "unknown column": ({**COLUMNS, "colour": COLUMNS["density"]}, "has unknown columns colour"),
    "not finite": (with_one("pressure", 3, np.nan), "pressure of row 4 is not finite"),
    "negative density": (with_one("density", 0, -1.0), "density of row 1 is not positive"),
    "no grid": ({key: column[:-1] for key, column in COLUMNS.items()}, "is no grid"),
    "too small": ({key: column[:3] for key, column in COLUMNS.items()}, "is no grid"),
    "energy twice": (with_one("internal_energy", 1, COLUMNS["internal_energy"][0]), "an energy is there twice"),
    "empty": ({key: column[:0] for key, column in COLUMNS.items()}, "is no grid"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_tables_get_one_sentence(tmp_path, name):
    columns, message = BAD[name]
    with pytest.raises(SceneError, match=message) as caught:
        read_equation(write(tmp_path / "bad.csv", columns))
    assert "\n" not in str(caught.value)


def test_files_that_are_none_are_refused(tmp_path):
    with pytest.raises(SceneError, match="is not there"):
        read_equation(tmp_path / "none.csv")
    (tmp_path / "long.csv").write_text("density,internal_energy,pressure\n" + "1" * 2000 + "\n")
    with pytest.raises(SceneError, match="longer than 1024"):
        read_equation(tmp_path / "long.csv")
    (tmp_path / "words.csv").write_text("density,internal_energy,pressure\n1,2,x\n")
    with pytest.raises(SceneError, match="is not numbers"):
        read_equation(tmp_path / "words.csv")
    np.savez(tmp_path / "odd.npz", density=np.array([{}], dtype=object), internal_energy=1.0, pressure=1.0)
    with pytest.raises(SceneError, match="npz file of plain numbers"):
        read_equation(tmp_path / "odd.npz")
    (tmp_path / "a.txt").write_text("1")
    with pytest.raises(SceneError, match=r"must be a \.csv"):
        read_equation(tmp_path / "a.txt")
