"""Snapshots that other codes wrote, as bodies: units of each, and what is refused with one sentence."""

import re

import h5py
import numpy as np
import pytest

import astroinertia
from astroinertia.errors import SceneError
from astroinertia.run.loop import run_scene
from astroinertia.scene.load import loads
from astroinertia.scene.plan import code_units, plan
from astroinertia.sph.table import read_body, read_table
from astroinertia.studies.moments import read_matter
from astroinertia.units import DIMENSIONLESS, PARSEC, SOLAR_MASS, CodeUnits

COUNT = 6
GALACTIC = CodeUnits(1e10 * SOLAR_MASS, 1e3 * PARSEC)
SINGLE = np.random.default_rng(8).random((COUNT, 8)).astype(np.float32)  # most codes write single precision
VALUES = SINGLE.astype(float)
GADGET_UNITS = {"UnitLength_in_cm": 3.085678e21, "UnitMass_in_g": 1.989e43, "UnitVelocity_in_cm_per_s": 1e5}


def fill(file, kind=0, energy="InternalEnergy"):
    header = file.require_group("Header").attrs
    header["NumPart_ThisFile"] = [COUNT if number == kind else 0 for number in range(6)]
    header["MassTable"], header["NumFilesPerSnapshot"], header["Redshift"] = np.zeros(6), 1, 0.0
    particles = file.create_group(f"PartType{kind}")
    particles["Masses"], particles[energy] = SINGLE[:, 0], SINGLE[:, 7]
    particles["Coordinates"], particles["Velocities"] = SINGLE[:, 1:4], SINGLE[:, 4:7]
    particles["ParticleIDs"] = np.arange(COUNT)


def written(path, *steps):
    with h5py.File(path, "w") as file:
        for step in steps:
            step(file)
    return path


def gadget4(file):
    fill(file)
    file.create_group("Parameters").attrs.update(GADGET_UNITS | {"HubbleParam": 1.0, "ComovingIntegrationOn": 0})


def gizmo(file):
    fill(file)
    units = {"UnitLength_In_CGS": 3.085678e21, "UnitMass_In_CGS": 1.989e43, "UnitVelocity_In_CGS": 1e5}
    file["Header"].attrs.update(units)


def swift(file):
    fill(file, energy="InternalEnergies")
    time = 3.085678e21 / 1e5
    units = {"length in cgs (U_L)": 3.085678e21, "mass in cgs (U_M)": 1.989e43, "time in cgs (U_t)": time}
    file.create_group("Units").attrs.update({f"Unit {name}": np.array([value]) for name, value in units.items()})
    file.create_group("Cosmology").attrs["Cosmological run"] = np.array([0])


@pytest.mark.parametrize("write", [gadget4, gizmo, swift], ids=lambda write: write.__name__)
def test_units_of_each_code_become_si(tmp_path, write):
    table = read_table(written(tmp_path / "snap.hdf5", write))
    assert table.units == "SI"
    # the unit of length of these codes is a kiloparsec, that of mass 1e10 solar masses, to the digits they write
    np.testing.assert_allclose(table.position, VALUES[:, 1:4] * 1e3 * PARSEC, rtol=1e-6)
    np.testing.assert_allclose(table.mass, VALUES[:, 0] * 1e10 * SOLAR_MASS, rtol=1e-3)
    np.testing.assert_allclose(table.velocity, VALUES[:, 4:7] * 1e3, rtol=1e-7)
    np.testing.assert_allclose(table.internal_energy, VALUES[:, 7] * 1e6, rtol=1e-7)


def test_without_units_the_numbers_are_in_those_of_the_scene(tmp_path):
    path = written(tmp_path / "snap.hdf5", fill)
    for units in (DIMENSIONLESS, GALACTIC):
        table = read_body(path, units)
        assert table.units == "unknown"
        np.testing.assert_array_equal(table.mass, VALUES[:, 0])
        np.testing.assert_array_equal(table.velocity, VALUES[:, 4:7])
    fast = read_body(path, GALACTIC, velocity_unit=1e3)
    np.testing.assert_allclose(fast.velocity, VALUES[:, 4:7] * 1e3 / GALACTIC.unit("velocity"), rtol=1e-14)
    np.testing.assert_allclose(fast.internal_energy, VALUES[:, 7] * 1e6 / GALACTIC.unit("specific_energy"), rtol=1e-14)
    with pytest.raises(SceneError, match='velocity_unit, but units = "code"'):
        read_body(path, DIMENSIONLESS, velocity_unit=1e3)
    assert read_matter(path, ("Msun", "kpc")).units == ("kg", "m")


