"""Scenes that are valid, put together by chance from the schema and the catalogue of effects.

A scene is its number: the same one gives the same text. What kinds, options and limits there are is read from the
schema's fields and from the effects' options, so that a new one is drawn without a word here; a field of a type that
this file does not know stops it. Numbers are those of a body of some mass and size, apart from a factor that is small,
large or at the limits; what contradicts itself is drawn again.
"""

import functools
import math
import random
import shutil
import types
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import numpy as np
from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from astroinertia.build.effects import effects_of
from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.errors import SceneError
from astroinertia.scene import load, scales, schema
from astroinertia.scene.dimensional import Quantity
from astroinertia.scene.fluids import FROM_BODY
from astroinertia.scene.text import toml_key, toml_text, toml_value
from astroinertia.units import (
    GRAVITATIONAL_CONSTANT,
    LIGHT,
    Default,
    Dimension,
    Option,
    dimension_of,
    pressure_constant_dimension,
    si_unit,
)

ROOT = Path(__file__).parents[2]
GIVEN = 0.2  # share of the options that are given although they need not be
EXTREME = math.log10(scales.LARGEST) - 1.0  # powers of ten over what the body has: next to what scenes take
# How far numbers are from those of the body, in powers of ten, and how often one of them is extreme: scenes whose
# numbers are all extreme are mostly refused, and show little else.
CALM, LOOSE, WILD = (0.5, 0.0), (1.5, 0.06), (4.0, 0.3)
FLUIDS = (*load.KINDS["equation_of_state"], None)
SELDOM = 0.05
TURNED = ("axes", "axis", "velocity_gradient")  # which the model scaling mostly refuses, as it follows no attitude
EITHER_OR = {"dipole_braking": (("field", "radius"), ("period", "period_derivative"))}  # options
TRIES = 12  # of one model, body and fluid, or of one part
MORE_OFTEN = {"sph": 4, "ellipsoid": 2}  # models with more to draw
STEPS = 3
PARTICLES = (16, 100)
ENGINE_XLA = 0.02  # of the scenes with particles: each has programs of its own to compile
LONGEST_LINE = 1000  # bytes; a scene may have 1 KiB


@functools.cache  # to draw one until it is valid takes a tenth of a second
def scene_text(number: int) -> str:
    """The TOML text of a scene that the loader takes; its files are those of `files`."""
    chance = random.Random(f"scene {number}")
    models = get_args(schema.Scene.model_fields["model"].annotation)
    while True:
        model = chance.choices(models, [MORE_OFTEN.get(each, 1) for each in models])[0]
        body = chance.choice(list(load.KINDS["body"]))
        for fluid in chance.sample(FLUIDS, len(FLUIDS)):
            for _ in range(TRIES):
                text = _Drawn(chance, f"scene_{number}", model, body, fluid).text()
                if text is not None:
                    return text


def files(folder: Path) -> None:
    """Writes what the scenes name: a table of particles, a stellar profile and a table of an equation of state."""
    places = np.random.default_rng(1).uniform(-1.0, 1.0, (40, 3))
    rows = "\n".join(",".join(f"{value:.6f}" for value in (0.025, *place)) for place in places)
    (folder / "particles.csv").write_text(f"mass,x,y,z\n{rows}\n")
    shutil.copy(ROOT / "data" / "example_mesa_profile.data", folder / "profile.data")
    grid = [(rho, u, 0.4 * rho * u) for rho in np.geomspace(0.1, 1e4, 12) for u in np.geomspace(1e2, 1e10, 12)]
    rows = "\n".join(",".join(repr(float(value)) for value in row) for row in grid)
    (folder / "matter.csv").write_text(f"density,internal_energy,pressure\n{rows}\n")


# Texts that no pattern or limit describes, by class and field.
TEXTS = {
    ("TableBody", "file"): ("particles.csv",),
    ("ProfileBody", "file"): ("profile.data",),
    ("Material", "file"): ("matter.csv",),
    ("Companion", "around"): ("body", "barycentre", "first", "second"),
    ("Layer", "material"): ("iron", "rock"),
    ("Box", "periodic"): ("x", "y", "z", "xy", "yz", "xz", "xyz"),
    ("Orbits", "archive"): (None,),  # a file of REBOUND's
    ("Orbits", "body"): (None,),  # of that file
    ("Scene", "judged_by"): ("inertia_tensor z z", "total_energy", "angular_velocity z"),
    ("Scene", "description"): ("", "Drawn by chance."),
}
NAMES = ("iron", "rock", "first", "second", "third", "fourth")
RECORD = (
    *load.RECORD, "name", "effects", "candidates", "observables", "regions", "body", "bodies", "equation_of_state",
    "model",
)  # fmt: skip


