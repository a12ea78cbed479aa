"""Several bodies in one scene: each in its place, and all as one set of particles (code units)."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from astroinertia.build.placing import Particles
from astroinertia.engines.pytree import named_leaves
from astroinertia.errors import SceneError
from astroinertia.scene.schema import Scene
from astroinertia.units import CodeUnits

_SAME_FLUID = 1e-3  # to which bodies must agree on a constant of the equation of state that is taken from them


def together(bodies: Sequence[Particles]) -> Particles:
    """All particles, body after body: identities 0 to N_1 - 1 are the first body's, and so on."""
    if len({body.entropy is None for body in bodies}) > 1:
        raise SceneError("[[bodies]] either all have a specific_internal_energy (or a table with u), or none of them.")

    def joined(name: str) -> np.ndarray | None:
        parts = [getattr(body, name) for body in bodies]
        return None if parts[0] is None else np.concatenate(parts)

    arrays: Any = {name: joined(name) for name in Particles.__dataclass_fields__ if name != "memory"}
    known = {name for body in bodies for name in body.memory}
    # What is known of the particles of one body alone are factors.
    memory = {
        name: np.concatenate([body.memory.get(name, np.ones(len(body.mass))) for body in bodies]) for name in known
    }
    return Particles(**arrays, memory=memory)


def check_same_fluid(equations: Sequence[object]) -> None:
    """SceneError where a constant that is taken "from body" would be another for another body."""
    first, *others = (np.hstack([0.0, *named_leaves(equation).values()]).astype(float) for equation in equations)
    for number, constants in enumerate(others, start=1):
        if not np.allclose(constants, first, rtol=_SAME_FLUID, atol=0.0):
            raise SceneError(
                '[equation_of_state] constant = "from body" is not the same for all bodies '
                f"({first[-1]:.6g} and, for bodies.{number}, {constants[-1]:.6g} in code units); give it as a number."
            )


def places(scene: Scene, units: CodeUnits) -> list[tuple[np.ndarray, np.ndarray]]:
    """Where the centre of each body is and how it moves, two vectors (3,) each."""
    bodies: Any = scene.bodies or (scene.body,)
    if scene.orbit is None:
        states = [(body.position or (0.0, 0.0, 0.0), body.velocity or (0.0, 0.0, 0.0)) for body in bodies]
        return [(units.to_code(np.array(x), "length"), units.to_code(np.array(v), "velocity")) for x, v in states]
    masses = [units.to_code(body.mass, "mass") for body in bodies]
    total, orbit = sum(masses), scene.orbit
    pericentre = units.to_code(orbit.pericentre, "length")
    separation = pericentre if orbit.separation is None else units.to_code(orbit.separation, "length")
    apart, speed = kepler_state(total, pericentre, orbit.eccentricity, separation)
    shares = (-masses[1] / total, masses[0] / total)
    return [(share * apart, share * speed) for share in shares]


def kepler_state(
    mass: float, pericentre: float, eccentricity: float, separation: float
) -> tuple[np.ndarray, np.ndarray]:
    """Relative position and velocity (3,) on the way in to the pericentre on +x, anticlockwise in the x-y plane, G = 1.

    r = p/(1 + e cos f) and v = (M/p)^(1/2) (-sin f, e + cos f) with p = q (1 + e), for any e (Murray & Dermott 1999,
    Solar System Dynamics, section 2.3). Test: tests/unit/build/test_combine.py.
    """
    parameter = pericentre * (1.0 + eccentricity)
    cosine = 1.0 if eccentricity == 0.0 else (parameter / separation - 1.0) / eccentricity
    cosine = min(1.0, max(-1.0, cosine))
    sine = -math.sqrt(1.0 - cosine**2)
    speed = math.sqrt(mass / parameter)
    return separation * np.array([cosine, sine, 0.0]), speed * np.array([-sine, eccentricity + cosine, 0.0])
