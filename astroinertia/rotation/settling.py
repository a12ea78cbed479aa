"""Settling of a free body to rotation about its axis of greatest moment: what it must lose, how fast, how long.

Friction inside a body turns energy of rotation into heat and leaves its angular momentum as it is; the rotation of
least energy is that about the axis of the greatest moment. The energy to lose is exact. The time is not: it has the
form

    time = coefficient rigidity Q/(density radius^2 rate^3),

on which all agree, and of whose coefficient authors differ by factors of 10. Burns & Safronov (1973) have 1/K_3^2, 100
for nearly round bodies and 10 for elongated ones; Harris (1994), in practical units, comes to 34 for a rigidity times Q
of 5e11 Pa and 2000 kg/m3; Sharma, Burns & Hui (2005) find some hundreds, so slower settling; Efroimsky & Lazarian
(2000), who count the strains at twice the frequency of the wobble, find it orders of magnitude faster (a factor near
100 is often quoted); Breiter, Rozek & Vokrouhlicky (2012) conclude that these differences, corrected, are much smaller
than was claimed. Rigidity times Q is no better known: the tumblers that are seen need values that are two to four
orders of magnitude apart (Pravec et al. 2005). So a settling time is an order of magnitude, or two.

Source: Burns & Safronov (1973), MNRAS 165, 403; Harris (1994), Icarus 107, 209; Efroimsky & Lazarian (2000), MNRAS 311,
269; Pravec et al. (2005), Icarus 173, 108; Sharma, Burns & Hui (2005), MNRAS 359, 79; Breiter, Rozek & Vokrouhlicky
(2012), MNRAS 427, 755.
"""

from typing import Any

import numpy as np

from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.process.vectors import require_components

Array = Any

SHAPE_FACTOR_ROUND, SHAPE_FACTOR_ELONGATED = 0.01, 0.1  # K_3^2 of Burns & Safronov (1973)
HARRIS_CONSTANT, HARRIS_SPREAD = 17.0, 2.5  # of period/(diameter^(2/3) time^(1/3)) in h, km, Gyr: Harris (1994)
_HOUR, _KILOMETRE, _GIGAYEAR = 3600.0, 1000.0, 1e9 * 365.25 * 86400.0  # Julian years


@with_quantities()
def energy_to_lose(moments: Array, angular_velocity: Array) -> np.ndarray:
    """The energy (...,) that a free body loses until it rotates about its axis of greatest moment, exactly.

    moments (..., 3) and angular_velocity (..., 3) along their axes, in any consistent units. T - L^2/(2 I_max), as the
    sum of I_k w_k^2 (1 - I_k/I_max)/2, in which no digits cancel. Source: Landau & Lifshitz, Mechanics, section 37.

    >>> print(energy_to_lose(np.array([1.0, 2.0, 4.0]), np.array([4.0, 0.0, 0.0])))  # L = 4: 8 J, of which 2 stay
    6.0
    """
    sizes, rates = _checked(moments, angular_velocity)
    largest = sizes.max(-1, keepdims=True)
    return 0.5 * (sizes * rates**2 * ((largest - sizes) / largest)).sum(-1)


@with_quantities()
def energy_above_separatrix(moments: Array, angular_velocity: Array) -> np.ndarray:
    """The energy (...,) that a free body loses until it passes the separatrix; negative once it has.

    T - L^2/(2 I_2): beyond it the angular velocity circles the axis of greatest moment, on one side or on the other,
    which of them nobody can foretell. Source: Landau & Lifshitz, Mechanics, section 37.

    >>> print(energy_above_separatrix(np.array([1.0, 2.0, 4.0]), np.array([4.0, 0.0, 0.0])))  # 8 - L^2 / (2 I_2)
    4.0
    """
    sizes, rates = _checked(moments, angular_velocity)
    middle = np.sort(sizes, axis=-1)[..., 1:2]
    return 0.5 * (sizes * rates**2 * ((middle - sizes) / middle)).sum(-1)


@with_quantities()
def settled_rate(moments: Array, angular_velocity: Array) -> np.ndarray:
    """The rate of rotation (...,) of the settled body, L/I_max: slower than before, as L stays.

    Source: Landau & Lifshitz, Mechanics, section 37.

    >>> print(settled_rate(np.array([1.0, 2.0, 4.0]), np.array([4.0, 0.0, 0.0])))  # L / I_3
    1.0
    """
    sizes, rates = _checked(moments, angular_velocity)
    return np.linalg.norm(sizes * rates, axis=-1) / sizes.max(-1)


