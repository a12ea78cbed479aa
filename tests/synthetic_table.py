"""A finite-temperature equation of state with exact thermodynamics, and a file of it as stellarcollapse.org has them.

Ions of 56 nucleons as an ideal gas, black-body radiation and cold degenerate electrons of any speed: the free energy is
the sum of theirs, so that all relations of thermodynamics hold exactly. In SI, but temperatures in MeV. Sources: Landau
& Lifshitz 1980, Statistical Physics, sections 45 and 63; Chandrasekhar 1935, MNRAS 95, 207.
"""

from pathlib import Path
from typing import Any

import h5py
import numpy as np

from astroinertia.units import ATOMIC_MASS, ELECTRON_MASS, REDUCED_PLANCK_CONSTANT as HBAR, SPEED_OF_LIGHT

MEV = 1.602176634e-13  # J
ION = 56.0 * ATOMIC_MASS
RADIATION = np.pi**2 / (15.0 * (HBAR * SPEED_OF_LIGHT) ** 3) * MEV**4  # J/m^3/MeV^4
COMPTON = HBAR / (ELECTRON_MASS * SPEED_OF_LIGHT)
ELECTRONS = ELECTRON_MASS * SPEED_OF_LIGHT**2 / (24.0 * np.pi**2 * COMPTON**3)  # Pa
SHIFT = 2e15  # J/kg
STAR = """
name = "star"
[body]
kind = "polytrope"
index = 3.0
mass = "1.3 Msun"
radius = "1800 km"
particles = 64
relax = false
pressure_fraction = 0.9
[equation_of_state]
kind = "materials"
[[equation_of_state.materials]]
name = "iron"
file = "FILE"
electron_fraction = 0.42
reference_density = "1e10 g/cm3"
[effects.gravity]
[effects.pressure]
[time]
end = "1 ms"
"""
"""A scene of a star on the table of FILE."""


def _momentum(density, fraction):
    return COMPTON * np.cbrt(3.0 * np.pi**2 * density * fraction / ATOMIC_MASS)


def pressure(density, temperature, fraction):
    """P, Pa."""
    x = _momentum(density, fraction)
    electrons = x * (2.0 * x**2 - 3.0) * np.sqrt(1.0 + x**2) + 3.0 * np.arcsinh(x)
    return density * temperature * MEV / ION + RADIATION * temperature**4 / 3.0 + ELECTRONS * electrons


def energy(density, temperature, fraction):
    """u, J/kg."""
    x = _momentum(density, fraction)
    root = np.sqrt(1.0 + x**2)
    electrons = 8.0 * x**3 * (root - 1.0) - x * (2.0 * x**2 - 3.0) * root - 3.0 * np.arcsinh(x)
    heat = 1.5 * temperature * MEV / ION
    return heat + (RADIATION * temperature**4 + ELECTRONS * electrons) / density


def entropy(density, temperature):
    """s in Boltzmann's constants a nucleon; electrons are cold."""
    waves = (ION * temperature * MEV / (2.0 * np.pi * HBAR**2)) ** 1.5
    ions = (np.log(ION / density * waves) + 2.5) / 56.0
    return ions + 4.0 / 3.0 * RADIATION * temperature**3 / density * ATOMIC_MASS / MEV


def arrays(nodes: tuple[int, int, int] = (21, 80, 100)) -> dict[str, np.ndarray]:
    """The arrays of a file of so many electron fractions, temperatures and densities, in cgs."""
    fractions = np.linspace(0.1, 0.5, nodes[0])
    temperatures, densities = np.linspace(-2.0, 2.0, nodes[1]), np.linspace(5.0, 15.0, nodes[2])
    ye, t, rho = np.meshgrid(fractions, 10.0**temperatures, 1e3 * 10.0**densities, indexing="ij")
    return {
        "ye": fractions, "logtemp": temperatures, "logrho": densities, "energy_shift": np.array([1e4 * SHIFT]),
        "logpress": np.log10(10.0 * pressure(rho, t, ye)), "logenergy": np.log10(1e4 * (energy(rho, t, ye) + SHIFT)),
        "entropy": entropy(rho, t),
    }  # fmt: skip


def write(path: Path, content: dict[str, Any] | None = None) -> Path:
    """A file of arrays, those of the exact equation of state without any."""
    with h5py.File(path, "w") as file:
        for name, values in (arrays() if content is None else content).items():
            file[name] = values
    return path
