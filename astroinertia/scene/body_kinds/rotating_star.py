"""Rotating stars in equilibrium, in a scene."""

import math
import re
from dataclasses import replace
from functools import lru_cache
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from astroinertia.errors import NumericalError, SceneError
from astroinertia.scene.body_kinds.stretched import profiles
from astroinertia.scene.dimensional import AngularMomentum, AngularVelocity, Duration, Length, Mass, Real
from astroinertia.scene.initial_body import (
    OF_BREAK_UP,
    Body,
    Count,
    Fraction,
    Perturbation,
    exactly_one,
    law_with_scale,
    spin_of,
)

StarLaw = Literal["rigid", "j_constant", "v_constant", "maclaurin"]


class RotatingStarBody(Body):
    """A rotating polytrope in equilibrium (self-consistent field), up to mass shedding; it turns about z."""

    kind: Literal["rotating_star"]
    rank: ClassVar[int] = 6
    structure: ClassVar[str] = "spheres.rotating"
    shape: ClassVar[str] = "index"
    settles: ClassVar[bool] = True
    rotates_itself: ClassVar[bool] = True
    particles: Count | None = Field(default=None, description="number of particles (model sph)")
    mass: Mass = Field(description="total mass")
    radius: Length = Field(description="equatorial radius of a rotating_star")
    index: Annotated[Real, Field(gt=0.0, le=4.5)] = Field(description="polytropic index n: P ~ rho^(1 + 1/n)")
    law: StarLaw = Field(
        default="rigid",
        description="rotation law, as in body.rotation; or maclaurin: rings of equal mass have the angular momentum "
        "that those of a Maclaurin spheroid have",
    )
    scale: Length | None = Field(default=None, description="length over which a law that is not rigid falls off")
    perturbation: Perturbation | None = Field(default=None, description="a density that is uneven about the z axis")
    axis_ratio: Annotated[Real, Field(gt=0.0, le=1.0)] | None = Field(
        default=None, description="polar over equatorial radius; or another of breakup_fraction to angular_momentum"
    )
    breakup_fraction: Fraction | None = Field(default=None, description=OF_BREAK_UP)
    t_over_w: Annotated[Real, Field(ge=0.0, lt=0.5)] | None = Field(default=None, description="T/|W| of the star")
    rate: AngularVelocity | None = Field(default=None, description="angular velocity on the star's axis")
    period: Duration | None = Field(default=None, description="rotation period on the star's axis")
    angular_momentum: AngularMomentum | None = Field(default=None, description="total angular momentum of the star")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.rotation is not None:
            raise ValueError("has a table rotation, but a rotating_star turns as its own law and axis_ratio say.")
        exactly_one(self, "axis_ratio", "breakup_fraction", "t_over_w", "rate", "period", "angular_momentum")
        law_with_scale(self)
        return self

    @property
    def spin(self) -> Any:
        """The star itself."""
        return self

    @property
    def volume_ratio(self) -> float:
        """By its axes, as of a spheroid: Maclaurin's, where its T/|W| is given."""
        if self.t_over_w is None:
            return self.axis_ratio or 1.0
        from astroinertia.bodies.maclaurin import from_energy_ratio

        return from_energy_ratio(self.t_over_w).c_over_a

    def profile(self) -> Any:
        """That of the polytrope at rest."""
        return profiles().polytrope(self.index)

    @property
    def quickly_known(self) -> bool:
        """Whether a plan can solve for the star: with the law maclaurin, that takes as long as some runs."""
        return self.law != "maclaurin"

    def equilibrium(self, gravitational_constant: float) -> Any:
        """The RotatingStar that it is; SceneError, with the limit, where there is none."""
        gravity = gravitational_constant * self.mass / self.radius**3
        rate, spin = math.sqrt(gravity), self.mass * self.radius**2 * math.sqrt(gravity)
        wanted = {
            "axis_ratio": self.axis_ratio,
            "t_over_w": self.t_over_w,
            "breakup_fraction": self.breakup_fraction,
            "period": None if self.period is None else self.period * rate,
            "spin": None if self.rate is None else self.rate / rate,
            "angular_momentum": None if self.angular_momentum is None else self.angular_momentum / spin,
        }
        ((quantity, value),) = ((name, value) for name, value in wanted.items() if value is not None)
        key = "rate" if quantity == "spin" else quantity
        scale = None if self.scale is None else self.scale / self.radius
        if value < 0.0:
            raise SceneError(f"[body] {key} must not be negative, for a rotating_star turns about z.")
        try:
            star = _unit_star(self.index, self.law, scale, quantity, value)
        except (ValueError, NumericalError) as error:
            size = {"period": 1.0 / rate, "spin": rate, "angular_momentum": spin}.get(quantity, 1.0)
            unit = {"period": " s", "spin": " rad s-1", "angular_momentum": " kg m2 s-1"}.get(quantity, "")
            unit = "" if gravitational_constant == 1.0 else unit
            limit = ""
            if isinstance(error, NumericalError):
                last = _last_star(self.index, self.law, scale)
                fastest = last.angular_velocity
                most = {
                    "axis_ratio": last.field.axis_ratio, "period": 2.0 * math.pi / fastest if fastest else math.inf,
                    "spin": fastest, "breakup_fraction": last.keplerian_fraction,
                    "t_over_w": last.rotational_to_gravitational, "angular_momentum": last.angular_momentum,
                }[quantity]  # fmt: skip
                bound = "least" if quantity in ("axis_ratio", "period") else "most"
                limit = f"; the {bound} {key} is {most * size:.4g}{unit}"
                limit += "" if key == "axis_ratio" else f", at axis ratio {last.field.axis_ratio:.4g}"
            reason = str(error).rpartition(", and ")[2]
            if key != "axis_ratio":  # where the search ended
                reason = re.sub(r"with axis ratio \S+ and ", "with ", reason)
            raise SceneError(f"[body] {key} of {value * size:.6g}{unit}: {reason}{limit}.") from None
        return replace(
            star, mass=self.mass, equatorial_radius=self.radius, gravitational_constant=gravitational_constant
        )

    def turning(self, tensor: np.ndarray, gravitational: float | None) -> dict[str, Any]:
        """An estimate for the law maclaurin, whose star takes long to solve for: as the sphere of its radius, with the
        T/|W| that Maclaurin's spheroid has at its axis ratio.
        """
        assert gravitational is not None  # it has a profile
        from astroinertia.bodies.maclaurin import from_axis_ratio  # only here: most scenes have no such star

        moment = float(tensor[2, 2])
        if self.breakup_fraction is not None:
            orbit = (5.0 - self.index) * gravitational / (3.0 * self.mass * self.radius**2)  # as of it at rest
            spin = self.breakup_fraction * math.sqrt(orbit)
        elif self.axis_ratio is not None:
            ratio = from_axis_ratio(self.axis_ratio).rotational_to_gravitational
            spin = math.sqrt(2.0 * ratio * gravitational / moment)
        else:
            spin = spin_of(self, moment, gravitational)
            assert spin is not None
        rotational = 0.5 * moment * spin**2
        backwards = (self.rate or self.angular_momentum or 0.0) < 0.0
        axis = (0.0, 0.0, -1.0 if backwards else 1.0)
        shear = 0.0 if self.law == "rigid" else spin
        return {"spin": spin, "spin_axis": axis, "wobble": 0.0, "rotational": rotational, "shear": shear}


@lru_cache(maxsize=8)
def _unit_star(index: float, kind: str, scale: float | None, quantity: str, value: float) -> Any:
    """In units of its mass, equatorial radius and G."""
    from astroinertia.bodies.rotating_star import rotating_star_with  # only scenes with stars solve for one

    return rotating_star_with(quantity, value, *_matter_and_law(index, kind, scale))


@lru_cache(maxsize=8)
def _last_star(index: float, kind: str, scale: float | None) -> Any:
    """The flattest, as closely as a sentence says it, in the same units."""
    from astroinertia.bodies.rotating_star import ROUGHLY, end_of_sequence

    return end_of_sequence(*_matter_and_law(index, kind, scale), within=ROUGHLY)


def _matter_and_law(index: float, kind: str, scale: float | None) -> tuple[Any, Any]:
    from astroinertia.bodies.maclaurin_momentum import MomentumLaw
    from astroinertia.bodies.rotation_laws import RotationLaw
    from astroinertia.matter.barotropes import polytropic_matter

    return polytropic_matter(index), MomentumLaw() if kind == "maclaurin" else RotationLaw(kind, scale)
