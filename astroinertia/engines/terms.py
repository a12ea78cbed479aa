"""What a pair sum is: a function of plain scalars, and what is done with the values that it returns."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

Reduction = Literal["central", "sum", "max", "outer"]


@dataclass(frozen=True)
class Output:
    """One result of a pair term and how it is gathered over the partners j of particle i.

    how = "central": -sum_j m_j q (x_i - x_j)/r, shape (N, 3); q symmetric in i and j conserves momentum.
    how = "sum":      sum_j m_j q, the particle itself included, shape (N,).
    how = "max":      the largest q >= 0 over other particles within reach, shape (N,).
    how = "outer":    sum_j m_j q (F_i - F_j) (x) (x_i - x_j)/r with F = fields[of], shape (N, 3, 3).
    """

    name: str
    how: Reduction
    of: str | None = None


@dataclass(frozen=True)
class PairTerm:
    """A pair function, written once for every engine, and its outputs.

    `pair(xp, ...)` names its scalars: `r`, `h_i`, `W_i`, `dW_i`, `phi_i`, `dphi_i` (and `_j`), `v_r` = v_ij.x_ij/r,
    `x_ij`, `y_ij`, `z_ij` = x_i - x_j, or any per-particle field with the suffix `_i` or `_j`. It is branch-free and
    finite at r = 0, uses only arithmetic and xp.where, maximum, minimum, abs and sqrt, and returns one scalar for each
    output, without the factor m_j.
    `far`, for sums over all pairs, is what `pair` becomes beyond the support of both kernels.
    """

    effect: str
    pair: Callable[..., tuple]
    outputs: tuple[Output, ...]
    far: Callable[..., tuple] | None = None


@dataclass(frozen=True)
class Density:
    """What an engine's density pass gives, all (N,): h with rho = m (eta/h)^3, rho, Omega and, if asked for, zeta.

    grad_h = Omega = 1 + h/(3 rho) drho/dh; zeta = dh/drho sum_j m_j dphi(r, h_i)/dh, the particle itself included
    (Price & Monaghan 2007, MNRAS 374, 1347).
    """

    smoothing_length: Any
    density: Any
    grad_h: Any
    zeta: Any | None
