"""Glitches: a crust and a superfluid inside it that share the angular momentum of a neutron star.

Any consistent units.
"""

from typing import Any, NamedTuple

import numpy as np

from astroinertia.process.quantities import with_quantities

Array = Any


class TwoComponents(NamedTuple):
    """Angular velocities of crust and superfluid, arrays of times."""

    crust: np.ndarray
    superfluid: np.ndarray


@with_quantities(lag_lost="rad/s")
def glitch_size(superfluid_share: Array, lag_lost: Array, angular_velocity: Array) -> Array:
    """Delta Omega/Omega of the crust when the superfluid, a share of the whole moment, gives up some of its lag.

    lag_lost is how much slower the superfluid then turns relative to the crust; L stays, so that
    Delta Omega = (I_s/I) lag_lost. ValueError for a share that is not from 0 to 1. Source: Anderson & Itoh 1975, Nature
    256, 25.

    >>> print(f"{glitch_size(0.01, 0.7e-2, 70.0):.0e}")  # dOmega / Omega
    1e-06
    """
    share = np.asarray(superfluid_share, dtype=float)
    if ((share < 0) | (share > 1)).any():
        raise ValueError("a superfluid has a share of the whole moment from 0 to 1")
    return share * lag_lost / angular_velocity


@with_quantities(external_rate="rad/s2")
def coupled_history(
    times: Array,
    crust_rate: float,
    superfluid_rate: float,
    superfluid_share: float,
    relaxation_time: float,
    external_rate: float = 0.0,
) -> TwoComponents:
    """Crust and superfluid, coupled by friction, from given rates on.

    I_c Omega_c' = I E - I_c I_s/(I tau) (Omega_c - Omega_s) and I_s Omega_s' = I_c I_s/(I tau) (Omega_c - Omega_s):
    their difference relaxes with `relaxation_time` tau to the steady lag E tau I/I_c, and the whole follows
    `external_rate` E = N/I (negative for braking). ValueError unless 0 < I_s/I < 1 and tau > 0. Source: Baym, Pethick,
    Pines & Ruderman 1969, Nature 224, 872.

    >>> print(coupled_history(np.array([0.0, 1e9]), 70.0, 71.0, 0.1, 1e6)[0].round(6))  # both at 70.1
    [70.  70.1]
    """
    if not 0 < superfluid_share < 1 or not relaxation_time > 0:
        raise ValueError("a superfluid has a share of the moment between 0 and 1 and a positive relaxation time")
    times = np.asarray(times, dtype=float)
    crust_share = 1 - superfluid_share
    mean = crust_share * crust_rate + superfluid_share * superfluid_rate + external_rate * times
    steady = external_rate * relaxation_time / crust_share
    lag = steady + (crust_rate - superfluid_rate - steady) * np.exp(-times / relaxation_time)
    return TwoComponents(mean + superfluid_share * lag, mean - crust_share * lag)


@with_quantities(jump="rad/s", lasting_rate="rad/s2")
def recovery(times: Array, jump: Array, healing: Array, relaxation_time: Array, lasting_rate: Array = 0.0) -> Array:
    """Delta Omega(t) after a glitch: jump (1 - Q + Q exp(-t/tau)) plus a lasting change of the derivative times t.

    Q, the healing, is I_s/I where the crust alone has jumped and the superfluid catches up. Of several glitches, times
    (T,) go with jumps and the others of the shape (N, 1), to (N, T). ValueError unless tau is above 0. Source: Lyne,
    Shemar & Graham-Smith 2000, MNRAS 315, 534.

    >>> print(recovery(np.array([0.0, 1e9]), 1e-6, 0.2, 1e6).round(9))  # a fifth heals
    [1.e-06 8.e-07]
    """
    times = np.asarray(times, dtype=float)
    if not np.all(np.asarray(relaxation_time) > 0):
        raise ValueError("the relaxation time of a glitch must be above 0")
    return jump * (1 + np.asarray(healing) * np.expm1(-times / relaxation_time)) + np.asarray(lasting_rate) * times


@with_quantities()
def starquake_moment_change(relative_jump: Array) -> Array:
    """Delta I/I of a crust that cracks and settles at fixed L, for a jump Delta Omega/Omega: 1/(1 + jump) - 1.

    >>> print(f"{starquake_moment_change(1e-8):.1e}")  # dI/I = -dOmega/Omega
    -1.0e-08
    """
    jump = np.asarray(relative_jump, dtype=float)
    return -jump / (1 + jump)


@with_quantities()
def glitch_activity(relative_jumps: Array, time_span: float) -> float:
    """A = (1/t) sum Delta Omega/Omega, in one over the unit of the time span.

    >>> print(f"{glitch_activity([1e-6, 2e-6], 3e8):.0e}")  # in 1/s
    1e-14
    """
    return float(np.sum(np.asarray(relative_jumps, dtype=float)) / time_span)


@with_quantities(activity="s-1")
def least_superfluid_share(activity: Array, characteristic_age: Array) -> Array:
    """I_s/I_c that the reservoir of the glitches must have at least: G = 2 tau_c A, tau_c = P/(2 P').

    The superfluid stores, between glitches, the spin-down that it does not take part in; entrainment in the crust
    raises what is needed (Andersson et al. 2012, PRL 109, 241103). What a crust has of the moment of inertia is in
    `bodies.neutron_stars.crust_moment_share`. Source: Link, Epstein & Lattimer 1999, PRL 83, 3362.

    >>> print(f"{least_superfluid_share(2e-14, 1e12 / 2):.3f}")
    0.020
    """
    return 2 * np.asarray(characteristic_age, dtype=float) * activity
