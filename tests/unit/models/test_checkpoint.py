"""The arrays of a checkpoint are held to the schema of the state before they are used."""

import numpy as np
import pytest

from astroinertia.models import checkpoint

LIKE = {"mass": (np.dtype(float), (3,)), "step": (np.dtype(np.int64), ()), "place": (np.dtype(float), (3, 2))}
LIMITS = {"mass": checkpoint.POSITIVE, "step": checkpoint.COUNT}


def arrays(**other):
    return {"mass": np.ones(3), "step": np.array(4), "place": np.zeros((3, 2))} | other


def test_a_state_and_what_is_not_known_of_are_let_through():
    checkpoint.check(arrays(other=np.array("x")), LIKE, LIMITS)


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"mass": np.ones(3, np.float32)}, "must be float64"),
        ({"mass": np.ones(4)}, "of shape"),
        ({"mass": np.ones((3, 1))}, "of shape"),
        ({"mass": np.array(["a", "b", "c"])}, "must be float64"),
        ({"mass": np.array([1.0, 0.0, 1.0])}, "beyond"),
        ({"mass": np.array([1.0, -1.0, 1.0])}, "beyond"),
        ({"place": np.full((3, 2), np.nan)}, "not finite"),
        ({"place": np.full((3, 2), 1e200)}, "not finite"),
        ({"step": np.array(-1)}, "beyond"),
        ({"step": np.array(4.0)}, "must be int64"),
    ],
)
def test_what_is_no_state_is_refused(other, words):
    with pytest.raises(ValueError, match=words):
        checkpoint.check(arrays(**other), LIKE, LIMITS)


def test_what_is_missing_is_named():
    with pytest.raises(ValueError, match="lacks the array 'place'"):
        checkpoint.check({"mass": np.ones(3), "step": np.array(4)}, LIKE, LIMITS)
