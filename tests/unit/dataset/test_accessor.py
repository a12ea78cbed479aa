"""`ds.inertia` lists what it can do; its plots say what they take, and refuse the rest in one sentence."""

import inspect
import json
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from astropy import units as u

from astroinertia import dataset, plots
from astroinertia.bodies.rotating_star import rotating_star_with
from astroinertia.dataset.accessor import InertiaAccessor
from astroinertia.dataset.picture_methods import OPTIONS
from astroinertia.dataset.rotational_share import differential, rotational_share
from astroinertia.errors import AbsentError, AstroinertiaError, SceneError
from astroinertia.matter.barotropes import polytropic_matter
from tests.unit.affine_body import METADATA, affine_run

PUBLIC = [name for name in vars(InertiaAccessor) if not name.startswith("_")]
PLOTS = [name for name in PUBLIC if name.startswith("plot_")]


@pytest.fixture(scope="module")
def ds() -> xr.Dataset:
    records, _ = affine_run(outputs=24, particles=64)
    return dataset.headline({name: np.stack([r[name] for r in records]) for name in records[0]}, METADATA)


def test_what_a_run_does_not_have_is_not_suggested(ds: xr.Dataset) -> None:
    names = ["inertia_tensor", "mass"]
    part = ds[names].assign_attrs(absent=json.dumps({"gw_angular_momentum": "no waves"}))
    with pytest.raises(AbsentError, match="this dataset has no 'angular_momentum'; its data_vars are what it has"):
        part.inertia.spin_rate()


def test_a_repr_lists_all_that_it_can_do_in_a_line_each(ds: xr.Dataset) -> None:
    title, *lines = repr(ds.inertia).splitlines()
    assert title == f"The inertia tensor of {ds.attrs['name']} (model {ds.attrs['model']}), and what follows from it:"
    assert [line.split()[0].strip(".()") for line in lines] == PUBLIC and len(PUBLIC) > 20
    assert all(len(line.split(maxsplit=1)[1]) > 10 for line in lines)
    page = ds.inertia._repr_html_()
    assert page.count("<tr>") == len(PUBLIC) and "n.I.n about an axis: &quot;x&quot;" in page


@pytest.mark.parametrize("name", PLOTS)
def test_what_a_plot_takes_is_in_its_docstring(name: str, ds: xr.Dataset) -> None:
    text = inspect.getdoc(getattr(InertiaAccessor, name)) or ""
    assert all(f"\n{option}: " in text for option in OPTIONS)
    with pytest.raises(SceneError, match=f"{name} has no option 'colour'; it has start, end, size, path"):
        getattr(ds.inertia, name)(colour="red")


def latest(figure: Any) -> float:
    """The last time that a curve of a figure reaches."""
    curves = [line.get_xdata() for axes in figure.axes for line in axes.lines]
    return max(float(np.max(times)) for times in curves if len(times) > 2)


@pytest.mark.slow
def test_times_size_and_path_do_what_they_say(ds: xr.Dataset, tmp_path: Path) -> None:
    times, middle = ds.time.values, float(ds.time[12])
    for start in (middle, middle * u.s, f"{middle!r} s", 1e3 * middle * u.ms):
        assert (
            ds.inertia._between(ds, ds.inertia._time("start", start), None).time.values.tolist() == times[12:].tolist()
        )
    figure = ds.inertia.plot_inertia(end=middle * u.s, size=(6, 4), path=tmp_path / "inertia.svg")
    assert figure.get_size_inches().tolist() == [6.0, 4.0]
    assert "<svg" in (tmp_path / "inertia.svg").read_text()
    share = latest(figure) / latest(ds.inertia.plot_inertia())
    assert share == pytest.approx(middle / times[-1], rel=1e-6)
    plt.close("all")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["inertia", "spin", "attitude", "energy", "shape", "ledger"])
