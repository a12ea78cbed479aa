"""The scaling model: its laws, its ledger, its datasets, and what it refuses."""

import math

import jax
import numpy as np
import pytest
from scipy.integrate import quad

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.build import scaling as start_scaling
from astroinertia.errors import NumericalError, SceneError
from astroinertia.inertia.evolution import second_moment_acceleration
from astroinertia.inertia.tensor import axial_vector
from astroinertia.models.scaling.evolution import PROFILES, RIGIDITY
from astroinertia.rotation import pulsars
from astroinertia.scene import load
from astroinertia.scene.plan import code_units

HEAD = 'name = "a"\nmodel = "scaling"\nunits = "code"\n[time]\nend = 2.0\n'
STAR = HEAD + '[body]\nkind = "polytrope"\nindex = 1.5\nmass = 1.0\nradius = 1.0\n'
LIGHT = STAR.replace("mass = 1.0", "mass = 1e-6")
TURNING = "[body.rotation]\nrate = 0.1\n"
GAS = '[equation_of_state]\nkind = "ideal"\ngamma = 1.6666666666666667\n'
BOUND = "[effects.gravity]\n[effects.pressure]\n"
CHANGE = "[body.change]\ntimes = [0.5, 1.0]\nfactors = [0.5, 0.01]\n"


def evolution(text: str):
    scene = load.loads(text)
    with jax.enable_x64(True):
        return start_scaling.evolution(scene, code_units(scene))


def record(body, time: float):
    with jax.enable_x64(True):
        body.advance(time)
        return body.record(0.0)


