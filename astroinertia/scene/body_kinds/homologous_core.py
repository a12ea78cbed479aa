"""Cores that collapse homologously, in a scene."""

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from astroinertia.scene.body_kinds.stretched import Sized, profiles
from astroinertia.scene.dimensional import Real
from astroinertia.scene.initial_body import PlanLine


class HomologousCoreBody(Sized):
    """The core of a star that collapses homologously, of a gas of exponent 4/3 (Goldreich & Weber 1980)."""

    kind: Literal["homologous_core"]
    rank: ClassVar[int] = 2
    collapse_rate: Annotated[Real, Field(ge=0.0, le=1.0)] = Field(
        default=1.0, description="how fast it falls: lambda of Goldreich & Weber over the largest that there is"
    )
    start: Literal["parabolic", "rest"] = Field(
        default="parabolic",
        description="how it falls at first: parabolic (a ~ (t0 - t)^(2/3), which stays similar to itself) or rest",
    )
    structure: ClassVar[str] = "spheres.homologous"
    shape: ClassVar[str] = "collapse_rate"
    has_core: ClassVar[bool] = True
    settles: ClassVar[bool] = True
    homologous: ClassVar[bool] = True

    def core(self, mass: float, radius: float, gravitational_constant: float = 1.0) -> Any:
        """The exact collapse (bodies.homologous_core.HomologousCore)."""
        from astroinertia.bodies.homologous_core import HomologousCore

        return HomologousCore(self.collapse_rate, mass, radius, self.start, gravitational_constant)

    def profile(self) -> Any:
        """Goldreich and Weber's."""
        return profiles().homologous_core(self.collapse_rate)

    def central(self, mass: float, radius: float) -> tuple[float, float]:
        """By Goldreich and Weber's constants."""
        core = self.core(mass, radius)
        return core.central_pressure, core.central_density

    def expansion(self, mass: float, radius: float, gravitational_constant: float = 1.0) -> float:
        """Negative: that of its collapse."""
        return self.core(mass, radius, gravitational_constant).starting_rate

    @property
    def support(self) -> float:
        """Less than 1: the rest of gravity draws it together."""
        core = self.core(1.0, 1.0)
        return -core.internal_energy / core.gravitational_energy

    def describe(self, scene: Any) -> list[PlanLine]:
        """With the end of its collapse."""
        core = self.core(self.mass, self.radius, scene.gravitational_constant)
        lines = super().describe(scene)
        ends = math.isfinite(core.collapse_time)
        rate = f"over at {scene.shown(core.collapse_time, 'time')}" if ends else "nothing draws it in"
        return [*lines, ("collapse", f"starts {'from ' * (self.start == 'rest')}{self.start}", rate)]

    def check(self, scene: Any) -> None:
        """Particles settle to its flow with entropies of their own."""
        super().check(scene)
        fluid = scene.equation_of_state
        if not (scene.model == "sph" and self.relax and scene.has_equilibrium):
            return
        if self.rotation is not None:
            raise ValueError(
                "[body] of the kind homologous_core settles without rotation: take the rotation away, or relax = false."
            )
        own = [name for name in ("specific_internal_energy", "entropy") if getattr(self, name) is not None]
        if own or fluid is None or fluid.kind != "ideal" or abs(fluid.gamma - 4.0 / 3.0) > 1e-6:
            what = f"has {own[0]}" if own else "has another equation_of_state"
            raise ValueError(
                "[body] of the kind homologous_core settles as an ideal gas of gamma = 1.3333333333333333, whose "
                f"entropy it finds itself, but {what}: change that, or take relax = false."
            )
