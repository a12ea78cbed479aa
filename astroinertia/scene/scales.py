"""The code units of a scene, and whether its numbers are of sizes that arithmetic can bear in them.

Formulas raise masses, lengths and times to powers up to six or so: within these limits none of them leaves the range of
float64 (1e-308 to 1e308). Tests: tests/unit/test_extreme_numbers.py.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import BaseModel

from astroinertia.scene.dimensional import quantity_of
from astroinertia.scene.own_body import OwnBody
from astroinertia.scene.problems import Path, Problem
from astroinertia.scene.schema import Scene, Units
from astroinertia.units import DIMENSIONLESS, DIMENSIONS, CodeUnits, Dimension, Option, pressure_constant_dimension

LARGEST = 1e35  # of a number in code units
SMALLEST = 1e-35  # of one that must be positive: others may be zero, so that what is as good as zero does no harm
LARGEST_UNIT, SMALLEST_UNIT = 1e48, 1e-48  # of mass, length and time, in SI: from electrons to clusters of galaxies

Number = tuple[Path, float, str | Dimension, bool]  # where, its value, dimension, and whether it must be positive


def code_units(scene: Scene) -> CodeUnits:
    """The units of a run: those the scene gives, or the mass of all bodies and the radius of the first; or all 1."""
    if scene.dimensionless:
        return DIMENSIONLESS
    if isinstance(scene.units, Units):
        return CodeUnits(scene.units.mass, scene.units.length)
    masses = [body.mass for body in scene.bodies or (scene.body,) if body.mass is not None]
    assert masses  # bodies without a mass ask for [units]
    return CodeUnits(sum(masses), scene.body.unit_length)


def refuse_extremes(scene: Scene) -> None:
    """Problem where the code units, or a number in them, are too large or too small."""
    own_units = isinstance(scene.units, Units)
    units = code_units(scene)
    for name in ("mass", "length", "time"):
        size = units.unit(name)
        if not SMALLEST_UNIT <= size <= LARGEST_UNIT:
            raise Problem(
                ("units",) if own_units else ("body",),
                f" makes the run's unit of {name} {size:.3g} in SI, which must be between {SMALLEST_UNIT:g} and "
                f"{LARGEST_UNIT:g}.",
                table=True,
            )
    for path, value, dimension, positive in (*_numbers(scene), *_constants(scene), *_of_effects(scene)):
        unit = units.unit(dimension)
        size = abs(value) / unit if unit else math.inf
        if size > LARGEST or (positive and size < SMALLEST):
            bound = f"at most {LARGEST:g}" if size > LARGEST else f"at least {SMALLEST:g}"
            raise Problem(path, f": must be {bound} in the units of the run, in which it is {size:.3g}.")


def _numbers(part: BaseModel, path: Path = ()) -> Iterator[Number]:
    for name, field in type(part).model_fields.items():
        if isinstance(part, Scene) and (name in ("effects", "candidates") or (name == "body" and part.bodies)):
            continue  # effects have no types of their own; the body is the first of several
        yield from _within(getattr(part, name), (*path, name), quantity_of(field))


def _within(value: Any, path: Path, quantity: Any) -> Iterator[Number]:
    if isinstance(value, BaseModel):
        yield from _numbers(value, path)
    elif isinstance(value, tuple | dict):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _within(item, (*path, key), quantity)
    elif quantity is not None and isinstance(value, float):
        yield path, value, quantity.dimension, quantity.sign == "positive"


def _constants(scene: Scene) -> Iterator[Number]:
    """K and entropies, whose dimension is that of their exponent."""
    fluid: Any = scene.equation_of_state
    if fluid is None:
        return
    constant, entropy = fluid.stated_constant, scene.body.entropy
    if isinstance(constant, float):
        yield ("equation_of_state", "constant"), constant, pressure_constant_dimension(fluid.first_gamma), True
    if entropy is not None:
        yield ("body", "entropy"), entropy, pressure_constant_dimension(fluid.thermal_gamma), False


def _of_effects(scene: Scene) -> Iterator[Number]:
    for kind, options in scene.effects.items():
        yield from _of_options(("effects", kind), scene.entries[kind].options, options)
    fluid = scene.equation_of_state
    if fluid is not None and fluid.kind == "own":
        yield from _of_options(("equation_of_state",), fluid.entry.options, fluid.options)
    for body in scene.bodies or (scene.body,):
        if isinstance(body, OwnBody):
            yield from _of_options(("body",), body.entry.options, body.options)


def _of_options(table: Path, declared: Mapping[str, Option], options: Mapping[str, Any]) -> Iterator[Number]:
    for name, value in options.items():
        option = declared[name]
        if (isinstance(option.dimension, Dimension) or option.dimension in DIMENSIONS) and value is not None:
            positive = option.minimum == 0.0 and option.exclusive
            for path, number in _flat(value, (*table, name)):
                yield path, number, option.dimension, positive


def _flat(value: Any, path: Path) -> Iterator[tuple[Path, float]]:
    if isinstance(value, tuple | list):
        for k, item in enumerate(value):
            yield from _flat(item, (*path, k))
    else:
        yield path, value