SCENES = {
    "prescribed": STAR + TURNING + CHANGE + BOUND,
    "pulsating": STAR.replace("[body]\n", "[body]\nrelax = false\npressure_fraction = 0.8\n") + TURNING + GAS + BOUND,
    "integrated": STAR.replace("[body]\n", "[body]\nrelax = false\npressure_fraction = 0.8\n")
    + TURNING
    + GAS.replace("1.6666666666666667", "1.5")
    + BOUND,
    "settled": STAR + TURNING + GAS + BOUND,
    "falling": STAR.replace('end = 2.0', 'end = 0.9') + "[effects.gravity]\n",
    "oblate": STAR.replace("index", "axes = [1.0, 1.0, 0.7]\nindex") + TURNING + CHANGE + BOUND,
    "differential": STAR + '[body.rotation]\nlaw = "j_constant"\nscale = 0.3\nrate = 0.8\n' + CHANGE + BOUND,
    "star": HEAD
    + '[body]\nkind = "rotating_star"\nindex = 1.0\nmass = 1.0\nradius = 1.0\naxis_ratio = 0.8\n'
    + CHANGE
    + BOUND,
    "gaseous star": HEAD + '[body]\nkind = "rotating_star"\nindex = 1.5\nmass = 1.0\nradius = 1.0\naxis_ratio = 0.8\n'
    + GAS
    + BOUND,
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_the_ledger_closes(name):
    body = evolution(SCENES[name])
    end, step = (0.6 if name == "falling" else 0.7), 1e-4
    before, now, after = (record(body, end + k * step) for k in (-1, 0, 1))
    # dQ/dt = P + P^T and d2Q/dt2 = 2 K + sum of V + V^T, by differences of Q.
    rate = (after["second_moment"] - before["second_moment"]) / (2 * step)
    np.testing.assert_allclose(now["mixed_moment"] + now["mixed_moment"].T, rate, atol=2e-7)
    second = (after["second_moment"] - 2 * now["second_moment"] + before["second_moment"]) / step**2
    found = second_moment_acceleration(now["kinetic_tensor"], now["virial_tensor"].sum(axis=0))
    np.testing.assert_allclose(found, second, atol=3e-6)
    np.testing.assert_allclose(axial_vector(now["mixed_moment"]), now["angular_momentum"], atol=1e-15)
    assert now["kinetic_energy"] == pytest.approx(0.5 * np.trace(now["kinetic_tensor"]), rel=1e-14)
    # Work is the change of the kinetic energy; a free body's energies are in balance.
    opening = evolution(SCENES[name]).record(None)
    assert now["work"].sum() == pytest.approx(now["kinetic_energy"] - opening["kinetic_energy"], abs=1e-12)
    assert abs(now["integration_energy_error"]) < 1e-12
    at_first, at_last = evolution(SCENES[name]).figures(), body.figures()  # of the progress line
    assert abs(at_last.total_energy - at_first.total_energy) < 1e-11 * at_last.energy_scale
    assert body.effects[-1] == RIGIDITY and len(now["virial_tensor"]) == len(body.effects)
    if name in ("pulsating", "integrated", "falling"):
        # The row that keeps the shape does no work and has no share in the scalar virial.
        assert abs(np.trace(now["virial_tensor"][-1])) < 1e-12 and now["work"][-1] == 0.0


def test_spin_follows_the_moment():
    body = evolution(SCENES["prescribed"])
    opening, later = record(body, 0.0), record(body, 1.5)
    np.testing.assert_allclose(later["angular_momentum"], opening["angular_momentum"], rtol=0)
    np.testing.assert_allclose(later["inertia_tensor"], 0.01 * opening["inertia_tensor"], rtol=1e-14)
    assert later["rotation_profile"] == pytest.approx(100 * 0.1, rel=1e-13)  # 1/I
    assert later["density_max"] == pytest.approx(1e3 * opening["density_max"], rel=1e-13)
    assert later["gravitational_energy"] == pytest.approx(10 * opening["gravitational_energy"], rel=1e-13)
    star = Polytrope(1.5)
    assert opening["inertia_tensor"][2, 2] == pytest.approx(star.moment_of_inertia, rel=1e-12)
    assert opening["gravitational_energy"] == pytest.approx(star.gravitational_energy, rel=1e-12)
    assert opening["density_max"] == pytest.approx(star.central_density, rel=1e-4)
    shells = later["radius_profile"], later["specific_angular_momentum_profile"]
    np.testing.assert_allclose(shells[1][1:], 2 / 3 * 10 * shells[0][1:] ** 2, rtol=6e-3)
    # In the innermost ball the mean square of the radius is 16/15 of the square of its mean.
    assert shells[1][0] == pytest.approx(2 / 3 * 10 * 16 / 15 * shells[0][0] ** 2, rel=6e-3)
    assert np.all(np.diff(later["density_profile"]) < 0)


def test_differential_rotation_keeps_its_profile():
    body = evolution(SCENES["differential"])
    opening, later = record(body, 0.0), record(body, 1.5)
    assert np.all(np.diff(opening["rotation_profile"]) < 0) and opening["rotation_profile"][0] < 0.8
    np.testing.assert_allclose(later["rotation_profile"], 100 * opening["rotation_profile"], rtol=1e-12)
    # Sum over shells of the j profile is L; and the energy exceeds that of the mean angular velocity.
    momentum = float(opening["angular_momentum"][2])
    assert opening["specific_angular_momentum_profile"].mean() == pytest.approx(momentum, rel=1e-5)
    mean_spin = 0.5 * momentum**2 / opening["inertia_tensor"][2, 2]
    assert opening["kinetic_energy"] > 1.1 * mean_spin
    assert later["kinetic_energy"] == pytest.approx(100 * opening["kinetic_energy"], rel=1e-12)


def test_differential_rotation_of_a_spheroid_has_the_sums_over_its_cylinders():
    """Omega = 0.8/(1 + (w/A)^2); columns of a homogeneous spheroid weigh 3 M w/a^2 (1 - w^2/a^2)^(1/2) dw."""
    body = '[body]\nkind = "uniform"\naxes = [1.2, 1.2, 0.5]\nmass = 2.0\nradius = 1.5\n'
    law = '[body.rotation]\nlaw = "j_constant"\nscale = 0.9\nrate = 0.8\n'
    found = record(evolution(HEAD + body + law + "[effects]\n"), 0.0)

    def over(power: int) -> float:
        return quad(lambda w: 6 * w**3 / 1.8**2 * (1 - (w / 1.8) ** 2) ** 0.5 * (0.8 / (1 + (w / 0.9) ** 2)) ** power,
                    0.0, 1.8)[0]  # fmt: skip

    assert found["angular_momentum"][2] == pytest.approx(over(1), rel=1e-4)
    assert found["kinetic_energy"] == pytest.approx(0.5 * over(2), rel=1e-4)


TIMES = {  # 1.0 of what has no unit but that of time or of a density
    "mass": 8.0, "radius_profile": 2.0, "specific_angular_momentum_profile": 4.0,
    **dict.fromkeys(("time", "step", "density_max", "density_profile", "rotation_profile", "mode_amplitude"), 1.0),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_a_body_of_eight_times_the_mass_and_twice_the_radius_does_the_same_at_the_same_times(name):
    """G M/R^3 is that of the first: energies, moments and angular momenta are 32 times as large."""
    large = SCENES[name].replace("mass = 1.0", "mass = 8.0").replace("radius = 1.0", "radius = 2.0")
    one, other = (record(evolution(text), 0.6) for text in (SCENES[name], large.replace("scale = 0.3", "scale = 0.6")))
    for key, values in one.items():
        times = TIMES.get(key, 32.0)
        size = np.abs(np.nan_to_num(values)).max()
        np.testing.assert_allclose(
            np.asarray(other[key]) / times, values, rtol=1e-9, atol=1e-9 * size + 1e-12, err_msg=key
        )


def test_free_fall_of_a_star_takes_its_own_time():
    star = Polytrope(1.5)
    body = evolution(SCENES["falling"])
    trace = 1.5 * star.moment_of_inertia
    expected = math.pi / 2 / math.sqrt(2 * -star.gravitational_energy / trace)
    assert body.law is not None
    assert body.law.collapse_time == pytest.approx(expected, rel=1e-12)
    uniform = evolution(SCENES["falling"].replace("index = 1.5", "index = 0.0"))
    assert uniform.law.collapse_time == pytest.approx(math.pi / math.sqrt(8), rel=1e-12)  # R^3/(G M) = 1
    with pytest.raises(NumericalError, match="collapses to a point"):
        body.advance(0.9)


def test_a_settled_body_swells_and_stays():
    body = evolution(SCENES["settled"])
    first, last = record(body, 0.0), record(body, 2.0)
    assert first["second_moment"][0, 0] == last["second_moment"][0, 0]
    swollen = math.sqrt(first["inertia_tensor"][2, 2] / Polytrope(1.5).moment_of_inertia)
    # gamma = 5/3: s^2 + ... : 2 T = |W| (1/s - 1/s^2) with T at the given rate.
    kinetic = 0.5 * 0.1**2 * Polytrope(1.5).moment_of_inertia * swollen**2
    assert 2 * kinetic == pytest.approx(6 / 7 * (1 / swollen - 1 / swollen**2), rel=1e-11)
    assert first["kinetic_energy"] == pytest.approx(kinetic, rel=1e-12)
    virial = sum(np.trace(row) for row in first["virial_tensor"][:-1]) + 2 * first["kinetic_energy"]
    assert abs(virial) < 1e-12
    fast = SCENES["settled"].replace("rate = 0.1", "t_over_w = 0.1")
    assert record(evolution(fast), 0.0)["kinetic_energy"] == pytest.approx(
        -0.1 * record(evolution(fast), 0.0)["gravitational_energy"], rel=1e-12
    )


def test_a_stiff_body_settles_by_its_own_exponent():
    """n = 1, P ~ rho^2: 2 T = |W| (1/s - 1/s^3) at the given rate, with |W| = 3/4."""
    star = Polytrope(1.0).moment_of_inertia
    text = SCENES["settled"].replace("index = 1.5", "index = 1.0").replace("gamma = 1.6666666666666667", "gamma = 2.0")
    body = evolution(text.replace("rate = 0.1", "rate = 0.3"))
    first, last = record(body, 0.0), record(body, 2.0)
    np.testing.assert_allclose(last["second_moment"], first["second_moment"], rtol=1e-9)
    swollen = math.sqrt(first["inertia_tensor"][2, 2] / star)
    assert 0.3**2 * star * swollen**2 == pytest.approx(0.75 * (1 / swollen - 1 / swollen**3), rel=1e-9)


@pytest.mark.parametrize("pressure", [GAS, ""])
def test_a_rotating_star_that_its_own_pressure_holds_stays(pressure):
    """3 Pi = |W| - 2 T, of the gas that it was made of shell by shell."""
    body = evolution(SCENES["gaseous star"].replace(GAS, pressure))
    opening, later = record(body, 0.0), record(body, 2.0)
    assert "stays" in body.approximation and opening["angular_momentum"][2] > 0.0
    np.testing.assert_array_equal(later["second_moment"], opening["second_moment"])
    held = np.trace(opening["virial_tensor"][list(body.names).index("pressure")])
    assert held == pytest.approx(-opening["gravitational_energy"] - 2 * opening["kinetic_energy"], rel=1e-6)


def test_closed_forms_and_integration_are_one_law():
    closed = evolution(SCENES["pulsating"])
    near = evolution(SCENES["pulsating"].replace("1.6666666666666667", "1.6666666667"))
    assert closed.dynamics is None and near.dynamics is not None
    for time in (0.3, 1.1, 1.9):
        assert record(near, time)["second_moment"][0, 0] == pytest.approx(
            record(closed, time)["second_moment"][0, 0], rel=1e-8
        )


def test_hubble_flow_and_what_has_no_shells():
    text = STAR.replace("[body]\n", "[body]\nvelocity_gradient = [[0.5, 0, 0], [0, 0.5, 0], [0, 0, 0.5]]\n")
    body = evolution(text + GAS + "[effects]\n")  # nothing acts
    assert record(body, 2.0)["second_moment"][1, 1] == pytest.approx(4 * record(body, 0.0)["second_moment"][1, 1])
    star = evolution(SCENES["star"])
    assert all(name in star.absent for name in PROFILES)
    with pytest.raises(SceneError, match="multiple of the unit matrix"):
        evolution(text.replace("[0, 0.5, 0]", "[0, 0.1, 0]") + GAS + "[effects]\n")


def test_a_checkpoint_goes_on_bit_for_bit():
    for name in ("integrated", "pulsating", "prescribed"):
        body = evolution(SCENES[name])
        record(body, 0.7)
        arrays = {key: np.array(value) for key, value in body.arrays().items()}
        scene = load.loads(SCENES[name])
        resumed = start_scaling.resumed(scene, code_units(scene), arrays)
        assert (resumed.time, resumed.steps) == (body.time, body.steps)
        one, other = record(body, 1.3), record(resumed, 1.3)
        for key, value in one.items():
            np.testing.assert_array_equal(np.asarray(value), np.asarray(other[key]), err_msg=key)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (STAR.replace("index", "axes = [1.0, 0.9, 0.8]\nindex") + TURNING + BOUND, "not symmetric about"),
        (LIGHT.replace("index", "axes = [1.0, 0.9, 0.8]\nindex") + TURNING + BOUND, "not symmetric about"),
        (STAR + TURNING.replace("rate = 0.1", "rate = 5.0") + GAS + BOUND, "too fast"),
        (STAR + TURNING.replace("rate = 0.1", "t_over_w = 0.1") + GAS + "[effects]\n", "self-gravitating"),
        (HEAD + '[body]\nkind = "power_law"\nexponent = 2.6\nmass = 1.0\nradius = 1.0\n' + BOUND, "infinite"),
        (STAR + "[effects.pressure]\n", "or gravity that it holds up"),
    ],
)
def test_what_scaling_cannot_tell_is_refused(text, message):
    with pytest.raises(SceneError, match=message):
        evolution(text)