@dataclass(frozen=True)
class _Place:
    """Which field of which class is drawn, and what is drawn beside it."""

    owner: str
    field: str
    beside: dict[str, Any]


class _Drawn:
    """One attempt at a scene."""

    def __init__(self, chance: random.Random, name: str, model: str, body: str, fluid: str | None) -> None:
        self.chance, self.name, self.model, self.body, self.fluid = chance, name, model, body, fluid
        self.code = body == "standard" or (body != "profile" and chance.random() < 0.5)
        self.spread, self.extreme = chance.choices((CALM, LOOSE, WILD), (4, 4, 1))[0]
        self.sizes = (1.0, 1.0, 1.0)
        if not self.code:
            mass, length = 10 ** chance.uniform(-1, 34), 10 ** chance.uniform(-1, 13)
            self.sizes = (mass, length, math.sqrt(length**3 / (GRAVITATIONAL_CONSTANT * mass)))
        self.gamma: float | None = None

    def text(self) -> str | None:
        """Its text; None where it contradicts itself."""
        tables: dict[str, Any] = {"name": self.name, "model": self.model}
        if self.code:
            tables["units"] = "code"
        if self.fluid is not None:
            fluid = self.part(load.KINDS["equation_of_state"][self.fluid])
            if fluid is None:
                return None
            tables["equation_of_state"] = fluid
            self.gamma = load._thermal_exponent(fluid)
        bodies = [self.part(load.KINDS["body"][kind]) for kind in self._bodies()]
        if None in bodies:
            return None
        tables |= {"bodies": bodies} if len(bodies) > 1 else {"body": bodies[0]}
        for name, field in schema.Scene.model_fields.items():
            if name in RECORD or name in tables:
                continue
            value = self._field(_Place("Scene", name, tables), field)
            if value is not None:
                tables[name] = value
        tables |= self._effects("box" in tables)
        if self.chance.random() < GIVEN:
            parts = {name: self.part(_region()) for name in self.chance.sample(NAMES, 2)}
            tables["regions"] = {name: part for name, part in parts.items() if part is not None}
        self._kept_short(tables)
        text = _written(tables)
        if max(len(line.encode()) for line in text.split("\n")) > LONGEST_LINE:
            return None
        try:
            scene = load.loads(text)
            if self.chance.random() > SELDOM:  # else its effects may contradict each other
                effects_of(scene, scales.code_units(scene))
        except SceneError:
            return None
        except Exception:  # what the loader itself falls over is found by whoever gives the scene to it
            return text
        return text

    def _bodies(self) -> list[str]:
        kinds = [self.body]
        while self.model == "sph" and len(kinds) < 4 and self.chance.random() < GIVEN:
            kinds.append(self.chance.choice(list(load.KINDS["body"])))
        return kinds

    def _kept_short(self, tables: dict[str, Any]) -> None:
        """A few steps of few particles; no pilot runs, which choose settings for an accuracy."""
        tables.setdefault("time", {})["max_steps"] = STEPS
        tables["settings"] = "given"
        tables.get("numerics", {}).pop("devices", None)
        if self.chance.random() > ENGINE_XLA:
            tables.setdefault("numerics", {})["engine"] = "numba_cpu"

    def _effects(self, boxed: bool) -> dict[str, Any]:
        fit = [kind for kind, entry in CATALOGUE.items() if self.model in entry.models or entry.numerical]
        fit = [kind for kind in fit if not boxed or CATALOGUE[kind].cost == "neighbours"]
        usual = [kind for kind in ("gravity", "pressure", "viscosity") if kind in fit and self.chance.random() < 0.8]
        more = [kind for kind in fit if kind not in usual]
        some = self.chance.sample(more, min(len(more), self.chance.choice((0, 0, 1, 1, 2, 3, len(more)))))
        effects = {kind: self._options(kind) for kind in (*usual, *some)}
        if self.chance.random() < 0.05:
            return {"effects": "auto", "candidates": effects}
        return {"effects": effects}

    def _options(self, kind: str) -> dict[str, Any]:
        found = {}
        one, other = self.chance.sample(EITHER_OR.get(kind, ((), ())), 2)
        for name, option in CATALOGUE[kind].options.items():
            needed = isinstance(option.default, Default) and (option.default is not LIGHT or self.code)
            seldom = 0.5 * GIVEN if one else 2 * GIVEN
            if name in one or (name not in other and (needed or self.chance.random() < seldom)):
                found[name] = self._option(option, option.shape)
        return found

    def _option(self, option: Option, shape: tuple[int, ...]) -> Any:
        if shape:
            if len(shape) == 2 and self.chance.random() < 0.7:  # matrices of fields are symmetric
                half = [[self._option(option, ()) for _ in range(3)] for _ in range(3)]
                return [[half[min(i, j)][max(i, j)] for j in range(3)] for i in range(3)]
            return [self._option(option, shape[1:]) for _ in range(shape[0])]
        if option.dimension == "choice":
            return self.chance.choice(option.choices)
        if option.dimension == "boolean":
            return self.chance.random() < 0.5
        sign = "any" if option.minimum < 0.0 else "positive" if option.exclusive else "not negative"
        if math.isfinite(option.minimum) and math.isfinite(option.maximum):
            return self._written(
                self._between(option.minimum, option.maximum, option.exclusive, False), option.dimension
            )
        value = self._number(option.dimension, sign)
        return self._written(min(max(value, option.minimum), option.maximum), option.dimension)

    def part(self, model: type[BaseModel]) -> dict[str, Any] | None:
        """A table of the scene that its own class takes; None where chance finds none."""
        context = {"code": self.code, "gamma_thermal": self.gamma}
        for _ in range(TRIES):
            found: dict[str, Any] = {}
            for name, field in model.model_fields.items():
                value = self._field(_Place(model.__name__, name, found), field)
                if value is not None:
                    found[name] = value
            _fits_together(model.__name__, found, self.chance)
            try:
                model.model_validate(found, context=context)
            except ValidationError:
                continue
            return found
        return None

    def _field(self, place: _Place, field: FieldInfo) -> Any:
        if place.field == "particles" and self.model == "sph":
            return self.chance.randint(*PARTICLES)
        if place.field == "box" and (not load.KINDS["body"][self.body].boxed or self.model != "sph"):
            return None
        if self.model == "scaling" and place.field in TURNED and self.chance.random() > SELDOM:
            return None
        needed = field.is_required() or (place.field == "units" and self.body in ("table", "profile"))
        needed = needed or (place.field == "box" and self.chance.random() < 0.6)
        if not needed and self.chance.random() > GIVEN:
            return None
        if place.field == "units":
            return "code" if self.code else self.part(schema.Units)
        if place.field == "constant":
            return self._constant(place)
        if place.field == "entropy":
            return (
                None
                if self.gamma is None
                else self._written(self._number(*_entropy(self.gamma)), _entropy(self.gamma)[0])
            )
        return self._value(place, field.annotation, list(field.metadata))

    def _constant(self, place: _Place) -> Any:
        gamma = place.beside.get("gamma", place.beside.get("gamma_1", (place.beside.get("gammas") or [5 / 3])[0]))
        if self.chance.random() < 0.3:
            return FROM_BODY
        dimension = pressure_constant_dimension(gamma)
        return self._written(self._number(dimension, "positive"), dimension)

    def _value(self, place: _Place, annotation: Any, metadata: list[Any]) -> Any:
        origin = get_origin(annotation)
        if origin is Annotated:
            inner, *more = get_args(annotation)
            return self._value(place, inner, [*more, *metadata])
        if origin in (Union, types.UnionType):
            choices = [choice for choice in get_args(annotation) if choice is not type(None)]
            return self._value(place, self.chance.choice(choices), metadata)
        if origin is Literal:
            return self.chance.choice(get_args(annotation))
        marks = [each for each in metadata if isinstance(each, Quantity)]
        if marks:
            return self._written(self._number(marks[0].dimension, marks[0].sign), marks[0].dimension)
        limits = [inner for each in metadata for inner in (each.metadata if isinstance(each, FieldInfo) else [each])]
        if origin is tuple:
            return self._several(place, get_args(annotation), limits)
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            return self.part(annotation)
        if annotation is bool:
            return self.chance.random() < 0.5
        if annotation is str:
            if (place.owner, place.field) in TEXTS:
                return self.chance.choice(TEXTS[place.owner, place.field])
            if place.field == "name":
                return self.chance.choice(NAMES)
        if annotation in (int, float):
            bounds = _bounds(limits)
            if bounds is not None:
                low, high, above, below = bounds
                value = self._between(low, high, above, below)
                return round(value) if annotation is int else value
        raise TypeError(f"{place.owner}.{place.field}: {annotation} with {metadata} is unknown to random scenes")

    def _several(self, place: _Place, items: tuple[Any, ...], limits: list[Any]) -> list[Any] | None:
        if items[-1] is not Ellipsis:
            alike = self.chance.random() < 0.5  # as the moments or the axes of a body are
            if alike and all(item == items[0] for item in items) and not self.code:
                alike = False
            values = [self._value(place, item, []) for item in items]
            if alike and all(isinstance(value, float) for value in values):
                return [abs(values[0]) * self.chance.uniform(0.6, 1.0) for _ in values]
            return values
        least = next((each.min_length for each in limits if isinstance(each, MinLen)), 0)
        most: int = next((each.max_length for each in limits if isinstance(each, MaxLen)), 4)
        counts = (least, *range(least, min(most, least + 3) + 1), *([most] if most <= 21 else []))
        values = [self._value(place, items[0], []) for _ in range(self.chance.choice(counts))]
        if None in values:
            return None
        for number, value in enumerate(values):
            if isinstance(value, dict) and "name" in value:
                value["name"] = NAMES[number] if number < len(NAMES) else f"number_{number}"
        return values

    def _number(self, dimension: str | Dimension, sign: str) -> float:
        """Near what the body would have, or far from it, or at the limits."""
        powers = zip(self.sizes, dimension_of(dimension), strict=True)
        natural = sum(power * math.log10(size) for size, power in powers)
        size = natural + self.chance.uniform(-self.spread, self.spread)
        if self.chance.random() < self.extreme:
            size = natural + self.chance.choice((self.chance.uniform(-EXTREME, EXTREME), EXTREME, -EXTREME))
        value = float(f"{10.0 ** min(max(size, -300.0), 300.0):.4g}")
        if sign != "positive" and self.chance.random() < 0.1:
            return 0.0
        return -value if sign == "any" and self.chance.random() < 0.4 else value

    def _written(self, value: float, dimension: str | Dimension) -> Any:
        if self.code or dimension == "dimensionless":
            return value
        return f"{value!r} {'rad' if dimension == 'angle' else _unit(dimension)}"

    def _between(self, low: float, high: float, above: bool, below: bool) -> float:
        """Between limits, or at one of them."""
        if self.chance.random() < self.extreme + 0.02:
            at_low = math.nextafter(low, high) if above else low
            return self.chance.choice((at_low, math.nextafter(high, low) if below else high))
        if low >= 0.0 and high > 100.0 * max(low, 1e-3):
            least = max(low, 1e-3 * min(high, 1.0))
            return float(f"{10 ** self.chance.uniform(math.log10(least), math.log10(high)):.4g}")
        return float(f"{self.chance.uniform(low, high):.4g}")


