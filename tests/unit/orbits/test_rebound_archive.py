"""Orbits out of REBOUND's archives: in any units, about any of its particles, and only where gravity made them."""

import jax
import numpy as np
import pytest
import rebound

from astroinertia.errors import NumericalError, SceneWarning
from astroinertia.orbits.rebound_archive import first_snapshot, snapshots
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.orbits.states import states
from astroinertia.rotation.ephemeris import archive_ephemeris, ephemeris
from astroinertia.units import CodeUnits

PLANETS = [
    Companion("inner", 1e-3, semi_major_axis=1.0, eccentricity=0.1),
    Companion("outer", 1e-3, semi_major_axis=2.3, eccentricity=0.05, inclination=0.1, mean_anomaly=2.0),
]


def written(path, bodies, end, every):
    bodies.save_to_file(str(path), interval=every, delete_file=True)
    bodies.integrate(end)
    return path


def test_its_orbits_are_those_of_the_simulation_that_wrote_it(tmp_path):
    bodies = simulation(1.0, PLANETS)
    whole = ephemeris(bodies, 9.0)
    path = written(tmp_path / "orbits.bin", bodies.copy(), 12.0, 1.7)
    found = archive_ephemeris(path, 9.0)
    assert found.names == ("inner", "outer")
    assert float(found.error) < 1e-12
    times = np.linspace(0.0, 9.0, 400)
    with jax.enable_x64(True):
        assert np.abs(np.asarray(found.position(times)) - np.asarray(whole.position(times))).max() < 1e-11
        assert np.abs(np.asarray(found.velocity(times)) - np.asarray(whole.velocity(times))).max() < 1e-11


def test_a_moment_that_was_saved_twice_counts_once(tmp_path):
    """At the end of an interval, and once more by hand, after which the simulation goes on."""
    whole, bodies = ephemeris(simulation(1.0, PLANETS), 5.0), simulation(1.0, PLANETS)
    path = written(tmp_path / "orbits.bin", bodies, 3.0, 1.0)
    bodies.save_to_file(str(path))
    bodies.integrate(6.0)
    moments = [each.t for each in snapshots(path)]
    assert len(set(moments)) < len(moments)
    found, times = archive_ephemeris(path, 5.0), np.linspace(0.0, 5.0, 200)
    with jax.enable_x64(True):
        assert np.abs(np.asarray(found.position(times)) - np.asarray(whole.position(times))).max() < 1e-11
    early = rebound.Simulation(str(path), snapshot=1)
    early.save_to_file(str(path))
    early.integrate(7.0)
    early.save_to_file(str(path))
    with pytest.raises(ValueError, match="the snapshots of the archive go back in time"):
        archive_ephemeris(path, 5.0)


def test_any_particle_may_be_the_body(tmp_path):
    bodies = simulation(1.0, PLANETS)
    path = written(tmp_path / "orbits.bin", bodies.copy(), 3.0, 1.0)
    found = archive_ephemeris(path, 2.0, body="outer")
    assert found.names == ("body", "inner")
    place, _ = states(bodies, np.array([1.3]), origin=2)
    with jax.enable_x64(True):
        assert np.asarray(found.position(1.3)) == pytest.approx(place[0], abs=1e-11)


def test_its_units_become_code_units(tmp_path):
    bodies = rebound.Simulation()
    bodies.units = ("AU", "yr", "Msun")
    bodies.add(m=3e-6)
    bodies.add(m=1.0, a=1.0, e=0.0167, name="sun")
    path = written(tmp_path / "orbits.bin", bodies, 0.5, 0.1)
    units = CodeUnits(mass=5.9722e24, length=6.371e6)
    found = archive_ephemeris(path, 0.2 * 31557600.0 / units.time, units=units)
    # REBOUND's solar mass is the Sun's G M over its own G: what the orbits show is G M.
    assert found.mass[0] == pytest.approx(1.32712440042e20 / (units.gravitational_constant * units.mass), rel=1e-9)
    with jax.enable_x64(True):
        distance = np.linalg.norm(np.asarray(found.position(0.0))[0])
    assert distance == pytest.approx((1 - 0.0167) * 149597870700.0 / units.length, rel=1e-12)


def test_whfast_is_met_within_its_error_and_other_forces_are_noticed(tmp_path):
    by_whfast = simulation(1.0, PLANETS, integrator="whfast")
    path = written(tmp_path / "whfast.bin", by_whfast, 12.0, 1.7)
    assert 1e-12 < float(archive_ephemeris(path, 9.0, tolerance=1e-5).error) < 1e-5
    pushed = simulation(1.0, PLANETS)

    def push(pointer):
        pointer.contents.particles[1].ax += 1e-5

    pushed.additional_forces = push
    path = written(tmp_path / "pushed.bin", pushed, 12.0, 1.7)
    with pytest.raises(NumericalError, match="from where gravity alone leads"):
        archive_ephemeris(path, 9.0)


def test_what_is_no_such_archive_is_refused_in_a_sentence(tmp_path):
    with pytest.raises(ValueError, match="there is no archive"):
        archive_ephemeris(tmp_path / "none.bin", 1.0)
    (tmp_path / "text.bin").write_text("not an archive")
    with pytest.raises(ValueError, match="not read as an archive"):
        archive_ephemeris(tmp_path / "text.bin", 1.0)
    path = written(tmp_path / "orbits.bin", simulation(1.0, PLANETS), 3.0, 1.0)
    with pytest.raises(ValueError, match="does not reach 5"):
        archive_ephemeris(path, 5.0)
    with pytest.raises(ValueError, match="no particle moon"):
        archive_ephemeris(path, 2.0, body="moon")
    with pytest.raises(ValueError, match="what its units are"):
        archive_ephemeris(path, 2.0, units=CodeUnits(1e24, 1e6))


def test_the_end_of_a_damaged_archive_is_missed_aloud(tmp_path):
    path = written(tmp_path / "orbits.bin", simulation(1.0, PLANETS), 4.0, 1.0)
    (tmp_path / "short.bin").write_bytes(path.read_bytes()[:-200])
    with pytest.warns(SceneWarning, match=r"archive short\.bin is damaged: \d snapshots of it can be read") as said:
        found = snapshots(tmp_path / "short.bin")
    assert f" {len(found)} snapshots" in str(said[0].message)
    assert 1 < len(found) < len(snapshots(path))


def test_an_archive_may_have_any_name_in_any_folder(tmp_path):
    folder = tmp_path / "bahn ü"
    folder.mkdir()
    path = written(tmp_path / "orbits.bin", simulation(1.0, PLANETS), 2.0, 1.0).rename(folder / "körper.bin")
    whole = snapshots(path)
    assert [particle.name for particle in whole[0].particles] == ["body", "inner", "outer"]
    assert first_snapshot(path).particles[1].xyz == whole[0].particles[1].xyz
