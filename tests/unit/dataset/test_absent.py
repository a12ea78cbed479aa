"""What a run does not have is not in the dataset that is opened; its reason is, and code that reads it has NaN."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import astroinertia
from astroinertia import dataset, plots
from astroinertia.dataset.absent import whole, without_absent
from astroinertia.dataset.waves import FAINTEST, too_faint
from astroinertia.interop.tables import write_series
from astroinertia.observables.quantities import DERIVED, OF_ATTITUDE, RECORDED

MOMENTS = ["1 kg m2", "2 kg m2", "3 kg m2"]
TOP = {
    "name": "top",
    "model": "rigid",
    "body": {"kind": "rigid", "mass": "1 kg", "moments": MOMENTS, "rotation": {"rate": "1 rad/s", "axis": [1, 0, 1]}},
    "effects": [],
    "numerics": {"integrator": "splitting"},
    "time": "10 s",
    "output": {"series_every": "2 s"},
}


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return astroinertia.run_scene(TOP, tmp_path_factory.mktemp("absent") / "run")


def test_a_rigid_body_has_nothing_of_particles_and_no_waves(file: Path) -> None:
    ds = astroinertia.open(file)
    assert not [name for name in ds.data_vars if "reason" in ds[name].attrs or bool(ds[name].isnull().all())]
    assert not [name for name in ds if str(name).startswith(("gw_", "mode_", "density", "timestep_limit"))]
    assert set(ds.dims) == set(ds.coords) and not {"radius_bin", "mode", "observer", "frequency"} & set(ds.dims)
    absent = ds.inertia.absent
    assert set(ds.data_vars) | set(absent) == {*RECORDED, *DERIVED, *OF_ATTITUDE} and not set(ds.data_vars) & set(
        absent
    )
    assert absent["core_particles"] == "there are no particles"
    assert absent["gw_energy"] == f"the waves are too faint: their strain times distance stays below {FAINTEST:g} m"
    tree = astroinertia.open_tree(file)
    assert set(tree.data_vars) == set(ds.data_vars) and tree.inertia.absent == absent


@pytest.mark.slow
def test_the_file_has_all_of_the_schema_and_code_gets_it_back(file: Path, tmp_path: Path) -> None:
    ds, full = astroinertia.open(file), dataset.open(file)
    assert set(full.data_vars) >= {*RECORDED, *DERIVED}
    again = ds.inertia.dataset
    assert again.sizes == full.sizes and again.encoding["source"] == full.encoding["source"]
    for name, variable in full.data_vars.items():
        assert again[name].equals(variable) or bool(variable.isnull().all()), name
        assert again[name].dims == variable.dims and again[name].shape == variable.shape
        for attribute in ("units", "long_name", "reason"):
            assert again[name].attrs.get(attribute) == variable.attrs.get(attribute), (name, attribute)
    assert plots.summary(ds) == plots.summary(full)
    for number, which in enumerate((ds, full)):
        write_series(which, tmp_path / f"{number}.csv")
    assert (tmp_path / "0.csv").read_text() == (tmp_path / "1.csv").read_text()


def test_what_was_left_out_survives_a_file_and_a_cut(file: Path, tmp_path: Path) -> None:
    ds = astroinertia.open(file)
    ds.isel(time=slice(1, 3)).to_netcdf(tmp_path / "cut.nc")
    cut = astroinertia.open(tmp_path / "cut.nc")
    assert cut.inertia.absent == ds.inertia.absent and set(cut.data_vars) == set(ds.data_vars)
    assert whole(cut).sizes["time"] == 2 and bool(whole(cut)["density_max"].isnull().all())
    xr.testing.assert_identical(without_absent(whole(cut)), cut)


def test_one_label_may_be_chosen_where_something_along_it_was_left_out(file: Path) -> None:
    ds = astroinertia.open(file)
    last = ds.isel(time=-1).inertia
    np.testing.assert_array_equal(last.about_axis("z"), ds.inertia.about_axis("z")[-1:])
    assert last.dataset["density_max"].isnull().all() and last.rotation_limits()["period"].shape == (1,)
    for chosen in (ds.isel(principal=0), whole(ds).sel(mode=2), whole(ds).isel(effect=0)):
        np.testing.assert_array_equal(chosen.inertia.about_axis("z"), ds.inertia.about_axis("z"))
        assert chosen.inertia.absent == ds.inertia.absent


def test_a_dataset_that_lacks_nothing_is_left_as_it_is() -> None:
    data = xr.Dataset({"mass": ("time", np.ones(3))}, {"time": np.arange(3.0), "label": ("other", [1, 2])})
    assert without_absent(data) is data and whole(data) is data


def test_faint_waves_are_those_that_stay_below_the_limit() -> None:
    assert too_faint(np.full(3, 0.9 * FAINTEST), np.zeros(3))
    assert not too_faint(np.array([0.0, 1.1 * FAINTEST]), np.zeros(2))
    assert not too_faint(np.full(3, np.nan), np.zeros(3))  # not known, for another reason
