"""How a star that a mass tears apart as it passes by grows, which makes its steps longer. Tests:
tests/unit/costs/test_torn.py.

At the pericentre, at the distance q, the energies of what is torn apart lie within +-G M R/q^2 of the orbit's, and
nothing changes them later (Stone, Sari & Loeb 2013, MNRAS 435, 1809). At the speed of a pericentre these are speeds
within G M R/(q^2 v): in the plane of the orbit the debris grows linearly with time, and its density falls as the
square of that.
"""

import math
from typing import Any

import numpy as np

from astroinertia.units import CodeUnits

# Exponents of polytropes, and by how many times their tidal radius is to be farther out than the pericentre if nothing
# is to stay together (Mainetti et al. 2017, A&A 600, A124).
EXPONENTS, WHOLLY = (4.0 / 3.0, 5.0 / 3.0), (2.01, 0.92)
MOMENTS = 200  # in which its growth is followed


def grown(
    tide: dict[str, Any] | None, units: CodeUnits, index: float | None, mass: float, radius: float, end: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """Times (K,) and sizes (K,), the third root of the volume over that at first, of a polytrope that is torn apart.

    tide: the effect's options; mass, radius and end of the run in code units. None where it holds together, or comes
    back on an ellipse, or is met after the end.
    """
    if tide is None or tide["pericentre_time"] is None or not index:
        return None
    begun = float(units.to_code(tide["pericentre_time"], "time"))
    perturber = float(units.to_code(tide["mass"], "mass"))
    nearest = math.hypot(*(float(units.to_code(x, "length")) for x in tide["position"]))
    depth = radius * (perturber / mass) ** (1.0 / 3.0) / nearest
    if not 0.0 <= begun < end or depth < np.interp(1.0 + 1.0 / index, EXPONENTS, WHOLLY):
        return None
    rate = math.sqrt(perturber / ((1.0 + tide["eccentricity"]) * nearest**3))  # G M/(q^2 v)
    since = np.linspace(0.0, end - begun, MOMENTS)
    times, sizes = begun + since, (1.0 + rate * since) ** (2.0 / 3.0)
    return (np.append(0.0, times), np.append(1.0, sizes)) if begun > 0.0 else (times, sizes)
