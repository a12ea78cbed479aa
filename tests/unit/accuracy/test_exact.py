"""The exact answers of scenes against independent integrations and closed forms, and what has none."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from astroinertia.accuracy.exact import exact
from astroinertia.bodies import riemann
from astroinertia.bodies.cold_spheroid import ColdSpheroid
from astroinertia.orbits.rigid_ode import RigidBodyOde
from astroinertia.process import activity
from astroinertia.scene import load
from tests.exact_top import motion
from tests.tradeoff_scenes import CASES, PULSATION, SIMS, TOY_STAR

REFERENCE = Path(__file__).parents[2] / "reference"
SCENES = {case.name: case for case in CASES}


def of(name, *settings):
    found = exact(SCENES[name].scene(*settings))
    assert found is not None
    return found


@pytest.mark.parametrize(("name", "file", "time"), [("dyson", "dyson", 4.0), ("cold_spheroid", "cold", 0.9),
                                                    ("toy_star", "toy_star", 10.0)])  # fmt: skip
def test_ellipsoids_are_those_of_an_independent_integration(name, file, time):
    row = next(row for row in json.loads((REFERENCE / f"{file}.json").read_text())["value"] if row["t"] == time)
    found = of(name, f"time.end={time}")
    assert found.values["inertia_tensor"][2, 2] == pytest.approx(row["Izz"], rel=3 * found.accuracy)
    assert found.values["angular_velocity"][2] == pytest.approx(row["omega_Lz_over_Izz"], rel=3 * found.accuracy)


def test_a_cold_spheroid_is_that_of_lin_mestel_and_shu():
    motion_of = ColdSpheroid(1.0, 0.9, 0.2).motion(0.9)
    found = of("cold_spheroid")
    assert found.values["inertia_tensor"][2, 2] == pytest.approx(0.4 * motion_of.equatorial_radius**2, rel=1e-11)


def test_a_ball_of_gas_is_the_closed_form():
    found = exact(load.load_file(SIMS / "free_expansion.toml"))
    assert found is not None
    assert found.values["inertia_tensor"] == pytest.approx(4.75 * np.eye(3), rel=1e-11, abs=1e-11)


def test_figures_of_equilibrium_are_closed_forms():
    figure = riemann.from_vorticity_ratio(0.6, -1.0)  # of the scene, in units of its own
    found = of("riemann")
    assert "closed form" in found.source
    rate = figure.angular_velocity / math.sqrt(figure.mass / figure.mean_radius**3)
    angle = rate * 119.1
    tensor = found.values["second_moment"]
    turned = np.arctan2(2 * tensor[0, 1], tensor[0, 0] - tensor[1, 1]) / 2  # of the longest axis
    assert math.sin(turned - angle) == pytest.approx(0.0, abs=1e-10)
    spheroid = of("maclaurin")
    assert "closed form" in spheroid.source
    rate = SCENES["maclaurin"].scene().body.rotation.rate
    assert spheroid.values["angular_velocity"][2] == pytest.approx(rate, rel=1e-15)  # processors round differently


@pytest.mark.slow
def test_far_companions_do_not_shorten_the_steps_of_the_exact_answer(monkeypatch):
    """The Earth for 24 days: with a tolerance in Earth radii the Sun, 23 000 away, takes 50 times the steps."""
    shown, steps = [], []
    begin, integrate = activity.begin, RigidBodyOde.integrate
    monkeypatch.setattr(activity, "begin", lambda words: (shown.append(words), begin(words)))
    monkeypatch.setattr(RigidBodyOde, "integrate", lambda self, end: (integrate(self, end), steps.append(self.steps)))
    answer = exact(load.load_file(SIMS / "earth_precession.toml", ["time.end='24 d'"]))
    assert answer is not None and answer.accuracy < 1e-11
    assert max(steps) < 500
    assert "integrating the exact answer, 50% done" in shown


@pytest.mark.full
def test_a_figure_out_of_equilibrium_is_integrated():
    found = of("maclaurin", "body.rotation.rate=0.3")
    assert "DOP853" in found.source


def test_a_free_top_is_that_of_many_digits():
    scene = SCENES["rigid_top"].scene()
    body = scene.body
    axis = np.array(body.rotation.axis)
    spin = body.rotation.rate * axis / np.linalg.norm(axis)
    wanted = motion(body.moments, spin.tolist(), scene.time.end, digits=40)
    rotation = np.array(wanted.rotation.tolist(), dtype=float)
    found = of("rigid_top")
    assert found.values["attitude"] == pytest.approx(rotation.T, abs=1e-12)
    assert found.values["angular_velocity"] == pytest.approx(rotation @ [float(w) for w in wanted.angular_velocity])


def test_a_pulsation_has_the_frequency_of_the_mode():
    found = exact(load.loads(PULSATION))
    assert found is not None and set(found.values) == {"frequency of inertia_tensor"}
    wanted = {"n": 1, "Gamma1": "2", "mode": 0}
    modes = json.loads((REFERENCE / "modes.json").read_text())
    mode = next(mode for mode in modes if wanted.items() <= mode["inputs"].items())
    assert float(found.values["frequency of inertia_tensor"]) ** 2 == pytest.approx(float(mode["value"]), rel=1e-10)


@pytest.mark.parametrize(
    ("settings", "ratio"),
    [
        (("body.pressure_fraction=0.97",), 0.97**-0.75),  # x^-3/2 of the radius x of balance, x^2 = 0.97
        (("body.axes=[1.03, 1.03, 1.03]",), 1.0),  # whose entropies are those of the sphere of radius 1
    ],
)
def test_a_pulsation_is_about_the_radius_of_balance(settings, ratio):
    """Particles of n = 1.5 and gamma 5/3 with 0.97 of the pressure tend to a frequency 4.5 % above the mode's."""
    found, mode = (exact(load.loads(PULSATION, more)).values["frequency of inertia_tensor"] for more in (settings, ()))
    assert found / mode == pytest.approx(ratio, rel=1e-12)


