"""What `astroinertia moments` and the functions behind it say of tables, meshes and snapshots."""

import json

import numpy as np
import pytest
import xarray as xr
from astropy import units as u

from astroinertia import dataset
from astroinertia.cli.main import main
from astroinertia.errors import SceneError
from astroinertia.inertia.mesh import icosphere
from astroinertia.process.quantities import InputError
from astroinertia.storage.archive import Archive
from astroinertia.studies.moments import gravity_field, moments, read_matter
from astroinertia.units import SOLAR_MASS, SOLAR_RADIUS
from tests.unit.affine_body import METADATA, affine_run
from tests.unit.rigid_body import RIGID, rigid_run

BOX = np.array([[x, y, z] for x in (-1, 1) for y in (-2, 2) for z in (-3, 3)], float)


def write_table(path, mass, position):
    rows = [",".join(map(repr, map(float, (m, *x)))) for m, x in zip(mass, position, strict=True)]
    path.write_text("mass,x,y,z\n" + "\n".join(rows) + "\n")
    return path


@pytest.fixture
def box(tmp_path):
    """Eight masses of 1 at the corners of a box of 2 x 4 x 6 whose centre is at (10, 0, 0)."""
    return write_table(tmp_path / "box.csv", np.ones(8), BOX + [10.0, 0.0, 0.0])


def write_mesh(path, vertices, faces):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    path.write_text("\n".join(lines + [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]) + "\n")
    return path


def test_masses_at_the_corners_of_a_box(box):
    found = moments(read_matter(box))
    # 8 masses: I_x = 8 (2^2 + 3^2), and so on
    np.testing.assert_allclose(found["inertia_tensor"], np.diag([104.0, 80.0, 40.0]), atol=1e-13)
    np.testing.assert_allclose(found["principal_moments"], [40.0, 80.0, 104.0], rtol=1e-14)
    np.testing.assert_allclose(abs(found["principal_axes"]), np.eye(3)[::-1], atol=1e-14)
    np.testing.assert_allclose(found["principal_gap"], [40 / 104, 24 / 104, 24 / 104], rtol=1e-13)
    np.testing.assert_allclose(found["radius_of_gyration"], np.sqrt([5.0, 10.0, 13.0]), rtol=1e-14)
    np.testing.assert_allclose(found["moment_ratio"], np.array([40, 80, 104]) / (8 * 14), rtol=1e-13)
    np.testing.assert_allclose(found["semi_axes"], np.sqrt(5.0) * np.array([3.0, 2.0, 1.0]), rtol=1e-13)
    assert float(found["triaxiality"]) == pytest.approx((9 - 4) / (9 - 1))
    assert found["axis_defined"].values.all()
    np.testing.assert_allclose(found["centre_of_mass"], [10, 0, 0])


def test_about_a_point_everything_is_about_that_point(box):
    found = moments(read_matter(box), about=(10.0, 0.0, 5.0), axis=(0, 0, -2))
    np.testing.assert_allclose(np.diag(found["inertia_tensor"]), [104 + 200, 80 + 200, 40], rtol=1e-13)
    np.testing.assert_allclose(found["principal_moments"], [40, 280, 304], rtol=1e-13)
    assert float(found["axis_moment"]) == pytest.approx(40)
    assert float(found["axis_radius_of_gyration"]) == pytest.approx(np.sqrt(5))
    assert found["origin"].values.tolist() == [10, 0, 5]


def test_units_of_a_file_become_si(box):
    plain, found = moments(read_matter(box)), moments(read_matter(box, units=("Msun", "Rsun")))
    factor = SOLAR_MASS * SOLAR_RADIUS**2
    np.testing.assert_allclose(found["principal_moments"], plain["principal_moments"] * factor, rtol=1e-13)
    np.testing.assert_allclose(found["moment_ratio"], plain["moment_ratio"], rtol=1e-13)
    assert found["inertia_tensor"].attrs["units"] == "kg m2"
    assert plain["inertia_tensor"].attrs["units"] == "1"


