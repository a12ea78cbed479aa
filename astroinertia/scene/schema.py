"""The scene: what a person may ask for, validated and frozen.

Every quantity is a float in SI units once validated (in code units, G = 1, where the scene says `units = "code"`). The
field descriptions are what `astroinertia new` writes as comments. Effects are checked in load.py, against the
entries of effects/catalogue.py.
"""

from collections.abc import Callable, Mapping
from inspect import Parameter, Signature
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, Field, model_validator

from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.effects.entries import Entry
from astroinertia.engines.few import FEW
from astroinertia.scene.box import Box
from astroinertia.scene.companions import MOST_COMPANIONS, MOST_SINKS, Companion, Orbits, Sink, check_names
from astroinertia.scene.dimensional import Duration, Length, Mass, Real, Whole, described, fraction
from astroinertia.scene.fluids import OwnFluid, Part, as_tuple
from astroinertia.scene.kinds import BODY_KINDS, AnyBody, AnyEquationOfState
from astroinertia.scene.own_body import OwnBody
from astroinertia.scene.places import MOST_BODIES, Orbit
from astroinertia.scene.regions import MOST_REGIONS, REGION_NAME, Region
from astroinertia.scene.text import toml_value, with_overrides
from astroinertia.sph.kernels import KERNELS, rising_neighbours
from astroinertia.units import GRAVITATIONAL_CONSTANT, Dimension, si_unit

MOST_RECORDS = 1e6  # a record holds some hundreds of numbers
MOST_SNAPSHOTS = 1e5
MOST_STEPS = 1e10
ORIGIN = ("source", "overrides", "origin")  # fields of a Scene that say where it came from
RECORD = (*ORIGIN, "reasons", "choice", "own", "observed")  # and why it is so; no keys of a scene


def _number_or_rising(value: Any) -> Any:
    value = fraction(value)
    if isinstance(value, str) and value != "rising":
        raise ValueError(f'must be a number, or "rising", not {described(value)}.')
    return value


class Numerics(Part):
    """How it is computed: engine, precision, kernel and time-step factors of particles; integrators of the others."""

    engine: Literal["numba_cpu", "xla"] = Field(
        default="numba_cpu", description="numba_cpu: threaded loops; xla: dense tiles, for GPUs and gradients"
    )
    precision: Literal["auto", "float64", "mixed"] = Field(
        default="float64",
        description=f"mixed: pair sums in float32, state in float64; auto: mixed for more than {FEW} particles, which "
        "compiles more and then steps faster",
    )
    devices: Annotated[Whole, Field(ge=1, le=65536)] = Field(
        default=1, description="devices that the engine xla shares its pair sums out over"
    )
    kernel: Literal["cubic", "quartic", "quintic", "wendland_c2", "wendland_c4", "wendland_c6"] = Field(
        default="wendland_c2", description="smoothing kernel"
    )
    eta: Annotated[Real, Field(ge=0.8, le=3.0)] | None = Field(
        default=None,
        description="smoothing length over particle spacing; without it, what is recommended for the kernel",
    )
    neighbours: Annotated[
        Annotated[Real, Field(ge=20.0, le=1000.0)] | Literal["rising"] | None, BeforeValidator(_number_or_rising)
    ] = Field(
        default=None,
        description="mean number of neighbours, another way to give eta; rising: the kernel's own times the square "
        "root of the number of particles over 1000, with which sums over neighbours converge, too",
    )
    smoothing_tolerance: Annotated[Real, Field(ge=1e-15, le=1e-2)] = Field(
        default=1e-8, description="relative tolerance of the smoothing lengths"
    )
    courant: Annotated[Real, Field(gt=0.0, le=1.0)] = Field(
        default=0.3, description="time step over smoothing length / signal speed (Monaghan 1992: 0.3)"
    )
    acceleration_factor: Annotated[Real, Field(gt=0.0, le=2.0)] = Field(
        default=0.25, description="time step over sqrt(smoothing length / acceleration) (Monaghan 1989: 0.25)"
    )
    energy_factor: Annotated[Real, Field(gt=0.0, le=2.0)] = Field(
        default=0.25, description="time step over internal energy / its rate of change"
    )
    timesteps: Literal["global", "individual"] = Field(
        default="global",
        description="individual: every particle has a step of its own, a power of two of the shortest (numba_cpu)",
    )
    max_timestep: Duration | None = Field(default=None, description="the time step never exceeds this")
    free_fall_factor: Annotated[Real, Field(gt=0.0, le=100.0)] | None = Field(
        default=None,
        description="the time step, with individual ones the base step that records are taken after, never exceeds "
        "this times (G density)^(-1/2) of the densest matter (model sph)",
    )
    integrator: Literal["adaptive", "splitting"] = Field(
        default="adaptive",
        description="of the models without particles: adaptive, to a tolerance; splitting (rigid), which keeps the "
        "angular momentum for ever",
    )
    tolerance: Annotated[Real, Field(ge=1e-14, le=1e-2)] = Field(
        default=1e-12, description="relative error of a step that adaptive allows"
    )
    steps_per_rotation: Annotated[Real, Field(ge=4.0, le=1e5)] = Field(
        default=40.0, description="steps of splitting in a rotation of the body"
    )
    order: Literal[2, 4, 6, 8] = Field(default=8, description="order of splitting")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.eta is not None and self.neighbours is not None:
            raise ValueError("has both eta and neighbours, which say the same thing; keep one.")
        if self.timesteps == "individual" and self.engine == "xla":
            raise ValueError('timesteps = "individual" needs the engine numba_cpu; xla takes global steps.')
        if self.devices > 1 and self.engine != "xla":
            raise ValueError("devices are for the engine xla; numba_cpu takes all cores of one machine.")
        return self


