"""What errors are judged against: a body that begins without spin does not spin by what errors of forces give it."""

import numpy as np
import pytest
import xarray as xr

from astroinertia.plots.axis_scales import angular_momentum_scale

# Measured: of the largest that the motion could carry, what errors give to a body at rest.
PAIRS, MULTIPOLES = 8e-9, 1.4e-6


@pytest.mark.parametrize(
    ("first", "given", "torque", "spins"),
    [
        (0.0, PAIRS, 0.0, False),
        (0.0, PAIRS, 4e-9, False),  # of the virial tensor, by its own single-precision pairs
        (0.0, MULTIPOLES, 0.0, False),
        (0.0, MULTIPOLES, 1e-3, True),  # by what turns it
        (0.0, MULTIPOLES, np.nan, True),  # by what is not known to be a force between particles
        (PAIRS, 0.0, 0.0, True),  # set up so
        (1e-3, MULTIPOLES, 0.0, True),
        (0.0, 1e-17, 1e-3, False),
    ],
)
def test_a_body_spins_by_more_than_errors_of_inner_forces_give(first, given, torque, spins):
    """An effect whose own virial tensor is symmetric cannot turn a body, whatever its forces sum up to."""
    momentum = np.outer([first, first + given], [0.0, 0.0, 1.0])
    tensors = {name: (("time", "i", "j"), np.tile(np.diag([1.0, 0.0, 0.0]), (2, 1, 1)))
               for name in ("second_moment", "kinetic_tensor")}  # fmt: skip
    impulse = np.zeros((2, 2, 3, 3))
    impulse[1, 0, 0, 1] = given
    turning = np.zeros((2, 2, 3))
    turning[:, 0] = torque * np.array([0.0, 0.0, 1.0])
    ledger = {
        "mixed_impulse": (("time", "effect", "i", "j"), impulse),
        "torque": (("time", "effect", "i"), turning),
        "virial_tensor": (("time", "effect", "i", "j"), np.ones((2, 2, 3, 3))),
    }
    run = xr.Dataset({"angular_momentum": (("time", "i"), momentum), **tensors, **ledger})
    scale, found = angular_momentum_scale(run)
    assert found is spins
    assert scale == (first + given if spins else 1.0)