def test_with_units_it_needs_no_others(tmp_path):
    path = written(tmp_path / "snap.hdf5", gadget4)
    np.testing.assert_allclose(read_body(path, GALACTIC).velocity, VALUES[:, 4:7] * 1e3 / GALACTIC.unit("velocity"))
    with pytest.raises(SceneError, match="velocity_unit, but its file has units"):
        read_body(path, GALACTIC, velocity_unit=1e3)
    with pytest.raises(SceneError, match="says which units it is in; leave --units out"):
        read_matter(path, ("Msun", "kpc"))
    assert read_matter(path).units == ("kg", "m")


def test_columns_of_one_number_a_row_may_have_two_dimensions(tmp_path):
    def upright(file):
        for name in ("Masses", "InternalEnergy"):
            del file[f"PartType0/{name}"]
        file["PartType0/Masses"], file["PartType0/InternalEnergy"] = SINGLE[:, :1], SINGLE[:, 7:]

    table = read_table(written(tmp_path / "snap.hdf5", fill, upright))
    np.testing.assert_array_equal(table.mass, VALUES[:, 0])
    np.testing.assert_array_equal(table.internal_energy, VALUES[:, 7])


def test_a_dimensionless_scene_has_it_in_its_own_units_with_g_of_one(tmp_path):
    """In kpc, 10^10 solar masses and km/s G is 43007: there velocities are over its root, and energies over it."""
    own = read_body(written(tmp_path / "snap.hdf5", gadget4), DIMENSIONLESS)
    np.testing.assert_allclose(own.position, VALUES[:, 1:4], rtol=1e-14)
    np.testing.assert_allclose(own.mass, VALUES[:, 0], rtol=1e-14)
    np.testing.assert_allclose(own.velocity**2 * 43007.1, VALUES[:, 4:7] ** 2, rtol=1e-3)
    np.testing.assert_allclose(own.internal_energy * 43007.1, VALUES[:, 7], rtol=1e-3)


def test_a_constant_of_nearly_one_in_the_units_of_a_file_is_one(tmp_path):
    """Codes have had values of G that differ by 1e-3: a file in units of G = 1 by one of them keeps its velocities."""
    length, mass = 1e12, 1e33  # cm and g
    for constant, over in ((6.672e-8, 1.0), (6.6e-8, (6.6743e-8 / 6.6e-8) ** 0.5)):
        units = dict(zip(GADGET_UNITS, (length, mass, (constant * mass / length) ** 0.5), strict=True))

        def own(file, units=units):
            fill(file)
            file.create_group("Parameters").attrs.update(units | {"HubbleParam": 0.0})  # as without an expansion

        found = read_body(written(tmp_path / "snap.hdf5", own), DIMENSIONLESS).velocity
        np.testing.assert_allclose(found, VALUES[:, 4:7] / over, rtol=1e-12 if over == 1.0 else 1e-5)


def evrard(file):
    """As the initial conditions of SWIFT's example: a box far larger than the sphere, and units of 1."""
    fill(file)
    file["Header"].attrs.update({"BoxSize": [100.0] * 3, "Flag_Entropy_ICs": 0, "Dimension": 3, "Time": 0.0})
    file["PartType0/SmoothingLength"] = file["PartType0/Density"] = SINGLE[:, 0]
    file["PartType0/MaterialIDs"] = np.zeros(COUNT, np.uint64)
    names = ("length in cgs (U_L)", "mass in cgs (U_M)", "time in cgs (U_t)", "current in cgs (U_I)",
             "temperature in cgs (U_T)")  # fmt: skip
    file.create_group("Units").attrs.update({f"Unit {name}": 1.0 for name in names})


