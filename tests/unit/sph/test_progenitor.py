"""Stellar profiles: what is read from each format, and the particles placed by them, against sums over the table."""

import gzip
import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.build.placing import particles
from astroinertia.build.sph import problem_of
from astroinertia.errors import SceneError
from astroinertia.scene import load
from astroinertia.scene.plan import code_units, plan
from astroinertia.sph.progenitor import read_progenitor
from astroinertia.units import ATOMIC_MASS, BOLTZMANN_CONSTANT, GRAVITATIONAL_CONSTANT, SOLAR_MASS, SOLAR_RADIUS

ROOT = Path(__file__).parents[3]
MESA, KEPLER = ROOT / "data" / "example_mesa_profile.data", ROOT / "data" / "example_kepler_presn"
STAR = Polytrope(3.0, 2.0 * SOLAR_MASS, 3.0e6, GRAVITATIONAL_CONSTANT)
SCENE = """
name = "progenitor"
[units]
mass = "1 Msun"
length = "1000 km"
[body]
kind = "profile"
file = "FILE"
particles = 1500
inner_mass = "1.4 Msun"
[equation_of_state]
kind = "ideal"
gamma = 1.3333333333333333
[effects.gravity]
[effects.pressure]
[time]
end = "1 ms"
"""


def scene_of(file, *settings):
    return load.loads(SCENE.replace("FILE", str(file)), settings)


def placed(scene):
    units = code_units(scene)
    problem, ball = problem_of(scene, units)
    return particles(scene, units, ball, problem), units, ball


@pytest.mark.parametrize("file", [MESA, KEPLER], ids=["mesa", "kepler"])
def test_a_table_is_the_star_that_it_was_made_of(file):
    """Shells of even density have a little more inertia than the star; the error falls with their number squared."""
    star = read_progenitor(file)
    assert star.mass[-1] == pytest.approx(STAR.mass, rel=1e-12)
    assert star.radius[-1] == pytest.approx(STAR.radius, rel=1e-12)
    assert star.moment_of_inertia == pytest.approx(STAR.moment_of_inertia, rel=4e-4)
    assert star.density[0] == pytest.approx(STAR.central_density, rel=5e-3)
    assert star.pressure is not None and star.pressure[0] == pytest.approx(STAR.central_pressure, rel=5e-3)
    assert star.internal_energy is not None
    assert np.allclose(star.internal_energy, 3.0 * star.pressure / star.density, rtol=1e-9)
    share, weights = np.polynomial.legendre.leggauss(200)
    share, weights = 0.5 * (share + 1.0), 0.5 * weights
    squared = STAR.radius_enclosing(STAR.mass * share) ** 2
    momentum = STAR.mass * (weights @ (8.0 / 3.0 * squared / (1.0 + squared / 1e12)))
    assert star.angular_momentum == pytest.approx(momentum, rel=3e-4)
    profile = star.profile()
    energy = STAR.gravitational_energy / (GRAVITATIONAL_CONSTANT * STAR.mass**2 / STAR.radius)
    assert profile.gravitational_energy == pytest.approx(energy, rel=2e-4)
    share = np.linspace(0.0, 1.0, 50)
    assert np.allclose(profile.enclosed(profile.radius(share)), share, atol=1e-14)


def test_a_profile_of_mesa_with_the_logarithm_of_angular_momentum_turns(tmp_path):
    lines = MESA.read_text().splitlines()
    place, turned = lines[5].split().index("omega"), tmp_path / "profile.data"
    radius = read_progenitor(MESA).radius[::-1]  # of zones from the surface inwards, as they are in the file
    rows = [line.split() for line in lines[6:]]
    for row, r in zip(rows, radius, strict=True):
        row[place] = repr(float(np.log10(2 / 3 * float(row[place]) * (100 * r) ** 2)))  # cm2/s
    head = [*lines[:5], lines[5].replace("omega", "log_j_rot")]
    turned.write_text("\n".join([*head, *(" ".join(row) for row in rows)]))
    expected = read_progenitor(MESA).angular_velocity
    np.testing.assert_allclose(read_progenitor(turned).angular_velocity, expected, rtol=1e-9)


def mesa_file(file, columns, said=None):
    """The example as MESA writes it with other columns, and with more values of the whole star."""
    said = {"model_number": "1", "num_zones": "160", **(said or {})}
    rows = [" ".join(map(str, row)) for row in zip(*(values[::-1] for values in columns.values()), strict=True)]
    head = [" ".join(str(k + 1) for k in range(len(table))) + "\n" + " ".join(table) for table in (said, columns)]
    file.write_text("\n".join([head[0], " ".join(said.values()), "", head[1], *rows, ""]))
    return file


