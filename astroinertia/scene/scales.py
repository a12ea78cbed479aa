"""How large and how small the numbers of a scene may be: double precision holds products of them only so far.

Powers up to the sixth of lengths and products of several quantities must neither overflow nor vanish, in SI at the two
ends of a run as in its own units inside. Tests: tests/unit/test_scene_scales.py.
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from pydantic import BaseModel

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.effects.catalogue import DIMENSIONS as OF_OPTIONS
from astroinertia.scene.quantities import marks
from astroinertia.units import GRAVITATIONAL_CONSTANT, dimension_of, si_unit

ABSOLUTE = 50.0  # powers of ten of masses, lengths and plain numbers
RELATIVE = 60.0  # powers of ten of a quantity over what the body's mass, its size and G make of its dimension
ROCK = 5e3  # kg/m3: what sets the size of a planet whose radius is not known before it is solved for


class Number(NamedTuple):
    """A quantity of a scene: where it is, its values, the exponents of its dimension, and whether it is positive."""

    place: str
    values: tuple[float, ...]
    dimension: str
    exponents: tuple[float, ...]
    positive: bool


def check_scales(scene: Any) -> None:
    """ValueError where a number of a scene is beyond what can be computed with."""
    numbers = [*_numbers(scene, ""), *_options(scene)]
    for number in numbers:
        if number.dimension in ("mass", "length", "dimensionless"):
            _check(scene, number, 0.0, ABSOLUTE, "")
    sizes = _sizes(scene)
    told = " beside a body of that mass and size"
    for number in numbers:
        if number.dimension not in ("dimensionless", "angle"):
            natural = sum(size * power for size, power in zip(sizes, number.exponents, strict=True))
            _check(scene, number, natural, RELATIVE, told)


def _check(scene: Any, number: Number, natural: float, span: float, told: str) -> None:
    # A vector may have components of any smallness, as long as one of them is of some size.
    largest = max(map(abs, number.values), default=0.0)
    least = min(number.values) if number.positive else largest if number.dimension == "dimensionless" else 0.0
    for value, small in ((largest, False), (least, True)):
        if value == 0.0 or (math.log10(value) > natural - span if small else math.log10(value) < natural + span):
            continue
        limit = natural - span if small else natural + span
        unit = "" if scene.dimensionless or number.dimension == "dimensionless" else f" {si_unit(number.dimension)}"
        bound = f"at least 1e{math.ceil(limit)}" if small else f"at most 1e{math.floor(limit)}"
        size = f"{value:.3g}{unit}, too {'small' if small else 'large'} to compute with{told}"
        raise ValueError(f"{number.place} has the size {size}: {bound}{unit}.")


def _sizes(scene: Any) -> tuple[float, float, float]:
    """Decimal logarithms of the body's mass, its size and its dynamical time (R^3/(G M))^(1/2)."""
    body, units = scene.body, None if scene.dimensionless else scene.units
    mass, length = getattr(body, "mass", None), getattr(body, "radius", None)
    if mass is not None and length is None:
        moments = getattr(body, "moments", None)
        length = (mass / ROCK) ** (1.0 / 3.0) if moments is None else math.sqrt(max(moments) / mass)
    if mass is None or not length:
        mass, length = (1.0, 1.0) if units is None else (units.mass, units.length)
    constant = 1.0 if scene.dimensionless else GRAVITATIONAL_CONSTANT
    size = math.log10(length)
    return math.log10(mass), size, 0.5 * (3.0 * size - math.log10(mass) - math.log10(constant))


def _numbers(part: BaseModel, place: str) -> Iterator[Number]:
    for name, field in type(part).model_fields.items():
        value = getattr(part, name)
        found = marks(field)
        if found and value is not None:
            dimension, positive = found[0].dimension, found[0].sign == "positive"
            for values in _vectors(value):
                yield Number(f"{_table(place)}{name}", values, dimension, dimension_of(dimension), positive)
        elif not found:
            yield from _inside(value, f"{place}.{name}".lstrip("."))


def _inside(value: Any, place: str) -> Iterator[Number]:
    if isinstance(value, BaseModel):
        yield from _numbers(value, place)
    elif isinstance(value, tuple):
        for number, item in enumerate(value):
            yield from _inside(item, f"{place}.{number}")
    elif isinstance(value, dict):
        for name, item in value.items():
            yield from _inside(item, f"{place}.{name}")


def _options(scene: Any) -> Iterator[Number]:
    for kind, given in scene.effects.items():
        for name, value in given.items():
            option = CATALOGUE[kind].options[name]
            if value is None or option.dimension in ("choice", "boolean"):
                continue
            positive = option.minimum == 0.0 and option.exclusive
            for values in _vectors(value):
                place = f"[effects.{kind}] {name}"
                yield Number(place, values, option.dimension, OF_OPTIONS[option.dimension], positive)


def _vectors(value: Any) -> Iterator[tuple[float, ...]]:
    if not isinstance(value, tuple):
        yield (value,)
    elif value and isinstance(value[0], tuple):
        for row in value:
            yield from _vectors(row)
    else:
        yield value


def _table(place: str) -> str:
    return f"[{place}] " if place else ""