def test_pictures_are_in_the_order_of_time_and_show_a_single_record(name: str, ds: xr.Dataset, tmp_path: Path) -> None:
    forth, back = (getattr(part.inertia, f"plot_{name}")(path=tmp_path / f"{turn}.png")
                   for turn, part in enumerate((ds, ds.isel(time=slice(None, None, -1)))))  # fmt: skip
    for one, other in zip(forth.axes, back.axes, strict=True):
        assert (one.get_xlim(), one.get_ylim()) == (other.get_xlim(), other.get_ylim())
    alone = getattr(ds.isel(time=3).inertia, f"plot_{name}")()
    points = [line for line in alone.axes[0].lines if len(line.get_xdata()) == 1]
    assert points and all(line.get_marker() not in ("", "None", None) for line in points)
    twice = getattr(ds.isel(time=[3, 3]).inertia, f"plot_{name}")()  # as sel(time=..., method="nearest") may give
    assert [axes.get_xlim() for axes in twice.axes] == [axes.get_xlim() for axes in alone.axes]
    plt.close("all")


@pytest.mark.parametrize(
    ("call", "kind", "sentence"),
    [
        (lambda i: i.plot_spin(start="x"), SceneError, "start: 'x' is not a number and a unit"),
        (lambda i: i.plot_spin(start=3 * u.m), SceneError, "start: must be a time, not 3 m"),
        (lambda i: i.plot_spin(end=object()), SceneError, "end must be a time, not something of the type object."),
        (lambda i: i.plot_spin(start=1e9), SceneError, "nothing is recorded from start = 1e+09 to end = inf in the"),
        (lambda i: i.plot_spin(size=3), SceneError, "size must be width and height in inches, not 3."),
        (lambda i: i.plot_spin(size=(3, -1)), SceneError, "size must be width and height in inches, not (3, -1)."),
        (lambda i: i.plot_density(), AbsentError, "this dataset has no snapshots to draw."),
        (lambda i: i.quantity("mas"), AbsentError, "this dataset has no 'mas'; did you mean 'mass'?"),
        (lambda i: i.about_axis("q"), SceneError, 'an axis is "x", "y", "z", "spin" or a vector, not \'q\''),
        (lambda i: i.spin_scaling("mass"), SceneError, 'the scaling laws are "inertia" and "radius", not \'mass\''),
        (lambda i: i.moment_ratio(3 * u.s), SceneError, "radius: must be a length, not 3 s"),
        (lambda i: i.moment_ratio(), SceneError, "InertiaAccessor.moment_ratio: missing a required argument: 'radius'"),
        (lambda i: i.moment_ratio(-1), SceneError, "radius must be positive and finite, not -1"),
        (lambda i: i.moment_ratio(xr.DataArray([7e8, 0.0])), SceneError, "radius must be positive and finite, not 0"),
        (lambda i: i.pattern_speed(7), SceneError, "mode must be one of the orders that are recorded, 1, 2, 3, 4"),
        (lambda i: i.strain("up"), SceneError, "polar_angle: 'up' is not a number and a unit"),
        (lambda i: i.growth_rate("density_max", start=3 * u.kg), SceneError, "start: must be in s, or in units"),
        (lambda i: i.growth_rate("nothing"), AbsentError, "this dataset has no 'nothing'"),
        (lambda i: i.growth_rate("gravitational_energy"), SceneError, "growth as exp(rate t) needs"),
        (lambda i: i.quantity("effect"), SceneError, "effect has no numbers, so that it has no unit."),
        (lambda i: i.about_axis([0, 0, 0]), SceneError, "an axis must have a direction: its components are all 0"),
        (lambda i: i.torque_shares([0, 1]), SceneError, "an axis has three components, not the shape (2,)"),
    ],
)
def test_what_is_wrong_is_one_sentence(call: Any, kind: type, sentence: str, ds: xr.Dataset) -> None:
    with pytest.raises(AstroinertiaError) as caught:
        call(ds.inertia)
    assert isinstance(caught.value, kind) and str(caught.value).startswith(sentence) and "\n" not in str(caught.value)


