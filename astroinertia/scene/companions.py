"""Other bodies of a scene, as point masses, on orbits or in its gas: validated and frozen, in SI (or code units)."""

from collections.abc import Callable
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from astroinertia.errors import SceneError
from astroinertia.scene.dimensional import Angle, Duration, Length, Mass, Real
from astroinertia.scene.fluids import Part
from astroinertia.scene.places import Position, Velocity
from astroinertia.scene.source import file_of_scene
from astroinertia.units import CodeUnits

BODY = "body"  # the name of the scene's own body among them
BARYCENTRE = "barycentre"  # of the body and of the companions listed before
MOST_COMPANIONS = 100


class Companion(Part):
    """A point mass that goes round the body, or that the body goes round: by elements, or by position and velocity."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_\-]{0,63}$")] = Field(description="what it is called")
    mass: Mass = Field(description="its mass")
    around: str = Field(
        default=BODY,
        description='what its orbit is relative to: "body", a companion listed before, or "barycentre" of all these',
    )
    position: Position | None = Field(default=None, description="position relative to that, instead of elements")
    velocity: Velocity | None = Field(default=None, description="velocity relative to that, with position")
    semi_major_axis: Length | None = Field(default=None, description="semi-major axis; or give the period")
    period: Duration | None = Field(default=None, description="orbital period, from which the semi-major axis follows")
    eccentricity: Annotated[Real, Field(ge=0.0, lt=1.0)] = Field(default=0.0, description="eccentricity")
    inclination: Angle = Field(default=0.0, description="inclination to the x-y plane")
    node: Angle = Field(default=0.0, description="longitude of the ascending node, from x")
    pericentre: Angle = Field(default=0.0, description="argument of the pericentre, from the node")
    mean_anomaly: Angle = Field(default=0.0, description="mean anomaly at time 0")

    @model_validator(mode="after")
    def _one_orbit(self) -> Self:
        vectors, size = (self.position, self.velocity), (self.semi_major_axis, self.period)
        if vectors != (None, None):
            if None in vectors:
                raise ValueError("needs both position and velocity, or neither.")
            if any(self.position or ()) is False:
                raise ValueError("has its position at what it goes round.")
            keys = {"semi_major_axis", "period", "eccentricity", "inclination", "node", "pericentre", "mean_anomaly"}
            keys &= self.model_fields_set
            if keys:
                raise ValueError(f"has position and velocity, so {min(keys)} must not be given.")
        elif size.count(None) != 1:
            raise ValueError("needs a position and velocity, or one of semi_major_axis and period.")
        return self


class Orbits(Part):
    """How the companions' orbits are computed (by REBOUND)."""

    integrator: Literal["ias15", "whfast"] = Field(
        default="ias15", description="ias15: adaptive, to round-off; whfast: symplectic, for long runs"
    )
    timestep: Duration | None = Field(
        default=None, description="of whfast; without it, a fortieth of the shortest period"
    )
    back_reaction: bool = Field(
        default=False,
        description="the body's quadrupole acts back on the orbits (model rigid, with the effect "
        "gravity_gradient), which are then evolved with the spin",
    )
    archive: Annotated[str, Field(min_length=1, max_length=512)] | None = Field(
        default=None,
        description="a REBOUND SimulationArchive to take the companions' orbits from, relative to the scene",
    )
    body: Annotated[str, Field(min_length=1, max_length=64)] | None = Field(
        default=None,
        description='name of the particle in it that is the body, "particle 1" where it has none; without it that '
        'named "body", else the first',
    )

    @model_validator(mode="after")
    def _body_of_archive(self) -> Self:
        if self.body is not None and self.archive is None:
            raise ValueError("has body, which only archive uses.")
        return self


def archive_at_start(orbits: Orbits, origin: str | None, units: CodeUnits) -> Any:
    """The first snapshot of the archive as a `rebound.Simulation` in code units, whose particle 0 is the body.

    SceneError that says why there is none.
    """
    from astroinertia.orbits import rebound_archive  # only here: other scenes do without REBOUND

    try:
        return rebound_archive.first_snapshot(file_of_scene(origin, str(orbits.archive)), orbits.body, units)
    except ValueError as error:
        raise SceneError(f"[orbits] archive: {str(error).rstrip('.')}.") from None


def check_names(companions: tuple[Companion, ...]) -> None:
    """ValueError where two companions share a name, or one goes round what is not listed before it."""
    names = [BODY, BARYCENTRE]
    for companion in companions:
        if companion.name in names:
            problem = "twice" if companion.name not in (BODY, BARYCENTRE) else "which is taken"
            raise ValueError(f"[[companions]] has the name {companion.name} {problem}.")
        if companion.around not in names:
            raise ValueError(
                f"[[companions]] {companion.name} goes around {companion.around}, which is not listed before it "
                f"(known are {', '.join(names)})."
            )
        names.append(companion.name)


MOST_SINKS = 100


class Sink(Part):
    """A sink that is there from the start, such as a star amid its disc (with the effect sinks)."""

    mass: Mass = Field(description="its mass at the start")
    position: Position | None = Field(default=None, description="where it is; at the origin without it")
    velocity: Velocity | None = Field(default=None, description="its velocity; at rest without it")

    def plan_line(self, shown: Callable[[float, str], str]) -> tuple[str, str, str]:
        """The line of the plan: name, mass and where it is, with quantities as `shown` writes them."""
        place = ", ".join(shown(x, "length") for x in self.position or (0.0, 0.0, 0.0))
        return ("mass", shown(self.mass, "mass"), f"at ({place})")
