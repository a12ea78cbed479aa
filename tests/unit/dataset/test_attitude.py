"""Obliquity, precession, wobble and settling time of rigid bodies: against closed forms and published rates."""

import numpy as np
import pytest

import astroinertia
from astroinertia.dataset.attitude import attitude_quantities, course
from astroinertia.plots.in_words import summary
from astroinertia.rotation import free_top, heavy_top
from astroinertia.rotation.precession import ARCSECOND, ARCSECOND_PER_YEAR, luni_solar_precession
from astroinertia.scene import load
from tests.sims import SIMS

DAY = 86400.0
TOP = """
name = "top"
model = "rigid"
units = "code"
[body]
kind = "rigid"
mass = 1.0
moments = MOMENTS
rotation = { rate = 1.0, wobble = WOBBLE, obliquity = 0.4 }
[effects]
[numerics]
integrator = "splitting"
[time]
end = 10.0
[output]
series_every = 0.5
"""


def ran(folder, path, *settings):
    return astroinertia.open(astroinertia.run_scene(astroinertia.load(path, settings), folder / "run"))


def top(folder, moments, wobble, *settings):
    text = TOP.replace("MOMENTS", str(moments)).replace("WOBBLE", str(wobble))
    return astroinertia.open(astroinertia.run_scene(load.loads(text, settings), folder / f"run{len(settings)}"))


def test_a_body_that_a_torque_sets_going_has_no_obliquity_before_and_is_judged_from_where_it_begins():
    """L of the first record is 0, and then turns about z at 2 rad/s, 0.3 from it: its precession rate is that."""
    time = np.linspace(0.0, 1.0, 11)
    momentum = np.stack(
        [np.sin(0.3) * np.cos(2.0 * time), np.sin(0.3) * np.sin(2.0 * time), np.cos(0.3) + 0.0 * time], 1
    )
    torque = np.zeros((11, 2, 3))
    torque[:, 0] = 2.0 * np.stack([-momentum[:, 1], momentum[:, 0], 0.0 * time], axis=1)
    momentum[0] = torque[0] = 0.0
    series = {"time": time, "angular_momentum": momentum, "torque": torque}
    series |= {
        "attitude": np.tile(np.eye(3), (11, 1, 1)),
        "inertia_tensor": np.tile(np.diag([1.0, 2.0, 2.5]), (11, 1, 1)),
    }
    found = attitude_quantities(series, held=False, deforms=False)
    for name in ("obliquity", "precession_rate", "wobble_angle"):
        assert np.isnan(found[name][0]), name
    np.testing.assert_allclose(found["obliquity"][1:], 0.3, rtol=1e-14)
    np.testing.assert_allclose(found["precession_rate"][1:], 2.0, rtol=1e-13)
    tilt = 0.3 * np.linspace(-1.2, 1.0, 11)  # through z, which it passes at 0.01, and does not go round
    momentum[1:] = np.stack([np.sin(tilt), np.full(11, 0.01), np.cos(tilt)], axis=1)[1:]
    assert "precession_rate" not in attitude_quantities(series, held=False, deforms=False)


def test_a_line_with_an_oscillation_gives_its_rate_also_where_turns_are_not_whole():
    time = np.linspace(0.0, 10.0, 500)
    for turns in (1.0, 1.37, 3.6, 40.2):
        found = course(time, 0.7 * time + 0.3 * np.sin(2.0 * np.pi * turns * time / 10.0 + 0.4))
        assert found is not None
        assert found.rate == pytest.approx(0.7, rel=1e-4)
        assert found.amplitude == pytest.approx(0.3, rel=1e-3)
        assert found.period == pytest.approx(10.0 / turns, rel=1e-3)


@pytest.mark.slow
def test_a_motion_that_is_no_line_and_no_oscillation_is_said_to_be_neither():
    time = np.linspace(0.0, 10.0, 500)
    blows = 0.3 * (time > 2.0) - 0.8 * (time > 3.1) + 0.5 * (time > 7.7)  # each of which turns it at once
    assert course(time, 0.05 * time + blows) is None
    assert course(time, 0.05 * time + 1e-3 * blows) is not None


