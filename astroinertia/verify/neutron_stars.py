"""Neutron stars: structure, slow rotation and tides in general relativity, and the published fits."""

import math

from astroinertia.bodies import neutron_star_fits as fits
from astroinertia.bodies.neutron_stars import maximum_mass, star, star_of_mass
from astroinertia.bodies.tov import structure
from astroinertia.matter.compact_stars import constant_density, energy_polytrope, polytrope, read2009
from astroinertia.process.roots import root_between
from astroinertia.verify.comparison import Quantities

_CONSTANT = 100.0  # K in P = K rho0^2, G = c = Msun = 1
_GAMMA_TWO = polytrope(_CONSTANT, 2.0)
_COMPACTNESS = 0.15  # of the star whose Love number Hinderer's table gives
_UNIFORM = 1e-3  # density of a star of constant density, in G = c = Msun = 1


def textbook_star() -> Quantities:
    """P = 100 rho0^2, central rest density 1.28e-3 (G = c = Msun = 1), and the heaviest such star."""
    body, heaviest = star(_GAMMA_TWO, central_rest_density=1.28e-3), maximum_mass(_GAMMA_TWO)
    return {"gamma2_mass": body.mass, "gamma2_radius": body.radius, "gamma2_heaviest": heaviest.mass}


def schwarzschild() -> Quantities:
    """A star of constant density: its redshift from M/R, and M/R from the central pressure."""
    body = star(constant_density(_UNIFORM), central_pressure=_UNIFORM)
    # P_c = e: 1 - 2 C = ((1 + 1)/(1 + 3))^2 in Schwarzschild's P_c/e = (1 - s)/(3 s - 1), s = sqrt(1 - 2 C)
    return {"uniform_compactness": body.compactness, "uniform_redshift": body.redshift}


def hinderer() -> Quantities:
    """Tidal Love number of P = K e^2 at M/R = 0.15."""
    equation = energy_polytrope(1.0, 2.0)

    def excess(enthalpy: float) -> float:
        return structure(equation, enthalpy).compactness - _COMPACTNESS

    enthalpy = root_between(excess, _COMPACTNESS / 2, 4 * _COMPACTNESS)
    return {"hinderer_love_number": star(equation, central_enthalpy=enthalpy).tidal_love_number}


def realistic() -> Quantities:
    """SLy as a piecewise polytrope: heaviest star, radius of 1.4 Msun, and its moment against the universal fits."""
    equation = read2009("SLy")
    body = star_of_mass(equation, 1.4)
    return {
        "sly_heaviest": maximum_mass(equation).mass,
        "sly_radius": body.radius_km,
        "i_love": (body.moment_bar, float(fits.moment_bar_of_love(body.tidal_deformability))),
        "love_q": (body.quadrupole_bar, float(fits.quadrupole_bar_of_love(body.tidal_deformability))),
        "lattimer_schutz": (body.moment_ratio, float(fits.lattimer_schutz(body.mass, body.radius_km))),
        "breu_rezzolla": (body.moment_ratio, float(fits.breu_rezzolla_moment_ratio(body.compactness))),
    }


def newtonian_limit() -> Quantities:
    """A star so light that relativity does not show: I/(M R^2) of n = 1."""
    faint = star(_GAMMA_TWO, central_rest_density=1e-9)
    unit = math.sqrt(_CONSTANT / (2.0 * math.pi))
    return {"newtonian_moment_ratio": faint.moment_ratio, "newtonian_radius": faint.radius / unit}


COMPUTATIONS = (textbook_star, schwarzschild, hinderer, realistic, newtonian_limit)
