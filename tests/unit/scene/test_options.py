"""Options of effects, checked against what their entries say."""

import pytest

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.scene.options import options_of
from astroinertia.scene.problems import Problem
from astroinertia.units import positive

POINTING = {
    "damping.axis", "dipole_braking.magnetic_axis", "pivot.arm", "rotating_frame.axis", "target_tensor.normal",
    "tide.normal", "tide.position",
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(POINTING))
def test_what_must_point_somewhere_is_no_vector_of_zero_length(name: str) -> None:
    kind, key = name.split(".")
    declared = {key: CATALOGUE[kind].options[key]}
    with pytest.raises(Problem) as refused:
        options_of(("effects", kind), declared, {key: [0, 0, 0]}, code=True)
    assert refused.value.path == ("effects", kind, key)
    assert refused.value.message == ": must not be a vector of zero length."
    assert options_of(("effects", kind), declared, {key: [0, 0, 2]}, code=True) == {key: (0.0, 0.0, 2.0)}


def test_a_number_may_have_the_name_of_a_direction() -> None:
    declared = {"axis": positive("length", None, "half the longest axis")}
    assert options_of(("effects", "spheroid"), declared, {"axis": 2.0}, code=True) == {"axis": 2.0}
