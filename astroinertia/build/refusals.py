"""Bodies that cannot be, refused before anything is prepared: in one sentence, with the limit.

Imports no engine, so that plans refuse them at once.
"""

import math
from typing import Any

import numpy as np

from astroinertia.build.fluids import equation_of_state, refuse_thin, refuse_without_equilibrium
from astroinertia.build.materials import equation
from astroinertia.build.spheres import sphere
from astroinertia.build.spin import rotation_amount
from astroinertia.errors import SceneError
from astroinertia.scene.characteristic import characteristic
from astroinertia.scene.fluids import FROM_BODY
from astroinertia.scene.plan import smoothing, softening
from astroinertia.scene.scales import code_units
from astroinertia.scene.schema import Scene
from astroinertia.sph.density import mass_around
from astroinertia.sph.table import read_body
from astroinertia.units import CodeUnits

# Up to an index, a rate, L and T/|W| (as of break_up.PolytropicLimit) that are below the limits, which fall with it.
_SURELY_HELD = ((1.0, (0.55, 0.244, 0.102)), (1.5, (0.528, 0.168, 0.0594)), (2.5, (0.453, 0.0798, 0.0182)))
_COLD_EXPONENTS = {"hybrid": "gamma_1", "polytropic": "gamma"}  # of what has no heat below nuclear density
_ROUNDED = 1e-3  # 1.333 is 4/3
_ORBIT = "of an orbit at its equator"


def refuse_impossible(scene: Scene) -> None:
    """SceneError for what cannot be.

    It is a star beyond its limits, a body that turns faster than break-up, a gas without its heat, matter that does not
    fit its file or all bodies, particles that are too few, electrons that would be lost twice, spheres about the middle
    of several bodies, error bars of a closed form, or a companion that begins or comes within a rigid body.
    """
    _refuse_lost_twice(scene)
    if scene.bodies and "relativistic_potential" in scene.effects:
        raise SceneError(
            f"{scene.where_listed('relativistic_potential')} is the mean of relativity's gravity over spheres about "
            "the centre of mass of all: it is for one [body], and not for [[bodies]]."
        )
    if scene.output.error_bars and scene.model == "scaling":
        raise SceneError("the model scaling has no error bars: its answers are closed forms.")
    units = code_units(scene)
    if scene.orbits.archive is not None and scene.body.mass is not None:
        from astroinertia.build.companions import refuse_archive  # only here: other scenes do without REBOUND

        refuse_archive(scene, units, units.to_code(scene.body.mass, "mass"))
    if scene.model == "rigid":
        _refuse_within(scene, units)
    for alone in scene.alone():
        if alone.body.quickly_known:
            sphere(alone, units)
        if scene.model == "sph":
            _refuse_body(alone, units)
    if scene.model == "sph":
        _refuse_few(scene)
        if scene.equation_of_state is not None:
            _refuse_matter(scene, units)


def _refuse_body(scene: Scene, units: CodeUnits) -> None:
    """Of a body of particles, in the scene of it alone: its rotation, and a gas without its heat."""
    body: Any = scene.body
    if body.rotation is not None and body.rotation.t_over_w is not None:
        rotation_amount(scene, units, "gravity" in scene.effects and body.placing != "placing.of_table")
    _refuse_break_up(scene, units)
    if body.placing == "placing.of_table":
        _refuse_without_heat(scene)
    elif body.placing == "placing.of_sphere" and not hasattr(body, "file"):  # which may have its own heat
        refuse_without_equilibrium(scene)


def _refuse_few(scene: Scene) -> None:
    """Of particles whose masses are known, which may be too few to have smoothing lengths that follow the density."""
    bodies: Any = scene.bodies or (scene.body,)
    known = all(body.structure and body.mass is not None for body in bodies)
    if softening(scene) is not None or scene.wants_choice or not known:
        return
    (eta, _), heaviest = smoothing(scene), max(body.mass / body.particles for body in bodies)
    needed, there = mass_around(scene.numerics.kernel, eta), sum(body.mass for body in bodies) / heaviest
    if not there > needed:
        raise SceneError(
            f"particles are too few: with eta = {eta:.3g} there must be more than {needed:.1f} times the mass of the "
            f"heaviest, not {there:.1f} times, for all to have a smoothing length; take more, or a smaller [numerics] "
            "eta."
        )


def _refuse_matter(scene: Scene, units: CodeUnits) -> None:
    """Of materials, by their files; of others, by their constants, of which all bodies have the same."""
    fluid: Any = scene.equation_of_state
    if fluid.kind == "materials":
        made_of = {material.name: equation(material, scene.origin) for material in fluid.materials}
        least = units.to_code(made_of[fluid.materials[0].name].densities[0], "density")
        for alone in scene.alone():
            for layer in getattr(alone.body, "layers", ()):
                _refuse_hot(scene, layer, made_of[layer.material].greatest_energy)
            refuse_thin(alone, units, None if alone.body.composite else sphere(alone, units), least)
    if fluid.made_by:
        return
    from_body = fluid.stated_constant == FROM_BODY
    made = [equation_of_state(each, units, sphere(each, units) if from_body else None) for each in scene.alone()]
    if len(made) > 1:
        from astroinertia.build.combine import check_same_fluid  # only here: it imports the engines' pytrees

        check_same_fluid(made)


def _refuse_hot(scene: Scene, layer: Any, greatest: float) -> None:
    """Of a layer on an isentrope that the table of its material does not reach."""
    if layer.isentrope > greatest:
        asked, most = (scene.shown(energy, "specific_energy", 4) for energy in (layer.isentrope, greatest))
        raise SceneError(
            f"[body] the layer of {layer.material} has an isentrope of {asked}, and those of its material reach to "
            f"{most}."
        )


