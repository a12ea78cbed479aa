"""Scaling laws at their ends: no spin, no pressure, no end; falls by twelve decades, bounces, a billion years."""

import math

import jax
import numpy as np
import pytest

import astroinertia
from astroinertia.bodies.polytrope import Polytrope
from astroinertia.build import scaling as start_scaling
from astroinertia.errors import NumericalError, SceneError
from astroinertia.models.scaling.homology import Dynamic, Kepler
from astroinertia.rotation import braking, pulsars
from astroinertia.rotation.collapsing_shells import shells_of
from astroinertia.rotation.spin_scaling import spin_up
from astroinertia.scene import load
from astroinertia.scene.plan import code_units

STAR = (
    'name = "a"\nmodel = "scaling"\nunits = "code"\n[body]\nkind = "polytrope"\nindex = 3.0\nmass = 1.0\nradius = 1.0\n'
)


def evolution(text: str):
    scene = load.loads(text)
    with jax.enable_x64(True):
        return start_scaling.evolution(scene, code_units(scene))


def test_a_cold_cloud_falls_to_a_point_and_what_was_seen_is_kept(tmp_path):
    text = STAR + "[effects.gravity]\n[time]\nend = 5.0\n[output]\nseries_every = 0.05\n"
    scene = load.loads(text)
    with pytest.raises(NumericalError, match=r"to a point: neither pressure nor spin stops it \(time 0\.\d+\)"):
        astroinertia.run_scene(scene, tmp_path / "run")
    kept = astroinertia.open(tmp_path / "run")
    assert kept.sizes["time"] > 5 and bool((kept["inertia_tensor"][1:, 2, 2].diff("time") < 0).all())


def test_the_least_spin_stops_a_collapse():
    # With 2T/|W| = 2e-8 at the start the body falls to 1e-8 of its size before it is thrown out again.
    law = Kepler(2e-8, 1.0)
    assert law.at(0.5 * law.period).scale == pytest.approx(1e-8, rel=1e-6)
    assert law.at(law.period).scale == pytest.approx(1.0, rel=1e-12)
    for share in (1e-3, 0.2, 0.4999, 0.5 - 1e-9, 0.5 + 1e-12, 0.7):
        size = law.at(share * law.period)
        parts = (0.5 * size.rate**2, 0.5 * law.repulsion / size.scale**2, -1.0 / size.scale)
        assert sum(parts) == pytest.approx(law.energy, abs=1e-14 * max(map(abs, (*parts, law.energy))))


def test_zero_spin_and_spin_alone():
    still = evolution(STAR + '[body.rotation]\nrate = 0.0\n[body.change]\ntimes = [1.0]\nfactors = [1e-12]\n'
                      "[effects.gravity]\n[effects.pressure]\n[time]\nend = 2.0\n")  # fmt: skip
    still.advance(2.0)
    record = still.record(0.0)
    assert np.array_equal(record["angular_momentum"], np.zeros(3)) and record["kinetic_energy"] == 0.0
    assert np.isfinite(record["virial_tensor"]).all()
    # Turned from rest by a torque: L = N t, along it.
    turned = evolution(STAR + "[effects.constant_torque]\nvector = [0.0, 0.1, 0.0]\n[time]\nend = 2.0\n")
    with jax.enable_x64(True):
        turned.advance(2.0)
        np.testing.assert_allclose(turned.record(0.0)["angular_momentum"], [0.0, 0.2, 0.0], rtol=1e-14)
    # Nothing holds a turning cloud without gravity: it flies apart along straight lines.
    gas = '[equation_of_state]\nkind = "isothermal"\nsound_speed = 1.0\n'
    free = evolution(STAR + gas + "[body.rotation]\nrate = 0.5\n[effects]\n[time]\nend = 100.0\n")
    opening = free.record(None)
    free.advance(100.0)
    spread = 1 + 2 * opening["kinetic_energy"] * 1e4 / np.trace(opening["second_moment"])
    assert np.trace(free.record(0.0)["second_moment"]) == pytest.approx(
        spread * np.trace(opening["second_moment"]), rel=1e-12
    )


def test_a_fall_by_twelve_decades_keeps_its_angular_momentum():
    change = "[body.change]\ntimes = [1.0, 1.5]\nfactors = [1e-3, 1e-12]\n"
    body = evolution(STAR + "[body.rotation]\nrate = -1e-9\n" + change +
                     "[effects.gravity]\n[effects.pressure]\n[time]\nend = 2.0\n")  # fmt: skip
    opening = body.record(None)
    for time in (1.0, 1.25, 1.5, 2.0):
        body.advance(time)
        record = body.record(0.0)
        assert record["angular_momentum"] == pytest.approx(opening["angular_momentum"], rel=1e-15)
    assert record["rotation_profile"] == pytest.approx(-1e3, rel=1e-12)


