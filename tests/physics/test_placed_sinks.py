"""Sinks that a scene has from the start: known orbits, discs that turn as Kepler says, Bondi's rate of accretion."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson
from scipy.optimize import brentq

from astroinertia.build.assemble import prepare
from astroinertia.build.sph import resumed
from astroinertia.models.sph.evolution import Particles
from astroinertia.scene import load
from astroinertia.scene.plan import code_units
from astroinertia.scene.schema import Scene
from tests.evolve import reached

pytestmark = pytest.mark.usefixtures("steps_differ")

GAS = """
name = "placed"
units = "code"
[body]
kind = "table"
file = "gas.csv"
PLACE
[equation_of_state]
FLUID
[effects.pressure]
[effects.viscosity]
[time]
end = 100.0
"""
LIGHT = 1e-8  # of all gas: it hardly pulls at the sinks


def isothermal(sound_speed: float) -> str:
    return f'kind = "isothermal"\nsound_speed = {sound_speed}'


def scene_of(folder: Path, gas: np.ndarray, sinks: str, *settings: str, fluid: str, place: str = "") -> Scene:
    """Light gas at rows (N, 6) of positions and velocities, beside sinks."""
    mass = np.full((len(gas), 1), LIGHT / len(gas))
    head = "mass,x,y,z,vx,vy,vz"
    np.savetxt(folder / "gas.csv", np.hstack([mass, gas]), delimiter=",", header=head, comments="", fmt="%.17g")
    text = GAS.replace("PLACE", place).replace("FLUID", fluid) + sinks
    return load.loads(text, settings, str(folder))


def beside(*scene: Any, **more: Any) -> Particles:
    return prepare(scene_of(*scene, **more)).evolution


@pytest.mark.parametrize("timesteps", ["global", "individual"])
def test_two_sinks_go_round_each_other_as_kepler_says(timesteps: str, tmp_path: Path) -> None:
    """Masses 3 and 1 on an ellipse of eccentricity 0.4 and semi-major axis 1: back after a turn, half way before."""
    eccentricity, period = 0.4, np.pi
    apart, speed = 1.0 + eccentricity, np.sqrt(4.0 * (1.0 - eccentricity) / (1.0 + eccentricity))
    sinks = "[effects.sinks]\nradius = 0.2\n"
    for mass, share in ((3.0, 0.25), (1.0, -0.75)):
        sinks += f"[[sinks]]\nmass = {mass}\nposition = [{share * apart}, 0, 0]\nvelocity = [0, {share * speed}, 0]\n"
    far = np.hstack([np.random.default_rng(1).normal(size=(20, 3)), np.zeros((20, 3))]) + [60.0, 0, 0, 0, 0, 0]
    body = beside(tmp_path, far, sinks, f"numerics.timesteps={timesteps}", fluid=isothermal(0.01))
    first, half = reached(body, 0.5 * period)
    near = (1.0 - eccentricity) / apart
    np.testing.assert_allclose(half["sink_position"][:2], -near * first["sink_position"][:2], atol=4e-3)
    _, last = reached(body, period)
    np.testing.assert_allclose(last["sink_position"][:2], first["sink_position"][:2], atol=8e-3)
    turning = np.linalg.norm(first["system_angular_momentum"])
    assert np.abs(last["system_angular_momentum"] - first["system_angular_momentum"]).max() <= 1e-13 * turning


@pytest.mark.parametrize("timesteps", ["global", "individual"])
def test_two_sinks_that_fall_onto_each_other_keep_their_energy_up_to_their_merger(
    timesteps: str, tmp_path: Path
) -> None:
    """At 1/5 of where they began: what they gained is four times what they had, and is within the one that is left."""
    sinks = "[effects.sinks]\nradius = 0.2\n"
    for side in (1.0, -1.0):
        sinks += f"[[sinks]]\nmass = 0.5\nposition = [{0.5 * side}, 0, 0]\nvelocity = [0, {0.025 * side}, 0]\n"
    far = np.hstack([np.random.default_rng(1).normal(size=(20, 3)), np.zeros((20, 3))]) + [60.0, 0, 0, 0, 0, 0]
    body = beside(tmp_path, far, sinks, f"numerics.timesteps={timesteps}", fluid=isothermal(0.01))
    first = body.record(None)
    while len(body.state.points["sinks"].mass) == 2 and body.time < 2.0:
        body.advance(5.0)
    last = body.record(first["potential_energy"])
    energy = 0.5 * 0.25 * 0.05**2 - 0.25
    assert first["sink_number"] - last["sink_number"] == 1.0
    assert last["sink_inner_energy"] == pytest.approx(energy, rel=1e-3)
    assert abs(last["integration_energy_error"]) <= 1e-4 * abs(energy)
    assert last["sink_spin"][0, 2] == pytest.approx(0.25 * 0.05, rel=1e-9)


def test_a_disc_about_a_star_keeps_turning_as_kepler_says(tmp_path: Path) -> None:
    """A cold disc at 1 to 2 about a star that moves goes along, and turns as fast to 1 % after a turn and a half."""
    random = np.random.default_rng(3)
    radius = np.sqrt(np.linspace(1.0, 4.0, 1200))
    angle = np.pi * (1.0 + 5.0**0.5) * np.arange(1200)
    gas = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.05 * random.normal(size=1200)], axis=1)
    speed = np.stack([-np.sin(angle), np.cos(angle), 0.0 * angle], axis=1) / np.sqrt(radius)[:, None]
    star = "[effects.sinks]\nradius = 0.4\n[[sinks]]\nmass = 1.0\nposition = [5, 0, 0]\nvelocity = [0, 0.3, 0]\n"
    body = beside(
        tmp_path, np.hstack([gas, speed]), star, "numerics.timesteps=individual", fluid=isothermal(0.02),
        place="position = [5.0, 0.0, 0.0]\nvelocity = [0.0, 0.3, 0.0]",
    )  # fmt: skip
    _, last = reached(body, 3.0 * np.pi)
    np.testing.assert_allclose(last["sink_position"][0], [5.0, 0.9 * np.pi, 0.0], atol=1e-6)
    assert last["accreted_mass"] == 0.0
    x, v = body.state.position - last["sink_position"][0], body.state.velocity - last["sink_velocity"][0]
    away, moment = np.hypot(x[:, 0], x[:, 1]), x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]
    inner = (away > 1.1) & (away < 1.9)
    order = np.argsort(away[inner])
    rings = (moment / np.sqrt(away))[inner][order]
    means = [ring.mean() for ring in np.array_split(rings, 8)]
    np.testing.assert_allclose(means, 1.0, atol=0.01)
    assert last["ledger_closure"] <= 1e-12


def test_what_two_stars_bind_is_a_region(tmp_path: Path) -> None:
    """Light gas about a binary that moves: bound is what has v^2/2 < sum M/d in the frame of the stars."""
    random = np.random.default_rng(5)
    gas = np.hstack([random.normal(size=(200, 3)), 0.7 * random.normal(size=(200, 3))])
    gas[:60, 3:] = [0.0, 40.0, 0.0]  # much that flies off: it is not what the rest is judged by
    sinks = "[effects.gravity]\n[regions.disc]\nbound = true\n[effects.sinks]\nradius = 0.01\nsoftening = 0.1\n"
    for mass, place, speed in ((0.6, -0.2, -0.4), (0.4, 0.3, 0.6)):
        sinks += f"[[sinks]]\nmass = {mass}\nposition = [{place}, 0, 0]\nvelocity = [3, {speed}, 0]\n"
    body = beside(tmp_path, gas + [0.0, 0.0, 0.0, 3.0, 0.0, 0.0], sinks, fluid=isothermal(0.1))
    depth = sum(
        mass / np.sqrt(((gas[:, :3] - [place, 0.0, 0.0]) ** 2).sum(axis=1) + 0.01)
        for mass, place in ((0.6, -0.2), (0.4, 0.3))
    )
    is_bound = 0.5 * (gas[:, 3:] ** 2).sum(axis=1) < depth
    assert 40 < is_bound.sum() < 140
    record = body.record(None)
    assert record["region_particles"][0] == is_bound.sum()
    assert record["region_mass"][0] == pytest.approx(LIGHT * is_bound.mean(), rel=1e-12)
    found = np.zeros(200)
    found[body.state.identity] = body.state.memory["region.disc"]
    assert np.array_equal(found, is_bound)


def test_a_star_accretes_isothermal_gas_at_bondis_rate(tmp_path: Path) -> None:
    """The steady flow onto a star, cut off at two Bondi radii, goes on at 4 pi lambda rho (G M)^2/c^3, within 10 %.

    Bondi (1952, MNRAS 112, 195): lambda = e^1.5/4, and v^2/2 - ln v - 2 ln r - 1/r the same everywhere, where c = G M =
    1; faster than sound within 1/2.
    """
    sink, edge, count, strength = 0.25, 2.0, 4000, np.exp(1.5) / 4.0

    def speed(radius: float) -> float:
        def balance(v: float) -> float:
            return 0.5 * v**2 - np.log(v) - 2.0 * np.log(radius) - 1.0 / radius + 1.5 + 2.0 * np.log(0.5)

        return brentq(balance, 1.0, 9.0) if radius < 0.5 else brentq(balance, 1e-6, 1.0)

    radii = np.linspace(sink, edge, 2001)
    speeds = np.array([speed(radius) for radius in radii])
    within = cumulative_simpson(4.0 * np.pi * strength / speeds, x=radii, initial=0.0)  # rho r^2 = lambda/v
    lattice = np.stack(np.meshgrid(*3 * [np.arange(-12.0, 13.0)]), axis=-1).reshape(-1, 3)
    lattice = np.concatenate([lattice + half for half in ([0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5])])
    lattice += [0.13, 0.27, 0.41]
    lattice = lattice[np.argsort((lattice**2).sum(axis=1))[:count]]
    distance = np.sqrt((lattice**2).sum(axis=1))
    toward = lattice / distance[:, None]
    place = np.interp((distance / distance.max()) ** 3 * within[-1], within, radii)
    gas = np.hstack([place[:, None] * toward, -np.interp(place, radii, speeds)[:, None] * toward])
    star = f"[effects.sinks]\nradius = {sink}\n[[sinks]]\nmass = 1.0\n"
    body = beside(tmp_path, gas, star, "numerics.timesteps=individual", fluid=isothermal(1.0))
    last: Any = reached(body, 0.5)[-1]
    rate = last["accreted_mass"] / 0.5 * within[-1] / LIGHT
    assert rate == pytest.approx(4.0 * np.pi * strength, rel=0.1)
    assert last["ledger_closure"] <= 1e-12


@pytest.mark.parametrize("timesteps", ["global", "individual"])
def test_gas_that_cools_among_three_stars_resumes_bit_for_bit(timesteps: str, tmp_path: Path) -> None:
    """From a checkpoint after stars have accreted and two of three have merged."""
    random = np.random.default_rng(2)
    gas = np.hstack([random.uniform(-1.0, 1.0, (300, 3)), np.zeros((300, 3))])
    stars = '[effects.cooling]\nlaw = "beta"\nbeta = 5.0\n[effects.sinks]\nradius = 0.2\nsoftening = 0.05\n'
    for place, speed in (([0.5, 0, 0], [0, 0.7, 0]), ([-0.5, 0, 0], [0, -0.7, 0]), ([-0.5, 0.3, 0], [0, -0.7, 0])):
        stars += f"[[sinks]]\nmass = 1.0\nposition = {place}\nvelocity = {speed}\n"
    scene = scene_of(
        tmp_path,
        gas,
        stars,
        f"numerics.timesteps={timesteps}",
        "body.specific_internal_energy=0.01",
        fluid='kind = "ideal"',
    )
    body = prepare(scene).evolution
    while body.time < 1.0 and (len(body.state.points["sinks"].mass) == 3 or not body.resumable):
        body.advance(9.0)
    again = resumed(scene, code_units(scene), {name: array.copy() for name, array in body.arrays().items()})
    assert again.state.points["sinks"].identity.tolist() == [0, 1]
    assert 100 < len(again.state.mass) < 300
    for _ in range(40):
        body.advance(9.0)
        again.advance(9.0)
    for name, array in body.arrays().items():
        np.testing.assert_array_equal(array, again.arrays()[name], err_msg=name)