def example_columns():
    star = read_progenitor(MESA)
    return {
        "mass": star.mass / SOLAR_MASS,
        "logM": np.log10(star.mass / SOLAR_MASS),
        "log_mass": np.log10(star.mass / SOLAR_MASS),
        "mass_grams": star.mass * 1e3,
        "radius": star.radius / SOLAR_RADIUS,
        "logR": np.log10(star.radius / SOLAR_RADIUS),
        "radius_cm": star.radius * 1e2,
        "logR_cm": np.log10(star.radius * 1e2),
        "radius_km": star.radius / 1e3,
        "density": star.density / 1e3,
    }


@pytest.mark.parametrize("mass", ["mass", "logM", "log_mass", "mass_grams"])
@pytest.mark.parametrize("radius", ["radius", "logR", "radius_cm", "logR_cm", "radius_km"])
def test_a_profile_of_mesa_has_mass_and_radius_by_any_of_their_names(tmp_path, mass, radius):
    columns = example_columns()
    found = read_progenitor(mesa_file(tmp_path / "profile.data", {name: columns[name] for name in (radius, mass)}))
    same = read_progenitor(MESA)
    np.testing.assert_allclose(found.mass, same.mass, rtol=1e-13)
    np.testing.assert_allclose(found.radius, same.radius, rtol=1e-13)


def test_densities_of_a_profile_of_mesa_may_be_called_so(tmp_path):
    columns = example_columns()
    found = read_progenitor(mesa_file(tmp_path / "profile.data", {n: columns[n] for n in ("density", "radius_km")}))
    np.testing.assert_allclose(found.mass, read_progenitor(MESA).mass, rtol=1e-12)


@pytest.mark.parametrize(("mass", "radius"), [("mass", "radius"), ("logM", "logR")])
def test_a_profile_of_mesa_says_how_much_the_sun_is(tmp_path, mass, radius):
    """Versions differ by 4e-4; numbers in grams and centimetres don't depend on it."""
    columns, said = example_columns(), {"version_number": '"10398"', "msun": "1.9892D+33", "rsun": "6.9598E+010"}
    found = read_progenitor(mesa_file(tmp_path / "one", {name: columns[name] for name in (mass, radius)}, said))
    same = read_progenitor(MESA)
    np.testing.assert_allclose(found.mass, same.mass * 1.9892e30 / SOLAR_MASS, rtol=1e-13)
    np.testing.assert_allclose(found.radius, same.radius * 6.9598e8 / SOLAR_RADIUS, rtol=1e-13)
    in_cgs = {name: columns[name] for name in ("mass_grams", "radius_cm")}
    np.testing.assert_allclose(read_progenitor(mesa_file(tmp_path / "two", in_cgs, said)).mass, same.mass, rtol=1e-13)


@pytest.mark.parametrize("wind", ["# wind", "wind:", "161"])
def test_what_keplers_own_writer_puts_around_the_cells(tmp_path, wind):
    """Two dozen lines about the model, a line of units, and the wind, which has a mass but no radius."""
    _, head, *rows = KEPLER.read_text().splitlines()
    names = re.split(r"\s{2,}", head.strip().removeprefix("grid").strip())
    lines = ["# VERSION  10104", *(f"# {'UUID':<25s} {k}" for k in range(22)), "#"]
    lines.append("# grid" + "".join(f"{name:>25}" for name in names))
    lines.append("# unit" + "".join(f"{unit:>25}" for unit in ("g", "cm", "cm/sec", "g/cm**3")))
    lines += [row.replace(":", " ") for row in rows] + [wind + f"{5e33:>25.17e}" + f"{'-':>25}" * (len(names) - 1)]
    file = tmp_path / "star@presn"
    file.write_text("\n".join(lines) + "\n\n")
    star, same = read_progenitor(file), read_progenitor(KEPLER)
    for column in ("mass", "radius", "pressure", "internal_energy", "angular_velocity"):
        np.testing.assert_array_equal(getattr(star, column), getattr(same, column))


