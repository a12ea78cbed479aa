"""An initial body that is not of this package, in a scene: its options, and what its class states of it for plans.

Tests: tests/unit/test_body_door.py.
"""

import math
from dataclasses import fields
from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from astroinertia.effects.characteristic import Characteristic
from astroinertia.errors import SceneError
from astroinertia.scene.dimensional import options_in_code_units
from astroinertia.scene.initial_body import Body, Count, PlanLine, option_lines
from astroinertia.units import DIMENSIONLESS, CodeUnits, shown as plain


class OwnBody(Body):
    """A body that is not of this package, which scene.load makes of a kind that it knows from outside.

    name: its kind in the scene. options: in SI, or in code units where the scene is. entry: what its class says.
    """

    kind: Literal["own"]
    name: str
    options: dict[str, Any]
    entry: Any = Field(exclude=True, repr=False)
    particles: Count | None = Field(default=None, description="number of particles")
    relax: bool = Field(default=False, description="must be false: its class places its particles")
    structure: ClassVar[str] = ""
    placing: ClassVar[str] = "placing.of_class"
    moments_from: ClassVar[str] = "rigid.of_class"
    turns_with_axis: ClassVar[bool] = False
    laid_out: ClassVar[bool] = False
    rotates_itself: ClassVar[bool] = True

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.relax or "placement" in self.model_fields_set:
            raise ValueError(f"has {'relax' if self.relax else 'a placement'}, but its class places its particles.")
        if self.pressure_fraction is not None:
            raise ValueError("has a pressure_fraction, but no equilibrium that is known.")
        return self

    @property
    def title(self) -> str:
        """Its name."""
        return self.name

    @property
    def models(self) -> tuple[str, ...]:
        """As its class says."""
        return self.entry.models

    @property
    def without_heat(self) -> str:
        """It may have no energies of its own."""
        return f"of the kind {self.name}, which has no `internal_energy`,"

    @property
    def mass(self) -> float | None:
        """As it states, in the units of the scene."""
        return self._stated("mass")

    @property
    def radius(self) -> float | None:
        """As it states, in the units of the scene."""
        return self._stated("radius")

    def made(self, units: CodeUnits = DIMENSIONLESS) -> Any:
        """The body (sph.placed.Body) in those units; as the scene has its numbers, without any.

        ValueError, in one sentence, where its options contradict each other.
        """
        return self.entry.build(options_in_code_units(self.options, self.entry.options, units))

    def refused(self, what: object) -> SceneError:
        """The error that names it and where it comes from."""
        return SceneError(f"[body] the {self.name} of {self.entry.origin} {plain(str(what), 300)}.")

    def _stated(self, name: str) -> float | None:
        with self.entry.at_work():
            value = getattr(self.made(), name, None)
        if value is None:
            return None
        if not isinstance(value, int | float) or not (math.isfinite(value) and value > 0.0):
            raise self.refused(f"states a {name} that is no positive number")
        return float(value)

    def check(self, scene: Any) -> None:
        """Its particles are needed by every model that takes it, and units where it states none."""
        super().check(scene)
        if self.particles is None:
            raise ValueError("[body] particles is missing (number of particles), by which it is made.")
        if scene.units in (None, "SI") and (self.mass is None or self.radius is None):
            raise ValueError(
                f'[units] with mass and length (or units = "code") is needed for a body of kind {self.name}, which '
                "does not state mass and radius."
            )
        self.characteristic()

    def characteristic(self) -> dict[str, Any]:
        """What its class states."""
        try:
            with self.entry.at_work(TypeError, ValueError):
                stated = {**self.made().characteristic(), "mass": self.mass, "radius": self.radius}
            odd = sorted(set(stated) - {field.name for field in fields(Characteristic)})
            numbers = [value for value in stated.values() if value is not None]
            right = not odd and all(np.isfinite(np.asarray(value, dtype=float)).all() for value in numbers)
        except (TypeError, ValueError) as error:
            raise self.refused(f"has a `characteristic` that cannot be read ({error})") from None
        if not right:
            raise self.refused(f"states {odd[0]}, which is none of the characteristic numbers" if odd
                               else "states a characteristic number that is not finite")  # fmt: skip
        return stated

    def describe(self, scene: Any) -> list[PlanLine]:
        """What its class says of it, where it comes from, and its options."""
        lines: list[PlanLine] = [
            ("kind", self.name.replace("_", " "), self.entry.described),
            ("particles", f"{self.particles}", f"placed by its class, seed {self.seed}"),
        ]
        stated = {"mass": "mass", "radius": "length"}
        for name, dimension in stated.items():
            if name not in self.options and (value := getattr(self, name)) is not None:
                lines.append((name, scene.shown(value, dimension)))
        if unstated := [name for name in stated if getattr(self, name) is None]:
            lines.append((" and ".join(unstated), "not stated", "so no sizes of effects follow from them"))
        return lines + option_lines(self.options, self.entry.options, scene)


KEYS = tuple(name for name in OwnBody.model_fields if name not in ("name", "options", "entry"))  # of any kind
