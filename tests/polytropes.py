"""Settled polytropes: judged against the exact body, and set ringing. M = R = G = 1 throughout."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.models.sph.evaluate import internal_energy, potential_energies
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.sorting import rearranged
from astroinertia.models.sph.state import Problem
from astroinertia.models.sph.step import step
from astroinertia.studies.relax import polytrope_problem

REFERENCE = Path(__file__).parent / "reference"


def errors(body: xr.Dataset) -> dict[str, float]:
    """Relative errors of I/(M R^2) with the analytic R = 1, W, the radius-free I W^2, and the central density."""
    inertia = float(np.trace(body.moment_of_inertia)) / 3 / body.moment_of_inertia.exact_at_rest
    energy = float(body.gravitational_energy) / body.gravitational_energy.exact_at_rest
    density = float(body.central_density) / body.central_density.exact_at_rest
    return {
        "inertia": inertia - 1,
        "gravitational_energy": energy - 1,
        "radius_free": inertia * energy**2 - 1,
        "central_density": density - 1,
    }


def mode_frequencies(index: float) -> tuple[float, float]:
    """omega of the radial fundamental and of the l = 2 f-mode for gamma = 1 + 1/n, in units of sqrt(G M/R^3)."""
    gamma = {1.0: "2", 1.5: "5/3"}[index]
    table = json.loads((REFERENCE / "modes.json").read_text())

    def entry(name: str, **inputs: Any) -> Any:
        (value,) = (
            item["value"]
            for item in table
            if item["name"] == name and all(item["inputs"].get(key) == wanted for key, wanted in inputs.items())
        )
        return value

    radial = float(entry("polytrope.radial_mode_omega2", n=index, Gamma1=gamma, mode=0))
    quadrupole = float(entry("polytrope.l2_modes_omega2", n=index, Gamma1=gamma)[0])
    return radial**0.5, quadrupole**0.5


def ring(
    index: float, body: xr.Dataset, end: float, amplitude: float = 0.01, courant: float = 0.4, precision: str = "mixed"
) -> dict[str, np.ndarray]:
    """Set a settled body ringing and follow tr Q and Q_zz - (Q_xx + Q_yy)/2 without any damping.

    Both oscillations start at rest size: v = a omega x for the radial one and a omega (-x/2, -y/2, z) for l = 2, so
    that the axes change by the share `amplitude`.
    """
    radial, quadrupole = mode_frequencies(index)
    mass, x = body.mass.values, body.position.values
    x = x - mass @ x
    velocity = amplitude * (radial * x + quadrupole * x * [-0.5, -0.5, 1.0])
    problem = replace(polytrope_problem(index, len(mass), body.kernel, precision), courant=courant)
    state, arrangement = initial_state(problem, mass, x, velocity, body.entropy.values)
    energy = [_energy(problem, state)]
    times, traces, quadrupoles = [], [], []
    while True:
        x = state.position - state.mass @ state.position
        moment = state.mass @ x**2
        times.append(float(state.time))
        traces.append(float(moment.sum()))
        quadrupoles.append(float(moment[2] - (moment[0] + moment[1]) / 2))
        if times[-1] >= end:
            break
        if int(state.step) % 16 == 0:
            state, arrangement = rearranged(problem, state)
        state = step(problem, arrangement, state, state.rates.timestep)
    energy.append(_energy(problem, state))
    return {
        "time": np.array(times),
        "trace": np.array(traces),
        "quadrupole": np.array(quadrupoles),
        "energy": np.array(energy),
    }


def _energy(problem: Problem, state: Any) -> float:
    kinetic = 0.5 * float(state.mass @ (state.velocity**2).sum(axis=1))
    return kinetic + float(potential_energies(problem, state)["gravity"] + internal_energy(problem, state))


def fitted_frequency(time: np.ndarray, signal: np.ndarray, guess: float) -> tuple[float, float, float]:
    """omega, amplitude and rms misfit over amplitude of a sinusoid on a slow parabola, by least squares.

    For each omega the other coefficients are linear; the misfit is minimised over omega by a scan of +-25 % and a
    golden section.
    """

    def fit(omega: float) -> tuple[float, float]:
        t = time / time[-1]
        columns = [np.ones_like(t), t, t**2, np.cos(omega * time), np.sin(omega * time)]
        design = np.stack(columns, axis=1)
        coefficients, *_ = np.linalg.lstsq(design, signal, rcond=None)
        misfit = float(np.sqrt(np.mean((signal - design @ coefficients) ** 2)))
        return misfit, float(np.hypot(coefficients[3], coefficients[4]))

    omegas = guess * np.linspace(0.75, 1.25, 201)
    best = int(np.argmin([fit(omega)[0] for omega in omegas]))
    low, high = omegas[max(best - 1, 0)], omegas[min(best + 1, 200)]
    golden = (5**0.5 - 1) / 2
    for _ in range(60):
        one, two = high - golden * (high - low), low + golden * (high - low)
        low, high = (low, two) if fit(one)[0] < fit(two)[0] else (one, high)
    omega = (low + high) / 2
    misfit, amplitude = fit(omega)
    return omega, amplitude, misfit / amplitude
