"""The scaling model: a body that keeps its profile and its shape while its size and its spin change.

Matter moves as x = s(t) R(t) x_0 with R a rotation about an axis of symmetry; L stays, or changes by the torques of
effects, and the rate of spin goes as L/s^2, a differential rotation keeping its profile. With the moments of the body
at scale 1 (suffix 0), n the axis and T the energy of the rotation,

    Q = s^2 Q_0,   P = s s' Q_0 + L x /2,   K = s'^2 Q_0 + T (1 - n n),   dP/dt = (s'^2 + s s'') Q_0 + N x /2,

with (v x)_jk = eps_ijk v_i. What the listed effects do not bring about of dP/dt is the row "rigidity" of the ledger: it
keeps the shape, and the size too where this is prescribed. Units with G = 1. Tests:
tests/unit/models/scaling/test_evolution.py.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from astroinertia.errors import NumericalError
from astroinertia.inertia.tensor import inertia_from_second_moment
from astroinertia.models.protocol import Figures, Record
from astroinertia.models.rigid.body import View
from astroinertia.models.scaling.homology import Dynamic, Size, SizeLaw
from astroinertia.observables.quantities import BodyState, row

Torque = Callable[[View], Any]

RIGIDITY = "rigidity"
_ALIGNED = 1e-9  # share of L that may stand across the axis of a body that is no sphere
_NO_PROFILE = "the model knows no spherical profile of this body"
PROFILES = ("radius_profile", "density_profile", "rotation_profile", "specific_angular_momentum_profile")


class Pressure(Protocol):
    """What holds a body, by its scale."""

    def integral(self, scale: float) -> float:
        """Volume integral of the pressure, Pi."""
        ...

    def energy(self, scale: float) -> float:
        """Internal energy; NaN where only Pi is known."""
        ...

    def work(self, opening: float, scale: float) -> float:
        """Integral of 3 Pi/s from one scale to another: what expansion has given, out of the internal energy."""
        ...


@dataclass(frozen=True)
class PowerLawPressure:
    """A gas of one exponent: Pi = Pi_0 s^(-3 (gamma - 1)), U = Pi/(gamma - 1)."""

    opening: float
    gamma: float

    def integral(self, scale: float) -> float:
        """Volume integral of the pressure."""
        return self.opening * scale ** (-3 * (self.gamma - 1))

    def energy(self, scale: float) -> float:
        """Internal energy."""
        return self.integral(scale) / (self.gamma - 1)

    def work(self, opening: float, scale: float) -> float:
        """What expansion has given."""
        return self.energy(opening) - self.energy(scale)


@dataclass(frozen=True)
class ShellPressure:
    """Any equation of state on shells of given mass, density at scale 1 and entropy, each (N,)."""

    fluid: Any
    mass: np.ndarray
    density: np.ndarray
    entropy: np.ndarray

    def integral(self, scale: float) -> float:
        """Volume integral of the pressure."""
        density = self.density / scale**3
        return float(self.mass @ (self.fluid.pressure(np, density, self.entropy) / density))

    def energy(self, scale: float) -> float:
        """Internal energy."""
        return float(self.mass @ self.fluid.internal_energy(np, self.density / scale**3, self.entropy))

    def work(self, opening: float, scale: float) -> float:
        """What expansion has given."""
        return self.energy(opening) - self.energy(scale)


@dataclass(frozen=True)
class HeldPressure:
    """Whatever holds a body whose size is known: Pi follows from the scalar virial theorem, U is not known."""

    binding: float  # -(2T + W) at scale 1, taken to go as 1/s

    def integral(self, scale: float) -> float:
        """Volume integral of the pressure."""
        return self.binding / (3 * scale)

    def energy(self, scale: float) -> float:
        """NaN."""
        return math.nan

    def work(self, opening: float, scale: float) -> float:
        """What expansion has given."""
        return self.binding * (1 / opening - 1 / scale)


@dataclass(frozen=True)
class Shells:
    """Spherical shells of equal mass at scale 1: mean radius, density and squared radius, each (B,)."""

    radius: np.ndarray
    density: np.ndarray
    squared_radius: np.ndarray
    relative_rate: np.ndarray  # mean rate of the shell over that of the whole body, L/I


@dataclass(frozen=True)
class Homologous:
    """A body at scale 1 with its opening spin. gravity_tensor and pressure are None where the scene has no such effect.

    spin_constant is T/L^2 at scale 1: 1/(2 I) where the rotation is rigid.
    """

    mass: float
    second_moment: np.ndarray
    gravity_tensor: np.ndarray | None
    pressure: Pressure | None
    angular_momentum: np.ndarray
    axis: np.ndarray
    spin_constant: float
    density_max: float = math.nan
    shells: Shells | None = None

    @property
    def gravitational_energy(self) -> float:
        """W at scale 1; 0 without gravity."""
        return 0.0 if self.gravity_tensor is None else float(np.trace(self.gravity_tensor))

    @property
    def sphere(self) -> bool:
        """Whether the second moment is isotropic."""
        mean = np.trace(self.second_moment) / 3
        return bool(np.abs(self.second_moment - mean * np.eye(3)).max() < 1e-12 * mean)

    def rotational_energy(self, angular_momentum: np.ndarray, scale: float) -> float:
        """T of the rotation."""
        return self.spin_constant * float(angular_momentum @ angular_momentum) / scale**2

    def acceleration(self, angular_momentum: np.ndarray, scale: float) -> float:
        """s'' by the scalar virial theorem."""
        force = 2 * self.rotational_energy(angular_momentum, scale) + self.gravitational_energy / scale
        if self.pressure is not None:
            force += 3 * self.pressure.integral(scale)
        return force / (float(np.trace(self.second_moment)) * scale)


@dataclass
class Scaling:
    """A body under way (models.protocol.Evolution).

    law says the size, or is None where size, spin and the torques' work are integrated together: then `dynamics` has
    the state (s, s', L over its unit (3), work over its unit), as it has where there are torques at all.
    """

    body: Homologous
    law: SizeLaw | None
    dynamics: Dynamic | None
    torques: Mapping[str, Torque]  # of the effects that turn the body
    names: tuple[str, ...]  # of all effects
    units: tuple[float, float]  # of L and of work in the state
    approximation: str
    free: bool  # whether the size follows from the energies, which are then in balance
    time: float = 0.0
    steps: int = 0
    meets_times: bool = True
    resumable: bool = True
    absent: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.effects = (*self.names, RIGIDITY)
        missing: dict[str, str] = {}
        if self.body.shells is None:
            missing.update(dict.fromkeys(PROFILES, _NO_PROFILE))
        if self.body.pressure is not None and math.isnan(self.body.pressure.energy(1.0)):
            missing["internal_energy"] = "the scene names no equation of state"
        self.absent = {**missing, **self.absent}
        self._now = self._state(self.time)
        opening = self._state(0.0)
        self._start, self._opening = opening[0].scale, self._energies(*opening)

    def advance(self, until: float, most: float = math.inf) -> None:
        """Go to a time, or as far towards it as so many steps get; NumericalError where the body collapses before."""
        self.time = until if self.dynamics is None else self.dynamics.reached(until)
        self._now = self._state(self.time)
        self.steps += 1

    def arrays(self) -> dict[str, np.ndarray]:
        """Where it stands: all else follows from the scene."""
        return {"time": np.array(self.time), "steps": np.array(self.steps)}

    def at(self, time: float, steps: int) -> "Scaling":
        """The same body, moved to a checkpoint's time."""
        self._now, self.time, self.steps = self._state(time), time, steps
        return self

    def snapshot(self) -> None:
        """There are no particles."""
        return

    def figures(self) -> Figures:
        """What the progress line shows."""
        energies = self._energies(*self._now)
        largest = max(1e-300, *(abs(value) for value in energies.values()))
        # What torques and a prescribed size have done is no error, nor what pressure has where heat is not known.
        works = self._works(energies, self._now[2])
        outside = [*self._now[2].values(), works[-1]]
        if "pressure" in self.names and math.isnan(self._internal(self._now[0].scale)):
            outside.append(works[self.names.index("pressure")])
        densest = self.body.density_max / self._now[0].scale ** 3
        return Figures(sum(energies.values()) - sum(outside), largest, math.nan, densest)

    def record(self, opening_potential: float | None) -> Record:
        """One row of the headline series."""
        body, (size, momentum, work) = self.body, self._now
        scale, rate, acceleration = size
        axis = self._axis(momentum)
        spin = body.rotational_energy(momentum, scale)
        kinetic = rate**2 * body.second_moment + spin * (np.eye(3) - np.outer(axis, axis))
        energies = self._energies(*self._now)
        torques = self._torques(self.time, size, momentum)
        virial = np.stack([self._virial(name, scale, torques.get(name)) for name in self.names] or [np.zeros((3, 3))])
        change = (rate**2 + scale * acceleration) * body.second_moment + _turning(sum(torques.values(), np.zeros(3)))
        virial = np.concatenate([virial[: len(self.names)], [change - kinetic - virial.sum(axis=0)]])
        torque = np.stack([*(torques.get(name, np.zeros(3)) for name in self.names), np.zeros(3)])
        done = self._works(energies, work)
        total, none = sum(energies.values()), np.zeros((len(self.effects), 3))
        state = BodyState(
            time=self.time, step=self.steps, mass=body.mass, centre_of_mass=np.zeros(3), momentum=np.zeros(3),
            second_moment=scale**2 * body.second_moment,
            mixed_moment=scale * rate * body.second_moment + _turning(momentum),
            kinetic_tensor=kinetic, virial_tensor=virial, force=none, impulse=none, work=done,
            heating=np.array([0.0 - effect_work if name == "pressure" else 0.0
                              for name, effect_work in zip(self.effects, done, strict=True)]),
            kinetic_energy=energies["kinetic"],
            internal_energy=self._internal(scale),
            gravitational_energy=energies["potential"] if body.gravity_tensor is not None else math.nan,
            potential_energy=energies["potential"], total_energy=total,
            integration_energy_error=total - sum(self._opening.values()) - sum(work.values()) if self.free else 0.0,
        )  # fmt: skip
        return row(
            state,
            angular_momentum=momentum,
            torque=torque,
            density_max=body.density_max / scale**3,
            mode_amplitude=np.zeros(4) if body.sphere else np.full(4, math.nan),
            **self._profiles(scale, momentum),
        )

    look = record

    def _state(self, time: float) -> tuple[Size, np.ndarray, dict[str, float]]:
        body = self.body
        if self.dynamics is None:
            assert self.law is not None
            return self.law.at(time), body.angular_momentum, {}
        state = self.dynamics.state(time)
        momentum = self.units[0] * state[2:5]
        if not body.sphere and np.linalg.norm(np.cross(momentum, body.axis)) > _ALIGNED * np.linalg.norm(momentum):
            raise NumericalError("a torque turns the axis of a body that is no sphere: take the model rigid")
        work = dict(zip(self.torques, self.units[1] * state[5:], strict=True))
        if self.law is not None:
            return self.law.at(time), momentum, work
        return Size(state[0], state[1], body.acceleration(momentum, float(state[0]))), momentum, work

    def _torques(self, time: float, size: Size, momentum: np.ndarray) -> dict[str, np.ndarray]:
        seen = turning_body(self.body, time, size.scale, momentum)
        return {name: np.asarray(torque(seen), dtype=float) for name, torque in self.torques.items()}

    def _axis(self, momentum: np.ndarray) -> np.ndarray:
        length = float(np.linalg.norm(momentum))
        return momentum / length if length > 0 and self.body.sphere else self.body.axis

    def _virial(self, name: str, scale: float, torque: np.ndarray | None) -> np.ndarray:
        body = self.body
        if name == "gravity" and body.gravity_tensor is not None:
            return body.gravity_tensor / scale
        if name == "pressure" and body.pressure is not None:
            return body.pressure.integral(scale) * np.eye(3)
        return np.zeros((3, 3)) if torque is None else _turning(torque)

    def _energies(self, size: Size, momentum: np.ndarray, _: dict[str, float]) -> dict[str, float]:
        body = self.body
        radial = 0.5 * size.rate**2 * float(np.trace(body.second_moment))
        internal = self._internal(size.scale)
        return {
            "kinetic": radial + body.rotational_energy(momentum, size.scale),
            "internal": 0.0 if math.isnan(internal) else internal,
            "potential": body.gravitational_energy / size.scale,
        }

    def _internal(self, scale: float) -> float:
        """The internal energy; NaN where no equation of state tells it."""
        return math.nan if self.body.pressure is None else self.body.pressure.energy(scale)

    def _works(self, energies: dict[str, float], work: dict[str, float]) -> np.ndarray:
        # Kinetic energy that each effect has given; what is left has been done by what holds the shape and the size.
        gained = {name: energies[name] - self._opening[name] for name in energies}
        pressure, scale = self.body.pressure, self._now[0].scale
        pressed = 0.0 if pressure is None else pressure.work(self._start, scale)
        works = {"gravity": 0.0 - gained["potential"], "pressure": pressed, **work}
        done = [works.get(name, 0.0) for name in self.names]
        return np.array([*done, 0.0 if self.free else gained["kinetic"] - sum(done)])

    def _profiles(self, scale: float, momentum: np.ndarray) -> Record:
        shells = self.body.shells
        if shells is None:
            return {}
        inertia = 2 / 3 * scale**2 * float(np.trace(self.body.second_moment))
        rate = shells.relative_rate * momentum[2] / inertia
        return {
            "radius_profile": scale * shells.radius,
            "density_profile": shells.density / scale**3,
            "rotation_profile": rate,
            "specific_angular_momentum_profile": 2 / 3 * rate * scale**2 * shells.squared_radius,
        }


def turning_body(body: Homologous, time: float, scale: float, momentum: np.ndarray) -> View:
    """The body at a scale, as a torque sees it; no attitude is followed, so that its axes are those of space."""
    inertia = inertia_from_second_moment(scale**2 * body.second_moment)
    rate = np.linalg.solve(inertia, momentum)
    moments = np.diag(inertia).copy()
    return View(
        time=np.float64(time),
        mass=body.mass,
        attitude=np.eye(3),
        moments=moments,
        principal_moments=np.sort(moments),
        inertia=inertia,
        angular_momentum=momentum,
        angular_velocity=rate,
        companions=None,
    )


def _turning(vector: np.ndarray) -> np.ndarray:
    # Half of (v x)_jk = eps_ijk v_i: the antisymmetric matrix whose axial vector is v.
    x, y, z = 0.5 * np.asarray(vector)
    return np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
