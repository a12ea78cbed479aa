"""Rotating figures of compressible bodies: the n = 1 polytrope in full, and other indices."""

from astroinertia.bodies.figures import figure_of_polytrope
from astroinertia.bodies.spectral_polytrope import rotating_polytrope
from astroinertia.verify.comparison import Quantities

_JUPITER = 0.089195487  # q of Wisdom & Hubbard 2016
_YOSHIDA = {"n1": (1.0, 0.14305187166806682), "n15": (1.5, 0.1706234364060331), "n3": (3.0, 0.2138772103221228)}
"""Index and q of the models of Yoshida 2022 with 1 - c/a = 0.0988."""


def wisdom_hubbard() -> Quantities:
    """Zonal harmonics of the n = 1 polytrope at Jupiter's rotation by the spectral solver and by the figure solver."""
    exact, layered = rotating_polytrope(_JUPITER), figure_of_polytrope(1.0, rotation_parameter=_JUPITER)
    harmonics = {f"j{2 * k + 2}": float(exact.zonal_harmonics[k]) for k in range(4)}
    return harmonics | {"j2_of_figures": float(layered.zonal_harmonics[0])}


def yoshida() -> Quantities:
    """Flattening and C/(M a^2) of polytropes at the q of a published sequence."""
    values = {}
    for name, (index, parameter) in _YOSHIDA.items():
        figure = figure_of_polytrope(index, rotation_parameter=parameter)
        values |= {
            f"{name}_flattening": figure.flattening,
            f"{name}_moment_ratio": figure.polar_moment_ratio_equatorial,
        }
    return values


COMPUTATIONS = (wisdom_hubbard, yoshida)
