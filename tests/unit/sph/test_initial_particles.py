"""Placement, rotation laws and particle tables."""

import gzip

import h5py
import netCDF4
import numpy as np
import pytest
from astropy.table import QTable, Table
from astropy.units import Unit
from scipy.integrate import quad
from scipy.spatial import cKDTree

from astroinertia.build.assemble import prepare
from astroinertia.errors import SceneError
from astroinertia.scene.load import loads
from astroinertia.scene.scales import code_units
from astroinertia.sph import profiles
from astroinertia.sph.placement import azimuthal_mode, isotropised, place, turned
from astroinertia.sph.rotation import linear_velocity, rotation_velocity
from astroinertia.sph.table import read_body, read_table
from astroinertia.storage import cache
from astroinertia.units import DIMENSIONLESS, SOLAR_MASS

pytestmark = pytest.mark.usefixtures("own_cache")

PROFILES = {
    "uniform": profiles.uniform(),
    "polytrope-1.5": profiles.polytrope(1.5),
    "polytrope-3": profiles.polytrope(3.0),
    "homologous-core": profiles.homologous_core(0.9),
    "evrard": profiles.power_law(1.0),
    "dyson": profiles.dyson(5 / 3),
}


@pytest.mark.parametrize("name", PROFILES)
def test_profile_integrals(name):
    """Mass, second moment and W follow from the density alone; the inverse undoes the enclosed mass."""
    profile = PROFILES[name]
    options = {"epsabs": 1e-12, "epsrel": 1e-10, "limit": 200}

    def integral(function):
        return quad(function, 0, 1, **options)[0]

    assert integral(lambda s: 4 * np.pi * s**2 * float(profile.density(s))) == pytest.approx(1, rel=1e-8)
    moment = integral(lambda s: 4 * np.pi / 3 * s**4 * float(profile.density(s)))
    assert moment == pytest.approx(profile.second_moment, rel=1e-8)
    energy = integral(lambda s: -4 * np.pi * s * float(profile.density(s)) * float(profile.enclosed(s)))
    assert energy == pytest.approx(profile.gravitational_energy, rel=1e-8)
    m = np.linspace(0, 1, 501)
    np.testing.assert_allclose(profile.enclosed(profile.radius(m)), m, rtol=0, atol=1e-13)


def test_dyson_is_the_polytrope_of_no_gravity_and_known_moments():
    assert profiles.dyson(5 / 3).second_moment == 1 / 8
    assert profiles.dyson(2.0).second_moment == pytest.approx(1 / 7, rel=1e-15)
    assert profiles.uniform().gravitational_energy == pytest.approx(-0.6, rel=1e-15)
    assert profiles.power_law(1.0).gravitational_energy == pytest.approx(-2 / 3, rel=1e-15)