def test_units_of_one_are_none_where_the_scene_has_none(tmp_path):
    path = written(tmp_path / "evrard.hdf5", evrard)
    own = read_body(path, DIMENSIONLESS)
    np.testing.assert_allclose(own.velocity, VALUES[:, 4:7], rtol=1e-14)
    np.testing.assert_allclose(own.internal_energy, VALUES[:, 7], rtol=1e-14)
    np.testing.assert_allclose(read_table(path).position, VALUES[:, 1:4] / 100, rtol=1e-14)  # else they are cgs
    with pytest.raises(SceneError, match=r"whose file evrard\.hdf5 states no units"):
        loads(SCENE.format(units="", body="", end='"1 s"').replace("snap", "evrard"), origin=str(tmp_path))
    # a snapshot of a run has the G of its parameter file, as text
    for constant, over in ((b"1.0", 1.0), (b"1.002", 1.002**0.5), (b"4.0", 2.0)):
        snapshot = written(
            tmp_path / "snap.hdf5", evrard, attribute("Parameters", "PhysicalConstants:G", np.bytes_(constant))
        )
        np.testing.assert_allclose(read_body(snapshot, DIMENSIONLESS).velocity, VALUES[:, 4:7] / over, rtol=1e-14)


SCENE = """
name = "own"
model = "sph"
{units}
[body]
kind = "table"
file = "snap.hdf5"
{body}
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = {end}
"""


def scene_of(folder, units="", body="", end='"1 Gyr"'):
    return loads(SCENE.format(units=units, body=body, end=end), origin=str(folder))


def test_a_scene_without_units_has_those_that_its_file_states(tmp_path):
    written(tmp_path / "snap.hdf5", gadget4)
    scene = scene_of(tmp_path)
    assert code_units(scene).mass == pytest.approx(1e10 * SOLAR_MASS, rel=1e-3)
    assert code_units(scene).length == pytest.approx(1e3 * PARSEC, rel=1e-6)
    (tmp_path / "snap.hdf5").unlink()  # what a run keeps of its scene needs the file no more
    assert code_units(loads(scene.to_toml())) == code_units(scene)
    written(tmp_path / "snap.hdf5", fill)
    with pytest.raises(SceneError, match=r"of kind table, whose file snap\.hdf5 states no units") as refused:
        scene_of(tmp_path)
    # the recipe of the refusal gives the units that files of GADGET have where they state them
    recipe = re.search(r'\[units\] (mass = ".*"), (length = ".*") and \[body\] (.*)\.$', str(refused.value))
    assert recipe is not None
    stated = scene_of(tmp_path, f"units = {{{recipe[1]}, {recipe[2]}}}", recipe[3])
    assert code_units(stated).mass == pytest.approx(code_units(scene).mass, rel=1e-3)
    assert code_units(stated).length == pytest.approx(code_units(scene).length, rel=1e-6)
    assert stated.body.velocity_unit == 1e3
    (tmp_path / "snap.hdf5").unlink()
    with pytest.raises(SceneError, match=r"snap\.hdf5 is not there"):
        scene_of(tmp_path)


def test_the_plan_says_what_is_in_the_table(tmp_path):
    written(tmp_path / "snap.hdf5", gadget4)
    text = plan(scene_of(tmp_path)).text()
    mass, fast = VALUES[:, 0].sum() * 1.989e40, VALUES[:, 4:7]
    about = np.linalg.norm(fast - VALUES[:, 0] @ fast / VALUES[:, 0].sum(), axis=1).max() * 1e3
    for words in (f"particles: {COUNT} (from the table snap.hdf5", "columns: mass x y z vx vy vz u", "as it states",
                  f"mass: {mass:.6g} kg", f"velocities: up to {about:.6g} m s-1", "internal energies: "):  # fmt: skip
        assert words in text
    written(tmp_path / "snap.hdf5", fill, without("PartType0/Velocities"), without("PartType0/InternalEnergy"))
    text = plan(scene_of(tmp_path, 'units = "code"', "specific_internal_energy = 1.0", "1.0")).text()
    for words in ("velocities: none (at rest)", "internal energies: none", "none stated"):
        assert words in text


