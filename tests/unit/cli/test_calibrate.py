"""What `run` and `resume` say of the time that a run took."""

import numpy as np
import pytest

from astroinertia.cli.calibrate import compared


def test_what_a_run_took_stands_beside_what_was_predicted():
    attrs = {"measured_wall_time": np.float64(2.0), "predicted_wall_time": 3.0, "error_bars_wall_time": np.float32(1.0)}
    assert compared(attrs) == "took 2 s, predicted 3 s; 1 s more for error bars"
    assert compared({"predicted_wall_time": 3.0}) == ""


@pytest.mark.parametrize("kept", ["true", True, [1.0, 2.0], np.array([1.0, 2.0]), np.nan])
def test_a_predicted_time_that_is_no_number_is_left_out(kept):
    assert compared({"measured_wall_time": 2.0, "predicted_wall_time": kept}) == "took 2 s"
    assert compared({"measured_wall_time": kept}) == ""
