"""Densities and smoothing lengths of particles, without what a kernel counts too much of the particle itself."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from astroinertia.engines.elementwise import elementwise
from astroinertia.engines.pytree import pytree
from astroinertia.engines.terms import Output, PairTerm
from astroinertia.errors import NumericalError
from astroinertia.sph.fourth_order import smoothed
from astroinertia.sph.kernels import KERNELS, OWN_SHARE_NEIGHBOURS, neighbour_number, self_excess


@pytree
@dataclass(frozen=True)
class Density:
    """The fluid's, all (N,): smoothing lengths, rho and the factors of their gradients (engines.terms.Density).

    zeta where softening adapts; contrast where rho is of fourth order (sph.fourth_order).
    """

    smoothing_length: Any
    density: Any
    grad_h: Any
    zeta: Any | None = None
    contrast: Any | None = None


def weight_pair(xp, W_i):
    """The kernel of the particle's own length."""
    return (W_i,)


WEIGHT = PairTerm("density", weight_pair, (Output("density", "sum"),))


def without_excess(xp, mass, h, rho, grad_h, excess):
    """The density without it, and Omega."""
    corrected = rho - excess * mass / h**3
    return corrected, grad_h * (rho / corrected)


def without_excess_softened(xp, mass, h, rho, grad_h, zeta, excess):
    """The same with zeta."""
    corrected, changed = without_excess(xp, mass, h, rho, grad_h, excess)
    return corrected, changed, zeta * (rho / corrected)


def wanted(kernel: str, eta: float) -> float:
    """sum_j m_j w(r_ij/h_i) over the particle's own mass, at its smoothing length: eta^3 and the particle's excess."""
    return eta**3 + self_excess(KERNELS[kernel], eta)


def own_share(xp: Any, kernel: str, eta: Any) -> Any:
    """What is taken off the contrast of a density of fourth order for the particle itself (sph.fourth_order)."""
    neighbours = xp.log(neighbour_number(KERNELS[kernel], eta))
    return xp.interp(neighbours, np.log(OWN_SHARE_NEIGHBOURS), np.asarray(KERNELS[kernel].own_share))


def mass_around(kernel: str, eta: float) -> float:
    """How many times its own mass there must be for a particle to have a smoothing length.

    However long it is, sum_j m_j w(r_ij/h_i) is below w(0) times all mass.
    """
    return wanted(kernel, eta) / float(KERNELS[kernel].w(np, 0.0))


def refuse_without_length(kernel: str, eta: float, mass: np.ndarray, spread: float) -> None:
    """NumericalError where particles of masses (N,) and that rms distance cannot all have a smoothing length."""
    needed = mass_around(kernel, eta)
    heaviest = int(np.argmax(mass))
    if not mass.sum() > needed * mass[heaviest]:
        share = mass[heaviest] / mass.sum()
        raise NumericalError(
            f"no smoothing length is long enough: a particle with {share:.2g} of all mass needs {needed:.1f} times its "
            f"own mass around it (with eta = {eta:.3g}); gravity alone can have a softening that is given",
            particle=heaviest,
        )
    if not spread > 0.0:
        raise NumericalError("all particles lie in one place", particle=0)


def refuse_unsolved(eta: float, mass: np.ndarray, solved: Density, identity: np.ndarray) -> None:
    """NumericalError that names a particle whose density is not that of its smoothing length: too many in one place."""
    density = np.asarray(solved.density)
    if solved.contrast is not None:
        (density,) = smoothed(np, density, np.asarray(solved.contrast))
    content = density * np.asarray(solved.smoothing_length) ** 3 / mass
    far = np.flatnonzero(~(np.abs(content / eta**3 - 1.0) < 1e-3))
    if len(far):
        raise NumericalError(
            "no smoothing length is short enough: too many particles lie in one place",
            particle=int(identity[far].min()),
        )


def density(
    engine: Any, arrangement: Any, kernel: str, position: Any, mass: Any, guess: Any, eta: float, tolerance: float,
    softening: bool, targets: Any = None, length: Any = None,
) -> Density:  # fmt: skip
    """h, rho = sum_j m_j W(r_ij, h_i) - excess m_i/h_i^3 = m (eta/h)^3 and their gradient factors, all (N,).

    The excess is constant in units of h, so that Omega and zeta, and with them the forces, follow from the corrected
    density by its Lagrangian (Dehnen & Aly 2012, MNRAS 425, 1068, section 5.1). Without it a settled body comes out 1 %
    too dense with Wendland's C2 on 74 neighbours, whatever the number of particles. `tolerance` is in h; zeta only with
    `softening`. targets: indices of the particles that are asked about, one row each; all without. length: h of all
    particles where it is given; then rho is the sum as it stands, and Omega is 1.
    Tests: tests/unit/sph/test_density.py, and the error of the Dyson ellipsoid against N.
    """
    chosen = {} if targets is None else {"targets": targets}
    if length is not None:
        xp, fields = engine.xp, {"mass": mass, "position": position, "smoothing_length": 0.0 * guess + length}
        rho = engine.neighbour_sums(arrangement, kernel, (WEIGHT,), fields, **chosen)["density"]["density"]
        return Density(xp.zeros_like(rho) + length, rho, xp.ones_like(rho))
    if not KERNELS[kernel].self_excess:
        plain = engine.density(arrangement, kernel, position, mass, guess, eta, tolerance, softening, **chosen)
        return Density(plain.smoothing_length, plain.density, plain.grad_h, plain.zeta)
    excess = self_excess(KERNELS[kernel], eta)
    solved = engine.density(
        arrangement, kernel, position, mass, guess, wanted(kernel, eta) ** (1.0 / 3.0), tolerance, softening, **chosen
    )
    xp, mass = engine.xp, engine.xp.asarray(mass if targets is None else mass[targets])
    quantities = (mass, solved.smoothing_length, solved.density, solved.grad_h)
    if solved.zeta is None:
        rho, grad_h = elementwise(xp, without_excess, *quantities, excess)
        return Density(solved.smoothing_length, rho, grad_h)
    rho, grad_h, zeta = elementwise(xp, without_excess_softened, *quantities, solved.zeta, excess)
    return Density(solved.smoothing_length, rho, grad_h, zeta)
