"""`ds.inertia.principal`: as recorded, and of a tensor that has taken the place of the recorded one."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from astroinertia import dataset
from astroinertia.dataset.principal import NAMES
from tests.unit.affine_body import METADATA, affine_run


@pytest.fixture(scope="module")
def ds() -> xr.Dataset:
    records, _ = affine_run(outputs=24, particles=64)
    return dataset.headline({name: np.stack([r[name] for r in records]) for name in records[0]}, METADATA)


@pytest.mark.parametrize("part", [lambda ds: ds, lambda ds: ds.isel(time=slice(5, 9)), lambda ds: ds.transpose()])
def test_what_is_recorded_is_given_as_it_is(part: Any, ds: xr.Dataset) -> None:
    shown = part(ds)
    found = shown.inertia.principal
    for name in NAMES:
        np.testing.assert_array_equal(*(each[name].transpose("time", ...) for each in (found, shown)))


def test_another_tensor_has_its_own_moments_and_axes(ds: xr.Dataset) -> None:
    """Of the sum with a shell, the moments are larger by its own; of a body turned over, the axes are others."""
    shell = 0.4 * float(np.trace(ds.inertia_tensor[0]))
    both = ds.assign(inertia_tensor=ds.inertia_tensor + xr.DataArray(shell * np.eye(3), dims=("i", "j")))
    found = both.inertia.principal
    np.testing.assert_allclose(found.principal_moments, ds.principal_moments + shell, rtol=1e-12)
    np.testing.assert_allclose(found.principal_axes, ds.principal_axes, atol=1e-9)
    assert found.principal_moments.attrs == ds.principal_moments.attrs
    assert np.isnan(found.figure_rotation_rate).all() and "in whose place" in found.figure_rotation_rate.attrs["reason"]
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turned = ds.assign(inertia_tensor=ds.inertia_tensor.copy(data=quarter @ ds.inertia_tensor.values @ quarter.T))
    found = turned.inertia.principal
    np.testing.assert_allclose(found.principal_moments, ds.principal_moments, rtol=1e-12)
    axes, moments = found.principal_axes.values, found.principal_moments.values
    back = np.einsum("tki,tk,tkj->tij", axes, moments, axes)
    np.testing.assert_allclose(back, turned.inertia_tensor, atol=1e-12 * moments.max())


def test_members_of_a_sweep_have_each_its_own(ds: xr.Dataset) -> None:
    sweep = xr.concat([ds, ds], dim="member")
    np.testing.assert_array_equal(sweep.inertia.principal.principal_axes[1], ds.principal_axes)
    factors = xr.DataArray([1.0, 3.0], dims="member")
    found = sweep.assign(inertia_tensor=factors * sweep.inertia_tensor).inertia.principal
    np.testing.assert_allclose(found.principal_moments[1], 3.0 * ds.principal_moments, rtol=1e-12)
    np.testing.assert_array_equal(found.figure_rotation_rate[0], ds.figure_rotation_rate)
