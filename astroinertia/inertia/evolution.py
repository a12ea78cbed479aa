"""How an inertia tensor evolves: its two time derivatives, the share of a force in them, and the waves they send out.

With P = sum m x (x) v, K = sum m v (x) v and V = sum m x (x) a about a point, dQ/dt = P + P^T and
d2Q/dt2 = 2 K + V + V^T, and I follows from Q as in tensor.py. Pure functions of arrays, numpy or jax, any consistent
units but where SI is asked for; particles are mass (..., N) and vectors (..., N, 3) in the axes of an inertial frame.
The point is `origin` (..., 3), at rest; where none is given it is the centre of mass, and velocities and accelerations
are relative to its own. weights (..., N) multiply mass. Source: Chandrasekhar (1969), Ellipsoidal Figures of
Equilibrium, sections 9 to 11. Checked by tests/unit/inertia/test_evolution.py against jax's derivatives of the tensor
itself.
"""

from typing import Any

from astroinertia.inertia.tensor import (
    axial_vector,
    inertia_from_second_moment,
    mixed_moment,
    namespace,
    twice_symmetric,
)
from astroinertia.process.quantities import with_quantities

Array = Any


@with_quantities()
def second_moment_acceleration(kinetic_tensor: Array, virial_tensor: Array) -> Array:
    """d2Q/dt2 = 2 K + V + V^T, (..., 3, 3): the tensor virial theorem, with the sum of all effects' virial tensors.

    >>> print(second_moment_acceleration(np.eye(3), -np.eye(3))[0, 0])  # 2 K + V + V^T: 2 K = -V - V^T is equilibrium
    0.0
    """
    return 2.0 * kinetic_tensor + twice_symmetric(virial_tensor)


@with_quantities()
def inertia_rate(
    mass: Array, position: Array, velocity: Array, origin: Array | None = None, weights: Array | None = None
) -> Array:
    """dI/dt, (..., 3, 3), of particles: the derivative of `inertia_tensor` along the velocities.

    >>> x = np.array([[1.0, 0, 0], [-1.0, 0, 0]])
    >>> print(inertia_rate(np.ones(2), x, 0.5 * x)[2, 2])  # v = H x grows I by 2 H I: I_zz is 2
    2.0
    """
    mixed = mixed_moment(mass, position, velocity, origin, _at_rest(origin), weights)
    return inertia_from_second_moment(twice_symmetric(mixed))


@with_quantities()
def inertia_acceleration(
    mass: Array,
    position: Array,
    velocity: Array,
    acceleration: Array,
    origin: Array | None = None,
    weights: Array | None = None,
) -> Array:
    """d2I/dt2, (..., 3, 3), of particles: the derivative of `inertia_rate` along velocities and accelerations.

    >>> x = np.array([[1.0, 0, 0], [-1.0, 0, 0]])
    >>> print(inertia_acceleration(np.ones(2), x, np.zeros_like(x), -3.0 * x)[2, 2])  # at rest: 2 (-3) I_zz
    -12.0
    """
    kinetic = mixed_moment(mass, velocity, velocity, _at_rest(origin), _at_rest(origin), weights)
    virial = virial_tensor(mass, position, acceleration, origin, weights)
    return inertia_from_second_moment(second_moment_acceleration(kinetic, virial))


@with_quantities()
def virial_tensor(
    mass: Array, position: Array, acceleration: Array, origin: Array | None = None, weights: Array | None = None
) -> Array:
    """V = sum m x (x) a, (..., 3, 3), of one force: all that it does to spin, shape and virial.

    >>> x = np.array([[1.0, 0, 0], [-1.0, 0, 0]])
    >>> print(np.trace(virial_tensor(np.ones(2), x, -x / 4)))  # two unit masses at distance 2 attract: W = -1/2
    -0.5
    """
    return mixed_moment(mass, position, acceleration, origin, _at_rest(origin), weights)


@with_quantities()
def torque(virial_tensor: Array) -> Array:
    """The torque of a force, (..., 3), from its virial tensor V (..., 3, 3) about the same point: eps_ijk V_jk.

    >>> print(torque(np.array([[0.0, 2.0, 0], [0, 0, 0], [0, 0, 0]])))  # the antisymmetric part
    [0. 0. 2.]
    """
    return axial_vector(virial_tensor)


@with_quantities()
def shape_share(virial_tensor: Array) -> Array:
    """The share of a force in d2I/dt2, (..., 3, 3), from its virial tensor: tr(S) 1 - S with S = V + V^T.

    >>> print(np.diag(shape_share(np.diag([0.0, 0.0, -1.0]))))  # what pulls along z lowers I about x and y
    [-2. -2.  0.]
    """
    return inertia_from_second_moment(twice_symmetric(virial_tensor))


@with_quantities()
def gravitational_wave_strain(
    second_moment_acceleration: Array,
    polar_angle: Array,
    azimuth: Array = 0.0,
    distance: Array = 1.0,
    gravitational_constant: float | None = None,
) -> tuple[Array, Array]:
    """Plus and cross strain (...,) of d2Q/dt2 (..., 3, 3) in J, seen from (theta, phi) in radians, at a distance in m.

    The quadrupole formula h_ij = (2 G / c^4 D) TT(d2Q/dt2) of slow bodies in nearly flat space, for the retarded time;
    plus and cross are along the spherical directions theta and phi at the observer. With d2I/dt2 instead of d2Q/dt2 the
    sign flips. Angles and distance (...,) may be arrays; at 1 m the result is strain times distance. The gravitational
    constant is CODATA's where none is given. Source: Thorne (1980), Reviews of Modern Physics 52, 299, eq. 4.8, 4.11.

    >>> plus, cross = gravitational_wave_strain(np.diag([1e40, -1e40, 0.0]), 0.0, distance=3.0857e20)
    >>> print(f"{plus:.2e}, {cross:.0e}")  # J, seen pole-on from 10 kpc
    5.36e-25, 0e+00
    """
    from astroinertia.units import GRAVITATIONAL_CONSTANT, SPEED_OF_LIGHT  # only here: it takes a while to import

    xp = namespace(second_moment_acceleration, polar_angle, azimuth)
    polar_angle, azimuth = xp.broadcast_arrays(xp.asarray(polar_angle), xp.asarray(azimuth))
    sine, cosine = xp.sin(polar_angle), xp.cos(polar_angle)
    theta = xp.stack([cosine * xp.cos(azimuth), cosine * xp.sin(azimuth), -sine], axis=-1)
    phi = xp.stack([-xp.sin(azimuth), xp.cos(azimuth), xp.zeros_like(sine)], axis=-1)

    def along(one: Array, other: Array) -> Array:
        return xp.einsum("...i,...ij,...j->...", one, second_moment_acceleration, other)

    gravity = GRAVITATIONAL_CONSTANT if gravitational_constant is None else gravitational_constant
    length, scale = 1 / SPEED_OF_LIGHT**4, gravity / distance  # whose product is no number of single precision
    return scale * (length * (along(theta, theta) - along(phi, phi))), 2.0 * scale * (length * along(theta, phi))


def _at_rest(origin: Array | None) -> Array | None:
    return None if origin is None else namespace(origin).zeros_like(namespace(origin).asarray(origin))
