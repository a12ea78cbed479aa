"""The exact answer to a scene, where there is one: recognised from the scene itself, by another route than its models.

Ellipsoids with a linear velocity (affine_exact), a homologous collapse (bodies.homologous_core), the frequency of a
polytrope's radial pulsation (a Rayleigh-Ritz calculation of its modes), free tops (Jacobi's closed form), a body under
the torques of companions (REBOUND's Gragg-Bulirsch-Stoer method, on equations of its own). Tests:
tests/unit/accuracy/test_exact.py.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from astroinertia.accuracy import affine_exact as affine
from astroinertia.bodies.oscillations import radial_modes
from astroinertia.build.flow import initial_velocity
from astroinertia.build.spheres import Sphere, sphere, stretch
from astroinertia.build.spin import rigid_moments, rotation_amount, rotation_axis
from astroinertia.process import activity
from astroinertia.rotation import free_attitude, free_top
from astroinertia.rotation.attitude import attitude_of_quaternion, nearest_rotation, quaternion
from astroinertia.scene.fluids import FROM_BODY
from astroinertia.scene.plan import code_units
from astroinertia.scene.schema import Scene
from astroinertia.units import CodeUnits, pressure_constant_dimension

_DIMENSIONS = {
    "second_moment": "moment_of_inertia",
    "inertia_tensor": "moment_of_inertia",
    "angular_momentum": "angular_momentum",
    "angular_velocity": "angular_velocity",
    "attitude": "dimensionless",
    "frequency of inertia_tensor": "angular_velocity",
}
_CLOSED = 1e-14  # what rounding leaves of a closed form
_PROFILE = 1e-11  # error of the profile of a homologous collapse, and of its rate
_ROUNDED = 2.0**-52  # of the rate of a figure, whose angle then errs by so much for every radian
_SMALL_PULSATION = 0.05  # departure from equilibrium up to which a pulsation is taken for a linear one
_LOOSER = 10.0  # factor of REBOUND's tolerance by which its own error is found
_PARTS = 50  # of the time that REBOUND integrates, after each of which the share that is done is shown
_FREE_FALL_OF_UNSTABLE = 1.0  # free-fall times up to which a compressible uniform fluid may be judged (convection)


@dataclass(frozen=True)
class Exact:
    """Values of dataset variables at the end of the run, in the dataset's units, and what they stand on.

    The key "frequency of NAME" is the angular frequency of every component of a series. accuracy is the relative error
    of the answer itself, below which it says nothing.
    """

    values: Mapping[str, np.ndarray]
    source: str
    accuracy: float


def exact(scene: Scene) -> Exact | None:
    """The exact answer to a scene, None where none is known here.

    >>> from astroinertia.scene import load
    >>> answer = exact(load.load_file("sims/tennis_racket.toml"))
    >>> print(answer.source.split(",")[0], answer.values["attitude"].shape)
    free top in closed form (3, 3)
    """
    if scene.bodies or scene.box is not None or scene.body.change is not None or scene.time.max_steps is not None:
        return None
    units = code_units(scene)
    answer = _rigid(scene, units) if scene.model == "rigid" else _fluid(scene, units)
    if answer is None:
        return None
    values = {name: units.to_si(value, _DIMENSIONS[name]) for name, value in answer.values.items()}
    return Exact(values, answer.source, answer.accuracy)


def _physical(scene: Scene) -> set[str]:
    """The effects of a scene but those that are devices of a numerical method."""
    return {kind for kind in scene.effects if not scene.entries[kind].numerical}


def _fluid(scene: Scene, units: CodeUnits) -> Exact | None:
    body = scene.body
    if scene.companions:
        return None
    if body.homologous:
        return _collapse(scene, units)
    if not (body.homogeneous or body.isentropic or body.polytropic_index):
        return None
    initial = sphere(scene, units)
    return _ellipsoid(scene, units, initial) or _pulsation(scene, initial)


def _ellipsoid(scene: Scene, units: CodeUnits, initial: Sphere) -> Exact | None:
    body: Any = scene.body
    if getattr(body, "perturbation", None) is not None or (body.rotation and body.rotation.law != "rigid"):
        return None
    start = stretch(body) * initial.radius
    acceleration = _acceleration(scene, units, initial, float(np.linalg.det(start)))
    if acceleration is None:
        return None
    rate = _first_rate(scene, units, initial, start)
    moment, end = initial.mass * initial.profile.second_moment, units.to_code(scene.time.end, "time")
    steady = affine.steady_rates(start, rate, acceleration) if _physical(scene) == {"gravity", "pressure"} else None
    if steady is not None:
        spin, inner, left = steady
        at, moving = affine.steady_motion(start, spin, inner, end)
        source = (
            "figure of equilibrium in closed form (Chandrasekhar 1969, ch. 5 and 7): F(t) = R(Omega t) F_0 R(Lambda t)"
        )
        return Exact(affine.observables(at, moving, moment), source, max(left, _ROUNDED * max(1.0, abs(spin) * end)))
    try:
        at, moving = affine.motion(start, rate, acceleration, end)
    except RuntimeError:
        return None
    source = (
        "exact motion of an ellipsoid, its deformation gradient integrated by scipy's DOP853 (accuracy.affine_exact)"
    )
    return Exact(affine.observables(at, moving, moment), source, affine.INTEGRATED)


def _acceleration(scene: Scene, units: CodeUnits, initial: Sphere, volume: float) -> affine.Acceleration | None:
    """d2F/dt2 of the family that a scene belongs to; None where its fluid has no linear velocity."""
    body: Any = scene.body
    fluid: Any = scene.equation_of_state
    effects = _physical(scene)
    parts = []
    if "external_field" in effects:
        matrix = _quadratic(scene)
        if matrix is None:
            return None
        parts.append(affine.field(matrix))
        effects = effects - {"external_field"}
    if body.homogeneous and effects == {"gravity"}:
        return affine.total([affine.gravity(initial.mass), *parts])
    if body.homogeneous and effects == {"gravity", "pressure"}:
        if fluid.kind == "incompressible":
            return affine.incompressible(affine.total([affine.gravity(initial.mass), *parts]))
        equilibrium = fluid.kind == "ideal" and body.entropy is None and body.specific_internal_energy is None
        if not equilibrium or (scene.model == "sph" and not _brief(scene, units, initial)):
            return None
        # P/rho at the centre of the sphere in equilibrium is M/(2 R).
        pressure = 0.5 * (body.pressure_fraction or 1.0) * initial.mass / initial.radius
        parts.append(affine.gas_pressure(pressure, initial.radius**3, fluid.gamma))
        return affine.total([affine.gravity(initial.mass), *parts])
    if body.isentropic and effects == {"pressure"}:
        entropy = _entropy(scene, units)
        if entropy is None:
            return None
        gamma = body.gamma
        central = affine.central_enthalpy(entropy, initial.mass, volume, gamma)
        return affine.total([affine.gas_pressure(central, volume, gamma), *parts])
    return None


def _brief(scene: Scene, units: CodeUnits, initial: Sphere) -> bool:
    free_fall = np.pi / 2.0 * np.sqrt(initial.radius**3 / (2.0 * initial.mass))
    return bool(units.to_code(scene.time.end, "time") <= _FREE_FALL_OF_UNSTABLE * free_fall)


def _quadratic(scene: Scene) -> Any:
    """The matrix of an external field that is nothing but quadratic about the origin (code units); else None."""
    options = {name: value for name, value in scene.effects["external_field"].items() if value is not None}
    others = set(options) - {"quadratic", "origin"}
    pure = scene.dimensionless and not others and not any(options.get("origin", ()))
    return options.get("quadratic") if pure else None


def _entropy(scene: Scene, units: CodeUnits) -> float | None:
    """A = P/rho^gamma of a gas of one entropy whose exponent is that of Dyson's profile; None for any other."""
    body: Any = scene.body
    fluid: Any = scene.equation_of_state
    if fluid.kind not in ("ideal", "polytropic") or fluid.gamma != body.gamma:
        return None
    value = body.entropy if fluid.kind == "ideal" else fluid.constant
    return units.to_code(value, pressure_constant_dimension(fluid.gamma)) if isinstance(value, float) else None


