"""The record of a rigid body: its moments, and the ledger that the row of rigidity closes."""

import numpy as np
import pytest

from astroinertia.inertia.prescribed import change
from astroinertia.models.rigid.record import dissipates
from astroinertia.observables.quantities import RECORDED
from tests.rigid import ADAPTIVE, effect, under_way

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("float64")]  # slow: each combination of effects is compiled
TOP, SPIN = np.array([1.0, 2.0, 2.5]), [0.5, 0.7, 1.0]
TILTED = (0.8, 0.1, -0.5, 0.3)

BODIES = {
    "free": ((), {}),
    "torque in the body": ((effect("constant_torque", vector=[0.1, -0.3, 0.2], frame="body"),), {}),
    "settling": ((effect("internal_dissipation", time_scale=3.0),), {}),
    "pivot": (
        (effect("pivot", gravity=[0.1, 0.0, -2.0], arm=[0.1, 0.2, 0.3]),),
        {"arm": np.array([0.1, 0.2, 0.3])},
    ),
    "size": ((effect("constant_torque", vector=[0.1, -0.3, 0.2]),), {"change": change([2.0], [0.3])}),
    "elastic": (
        (effect("rotational_deformation", love_number=0.06, radius=1.0),),
        {"deformability": 0.02, "spin": 1.0},
    ),
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=() if name == "pivot" else pytest.mark.full) for name in BODIES],
)
def test_the_ledger_closes(name):
    effects, rest = BODIES[name]
    body = under_way(TOP, SPIN, *effects, settings=ADAPTIVE, quaternion=TILTED, mass=2.0, **rest)
    records = []
    step = 1e-3
    for k in range(-2, 3):
        body.advance(0.7 + k * step)
        records.append(body.record(0.0))
    middle = records[2]

    def slope(quantity):  # of order 4
        one, two, _, four, five = (record[quantity] for record in records)
        return (one - 8.0 * two + 8.0 * four - five) / (12.0 * step)

    close = {"abs": 1e-10, "rel": 1e-8}
    mixed = middle["mixed_moment"]
    if name != "elastic":  # whose matter moves in a way that is known to first order of the bulge alone
        assert slope("second_moment") == pytest.approx(mixed + mixed.T, **close)
    assert slope("mixed_moment") == pytest.approx(middle["kinetic_tensor"] + middle["virial_tensor"].sum(0), **close)
    assert slope("angular_momentum") == pytest.approx(middle["torque"].sum(0), **close)
    assert slope("momentum") == pytest.approx(middle["force"].sum(0), **close)
    assert slope("centre_of_mass") * 2.0 == pytest.approx(middle["momentum"], **close)
    # Internal forces exert no torque, and leave the energy to the effects.
    assert middle["virial_tensor"][-1] == pytest.approx(middle["virial_tensor"][-1].T, abs=1e-13)
    kinetic = 0.5 * np.trace(middle["kinetic_tensor"]) + middle["momentum"] @ middle["momentum"] / 4.0
    assert middle["kinetic_energy"] == pytest.approx(kinetic, rel=1e-14)
    power = slope("work").sum()
    assert slope("kinetic_energy") == pytest.approx(power, **close)
    if not rest and not any(dissipates(each) for each in effects):
        spun = np.linalg.solve(middle["inertia_tensor"], middle["angular_momentum"])
        assert power == pytest.approx(spun @ middle["torque"].sum(0), **close)


@pytest.mark.full
def test_second_moments_of_the_elastic_body_follow_its_mixed_moment():
    effects, rest = BODIES["elastic"]
    body = under_way(TOP, SPIN, *effects, settings=ADAPTIVE, quaternion=TILTED, **rest)
    places = []
    for time in (0.5 - 1e-4, 0.5, 0.5 + 1e-4):
        body.advance(time)
        places.append(body.record(0.0))
    mixed = places[1]["mixed_moment"]
    change = (places[2]["second_moment"] - places[0]["second_moment"]) / 2e-4
    assert change == pytest.approx(mixed + mixed.T, abs=1e-7)


def test_every_quantity_of_the_schema_is_recorded_or_absent_for_a_reason():
    body = under_way(TOP, SPIN)
    absent = {name for name, quantity in RECORDED.items() if "rigid" in quantity.absent}
    assert set(RECORDED) <= set(body.record(None)) | absent | {"wall_time"}


def test_the_attitude_is_that_of_the_axes_that_the_body_was_given():
    axes = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    body = under_way(TOP, SPIN, quaternion=TILTED, axes=axes)
    record = body.record(None)
    attitude = record["attitude"]
    assert attitude @ record["inertia_tensor"] @ attitude.T == pytest.approx(np.diag(axes @ TOP), abs=1e-14)
    assert np.linalg.det(attitude) == pytest.approx(1.0)
