"""The accuracy knobs of a scene, by model: what may be turned, to which values, and the order that theory gives.

Every knob is given by `--set` overrides, so that what is measured is a scene that anyone can run.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from astroinertia.costs.smooth import STAGES
from astroinertia.errors import SceneError
from astroinertia.scene import load
from astroinertia.scene.plan import gravity_method, smoothing
from astroinertia.scene.schema import Scene
from astroinertia.sph.kernels import KERNELS, eta_for_neighbours

Value = float | str
_FEWEST_PARTICLES = 200  # three times the neighbours of one
_LADDER = (1 / 27, 1 / 9, 1 / 3, 3.0)  # of the number of particles, over the scene's
_TIMESTEP_FACTORS = (4.0, 2.0, 1.0, 0.5, 0.25)
_STEP_FACTORS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)  # of the steps in a rotation
_FORCE_ERRORS = (1e-2, 2e-3, 2e-4, 2e-5)
_TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14)
_SMOOTHING_TOLERANCES = (1e-2, 1e-3, 1e-5, 1e-8)
_NEIGHBOUR_FACTORS = (0.7, 1.0, 1.6)
_KERNELS = ("cubic", "quartic", "wendland_c2", "quintic", "wendland_c4", "wendland_c6")
_RUNGS = ("scaling", "ellipsoid", "sph")
MODEL = "model"
"""Knob of the rungs of the ladder of models."""
BALANCED = "balanced"
"""Knob of the settings in which several are turned together."""


@dataclass(frozen=True)
class Knob:
    """One knob: values from coarse to fine, the default among them, and the overrides that set one.

    step(value) is what the error goes as a power of (`order`, by `source`), value_at its inverse; None for choices,
    which have no order. cost(value) is a guess of the cost, over any unit, until it is measured. alternative: the knob
    is that of another method, which takes the place of the scene's own with any of its values.
    """

    name: str
    text: str
    values: tuple[Value, ...]
    default: Value
    overrides: Callable[[Value], tuple[str, ...]] = field(compare=False)
    step: Callable[[Any], float] | None = field(default=None, compare=False)
    value_at: Callable[[float], float] = field(default=float, compare=False)
    cost: Callable[[Any], float] = field(default=lambda value: 1.0, compare=False)
    order: float | None = None
    source: str = ""
    alternative: bool = False


@dataclass(frozen=True)
class Setting:
    """A scene at values of some knobs; all others are at their base."""

    knob: str
    value: Value
    overrides: tuple[str, ...]
    chosen: Mapping[str, Value] = field(default_factory=dict, compare=False)

    @property
    def label(self) -> str:
        """What it is, in words and numbers."""
        return f"{self.knob.replace('_', ' ')} {shown(self.value)}"


def shown(value: Value) -> str:
    """A value as a person writes it.

    >>> print(shown(3000.0), shown(1e-12), shown("cubic"))
    3000 1e-12 cubic
    """
    if isinstance(value, str):
        return value
    return f"{value:.0f}" if value == round(value) and 1 <= abs(value) < 1e9 else f"{value:g}"


def knobs(scene: Scene) -> tuple[Knob, ...]:
    """The knobs of a scene; the first is the one that sets its resolution.

    >>> print([knob.name for knob in knobs(load.load_file("sims/skater.toml"))])
    ['tolerance', 'steps_per_rotation']
    """
    builders = {
        "sph": _of_particles,
        "ellipsoid": lambda scene: (_tolerance(scene),),
        "rigid": _of_rigid,
        "scaling": lambda _: (),
    }
    return (*builders[scene.model](scene), *_model(scene))


def overridden(scene: Scene, overrides: tuple[str, ...]) -> Scene:
    """The scene with more overrides; SceneError where it does not allow them.

    >>> scene = load.load_file("sims/skater.toml")
    >>> print(overridden(scene, ("numerics.steps_per_rotation=100",)).numerics.steps_per_rotation)
    100.0
    """
    return load.loads(scene.to_toml(), overrides, scene.origin, effects=scene.own_classes)


def _of_particles(scene: Scene) -> tuple[Knob, ...]:
    kernel = "smoothing kernel, with its own number of neighbours"
    precision = "mixed: pair sums in float32, state in float64"
    found = (
        _particles(scene), _timestep(scene), _force_error(scene), _neighbours(scene),
        _choice("kernel", kernel, _KERNELS, scene.numerics.kernel, "numerics.kernel"),
        _order(scene, "pressure"), _order(scene, "gravity"), _smoothing_tolerance(scene),
        _choice("precision", precision, ("mixed", "float64"), scene.precision, "numerics.precision"),
        _timesteps(scene),
    )  # fmt: skip
    return tuple(knob for knob in found if knob is not None)


def _particles(scene: Scene) -> Knob | None:
    count = scene.particles
    if count is None:
        return None
    others = (_rounded(share * count) for share in _LADDER)
    values = sorted({float(count), *(float(number) for number in others if number >= _FEWEST_PARTICLES)})
    return Knob(
        "particles", "number of particles", tuple(values), float(count),
        lambda value: _shared_out(scene, float(value)),
        step=lambda value: scene.body.placed(scene, float(value)) ** (-1 / 3),
        value_at=lambda step: step**-3,
        cost=lambda value: value ** (4 / 3),
        order=2.0,
        source="SPH interpolation is of second order in the smoothing length (Monaghan 2005, Rep. Prog. Phys. 68, "
        "1703, section 2); a free surface, a layer of one smoothing length with an error of first order, or disorder "
        "makes it less",
    )  # fmt: skip


def _shared_out(scene: Scene, count: float) -> tuple[str, ...]:
    """So many particles for one body, or for several as they have them now."""
    if not scene.bodies:
        return (f"body.particles={count:.0f}",)
    bodies: tuple[Any, ...] = scene.bodies
    whole = sum(body.particles for body in bodies)
    return tuple(f"bodies.{k}.particles={count * body.particles / whole:.0f}" for k, body in enumerate(bodies))


def _rounded(count: float) -> int:
    """A number of particles with two digits."""
    unit = 10.0 ** (math.floor(math.log10(count)) - 1)
    return int(round(count / unit) * unit)


def _timestep(scene: Scene) -> Knob:
    numerics = scene.numerics

    def overrides(value: Value) -> tuple[str, ...]:
        factor = float(value)
        settings = [
            f"numerics.{name}={factor * getattr(numerics, name)!r}"
            for name in ("courant", "acceleration_factor", "energy_factor")
        ]
        if numerics.max_timestep is not None:
            settings.append(f"numerics.max_timestep={scene.time_setting(factor * numerics.max_timestep)}")
        if numerics.free_fall_factor is not None:
            settings.append(f"numerics.free_fall_factor={factor * numerics.free_fall_factor!r}")
        return tuple(settings)

    most = min(1.0 / numerics.courant, 2.0 / numerics.acceleration_factor, 2.0 / numerics.energy_factor)
    values = tuple(factor for factor in _TIMESTEP_FACTORS if factor <= most)
    return Knob(
        "timestep_factor", "factor of all limits of the time step", values, 1.0, overrides,
        step=float,
        cost=lambda value: 1.0 / value,
        order=2.0,
        source="kick-drift-kick is of second order (Verlet 1967, Phys. Rev. 159, 98)",
    )  # fmt: skip


def _force_error(scene: Scene) -> Knob | None:
    if "gravity" not in scene.effects or gravity_method(scene, scene.particles or 0) != "multipole":
        return None
    default = float(scene.effects["gravity"]["force_error"])
    values = tuple(sorted({*_FORCE_ERRORS, default}, reverse=True))
    return Knob(
        "force_error", "rms error of gravity by multipoles", values, default,
        lambda value: ("effects.gravity.method='multipole'", f"effects.gravity.force_error={value!r}"),
        step=float,
        cost=lambda value: value**-0.15,
        order=1.0,
        source="motion is linear in small errors of the force",
    )  # fmt: skip


def _neighbours(scene: Scene) -> Knob:
    default = float(f"{smoothing(scene)[1]:.3g}")
    values = tuple(float(f"{factor * default:.3g}") for factor in _NEIGHBOUR_FACTORS)
    return Knob(
        "neighbours", "mean number of neighbours", values, default,
        lambda value: _without_eta(scene, f"numerics.neighbours={value!r}"),
        cost=float,
    )  # fmt: skip


def _without_eta(scene: Scene, setting: str) -> tuple[str, ...]:
    # A scene that gives eta says the number of neighbours in another way: it is given as eta, too.
    if scene.numerics.eta is None:
        return (setting,)
    kernel = KERNELS[scene.numerics.kernel]
    return (f"numerics.eta={eta_for_neighbours(kernel, float(setting.partition('=')[2]))!r}",)


def _choice(name: str, text: str, values: tuple[str, ...], default: str, key: str) -> Knob:
    """Some words that a key of the scene may have."""
    return Knob(name, text, values, default, lambda value: (f"{key}={value!r}",))


def _order(scene: Scene, effect: str) -> Knob | None:
    options = scene.effects.get(effect, {})
    if "order" not in options or options.get("gradients") == "integral":
        return None
    text = f"order of the error of {effect} in the smoothing length"
    return _choice(f"{effect}_order", text, ("second", "fourth"), options["order"], f"effects.{effect}.order")


def _smoothing_tolerance(scene: Scene) -> Knob:
    default = scene.numerics.smoothing_tolerance
    return Knob(
        "smoothing_tolerance", "relative tolerance of the smoothing lengths",
        tuple(sorted({*_SMOOTHING_TOLERANCES, default}, reverse=True)), default,
        lambda value: (f"numerics.smoothing_tolerance={value!r}",),
        step=float,
        order=1.0,
        source="density and forces are linear in small errors of the smoothing length",
    )  # fmt: skip


def _timesteps(scene: Scene) -> Knob:
    """The engine and its steps: individual ones are numba's, and xla compiles for minutes, so it is asked last."""
    default = f"{scene.numerics.engine} {scene.numerics.timesteps}"
    return Knob(
        "engine", "engine and time steps",
        ("numba_cpu individual", "numba_cpu global", "xla global"), default,
        lambda value: tuple(
            f"numerics.{name}='{word}'" for name, word in zip(("engine", "timesteps"), str(value).split(), strict=True)
        ),
        cost=lambda value: {"numba_cpu individual": 1.0, "numba_cpu global": 1.0}.get(value, 300.0),
    )  # fmt: skip