def test_ellipsoid_energy_of_a_maclaurin_spheroid():
    """W = -(3/5) (M^2/a) asin(e)/e for a homogeneous oblate spheroid (Binney & Tremaine 2008, sect. 2.5)."""
    a, c = 1.3, 0.7
    e = np.sqrt(1 - (c / a) ** 2)
    energy = profiles.ellipsoid_gravitational_energy(profiles.uniform(), 2.0, (a, a, c))
    assert energy == pytest.approx(-0.6 * 4 / a * np.arcsin(e) / e, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("placement", ["lattice", "glass", "random"])
@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.parametrize("count", [4, pytest.param(157, marks=pytest.mark.full), 500])
def test_count_centre_and_moment(name, placement, count):
    profile = PROFILES[name]
    points = place(profile, count, placement, seed=3)
    assert points.shape == (count, 3)
    assert np.abs(points.mean(axis=0)).max() < 1e-15
    np.testing.assert_allclose(points.T @ points / count, profile.second_moment * np.eye(3), rtol=0, atol=4e-16)
    np.testing.assert_array_equal(points, place(profile, count, placement, seed=3))
    assert np.abs(points - place(profile, count, placement, seed=4)).max() > 0.01


def _density(points):
    """Kernel density with the cubic spline and 58 neighbours' worth of smoothing, by brute neighbour lists."""
    distance, _ = cKDTree(points).query(points, k=160)
    h = distance[:, 57] / 2
    for _ in range(10):
        q = distance / h[:, None]
        w = (2 * np.maximum(1 - q / 2, 0) ** 3 - np.maximum(1 - q, 0) ** 3) / np.pi
        density = w.sum(axis=1) / len(points) / h**3
        h = np.sqrt(h * 1.2 * (1 / len(points) / density) ** (1 / 3))
    return density


@pytest.mark.full
@pytest.mark.parametrize("name", PROFILES)
def test_density_noise(name):
    """Scatter about the profile inside; measured at 2000: glass 0.6-1.8 %, lattice 0.4-2.7 %, random 40 %."""
    profile = PROFILES[name]
    noise = {}
    for placement in ("glass", "lattice", "random"):
        points = place(profile, 1200, placement)
        s = np.linalg.norm(points, axis=1)
        inside = (profile.enclosed(s) > 0.04) & (profile.enclosed(s) < 0.6)
        noise[placement] = (_density(points)[inside] / profile.density(s[inside])).std()
    assert noise["glass"] < 0.03
    assert noise["lattice"] < 0.04
    assert noise["random"] > 0.2


@pytest.mark.full
def test_sampling_error_of_the_moment_before_it_is_removed():
    """A glass carries the profile by its ranks: what the affine correction takes away shrinks faster than 1/N."""
    from astroinertia.sph.placement import glass

    profile = profiles.polytrope(1.5)
    errors = []
    for count in (500, 2000):
        points = glass(profile, count, 0)
        errors.append(abs((points**2).sum() / 3 / count / profile.second_moment - 1))
    assert errors[0] < 5e-5
    assert errors[1] < errors[0] / 4


def test_a_glass_is_kept_and_a_broken_file_is_replaced():
    profile = profiles.uniform()
    first = place(profile, 300)
    (file,) = cache.cache_directory().glob("glass-*.npz")
    file.write_bytes(b"PK\x03\x04 not an archive")
    np.testing.assert_array_equal(place(profile, 300), first)
    assert file.stat().st_size > 300 * 24


def test_a_cache_that_cannot_be_written_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("ASTROINERTIA_CACHE", str(tmp_path / "file"))
    assert place(profiles.uniform(), 100).shape == (100, 3)


def test_isotropised_is_affine():
    points = np.random.default_rng(0).normal(size=(50, 3)) * [1.0, 2.0, 3.0] + 5
    mapped = isotropised(points, 0.2)
    design = np.column_stack([points, np.ones(50)])
    residual = mapped - design @ np.linalg.lstsq(design, mapped, rcond=None)[0]
    assert np.abs(residual).max() < 1e-13


@pytest.mark.parametrize("law", ["rigid", "j_constant"])
@pytest.mark.parametrize("measure", ["rate", "angular_momentum", "t_over_w"])
def test_rotation_measures(law, measure):
    generator = np.random.default_rng(1)
    points, mass = generator.normal(size=(200, 3)), generator.random(200)
    axis, scale = np.array([1.0, 2.0, -2.0]) / 3, None if law == "rigid" else 0.7
    v = rotation_velocity(mass, points, law, 3 * axis, scale, gravitational_energy=-2.5, **{measure: 0.04})
    along = points @ axis
    w = np.linalg.norm(points - along[:, None] * axis, axis=1)
    rate = np.linalg.norm(v, axis=1) / w
    assert max(np.abs(v @ axis).max(), np.abs((v * points).sum(axis=1)).max()) < 1e-14 * (1 + np.abs(v).max())
    on_axis = rate * (1 if law == "rigid" else 1 + (w / 0.7) ** 2)
    np.testing.assert_allclose(on_axis, on_axis[0], rtol=1e-12)
    found = {
        "rate": on_axis[0],
        "angular_momentum": (mass @ np.cross(points, v)) @ axis,
        "t_over_w": 0.5 * (mass @ (v**2).sum(axis=1)) / 2.5,
    }
    assert found[measure] == pytest.approx(0.04, rel=1e-12)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({}, "exactly one"),
        ({"rate": 1.0, "t_over_w": 0.1}, "exactly one"),
        ({"period": 1.0}, "exactly one"),
        ({"rate": np.nan}, "finite"),
        ({"t_over_w": 0.1}, "self-gravitating"),
        ({"rate": 1.0, "law": "keplerian"}, "rotation law"),
        ({"rate": 1.0, "law": "j_constant"}, "scale"),
        ({"rate": 1.0, "axis": (0, 0, 0)}, "axis"),
    ],
)
def test_rotation_refuses(options, sentence):
    with pytest.raises(ValueError, match=sentence):
        rotation_velocity(np.ones(5), np.eye(5)[:, :3], **options)