def test_shells_whose_masses_are_rounded_to_one_number_are_one_shell(tmp_path):
    """Near the surface of a table of few digits: I is then known to half a unit of the last at the surface."""
    columns, same = example_columns(), read_progenitor(MESA)
    columns["mass"] = np.array([float(f"{mass:.3g}") for mass in columns["mass"]])
    rounded = mesa_file(tmp_path / "profile.data", {name: columns[name] for name in ("radius_cm", "mass", "density")})
    found = read_progenitor(rounded)
    assert np.unique(columns["mass"]).size == found.mass.size < same.mass.size
    assert found.mass[-1] == pytest.approx(same.mass[-1], rel=1e-13)
    assert found.radius[-1] == pytest.approx(same.radius[-1], rel=1e-13)
    half_a_unit = 2 / 3 * 0.005 * SOLAR_MASS * same.radius[-1] ** 2
    assert abs(found.moment_of_inertia - same.moment_of_inertia) < half_a_unit


def test_a_wrong_row_is_that_of_the_file_whichever_way_round(tmp_path):
    columns = {name: values.copy() for name, values in example_columns().items() if name in ("radius", "mass")}
    columns["mass"][-3] = columns["mass"][-1]  # the third from the surface, and so the third row
    file = mesa_file(tmp_path / "profile.data", columns)
    with pytest.raises(SceneError, match=r"the mass does not rise at row 2$"):
        read_progenitor(file)


def test_committed_files_are_what_the_program_writes(tmp_path):
    runpy.run_path(str(ROOT / "sims" / "progenitor_tables.py"))["main"](tmp_path)
    for file in (MESA, KEPLER):
        for one, two in zip(file.read_text().split(), (tmp_path / file.name).read_text().split(), strict=True):
            assert one == two or float(one) == pytest.approx(float(two), rel=1e-9)


@pytest.mark.parametrize("name", [" [{0:02d} {1:>28}]  ", " [ {0} {1:<28} ] "])
def test_names_in_brackets_may_be_padded_on_either_side(tmp_path, name):
    """Phantom writes such files, with its name of the energy."""
    lines = KEPLER.read_text().splitlines()
    names = ["grid", *re.split(r"\s{2,}", lines[1].strip().removeprefix("grid").strip())]
    head = "#" + "".join(name.format(k, word) for k, word in enumerate(names, 1))
    file = tmp_path / "kepler"
    file.write_text("\n".join([lines[0], head.replace("specific energy", "spec. int. energy"), *lines[2:]]))
    star, same = read_progenitor(file), read_progenitor(KEPLER)
    for column in ("mass", "radius", "pressure", "internal_energy", "angular_velocity"):
        np.testing.assert_array_equal(getattr(star, column), getattr(same, column))


def test_what_phantom_writes_now_has_names_of_22_characters(tmp_path):
    """The mass is abbreviated, and what KEPLER has of velocity and pressure is not there."""
    _, head, *rows = KEPLER.read_text().splitlines()
    names = ["grid", *re.split(r"\s{2,}", head.strip().removeprefix("grid").strip())]
    kept = [names.index(name) for name in ("grid", "cell outer total mass", "cell outer radius", "cell density")]
    head = "#" + "".join(f"{names[k].replace('total', 'tot.'):>22} " for k in kept)
    values = [row.replace(":", " ").split() for row in rows]
    lines = [
        "# 10000   # Version",
        "# 1.0   # Dump file number",
        head,
        *(" ".join(row[k] for k in kept) for row in values),
    ]
    file = tmp_path / "ptok00001"
    file.write_text("\n".join(lines) + "\n")
    star, same = read_progenitor(file), read_progenitor(KEPLER)
    np.testing.assert_array_equal(star.mass, same.mass)
    np.testing.assert_array_equal(star.radius, same.radius)
    assert star.pressure is None and star.angular_velocity is None


