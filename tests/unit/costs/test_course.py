"""How many steps runs are predicted to take, beside how many they took."""

import json
import time
from pathlib import Path

import numpy as np
import pytest

from astroinertia.costs import course, machine, piloted, plan_lines, shells
from astroinertia.costs.prediction import predict
from astroinertia.scene import load

pytestmark = pytest.mark.usefixtures("own_cache")

ROOT = Path(__file__).parents[3]
RUNS = json.loads((ROOT / "tests" / "benchmarks" / "results" / "predicted_steps.json").read_text())
PREDICTED = [
    *("giant_impact", "neutron_star", "progenitor_collapse", "rocky_planet", "spinning_planet"),
    *("bar_mode", "cold_spheroid", "contracting_star", "dyson_ellipsoid", "evrard", "free_expansion", "gresho"),
    *("homologous_collapse", "kelvin_helmholtz", "keplerian_disc", "made_to_order", "noh", "pulsar_collapse"),
    *("rotating_star", "sedov", "sod", "square", "strong_tube"),
    *("accretion_induced_collapse", "core_collapse", "tidal_disruption"),
]
CLOUD = """
name = "cloud"
units = "code"
body = {kind = "uniform", particles = 300, mass = 1, radius = 1, relax = false}
effects = {gravity = {}, pressure = {}, viscosity = {}}
time = {end = 2}
[equation_of_state]
kind = "isothermal"
"""
FEW = (
    "core_collapse",
    "evrard",
    "giant_impact",
    "gresho",
    "neutron_star",
    "sod",
    "spinning_planet",
)  # all of them: test-full


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in FEW else pytest.mark.full(inputs=[f"sims/{name}.toml"]))
        for name in PREDICTED
    ],
)
def test_runs_took_the_steps_that_are_predicted(name, monkeypatch):
    """Without a pilot, within a factor of 1.5 of what tests/benchmarks/predicted_steps.py counted."""
    monkeypatch.setattr(piloted, "kept", lambda scene: None)
    run = RUNS[name]
    particles = [f"body.particles={run['particles']}"]
    if name == "giant_impact":
        particles = [f"bodies.{k}.particles={round(share * run['particles'])}" for k, share in enumerate((0.87, 0.13))]
    found = predict(load.load_file(ROOT / "sims" / f"{name}.toml", particles), machine.current())
    assert found is not None and found.steps_by == "an estimate"
    assert run["steps"] / 1.5 < found.steps < 1.5 * run["steps"]


def followed(scene, end):
    """Times and sizes of a body that keeps its profile."""
    start = course.at_start(scene)
    return course.similar(scene, start, end)[:2]


def test_a_body_that_flies_apart_at_once_has_a_course_all_the_same():
    """A step of its own pace is then too short for the time to change by it."""
    hot = load.load_file(ROOT / "sims" / "evrard.toml", ["body.specific_internal_energy=1e10"])
    times, _ = followed(hot, hot.time.end)
    assert (np.diff(times) > 0.0).all() and times[-1] == hot.time.end
    assert course.counted(hot).steps > 0.0


@pytest.mark.parametrize(("start", "end"), [("parabolic", 0.45649740094), ("rest", 1.0953407700317674)])
def test_a_homologous_core_is_followed_to_a_tenth_of_its_size(start, end):
    """The run takes 205 steps, and 316 from rest with 300 particles."""
    scene = load.load_file(ROOT / "sims" / "homologous_collapse.toml", [f"body.start={start}", f"time.end={end}"])
    times, sizes = followed(scene, 0.98 * end)
    exact = scene.body.core(1.0, 1.0)
    assert sizes[-1] == pytest.approx(float(exact.scale_factor(times[-1])), rel=0.05)
    assert course.counted(scene).steps == pytest.approx({"parabolic": 205, "rest": 319}[start], rel=0.1)


@pytest.mark.slow
def test_no_number_of_steps_is_claimed_of_a_collapse_that_nothing_stops():
    """Nor of a cloud of one temperature by the pressure that would hold it up: one took 1453 steps, not 200."""
    cold = load.loads(CLOUD, ["equation_of_state.sound_speed=0.05"])
    assert predict(cold, machine.shipped()) is None
    assert plan_lines.lines(cold, None)[0].value == "not known"


