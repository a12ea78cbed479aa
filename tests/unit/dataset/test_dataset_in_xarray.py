"""What analysts lean on: lazy opening, results that keep coordinates and attributes, astropy units, CF's attributes."""

import dask.array
import netCDF4
import numpy as np
import pytest
import xarray as xr
from astropy import units
from xarray.plot.utils import label_from_attrs

import astroinertia
from astroinertia import dataset
from astroinertia.dataset.schema import code_units
from astroinertia.errors import AbsentError, ArchiveError
from astroinertia.plots import style
from astroinertia.storage.archive import Archive
from tests.unit.affine_body import METADATA, affine_run


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    records, snapshots = affine_run(outputs=24, particles=64)
    folder = tmp_path_factory.mktemp("affine")
    with Archive.create(folder, METADATA) as archive:
        archive.write_segment(records, snapshots)
        dataset.finish(archive)
    return folder


@pytest.fixture(scope="module")
def opened(run):
    return astroinertia.open(run)


RESULTS = {
    "about_axis": lambda found: found.about_axis("y"),
    "radius_of_gyration": lambda found: found.radius_of_gyration(),
    "moment_ratio": lambda found: found.moment_ratio(1e6),
    "quadrupole": lambda found: found.quadrupole,
    "acceleration_shares": lambda found: found.acceleration_shares(),
    "shares along an axis": lambda found: found.acceleration_shares("z"),
    "virial_shares": lambda found: found.virial_shares(),
    "torque_shares": lambda found: found.torque_shares(),
    "spin_rate": lambda found: found.spin_rate(),
    "spin_scaling": lambda found: found.spin_scaling(),
    "strain": lambda found: found.strain(0.3)["plus"],
}


def test_a_path_may_begin_at_home(run, opened, monkeypatch):
    monkeypatch.setenv("HOME", str(run.parent))
    assert astroinertia.open(f"~/{run.name}").sizes == opened.sizes
    with pytest.raises(ArchiveError, match="~nobody-at-all/run does not exist"):
        astroinertia.open("~nobody-at-all/run")


def test_chunks_read_only_what_is_asked_for_and_the_same_numbers(run, opened):
    lazy = astroinertia.open(run, chunks={"time": 5})
    assert isinstance(lazy["inertia_tensor"].data, dask.array.Array)
    assert lazy["inertia_tensor"].chunks[0] == (5, 5, 5, 5, 5)
    for result in RESULTS.values():
        xr.testing.assert_identical(result(lazy.inertia), result(opened.inertia))
    assert isinstance(lazy.inertia.snapshots["position"].data, dask.array.Array)
    xr.testing.assert_identical(lazy.load(), opened)


@pytest.mark.slow
def test_particles_of_runs_that_were_put_together_are_never_those_of_another(run, opened, tmp_path):
    """xarray keeps the name of the first file alone: the particles of the second run are not known, not the first's."""
    records, snapshots = affine_run(outputs=24, particles=64)
    later = [{**record, "wall_time": record["wall_time"] + 0.1} for record in records]
    with Archive.create(tmp_path / "again", METADATA) as archive:
        archive.write_segment(later, [{**each, "position": -each["position"]} for each in snapshots])
        dataset.finish(archive)
    both = xr.concat([opened, astroinertia.open(tmp_path / "again")], "run")
    xr.testing.assert_identical(both.isel(run=0).inertia.snapshots, opened.inertia.snapshots)
    assert both.isel(run=1).inertia.snapshots is None
    with pytest.raises(AbsentError, match="no snapshots"):
        both.isel(run=1).inertia.plot_density()
    both.to_netcdf(tmp_path / "both.nc")
    assert astroinertia.open(tmp_path / "both.nc").isel(run=0).inertia.snapshots is None  # that file has none


@pytest.mark.parametrize(
    "cut",
    [
        lambda ds: ds.isel(time=slice(3, None, 5)),
        lambda ds: ds.isel(time=-1),
        lambda ds: ds.interp(time=np.linspace(0.0, float(ds.time[-1]), 7)),
        lambda ds: ds[["inertia_tensor", "mass"]],
        lambda ds: xr.concat([ds.isel(time=slice(0, 4)), ds.isel(time=slice(4, None))], "time", data_vars="minimal"),
    ],
)
def test_a_dataset_that_was_cut_or_interpolated_keeps_its_particles(cut, opened):
    with xr.set_options(keep_attrs=True):
        found = cut(opened)
    assert found.inertia.snapshots.sizes["particle"] == 64