def test_what_is_given_is_taken_by_its_times_and_not_by_its_order(ds: xr.Dataset) -> None:
    vectors = np.random.default_rng(1).normal(size=(ds.sizes["time"], 3))
    axes = xr.DataArray(vectors, {"time": ds.time, "i": ds.i}, ("time", "i"))
    sizes = axes.sel(i="x", drop=True) ** 2 + 1.0
    about, ratio = ds.inertia.about_axis(axes), ds.inertia.moment_ratio(sizes)
    np.testing.assert_allclose(about, ds.inertia.about_axis(vectors), rtol=1e-15)
    back, part = slice(None, None, -1), slice(5, 9)
    xr.testing.assert_identical(ds.inertia.about_axis(axes[back]), about)
    xr.testing.assert_identical(ds.inertia.moment_ratio(sizes[back]), ratio)
    xr.testing.assert_identical(ds.isel(time=part).inertia.about_axis(axes), about.isel(time=part))
    xr.testing.assert_identical(ds.isel(time=part).inertia.moment_ratio(sizes), ratio.isel(time=part))
    for call in (lambda: ds.inertia.about_axis(axes[part]), lambda: ds.inertia.moment_ratio(sizes[part])):
        with pytest.raises(SceneError, match=r"what is given along time has no value at 0[.]0, which the dataset has"):
            call()


def test_times_in_another_unit_are_refused(ds: xr.Dataset) -> None:
    """A rate per millisecond would be called one per second."""
    known = float(ds.inertia.growth_rate("density_max").rate)
    milliseconds = ds.assign_coords(time=(1e3 * ds.time).assign_attrs(units="ms"))
    for call in (lambda: milliseconds.inertia, lambda: ds.inertia.growth_rate(milliseconds.density_max)):
        with pytest.raises(ValueError, match="the times are in ms; the accessor takes seconds or timedelta64"):
            call()
    exact = ds.assign_coords(time=(1e9 * ds.time).astype("timedelta64[ns]"))
    for found in (exact.inertia.growth_rate("density_max"), ds.inertia.growth_rate(exact.density_max)):
        assert float(found.rate) == pytest.approx(known, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("part", "sentence"),
    [
        (lambda ds: ds[["inertia_tensor"]].inertia.principal, "this dataset has no 'principal_moments'"),
        (lambda ds: ds.drop_vars("mean_radius").inertia.rotation_limits(), "this dataset has no 'mean_radius'"),
        (lambda ds: ds.drop_vars("mode_phase").inertia.pattern_speed(), "this dataset has no 'mode_phase'"),
        (lambda ds: ds.drop_attrs(deep=False).inertia.rotation_limits(), "this dataset has lost its attribute"),
        (lambda ds: ds.drop_attrs().inertia.strain(0.0), "this dataset has lost its attribute gravitational_constant"),
        (lambda ds: ds.rename(i="axis").inertia, "inertia_tensor has no dimension i: components are along i and j"),
        (lambda ds: ds.assign_coords(n=("time", np.arange(ds.sizes["time"]))).swap_dims(time="n").inertia,
         "the times are along n; the accessor takes records along time"),
        (lambda ds: ds.max("time", keepdims=True, keep_attrs=True).inertia,
         "the dataset has no times: those of its records have been lost, and ds.assign_coords(time=...) has them"),
        (lambda ds: ds.where(ds.effect == ds.effect[0]).inertia, "inertia_tensor is along effect, too"),
        (lambda ds: ds.isel(time=[]).inertia.gravity_field(2), "nothing is recorded in this dataset"),
        (lambda ds: ds.inertia.quantity(3), "a series is a name or a DataArray, not something of the type int."),
        (lambda ds: ds.inertia.growth_rate("effect"), "effect does not vary along time."),
        (lambda ds: ds.inertia.moment_ratio(ds.mass), "radius: must be a length, not an array in kg"),
    ],
)  # fmt: skip
def test_what_a_dataset_has_lost_is_named(part: Any, sentence: str, ds: xr.Dataset) -> None:
    with pytest.raises((AstroinertiaError, ValueError)) as caught:
        part(ds)
    assert str(caught.value).startswith(sentence) and "\n" not in str(caught.value)
    bare = ds.drop_attrs().inertia
    assert bare.about_axis().attrs["units"] == bare.quadrupole.attrs["units"] == "1"
    unnamed = ds.drop_attrs().assign_attrs(ds.attrs).inertia.strain(0.3)  # in SI, though no unit says so
    np.testing.assert_array_equal(unnamed.plus, ds.inertia.strain(0.3).plus)