@with_quantities(rate="rad/s")
def settling_time(
    rigidity: float,
    quality_factor: float,
    density: float,
    radius: float,
    rate: float,
    shape_factor: float = SHAPE_FACTOR_ROUND,
) -> float:
    """The time rigidity Q/(density K_3^2 radius^2 rate^3) in which a wobble dies away, as Burns & Safronov have it.

    In any consistent units, such as Pa, kg/m3, m, rad/s and s. shape_factor is K_3^2, from 0.01 of nearly round to 0.1
    of elongated bodies. An order of magnitude: see the module's head. ValueError unless all are positive.
    Source: Burns & Safronov (1973), MNRAS 165, 403.

    >>> print(f"{settling_time(4e9, 100.0, 2000.0, 250.0, 1e-4) / 3.15576e7:.1e} yr")  # of a small asteroid
    1.0e+10 yr
    """
    require_positive(rigidity=rigidity, quality_factor=quality_factor, density=density)
    require_positive(radius=radius, rate=rate, shape_factor=shape_factor)
    return rigidity * quality_factor / (density * shape_factor * radius**2 * rate**3)


@with_quantities()
def harris_settling_time(period: float, diameter: float) -> tuple[float, float, float]:
    """The settling time in s of an asteroid by Harris's rule, and the least and the greatest by his spread.

    period in s, diameter in m. P^3/(C^3 D^2) in Gyr with P in h, D in km and C = 17 +- 2.5: the form of Burns &
    Safronov for a rigidity times Q of 5e11 Pa, 2000 kg/m3 and K_3^2 = 0.03. ValueError unless both are positive.
    Source: Harris (1994), Icarus 107, 209.

    >>> time, least, greatest = harris_settling_time(100 * 3600.0, 1e3)  # 1 km, 100 h: still tumbling
    >>> print(f"{time / 3.15576e16:.0f} Gyr")
    204 Gyr
    """
    require_positive(period=period, diameter=diameter)
    scale = (period / _HOUR) ** 3 / (diameter / _KILOMETRE) ** 2 * _GIGAYEAR
    middle, least, greatest = (
        scale / constant**3
        for constant in (HARRIS_CONSTANT, HARRIS_CONSTANT + HARRIS_SPREAD, HARRIS_CONSTANT - HARRIS_SPREAD)
    )
    return middle, least, greatest


@with_quantities()
def settling_power(excess_energy: Array, time: float) -> np.ndarray:
    """The power (...,) that is turned to heat while an energy (...,) above the least is left: 2 energy/time.

    time is that in which the angle of the wobble falls by 1/e, and its energy, which goes as the square, by 1/e^2.
    Source: Burns & Safronov (1973).

    >>> print(settling_power(10.0, 5.0))  # W
    4.0
    """
    return 2.0 * np.asarray(excess_energy, dtype=float) / time


@with_quantities()
def excess_energy(moments: Array, angular_velocity: Array, times: Array, time: float) -> np.ndarray:
    """The energy (...,) above the least, at times (...,), of a body whose wobble dies away at a constant rate.

    moments (3,), angular_velocity (3,) at time 0; `time` as in `settling_power`. Real friction is not so simple next to
    the separatrix, where wobbles are slow. Source: Burns & Safronov (1973).

    >>> print(excess_energy(np.array([1.0, 2.0, 4.0]), np.array([4.0, 0.0, 0.0]), np.array([0.0, 1e9]), 1.0).round(6))
    [6. 0.]
    """
    return energy_to_lose(moments, angular_velocity) * np.exp(-2.0 * np.asarray(times, dtype=float) / time)


@with_quantities()
def time_of_separatrix(moments: Array, angular_velocity: Array, time: float) -> np.ndarray:
    """When (...,) a body that settles as in `excess_energy` passes the separatrix; 0 if it has, infinite if it cannot.

    Source: Burns & Safronov (1973).

    >>> print(f"{time_of_separatrix(np.array([1.0, 2.0, 4.0]), np.array([4.0, 0.0, 0.0]), 1.0):.4f}")
    0.5493
    """
    above, excess = energy_above_separatrix(moments, angular_velocity), energy_to_lose(moments, angular_velocity)
    left = excess - above
    never = left <= 0.0
    taken = np.where(never, np.inf, 0.5 * time * np.log1p(np.maximum(above, 0.0) / np.where(never, 1.0, left)))
    return np.where(above <= 0.0, 0.0, taken)[()]


def _checked(moments: Array, angular_velocity: Array) -> tuple[np.ndarray, np.ndarray]:
    sizes, rates = np.asarray(moments, dtype=float), np.asarray(angular_velocity, dtype=float)
    if sizes.shape[-1:] != (3,) or not (np.isfinite(sizes).all() and (sizes >= 0).all() and (sizes.max(-1) > 0).all()):
        raise ValueError("settling needs three finite moments, none negative and not all 0")
    require_components(angular_velocity=rates)
    return sizes, rates