def test_linear_velocity():
    points = np.random.default_rng(2).normal(size=(20, 3))
    np.testing.assert_allclose(linear_velocity(points, [[0, -2, 0], [2, 0, 0], [0, 0, 1.5]])[:, 2], 1.5 * points[:, 2])
    with pytest.raises(ValueError, match="3x3"):
        linear_velocity(points, [[1, 2], [3, 4]])


COLUMNS = "mass,x,y,z,vx,vy,vz,u"


def test_table_round_trip(tmp_path):
    values = np.random.default_rng(3).random((6, 8))
    text = "# particles\n" + COLUMNS + "\n" + "\n".join(",".join(repr(float(v)) for v in row) for row in values)
    (tmp_path / "p.csv").write_text(text)
    np.savez(tmp_path / "p.npz", **dict(zip(COLUMNS.split(","), values.T, strict=True)))
    vectors = {"position": values[:, 1:4], "velocity": values[:, 4:7]}
    np.savez(tmp_path / "v.npz", mass=values[:, 0], u=values[:, 7], **vectors)
    for name in ("p.csv", "p.npz", "v.npz"):
        table = read_table(tmp_path / name)
        np.testing.assert_array_equal(table.position, values[:, 1:4])
        np.testing.assert_array_equal(table.velocity, values[:, 4:7])
        np.testing.assert_array_equal(table.mass, values[:, 0])
        np.testing.assert_array_equal(table.internal_energy, values[:, 7])
    (tmp_path / "r.csv").write_text("x,y,z,mass,specific_internal_energy\n" + "1,2,3,4,5\n" * 4)
    assert (read_table(tmp_path / "r.csv").internal_energy == 5).all()
    numbers = np.array([[1.0, 2.0, 3.0, 4.0]] * 4)
    np.savetxt(tmp_path / "s.csv", numbers, delimiter=",", header="of mine, all alike\nx,y,z,mass")
    assert (read_table(tmp_path / "s.csv").mass == 4).all() and read_table(tmp_path / "s.csv").mass.size == 4
    (tmp_path / "q.csv").write_text("x,y,z,mass\n" + "1,2,3,4\n" * 4)
    table = read_table(tmp_path / "q.csv")
    assert table.internal_energy is None
    assert (table.velocity == 0).all()
    assert (table.mass == 4).all()


ECSV = """\
# %ECSV 1.0
# ---
# datatype:
# - {{name: mass, unit: solMass, datatype: float64}}
# - {{name: x, unit: km, datatype: float64}}
# - {{name: y, unit: km, datatype: float64, description: up}}
# - {{name: z, unit: km, datatype: float64}}
# schema: astropy-2.0
mass x y z
{}
"""
PLACES = np.random.default_rng(5).random((6, 4))
_SIZES = np.array([SOLAR_MASS, 1e3, 1e3, 1e3])
_BODY = """\
[[bodies]]
kind = "table"
file = "{}"
specific_internal_energy = "1e10 J/kg"
position = ["{} km", "0 m", "0 m"]
"""
_OF_TABLES = """\
name = "tables"
model = "sph"
{units}
{bodies}
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = "1 s"
"""


@pytest.fixture
def tables(tmp_path):
    """The same particles with units in their heads, as astropy writes them, and in SI without."""

    def rows(values, between):
        return "\n".join(between.join(map(repr, row)) for row in values.tolist())

    (tmp_path / "heads.csv").write_text("m [Msun],x (km),y (km), z [km]\n" + rows(PLACES, ","))
    (tmp_path / "astropy.ecsv").write_text(ECSV.format(rows(PLACES, " ")))
    (tmp_path / "si.csv").write_text("mass,x,y,z\n" + rows(PLACES * _SIZES, ","))
    return tmp_path


