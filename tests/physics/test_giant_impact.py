"""A giant impact: what it leaves, and that the ledger of mass, angular momentum and energy closes over it."""

import math
from pathlib import Path

import jax
import numpy as np
import pytest

from astroinertia import dataset as datasets
from astroinertia.bodies.hydrostatic import planet_from_masses
from astroinertia.build import assemble
from astroinertia.build.materials import materials
from astroinertia.build.planets import planet
from astroinertia.matter.interior import isentrope
from astroinertia.run.loop import run_scene
from astroinertia.scene import load
from astroinertia.scene.scales import code_units
from astroinertia.studies.impact_remnant import remnant
from astroinertia.units import GRAVITATIONAL_CONSTANT

SCENE = Path(__file__).parents[2] / "sims" / "giant_impact.toml"
CONDENSED = 1340.0  # kg/m^3, half the density of granite without pressure
SHARE = 0.13  # of the particles, and of the mass, in the impactor


CORRECTED = ("equation_of_state.boundary_pressure='5 GPa'", "bodies.0.surface=full", "bodies.1.surface=full")
LUNAR = 7.346e22  # kg


def after(count, end, folder, *settings):
    """The series, what is left after a time, and the last snapshot, of so many particles."""
    settings = [
        f"bodies.0.particles={round((1 - SHARE) * count)}", f"bodies.1.particles={round(SHARE * count)}", *settings
    ]  # fmt: skip
    file = run_scene(load.load_file(SCENE, [*settings, f"time.end='{end}'", "output.snapshot_every='30 min'"]), folder)
    snapshots = datasets.open_snapshots(file)
    assert snapshots is not None
    last = snapshots.isel(snapshot_time=-1).load()
    mass, position, velocity, density = (last[name].values for name in ("mass", "position", "velocity", "density"))
    left = remnant(mass, position, velocity, density, CONDENSED, GRAVITATIONAL_CONSTANT)
    return datasets.open(file).load(), left, last


def at_rest_with_its_heat(last, body):
    """The layered planet at rest of the iron and the rock of a body, in 3 and 12 shells of the heat that each has.

    Where matter is so hot that it is a gas without pressure, in the outermost shells, it is the hottest that is none.
    """
    scene = load.load_file(SCENE)
    matter = materials(scene.equation_of_state, scene.origin, code_units(scene))
    mass, position, entropy, material = (last[name].values for name in ("mass", "position", "entropy", "material"))
    mass = mass / mass.sum()
    distance = np.linalg.norm(position - np.average(position[body], weights=mass[body], axis=0), axis=1)
    layers, masses = [], []
    for number, shells in ((0, 3), (1, 12)):
        outwards = np.flatnonzero(body & (material == number))
        outwards = outwards[np.argsort(distance[outwards])]
        for shell in np.array_split(outwards, shells):
            layers.append(warmest(matter, number, float(np.mean(entropy[shell]))))
            masses.append(mass[shell].sum())
    with jax.enable_x64(True):
        return planet_from_masses(np.array(masses) * scene_mass(scene), layers)


def scene_mass(scene):
    """Of all bodies, in code units."""
    return sum(float(code_units(scene).to_code(body.mass, "mass")) for body in scene.bodies)


def warmest(matter, number, label):
    """The isentrope of that label, or the warmest below it on which the matter has a surface."""
    for _ in range(20):
        try:
            return isentrope(matter, number, label)
        except ValueError:
            label *= 0.9
    raise AssertionError("no isentrope has a surface")


def of_body(last, left, planet):
    """How far I, the radius of equal volume and I/(M R^2) of the body are from those of a planet at rest."""
    units, body = code_units(load.load_file(SCENE)), left.body
    mass, position, density = (last[name].values[body] for name in ("mass", "position", "density"))
    place = position - np.average(position, weights=mass, axis=0)
    moment = 2 / 3 * mass @ (place**2).sum(axis=1)
    radius = (3 * (mass / density).sum() / (4 * math.pi)) ** (1 / 3)
    exact = units.to_si(float(planet.mean_radius), "length")
    ratio = float(planet.moment_ratio)
    return {
        "moment": moment / (ratio * mass.sum() * exact**2) - 1,
        "radius": radius / exact - 1,
        "ratio": left.moment_ratio / ratio - 1,
    }


def ledger_closes(series, momentum, energy):
    spin = series.angular_momentum.values
    assert np.linalg.norm(spin - spin[0], axis=1).max() < momentum * np.linalg.norm(spin[0])
    assert np.ptp(series.total_energy.values) < energy * np.abs(series.gravitational_energy.values).max()
    assert series.ledger_closure.max() < 1e-12


@pytest.mark.full
def test_an_impact_spins_a_planet_up_and_its_ledger_closes(tmp_path):
    """500 particles, 3 h: angular momentum to 1e-13, energy to 1e-3 (measured 2e-4 over the whole day).

    The planet is by then most of the mass and turns with the orbit; what turns in all is what there was.
    """
    series, left, last = after(500, "3 h", tmp_path / "run")
    mass = last.mass.values
    ledger_closes(series, 1e-13, 1e-3)
    assert (left.planet.astype(int) + left.disc + left.escaped == 1).all()
    assert mass[left.planet].sum() > 0.85 * mass.sum()
    total = series.angular_momentum.values[0]
    assert left.planet_angular_momentum @ total > 0.1 * (total @ total)
    assert left.angular_velocity @ total > 0
    assert series.jeans_ratio.isnull().all()  # rock under tension is no gas


