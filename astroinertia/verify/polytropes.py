"""Polytropes: Lane-Emden numbers, moment ratios, apsidal constants and modes."""

from astroinertia.bodies.apsidal import apsidal_constant, love_number
from astroinertia.bodies.oscillations import nonradial_modes, radial_modes
from astroinertia.bodies.polytrope import Polytrope, lane_emden
from astroinertia.verify.comparison import Quantities

_GAMMA = 5.0 / 3.0


def structure() -> Quantities:
    """Surface, mass, condensation and moment ratio of the usual indices."""
    values = {}
    for name, index in (("n1", 1.0), ("n15", 1.5), ("n3", 3.0)):
        solution = lane_emden(index)
        values |= {
            f"{name}_surface": solution.xi_1,
            f"{name}_mass": solution.surface_mass,
            f"{name}_condensation": solution.central_to_mean,
            f"{name}_moment_ratio": solution.moment_ratio,
            f"{name}_energy": Polytrope(index, 1.0, 1.0).gravitational_energy,
        }
    return values


def love_numbers() -> Quantities:
    """Response to a tide: k_2, and half of it where apsidal motion is given."""
    return {
        "n1_love_number": love_number(1.0),
        "n15_apsidal_constant": apsidal_constant(1.5),
        "n3_apsidal_constant": apsidal_constant(3.0),
    }


def modes() -> Quantities:
    """Squared frequencies in G M/R^3 of the uniform sphere and of n = 3."""
    uniform = {mode.label: mode.squared_frequency for mode in radial_modes(0.0, _GAMMA, 2)}
    (kelvin,) = nonradial_modes(0.0, _GAMMA, 2, 0, 0)
    standard = {mode.label: mode.squared_frequency for mode in nonradial_modes(3.0, _GAMMA, 2, 1, 1)}
    return {
        "uniform_fundamental": uniform["F"],
        "uniform_overtone": uniform["1O"],
        "kelvin_mode": kelvin.squared_frequency,
        "n3_fundamental": standard["f"],
    }


COMPUTATIONS = (structure, love_numbers, modes)
