"""Dyson's gas ellipsoids in a scene."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from astroinertia.scene.body_kinds.stretched import Sized, profiles
from astroinertia.scene.dimensional import Real


class DysonBody(Sized):
    """Dyson's isentropic gas ellipsoid: rho ~ (1 - s^2)^(1/(gamma-1)), s^2 = sum (x/a)^2."""

    kind: Literal["dyson"]
    rank: ClassVar[int] = 5
    gamma: Annotated[Real, Field(ge=1.001, le=10.0)] = Field(description="adiabatic exponent of the profile")
    shape: ClassVar[str] = "gamma"
    has_core: ClassVar[bool] = True
    isentropic: ClassVar[bool] = True

    def profile(self) -> Any:
        """The power of 1 - s^2."""
        return profiles().dyson(self.gamma)
