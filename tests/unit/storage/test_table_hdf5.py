"""Particle tables in HDF5 and netCDF: every layout that is read, and how a hostile file is refused."""

import h5py
import netCDF4
import numpy as np
import pytest
import xarray as xr
from astropy import units as u
from astropy.table import QTable

from astroinertia.errors import SceneError
from astroinertia.sph.table import read_table, units_for
from astroinertia.units import SOLAR_MASS

VALUES = np.random.default_rng(5).random((6, 8))
NAMES = ("mass", "x", "y", "z", "vx", "vy", "vz", "u")


def fill(group, columns=NAMES):
    for name, column in zip(columns, VALUES.T, strict=False):
        group.create_dataset(name, data=column, compression="gzip")


def as_vectors(group):
    group["mass"], group["position"], group["velocity"] = VALUES[:, 0], VALUES[:, 1:4], VALUES[:, 4:7]
    group["specific_internal_energy"] = VALUES[:, 7]
    group["note"] = "not a column"


def as_one_table(group):
    table = np.zeros(6, dtype=[("mass", "f8"), ("position", "f8", (3,)), ("velocity", "f8", (3,)), ("u", "f8")])
    table["mass"], table["u"] = VALUES[:, 0], VALUES[:, 7]
    table["position"], table["velocity"] = VALUES[:, 1:4], VALUES[:, 4:7]
    group["table"] = table


@pytest.mark.parametrize("write", [fill, as_vectors, as_one_table])
@pytest.mark.parametrize("place", ["/", "particles"])
def test_every_layout_is_read(tmp_path, write, place):
    with h5py.File(tmp_path / "p.hdf5", "w") as file:
        write(file.require_group(place))
        file.require_group("about").attrs["author"] = "someone"
    table = read_table(tmp_path / "p.hdf5")
    np.testing.assert_array_equal(table.mass, VALUES[:, 0])
    np.testing.assert_array_equal(table.position, VALUES[:, 1:4])
    np.testing.assert_array_equal(table.velocity, VALUES[:, 4:7])
    np.testing.assert_array_equal(table.internal_energy, VALUES[:, 7])


def test_a_netcdf_file_of_columns_is_read(tmp_path):
    with netCDF4.Dataset(tmp_path / "p.nc", "w") as file:
        file.createDimension("particle", 6)
        file.createDimension("i", 3)
        file.createVariable("mass", "f8", ("particle",))[:] = VALUES[:, 0]
        file.createVariable("position", "f4", ("particle", "i"))[:] = VALUES[:, 1:4]
    table = read_table(tmp_path / "p.nc")
    np.testing.assert_array_equal(table.mass, VALUES[:, 0])
    np.testing.assert_array_equal(table.position, VALUES[:, 1:4].astype("f4"))


def huge(file):
    for name in NAMES[:4]:
        file.create_dataset(name, shape=(10**12,), chunks=(1000,), dtype="f8")


def in_another_file(file):
    fill(file, NAMES[1:4])
    file["mass"] = h5py.ExternalLink("/etc/hostname", "mass")


def in_raw_bytes(file):
    fill(file, NAMES[1:4])
    file.create_dataset("mass", shape=(6,), dtype="f8", external=[("/etc/hostname", 0, 48)])


def virtual(file):
    layout = h5py.VirtualLayout(shape=(6,), dtype="f8")
    layout[:] = h5py.VirtualSource("/somewhere/else.h5", "mass", shape=(6,))
    file.create_virtual_dataset("mass", layout)
    fill(file, NAMES[1:4])


def words(file):
    fill(file, NAMES[1:4])
    file["mass"] = ["a"] * 6


def flat(file):
    file["mass"], file["position"] = np.ones(6), np.ones((6, 2))


def twice(file):
    fill(file.create_group("a"))
    fill(file.create_group("b"))


def crowded(file):
    for number in range(1001):
        file.create_group(f"g{number}")


BAD = {
    huge: "at most 10000000 rows",
    in_another_file: "lacks mass",
    in_raw_bytes: "mass is kept in another file",
    virtual: "mass is kept in another file",
    words: "mass is not of numbers",
    flat: "position is not three numbers",
    twice: "more than one group",
    crowded: "more than 1000 members",
}


