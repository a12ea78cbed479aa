"""Cold degenerate electrons: the equation of state of white dwarfs, for bodies.neutron_stars.

With x the Fermi momentum over m_e c, the rest density is that of the nucleons, rho0 ~ x^3, and the specific enthalpy is
eta = (m_e/(mu_e m_u)) ((1 + x^2)^(1/2) - 1), so that x and all else follow from eta in closed form. Coulomb corrections
(a few per cent of the pressure) are left out. Units are geometric, G = c = Msun = 1.

Source: Chandrasekhar 1935, MNRAS 95, 207; Shapiro & Teukolsky 1983, Black Holes, White Dwarfs and Neutron Stars,
section 2.3.
"""

import math
from dataclasses import dataclass

from astroinertia.matter.compact_stars import Barotrope, geometric_density
from astroinertia.units import ATOMIC_MASS, ELECTRON_MASS, REDUCED_PLANCK_CONSTANT, SPEED_OF_LIGHT

_COMPTON = REDUCED_PLANCK_CONSTANT / (ELECTRON_MASS * SPEED_OF_LIGHT)  # reduced Compton wavelength of the electron, m
_SMALL = 0.5  # x below which the series of the pressure is summed: there its closed form is a small difference
_ROUND_OFF = 1e-17  # of the series


@dataclass(frozen=True)
class DegenerateElectrons:
    """rho0 = density x^3, and eta = scale ((1 + x^2)^(1/2) - 1)."""

    density: float
    scale: float

    def at(self, enthalpy: float) -> tuple[float, float, float]:
        """Rest-mass density, pressure and energy density at eta."""
        kinetic = enthalpy / self.scale
        x = math.sqrt(kinetic * (kinetic + 2))
        density, pressure = self.density * x**3, 3 * self.density * self.scale * _pressure(x)
        return density, pressure, density * (1 + enthalpy) - pressure

    def sound_speed_squared(self, enthalpy: float) -> float:
        """Return dP/de at eta, in c^2."""
        kinetic = enthalpy / self.scale
        return self.scale * kinetic * (kinetic + 2) / (3 * (1 + enthalpy) * (1 + kinetic))


def _pressure(x: float) -> float:
    # Integral of x^4/(1 + x^2)^(1/2)/3 from 0 to x: (x (1 + x^2)^(1/2) (2 x^2/3 - 1) + arsinh x)/8.
    if x < _SMALL:
        square, total, factor, k = x * x, 0.2, 1.0, 0
        while abs(factor) > _ROUND_OFF:
            factor *= -square * (2 * k + 1) / (2 * k + 2)
            k += 1
            total += factor / (5 + 2 * k)
        return x**5 * total / 3
    return (x * math.sqrt(1 + x * x) * (2 * x * x / 3 - 1) + math.asinh(x)) / 8


def degenerate_electrons(nucleons_per_electron: float = 2.0) -> Barotrope:
    """The ideal gas of cold electrons that nucleons make heavy, mu_e of them each: 2 for He, C and O, 2.15 for Fe.

    ValueError unless mu_e is at least 1.

    >>> from astroinertia.bodies.neutron_stars import star
    >>> print(f"{star(degenerate_electrons(), central_rest_density=1e-8).mass:.2f}")  # solar masses
    1.41
    """
    if not (math.isfinite(nucleons_per_electron) and nucleons_per_electron >= 1):
        raise ValueError(f"there is at least one nucleon for each electron, not {nucleons_per_electron}")
    nucleon = nucleons_per_electron * ATOMIC_MASS
    density = float(geometric_density(nucleon / (3 * math.pi**2 * _COMPTON**3)))
    piece = DegenerateElectrons(density, ELECTRON_MASS / nucleon)
    return Barotrope(f"degenerate electrons of mu_e {nucleons_per_electron:g}", (0.0, math.inf), (piece,))
