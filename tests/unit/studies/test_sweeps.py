"""Sweeps over parameters: what each member is, in which order, with dask and without."""

import numpy as np
import pytest

from astroinertia.errors import SceneError
from astroinertia.studies.sweeps import Model, sweep

AREA = Model(
    lambda width, height, offset=0.0: {"area": width * height + offset, "half": width / 2},
    {"width": ("m", "width"), "height": ("m", "height"), "offset": ("m2", "offset")},
    {"area": ("m2", "area"), "half": ("m", "half the width")},
)


def test_a_sweep_has_every_combination_in_named_dimensions():
    found = sweep(AREA, {"width": [1.0, 2.0, 3.0], "height": np.linspace(0, 1, 5)}, {"offset": 0.5})
    assert dict(found.sizes) == {"width": 3, "height": 5}
    assert found["area"].dims == ("width", "height")
    np.testing.assert_allclose(found["area"], np.multiply.outer([1, 2, 3], np.linspace(0, 1, 5)) + 0.5)
    assert float(found["half"].sel(width=3.0, height=0.25)) == 1.5
    assert found["area"].attrs == {"units": "m2", "long_name": "area"}
    assert found["width"].attrs["units"] == "m"
    assert found.attrs == {"offset": 0.5}


@pytest.mark.parametrize("chunk", [1, 7, 64, 10**6])
def test_dask_gives_the_same_lazily(chunk):
    pytest.importorskip("dask")
    values = {"width": np.linspace(1, 2, 9), "height": np.linspace(0, 1, 13)}
    lazy = sweep(AREA, values, dask=True, chunk=chunk)
    assert lazy["area"].chunks is not None
    blocks = np.prod([max(sizes) for sizes in lazy["area"].chunks])
    assert blocks <= max(chunk, 1)
    np.testing.assert_array_equal(lazy["area"].compute(), sweep(AREA, values)["area"])


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"depth": [1.0]}, "no parameter 'depth'.*width, height"),
        ({"width": []}, "finite values of width"),
        ({"width": [1.0, np.nan]}, "finite values of width"),
        ({}, "at least one"),
        ({"width": np.ones(10**4), "height": np.ones(10**4)}, "100000000 combinations"),
    ],
)
def test_sweeps_that_cannot_be_are_reported(values, words):
    with pytest.raises(SceneError, match=words):
        sweep(AREA, values)
