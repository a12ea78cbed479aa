"""Dumps of Phantom as particle tables: bytes written here by the format's description, and what sarracen writes."""

import builtins

import numpy as np
import pytest

import astroinertia
from astroinertia.cli.main import main
from astroinertia.errors import SceneError, SceneWarning
from astroinertia.inertia import tensor
from astroinertia.inertia.spin import angular_momentum
from astroinertia.run.loop import run_scene
from astroinertia.scene.load import loads
from astroinertia.sph.table import read_body, read_table
from astroinertia.studies.moments import moments, read_matter
from astroinertia.units import DIMENSIONLESS, SOLAR_MASS, CodeUnits
from tests.phantom_dump import COUNT, MASS, PARTICLES, SMOOTHING, UNITS, dump, gas, header, record


def needs_sarracen():
    pytest.importorskip("sarracen", reason="sarracen, of the extra phantom, reads dumps")


def written(path, content):
    path.write_bytes(content)
    return path


def in_si(name):
    length, time = UNITS["udist"] / 100, UNITS["utime"]
    return PARTICLES[name] * {"v": length / time, "u": (length / time) ** 2}.get(name[0], length)


LAYOUTS = [("<", "f8", "i4"), (">", "f8", "i4"), ("<", "f4", "i4"), ("<", "f8", "i8"), (">", "f4", "i8")]


@pytest.mark.parametrize(("order", "real", "integer"), LAYOUTS, ids=["".join(each) for each in LAYOUTS])
def test_a_dump_of_every_layout_is_what_was_written(tmp_path, order, real, integer):
    needs_sarracen()
    content = dump(header(), gas(), {}, order=order, real=real, integer=integer)
    table = read_table(written(tmp_path / "star_00010", content))
    near = {"rtol": 1e-15 if real == "f8" else 1e-7}
    assert table.units == "SI"
    np.testing.assert_allclose(table.position, np.stack([in_si(name) for name in "xyz"], 1), **near)
    np.testing.assert_allclose(table.velocity, np.stack([in_si(name) for name in ("vx", "vy", "vz")], 1), **near)
    np.testing.assert_allclose(table.internal_energy, in_si("u"), **near)
    np.testing.assert_allclose(table.mass, MASS * UNITS["umass"] / 1000, **near)


def test_what_sarracen_writes_comes_back_with_its_mass_centre_momentum_and_inertia(tmp_path):
    needs_sarracen()
    import sarracen

    path = tmp_path / "body_00000"
    frame = sarracen.SarracenDataFrame(PARTICLES | {"h": SMOOTHING}, params=dict(UNITS) | {"massoftype": MASS})
    sarracen.write_phantom(str(path), frame)
    found = read_table(path)
    length, mass = UNITS["udist"] / 100, np.full(COUNT, MASS * UNITS["umass"] / 1000)
    position = np.stack([PARTICLES[name] for name in "xyz"], 1) * length
    velocity = np.stack([PARTICLES[name] for name in ("vx", "vy", "vz")], 1) * length / UNITS["utime"]
    for figure in (
        lambda m, x, v: m.sum(),
        lambda m, x, v: tensor.centre_of_mass(m, x),
        lambda m, x, v: tensor.inertia_tensor(m, x),
        lambda m, x, v: angular_momentum(m, x, v),
    ):
        expected, got = figure(mass, position, velocity), figure(found.mass, found.position, found.velocity)
        assert np.abs(np.asarray(got) - expected).max() <= 1e-15 * np.abs(expected).max()


def test_masses_are_those_of_the_types_and_of_a_type_that_is_alone(tmp_path):
    needs_sarracen()
    masses = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25)
    kinds = [1, 1, 7, 7, 7, 1, 1]
    mixed = written(tmp_path / "dusty_00000", dump(header(masses, {}), gas(kinds), {}))
    assert read_table(mixed).mass.tolist() == [masses[kind - 1] for kind in kinds]
    assert "of the types 1, 7" in read_matter(mixed).text
    with pytest.raises(SceneError, match="has particles of 2 types, so it cannot be a body"):
        read_body(mixed, DIMENSIONLESS)
    alone = written(tmp_path / "dust_00000", dump(header(masses, {}), gas([7] * COUNT), {}))
    assert read_body(alone, DIMENSIONLESS).mass.tolist() == [0.25] * COUNT
    unknown = written(tmp_path / "odd_00000", dump(header(), gas([9] * COUNT), {}))
    with pytest.raises(SceneError, match="does not state the mass of particles of type 9"):
        read_table(unknown)


