"""What gravitational waves carry away, against a binary on a circular orbit, and how fast modes turn and grow."""

import numpy as np
import pytest
import xarray as xr

from astroinertia.bodies.bar_analysis import bar
from astroinertia.dataset import (
    accessor as _accessor,  # noqa: F401
    headline,
)
from astroinertia.dataset.waves import FAINTEST, too_faint, waves
from astroinertia.errors import AbsentError
from astroinertia.inertia import growth
from astroinertia.inertia.evolution import second_moment_acceleration
from astroinertia.models.sph.record import _modes
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS, SPEED_OF_LIGHT
from tests.unit import affine_datasets
from tests.unit.affine_body import METADATA, affine_run
from tests.unit.rigid_body import RIGID, rigid_run

MASS, APART = 1.4 * SOLAR_MASS, 1e8  # each of two stars, and their distance, in kg and m
RATE = (GRAVITATIONAL_CONSTANT * 2 * MASS / APART**3) ** 0.5


def binary(times):
    """d2Q/dt2 (T, 3, 3) of two stars on a circular orbit, in closed form."""
    angle = RATE * np.asarray(times)
    x = APART / 2 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    v = APART / 2 * RATE * np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=-1)
    kinetic = 2 * MASS * np.einsum("ti,tj->tij", v, v)
    virial = -2 * MASS * RATE**2 * np.einsum("ti,tj->tij", x, x)
    return second_moment_acceleration(kinetic, virial)


def test_a_circular_binary_radiates_as_peters_and_mathews_say():
    """32/5 G^4/c^5 m1^2 m2^2 (m1 + m2)/a^5 (Peters & Mathews 1963, eq. 16 with e = 0), and Omega dL = dE."""
    turns = 10
    times = np.linspace(0, turns * 2 * np.pi / RATE, 64 * turns + 1)
    found = waves(times, binary(times), GRAVITATIONAL_CONSTANT)
    power = 32 / 5 * GRAVITATIONAL_CONSTANT**4 / SPEED_OF_LIGHT**5 * MASS**4 * 2 * MASS / APART**5
    # The slope of the spline is off by (2 Omega dt)^6/15120 within, and dt^5 at the very ends, of which few are given.
    assert np.abs(found.luminosity[8:-8] / power - 1).max() < 1e-7
    assert np.abs(found.luminosity / power - 1).max() < 3e-5
    assert found.energy[-1] == pytest.approx(power * times[-1], rel=2e-7)
    assert found.angular_momentum[-1, 2] == pytest.approx(found.energy[-1] / RATE, rel=2e-6)
    assert np.abs(found.angular_momentum[:, :2]).max() < 1e-10 * found.angular_momentum[-1, 2]
    assert (np.diff(found.energy) > 0).all()


@pytest.mark.parametrize(("each", "within", "at_ends", "of_energy"), [(12, 1e-5, 7e-3, 6e-5), (24, 2e-7, 2e-4, 6e-7)])
def test_few_records_a_period_give_what_the_module_says(each, within, at_ends, of_energy):
    times = np.linspace(0, 10 * np.pi / RATE, 10 * each + 1)
    found = waves(times, binary(times), GRAVITATIONAL_CONSTANT)
    power = 32 / 5 * GRAVITATIONAL_CONSTANT**4 / SPEED_OF_LIGHT**5 * MASS**4 * 2 * MASS / APART**5
    errors = np.abs(found.luminosity / power - 1)
    assert errors[each:-each].max() < within and errors.max() < at_ends
    assert found.energy[-1] == pytest.approx(power * times[-1], rel=of_energy)


def test_the_spectrum_holds_the_energy_and_peaks_at_twice_the_orbit():
    turns = 20
    times = np.linspace(0, turns * 2 * np.pi / RATE, 64 * turns + 1)
    found = waves(times, binary(times), GRAVITATIONAL_CONSTANT)
    width = found.frequency[1]
    assert found.energy_spectrum.sum() * width == pytest.approx(found.energy[-1], rel=5e-3)
    assert found.frequency[np.argmax(found.energy_spectrum)] == pytest.approx(RATE / np.pi, abs=width)
    strain = (2 * GRAVITATIONAL_CONSTANT / np.pi**2 / SPEED_OF_LIGHT**3 * found.energy_spectrum) ** 0.5
    assert np.allclose(found.characteristic_strain, strain, rtol=1e-12)


