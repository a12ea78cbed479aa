"""What is common to all that comes in from outside: what is wrong of a class, or fails in it, is one sentence."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from astroinertia.build.assemble import refuse_contradictions
from astroinertia.effects import Effect, positive, pytree
from astroinertia.errors import SceneError
from astroinertia.initial import Body
from astroinertia.matter import Matter
from astroinertia.observables import Observable
from astroinertia.scene.load import loads
from astroinertia.scene.own import DOORS
from astroinertia.scene.plan import plan

SCENE = """
name = "gas"
units = "code"
[body]
kind = "uniform"
mass = 1.0
radius = 1.0
particles = 64
relax = false
[equation_of_state]
kind = "isothermal"
sound_speed = 0.3
[effects.pressure]
[time]
end = 0.01
"""
LENGTH = {"k": positive("length", 1.0, "k")}
BASES = {"effects": Effect, "matter": Matter, "bodies": Body, "observables": Observable}
USUAL = {
    "effects": {"acceleration": lambda self, xp, fluid: 0.0 * fluid.velocity},
    "matter": {
        "pressure": lambda self, xp, rho, A: 0.09 * rho,
        "internal_energy": lambda self, xp, rho, A: 0.09 * xp.log(rho),
        "sound_speed": lambda self, xp, rho, A: 0.3 + 0.0 * rho,
    },
    "bodies": {
        "density": lambda self, x: 1.0 * (abs(x).max(axis=1) < 1.0),
        "extent": lambda self: (1.0, 1.0, 1.0),
    },
    "observables": {"long_name": "made", "value": lambda self, body: 1.0},
}


def made(name: str, **parts: Any) -> type:
    """A class with one field, of what comes in by the door of that name."""
    usual = {"kind": "made", "__module__": __name__, "__annotations__": {"k": Any}, "k": 1.0, "options": LENGTH}
    plain = type("Made", (BASES[name],), usual | USUAL[name] | parts)
    return pytree(dataclass(frozen=True, eq=False)(plain))


def fails(*arguments: Any) -> None:
    """Fails as a mistake does."""
    raise KeyError("mistaken")


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.name)
def test_what_is_wrong_of_any_class_is_one_sentence(door: Any) -> None:
    assert f"the class Made of {__name__}, given from Python" in plan(loads(SCENE, effects=[made(door.name)()])).text()
    wrong = [
        ({"kind": "Made Up"}, "its `kind` must be a name of small letters"),
        ({"options": {}}, "its `options` must describe each of its fields, but not so k"),
        ({"options": {"k": 1.0}}, "its `options` must describe k by an Option"),
        ({"options": ["k"]}, "its `options` must describe each of its fields"),
        ({"options": {**LENGTH, 3: LENGTH["k"]}}, "its `options` must describe each of its fields, but not so 3"),
        ({"source": 3}, "its `source` must be text"),
    ]
    if door.models:
        wrong += [
            ({"models": models}, "its `models` must be some of sph, ") for models in (3, "sph", ("gas",), (["sph"],))
        ]
    if door.name == "effects":
        wrong.append(({"size": "large"}, "its `size` must be a Measure"))
    for parts, sentence in wrong:
        with pytest.raises(SceneError) as refused:
            loads(SCENE, effects=[made(door.name, **parts)()])
        assert str(refused.value).startswith(f"Made is no {door.thing}: {sentence}")


@pytest.mark.parametrize(
    ("name", "part"),
    [
        *((door.name, "from_options") for door in DOORS),
        ("effects", "in_units"), ("matter", "pressure"), ("matter", "sound_speed"), ("bodies", "radius"),
        ("bodies", "characteristic"),
    ],
)  # fmt: skip
def test_what_a_class_fails_with_names_it(name: str, part: str) -> None:
    wrong = {"from_options": classmethod(fails), "radius": property(fails)}.get(part, fails)
    where = f"made of the class Made of {__name__}, given from Python"
    with pytest.raises(SceneError, match=rf"{where} failed \(KeyError: 'mistaken'\)"):
        _planned(made(name, **{part: wrong})())


def test_matter_that_gives_no_number_for_each_density_names_itself() -> None:
    with pytest.raises(SceneError, match=r"given from Python failed \(ValueError: "):
        _planned(made("matter", pressure=lambda self, xp, rho, A: np.zeros((3, 2)))())


def _planned(thing: Any) -> None:
    scene = loads(SCENE, effects=[thing])
    plan(scene)
    refuse_contradictions(scene)