def test_levels_of_refinement_halve_the_mass(tmp_path):
    needs_sarracen()
    levels = [1, 1, 2, 2, 3, 3, 3]
    block = gas() | {1: {"apr_level": levels}}
    table = read_table(written(tmp_path / "refined_00000", dump(header(units={}), block, {})))
    assert table.mass.tolist() == [MASS / 2 ** (level - 1) for level in levels]


def test_accreted_and_dead_particles_are_left_out_and_reported(tmp_path):
    needs_sarracen()
    smoothing = SMOOTHING * np.float32([1, -1, 1, 0, 1, -1, 1])
    path = written(tmp_path / "disc_00100", dump(header(units={}), gas(smoothing=smoothing), {}))
    alive = smoothing > 0
    with pytest.warns(SceneWarning, match="disc_00100: 3 accreted or dead ones left out."):
        table = read_body(path, DIMENSIONLESS)
    np.testing.assert_array_equal(table.position[:, 0], PARTICLES["x"][alive])
    assert read_matter(path).text == "4 particles, 3 accreted or dead ones left out"
    nobody = written(tmp_path / "gone_00000", dump(header(), gas(smoothing=-SMOOTHING), {}))
    with pytest.raises(SceneError, match="has 0 particles"):
        read_table(nobody)


def test_sinks_are_points_of_moments_and_no_body_of_a_scene(tmp_path):
    needs_sarracen()
    sinks = {"x": [10.0, -10.0, 3.0], "y": [0.0, 1.0, 0.0], "z": [0.0, 0.0, 2.0], "m": [2.0, 1.0, -1.0]}
    sinks |= {name: [0.5, 0.25, 0.0] for name in ("h", "vx", "vy", "vz")}  # the third has merged into another
    path = written(tmp_path / "binary_00000", dump(header(units={}), gas(), {5: sinks}))
    found = moments(read_matter(path))
    mass = np.append(np.full(COUNT, MASS), [2.0, 1.0])
    places = np.stack([np.append(PARTICLES[name], sinks[name][:2]) for name in "xyz"], 1)
    np.testing.assert_allclose(
        found.inertia_tensor, tensor.inertia_tensor(mass, places, tensor.centre_of_mass(mass, places)), rtol=1e-13
    )
    assert found.attrs["title"] == "inertia of 9 particles, 2 sinks among them as points"
    with pytest.raises(SceneError, match="has 2 sinks, so it cannot be a body"):
        read_body(path, DIMENSIONLESS)
    nowhere = written(tmp_path / "odd_00000", dump(header(), gas(), {5: {"m": [1.0]}}))
    with pytest.raises(SceneError, match="sinks without a mass, a position or a velocity"):
        read_table(nowhere)


def test_blocks_of_several_processes_are_one_body(tmp_path):
    needs_sarracen()
    halves = [
        {5: {name: values[part] for name, values in PARTICLES.items()}} for part in (slice(0, 4), slice(4, COUNT))
    ]
    content = dump(header(units={}, processes=2), halves[0], {}, halves[1], {}, processes=2)
    np.testing.assert_array_equal(read_table(written(tmp_path / "mpi_00000", content)).position[:, 1], PARTICLES["y"])


def test_units_decide_which_scenes_may_have_it(tmp_path):
    needs_sarracen()
    in_units = written(tmp_path / "a_00000", dump(header(), gas(), {}))
    plain = written(tmp_path / "b_00000", dump(header(units=dict.fromkeys(UNITS, 1.0)), gas(), {}))
    solar = CodeUnits(SOLAR_MASS, 6.957e8)
    body = read_body(in_units, solar)
    assert body.units == "SI"
    np.testing.assert_allclose(body.position[:, 0], PARTICLES["x"], rtol=1e-12)  # in the units of the scene: Rsun
    for units in (DIMENSIONLESS, solar):  # numbers without units are those of the scene
        assert read_body(plain, units).units == "unknown"
        np.testing.assert_allclose(read_body(plain, units).velocity[:, 1], PARTICLES["vy"], rtol=1e-15)
    # in a dimensionless scene a dump is in its own units, in which G is 1
    own = read_body(in_units, DIMENSIONLESS)
    for values, name in ((own.position[:, 2], "z"), (own.velocity[:, 0], "vx"), (own.internal_energy, "u")):
        np.testing.assert_allclose(values, PARTICLES[name], rtol=1e-12)
    nonsense = written(tmp_path / "c_00000", dump(header(units=UNITS | {"utime": -1.0}), gas(), {}))
    with pytest.raises(SceneError, match="a unit that is not positive"):
        read_table(nonsense)


