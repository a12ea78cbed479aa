"""What particles stand for on a grid: slices are sums over kernels, projections hold all mass, the flow is exact."""

import itertools

import numpy as np
import pytest

from astroinertia.plots import render
from tests.unit.affine_body import particle_sphere


def test_a_slice_through_one_particle_is_its_kernel():
    image = render.density_slice(np.zeros((1, 3)), np.array([2.0]), np.array([0.5]), (0, 1), 1.505, 301)
    assert image[150, 150] == pytest.approx(2.0 / (np.pi * 0.5**3), rel=1e-12)
    assert image[150, 150 + 50] == pytest.approx(2.0 * 0.25 / (np.pi * 0.5**3), rel=1e-9)  # one h away
    assert image[150, 0] == 0.0
    # The same particle at a distance h from the plane
    beside = render.density_slice(np.array([[0, 0, 0.5]]), np.array([2.0]), np.array([0.5]), (0, 1), 1.505, 301)
    assert beside[150, 150] == pytest.approx(2.0 * 0.25 / (np.pi * 0.5**3), rel=1e-12)


def test_slices_add_up_to_the_mass_and_put_axes_where_they_belong():
    position, mass = np.array([[0.6, -0.2, 0.3]]), np.array([1.5])
    depths = np.linspace(-2, 2, 81)
    slices = [
        render.density_slice(position - [0, depth, 0], mass, np.array([0.4]), (0, 2), 2.0, 80) for depth in depths
    ]
    total = np.sum(slices) * (4.0 / 80) ** 2 * (depths[1] - depths[0])
    assert total == pytest.approx(1.5, rel=1e-3)
    row, column = np.unravel_index(np.argmax(slices[36]), (80, 80))  # the slice at y = -0.2
    assert (column + 0.5) * 0.05 - 2 == pytest.approx(0.6, abs=0.051)
    assert (row + 0.5) * 0.05 - 2 == pytest.approx(0.3, abs=0.051)


def test_the_flow_of_a_linear_motion_is_exact():
    position = particle_sphere(3000)
    gradient = np.array([[-0.3, -2.0, 0.4], [2.0, -0.5, 0.0], [0.1, 0.0, 1.0]])
    centres, across, up = render.flow(
        position, position @ gradient.T, np.ones(3000), np.full(3000, 0.15), (0, 2), 1.2, 9
    )
    x, z = np.meshgrid(centres, centres)
    matter = np.isfinite(across)
    assert matter.sum() > 30
    assert not matter[0, 0]
    np.testing.assert_allclose(across[matter], (gradient[0, 0] * x + gradient[0, 2] * z)[matter], atol=1e-9)
    np.testing.assert_allclose(up[matter], (gradient[2, 0] * x + gradient[2, 2] * z)[matter], atol=1e-9)


def test_a_body_that_moves_as_one_has_its_velocity_throughout():
    position, velocity = particle_sphere(3000), np.tile([5500.0 / 3, -1200.1, 0.0], (3000, 1))
    centres, across, up = render.flow(position, velocity, np.ones(3000), np.full(3000, 0.15), (0, 1), 1.2, 9)
    inside = np.hypot(*np.meshgrid(centres, centres)) < 0.9
    np.testing.assert_allclose(across[inside], 5500.0 / 3)
    np.testing.assert_allclose(up[inside], -1200.1)


def test_no_flow_is_said_where_particles_on_one_side_would_have_it_faster_than_any_of_them():
    place = np.random.default_rng(3).normal(size=(60, 3)) * [0.05, 0.3, 0.3] + [1.0, 0.0, 0.0]
    velocity = np.outer(40.0 * (place[:, 0] - 1.0), [1.0, 0.0, 0.0])  # steep, across a thin sheet
    _, across, _ = render.flow(place, velocity, np.ones(60), np.full(60, 0.6), (0, 1), 1.5, 9)
    assert np.isfinite(across).any()
    assert np.nanmax(abs(across)) < 2.0 * abs(velocity).max()


def ball(spacing):
    """A ball of radius and density 1 on a body-centred lattice, and its smoothing lengths."""
    corner = np.arange(-1.5, 1.5, spacing)
    lattice = np.stack(np.meshgrid(corner, corner, corner, indexing="ij"), axis=-1).reshape(-1, 3)
    lattice = np.concatenate([lattice, lattice + 0.5 * spacing]) + 0.013
    inside = lattice[np.linalg.norm(lattice, axis=1) < 1.0]
    return inside, np.full(len(inside), 0.5 * spacing**3), np.full(len(inside), 1.2 * spacing * 0.5 ** (1 / 3))