PULSAR = (
    'name = "a"\nmodel = "scaling"\n[time]\nend = "3000 yr"\n[body]\nkind = "polytrope"\nindex = 1.0\n'
    'mass = "1.4 Msun"\nradius = "12 km"\n[body.rotation]\nperiod = "33.3924123 ms"\n[effects.dipole_braking]\n'
)


@pytest.mark.slow
@pytest.mark.parametrize("index", [1.0, 2.51, 3.0, 5.0])
def test_a_pulsar_brakes_with_any_index(index):
    text = PULSAR + f'period = "33.3924123 ms"\nperiod_derivative = 4.20972e-13\nindex = {index}\n'
    scene = load.loads(text)
    units = code_units(scene)
    body = evolution(text)
    opening = record(body, 0.0)
    for years in (1.0, 968.0, 3000.0):
        time = years * 365.25 * 86400
        found = record(body, time / units.time)
        spin = found["angular_momentum"][2] / found["inertia_tensor"][2, 2] / units.time
        expected = pulsars.period_history(time, 0.0333924123, 4.20972e-13, index)
        assert 2 * math.pi / spin == pytest.approx(expected, rel=1e-11)
        # All that it has lost is the torque's work.
        lost = found["kinetic_energy"] - opening["kinetic_energy"]
        assert found["work"][0] == pytest.approx(lost, rel=1e-8)
        assert abs(found["work"][-1]) < 1e-8 * abs(lost)
        np.testing.assert_allclose(axial_vector(found["virial_tensor"].sum(axis=0)), found["torque"].sum(axis=0))


