"""Companions beside a particle fluid: orbits as REBOUND has them, and a ledger that closes while masses move."""

from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

import astroinertia
from astroinertia.build.assemble import prepare
from astroinertia.build.sph import resumed
from astroinertia.errors import SceneError
from astroinertia.models.sph.evolution import STEPS_BETWEEN_SORTS
from astroinertia.orbits.simulation import Companion, simulation
from astroinertia.orbits.states import states
from astroinertia.scene import load
from astroinertia.scene.plan import code_units
from tests.evolve import prepared, reached

pytestmark = pytest.mark.usefixtures("steps_differ")

STAR = """
name = "accompanied"
units = "code"
[body]
kind = "polytrope"
index = 1.5
particles = 200
mass = 1.0
radius = 1.0
relax = false
axes = [1.1, 1.0, 0.9]
rotation = { law = "rigid", rate = 0.4 }
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
[effects.gravity]
[effects.pressure]
[effects.viscosity]
[time]
end = 1.0
"""
ECCENTRICITY, DISTANCE, MASS = 0.3, 6.0, 0.7
COMPANION = f"""
[[companions]]
name = "neighbour"
mass = {MASS}
semi_major_axis = {DISTANCE}
eccentricity = {ECCENTRICITY}
inclination = 0.4
"""
MOON = """
[[companions]]
name = "moon"
mass = 1e-3
around = "neighbour"
semi_major_axis = 1.0
"""
PERIOD = 2 * np.pi * np.sqrt(DISTANCE**3 / (1 + MASS))


def companions_of(motion: str, frame: str = "direct", more: str = "") -> str:
    return STAR + f'[effects.companions]\nmotion = "{motion}"\nframe = "{frame}"\nsoftening = 0.05\n' + COMPANION + more


def orbit_at(time: float) -> np.ndarray:
    """Where the companion is relative to the body, by REBOUND, (3,)."""
    given = Companion("neighbour", MASS, semi_major_axis=DISTANCE, eccentricity=ECCENTRICITY, inclination=0.4)
    return states(simulation(1.0, [given]), np.array([time]))[0][0, 0]


SCHEMES = {
    "global": (),
    "individual": ("numerics.timesteps=individual",),
    "xla": ("numerics.engine=xla",),
}


@pytest.mark.full
def test_the_ledger_closes_with_live_companions_in_the_xla_engine(result: Any) -> None:
    ledger_closes_with("xla")
    result(engine="xla", particles=200)


@pytest.mark.parametrize("scheme", ["global", "individual"])
def test_fluid_and_live_companions_keep_momentum_angular_momentum_and_energy(scheme: str) -> None:
    """Two companions and a star that is no sphere: all is kept to round-off, and the torque is what the star gains."""
    ledger_closes_with(scheme)


def ledger_closes_with(scheme: str) -> None:
    with jax.enable_x64(True):
        body = prepared(companions_of("live", more=MOON), *SCHEMES[scheme], "numerics.precision=float64")
        first, last = reached(body, 1.0)
    row = list(body.effects).index("companions")
    impulse = np.abs(last["impulse"][row]).max()
    assert impulse > 1e-3
    assert np.abs(last["system_momentum"] - first["system_momentum"]).max() <= 1e-14
    assert np.abs(last["system_angular_momentum"] - first["system_angular_momentum"]).max() <= 1e-13
    assert np.linalg.norm(first["system_momentum"]) <= 1e-13  # the centre of mass of all is at rest
    assert last["ledger_closure"] <= 1e-13
    assert max(last["virial_mismatch"]) <= 1e-12
    assert abs(last["total_energy"] - first["total_energy"]) <= 1e-4 * abs(first["total_energy"])
    lost = last["total_energy"] - first["total_energy"] - last["integration_energy_error"]
    assert abs(lost) <= 1e-12 * abs(first["total_energy"])
    # Spin-orbit exchange: what the star's angular momentum gains is the row of the companions' torque, all of it.
    gained = last["angular_momentum"] - first["angular_momentum"]
    moment = last["mixed_impulse"][row]
    torque = np.array([moment[1, 2] - moment[2, 1], moment[2, 0] - moment[0, 2], moment[0, 1] - moment[1, 0]])
    assert np.abs(gained - torque).max() <= 1e-13
    assert np.linalg.norm(torque) > 1e-6


CLOUD = """
name = "two_points"
units = "code"
[body]
kind = "uniform"
particles = 64
mass = 1.0
radius = 3e-3
specific_internal_energy = 1e-9
relax = false
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
[numerics]
acceleration_factor = 2.0
[time]
end = 30.0
[effects.companions]
"""


@pytest.mark.full
@pytest.mark.parametrize("scheme", ["global", "individual"])
def test_a_compact_ball_and_a_point_move_as_two_points(scheme: str) -> None:
    """A cloud far smaller than its orbit, left to its companion alone: REBOUND's orbit, to the square of the step."""
    errors = []
    for longest in (0.4, 0.2, 0.1):
        settings = [*SCHEMES[scheme], f"numerics.max_timestep={longest}", "effects.companions.motion=live"]
        _, last = reached(prepared(CLOUD + COMPANION, *settings), 30.0)
        relative = last["companion_position"][0] - last["centre_of_mass"]
        errors.append((relative - orbit_at(30.0)) / DISTANCE)
    sizes = [np.linalg.norm(error) for error in errors]
    assert sizes[0] / sizes[1] == pytest.approx(4.0, rel=0.02), sizes
    assert sizes[1] / sizes[2] == pytest.approx(4.0, rel=0.02), sizes
    # What remains without the error of the steps: the fourth order of theirs, and the size of the cloud.
    assert np.linalg.norm(errors[2] - (errors[1] - errors[2]) / 3.0) < 1e-6