@pytest.mark.full(inputs=["sims/giant_impact.toml"])
def test_what_an_impact_leaves_settles_with_particles(tmp_path, result):
    """From 1000 to 2000: spin period within 10 %, moment ratio within 1 %; measured 2.5 and 0.3 %.

    The disc is of 10 to 50 particles, and its mass only bracketed: rock, without iron, 0.5 to 4 % of all.
    """
    periods, ratios, discs, flattenings = [], [], [], []
    for count in (1000, 2000):
        series, left, last = after(count, "24 h", tmp_path / str(count))
        mass, material = last.mass.values, last.material.values
        ledger_closes(series, 1e-13, 1e-3)
        periods.append(2 * math.pi / float(np.linalg.norm(left.angular_velocity)) / 3600)
        ratios.append(left.moment_ratio)
        flattenings.append(left.flattening)
        discs.append(float(mass[left.disc].sum() / mass.sum()))
        assert (material[left.disc] == 1).mean() > 0.9  # 0 is iron
    result(period_hours=periods, moment_ratio=ratios, flattening=flattenings, disc_share=discs)
    assert periods[1] == pytest.approx(periods[0], rel=0.10)
    assert ratios[1] == pytest.approx(ratios[0], rel=0.01)
    assert all(0.005 < disc < 0.04 for disc in discs)


@pytest.mark.full(inputs=["sims/giant_impact.toml"])
@pytest.mark.parametrize("settings", [(), CORRECTED], ids=["smoothed", "corrected"])
def test_three_placements_leave_one_planet_and_discs_that_differ(tmp_path, result, settings):
    """1000 particles. Measured twice, with code that differs in round-off: discs of 1.63 +- 0.16 and 1.73 +- 0.75 lunar
    masses, with corrected densities 1.71 +- 0.35 and 1.95 +- 0.08: such an impact is chaotic.

    Among three spin periods differ by 3 to 9 %, moment ratios by 0.3 to 0.5 %. The mean of three discs is held to three
    of its standard errors by the largest scatter.
    """
    periods, ratios, discs = [], [], []
    for seed in (1, 2, 3):
        seeds = (f"bodies.0.seed={seed}", f"bodies.1.seed={seed + 100}")
        series, left, last = after(1000, "24 h", tmp_path / str(seed), *seeds, *settings)
        mass, material = last.mass.values, last.material.values
        ledger_closes(series, 1e-13, 1e-3)
        periods.append(2 * math.pi / float(np.linalg.norm(left.angular_velocity)) / 3600)
        ratios.append(left.moment_ratio)
        discs.append(float(mass[left.disc].sum() / LUNAR))
        assert (material[left.disc] == 1).mean() > 0.9
    result(period_hours=periods, moment_ratio=ratios, disc_lunar_masses=discs)
    assert np.ptp(periods) < 0.2 * np.mean(periods)
    assert np.ptp(ratios) < 0.01 * np.mean(ratios)
    assert np.mean(discs) == pytest.approx(1.75, abs=1.3)


@pytest.mark.full(inputs=["sims/giant_impact.toml"])
@pytest.mark.parametrize(("settings", "ratio"), [((), 0.010), (CORRECTED, 0.061)], ids=["smoothed", "corrected"])
def test_what_is_left_is_the_layered_planet_of_its_own_heat_without_corrections(tmp_path, result, settings, ratio):
    """1000 particles: I/(M R^2) 1.0 % above that planet's, 6.1 % with corrections; with 3000 2.0 and 4.9 %.

    That it turns makes some 0.3 % of it. Factors of the full surface stay with particles that the impact has moved.
    """
    _, left, last = after(1000, "24 h", tmp_path / "run", *settings)
    errors = of_body(last, left, at_rest_with_its_heat(last, left.body))
    result(**errors)
    assert errors["ratio"] == pytest.approx(ratio, abs=0.02)


def alone(count, *settings):
    """The scene's planet by itself, of so many particles."""
    lines = SCENE.read_text().split("[orbit]")
    bodies, rest = lines[0].split("[[bodies]]"), lines[1].split("[equation_of_state]", 1)[1]
    body = bodies[1].replace("[[bodies.layers]]", "[[body.layers]]")
    return load.loads(
        bodies[0] + "[body]" + body + "[equation_of_state]" + rest, [f"body.particles={count}", *settings]
    )


@pytest.mark.full(inputs=["sims/giant_impact.toml"])
@pytest.mark.parametrize("count", [1000, 3000, 10000])
def test_the_planet_at_rest_has_its_moment_with_and_without_corrections(count, result):
    """Against the solver. Whole surfaces are nearer in I, none in I/(M R^2) with the radius of equal volume: both radii
    come out too small, by 1.2 % at 1000, which makes up for what I lacks.
    """
    found = {}
    for name, settings in (("smoothed", ()), ("corrected", (CORRECTED[0], "body.surface=full"))):
        scene = alone(count, *settings)
        with jax.enable_x64(True):
            prepared = assemble.prepare(scene)
            exact, record = planet(scene, prepared.units), prepared.evolution.snapshot()
        mass, position, velocity, density = (record[key] for key in ("mass", "position", "velocity", "density"))
        left = remnant(mass, position, velocity, density, float(prepared.units.to_code(CONDENSED, "density")))
        assert left.body.all()
        place = position - mass @ position / mass.sum()
        moment = 2 / 3 * mass @ (place**2).sum(axis=1) / float(exact.solution.mean_moment) - 1
        found[name] = moment, left.moment_ratio / float(exact.solution.moment_ratio) - 1
    result(
        **{
            f"{name}_{what}": value
            for name in found
            for what, value in zip(("moment", "ratio"), found[name], strict=True)
        }
    )
    assert abs(found["corrected"][0]) < 0.01 and abs(found["corrected"][0]) < abs(found["smoothed"][0]) < 0.04
    assert abs(found["smoothed"][1]) < 0.012 and abs(found["smoothed"][1]) < abs(found["corrected"][1]) < 0.016