def test_a_field_brakes_as_its_conventions_say():
    text = PULSAR + 'field = "3.793563149e12 G"\nradius = "12 km"\n'
    units = code_units(load.loads(text))
    found = record(evolution(text), 0.0)
    moment = float(found["inertia_tensor"][2, 2]) * units.unit("moment_of_inertia")
    slowing = pulsars.dipole_period_derivative(0.0333924123, 3.793563149e8, moment, 1.2e4)
    rate = 2 * math.pi / 0.0333924123
    expected = -moment * slowing * rate**2 / (2 * math.pi)
    assert found["torque"][0, 2] * units.unit("energy") == pytest.approx(expected, rel=1e-9)


@pytest.mark.full
def test_torques_on_a_body_that_shrinks():
    torque = "[effects.constant_torque]\nvector = [0.0, 0.0, -0.01]\nbegin = 0.3\nuntil = 0.8\n"
    body = evolution(SCENES["prescribed"] + torque)
    opening, found = record(body, 0.0), record(body, 2.0)
    assert found["angular_momentum"][2] == pytest.approx(opening["angular_momentum"][2] - 0.005, rel=1e-13)
    assert record(body, 0.5)["torque"][body.names.index("constant_torque"), 2] == pytest.approx(-0.01)
    # A sphere may be turned about another axis; a body with one axis of its own may not.
    aslant = torque.replace("[0.0, 0.0, -0.01]", "[0.01, 0.0, 0.0]")
    turned = record(evolution(SCENES["prescribed"] + aslant), 2.0)
    assert turned["angular_momentum"][0] == pytest.approx(0.005, rel=1e-13)
    with pytest.raises(NumericalError, match="take the model rigid"):
        evolution(SCENES["oblate"] + aslant).advance(2.0)
    with pytest.raises(SceneError, match="does not follow: take the model rigid"):
        evolution(SCENES["prescribed"] + torque + 'frame = "body"\n')