@pytest.mark.parametrize("name", ["heads.csv", "astropy.ecsv"])
def test_text_that_gzip_has_packed_is_read_as_it_was(tables, name):
    content = (tables / name).read_bytes()
    (tables / f"{name}.GZ").write_bytes(gzip.compress(content))
    np.testing.assert_array_equal(read_table(tables / f"{name}.GZ").position, read_table(tables / name).position)
    assert read_table(tables / f"{name}.GZ").units == "SI"


def test_what_gzip_has_packed_is_refused_where_it_is_damaged_or_out_of_proportion(tmp_path):
    packed = gzip.compress(b"mass,x,y,z\n" + b"1,0,0,0\n" * 9)
    bomb = gzip.compress(b"mass,x,y,z\n" + b"1,0,0,0\n" * 9_000_000)
    for content, sentence in (
        (packed[:-12], "cannot be unpacked"),
        (packed[:20] + b"!" + packed[21:], "cannot be unpacked"),
        (packed[:-5] + b"!" + packed[-4:], "cannot be unpacked"),
        (gzip.compress(bytes(range(256))), "is not text"),
        (bomb, "unpacks to more than the 64 MiB allowed"),
    ):
        (tmp_path / "p.csv.gz").write_bytes(content)
        with pytest.raises(SceneError, match=sentence) as caught:
            read_table(tmp_path / "p.csv.gz")
        assert "\n" not in str(caught.value)
    (tmp_path / "p.npz.gz").write_bytes(packed)
    with pytest.raises(SceneError, match=r"must be a \.csv"):
        read_table(tmp_path / "p.npz.gz")


@pytest.mark.parametrize("name", ["heads.csv", "astropy.ecsv"])
def test_columns_with_units_become_si_and_go_with_no_scene_in_code_units(tables, name):
    table = read_table(tables / name)
    assert table.units == "SI"
    np.testing.assert_allclose(table.mass, PLACES[:, 0] * SOLAR_MASS, rtol=1e-9)
    np.testing.assert_allclose(table.position, PLACES[:, 1:] * 1e3, rtol=1e-15)
    with pytest.raises(SceneError, match="states units, but the scene has none"):
        read_body(tables / name, DIMENSIONLESS)


@pytest.mark.parametrize(
    "column",
    [
        "# - {{name: {name}, datatype: float64, unit: {unit}}}",
        "# -\n#   name: {name}\n#   datatype: float64\n#   unit: {unit}\n#   description: of particles",
        "# - name: '{name}'\n#   unit: '{unit}'\n#   datatype: float64",
    ],
)
@pytest.mark.parametrize("between", [" ", ","])
def test_units_of_ecsv_are_found_however_it_is_laid_out(tmp_path, column, between):
    named = {"mass": "solMass", "x": "km", "y": "km", "z": "km"}
    head = ["# %ECSV 1.0", "# ---", f'# delimiter: "{between}"', "# datatype:"]
    head += [column.format(name=name, unit=unit) for name, unit in named.items()]
    head += ["# meta:", "#   name: x", "#   unit: m", "# schema: astropy-2.0"]
    rows = [between.join(map(repr, row)) for row in PLACES.tolist()]
    (tmp_path / "p.ecsv").write_text("\n".join([*head, between.join(named), *rows]))
    table = read_table(tmp_path / "p.ecsv")
    assert table.units == "SI"
    np.testing.assert_allclose(table.mass, PLACES[:, 0] * SOLAR_MASS, rtol=1e-9)
    np.testing.assert_allclose(table.position, PLACES[:, 1:] * 1e3, rtol=1e-15)


def test_vectors_of_astropy_are_columns_and_what_it_masks_is_refused(tmp_path):
    units = dict(zip(("mass", "position", "velocity"), ("solMass", "km", "km / s"), strict=True))
    rng = np.random.default_rng(6)
    table = {name: rng.random((6, 3) if name != "mass" else 6) * Unit(unit) for name, unit in units.items()}
    for delimiter in (" ", ","):
        QTable(table).write(tmp_path / "vectors.ecsv", delimiter=delimiter, overwrite=True)
        read = read_table(tmp_path / "vectors.ecsv")
        assert read.units == "SI"
        np.testing.assert_allclose(read.position, table["position"].to_value("m"), rtol=1e-15)
        np.testing.assert_allclose(read.velocity, table["velocity"].to_value("m/s"), rtol=1e-15)
    text = (tmp_path / "vectors.ecsv").read_text()
    head, _, rows = text.partition("schema")
    (tmp_path / "vectors.ecsv").write_text(head + "schema" + rows.replace("[", "[7,", 1))
    with pytest.raises(SceneError, match=r"row 1 is not numbers \(position is not three numbers"):
        read_table(tmp_path / "vectors.ecsv")
    masked = Table(table, masked=True)
    masked["mass"].mask[3] = True
    masked.write(tmp_path / "masked.h5", path="t", serialize_meta=True)
    with pytest.raises(SceneError, match="mass of row 4 is masked"):
        read_table(tmp_path / "masked.h5")


