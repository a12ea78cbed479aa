"""Exported files: every bit of the dataset, the meaning that each format gives to it, and messages of wrong calls."""

import csv
import re
import sys
import xml.etree.ElementTree as xml
from dataclasses import replace

import h5py
import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad

from astroinertia import dataset
from astroinertia.cli.main import main
from astroinertia.errors import ArchiveError, SceneError, SceneWarning
from astroinertia.interop import swift
from astroinertia.interop.export import FORMATS, SNAPSHOT_FORMATS, export
from astroinertia.interop.snapshots import snapshots_of
from astroinertia.interop.tables import series_columns
from astroinertia.sph.kernels import KERNELS
from astroinertia.sph.table import read_table
from astroinertia.storage.archive import Archive
from astroinertia.studies.moments import moments, read_matter
from tests.unit.affine_body import METADATA, affine_run

STRAY = 7  # a particle that a sink has accreted in the last snapshot


def finished(folder, metadata):
    records, snapshots = affine_run(outputs=12, particles=64)
    last = {name: np.array(values) for name, values in snapshots[-1].items()}
    for name in set(last) - {"time"}:
        last[name][STRAY] = np.nan
    with Archive.create(folder, METADATA | metadata) as archive:
        archive.write_segment(records, [*snapshots[:-1], last])
        dataset.finish(archive)
    return folder


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A finished run of 13 snapshots, not all particles of which are in the last."""
    return finished(tmp_path_factory.mktemp("affine"), {"kernel": "wendland_c2"})


@pytest.fixture(scope="module")
def one(run):
    """The snapshot with number 5."""
    return dataset.open_snapshots(run).isel(snapshot_time=5).load()


def expected(one):
    return {
        "Coordinates": one["position"].transpose("particle", "i"),
        "Velocities": one["velocity"].transpose("particle", "i"),
        "Masses": one["mass"],
        "InternalEnergy": one["internal_energy"],
        "Density": one["density"],
        "KernelScale": one["smoothing_length"],
        "SmoothingLength": 2.0 * one["smoothing_length"],  # the support of Wendland's kernels: no bit is lost
    }


SWIFT_NAMES = {
    "Coordinates": "Coordinates",
    "Velocities": "Velocities",
    "Masses": "Masses",
    "InternalEnergy": "InternalEnergies",
    "Density": "Densities",
    "KernelScale": "KernelScales",
}


# yt takes these for granted of a GADGET file, and passes over what the file says: kpc, 10^10 solar masses, km/s.
KPC, SUNS, GIGAYEAR = 3.0856775809623245e19, 1.98841586e40, 1e9 * 31557600.0


def test_gadget_has_the_default_units_in_full_precision(run, one, tmp_path):
    (path,) = export(run, "gadget", "5", tmp_path / "snap_005.hdf5")
    unit = {"Coordinates": KPC, "Velocities": 1e3, "Masses": SUNS, "InternalEnergy": 1e6, "Density": SUNS / KPC**3}
    with h5py.File(path) as file:
        gas = file["PartType0"]
        for name, values in expected(one).items():
            assert gas[name].dtype == np.float64
            np.testing.assert_allclose(gas[name][:] * unit.get(name, KPC), values.values, rtol=2e-15, err_msg=name)
        assert gas["ParticleIDs"][:].tolist() == list(range(1, 65))
        header = file["Header"].attrs
        assert header["NumPart_ThisFile"].tolist() == header["NumPart_Total"].tolist() == [64, 0, 0, 0, 0, 0]
        assert header["Time"] * (KPC / 1e3) == pytest.approx(float(one["snapshot_time"]), rel=1e-14)
        assert header["MassTable"].tolist() == [0.0] * 6
        assert header["BoxSize"] == file["Parameters"].attrs["BoxSize"] == 0.0
        assert header["Flag_DoublePrecision"] == 1  # for readers that ask it, not the type of the fields
        parameters = file["Parameters"].attrs
        assert parameters["Time_GYR"] * GIGAYEAR == pytest.approx(float(one["snapshot_time"]), rel=1e-14)
        constant = parameters["GravityConstantInternal"] * KPC / SUNS * 1e6
        assert constant == pytest.approx(METADATA["code_units"]["G"], rel=1e-14)


def test_swift_has_every_bit(run, one, tmp_path):
    (path,) = export(run, "swift", "5", tmp_path / "snap_0005.hdf5")
    with h5py.File(path) as file:
        gas, values = file["PartType0"], expected(one)
        for name, written in SWIFT_NAMES.items():
            np.testing.assert_array_equal(gas[written][:], values[name].values, err_msg=name)
        assert file["Header"].attrs["Time"].tolist() == [float(one["snapshot_time"])]
        assert file["Header"].attrs["NumPart_ThisFile"][0] == 64
        widest = 2.0 * float(np.abs(one["position"]).max())  # a box about the origin, which is not periodic
        assert file["Header"].attrs["BoxSize"].tolist() == [widest] * 3
        assert file["Parameters"].attrs["InitialConditions:periodic"] == b"0"
        assert file["Header"].attrs["CanHaveTypes"].tolist() == [1, 0, 0, 0, 0, 0, 0]  # gas is the first
        assert gas["Velocities"].attrs["U_t exponent"].tolist() == [-1.0]  # of a unit of 1 that hides its sign
        assert file["PhysicalConstants"].attrs["newton_G"].tolist() == [METADATA["code_units"]["G"]]
        # SWIFT's h times its gamma of this kernel is the radius of the support
        support = gas["SmoothingLengths"][:] * 1.936492
        np.testing.assert_allclose(support, 2.0 * one["smoothing_length"], rtol=1e-15)


@pytest.mark.parametrize("name", KERNELS)
def test_swift_measures_kernels_by_their_standard_deviation(name):
    kernel = KERNELS[name]
    w = lambda q: kernel.w(np, q)  # noqa: E731
    norm, second = (quad(lambda q, p=p: q**p * w(q), 0, kernel.support, limit=200)[0] for p in (2, 4))
    assert swift.KERNELS[name][1] == pytest.approx(kernel.support / (2.0 * np.sqrt(second / norm / 3.0)), abs=1e-6)


def test_units_of_every_field_follow_from_its_dimension(run, tmp_path):
    cgs = {"Coordinates": 1e2, "Velocities": 1e2, "Masses": 1e3, "InternalEnergy": 1e4, "Density": 1e-3, "Pressure": 10}
    unit = {"Coordinates": KPC, "Velocities": 1e3, "Masses": SUNS, "InternalEnergy": 1e6, "Density": SUNS / KPC**3}
    unit["Pressure"] = unit["Density"] * 1e6
    with h5py.File(export(run, "gadget", "0", tmp_path)[0]) as file:
        units = file["Parameters"].attrs
        for name, from_si in cgs.items():
            factor = unit[name] * from_si
            attrs = file["PartType0"][name].attrs
            powers = {"length": "UnitLength_in_cm", "mass": "UnitMass_in_g", "velocity": "UnitVelocity_in_cm_per_s"}
            assert attrs["to_cgs"] == pytest.approx(factor), name
            product = np.prod([units[unit] ** attrs[f"{kind}_scaling"] for kind, unit in powers.items()])
            assert product == pytest.approx(factor), name
            # As pynbody reads it: powers up to the next blank, the last character left out
            described = {"U_L": "length", "U_M": "mass", "U_V": "velocity"}
            found = re.findall(r"(U_[LMV])(?:\^(-?\d+))? ", attrs["VarDescription"][:-1])
            product = np.prod([units[powers[described[unit]]] ** float(power or 1) for unit, power in found])
            assert product == pytest.approx(attrs["CGSConversionFactor"]) == factor, name
            assert attrs["aexp-scale-exponent"] == attrs["h-scale-exponent"] == 0.0
    plural = SWIFT_NAMES | {"Pressure": "Pressures"}
    with h5py.File(export(run, "swift", "0", tmp_path)[0]) as file:
        units = file["Units"].attrs
        powers = {"L": "length in cgs (U_L)", "M": "mass in cgs (U_M)", "t": "time in cgs (U_t)"}
        for name, factor in cgs.items():
            attrs = file["PartType0"][plural[name]].attrs
            product = np.prod([units[f"Unit {unit}"] ** attrs[f"U_{kind} exponent"] for kind, unit in powers.items()])
            assert product == pytest.approx(factor), name


@pytest.mark.parametrize(("to", "near"), [("gadget", 1e-15), ("swift", 0.0), ("csv", 0.0)])
def test_what_is_written_is_read_back_and_bit_for_bit_where_it_is_in_si(run, one, tmp_path, to, near):
    (path,) = export(run, to, "5", tmp_path)
    table = read_table(path)
    assert table.units == "SI"
    np.testing.assert_allclose(table.mass, one["mass"], rtol=near)
    np.testing.assert_allclose(table.position, one["position"].transpose("particle", "i"), rtol=near)
    np.testing.assert_allclose(table.velocity, one["velocity"].transpose("particle", "i"), rtol=near)
    np.testing.assert_allclose(table.internal_energy, one["internal_energy"], rtol=near)
    own, exported = moments(read_matter(run, snapshot=5)), moments(read_matter(path))
    size = float(own["inertia_tensor"].max())
    np.testing.assert_allclose(own["inertia_tensor"], exported["inertia_tensor"], rtol=0, atol=4 * near * size)
    assert exported["inertia_tensor"].attrs["units"] == "kg m2"


def test_accreted_particles_are_left_out_and_the_others_keep_their_numbers(run, tmp_path):
    (path,) = export(run, "gadget", output=tmp_path)
    with h5py.File(path) as file:
        gas = file["PartType0"]
        assert gas["ParticleIDs"][:].tolist() == [k + 1 for k in range(64) if k != STRAY]
        assert {values.shape[0] for values in gas.values()} == {63}
        assert all(np.isfinite(values[:]).all() for values in gas.values())


@pytest.mark.full
def test_a_dimensionless_run_says_that_it_has_no_units(tmp_path):
    folder = finished(tmp_path / "plain", {"dimensionless": True, "kernel": "quintic"})
    bare = dataset.open_snapshots(folder).isel(snapshot_time=0).load()
    for to in ("gadget", "swift", "csv"):
        (path,) = export(folder, to, "0")
        table = read_table(path)
        assert table.units == (None if to == "csv" else "unknown")
        np.testing.assert_array_equal(table.mass, bare["mass"])
    with h5py.File(folder / "plain_swift_000.hdf5") as file:
        units = file["Units"].attrs
        assert units["Unit length in cgs (U_L)"].tolist() == units["Unit mass in cgs (U_M)"].tolist() == [1.0]
    with h5py.File(folder / "plain_gadget_000.hdf5") as file:
        parameters = file["Parameters"].attrs
        assert parameters["GravityConstantInternal"] == 1.0
        assert parameters["UnitLength_in_cm"] == parameters["UnitMass_in_g"] == 1.0  # as files without units have it
        np.testing.assert_array_equal(file["PartType0/SmoothingLength"], 3.0 * bare["smoothing_length"])


@pytest.mark.parametrize("dimensionless", [False, True])
def test_the_units_of_swift_agree_with_those_of_its_fields(tmp_path, dimensionless):
    folder = finished(tmp_path / "star", {"dimensionless": dimensionless})
    with h5py.File(export(folder, "swift", "0")[0]) as file:
        units = {name.split("(")[1][:-1]: value[0] for name, value in file["Units"].attrs.items()}
        for field in file["PartType0"].values():
            factors = [units[name] ** field.attrs[f"{name} exponent"][0] for name in ("U_M", "U_L", "U_t")]
            for kind in ("CGS (not including", "physical CGS (including"):
                stated = field.attrs[f"Conversion factor to {kind} cosmological corrections)"][0]
                assert stated == pytest.approx(np.prod(factors), rel=1e-14)


def test_the_box_of_a_periodic_run_is_reported(tmp_path):
    scene = 'name = "b"\n[box]\nlengths = ["2 km", "2 km", "2 km"]\n'
    folder = finished(tmp_path / "boxed", {"scene": scene})
    with h5py.File(export(folder, "gadget", "0")[0]) as file:
        assert file["Header"].attrs["BoxSize"] * KPC == pytest.approx(2000.0, rel=1e-14)
        assert file["Parameters"].attrs["BoxSize"] == file["Header"].attrs["BoxSize"]
        assert "SmoothingLength" not in file["PartType0"]  # the kernel is not known, and so not where it ends
    with h5py.File(export(folder, "swift", "0")[0]) as file:
        assert file["Header"].attrs["BoxSize"].tolist() == [2000.0] * 3
        assert file["Parameters"].attrs["InitialConditions:periodic"] == b"1"


def test_a_box_that_repeats_itself_along_one_axis_is_none_of_other_codes(tmp_path):
    scene = 'name = "b"\n[box]\nlengths = ["2 km", "2 km", "2 km"]\nperiodic = "x"\n'
    assert next(snapshots_of(finished(tmp_path / "slab", {"scene": scene}), "0")).box is None


def test_a_box_that_is_no_cube_is_not_left_out_of_a_file_of_gadget_without_a_word(tmp_path):
    scene = 'name = "b"\n[box]\nlengths = ["2 km", "1 km", "1 km"]\n'
    folder = finished(tmp_path / "boxed", {"scene": scene})
    with pytest.warns(SceneWarning, match="the periodic box of the run is left out, for GADGET's are cubes"):
        (path,) = export(folder, "gadget", "0")
    with h5py.File(path) as file:
        assert file["Header"].attrs["BoxSize"] == 0.0
    with h5py.File(export(folder, "swift", "0")[0]) as file:
        assert file["Header"].attrs["BoxSize"].tolist() == [2000.0, 1000.0, 1000.0]


def vtp(path):
    """Arrays of a .vtp file by name, by the letter of the format: little endian, after a length of 8 bytes each."""
    head, _, rest = path.read_bytes().partition(b'<AppendedData encoding="raw">_')
    root = xml.fromstring(head + b"</VTKFile>")
    kinds = {"Float64": "<f8", "Int64": "<i8", "Int32": "<i4", "UInt64": "<u8"}
    found = {}
    for each in root.iter("DataArray"):
        if each.get("format") == "appended":
            start = int(each.get("offset"))
            size = int(np.frombuffer(rest, "<u8", 1, start)[0])
            values = np.frombuffer(rest[start + 8 : start + 8 + size], kinds[each.get("type")])
            found[each.get("Name")] = values.reshape(-1, int(each.get("NumberOfComponents", 1)))
    return root, found


def test_paraview_files_hold_every_bit_and_their_times(run, one, tmp_path):
    files = export(run, "vtk", "all", tmp_path / "film")
    root, found = vtp(files[5])
    np.testing.assert_array_equal(found["Points"], one["position"].transpose("particle", "i"))
    np.testing.assert_array_equal(found["velocity"], one["velocity"].transpose("particle", "i"))
    np.testing.assert_array_equal(found["density"][:, 0], one["density"])
    assert found["connectivity"][:, 0].tolist() == list(range(64))
    assert found["offsets"][:, 0].tolist() == list(range(1, 65))
    assert root.find(".//Piece").get("NumberOfPoints") == root.find(".//Piece").get("NumberOfVerts") == "64"
    assert float(root.find(".//FieldData/DataArray").text) == float(one["snapshot_time"])
    steps = xml.parse(files[-1]).findall(".//DataSet")
    assert [each.get("file") for each in steps] == [each.name for each in files[:-1]]
    times = dataset.open_snapshots(run)["snapshot_time"].values.tolist()
    assert [float(each.get("timestep")) for each in steps] == times


def test_the_headline_series_as_flat_columns(run, tmp_path):
    (path,) = export(run, "csv", output=tmp_path / "series.csv")
    with pytest.raises(SceneError, match=r"series of a run.*; with --snapshot last it writes a particle table"):
        read_matter(path)
    with path.open(newline="") as stream:
        names, *rows = csv.reader(stream)
    columns = dict(zip(names, np.array(rows, dtype=float).T, strict=True))
    opened = dataset.open(run)
    np.testing.assert_array_equal(columns["time [s]"], opened["time"])
    np.testing.assert_array_equal(
        columns["inertia_tensor_x_z [kg m2]"], opened["inertia_tensor"].sel(i="x", j="z").values
    )
    np.testing.assert_array_equal(columns["torque_tide_y [N m]"], opened["torque"].sel(effect="tide", i="y").values)
    np.testing.assert_array_equal(columns["principal_moments_2 [kg m2]"], opened["principal_moments"].sel(principal=2))
    absent = [
        name for name in names if name.startswith("jeans_ratio")
    ]  # not recorded: a column of NaN would say nothing
    assert not absent and opened["jeans_ratio"].isnull().all()


def test_columns_of_a_sweep_say_what_each_member_has():
    radii = [1.5e6, 2e6]
    of_members = xr.DataArray(np.arange(6.0).reshape(2, 3), dims=("body.radius", "time"), attrs={"units": "kg"})
    tensor = xr.DataArray(np.ones((2, 3, 3, 3)), dims=("body.radius", "time", "i", "j"), attrs={"units": "kg m2"})
    sweep = xr.Dataset({"mass": of_members, "inertia_tensor": tensor}).assign_coords(
        {"time": ("time", np.arange(3.0), {"units": "s"}), "body.radius": ("body.radius", radii, {"units": "m"})}
    )
    columns = dict(series_columns(sweep))
    np.testing.assert_array_equal(columns["mass_body.radius=2000000.0 m [kg]"], [3.0, 4.0, 5.0])
    assert "inertia_tensor_body.radius=1500000.0 m_0_2 [kg m2]" in columns


def test_columns_of_a_sample_have_the_values_of_each_member():
    tensor = xr.DataArray(np.ones((2, 3, 3, 3)), dims=("member", "time", "i", "j"), attrs={"units": "kg m2"})
    sample = xr.Dataset({"inertia_tensor": tensor}).assign_coords(
        time=("time", np.arange(3.0), {"units": "s"}), member=[0, 1], failure=("member", ["", ""]),
        body_radius=("member", [1.5e6, 2e6], {"units": "m"}), model=("member", ["sph", "rigid"]),
    )  # fmt: skip
    columns = dict(series_columns(sample))
    assert list(columns)[:3] == ["time [s]", "body_radius_member=0 [m]", "body_radius_member=1 [m]"]
    np.testing.assert_array_equal(columns["body_radius_member=1 [m]"], [2e6, 2e6, 2e6])
    assert columns["model_member=1 [1]"].tolist() == ["rigid"] * 3
    assert not any(name.startswith("failure") for name in columns)


@pytest.mark.slow
def test_zarr_holds_the_whole_tree(run, tmp_path):
    pytest.importorskip("zarr", reason="needs the extra zarr")
    (path,) = export(run, "zarr", output=tmp_path / "run.zarr")
    tree = dataset.open_tree(run)
    with xr.open_datatree(path, engine="zarr") as found:
        xr.testing.assert_identical(found.to_dataset().load(), tree.to_dataset().load())
        snapshots = found["snapshots"].to_dataset()
        assert snapshots["position"].encoding["chunks"][0] == 1  # a reader of one snapshot reads nothing else
        xr.testing.assert_identical(snapshots.load(), tree["snapshots"].to_dataset().load())
    assert [each.name for each in tmp_path.iterdir()] == ["run.zarr"]
    with pytest.raises(ArchiveError, match="it is a Zarr store, which xarray"):
        dataset.open(path)


def test_a_zarr_store_that_another_export_has_written_meanwhile_stays_as_it_is(run, tmp_path, monkeypatch):
    pytest.importorskip("zarr", reason="needs the extra zarr")
    path, begun = tmp_path / "run.zarr", []

    def to_zarr(tree, store, **_):
        begun.append(store)
        store.mkdir()
        if len(begun) == 1:
            export(run, "zarr", output=path)
        (store / "writer").write_text(store.parent.name)

    monkeypatch.setattr(xr.DataTree, "to_zarr", to_zarr)
    with pytest.raises(ArchiveError, match="is there already"):
        export(run, "zarr", output=path)
    assert [each.name for each in tmp_path.iterdir()] == ["run.zarr"]
    assert (path / "writer").read_text() == begun[1].parent.name
    (tmp_path / "folder").mkdir()
    assert path.stat().st_mode == (tmp_path / "folder").stat().st_mode  # others may read it as they may any folder


def test_a_quantity_that_is_not_known_of_every_particle_is_left_out(tmp_path):
    records, snapshots = affine_run(outputs=12, particles=64)
    partly = np.where(np.arange(64) == STRAY, np.nan, snapshots[0]["density"])
    with Archive.create(tmp_path / "run", METADATA) as archive:
        archive.write_segment(records, [snapshots[0] | {"density": partly}])
        dataset.finish(archive)
    (first,) = snapshots_of(tmp_path / "run", "0")
    assert "density" not in first.arrays and first.arrays["mass"].shape == (64,)


def test_files_in_another_order_of_dimensions_have_the_same_particles(run, tmp_path):
    tree = dataset.open_tree(run).load()
    tree["snapshots"] = tree["snapshots"].to_dataset().transpose("i", "particle", "snapshot_time", ...)
    tree.to_netcdf(tmp_path / "turned.nc")
    (turned,), (one,) = snapshots_of(tmp_path / "turned.nc", "5"), snapshots_of(run, "5")
    assert turned.arrays.keys() == one.arrays.keys()
    np.testing.assert_array_equal(turned.arrays["position"], one.arrays["position"])


def test_snapshots_are_chosen_by_number_from_either_end(run):
    assert [each.number for each in snapshots_of(run, "all")] == list(range(13))
    assert [each.number for each in snapshots_of(run, "last")] == [12]
    assert [each.number for each in snapshots_of(run, "-2")] == [11]
    assert [each.number for each in snapshots_of(run, "-13")] == [0]


def test_the_command_says_what_it_wrote_and_help_names_every_format(run, tmp_path, capsys):
    assert main(["export", str(run), "--to", "vtk", "--snapshot", "3", "--output", str(tmp_path)]) == 0
    assert capsys.readouterr().out == f"wrote {tmp_path / run.name}_003.vtp\n"
    with pytest.raises(SystemExit):
        main(["export", "--help"])
    printed = capsys.readouterr().out
    assert all(f"\n  {name} " in printed for name in FORMATS)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--to", "hdf4"], "the formats are gadget, swift, vtk, csv, zarr, not 'hdf4'"),
        (["--to", "gadget", "--snapshot", "13"], "has 13 snapshots, numbered from 0: there is no 13"),
        (["--to", "gadget", "--snapshot=-14"], "has 13 snapshots, numbered from 0: there is no -14"),
        (["--to", "gadget", "--snapshot", "first"], "--snapshot takes a number from 0, last or all, not 'first'"),
        (["--to", "gadget", "--snapshot", "all", "--output", "OUT/a.hdf5"], "writes several; give a folder"),
        (["--to", "gadget", "--output", "OUT/a.h5"], "does not end in .hdf5, nor is it a folder"),
        (["--to", "gadget", "--output", "OUT/none/such/a.hdf5"], "there is no folder"),
        (["--to", "csv", "--output", "OUT/there.csv"], "is there already and is left as it is"),
        (["--to", "zarr", "--snapshot", "1"], "zarr takes the whole dataset"),
    ],
)
def test_wrong_calls_get_one_sentence_and_write_nothing(run, tmp_path, capsys, arguments, sentence):
    (tmp_path / "there.csv").write_text("mine")
    assert main(["export", str(run), *(each.replace("OUT", str(tmp_path)) for each in arguments)]) == 2
    printed = capsys.readouterr()
    assert sentence in printed.err and printed.err.count("\n") == 1 and not printed.out
    assert [each.name for each in tmp_path.iterdir()] == ["there.csv"]
    assert (tmp_path / "there.csv").read_text() == "mine"


def test_numbers_of_materials_stay_whole(run, tmp_path):
    (one,) = snapshots_of(run, "0")
    kinds = np.arange(64) % 3
    several = replace(one, arrays=one.arrays | {"material": kinds})
    for to, path in (("gadget", tmp_path / "g.hdf5"), ("swift", tmp_path / "s.hdf5")):
        SNAPSHOT_FORMATS[to].write(several, path)
        with h5py.File(path) as file:
            assert file["PartType0/MaterialIDs"].dtype == np.int32
            assert file["PartType0/MaterialIDs"][:].tolist() == kinds.tolist()
    with h5py.File(tmp_path / "g.hdf5") as file:
        described = file["PartType0/MaterialIDs"].attrs
        assert described["VarDescription"] == "Physical, in no unit ." and described["CGSConversionFactor"] == 1.0
    SNAPSHOT_FORMATS["vtk"].write(several, tmp_path / "v.vtp")
    root, _ = vtp(tmp_path / "v.vtp")
    assert root.find(".//PointData/DataArray[@Name='material']").get("type") == "Int64"


@pytest.mark.parametrize(("to", "package", "extra"), [("gadget", "h5py", "hdf5"), ("zarr", "zarr", "zarr")])
def test_a_missing_package_is_named_with_what_installs_it(run, tmp_path, monkeypatch, capsys, to, package, extra):
    monkeypatch.setitem(sys.modules, package, None)  # as if it were not installed
    assert main(["export", str(run), "--to", to, "--output", str(tmp_path)]) == 2
    printed = capsys.readouterr().err
    assert "need" in printed and f"pip install 'astroinertia[{extra}]'" in printed and printed.count("\n") == 1
    assert not any(tmp_path.iterdir())


def test_a_model_without_particles_has_no_snapshots_to_export(tmp_path, capsys):
    records, _ = affine_run(outputs=12, particles=64)
    with Archive.create(tmp_path / "bare", METADATA) as archive:
        archive.write_segment(records, [])
        dataset.finish(archive)
    assert main(["export", str(tmp_path / "bare"), "--to", "swift"]) == 2
    assert "has no snapshots of particles (its model is ellipsoid)" in capsys.readouterr().err