@pytest.mark.slow
def test_a_free_symmetric_top_wobbles_and_precesses_as_euler_says(tmp_path):
    ds = top(tmp_path, [1.0, 1.0, 1.5], 0.3)
    inertia, momentum = ds.inertia_tensor.values[0], ds.angular_momentum.values[0]
    size = np.linalg.norm(momentum)
    assert np.linalg.norm(np.linalg.solve(inertia, momentum)) == pytest.approx(1.0)
    assert ds.wobble_angle.values == pytest.approx(0.3, abs=1e-12)
    assert ds.obliquity.values == pytest.approx(0.4, abs=1e-12)
    spin = size * np.cos(0.3) / 1.5  # about its own axis
    assert ds.wobble_period.values == pytest.approx(2.0 * np.pi / ((1.5 - 1.0) / 1.0 * spin), rel=1e-12)
    assert ds.free_precession_rate.values == pytest.approx(size / 1.0, rel=1e-12)
    # The axis itself, from one record to the next, goes round L by that rate.
    axis = ds.attitude.values[:, 2]
    across = axis - np.outer(axis @ momentum, momentum) / size**2
    turned = np.arctan2(np.cross(across[:-1], across[1:]) @ momentum / size, (across[:-1] * across[1:]).sum(axis=1))
    assert turned == pytest.approx(0.5 * size, rel=1e-10)
    assert not ds.precession_rate.values.any() and "mean" not in ds.precession_rate.attrs
    assert "wobble period" in summary(ds) and "precession rate, of torques" not in summary(ds)


@pytest.mark.slow
@pytest.mark.parametrize("moments", [[0.6, 1.0, 1.0], [1.0, 1.0, 1.0]])
def test_the_wobble_of_a_body_whose_largest_moments_are_equal_is_that_from_their_plane(tmp_path, moments):
    """Between them any axis has the largest moment; friction takes a long body there in the time that was asked for."""
    text = TOP.replace("MOMENTS", str(moments)).replace("wobble = WOBBLE", "axis = [0.1, 1.0, 0.3]")
    text = text.replace("[effects]", "[effects.internal_dissipation]\ntime_scale = 3.0")
    ds = astroinertia.open(astroinertia.run_scene(load.loads(text), tmp_path / "run"))
    along = np.abs(ds.attitude.values @ ds.angular_momentum.values[0]) / np.linalg.norm(ds.angular_momentum.values[0])
    if moments[0] == 1.0:
        assert not ds.wobble_angle.values.any()
    else:
        assert ds.wobble_angle.values == pytest.approx(np.arcsin(along[:, 0]), rel=1e-9)
        tangents = np.tan(ds.wobble_angle.values)
        assert tangents == pytest.approx(tangents[0] * np.exp(-ds.time.values / 3.0), rel=1e-6)
        assert ds.wobble_angle.attrs["settling_time"] == pytest.approx(3.0, rel=1e-2)
    assert "free_precession_rate" not in ds or np.isnan(ds.free_precession_rate).all()


@pytest.mark.slow
def test_a_wobble_that_is_round_off_of_the_attitude_is_said_to_be_none(tmp_path):
    ds = top(tmp_path, [1.0, 1.0, 1.5], 0.0)
    (angles,) = (line for line in summary(ds).splitlines() if line.startswith("wobble angle"))
    assert ds.wobble_angle.values.any()  # arctan of what is left in the last places
    assert angles.split()[-4:] == ["0"] * 4


