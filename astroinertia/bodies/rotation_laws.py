"""Rotation laws that a barotropic star can have: Omega depends on the distance w from the axis alone.

    rigid        Omega = Omega_0
    j_constant   Omega = Omega_0 A^2/(A^2 + w^2)         specific angular momentum constant far outside A
    v_constant   Omega = Omega_0 A/(A^2 + w^2)^(1/2)     velocity constant far outside A

Source: Hachisu 1986, ApJS 61, 479, eqs. 11-13; Eriguchi & Mueller 1985, A&A 146, 260. Tests:
tests/unit/bodies/test_scf.py.
"""

import math
from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np

from astroinertia.process.quantities import with_quantities

LAWS = ("rigid", "j_constant", "v_constant")


class Law(Protocol):
    """What is asked of a rotation law; lengths are in the unit of its scale."""

    @property
    def kind(self) -> str:
        """Its name."""
        ...

    @property
    def scale(self) -> float | None:
        """The length over which it falls off, where one number says it."""
        ...

    def rate(self, w: Any) -> np.ndarray:
        """Omega/Omega_0 at distance w from the axis."""
        ...

    def potential(self, w: Any) -> np.ndarray:
        """Integral from 0 to w of (Omega/Omega_0)^2 w dw."""
        ...

    def scaled(self, length: float) -> Self:
        """The law with its lengths times `length`."""
        ...


class FollowingLaw(Law, Protocol):
    """A law that is found with the star: `rates` is what is sought, any K numbers of the order of one."""

    @property
    def rates(self) -> Any:
        """The numbers that make the law what it is."""
        ...

    def with_rates(self, rates: np.ndarray) -> Self:
        """The law with other numbers."""
        ...

    def followed(self, field: Any) -> np.ndarray:
        """The numbers (K,) that a star (scf.Field) with this law asks for: its own where it is the star sought."""
        ...


@with_quantities(scale="m")
@dataclass(frozen=True)
class RotationLaw:
    """A law by its kind and scale A (any unit of length; None for rigid); ValueError where these contradict.

    Lengths are given to the methods in the unit of the scale.

    >>> law = RotationLaw("j_constant", 0.5)
    >>> print(law.rate([0.0, 0.5]), f"{law.rate(1e3) * 1e6:.4f}")  # halved at A, then as A^2/w^2
    [1.  0.5] 0.2500
    """

    kind: str = "rigid"
    scale: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in LAWS:
            raise ValueError(f"the rotation law must be one of {', '.join(LAWS)}, not {self.kind!r}")
        if self.kind == "rigid" and self.scale is not None:
            raise ValueError("a rigid rotation law has no scale")
        if self.kind != "rigid" and not (self.scale is not None and math.isfinite(self.scale) and self.scale > 0):
            raise ValueError(f"rotation law {self.kind!r} needs a positive scale, not {self.scale}")

    def rate(self, w) -> np.ndarray:
        """Omega/Omega_0 at distance w from the axis."""
        w = np.asarray(w, dtype=float)
        if self.scale is None:
            return np.ones_like(w)
        falloff = 1 / (1 + (w / self.scale) ** 2)
        return falloff if self.kind == "j_constant" else np.sqrt(falloff)

    def potential(self, w) -> np.ndarray:
        """Integral from 0 to w of (Omega/Omega_0)^2 w dw, in the unit of length squared: minus the potential."""
        w = np.asarray(w, dtype=float)
        if self.scale is None:
            return 0.5 * w**2
        if self.kind == "j_constant":
            return 0.5 * w**2 / (1 + (w / self.scale) ** 2)
        return 0.5 * self.scale**2 * np.log1p((w / self.scale) ** 2)

    def scaled(self, length: float) -> "RotationLaw":
        """Return the law with its scale times `length`: from radii of a star to another unit."""
        return self if self.scale is None else RotationLaw(self.kind, self.scale * length)


RIGID = RotationLaw()
