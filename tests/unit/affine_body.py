"""A synthetic run with known answers: a homogeneous ellipsoid x = A(t) X of perfect gas that collapses and bounces.

Its equation of motion is closed (Chandrasekhar 1969, chapter 4; Dyson 1968): gravity and pressure of a homogeneous
ellipsoid, and a constant tidal field, are linear in x. Code units, G = M = 1. All records follow from A and dA/dt.
"""

import functools

import numpy as np
from scipy.special import elliprd, elliprf

EFFECTS = ["gravity", "pressure", "tide"]
TIDE = 0.02 * np.diag([1.0, -0.5, -0.5])
SOLAR_MASS, G = 1.988409870698051e30, 6.6743e-11
METADATA = {
    "name": "affine star",
    "description": "a homogeneous ellipsoid collapses and bounces",
    "scene": "name = 'affine star'\n",
    "overrides": [],
    "dimensionless": False,
    "code_units": {"mass": 1.4 * SOLAR_MASS, "length": 1.5e6, "G": G},
    "model": "ellipsoid",
    "engine": "numpy",
    "precision": "float64",
    "seed": 1,
    "effects": EFFECTS,
    "versions": {"numpy": np.__version__},
    "reference_radius": 1.0,
    "reference_radius_convention": "mean radius of the initial body",
}


def inertia(second):
    return np.trace(second) * np.eye(3) - second


def axial(tensor):
    return np.array([tensor[1, 2] - tensor[2, 1], tensor[2, 0] - tensor[0, 2], tensor[0, 1] - tensor[1, 0]])


class AffineBody:
    """The equation of motion; internal energy is that of the start times (volume)^(1 - gamma)."""

    def __init__(self, semi_axes=(1.0, 0.94, 0.84), spin=(0.05, 0.0, 0.32), pressure=0.25, gamma=1.42):
        self.start = np.diag(semi_axes)
        self.rate = np.cross(np.eye(3), -np.asarray(spin)).T @ self.start
        self.gamma = gamma
        self.opening = -pressure * self.gravitational_energy(self.start)

    def gravitational_energy(self, matrix):
        squares = np.linalg.svd(matrix, compute_uv=False) ** 2
        return -0.6 * elliprf(*squares)

    def internal_energy(self, matrix):
        return self.opening * (np.linalg.det(matrix) / np.linalg.det(self.start)) ** (1 - self.gamma)

    def tidal_energy(self, matrix):
        return -0.1 * np.trace(TIDE @ matrix @ matrix.T)

    def accelerations(self, matrix):
        """d2A/dt2 of each effect, (3, 3, 3)."""
        axes, size, _ = np.linalg.svd(matrix)
        a, b, c = size**2
        pull = np.array([elliprd(b, c, a), elliprd(c, a, b), elliprd(a, b, c)])
        gravity = -axes @ np.diag(pull) @ axes.T @ matrix
        pressure = 5 * (self.gamma - 1) * self.internal_energy(matrix) * np.linalg.inv(matrix).T
        return np.stack([gravity, pressure, TIDE @ matrix])

    def virials(self, matrix):
        return 0.2 * np.einsum("ik,ejk->eij", matrix, self.accelerations(matrix))

    def slope(self, state):
        matrix, rate = state["matrix"], state["rate"]
        accelerations = self.accelerations(matrix)
        power = 0.2 * np.einsum("eij,ij->e", accelerations, rate)
        virials = self.virials(matrix)
        return {
            "matrix": rate,
            "rate": accelerations.sum(0),
            "second": state["mixed"] + state["mixed"].T,
            "mixed": 0.2 * rate @ rate.T + virials.sum(0),
            "mixed_impulse": virials,
            "work": power,
        }

    def step(self, state, dt):
        """One classical Runge-Kutta step."""

        def moved(slope, length):
            return {name: state[name] + length * slope[name] for name in state}

        k1 = self.slope(state)
        k2 = self.slope(moved(k1, dt / 2))
        k3 = self.slope(moved(k2, dt / 2))
        k4 = self.slope(moved(k3, dt))
        return {name: state[name] + dt / 6 * (k1[name] + 2 * k2[name] + 2 * k3[name] + k4[name]) for name in state}

    def record(self, time, state, particles):
        matrix, rate = state["matrix"], state["rate"]
        second, mixed, kinetic = 0.2 * matrix @ matrix.T, 0.2 * matrix @ rate.T, 0.2 * rate @ rate.T
        virials, work = self.virials(matrix), state["work"]
        heating = np.array([0.0, -work[1], 0.0])
        internal, gravity, tide = (
            self.internal_energy(matrix),
            self.gravitational_energy(matrix),
            self.tidal_energy(matrix),
        )
        opening = self.gravitational_energy(self.start) + self.tidal_energy(self.start)
        evolved = inertia(state["second"])
        return {
            "time": time,
            "step": round(time * 1000),
            "mass": 1.0,
            "centre_of_mass": np.zeros(3),
            "momentum": np.zeros(3),
            "angular_momentum": axial(mixed),
            "second_moment": second,
            "mixed_moment": mixed,
            "kinetic_tensor": kinetic,
            "virial_tensor": virials,
            "virial_mismatch": np.zeros(3),
            "inertia_tensor": inertia(second),
            "inertia_tensor_evolved": evolved,
            "ledger_closure": np.linalg.norm(evolved - inertia(second)) / np.linalg.norm(inertia(self.start**2 / 5)),
            "mixed_impulse": state["mixed_impulse"],
            "torque": np.stack([axial(virial) for virial in virials]),
            "force": np.zeros((3, 3)),
            "impulse": np.zeros((3, 3)),
            "work": work,
            "heating": heating,
            "kinetic_energy": 0.5 * np.trace(kinetic),
            "internal_energy": internal,
            "gravitational_energy": gravity,
            "potential_energy": gravity + tide,
            "total_energy": 0.5 * np.trace(kinetic) + internal + gravity + tide,
            "integration_energy_error": (work + heating)[[0, 2]].sum() + gravity + tide - opening,
            "density_max": 0.75 / np.pi / np.linalg.det(matrix),
            "timestep": 1e-3 * np.linalg.det(matrix),
            "timestep_limit": 1.0,
            "timestep_limit_radius": 0.5,
            "timestep_limit_density": 2.0,
            "wall_time": 0.5 * time,
            **profiles(particles @ matrix.T, particles @ rate.T, 0.75 / np.pi / np.linalg.det(matrix)),
        }


