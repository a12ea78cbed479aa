"""Variables with their units, along dimensions and from the rows of a table."""

import numpy as np
import xarray as xr

from astroinertia.dataset.variables import of_rows, variables


def test_variables_have_their_dimensions_units_and_names() -> None:
    columns = {"mass": (np.ones((2, 3)), "kg", "mass of each"), "count": (np.arange(6).reshape(2, 3), "1", "how many")}
    dataset = xr.Dataset(variables(("time", "body"), columns))
    assert dataset["mass"].dims == dataset["count"].dims == ("time", "body")
    assert dataset["mass"].attrs == {"units": "kg", "long_name": "mass of each"}
    np.testing.assert_array_equal(dataset["count"], np.arange(6).reshape(2, 3))


def test_a_number_has_no_dimension() -> None:
    number = xr.Dataset(variables((), {"rate": (0.5, "s-1", "rate")}))["rate"]
    assert number.dims == ()
    assert float(number) == 0.5


def test_columns_of_rows_are_in_the_order_of_the_rows_and_only_those_that_have_heads() -> None:
    rows = ({"name": name, "radius": radius, "note": ""} for name, radius in (("Io", 1.8e6), ("Europa", 1.6e6)))
    dataset = xr.Dataset(of_rows("moon", rows, {"radius": ("m", "mean radius"), "name": ("", "which")}))
    assert set(dataset.data_vars) == {"radius", "name"}
    assert dataset["radius"].values.tolist() == [1.8e6, 1.6e6]
    assert dataset["name"].values.tolist() == ["Io", "Europa"]
    assert dataset["radius"].attrs == {"units": "m", "long_name": "mean radius"}
