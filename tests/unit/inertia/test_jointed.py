"""Jointed bodies against their own limbs as points of mass, moved a little; and turns that are known."""

import numpy as np
import pytest

from astroinertia.errors import AstroinertiaError
from astroinertia.inertia import shapes
from astroinertia.inertia.jointed import Limb, free_turning, posture
from astroinertia.inertia.realise import point_masses
from astroinertia.inertia.tensor import inertia_tensor

LIMBS = [
    Limb(shapes.box(5.0, 0.3, 0.2, 0.6)),
    Limb(shapes.rod(1.0, 0.5).translated((0.2, 0.0, 0.3)), (0.2, 0.0, 0.1), (0.3, 1.0, 0.2), parent=0),
    Limb(shapes.box(0.7, 0.1, 0.3, 0.2).translated((0.2, 0.1, 0.7)), (0.2, 0.0, 0.55), (1.0, -0.5, 0.0), parent=1),
    Limb(shapes.solid_sphere(0.5, 0.1).translated((-0.4, 0.1, 0.0)), (-0.2, 0.0, 0.0), (0.0, 0.0, 2.0), parent=0),
]
ANGLES, RATES = np.array([0.0, 0.7, -1.1, 2.0]), np.array([0.0, 1.3, 0.4, -0.9])


def as_points(angles):
    """The limbs as equivalent points of mass, (N,) and (N, 3), that move with them."""
    at_rest, at_work = posture(LIMBS, np.zeros(4)), posture(LIMBS, angles)
    masses, places = [], []
    for before, after in zip(at_rest.parts, at_work.parts, strict=True):
        few, around = point_masses(before.inertia, before.mass)
        # The rotation that takes the one tensor's axes to the other's, by three marked points of the limb.
        marks = [shapes.point(1.0, before.centre + step) for step in np.eye(3)]
        index = at_rest.parts.index(before)
        swapped = [
            posture([*LIMBS[:index], Limb(mark, LIMBS[index].joint, LIMBS[index].axis, LIMBS[index].parent),
                     *LIMBS[index + 1 :]], angles).parts[index].centre - after.centre
            for mark in marks
        ]  # fmt: skip
        masses.append(few)
        places.append(after.centre + around @ np.array(swapped))
    return np.concatenate(masses), np.concatenate(places)


def test_the_whole_is_that_of_the_points():
    masses, places = as_points(ANGLES)
    whole = posture(LIMBS, ANGLES).whole
    np.testing.assert_allclose(whole.inertia, inertia_tensor(masses, places), rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(whole.centre, masses @ places / masses.sum(), atol=1e-14)


def test_relative_momentum_and_growth_of_the_tensor_are_those_of_the_points():
    step = 1e-5
    (masses, before), (_, after), (_, now) = (as_points(ANGLES + way * step * RATES) for way in (-1, 1, 0))
    velocities = (after - before) / (2 * step)
    still, centred = velocities - masses @ velocities / masses.sum(), now - masses @ now / masses.sum()
    moving = posture(LIMBS, ANGLES, RATES)
    np.testing.assert_allclose(moving.relative_momentum, masses @ np.cross(centred, still), atol=1e-9)
    rate = (inertia_tensor(masses, after) - inertia_tensor(masses, before)) / (2 * step)
    np.testing.assert_allclose(moving.inertia_rate, rate, atol=1e-9)


@pytest.mark.full
def test_angular_momentum_in_space_is_kept():
    momentum = np.array([0.2, -0.5, 0.3])
    times = np.linspace(0.0, 2.0, 5)

    def joints(time):
        return ANGLES * np.sin(3 * time), 3 * ANGLES * np.cos(3 * time)

    attitudes, spins = free_turning(LIMBS, joints, times, momentum)
    # By differences of where the points are in space, and not by the equation that was solved.
    step = 1e-4
    for time, attitude in zip(times[1:-1], attitudes[1:-1], strict=True):
        beside = free_turning(LIMBS, joints, [0.0, time - step, time + step], momentum)[0][1:]
        places = [
            turn @ as_points(joints(one)[0])[1].T for turn, one in zip(beside, (time - step, time + step), strict=True)
        ]
        masses, now = as_points(joints(time)[0])
        velocities, here = ((places[1] - places[0]) / (2 * step)).T, now @ attitude.T
        drift, centre = masses @ velocities / masses.sum(), masses @ here / masses.sum()
        np.testing.assert_allclose(masses @ np.cross(here - centre, velocities - drift), momentum, atol=1e-5)
    assert spins.shape == (5, 3)


def test_a_wheel_turned_inside_turns_the_rest_back():
    wheel = Limb(shapes.cylinder(2.0, 0.5, 0.1), axis=(0.0, 0.0, 1.0), parent=0)
    trunk = Limb(shapes.cylinder(6.0, 0.5, 0.1))
    attitudes, _ = free_turning([trunk, wheel], lambda t: ([0, t], [0, 1.0]), [0.0, np.pi])
    turned = np.arctan2(attitudes[-1][1, 0], attitudes[-1][0, 0])
    assert turned == pytest.approx(-np.pi / 4, abs=1e-8)  # I of the wheel over I of both


@pytest.mark.parametrize(
    ("limbs", "angles", "sentence"),
    [
        (LIMBS, [0.0, 1.0], "angles must be one for each of the 4 limbs"),
        (LIMBS, [1.0, 0.0, 0.0, 0.0], "the first of the limbs is the trunk"),
        ([LIMBS[0], Limb(LIMBS[1].body, parent=1)], [0.0, 0.0], "the parent of limb 1 must be"),
    ],
)
def test_what_is_no_tree_of_limbs_is_refused(limbs, angles, sentence):
    with pytest.raises(AstroinertiaError, match=sentence):
        posture(limbs, angles)


@pytest.mark.parametrize("times", [[0.5], [0.5, 0.5]])
def test_at_one_time_the_trunk_is_as_it_was(times):
    limbs = [Limb(shapes.disc(1.0, 1.0)), Limb(shapes.disc(1.0, 1.0), parent=0)]
    attitudes, rates = free_turning(limbs, lambda t: ([0.0, np.pi * t], [0.0, np.pi]), times)
    np.testing.assert_array_equal(attitudes, np.broadcast_to(np.eye(3), (len(times), 3, 3)))
    np.testing.assert_allclose(rates[:, 2], -np.pi / 2)


def test_a_hinge_without_an_axis_and_times_to_and_fro_are_refused():
    wheels = [Limb(shapes.disc(1.0, 1.0)), Limb(shapes.disc(1.0, 1.0), axis=(0.0, 0.0, 0.0), parent=0)]
    with pytest.raises(AstroinertiaError, match="axis of limb 1 must not be the vector 0"):
        posture(wheels, [0.0, 1.0])
    with pytest.raises(AstroinertiaError, match="times must go one way"):
        free_turning(wheels[:1], lambda time: ([0.0], [0.0]), [0.0, 1.0, 0.5])