def profiles(position, velocity, density):
    """Eight shells of equal mass, and the azimuthal modes."""
    order = np.argsort(np.linalg.norm(position, axis=1))
    position, velocity = (array[order].reshape(8, -1, 3) for array in (position, velocity))
    spin = (position[..., 0] * velocity[..., 1] - position[..., 1] * velocity[..., 0]).mean(1)
    phase = np.arctan2(position[..., 1], position[..., 0])
    modes = np.array([np.exp(1j * k * phase).mean() for k in (1, 2, 3, 4)])
    return {
        "radius_profile": np.linalg.norm(position, axis=2).mean(1),
        "density_profile": np.full(8, density),
        "rotation_profile": spin / (position[..., :2] ** 2).sum(2).mean(1),
        "specific_angular_momentum_profile": spin,
        "mode_amplitude": abs(modes),
        "mode_phase": np.angle(modes),
    }


def particle_sphere(count, seed=3):
    """Points that fill the unit sphere evenly."""
    generator = np.random.default_rng(seed)
    direction = generator.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    return direction * ((np.arange(count) + 0.5) / count)[:, None] ** (1 / 3)


@functools.cache
def affine_run(outputs=120, end=2.4, particles=1600):
    """Records and snapshots of a run, in code units."""
    body, points = AffineBody(), particle_sphere(particles)
    state = {
        "matrix": body.start,
        "rate": body.rate,
        "second": 0.2 * body.start @ body.start.T,
        "mixed": 0.2 * body.start @ body.rate.T,
        "mixed_impulse": np.zeros((3, 3, 3)),
        "work": np.zeros(3),
    }
    records, snapshots = [], []
    substeps = 10
    for number in range(outputs + 1):
        time = end * number / outputs
        records.append(body.record(time, state, points))
        if number % (outputs // 12) == 0:
            snapshots.append(snapshot(body, time, state, points))
        for _ in range(substeps):
            state = body.step(state, end / outputs / substeps)
    return records, snapshots


def snapshot(body, time, state, points):
    count, matrix = len(points), state["matrix"]
    density = np.full(count, 0.75 / np.pi / np.linalg.det(matrix))
    specific = np.full(count, body.internal_energy(matrix))
    return {
        "time": time,
        "position": points @ matrix.T,
        "velocity": points @ state["rate"].T,
        "mass": np.full(count, 1.0 / count),
        "density": density,
        "smoothing_length": 1.2 * (1.0 / count / density) ** (1 / 3),
        "internal_energy": specific,
        "entropy": specific * (body.gamma - 1) * density ** (1 - body.gamma),
        "pressure": (body.gamma - 1) * density * specific,
    }
