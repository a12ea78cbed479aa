"""Quantities of the headline series: every model records those that the table says it has, and what follows."""

import textwrap

import numpy as np
import pytest

from astroinertia.build.assemble import prepare
from astroinertia.observables.quantities import DERIVED, OF_EFFECTS, RECORDED, SAID, BodyState, ledger_closure, row
from astroinertia.scene.load import load_file

ALSO = {"time", "wall_time"}  # which the loop adds, or which is a coordinate
NOT_A_NUMBER = {"rigid": {"internal_energy", "gravitational_energy"}}  # said, though absent: heat makes it a number
SCENES = {
    "sph": "rotating_polytrope", "ellipsoid": "maclaurin_to_jacobi", "rigid": "tennis_racket",
    "scaling": "core_to_pulsar_scaling",
}  # fmt: skip


@pytest.mark.parametrize("model", SCENES)
def test_a_model_records_what_the_table_says_that_it_has(model) -> None:
    import jax

    few = ["body.particles=100", "body.relax=false"] if model == "sph" else []
    with jax.enable_x64(True):
        body = prepare(load_file(f"sims/{SCENES[model]}.toml", few)).evolution
        record = body.record(None)
    absent = {name for name, quantity in RECORDED.items() if model in quantity.absent}
    assert set(record) - ALSO - set(OF_EFFECTS) == set(RECORDED) - ALSO - absent | NOT_A_NUMBER.get(model, set())
    assert not absent & set(body.absent)  # of which each has one reason
    count = len(body.effects)
    sizes = {"time": (), "i": (3,), "j": (3,), "principal": (3,), "effect": (count,), "mode": (4,)}
    for name, value in record.items():
        if name in RECORDED and "radius_bin" not in RECORDED[name].dims:
            assert np.shape(value) == sum((sizes[dim] for dim in RECORDED[name].dims), ()), name


def test_what_follows_is_by_its_equation_and_what_a_model_has_of_its_own_goes_before() -> None:
    rng = np.random.default_rng(7)
    said = {name: rng.normal(size=(3, 3)) for name in SAID} | {"virial_tensor": rng.normal(size=(2, 3, 3))}
    state = BodyState(**said)
    found = row(state)
    Q, P, V = state.second_moment, state.mixed_moment, state.virial_tensor
    levi_civita = np.array([[[(i - j) * (j - k) * (k - i) / 2 for k in range(3)] for j in range(3)] for i in range(3)])
    np.testing.assert_allclose(found["angular_momentum"], np.einsum("ijk,jk", levi_civita, P), atol=1e-14)
    np.testing.assert_allclose(found["torque"], np.einsum("ijk,ejk->ei", levi_civita, V), atol=1e-14)
    np.testing.assert_allclose(found["inertia_tensor"], np.trace(Q) * np.eye(3) - Q, atol=1e-14)
    assert set(found) == {*SAID, "angular_momentum", "torque", "inertia_tensor"}
    own = row(state, torque=1.0, timestep=2.0)
    assert (own["torque"], own["timestep"]) == (1.0, 2.0) and set(own) == {*found, "timestep"}
    assert ledger_closure(Q + np.eye(3), Q, 4.0) == pytest.approx(2.0 * np.sqrt(3.0) / 4.0)


def test_each_name_is_declared_once() -> None:
    tables = (RECORDED, DERIVED, OF_EFFECTS)
    assert len({name for table in tables for name in table}) == sum(map(len, tables))


def test_what_xarray_writes_along_an_axis_takes_two_lines_at_most():
    """Beside its default axes there is room for no more: xarray wraps "long_name [units]" at 30 characters."""
    labels = {name: f"{each.long_name} [{each.unit}]" for name, each in (RECORDED | DERIVED).items()}
    assert [name for name, label in labels.items() if len(textwrap.wrap(label, 30)) > 2] == []
