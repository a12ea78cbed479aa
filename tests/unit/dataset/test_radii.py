"""What refers to a radius of the body now: ratios that a homologous change keeps, and J2 against closed forms."""

import jax
import numpy as np
import pytest
import xarray as xr

from astroinertia import dataset
from astroinertia.bodies import maclaurin
from astroinertia.bodies.polytrope import lane_emden
from astroinertia.build.assemble import metadata, model_description, prepare
from astroinertia.build.structure import as_begun
from astroinertia.dataset import radii
from astroinertia.dataset.derived import spin_axis
from astroinertia.dataset.radii import RATIOS, degree_two, reference_radius, surface
from astroinertia.scene.load import loads
from tests.exact_polytropes import exact_polytrope

SPIN = "[body.rotation]\nrate = 0.1\n"
STAR = '[body]\nkind = "polytrope"\nindex = 1.5\nmass = 1.0\nradius = 2.0\nrelax = false\n'
SHRINKS = "[body.change]\ntimes = [0.1, 1.0]\nfactors = [1.0, 1e-4]\n"
FALLS = (
    "velocity_gradient = [[-0.99, 0.0, 0.0], [0.0, -0.99, 0.0], [0.0, 0.0, -0.99]]\n"
    '[equation_of_state]\nkind = "ideal"\n'
)
SCENES = {
    "sph": STAR + "particles = 100\n" + FALLS,
    "ellipsoid": STAR + FALLS,
    "rigid": STAR + SPIN + SHRINKS,
    "scaling": STAR + SPIN + SHRINKS,
    "a solid": '[body]\nkind = "rigid"\nmass = 1.0\nradius = 2.0\nmoment_ratios = [0.3, 0.31, 0.33]\n' + SPIN + SHRINKS,
}
PLAIN = {"name": "points", "dimensionless": True, "effects": [], "model": "sph"}


def course(text: str, model: str, *times: float, effects: str = "[effects]\n") -> xr.Dataset:
    """The dataset of a scene in code units, recorded at 0 and some times."""
    scene = loads(f'name = "one"\nmodel = "{model}"\nunits = "code"\n{text}\n{effects}[time]\nend = 1.0\n')
    with jax.enable_x64(True):
        body, first = prepare(scene).evolution, prepare(scene).evolution
        rows = [body.record(None) | {"time": 0.0}]
        for time in times:
            while body.time < time:
                body.advance(time)
            rows.append(body.record(0.0) | {"time": body.time})
    series = {name: np.stack([np.asarray(row[name]) for row in rows]) for name in rows[0]}
    described = metadata(scene)
    described["structure"] = as_begun(described["structure"], first)
    return dataset.headline(series, {**described, **model_description(body)})


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=() if name in ("ellipsoid", "scaling", "sph") else pytest.mark.full) for name in SCENES],
)
def test_a_homologous_contraction_keeps_its_moment_ratios_to_round_off(name: str) -> None:
    """By a factor of 100; the affine body's is as exact as its integration."""
    found = course(SCENES[name], "rigid" if name == "a solid" else name, 0.5, 1.0)
    known = [ratio for ratio in RATIOS if np.isfinite(found[ratio]).any()]
    assert known == (["moment_ratio"] if name == "a solid" else list(RATIOS))
    for ratio in known:
        np.testing.assert_allclose(found[ratio], found[ratio][0], rtol=1e-10 if name == "ellipsoid" else 1e-13)
    exact = 0.33 if name == "a solid" else lane_emden(1.5).moment_ratio
    assert float(found["moment_ratio"][-1]) == pytest.approx(exact, rel=0.01 if name == "sph" else 1e-10)
    assert float(found["surface_mean_radius"][-1]) == pytest.approx(0.02, rel=0.01 if name == "sph" else 1e-10)
    convention = found["moment_ratio"].attrs
    origins = {"sph": radii.ENCLOSING, "a solid": radii.OF_SCENE}
    assert convention["radius"] == "surface_mean_radius"
    assert convention["radius_convention"] == origins.get(name, radii.KEPT)
    assert ("radial_moments" in found["gravity_coefficient"].attrs) == (name not in origins)  # it keeps its layers


def test_j2_of_a_maclaurin_spheroid_and_the_coefficients_of_an_ellipsoid_are_those_of_the_closed_form() -> None:
    """J2 = (1 - c^2/a^2)/5; C20 and C22 of a homogeneous ellipsoid, R^2 = (a^2 + b^2)/2."""
    rest = "[equation_of_state]\nkind = 'ideal'\n"
    uniform = '[body]\nkind = "uniform"\nmass = 2.0\nradius = 3.0\naxes = '
    spheroid = maclaurin.from_axis_ratio(0.7)
    found = course(f"{uniform}[1.0, 1.0, 0.7]\n{rest}", "ellipsoid").isel(time=0)
    assert float(found["zonal_harmonic_2"]) == pytest.approx(spheroid.second_zonal_harmonic, rel=1e-12)
    assert float(found["zonal_harmonic_2"]) == pytest.approx((1 - 0.7**2) / 5, rel=1e-12)
    assert float(found["surface_flattening"]) == pytest.approx(0.3, rel=1e-12)
    a, b, c = 1.2, 1.0, 0.7
    found = course(f"{uniform}[{a}, {b}, {c}]\n{rest}", "ellipsoid").isel(time=0)
    size = 5 * (a**2 + b**2) / 2
    exact = [(c**2 - (a**2 + b**2) / 2) / size, 0.0, 0.0, (a**2 - b**2) / (4 * size), 0.0]
    np.testing.assert_allclose(found["gravity_coefficient"], exact, atol=1e-13)
    assert float(found["zonal_harmonic_2"]) == pytest.approx(-exact[0], rel=1e-12)
    assert found["zonal_harmonic_2"].attrs["radius"] == "surface_equatorial_radius"


