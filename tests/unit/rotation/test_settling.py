"""What a settling body loses, exactly, and the times that authors give for it."""

import json
from pathlib import Path

import numpy as np
import pytest

from astroinertia.rotation import settling

ENTRY = next(
    entry
    for entry in json.loads((Path(__file__).parents[2] / "reference" / "free_top.json").read_text())
    if entry["name"] == "relaxation_time"
)
YEAR = 365.25 * 86400.0


def test_the_reference_settling_time():
    inputs = ENTRY["inputs"]
    rigidity = float(inputs["muQ"].split()[0]) / 100
    time = settling.settling_time(
        rigidity, 100, inputs["rho"], inputs["r_m"], 2 * np.pi / inputs["P_s"], inputs["K3^2"]
    )
    assert time / YEAR == pytest.approx(float(ENTRY["value"].split()[0]), rel=1e-9)


def test_harris_has_the_form_of_burns_and_safronov():
    middle, least, greatest = settling.harris_settling_time(10 * 3600.0, 2000.0)
    assert middle == pytest.approx(1000 / (17.0**3 * 4) * 1e9 * YEAR, rel=1e-15)
    assert least < middle < greatest
    same = settling.settling_time(5e9, 100, 2000, 1000.0, 2 * np.pi / 36000, 0.03)
    assert least < same < greatest
    assert middle == pytest.approx(same, rel=0.05)


def test_the_energy_to_lose_is_the_difference_of_energies_at_one_angular_momentum():
    moments, spin = np.array([2.9, 1.3, 2.1]), np.array([-0.2, 0.6, 0.5])
    momentum = np.linalg.norm(moments * spin)
    energy = 0.5 * (moments * spin**2).sum()
    assert settling.energy_to_lose(moments, spin) == pytest.approx(energy - momentum**2 / 5.8, rel=1e-14)
    assert settling.energy_above_separatrix(moments, spin) == pytest.approx(energy - momentum**2 / 4.2, rel=1e-13)
    rate = settling.settled_rate(moments, spin)
    assert rate == pytest.approx(momentum / 2.9)
    assert settling.energy_to_lose(moments, np.array([rate, 0, 0])) == 0.0


def test_a_small_wobble_keeps_the_digits_of_its_energy():
    # 1e-20 of the whole energy, which a difference of energies would lose
    lost = settling.energy_to_lose([1.0, 2.0, 3.0], [[1e-10, 0.0, 1.0], [0.0, 1e-10, 1.0]])
    np.testing.assert_allclose(lost, [1e-20 / 3, 1e-20 / 3], rtol=1e-15)


def test_a_body_settles_through_the_separatrix():
    moments, spin = [1.0, 2.0, 3.0], [1.0, 0.1, 0.1]
    time = settling.time_of_separatrix(moments, spin, 7.0)
    left = settling.excess_energy(moments, spin, time, 7.0)
    passed = settling.energy_to_lose(moments, spin) - settling.energy_above_separatrix(moments, spin)
    assert left == pytest.approx(passed, rel=1e-14)
    step = 1e-6
    before, after = settling.excess_energy(moments, spin, [time - step, time + step], 7.0)
    assert settling.settling_power(left, 7.0) == pytest.approx((before - after) / (2 * step), rel=1e-8)
    assert settling.time_of_separatrix(moments, [0.1, 0.1, 1.0], 7.0) == 0.0
    assert settling.time_of_separatrix([1.0, 3.0, 3.0], spin, 7.0) == np.inf


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match="density must be positive and finite"):
        settling.settling_time(1.0, 1.0, 0.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="period must be positive and finite"):
        settling.harris_settling_time(-1.0, 1.0)
    with pytest.raises(ValueError, match="three finite moments"):
        settling.energy_to_lose([1.0, 2.0], [1.0, 2.0])


def test_times_of_the_separatrix_go_by_leading_axes():
    moments, rates = (
        np.array([1.0, 2.0, 4.0]),
        np.array([[4.0, 0.0, 0.0], [0.1, 0.0, 4.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.1]]),
    )
    found = settling.time_of_separatrix(moments, rates, 10.0)
    assert found.tolist() == [settling.time_of_separatrix(moments, one, 10.0) for one in rates]
    assert found[0] > found[3] > 0.0 == found[1] == found[2]
    assert settling.time_of_separatrix(np.array([1.0, 4.0, 4.0]), rates[0], 10.0) == np.inf


def test_what_is_not_known_passes_no_separatrix():
    assert np.isnan(settling.time_of_separatrix([1.0, 2.0, 4.0], [np.nan, 0.0, 0.0], 1.0))  # it had passed at 0
