"""Named numbers of a dataset, and frequencies of its series."""

import numpy as np
import pytest
import xarray as xr

from astroinertia.accuracy.selected_observables import (
    components,
    default_names,
    frequency,
    parsed,
    relative_error,
    value,
)
from astroinertia.errors import NumericalError, SceneError
from astroinertia.observables.quantities import DERIVED, OF_ATTITUDE, OF_EFFECTS, RECORDED
from astroinertia.scene import load
from tests.sims import SIMS

TIMES = np.linspace(0.0, 20.0, 161)
TENSOR = np.arange(9.0).reshape(3, 3) + TIMES[:, None, None]
RINGING = 2.0 + 0.03 * TIMES + 0.1 * np.cos(1.7 * TIMES + 0.3)


@pytest.fixture
def dataset():
    axes = {"i": list("xyz"), "j": list("xyz")}
    tensor = (("time", "i", "j"), TENSOR)
    missing = ("time", np.full(len(TIMES), np.nan), {"reason": "the scene lists no gravity"})
    return xr.Dataset(
        {"inertia_tensor": tensor, "ellipsoid_flattening": ("time", RINGING), "gravitational_energy": missing},
        coords={"time": TIMES, **axes},
    )


def test_labels_choose_a_number_at_the_end(dataset):
    assert value(dataset, parsed("inertia_tensor y z")).tolist() == [25.0]
    assert value(dataset, parsed(" ellipsoid_flattening ")) == pytest.approx(RINGING[-1:])


@pytest.mark.parametrize("name", [*RECORDED, *DERIVED, *OF_EFFECTS, *OF_ATTITUDE])
def test_every_series_that_a_run_may_have_can_be_named(name):
    assert parsed(name).variable == name


def test_a_label_that_no_run_has_is_refused_before_any_run():
    """Those of effects, regions and companions are for a run to say."""
    for name, words in (
        ("inertia_tensor z q", "j is one of x, y, z, not 'q'"),
        ("frequency of attitude 4", "principal is one of 1, 2, 3, not '4'"),
        ("mode_amplitude 5", "mode is one of 1, 2, 3, 4, not '5'"),
        ("mass z", r"more labels than mass has dimensions \(0\)"),
    ):
        with pytest.raises(SceneError, match=words):
            parsed(name)
    for name in ("torque gravity z", "work pressure", "region_inertia_tensor core z z", "angular_velocity"):
        parsed(name)


def test_fewer_labels_give_all_components_in_the_order_of_their_names(dataset):
    row = parsed("inertia_tensor z")
    assert value(dataset, row).tolist() == [26.0, 27.0, 28.0]
    assert components(dataset, row)[1].split()[:2] == ["inertia_tensor", "z"]
    assert len(components(dataset, parsed("inertia_tensor"))) == 9


def test_a_frequency_is_found_beside_a_drift(dataset):
    assert value(dataset, parsed("frequency of ellipsoid_flattening")) == pytest.approx([1.7], rel=1e-7)
    noisy = RINGING + 0.01 * np.random.default_rng(0).normal(size=len(TIMES))
    assert frequency(TIMES, noisy) == pytest.approx(1.7, rel=3e-3)


@pytest.mark.parametrize(("size", "turns"), [(1.0, 1.05), (1e45, 1.5), (1e-6, 3.3), (1e45, 7.9)])
def test_the_frequency_of_a_sinusoid_is_known_to_rounding_in_any_units(size, turns):
    # The square of what the fit misses by is rounding from 1e-8 of the frequency on.
    times = 1e9 * np.linspace(3.0, 23.0, 100)
    omega = 2.0 * np.pi * turns / 20e9
    assert frequency(times, size * (5.0 + np.cos(omega * times + 2.5))) == pytest.approx(omega, rel=1e-13, abs=0.0)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("", "inertia_tensor z z"),
        ("nonsense", "no series"),
        ("angular_velocty", "did you mean angular_velocity"),
        ("angular_velocity", "not in the dataset"),
        ("ellipsoid_flattening x", "more labels"),
        ("inertia_tensor w z", "one of x, y, z"),
        ("frequency of inertia_tensor z", "add labels"),
    ],
)
def test_what_there_is_not_gets_a_sentence(dataset, name, words):
    with pytest.raises(SceneError, match=words):
        value(dataset, parsed(name))


def test_a_quantity_that_the_run_lacks_says_why(dataset):
    with pytest.raises(NumericalError, match="lists no gravity"):
        value(dataset, parsed("gravitational_energy"))
    with pytest.raises(NumericalError, match="at least"):
        frequency(TIMES[:5], RINGING[:5])


def test_the_error_of_a_direction_is_an_angle():
    angle = 1e-4
    turned = np.array([np.sin(angle), 0.0, np.cos(angle)])
    assert relative_error(turned, np.array([0.0, 0.0, 1.0])) == pytest.approx(angle, rel=1e-8)
    assert np.isnan(relative_error(np.ones(1), np.zeros(1)))


@pytest.mark.parametrize(
    ("gradient", "turns"),
    [([[0.1, 0, 0], [0, -0.2, 0], [0, 0, 0.1]], False), ([[0, -0.1, 0], [0.1, 0, 0], [0, 0, 0]], True)],
    ids=["strain_along_axes", "rotation"],
)
def test_a_flow_that_turns_nothing_is_not_judged_by_its_angular_velocity(gradient, turns):
    """Which is 0, to which no error is relative."""
    scene = load.load_file(SIMS / "free_expansion.toml", [f"body.velocity_gradient={gradient}"])
    assert ("angular_velocity" in default_names(scene)) == turns
