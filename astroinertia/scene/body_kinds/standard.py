"""Problems with known solutions, on which hydrodynamics is tested, in a scene."""

from typing import Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from astroinertia.scene.body_kinds.stretched import Unknown
from astroinertia.scene.initial_body import Body, Count, PlanLine

_MANY = 20_000  # particles, of which lattices have about as many as they are asked for
UNBOXED = ("noh", "keplerian_disc")  # standard problems that end before a box would
_STIFFEST = 6.8  # gamma of a point explosion: from 7 on it is empty inside, and just below its flow is all at the shock


class StandardBody(Unknown, Body):
    """The gas of a problem with a known solution, on which hydrodynamics is tested (code units)."""

    kind: Literal["standard"]
    rank: ClassVar[int] = 11
    models: ClassVar[tuple[str, ...]] = ("sph",)
    structure: ClassVar[str] = ""
    placing: ClassVar[str] = "placing.of_problem"
    composite: ClassVar[bool] = True
    boxed: ClassVar[bool] = True
    laid_out: ClassVar[bool] = False
    problem: Literal["sod", "strong_tube", "sedov", "noh", "gresho", "kelvin_helmholtz", "square", "keplerian_disc"] = (
        Field(description="which problem")
    )
    particles: Count | None = Field(default=None, description="number of particles, about: lattices have their own")
    relax: bool = Field(default=False, description="settle the particles to equilibrium before the start")

    @model_validator(mode="after")
    def _has_its_own_state(self) -> Self:
        own = ("specific_internal_energy", "entropy", "pressure_fraction", "velocity_gradient", "rotation", "change")
        own_keys = [name for name in own if getattr(self, name) is not None] + ["relax"] * self.relax
        if own_keys:
            raise ValueError(f"has {own_keys[0]}, but a standard problem has a state of its own.")
        return self

    def check(self, scene: Any) -> None:
        """It needs code units, an ideal gas, and the box that its problem fills."""
        if scene.model != "sph" or scene.bodies:
            raise ValueError("[body] of the kind standard is for the model sph, and alone.")
        super().check(scene)
        if not scene.dimensionless:
            raise ValueError('[body] of the kind standard needs a scene in code units: units = "code".')
        if scene.equation_of_state is None or scene.equation_of_state.kind != "ideal":
            raise ValueError("[body] of the kind standard needs an equation_of_state of the kind ideal.")
        gamma = scene.equation_of_state.gamma
        if self.problem == "sedov" and gamma > _STIFFEST:
            raise ValueError(
                f"[equation_of_state] gamma of the problem sedov must be at most {_STIFFEST}, not {gamma:g}: from 7 on "
                "the explosion is empty inside."
            )
        without = self.problem in UNBOXED
        if without != (scene.box is None) or (scene.box is not None and not all(scene.box.repeats)):
            needs = "ends by itself and has no box" if without else "fills a box that is periodic along all axes"
            raise ValueError(f"[body] the problem {self.problem} {needs}.")

    def placed(self, scene: Any, asked: float) -> float:
        """As many as lattices have that fill the box with whole cells."""
        if asked > _MANY:
            return asked
        from astroinertia.test_problems.matter import standard  # only here: other bodies need no problem

        lengths = scene.box_lengths
        return len(standard(self.problem).place(round(asked), lengths, scene.equation_of_state.gamma).mass)

    def describe(self, scene: Any) -> list[PlanLine]:
        """Its problem."""
        assert self.particles is not None
        placed = self.placed(scene, self.particles)
        return [("problem", self.problem), ("particles", f"{placed}", f"on lattices, of {self.particles} asked for")]
