"""What a scene calls for, and why: plain data, worked out without importing an effect or an engine."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from astroinertia.effects.entries import Entry
from astroinertia.engines.few import FEW
from astroinertia.observables.own import quantity_of
from astroinertia.process.words import duration
from astroinertia.scene import gravity_costs, plan_body, plan_effects
from astroinertia.scene.companions import archive_at_start
from astroinertia.scene.dimensional import quantity_of as quantity_of_field
from astroinertia.scene.fluid_kinds.materials import Material
from astroinertia.scene.fluids import FROM_BODY
from astroinertia.scene.initial_body import PlanLine, option_lines, option_text
from astroinertia.scene.resolution import resolved
from astroinertia.scene.scales import code_units
from astroinertia.scene.schema import Scene
from astroinertia.scene.source import file_of_scene
from astroinertia.sph.kernels import KERNELS, eta_for_neighbours, neighbour_number, rising_neighbours
from astroinertia.units import shown

UNCHOSEN = (
    "settings",
    "chosen by pilot runs when it is run",
    "all here is of the scene as it is written; `plan --pilot` chooses now",
)
RECORDS, SNAPSHOTS = 200, 10  # of a run that does not say how often


@dataclass(frozen=True)
class Line:
    """One thing that is settled: its name, what it is, and why or what it means."""

    name: str
    value: str
    why: str = ""


@dataclass(frozen=True)
class EffectLine:
    """One effect of the catalogue: `options` as written for a person, empty where it is not listed.

    skipped: listed, but a numerical device that the scene's model does not need. size: how large it is in this scene,
    and what leaving it out would cost; empty where that takes numbers that the scene does not give. origin: where it
    comes from, empty for an effect of this package.
    """

    kind: str
    listed: bool
    text: str
    options: str
    loop: str
    source: str
    skipped: bool = False
    size: str = ""
    origin: str = ""


@dataclass(frozen=True)
class Plan:
    """The whole plan, in sections of lines, with all effects, listed or not."""

    name: str
    description: str
    sections: dict[str, tuple[Line, ...]]
    effects: tuple[EffectLine, ...]

    def text(self) -> str:
        """The plan as plain text, for a dataset's attributes."""
        lines = [f"{self.name}: {self.description}" if self.description else self.name]
        for title, entries in self.sections.items():
            lines += [f"{title}:"]
            lines += [f"  {line.name}: {line.value}{f' ({line.why})' if line.why else ''}" for line in entries]
        lines += ["effects:"]
        lines += [
            f"  {line.kind}: {line.text}{f'; {line.options}' if line.options else ''}"
            f"{f'; from {line.origin}' if line.origin else ''}"
            for line in self.effects
            if line.listed and not line.skipped
        ]
        lines += [f"  {line.kind}: a numerical device of particles, skipped" for line in self.effects if line.skipped]
        absent = [line.kind for line in self.effects if not line.listed]
        sizes = [f"  {line.kind}: {line.size}" for line in self.effects if line.size]
        return "\n".join([*lines, f"not listed, so absent: {', '.join(absent) or 'none'}", "sizes of effects:", *sizes])


@dataclass(frozen=True)
class Cadence:
    """How often a scene is written, defaults filled in; times in the scene's units, None for never."""

    series_every: float | None
    series_steps: int | None
    snapshot_every: float


def cadence(scene: Scene) -> Cadence:
    """When the scene is written, with 200 records and 10 snapshots a run where it does not say."""
    output, end = scene.output, scene.time.end
    every, snapshots = output.series_every, output.snapshot_every
    if every is None and output.series_steps is None:
        every = end / RECORDS
    return Cadence(every, output.series_steps, end / SNAPSHOTS if snapshots is None else snapshots)


def smoothing(scene: Scene) -> tuple[float, float]:
    """Smoothing length over particle spacing (eta), and the mean neighbour number that goes with it."""
    numerics, kernel = scene.numerics, KERNELS[scene.numerics.kernel]
    eta = kernel.eta if numerics.eta is None else numerics.eta
    if numerics.neighbours == "rising":
        assert scene.particles is not None  # the schema asks for it
        eta = eta_for_neighbours(kernel, rising_neighbours(kernel, scene.particles))
    elif numerics.neighbours is not None:
        eta = eta_for_neighbours(kernel, numerics.neighbours)
    return eta, neighbour_number(kernel, eta)