def test_a_sphere_that_pulsates_sends_no_waves():
    """What is the same in all directions radiates nothing, alone or beside a binary: only the trace changes."""
    times = np.linspace(0, 20 * np.pi / RATE, 641)
    pulsation = 3e43 * np.cos(1.7 * RATE * times)[:, None, None] * np.eye(3)  # J; the binary's has 1e43
    alone, both, bare = (
        waves(times, part, GRAVITATIONAL_CONSTANT) for part in (pulsation, binary(times) + pulsation, binary(times))
    )
    assert alone.energy[-1] < 1e-20 * bare.energy[-1]
    for found, known in zip(both, bare, strict=True):
        np.testing.assert_allclose(found, known, rtol=1e-9, atol=1e-12 * abs(known).max())


def test_the_spectrum_of_even_records_reaches_half_their_rate():
    times = np.linspace(0, 20 * np.pi / RATE, 641)
    found = waves(times, binary(times), GRAVITATIONAL_CONSTANT)
    np.testing.assert_allclose(found.frequency, np.arange(321) / (641 * times[1]), rtol=1e-12)
    four, three = (waves(times[:count], binary(times[:count]), GRAVITATIONAL_CONSTANT) for count in (4, 3))
    assert np.isfinite(four.luminosity).all() and np.isnan(three.luminosity).all()


def test_uneven_records_give_the_same_energy():
    random = np.random.default_rng(3)
    times = np.sort(random.uniform(0, 20 * np.pi / RATE, 1500))
    found = waves(times, binary(times), GRAVITATIONAL_CONSTANT)
    even = np.linspace(times[0], times[-1], 1500)
    assert found.energy[-1] == pytest.approx(waves(even, binary(even), GRAVITATIONAL_CONSTANT).energy[-1], rel=5e-3)
    assert found.energy_spectrum.sum() * found.frequency[1] == pytest.approx(found.energy[-1], rel=2e-2)


def test_the_spectrum_of_uneven_records_reaches_half_the_rate_of_the_closest_usual_ones():
    """Three quarters of the steps are a tenth of the others, and one by chance is far shorter."""
    steps = np.resize([0.1, 0.1, 0.1, 1.0], 40)
    steps[5] = 1e-6
    times = np.concatenate([[0.0], np.cumsum(steps)]) / RATE
    found = waves(times, binary(times), GRAVITATIONAL_CONSTANT)
    assert found.frequency[-1] == pytest.approx(0.5 * RATE / 0.1, rel=0.02)


def test_waves_are_too_faint_where_all_of_their_strain_is_known_and_below_a_limit():
    faint, strong = np.full(3, 0.9 * FAINTEST), np.array([0.0, -1.1 * FAINTEST, 0.0])
    assert too_faint(faint, faint) and too_faint(np.zeros(0))
    assert not too_faint(faint, strong) and not too_faint(strong, faint)
    assert not too_faint(faint, np.array([0.0, np.nan, 0.0]))  # not known to be


def test_energy_converges_with_the_number_of_records():
    errors = []
    for each in (8, 16, 32):
        times = np.linspace(0, 10 * 2 * np.pi / RATE, each * 10 + 1)
        power = waves(times, binary(times), GRAVITATIONAL_CONSTANT).luminosity
        exact = 32 / 5 * GRAVITATIONAL_CONSTANT**4 / SPEED_OF_LIGHT**5 * MASS**4 * 2 * MASS / APART**5
        errors.append(np.abs(power[each:-each] / exact - 1).max())
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (order > 5.5).all()


def test_few_or_unknown_records_have_no_waves():
    times = np.arange(3.0)
    assert np.isnan(waves(times, binary(times), GRAVITATIONAL_CONSTANT).energy).all()
    times = np.arange(9.0)
    broken = binary(times)
    broken[4] = np.nan
    assert np.isnan(waves(times, broken, GRAVITATIONAL_CONSTANT).energy_spectrum).all()


def turning_bar(rate=0.7, count=400):
    random = np.random.default_rng(6)
    position = random.normal(size=(count, 3)) * [1.5, 1.0, 0.5]
    mass = random.uniform(0.5, 1.5, count)
    position -= mass @ position / mass.sum()
    return mass, position, np.cross([0.0, 0.0, rate], position)


