"""The companions of a scene: on orbits that REBOUND finds at once, or an archive holds, or acted on by the body."""

from pathlib import Path
from typing import Any

from astroinertia.errors import NumericalError, SceneError
from astroinertia.scene.schema import Scene
from astroinertia.units import CodeUnits

_COVERED = 1.0 + 1e-9  # of the run by the orbits: its last step may end a rounding late


def companions(scene: Scene, units: CodeUnits, mass: float) -> Any:
    """Where they are at any time of the run (`rotation.ephemeris.Ephemeris`), in code units; None without any."""
    archive = scene.orbits.archive
    if archive is None and not scene.companions:
        return None
    # Only here: other scenes do without REBOUND.
    from astroinertia.rotation.ephemeris import archive_ephemeris, ephemeris

    end = units.to_code(scene.time.end, "time")
    if archive is None:
        return ephemeris(bodies(scene, units, mass), _COVERED * end)
    if scene.companions:
        raise SceneError("[orbits] archive holds the companions, so [[companions]] must not be given with it.")
    try:
        return archive_ephemeris(Path(scene.origin or ".") / archive, end, units=units)
    except (ValueError, NumericalError) as error:
        raise SceneError(f"[orbits] archive: {str(error).rstrip('.')}.") from None


def bodies(scene: Scene, units: CodeUnits, mass: float) -> Any:
    """The body, of that mass in code units, and its companions as a `rebound.Simulation`."""
    from astroinertia.orbits.simulation import in_code_units, simulation

    orbits = scene.orbits
    timestep = None if orbits.timestep is None else units.to_code(orbits.timestep, "time")
    return simulation(mass, in_code_units(scene.companions, units), integrator=orbits.integrator, timestep=timestep)


def refuse_one_sided(scene: Scene) -> None:
    """SceneError where a scene wants the body to act back on the orbits without what that needs."""
    missing = {
        "companions": not scene.companions,
        "the effect gravity_gradient": "gravity_gradient" not in scene.effects,
        '[numerics] integrator = "splitting"': scene.numerics.integrator != "splitting",
    }
    for what, lacking in missing.items():
        if lacking:
            raise SceneError(f"[orbits] back_reaction needs {what}.")
    if scene.body.change is not None:
        raise SceneError("[orbits] back_reaction is for a body that keeps its size, so there can be no [body.change].")