@pytest.mark.parametrize("frame", [pytest.param("direct", marks=pytest.mark.full), "tidal"])
def test_on_prescribed_orbits_the_ball_stays_where_the_orbits_have_the_body(frame: str) -> None:
    """The companion is where REBOUND has it; the cloud, which nothing holds, goes along or stays at the origin."""
    _, last = reached(
        prepared(CLOUD + COMPANION, "numerics.max_timestep=0.1", f"effects.companions.frame={frame}"), 30.0
    )
    relative = orbit_at(30.0)
    body = -MASS / (1.0 + MASS) * relative if frame == "direct" else np.zeros(3)
    assert np.abs(last["companion_position"][0] - (body + relative)).max() <= 1e-11
    assert np.abs(last["centre_of_mass"] - body).max() <= 1e-4 * DISTANCE  # of the steps
    assert last["companion_energy"][0] == pytest.approx(-MASS / (2 * DISTANCE), rel=1e-5)


def test_the_tidal_frame_is_the_inertial_one_less_its_fall() -> None:
    """The same star in both frames keeps the same shape and spin."""
    ends = [
        reached(prepared(companions_of("orbit", frame).replace("[effects.viscosity]\n", "")), 0.5)[-1]
        for frame in ("direct", "tidal")
    ]
    for name in ("inertia_tensor", "angular_momentum", "mixed_moment"):
        assert np.allclose(ends[0][name], ends[1][name], rtol=1e-8, atol=1e-8), name


@pytest.mark.full
def test_individual_steps_follow_the_same_orbits() -> None:
    """Two companions, one close to the star, so that particles have many rungs: as with global steps."""
    near = COMPANION.replace(f"semi_major_axis = {DISTANCE}", "semi_major_axis = 2.0")
    text = companions_of("live", more=MOON.replace("1.0", "0.3")).replace(COMPANION, near)
    ends = [reached(prepared(text, *SCHEMES[scheme]), 1.0)[-1] for scheme in ("global", "individual")]
    for name in ("companion_position", "companion_velocity", "centre_of_mass"):
        assert np.allclose(ends[0][name], ends[1][name], atol=2e-3), name


@pytest.mark.parametrize("motion", ["live", "orbit"])
@pytest.mark.parametrize("timesteps", [pytest.param("global", marks=pytest.mark.full), "individual"])
def test_a_run_with_companions_resumes_bit_for_bit(motion: str, timesteps: str) -> None:
    """From a checkpoint the run goes on with the same bits, companions and all."""
    scene = load.loads(companions_of(motion, more=MOON), [f"numerics.timesteps={timesteps}", "time.end=30.0"])
    bodies = [prepare(scene).evolution for _ in range(2)]
    for body in bodies:
        for _ in range(STEPS_BETWEEN_SORTS):
            body.advance(30.0)
    bodies[1] = resumed(scene, code_units(scene), {name: array.copy() for name, array in bodies[1].arrays().items()})
    for body in bodies:
        for _ in range(STEPS_BETWEEN_SORTS):
            body.advance(30.0)
    one, other = (body.arrays() for body in bodies)
    assert one.keys() == other.keys()
    for name, array in one.items():
        np.testing.assert_array_equal(array, other[name], err_msg=name)


def test_the_dataset_has_the_companions_under_their_names_in_SI(tmp_path: Path) -> None:
    text = companions_of("live").replace('units = "code"', '[units]\nmass = "1 Msun"\nlength = "1 Rsun"')
    for number in ("mass = 1.0", f"mass = {MASS}"):
        text = text.replace(number, f'mass = "{number[7:]} Msun"')
    for old, new in (
        (f"semi_major_axis = {DISTANCE}", f'semi_major_axis = "{DISTANCE} Rsun"'),
        ("radius = 1.0", 'radius = "1 Rsun"'),
        ("rate = 0.4", 'rate = "1e-4 rad/s"'), ("softening = 0.05", 'softening = "0.05 Rsun"'),
        ("inclination = 0.4", 'inclination = "0.4 rad"'), ("end = 1.0", 'end = "10 min"'),
    ):  # fmt: skip
        text = text.replace(old, new)
    dataset = astroinertia.open(astroinertia.run_scene(load.loads(text), tmp_path / "run"))
    assert list(dataset["companion"].values) == ["neighbour"]
    assert dataset["companion_position"].dims == ("time", "companion", "i")
    assert dataset["companion_position"].attrs["units"] == "m"
    away = dataset["companion_position"][0, 0] - dataset["centre_of_mass"][0]
    assert float(np.sqrt((away**2).sum())) == pytest.approx(DISTANCE * (1 - ECCENTRICITY) * 6.957e8, rel=1e-6)
    assert (
        np.ptp(dataset["system_angular_momentum"].values, axis=0).max()
        <= 1e-13 * np.abs(dataset["system_angular_momentum"].values).max()
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (STAR + COMPANION, "act on particles by .effects.companions., which the scene does not list"),
        (STAR + "[effects.companions]\n", "needs ..companions.."),
        (companions_of("live", "tidal"), "frame must be"),
        (companions_of("live") + "[effects.rotating_frame]\nrate = 0.1\n", "rotating_frame. acts on the fluid alone"),
        (companions_of("orbit") + "[orbits]\nback_reaction = true\n", "particles act back with motion"),
        (STAR + '[effects.companions]\nmotion = "live"\n[orbits]\narchive = "a.bin"\n', "not with .orbits. archive"),
    ],
)
def test_what_contradicts_itself_is_refused_in_one_sentence(text: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        prepared(text)


def test_a_scene_without_companions_records_nothing_of_them() -> None:
    record = prepared(STAR).record(None)
    assert not [name for name in record if name.startswith(("companion", "system"))]
