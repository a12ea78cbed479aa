"""From records to SI and netCDF and back: the schema, conversion by hand, derived identities, old files."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from astropy import units

from astroinertia import dataset
from astroinertia.dataset import accessor
from astroinertia.dataset.derived import BAR
from astroinertia.dataset.radii import RATIOS
from astroinertia.dataset.schema import SNAPSHOT, SNAPSHOT_TIME, TIME_QUANTITY
from astroinertia.errors import ArchiveError
from astroinertia.observables.quantities import DERIVED, RECORDED
from astroinertia.plots.in_words import summary
from astroinertia.storage.archive import Archive
from tests.unit.affine_body import EFFECTS, METADATA, SOLAR_MASS, AffineBody, G, affine_run

DATA = Path(__file__).parents[2] / "data"
MASS, LENGTH = 1.4 * SOLAR_MASS, 1.5e6
TIME = np.sqrt(LENGTH**3 / (G * MASS))

RESOLUTION = ("core_particles", "jeans_ratio", "smoothing_to_thickness")


def stacked(records):
    return {name: np.stack([np.asarray(record[name]) for record in records]) for name in records[0]}


def written(folder, records, snapshots, metadata=METADATA, segments=3):
    with Archive.create(folder, metadata) as archive:
        for part in range(segments):
            archive.write_segment(records[part::segments][: len(records)], snapshots[part::segments])
        return dataset.finish(archive)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A finished run folder, its segments in order of time."""
    records, snapshots = affine_run()
    folder = tmp_path_factory.mktemp("run")
    with Archive.create(folder, METADATA) as archive:
        archive.write_segment(records[:50], snapshots[:5])
        archive.write_segment(records[50:51], [])
        archive.write_segment(records[51:], snapshots[5:])
        archive.write_checkpoint({}, {})
        dataset.finish(archive)
    return folder


@pytest.fixture(scope="module")
def opened(run):
    return dataset.open(run)


def test_every_quantity_of_the_schema_is_there_with_unit_and_name(run):
    with xr.open_dataset(run / "affine_star.nc") as plain:
        for name, quantity in (RECORDED | DERIVED).items():
            assert plain[name].dims == quantity.dims, name
            assert plain[name].attrs["units"] == quantity.unit, name
            assert plain[name].attrs["long_name"], name
            assert plain[name].notnull().any() or plain[name].attrs["reason"], name
        assert plain["time"].dtype == np.float64
        assert plain["time"].attrs["units"] == "s"
        assert list(plain["effect"].values) == EFFECTS
        assert list(plain["i"].values) == ["x", "y", "z"]
        assert plain.attrs["Conventions"] == "CF-1.11"
        assert plain.attrs["scene"] == METADATA["scene"]
        assert json.loads(plain.attrs["versions"]) == METADATA["versions"]
        assert plain.attrs["seed"] == 1
        assert plain.attrs["frame"] == "inertial"


def test_snapshots_are_a_group_of_the_tree(run):
    _, snapshots = affine_run()
    with xr.open_datatree(run / "affine_star.nc") as tree:
        group = tree["snapshots"]
        assert group["position"].dims == ("snapshot_time", "particle", "i")
        assert "material" not in group  # nothing is of several
        absent = {"electron_fraction", "density_factor"}  # nothing loses electrons, and densities are sums of masses
        assert not absent & set(group.data_vars)
        for name in SNAPSHOT.keys() - {"material", *absent}:
            assert group[name].attrs["units"] == SNAPSHOT[name].unit
            assert group[name].shape[:2] == (len(snapshots), 1600)
        expected = np.stack([snapshot["position"] for snapshot in snapshots]) * LENGTH
        np.testing.assert_array_equal(group["position"].values, expected)
        np.testing.assert_allclose(group["snapshot_time"].values, [s["time"] * TIME for s in snapshots], rtol=1e-14)
        assert tree.inertia.snapshots.sizes["particle"] == 1600


