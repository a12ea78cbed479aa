"""What a pair sum is: a function of plain scalars, and what is done with the values that it returns."""

import inspect
import types
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

Reduction = Literal["central", "sum", "max", "outer"]

COMMON = "common"  # the effect of terms whose sums are of several effects, and of what belongs to none
SEPARATION = ("x_ij", "y_ij", "z_ij")
KERNEL_NAMES = {"W": ("w", 3), "dW": ("dw", 4), "d2W": ("d2w", 5), "phi": ("phi", 1), "dphi": ("dphi", 2)}
"""Scalars of kernels: the functions of a Kernel that they are, and the power of 1/h that goes with each."""


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

    `pair(xp, ...)` names its scalars: `r`, `h_i`, `W_i`, `dW_i`, `d2W_i`, `phi_i`, `dphi_i` (and `_j`),
    `v_r` = v_ij.x_ij/r, `x_ij`, `y_ij`, `z_ij` = x_i - x_j, or any per-particle field with the suffix `_i` or `_j`. It
    is branch-free and finite at r = 0, uses only arithmetic and xp.where, maximum, minimum, abs and sqrt, and returns
    one scalar for each output, without the factor m_j. Scalars that belong together may come as one argument, annotated
    with a NamedTuple of theirs: `i: Gas` with the fields density and u is `density_i` and `u_i`, `strain_j: Tensor` is
    `strain_xx_j` ...
    `far`, for sums over all pairs, is what `pair` becomes beyond the support of both kernels.
    """

    effect: str
    pair: Callable[..., tuple]
    outputs: tuple[Output, ...]
    far: Callable[..., tuple] | None = None

    def __hash__(self) -> int:
        return hash((self.effect, self.pair))  # says enough, and is asked for in every pass


def argument_names(function: Callable) -> list[str]:
    """The names of the scalars that a pair function asks for; ValueError for what is not a Python function."""
    return [name for _, names in _parameters(function) for name in names]


def arguments(function: Callable, scalars: Any) -> list[Any]:
    """What a pair function is called with, without the namespace, made of what `scalars` holds by name."""
    return [made(*(scalars[name] for name in names)) for made, names in _parameters(function)]


def side_of(name: str) -> tuple[str, str]:
    """The field or scalar of a kernel that an argument is of, and its side, i or j; ValueError where it names none."""
    stem, _, side = name.rpartition("_")
    if side not in ("i", "j") or not stem:
        raise ValueError(f"pair functions cannot ask for {name}: it ends neither in _i nor in _j")
    return stem, side


def field_named(fields: dict[str, Any], name: str) -> Any:
    """A field of particles; ValueError where there is none of that name."""
    if name not in fields:
        raise ValueError(f"a pair term asks for the field {name}, which is not among {', '.join(sorted(fields))}")
    return fields[name]


def _parameters(function: Callable) -> list[tuple[Callable, list[str]]]:
    # What each is made by, and of which scalars.
    if not isinstance(function, types.FunctionType):
        raise ValueError(f"a pair function must be a plain Python function, not {function!r}")
    parameters = []
    for name, parameter in list(inspect.signature(function).parameters.items())[1:]:
        stem, joint, side = name.rpartition("_")
        if fields := getattr(parameter.annotation, "_fields", None):
            parameters.append((parameter.annotation, [f"{stem}{joint}{field}_{side}" for field in fields]))
        else:
            parameters.append((lambda scalar: scalar, [name]))
    return parameters


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