@pytest.mark.slow
@pytest.mark.parametrize("wobble", [0.2, 1.4])  # about the largest moment, and about the least
def test_the_wobble_period_of_three_moments_is_that_of_the_elliptic_functions(tmp_path, wobble):
    ds = top(tmp_path, [1.0, 2.0, 2.5], wobble)
    spin = ds.attitude.values[0] @ ds.angular_momentum.values[0] / [1.0, 2.0, 2.5]
    expected = free_top.period(free_top.free_top((1.0, 2.0, 2.5), [float(rate) for rate in spin]))
    assert ds.wobble_period.values == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("unit", [1e-30, 1.0, 1e40])
@pytest.mark.parametrize("about", [0, 2])
def test_small_wobbles_about_the_least_and_the_largest_moment_have_the_periods_of_euler_in_any_unit(about, unit):
    """Omega^2 (I - I')(I - I'')/(I' I'') is the square of their rate; Goldstein, Poole & Safko 2002, section 5.6."""
    moments = np.array([1.0, 2.0, 2.5])
    least, other = (moments[k] for k in range(3) if k != about)
    rates = np.full(3, 1e-5)
    rates[about] = 0.7
    series = {
        "time": np.arange(2.0), "angular_momentum": unit * np.tile(moments * rates, (2, 1)),
        "torque": np.zeros((2, 2, 3)), "attitude": np.tile(np.eye(3), (2, 1, 1)),
        "inertia_tensor": unit * np.tile(np.diag(moments), (2, 1, 1)),
    }  # fmt: skip
    found = attitude_quantities(series, held=False, deforms=False)
    rate = 0.7 * np.sqrt((moments[about] - least) * (moments[about] - other) / (least * other))
    np.testing.assert_allclose(found["wobble_period"], 2.0 * np.pi / rate, rtol=1e-8)
    wobble = np.arctan2(np.hypot(1.0, 2.0) * 1e-5, 0.7 * 2.5) if about == 2 else np.arctan2(0.7, 2.5e-5)
    np.testing.assert_allclose(found["wobble_angle"], wobble, rtol=1e-8)
    size = np.linalg.norm(moments * rates)
    np.testing.assert_allclose(found["obliquity"], np.arccos(2.5 * rates[2] / size), rtol=1e-6)
    # Landau & Lifshitz, Mechanics, section 37: L (L_1^2/I_1 + L_2^2/I_2)/(L_1^2 + L_2^2)
    around = size * (rates[:2] ** 2 @ moments[:2]) / (rates[:2] ** 2 @ moments[:2] ** 2)
    np.testing.assert_allclose(found["free_precession_rate"], around, rtol=1e-8)


@pytest.mark.parametrize(("tilt", "known"), [(0.3, True), (1e-2, True), (1e-6, False), (0.0, False)])
def test_a_body_that_a_torque_moves_past_the_pole_has_no_rate_of_precession(tilt, known):
    """Beside the pole, a torque over the little of L that is across it would be a rate of any size."""
    time = np.linspace(0.0, 1.0, 20)
    pull = np.array([0.0, 5e-3, 0.0])
    momentum = np.array([np.sin(tilt), 0.0, np.cos(tilt)]) + time[:, None] * pull
    series = {
        "time": time, "angular_momentum": momentum, "torque": np.tile([pull, 0.0 * pull], (20, 1, 1)),
        "attitude": np.tile(np.eye(3), (20, 1, 1)), "inertia_tensor": np.tile(np.diag([1.0, 1.0, 2.0]), (20, 1, 1)),
    }  # fmt: skip
    found = attitude_quantities(series, held=False, deforms=False)
    assert ("precession_rate" in found) == known
    if known:
        assert found["precession_rate"][0] == pytest.approx(5e-3 / np.sin(tilt), rel=1e-12)
    assert "obliquity" in found and "wobble_angle" in found