def test_a_small_dump_has_moments_and_is_no_body(tmp_path):
    needs_sarracen()
    places = {name: PARTICLES[name] for name in "xyz"}
    path = written(tmp_path / "small_00001", dump(header(units={}), gas(particles=places), {}, real="f4"))
    assert read_matter(path).text == "7 particles"
    with pytest.raises(SceneError, match="has no velocities, as a small dump, so it cannot be a body"):
        read_body(path, DIMENSIONLESS)


def test_the_command_moments_takes_a_dump(tmp_path, capsys):
    needs_sarracen()
    written(tmp_path / "star_00010", dump(header(), gas(), {}))
    assert main(["moments", str(tmp_path / "star_00010")]) == 0
    said = capsys.readouterr().out
    assert "inertia of 7 particles" in said
    assert f"{COUNT * MASS * UNITS['umass'] / 1000:.6e}" in said


# What is wrong with a file is found before sarracen is asked, so these need none.


def test_a_dump_that_ends_anywhere_is_refused(tmp_path):
    whole = dump(header(), gas(), {5: {"m": [1.0]}})
    for length in range(16, len(whole)):
        path = written(tmp_path / "cut_00000", whole[:length])
        with pytest.raises(SceneError, match=r"is not a whole dump of Phantom|must be a \.csv"):
            read_table(path)


def test_counts_that_a_disk_has_damaged_are_refused_soon(tmp_path):
    empty = {5: {"m": []}}
    whole = dump(header(), gas(), empty)
    counts = np.int32([0, 0, 0, 0, 0, 0, 0, 1, 0, 0])  # of rows, in 64 bits, and of arrays in the empty block
    assert whole.count(counts.tobytes()) == 1
    for place, damaged in ((7, 1 << 30), (0, 3), (1, 1 << 30)):
        counts_now = counts.copy()
        counts_now[place] = damaged
        path = written(tmp_path / "bad_00000", whole.replace(counts.tobytes(), counts_now.tobytes()))
        with pytest.raises(SceneError, match="is not a whole dump of Phantom"):
            read_table(path)
    more = written(tmp_path / "more_00000", whole + record(b"more"))
    with pytest.raises(SceneError, match="more records than it announces"):
        read_table(more)


def test_without_sarracen_it_says_what_to_install(tmp_path, monkeypatch):
    usual = builtins.__import__

    def without(name, *rest):
        if name == "sarracen":
            raise ModuleNotFoundError("No module named 'sklearn'")
        return usual(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    path = written(tmp_path / "star_00010", dump(header(), gas(), {}))
    with pytest.raises(SceneError, match=r"No module named 'sklearn'.*pip install 'astroinertia\[phantom\]'"):
        read_table(path)


def test_a_scene_runs_from_a_dump(tmp_path):
    """A ball of gas in solar units, at rest but for its rotation: it begins with the dump's mass, L and I."""
    needs_sarracen()
    random = np.random.default_rng(4)
    count = 120
    position = random.normal(size=(count, 3))
    position *= (random.random(count) ** (1 / 3) / np.linalg.norm(position, axis=1))[:, None]
    columns = dict(zip("xyz", position.T, strict=True))
    columns |= {
        "vx": -0.1 * position[:, 1],
        "vy": 0.1 * position[:, 0],
        "vz": np.zeros(count),
        "u": np.full(count, 0.5),
    }
    one = {0: {"nparttot": count, "nblocks": 1}, 5: {"massoftype#0": 1.0 / count}, 7: UNITS}
    block = {5: columns, 6: {"h": np.full(count, 0.3, np.float32)}}
    written(tmp_path / "star_00000", dump(one, block, {}))
    text = f"""
name = "star"
model = "sph"
[units]
mass = "1 Msun"
length = "1 Rsun"
[body]
kind = "table"
file = "{tmp_path / "star_00000"}"
[effects.gravity]
[effects.pressure]
[effects.viscosity]
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
[time]
end = "30 min"
[output]
series_every = "10 min"
"""
    run_scene(loads(text), tmp_path / "run")
    series = astroinertia.open(tmp_path / "run")
    mass, table = UNITS["umass"] / 1000, read_table(tmp_path / "star_00000")
    assert float(series["mass"][0]) == pytest.approx(mass, rel=1e-12)
    first = series.isel(time=0)
    np.testing.assert_allclose(first["inertia_tensor"], tensor.inertia_tensor(table.mass, table.position), rtol=1e-9)
    spin = angular_momentum(table.mass, table.position, table.velocity)
    np.testing.assert_allclose(first["angular_momentum"], spin, rtol=1e-9, atol=1e-12 * np.abs(spin).max())
    assert float(np.abs(series["angular_momentum"][-1] - spin).max()) < 1e-12 * np.abs(spin).max()
    assert float(series["time"][-1]) == pytest.approx(1800.0)
