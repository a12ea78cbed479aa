"""`ds.inertia.gravity_field`: of particles the sums at their snapshots, of a homogeneous ellipsoid the closed form."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import astroinertia
from astroinertia import dataset
from astroinertia.errors import AbsentError, SceneError
from astroinertia.inertia.gravity_field import ellipsoid_field, layered_field
from astroinertia.storage.archive import Archive
from tests.sims import SIMS
from tests.unit.affine_body import METADATA, affine_run
from tests.unit.dataset.test_radii import STAR, course

UNIFORM = '[body]\nkind = "uniform"\nmass = 2.0\nradius = 3.0\naxes = [1.2, 1.0, 0.7]\n'
FALLS = (
    "velocity_gradient = [[0.0, 0.3, 0.0], [-0.3, 0.0, 0.2], [0.0, -0.2, 0.0]]\n[equation_of_state]\nkind = 'ideal'\n"
)


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    records, snapshots = affine_run(outputs=24, particles=64)
    folder = tmp_path_factory.mktemp("run")
    with Archive.create(folder, METADATA) as archive:
        archive.write_segment(records, snapshots)
        return astroinertia.open_tree(dataset.finish(archive))


def test_particles_have_the_field_of_their_second_moments_at_each_snapshot(tree) -> None:
    field = tree.inertia.gravity_field(degree=4, radius=2e6, normalization="unnorm")
    assert field.harmonic_coefficient.dims == ("snapshot_time", "part", "degree", "order")
    np.testing.assert_array_equal(field.snapshot_time, tree["snapshots"].snapshot_time)
    mass, place = tree["snapshots"].mass.values[..., None], tree["snapshots"].position.transpose(..., "i").values
    centre = (mass * place).sum(1, keepdims=True) / mass.sum(1, keepdims=True)
    x, y, z = np.moveaxis(place - centre, -1, 0)
    weight, square = mass[..., 0] / mass.sum(1), x**2 + y**2 + z**2
    j2 = -(weight * (1.5 * z**2 - 0.5 * square)).sum(1) / 2e6**2
    j4 = -(weight * (35 * z**4 - 30 * z**2 * square + 3 * square**2) / 8).sum(1) / 2e6**4
    np.testing.assert_allclose(field.zonal_harmonic.sel(degree=2), j2, rtol=0, atol=1e-15)
    np.testing.assert_allclose(field.zonal_harmonic.sel(degree=4), j4, rtol=0, atol=1e-15)
    s22 = field.harmonic_coefficient.sel(part="S", degree=2, order=2)
    np.testing.assert_allclose(s22, 0.5 * (weight * x * y).sum(1) / 2e6**2, rtol=0, atol=1e-15)
    assert abs(field.harmonic_coefficient.sel(degree=1, order=[0, 1])).max() < 1e-15
    assert field.harmonic_coefficient.sel(degree=1, order=2).isnull().all()


def test_a_snapshot_at_the_end_is_not_lost_to_round_off(tree) -> None:
    """Members of a sweep share their times, which are those of their own snapshots to round-off."""
    series, particles = tree.to_dataset(), tree["snapshots"].to_dataset(inherit=False)
    earlier = series.assign_coords(time=(series.time * (1.0 - 4e-16)).assign_attrs(series.time.attrs))
    field = xr.DataTree.from_dict({"/": earlier, "/snapshots": particles}).inertia.gravity_field(degree=2, radius=2e6)
    xr.testing.assert_identical(field, tree.inertia.gravity_field(degree=2, radius=2e6))
    part = earlier.isel(time=slice(4, 9))
    within = xr.DataTree.from_dict({"/": part, "/snapshots": particles}).inertia.gravity_field(degree=2)
    np.testing.assert_array_equal(within.snapshot_time, series.time[4:9:2])


def test_without_a_radius_it_is_the_one_that_j2_refers_to(tree) -> None:
    series = tree.to_dataset()
    field = tree.inertia.gravity_field(degree=2)
    radius = series[series.zonal_harmonic_2.attrs["radius"]].values[::2]
    np.testing.assert_allclose(field.reference_radius, radius, rtol=1e-12)
    again = tree.inertia.gravity_field(degree=2, radius="2000 km", normalization="schmidt", csphase=-1)
    ratio = again.harmonic_coefficient.sel(part="C", degree=2, order=0) / field.harmonic_coefficient.sel(
        part="C", degree=2, order=0
    )
    np.testing.assert_allclose(ratio, np.sqrt(5) * radius**2 / 4e12, rtol=1e-12)
    assert (again.harmonic_coefficient.attrs["normalization"], again.harmonic_coefficient.attrs["csphase"]) == (
        "schmidt", -1,
    )  # fmt: skip


@pytest.mark.full
def test_a_homogeneous_ellipsoid_has_the_closed_form_at_each_record() -> None:
    run = course(UNIFORM + FALLS, "ellipsoid", 0.5, 1.0)
    field = run.inertia.gravity_field(degree=8)
    assert field.zonal_harmonic.dims == ("time", "degree") and field.sizes["time"] == 3
    np.testing.assert_array_equal(field.reference_radius, run.surface_equatorial_radius)
    exact = ellipsoid_field(2.0, (3.6, 3.0, 2.1), 8, float(field.reference_radius[0])).coefficients
    coefficients = field.harmonic_coefficient[0].fillna(0.0)
    np.testing.assert_allclose(coefficients, exact, rtol=0, atol=1e-14)
    # Turned and strained, degree 2 is still that of the tensor.
    unit = np.sqrt([5.0, 5 / 3, 5 / 12])
    degree_two = np.array([field.harmonic_coefficient.sel(part="C", degree=2, order=m) * unit[m] for m in range(3)])
    np.testing.assert_allclose(degree_two, run.gravity_coefficient.values[:, [0, 1, 3]].T, rtol=0, atol=1e-14)
    assert abs(run.gravity_coefficient[-1, 1]) > 1e-3


@pytest.mark.slow
def test_in_principal_axes_j2_is_that_of_the_principal_moments(tree) -> None:
    series = tree.to_dataset()
    turned = course(UNIFORM + FALLS, "ellipsoid", 1.0)
    field = turned.inertia.gravity_field(degree=2, principal_axes=True)
    np.testing.assert_allclose(field.zonal_harmonic.sel(degree=2), turned.zonal_harmonic_2, rtol=1e-12)
    sweep = xr.concat([series, series], "spin")
    with pytest.raises(SceneError, match=r"the gravity field is of one member of a sweep: take one, such as ds\.isel"):
        sweep.inertia.gravity_field()


@pytest.mark.slow
@pytest.mark.parametrize(
    "model",
    ["ellipsoid", pytest.param("rigid", marks=pytest.mark.full), pytest.param("scaling", marks=pytest.mark.full)],
)
def test_a_polytrope_has_the_field_of_its_similar_layers(model: str) -> None:
    """J_l over that of the homogeneous spheroid of its surface is (l + 3)/3 <s^l>, in closed form for n = 1."""
    body = STAR.replace("1.5", "1.0") + "axes = [1.0, 1.0, 0.8]\n"
    run = course(body + ("" if model == "rigid" else "[equation_of_state]\nkind = 'ideal'\n"), model)
    field = run.inertia.gravity_field(degree=20, radius=2.0)
    single = run.astype("float32").inertia.gravity_field(degree=4, radius=2.0)
    np.testing.assert_allclose(single.zonal_harmonic, field.zonal_harmonic.sel(degree=slice(4)), atol=1e-6)
    bare = run.assign(zonal_harmonic_2=run.zonal_harmonic_2.drop_attrs())  # as some of xarray's arithmetic leaves it
    found = bare.inertia.gravity_field(degree=2).zonal_harmonic.sel(degree=2)
    np.testing.assert_allclose(found, run.zonal_harmonic_2, rtol=1e-9)
    part = run[["inertia_tensor", "mass", "gravity_coefficient"]]
    xr.testing.assert_identical(part.inertia.gravity_field(20, radius=2.0).zonal_harmonic, field.zonal_harmonic)
    with pytest.raises(AbsentError, match="has no equatorial_radius"):
        part.inertia.gravity_field(degree=2)
    uniform = ellipsoid_field(1.0, (2.0, 2.0, 1.6), 20, 2.0)
    pi2 = np.pi**2
    means = {2: 1 - 6 / pi2, 4: 1 - 20 / pi2 + 120 / pi2**2, 6: 1 - 42 / pi2 + 840 / pi2**2 - 5040 / pi2**3}
    for degree, mean in means.items():
        expected = uniform.zonal_harmonic(degree) * (degree + 3) / 3 * mean
        assert float(field.zonal_harmonic.sel(degree=degree)[0]) == pytest.approx(expected, rel=1e-9)
    shells = (np.arange(4000) + 0.5) / 4000
    layers = layered_field(np.sinc(shells), np.outer(shells + 0.5 / 4000, (2.0, 2.0, 1.6)), 20, 2.0)
    assert float(field.zonal_harmonic.sel(degree=20)[0]) == pytest.approx(layers.zonal_harmonic(20), rel=1e-4)
    with pytest.raises(SceneError, match="the gravity field of layers goes to degree 20, not 21"):
        run.inertia.gravity_field(degree=21)


def test_other_bodies_have_none_above_degree_two() -> None:
    text = '[body]\nkind = "rotating_star"\nindex = 1.0\naxis_ratio = 0.8\nmass = 1.0\nradius = 2.0\n'
    with pytest.raises(AbsentError, match="needs snapshots of particles, or a body that keeps its layers; degree 2 is"):
        course(text, "scaling").inertia.gravity_field()


def test_particles_of_older_files_have_theirs() -> None:
    old = astroinertia.open(Path(__file__).parents[2] / "data" / "format_1.nc")
    field = old.inertia.gravity_field(degree=4)
    assert field.sizes["snapshot_time"] == 2 and field.zonal_harmonic.notnull().all()
    assert float(field.reference_radius[0]) == float(old.equatorial_radius[0])


def test_wrong_arguments_are_refused(tree) -> None:
    with pytest.raises(SceneError, match="the degree must be a whole number from 0 to 80, not 99"):
        tree.inertia.gravity_field(degree=99)
    with pytest.raises(SceneError, match="normalization must be one of 4pi, ortho, schmidt, unnorm"):
        tree.inertia.gravity_field(normalization="full")


@pytest.mark.slow
def test_a_member_of_a_sweep_has_the_field_of_its_own_layers(tmp_path) -> None:
    """Of members with other profiles the sweep notes no layers."""
    scene = (SIMS / "core_to_pulsar_scaling.toml").read_text().replace('end = "0.3 s"', 'end = "20 ms"')
    (tmp_path / "two.toml").write_text(f'{scene}\n[sweep]\n"body.index" = [3.0, 1.5]\n')
    astroinertia.run_scene(tmp_path / "two.toml", tmp_path / "two", workers=1)
    sweep = astroinertia.open(tmp_path / "two")
    for member in (sweep.isel(body_index=0), sweep.isel(body_index=1)):
        alone = astroinertia.open(tmp_path / "two" / f"member-{int(member.member):04d}")
        found, own = (part.inertia.gravity_field(degree=4, radius=1e6) for part in (member, alone))
        np.testing.assert_array_equal(found.harmonic_coefficient, own.harmonic_coefficient)
    file = xr.load_dataset(tmp_path / "two" / "core_to_pulsar_scaling.nc").isel(body_index=0)
    file.encoding.pop("source", None)
    with pytest.raises(AbsentError, match="needs snapshots of particles, or a body that keeps its layers"):
        file.inertia.gravity_field()
