"""What errors are judged against: a body that begins without spin does not spin by what round-off gives it."""

import numpy as np
import pytest
import xarray as xr

from astroinertia.plots.axis_scales import angular_momentum_scale


@pytest.mark.parametrize(
    ("first", "last", "precision", "spins"),
    [
        (0.0, 8e-9, "mixed", False),  # of the largest that the motion could carry
        (0.0, 8e-9, "float64", True),
        (8e-9, 8e-9, "mixed", True),  # set up so
        (0.0, 1e-3, "mixed", True),
        (0.0, 1e-17, "float64", False),
    ],
)
def test_a_body_spins_by_more_than_pairs_of_its_precision_give(first, last, precision, spins):
    momentum = np.outer([2.0 * first, 2.0 * last], [0.0, 0.0, 1.0])
    tensors = {name: (("time", "i", "j"), np.tile(np.diag([1.0, 0.0, 0.0]), (2, 1, 1)))
               for name in ("second_moment", "kinetic_tensor")}  # fmt: skip
    run = xr.Dataset({"angular_momentum": (("time", "i"), momentum), **tensors}, attrs={"precision": precision})
    scale, turning = angular_momentum_scale(run)
    assert turning is spins
    assert scale == (2.0 * last if spins else 2.0)