@pytest.mark.full
def test_a_stiff_bounce_repeats():
    # Cold below nuclear density, stiff above: the bounce is ten thousand times shorter than the fall.
    fluid = '[equation_of_state]\nkind = "hybrid"\ngamma_1 = 1.25\ngamma_2 = 3.0\nnuclear_density = 1e6\n'
    body = evolution(STAR.replace("[body]", "[body]\npressure_fraction = 0.6\nrelax = false") + fluid
                     + "[effects.gravity]\n[effects.pressure]\n[time]\nend = 1000.0\n")  # fmt: skip
    opening = body.record(None)
    body.advance(1000.0)
    record = body.record(opening["potential_energy"])
    assert abs(record["integration_energy_error"]) < 1e-6 * abs(record["gravitational_energy"])
    assert isinstance(body.dynamics, Dynamic) and math.isfinite(body.dynamics._period)
    body.advance(1000.0 - body.dynamics._period)
    again = body.record(0.0)
    assert again["second_moment"][0, 0] == pytest.approx(record["second_moment"][0, 0], rel=1e-8)


def test_a_neutral_star_with_spin_finds_no_rest():
    # n = 3 with gamma = 4/3: pressure holds it exactly, so that the least spin lets it expand for ever.
    gas = '[equation_of_state]\nkind = "polytropic"\ngamma = 1.3333333333333333\n'
    body = evolution(STAR.replace("[body]", "[body]\nrelax = false") + gas + "[body.rotation]\nrate = 0.01\n"
                     "[effects.gravity]\n[effects.pressure]\n[time]\nend = 1e6\n")  # fmt: skip
    opening = body.record(None)
    body.advance(1e6)
    record = body.record(opening["potential_energy"])
    assert record["second_moment"][0, 0] > 100 * opening["second_moment"][0, 0]
    assert abs(record["integration_energy_error"]) < 1e-13


def test_a_pulsar_after_a_billion_years():
    year = 365.25 * 86400
    text = ('name = "a"\nmodel = "scaling"\n[body]\nkind = "rigid"\nmass = "1.4 Msun"\nmoments = ["1e38 kg m2", '
            '"1e38 kg m2", "1e38 kg m2"]\nradius = "12 km"\n[body.rotation]\nperiod = "1.5 ms"\n'
            '[effects.dipole_braking]\nperiod = "1.5 ms"\nperiod_derivative = 1e-12\n'
            '[time]\nend = "1e9 yr"\n')  # fmt: skip
    scene = load.loads(text)
    units = code_units(scene)
    body = evolution(text)
    with jax.enable_x64(True):
        for years in (1e-6, 1.0, 1e4, 1e9):
            body.advance(years * year / units.time)
            record = body.record(0.0)
            spin = record["angular_momentum"][2] / record["inertia_tensor"][2, 2] / units.time
            assert 2 * math.pi / spin == pytest.approx(pulsars.period_history(years * year, 1.5e-3, 1e-12), rel=1e-10)


def test_torques_of_very_different_index():
    star = braking.Braking(4000.0, -1e-3, (0.0, 7.0), (1e-6, 1 - 1e-6))
    rates = star.history(np.array([1e3, 1e9, 3e11]))
    assert star.index(rates[0]) > 6.9 and star.index(rates[-1]) < 0.1
    np.testing.assert_allclose(star.time_to(rates), [1e3, 1e9, 3e11], rtol=1e-9)


def test_condensed_and_hollow_shells():
    condensed = Polytrope(4.9, 1.0, 1.0)
    shells = shells_of(condensed, 1.0, gravitational_constant=1.0)
    assert shells.moment_of_inertia == pytest.approx(condensed.moment_of_inertia, rel=1e-7)
    assert np.isfinite(shells.centrifugal_radius).all()


def test_what_is_beyond_numbers_is_refused():
    with pytest.raises(ValueError, match="positive and finite"):
        spin_up(0.1, 1e300 * 1e10, 1.0, 1.0, 0.1, 1.0, 1.0)
    with pytest.raises(SceneError, match="too fast"):
        evolution(STAR + '[equation_of_state]\nkind = "ideal"\n[body.rotation]\nrate = 10.0\n'
                  "[effects.gravity]\n[effects.pressure]\n[time]\nend = 1.0\n")  # fmt: skip