@pytest.mark.parametrize("model", ["scaling", "rigid"])
def test_j2_and_the_surface_of_a_rotating_polytrope_are_those_of_its_series(model: str) -> None:
    star = exact_polytrope(axis_ratio=0.8)
    text = '[body]\nkind = "rotating_star"\nindex = 1.0\naxis_ratio = 0.8\nmass = 1.0\nradius = 2.0\n'
    found = course(text, model).isel(time=0)
    assert float(found["zonal_harmonic_2"]) == pytest.approx(star.zonal_harmonics[0], rel=1e-5)
    assert float(found["moment_ratio_equatorial"]) == pytest.approx(star.polar_moment_ratio_equatorial, rel=1e-5)
    assert float(found["surface_flattening"]) == pytest.approx(0.2, rel=1e-10)
    # Surfaces of equal density are flatter outside than within.
    assert 0.14 < float(found["ellipsoid_flattening"]) < 0.19


def test_the_surface_of_a_body_that_keeps_its_layers_is_a_stretched_ellipsoid() -> None:
    """Sums m x^2 are those numbers of the start times M and the squares of the semi-axes 6, 6 and 3, about x."""
    mass, numbers = np.array([8.0]), {"equatorial_second_moment": 0.15, "polar_second_moment": 0.25}
    second = mass[:, None, None] * np.diag([0.25 * 3.0**2, 0.15 * 6.0**2, 0.15 * 6.0**2])
    found = surface({"mass": mass}, second, np.array([[1.0, 0.0, 0.0]]), numbers)
    assert found is not None
    np.testing.assert_allclose(np.ravel(found), [(6.0 * 6.0 * 3.0) ** (1 / 3), 6.0, 3.0], rtol=1e-14)


def test_the_surface_of_particles_is_their_ellipsoid_enlarged_as_at_the_start() -> None:
    shapes = np.array([np.diag([9.0, 36.0, 36.0]), np.full((3, 3), np.nan)])
    series = {"mass": np.full(2, 8.0), "enclosing_ellipsoid": shapes}
    found = surface(series, shapes, np.tile([1.0, 0.0, 0.0], (2, 1)), {"enclosing_99": 0.75})
    assert found is not None and np.isnan(np.array(found)[:, 1]).all()
    np.testing.assert_allclose(np.array(found)[:, 0], [4.0 * 4.0 ** (1 / 3), 8.0, 4.0], rtol=1e-14)


def test_the_surface_of_a_body_of_which_only_one_radius_is_known_goes_as_the_root_of_its_moments() -> None:
    """tr Q = 3 M R^2 times the number of the start: 1/5 of a ball, which 4 times the mass does not make larger."""
    mass, size = np.array([2.0, 2.0, 8.0]), np.array([3.0, 6.0, 3.0])
    second = np.einsum("t,ij->tij", mass * size**2, np.diag([0.1, 0.2, 0.3]))
    axis = np.tile([0.0, 0.0, 1.0], (3, 1))
    found = surface({"mass": mass}, second, axis, {"mean_second_moment": 0.2})
    assert found is not None and np.isnan(found.equatorial).all() and np.isnan(found.polar).all()
    np.testing.assert_allclose(found.mean, size, rtol=1e-15)


def test_j2_refers_to_the_first_radius_that_is_known() -> None:
    known, unknown = np.array([np.nan, 2.0]), np.full(2, np.nan)
    names = "surface_equatorial_radius", "surface_mean_radius", "equatorial_radius"
    for number, expected in enumerate(names):
        has = {name: unknown if k < number else known for k, name in enumerate(names)}
        assert reference_radius(has) == expected
    assert reference_radius(dict.fromkeys(names, unknown)) == "equatorial_radius"