@pytest.mark.slow
@pytest.mark.parametrize("law", ["inertia", "radius"])
def test_the_start_is_the_earliest_record_that_is_there(law: str, ds: xr.Dataset) -> None:
    """Records in any order, and after a mask; a spin that turns round is negative from then on."""
    signs = np.where(np.arange(ds.sizes["time"]) < 12, 1.0, -1.0)
    momentum = ds.angular_momentum.copy(data=np.outer(signs, [3.0, 0.0, 4.0]) * 1e48)
    ds = ds.assign(angular_momentum=momentum)
    back = ds.isel(time=slice(None, None, -1))
    xr.testing.assert_allclose(back.inertia.spin_scaling(law).sortby("time"), ds.inertia.spin_scaling(law), rtol=1e-14)
    assert (np.sign(ds.inertia.spin_rate()) == signs).all() and (
        back.inertia.spin_rate() == ds.inertia.spin_rate()
    ).all()
    masked = ds.where(ds.time >= ds.time[3]).inertia.spin_rate()
    np.testing.assert_allclose(masked[3:], ds.inertia.spin_rate()[3:], rtol=1e-14)


def test_single_precision_is_taken_where_it_holds_the_numbers(ds: xr.Dataset) -> None:
    """Moments of a star in SI are beyond it, and were NaN without a word."""
    with np.errstate(over="ignore"):
        star = ds.astype("float32")
    with pytest.raises(
        ValueError, match=r"^angular_momentum is infinite in float32, which ends at 3.4e\+38: keep float64$"
    ):
        assert star.inertia
    small = ds[["inertia_tensor"]] / 1e30
    np.testing.assert_allclose(small.astype("float32").inertia.about_axis(), small.inertia.about_axis(), rtol=1e-6)


def test_quantities_are_numbers_in_the_unit_of_the_dataset(ds: xr.Dataset) -> None:
    np.testing.assert_allclose(ds.inertia.moment_ratio(7e5 * u.km), ds.inertia.moment_ratio(7e8), rtol=1e-14)
    xr.testing.assert_allclose(ds.inertia.strain(90 * u.deg, "0 deg"), ds.inertia.strain(np.pi / 2, 0.0), rtol=1e-14)


def test_the_mean_angular_velocity_of_a_body_whose_axis_moves_is_its_size(ds: xr.Dataset) -> None:
    """The axis of a top goes round a cone: along where it was first, its spin would change its sign."""
    assert ds.inertia.spin_rate().attrs["long_name"] == "mean angular velocity about the axis of the angular momentum"
    angle = np.linspace(0.0, np.pi, ds.sizes["time"])
    axis = np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=1)
    size = 2.0 + angle
    sizes = {"angular_velocity": 1.0, "angular_momentum": float(np.linalg.norm(ds.angular_momentum[0]))}
    vectors = {name: scale * size[:, None] * axis for name, scale in sizes.items()}
    top = ds.assign({name: (("time", "i"), vector, ds[name].attrs) for name, vector in vectors.items()})
    rate = top.inertia.spin_rate()
    np.testing.assert_allclose(rate, size, rtol=1e-14)
    assert "whose axis moves" in rate.attrs["long_name"] and "whose axis moves" in plots.summary(top)
    # An axis that precesses a little takes its spin along: along where it was first, that would seem to fall.
    little = 0.03 * angle / np.pi
    axis = np.stack([np.sin(little), np.zeros_like(little), np.cos(little)], axis=1)
    momentum = sizes["angular_momentum"] * axis
    inertia = np.broadcast_to(np.diag([1.0, 1.0, 2.0]), (len(angle), 3, 3))
    turned = {"angular_momentum": (("time", "i"), momentum), "inertia_tensor": (("time", "i", "j"), inertia)}
    planet = ds.assign({name: (*made, ds[name].attrs) for name, made in turned.items()})
    along = np.einsum("ti,tij,tj->t", axis, inertia, axis)
    np.testing.assert_allclose(planet.inertia.spin_rate(), sizes["angular_momentum"] / along, rtol=1e-14)
    np.testing.assert_allclose(planet.inertia.spin_scaling(), planet.inertia.spin_rate(), rtol=1e-14)
    # A torque that stops a spin and turns it back leaves the axis where it was: there the sign says something.
    vectors = {name: scale * np.outer(np.cos(angle), [0.0, 0.0, 1.0]) for name, scale in sizes.items()}
    back = ds.assign({name: (("time", "i"), vector, ds[name].attrs) for name, vector in vectors.items()})
    assert back.inertia.spin_rate()[0] > 0.0 > back.inertia.spin_rate()[-1]