def test_several_tables_need_no_units_where_each_states_its_own_or_all_are_in_si(tables):
    def scene(units, *names):
        bodies = "".join(_BODY.format(name, 9 * number) for number, name in enumerate(names))
        return loads(_OF_TABLES.format(units=units, bodies=bodies), origin=str(tables))

    for stated in (scene("", "heads.csv", "astropy.ecsv"), scene('units = "SI"', "heads.csv", "si.csv")):
        assert code_units(stated).mass == pytest.approx(PLACES[:, 0].sum() * SOLAR_MASS, rel=1e-9)
        centre = PLACES[:, 0] @ PLACES[:, 1:] / PLACES[:, 0].sum()
        radius = 1e3 * np.linalg.norm(PLACES[:, 1:] - centre, axis=1).max()
        assert code_units(stated).length == pytest.approx(radius, rel=1e-9)
        assert code_units(loads(stated.to_toml())) == code_units(stated)  # without the files
    with pytest.raises(SceneError, match=r'whose file si\.csv states no units; a table in SI takes units = "SI"'):
        scene("", "heads.csv", "si.csv")


@pytest.mark.parametrize("names", ["m,x,y,z,vx,vy,vz,internal_energy", "masses,x,y,z,vx,vy,vz,u,rho,hsml",
                                   "M,X,Y,Z,VX,VY,VZ,u", "Mass,X,Y,Z,Vx,Vy,Vz,U", "MASS,X,Y,Z,VX,VY,VZ,U,RHO",
                                   "mass,x,y,z,vx,vy,vz,specific_internal_energy,density,h"])  # fmt: skip
def test_columns_have_the_names_that_other_codes_give_them(tmp_path, names):
    columns = dict(zip(names.split(","), np.random.default_rng(4).random((10, 6)), strict=False))
    rows = [",".join(map(repr, row)) for row in np.array(list(columns.values())).T.tolist()]
    (tmp_path / "p.csv").write_text("\n".join([names, *rows]))
    np.savez(tmp_path / "p.npz", **columns)
    with h5py.File(tmp_path / "p.h5", "w") as file:
        for name, column in columns.items():
            file[name] = column
    with netCDF4.Dataset(tmp_path / "p.nc", "w") as file:
        file.createDimension("particle", 6)
        for name, column in columns.items():
            file.createVariable(name, "f8", ("particle",))[:] = column
    first, *_, last, energy = list(columns)[:8]
    for file in ("p.csv", "p.npz", "p.h5", "p.nc"):
        table = read_table(tmp_path / file)
        np.testing.assert_array_equal(table.mass, columns[first])
        np.testing.assert_array_equal(table.internal_energy, columns[energy])
        np.testing.assert_array_equal(table.velocity[:, 2], columns[last])


def test_a_column_under_two_names_is_refused(tmp_path):
    with h5py.File(tmp_path / "p.h5", "w") as file:
        for name in ("m", "mass", "x", "y", "z"):
            file[name] = np.ones(6)
    with pytest.raises(SceneError, match="columns more than once, namely mass"):
        read_table(tmp_path / "p.h5")


