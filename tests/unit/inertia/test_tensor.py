"""Inertia tensors and what follows from them, against closed forms and plain sums."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import xarray as xr
from astropy import units

from astroinertia.errors import SceneError
from astroinertia.inertia import tensor


def random_tensor(seed):
    generator = np.random.default_rng(seed)
    points = generator.normal(size=(20, 3)) * [1.0, 1.4, 2.1]
    return tensor.inertia_from_second_moment(points.T @ points)


def test_second_moment_and_inertia_invert_each_other_for_points():
    points = np.random.default_rng(1).normal(size=(50, 3))
    mass = np.random.default_rng(2).uniform(1, 2, 50)
    second = (mass[:, None] * points).T @ points
    direct = sum(m * ((x @ x) * np.eye(3) - np.outer(x, x)) for m, x in zip(mass, points, strict=True))
    inertia = tensor.inertia_from_second_moment(second)
    np.testing.assert_allclose(inertia, direct, rtol=1e-13, atol=1e-12)
    np.testing.assert_allclose(tensor.second_moment_from_inertia(inertia), second, rtol=1e-13, atol=1e-12)


def test_axial_vector_is_the_angular_momentum():
    generator = np.random.default_rng(3)
    x, v, mass = generator.normal(size=(9, 3)), generator.normal(size=(9, 3)), generator.uniform(1, 2, 9)
    mixed = (mass[:, None] * x).T @ v
    np.testing.assert_allclose(tensor.axial_vector(mixed), mass @ np.cross(x, v), rtol=1e-13)


def test_semi_axes_of_a_homogeneous_ellipsoid():
    mass, axes = 3.0, np.array([1.0, 2.0, 3.0])
    squares = axes**2
    moments = mass / 5 * (squares.sum() - squares)
    np.testing.assert_allclose(tensor.equivalent_semi_axes(mass, moments), axes, rtol=1e-14)
    impossible, disc = np.array([1.0, 1.0, 3.0]), np.array([1.0, 1.0, np.float64(2.0 + 1e-12)])
    assert np.isnan(tensor.equivalent_semi_axes(mass, impossible)).tolist() == [False, False, True]
    assert tensor.equivalent_semi_axes(mass, disc)[2] == 0.0


def particles(seed, count=40, batch=()):
    generator = np.random.default_rng(seed)
    return generator.uniform(0.5, 2, (*batch, count)), generator.normal(size=(*batch, count, 3)) * [1.0, 1.4, 2.1]


def by_definition(mass, position, origin):
    return sum(m * ((x @ x) * np.eye(3) - np.outer(x, x)) for m, x in zip(mass, position - origin, strict=True))


def test_the_tensor_of_particles_is_about_the_origin_asked_for():
    mass, position = particles(6)
    origin = np.array([1.0, -3.0, 2.0])
    np.testing.assert_allclose(
        tensor.inertia_tensor(mass, position, origin), by_definition(mass, position, origin), rtol=1e-13, atol=1e-11
    )
    centre = mass @ position / mass.sum()
    np.testing.assert_allclose(tensor.centre_of_mass(mass, position), centre, rtol=1e-13)
    np.testing.assert_allclose(
        tensor.inertia_tensor(mass, position), by_definition(mass, position, centre), rtol=1e-13, atol=1e-11
    )


@pytest.mark.slow
@pytest.mark.parametrize("made", [np.asarray, jnp.asarray])
@pytest.mark.parametrize("mass", [2.0, [2.0], [[2.0], [2.0]]])
def test_one_number_is_the_mass_of_each_particle(mass, made):
    position = made(np.random.default_rng(7).normal(size=(2, 5, 3)))
    one, each = made(np.array(mass)), made(np.full((2, 5), 2.0))
    for of in (tensor.centre_of_mass, tensor.inertia_tensor, tensor.second_moment):
        np.testing.assert_allclose(of(one, position), of(each, position), rtol=1e-6)
    assert np.array_equal(tensor.centre_of_mass(1.0, [[1, 0, 0], [2, 0, 0], [3, 0, 0]]), [2.0, 0.0, 0.0])


def test_weights_select_and_batches_are_series_of_snapshots():
    mass, position = particles(7, batch=(4, 2))
    chosen = np.random.default_rng(8).integers(0, 2, mass.shape)
    found = tensor.inertia_tensor(mass, position, weights=chosen)
    assert found.shape == (4, 2, 3, 3)
    inside = chosen[3, 1] == 1
    np.testing.assert_allclose(found[3, 1], tensor.inertia_tensor(mass[3, 1][inside], position[3, 1][inside]))
    # One set of masses serves all snapshots.
    np.testing.assert_array_equal(
        tensor.inertia_tensor(mass[0, 0], position)[2, 1], tensor.inertia_tensor(mass[0, 0], position[2, 1])
    )


def test_a_body_far_from_the_origin_keeps_every_digit_of_its_coordinates():
    mass, position = particles(9)
    position = np.round(position * 2**20) / 2**20  # so that the shift rounds nothing off
    near, far = tensor.inertia_tensor(mass, position), tensor.inertia_tensor(mass, position + 2.0**30)
    np.testing.assert_allclose(far, near, rtol=1e-14, atol=1e-14 * near.max())


def test_a_thin_rod_keeps_its_thickness():
    position = np.array([[1.0, 1e-9, 0.0], [-1.0, -1e-9, 0.0]])
    assert tensor.inertia_tensor(np.ones(2), position)[0, 0] == pytest.approx(2e-18, rel=1e-15)


def test_no_mass_has_no_centre():
    assert np.isnan(tensor.centre_of_mass(np.zeros(4), particles(1, 4)[1])).all()


@pytest.mark.parametrize("cells", [7, 12])
def test_a_grid_of_constant_density_is_a_box(cells):
    # Cells of uneven widths whose centres lie between walls: a box from -1 to 2, 0 to 1 and 3 to 3.5.
    generator = np.random.default_rng(cells)
    sides = {"x": (-1.0, 2.0), "y": (0.0, 1.0), "z": (3.0, 3.5)}
    coordinates = {name: low + (high - low) * (np.arange(cells) + 0.5) / cells for name, (low, high) in sides.items()}
    coordinates["y"] = coordinates["y"][::-1]
    density = xr.DataArray(np.full((2, cells, cells, cells), [[[[2.0]]], [[[4.0]]]]), coordinates, ("time", *sides))
    density.attrs["units"], density["x"].attrs["units"] = "kg/m3", "m"
    found = tensor.grid_inertia(density.transpose("y", "time", "z", "x"))
    np.testing.assert_allclose(found["mass"], [3.0, 6.0], rtol=1e-13)
    np.testing.assert_allclose(found["centre_of_mass"][0], [0.5, 0.5, 3.25], rtol=1e-13)
    box = np.diag([1 + 0.25, 9 + 0.25, 9 + 1]) * 3 / 12
    np.testing.assert_allclose(found["inertia_tensor"].sel(time=0), box, atol=1e-13)
    assert found["inertia_tensor"].dims == ("time", "i", "j")
    assert units.Unit(found["inertia_tensor"].attrs["units"]) == units.kg * units.m**2
    corner = tensor.grid_inertia(density, origin=generator.normal(size=3))
    assert corner["inertia_tensor"].shape == (2, 3, 3)


def test_a_grid_of_uneven_cells_is_the_sum_of_its_cells():
    generator = np.random.default_rng(3)
    centres = {name: np.cumsum(generator.uniform(0.5, 1.5, 4)) for name in "xyz"}
    density = xr.DataArray(generator.uniform(1, 2, (4, 4, 4)), centres, tuple("xyz"))
    origin = np.array([0.3, -0.2, 0.9])
    expected = np.zeros((3, 3))
    walls = {}
    for name, at in centres.items():
        middle = (at[1:] + at[:-1]) / 2
        walls[name] = np.concatenate([[2 * at[0] - middle[0]], middle, [2 * at[-1] - middle[-1]]])
    for cell in np.ndindex(4, 4, 4):
        low = np.array([walls[name][k] for name, k in zip("xyz", cell, strict=True)])
        high = np.array([walls[name][k + 1] for name, k in zip("xyz", cell, strict=True)])
        mass, side = density.values[cell] * (high - low).prod(), high - low
        own = mass / 12 * np.diag((side**2).sum() - side**2)
        expected += tensor.about_point(own, mass, (low + high) / 2 - origin)
    found = tensor.grid_inertia(density, origin=origin)
    np.testing.assert_allclose(found["inertia_tensor"], expected, rtol=1e-12)
    about = tensor.about_point(
        tensor.grid_inertia(density)["inertia_tensor"].values, found["mass"].values, found["centre_of_mass"] - origin
    )
    np.testing.assert_allclose(about, expected, rtol=1e-12)


def test_the_origin_of_a_grid_is_in_the_unit_of_its_coordinates():
    cells = {name: (name, [-0.5, 0.5], {"units": "cm"}) for name in "xyz"}
    cube = xr.DataArray(np.ones((2, 2, 2)), cells, tuple("xyz"), attrs={"units": "g cm-3"})
    exact = 8 * (2.0**2 / 6 + 100.0**2)  # of a cube with sides of 2 cm, 1 m away
    stated = xr.DataArray([1.0, 0.0, 0.0], dims="i", attrs={"units": "m"})
    for origin in ([100.0, 0.0, 0.0], xr.DataArray([100.0, 0.0, 0.0], dims="i")):
        assert tensor.grid_inertia(cube, origin=origin)["inertia_tensor"][1, 1] == pytest.approx(exact, rel=1e-13)
    for origin in ([1.0, 0.0, 0.0] * units.m, stated, ["1 m", "0 m", "0 m"]):
        with pytest.raises(SceneError, match=r"origin.* must be a (plain )?number"):
            tensor.grid_inertia(cube, origin=origin)


def test_grids_that_are_not_rectangular_are_refused():
    density = xr.DataArray(np.ones((2, 3, 2)), {"x": [0, 1], "y": [0, 2, 1], "z": [0, 1]}, tuple("xyz"))
    with pytest.raises(ValueError, match="'y' is neither ascending nor descending"):
        tensor.grid_inertia(density)
    with pytest.raises(ValueError, match="coordinate 'z' of two or more cells"):
        tensor.grid_inertia(density.sortby("y").isel(z=[0]))


def test_a_radial_profile_is_integrated_exactly_where_it_is_linear():
    # rho = 1 - r between 0.2 and 1, with the closed form of its powers.
    mass, inertia = tensor.radial_profile_inertia(np.array([0.2, 0.5, 1.0]), np.array([0.8, 0.5, 0.0]))
    assert mass == pytest.approx(4 * np.pi * ((1 - 0.2**3) / 3 - (1 - 0.2**4) / 4), rel=1e-14)
    moment = 8 * np.pi / 3 * ((1 - 0.2**5) / 5 - (1 - 0.2**6) / 6)
    np.testing.assert_allclose(inertia, moment * np.eye(3), rtol=1e-14)
    with pytest.raises(ValueError, match="ascending"):
        tensor.radial_profile_inertia(np.array([0.2, 0.2]), np.ones(2))
    with pytest.raises(ValueError, match="and finite"):
        tensor.radial_profile_inertia(np.array([0.2, np.inf]), np.ones(2))
    with pytest.raises(ValueError, match="the densities of a profile must be finite"):
        tensor.radial_profile_inertia(np.array([0.2, 0.3]), np.array([1.0, np.nan]))


def test_an_offset_of_another_shape_is_answered_with_every_shape_that_is_taken():
    with pytest.raises(TypeError, match=r"offset \(2,\); it takes mass \(\.\.\.,\), offset \(\.\.\., 3\)\.$"):
        tensor.about_point(np.eye(3), 2.0, [1.0, 0.0])


def test_the_ring_with_the_moment_of_a_sphere():
    sphere = 0.4 * 3.0 * 2.0**2 * np.eye(3)  # mass 3, radius 2
    radius, ring = tensor.equivalent_ring(sphere, 3.0, np.array([0.0, 0.0, 5.0]))
    assert radius == pytest.approx(2 * np.sqrt(0.4), rel=1e-15)
    np.testing.assert_allclose(ring, 4.8 * np.diag([0.5, 0.5, 1.0]), rtol=1e-15)


@pytest.mark.parametrize("length", [1e-200, 1e200, 2**31])  # the last of whole numbers
def test_the_axis_of_a_ring_may_have_any_length(length):
    direction = np.array([1, 2, 2])
    inertia = np.diag([1.0, 2.0, 2.5])
    radius, ring = tensor.equivalent_ring(inertia, 3.0, direction * length)
    moment = tensor.moment_about(inertia, direction)
    across = np.outer(direction, direction) / 9
    np.testing.assert_allclose(ring, 0.5 * moment * (np.eye(3) + across), rtol=1e-15)
    assert radius == pytest.approx(np.sqrt(moment / 3.0), rel=1e-15)


def test_invariants_are_those_of_the_moments():
    axes = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    found = tensor.invariants(axes @ np.diag([1.0, 2.0, 2.5]) @ axes.T)
    np.testing.assert_allclose(found, [5.5, 2 + 5 + 2.5, 5.0], rtol=1e-14)


@pytest.mark.parametrize(
    ("inertia", "match"),
    [
        (np.diag([1.0, 1.0, 2.001]), r"1 \+ 1 < 2.001"),
        (np.diag([-0.5, 3.0, 3.0]), "not negative, and this tensor has -0.5"),
        (np.array([[1.0, 0.1, 0], [0.0, 1, 0], [0, 0, 1]]), "symmetric"),
        (np.diag([1.0, np.nan, 1.0]), "finite"),
        (np.eye(2), "3 x 3"),
        (np.stack([1e9 * np.eye(3), np.diag([1.0, 1.0, 2.001])]), r"1 \+ 1 < 2.001"),
    ],
)
def test_tensors_that_no_body_has_are_refused(inertia, match):
    with pytest.raises(ValueError, match=match):
        tensor.require_plausible(inertia)


@pytest.mark.parametrize("moments", [(1, 1, 2), (0, 1, 1), (0, 0, 0), (1, 1, 1), (1e-12, 1, 1)])
def test_discs_rods_points_and_spheres_are_plausible(moments):
    axes = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    tensor.require_plausible(axes @ np.diag(np.array(moments, float)) @ axes.T)


@pytest.mark.parametrize("matrix", [np.diag([1.0, 1.0, 2.0]), np.eye(3) + np.eye(3, k=1), np.eye(2), np.zeros((3, 3))])
def test_a_tensor_is_turned_by_what_turns_alone(matrix):
    with pytest.raises(ValueError, match="a rotation matrix must be orthogonal, and this one is not"):
        tensor.rotated(np.diag([1.0, 2.0, 2.5]), matrix)
    turns = np.linalg.qr(np.random.default_rng(3).normal(size=(2, 3, 3)))[0].astype(np.float32)
    found = tensor.rotated(np.diag([1.0, 2.0, 2.5]), turns)  # also in single precision, and traced
    np.testing.assert_allclose(tensor.invariants(found), [[5.5, 9.5, 5.0]] * 2, rtol=2e-6)
    np.testing.assert_allclose(jax.jit(tensor.rotated)(jnp.diag(jnp.array([1.0, 2.0, 2.5])), turns), found, atol=1e-5)


def test_a_tensor_that_is_traced_is_not_refused():
    assert jax.jit(lambda inertia: tensor.require_plausible(inertia) is None)(jnp.eye(3))


def test_single_precision_is_kept():
    mass, position = (array.astype(np.float32) for array in particles(1))
    inertia = tensor.inertia_tensor(mass, position)
    results = [inertia, tensor.second_moment_from_inertia(inertia), tensor.invariants(inertia)]
    results += [
        tensor.about_centre(inertia, mass.sum(), position[0]),
        tensor.radius_of_gyration(inertia[0, 0], mass[0]),
    ]
    results += tensor.equivalent_ring(inertia, mass.sum(), position[0])
    results += tensor.radial_profile_inertia(np.arange(3, dtype=np.float32), mass[:3])
    assert {result.dtype for result in results} == {np.dtype(np.float32)}


@pytest.mark.slow
def test_jax_gives_the_same_numbers_and_a_finite_gradient_for_a_disc():
    import jax

    mass, position = particles(4)
    with jax.enable_x64(True):
        for function in (tensor.inertia_from_second_moment, tensor.second_moment_from_inertia, tensor.axial_vector):
            argument = position[:3]
            np.testing.assert_allclose(
                function(jax.numpy.asarray(argument)), function(argument), rtol=1e-14, atol=1e-14
            )
        found = jax.jit(tensor.inertia_tensor)(jax.numpy.asarray(mass), jax.numpy.asarray(position))
        np.testing.assert_allclose(found, tensor.inertia_tensor(mass, position), rtol=1e-13, atol=1e-12)
        gradient = jax.jacobian(lambda moments: tensor.equivalent_semi_axes(2.0, moments))(jax.numpy.array([1.0, 1, 2]))
        assert np.isfinite(gradient).all()


@pytest.mark.slow
@pytest.mark.parametrize("xp", [np, jnp])
def test_no_particles_have_no_centre_and_no_inertia(xp):
    nothing = xp.zeros(0), xp.zeros((0, 3))
    assert np.isnan(tensor.centre_of_mass(*nothing)).all()
    assert (np.asarray(tensor.inertia_tensor(*nothing, origin=xp.zeros(3))) == 0.0).all()


def test_coordinates_of_a_grid_are_in_one_unit():
    axis = np.linspace(0.0, 1.0, 3)
    grid = {name: (name, axis, {"units": unit}) for name, unit in (("x", "km"), ("y", "m"), ("z", "m"))}
    with pytest.raises(ValueError, match="in one unit, not in km and m"):
        tensor.grid_inertia(xr.DataArray(np.ones((3, 3, 3)), grid, ("x", "y", "z")))


@pytest.mark.full
def test_gradients_by_the_mass_alone_are_those_of_differences():
    """With moments in numpy, which says nothing of what is traced."""
    import jax

    moments = np.array([1.0, 2.0, 2.5])
    with jax.enable_x64(True):
        slope = jax.grad(lambda mass: tensor.equivalent_semi_axes(mass, moments)[0])(3.0)
    assert float(slope) == pytest.approx(-0.5 * tensor.equivalent_semi_axes(3.0, moments)[0] / 3.0, rel=1e-12)


def test_moments_that_are_nearly_possible_are_shown_with_their_digits():
    with pytest.raises(ValueError, match=r"1 \+ 1 < 2.000000001, and none"):
        tensor.require_plausible(np.diag([1.0, 1.0, 2.0 + 1e-9]))


@pytest.mark.parametrize("length", [1e-200, 1.0, 1e200])
def test_the_moment_about_an_axis_does_not_depend_on_its_length(length):
    axis = length * np.array([3.0, 0.0, 4.0])
    assert tensor.moment_about(np.diag([1.0, 2.0, 3.0]), axis) == pytest.approx(
        (9.0 * 1.0 + 16.0 * 3.0) / 25.0, rel=1e-15
    )


def test_a_factor_in_the_unit_of_a_grid_is_refused():
    cells = xr.DataArray([0.0, 1.0], dims="x", attrs={"units": "10 km"})
    grid = xr.DataArray(np.ones((2, 2, 2)), {"x": cells, "y": [0.0, 1.0], "z": [0.0, 1.0]}, attrs={"units": "g/cm3"})
    with pytest.raises(ValueError, match="units of a grid have no factors: 10 km and g/cm3"):
        tensor.grid_inertia(grid)


@pytest.mark.parametrize(("mass", "first"), [(np.nan, 5.0), (5.0, np.nan)])
def test_semi_axes_of_what_is_not_known_are_not_known(mass, first):
    assert np.isnan(tensor.equivalent_semi_axes(mass, np.array([first, 10.0, 13.0]))).all()  # they were 0
