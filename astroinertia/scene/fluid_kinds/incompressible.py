"""Incompressible fluids in a scene."""

from typing import ClassVar, Literal

from astroinertia.scene.fluids import Fluid


class IncompressibleFluid(Fluid):
    """Every part of the body keeps its density; the pressure is what that takes (model ellipsoid)."""

    kind: Literal["incompressible"]
    rank: ClassVar[int] = 7
