"""Rheologies of solids: by how much more they yield to a stress that goes as exp(i omega t) than at once.

Each function is the complex compliance J over the elastic one 1/mu, so that the complex rigidity is mu over it (the
correspondence principle); its imaginary part is negative where heat is made. Frequencies (rad/s) have any shape, NumPy
or JAX. The Maxwell time is viscosity over rigidity. Frozen with their constants by functools.partial, they are what
layers of `bodies.love_numbers` take.

Sources: Andrade 1910, Proc. R. Soc. A 84, 1; Castillo-Rogez, Efroimsky & Lainey 2011, JGR 116, E09008; Renaud & Henning
2018, ApJ 857, 98, of all.
"""

import math
from importlib import import_module
from typing import Any

from astroinertia.inertia.tensor import namespace
from astroinertia.process.quantities import with_quantities

Array = Any


@with_quantities(frequency="rad/s")
def maxwell(frequency: Array, relaxation_time: Array) -> Array:
    """A spring and a dashpot in series, 1 - i/(omega tau_M): flows for good in times above the Maxwell time (s).

    >>> print(maxwell(0.5, 2.0))
    (1-1j)
    """
    return 1 - 1j / (frequency * relaxation_time)


@with_quantities(frequency="rad/s")
def kelvin_voigt(frequency: Array, relaxation_time: Array) -> Array:
    """A spring and a dashpot side by side, 1/(1 + i omega tau): yields late, and no more than the spring in the end.

    >>> print(kelvin_voigt(0.5, 2.0))
    (0.5-0.5j)
    """
    return 1 / (1 + 1j * frequency * relaxation_time)


@with_quantities(frequency="rad/s")
def burgers(frequency: Array, relaxation_time: Array, strength: Array, decay_time: Array) -> Array:
    """Maxwell's and Kelvin and Voigt's in series: `strength` times the elastic compliance more, by the decay time (s).

    >>> print(burgers(0.5, 2.0, 1.0, 2.0))
    (1.5-1.5j)
    """
    return maxwell(frequency, relaxation_time) + strength * kelvin_voigt(frequency, decay_time)


@with_quantities(frequency="rad/s")
def andrade(frequency: Array, relaxation_time: Array, exponent: float = 1 / 3, decay_time: Array = None) -> Array:
    """Maxwell's and a creep that goes as t^exponent: + Gamma(1 + alpha) (i omega tau_A)^-alpha.

    decay_time: tau_A (s), the Maxwell time without it, as laboratories suggest; exponent alpha: 0.2 to 0.4 of rock and
    ice, between 0 and 1 (ValueError otherwise).

    >>> print(f"{andrade(1.0, 1e6):.5f}")  # a million times faster than Maxwell's flow: transient creep
    1.00773-0.00447j
    """
    if isinstance(exponent, float) and not 0 < exponent < 1:
        raise ValueError("the exponent of Andrade's creep is between 0 and 1")
    if isinstance(relaxation_time, float | int) and not relaxation_time > 0:
        raise ValueError(f"the relaxation_time of Andrade's creep must be positive, not {relaxation_time}")
    transient = relaxation_time if decay_time is None else decay_time
    gamma = math.gamma if isinstance(exponent, float) else import_module("jax.scipy.special").gamma  # of a tracer
    return maxwell(frequency, relaxation_time) + gamma(1 + exponent) * (1j * frequency * transient) ** -exponent


@with_quantities(frequency="rad/s", reference_frequency="rad/s")
def absorption_band(frequency: Array, quality: Array, reference_frequency: Array, exponent: float) -> Array:
    """Matter whose Q goes as omega^alpha, over its compliance at the frequency (rad/s) of its moduli and of that Q.

    1 + (cot(alpha pi/2) (x - 1) - i x)/Q with x = (omega_r/omega)^alpha takes moduli of seismic waves to the frequency
    of a tide: with alpha near 0 (1e-6) Q is constant, and the compliance grows by (2/(pi Q)) ln(omega_r/omega). The
    transient part of Andrade's creep has this form exactly, others to first order in 1/Q. ValueError for an exponent
    that is not between 0 and 1. At a negative frequency it is the conjugate. Source: Wahr & Bergen 1986, GJRAS 87, 633,
    as in IERS TN 36, 6.2.1; Kanamori & Anderson 1977, Rev. Geophys. 15, 105.

    >>> print(f"{absorption_band(1e-4, 100.0, 1.0, 0.15):.4f}")  # four decades below: softer by 12 %, Q 27
    1.1242-0.0398j
    """
    if isinstance(exponent, float) and not 0 < exponent < 1:
        raise ValueError("the exponent of an absorption band is between 0 and 1")
    turned, forward = 1j**-exponent, 2 * (frequency > 0) - 1  # at a frequency below 0, the conjugate
    xp = namespace(frequency, quality, reference_frequency, exponent)
    growth = xp.expm1(exponent * xp.log(reference_frequency / abs(frequency)))  # x - 1
    return 1 + (turned.real / -turned.imag * growth - 1j * forward * (1 + growth)) / quality


@with_quantities(frequency="rad/s")
def dissipation(
    love_number: Array,
    fluid_love_number: Array,
    frequency: Array,
    relaxation_time: Array,
    exponent: float | None = None,
) -> Array:
    """-Im k of a homogeneous incompressible body at frequencies above 0, by Maxwell's or Andrade's rheology.

    love_number: the elastic k; fluid_love_number: k of the fluid, 3/(2(n - 1)) of a homogeneous one of degree n. With
    the compliance j, k = k_f/(1 + (k_f/k_e - 1)/j). Source: Efroimsky 2012, CeMDA 112, 283.

    >>> print(f"{dissipation(0.3, 1.5, 1.0, 0.2):.3f}")  # the greatest: at the relaxation time 0.2 (1 + 4)
    0.600
    """
    law = maxwell(frequency, relaxation_time) if exponent is None else andrade(frequency, relaxation_time, exponent)
    return -(fluid_love_number / (1 + (fluid_love_number / love_number - 1) / law)).imag