@pytest.mark.slow
def test_a_torque_on_a_pulsating_body_is_in_its_energy():
    torque = "[effects.constant_torque]\nvector = [0.0, 0.0, 0.003]\n"
    for name in ("pulsating", "integrated"):
        body = evolution(SCENES[name] + torque)
        found = record(body, 2.0)
        assert abs(found["integration_energy_error"]) < 1e-11 and found["work"][-1] == 0.0
        opening = evolution(SCENES[name]).record(None)["angular_momentum"][2]
        assert found["angular_momentum"][2] == pytest.approx(opening + 0.006, rel=1e-12)


@pytest.mark.parametrize(
    "kind",
    [
        'kind = "polytrope"\nindex = 1.5\nradius = 1.5\n',
        'kind = "uniform"\naxes = [1.0, 1.0, 0.7]\nradius = 1.5\n',
        'kind = "rotating_star"\nindex = 1.0\naxis_ratio = 1.0\nradius = 1.5\n',
        'kind = "rigid"\nradius = 1.5\nmoment_ratios = [0.3, 0.3, 0.35]\n',
    ],
)
def test_what_a_torque_does_to_a_body_at_rest_is_all_its_energy_of_rotation(kind):
    torque = "[effects.constant_torque]\nvector = [0.0, 0.0, 0.003]\n"
    found = record(evolution(f"{HEAD}[body]\nmass = 2.0\n{kind}{torque}"), 2.0)
    assert found["angular_momentum"][2] == pytest.approx(0.006, rel=1e-12)
    energy = 0.5 * 0.006**2 / found["inertia_tensor"][2, 2]
    np.testing.assert_allclose([found["kinetic_energy"], *found["work"]], [energy, energy, 0.0], rtol=1e-9, atol=1e-15)
    assert not np.nan_to_num(found["gravitational_energy"])  # the scene lists no gravity