def _first_rate(scene: Scene, units: CodeUnits, initial: Sphere, start: np.ndarray) -> np.ndarray:
    """dF/dt at first (3, 3), by the velocities of six points that have the body's second moment."""
    out = np.sqrt(3.0 * initial.profile.second_moment)
    points = out * np.concatenate([start.T, -start.T])
    velocity = initial_velocity(scene, units, initial, np.full(6, initial.mass / 6.0), points)
    return velocity[:3].T / out


def _collapse(scene: Scene, units: CodeUnits) -> Exact | None:
    """Goldreich and Weber's collapse, while there is a body left."""
    body: Any = scene.body
    fluid: Any = scene.equation_of_state
    if _physical(scene) != {"gravity", "pressure"} or fluid is None or fluid.kind not in ("ideal", "polytropic"):
        return None
    others = (
        "pressure_fraction",
        "entropy",
        "specific_internal_energy",
        "velocity_gradient",
        "rotation",
        "perturbation",
    )
    if any(getattr(body, name) is not None for name in others) or set(body.axes) != {1.0}:
        return None
    if abs(fluid.gamma - 4.0 / 3.0) > _CLOSED or fluid.stated_constant not in (None, FROM_BODY):
        return None
    core = body.core(units.to_code(body.mass, "mass"), units.to_code(body.radius, "length"))
    end = units.to_code(scene.time.end, "time")
    if end >= core.collapse_time:
        return None
    tensor = float(core.moment_at(end)) * np.eye(3)
    source = "homologous collapse of Goldreich and Weber in closed form in time (bodies.homologous_core)"
    accuracy = _PROFILE / (1.0 - end / core.collapse_time)
    return Exact({"inertia_tensor": tensor, "second_moment": 0.5 * tensor}, source, accuracy)


