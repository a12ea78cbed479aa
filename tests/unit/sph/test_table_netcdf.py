"""Particle tables in netCDF of every format, as netCDF's own library reads them: packed, unsigned, and not valid."""

import netCDF4
import numpy as np
import pytest
from scipy.io import netcdf_file

from astroinertia.errors import SceneError
from astroinertia.sph.table import read_table

FORMATS = ("NETCDF4", "NETCDF4_CLASSIC", "NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET")
COUNT = 6
COLUMNS = {
    "mass": np.full(COUNT, 2.0),
    **{name: np.linspace(-1.0, 1.0, COUNT) + shift for shift, name in enumerate("xyz")},
}


def table(path, layout="NETCDF4", missing=None, odd=None, **attributes):
    """Columns in a file, of which x has `odd` in its fourth row and the attributes."""
    with netCDF4.Dataset(path, "w", format=layout) as file:
        file.createDimension("particle", COUNT)
        for name, values in COLUMNS.items():
            variable = file.createVariable(name, "f8", ("particle",), fill_value=missing)
            variable.set_auto_mask(False)
            variable[:] = values
        if odd is not None:
            file["x"][3] = odd
        for name, value in attributes.items():
            file["x"].setncattr(name, value)
    return path


@pytest.mark.parametrize("layout", FORMATS)
@pytest.mark.parametrize(
    ("odd", "attributes"),
    [
        (9e9, {"valid_range": np.array([-100.0, 100.0])}),
        (-9e9, {"valid_range": np.array([-100.0, 100.0])}),
        (9e9, {"valid_max": 100.0}),
        (-9e9, {"valid_min": -100.0}),
        (-99.0, {"missing_value": -99.0}),
        (-9.0, {"missing": -9.0}),
        (-99.0, {"missing": -9.0, "missing_value": -99.0}),
        (netCDF4.default_fillvals["f8"], {"missing_value": -99.0}),
    ],
)
def test_what_is_not_valid_is_no_number(tmp_path, layout, odd, attributes):
    with pytest.raises(SceneError, match="x of row 4 is not finite"):
        read_table(table(tmp_path / "p.nc", layout, odd=odd, **attributes))
    assert read_table(table(tmp_path / "valid.nc", layout, **attributes)).position[3, 0] == COLUMNS["x"][3]


@pytest.mark.parametrize("layout", ["NETCDF4", "NETCDF3_CLASSIC", "HDF5"])
@pytest.mark.parametrize(("name", "said"), [("m", "mass"), ("position", "position and x, y, z")])
def test_a_column_by_two_names_is_refused(tmp_path, layout, name, said):
    path = tmp_path / ("p.h5" if layout == "HDF5" else "p.nc")
    with netCDF4.Dataset(path, "w", format=layout.replace("HDF5", "NETCDF4")) as file:
        for dim, size in {"particle": COUNT, "i": 3}.items():
            file.createDimension(dim, size)
        for own, values in COLUMNS.items():
            file.createVariable(own, "f8", ("particle",))[:] = values
        shape = ("particle", "i") if name == "position" else ("particle",)
        file.createVariable(name, "f8", shape)[:] = 7.0
    with pytest.raises(SceneError, match=f"has columns more than once, namely {said}"):
        read_table(path)


def test_the_format_that_is_not_read_is_named(tmp_path):
    with pytest.raises(SceneError, match="netCDF's format CDF-5, which is not read; `nccopy -k nc4` makes netCDF-4"):
        read_table(table(tmp_path / "p.nc", "NETCDF3_64BIT_DATA"))


def test_a_run_whose_sinks_have_accreted_is_no_body(tmp_path):
    mass = np.array([[2.0] * COUNT, [2.0, np.nan, 2.0, np.nan, np.nan, 2.0]])
    with netCDF4.Dataset(tmp_path / "run.nc", "w") as file:
        group = file.createGroup("snapshots")
        for dim, size in {"snapshot_time": 2, "particle": COUNT, "i": 3}.items():
            group.createDimension(dim, size)
        group.createVariable("mass", "f8", ("snapshot_time", "particle"))[:] = mass
        for name in ("position", "velocity"):
            group.createVariable(name, "f8", ("snapshot_time", "particle", "i"))[:] = mass[..., None]
        group.createVariable("internal_energy", "f8", ("snapshot_time", "particle"))[:] = mass
    with pytest.raises(SceneError, match="no whole body: 3 of its 6 particles are in sinks"):
        read_table(tmp_path / "run.nc")


@pytest.mark.parametrize("layout", FORMATS)
def test_the_ends_of_a_valid_range_are_valid(tmp_path, layout):
    x = COLUMNS["x"]
    for ends in ({"valid_range": x[[0, -1]]}, {"valid_min": x[0], "valid_max": x[-1]}):
        np.testing.assert_array_equal(read_table(table(tmp_path / "p.nc", layout, **ends)).position[:, 0], x)


def test_packed_bytes_without_a_sign(tmp_path):
    with netcdf_file(tmp_path / "p.nc", "w") as file:
        file.createDimension("particle", COUNT)
        for name, values in COLUMNS.items():
            variable = file.createVariable(name, "b", ("particle",))
            variable[:] = np.round((values + 1.0) * 50.0).astype("u1").view("i1")
            variable._Unsigned, variable.scale_factor, variable.add_offset = b"true", np.array(0.02), np.array(-1.0)
    found = read_table(tmp_path / "p.nc")
    with netCDF4.Dataset(tmp_path / "p.nc") as file:
        for column, name in enumerate("xyz"):
            np.testing.assert_array_equal(found.position[:, column], file[name][:])
    assert found.position[-1] == pytest.approx([1.0, 2.0, 3.0], abs=1e-14)  # beyond 127 as a byte
