"""Bodies made to a wanted tensor have it, to round-off, and what no body has is refused with its numbers."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from astroinertia.inertia import realise
from astroinertia.inertia.gravity_field import inertia_field, particle_field
from astroinertia.inertia.tensor import inertia_from_second_moment, inertia_tensor

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "inverse.json").read_text())
TWO_LAYERS = [case for case in REFERENCE if case["name"] == "inverse_two_layer"]
decades = st.floats(-6, 6).map(lambda exponent: 10.0**exponent)


def turned(second, seed):
    axes = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return inertia_from_second_moment(axes @ np.diag(second) @ axes.T)


def relative(found, wanted):
    return abs(found - wanted).max() / abs(wanted).max()


# Point masses


@pytest.mark.slow
@given(st.integers(0, 10**6), st.lists(st.floats(1e-3, 1), min_size=1, max_size=3), decades, decades)
def test_the_fewest_points_have_the_tensor_and_lie_equally_far(seed, second, mass, length):
    """Rods, laminae and solids over twelve decades of mass and length."""
    inertia = turned(np.array(second + [0.0] * (3 - len(second))) * mass * length**2, seed)
    masses, places = realise.point_masses(inertia, mass=mass)
    assert len(masses) == len(second) + 1
    assert (masses > 0).all()
    assert masses.sum() == pytest.approx(mass, rel=1e-14)
    radius = np.sqrt(sum(second)) * length
    assert np.linalg.norm(masses @ places) < 1e-14 * mass * radius
    np.testing.assert_allclose(np.linalg.norm(places, axis=1), radius, rtol=1e-13)
    assert relative(inertia_tensor(masses, places, np.zeros(3)), inertia) < 1e-13
    again = realise.point_masses(inertia, radius=radius)
    np.testing.assert_allclose(again[0], masses, rtol=1e-12)
    np.testing.assert_allclose(again[1], places, atol=1e-12 * radius)


def test_fewer_points_cannot_do_it():
    """n points about their centre span n - 1 dimensions at most, which is the rank of Q."""
    for count in (2, 3, 4):
        random = np.random.default_rng(count)
        masses, places = random.uniform(1, 2, count), random.normal(size=(count, 3))
        inertia = inertia_tensor(masses, places)
        found, _ = realise.point_masses(inertia, mass=masses.sum())
        assert len(found) == count


def test_mass_left_over_lies_at_the_centre():
    inertia = turned([3.0, 2.0, 1.0], 5)
    masses, places = realise.point_masses(inertia, mass=10.0, radius=2.0)
    np.testing.assert_allclose(masses, [0.375] * 4 + [8.5])
    np.testing.assert_allclose(np.linalg.norm(places, axis=1), [2.0] * 4 + [0.0])
    assert relative(inertia_tensor(masses, places), inertia) < 1e-13
    assert len(realise.point_masses(inertia, mass=1.5, radius=2.0)[0]) == 4
    assert realise.point_masses(inertia, mass=1.5 + 1e-9, radius=2.0)[0][4] == pytest.approx(1e-9, rel=1e-5)
    masses, places = realise.point_masses(np.zeros((3, 3)), mass=2.0)
    assert masses.tolist() == [2.0] and (places == 0).all()


def test_a_plate_that_is_not_quite_flat_takes_four_points():
    """Its thickness is far beyond round-off, and the points have it."""
    inertia = turned([1.0, 0.5, 1e-9], 7)
    masses, places = realise.point_masses(inertia, mass=2.0)
    assert len(masses) == 4
    second = np.linalg.eigvalsh(np.einsum("n,ni,nj->ij", masses, places, places))
    np.testing.assert_allclose(second, [1e-9, 0.5, 1.0], rtol=1e-6)


# Ellipsoids


@given(st.integers(0, 10**6), st.tuples(*[st.floats(0.01, 1)] * 3), decades, decades)
def test_homogeneous_ellipsoids(seed, axes, length, density):
    semi_axes = np.sort(np.array(axes))[::-1] * length
    mass = density * 4 / 3 * np.pi * semi_axes.prod()
    inertia = turned(mass * semi_axes**2 / 5, seed)
    for found in (
        realise.homogeneous_ellipsoid(inertia, mass=mass),
        realise.homogeneous_ellipsoid(inertia, density=density),
    ):
        # The least second moment is a difference of moments.
        np.testing.assert_allclose(found.semi_axes[0], semi_axes, rtol=1e-15 * (semi_axes[0] / semi_axes[2]) ** 2 * 10)
        assert found.mass == pytest.approx(mass, rel=1e-10)
        assert found.densities[0] == pytest.approx(density, rel=1e-10)
        assert relative(found.inertia, inertia) < 1e-12


def layered(fractions, densities, seed, size=(1.3, 1.0, 0.7)):
    """Mass and tensor of layers, each integrated by itself: a full ellipsoid less the one within."""
    mass, second, inner = 0.0, np.zeros(3), 0.0
    axes = np.array(size)
    for x, density in zip([*fractions, 1.0], densities, strict=True):
        volume = 4 / 3 * np.pi * axes.prod()
        mass += density * volume * (x**3 - inner**3)
        second += density * volume * axes**2 / 5 * (x**5 - inner**5)
        inner = x
    return mass, turned(second, seed)


@pytest.mark.parametrize(
    ("fractions", "densities"),
    [
        ((0.4,), (9.0, 3.0)),
        ((0.8,), (2.0, 3.0)),
        ((0.25, 0.5, 0.75), (13.0, 11.0, 5.0, 2.5)),
        ((0.2, 0.5, 0.9), (1.0, 9.0, 4.0, 2.5)),
        ((0.02,), (5000.0, 1.0)),
        ((0.3, 0.6), (4.0, 4.0, 1.0)),
        ((0.45, 0.9), (1.0, 9.0, 4.0)),  # near x = 0.918, from where on larger cores do the opposite
    ],
    ids=str,
)
def test_layers_are_found_again(fractions, densities):
    mass, inertia = layered(fractions, densities, 6)
    found = realise.layered_ellipsoid(inertia, mass, densities, boundaries=fractions)
    assert found.mass == pytest.approx(mass, rel=1e-12)
    assert relative(found.inertia, inertia) < 1e-12
    np.testing.assert_allclose(found.semi_axes[-1], [1.3, 1.0, 0.7], rtol=1e-11)
    np.testing.assert_allclose(found.semi_axes[:, 0] / 1.3, [*fractions, 1.0], rtol=1e-9)
    if fractions in ((0.4,), (0.8,), (0.25, 0.5, 0.75)):
        again = realise.layered_ellipsoid(inertia, mass, densities)
        np.testing.assert_allclose(again.semi_axes, found.semi_axes, rtol=1e-14)


def test_layers_that_are_all_core_or_all_mantle():
    mass, inertia = layered((), (3.0,), 1)
    for densities, share in (((7.0, 3.0), 0.0), ((3.0, 1.0), 1.0)):
        found = realise.layered_ellipsoid(inertia, mass, densities)
        np.testing.assert_allclose(found.semi_axes, np.outer([share, 1.0], [1.3, 1.0, 0.7]), rtol=1e-12)


@pytest.mark.parametrize("case", TWO_LAYERS, ids=["Earth", "Mars"])
def test_published_cores(case):
    given, value = case["inputs"], case["value"]
    radius = 6.4e6
    mass = given["rho_mean"] * 4 / 3 * np.pi * radius**3
    found = realise.two_layer_ellipsoid(
        float(given["k"]) * mass * radius**2 * np.eye(3), mass, given["rho_mean"], given["rho_mantle"]
    )
    np.testing.assert_allclose(found.semi_axes[1], radius, rtol=1e-14)
    np.testing.assert_allclose(found.semi_axes[0] / radius, float(value["rc_over_R"]), rtol=1e-12)
    assert found.densities[0] == pytest.approx(float(value["rho_core"]), rel=1e-12)
    assert found.mass == pytest.approx(mass, rel=1e-12)


def test_a_flattened_body_of_two_layers():
    mass, inertia = layered((0.45,), (11.0, 4.0), 3)
    mean = mass / (4 / 3 * np.pi * 1.3 * 1.0 * 0.7)
    found = realise.two_layer_ellipsoid(inertia, mass, mean, 4.0)
    np.testing.assert_allclose(found.semi_axes, np.outer([0.45, 1.0], [1.3, 1.0, 0.7]), rtol=1e-12)
    np.testing.assert_allclose(found.densities, [11.0, 4.0], rtol=1e-12)


def test_the_gravity_field_of_a_tilted_body_is_that_of_its_tensor_and_of_its_layers():
    """Degree 2 from I; degree 4 from a cloud of points: in each layer those of a shell, moved to its ellipsoid."""
    mass, inertia = layered((0.45,), (11.0, 4.0), 3)
    found = realise.layered_ellipsoid(inertia, mass, (11.0, 4.0))
    field = found.gravity_field(4, 2.0)
    assert field.mass == pytest.approx(mass, rel=1e-12)
    unnormalised, wanted = field.normalized("unnorm"), inertia_field(inertia, mass, 2.0).normalized("unnorm")
    np.testing.assert_allclose(unnormalised[:, :3, :3], wanted, atol=1e-12)
    # A Gauss rule in the cosine of the polar angle and even azimuths are exact to degree 4 on a sphere, and in radius.
    nodes, weights = np.polynomial.legendre.leggauss(5)
    angle = 2 * np.pi * (np.arange(8) + 0.5) / 8
    across = np.sqrt(1 - nodes**2)
    ball = np.stack([np.outer(across, np.cos(angle)), np.outer(across, np.sin(angle)), np.outer(nodes, 0 * angle + 1)])
    radius, share = (nodes + 1) / 2, weights / 2
    place = np.einsum("r,ipq->rpqi", radius, ball).reshape(-1, 3)
    volume = (np.einsum("r,p->rp", share * radius**2, weights / 2)[..., None] / 8 * np.ones(8)).ravel() * 4 * np.pi
    steps = zip(found.semi_axes, found.densities - np.append(found.densities[1:], 0.0), strict=True)
    parts = [(density * axes.prod() * volume, place * axes @ found.axes) for axes, density in steps]
    masses, places = (np.concatenate(each) for each in zip(*parts, strict=True))
    cloud = particle_field(masses, places, 4, 2.0).normalized("unnorm")
    np.testing.assert_allclose(unnormalised, cloud, rtol=0, atol=1e-12)


# Refusals

FLAT, SOLID = np.diag([1.0, 1.0, 2.0]), np.diag([1.0, 1.2, 1.4])
IMPOSSIBLE = np.diag(next(case for case in REFERENCE if case["name"] == "inverse_infeasible")["inputs"]["I_principal"])


@pytest.mark.parametrize(
    "make",
    [
        lambda inertia: realise.point_masses(inertia, mass=1.0),
        lambda inertia: realise.homogeneous_ellipsoid(inertia, mass=1.0),
        lambda inertia: realise.layered_ellipsoid(inertia, 1.0, (2.0, 1.0)),
        lambda inertia: realise.two_layer_ellipsoid(inertia, 1.0, 2.0, 1.0),
        lambda inertia: realise.fit_to_tensor(lambda p: p, np.eye(3), inertia),
    ],
    ids=["points", "ellipsoid", "layers", "two layers", "fit"],
)
def test_impossible_tensors_are_refused_with_the_inequality(make):
    with pytest.raises(ValueError, match=r"1 \+ 1 < 2\.1"):
        make(IMPOSSIBLE)
    with pytest.raises(ValueError, match="not negative, and this tensor has -1"):
        make(np.diag([-1.0, 1.0, 1.0]))
    with pytest.raises(ValueError, match="symmetric"):
        make(np.eye(3) + np.diag([0.1, 0.1], 1))


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: realise.point_masses(SOLID, mass=2.0, radius=0.5), r"0\.5 < 1\.8"),
        (lambda: realise.point_masses(SOLID), "need a total mass, a radius or both"),
        (lambda: realise.point_masses(np.zeros((3, 3)), radius=1.0), "mass must be given"),
        (lambda: realise.point_masses(SOLID, mass=-1.0), "mass must be positive"),
        (lambda: realise.homogeneous_ellipsoid(FLAT, mass=1.0), r"1 \+ 1 > 2 fails"),
        (lambda: realise.homogeneous_ellipsoid(SOLID, mass=1.0, density=1.0), "and not both"),
        (lambda: realise.homogeneous_ellipsoid(SOLID, density=0.0), "density must be positive"),
        (lambda: realise.layered_ellipsoid(SOLID, 1.0, (2.0,)), "two densities or more"),
        (lambda: realise.layered_ellipsoid(SOLID, 1.0, (2.0, 1.0, 0.5), (0.5, 0.2)), "must be positive and ascend"),
        (lambda: realise.layered_ellipsoid(SOLID, 1.0, (2.0, 1.0, 0.5), (0.5, 0.5)), "must be positive and ascend"),
        (lambda: realise.layered_ellipsoid(SOLID, 1.0, (2.0, 1.0, 0.5), (0.0, 0.5)), "must be positive and ascend"),
        (lambda: realise.two_layer_ellipsoid(SOLID, 1.0, 1.0, 1.0), "no core to be found"),
        (lambda: realise.two_layer_ellipsoid(np.eye(3) * 0.6, 1.0, 3 / (4 * np.pi), 0.1), r"0 < x\^2 < 1 fails"),
        (lambda: realise.two_layer_ellipsoid(np.eye(3) * 0.48, 1.0, 3 / (4 * np.pi), 0.3), r"density > 0 fails"),
    ],
)
def test_what_cannot_be_made_is_refused(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()


def test_layers_out_of_reach_name_the_density_that_would_be_needed():
    mass, inertia = layered((), (3.0,), 1)
    with pytest.raises(ValueError, match=r"has the density 3, and 4 <= 3 <= 7 fails"):
        realise.layered_ellipsoid(inertia, mass, (7.0, 4.0))


@pytest.mark.parametrize("size", [1e-200, 1e-160, 1e160, 1e200])
def test_tensors_whose_cubes_numbers_do_not_hold(size):
    """Semi-axes a^2 = 5 Q/M grow as the root of the tensor with a given mass, as its fifth root with a density."""
    tensor, density = size * np.diag([5.0, 10.0, 13.0]), 15.0 / (4.0 * np.pi) / 6.0
    found = realise.homogeneous_ellipsoid(tensor, mass=5.0)
    np.testing.assert_allclose(found.semi_axes, size**0.5 * np.array([[3.0, 2.0, 1.0]]), rtol=1e-14)
    assert found.densities[0] == pytest.approx(density * size**-1.5, rel=1e-13)
    by_density = realise.homogeneous_ellipsoid(tensor, density=density)
    np.testing.assert_allclose(by_density.semi_axes, size**0.2 * np.array([[3.0, 2.0, 1.0]]), rtol=1e-13)
    with pytest.raises(ValueError, match=r"has the density .*, and 0\.2 <= .* <= 0\.5 fails"):
        realise.layered_ellipsoid(tensor, 5.0, (0.5, 0.2))
    with pytest.raises(ValueError, match=r"0 < x\^2 < 1 fails"):
        realise.two_layer_ellipsoid(tensor, 5.0, 0.5, 0.2)


@pytest.mark.parametrize("size", [1e-300, 1e300])
def test_a_density_that_numbers_do_not_hold_is_refused(size):
    with pytest.raises(ValueError, match="the density lies beyond what numbers hold"):
        realise.homogeneous_ellipsoid(size * np.diag([5.0, 10.0, 13.0]), mass=5.0)


# Fits


@pytest.mark.full
def test_a_fit_by_gradients_finds_an_ellipsoid_by_its_axes_and_tilt():
    import jax
    import jax.numpy as jnp

    def inertia_of(parameters):
        tilt = parameters["tilt"]
        turn = jnp.array([[jnp.cos(tilt), -jnp.sin(tilt), 0.0], [jnp.sin(tilt), jnp.cos(tilt), 0.0], [0.0, 0.0, 1.0]])
        return inertia_from_second_moment(turn @ jnp.diag(parameters["axes"] ** 2) @ turn.T) / 5.0

    true = {"axes": np.array([1.5, 1.1, 0.7]), "tilt": np.array(0.3)}
    with jax.enable_x64(True):
        wanted = np.asarray(inertia_of(true))
    start = {"axes": np.array([1.2, 1.0, 1.0]), "tilt": np.array(0.1)}
    found = realise.fit_to_tensor(inertia_of, start, wanted)
    assert found.misfit < 1e-12
    np.testing.assert_allclose(found.parameters["axes"], true["axes"], rtol=1e-9)
    np.testing.assert_allclose(found.parameters["tilt"], 0.3, rtol=1e-9)
    assert relative(found.inertia, wanted) < 1e-12
    assert found.evaluations < 15
    bounds = ({"axes": np.zeros(3), "tilt": np.array(-1.0)}, {"axes": np.array([1.4, 2.0, 2.0]), "tilt": np.array(0.2)})
    held = realise.fit_to_tensor(inertia_of, start, wanted, bounds)
    assert held.parameters["axes"][0] == pytest.approx(1.4, rel=1e-6)
    assert held.misfit > 1e-2
    assert held.misfit == pytest.approx(np.linalg.norm(held.inertia - wanted) / np.linalg.norm(wanted), rel=1e-12)


@pytest.mark.slow
def test_a_fit_moves_every_particle():
    """More parameters than a tensor has elements: gradients by reverse mode."""
    import jax.numpy as jnp

    mass, places = np.ones(30), np.random.default_rng(2).normal(size=(30, 3))
    wanted = turned([30.0, 20.0, 12.0], 4)
    found = realise.fit_to_tensor(lambda x: inertia_tensor(jnp.asarray(mass), x), places, wanted)
    assert found.misfit < 1e-12
    assert relative(inertia_tensor(mass, found.parameters), wanted) < 1e-12


def test_a_series_of_tensors_is_refused_with_the_shape_that_is_taken():
    with pytest.raises(ValueError, match="the mass must be positive and finite, and is inf"):
        realise.point_masses(SOLID, np.inf)
    with pytest.raises(TypeError, match=r"inertia \(2, 3, 3\), mass \(\); it takes inertia \(3, 3\)"):
        realise.point_masses(np.stack([SOLID, SOLID]), 1.0)