def test_nothing_is_known_of_pressures_beyond_all_numbers():
    """Of a gas of density 2.4e35 and pressure 1e353: without a warning."""
    text = CLOUD.replace("isothermal", "polytropic").replace("radius = 1,", "radius = 1e-12,")
    stiff = load.loads(text, ["equation_of_state.gamma=10.0", "equation_of_state.constant=1.0"])
    assert predict(stiff, machine.shipped()) is None


TURNING_GAS = CLOUD.replace("end = 2}", "end = 2.5}\noutput = {align = false}").replace(
    "particles = 300", "particles = 500, rotation = {t_over_w = 0.1}"
)


@pytest.mark.parametrize(
    ("gas", "settings", "taken"),
    [
        ("polytropic", ["body.pressure_fraction=0.01"], 1313),
        ("ideal", ["body.specific_internal_energy=0.01"], 525),
        (
            "ideal",
            ["body.specific_internal_energy=0.02", "equation_of_state.gamma=1.4", "body.rotation.t_over_w=0.15"],
            478,
        ),
    ],
)
def test_a_cloud_that_falls_to_a_bar_stays_dense(gas, settings, taken):
    """The steps that runs took: a third of the first, of shells that swing back as they have their angular momentum,
    and ten times as many as the last where what bars dissipate is no heat.
    """
    scene = load.loads(
        TURNING_GAS.replace("isothermal", gas), ["equation_of_state.gamma=1.6666666666666667", *settings]
    )
    assert taken / 1.5 < course.counted(scene).steps < 2.5 * taken


@pytest.mark.parametrize("ratio", [0.1, 0.2])
def test_rotation_stops_no_gas_of_one_temperature(ratio, monkeypatch):
    """A run came to 1e9 times the first density, and went on; its bar carries the angular momentum away."""
    monkeypatch.setattr(shells, "MOST_STEPS", 2000)  # shells that swing back are there in 980
    settings = ["equation_of_state.sound_speed=0.3", f"body.rotation.t_over_w={ratio}"]
    assert course.counted(load.loads(TURNING_GAS, settings)) is None


def test_a_gas_of_one_temperature_falls_within_and_swells_outside():
    """A run took 77 steps and was 10 times as dense at its centre; one zone, which swells, would take 20."""
    settings = ["equation_of_state.sound_speed=0.4", "body.rotation.t_over_w=0.25"]
    scene = load.loads(TURNING_GAS, settings)
    assert not course.at_start(scene).evenly_driven
    assert 77 / 1.7 < course.counted(scene).steps < 1.7 * 77


def test_what_pulsates_for_long_is_followed_for_a_while():
    """A million dynamical times take as long to plan as a hundred, which take 0.3 s, and as many steps a time."""
    text = CLOUD.replace("isothermal", "polytropic").replace("end = 2", "end = 100")
    text = text.replace('"uniform"', '"polytrope", index = 1.5')
    settings = ["equation_of_state.gamma=1.6666666666666667", "body.pressure_fraction=0.7", "output.align=false"]
    short = course.counted(load.loads(text, settings))
    begun = time.process_time()
    long = course.counted(load.loads(text, [*settings, "time.end=1e6"]))
    assert time.process_time() - begun < 5.0
    assert long.steps == pytest.approx(1e4 * short.steps, rel=0.03)


@pytest.mark.parametrize("rotation", ["t_over_w=0.05", "angular_momentum=0.2", "rate=0.6"])
def test_shells_turn_as_the_body_does_however_that_is_said(rotation):
    scene = load.loads(CLOUD, ["equation_of_state.sound_speed=0.5", f"body.rotation.{rotation}"])
    start = course.at_start(scene)
    zone, second = start.zone, 0.6  # of a uniform sphere: |W| is 0.6, and I is 0.4
    each = {"t_over_w": 0.05 * 0.6, "angular_momentum": 0.2**2 / 0.8, "rate": 0.5 * 0.4 * 0.6**2}
    kinetic = each[rotation.split("=")[0]]
    assert zone.turning * second == pytest.approx(2.0 * kinetic, rel=0.05)  # edges of 40 shells carry their masses