BAD = {
    "empty.csv": (b"", "lacks mass"),
    "columns.csv": (b"mass,x,y\n1,2,3\n", "lacks z"),
    "spaces.csv": (b"mass x y z\n1 2 3 4\n", "lacks mass, x, y, z, and has mass x y z; its .*, with commas between"),
    "no_head.csv": (b"# of mine\n1,2,3,4\n", "lacks mass, x, y, z, and has of mine; its columns are"),
    "unnamed.csv": (b",mass,x,y,z\n1,2,3,4,5\n", "unknown columns without a name"),
    "unknown.csv": (b"mass,x,y,z,spin\n1,2,3,4,5\n", "unknown"),
    "twice.csv": (b"mass,x,y,z,x\n1,2,3,4,5\n", "more than once, namely x"),
    "word.csv": (b"mass,x,y,z\n1,2,3,4\n1,2,three,4\n", "row 2 is not numbers"),
    "ragged.csv": (b"mass,x,y,z\n1,2,3\n", "row 1 has 3 values"),
    "nan.csv": (b"mass,x,y,z\n" + b"1,0,0,0\n" * 4 + b"1,nan,0,0\n", "x of row 5 is not finite"),
    "negative.csv": (b"mass,x,y,z\n" + b"1,0,0,0\n" * 4 + b"-1,0,0,0\n-2,0,0,0\n", "mass of row 5 is not positive"),
    "few.csv": (b"mass,x,y,z\n1,0,0,0\n", "1 particles"),
    "long.csv": (b"mass,x,y,z\n" + b"1" * 5000 + b",0,0,0\n", "line 2 is longer"),
    "binary.csv": (bytes(range(256)), "not text"),
    "junk.npz": (bytes(range(256)), "not an npz file"),
    "junk.nc": (bytes(range(256)), "not the result of a run"),
    "some.csv": (b"mass (kg),x (km),y,z (km)\n" + b"1,0,0,0\n" * 4, "column y has no unit, but mass has one"),
    "second.csv": (b"mass (kg),x (s),y (km),z (km)\n" + b"1,0,0,0\n" * 4, "the unit of x: '1 s' is not a length"),
    "table.txt": (b"mass,x,y,z\n", "must be a .csv, .ecsv, .npz, .nc, .h5 or .hdf5"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_tables_get_one_sentence(tmp_path, name):
    content, sentence = BAD[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError, match=sentence) as caught:
        read_table(tmp_path / name)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize("placement", ["glass", "lattice", "random"])
@pytest.mark.parametrize("count", [3, 100.5, float("nan")])
def test_a_body_is_of_a_whole_number_of_particles(placement, count):
    """A glass of 100.5 particles was one of 101, at radii that were not theirs."""
    with pytest.raises(ValueError, match=f"a whole number of at least 4 particles, not {count}"):
        place(profiles.uniform(), count, placement)


@pytest.mark.parametrize("style", ["NETCDF4", "NETCDF3_CLASSIC"])
@pytest.mark.parametrize(("name", "axes"), [("density", "abc"), ("temperature", "zyx"), ("m", "xyz")])
def test_a_grid_is_refused_with_what_would_be_right(tmp_path, style, name, axes):
    with netCDF4.Dataset(tmp_path / "grid.nc", "w", format=style) as file:
        for axis in axes:
            file.createDimension(axis, 4)
            file.createVariable(axis, "f8", (axis,))[:] = np.arange(4.0)
        file.createVariable(name, "f8", tuple(axes))[:] = np.ones((4, 4, 4))
    with pytest.raises(SceneError, match=r"on a grid of 4 x 4 x 4 cells; give each cell as a particle, with its mass"):
        read_table(tmp_path / "grid.nc")


def test_the_last_snapshot_of_a_run_is_a_table(tmp_path):
    values = np.random.default_rng(4).random((2, 6, 8))
    with netCDF4.Dataset(tmp_path / "run.nc", "w") as file:
        group = file.createGroup("snapshots")
        for name, size in {"snapshot_time": 2, "particle": 6, "i": 3}.items():
            group.createDimension(name, size)
        shape = ("snapshot_time", "particle")
        for name, column, more in (
            ("mass", values[..., 0], ()),
            ("position", values[..., 1:4], ("i",)),
            ("velocity", values[..., 4:7], ("i",)),
            ("internal_energy", values[..., 7], ()),
        ):
            group.createVariable(name, "f8", shape + more)[:] = column
    table = read_table(tmp_path / "run.nc")
    np.testing.assert_array_equal(table.mass, values[1, :, 0])
    np.testing.assert_array_equal(table.position, values[1, :, 1:4])
    np.testing.assert_array_equal(table.velocity, values[1, :, 4:7])
    np.testing.assert_array_equal(table.internal_energy, values[1, :, 7])


def test_tables_that_are_not_there_or_pickled(tmp_path):
    with pytest.raises(SceneError, match="not there"):
        read_table(tmp_path / "none.csv")
    with pytest.raises(SceneError, match="a directory"):
        read_table(tmp_path)
    objects = np.array([{}] * 5, dtype=object)
    np.savez(tmp_path / "p.npz", mass=objects, x=objects, y=objects, z=objects)
    with pytest.raises(SceneError, match="plain numbers"):
        read_table(tmp_path / "p.npz")


@pytest.mark.parametrize(
    ("count", "placement", "sentence"), [(3, "glass", "at least 4"), (10, "grid", "must be one of")]
)
def test_bad_placements_are_refused(count, placement, sentence):
    with pytest.raises(ValueError, match=sentence):
        place(profiles.uniform(), count, placement)


def test_an_azimuthal_mode_gives_the_density_asked_for_and_keeps_the_rest():
    """Of evenly spread angles: Fourier coefficient amplitude/2 in the mode and none in others; distances untouched."""
    angle = 2 * np.pi * (np.arange(5000) + 0.3) / 5000
    points = np.stack([3 * np.cos(angle), 3 * np.sin(angle), np.linspace(-1, 1, 5000)], axis=1)
    for mode, amplitude in ((2, 0.1), (2, 0.5), (3, 0.9)):
        moved = turned(points, azimuthal_mode(points, mode, amplitude))
        phase = np.arctan2(moved[:, 1], moved[:, 0])
        found = [np.exp(1j * k * phase).mean() for k in range(1, 6)]
        wanted = [amplitude / 2 if k == mode else 0.0 for k in range(1, 6)]
        np.testing.assert_allclose(found, wanted, atol=1e-9)
        np.testing.assert_allclose(np.hypot(*moved[:, :2].T), 3.0, rtol=1e-12)
        np.testing.assert_array_equal(moved[:, 2], points[:, 2])


@pytest.mark.slow
def test_an_uneven_body_is_as_the_scene_says_and_turns_as_before():
    """The second mode of the density, the angular momentum of the even body, and what is refused."""
    text = """
    name = "uneven"
    units = "code"
    body = {kind = "uniform", particles = 500, mass = 1, radius = 1, rotation = {rate = 0.3}}
    equation_of_state = {kind = "isothermal", sound_speed = 0.3}
    effects = {gravity = {}, pressure = {}}
    time = {end = 1}
    """
    uneven = "body.perturbation={mode=2, amplitude=0.5}"
    states = [prepare(loads(text, settings)).evolution.state for settings in ([], [uneven])]
    spins = [np.cross(s.position, s.velocity).T @ s.mass for s in states]
    np.testing.assert_allclose(spins[1][2], spins[0][2], rtol=1e-12)
    phases = [np.arctan2(s.position[:, 1], s.position[:, 0]) for s in states]
    modes = [abs(np.exp(2j * phase).mean()) for phase in phases]
    assert modes[0] < 0.05 and abs(modes[1] - 0.25) < 0.05
    with pytest.raises(SceneError, match="about another axis"):
        loads(text, [uneven, "body.rotation={rate=0.3, axis=[1,0,0]}"])
    with pytest.raises(SceneError, match="needs particles"):
        loads(text, [uneven, "model='scaling'"])


@pytest.mark.parametrize("gamma", [7.0, 5.0 / 3.0, 1.4, 1.1])
def test_a_dyson_ellipsoid_is_bound_by_the_energy_of_its_profile(gamma):
    profile = profiles.dyson(gamma)
    # In terms of the angle whose sine is s: smooth at the centre and at the surface.
    nodes, weights = np.polynomial.legendre.leggauss(200)
    angle = 0.25 * np.pi * (nodes + 1)
    s = np.sin(angle)
    work = profile.enclosed(s) * 4 * np.pi * s * profile.density(s) * np.cos(angle)
    assert profile.gravitational_energy == pytest.approx(-0.25 * np.pi * (weights @ work), rel=1e-9)


def test_a_dyson_ellipsoid_of_gamma_two_is_bound_by_five_sevenths():
    assert profiles.dyson(2.0).gravitational_energy == pytest.approx(-5 / 7, rel=1e-14)  # of 1 - r^2