def test_every_mode_of_what_turns_rigidly_turns_at_that_rate():
    mass, position, velocity = turning_bar()
    found = _modes(mass, position, velocity)
    assert np.allclose(found["mode_pattern_speed"], 0.7, rtol=1e-12)
    assert (found["ring_mode_amplitude"] > 0).all()


def test_pattern_speed_is_the_derivative_of_the_phase():
    """Of any motion: against the phase a little earlier and later."""
    mass, position, velocity = turning_bar()
    velocity = velocity + 0.3 * np.sin(position[:, [1, 2, 0]])
    early, late = (_modes(mass, position + dt * velocity, velocity) for dt in (-1e-5, 1e-5))
    speed = np.angle(np.exp(1j * (late["mode_phase"] - early["mode_phase"]))) / 2e-5 / [1, 2, 3, 4]
    assert np.allclose(_modes(mass, position, velocity)["mode_pattern_speed"], speed, rtol=1e-5)


def test_a_point_has_no_bar():
    assert np.isnan(bar(np.zeros((2, 3, 3)), np.zeros((2, 3, 3)))[0]).all()


def test_a_ring_has_the_mode_that_the_middle_lacks():
    """A bar in the middle half of the mass, all else round."""
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    ring = np.pi * (np.arange(400) % 2) + 0.02 * angle
    phi = np.concatenate([angle, ring, ring, angle])
    radius = np.concatenate([np.full(400, 0.2), np.full(800, 1.0), np.full(400, 2.0)])
    position = np.stack([radius * np.cos(phi), radius * np.sin(phi), 0 * phi], axis=1)
    found = _modes(np.ones(1600), position, np.zeros_like(position))
    assert found["ring_mode_amplitude"][1] > 0.99
    assert found["mode_amplitude"][1] == pytest.approx(0.5, abs=0.01)
    assert found["ring_mode_amplitude"][0] < 0.01


def test_growth_and_turning_are_found_in_a_dataset():
    times = np.linspace(0, 5, 60)
    random = np.random.default_rng(1)
    size = 1e-3 * np.exp(0.8 * times) * np.exp(0.01 * random.normal(size=60))
    phases = np.angle(np.exp(1j * np.outer(times, [0.5, 2 * 1.3, 0.0, 0.0])))
    data = xr.Dataset(
        {
            "inertia_tensor": (("time", "i", "j"), np.tile(np.eye(3), (60, 1, 1))),
            "mass": ("time", np.ones(60), {"units": "kg"}),
            "bar_strength": ("time", size),
            "mode_phase": (("time", "mode"), phases),
        },
        {"time": times, "mode": [1, 2, 3, 4]},
    )
    grown = data.inertia.growth_rate("bar_strength", 1.0, 4.0)
    assert abs(float(grown["rate"]) - 0.8) < 4 * float(grown["error"]) < 0.02
    assert grown["rate"].attrs["units"] == "s-1"
    assert float(data.inertia.pattern_speed(2)["rate"]) == pytest.approx(1.3, rel=1e-12)
    with pytest.raises(ValueError, match="record more often"):
        data.isel(time=slice(None, None, 14)).inertia.pattern_speed(2)
    with pytest.raises(ValueError, match="at least three"):
        data.inertia.growth_rate("bar_strength", 1.0, 1.05)


@pytest.mark.slow
def test_a_pattern_speed_needs_a_mode_that_has_a_size():
    records, _ = affine_run(outputs=24, particles=64)
    amplitude = np.zeros((len(records), 4))
    phase = np.pi * np.resize([0.0, 1.0], amplitude.shape[::-1]).T
    still = {name: np.stack([record[name] for record in records]) for name in records[0]}
    round_body = headline(still | {"mode_amplitude": 1e-16 + amplitude, "mode_phase": phase}, METADATA)
    with pytest.raises(AbsentError, match="azimuthal mode of order 2 has no size here, so its phase is undefined"):
        round_body.inertia.pattern_speed(2)
    with pytest.raises(AbsentError, match="no azimuthal mode of order 2: the body is known by its mass and moments"):
        affine_datasets.headline(rigid_run()[:5], RIGID).inertia.pattern_speed(2)
    # where the mode comes to have a size only later, its speed is that since then
    amplitude[5:] = 0.1
    phase[5:] = 2 * 0.3 * still["time"][5:, None]
    grown = headline(still | {"mode_amplitude": amplitude, "mode_phase": phase}, METADATA)
    found = grown.inertia.pattern_speed(2)["rate"] * grown.attrs["code_unit_time"]
    assert float(found) == pytest.approx(0.3, rel=1e-12)