@pytest.mark.full(inputs=["sims/evrard.toml"])
def test_the_example_of_swift_runs_as_it_stands(tmp_path):
    """Evrard's sphere in the middle of SWIFT's box of 100: energies are those of the problem, for G is 1."""
    count = 100
    random = np.random.default_rng(5)
    along = random.normal(size=(count, 3))
    place = along / np.linalg.norm(along, axis=1)[:, None] * np.sqrt((np.arange(count) + 0.5) / count)[:, None]

    def sphere(file):
        evrard(file)
        del file["PartType0"]
        file["PartType0/Coordinates"], file["PartType0/Velocities"] = place + 50.0, np.zeros((count, 3))
        file["PartType0/Masses"], file["PartType0/InternalEnergy"] = np.full(count, 0.01), np.full(count, 0.05)

    written(tmp_path / "snap.hdf5", sphere)
    scene = scene_of(tmp_path, 'units = "code"', end="0.01")
    series = astroinertia.open(run_scene(scene, tmp_path / "run"))
    first = series.isel(time=0)
    assert float(first["internal_energy"]) == pytest.approx(0.05, rel=1e-12)
    assert float(first["gravitational_energy"]) == pytest.approx(-2 / 3, rel=0.15)  # softened, of 100 particles
    np.testing.assert_allclose(first["centre_of_mass"], 50.0 + place.mean(axis=0), rtol=1e-12)
    assert float(series["kinetic_energy"][-1]) > 0


def test_masses_may_stand_in_the_header_and_particles_be_of_another_type(tmp_path):
    def equal_masses(file):
        fill(file, kind=1)
        del file["PartType1/Masses"]
        file["Header"].attrs["MassTable"] = [0.0, 0.25, 0.0, 0.0, 0.0, 0.0]

    table = read_table(written(tmp_path / "snap.hdf5", equal_masses))
    assert table.mass.tolist() == [0.25] * COUNT
    np.testing.assert_array_equal(table.position, VALUES[:, 1:4])


@pytest.mark.parametrize(
    ("said", "size"), [("swift", [4.0, 5.0, 6.0]), ("gadget4", 5.0), ("not by swift", [4.0, 5.0, 6.0]), ("", 5.0)]
)
def test_a_body_across_the_faces_of_a_periodic_box_is_put_together(tmp_path, said, size):
    """A ball in the corner of a box, or cube: its tensor is that of the ball where the file says periodic."""
    count, box = 40, np.broadcast_to(size, 3)
    random = np.random.default_rng(3)
    ball, mass = random.uniform(-0.8, 0.8, (count, 3)), random.uniform(1.0, 2.0, count)

    def corner(file):
        fill(file)
        del file["PartType0"]
        file["PartType0/Coordinates"], file["PartType0/Masses"] = (ball + [0.1, 2.5, box[2] - 0.1]) % box, mass
        file["Header"].attrs["BoxSize"] = size
        if "swift" in said:
            periodic = b"1" if said == "swift" else b"0"
            file.create_group("Parameters").attrs["InitialConditions:periodic"] = np.bytes_(periodic)
        elif said == "gadget4":
            file.create_group("Config").attrs["PERIODIC"] = ""

    matter = read_matter(written(tmp_path / "snap.hdf5", corner))
    distance = ball - mass @ ball / mass.sum()
    expected = np.diag([mass @ (distance**2).sum(axis=1)] * 3) - np.einsum("n,ni,nj", mass, distance, distance)
    if said in ("swift", "gadget4"):
        np.testing.assert_allclose(matter.body.inertia, expected, rtol=1e-13, atol=1e-12)
        assert "put together across faces of a periodic box along x, z" in matter.text
    else:
        assert matter.body.inertia[1, 1] > 5 * expected[1, 1]
        assert matter.text == "40 particles"


def test_a_medium_that_fills_a_periodic_box_stays_as_it_is(tmp_path):
    place = np.random.default_rng(3).uniform(0.0, 1.0, (200, 3))

    def medium(file):
        fill(file)
        del file["PartType0"]
        file["PartType0/Coordinates"], file["PartType0/Masses"] = place, np.ones(200)
        file["Header"].attrs["BoxSize"] = [1.0] * 3
        file.create_group("Parameters").attrs["InitialConditions:periodic"] = np.bytes_(b"1")

    np.testing.assert_array_equal(read_table(written(tmp_path / "snap.hdf5", medium)).position, place)


def attribute(group, name, value):
    def step(file):
        file.require_group(group).attrs[name] = value

    return step


def without(name):
    def step(file):
        del file[name]

    return step