@pytest.mark.parametrize("plane", [(0, 2), (0, 1), (1, 2)])
def test_a_slice_of_a_uniform_ball_has_its_density_and_a_projection_its_chord(plane):
    position, mass, size = ball(0.1)
    pixels, reach = 120, 1.5
    centres = (np.arange(pixels) + 0.5) * 2 * reach / pixels - reach
    radius = np.hypot(centres, centres[:, None])
    sliced = render.density_slice(position, mass, size, plane, reach, pixels)
    deep = radius < 0.75
    assert sliced[deep].mean() == pytest.approx(1.0, abs=2e-3)
    assert abs(sliced[deep] - 1.0).max() < 0.02
    assert not sliced[radius > 1.0 + 2.0 * size[0]].any()
    column = render.column_density(position, mass, size, plane, reach, pixels)
    chord = 2.0 * np.sqrt(1.0 - radius[deep] ** 2)
    assert abs(column[deep] / chord - 1.0).max() < 0.04
    assert not column[radius > 1.0 + 2.0 * size[0]].any()


@pytest.mark.parametrize("pixels", [7, 50, 301])
def test_a_projection_adds_up_to_the_mass_at_any_resolution(pixels):
    """Particles of all sizes, from far below a pixel to a third of the picture."""
    rng = np.random.default_rng(3)
    position, mass = rng.uniform(-0.2, 0.2, (200, 3)), rng.uniform(0.5, 2.0, 200)
    size = 10.0 ** rng.uniform(-6, -0.6, 200)
    column = render.column_density(position, mass, size, (1, 2), 1.0, pixels)
    assert column.sum() * (2.0 / pixels) ** 2 == pytest.approx(mass.sum(), rel=1e-13)


def test_what_reaches_out_of_the_picture_is_cut_off_and_not_pushed_in():
    rng = np.random.default_rng(4)
    position, mass, size = rng.uniform(-1.2, 1.2, (200, 3)), np.ones(200), 10.0 ** rng.uniform(-3, -0.6, 200)
    near = render.column_density(position, mass, size, (1, 2), 1.0, 50)
    wide = render.column_density(position, mass, size, (1, 2), 2.0, 100)
    np.testing.assert_allclose(near, wide[25:75, 25:75], rtol=1e-3)


def columns(q):
    """The integral of the kernel along lines that pass at q smoothing lengths, times h^2: each piece by quadrature."""
    offset, weight = np.polynomial.legendre.leggauss(40)
    squared = np.asarray(q)[..., None] ** 2
    total = np.zeros(np.shape(q))
    for begin, end in itertools.pairwise(np.sqrt(np.maximum(knot**2 - squared, 0.0)) for knot in (0.0, 1.0, 2.0)):
        along = 0.5 * (end - begin) * (offset + 1.0) + begin
        total += ((end - begin) * weight * render.KERNEL.w(np, np.sqrt(squared + along**2))).sum(-1)
    return total


def test_the_column_through_the_kernel_is_its_integral_along_the_line():
    q = np.linspace(0.0, 1.9999, 4001)
    assert columns(0.0) == pytest.approx(1.5 / np.pi, rel=1e-12)
    written = np.array([render._column(1.0 - (each / 2.0) ** 2) for each in q])
    np.testing.assert_allclose(written, columns(q), rtol=5e-5)
    assert render._column(0.0) == render._column(-1e-3) == render._column(-50.0) == 0.0


def test_a_projection_of_one_particle_is_the_column_through_it_where_it_lies():
    column = render.column_density(np.array([[0.3, 9.0, -0.4]]), np.array([2.0]), np.array([0.25]), (0, 2), 1.0, 200)
    centres = (np.arange(200) + 0.5) * 0.01 - 1.0
    q = np.hypot(centres - 0.3, (centres + 0.4)[:, None]) / 0.25
    np.testing.assert_allclose(column, 2.0 / 0.25**2 * columns(np.minimum(q, 2.0)), rtol=1e-3, atol=1e-3)


def test_far_flung_particles_that_are_larger_than_the_picture_are_seen_through():
    """Only the middle of a huge particle is in the picture: its column is that of the kernel's middle."""
    column = render.column_density(np.zeros((1, 3)), np.ones(1), np.array([300.0]), (0, 1), 1.0, 40)
    np.testing.assert_allclose(column, 1.5 / np.pi / 300.0**2, rtol=1e-4)
