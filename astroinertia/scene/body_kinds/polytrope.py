"""Polytropes in a scene."""

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
