"""`ds.inertia` on a sweep: for each member what it says of that member alone, NaN where there is none."""

import numpy as np
import pytest
import xarray as xr

import astroinertia
from astroinertia.errors import AbsentError, SceneError
from astroinertia.scene.load import load_file
from tests.sims import SIMS

SETTINGS = ["time.end='2 s'", "output.series_every='0.5 s'"]
ANSWERS = {
    "about_axis": lambda inertia: inertia.about_axis([1.0, 2.0, 2.0]),
    "about_spin": lambda inertia: inertia.about_axis("spin"),
    "radius_of_gyration": lambda inertia: inertia.radius_of_gyration(),
    "moment_ratio": lambda inertia: inertia.moment_ratio(2.0),
    "quadrupole": lambda inertia: inertia.quadrupole,
    "acceleration_shares": lambda inertia: inertia.acceleration_shares(),
    "virial_shares": lambda inertia: inertia.virial_shares(),
    "torque_shares": lambda inertia: inertia.torque_shares("x"),
    "spin_rate": lambda inertia: inertia.spin_rate(),
    "spin_scaling": lambda inertia: inertia.spin_scaling(),
    "strain": lambda inertia: inertia.strain(0.3, 0.2).plus,
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Three tops that turn differently, the second of which ends early; then one that failed."""
    place = tmp_path_factory.mktemp("tops")
    ends = {"0": "2 s", "1": "1 s", "2": "2 s"}
    return [
        astroinertia.open(
            astroinertia.run_scene(
                load_file(SIMS / "tennis_racket.toml", [*SETTINGS, f"time.end='{end}'", f"name='top{number}'"]),
                place / number,
            )
        )
        for number, end in ends.items()
    ]


@pytest.fixture(scope="module")
def sweep(runs):
    series = ["inertia_tensor", "second_moment", "kinetic_tensor", "virial_tensor", "torque", "mass", "spin_axis"]
    series += ["angular_momentum", "principal_moments", "mean_radius", "inertia_acceleration"]
    parts = [run[series] for run in runs]
    parts.append(xr.full_like(parts[0], np.nan))
    return xr.concat(parts, "member", join="outer", coords="minimal", compat="override").assign_coords(
        member=range(4), body_mass=("member", [1.0, 2.0, 3.0, 4.0])
    )


def test_a_sweep_of_the_tensor_alone_is_asked_for_its_moments(sweep):
    part = sweep[["inertia_tensor"]]
    xr.testing.assert_identical(part.inertia.about_axis(), sweep.inertia.about_axis())
    xr.testing.assert_identical(part.inertia.quadrupole, sweep.inertia.quadrupole)
    with pytest.raises(AbsentError, match="this dataset has no 'mass'"):
        part.inertia.radius_of_gyration()


@pytest.mark.parametrize("name", ANSWERS)
def test_every_member_has_its_own_answer(name, runs, sweep):
    found = ANSWERS[name](sweep.inertia)
    assert found.dims[:2] == ("member", "time") and found["body_mass"].dims == ("member",)
    for number, run in enumerate(runs):
        alone = ANSWERS[name](run.inertia)
        of_member = found.isel(member=number)
        np.testing.assert_array_equal(of_member.isel(time=slice(0, run.sizes["time"])), alone)
        assert np.isnan(of_member.isel(time=slice(run.sizes["time"], None))).all()
    assert np.isnan(found.isel(member=3)).all()
    assert found.attrs == ANSWERS[name](runs[0].inertia).attrs


def test_arguments_may_differ_from_member_to_member(runs, sweep):
    ratio = sweep.inertia.moment_ratio(xr.DataArray([1.0, 2.0, 3.0, 4.0], dims="member"))
    np.testing.assert_array_equal(ratio.isel(member=2), runs[2].inertia.moment_ratio(3.0))
    along = sweep.inertia.about_axis(sweep["spin_axis"])
    np.testing.assert_array_equal(along.isel(member=0), runs[0].inertia.about_axis("spin"))
    turned = xr.DataArray([4.0, 3.0, 2.0, 1.0], {"member": [3, 2, 1, 0]}, ("member",))
    xr.testing.assert_identical(sweep.inertia.moment_ratio(turned), ratio)
    with pytest.raises(SceneError, match="what is given along member has no value at 1, which the dataset has"):
        sweep.inertia.moment_ratio(turned.sel(member=[0, 2, 3]))


def test_pictures_are_of_one_member(sweep):
    with pytest.raises(ValueError, match=r"of one member of a sweep: take one, such as ds.isel\(member=0\).inertia"):
        sweep.inertia.plot_inertia()
    later = sweep.isel(member=[3, 1])  # the one without a result is not the one to take
    with pytest.raises(ValueError, match=r"take one, such as ds.isel\(member=1\).inertia"):
        later.inertia.plot_inertia()
    noted = sweep.assign_coords(failure=("member", ["", "", "", "the body sheds mass."]))
    with pytest.raises(AbsentError, match=r"this member of the sweep has no result: the body sheds mass\.$"):
        noted.isel(member=3).inertia.plot_inertia()
    with pytest.raises(AbsentError, match=r"has no result: the body sheds mass\.$"):
        noted.isel(member=3).inertia.spin_rate()
    assert sweep.inertia.snapshots is None
    with pytest.raises(ValueError, match="no member of this sweep has records"):
        sweep.isel(member=[3]).inertia.spin_rate()


def test_a_spin_means_the_same_in_every_member(runs):
    """A member whose axis has not gone far yet is compared with one whose axis has: both by the size of the spin."""
    series = ["inertia_tensor", "second_moment", "kinetic_tensor", "mass", "angular_momentum", "angular_velocity"]
    angle = np.linspace(0.0, 3.0, runs[2].sizes["time"])
    moved = runs[2][series].copy(deep=True)
    moved["angular_momentum"].values[:] = np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)
    short = moved.isel(time=slice(0, 1))
    assert moved.inertia.axis_moves() and not short.inertia.axis_moves()
    both = xr.concat([short, moved], "member", join="outer", coords="minimal", compat="override").inertia
    assert both.axis_moves()
    rates = both.spin_rate()
    assert "whose axis moves" in rates.attrs["long_name"]
    np.testing.assert_array_equal(rates.isel(member=0, time=0), rates.isel(member=1, time=0))
    np.testing.assert_array_equal(rates.isel(member=0, time=slice(0, 1)), short.inertia.spin_rate(as_size=True))


@pytest.mark.parametrize("name", ["spin_rate", "axis_moves", "rotation_limits"])
def test_of_no_times_nothing_is_said(name, runs):
    with pytest.raises(SceneError, match="nothing is recorded in this dataset"):
        getattr(runs[0].isel(time=slice(0, 0)).inertia, name)()