def test_dysons_expansion_is_exact():
    # An isentropic gas of exponent 5/3 without gravity: s^2 = 1 + c t^2, to the last digits.
    text = HEAD + '[body]\nkind = "dyson"\ngamma = 1.6666666666666667\nmass = 1.0\nradius = 1.0\nentropy = 0.3\n'
    body = evolution(text + GAS + "[effects.pressure]\n")
    opening, later = record(body, 0.0), record(body, 2.0)
    growth = later["second_moment"][0, 0] / opening["second_moment"][0, 0]
    squared_speed = 2 * opening["internal_energy"] / np.trace(opening["second_moment"])
    assert growth == pytest.approx(1 + squared_speed * 4.0, rel=1e-14)
    # Its internal energy by the closed form: U = (3/2) A integral of rho^(5/3), rho ~ (1 - s^2)^(3/2).
    central = math.gamma(4.0) / (math.pi**1.5 * math.gamma(2.5))
    integral = 2 * math.pi * central ** (5 / 3) * math.gamma(1.5) * math.gamma(3.5) / math.gamma(5.0)
    assert opening["internal_energy"] == pytest.approx(1.5 * 0.3 * integral, rel=1e-12)
    assert later["total_energy"] == pytest.approx(opening["total_energy"], rel=1e-14)


def test_a_held_body_is_held_by_the_pressure_that_it_needs():
    body = evolution(SCENES["prescribed"])  # no equation of state
    row, opening = body.names.index("pressure"), record(body, 0.0)
    balance = np.trace(opening["virial_tensor"][:-1].sum(axis=0)) + 2 * opening["kinetic_energy"]
    assert abs(balance) < 1e-14 and np.isnan(opening["internal_energy"])
    later = record(body, 1.5)
    # Pi ~ 1/s: its work from s = 1 to 1/10 is minus nine times 3 Pi_0, and heats what it compresses.
    assert later["work"][row] == pytest.approx(-9 * np.trace(opening["virial_tensor"][row]), rel=1e-12)
    assert later["heating"][row] == -later["work"][row] and later["heating"].sum() == later["heating"][row]
