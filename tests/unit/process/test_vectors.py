"""Vectors need all of their components, and functions that take vectors refuse a number in place of one."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.bodies import bar_analysis, ellipsoid_gravity
from astroinertia.inertia import gravity_field, jointed, pivoted, shapes, tensor
from astroinertia.process.vectors import require_components
from astroinertia.rotation import attitude, frame_dragging, settling

BOX = shapes.box(1.0, 1.0, 2.0, 3.0)
MOMENTS = (1.0, 2.0, 2.5)


def test_components_are_counted_of_lists_arrays_and_what_is_traced():
    require_components(axis=[0.0, 0.0, 1.0], point=np.zeros((4, 3)))
    require_components(2, planes=np.zeros((5, 2)))
    with pytest.raises(ValueError, match=r"point \(1,\) must have the shape \(..., 3\)"):
        require_components(axis=np.ones(3), point=[1.0])
    with pytest.raises(ValueError, match=r"axis \(\) must have the shape \(..., 3\)"):
        jax.jit(lambda axis: require_components(axis=axis))(jnp.asarray(1.0))


@pytest.mark.parametrize(
    "call",
    [  # each was taken as a vector of equal components, which gave a number without a word
        lambda: tensor.moment_about(np.diag(MOMENTS), [1.0]),
        lambda: tensor.equivalent_semi_axes(1.0, [1.0]),
        lambda: BOX.about(1.0),
        lambda: BOX.translated(1.0),
        lambda: BOX.rotated(np.eye(3), about=1.0),
        lambda: pivoted.pendulum_length(BOX, 1.0),
        lambda: settling.energy_to_lose(MOMENTS, 1.0),
        lambda: settling.energy_above_separatrix(MOMENTS, [1.0]),
        lambda: settling.settled_rate(MOMENTS, 2.0),
        lambda: attitude.quaternion_product(1.0, [1.0, 0.0, 0.0, 0.0]),
        lambda: frame_dragging.dragged_gyroscope(5.86e33, [1.0, 0.0, 0.0], 7.0274e6),
        lambda: ellipsoid_gravity.potential([3.0, 2.0, 1.0], 1.0),
        lambda: ellipsoid_gravity.acceleration([3.0, 2.0, 1.0], [[1.0]]),
        lambda: gravity_field.particle_field(np.ones(2), [[0, 0, 1], [0, 0, -1]], 2, 1.0, origin=1.0),
    ],
)
def test_a_number_in_place_of_a_vector_is_refused(call):
    with pytest.raises(ValueError, match=r"must have the shape \(..., [34]\)"):
        call()


@pytest.mark.parametrize("size", [1e200, 1e-200])
def test_axes_are_of_any_length(size):
    axis, limb, trunk = size * np.array([0.3, 1.0, 0.2]), shapes.rod(2.0, 3.0), jointed.Limb(BOX)
    made = [
        lambda axis: pivoted.pendulum_length(limb, (0, 0, 1.5), axis),
        lambda axis: bar_analysis.bar(np.diag([4.0, 1.0, 1.0]), np.zeros((3, 3)), axis)[:2],
        lambda axis: frame_dragging.dragged_gyroscope([0.0, 0.0, 1e40], axis, 1e7),
        lambda axis: jointed.posture([trunk, jointed.Limb(limb, axis=tuple(axis), parent=0)], [0.0, 0.3]).whole.inertia,
    ]
    for each in made:
        np.testing.assert_allclose(each(axis), each(axis / size), rtol=1e-12)