def test_coefficients_are_the_sums_over_legendre_functions() -> None:
    """C_2m = (2 - delta) (2 - m)!/(2 + m)! sum m (r/R)^2 P_2m(sin latitude) cos m longitude / M; S_2m with the sine."""
    rng = np.random.default_rng(5)
    mass, place = rng.uniform(0.5, 1.5, 20), rng.normal(size=(20, 3))
    place = place - mass @ place / mass.sum()
    x, y, z = place.T
    second = (mass * place.T) @ place
    record = {
        "time": 0.0,
        "mass": mass.sum(),
        "second_moment": second,
        "inertia_tensor": np.trace(second) * np.eye(3) - second,
    }
    found = dataset.headline({name: np.asarray(value)[None] for name, value in record.items()}, PLAIN).isel(time=0)
    square, longitude = (place**2).sum(axis=1), np.arctan2(y, x)
    sine, cosine = z / np.sqrt(square), np.hypot(x, y) / np.sqrt(square)
    size = mass.sum() * float(found[found["gravity_coefficient"].attrs["radius"]]) ** 2
    p20, p21, p22 = 1.5 * sine**2 - 0.5, 3 * sine * cosine, 3 * cosine**2
    exact = [p20, p21 * np.cos(longitude) / 3, p21 * np.sin(longitude) / 3, p22 * np.cos(2 * longitude) / 12,
             p22 * np.sin(2 * longitude) / 12]  # fmt: skip
    np.testing.assert_allclose(
        found["gravity_coefficient"], [(mass * square) @ each / size for each in exact], rtol=1e-12
    )


def test_j2_is_about_the_axis_of_the_largest_moment_whatever_its_number() -> None:
    """Moments keep their numbers where they cross, so that the largest need not be the third."""
    inertia = np.diag([5.0, 4.0, 3.0])[None]
    for numbered in ([3.0, 4.0, 5.0], [5.0, 3.0, 4.0]):
        found = degree_two(inertia, np.array([numbered]), np.array([2.0]), np.array([3.0]))
        np.testing.assert_allclose(found["zonal_harmonic_2"], (5.0 - 3.5) / (2.0 * 3.0**2), rtol=1e-15)


def test_a_body_spins_where_its_angular_momentum_is_beyond_round_off_of_its_motion() -> None:
    """Two points at -1 and 1 move outwards at an angle: L is its sine times the root of tr Q tr K."""
    largest = np.array([[0.0, 0.6, 0.8]])
    for sine, spins in ((1.1e-9, True), (0.9e-9, False), (0.0, False)):
        momentum = np.array([[0.0, 0.0, -2.0 * sine]])
        series = {"angular_momentum": momentum, "second_moment": np.diag([2.0, 0, 0])[None]}
        series["kinetic_tensor"] = np.array([[[2.0, 2.0 * sine, 0], [2.0 * sine, 2.0 * sine**2, 0], [0, 0, 0]]])
        np.testing.assert_array_equal(spin_axis(series, largest)[0], [0.0, 0.0, -1.0] if spins else largest[0])
        alone = spin_axis({"angular_momentum": momentum}, largest)[0]  # without what its motion could carry
        np.testing.assert_array_equal(alone, [0.0, 0.0, -1.0] if sine else largest[0])


@pytest.mark.slow
def test_particles_of_a_rotating_star_have_its_flattening() -> None:
    text = '[body]\nkind = "rotating_star"\nindex = 1.5\naxis_ratio = 0.8\nmass = 1.0\nradius = 2.0\nrelax = false\n'
    found = course(text + 'particles = 1000\n[equation_of_state]\nkind = "ideal"\n', "sph").isel(time=0)
    assert float(found["surface_flattening"]) == pytest.approx(0.2, abs=0.03)  # 0.18 where 95 % lie
    assert float(found["surface_equatorial_radius"]) == pytest.approx(2.0, rel=0.03)
    exact = course(text, "scaling").isel(time=0)
    for name in ("moment_ratio", "half_mass_radius", "radius_enclosing_99", "zonal_harmonic_2"):
        assert float(found[name]) == pytest.approx(float(exact[name]), rel=0.06), name


def test_older_records_keep_the_radius_of_the_start_and_say_so() -> None:
    second = 0.2 * np.diag([4.0, 4.0, 1.0])
    record = {
        "time": 0.0,
        "mass": 1.0,
        "second_moment": second,
        "inertia_tensor": np.trace(second) * np.eye(3) - second,
    }
    metadata = PLAIN | {"reference_radius": 3.0, "reference_radius_convention": "radius that the scene gives"}
    found = dataset.headline({name: np.asarray(value)[None] for name, value in record.items()}, metadata)
    assert float(found["moment_ratio"][0]) == pytest.approx(1.6 / 9.0)
    assert found["moment_ratio"].attrs["radius"] == "reference_radius"
    assert found["moment_ratio"].attrs["radius_convention"].endswith("of the start")


def test_particles_that_have_settled_have_the_moment_ratio_of_their_polytrope() -> None:
    """Their outermost layer lies within the surface: 99 % of the mass of 200 within 0.74 of what the profile says."""
    text = STAR.replace("relax = false\n", "particles = 200\n") + '[equation_of_state]\nkind = "ideal"\n'
    effects = "[effects.gravity]\n[effects.pressure]\n"
    found = course(text, "sph", effects=effects).isel(time=0)
    assert float(found["surface_mean_radius"]) == pytest.approx(2.0, rel=1e-12)
    assert float(found["moment_ratio"]) == pytest.approx(lane_emden(1.5).moment_ratio, rel=0.1)
