"""Series of datasets as arguments: by the names and labels of their dimensions, not by place."""

import numpy as np
import pytest
import xarray as xr

from astroinertia.inertia import realise, rolling, spin, tensor
from astroinertia.inertia.principal import principal_moments
from astroinertia.process.quantities import InputError
from astroinertia.rotation import attitude, pulsars


@pytest.mark.parametrize("unit", ["kg m2", "g cm2"])
def test_a_series_with_any_order_of_dimensions_has_components_last_in_any_unit(unit: str) -> None:
    scale = {"kg m2": 1.0, "g cm2": 1e7}[unit]
    tensors = scale * np.array([np.diag([1.0, 2, 3]), np.diag([2.0, 3, 5]), np.diag([3.0, 4, 6])])
    series = xr.DataArray(tensors, dims=("time", "i", "j"), attrs={"units": unit}).transpose("i", "j", "time")
    np.testing.assert_allclose(principal_moments(series), [[1, 2, 3], [2, 3, 5], [3, 4, 6]])
    rates = xr.DataArray(np.eye(3), dims=("time", "i"), attrs={"units": "rad s-1"}).transpose("i", "time")
    np.testing.assert_allclose(spin.rotational_energy(series, rates), [0.5, 1.5, 3.0])


def test_masses_and_velocities_go_by_their_dimensions_not_by_place() -> None:
    random = np.random.default_rng(3)
    mass, x, v = random.uniform(1, 2, (4, 4)), random.normal(size=(4, 4, 3)), random.normal(size=(4, 4, 3))
    dims = ("time", "particle", "i")
    position = xr.DataArray(x, dims=dims)
    masses = xr.DataArray(mass, dims=dims[:2]).transpose()
    velocity = xr.DataArray(v, dims=dims).transpose("i", "particle", "time")
    np.testing.assert_allclose(tensor.inertia_tensor(masses, position), tensor.inertia_tensor(mass, x), rtol=1e-15)
    np.testing.assert_allclose(
        spin.angular_momentum(masses, position, velocity), spin.angular_momentum(mass, x, v), rtol=1e-15
    )


def test_series_of_other_times_do_not_go_together_and_axes_go_by_their_labels() -> None:
    axes = ["x", "y", "z"]
    at = {"time": [0.0, 1.0, 2.0], "i": axes}
    tensors = xr.DataArray(
        np.array([np.diag([1.0, 2, 3]), np.diag([2.0, 3, 5]), np.diag([3.0, 4, 6])]), dims=("time", "i", "j"),
        coords=at | {"j": axes},
    )  # fmt: skip
    rates = xr.DataArray(np.eye(3), dims=("time", "i"), coords=at)
    energies = spin.rotational_energy(tensors, rates)
    np.testing.assert_allclose(spin.rotational_energy(tensors[..., ::-1], rates[:, [2, 0, 1]]), energies)
    with pytest.raises(InputError, match="inertia and angular_velocity have different values of time"):
        spin.rotational_energy(tensors.isel(time=[0, 1]), rates.isel(time=[1, 2]))


def test_one_value_of_a_dataset_is_a_number_to_functions_of_arrays() -> None:
    mass = xr.DataArray(np.array([2.0, 3.0]), dims="time", attrs={"units": "kg"}).isel(time=0)
    inertia = xr.DataArray(np.diag([1.0, 1.2, 1.5]), dims=("i", "j"), attrs={"units": "kg m2"})
    found, plain = (realise.point_masses(*given) for given in ((inertia, mass), (inertia.values, 2.0)))
    for one, other in zip(found, plain, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-15)


@pytest.mark.parametrize("dims", [("time", "row", "column"), ("dim_0", "dim_1", "dim_2")])
def test_series_of_tensors_go_by_place_where_their_dimensions_have_names_of_their_own(dims: tuple[str, ...]) -> None:
    """Products of labelled arrays sum over all dimensions of one name, which are here those of both factors."""
    turns = np.array([np.eye(3), [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])
    tensors = np.array([np.diag([1.0, 2, 3]) + 0.1, np.diag([2.0, 3, 5]) - 0.2])
    vectors = np.array([[1.0, 2, 3], [3.0, 1, 2]])
    inertia, axes = (xr.DataArray(values, dims=dims) for values in (tensors, turns))
    rates = xr.DataArray(vectors, dims=dims[:2])
    calls = {
        tensor.rotated: ((inertia, axes), (tensors, turns)),
        tensor.moment_about: ((inertia, rates), (tensors, vectors)),
        spin.angular_velocity: ((inertia, rates), (tensors, vectors)),
        spin.rotational_energy: ((inertia, rates), (tensors, vectors)),
        spin.bearing_torque: ((tensors, rates), (tensors, vectors)),
        attitude.attitude_rate: ((axes, rates), (turns, vectors)),
        attitude.euler_angles: ((axes,), (turns,)),
    }
    for function, (series, plain) in calls.items():
        np.testing.assert_array_equal(function(*series), function(*plain), err_msg=function.__name__)


def test_series_of_numbers_keep_their_labels() -> None:
    rates = xr.DataArray([100.0, 200.0], {"time": [0.0, 1.0]}, "time")
    assert rolling.spinning_disc_stress(7800.0, 0.5, rates).dims == ("time",)
    with pytest.raises(InputError, match="radius and rate have different values of time"):
        rolling.spinning_disc_stress(7800.0, rates.assign_coords(time=[1.0, 2.0]), rates)


@pytest.mark.parametrize("unit", [{"units": "s"}, {}])
def test_what_is_computed_from_series_has_neither_their_units_nor_their_names(unit: dict[str, str]) -> None:
    """An age is no number without a unit because a rate of change is."""
    pulsars_of = {"pulsar": ["a", "b"]}
    period = xr.DataArray([2e-3, 5e-3], pulsars_of, name="period", attrs=unit | {"long_name": "period"})
    slope = xr.DataArray([1e-20, 3e-20], pulsars_of, name="slope", attrs={"units": "1", "long_name": "slope"})
    age = pulsars.characteristic_age(period, slope)
    np.testing.assert_allclose(age, [1e17, 5e17 / 6.0], rtol=1e-14)
    assert (age.attrs, age.name, age.pulsar.values.tolist()) == ({}, None, ["a", "b"])
    assert (slope.name, slope.attrs["units"]) == ("slope", "1")
