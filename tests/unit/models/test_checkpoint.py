"""The arrays of a checkpoint are held to the schema of the state before they are used."""

import numpy as np
import pytest

from astroinertia.models import checkpoint
from astroinertia.orbits import states
from astroinertia.orbits.simulation import Companion, simulation

LIKE = {"mass": (np.dtype(float), (3,)), "step": (np.dtype(np.int64), ()), "place": (np.dtype(float), (3, 2))}
LIMITS = {"mass": checkpoint.POSITIVE, "step": checkpoint.COUNT}


def arrays(**other):
    return {"mass": np.ones(3), "step": np.array(4), "place": np.zeros((3, 2))} | other


def test_a_state_and_what_is_not_known_of_are_let_through():
    checkpoint.check(arrays(other=np.array("x")), LIKE, LIMITS)


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"mass": np.ones(3, np.float32)}, "must be float64"),
        ({"mass": np.ones(4)}, "of shape"),
        ({"mass": np.ones((3, 1))}, "of shape"),
        ({"mass": np.array(["a", "b", "c"])}, "must be float64"),
        ({"mass": np.array([1.0, 0.0, 1.0])}, "beyond"),
        ({"mass": np.array([1.0, -1.0, 1.0])}, "beyond"),
        ({"place": np.full((3, 2), np.nan)}, "not finite"),
        ({"place": np.full((3, 2), 1e200)}, "not finite"),
        ({"step": np.array(-1)}, "beyond"),
        ({"step": np.array(4.0)}, "must be int64"),
    ],
)
def test_what_is_no_state_is_refused(other, words):
    with pytest.raises(ValueError, match=words):
        checkpoint.check(arrays(**other), LIKE, LIMITS)


def test_what_is_missing_is_named():
    with pytest.raises(ValueError, match="lacks the array 'place'"):
        checkpoint.check({"mass": np.ones(3), "step": np.array(4)}, LIKE, LIMITS)


def begun(integrator="ias15", companions=1):
    moons = [Companion(name=f"moon {k}", mass=1e-3, semi_major_axis=1.0 + k) for k in range(companions)]
    return simulation(1.0, moons, integrator=integrator)


@pytest.mark.parametrize("integrator", ["ias15", "whfast"])
@pytest.mark.parametrize("steps", [0, 1, 20])
def test_orbits_go_on_to_the_last_bit(integrator, steps):
    whole = begun(integrator)
    for _ in range(steps):
        states.drift(whole, 0.1, 0.0)
    again = states.unpacked(states.packed(whole), begun(integrator))
    for each in (whole, again):
        states.drift(each, 0.3, 0.3)
    assert states.present(whole)[0].tobytes() == states.present(again)[0].tobytes()


def test_orbits_of_bodies_with_other_masses_are_refused():
    """A companion of another mass would be on an orbit that nobody asked for."""
    heavier = simulation(1.0, [Companion(name="moon 0", mass=64.0, semi_major_axis=1.0)])
    with pytest.raises(ValueError, match="other masses than those of its scene"):
        states.unpacked(states.packed(begun()), heavier)


def test_orbits_of_another_scene_or_damaged_ones_are_refused():
    packed = states.packed(begun(companions=2))
    with pytest.raises(ValueError, match="not those of its scene"):
        states.unpacked(packed, begun())
    for place in range(64, len(packed), 7):  # lengths, counts and pointers among them
        changed = packed.copy()
        changed[place : place + 8] = 255
        try:
            found = states.unpacked(changed, begun(companions=2))
        except ValueError:
            continue
        states.drift(found, 0.01, 0.0)
        assert found.N == 3