def softening(scene: Scene) -> float | None:
    """The smoothing length that gravity asks all particles to keep, in the scene's units; None where it adapts."""
    return scene.effects.get("gravity", {}).get("softening")


def gravity_method(scene: Scene, particles: int) -> gravity_costs.Method:
    """How so many particles attract each other: as the scene says, or what takes less time."""
    gravity, numerics = scene.effects["gravity"], scene.numerics
    if gravity["method"] != "auto":
        return gravity["method"]
    return gravity_costs.cheaper(particles, numerics.engine, scene.precision, gravity["force_error"])


def plan(scene: Scene) -> Plan:
    """What will be run."""
    titles = [f"bodies.{number}" for number in range(len(scene.bodies))] or ["body"]
    sections: dict[str, Sequence[PlanLine]] = {
        title: plan_body.body_lines(alone) for title, alone in zip(titles, scene.alone(), strict=True)
    }
    if scene.orbit is not None:
        sections["orbit"] = scene.orbit.plan_lines(scene.shown)
    if scene.model in ("sph", "ellipsoid"):
        sections["equation of state"] = _equation_of_state(scene)
    if scene.regions:
        sections["regions"] = [*region_descriptions(scene).items()]
    if scene.has_companions:
        sections["companions"] = _companions(scene)
    if scene.sinks:
        sections["sinks"] = [sink.plan_line(scene.shown) for sink in scene.sinks]
    if scene.box is not None:
        sections["box"] = [scene.box.plan_line(scene.shown)]
    sections |= {"model and numerics": _numerics(scene), "time and output": _time(scene)}
    if scene.observed:
        sections["observables"] = [_observable(scene, kind, entry) for kind, entry in scene.observed.items()]
    follows = scene.model == "sph" and softening(scene) is None
    if follows and (resolution := resolved(scene, *smoothing(scene))):
        sections["resolution"] = resolution
    if scene.choice:
        sections["accuracy"] = [*scene.choice.items()]
    elif scene.wants_choice:
        sections["accuracy"] = [UNCHOSEN]
    sections["characteristic numbers"] = plan_effects.number_lines(scene)
    sizes = plan_effects.size_descriptions(scene)
    effects = tuple(
        EffectLine(
            kind,
            kind in scene.effects,
            entry.text,
            _options(scene, entry, scene.effects[kind]) if kind in scene.effects else "",
            f"over {entry.cost}" if scene.model == "sph" else "closed form",
            entry.source,
            kind in scene.effects and scene.model not in entry.models,
            sizes.get(kind, ""),
            entry.origin,
        )
        for kind, entry in scene.entries.items()
        if kind in scene.effects or scene.model in entry.models
    )
    lines = {title: tuple(Line(*line) for line in section) for title, section in sections.items()}
    return Plan(scene.name, scene.description.strip(), lines, effects)


def _companions(scene: Scene) -> list[PlanLine]:
    if scene.orbits.archive is not None:
        return _of_archive(scene)
    lines: list[PlanLine] = []
    for companion in scene.companions:
        if companion.position is not None:
            orbit = "from its position and velocity"
        elif companion.period is not None:
            orbit = f"period {scene.shown(companion.period, 'time')}, eccentricity {companion.eccentricity:g}"
        else:
            size = scene.shown(companion.semi_major_axis or 0.0, "length")
            orbit = f"semi-major axis {size}, eccentricity {companion.eccentricity:g}"
        lines.append((companion.name, scene.shown(companion.mass, "mass"), f"around {companion.around}, {orbit}"))
    if scene.orbits.back_reaction:
        return [*lines, ("orbits", "in the steps of the body", "its quadrupole acts back")]
    if scene.effects.get("companions", {}).get("motion") == "live":
        return [*lines, ("orbits", "in the steps of the particles", "they feel the particles and each other")]
    return [*lines, ("orbits", f"REBOUND, {scene.orbits.integrator}", "the body is a point to them")]


def _of_archive(scene: Scene) -> list[PlanLine]:
    units, archive = code_units(scene), scene.orbits.archive
    body, *others = archive_at_start(scene.orbits, scene.origin, units).particles
    lines = [(shown(one.name), scene.shown(float(units.to_si(one.m, "mass")), "mass")) for one in others]
    return [*lines, ("orbits", f"from the archive {archive}", f"about its particle {shown(body.name)}")]