def two_types(file):
    fill(file, kind=1)


def elsewhere(file):
    del file["PartType0/Masses"]
    file["PartType0/Masses"] = h5py.ExternalLink("/etc/hostname", "Masses")


def flat(file):
    del file["PartType0/Coordinates"]
    file["PartType0/Coordinates"] = np.ones((COUNT, 2))


def huge(file):
    del file["PartType0/Coordinates"]
    file.create_dataset("PartType0/Coordinates", shape=(10**12, 3), chunks=(1000, 3), dtype="f8")


def short(file):
    del file["PartType0/Masses"]
    file["PartType0/Masses"] = np.ones(COUNT - 1)


BAD = {
    "several types": ([gadget4, two_types], "has particles of PartType0 and PartType1; a body is of one type"),
    "no particles": ([gadget4, without("PartType0/Coordinates"), without("PartType0/Masses"),
                      without("PartType0/Velocities"), without("PartType0/InternalEnergy")], "particles of no type"),
    "a part": ([gadget4, attribute("Header", "NumFilesPerSnapshot", 2)], "one of several files of a snapshot"),
    "redshift": ([gadget4, attribute("Header", "Redshift", 0.5)], "expanding universe"),
    "comoving": ([gadget4, attribute("Parameters", "ComovingIntegrationOn", 1)], "expanding universe"),
    "swift's cosmology": ([swift, attribute("Cosmology", "Cosmological run", [1])], "expanding universe"),
    "over h": ([gadget4, attribute("Parameters", "HubbleParam", 0.7)], "has a HubbleParam"),
    "over h, without units": ([fill, attribute("Header", "HubbleParam", 0.7)], "has a HubbleParam"),
    "entropies": ([gadget4, attribute("Header", "Flag_Entropy_ICs", 1)], "entropies where energies are"),
    "no places": ([gadget4, without("PartType0/Coordinates")], "has no Coordinates in PartType0"),
    "no masses": ([gadget4, without("PartType0/Masses")], "neither Masses in PartType0 nor a mass"),
    "a short table of masses": ([lambda file: fill(file, kind=1), without("PartType1/Masses"),
                                 attribute("Header", "MassTable", [1.0])], "neither Masses in PartType1 nor a mass"),
    "another file": ([gadget4, elsewhere], "neither Masses in PartType0 nor a mass"),
    "two components": ([gadget4, flat], "position is not three numbers"),
    "a bomb": ([gadget4, huge], "at most 10000000 rows"),
    "too few masses": ([gadget4, short], "is not one number a particle"),
    "words for a unit": ([gadget4, attribute("Parameters", "UnitMass_in_g", "kg")], "UnitMass_in_g is not a number"),
    "no unit": ([gadget4, attribute("Parameters", "UnitMass_in_g", 0.0)], "a unit that is not positive"),
    "NaN": ([gadget4, attribute("Parameters", "UnitMass_in_g", np.nan)], "UnitMass_in_g is not finite"),
    "a long attribute": ([gadget4, attribute("Header", "Redshift", np.zeros(5000))], "Redshift is not a number"),
    "words for G": ([evrard, attribute("Parameters", "PhysicalConstants:G", np.bytes_(b"one"))], "G is not a number"),
    "a negative G": ([evrard, attribute("Parameters", "PhysicalConstants:G", np.bytes_(b"-1"))], "G is not positive"),
    "no G": ([evrard, attribute("Parameters", "PhysicalConstants:G", np.bytes_(b"0"))], "G is not positive"),
    "many G": ([evrard, attribute("Parameters", "PhysicalConstants:G", np.zeros(9))], "G is not a number"),
    "a book for G": ([evrard, attribute("Parameters", "PhysicalConstants:G", np.bytes_(b"1" * 5000))],
                     "G is not a number"),
    "overflow": ([gadget4, attribute("Parameters", "UnitLength_in_cm", 1e308),
                  attribute("Parameters", "UnitVelocity_in_cm_per_s", 1e200)], "is not finite"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_a_body_gets_one_sentence(tmp_path, case):
    steps, sentence = BAD[case]
    with pytest.raises(SceneError, match=sentence) as caught:
        read_table(written(tmp_path / "snap.hdf5", *steps))
    assert "\n" not in str(caught.value)