@pytest.mark.slow
def test_means_of_phases_are_phases_of_means():
    """Phases go on over whole turns: a mean over both sides of one would be half a turn off."""
    records, _ = affine_run(outputs=60, particles=64)
    series = {name: np.stack([record[name] for record in records]) for name in records[0]}
    times = np.linspace(0.0, 30.0, len(records))
    amplitude, phases = np.full((len(times), 4), 0.1), np.outer(times, [0.7, 1.4, 2.1, 2.8])
    turning = series | {"mode_amplitude": amplitude, "mode_phase": np.angle(np.exp(1j * phases)), "time": times}
    data = headline(turning, METADATA)
    np.testing.assert_allclose(data.mode_phase, phases, rtol=1e-13, atol=1e-13)
    unit = data.attrs["code_unit_time"]
    for mean in (
        data.coarsen(time=3, boundary="trim").mean(),
        data.rolling(time=3).mean(),
        data.interp(time=data.time[:-1] + 0.2 * unit),
    ):
        assert float(mean.inertia.pattern_speed(2)["rate"]) * unit == pytest.approx(0.7, rel=1e-9)


def test_the_direction_of_a_bar_goes_on_over_half_turns():
    angle = np.linspace(0.0, 9.0, 40)
    turned = np.stack([np.diag([2.0, 1.0, 1.0])] * 40)
    cos, sin = np.cos(angle), np.sin(angle)
    axes = np.moveaxis(np.array([[cos, -sin, 0 * cos], [sin, cos, 0 * cos], [0 * cos, 0 * cos, 0 * cos + 1]]), 2, 0)
    second = axes @ turned @ axes.transpose(0, 2, 1)
    series = {"time": angle, "mass": np.ones(40), "second_moment": second, "mixed_moment": 0 * second,
              "inertia_tensor": np.trace(second, axis1=1, axis2=2)[:, None, None] * np.eye(3) - second}  # fmt: skip
    found = headline(series, {"name": "x", "dimensionless": True, "effects": [], "code_units": None})["bar_phase"]
    np.testing.assert_allclose(found, angle, atol=1e-12)


def test_a_line_has_the_slope_the_errors_and_the_residual_of_least_squares():
    """Of unknown records nothing; the covariance is that of NumPy's polynomials."""
    random = np.random.default_rng(8)
    times = np.sort(random.uniform(3.0, 9.0, 12))
    values = 5.0 - 0.7 * times + random.normal(size=12)
    values[4] = np.nan
    known = np.isfinite(values)
    (slope, intercept), covariance = np.polyfit(times[known], values[known], 1, cov=True)
    found = growth.line(times, values)
    assert (found.slope, found.intercept) == pytest.approx((slope, intercept), rel=1e-11)
    assert found.error == pytest.approx(np.sqrt(covariance[0, 0]), rel=1e-11)
    left = values[known] - slope * times[known] - intercept
    assert found.residual == pytest.approx(np.sqrt((left**2).mean()), rel=1e-11)


def test_scenes_in_code_units_have_no_waves_and_say_why():
    metadata = {"name": "x", "dimensionless": True, "effects": ["gravity"], "code_units": None}
    count = 6
    tensor = np.tile(np.eye(3), (count, 1, 1))
    series = {
        "time": np.arange(float(count)), "mass": np.ones(count), "inertia_tensor": tensor, "second_moment": tensor,
        "mixed_moment": tensor, "kinetic_tensor": tensor, "virial_tensor": tensor[:, None],
    }  # fmt: skip
    data = headline(series, metadata)
    for name in ("gw_luminosity", "gw_energy", "gw_angular_momentum", "gw_energy_spectrum"):
        assert np.isnan(data[name]).all()
        assert "speed of light" in data[name].attrs["reason"]
