"""Rapidly and differentially rotating barotropes in equilibrium: the self-consistent field method.

A barotrope that turns with Omega(w) about its axis obeys the algebraic equation

    h + phi - Omega_0^2 psi(w) = C,     psi = int_0^w (Omega/Omega_0)^2 w dw,

with the enthalpy h = int dP/rho. C and Omega_0^2 follow from h = 0 on the equator (radius 1) and at the pole (for a
ring on its inner edge), the density from h, the potential phi from the density, and so on until nothing changes.
Source: Hachisu 1986, ApJS 61, 479, sect. II; mixing of earlier iterations: anderson.py.

Unlike on a fixed grid, the density on each sphere is integrated over angles up to the surface itself, found as the root
of h, so no cell is cut by the surface, and radial integrals are exact for interpolated densities (scf_mesh.py).
A law that follows from the star itself, by the angular momentum of its rings say, is one more unknown of the iteration
(Ostriker & Mark 1968, ApJ 151, 1075).
How accurate that is: tests/benchmarks/work_precision_scf.py.
Tests: tests/unit/bodies/test_scf.py, tests/hard/test_scf_hard.py.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from astroinertia.bodies.anderson import Anderson
from astroinertia.bodies.rotation_laws import RIGID, FollowingLaw, Law
from astroinertia.bodies.scf_mesh import Mesh, build_mesh, even_legendre
from astroinertia.errors import NumericalError
from astroinertia.matter.barotropes import ScaledLaw

_TOLERANCE = 1e-11  # largest change in one iteration of the angular moments, over the largest of them, and of a law
_MOST_ITERATIONS = 120  # bodies take 10 to 50; what takes longer has turned out to be none
_STALLED = 40  # iterations that did not halve the smallest change: bodies that converge have had up to 31 of them
_HISTORY = 5  # earlier iterations that Anderson's acceleration mixes in
_TORN = 1e-7  # of the largest enthalpy: below minus this inside, or above it outside, a surface is not closed
_TRUNCATION = 1e-3  # of the largest enthalpy, that the last harmonics may still add
_FLATTEST = 1e-6  # axis ratio: of a star that is hollow at its axis
_ROOT_STEPS = 12  # of the Illinois rule, from a bracket as wide as the angles stand apart


@dataclass(frozen=True)
class Resolution:
    """Elements of 8 radial nodes inside and outside the polar radius, angles on each sphere, highest Legendre degree.

    On the spheres that the surface cuts q_l goes through l/4 waves: elements below degree/8 cannot follow them.
    """

    elements: int = 8
    angles: int = 48
    degree: int = 48


@dataclass(frozen=True)
class Field:
    """A converged field in units of the equatorial radius, the largest density and G.

    moments (K, L): q_l at the nodes of the mesh; phi (K, L): Legendre components of the potential; exterior (L,): the
    integrals of q_l r^(l+2). cosine, weight and level (K, J) are the abscissae and weights of the quadrature over
    0 < mu < mu_surface on each sphere, and h/h_max there; peak is h_max.
    """

    matter: ScaledLaw
    law: Law
    axis_ratio: float
    mesh: Mesh
    moments: np.ndarray
    phi: np.ndarray
    exterior: np.ndarray
    constant: float
    rate_squared: float
    peak: float
    cosine: np.ndarray
    weight: np.ndarray
    level: np.ndarray

    @property
    def equatorial_gravity(self) -> float:
        """Gravity and centrifugal force at the equator, outwards: zero at mass shedding."""
        degrees = self.mesh.degrees
        pull = 4 * math.pi * float((degrees + 1) * self.exterior @ even_legendre(np.array(0.0), int(degrees[-1])))
        return self.rate_squared * float(self.law.rate(1.0)) ** 2 - pull

    @property
    def truncation(self) -> float:
        """The last two harmonics of the enthalpy over its maximum: about the error of mass and rate (measured).

        The virial theorem holds for the truncated problem as well and does not tell.
        """
        return float(np.abs(self.phi[:, -2:]).max() / self.peak)

    @property
    def resolved(self) -> bool:
        """Whether what is left to higher harmonics is small: masses and rates are right to 1e-3, mostly far better."""
        return self.truncation < _TRUNCATION


@dataclass(frozen=True)
class _Balance:
    # What one set of moments says of the body.
    phi: np.ndarray
    exterior: np.ndarray
    constant: float
    rate_squared: float
    peak: float


def solve_field(
    matter: ScaledLaw,
    axis_ratio: float,
    law: Law | FollowingLaw = RIGID,
    resolution: Resolution = Resolution(),
) -> Field:
    """Return the field of the body with polar/equatorial radius `axis_ratio` in (0, 1], or a ring for (-1, 0).

    A ring has -axis_ratio = inner/outer radius (Hachisu's sign). The scale of the law is in equatorial radii; one that
    follows from the star is found with it. NumericalError where the iteration does not converge; whether what converged
    is a body, check_field says. Test: tests/unit/bodies/test_scf.py, tests/unit/bodies/test_maclaurin_momentum.py.

    >>> from astroinertia.bodies.maclaurin import from_axis_ratio
    >>> from astroinertia.matter.barotropes import polytropic_matter
    >>> field = solve_field(polytropic_matter(0.0), 0.8)  # a liquid: Maclaurin's spheroid
    >>> print(f"{field.rate_squared / np.pi:.6f} {from_axis_ratio(0.8).omega2:.6f}")  # Omega^2/(pi G rho)
    0.201353 0.201352
    """
    if not -1 < axis_ratio <= 1 or axis_ratio == 0:
        raise ValueError(f"the axis ratio must lie in (0, 1], or in (-1, 0) for a ring, not {axis_ratio}")
    if 0 < axis_ratio < _FLATTEST:
        raise NumericalError(f"no star as flat as an axis ratio of {axis_ratio:g} can be solved for")
    solver = _Solver(matter, float(axis_ratio), resolution)
    rotation: Any = law
    follows = hasattr(rotation, "followed")
    guessed = solver.guessed()
    outer = even_legendre(guessed[0][solver.mesh.split :], resolution.degree)
    moments, mixed = solver.moments(*guessed[1:], outer), Anderson(_HISTORY)
    unit = np.abs(moments[:, 0]).max()
    least, progress = math.inf, 0
    for iteration in range(1, _MOST_ITERATIONS + 1):
        if follows or iteration == 1:
            solver.turn_as(rotation)
        balance = solver.balance(moments)
        quadrature, table = solver.levels(balance)
        updated = solver.moments(*quadrature[1:], table)
        field = Field(matter, rotation, float(axis_ratio), solver.mesh, moments, balance.phi, balance.exterior,
                      balance.constant, balance.rate_squared, balance.peak, *quadrature)  # fmt: skip
        before, after = moments.ravel() / unit, updated.ravel() / unit
        if follows and np.isfinite(after).all():
            before, after = np.append(before, rotation.rates), np.append(after, rotation.followed(field))
        change = float(np.abs(after - before).max())
        if 2 * change < least:
            least, progress = change, iteration
        if not math.isfinite(change) or iteration - progress > _STALLED:
            break
        if change < _TOLERANCE:
            return field
        state = mixed.next(before, after)
        moments = state[: moments.size].reshape(moments.shape) * unit
        if follows:
            rotation = rotation.with_rates(state[moments.size :])
    raise NumericalError(
        f"the self-consistent field of a {_description(matter, axis_ratio, law)} did not converge: "
        "there may be no such body"
    )


def _description(matter: ScaledLaw, axis_ratio: float, law: Law) -> str:
    return f"{matter.name} with axis ratio {axis_ratio:g} and {law.kind} rotation"


class _Solver:
    """One body being sought: its mesh, the angles, and the steps of an iteration."""

    law: Law
    inside_psi: np.ndarray
    bracket_psi: np.ndarray

    def __init__(self, matter: ScaledLaw, axis_ratio: float, resolution: Resolution) -> None:
        self.matter, self.degree = matter, resolution.degree
        self.ring = axis_ratio < 0
        self.edge = abs(axis_ratio)
        # A ring's mesh has its inner edge where a star's has the pole, and nothing inside.
        self.mesh = build_mesh(self.edge, resolution.elements, resolution.degree, hollow=self.ring)
        nodes, weights = np.polynomial.legendre.leggauss(resolution.angles)
        self.share, self.share_weight = (nodes + 1) / 2, weights / 2
        self.table = even_legendre(self.share, resolution.degree)
        self.equator = even_legendre(np.array(0.0), resolution.degree)
        self.outer = self.mesh.radius[self.mesh.split :]
        bracket = np.concatenate([[0.0], self.share, [1.0]])
        self.bracket, self.bracket_table = bracket, even_legendre(bracket, resolution.degree)

    def turn_as(self, law: Law) -> None:
        """Take this rotation law from now on."""
        self.law = law
        inside = self.mesh.radius[: self.mesh.split, None]
        self.inside_psi = law.potential(inside * np.sqrt(1 - self.share**2))
        self.bracket_psi = law.potential(self.outer[:, None] * np.sqrt(1 - self.bracket**2))

    def guessed(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Quadrature and levels of an ellipsoid, or of a ring of elliptic section, whose level falls off as 1 - s^2."""
        split, r, share = self.mesh.split, self.mesh.radius, self.share
        if self.ring:
            middle, half = (1 + self.edge) / 2, (1 - self.edge) / 2
            # w^2 + z^2 = r^2 and (w - middle)^2 + z^2 = half^2 meet at this w
            w = (r**2 + middle**2 - half**2) / (2 * middle)
            surface = np.sqrt(np.clip(1 - (w / r) ** 2, 0.0, 1.0))
            cosine, weight = self._within(surface)
            w, z = r[:, None] * np.sqrt(1 - cosine**2), r[:, None] * cosine
            return cosine, weight, np.clip(1 - ((w - middle) ** 2 + z**2) / half**2, 0.0, 1.0)
        flatness = 1 / self.edge**2 - 1
        surface = np.sqrt(np.clip((1 / self.outer**2 - 1) / max(flatness, 1e-300), 0.0, 1.0))
        cosine, weight = self._within(surface)
        cosine = np.concatenate([np.broadcast_to(share, (split, len(share))), cosine])
        weight = np.concatenate([np.broadcast_to(self.share_weight, (split, len(share))), weight])
        return cosine, weight, np.clip(1 - r[:, None] ** 2 * (1 + flatness * cosine**2), 0.0, 1.0)

    def balance(self, moments: np.ndarray) -> _Balance:
        """Potential, constants and largest enthalpy that follow from the moments."""
        phi, edges, exterior = self.mesh.potential(moments)
        at_equator = float(edges[-1] @ self.equator)
        inner = edges[0 if self.ring else (self.mesh.split // 8)]
        psi_equator = float(self.law.potential(1.0))
        if self.ring:
            at_inner, psi_inner = float(inner @ self.equator), float(self.law.potential(self.edge))
        else:
            at_inner, psi_inner = float(inner.sum()), 0.0
        rate_squared = 0.0 if self.edge == 1 else (at_equator - at_inner) / (psi_equator - psi_inner)
        constant = at_equator - rate_squared * psi_equator
        profile = constant - phi @ self.equator + rate_squared * self.law.potential(self.mesh.radius)
        radius, height = self.mesh.radius, profile
        if not self.ring:
            radius, height = np.append(0.0, radius), np.append(constant - edges[0, 0], profile)
        return _Balance(phi, exterior, constant, rate_squared, _highest(radius, height))

    def levels(self, balance: _Balance) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
        """Quadrature (K, J) over the part of each sphere that the body fills, h/h_max there; P_l on the outer ones."""
        split, phi = self.mesh.split, balance.phi
        inside = balance.constant - phi[:split] @ self.table + balance.rate_squared * self.inside_psi
        surface = self._surface(balance)
        cosine, weight = self._within(surface)
        table = even_legendre(cosine, self.degree)
        psi = self.law.potential(self.outer[:, None] * np.sqrt(1 - cosine**2))
        outside = balance.constant - np.einsum("kl,lkj->kj", phi[split:], table) + balance.rate_squared * psi
        shape = inside.shape
        return (
            np.concatenate([np.broadcast_to(self.share, shape), cosine]),
            np.concatenate([np.broadcast_to(self.share_weight, shape), weight]),
            np.concatenate([inside, outside]) / balance.peak,
        ), table

    def moments(self, weight: np.ndarray, level: np.ndarray, table: np.ndarray) -> np.ndarray:
        """q_l on each sphere, (K, L); table: P_l at the cosines of those outside the polar radius."""
        split = self.mesh.split
        mass = weight * self.matter.density(level)
        outer = np.einsum("kj,lkj->kl", mass[split:], table)
        return np.concatenate([mass[:split] @ self.table.T, outer])

    def _within(self, surface: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        # Abscissae that crowd quadratically at the surface, where the density vanishes as depth^n.
        left = 1 - self.share
        return surface[:, None] * (1 - left**2), surface[:, None] * (2 * left * self.share_weight)

    def _surface(self, balance: _Balance) -> np.ndarray:
        """The cosine at which each outer sphere leaves the body, seen from the equator; 0 where it never is inside."""
        phi = balance.phi[self.mesh.split :]
        values = balance.constant - phi @ self.bracket_table + balance.rate_squared * self.bracket_psi
        outside = values <= 0
        first = np.where(outside.any(axis=1), outside.argmax(axis=1), len(self.bracket) - 1)
        rows = np.arange(len(first))
        before = np.maximum(first - 1, 0)
        low, high = self.bracket[before], self.bracket[first]
        f_low, f_high = values[rows, before], values[rows, first]
        never, whole = first == 0, ~outside.any(axis=1)
        side = np.zeros(len(low))
        for _ in range(_ROOT_STEPS):  # the Illinois rule
            middle = np.clip((low * f_high - high * f_low) / np.where(f_high == f_low, -1.0, f_high - f_low), low, high)
            psi = self.law.potential(self.outer * np.sqrt(1 - middle**2))
            table = even_legendre(middle, self.degree)
            f = balance.constant - np.einsum("kl,lk->k", phi, table) + balance.rate_squared * psi
            right = f <= 0
            f_low = np.where(right & (side > 0), 0.5 * f_low, f_low)
            f_high = np.where(~right & (side < 0), 0.5 * f_high, f_high)
            high, f_high = np.where(right, middle, high), np.where(right, f, f_high)
            low, f_low = np.where(right, low, middle), np.where(right, f_low, f)
            side = np.where(right, 1.0, -1.0)
        root = np.where(np.abs(f_low) < np.abs(f_high), low, high)
        return np.where(never, 0.0, np.where(whole, 1.0, root))


def _highest(radius: np.ndarray, height: np.ndarray) -> float:
    """The maximum along the equator: at the centre, or of the quartic through the five nodes about the highest."""
    top = int(np.argmax(height))
    if top == 0 and radius[0] == 0:
        return float(height[0])
    first = int(np.clip(top - 2, 0, len(radius) - 5))
    x = radius[first : first + 5]
    curve = np.polynomial.Polynomial.fit(x, height[first : first + 5], 4)
    stationary = curve.deriv().roots()
    real = stationary[np.abs(stationary.imag) < 1e-9].real
    inside = real[(real >= x[0]) & (real <= x[-1])]
    return float(max([height[top], *curve(inside)]))


def check_field(field: Field) -> None:
    """Raise NumericalError where a field is no body (past mass shedding, torn), or not resolved by its harmonics.

    Test: tests/hard/test_scf_hard.py.

    >>> from astroinertia.matter.barotropes import polytropic_matter
    >>> check_field(solve_field(polytropic_matter(1.5), 0.9))  # a body
    >>> check_field(solve_field(polytropic_matter(1.5), 0.5))
    Traceback (most recent call last):
        ...
    astroinertia.errors.NumericalError: no polytrope of index 1.5 with axis ratio 0.5 ... (mass shedding)
    """
    description = _description(field.matter, field.axis_ratio, field.law)
    if field.equatorial_gravity >= 0:
        raise NumericalError(
            f"no {description} exists: its equator would turn faster than an orbit there (mass shedding)"
        )
    if field.rate_squared < 0 or field.level.min() < -_TORN or _surface_beyond(field):
        raise NumericalError(f"no {description} exists: the surface would not close between its pole and its equator")
    if not field.resolved:
        raise NumericalError(
            f"a {description} needs harmonics beyond degree {field.mesh.degrees[-1]}: raise the resolution"
        )


def _surface_beyond(field: Field) -> bool:
    """Whether there is matter again on a sphere beyond the cosine where it was left, seen from the equator."""
    split = field.mesh.split
    surface = field.weight[split:].sum(axis=1)
    mu = surface[:, None] + (1 - surface[:, None]) * np.linspace(0.05, 1, 20)
    table = even_legendre(mu, int(field.mesh.degrees[-1]))
    psi = field.law.potential(field.mesh.radius[split:, None] * np.sqrt(1 - mu**2))
    level = field.constant - np.einsum("kl,lkj->kj", field.phi[split:], table) + field.rate_squared * psi
    return bool((level > _TORN * field.peak).any())