@pytest.mark.slow
def test_a_lazy_tree_has_one_snapshot_a_chunk_and_can_be_opened_again(run):
    trees = [astroinertia.open_tree(run, chunks={}) for _ in range(3)]  # netCDF has crashed on files opened again
    for tree in trees:
        assert set(tree["snapshots"]["position"].chunks[0]) == {1}
        tree["snapshots"]["position"].sum().compute()
    xr.testing.assert_identical(trees[0].load(), astroinertia.open_tree(run).load())


def test_a_run_in_progress_opens_with_chunks_too(tmp_path, opened):
    records, snapshots = affine_run(outputs=24, particles=64)
    with Archive.create(tmp_path / "halfway", METADATA) as archive:
        archive.write_segment(records[:12], snapshots[:3])
    tree = astroinertia.open_tree(tmp_path / "halfway", chunks={})
    assert isinstance(tree["inertia_tensor"].data, dask.array.Array)
    assert tree["snapshots"]["position"].chunks[0] == (1, 1, 1)
    np.testing.assert_array_equal(tree["inertia_tensor"], opened["inertia_tensor"][:12])


@pytest.mark.parametrize("name", RESULTS)
def test_results_keep_coordinates_units_and_meaning(opened, name):
    member = opened.assign_coords(member=3, half=("time", np.arange(25) // 2)).isel(time=slice(4, 9))
    result = RESULTS[name](member.inertia)
    np.testing.assert_array_equal(result["time"], member["time"])
    assert result["time"].attrs == opened["time"].attrs
    assert result["member"] == 3
    assert result["half"].values.tolist() == [2, 2, 3, 3, 4]
    assert result.attrs["units"]
    assert result.attrs["long_name"]
    for dim in set(result.dims) - {"time"}:
        assert dim in result.coords


def test_quantities_have_astropy_units(opened):
    found = opened.inertia
    momentum = found.quantity("angular_momentum")
    np.testing.assert_allclose(momentum.to_value("erg s"), opened["angular_momentum"] * 1e7, rtol=1e-14)
    assert found.quantity(found.about_axis("z")).unit == units.kg * units.m**2
    assert found.quantity("ellipsoid_flattening").unit == units.dimensionless_unscaled
    for name, variable in opened.data_vars.items():
        if variable.dtype.kind == "f":  # every unit of the schema is one that astropy reads
            found.quantity(str(name))


def test_time_is_in_seconds_and_says_what_to_show_it_in(opened, tmp_path):
    times, factor, text = style.shown_times(opened)
    assert opened["time"].attrs["units"] == "s"
    assert (opened["time"].attrs["display_unit"], factor, text) == ("ms", 1e-3, "time (ms)")
    minutes = opened.assign_coords(time=opened["time"].assign_attrs(display_unit="min"))
    times, factor, text = style.shown_times(minutes)
    assert (factor, text) == (60.0, "time (min)")
    np.testing.assert_allclose(times, opened["time"] / 60.0)


def test_dimensionless_times_have_no_unit_to_show(tmp_path):
    records, _ = affine_run(outputs=24, particles=64)
    found = dataset.headline({name: np.stack([r[name] for r in records]) for name in records[0]},
                             METADATA | {"dimensionless": True})  # fmt: skip
    assert found["time"].attrs["units"] == "1"
    assert "display_unit" not in found["time"].attrs


def test_what_cf_asks_of_a_file_is_there(run):
    with xr.open_dataset(run / "affine_star.nc") as plain:
        assert plain.attrs["Conventions"] == "CF-1.11"
        assert all(plain.attrs[name] for name in ("title", "history", "source"))
        assert all(each.attrs.get("long_name") or each.attrs.get("standard_name") for each in plain.variables.values())
        assert all("units" in each.attrs for each in plain.data_vars.values())
        below = [label_from_attrs(plain[name]) for name in ("time", "frequency", "radius_bin", "mode", "principal")]
        assert [text for text in below if "\n" in text] == []  # below xarray's default axes a second line is cut
    with netCDF4.Dataset(
        run / "affine_star.nc"
    ) as file:  # labels as characters, the form that CF has had from the start
        assert {str(file[name].dtype) for name in ("i", "j", "effect", "snapshots/i")} == {"|S1"}


def test_what_follows_from_few_series_needs_no_others(opened):
    few = opened[["inertia_tensor", "angular_momentum"]]
    for name in ("about_axis", "quadrupole", "spin_rate"):
        whole, part = RESULTS[name](opened.inertia), RESULTS[name](few.inertia)
        np.testing.assert_allclose(part, whole, rtol=1e-12, atol=1e-14 * float(abs(whole).max()))
        assert part.attrs == whole.attrs
    np.testing.assert_allclose(few.inertia.spin_rate(True), opened.inertia.spin_rate(True), rtol=1e-12)


@pytest.mark.parametrize("name", ["inertia", "spin", "ledger", "shape", "energy"])
def test_a_picture_of_a_part_of_the_series_says_what_is_missing(opened, name):
    few = opened[["inertia_tensor", "angular_momentum"]]
    with pytest.raises(AbsentError, match=f"plot_{name} is drawn from all series .* missing: No variable named '"):
        getattr(few.inertia, f"plot_{name}")()


def test_a_picture_of_a_running_mean_begins_where_it_has_a_value(opened):
    mean = opened.rolling(time=5).mean()
    for name in ("inertia", "spin", "ledger"):
        getattr(mean.inertia, f"plot_{name}")()  # without a warning, which is an error here
    lines = mean.inertia.plot_inertia().axes[0].lines
    assert len(lines[0].get_xdata()) == opened.sizes["time"] - 4


@pytest.mark.parametrize(
    ("made", "way"),
    [
        (lambda ds: ds.groupby_bins("time", 4).mean(), lambda ds: ds.assign_coords(
            time_bins=[bin.mid for bin in ds["time_bins"].values]).rename(time_bins="time")),
        (lambda ds: ds.rename(time="t"), lambda ds: ds.rename(t="time")),
        (lambda ds: ds.assign_coords(n=("time", np.arange(25))).swap_dims(time="n"), lambda ds: ds.swap_dims(n="time")),
        (lambda ds: xr.concat([ds, ds], "run").stack(all=("run", "time")), lambda ds: ds.unstack("all")),
    ],
    ids=["bins", "renamed", "swapped", "stacked"],
)  # fmt: skip
def test_records_that_are_no_longer_along_time_are_refused_with_the_way_back(opened, made, way):
    """What the sentence says to do, after "ds", is what is done here, and it works."""
    with xr.set_options(keep_attrs=True):
        given = made(opened)
    with pytest.raises(ValueError, match="along") as caught:
        given.inertia  # noqa: B018
    said = str(caught.value).partition(" ds")[2].removesuffix(" has them").removesuffix(" has them so")
    again = eval(f"ds{said}", {"ds": given})
    xr.testing.assert_identical(again, way(given))
    assert np.isfinite(again.inertia.spin_rate()).all()


def test_particles_by_themselves_are_said_to_be_particles(run):
    with pytest.raises(ValueError, match=r"no inertia_tensor.*; these are particles: ask that of their run"):
        astroinertia.open_tree(run)["snapshots"].inertia  # noqa: B018


def test_records_and_snapshots_are_found_by_the_times_that_a_user_writes(tmp_path):
    records, snapshots = affine_run(outputs=24, particles=64)
    every = 0.1 / code_units(METADATA).time
    wanted = [number / 10 for number in range(24)]  # of which 0.3 is not 3 times 0.1
    with Archive.create(tmp_path / "run", METADATA) as archive:
        archive.write_segment(
            [record | {"time": number * every} for number, record in enumerate(records[:24])],
            [snapshot | {"time": number * every} for number, snapshot in enumerate(snapshots)],
        )
        file = dataset.finish(archive)
    assert astroinertia.open(file).sel(time=wanted).sizes["time"] == 24
    for tree in (astroinertia.open_tree(tmp_path / "run"), xr.open_datatree(file)):
        found = tree["snapshots"].to_dataset().sel(snapshot_time=wanted[: len(snapshots)])
        assert found.sizes["snapshot_time"] == len(snapshots)
