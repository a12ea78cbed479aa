"""A synthetic run of a free rigid body with known laws: L stays in space, the attitude follows omega = I^-1 L.

Code units, G = M = 1; the moments and the spin near the intermediate axis of truths' asymmetric tops, at choice.
"""

import functools

import numpy as np

from tests.unit.affine_body import METADATA, axial, inertia

RIGID = {
    **METADATA, "name": "rigid body", "description": "a racket thrown into the air", "model": "rigid",
    "effects": ["rigidity"], "absent": {"internal_energy": "a rigid body has none"},
}  # fmt: skip


def cross(vector):
    return np.cross(np.eye(3), -np.asarray(vector)).T


def angular_velocity(axes, moments, momentum):
    return axes.T @ (axes @ momentum / moments)


def turned(axes, moments, momentum, dt):
    """One classical Runge-Kutta step of de_k/dt = omega x e_k, kept orthonormal."""

    def slope(rows):
        return rows @ cross(angular_velocity(rows, moments, momentum)).T

    k1 = slope(axes)
    k2 = slope(axes + dt / 2 * k1)
    k3 = slope(axes + dt / 2 * k2)
    k4 = slope(axes + dt * k3)
    left, _, right = np.linalg.svd(axes + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
    return left @ right


def rigid_record(time, axes, moments, momentum, opening):
    tensor = axes.T @ np.diag(moments) @ axes
    second = 0.5 * np.trace(tensor) * np.eye(3) - tensor
    spin = angular_velocity(axes, moments, momentum)
    mixed = second @ cross(spin).T
    kinetic = cross(spin) @ second @ cross(spin).T
    energy = 0.5 * spin @ momentum
    change = np.linalg.solve(tensor, -np.cross(spin, momentum))
    # dP/dt = K + V with v = omega x x: the internal forces that hold the shape
    virial = second @ (cross(change) + cross(spin) @ cross(spin)).T
    return {
        "time": time,
        "step": round(100 * time),
        "mass": 1.0,
        "centre_of_mass": np.zeros(3),
        "momentum": np.zeros(3),
        "angular_momentum": axial(mixed),
        "second_moment": second,
        "mixed_moment": mixed,
        "kinetic_tensor": kinetic,
        "virial_tensor": virial[None],
        "inertia_tensor": tensor,
        "inertia_tensor_evolved": tensor,
        "ledger_closure": 1e-15 * (1 + np.sin(time) ** 2),
        "mixed_impulse": (mixed - opening["mixed_moment"] if opening else np.zeros((3, 3)))[None] * 0.0,
        "torque": np.zeros((1, 3)),
        "force": np.zeros((1, 3)),
        "impulse": np.zeros((1, 3)),
        "work": np.zeros(1),
        "heating": np.zeros(1),
        "kinetic_energy": energy,
        "internal_energy": np.nan,
        "gravitational_energy": np.nan,
        "potential_energy": 0.0,
        "total_energy": energy,
        "integration_energy_error": energy - opening["kinetic_energy"] if opening else 0.0,
        "density_max": np.nan,
        "timestep": 0.01,
        "wall_time": 0.001 * time,
        "attitude": axes,
    }


@functools.cache
def rigid_run(moments=(0.2, 0.3, 0.4), spin=(0.1, 1.0, 0.1), end=30.0, outputs=300):
    """Records of a free top that starts with its principal axes along x, y and z, in code units."""
    moments, axes = np.asarray(moments), np.eye(3)
    momentum = moments * np.asarray(spin)
    records: list[dict] = []
    substeps = max(1, round(end / outputs / 0.01))
    for number in range(outputs + 1):
        time = end * number / outputs
        records.append(rigid_record(time, axes, moments, momentum, records[0] if records else None))
        for _ in range(substeps):
            axes = turned(axes, moments, momentum, end / outputs / substeps)
    assert np.allclose(inertia(records[-1]["second_moment"]), records[-1]["inertia_tensor"])
    return records