@pytest.mark.slow
@pytest.mark.parametrize("asked", [0.3, 0.8, 0.97])
def test_a_star_that_turns_so_fast_is_said_to_turn_so_fast(ds: xr.Dataset, asked: float) -> None:
    """The exact star of 80 % of break-up has that fraction by its equator and J2, and sheds no mass."""
    star = rotating_star_with("breakup_fraction", asked, polytropic_matter(1.5), mass=2e30, equatorial_radius=7e8,
                              gravitational_constant=ds.attrs["gravitational_constant"])  # fmt: skip
    second = (star.polar_moment - star.equatorial_moment) / (star.mass * star.mean_radius**2)
    series = {
        "mass": star.mass, "surface_equatorial_radius": star.equatorial_radius, "zonal_harmonic_2": second,
        "surface_mean_radius": star.mean_radius, "rotational_to_gravitational": star.rotational_to_gravitational,
    }  # fmt: skip
    turning = ds.assign({name: xr.full_like(ds[name], value) for name, value in series.items()})
    turning["angular_velocity"] = xr.zeros_like(ds["angular_velocity"]) + xr.DataArray(
        [0.0, 0.0, star.angular_velocity], dims="i"
    )
    turning["zonal_harmonic_2"].attrs["radius"] = "surface_mean_radius"
    limits = turning.inertia.rotation_limits()
    np.testing.assert_allclose(limits.breakup_fraction, asked, rtol=0.012)
    orbit = np.sqrt(ds.attrs["gravitational_constant"] * star.mass / star.mean_radius**3)
    np.testing.assert_allclose(limits.period, 2 * np.pi / star.angular_velocity, rtol=1e-14)
    np.testing.assert_allclose(limits.kepler_period, 2 * np.pi / orbit, rtol=1e-14)
    np.testing.assert_allclose(limits.kepler_fraction, star.angular_velocity / orbit, rtol=1e-14)
    assert not limits.sheds_mass.any()
    assert np.isinf(
        turning.assign(angular_velocity=0 * turning["angular_velocity"]).inertia.rotation_limits().period
    ).all()
    faster = turning.assign(angular_velocity=turning["angular_velocity"] * 1.02 / asked)
    assert faster.assign_attrs(model="sph").inertia.rotation_limits().sheds_mass.all()


def test_a_core_that_turns_faster_than_the_rest_counts_in_the_energy_of_rotation(ds: xr.Dataset) -> None:
    """Halves of the mass with moments 1 and 100 and rates 90 and 1: T = (1 * 90^2 + 100 * 1)/2, L = 190, I = 101."""
    count = ds.sizes["time"]
    moments, rates = np.array([1.0, 100.0]), np.array([90.0, 1.0])
    mean = (moments @ rates) ** 2 / moments.sum() / 2
    shells = (("time", "radius_bin"), np.tile(rates, (count, 1)), ds["rotation_profile"].attrs)
    momenta = (("time", "radius_bin"), np.tile(moments * rates / (0.5 * 3.0), (count, 1)))
    kept = ds.drop_dims("radius_bin")
    other = {"mass": 3.0, "gravitational_energy": -1e4, "rotational_to_gravitational": mean / 1e4}
    turning = kept.assign({name: xr.full_like(ds[name], value) for name, value in other.items()})
    assert not turning.inertia.rotation_limits().dynamically_unstable.any()  # nothing is known of its shells
    turning = turning.assign(rotation_profile=shells, specific_angular_momentum_profile=momenta)
    np.testing.assert_allclose(rotational_share(turning), (moments @ rates**2) / 2 / 1e4, rtol=1e-14)
    assert turning.inertia.rotation_limits().dynamically_unstable.all()
    summary = {line.split("  ")[0]: line.split()[-4:] for line in plots.summary(turning).splitlines()}
    assert summary["T/|W|"] == ["0.41"] * 4
    across = turning.assign(rotation_profile=0.0 * turning["rotation_profile"])  # about another axis than z
    np.testing.assert_allclose(rotational_share(across), mean / 1e4, rtol=1e-14)
    # Both are shown from where they differ by a hundredth of the largest, and only where the shells have more.
    most, shells = 0.2, np.array([0.1, 0.2])
    assert not differential(shells, shells - [0.0, 0.0099 * most]) and differential(shells, shells - [0.0101 * most, 0])
    assert not differential(shells, 2.0 * shells)