def test_masses_are_read_and_not_made_of_densities(tmp_path):
    """Of a file whose densities are 5% too high."""
    head, rows = KEPLER.read_text().splitlines()[:2], [line.split() for line in KEPLER.read_text().splitlines()[2:]]
    for row in rows:
        row[4] = repr(1.05 * float(row[4]))
    file = tmp_path / "high"
    file.write_text("\n".join([*head, *(" ".join(row) for row in rows)]))
    assert read_progenitor(file).mass[-1] == pytest.approx(STAR.mass, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("file", [MESA, KEPLER], ids=["mesa", "kepler"])
def test_particles_have_mass_inertia_and_spin_of_the_table(file):
    """Mass and I to round-off; L to the noise of a glass; where they stand and their entropy, as the table has it."""
    shells = read_progenitor(file).inner(1.4 * SOLAR_MASS)
    scene = scene_of(file)
    body, units, ball = placed(scene)
    assert units.to_si(body.mass.sum(), "mass") == pytest.approx(1.4 * SOLAR_MASS, rel=1e-12)
    moment = 2 * (body.mass @ body.position[:, 0] ** 2)
    assert units.to_si(moment, "moment_of_inertia") == pytest.approx(shells.moment_of_inertia, rel=1e-10)
    spin = body.mass @ np.cross(body.position, body.velocity)
    assert units.to_si(spin[2], "angular_momentum") == pytest.approx(shells.angular_momentum, rel=5e-3)
    assert np.abs(spin[:2]).max() < 1e-2 * spin[2]
    pressure, density = ball.densest()
    assert units.to_si(density, "density") == pytest.approx(STAR.central_density, rel=5e-3)
    assert units.to_si(pressure, "pressure") == pytest.approx(STAR.central_pressure, rel=5e-3)
    # A polytrope of index 3 has one entropy function for gamma = 4/3 throughout.
    assert body.entropy is not None
    assert np.ptp(body.entropy) < 1e-2 * body.entropy.mean()
    # Half of the mass within the radius that the table says.
    away = np.linalg.norm(body.position, axis=1)
    half = np.interp(0.7 * SOLAR_MASS, shells.mass, shells.radius)
    assert units.to_si(np.median(away), "length") == pytest.approx(half, rel=0.01)


def test_shells_turn_as_fast_as_asked():
    body, units, _ = placed(scene_of(KEPLER))
    double, *_ = placed(scene_of(KEPLER, "body.rotation_factor=2.0"))
    still, *_ = placed(scene_of(KEPLER, "body.rotation_factor=0.0"))
    assert np.allclose(double.velocity, 2 * body.velocity, rtol=1e-14) and not still.velocity.any()
    rigid, *_ = placed(scene_of(KEPLER, 'body.rotation.rate="3 rad/s"'))
    rate = units.to_code(3.0, "angular_velocity")
    assert np.allclose(rigid.velocity, np.cross([0, 0, rate], rigid.position), rtol=1e-12)


def test_csv_takes_any_units_and_either_order(tmp_path):
    star = read_progenitor(MESA)
    j = 8 / 3 * star.radius**2 / (1 + (star.radius / 1e6) ** 2)
    rows = np.array([star.radius / 1e3, star.mass / SOLAR_MASS, star.pressure * 10, j * 1e4]).T
    for name, ordered in (("out", rows), ("in", rows[::-1])):
        file = tmp_path / f"{name}.csv"
        text = "\n".join(",".join(map(repr, map(float, row))) for row in ordered)
        comment = "# " if name == "in" else ""
        file.write_text(f"# a star\n{comment}radius (km), mass [Msun], pressure (dyn/cm2), j [ cm2/s ]\n{text}\n")
        found = read_progenitor(file)
        for column in ("mass", "radius", "pressure", "angular_velocity"):
            assert np.allclose(getattr(found, column), getattr(star, column), rtol=1e-9), column


def test_density_alone_gives_masses_and_temperature_a_pressure(tmp_path):
    star = read_progenitor(KEPLER)
    temperature = star.pressure / star.density * 2.0 * ATOMIC_MASS / BOLTZMANN_CONSTANT
    file = tmp_path / "warm.csv"
    rows = "\n".join(
        f"{r!r},{d!r},{t!r}"
        for r, d, t in zip(*map(np.ndarray.tolist, (star.radius, star.density, temperature)), strict=True)
    )
    file.write_text(f"radius (m), density (kg/m3), temperature (K)\n{rows}\n")
    found = read_progenitor(file, 2.0)
    assert np.allclose(found.mass, star.mass, rtol=1e-10)
    assert np.allclose(found.pressure, star.pressure, rtol=1e-10)
    assert read_progenitor(file).pressure is None


@pytest.mark.full
def test_a_profile_without_pressure_is_put_into_equilibrium(tmp_path):
    star = read_progenitor(KEPLER)
    file = tmp_path / "cold.csv"
    rows = "\n".join(f"{r!r},{m!r}" for r, m in zip(star.radius.tolist(), star.mass.tolist(), strict=True))
    file.write_text(f"radius (m), mass (kg)\n{rows}\n")
    scene = load.loads(SCENE.replace("FILE", str(file)).replace('inner_mass = "1.4 Msun"\n', ""))
    _, units, ball = placed(scene)
    assert units.to_si(ball.densest()[0], "pressure") == pytest.approx(STAR.central_pressure, rel=1e-2)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "it is empty"),
        ("radius (km), mass\n1,2\n", "must be a name and a unit"),
        ("radius (km), mass [km]\n" + "1,2\n" * 9, r"the unit of mass: '1 km' is not a mass"),
        ("radius (km), colour (m)\n1,2\n", "not one of radius"),
        ("radius (furlongs per hour), mass (kg)\n" + "1,2\n" * 9, "furlongs"),
        ("radius (m), mass (kg)\n" + "".join(f"{k + 1},{k + 1}\n" for k in range(5)), "5 shells"),
        ("radius (m), mass (kg)\n" + "".join(f"{k + 1},{9 - k}\n" for k in range(9)), "mass does not rise"),
        (
            "radius (m), mass (kg)\n" + "".join(f"{k // 2 + 1},{k + 1}\n" for k in range(9)),
            "radius does not rise at row 2",
        ),
        ("radius (m), mass (kg)\n" + "".join(f"{k + 1},nan\n" for k in range(9)), "not finite"),
        ("radius (m), mass (kg)\n1,2\n__import__('os'),3\n", "is not a number but '__import__('os')'"),
        ("radius (m), mass (kg)\n1,2\n3\n", "another length"),
        ("pressure (Pa), mass (kg)\n" + "".join(f"{k + 1},{k + 1}\n" for k in range(9)), "needs a column of radius"),
        (
            "radius (m), mass (kg), density (g/cm3)\n"
            + "".join(f"{k + 1},{(k + 1) ** 3 * 4188.79},1000\n" for k in range(9)),
            "1e+03 times off",
        ),
        (
            "radius (m), density (kg/m3)\n" + "".join(f"{k + 1},{8 - k}\n" for k in range(9)),
            "density of row 9 is not positive: it is that of the shell out to the row's radius",
        ),
    ],
)
def test_what_is_wrong_with_a_file_is_reported(tmp_path, text, message):
    file = tmp_path / "bad.csv"
    file.write_text(text)
    with pytest.raises(SceneError) as refused:
        read_progenitor(file)
    assert message in str(refused.value) and "\n" not in str(refused.value)


