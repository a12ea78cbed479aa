"""How a star that is torn apart grows, against the run that sims/tidal_disruption.toml tells of."""

import numpy as np
import pytest

from astroinertia.costs import torn
from astroinertia.costs.prediction import counted
from astroinertia.scene import load
from astroinertia.units import DIMENSIONLESS
from tests.sims import SIMS

SCENE = SIMS / "tidal_disruption.toml"
TIDE = load.load_file(SCENE).effects["tide"]


def grown(tide=TIDE, index=1.5, end=30.0):
    return torn.grown(tide, DIMENSIONLESS, index, 1.0, 1.0, end)


def test_density_falls_as_in_the_run():
    """Its densest fell from 1.39 to 0.14 in 3 dynamical times after the pericentre, and to 0.0032 in 25."""
    times, sizes = grown()
    assert np.interp(TIDE["pericentre_time"], times, sizes) == 1.0
    for since, density in ((3.0, 0.14), (25.0, 0.0032)):
        found = np.interp(TIDE["pericentre_time"] + since, times, sizes) ** -3.0
        assert found == pytest.approx(density / 1.39, rel=0.3)


def test_speeds_scale_as_the_tide_does():
    """Twice as near, at twice the eccentricity less one, the rate is sqrt(2^3 2/3) times as great."""
    nearer = TIDE | {"position": [50.0, 0.0, 0.0], "eccentricity": 2.0}
    rates = [(grown(tide)[1][-1] ** 1.5 - 1.0) / 25.0 for tide in (TIDE, nearer)]
    assert rates[1] / rates[0] == pytest.approx((8.0 * 2.0 / 3.0) ** 0.5)


@pytest.mark.parametrize("changed", [
    {"tide": None},
    {"tide": TIDE | {"position": [0.0, 110.0, 0.0]}},  # 0.91 of the tidal radius's depth
    {"tide": TIDE | {"pericentre_time": None}},
    {"tide": TIDE | {"pericentre_time": -1.0}},
    {"end": 4.0},
    {"index": 3.0},
    {"index": None},
])  # fmt: skip
def test_what_holds_together_is_left_alone(changed):
    assert grown(**changed) is None


def test_a_condensed_star_is_torn_apart_deeper_in():
    assert grown(TIDE | {"position": [49.0, 0.0, 0.0]}, index=3.0) is not None
    assert grown(TIDE | {"pericentre_time": 0.0})[0][0] == 0.0


def test_a_tide_beyond_all_measure_is_planned_without_a_warning():
    """Sizes of 1e200 at the end have powers that are no numbers; warnings are errors here."""
    done = counted(load.load_file(SCENE, ["body.particles=500", "effects.tide.position=[1e-100, 0.0, 0.0]"]))
    assert done.steps > 0.0


def test_the_work_of_a_scene_goes_with_it():
    done, whole = (
        counted(load.load_file(SCENE, ["body.particles=500", *more]))
        for more in ([], ["effects.tide.position=[200.0, 0.0, 0.0]"])
    )
    assert whole.done[25] == pytest.approx(0.5, abs=0.01)
    assert done.done[25] > 0.6
    assert done.evaluations < 0.7 * whole.evaluations