def _refuse_within(scene: Scene, units: CodeUnits) -> None:
    """Of a rigid body, which companions feel as a point with a quadrupole: that holds outside it alone."""
    if not scene.has_companions:
        return
    body = characteristic(scene)
    if body.mass is None or body.radius is None:
        return
    # Only here: other scenes do without REBOUND.
    from astroinertia.build.companions import at_start, names
    from astroinertia.orbits.approach import pericentres_within

    masses, places, velocities = at_start(scene, units, units.to_code(body.mass, "mass"))
    inside = scene.shown(body.radius, "length", 4)
    for name, distance in zip(names(scene, units), np.linalg.norm(places, axis=-1), strict=True):
        away = units.to_si(distance, "length")
        if away < body.radius:
            raise SceneError(
                f"companion {name} begins {scene.shown(away, 'length', 4)} from the centre of the body, which is "
                f"inside it; it must begin farther out than the radius of the rigid body, {inside}."
            )
    radius, end = units.to_code(body.radius, "length"), units.to_code(scene.time.end, "time")
    nearest = pericentres_within(masses, places, velocities, radius, end)
    for name, distance in zip(names(scene, units), nearest, strict=True):
        if np.isfinite(distance):
            raise SceneError(
                f"companion {name} comes within the body during the run, on an orbit whose least distance from its "
                f"centre is {scene.shown(units.to_si(distance, 'length'), 'length', 4)}; it must be more than the "
                f"radius of the rigid body, {inside}."
            )


def _refuse_break_up(scene: Scene, units: CodeUnits) -> None:
    """Of a body that settles with its rotation: a polytrope at mass shedding, another at an orbit at its equator."""
    body: Any = scene.body
    spin: Any = body.rotation
    settles = scene.settles and not body.homologous
    if not settles or spin is None or spin.law != "rigid" or body.radius is None or spin.breakup_fraction is not None:
        return
    mass, radius = units.to_code(body.mass, "mass"), units.to_code(body.radius, "length")
    sizes = {"rate": math.sqrt(mass / radius**3), "angular_momentum": math.sqrt(mass**3 * radius), "t_over_w": 1.0}
    ((name, value),) = rotation_amount(scene, units, True).items()
    measure, value = list(sizes).index(name), abs(value) / sizes[name]
    limit, of = _limit(body.polytropic_index, measure, value)
    if value <= limit:
        return
    share = f"{value / limit:.3g} times as"
    if measure == 0:
        period = units.to_si(2 * math.pi / (limit * sizes[name]), "time")
        raise SceneError(
            f"[body.rotation] turns the body {share} fast as it can without breaking up: its period must be at least "
            f"{scene.shown(period, 'time', 4)}, that {of}."
        )
    dimension = "dimensionless" if measure == 2 else "angular_momentum"
    least = scene.shown(units.to_si(limit * sizes[name], dimension), dimension, 4)
    raise SceneError(
        f"[body.rotation] {name} is {share} large as the body can have without breaking up: it must be at most "
        f"{least}, that {of}."
    )


def _limit(index: float | None, measure: int, value: float) -> tuple[float, str]:
    """The most of a measure that the body can have, as far as it is needed to judge a value, and whose it is."""
    if index is None or not 0.0 < index < 3.0:  # whose radius at rest says no more than this
        return (1.0 if measure == 0 else math.inf), _ORBIT
    if any(index <= most and value <= held[measure] for most, held in _SURELY_HELD):
        return math.inf, ""
    from astroinertia.bodies.break_up import polytropic_limit  # takes seconds, and so only near the limit

    limit = polytropic_limit(float(index))
    most = (limit.rate, limit.angular_momentum, limit.rotational_to_gravitational)[measure]
    return float(most), f"at which a polytrope of index {index:g} sheds mass"


def _refuse_lost_twice(scene: Scene) -> None:
    """Of matter whose electrons are lost already, by its exponent or its table, or that has none."""
    fluid: Any = scene.equation_of_state
    if fluid is None or "deleptonisation" not in scene.effects:
        return
    listed, begun = scene.where_listed("deleptonisation"), scene.effects["deleptonisation"]["electron_fraction"]
    for material in fluid.materials if fluid.kind == "materials" else ():
        own = material.electron_fraction
        if own is None or abs(own - begun) > _ROUNDED:
            has = "states none" if own is None else f"has {own:g}"
            raise SceneError(
                f"{listed} takes electrons from matter with an electron_fraction of {begun:g}, and "
                f"the material {material.name} {has}: both must be the same."
            )
    key = _COLD_EXPONENTS.get(fluid.kind)
    if key and fluid.first_gamma < 4.0 / 3.0 - _ROUNDED:
        raise SceneError(
            f"[equation_of_state] {key} of {fluid.first_gamma:.4g} stands for electrons that are captured, which "
            f'{listed} takes away itself: set {key} = "4/3", or leave the effect away.'
        )


def _refuse_without_heat(scene: Scene) -> None:
    """Of a table, which is read: its other columns and numbers are checked, too."""
    body: Any = scene.body
    fluid = scene.equation_of_state
    table = read_body(body.path(scene), code_units(scene), body.velocity_unit)
    assert fluid is not None  # the schema asks for it
    warm = fluid.thermal_gamma is not None and fluid.kind not in ("materials", "own")
    if warm and table.internal_energy is None and body.specific_internal_energy is None and body.entropy is None:
        raise SceneError(f"[body] {body.without_heat} needs specific_internal_energy or entropy.")
