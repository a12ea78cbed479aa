"""Densities and smoothing lengths of particles, without what a kernel counts too much of the particle itself."""

from typing import Any

from astroinertia.engines.terms import Density
from astroinertia.sph.kernels import KERNELS, self_excess


def density(
    engine: Any, arrangement: Any, kernel: str, position: Any, mass: Any, guess: Any, eta: float, tolerance: float,
    softening: bool,
) -> Density:  # fmt: skip
    """h, rho = sum_j m_j W(r_ij, h_i) - excess m_i/h_i^3 = m (eta/h)^3 and their gradient factors, all (N,).

    The excess is constant in units of h, so that Omega and zeta, and with them the forces, follow from the corrected
    density by its Lagrangian (Dehnen & Aly 2012, MNRAS 425, 1068, section 5.1). Without it a settled body comes out 1 %
    too dense with Wendland's C2 on 74 neighbours, whatever the number of particles. `tolerance` is in h; zeta only with
    `softening`. Tests: tests/unit/test_density.py, and the error of the Dyson ellipsoid against N.
    """
    if not KERNELS[kernel].self_excess:
        return engine.density(arrangement, kernel, position, mass, guess, eta, tolerance, softening)
    excess = self_excess(KERNELS[kernel], eta)
    found = engine.density(
        arrangement, kernel, position, mass, guess, (eta**3 + excess) ** (1.0 / 3.0), tolerance, softening
    )
    rho = found.density - excess * mass / found.smoothing_length**3
    ratio = found.density / rho
    zeta = None if found.zeta is None else found.zeta * ratio
    return Density(found.smoothing_length, rho, found.grad_h * ratio, zeta)
