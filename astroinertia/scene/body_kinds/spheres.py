"""Spheres and ellipsoids of a profile in closed form, in a scene."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from astroinertia.scene.body_kinds.stretched import Sized, profiles
from astroinertia.scene.dimensional import Real


class PolytropeBody(Sized):
    """A polytrope (Lane-Emden), stretched along its axes."""

    kind: Literal["polytrope"]
    rank: ClassVar[int] = 1
    index: Annotated[Real, Field(ge=0.0, lt=5.0)] = Field(description="polytropic index n: P ~ rho^(1 + 1/n)")
    shape: ClassVar[str] = "index"
    has_core: ClassVar[bool] = True

    @property
    def homogeneous(self) -> bool:
        """That of index 0 is."""
        return self.index == 0.0

    @property
    def polytropic_index(self) -> float:
        """Its index."""
        return self.index

    @property
    def settles(self) -> bool:
        """All but that of index 0, whose pressure no gas has."""
        return self.index > 0

    def profile(self) -> Any:
        """Lane and Emden's."""
        return profiles().polytrope(self.index)

    def central(self, mass: float, radius: float) -> tuple[float, float]:
        """By Lane and Emden's constants."""
        from astroinertia.bodies.polytrope import Polytrope

        star = Polytrope(self.index, mass, radius)
        return star.central_pressure, star.central_density


class UniformBody(Sized):
    """A sphere or ellipsoid of uniform density."""

    kind: Literal["uniform"]
    rank: ClassVar[int] = 3
    has_core: ClassVar[bool] = True

    @property
    def homogeneous(self) -> bool:
        """It is."""
        return True

    def profile(self) -> Any:
        """Of one density."""
        return profiles().uniform()


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
