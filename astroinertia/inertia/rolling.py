"""Bodies that roll down an incline without slipping, and flywheels: what a moment of inertia does to motion.

Pure functions of numpy or jax arrays (...,), which broadcast, in any consistent units; angles in radians. The default
of gravity is in m/s^2, so lengths are then in m and times in s. Checked by tests/unit/inertia/test_rolling.py.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from astroinertia.inertia.body import Body
from astroinertia.inertia.tensor import namespace
from astroinertia.process.known import is_known
from astroinertia.process.quantities import with_quantities

Array = Any

STANDARD_GRAVITY = 9.80665  # m/s^2 (3rd General Conference on Weights and Measures, 1901)


@dataclass(frozen=True)
class Finish:
    """How one body ends a race: its rolling coefficient, the time it took and its speed at the end.

    >>> print(f"{rolling_race(dict(ring=1.0), 2.0, np.pi / 6, gravity=9.0)[0].speed:.4f}")  # v^2 = g h, of a ring
    3.0000
    """

    name: str
    coefficient: float
    time: float
    speed: float


@with_quantities()
def rolling_coefficient(body: Body, radius: Array, axis: Array = (0.0, 0.0, 1.0)) -> Array:
    """I/(m R^2) about the axis (..., 3) through the centre of mass, for a body that rolls on the radius R (...,).

    2/5 for a solid sphere, 1/2 for a solid cylinder, 2/3 for a thin sphere, 1 for a hoop; above 1 for a spool that
    rolls on its hub. Source: Goldstein, Poole & Safko (2002), Classical Mechanics, section 5.3.

    >>> from astroinertia.inertia import shapes
    >>> print(f"{rolling_coefficient(shapes.solid_sphere(3.0, 0.1), 0.1):.2f}")  # k = 2/5
    0.40
    """
    radius = namespace(radius, body.inertia).asarray(radius)
    if is_known(radius) and not (radius > 0).all():
        raise ValueError("the radius on which a body rolls must be positive")
    return body.moment(axis) / (body.mass * radius**2)


@with_quantities()
def rolling_acceleration(coefficient: Array, incline: Array, gravity: Array = STANDARD_GRAVITY) -> Array:
    """g sin(incline) / (1 + k), along the incline, for a body that starts to roll; neither mass nor size matter.

    Source: energy, (1 + k) m v^2 / 2 = m g h (Kleppner & Kolenkow 2014, An Introduction to Mechanics, chapter 7).

    >>> print(f"{rolling_acceleration(0.4, np.pi / 6, gravity=9.8):.2f}")  # g sin / (1 + k) = (5/7) 4.9
    3.50
    """
    xp = namespace(coefficient, incline, gravity)
    return gravity * xp.sin(incline) / (1 + xp.asarray(coefficient))


@with_quantities()
def rolling_time(coefficient: Array, distance: Array, incline: Array, gravity: Array = STANDARD_GRAVITY) -> Array:
    """sqrt(2 d / a): the time to roll a distance down the incline from rest.

    ValueError for a distance that is negative, and for an incline that does not go down: not above 0, or beyond pi/2.

    >>> print(f"{rolling_time(0.4, 3.5, np.pi / 6, gravity=9.8):.4f}")  # sqrt(2 d / a) with a = 3.5
    1.4142
    """
    if is_known(incline) and not ((np.asarray(incline) > 0) & (np.asarray(incline) <= np.pi / 2)).all():
        raise ValueError("incline must be above 0 and at most pi/2, in radians: nothing rolls down another by itself")
    if is_known(distance) and not (np.asarray(distance) >= 0).all():
        raise ValueError("distance must not be negative")
    acceleration = rolling_acceleration(coefficient, incline, gravity)
    return namespace(acceleration, distance).sqrt(2 * distance / acceleration)


@with_quantities()
def least_friction(coefficient: Array, incline: Array) -> Array:
    """tan(incline) k / (1 + k): the coefficient of static friction below which the body slips.

    The friction that turns it is I a / R^2 = k m a, out of a normal force m g cos(incline).

    >>> print(f"{least_friction(0.4, np.pi / 4):.4f}")  # k / (1 + k) at 45 degrees
    0.2857
    """
    xp = namespace(coefficient, incline)
    coefficient = xp.asarray(coefficient)
    return xp.tan(incline) * coefficient / (1 + coefficient)


@with_quantities()
def rolling_race(
    coefficients: Mapping[str, float], distance: float, incline: float, gravity: float = STANDARD_GRAVITY
) -> list[Finish]:
    """The bodies, by name, in the order in which they arrive; all start from rest together and none slips.

    >>> print([each.name for each in rolling_race({"hoop": 1.0, "disc": 0.5, "ball": 0.4}, 2.0, 0.3)])
    ['ball', 'disc', 'hoop']
    """
    finishes = []
    for name, coefficient in coefficients.items():
        time = float(rolling_time(coefficient, distance, incline, gravity))
        finishes.append(Finish(name, float(coefficient), time, 2 * distance / time))
    return sorted(finishes, key=lambda finish: finish.time)


@with_quantities(rate="rad/s")
def flywheel_energy(body: Body, rate: Array, axis: Array = (0.0, 0.0, 1.0)) -> Array:
    """I w^2 / 2 for spin at the rate w (...,), in radians per time, about the axis (..., 3) through the centre of mass.

    A disc of 100 kg and 1 m in diameter stores 1.9 kWh at 10,000 revolutions per minute; `spinning_disc_stress` says
    whether it survives that.

    >>> from astroinertia.inertia import shapes
    >>> disc, rate = shapes.disc(100.0, 0.5), 10_000 * 2 * np.pi / 60
    >>> print(f"{flywheel_energy(disc, rate) / 3.6e6:.2f} kWh")  # 100 kg, 1 m across, 10,000 turns a minute
    1.90 kWh
    """
    return 0.5 * body.moment(axis) * namespace(rate, body.inertia).asarray(rate) ** 2


@with_quantities(angles="rad", rate="rad/s", load="N m")
def flywheel_rates(torque: Array, angles: Array, moment: Array, rate: Array, load: Array | None = None) -> Array:
    """The angular velocity (..., n) of a flywheel driven by a torque that depends on its angle, at angles (n,).

    I w^2/2 grows by the work of `torque` (..., n) less that of a steady `load`, the mean torque where none is given, by
    the trapezoid rule; moment: I (...,); rate: w at the first angle (...,). A flywheel that the load stops is NaN from
    there. For a moment large enough the fluctuation (greatest - least)/mean is (greatest - least work)/(I w^2). Source:
    Norton (2011), Design of Machinery, section 11.11.

    >>> angles = np.linspace(0, 2 * np.pi, 361)
    >>> rates = flywheel_rates(100 * np.sin(2 * angles), angles, moment=2.0, rate=50.0)  # work swings by 100 J
    >>> print(f"{np.ptp(rates) / rates.mean():.4f}")  # 100/(2 50.5^2)
    0.0196
    """
    xp = namespace(torque, angles, moment, rate, load)
    torque, angles = xp.asarray(torque), xp.asarray(angles)
    steps = xp.diff(angles)
    work = xp.cumsum(0.5 * (torque[..., 1:] + torque[..., :-1]) * steps, axis=-1)
    work = xp.concatenate([xp.zeros_like(torque[..., :1]), work], axis=-1)
    turned = angles - angles[..., :1]
    load = work[..., -1:] / turned[..., -1:] if load is None else xp.asarray(load)[..., None]
    square = xp.asarray(rate)[..., None] ** 2 + 2 * (work - load * turned) / xp.asarray(moment)[..., None]
    stopped = xp.cumsum(square <= 0, axis=-1) > 0
    return xp.sqrt(xp.where(stopped, xp.nan, square))


@with_quantities(rate="rad/s")
def spinning_disc_stress(density: Array, radius: Array, rate: Array, poisson_ratio: Array = 0.3) -> Array:
    """(3 + nu)/8 rho w^2 R^2: the greatest stress in a flat disc without a hole, at its centre, hoop and radial alike.

    rate: w, in radians per time; poisson_ratio: 0.3 is that of steel. Source: Timoshenko & Goodier (1970), Theory of
    Elasticity, section 32, rotating disks, plane stress.

    >>> print(f"{spinning_disc_stress(7800.0, 0.5, 500.0) / 1e6:.0f} MPa")  # (3.3/8) rho (w R)^2 of steel
    201 MPa
    """
    return (3 + poisson_ratio) / 8 * density * (rate * radius) ** 2


@with_quantities(strength="Pa")
def bursting_rate(strength: Array, density: Array, radius: Array, poisson_ratio: Array = 0.3) -> Array:
    """The rate w at which `spinning_disc_stress` reaches the strength of the material: no disc of it stores more.

    The energy per mass is then w^2 R^2 / 4 = 2 strength / ((3 + nu) rho), whatever the size.

    >>> print(f"{bursting_rate(1e9, 7800.0, 0.5) * 60 / (2 * np.pi):.0f}")  # turns a minute of steel that bears 1 GPa
    10647
    """
    xp = namespace(strength, density, radius, poisson_ratio)
    return xp.sqrt(strength / spinning_disc_stress(density, radius, 1.0, poisson_ratio))