class TimeSpan(Part):
    """From time 0 to the end."""

    end: Duration = Field(description="the run ends here")
    max_steps: Annotated[Whole, Field(ge=1, le=10**12)] | None = Field(
        default=None, description="or after so many steps"
    )


class Output(Part):
    """What is written and how often; without any of them, 200 records and 10 snapshots a run."""

    series_every: Duration | None = Field(default=None, description="time between records of the series")
    series_steps: Annotated[Whole, Field(ge=1, le=10**9)] | None = Field(
        default=None, description="steps between records, instead of series_every"
    )
    snapshot_every: Duration | None = Field(default=None, description="time between snapshots of all particles")
    align: bool = Field(
        default=True,
        description="particles' time steps are shortened to meet the times of records and snapshots; false: the first "
        "step past each is taken",
    )
    checkpoint_seconds: Annotated[Real, Field(ge=0.0, le=1e6)] = Field(
        default=60.0, description="seconds of wall time between checkpoints; with 0, one after each step or record"
    )
    error_bars: bool = Field(
        default=False,
        description="estimate errors of the headline series, from companions: the same run with fewer particles, other "
        "steps or another tolerance",
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.series_every is not None and self.series_steps is not None:
            raise ValueError("has both series_every and series_steps; keep one.")
        return self


class Units(Part):
    """Code units (G = 1) that the run uses inside; without them, the body's mass and radius."""

    mass: Mass = Field(description="unit of mass")
    length: Length = Field(description="unit of length")


class Outside(NamedTuple):
    """What of a scene is not of this package: its table there, its kind, what its class says, and its options."""

    table: str
    kind: str
    entry: Entry
    options: dict[str, Any]


class _Called(type(BaseModel)):
    """What Scene(...) does: the tables of a scene are read as those of a file are."""

    def __call__(cls, tables: Any = MappingProxyType({}), /, **keys: Any) -> Any:
        from astroinertia.scene.load import of_tables  # which imports this module

        return of_tables({**tables, **keys} if isinstance(tables, Mapping) else tables)


class Scene(Part, metaclass=_Called):
    """A scene, from its tables in Python: values are text with units, quantities of astropy, NumPy's numbers, arrays.

    `effects` is a list of kinds, of tables with their kind, and of effects of your own, or a table of tables; `time`
    may be the end alone. All else is as in a file (`astroinertia guide scene`), and so is what is refused: SceneError.

    >>> scene = Scene(
    ...     body={"kind": "polytrope", "index": "3/2", "mass": "1 Msun", "radius": "1 Rsun"}, model="scaling",
    ...     effects=["gravity", {"kind": "dipole_braking", "field": "1 kG", "radius": "1 Rsun"}], time="1 yr",
    ... )
    >>> print(scene.body.index, scene == Scene.from_toml(scene.to_toml()))
    1.5 True

    `source` and `overrides` are the text it came from and the --set arguments, for the record. `reasons`: with
    effects = "auto", why each effect that was considered is on or off. `choice`: where settings were chosen for an
    accuracy, what is expected of them and why they are so. `own`: of the effects that it lists, those that are not of
    this package, by kind (effects.own). `observed`: of the observables that it lists (observables.own).
    """

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_\-]{0,63}$")] = Field(
        description="short name: letters, digits, _ and -; names the run's folder"
    )
    description: Annotated[str, Field(max_length=2000)] = Field(default="", description="what the scene is for")
    model: Literal["sph", "ellipsoid", "rigid", "scaling"] = Field(
        default="sph",
        description="which model answers the scene: sph (particles), ellipsoid (a deformation that is linear in "
        "position), rigid (no deformation, or a prescribed one) or scaling (conservation laws)",
    )
    units: Literal["code", "SI"] | Units | None = Field(
        default=None,
        description='"code": plain numbers with G = 1 everywhere; "SI": particle tables without units of their own are '
        "in SI; or a table with mass and length",
    )
    bodies: Annotated[tuple[AnyBody, ...], BeforeValidator(as_tuple), Field(min_length=2, max_length=MOST_BODIES)] = (
        Field(default=(), description="several bodies in place of one (model sph)")
    )
    body: AnyBody = Field(description="the body; of several, the first")
    orbit: Orbit | None = Field(default=None, description="an orbit that two bodies are on")
    equation_of_state: AnyEquationOfState | None = Field(
        default=None, description="of the fluid (not of the model rigid)"
    )
    companions: Annotated[tuple[Companion, ...], BeforeValidator(as_tuple), Field(max_length=MOST_COMPANIONS)] = Field(
        default=(), description="other bodies, as point masses on orbits"
    )
    orbits: Orbits = Field(default_factory=Orbits)
    sinks: Annotated[tuple[Sink, ...], BeforeValidator(as_tuple), Field(max_length=MOST_SINKS)] = Field(
        default=(), description="sinks that are there from the start (model sph, with the effect sinks)"
    )
    box: Box | None = Field(default=None, description="a periodic box (model sph)")
    effects: dict[str, dict[str, Any]] = Field(description="kind of each effect called for, with all its options")
    candidates: dict[str, dict[str, Any]] = Field(
        default_factory=dict, description='with effects = "auto": effects to choose from that need numbers'
    )
    accuracy: Annotated[Real, Field(ge=1e-12, le=0.3)] | None = Field(
        default=None,
        description="wanted relative accuracy of the observables: I_zz and the angular velocity at the end",
    )
    settings: Literal["chosen", "given"] = Field(
        default="chosen",
        description="where accuracy is asked for: chosen by pilot runs to have it, the model too unless the scene "
        "names one; or given, as they are written here, and accuracy only judges effects",
    )
    judged_by: Annotated[tuple[str, ...], BeforeValidator(as_tuple), Field(max_length=16)] = Field(
        default=(),
        description='series of the dataset that are to have the accuracy at the end, such as "inertia_tensor z z"; '
        "without any, I_zz and the angular velocity",
    )
    reasons: dict[str, str] = Field(default_factory=dict)
    choice: dict[str, str] = Field(default_factory=dict)
    regions: Annotated[dict[Annotated[str, Field(pattern=REGION_NAME)], Region], Field(max_length=MOST_REGIONS)] = (
        Field(default_factory=dict, description="parts of the body with a ledger of their own, by name")
    )
    observables: dict[str, dict[str, Any]] = Field(
        default_factory=dict, description="quantities of your own, recorded beside the others, with their options"
    )
    numerics: Numerics = Field(default_factory=Numerics)
    time: TimeSpan = Field(description='when the run ends, such as end = "33 ms"')
    output: Output = Field(default_factory=Output)
    source: str = ""
    overrides: tuple[str, ...] = ()
    origin: str | None = None
    own: dict[str, Any] = Field(default_factory=dict, exclude=True)
    observed: dict[str, Any] = Field(default_factory=dict, exclude=True)

    @classmethod
    def from_toml(cls, text: str) -> Self:
        """The scene in a TOML text, in which files are relative to the current folder; SceneError."""
        from astroinertia.scene.load import loads

        return loads(text, origin=str(Path.cwd()))  # type: ignore[return-value]

    def to_toml(self) -> str:
        """One TOML text that gives the scene back: what it came from, with what was set since in its place.

        Effects that were given as functions or classes are named in it; the text alone does not bring them back.
        """
        return with_overrides(self.source, self.overrides)

    def __eq__(self, other: object) -> bool:
        """Whether the same is to be run, whatever text it came from."""
        if not isinstance(other, Scene):
            return NotImplemented
        return all(getattr(self, name) == getattr(other, name) for name in Scene.model_fields if name not in ORIGIN)

    def __repr__(self) -> str:
        return f"Scene(name={self.name!r}, model={self.model!r}, effects={list(self.effects)})"

    __str__ = __repr__

    @property
    def entries(self) -> Mapping[str, Entry]:
        """What is known of every effect, by kind: those of the catalogue, then those of its own."""
        return {**CATALOGUE, **self.own}

    @property
    def own_classes(self) -> tuple[type, ...]:
        """The classes that were given from Python, which its text alone does not bring back."""
        return tuple(each.entry.made for each in self.outside if not each.entry.package)

    @property
    def outside(self) -> tuple[Outside, ...]:
        """Its effects, matter, bodies and observables, of those that are not of this package."""
        listed = {**self.candidates, **self.effects}
        bodies = {body.name: ("body", body) for body in self.bodies or (self.body,) if isinstance(body, OwnBody)}
        matter = [("equation_of_state", self.equation_of_state)] if isinstance(self.equation_of_state, OwnFluid) else []
        return (
            *(Outside("effects", kind, entry, listed[kind]) for kind, entry in self.own.items()),
            *(Outside(table, own.name, own.entry, own.options) for table, own in (*matter, *bodies.values())),
            *(Outside("observables", kind, entry, self.observables[kind]) for kind, entry in self.observed.items()),
        )

    def where_listed(self, kind: str) -> str:
        """The table that the user listed an effect by, for messages; by its kind where "auto" has chosen it alone."""
        if kind in self.candidates:
            return f"[candidates.{kind}]"
        return f"the effect {kind}" if kind in self.reasons else f"[effects.{kind}]"

    @property
    def dimensionless(self) -> bool:
        """Whether the scene is in code units, with G = 1 and no conversion at either end."""
        return self.units == "code"

    @property
    def gravitational_constant(self) -> float:
        """G in its units."""
        return 1.0 if self.dimensionless else GRAVITATIONAL_CONSTANT

    def shown(self, value: float, dimension: str | Dimension, digits: int = 6) -> str:
        """A number of it, in its units, as a person reads it."""
        unit = "" if self.dimensionless or dimension == "dimensionless" else f" {si_unit(dimension)}"
        return f"{value:.{digits}g}{unit}"

    def time_setting(self, value: float) -> str:
        """A time of it as settings have it."""
        return toml_value(value if self.dimensionless else f"{value!r} s")

    def with_bodies(self, changes: Callable[[Any], Mapping[str, Any]]) -> Self:
        """The scene with other values of fields of each of its bodies, as `changes` says of a body by name."""
        body, *others = (
            body.model_copy(update={name: value for name, value in changes(body).items() if hasattr(body, name)})
            for body in (self.body, *self.bodies)
        )
        return self.model_copy(update={"body": body, "bodies": tuple(others)})

    @property
    def particles(self) -> int | None:
        """The number of particles of all bodies; None where a body does not tell."""
        counts: list[Any] = [body.particles for body in self.bodies or (self.body,)]
        return None if None in counts else sum(counts)

    @property
    def precision(self) -> Literal["float64", "mixed"]:
        """Of the sums over pairs: as asked for, or by the number of particles; mixed where a body does not tell it."""
        asked = self.numerics.precision
        if asked == "auto":
            return "mixed" if self.particles is None or self.particles > FEW else "float64"
        return asked

    @property
    def has_companions(self) -> bool:
        """Whether it has companions, listed or from an archive."""
        return bool(self.companions) or self.orbits.archive is not None

    @property
    def box_lengths(self) -> np.ndarray:
        """Lengths of the box (3,), infinite without one."""
        return np.full(3, np.inf) if self.box is None else np.array(self.box.lengths)

    @property
    def has_equilibrium(self) -> bool:
        """Whether gravity and pressure both act, so that a body may be in equilibrium."""
        return {"gravity", "pressure"} <= set(self.effects)

    @property
    def settles(self) -> bool:
        """Whether its body settles to equilibrium before it starts, as particles and scaling laws have it."""
        return self.body.relax and self.body.settles and self.has_equilibrium

    @property
    def wants_choice(self) -> bool:
        """Whether its settings are to be chosen for an accuracy before it is run; closed forms have none."""
        return self.accuracy is not None and self.settings == "chosen" and self.model != "scaling"

    def alone(self) -> tuple[Self, ...]:
        """The scene of each body as if there were no other, with as many neighbours as all together have."""
        numerics = self.numerics
        if self.bodies and numerics.neighbours == "rising" and self.particles is not None:
            neighbours = rising_neighbours(KERNELS[numerics.kernel], self.particles)
            numerics = numerics.model_copy(update={"neighbours": neighbours})
        update = {"bodies": (), "numerics": numerics}
        return tuple(self.model_copy(update=update | {"body": body}) for body in self.bodies) or (self,)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for table, key, most in (
            ("output", "series_every", MOST_RECORDS),
            ("output", "snapshot_every", MOST_SNAPSHOTS),
            ("numerics", "max_timestep", MOST_STEPS),
        ):
            value = getattr(getattr(self, table), key)
            if value is not None and self.time.end > most * value:
                raise ValueError(f"[{table}] {key} divides the run into more than {most:.0e} parts; make it longer.")
        check_names(self.companions)
        if self.numerics.neighbours == "rising" and self.particles is None:
            raise ValueError('[numerics] neighbours = "rising" needs bodies with a number of particles; give one here.')
        for alone in self.alone():
            alone._has_what_its_model_needs(self)
        if self.wants_choice and self.model == "sph" and self.particles is None:
            raise ValueError(
                'accuracy chooses the number of particles, and a table has its own: write settings = "given".'
            )
        self._has_bodies_in_their_places()
        self._has_what_its_regions_need()
        self._has_what_acts_back()
        return self

    def _has_bodies_in_their_places(self) -> None:
        moved = [body for body in (*self.bodies, self.body) if body.position is not None or body.velocity is not None]
        if self.model != "sph":
            if self.bodies:
                raise ValueError(f"[[bodies]] are for the model sph; {self.model} has one [body].")
            if moved:
                raise ValueError(f"[body] position and velocity are for the model sph, not for {self.model}.")
            if self.sinks:
                raise ValueError(f"[[sinks]] are for the model sph, not for {self.model}.")
        if self.orbit is None:
            return
        if len(self.bodies) != 2 or any(body.mass is None for body in self.bodies):
            raise ValueError("[orbit] is for two [[bodies]] of known mass.")
        if moved:
            raise ValueError("[orbit] says where the bodies are, so they must not have position or velocity.")

    def _has_what_its_regions_need(self) -> None:
        for name, region in self.regions.items():
            if self.model != "sph":
                raise ValueError(
                    f"[regions.{name}] is a part of a body of particles, which {self.model} does not have."
                )
            if region.bound and "gravity" not in self.effects:
                raise ValueError(f"[regions.{name}] bound needs gravity among the effects.")

    def _has_what_acts_back(self) -> None:
        """What a rigid body needs to act back on its companions."""
        if self.model != "rigid" or not self.orbits.back_reaction:
            return
        needed = {
            "companions": bool(self.companions),
            "the effect gravity_gradient": "gravity_gradient" in self.effects,
        }
        for what, there in needed.items():
            if not there:
                raise ValueError(f"[orbits] back_reaction needs {what}.")
        if self.orbits.timestep is not None or self.orbits.integrator != "ias15":
            raise ValueError(
                "[orbits] back_reaction evolves orbits with the spin, as [numerics] says: integrator and timestep are "
                "for orbits that the body does not act on."
            )
        if self.body.change is not None:
            raise ValueError(
                "[orbits] back_reaction is for a body that keeps its size, so there can be no [body.change]."
            )

    def _has_its_materials(self) -> None:
        fluid = self.equation_of_state
        if fluid is not None and fluid.kind == "materials":
            if self.model != "sph":
                raise ValueError(f"[equation_of_state] materials are for the model sph, not for {self.model}.")
            if self.dimensionless and any(material.tillotson for material in fluid.materials):
                raise ValueError("[equation_of_state] tillotson needs a scene with units: its numbers are in SI.")

    def _has_what_its_model_needs(self, whole: Self) -> None:
        body, model = self.body, self.model
        if model in ("sph", "ellipsoid") and self.equation_of_state is None:
            raise ValueError(
                "[equation_of_state] is missing, which the models sph and ellipsoid need; for a perfect gas, it has "
                'kind = "ideal".'
            )
        if self.equation_of_state is not None and self.equation_of_state.kind == "incompressible" and model == "sph":
            raise ValueError("[equation_of_state] incompressible is for the model ellipsoid, not for sph.")
        self._has_its_materials()
        fluid = self.equation_of_state
        if fluid is not None and fluid.kind == "own" and model != "rigid" and model not in fluid.entry.models:
            raise ValueError(
                f"[equation_of_state] {fluid.name} has a thermal part, which an equation of state that is not built in "
                f"may have in the models {' and '.join(fluid.entry.models)}, not in {model}."
            )
        self._has_heat_that_counts()
        body.check(whole)
        if model != "sph" and getattr(body, "perturbation", None) is not None:
            raise ValueError(f"[body.perturbation] needs particles: model sph, not {model}.")
        if body.change is not None and model not in ("rigid", "scaling"):
            raise ValueError(
                f"[body.change] prescribes a size, for the models rigid and scaling; {model} works it out."
            )
        if self.box is not None:
            self._can_be_in_a_box()
        if model != "sph" and self.output.series_steps is not None:
            raise ValueError("[output] series_steps counts the steps of particles; give series_every.")

    def _has_heat_that_counts(self) -> None:
        """Nothing that is written about the heat of the body goes unused."""
        fluid, body = self.equation_of_state, self.body
        if fluid is None:
            return
        if fluid.barotropic and body.specific_internal_energy is not None:
            raise ValueError(
                "[body] specific_internal_energy needs matter that can be warm: the pressure of the kind "
                f"{fluid.kind} follows from the density alone."
            )
        key = fluid.pressure_key
        if key is not None and body.pressure_fraction is not None:
            raise ValueError(f"[body] pressure_fraction has no say where [equation_of_state] {key} gives the pressure.")

    def _can_be_in_a_box(self) -> None:
        if self.model != "sph":
            raise ValueError(f"[box] is for the model sph, not for {self.model}.")
        if self.numerics.engine != "numba_cpu":
            raise ValueError(f"[box] needs the engine numba_cpu; {self.numerics.engine} sees no images of particles.")
        for body in self.bodies or (self.body,):
            if not body.boxed:
                kinds = " and ".join(kind for kind, made in BODY_KINDS.items() if made.boxed)
                raise ValueError(f"[box] is for bodies of the kinds {kinds}, not {body.title}.")
        if self.regions:
            raise ValueError("[box] cannot have regions, whose ledgers are about places.")
        if self.companions:
            raise ValueError("[box] cannot have companions, whose attraction has no end.")


# What help and Tab show: the keys of a scene, without pages of types.
Scene.__signature__ = Signature(
    [
        parameter.replace(annotation=Parameter.empty)
        for name, parameter in Scene.__signature__.parameters.items()
        if name not in RECORD
    ]
)