@pytest.mark.parametrize("write", BAD, ids=lambda write: write.__name__)
def test_bad_files_get_one_sentence(tmp_path, write):
    with h5py.File(tmp_path / "p.h5", "w") as file:
        write(file)
    with pytest.raises(SceneError, match=BAD[write]) as caught:
        read_table(tmp_path / "p.h5")
    assert "\n" not in str(caught.value)


def test_a_group_that_holds_itself_is_no_trap(tmp_path):
    with h5py.File(tmp_path / "p.h5", "w") as file:
        fill(file.create_group("particles"))
        file["again"] = file["/"]  # a hard link; a reader that walks the tree never ends
        file["particles/up"] = file["/"]
    assert read_table(tmp_path / "p.h5").mass.size == 6


def test_what_is_no_hdf5_file_and_what_is_cut_off(tmp_path):
    (tmp_path / "junk.h5").write_bytes(bytes(range(256)))
    with h5py.File(tmp_path / "p.h5", "w") as file:
        fill(file)
    whole = (tmp_path / "p.h5").read_bytes()
    (tmp_path / "cut.h5").write_bytes(whole[: len(whole) // 2])
    for name in ("junk.h5", "cut.h5"):
        with pytest.raises(SceneError, match="not an HDF5 file that can be read"):
            read_table(tmp_path / name)


def as_hdf5(path, mass, position, units, labels):
    with h5py.File(path, "w") as file:
        file["mass"], file["position"] = mass, position
        for name, unit in zip(("mass", "position"), units, strict=True):
            file[name].attrs["units"] = unit


def as_netcdf(path, mass, position, units, labels, **how):
    data = xr.Dataset({"mass": ("particle", mass), "position": (("particle", "i"), position)})
    for name, unit in zip(("mass", "position"), units, strict=True):
        data[name].attrs["units"] = unit
    data = data if labels is None else data.assign_coords(i=labels)
    data.transpose(*how.pop("order", ("particle", "i"))).to_netcdf(path, **how)


def as_classic(*given, **how):
    as_netcdf(*given, engine="scipy", format="NETCDF3_64BIT", **how)


def as_csv(path, mass, position, units, labels):
    head = f"mass [{units[0]}]," + ",".join(f"{name} ({units[1]})" for name in "xyz")
    rows = [",".join(map(repr, row)) for row in np.column_stack([mass, position]).tolist()]
    path.write_text("\n".join([head, *rows]))


FORMATS = {"p.hdf5": as_hdf5, "p.nc": as_netcdf, "classic.nc": as_classic, "p.csv": as_csv}


@pytest.mark.parametrize("name", FORMATS)
def test_units_of_columns_are_those_that_their_attributes_state(tmp_path, name):
    def written(*units):
        FORMATS[name](tmp_path / name, VALUES[:, 0], VALUES[:, 1:4], units, None)
        return read_table(tmp_path / name)

    table = written("Msun", "km")
    assert table.units == "SI"
    np.testing.assert_allclose(table.mass, VALUES[:, 0] * SOLAR_MASS, rtol=1e-9)
    np.testing.assert_allclose(table.position, VALUES[:, 1:4] * 1e3, rtol=1e-15)
    without = written("1", "1")
    assert without.units is None
    np.testing.assert_array_equal(without.position, VALUES[:, 1:4])
    with pytest.raises(SceneError, match="its column x has no unit, but mass has one"):
        written("kg", "1")
    with pytest.raises(SceneError, match="the unit of x: '1 s' is not a length"):
        written("kg", "s")


def test_a_scene_has_the_units_of_the_columns_of_its_table(tmp_path):
    for name, write in FORMATS.items():
        write(tmp_path / name, VALUES[:, 0], VALUES[:, 1:4], ("Msun", "km"), None)
        mass, length = units_for(tmp_path / name, in_si=False)
        assert mass == pytest.approx(VALUES[:, 0].sum() * SOLAR_MASS, rel=1e-9)
        assert 1e2 < length < 2e3


@pytest.mark.parametrize("suffix", ["nc", "h5", "hdf5"])
def test_what_netcdf_has_written_is_read_so_whatever_its_ending(tmp_path, suffix):
    """Packed numbers, labels and fill values are what they stand for."""
    labels = ["z", "y", "x"]
    data = xr.Dataset(
        {"mass": ("particle", VALUES[:, 0]), "position": (("particle", "i"), VALUES[:, 3:0:-1].copy())}, {"i": labels}
    )
    packed = {"dtype": "int32", "scale_factor": 1e-8, "_FillValue": -9}
    data.to_netcdf(tmp_path / "p.nc", encoding={"position": packed})
    path = (tmp_path / "p.nc").rename(tmp_path / f"p.{suffix}")
    np.testing.assert_allclose(read_table(path).position, VALUES[:, 1:4], atol=1e-8)
    data["position"][3, 0] = np.nan
    data.to_netcdf(tmp_path / "q.nc", encoding={"position": packed})
    with pytest.raises(SceneError, match="z of row 4 is not finite"):
        read_table((tmp_path / "q.nc").rename(tmp_path / f"q.{suffix}"))


def test_packed_numbers_are_known_without_the_mark_that_newer_netcdf_leaves(tmp_path):
    data = xr.Dataset({name: ("particle", VALUES[:, k]) for k, name in enumerate(("mass", "x", "y", "z"))})
    packed = {"mass": {"dtype": "int32", "scale_factor": 1e-8, "_FillValue": -9}}
    data.to_netcdf(tmp_path / "p.h5", encoding=packed, engine="netcdf4")
    with h5py.File(tmp_path / "p.h5", "a") as file:
        del file.attrs["_NCProperties"]
    np.testing.assert_allclose(read_table(tmp_path / "p.h5").mass, VALUES[:, 0], atol=1e-8)
    data.to_netcdf(tmp_path / "q.h5", group="stars", encoding=packed, engine="netcdf4")
    np.testing.assert_allclose(read_table(tmp_path / "q.h5").mass, VALUES[:, 0], atol=1e-8)


@pytest.mark.parametrize("group", [None, "stars"])
def test_components_of_a_netcdf_file_are_in_the_order_of_their_labels_wherever_they_stand(tmp_path, group):
    data = xr.Dataset(
        {"mass": ("particle", VALUES[:, 0]), "position": (("particle", "i"), VALUES[:, 1:4])}, {"i": ["x", "y", "z"]}
    )
    data.sel(i=["z", "x", "y"]).to_netcdf(tmp_path / "p.h5", group=group, engine="netcdf4")
    np.testing.assert_array_equal(read_table(tmp_path / "p.h5").position, VALUES[:, 1:4])


def test_scales_of_dimensions_make_no_netcdf_of_a_file(tmp_path):
    with h5py.File(tmp_path / "p.h5", "w") as file:
        file["number"] = np.arange(len(VALUES))
        file["number"].make_scale("particle")
        file["mass"], file["position"] = VALUES[:, 0], VALUES[:, 1:4]
        for name in ("mass", "position"):
            file[name].dims[0].attach_scale(file["number"])
    np.testing.assert_array_equal(read_table(tmp_path / "p.h5").position, VALUES[:, 1:4])


def test_a_table_of_astropy_has_the_units_that_stand_beside_it(tmp_path):
    table = QTable({"mass": VALUES[:, 0] * u.Msun, "position": VALUES[:, 1:4] * u.km})
    table.write(tmp_path / "p.h5", path="particles", serialize_meta=True)
    found = read_table(tmp_path / "p.h5")
    assert found.units == "SI"
    np.testing.assert_allclose(found.mass, VALUES[:, 0] * SOLAR_MASS, rtol=1e-9)
    np.testing.assert_allclose(found.position, VALUES[:, 1:4] * 1e3, rtol=1e-15)


@pytest.mark.parametrize("write", [as_netcdf, as_classic])
@pytest.mark.parametrize("order", [("particle", "i"), ("i", "particle")])
def test_components_of_a_vector_are_those_that_its_labels_say(tmp_path, write, order):
    given = (tmp_path / "p.nc", VALUES[:, 0], VALUES[:, 3:0:-1], ("1", "1"))
    write(*given, ["z", "y", "x"], order=order)
    np.testing.assert_array_equal(read_table(tmp_path / "p.nc").position, VALUES[:, 1:4])
    for labels in (["r", "theta", "phi"], [2, 1, 0]):
        write(*given, labels)
        with pytest.raises(SceneError, match=f"components of position are {labels[0]}, .*, and not x, y, z"):
            read_table(tmp_path / "p.nc")