def region_descriptions(scene: Scene) -> dict[str, str]:
    """What each region of a scene is, in words."""
    return {
        name: region.description(
            "" if region.innermost_mass is None else scene.shown(region.innermost_mass, "mass"),
            "" if region.density_above is None else scene.shown(region.density_above, "density"),
        )
        for name, region in scene.regions.items()
    }


def _equation_of_state(scene: Scene) -> list[PlanLine]:
    chosen = scene.equation_of_state
    assert chosen is not None
    if chosen.kind == "own":
        kind = ("kind", chosen.name.replace("_", " "), chosen.entry.described)
        return [kind, *option_lines(chosen.options, chosen.entry.options, scene)]
    meaning = (type(chosen).__doc__ or "").split("\n")[0].rstrip(".")
    lines: list[PlanLine] = [("kind", chosen.kind.replace("_", " "), meaning)]
    for name, value in chosen:
        if name == "kind" or value is None:
            continue
        if name == "materials":
            lines += [(row.name, row.tillotson or row.file, _material(scene, row)) for row in value]
            continue
        quantity = quantity_of_field(type(chosen).model_fields[name])
        dimension = "dimensionless" if quantity is None else quantity.dimension
        if value == FROM_BODY:
            lines.append((name, FROM_BODY, "worked out when the body is placed"))
        elif isinstance(value, tuple):
            items = [scene.shown(item, dimension) for item in value]
            lines.append((name, ", ".join(items)))
        else:
            lines.append((name.replace("_", " "), scene.shown(value, dimension)))
    return lines


def _material(scene: Scene, material: Material) -> str:
    pulled = "can be pulled" if material.tension else "no tension"
    if material.electron_fraction is not None:
        from astroinertia.matter.finite_temperature import read_finite_temperature  # with JAX, as its runs

        path = file_of_scene(scene.origin, str(material.file))
        return read_finite_temperature(path, material.electron_fraction).description
    return f"{'table' if material.tillotson is None else 'Tillotson'}, {pulled}"


MODELS = {
    "sph": "particles: the fluid itself",
    "ellipsoid": "a deformation that is linear in position: nine numbers and their rates",
    "rigid": "orientation and angular momentum; the shape stays, or changes as prescribed",
    "scaling": "conservation laws: a size and a spin",
}


def _numerics(scene: Scene) -> list[PlanLine]:
    model = ("model", scene.model, MODELS[scene.model])
    return [model, *(_particle_numerics(scene) if scene.model == "sph" else _integrator(scene)), _units(scene)]


def _integrator(scene: Scene) -> list[PlanLine]:
    numerics = scene.numerics
    if scene.model == "scaling":
        return []
    if numerics.integrator == "adaptive":
        return [("integrator", "adaptive", f"order 8(7), relative error {numerics.tolerance:g} a step")]
    why = f"order {numerics.order}, {numerics.steps_per_rotation:g} steps a rotation"
    return [("integrator", "splitting", why)]


def _units(scene: Scene) -> PlanLine:
    units = code_units(scene)
    if scene.dimensionless:
        return ("units", "code units", "G = 1, plain numbers at both ends")
    text = f"{units.mass:.6g} kg, {units.length:.6g} m, {units.time:.6g} s"
    return ("code units", text, "G = 1 inside")


def _particle_numerics(scene: Scene) -> list[PlanLine]:
    numerics = scene.numerics
    eta, neighbours = smoothing(scene)
    factors = {name: getattr(numerics, f"{name}_factor") for name in ("acceleration", "energy")}
    limits = ", ".join(f"{name} {value:g}" for name, value in {"courant": numerics.courant, **factors}.items())
    if numerics.max_timestep is not None:
        limits += f", at most {scene.shown(numerics.max_timestep, 'time')}"
    if numerics.free_fall_factor is not None:
        limits += f", at most {numerics.free_fall_factor:g} (G density)^(-1/2)"
    return [
        ("engine", numerics.engine, _precision(scene)),
        ("kernel", numerics.kernel, f"{neighbours:.0f} neighbours, eta {eta:.4g}"),
        _smoothing_lengths(scene),
        *([_gravity(scene)] if "gravity" in scene.effects else []),
        ("time step", limits),
        ("time steps", numerics.timesteps, SPLITTING[numerics.timesteps]),
    ]