def _pulsation(scene: Scene, initial: Sphere) -> Exact | None:
    """The radial fundamental of a polytrope of one exponent that is a little out of balance, not turning."""
    body: Any = scene.body
    fluid: Any = scene.equation_of_state
    if not body.polytropic_index or _physical(scene) != {"gravity", "pressure"} or body.rotation is not None:
        return None
    if fluid is None or fluid.kind not in ("ideal", "polytropic"):
        return None
    gradient = np.zeros((3, 3)) if body.velocity_gradient is None else np.array(body.velocity_gradient)
    swelling = np.allclose(gradient, gradient[0, 0] * np.eye(3)) and len(set(body.axes)) == 1
    if not swelling or body.entropy is not None or body.specific_internal_energy is not None:
        return None
    own = fluid.stated_constant in (None, FROM_BODY)
    alike = abs(fluid.gamma - 1.0 - 1.0 / body.polytropic_index) < _CLOSED
    mode = radial_modes(body.polytropic_index, fluid.gamma)[0]
    if mode.squared_frequency <= 0.0 or not (fluid.kind == "ideal" or (own and alike)):
        return None
    # A share f of the pressure, f x^(-3 gamma), is in balance with gravity, x^-4, at x times the radius.
    balance = (body.pressure_fraction or 1.0) ** (1.0 / (3.0 * fluid.gamma - 4.0))
    off = abs(body.axes[0] / balance - 1.0)
    if off > _SMALL_PULSATION:
        return None
    omega = np.sqrt(mode.squared_frequency * initial.mass / (initial.radius * balance) ** 3)
    source = (
        "frequency of the radial fundamental of a polytrope by Rayleigh and Ritz (bodies.oscillations), to first order "
        "in the amplitude"
    )
    return Exact({"frequency of inertia_tensor": np.asarray(omega)}, source, max(off**2, 1e-9))