def test_units_and_exponents_of_the_table_agree():
    for name, quantity in (RECORDED | DERIVED | SNAPSHOT | {"time": TIME_QUANTITY, "shot": SNAPSHOT_TIME}).items():
        unit = units.Unit("" if quantity.unit == "1" else quantity.unit).decompose()
        assert unit.scale == 1.0, name
        powers = {base.name: power for base, power in zip(unit.bases, unit.powers, strict=True)}
        if quantity.dimension is not None:
            assert tuple(powers.get(base, 0) for base in ("kg", "m", "s")) == tuple(quantity.dimension), name


def test_code_units_become_si_by_hand(opened):
    record, first = affine_run()[0][7], opened.isel(time=7)
    energy = G * MASS**2 / LENGTH
    expected = {
        "mass": MASS,
        "inertia_tensor": record["inertia_tensor"] * MASS * LENGTH**2,
        "angular_momentum": record["angular_momentum"] * MASS * np.sqrt(G * MASS * LENGTH),
        "gravitational_energy": record["gravitational_energy"] * energy,
        "kinetic_tensor": record["kinetic_tensor"] * energy,
        "torque": record["torque"] * energy,
        "density_max": record["density_max"] * MASS / LENGTH**3,
        "rotation_profile": record["rotation_profile"] * np.sqrt(G * MASS / LENGTH**3),
        "specific_angular_momentum_profile": record["specific_angular_momentum_profile"] * np.sqrt(G * MASS * LENGTH),
        "momentum": record["momentum"],
        "radius_profile": record["radius_profile"] * LENGTH,
        "timestep": record["timestep"] * np.sqrt(LENGTH**3 / (G * MASS)),
        "wall_time": record["wall_time"],  # the computer's seconds
        "mode_amplitude": record["mode_amplitude"],
    }
    for name, value in expected.items():
        np.testing.assert_allclose(first[name].values, value, rtol=1e-13, err_msg=name)
    assert first["time"] == pytest.approx(record["time"] * np.sqrt(LENGTH**3 / (G * MASS)), rel=1e-14)


def test_a_dimensionless_scene_stays_as_it_is_and_says_so():
    metadata = {**METADATA, "dimensionless": True, "code_units": {"mass": 1.0, "length": 1.0, "G": 1.0}}
    records = affine_run()[0][:3]
    plain = dataset.headline(stacked(records), metadata)
    np.testing.assert_array_equal(plain["inertia_tensor"][2], records[2]["inertia_tensor"])
    assert {plain[name].attrs["units"] for name in ("time", "mass", "torque", "angular_velocity")} == {"1"}
    assert "G = 1" in plain.attrs["units_system"]
    assert plain["gw_strain_plus"].isnull().all()
    assert "speed of light" in plain["gw_strain_plus"].attrs["reason"]


def moving_records(times):
    """Records of x = A(t) X for a given A(t), with all the derivatives of I taken by automatic differentiation."""
    import jax
    import jax.numpy as jnp

    def matrix(t):
        turn = jnp.array([[jnp.cos(t), -jnp.sin(t), 0], [jnp.sin(t), jnp.cos(t), 0], [0, 0, 1.0]])
        return turn @ jnp.diag(jnp.stack([1 + 0.3 * jnp.sin(t), 0.8 + 0.1 * t**2, 0.5 * jnp.exp(-t)]))

    def inertia(t):
        second = 0.2 * matrix(t) @ matrix(t).T
        return jnp.trace(second) * jnp.eye(3) - second

    def derivatives(function):
        return jax.jit(lambda t: (function(t), jax.jacfwd(function)(t), jax.jacfwd(jax.jacfwd(function))(t)))

    records, rates, accelerations = [], [], []
    with jax.enable_x64(True):
        motion, moments = derivatives(matrix), derivatives(inertia)
        for t in times:
            a, da, dda = motion(t)
            tensor, rate, acceleration = moments(t)
            pull = jnp.array([[1.0, 2, 0], [0.5, -1, 0], [0, 0, 3]])  # any split of the motion's cause will do
            virials = 0.2 * jnp.stack([a @ (pull @ a).T, a @ (dda - pull @ a).T])
            mixed = 0.2 * a @ da.T
            records.append(
                {
                    "time": t,
                    "mass": 1.0,
                    "second_moment": 0.2 * a @ a.T,
                    "mixed_moment": mixed,
                    "kinetic_tensor": 0.2 * da @ da.T,
                    "virial_tensor": virials,
                    "inertia_tensor": tensor,
                    "angular_momentum": jnp.stack(
                        [mixed[1, 2] - mixed[2, 1], mixed[2, 0] - mixed[0, 2], mixed[0, 1] - mixed[1, 0]]
                    ),
                }
            )
            rates.append(rate)
            accelerations.append(acceleration)
        return jax.tree.map(np.asarray, (records, np.stack(rates), np.stack(accelerations)))