def _tolerance(scene: Scene, more: tuple[str, ...] = (), name: str = "tolerance") -> Knob:
    default = scene.numerics.tolerance
    return Knob(
        name, "relative error of a step that the adaptive integrator allows",
        tuple(sorted({*_TOLERANCES, default}, reverse=True)), default,
        lambda value: (*more, f"numerics.tolerance={value!r}"),
        step=float,
        cost=lambda value: value**-0.125,
        order=1.0,
        source="the pair 8(7) goes on with its solution of order 8, whose error in a step goes as the estimate's "
        "(Hairer, Norsett & Wanner 1993, section II.4: tolerance proportionality)",
        alternative=bool(more),
    )  # fmt: skip


def _of_rigid(scene: Scene) -> tuple[Knob, ...]:
    numerics = scene.numerics
    if numerics.integrator == "adaptive":
        return (_tolerance(scene), _splitting(scene, ("numerics.integrator='splitting'",)))
    steps = _splitting(scene, ())
    order = Knob(
        "order", "order of the splitting", tuple(map(float, STAGES)), float(numerics.order),
        lambda value: (f"numerics.order={value:.0f}",),
        cost=lambda value: STAGES[int(value)],
    )  # fmt: skip
    return steps, order, _tolerance(scene, ("numerics.integrator='adaptive'",), "adaptive_tolerance")