COLLAPSE = (SIMS / "homologous_collapse.toml").read_text()


@pytest.mark.parametrize("model", ["sph", "ellipsoid", "scaling"])
def test_a_homologous_collapse_has_fallen_as_an_integration_says(model):
    """a'' = -k/a^2 with k = G M/R^3 at the critical rate, of which I goes as a^2."""
    found = exact(load.loads(COLLAPSE, [f"model={model}", "time.end=0.4"]))
    assert found is not None
    size = solve_ivp(lambda _, y: [y[1], -1 / y[0] ** 2], (0, 0.4), [1.0, -math.sqrt(2)], rtol=1e-12, atol=1e-14).y[
        0, -1
    ]
    at_first = exact(load.loads(COLLAPSE, ["time.end=1e-12"])).values["inertia_tensor"]
    np.testing.assert_allclose(found.values["inertia_tensor"], at_first * size**2, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.values["second_moment"], 0.5 * found.values["inertia_tensor"], rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "settings"),
    [
        (TOY_STAR, ("equation_of_state.gamma=1.9",)),  # not the exponent of the profile
        (TOY_STAR, ("body.rotation.law=j_constant", "body.rotation.scale=1.0")),
        (TOY_STAR, ("effects.gravity={}",)),
        (PULSATION, ("body.rotation={rate=0.1}",)),
        (PULSATION, ("body.pressure_fraction=0.7",)),
        (PULSATION, ("body.axes=[1.2, 1.2, 1.2]",)),
        ((SIMS / "cold_spheroid.toml").read_text(), ("time.max_steps=5",)),
        ((SIMS / "gyroscope.toml").read_text(), ()),
        (COLLAPSE, ("equation_of_state.gamma=1.4", "body.relax=false")),  # not the exponent of the collapse
        (COLLAPSE, ("body.pressure_fraction=0.99",)),
        (COLLAPSE, ("body.velocity_gradient=[[0.1,0,0],[0,0.1,0],[0,0,0.1]]",)),
        (COLLAPSE, ("body.axes=[1,1,0.9]",)),
        (COLLAPSE, ("time.end=0.4715",)),  # there is no body any more
        (COLLAPSE, ("equation_of_state.kind=polytropic", "equation_of_state.constant=0.3", "body.relax=false")),
    ],
)
def test_what_is_not_exact_is_not_called_so(text, settings):
    assert exact(load.loads(text, settings)) is None


@pytest.mark.parametrize("kind", ['kind = "polytrope"\nindex = 0.0', 'kind = "power_law"\nexponent = 0.0'])
def test_a_homogeneous_body_has_the_same_motion_by_any_name(kind):
    text = (SIMS / "cold_spheroid.toml").read_text()
    tensors = [exact(load.loads(body)).values["inertia_tensor"] for body in
               (text, text.replace('kind = "uniform"', kind))]  # fmt: skip
    assert tensors[1] == pytest.approx(tensors[0], rel=1e-12, abs=1e-15)
