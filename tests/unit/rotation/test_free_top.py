"""Free rotation in closed form: against independent reference values, mpmath and the theorems of motion."""

import json
from pathlib import Path

import numpy as np
import pytest

from astroinertia.rotation import free_top
from tests import exact_top

ENTRIES = [
    entry
    for entry in json.loads((Path(__file__).parents[2] / "reference" / "free_top.json").read_text())
    if entry["name"] == "asymmetric_top"
]


@pytest.mark.parametrize("kind", [str, float])
@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: ",".join(entry["inputs"]["I"] + entry["inputs"]["omega0"]))
def test_reference_values(entry, kind):
    top = free_top.free_top(*([kind(each) for each in entry["inputs"][name]] for name in ("I", "omega0")))
    value = entry["value"]
    limit = 4e-16
    assert free_top.period(top) == pytest.approx(float(value["period"]), rel=limit)
    assert abs(np.pi / free_top.wobble_rate(top)) == pytest.approx(float(value["half_period_2K"]), rel=limit)
    assert float(top.argument_rate) == pytest.approx(float(value["rate_p"]), rel=limit)
    assert float(top.modulus.square) == pytest.approx(float(value["k2"]), rel=2e-12 if kind is float else limit)
    assert top.energy == pytest.approx(float(value["T"]), rel=limit)
    assert float(top.angular_momentum) == pytest.approx(float(value["L"]), rel=limit)
    assert 0.5 * float(top.angular_momentum) ** 2 / top.energy == pytest.approx(float(value["Itilde"]), rel=2e-15)
    times = [float(time) for time in value["omega_body_at_t"]]
    expected = np.array([[float(each) for each in row] for row in value["omega_body_at_t"].values()])
    # Of each component by itself. 0.1 and the like are not floats: that alone is felt far along the nearly symmetric.
    rtol = 5e-14 if kind is float else 2e-15
    np.testing.assert_allclose(free_top.angular_velocity(top, times), expected, rtol=rtol)


CASES = {
    "about the least": ([1.3, 2.1, 2.9], [1.0, 0.3, -0.2]),
    "about the greatest": ([1.3, 2.1, 2.9], [0.2, -0.3, -1.1]),
    "descending": ([2.9, 2.1, 1.3], [0.9, 0.7, -0.4]),
    "middle first": ([2.1, 2.9, 1.3], [0.8, -0.7, -0.2]),
    "middle last": ([1.3, 2.9, 2.1], [-0.8, 0.7, 0.2]),
    "greatest first": ([2.9, 1.3, 2.1], [-0.2, 0.6, 0.5]),
}


@pytest.mark.parametrize("name", CASES)
def test_any_order_of_moments_at_any_time(name):
    moments, spin = CASES[name]
    top = free_top.free_top(moments, spin)
    np.testing.assert_allclose(free_top.angular_velocity(top, 0.0), spin, rtol=1e-15)
    for time in (-7.0, 0.3, 1.0, 40.0, 123456.7):
        expected = [float(w) for w in exact_top.motion(moments, spin, time).angular_velocity]
        np.testing.assert_allclose(free_top.angular_velocity(top, time), expected, rtol=3e-15)


def test_the_closed_form_is_that_of_eulers_equations():
    moments, spin = CASES["middle first"]
    expected = [float(w) for w in exact_top.taylor_motion(moments, spin, 1.5, 20).angular_velocity]
    np.testing.assert_allclose(free_top.angular_velocity(free_top.free_top(moments, spin), 1.5), expected, rtol=2e-15)


def test_energy_and_angular_momentum_are_kept_over_any_array_of_times():
    moments, spin = map(np.array, CASES["greatest first"])
    top = free_top.free_top(moments, spin)
    times = np.linspace(-1e4, 1e9, 600).reshape(3, 200)
    found = free_top.angular_velocity(top, times)
    assert found.shape == (3, 200, 3)
    np.testing.assert_allclose((moments * found**2).sum(-1), 2 * top.energy, rtol=2e-15)
    np.testing.assert_allclose(np.linalg.norm(moments * found, axis=-1), float(top.angular_momentum), rtol=2e-15)
    assert free_top.angular_velocity(top, []).shape == (0, 3)


