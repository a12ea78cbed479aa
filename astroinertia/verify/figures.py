"""Rotating figures of compressible bodies: polytropes by the theory of figures."""

from astroinertia.bodies.figures import figure_of_polytrope
from astroinertia.verify.comparison import Quantities

_JUPITER = 0.089195487  # q of Wisdom & Hubbard 2016
_YOSHIDA = {"n1": (1.0, 0.14305187166806682), "n15": (1.5, 0.1706234364060331), "n3": (3.0, 0.2138772103221228)}
"""Index and q of the models of Yoshida 2022 with 1 - c/a = 0.0988."""


def wisdom_hubbard() -> Quantities:
    """Zonal harmonics of the n = 1 polytrope at Jupiter's rotation."""
    figure = figure_of_polytrope(1.0, rotation_parameter=_JUPITER, harmonics=12)
    return {f"j{2 * k + 2}": float(figure.zonal_harmonics[k]) for k in range(4)}


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
