"""Bodies whose density is a power of the radius, in a scene."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from astroinertia.scene.body_kinds.stretched import Sized, profiles
from astroinertia.scene.dimensional import Real


class PowerLawBody(Sized):
    """A sphere or ellipsoid with rho ~ r^-exponent (Evrard's cloud has 1)."""

    kind: Literal["power_law"]
    rank: ClassVar[int] = 4
    exponent: Annotated[Real, Field(ge=0.0, lt=3.0)] = Field(description="exponent of rho ~ r^-exponent")
    shape: ClassVar[str] = "exponent"

    @property
    def homogeneous(self) -> bool:
        """That of exponent 0 is."""
        return self.exponent == 0.0

    def profile(self) -> Any:
        """The power of r."""
        return profiles().power_law(self.exponent)
