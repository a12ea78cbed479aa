"""Tensors of a series of snapshots: right, in any layout, and without holding the file."""

import subprocess
import sys
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from astropy import units as u

from astroinertia.errors import SceneError
from astroinertia.inertia import tensor
from astroinertia.studies.moments_series import moments_series

ROOT = Path(__file__).parents[3]


def snapshots(count=7, particles=501, dtype=float, shift=0.0):
    random = np.random.default_rng(6)
    position = (random.normal(size=(count, particles, 3)) * [1.0, 2.0, 3.0] + shift).astype(dtype)
    return xr.Dataset(
        {
            "position": (("snapshot_time", "particle", "i"), position, {"units": "m"}),
            "mass": (("snapshot_time", "particle"), random.uniform(1, 2, (count, particles)), {"units": "kg"}),
        },
        coords={"snapshot_time": ("snapshot_time", np.arange(count) * 0.5, {"units": "s"})},
    )


@pytest.mark.parametrize("shift", [0.0, 1e6])
@pytest.mark.parametrize("buffer", [1, 40_000, 10**9])
def test_every_snapshot_has_the_tensor_of_its_particles(shift, buffer):
    given = snapshots(shift=shift)
    mass, position = given["mass"].values, given["position"].values
    found = moments_series(given, buffer=buffer)
    size = abs(tensor.inertia_tensor(mass, position)).max()
    np.testing.assert_allclose(found["inertia_tensor"], tensor.inertia_tensor(mass, position), atol=1e-14 * size)
    np.testing.assert_allclose(found["mass"], mass.sum(1), rtol=1e-14)
    reach = abs(position).max()  # what a centre can be rounded by
    np.testing.assert_allclose(
        found["centre_of_mass"], tensor.centre_of_mass(mass, position), rtol=0, atol=1e-14 * reach
    )
    assert found["inertia_tensor"].attrs["units"] == "kg m2"
    xr.testing.assert_identical(found["snapshot_time"], given["snapshot_time"])


def test_about_a_point_it_is_the_tensor_about_that_point():
    given = snapshots(shift=3.0)
    direct = tensor.inertia_tensor(given["mass"].values, given["position"].values, np.array([1.0, -2.0, 0.5]))
    found = moments_series(given, about=(1.0, -2.0, 0.5))
    np.testing.assert_allclose(found["inertia_tensor"], direct, rtol=0, atol=1e-14 * abs(direct).max())


def test_a_point_may_have_a_unit():
    given = snapshots(shift=3.0)
    given["position"].attrs["units"] = "km"
    in_metres = np.array([1e3, -2e3, 500.0]) * u.m
    points = (1.0, -2.0, 0.5), in_metres, ["1 km", "-2000 m", 0.5], [1.0 * u.km, "-2 km", 500 * u.m]
    found = [moments_series(given, about=point)["inertia_tensor"] for point in points]
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], rtol=1e-13)
    for wrong, sentence in (((1.0, 2.0), "three finite numbers"), ([1, 2, np.nan], "three finite numbers"),
                            (["1 s", 0, 0], "must be in km")):  # fmt: skip
        with pytest.raises((ValueError, SceneError), match=sentence):
            moments_series(given, about=wrong)
    del given["position"].attrs["units"]
    with pytest.raises(ValueError, match="about must have no unit"):
        moments_series(given, about=["1 km", 0, 0])


def test_dimensions_may_stand_in_any_order_and_masses_be_the_same_throughout():
    given = snapshots()
    given["mass"] = given["mass"].isel(snapshot_time=0)
    turned = given.transpose("i", "particle", "snapshot_time").rename(particle="star", i="axis", snapshot_time="time")
    found = moments_series(turned, series="time", particle="star", component="axis")
    np.testing.assert_array_equal(found["inertia_tensor"], moments_series(given)["inertia_tensor"])


def test_components_are_those_that_labels_say():
    given = snapshots().assign_coords(i=list("xyz"))
    for order in ([2, 0, 1], [1, 0, 2]):
        found = moments_series(given.isel(i=order))
        for name in ("inertia_tensor", "centre_of_mass", "principal_axes"):
            np.testing.assert_allclose(found[name], moments_series(given)[name], atol=1e-14)
    np.testing.assert_array_equal(
        moments_series(given.assign_coords(i=[0, 1, 2]))["centre_of_mass"], moments_series(given)["centre_of_mass"]
    )
    for labels in (["r", "theta", "phi"], [2, 1, 0]):
        with pytest.raises(ValueError, match="the components of position are"):
            moments_series(given.assign_coords(i=labels))