def _rigid(scene: Scene, units: CodeUnits) -> Exact | None:
    body = scene.body
    if not body.solid or scene.orbits.archive is not None:
        return None
    if not scene.effects and not scene.companions:
        return _free(scene, units)
    if set(scene.effects) == {"gravity_gradient"} and scene.companions:
        return _torqued(scene, units)
    return None


def _turning(scene: Scene, units: CodeUnits) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Moments (3,), axes as rows (3, 3) and angular velocity in them (3,), at the start."""
    moments, rows = rigid_moments(scene, units)
    rows = np.asarray(nearest_rotation(rows))
    amount, axis = rotation_amount(scene, units, False), rotation_axis(scene)
    if "angular_momentum" in amount:
        amount = {"rate": amount["angular_momentum"] / float(np.linalg.norm(moments * (rows @ axis)))}
    return moments, rows, rows @ (amount.get("rate", 0.0) * axis)


def _free(scene: Scene, units: CodeUnits) -> Exact:
    moments, rows, spin = _turning(scene, units)
    top = free_top.free_top(moments.tolist(), spin.tolist())
    end = np.asarray(units.to_code(scene.time.end, "time"))
    attitude = free_attitude.attitude(top, end, rows)
    source = "free top in closed form, Jacobi's elliptic functions in 60 digits (rotation.free_top)"
    spread = float(free_attitude.uncertainty(top, end)[1])
    return Exact(_of_attitude(moments, attitude, free_top.angular_velocity(top, end)), source, max(spread, _CLOSED))


def _torqued(scene: Scene, units: CodeUnits) -> Exact:
    body: Any = scene.body
    # Only here: other scenes do without REBOUND.
    from astroinertia.build.companions import bodies
    from astroinertia.orbits.rigid_ode import TOLERANCE, RigidBodyOde
    from astroinertia.orbits.states import masses, present

    moments, rows, spin = _turning(scene, units)
    end = units.to_code(scene.time.end, "time")
    integrated = []
    for number, tolerance in enumerate(tolerances := (TOLERANCE, _LOOSER * TOLERANCE)):
        system = bodies(scene, units, units.to_code(body.mass, "mass"))
        place, velocity = present(system)
        zero = np.zeros((1, 3))
        inside = RigidBodyOde(
            masses(system), np.concatenate([zero, place]), np.concatenate([zero, velocity]), moments,
            np.asarray(quaternion(rows)), spin, back_reaction=scene.orbits.back_reaction, tolerance=tolerance,
        )  # fmt: skip
        for part in range(_PARTS):
            share = (number + part / _PARTS) / len(tolerances)
            with activity.under_way(f"integrating the exact answer, {share:.0%} done"):
                inside.integrate(end * ((part + 1) / _PARTS))
        attitude = np.asarray(attitude_of_quaternion(inside.quaternion))
        integrated.append(_of_attitude(moments, attitude, inside.angular_velocity))
    spread = max(
        float(np.linalg.norm(integrated[0][name] - integrated[1][name]) / np.linalg.norm(integrated[0][name]))
        for name in ("angular_velocity", "attitude")
    )
    source = (
        "same body and companions in REBOUND's interface to differential equations, by Gragg, Bulirsch and Stoer "
        f"with a tolerance of {TOLERANCE:g} (orbits.rigid_ode)"
    )
    return Exact(integrated[0], source, max(spread, _CLOSED))


def _of_attitude(moments: np.ndarray, attitude: np.ndarray, rates: np.ndarray) -> dict[str, np.ndarray]:
    """Variables of the dataset from the body's axes as rows (3, 3) and its angular velocity in them (3,)."""
    inertia = attitude.T @ np.diag(moments) @ attitude
    return {
        "attitude": attitude,
        "inertia_tensor": inertia,
        "angular_velocity": attitude.T @ rates,
        "angular_momentum": attitude.T @ (moments * rates),
    }