@pytest.mark.parametrize(("moments", "sign"), [([2.0, 2.0, 3.0], 1), ([2.0, 2.0, 0.5], -1), ([2.0, 2.0, 0.0], -1)])
def test_symmetric_bodies_and_rods_wobble_in_circles(moments, sign):
    spin = np.array([0.3, -0.4, 1.2])
    top = free_top.free_top(moments, spin)
    rate = (moments[2] - 2.0) / 2.0 * 1.2  # Euler's
    assert free_top.wobble_rate(top) == pytest.approx(rate, rel=1e-15)
    assert np.sign(rate) == sign
    times = np.linspace(0, 1000, 37)
    turned = (0.3 - 0.4j) * np.exp(1j * rate * times)
    expected = np.stack([turned.real, turned.imag, np.full(37, 1.2)], axis=-1)
    np.testing.assert_allclose(free_top.angular_velocity(top, times), expected, rtol=0, atol=2e-13)


@pytest.mark.parametrize(
    ("moments", "spin"),
    [
        ([1.0, 2.0, 3.0], [0.0, 0.0, 0.0]),
        ([1.0, 2.0, 3.0], [0.0, 0.7, 0.0]),
        ([1.0, 2.0, 3.0], [0.0, 0.0, -0.7]),
        ([2.0, 2.0, 2.0], [0.3, 0.4, 0.5]),
        ([2.0, 2.0, 3.0], [0.3, 0.4, 0.0]),
        ([0.0, 1.0, 1.0], [0.0, 0.4, 0.3]),
    ],
)
def test_steady_rotations_stay(moments, spin):
    top = free_top.free_top(moments, spin)
    assert top.motion == "steady"
    assert np.isnan(free_top.period(top))
    assert free_top.wobble_rate(top) == 0.0
    np.testing.assert_array_equal(free_top.angular_velocity(top, [0.0, 1e9]), [spin, spin])


@pytest.mark.full
@pytest.mark.parametrize("signs", [(1, 1, 1), (-1, 1, 1), (1, -1, -1), (-1, -1, -1)])
def test_the_separatrix_is_followed_by_hyperbolic_functions(signs):
    moments = np.array([1.0, 1.5, 3.0])  # 1 (1.5 - 1) 3^2 = 3 (3 - 1.5) 1^2
    spin = np.array([3.0, 0.6, 1.0]) * signs
    top = free_top.free_top(moments, spin)
    assert (top.motion, top.separation, free_top.period(top)) == ("separatrix", 0.0, np.inf)
    times = np.array([0.7])
    expected = [[float(w) for w in exact_top.taylor_motion(moments, spin, time, 20).angular_velocity] for time in times]
    np.testing.assert_allclose(free_top.angular_velocity(top, times), expected, rtol=3e-15)
    # It ends along the intermediate axis, with what is left of the others falling exponentially.
    late = free_top.angular_velocity(top, [40.0, 41.0])
    np.testing.assert_allclose(moments[1] * abs(late[:, 1]), float(top.angular_momentum), rtol=1e-15)
    np.testing.assert_allclose(late[1, ::2] / late[0, ::2], np.exp(-float(top.argument_rate)), rtol=1e-14)


def test_a_float_is_not_the_decimal_that_it_is_printed_as():
    # On the separatrix: what 0.1 lacks decides on which side the float is, and so when the body turns over.
    by_text = free_top.free_top(["1", "1.5", "3"], ["0.3", "0.6", "0.1"])
    by_float = free_top.free_top([1.0, 1.5, 3.0], [0.3, 0.6, 0.1])
    assert by_text.motion == "separatrix"
    assert by_float.motion == "periodic"


def test_bad_arguments_are_refused():
    for moments in ([1.0, 2.0, -3.0], [0.0, 1.0, 2.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]):
        with pytest.raises(ValueError, match="the moments of a free top are positive"):
            free_top.free_top(moments, [1.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="three principal moments"):
        free_top.free_top([1.0, 2.0], [1.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="finite numbers"):
        free_top.free_top([1.0, 2.0, np.inf], [1.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="must be finite"):
        free_top.angular_velocity(free_top.free_top([1.0, 2.0, 3.0], [1.0, 0.0, 0.0]), [0.0, np.nan])