def test_axes_that_move_have_directions_and_no_lengths(ds: xr.Dataset) -> None:
    """However they are given: a vector, one for each time as an array, a list or a series, of any length."""
    count = ds.sizes["time"]
    generator = np.random.default_rng(1)
    moving = generator.normal(size=(count, 3))
    series = xr.DataArray(3.0 * moving, dims=("time", "i"), coords={"i": list("xyz")})
    for method in ("about_axis", "acceleration_shares", "torque_shares"):
        asked = getattr(ds.inertia, method)
        np.testing.assert_allclose(asked([0.0, 0.0, 2.0]), asked("z"), rtol=1e-14)
        np.testing.assert_allclose(asked(np.tile([0.0, 0.0, 7.0], (count, 1))), asked("z"), rtol=1e-14)
        one_by_one = [asked(list(axis)).isel(time=k).values for k, axis in enumerate(moving)]
        for given in (moving, moving.tolist(), series, series.sel(i=["z", "x", "y"])):
            np.testing.assert_allclose(asked(given).values, one_by_one, rtol=1e-12)


def test_the_order_of_components_is_that_of_their_labels(ds: xr.Dataset) -> None:
    turned = ds.sel(i=["z", "x", "y"], j=["y", "z", "x"])
    for ask in (
        lambda i: i.about_axis("z"),
        lambda i: i.torque_shares("x"),
        lambda i: i.strain(0.4, 0.3).plus,
        lambda i: i.spin_rate(),
    ):
        np.testing.assert_allclose(ask(turned.inertia), ask(ds.inertia), rtol=1e-13)
    with pytest.raises(ValueError, match="vectors and tensors must be whole: along i there is x, y"):
        _ = ds.sel(i=["x", "y"]).inertia


def test_one_time_and_one_effect_can_be_chosen(ds: xr.Dataset) -> None:
    last = ds.isel(time=-1).inertia
    np.testing.assert_array_equal(last.about_axis("z"), ds.inertia.about_axis("z")[-1:])
    np.testing.assert_array_equal(last.acceleration_shares("x"), ds.inertia.acceleration_shares("x")[-1:])
    pulled = ds.sel(effect="gravity").inertia
    np.testing.assert_array_equal(pulled.virial_shares()[:, 1], ds.inertia.virial_shares().sel(share="gravity"))
    xr.testing.assert_identical(pulled.strain(0.4, 0.3), ds.inertia.strain(0.4, 0.3))  # of the whole body
    with pytest.raises(ValueError, match="the dataset has no times"):
        _ = ds.mean("time").inertia
    with pytest.raises(ValueError, match="vectors and tensors must be whole: along i there is z alone"):
        _ = ds.sel(i="z", j="z").inertia


def test_a_body_that_begins_at_rest_has_no_law_of_its_spin(ds: xr.Dataset) -> None:
    """Its angular momentum at first is round-off, of which a law would make predictions."""
    momentum, mixed = ds["angular_momentum"].copy(), ds["mixed_moment"].copy()
    spread = np.sqrt(np.trace(ds["second_moment"].values[0]) * np.trace(ds["kinetic_tensor"].values[0]))
    momentum[0], mixed[0] = 1e-16 * spread * np.array([0.0, 0.3, -1.0]), 0.0
    spun = ds.assign(angular_momentum=momentum, mixed_moment=mixed)
    for law in ("inertia", "radius"):
        assert not spun.inertia.spin_scaling(law).any()
        assert (ds.inertia.spin_scaling(law) > 0).all()
    said = plots.summary(spun)
    assert "mean angular velocity" in said and "if it went as" not in said and "if it went as" in plots.summary(ds)
    assert len(spun.inertia.plot_spin().axes) == len(ds.inertia.plot_spin().axes) - 1  # no panel of ratios
    plt.close("all")