@pytest.mark.parametrize(
    ("stretch", "defined", "triaxiality"),
    [
        ((1, 1, 1), [False, False, False], np.nan),
        ((2, 2, 1), [False, False, True], 0.0),
        ((1, 1, 2), [True, False, False], 1.0),
        ((1, 1, 0), [False, False, True], 0.0),  # a plate
        ((1, 0, 0), [True, False, False], 1.0),  # a rod
    ],
)
def test_axes_of_equal_moments_are_undefined(tmp_path, stretch, defined, triaxiality):
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float) * stretch
    found = moments(read_matter(write_table(tmp_path / "p.csv", np.ones(8), corners)))
    assert found["axis_defined"].values.tolist() == defined
    np.testing.assert_allclose(float(found["triaxiality"]), triaxiality, atol=1e-12)


def test_a_mesh_of_a_sphere_has_the_ratio_of_a_homogeneous_sphere(tmp_path):
    vertices, faces = icosphere(4, radius=100.0)
    found = moments(read_matter(write_mesh(tmp_path / "ball.obj", vertices, faces), ("kg", "km"), density=1e12))
    assert found.attrs["title"].endswith(" triangles, of density 1000 kg/m3")
    # 2/5 with the radius of equal volume, up to the facets: the error is of the square of their size.
    np.testing.assert_allclose(found["moment_ratio"], 0.4, rtol=2e-5)
    assert float(found["mass"]) == pytest.approx(4 / 3 * np.pi * 100**3 * 1e12, rel=4e-3)
    assert float(found["reference_radius"]) == pytest.approx(1e5, rel=2e-3)
    assert found.attrs["radius_convention"] == "radius of the sphere of the same volume"


def test_quantities_are_in_the_units_of_the_file_and_refused_where_it_has_none(tmp_path, box):
    path = write_mesh(tmp_path / "ball.obj", *icosphere(2))
    for dense in (2 * u.g / u.cm**3, "2000 kg/m3", 2.0):
        assert read_matter(path, ("g", "cm"), density=dense).body.mass == pytest.approx(8.094e-3, rel=1e-5)
    with pytest.raises(InputError, match=r"^density: must be a plain number where the units of the mesh are not given"):
        read_matter(path, density="2 g/cm3")
    with pytest.raises(InputError, match=r"^density: must be a density, not 2 km"):
        read_matter(path, ("g", "cm"), density=2 * u.km)
    plain, known = read_matter(box), read_matter(box, ("kg", "m"))
    for asked in ({"radius": 500 * u.cm}, {"about": [1 * u.m, 0, 0]}, {"about": [100, 0, 0] * u.cm}):
        with pytest.raises(InputError, match=rf"^{next(iter(asked))} must have no unit, for that of 8 particles"):
            moments(plain, **asked)
        same = {name: [1.0, 0.0, 0.0] if name == "about" else 5.0 for name in asked}
        xr.testing.assert_allclose(moments(known, **asked), moments(known, **same))
    with pytest.raises(InputError, match=r"^radius must have no unit"):
        gravity_field(plain, 2, radius="5 cm")
    assert gravity_field(known, 2, radius="500 cm").radius == 5.0


@pytest.mark.slow
def test_a_snapshot_is_chosen_by_its_number(tmp_path):
    main(["new", str(tmp_path / "star.toml")])
    small = ["body.particles=64", "body.relax=false", "body.placement=lattice", "time.max_steps=2"]
    overrides = [part for setting in small for part in ("--set", setting)]
    assert main(["run", str(tmp_path / "star.toml"), *overrides, "--output", str(tmp_path / "run")]) == 0
    run = tmp_path / "run"
    with (
        xr.open_dataset(run / "star.nc") as series,
        xr.open_dataset(run / "star.nc", group="snapshots") as particles,
    ):
        first = moments(read_matter(run, snapshot=0))
        direct = series["inertia_tensor"].values[0]
        np.testing.assert_allclose(first["inertia_tensor"], direct, rtol=0, atol=1e-14 * abs(direct).max())
        last, negative = moments(read_matter(run / "star.nc")), moments(read_matter(run, snapshot=-1))
        np.testing.assert_array_equal(last["inertia_tensor"], negative["inertia_tensor"])
        count = particles.sizes["snapshot_time"]
    assert first["mass"].attrs["units"] == "kg"
    with pytest.raises(SceneError, match=f"has {count} snapshots"):
        read_matter(run, snapshot=count)
    with pytest.raises(SceneError, match="leave --units out"):
        read_matter(run, units=("g", "cm"))


