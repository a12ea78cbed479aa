"""The catalogue of effects: options and their limits, what is refused, and effects as pytrees."""

import dataclasses
from typing import Any

import jax
import numpy as np
import pytest

from astroinertia.effects import catalogue
from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.units import DIMENSIONS, Default


@pytest.mark.parametrize("kind", CATALOGUE)
def test_the_catalogue_describes_the_options_that_the_effect_has(kind: str) -> None:
    entry = CATALOGUE[kind]
    made = entry.made
    assert made.kind == kind
    fields = {field.name: field for field in dataclasses.fields(made) if not field.metadata.get("of_problem")}
    assert set(entry.options) == set(fields)
    for name, option in entry.options.items():
        assert option.dimension in {*DIMENSIONS, "choice", "boolean"}
        assert (option.dimension == "choice") == bool(option.choices)
        assert (fields[name].metadata.get("static", False)) == bool(option.choices)
        if isinstance(option.default, Default):
            continue
        assert fields[name].default == option.default
        if option.choices:
            assert option.default in option.choices
        elif option.default is not None:
            assert np.shape(option.default) == option.shape


def test_a_missing_and_an_unknown_option_are_named() -> None:
    with pytest.raises(ValueError, match="time_scale is missing"):
        catalogue.build("damping")
    with pytest.raises(ValueError, match="alfa is not an option of viscosity"):
        catalogue.build("viscosity", {"alfa": 1.0})


@pytest.mark.parametrize(
    ("kind", "options", "sentence"),
    [
        ("viscosity", {"alpha_max": 0.5, "alpha_min": 0.6}, "alpha_min must not be above"),
        ("damping", {"time_scale": 1.0, "rate_change": 0.1}, "needs the rate at time 0"),
        ("tide", {"mass": 1.0, "position": (1.0, 0.0, 1.0), "period": 1.0}, "perpendicular"),
        ("external_field", {}, "needs one of"),
        ("external_field", {"circular_speed": 1.0}, "needs both circular_speed and core"),
        ("external_field", {"quadratic": ((0.0, 1.0, 0.0), (0.0,) * 3, (0.0,) * 3)}, "must be symmetric"),
    ],
)
def test_options_that_contradict_are_refused(kind: str, options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        catalogue.build(kind, options)


def test_effects_are_pytrees_whose_numbers_are_leaves() -> None:
    effect = catalogue.build("viscosity", {"beta": 1.5})
    leaves, tree = jax.tree.flatten(effect)
    assert sorted(leaves) == [0.0, 1.0, 1.5, 10.0]
    assert jax.tree.unflatten(tree, leaves) == effect or jax.tree.unflatten(tree, leaves).beta == 1.5