def test_an_axis_has_a_direction_and_is_there(ds: xr.Dataset) -> None:
    with pytest.raises(ValueError, match="an axis must have a direction"):
        ds.inertia.about_axis([0.0, np.inf, 0.0])
    with pytest.raises(AbsentError, match=r"^this dataset has no 'spin_axis'"):
        ds[["inertia_tensor", "mass"]].inertia.about_axis("spin")


def test_a_radius_is_in_the_unit_that_it_says(ds: xr.Dataset) -> None:
    radius = ds["mean_radius"] / 1e3
    found = ds.inertia.moment_ratio(radius.assign_attrs(units="km"))
    np.testing.assert_allclose(found, ds.inertia.moment_ratio(ds["mean_radius"]), rtol=1e-14)
    with pytest.raises(AstroinertiaError, match="must be a length"):
        ds.inertia.moment_ratio(radius.assign_attrs(units="kg"))


def test_in_a_rotating_frame_nothing_is_said_of_waves_and_break_up() -> None:
    """A body that rests in such a frame turns with it: its own rates say nothing of either."""
    records, _ = affine_run(outputs=24, particles=64)
    series = {name: np.stack([record[name] for record in records]) for name in records[0]}
    turning = dataset.headline(series, METADATA | {"frame": "rotating with the scene's rotating_frame"})
    rates = ("angular_velocity", "figure_rotation_rate", "mode_pattern_speed", "bar_pattern_speed", "rotation_profile")
    for name in (*rates, "rotational_to_gravitational", "momentum", "kinetic_tensor"):
        assert turning[name].attrs["comment"].endswith("relative to the rotating frame"), name
    for ask in (lambda i: i.strain(0.0), lambda i: i.rotation_limits()):
        with pytest.raises(AbsentError, match="follow from rates in an inertial frame, and that of"):
            ask(turning.inertia)
    assert "relative to the rotating frame" in plots.summary(turning)


def test_the_reference_radius_is_in_the_unit_of_the_dataset(ds: xr.Dataset) -> None:
    assert ds.attrs["reference_radius"] == METADATA["code_units"]["length"]


def test_times_that_can_be_resampled_are_seconds_to_the_accessor(ds: xr.Dataset) -> None:
    times = (1e9 * ds.time.values / ds.time.values[-1]).astype("timedelta64[ns]")
    resampled = ds.assign_coords(time=times)
    assert resampled.inertia.spin_rate().time.values[-1] == pytest.approx(1.0)
    rate = resampled.inertia.growth_rate("density_max").rate
    assert float(rate) == pytest.approx(
        ds.inertia.growth_rate("density_max").rate.item() * ds.time.values[-1], rel=1e-6
    )
    resampled.inertia.plot_inertia()
    plt.close("all")
    with pytest.raises(ValueError, match="the times are dates"):
        _ = ds.assign_coords(time=times + np.datetime64("2000-01-01")).inertia


def test_variables_that_were_converted_are_refused(ds: xr.Dataset) -> None:
    def stating(unit: str) -> xr.Dataset:
        tensor = ds["inertia_tensor"]
        return ds.assign(inertia_tensor=tensor.assign_attrs(tensor.attrs | {"units": unit}))

    with pytest.raises(ValueError, match="inertia_tensor is in g cm2; the accessor takes datasets in their own units"):
        _ = stating("g cm2").inertia
    assert stating("m2 kg").inertia.spin_rate().size
    with pytest.raises(AbsentError, match="this dataset has no 'mass'"):
        ds[["inertia_tensor"]].inertia.radius_of_gyration()


def test_records_that_were_masked_spoil_no_others(ds: xr.Dataset) -> None:
    masked = ds.where(ds.time > ds.time[3])
    for whole, part in (
        (ds.inertia.rotation_limits(), masked.inertia.rotation_limits()),
        (ds.inertia.spin_scaling().to_dataset(name="spin"), masked.inertia.spin_scaling().to_dataset(name="spin")),
    ):
        for name, values in part.items():
            if values.dtype.kind == "f" and not whole[name].isnull().all():
                assert values[4:].notnull().all(), name
                assert values[:4].isnull().all(), name