@pytest.mark.parametrize("layout", ["NETCDF4", "NETCDF3_CLASSIC"])
def test_labels_may_be_characters_as_other_programs_write_them(tmp_path, layout):
    given = snapshots()
    with netCDF4.Dataset(tmp_path / "s.nc", "w", format=layout) as file:
        for dim, size in given.sizes.items():
            file.createDimension(dim, size)
        file.createVariable("i", "S1", ("i",))[:] = np.array(list("ZXY"), "S1")
        for name, values in given.isel(i=[2, 0, 1]).data_vars.items():
            file.createVariable(name, "f8", values.dims)[:] = values.values
    with xr.open_dataset(tmp_path / "s.nc") as opened:
        found = moments_series(opened)
    np.testing.assert_array_equal(found["inertia_tensor"], moments_series(given)["inertia_tensor"])


def test_single_precision_is_summed_in_double():
    given = snapshots(dtype=np.float32, shift=1000.0)
    exact = given.assign(position=given["position"].astype(float))
    np.testing.assert_array_equal(moments_series(given)["inertia_tensor"], moments_series(exact)["inertia_tensor"])


def test_axes_do_not_flip_along_the_series():
    angle = np.linspace(0, 2 * np.pi, 60)
    body = np.random.default_rng(7).normal(size=(200, 3)) * [3.0, 2.0, 1.0]
    turn = np.stack([np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)], 1).reshape(-1, 2, 2)
    position = np.repeat(body[None], 60, axis=0)
    position[..., :2] = np.einsum("tij,nj->tni", turn, body[:, :2])
    given = snapshots(60, 200)
    given["position"] = given["position"].copy(data=position)
    given["mass"] = given["mass"].isel(snapshot_time=0)
    axes = moments_series(given)["principal_axes"].values
    assert np.einsum("tki,tki->tk", axes[1:], axes[:-1]).min() > 0.99


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda given: given.drop_vars("mass"), "no variable 'mass'"),
        (lambda given: given.isel(i=slice(2)), "position has the dimensions"),
        (lambda given: given.assign(mass=given["snapshot_time"]), "mass has the dimensions"),
        (lambda given: given.isel(particle=slice(0)), "no particles"),
    ],
)
def test_what_is_no_series_of_particles_is_refused(change, sentence):
    with pytest.raises(ValueError, match=sentence):
        moments_series(change(snapshots()))


MEASURED = """
import sys
import netCDF4, xarray
from astroinertia.studies.moments_series import moments_series

def peak():
    # not ru_maxrss, which begins with the size of the process that started this one
    with open("/proc/self/status") as status:
        return 1024 * int(next(line for line in status if line.startswith("VmHWM:")).split()[1])

netCDF4.set_chunk_cache(2**20)  # netCDF itself would keep 64 MB of each variable
with xarray.open_dataset(sys.argv[1]) as opened:
    moments_series(opened.isel(snapshot_time=slice(20)), buffer=2**21)  # compiles
    before = peak()
    found = moments_series(opened, buffer=2**21)
    print(peak() - before, opened["position"].nbytes + opened["mass"].nbytes, float(found["mass"].sum()))
"""


@pytest.mark.slow
def test_a_file_is_never_held_whole(tmp_path):
    file = tmp_path / "snapshots.nc"
    with netCDF4.Dataset(file, "w") as written:
        for name, size in (("snapshot_time", 400), ("particle", 20_000), ("i", 3)):
            written.createDimension(name, size)
        for name, more in (("position", ("i",)), ("mass", ())):
            shape = (1, 20_000, 3)[: 2 + len(more)]
            variable = written.createVariable(
                name, "f8", ("snapshot_time", "particle", *more), zlib=True, complevel=1, chunksizes=shape
            )
            for index in range(400):
                variable[index] = 1.0 + index
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, str(file)], capture_output=True, text=True, cwd=ROOT, check=True
    )
    grown, size, total = map(float, done.stdout.split())
    assert total == pytest.approx(20_000 * 400 * 401 / 2)
    assert size > 250e6
    assert grown < 0.1 * size, f"the peak rose by {grown / 1e6:.0f} MB for a file of {size / 1e6:.0f} MB"
