"""The fluid of a scene in code units: its equation of state, and entropies taken from equilibrium."""

import math
from importlib import import_module
from typing import Any

import numpy as np

from astroinertia.build.spheres import Sphere, Star, building
from astroinertia.errors import SceneError
from astroinertia.matter import gases
from astroinertia.scene.fluids import FROM_BODY
from astroinertia.scene.schema import Scene
from astroinertia.units import CodeUnits, pressure_constant_dimension

_THIN = 1e-3  # of the least density of a table: so far its slopes may be followed


def equation_of_state(scene: Scene, units: CodeUnits, initial: Sphere | Star | None) -> Any:
    """The scene's equation of state in code units, its constant taken from the body where the scene says so.

    SceneError where its numbers are beyond what can be computed with in units of the body.
    """
    try:
        return _equation_of_state(scene, units, initial)
    except OverflowError:  # whose own text is a number of the system's
        raise SceneError(
            "[equation_of_state] in units of the body: its numbers lead beyond the largest that there are."
        ) from None
    except (ValueError, ArithmeticError) as error:
        message = str(error).removeprefix("equation of state: ")
        raise SceneError(f"[equation_of_state] in units of the body: {message}.") from None


def _equation_of_state(scene: Scene, units: CodeUnits, initial: Sphere | Star | None) -> Any:
    chosen = scene.equation_of_state
    assert chosen is not None  # the schema asks for it where the model needs it
    if chosen.made_by:
        made = building(chosen.made_by)(chosen, scene.origin, units)
        refuse_thin(scene, units, initial, made.least_density(0))
        return made
    constant = _constant(scene, units, initial, chosen.first_gamma) if hasattr(chosen, "constant") else None
    matter = chosen.matter(units, constant)
    if chosen.kind == "own" and initial is not None:
        with chosen.entry.at_work():
            wrong = import_module("astroinertia.matter.equation").disagreement(matter, _mean_density(scene, initial))
        if wrong:
            raise ValueError(f"the equation of state {chosen.name} would not conserve energy: {wrong}")
    return matter


def refuse_thin(scene: Scene, units: CodeUnits, initial: Sphere | Star | None, least: float) -> None:
    """SceneError for a body far thinner than the least density of its material's table, which says nothing there.

    Matter that can be pulled apart has no gas below its table, whose slopes it cannot follow.
    """
    body: Any = scene.body
    if initial is None or body.composite:  # whose layers are made of the tables
        return
    mean = _mean_density(scene, initial)
    chosen: Any = scene.equation_of_state
    if mean < (1.0 if chosen.materials[0].tension else _THIN) * least:
        shown = [f"{density * units.unit('density'):.3g} kg m-3" for density in (mean, least)]
        raise SceneError(
            f"[body] has a mean density of {shown[0]}, too far below {shown[1]}, where the table of its material ends: "
            "take a smaller radius, or an ideal gas."
        )


def _mean_density(scene: Scene, initial: Sphere | Star) -> float:
    return initial.mass / (4.0 / 3.0 * math.pi * initial.radius**3 * math.prod(getattr(scene.body, "axes", (1.0,))))


def materials_of(matter: Any) -> int:
    """How many materials an equation of state knows; 0 of one without any."""
    return len(getattr(matter, "names", ()))


def entropies(
    scene: Scene, units: CodeUnits, initial: Sphere | Star | None, fluid: Any, where: np.ndarray
) -> np.ndarray:
    """The entropy function of particles, (N,), at s = r/R in the unstretched sphere or at positions in the star.

    What the scene gives, or that of hydrostatic equilibrium times its pressure_fraction; zero where the equation of
    state is barotropic, for the hybrid one, whose cold part holds the body, and for materials without a
    pressure_fraction: the coldest isentrope.
    """
    body = scene.body
    if not fluid.thermal:
        return np.zeros(len(where))
    if scene.equation_of_state is not None and scene.equation_of_state.kind == "materials":
        if body.pressure_fraction is None or initial is None or not scene.has_equilibrium:
            return np.zeros(len(where))
        pressure, density = initial.hydrostatic(where)
        return fluid.entropy_at_pressure(np, density, body.pressure_fraction * pressure)
    if scene.equation_of_state is not None and scene.equation_of_state.kind == "own":
        if "pressure" in scene.effects:
            raise SceneError(
                f"[body] needs specific_internal_energy: how warm matter of the kind {scene.equation_of_state.name} is "
                "does not follow from equilibrium."
            )
        return np.zeros(len(where))
    if body.entropy is not None:
        gamma: Any = scene.equation_of_state.thermal_gamma  # type: ignore[union-attr]
        return np.full(len(where), units.to_code(body.entropy, pressure_constant_dimension(gamma)))
    if initial is None:
        raise SceneError(f"[body] {body.without_heat} needs specific_internal_energy or entropy.")
    hybrid = scene.equation_of_state is not None and scene.equation_of_state.kind == "hybrid"
    if hybrid or "pressure" not in scene.effects:
        return np.zeros(len(where))
    refuse_without_equilibrium(scene)
    pressure, density = initial.hydrostatic(where)
    with np.errstate(all="ignore"):
        entropy = (body.pressure_fraction or 1.0) * pressure / density**fluid.gamma
    if not np.isfinite(entropy).all():
        raise SceneError(
            f"[equation_of_state] gamma = {fluid.gamma:g} makes P/density^gamma of this body's equilibrium, in units "
            "of the run, larger than any number: take a smaller gamma, or other units."
        )
    return entropy


def refuse_without_equilibrium(scene: Scene) -> None:
    """SceneError for a body of an ideal gas that says nothing of its heat, and that no gravity holds."""
    body, fluid = scene.body, scene.equation_of_state
    given = body.specific_internal_energy is not None or body.entropy is not None
    if given or fluid is None or fluid.kind != "ideal" or "pressure" not in scene.effects or "gravity" in scene.effects:
        return
    raise SceneError(
        "[body] needs specific_internal_energy or entropy: without gravity there is no equilibrium to take it from."
    )


def _constant(scene: Scene, units: CodeUnits, initial: Sphere | Star | None, gamma: float) -> float:
    body: Any = scene.body
    chosen: Any = scene.equation_of_state
    constant = chosen.constant
    if constant != FROM_BODY:
        return units.to_code(constant, pressure_constant_dimension(gamma))
    if initial is None:
        raise SceneError('[equation_of_state] constant = "from body" needs a body of known structure, not a table.')
    pressure, density = body.central(initial.mass, initial.radius) or initial.densest()
    return (body.pressure_fraction or 1.0) * gases.polytropic_constant(density, pressure, gamma)
