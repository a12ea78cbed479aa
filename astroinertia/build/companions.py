"""The companions of a scene: on orbits that REBOUND finds at once, or an archive holds, or acted on by the body."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from astroinertia.errors import NumericalError, SceneError
from astroinertia.scene.apart import beside_points
from astroinertia.scene.companions import archive_at_start
from astroinertia.scene.schema import Scene
from astroinertia.scene.source import file_of_scene
from astroinertia.units import CodeUnits

if TYPE_CHECKING:
    from astroinertia.build.placing import Particles

_OTHER_BODY = 2.0  # times as heavy or light: no uncertainty of a mass, or of G
_COVERED = 1.0 + 1e-9  # of the run by the orbits: its last step may end a rounding late
AT_FIRST = 4096.0  # radians of the fastest orbit: some 650 turns, which take a second or two


def companions(scene: Scene, units: CodeUnits, mass: float, turns: float = math.inf) -> Any:
    """Where they are at any time of the run (`rotation.ephemeris.Ephemeris`), in code units; None without any.

    turns: radians of the fastest of their orbits, after which these end, if not with the run; not of an archive's.
    """
    archive = scene.orbits.archive
    if archive is None and not scene.companions:
        return None
    # Only here: other scenes do without REBOUND.
    from astroinertia.orbits import states
    from astroinertia.rotation.ephemeris import archive_ephemeris, ephemeris

    end = units.to_code(scene.time.end, "time")
    if archive is None:
        every = bodies(scene, units, mass)
        return ephemeris(every, min(_COVERED * end, turns * states.shortest_time(every)))
    if scene.companions:
        raise SceneError("[orbits] archive holds the companions, so [[companions]] must not be given with it.")
    refuse_archive(scene, units, mass)
    try:
        return archive_ephemeris(file_of_scene(scene.origin, archive), end, scene.orbits.body, units)
    except (ValueError, NumericalError) as error:
        raise SceneError(f"[orbits] archive: {str(error).rstrip('.')}.") from None


def of_rigid(scene: Scene, units: CodeUnits, mass: float, turns: float) -> Any:
    """Those of a rigid body of that mass, in code units: on known orbits, or as they begin where it acts on them."""
    if not scene.orbits.back_reaction:
        return companions(scene, units, mass, turns)
    # Only here: other scenes do without REBOUND.
    from astroinertia.models.rigid import two_way
    from astroinertia.orbits import states

    start = bodies(scene, units, mass)
    radius = 0.0 if scene.body.radius is None else units.to_code(scene.body.radius, "length")
    return two_way.Companions(states.masses(start)[1:], np.stack(states.present(start)), radius=radius)


def names(scene: Scene, units: CodeUnits) -> list[str]:
    """Names of the companions, in their order; SceneError where they are those of an archive that cannot be read."""
    if scene.orbits.archive is None:
        return [companion.name for companion in scene.companions]
    return [particle.name for particle in archive_at_start(scene.orbits, scene.origin, units).particles[1:]]


def at_start(scene: Scene, units: CodeUnits, mass: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Masses (N + 1,) of the body, of that mass in code units, and its companions; their places and velocities (N, 3).

    At the start, and relative to the body.
    """
    from astroinertia.orbits import states  # only here: other scenes do without REBOUND

    archive = scene.orbits.archive
    first = bodies(scene, units, mass) if archive is None else archive_at_start(scene.orbits, scene.origin, units)
    return states.masses(first), *states.present(first)


def refuse_archive(scene: Scene, units: CodeUnits, mass: float) -> None:
    """SceneError where the archive of a scene is none, or has another body than that of this mass, in code units."""
    if scene.orbits.archive is None:
        return
    first = archive_at_start(scene.orbits, scene.origin, units)
    there = first.particles[0].m
    if there > 0.0 and not 1.0 / _OTHER_BODY < there / mass < _OTHER_BODY:  # test particles have no mass
        names = ", ".join(str(particle.name or number) for number, particle in enumerate(first.particles))
        raise SceneError(
            f"[orbits] archive: its particle '{names.partition(',')[0]}' has {there / mass:.2g} of the body's mass, so "
            f"it is another; say which is the body by orbits.body, of these: {names}."
        )


