"""Barotropic matter as a self-consistent field needs it: density and pressure from the enthalpy h = int dP/rho.

Both are functions of x = h/h_max, 0 <= x <= 1, in units of the largest density rho_max and of rho_max h_max.
Tests: tests/unit/bodies/test_scf.py.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

SOFTEST = 4.5  # index up to which the iteration converges to round-off and the virial theorem to 1e-6 (measured)
_SMALLEST = 1e-200  # of h_max: where a law is asked for nothing at all, for its logarithms' sake


class Law(Protocol):
    """A barotropic law in any consistent units: those of barotropes.py have both, and more."""

    def density(self, enthalpy) -> np.ndarray:
        """Density at an enthalpy above zero, zero at zero."""
        ...

    def pressure(self, enthalpy) -> np.ndarray:
        """Pressure at an enthalpy above zero."""
        ...


@dataclass(frozen=True)
class Matter:
    """density(x)/rho_max and pressure(x)/(rho_max h_max); max_density and max_enthalpy are None where all scales do."""

    name: str
    density: Callable[[np.ndarray], np.ndarray]
    pressure: Callable[[np.ndarray], np.ndarray]
    max_density: float | None = None
    max_enthalpy: float | None = None


def polytropic_matter(index: float) -> Matter:
    """Return P = K rho^(1 + 1/n): rho ~ h^n, P = rho h/(n + 1); ValueError outside 0 <= n <= 4.5. n = 0 is a liquid.

    Source: Hachisu 1986, ApJS 61, 479, eq. 6. Test: tests/unit/bodies/test_scf.py.

    >>> matter = polytropic_matter(1.5)
    >>> print(float(matter.density(np.array(0.25))), float(matter.pressure(np.array(1.0))))  # x^n, 1/(n + 1)
    0.125 0.4
    """
    n = float(index)
    if not 0 <= n <= SOFTEST:
        raise ValueError(f"a rotating polytrope needs an index 0 <= n <= {SOFTEST}, not {index!r}: cores get too small")
    return Matter(
        name=f"polytrope of index {n:g}",
        density=lambda x: np.where(x > 0, np.maximum(x, 0.0) ** n, 0.0),
        pressure=lambda x: np.maximum(x, 0.0) ** (n + 1) / (n + 1),
    )


def matter_of(law: Law, max_enthalpy: float, name: str = "barotrope") -> Matter:
    """Return the matter of a law up to a largest enthalpy, in the law's units; ValueError unless that is positive.

    Test: tests/unit/bodies/test_scf.py.

    >>> from astroinertia.bodies.barotropes import PolytropicLaw
    >>> matter = matter_of(PolytropicLaw(1.5), 2.0)
    >>> print(f"{matter.max_density:.6f} {matter.density(np.array(0.25)):.6f}")  # (2/2.5)^1.5, and 0.25^1.5
    0.715542 0.125000
    """
    if not (math.isfinite(max_enthalpy) and max_enthalpy > 0):
        raise ValueError(f"the largest enthalpy must be positive and finite, not {max_enthalpy!r}")
    densest = float(law.density(np.array([max_enthalpy]))[0])

    def scaled(curve, unit):
        return lambda x: np.where(x > 0, curve(np.maximum(x, _SMALLEST) * max_enthalpy), 0.0) / unit

    return Matter(name, scaled(law.density, densest), scaled(law.pressure, densest * max_enthalpy),
                  densest, float(max_enthalpy))  # fmt: skip
