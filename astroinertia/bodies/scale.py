"""The scale of a body whose figure is known: its mass, its mean radius, and the units that it is given in."""

import math


def positive_scale(mass: float, mean_radius: float, gravitational_constant: float) -> dict[str, float]:
    """Return the three as named arguments; ValueError unless each is positive and finite.

    Test: tests/unit/bodies/test_ellipsoids.py, tests/unit/bodies/test_spectral_polytrope.py.
    """
    scale = {"mass": mass, "mean_radius": mean_radius, "gravitational_constant": gravitational_constant}
    for name, value in scale.items():
        if not (0 < value < math.inf):
            raise ValueError(f"the {name.replace('_', ' ')} of a body has to be positive and finite, not {value!r}")
    return scale