@pytest.mark.slow
def test_a_run_without_particles_is_said_to_have_none(tmp_path):
    for model, records, words in (
        (RIGID, rigid_run(), "has no snapshots, for its model is rigid, which has no particles"),
        ({**METADATA, "model": "sph"}, affine_run()[0], "has no snapshots"),
    ):
        with Archive.create(tmp_path / model["model"], model) as archive:
            archive.write_segment(records[:3])
        with pytest.raises(SceneError, match=words):
            read_matter(tmp_path / model["model"])
        path = tmp_path / f"{model['model']}.nc"
        dataset.open(tmp_path / model["model"]).to_netcdf(path)
        with pytest.raises(SceneError, match=words):
            read_matter(path)
        dataset.open(path).assign_attrs(sweep="grid").to_netcdf(tmp_path / "sweep.nc")
        with pytest.raises(SceneError, match="is of a sweep, whose members have the particles"):
            read_matter(tmp_path / "sweep.nc")


@pytest.mark.parametrize("end", [(1.0, 1.0, 1.0), (0.3, 0.7, 0.1), (1e-3, 2.0, -0.7), (3.0, 0.1, 5.0)])
def test_a_thin_rod_has_no_moment_below_zero(tmp_path, end, capsys):
    table = write_table(tmp_path / "rod.csv", np.ones(2), np.array([end, np.negative(end)]))
    axis = ",".join(map(str, end))
    found = moments(read_matter(table), axis=end)
    for name in ("principal_moments", "moment_ratio", "axis_moment"):
        assert (found[name] >= 0).all() and float(abs(found[name]).min()) < 1e-15 * float(np.dot(end, end))
    assert main(["moments", str(table), f"--axis={axis}"]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert not any(line.startswith(("moment", "I/(M")) and "-" in line[20:].replace("e-", "") for line in printed)


def test_the_command_prints_the_numbers(box, capsys):
    assert main(["moments", str(box), "--axis", "z"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("inertia of 8 particles\nall about the centre of mass\n")
    lines = {line[:30].strip(): line[30:].split() for line in printed.splitlines() if len(line) > 30}
    assert list(map(float, lines["moment"])) == [40, 80, 104]
    assert lines["centre of mass  (x y z)"] == ["10", "0", "0"]
    assert float(lines["moment about it"][0]) == 40
    assert "outermost particle" in printed


def test_the_command_prints_the_gravity_field(box, tmp_path, capsys):
    """Of 8 masses at the corners (1, 2, 3): J2 = -(2 z^2 - x^2 - y^2)/2, and Q_xx - Q_yy over 4 in C22."""
    options = ["--gravity-field", "2", "--normalization", "unnorm", "--radius", "2", "--output", str(tmp_path / "f.nc")]
    assert main(["moments", str(box), *options]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[-6:]]
    assert rows == [
        ["0", "0", "1", "0"], ["1", "0", "0", "0"], ["1", "1", "0", "0"],
        ["2", "0", "1.625", "0", "-1.625"], ["2", "1", "0", "0"], ["2", "2", "-0.1875", "0"],
    ]  # fmt: skip
    with xr.open_dataset(tmp_path / "f.nc") as stored:
        cosine = stored.harmonic_coefficient.sel(part="C")
        assert float(cosine.sel(degree=2, order=2)) == pytest.approx(-0.1875, rel=1e-15)
        assert cosine.attrs["normalization"] == "unnorm"
    assert main(["moments", str(box), *options[:6], "--principal-axes"]) == 0
    row = capsys.readouterr().out.splitlines()[-3].split()  # of the largest moment is x: (13 / 2 - 1) / 4
    assert row == ["2", "0", "-1.375", "0", "1.375"]


def test_a_mesh_has_a_gravity_field_about_any_point(tmp_path):
    """Of a ball of radius 1 about a point at a distance d from its centre: C_l0 = d^l/(2 l + 1)^(1/2)."""
    vertices, faces = icosphere(2)  # whose own harmonics begin at degree 6, by symmetry
    matter = read_matter(write_mesh(tmp_path / "ball.obj", 2.0 * vertices + [0.0, 0.0, 1.0], faces), ("kg", "km"))
    found = moments(matter, (0.0, 0.0, 0.0), radius=1000.0, field_degree=5)
    zonal = found.harmonic_coefficient.sel(part="C", order=0)
    np.testing.assert_allclose(zonal, 1 / np.sqrt(2 * np.arange(6) + 1), rtol=1e-14)
    own = moments(matter, radius=1000.0, field_degree=6).harmonic_coefficient.isel(part=0)
    assert float(abs(own[1:6]).max()) < 1e-13 < 1e-4 < float(abs(own[6]).max())


def test_the_command_says_which_axes_are_undefined(tmp_path, capsys):
    two = write_table(tmp_path / "two.csv", [1, 1], [[0, 0, 0], [0, 0, 2]])
    assert main(["moments", str(two), "--units", "kg,cm", "--about=0,0,1"]) == 0
    printed = capsys.readouterr().out
    assert printed.count("undefined") == 7  # two axes of three components, and the line that explains it
    assert "all about the point (0, 0, 0.01), in SI" in printed
    assert "nan" not in printed


def test_json_and_netcdf_hold_the_same(box, tmp_path, capsys):
    corners = write_table(tmp_path / "cube.csv", np.ones(8), BOX / [1, 2, 3])
    assert main(["moments", str(corners), "--json", "--output", str(tmp_path / "cube.nc")]) == 0
    content = json.loads(capsys.readouterr().out)
    with xr.open_dataset(tmp_path / "cube.nc") as stored:
        np.testing.assert_array_equal(content["principal_moments"]["value"], stored["principal_moments"])
        assert content["triaxiality"]["value"] is None and np.isnan(stored["triaxiality"])
        assert not stored["axis_defined"].values.any()


def test_radius_and_density_of_the_command_may_have_units(tmp_path, capsys):
    mesh = write_mesh(tmp_path / "ball.obj", *icosphere(0))
    answers = []
    for density, radius in (("2", "300"), ("2000 kg/m3", "3 m")):
        options = ["--units", "g,cm", "--density", density, "--radius", radius, "--json"]
        assert main(["moments", str(mesh), *options]) == 0
        answers.append(json.loads(capsys.readouterr().out))
    assert answers[0]["mass"]["value"] == pytest.approx(answers[1]["mass"]["value"], rel=1e-12)
    assert answers[0]["moment_ratio"]["value"] == pytest.approx(answers[1]["moment_ratio"]["value"], rel=1e-12)
    for option in ("--density=2 g/cm3", "--radius=3 m", "--density=heavy"):
        assert main(["moments", str(mesh), option]) == 2


def test_the_command_draws(box, tmp_path, capsys):
    assert main(["moments", str(box), "--plot", str(tmp_path / "box.png")]) == 0
    assert (tmp_path / "box.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.csv"], "not there"),
        (["none.stl"], "mesh none.stl is not there"),
        (["none.xyz"], "not there"),
        (["junk.nc"], "cannot be read as netCDF"),
        (["junk.h5"], "not an HDF5 file"),
        (["open.obj"], "mesh open.obj: "),
        (["."], "holds no run"),
        (["p.csv", "--about", "1,2"], "--about takes three numbers"),
        (["p.csv", "--about=0,0,nan"], "--about takes three numbers"),
        (["p.csv", "--axis", "w"], "--axis takes three numbers"),
        (["p.csv", "--axis", "0,0,0"], "an axis needs a direction"),
        (["p.csv", "--units", "kg"], "--units takes"),
        (["p.csv", "--units", "kg,furlongs2"], "furlongs2"),
        (["p.csv", "--units", "m,kg"], "not a mass"),
        (["p.csv", "--radius", "-1"], "must be positive"),
        (["p.csv", "--radius", "nan"], "must be positive"),
        (["p.csv", "--radius", "inf"], "must be positive"),
        (["p.csv", "--units", "kg,1"], "not a length"),
        (["p.csv", "--about", "1e200,0,0"], "too large for a number"),
        (["far.csv"], "too large for a number"),
        (["p.csv", "--density", "2"], "not a mesh"),
        (["p.glb"], "must be a .csv, .ecsv, .npz, .nc, .h5, .hdf5, .stl, .obj, .ply or .off file"),
        (["ball.obj", "--density", "-2"], "density of a mesh must be positive"),
        (["p.csv", "--snapshot", "0"], "no snapshots"),
        (["p.csv", "--gravity-field", "-1"], "the degree must be a whole number from 0 to 80, not -1"),
        (["p.csv", "--gravity-field", "2", "--normalization", "full"], "one of 4pi, ortho, schmidt, unnorm"),
        (["p.csv", "--principal-axes"], "--principal-axes is of spherical harmonics"),
        (["p.csv", "--normalization", "4pi"], "--normalization is of spherical harmonics"),
        (["point.csv", "--gravity-field", "2"], "the reference radius must be positive"),
        (["p.csv", "--plot", "p.gif"], "must be a .png file"),
        (["p.csv", "--output", "nowhere/p.nc"], "a folder that is there"),
        (["point.csv", "--plot", "p.png"], "nothing to draw"),
    ],
)
def test_what_is_wrong_gets_one_sentence_and_writes_nothing(arguments, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_table(tmp_path / "p.csv", np.ones(8), BOX)
    write_table(tmp_path / "point.csv", [1.0], [[1.0, 2.0, 3.0]])
    write_table(tmp_path / "far.csv", np.ones(8), 1e200 * BOX)
    vertices, faces = icosphere(0)
    write_mesh(tmp_path / "ball.obj", vertices, faces)
    write_mesh(tmp_path / "open.obj", vertices, faces[1:])
    for name in ("junk.nc", "junk.h5", "p.glb"):
        (tmp_path / name).write_bytes(bytes(range(256)))
    before = sorted(tmp_path.iterdir())
    assert main(["moments", *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert words in printed.err
    assert printed.err.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before


def test_the_ellipsoid_of_a_body_is_about_its_centre_whatever_the_moments_are_about(box, tmp_path, capsys):
    matter = read_matter(box)
    own, about = moments(matter), moments(matter, about=(30.0, 0.0, 0.0))
    np.testing.assert_allclose(about.semi_axes, own.semi_axes, rtol=1e-14)
    assert float(about.triaxiality) == pytest.approx(float(own.triaxiality))
    picture = tmp_path / "box.png"
    assert main(["moments", str(box), "--about=30,0,0", "--plot", str(picture)]) == 0
    line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("equivalent semi-axes"))
    assert line.endswith("about the centre")
    assert [float(value) for value in line.split()[2:5]] == pytest.approx(own.semi_axes.values, rel=1e-6)
    assert picture.stat().st_size > 10_000


def test_a_mesh_with_a_part_inside_out_is_no_body_and_is_not_drawn(tmp_path, capsys):
    vertices, faces = icosphere(1)
    both = np.concatenate([2.0 * vertices, vertices + [5.0, 0.0, 0.0]])
    mesh = write_mesh(tmp_path / "two.obj", both, np.concatenate([faces, faces[:, ::-1] + len(vertices)]))
    assert main(["moments", str(mesh)]) == 0
    printed = capsys.readouterr().out
    assert "not the tensor of a body of positive mass: principal moments are not negative" in printed
    assert next(line for line in printed.splitlines() if "gyration" in line).split()[-3] == "undefined"
    assert main(["moments", str(mesh), "--plot", str(tmp_path / "two.png")]) == 2
    assert "has a tensor that is not drawn: principal moments are not negative" in capsys.readouterr().err