@pytest.mark.full
def test_a_gyroscope_precesses_and_nods_as_the_heavy_top(tmp_path):
    ds = ran(tmp_path, SIMS / "gyroscope.toml", "time.end=2 s", "output.series_every=4 ms")
    transverse, weight = 4e-5 + 0.1 * 0.04**2, 0.1 * 9.81 * 0.04
    exact = heavy_top.heavy_top(transverse, 7e-5, weight, np.pi / 3.0, [0.0, 0.0, 200.0])
    assert ds.precession_rate.attrs["mean"] == pytest.approx(heavy_top.precession_rate(exact), rel=1e-3)
    assert ds.obliquity.attrs["nutation_period"] == pytest.approx(heavy_top.nutation_period(exact), rel=1e-3)
    assert "wobble_period" not in ds  # it is not free
    text = summary(ds)
    assert "mean precession rate 2.85" in text and "nutation amplitude" in text


@pytest.mark.full
def test_a_fast_gyroscope_precesses_by_the_torque_over_its_spin(tmp_path):
    settings = ("body.rotation.rate=4000 rad/s", "time.end=0.5 s", "output.series_every=1 ms")
    rate = ran(tmp_path, SIMS / "gyroscope.toml", *settings).precession_rate.attrs["mean"]
    assert rate == pytest.approx(0.1 * 9.81 * 0.04 / (7e-5 * 4000.0), rel=5e-4)


@pytest.mark.full(inputs=["sims/earth_precession.toml"])
def test_the_earth_precesses_and_nods_as_the_formulae_of_sun_and_moon_say(tmp_path):
    """As `verify` has it; the run is one turn of the node, and two sines of the year are left in the rate."""
    ds = ran(tmp_path, SIMS / "earth_precession.toml")
    published = luni_solar_precession()
    assert ds.precession_rate.attrs["mean"] == pytest.approx(-published.total, rel=2e-3)
    assert ds.obliquity.attrs["nutation_amplitude"] / ARCSECOND == pytest.approx(
        published.nutation_obliquity / ARCSECOND, rel=0.01
    )
    assert ds.obliquity.attrs["nutation_period"] / DAY / 365.25 == pytest.approx(18.6, rel=0.01)
    text = summary(ds)
    assert f"{ds.precession_rate.attrs['mean'] / ARCSECOND_PER_YEAR:.6g} arcsec/yr" in text


@pytest.mark.full
def test_a_small_wobble_settles_in_the_time_that_the_scene_says(tmp_path):
    settings = (
        "body.rotation.axis=[0, 0, 1]", "body.rotation.wobble=1 deg", "time.end=350 d", "output.series_every=1 d",
    )  # fmt: skip
    ds = ran(tmp_path, SIMS / "asteroid_settles.toml", *settings)
    assert ds.wobble_angle.attrs["settling_time"] == pytest.approx(100.0 * DAY, rel=3e-3)
    assert ds.wobble_angle.values[0] == pytest.approx(np.radians(1.0), rel=1e-9)
    assert "settling time 100" in summary(ds)


@pytest.mark.full(inputs=["sims/chandler_wobble.toml"])
def test_the_elastic_earth_wobbles_in_the_time_that_its_attitude_shows(tmp_path):
    ds = ran(tmp_path, SIMS / "chandler_wobble.toml", "time.end=450 d")
    assert ds.wobble_period.values / DAY == pytest.approx(445.39, abs=0.01)


@pytest.mark.slow
def test_the_wobble_period_of_what_hardly_yields_is_that_of_a_rigid_body(tmp_path):
    """Of three moments L goes round by a varying rate: its rate at a record had been 50 % off."""
    effect = "effects.rotational_deformation={love_number = 1e-9, radius = 1.0, rate = 0.0}"
    rigid, yielding = (top(tmp_path, [1.0, 2.0, 2.5], 0.2, *more) for more in ((), (effect, "time.end=25.0")))
    assert yielding.wobble_period.values == pytest.approx(rigid.wobble_period.values[0], rel=1e-3)  # 24 records a turn
    with pytest.raises(AttributeError, match="wobble_period"):  # of less than a turn
        _ = top(tmp_path, [1.0, 2.0, 2.5], 0.2, effect).wobble_period