def saved(star, tmp_path, change=lambda text: text):
    """A star as MESA saves its models: from the surface inwards, natural logarithms in cgs, D for the power of ten."""
    shares = np.diff(star.mass, prepend=0.0) / star.mass[-1]
    of_edge = np.interp(star.radius, 0.5 * (star.radius + np.append(0.0, star.radius[:-1])), star.angular_velocity)
    columns = {"lnd": np.log(star.density / 1e3), "lnR": np.log(star.radius * 100), "L": 0 * shares, "dq": shares,
               "omega": of_edge, "h1": 0 * shares + 1}  # fmt: skip
    rows = [f"{k + 1:5d} " + " ".join(f"{value:26.16e}" for value in row) for k, row in
            enumerate(np.array(list(columns.values())).T[::-1])]  # fmt: skip
    said = {"version_number": "'r24.08.1'", "M/Msun": f"{star.mass[-1] / SOLAR_MASS:.16e}", "species": 1}
    head = [
        "! note: initial lines of file can contain comments",
        "!",
        "  8 -- model for mesa/star, dq=fraction of mstar",
    ]
    text = "\n".join([*head, "", *(f"{name:>32}  {value}" for name, value in said.items()), "",
                      " ".join(f"{name:>26}" for name in columns), *rows, "", "        previous model", "",
                      f"{'previous n_shells':>32}  {len(shares)}", ""])  # fmt: skip
    (tmp_path / "star.mod").write_text(change(re.sub(r"(\d)e([+-])", r"\1D\2", text)))
    return read_progenitor(tmp_path / "star.mod")


def test_a_model_that_mesa_has_saved_is_its_star(tmp_path):
    star = read_progenitor(MESA)
    found = saved(star, tmp_path)
    np.testing.assert_allclose(found.mass, star.mass, rtol=1e-13)
    np.testing.assert_allclose(found.radius, star.radius, rtol=1e-13)
    assert found.moment_of_inertia == pytest.approx(star.moment_of_inertia, rel=1e-13)
    assert found.angular_momentum == pytest.approx(star.angular_momentum, rel=1e-3)
    assert found.pressure is None
    for old, new, message in (
        ("M/Msun", "M/Mearth", "without its mass"),
        (" dq", " dm", "or shells"),
        ("species", "R_center", "core is cut out"),
        ("D-01 ", "D-01 1 ", "row 1 has 8 values, not 7"),
    ):
        with pytest.raises(SceneError, match=message):
            saved(star, tmp_path, lambda text, old=old, new=new: text.replace(old, new))
    with pytest.raises(SceneError, match="times off what its masses"):  # of a mass in other units
        saved(star, tmp_path, lambda text: re.sub(r"(M/Msun +)", r"\g<1>9", text))