def _precision(scene: Scene) -> str:
    if scene.numerics.precision != "auto":
        return scene.precision
    if scene.particles is None:
        return f"{scene.precision}, for a number of particles that is not known here"
    few = scene.particles <= FEW
    return f"{scene.precision}, for {'no more' if few else 'more'} than {FEW} particles"


def _smoothing_lengths(scene: Scene) -> PlanLine:
    kept = softening(scene)
    if kept is None:
        return ("smoothing lengths", f"to {scene.numerics.smoothing_tolerance:g}")
    return ("smoothing lengths", scene.shown(kept, "length"), "of every particle, as gravity's softening asks")


def _gravity(scene: Scene) -> PlanLine:
    # Both costs are shown, so that a person sees what the other way would cost.
    gravity, particles = scene.effects["gravity"], scene.particles
    if particles is None:
        why = "by the number of particles in the table" if gravity["method"] == "auto" else "as asked for"
        return ("gravity", gravity["method"], why)
    numerics, chosen = scene.numerics, gravity_method(scene, particles)
    error = gravity["force_error"]
    cost = {
        method: gravity_costs.seconds(method, particles, numerics.engine, scene.precision, error)
        for method in ("direct", "multipole")
    }
    verdict = "as asked for"
    if gravity["method"] == "auto":
        verdict = f"cheaper with {particles} particles"
    direct, multipole = duration(cost["direct"]), duration(cost["multipole"])
    value = "direct sums" if chosen == "direct" else f"multipoles, forces to {error:g}"
    why = f"{verdict}: direct sums take about {direct} a step on two cores, multipoles {multipole}"
    return ("gravity", value, why)


SPLITTING = {
    "global": "all particles take the shortest",
    "individual": "each particle its own, in powers of two, where that saves a third of work, else all the shortest; "
    "their histogram is shown as the run goes",
}


TIMES = {"Myr": 3.15576e13, "kyr": 3.15576e10, "yr": 3.15576e7, "d": 86400.0, "h": 3600.0, "min": 60.0, "s": 1.0,
         "ms": 1e-3, "µs": 1e-6}  # fmt: skip


def _lasting(scene: Scene, time: float) -> str:
    """A time of the run in the largest unit that it is at least one of."""
    if scene.dimensionless:
        return f"{time:.6g}"
    unit = next((name for name, size in TIMES.items() if time >= size * (1.0 - 1e-9)), "µs")
    return f"{time / TIMES[unit]:.6g} {unit}"


def _time(scene: Scene) -> list[PlanLine]:
    written, end = cadence(scene), scene.time.end
    lines: list[PlanLine] = [("end", _lasting(scene, end))]
    if scene.time.max_steps is not None:
        lines.append(("or after", f"{scene.time.max_steps} steps"))
    if written.series_every is not None:
        often = f"every {_lasting(scene, written.series_every)}"
        lines.append(("series", often, f"{records(end, written.series_every)} records"))
    else:
        lines.append(("series", f"every {written.series_steps} steps"))
    if scene.model == "sph":
        often = f"every {_lasting(scene, written.snapshot_every)}"
        lines.append(("snapshots", often, f"{records(end, written.snapshot_every)} of all particles"))
    return [*lines, ("checkpoints", f"every {scene.output.checkpoint_seconds:g} s of wall time")]


def records(end: float, every: float) -> int:
    """How many records a run leaves at most: the first at time 0, one at each multiple, and the last at the end."""
    parts = end / every
    whole = round(parts)
    return (whole if abs(parts - whole) < 1e-9 * max(1.0, parts) else math.floor(parts) + 1) + 1


def _observable(scene: Scene, kind: str, entry: Entry) -> PlanLine:
    quantity, options = quantity_of(entry), _options(scene, entry, scene.observables[kind])
    unit = "1" if scene.dimensionless and quantity.dimension is not None else quantity.unit
    value = f"{quantity.long_name} ({unit})" if unit != "1" else quantity.long_name
    return (kind, value, "; ".join(filter(None, [options, f"from {entry.origin}", entry.source])))


def _options(scene: Scene, entry: Entry, values: Mapping[str, Any]) -> str:
    return ", ".join(
        f"{name} {option_text(value, entry.options[name].dimension, scene)}"
        for name, value in values.items()
        if value is not None and scene.model in entry.options[name].models
    )