def _entropy(gamma: float) -> tuple[Dimension, str]:
    return pressure_constant_dimension(gamma), "not negative"


def _unit(dimension: str | Dimension) -> str:
    if isinstance(dimension, str):
        return si_unit(dimension) if dimension != "magnetic_field" else "T"
    return " ".join(f"{unit}({power:.8f})" for unit, power in zip(("kg", "m", "s"), dimension, strict=True))


def _bounds(limits: list[Any]) -> tuple[float, float, bool, bool] | None:
    low: list[tuple[Any, bool]] = [(each.ge, False) for each in limits if isinstance(each, Ge)]
    low += [(each.gt, True) for each in limits if isinstance(each, Gt)]
    high: list[tuple[Any, bool]] = [(each.le, False) for each in limits if isinstance(each, Le)]
    high += [(each.lt, True) for each in limits if isinstance(each, Lt)]
    if not low or not high:
        return None
    return float(low[0][0]), float(high[0][0]), low[0][1], high[0][1]


def _fits_together(owner: str, found: dict[str, Any], chance: random.Random) -> None:
    """What chance would hardly ever find: shares that are 1 together, numbers that rise, axes at right angles."""
    for name in ("densities", "times"):
        if name in found:
            found[name] = sorted(found[name], key=lambda value: float(str(value).split()[0]))
    if "axes_at_start" in found:
        turned, _ = np.linalg.qr([[chance.gauss(0, 1) for _ in range(3)] for _ in range(3)])
        found["axes_at_start"] = [[float(x) for x in row] for row in turned]
    if owner == "LayeredPlanet":
        total = sum(layer["mass_fraction"] for layer in found["layers"])
        for layer in found["layers"]:
            layer["mass_fraction"] /= total
    if owner == "PiecewisePolytropicFluid":
        found["gammas"] = [chance.choice(found["gammas"]) for _ in range(len(found["densities"]) + 1)]
    if owner == "Change":
        found["factors"] = [chance.choice(found["factors"]) for _ in found["times"]]


def _region() -> type[BaseModel]:
    return get_args(schema.Scene.model_fields["regions"].annotation)[1]


def _written(tables: dict[str, Any]) -> str:
    """As toml_text, with lists of tables as sections: one line would be too long."""
    plain = {key: value for key, value in tables.items() if not _lists_tables(value)}
    return (
        "\n\n".join([toml_text(plain), *_sections((), {key: tables[key] for key in tables if key not in plain})]) + "\n"
    )


def _lists_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], dict)


def _sections(path: tuple[str, ...], tables: dict[str, Any]) -> Iterator[str]:
    for key, items in tables.items():
        for item in items:
            lines = [f"[[{'.'.join(map(toml_key, (*path, key)))}]]"]
            lines += [
                f"{toml_key(name)} = {toml_value(value)}" for name, value in item.items() if not _lists_tables(value)
            ]
            yield "\n".join(lines)
            yield from _sections((*path, key), {name: value for name, value in item.items() if _lists_tables(value)})