CODE = {"name": "moving", "dimensionless": True, "effects": ["one", "other"], "model": "ellipsoid"}


@pytest.mark.slow
def test_rate_and_acceleration_are_the_derivatives_of_the_inertia_tensor():
    records, rates, accelerations = moving_records([0.0, 0.3, 0.7, 1.1])
    found = dataset.headline(stacked(records), CODE)
    np.testing.assert_allclose(found["inertia_rate"], rates, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(found["inertia_acceleration"], accelerations, rtol=1e-12, atol=1e-13)
    # The figure turns at the rate 1 about z that the motion was made with, whatever the spin L/I is.
    z = int(np.argmax(abs(found["principal_axes"][0, :, 2].values)))
    np.testing.assert_allclose(abs(found["figure_rotation_rate"][:, z]), 1.0, rtol=1e-11)


@pytest.mark.slow
def test_shares_add_up_to_the_whole():
    records, _, accelerations = moving_records([0.2, 0.9])
    found = dataset.headline(stacked(records), CODE).inertia
    shares = found.acceleration_shares()
    assert list(shares["share"].values) == [accessor.MOTION, "one", "other"]
    np.testing.assert_allclose(shares.sum("share"), accelerations, rtol=1e-12, atol=1e-13)
    along = found.acceleration_shares("x").sum("share")
    np.testing.assert_allclose(along, accelerations[:, 0, 0], rtol=1e-12)
    virial = found.virial_shares().sum("share")
    np.testing.assert_allclose(virial, np.trace(accelerations, axis1=1, axis2=2) / 4, rtol=1e-12)


def test_derived_quantities_of_a_turning_ellipsoid(opened):
    body, first = AffineBody(), opened.isel(time=0)
    axes = np.diag(body.start) * LENGTH
    np.testing.assert_allclose(first["mean_radius"], axes.prod() ** (1 / 3), rtol=1e-12)
    squares = axes**2
    moments = MASS / 5 * (squares.sum() - squares)
    np.testing.assert_allclose(first["principal_moments"], np.sort(moments), rtol=1e-12)
    spin = first["angular_velocity"].values
    np.testing.assert_allclose(spin, np.array([0.05, 0, 0.32]) / TIME, rtol=1e-11, atol=1e-9)
    assert first["angular_speed"] == pytest.approx(np.hypot(0.05, 0.32) / TIME, rel=1e-11)
    assert first["angular_speed"].attrs["units"] == "rad s-1"
    energy = 0.5 * spin @ np.diag(moments) @ spin
    assert first["rotational_energy"] == pytest.approx(energy, rel=1e-12)
    assert first["rotational_to_gravitational"] == pytest.approx(
        energy / abs(first["gravitational_energy"].item()), rel=1e-12
    )
    axis = np.diag(moments) @ spin
    axis /= np.linalg.norm(axis)
    assert first["moment_ratio"] == pytest.approx(axis @ np.diag(moments) @ axis / (MASS * LENGTH**2), rel=1e-12)
    assert first["polar_radius"] == pytest.approx(np.sqrt(axis @ np.diag(squares) @ axis), rel=1e-12)
    assert first["moment_ratio"].attrs["reference_radius"] == LENGTH
    assert "mean radius" in first["moment_ratio"].attrs["radius_convention"]


def test_radii_of_a_spheroid_are_its_semi_axes():
    second = 0.2 * np.diag([4.0, 4.0, 1.0])
    record = {
        "time": 0.0,
        "mass": 1.0,
        "second_moment": second,
        "inertia_tensor": np.trace(second) * np.eye(3) - second,
    }
    found = dataset.headline(stacked([record]), CODE).isel(time=0)
    assert found["equatorial_radius"] == pytest.approx(2.0, rel=1e-14)
    assert found["polar_radius"] == pytest.approx(1.0, rel=1e-14)
    assert found["ellipsoid_flattening"] == pytest.approx(0.5, rel=1e-14)
    assert found["mean_radius"] == pytest.approx(4.0 ** (1 / 3), rel=1e-14)


def test_strain_of_a_turning_bar_is_that_of_the_textbook():
    """A rigid bar about z: h+ = (G/c^4) 4 omega^2 (I1 - I2) cos(2 omega t) up to sign and phase, on the pole."""
    mass, rate, axes = 2.0, 3.0, np.array([2.0, 1.0, 1.0])
    records = []
    for time in np.linspace(0.0, 1.0, 9):
        cosine, sine = np.cos(rate * time), np.sin(rate * time)
        turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
        second = turn @ np.diag(mass * axes**2 / 5) @ turn.T
        spin = np.array([[0, -rate, 0], [rate, 0, 0], [0, 0, 0]])
        records.append(
            {
                "time": time,
                "mass": mass,
                "second_moment": second,
                "inertia_tensor": np.trace(second) * np.eye(3) - second,
                "kinetic_tensor": spin @ second @ spin.T,
                "virial_tensor": (second @ (spin @ spin).T)[None],
            }
        )
    metadata = {
        **CODE,
        "dimensionless": False,
        "code_units": {"mass": 1e20, "length": 1.0, "G": G},  # waves of 1 kg are too faint to be kept
        "effects": ["spring"],
    }
    found = dataset.headline(stacked(records), metadata)
    phase = 2 * rate * found["time"] / np.sqrt(1 / (G * 1e20))
    size = -4 * rate**2 * G * 1e40 * mass * (axes[0] ** 2 - axes[1] ** 2) / 5 * G / 299792458.0**4
    np.testing.assert_allclose(
        found["gw_strain_plus"].sel(observer="polar"), size * np.cos(phase), atol=1e-12 * abs(size)
    )
    np.testing.assert_allclose(
        found["gw_strain_cross"].sel(observer="polar"), size * np.sin(phase), atol=1e-12 * abs(size)
    )
    # In the plane of the motion only half of the plus polarisation is left.
    np.testing.assert_allclose(
        found["gw_strain_plus"].sel(observer="equatorial"), size / 2 * np.cos(phase), atol=1e-12 * abs(size)
    )
    tilted = found.inertia.strain(0.0)
    np.testing.assert_allclose(tilted["plus"], found["gw_strain_plus"].sel(observer="polar"))


def test_absent_quantities_are_nan_and_say_why():
    record = {**affine_run()[0][0], "gravitational_energy": np.nan}
    del record["density_profile"]
    metadata = {**METADATA, "effects": ["rotating_frame", "pressure", "tide"]}
    del metadata["reference_radius"]
    found = dataset.headline(stacked([record]), metadata)
    reasons = {name: found[name].attrs["reason"] for name in found if "reason" in found[name].attrs}
    assert reasons == {
        "gravitational_energy": "the scene lists no gravity",
        "rotational_to_gravitational": "the scene lists no gravity",
        "density_profile": "the shells of an affine body are similar ellipsoids, not spheres",
        **dict.fromkeys(RESOLUTION, "there are no particles"),
        "mode_pattern_speed": "this model does not record it",
        "ring_mode_amplitude": "this model does not record it",
        "ring_mode_phase": "this model does not record it",
        **dict.fromkeys((name for name in found if str(name).startswith("gw_")), "the frame is not inertial"),
        "attitude": "only a rigid body has axes of its own",
        **dict.fromkeys(
            (name for name in found if str(name).startswith(("moment_ratio", "surface_"))),
            "the surface of the body is not known",
        ),
        **dict.fromkeys(("half_mass_radius", "radius_enclosing_99"), "the profile of the body is not known"),
        "enclosing_ellipsoid": "there are no particles",
    }
    assert all(found[name].isnull().all() for name in reasons)
    assert "rotating" in found.attrs["frame"]


def test_equal_moments_are_flagged_and_leave_the_figure_rotation_undefined():
    record = affine_run()[0][0]
    second = np.diag([1.0, 1.0 + 1e-4, 0.5])
    record = {**record, "second_moment": second, "inertia_tensor": np.trace(second) * np.eye(3) - second}
    found = dataset.headline(stacked([record]), {**METADATA, "model": "sph"}).isel(time=0)
    assert (found["principal_gap"] < found["principal_gap"].attrs["tolerance"]).values.tolist() == [True, True, False]
    assert np.isnan(found["figure_rotation_rate"]).values.tolist() == [False, False, True]


def test_a_run_in_progress_reads_like_the_finished_file(run, opened, tmp_path):
    folder = tmp_path / "copy"
    shutil.copytree(run, folder)
    (folder / "affine_star.nc").unlink()
    fresh = dataset.open(folder)
    xr.testing.assert_identical(fresh, opened)
    one, other = dataset.open_snapshots(folder), dataset.open_snapshots(run)
    assert one is not None
    assert other is not None
    xr.testing.assert_identical(one, other.load().transpose(*one.dims))
    assert fresh.inertia.snapshots.sizes == other.sizes
    other.close()


def test_a_damaged_segment_is_named_or_skipped(run, tmp_path):
    folder = tmp_path / "copy"
    shutil.copytree(run, folder)
    (folder / "affine_star.nc").unlink()
    (folder / "segment-000002.npz").write_bytes(b"rubbish")
    with pytest.raises(ArchiveError, match=r"segment-000002\.npz is damaged"):
        dataset.open(folder)
    with pytest.warns(UserWarning, match=r"segment-000002\.npz is damaged"):
        assert dataset.open(folder, damaged="skip").sizes["time"] == 120
    with pytest.raises(ArchiveError, match="reading only"):
        dataset.finish(Archive.view(folder))
    assert not (folder / "affine_star.nc").exists()


def test_quantities_that_the_schema_does_not_know_are_kept(tmp_path):
    records = [{**record, "novelty": np.ones(4)} for record in affine_run()[0][:2]]
    snapshots = [{**snapshot, "colour": np.ones((1600, 2))} for snapshot in affine_run()[1][:2]]
    path = written(tmp_path, records, snapshots)
    assert dataset.open(path)["novelty"].shape == (2, 4)
    with xr.open_dataset(path, group="snapshots") as group:
        assert group["colour"].dims == ("snapshot_time", "particle", "colour_0")


@pytest.mark.slow
def test_a_scene_without_effects_or_snapshots(tmp_path):
    record = {name: value for name, value in affine_run()[0][0].items() if name in ("time", "mass", "inertia_tensor")}
    path = written(tmp_path, [record], [], {**CODE, "effects": []}, segments=1)
    found = dataset.open(path)
    assert found.sizes["effect"] == 0
    assert found["virial_tensor"].attrs["units"] == "1"
    assert dataset.open_snapshots(path) is None
    assert found.inertia.snapshots is None
    assert set(dataset.open_tree(path).children) == set()


def test_whether_there_are_snapshots_is_asked_of_the_file_not_of_an_error(run, tmp_path, monkeypatch):
    record = {name: value for name, value in affine_run()[0][0].items() if name in ("time", "mass", "inertia_tensor")}
    without = written(tmp_path, [record], [], {**CODE, "effects": []}, segments=1)

    def refused(*_, **__):
        raise OSError(-101, "in words of another version")

    monkeypatch.setattr(xr, "open_dataset", refused)
    assert dataset.open_snapshots(without) is None
    with pytest.raises(ArchiveError, match="in words of another version"):
        dataset.open_snapshots(run)


DISK_FULL = """
import resource, signal, sys
from astroinertia import dataset
from astroinertia.storage.archive import Archive
from astroinertia.errors import ArchiveError

for size in (1000, 30000, 150000, 600000):  # of 616 kB
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
    try:
        with Archive.open(sys.argv[1]) as archive:
            dataset.finish(archive)
    except ArchiveError as error:
        print(error)
"""


@pytest.mark.slow
def test_a_disk_that_is_full_when_the_file_is_written_is_reported_and_the_rest_kept(run, tmp_path):
    shutil.copytree(run, tmp_path / "run")
    (tmp_path / "run" / "affine_star.nc").unlink()
    before = sorted(path.name for path in (tmp_path / "run").iterdir())
    done = subprocess.run(
        [sys.executable, "-B", "-c", DISK_FULL, str(tmp_path / "run")],
        capture_output=True, text=True, check=True, cwd=Path(__file__).parents[3],
    )  # fmt: skip
    lines = done.stdout.splitlines()
    assert len(lines) == 4 and all("affine_star.nc cannot be written" in line and "disk full" in line for line in lines)
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == before
    assert dataset.open(tmp_path / "run").equals(dataset.open(run / "affine_star.nc"))


def test_things_that_are_no_datasets_are_refused_by_one_sentence(tmp_path):
    (tmp_path / "junk.nc").write_bytes(b"\x89HDF junk")
    xr.Dataset({"a": 1}).to_netcdf(tmp_path / "other.nc")
    Archive.create(tmp_path / "empty", CODE).close()
    newer = xr.Dataset(attrs={"astroinertia_format": 99})
    newer.to_netcdf(tmp_path / "newer.nc")
    for name, text in {
        "junk.nc": "cannot be read as netCDF",
        "other.nc": "not one of this package",
        "nowhere.nc": "does not exist",
        "empty": "no output yet",
        "newer.nc": "newer version",
    }.items():
        with pytest.raises(ArchiveError, match=text):
            dataset.open(tmp_path / name)
    with pytest.raises(ArchiveError, match="holds no run"):
        dataset.open(tmp_path)
    with pytest.raises(ValueError, match="inertia_tensor"):
        xr.Dataset({"a": 1}).inertia  # noqa: B018


def test_a_damaged_result_of_a_run_says_how_it_is_written_again(run, tmp_path):
    """And only there: the same file by another name, or without its run, is nothing that the program can mend."""
    copy = tmp_path / "run"
    shutil.copytree(run, copy)
    whole = (copy / "affine_star.nc").read_bytes()
    for path in (copy / "affine_star.nc", copy / "copy.nc", tmp_path / "affine_star.nc"):
        path.write_bytes(whole[: len(whole) // 2])
        for ask in (dataset.open, dataset.open_snapshots):
            with pytest.raises(ArchiveError, match="ends before its time") as caught:
                ask(path)
            again = f"astroinertia resume {copy} writes it again."
            assert str(caught.value).endswith(again) == (path == copy / "affine_star.nc")
    with Archive.open(copy) as archive:
        dataset.finish(archive)
    assert dataset.open(copy).equals(dataset.open(run))


def test_a_long_scene_survives(tmp_path):
    text = "# é" + "x" * 70000
    path = written(tmp_path, affine_run()[0][:1], [], {**METADATA, "scene": text}, segments=1)
    assert dataset.open(path).attrs["scene"] == text


@pytest.mark.slow
def test_the_accessor_works_on_plain_xarray_in_a_fresh_interpreter(run):
    script = (
        "import sys, xarray as xr, astroinertia\n"
        "ds = xr.open_dataset(sys.argv[1])\n"
        "assert 'matplotlib' not in sys.modules\n"
        "print(ds.inertia.about_axis('z').attrs['units'], ds.inertia.snapshots.sizes['particle'])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(run / "affine_star.nc")],
        capture_output=True, text=True, check=False, cwd=Path(__file__).parents[3],
    )  # fmt: skip
    assert done.stdout == "kg m2 1600\n", done.stderr


def test_accessor_quantities_keep_coordinates_and_units(opened):
    found = opened.inertia
    z = found.about_axis("z")
    np.testing.assert_array_equal(z, opened["inertia_tensor"].sel(i="z", j="z"))
    np.testing.assert_allclose(found.about_axis([0, 0, 2.0]), z, rtol=1e-14)
    xr.testing.assert_equal(z["time"], opened["time"])
    np.testing.assert_allclose(found.radius_of_gyration("z"), np.sqrt(z / opened["mass"]))
    assert found.radius_of_gyration("z").attrs["units"] == "m"
    np.testing.assert_allclose(found.moment_ratio(LENGTH), opened["moment_ratio"], rtol=1e-13)
    np.testing.assert_allclose(np.trace(found.quadrupole, axis1=1, axis2=2), 0, atol=1e-14 * float(z.max()))
    torque = found.torque_shares("z")
    np.testing.assert_array_equal(torque, opened["torque"].sel(i="z"))
    assert list(found.principal["principal"].values) == [1, 2, 3]
    with pytest.raises(ValueError, match="an axis is"):
        found.about_axis("w")
    with pytest.raises(ValueError, match="scaling laws"):
        found.spin_scaling("guess")


def test_scaling_with_inertia_holds_while_nothing_pulls_on_the_spin(opened):
    found = opened.inertia
    rate, predicted = found.spin_rate(), found.spin_scaling("inertia")
    momentum = opened["angular_momentum"]
    kept = abs(np.linalg.norm(momentum, axis=1) / np.linalg.norm(momentum[0]) - 1) < 1e-3
    assert kept.sum() > 30
    np.testing.assert_allclose(rate[kept], predicted[kept], rtol=2e-3)
    by_radius = found.spin_scaling("radius")
    assert by_radius[0] == rate[0]
    assert abs(by_radius / rate - 1).max() > 0.1  # the body does not keep its shape


# Written when each format was new: the first outputs of `affine_run` with 20 particles, finished and unfinished.
@pytest.mark.parametrize("name", ["format_1.nc", "format_1_run", "format_2_run"])
def test_old_files_still_open(name):
    old = dataset.open(DATA / name)
    younger = {"attitude", "timestep_limit", "timestep_limit_radius", "timestep_limit_density"}  # came later
    younger |= {*RESOLUTION, "mode_pattern_speed", "ring_mode_amplitude", "ring_mode_phase", *BAR}
    younger |= {
        *list(RATIOS)[1:],
        *RATIOS.values(),
        "surface_polar_radius",
        "surface_flattening",
        "enclosing_ellipsoid",
    }
    younger |= {"zonal_harmonic_2", "gravity_coefficient", "angular_speed"}
    younger |= {"gw_luminosity", "gw_energy", "gw_angular_momentum", "gw_energy_spectrum", "gw_characteristic_strain"}
    assert set(RECORDED) | set(DERIVED) <= set(old.variables) | younger
    assert old.sizes["time"] == 3
    assert "flattening" in summary(old)
    if name == "format_1.nc":
        np.testing.assert_array_equal(old["ellipsoid_flattening"], old["flattening"])
    squares = np.array([1.0, 0.94, 0.84]) ** 2
    moments = 1.4 * 1.988409870698051e30 * 1.5e6**2 / 5 * (squares.sum() - squares)
    np.testing.assert_allclose(np.diag(old["inertia_tensor"][0]), moments, rtol=1e-12)
    np.testing.assert_allclose(old["time"], [0.0, 2.695548e-3, 5.391096e-3], rtol=1e-5)
    assert old.inertia.snapshots.sizes == {"snapshot_time": 2, "particle": 20, "i": 3}
    assert old.attrs["scene"] == "name = 'affine star'\n"
