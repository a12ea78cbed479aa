"""Snapshots that other codes wrote, as bodies: units of each, and what is refused with one sentence."""

import h5py
import numpy as np
import pytest

from astroinertia.errors import SceneError
from astroinertia.sph.table import read_body, read_table
from astroinertia.studies.moments import read_matter
from astroinertia.units import PARSEC, SOLAR_MASS

COUNT = 6
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


def test_without_units_the_numbers_are_the_files_and_no_body_of_a_scene_in_si(tmp_path):
    path = written(tmp_path / "snap.hdf5", fill)
    table = read_body(path, dimensionless=True)
    assert table.units == "unknown"
    np.testing.assert_array_equal(table.mass, VALUES[:, 0])
    with pytest.raises(SceneError, match="does not tell its units"):
        read_body(path, dimensionless=False)
    assert read_matter(path, ("Msun", "kpc")).units == ("kg", "m")


def test_with_units_it_is_no_body_of_a_dimensionless_scene_and_needs_no_other_units(tmp_path):
    path = written(tmp_path / "snap.hdf5", gadget4)
    with pytest.raises(SceneError, match="has units, so it cannot be a body"):
        read_body(path, dimensionless=True)
    with pytest.raises(SceneError, match="says which units it is in; leave --units out"):
        read_matter(path, ("Msun", "kpc"))
    assert read_matter(path).units == ("kg", "m")


def test_masses_may_stand_in_the_header_and_particles_be_of_another_type(tmp_path):
    def equal_masses(file):
        fill(file, kind=1)
        del file["PartType1/Masses"]
        file["Header"].attrs["MassTable"] = [0.0, 0.25, 0.0, 0.0, 0.0, 0.0]

    table = read_table(written(tmp_path / "snap.hdf5", equal_masses))
    assert table.mass.tolist() == [0.25] * COUNT
    np.testing.assert_array_equal(table.position, VALUES[:, 1:4])


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
    "a part": ([gadget4, attribute("Header", "NumFilesPerSnapshot", 4)], "one of several files of a snapshot"),
    "redshift": ([gadget4, attribute("Header", "Redshift", 0.5)], "expanding universe"),
    "comoving": ([gadget4, attribute("Parameters", "ComovingIntegrationOn", 1)], "expanding universe"),
    "swift's cosmology": ([swift, attribute("Cosmology", "Cosmological run", [1])], "expanding universe"),
    "over h": ([gadget4, attribute("Parameters", "HubbleParam", 0.7)], "has a HubbleParam"),
    "no places": ([gadget4, without("PartType0/Coordinates")], "has no Coordinates in PartType0"),
    "no masses": ([gadget4, without("PartType0/Masses")], "neither Masses in PartType0 nor a mass"),
    "another file": ([gadget4, elsewhere], "neither Masses in PartType0 nor a mass"),
    "two components": ([gadget4, flat], "position is not three numbers"),
    "a bomb": ([gadget4, huge], "at most 10000000 rows"),
    "too few masses": ([gadget4, short], "is not one number a particle"),
    "words for a unit": ([gadget4, attribute("Parameters", "UnitMass_in_g", "kg")], "UnitMass_in_g is not a number"),
    "no unit": ([gadget4, attribute("Parameters", "UnitMass_in_g", 0.0)], "a unit that is not positive"),
    "NaN": ([gadget4, attribute("Parameters", "UnitMass_in_g", np.nan)], "UnitMass_in_g is not finite"),
    "a long attribute": ([gadget4, attribute("Header", "Redshift", np.zeros(5000))], "Redshift is not a number"),
    "overflow": ([gadget4, attribute("Parameters", "UnitLength_in_cm", 1e308),
                  attribute("Parameters", "UnitVelocity_in_cm_per_s", 1e200)], "is not finite"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_a_body_gets_one_sentence(tmp_path, case):
    steps, sentence = BAD[case]
    with pytest.raises(SceneError, match=sentence) as caught:
        read_table(written(tmp_path / "snap.hdf5", *steps))
    assert "\n" not in str(caught.value)