@pytest.mark.parametrize("file", [MESA, KEPLER])
def test_a_profile_that_gzip_has_packed_is_the_same_star(tmp_path, file):
    (tmp_path / f"{file.name}.gz").write_bytes(gzip.compress(file.read_bytes().replace(b"\n", b"\r\n")))
    found, known = read_progenitor(tmp_path / f"{file.name}.gz"), read_progenitor(file)
    np.testing.assert_array_equal(found.mass, known.mass)
    np.testing.assert_array_equal(found.angular_velocity, known.angular_velocity)
    rows = "\n".join(f"{r},{r}" for r in range(1, 20))
    (tmp_path / "p.csv.gz").write_bytes(gzip.compress(f"radius (km), mass (kg)\n{rows}".encode()))
    assert read_progenitor(tmp_path / "p.csv.gz").radius[0] == 1e3
    (tmp_path / "bomb.gz").write_bytes(gzip.compress(b" " * 68_000_000))
    with pytest.raises(SceneError, match="unpacks to more than the 64 MiB allowed"):
        read_progenitor(tmp_path / "bomb.gz")


def test_limits_and_unknown_formats_are_reported(tmp_path):
    file = tmp_path / "strange"
    file.write_text("hello\n")
    with pytest.raises(SceneError, match="none of the known formats"):
        read_progenitor(file)
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneError, match="not text"):
        read_progenitor(file)
    file.write_text("1 " * 40_000)
    with pytest.raises(SceneError, match="a line of more than"):
        read_progenitor(file)
    file.write_text("1\n" * 300_000)
    with pytest.raises(SceneError, match="more than 200000 shells"):
        read_progenitor(file)
    with pytest.raises(SceneError, match="not there"):
        read_progenitor(tmp_path / "nowhere")
    with pytest.raises(SceneError, match="is a directory"):
        read_progenitor(tmp_path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ('body.inner_mass = "3 Msun"', "inner_mass: the profile has 3.97"),
        ("body.relax = true", "placed as the file has it"),
        ('units = "code"', "needed for a body of kind profile"),
        ('model = "ellipsoid"', "is for the model sph"),
    ],
)
def test_scenes_that_cannot_be_are_refused(change, message):
    text = SCENE.replace("FILE", str(KEPLER))
    if change.startswith("units"):
        text = text.replace('[units]\nmass = "1 Msun"\nlength = "1000 km"\n', "")
        text = text.replace('name = "progenitor"', 'name = "progenitor"\nunits = "code"')
        text = text.replace('"1.4 Msun"', "1.4").replace('"1 ms"', "1.0")
        change = "name = other"
    with pytest.raises(SceneError) as refused:
        placed(load.loads(text, [change]))
    assert message in str(refused.value)


def test_the_plan_says_the_moment_ratio_and_the_mean_spin_of_the_profile():
    """Of the whole star: those of the n = 3 polytrope, and twice the file's L over I."""
    scene = load.loads(SCENE.replace("FILE", str(KEPLER)).replace('inner_mass = "1.4 Msun"', "rotation_factor = 2.0"))
    lines = {line[0]: line[1:] for line in scene.body.describe(scene)}
    assert float(lines["moment of inertia"][0].removesuffix(" kg m2")) == pytest.approx(
        STAR.moment_of_inertia, rel=4e-4
    )
    ratio = STAR.moment_of_inertia / (STAR.mass * STAR.radius**2)
    assert float(lines["moment of inertia"][1].removesuffix(" M R^2")) == pytest.approx(ratio, rel=4e-4)
    star = read_progenitor(KEPLER)
    rate = lines["shells turn"][1].removeprefix("about z, in the mean (L/I) at ").removesuffix(" rad/s")
    assert float(rate) == pytest.approx(2.0 * star.angular_momentum / star.moment_of_inertia, rel=1e-5)


def test_the_plan_tells_of_the_profile():
    text = plan(scene_of(KEPLER)).text()
    assert "the inner 2.78377e+30 kg" in text and "1 times as fast as the file says" in text
    assert "2.78377e+30 kg within" in text and "its size is not known" not in text