def _splitting(scene: Scene, more: tuple[str, ...]) -> Knob:
    numerics = scene.numerics
    default = numerics.steps_per_rotation
    values = tuple(sorted({max(4.0, factor * default) for factor in _STEP_FACTORS}))
    return Knob(
        "steps_per_rotation", "steps of the splitting in a rotation", values, default,
        lambda value: (*more, f"numerics.steps_per_rotation={value!r}"),
        step=lambda value: 1.0 / value,
        value_at=lambda step: 1.0 / step,
        cost=float,
        order=float(numerics.order),
        source="a symmetric composition of that order (Hairer, Lubich & Wanner 2006, section V.3)",
        alternative=bool(more),
    )  # fmt: skip


def _model(scene: Scene) -> tuple[Knob, ...]:
    """The rungs that can answer the scene, the scene's own among them; scaling laws have nothing else to turn."""
    if scene.model not in _RUNGS[1:]:
        return ()
    allowed = []
    for rung in _RUNGS:
        try:
            overridden(scene, (f"model='{rung}'",))
        except SceneError:
            continue
        allowed.append(rung)
    if len(allowed) < 2:
        return ()
    rungs = Knob(
        MODEL, "rung of the ladder of models", tuple(allowed), scene.model,
        lambda value: (f"model='{value}'",),
        cost=lambda value: {"sph": 1.0}.get(value, 1e-3),
    )  # fmt: skip
    return (rungs,)