def bodies(scene: Scene, units: CodeUnits, mass: float) -> Any:
    """The body, of that mass in code units, and its companions as a `rebound.Simulation`."""
    from astroinertia.orbits.simulation import in_code_units, simulation

    orbits = scene.orbits
    timestep = None if orbits.timestep is None else units.to_code(orbits.timestep, "time")
    return simulation(mass, in_code_units(scene.companions, units), integrator=orbits.integrator, timestep=timestep)


def beside(scene: Scene, units: CodeUnits, problem: Any, body: "Particles") -> "tuple[dict[str, Any], Particles]":
    """The companions beside a body of particles as the scene wants them to move, and the body where they have it.

    Raises SceneError where the scene contradicts itself. The body's centre of mass is put where it is to the orbits.
    """
    refuse_with_particles(scene, problem.effects)
    if (effect := _effect(problem.effects)) is None:
        return {}, body
    # Only here: other scenes do without them. The exact sum of masses does not depend on their order.
    from astroinertia.rotation.on_orbits import on_orbits

    xp, mass = problem.engine.xp, math.fsum(body.mass)
    inertial = effect.frame == "direct"
    if effect.motion == "orbit":
        points = on_orbits(xp, companions(scene, units, mass), mass, inertial)
        place, velocity = (np.asarray(vector) for vector in points.body(xp))
    else:
        points, place, velocity = _live(scene, units, mass, effect.softening, xp)
    share = body.mass / mass
    moved = replace(
        body,
        position=body.position - share @ body.position + place,
        velocity=body.velocity - share @ body.velocity + velocity,
    )
    return {effect.kind: points}, moved


def _live(scene: Scene, units: CodeUnits, mass: float, softening: float, xp: Any) -> tuple[Any, np.ndarray, np.ndarray]:
    """Companions that the fluid moves, and place and velocity of the body, with the centre of mass of all at rest."""
    from astroinertia.gravity.point_masses import PointMasses
    from astroinertia.orbits import states

    companions_of_body = bodies(scene, units, mass)
    masses, (place, velocity) = states.masses(companions_of_body), states.present(companions_of_body)
    middle, drift = (masses[1:] @ vectors / masses.sum() for vectors in (place, velocity))
    points = PointMasses(
        mass=xp.asarray(masses[1:]),
        position=xp.asarray(place - middle),
        velocity=xp.asarray(velocity - drift),
        softening=xp.asarray(softening),
    )
    return points, -middle, -drift


def _effect(effects: Sequence[Any]) -> Any:
    return next((effect for effect in effects if effect.kind == "companions"), None)


def refuse_with_particles(scene: Scene, effects: Sequence[Any]) -> None:
    """SceneError where companions cannot be beside particles as the scene has them."""
    effect = _effect(effects)
    if effect is None:
        if scene.has_companions:
            raise SceneError("[[companions]] act on particles by [effects.companions], which the scene does not list.")
        return
    if not scene.has_companions:
        raise SceneError(f"{scene.where_listed('companions')} needs [[companions]] (or [orbits] archive).")
    if scene.orbits.back_reaction:
        raise SceneError('[orbits] back_reaction is of a rigid body; particles act back with motion = "live".')
    if effect.motion == "orbit":
        return
    if scene.orbits.archive is not None:
        raise SceneError(
            f'{scene.where_listed("companions")} motion = "live" begins with [[companions]], not with [orbits] archive.'
        )
    refuse_fields(scene, "live companions")


def refuse_fields(scene: Scene, what: str) -> None:
    """SceneError where a scene lists what would have to act on moving point masses, too."""
    for kind in scene.effects:
        if why := beside_points(kind, what):
            raise SceneError(f"{scene.where_listed(kind)} {why}.")
