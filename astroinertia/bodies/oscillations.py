"""Oscillations of polytropes: radial modes, and non-radial f, p and g modes with the full perturbation of gravity.

Both are Rayleigh-Ritz problems. With G = M = R = 1, L = l(l + 1), displacement (xi_r, xi_h) and D its divergence,

    radial, xi_r = x y:     omega^2 = int [Gamma1 P x^4 y'^2 + (3 Gamma1 - 4) rho g x^3 y^2] / int rho x^4 y^2,
    non-radial:             omega^2 = E / int rho x^2 (xi_r^2 + L xi_h^2),
        E = int x^2 [Gamma1 P D^2 + rho (rho - 4 g/x) xi_r^2 + 2 L rho g xi_r xi_h/x] - (energy of the field Phi'),

where rho stands for 4 pi rho, and Phi' is the solution of Poisson's equation in its own weak form. No coefficient is
singular, not even for n = 0. The unknowns are y and D, not xi_h: then fields without divergence are represented
exactly, and few false modes lie among the true ones; D has two polynomials fewer than y for the same reason. Every
eigenvalue is calculated at two resolutions, and one that they do not share is never returned.

Sources: Chandrasekhar 1964, ApJ 139, 664 (variational principle); Lynden-Bell & Ostriker 1967, MNRAS 136, 293;
Unno et al. 1989, Nonradial Oscillations of Stars. Tests: tests/unit/bodies/test_oscillations.py, tests/physics/
test_polytrope_modes.py, tests/hard/test_polytropes_hard.py.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, eigh, solve_triangular

from astroinertia.bodies.polytrope import lane_emden
from astroinertia.bodies.polytrope_elements import BUOYANT, Basis, Elements, polytrope_elements
from astroinertia.errors import NumericalError
from astroinertia.process.blas import one_thread
from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities

RESOLUTIONS = (20, 28, 40, 56, 80)  # polynomials an element: tried in turn until two neighbours agree
_LIMITS = (np.inf, 1e4, 1e2, 1.0, 1e-2, 1e-4, 1e-6)  # of omega^2: each Rayleigh-Ritz works among slower modes
_TOLERANCE = 1e-9  # relative difference of two resolutions up to which a mode counts as converged
_RESEMBLANCE = 1e-5  # the same, up to which it is known to be there: no label may skip a mode that has yet to converge
_FLOOR = 1e-12  # of |omega^2|, G M/R^3: below it lies the round-off of motions that cost no energy
_NEUTRAL = 1e-10  # of |Gamma1 n/(n + 1) - 1|: below it there are no g modes that stand out of the round-off
_SEEN = 1e-9  # share of the largest |xi_r| below which its sign is round-off


@dataclass(frozen=True, eq=False)
class Mode:
    """A mode of a polytrope with M = R = 1: displacement (radial Y, horizontal grad Y), Y a real spherical harmonic.

    label: "f", "p1", "g1" and so on; squared_frequency: omega^2 in G M/R^3, negative for an instability;
    difference: |change| of omega^2 between two resolutions; gamma_derivative: d omega^2/d Gamma1 at fixed n.
    At the nodes `radius` = r/R: radial (positive at the surface) and horizontal displacement, its divergence, and the
    Eulerian change of the potential in G M/R (None for radial modes). mass_weights integrates over mass: their sum is
    1, and so is that of mass_weights (radial^2 + l(l+1) horizontal^2). Where there is no mass the displacement carries
    round-off: 4e-6 of itself at the outermost node for n = 4, 2e-8 for n = 3.
    """

    label: str
    degree: int
    squared_frequency: float
    difference: float
    gamma_derivative: float
    radius: np.ndarray
    mass_weights: np.ndarray
    radial: np.ndarray
    horizontal: np.ndarray
    divergence: np.ndarray
    potential: np.ndarray | None


@dataclass(frozen=True)
class Spectrum:
    """Eigenvalues in ascending order, with the fields of each (node, mode)."""

    elements: Elements
    values: np.ndarray
    radial: np.ndarray
    horizontal: np.ndarray
    divergence: np.ndarray
    potential: np.ndarray | None


def _inner(weights: np.ndarray, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    return left.T @ (weights[:, None] * right)


def _displacement_basis(elements: Elements, slope_weight: float, power: int = 1) -> Basis:
    """Polynomials that x^power times gives a radial displacement."""
    mass = elements.mass_weights * elements.x ** (2 * power - 2)
    return elements.basis(elements.polynomials, elements.mass_power, mass, slope_weight * mass * elements.x**2)


@one_thread
def radial_spectrum(elements: Elements, gamma: float) -> Spectrum:
    """Return all radial modes of one discretisation, true and unconverged ones alike: what `radial_modes` chooses from.

    omega^2 in G M/R^3. Source: module text. Checked by tests/unit/bodies/test_oscillations.py.
    """
    x, weights = elements.x, elements.weights
    basis = _displacement_basis(elements, 1.0)
    stiff = weights * gamma * elements.pressure * x**4
    soft = (3 * gamma - 4) * weights * elements.density * elements.gravity * x**3
    stiffness = _inner(stiff, basis.slopes, basis.slopes) + _inner(soft, basis.values, basis.values)
    _, vectors = eigh(stiffness, _inner(elements.mass_weights, basis.values, basis.values))
    y, slope = basis.values @ vectors, basis.slopes @ vectors
    # the quotient is exact to second order in what round-off did to the vectors
    values = (stiff @ slope**2 + soft @ y**2) / (elements.mass_weights @ y**2)
    radial = x[:, None] * y
    return Spectrum(elements, values, radial, np.zeros_like(radial), x[:, None] * slope + 3 * y, None)


@one_thread
def nonradial_spectrum(elements: Elements, gamma: float, degree: int, gravity: bool = True) -> Spectrum:
    """Return all modes of one discretisation, converged or not: what `nonradial_modes` chooses from.

    Without `gravity` in Cowling's approximation. omega^2 in G M/R^3. Source: module text. Checked by
    tests/unit/bodies/test_oscillations.py.
    """
    p = elements.polynomials
    x, weights, mass = elements.x, elements.weights, elements.mass_weights
    column, ell = x[:, None], degree * (degree + 1)

    # xi_r goes as x^(l-1) and Phi' as x^l at the centre: x and x^2 times polynomials, or with l = 1 a power of x less
    power = min(degree, 2)
    lift = column ** (power - 2)
    shape = _displacement_basis(elements, 1 / ell, power - 1)
    spread = elements.basis(p - 2, elements.mass_power, mass / ell)
    y = np.hstack([lift * shape.values, np.zeros_like(spread.values)])
    divergence = np.hstack([np.zeros_like(shape.values), spread.values])
    z = np.hstack([lift * (column * shape.slopes + (power + 1) * shape.values), -spread.values]) / ell  # xi_h = x z

    # orthonormal by QR: the inertia matrix itself has the square of the condition number
    root = np.sqrt(mass)[:, None]
    triangle = np.linalg.qr(np.concatenate([root * y, np.sqrt(ell) * root * z]), mode="r")
    y, z, divergence = (solve_triangular(triangle, part.T, trans=1).T for part in (y, z, divergence))

    field = elements.basis(p, elements.power - 1, weights * x ** (2 * power), weights * x ** (2 * power + 2))
    potential, slope = lift * field.values, lift * (column * field.slopes + power * field.values)  # Phi', dPhi'/dx x^2
    poisson = _inner(weights * x**4, slope, slope) + ell * _inner(weights * x**4, potential, potential)
    poisson += (degree + 1) * np.outer(field.surface, field.surface)
    source = _inner(mass, slope, y) + ell * _inner(mass, potential, z)
    response = -cho_solve(cho_factor(poisson), source) if gravity else np.zeros_like(source)

    stiffness = _local_energy(elements, gamma, ell, (y, z, divergence), squares=False) + source.T @ response
    _, vectors = eigh(stiffness)
    y, z, divergence, potential, source = (part @ vectors for part in (y, z, divergence, potential @ response, source))
    values, turn = _refined(elements, gamma, ell, (y, z, divergence), source, response @ vectors)
    y, z, divergence, potential = (part @ turn for part in (y, z, divergence, potential))
    return Spectrum(elements, values, column * y, column * z, divergence, column**2 * potential)


def _local_energy(
    elements: Elements, gamma: float, ell: int, fields: Sequence[np.ndarray], squares: bool
) -> np.ndarray:
    """E without the field, between all pairs of displacements (x y, x z) of given divergence.

    squares: as the sum of compression and buoyancy, rho (p'/rho)^2/c^2 + rho N^2 xi_r^2, in which nothing cancels;
    it diverges as n -> 0.
    """
    y, z, divergence = fields
    n, x, mass, gravity = elements.index, elements.x, elements.mass_weights, elements.gravity
    sound_squared = gamma * elements.enthalpy / (n + 1)
    if squares:
        divergence = divergence - (x * gravity / sound_squared)[:, None] * y
        local = _inner(mass * (n - (n + 1) / gamma) * gravity**2 / elements.enthalpy, y, y)
    else:
        cross = ell * _inner(mass * gravity / x, y, z)
        local = cross + cross.T + _inner(mass * (elements.density - 4 * gravity / x), y, y)
    return local + _inner(mass * sound_squared / x**2, divergence, divergence)


def _refined(elements: Elements, gamma: float, ell: int, fields: tuple, source: np.ndarray, response: np.ndarray):
    """Eigenvalues and the turn of the vectors to them, freed of the round-off that fast modes leave in slow ones.

    A further Rayleigh-Ritz among ever slower modes, with the energy as a sum of squares over the nodes: then even the
    g modes of a star that is almost neutrally stratified keep their digits, since none of their energy is a difference.
    """
    mass = elements.mass_weights
    y, z, divergence = (field.copy() for field in fields)
    source, response = source.copy(), response.copy()
    turn = np.eye(y.shape[1])
    values = np.zeros(y.shape[1])
    for limit in _LIMITS:
        chosen = np.abs(values) < limit
        if not chosen.any():
            break
        parts = [part[:, chosen] for part in (y, z, divergence, source, response)]
        inertia = _inner(mass, parts[0], parts[0]) + ell * _inner(mass, parts[1], parts[1])
        energy = (
            _local_energy(elements, gamma, ell, parts[:3], squares=elements.index >= BUOYANT) + parts[3].T @ parts[4]
        )
        squares, vectors = eigh(0.5 * (energy + energy.T), inertia)
        for whole in (y, z, divergence, source, response, turn):
            whole[:, chosen] = whole[:, chosen] @ vectors
        values[chosen] = squares
    order = np.argsort(values)
    return values[order], turn[:, order]


def _shared(coarse: np.ndarray, fine: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Which of the fine eigenvalues the coarse ones share to the tolerance, and the differences of all."""
    nearest = np.abs(fine[:, None] - coarse).min(axis=1)
    return np.flatnonzero((nearest <= tolerance * np.abs(fine)) & (np.abs(fine) > _FLOOR)), nearest


def _winding(spectrum: Spectrum, mode: int, gamma: float) -> int:
    """Acoustic minus buoyant nodes of xi_r: each counts by the sense in which (xi_r, p') turns there.

    Source: Scuflaire 1974, A&A 36, 107, and Osaki 1975, PASJ 27, 237; exact in Cowling's approximation.
    """
    elements = spectrum.elements
    radial = spectrum.radial[:, mode]
    pressure = (
        elements.gravity * radial - gamma * elements.enthalpy / (elements.index + 1) * spectrum.divergence[:, mode]
    )
    seen = np.abs(radial) > _SEEN * np.abs(radial).max()
    sign, pressure = np.sign(radial[seen]), pressure[seen]
    change = np.diff(sign) / 2
    return int(-np.sum(change * np.sign(pressure[1:] + pressure[:-1])))


def _fundamental(gamma: float, degree: int, coarse: Elements, fine: Elements, buoyant: int) -> int | None:
    """The place of the f mode in the fine spectrum; None while it, or one of so many g modes below, has yet to appear.

    In Cowling's approximation the winding rises by one from each mode to the next, and that of the f mode is 0. It is
    counted at the slowest mode that is nowhere buoyant, and by rank from there: further down modes of high degree have
    nodes where they are too faint to be seen. Modes that are missing show by the number of wavelengths, which is within
    one of the winding (Unno et al. 1989, (16.1)). While the perturbation of gravity is turned on no two levels cross:
    the f mode keeps its place among all.
    """
    spectra = [nonradial_spectrum(elements, gamma, degree, gravity=False) for elements in (coarse, fine)]
    common, _ = _shared(spectra[0].values, spectra[1].values, _RESEMBLANCE)
    values, n = spectra[1].values[common], fine.index
    sound_squared = gamma * fine.enthalpy / (n + 1)
    lamb = degree * (degree + 1) * sound_squared / fine.x**2
    buoyancy = (n - (n + 1) / gamma) * fine.gravity**2 / fine.enthalpy

    def waves(value: float) -> tuple[float, float]:
        """Half wavelengths, acoustic and buoyant ones."""
        squared = np.maximum((lamb - value) * (buoyancy - value) / (sound_squared * value), 0.0)
        half = fine.weights * np.sqrt(squared) / np.pi
        return float(half[lamb < value].sum()), float(half[lamb > value].sum())

    fast = int(np.searchsorted(values, max(0.0, np.minimum(lamb, buoyancy).max())))
    fast = min(fast, len(common) - 1)
    place = fast - _winding(spectra[1], common[fast], gamma)
    if not (buoyant <= place <= fast and values[place - buoyant] > 0):
        return None
    (acoustic, slow), (_, slowest) = waves(values[place]), waves(values[place - buoyant])
    return int(common[place]) if acoustic - slow > -0.5 and slowest - slow < buoyant + 1 else None


def _mode(label: str, degree: int, spectrum: Spectrum, place: int, difference: float) -> Mode:
    elements = spectrum.elements
    ell = degree * (degree + 1)
    inner = elements.weights * elements.x**2
    weights = inner * elements.density
    radial, horizontal, divergence = (
        field[:, place] for field in (spectrum.radial, spectrum.horizontal, spectrum.divergence)
    )
    scale = np.sign(radial[-1]) / np.sqrt(weights @ (radial**2 + ell * horizontal**2))
    return Mode(
        label=label,
        degree=degree,
        squared_frequency=float(spectrum.values[place]),
        difference=float(difference),
        gamma_derivative=float(scale**2 * (inner * elements.pressure) @ divergence**2),
        radius=elements.x,
        mass_weights=weights,
        radial=scale * radial,
        horizontal=scale * horizontal,
        divergence=scale * divergence,
        potential=None if spectrum.potential is None else scale * spectrum.potential[:, place],
    )


def _checked(index: float, gamma: float) -> tuple[float, float]:
    lane_emden(float(index))  # says what is wrong with an index
    require_positive(gamma=gamma)
    return float(index), float(gamma)


@with_quantities()
def radial_modes(index: float, gamma: float, count: int = 3) -> tuple[Mode, ...]:
    """Return the first `count` radial modes of the polytrope of `index`, "F", "1O", "2O", ... from the slowest.

    gamma: Gamma1, constant. omega^2 in G M/R^3; at Gamma1 = 4/3 that of the fundamental is zero, and below it is
    negative. Measured: 3e-12 relative or better against exact values at n = 0, and for n = 0.3 to 3.5 against
    independent ones and shooting. ValueError for an index outside 0 <= n < 5; NumericalError for modes on which no two
    resolutions agree to 1e-9.
    Source: Chandrasekhar 1964. Checked by tests/unit/bodies/test_oscillations.py and
    tests/physics/test_polytrope_modes.py.

    >>> print(f"{radial_modes(1.0, 5 / 3)[0].squared_frequency:.4f}")  # omega^2 in G M/R^3, fundamental mode
    1.8916
    """
    n, gamma = _checked(index, gamma)
    if not (count >= 1 and count % 1 == 0):
        raise ValueError(f"the number of modes must be a whole one and at least 1, not {count!r}")
    count = int(count)
    coarse = None
    for polynomials in RESOLUTIONS:
        fine = radial_spectrum(polytrope_elements(n, polynomials), gamma)
        if coarse is not None and len(coarse.values) >= count:
            difference = np.abs(fine.values[:count] - coarse.values[:count])
            if np.all(difference <= _TOLERANCE * np.abs(fine.values[:count]) + _FLOOR):
                labels = ["F", *(f"{overtone}O" for overtone in range(1, count))]
                return tuple(_mode(labels[k], 0, fine, k, difference[k]) for k in range(count))
        coarse = fine
    raise NumericalError(f"{count} radial modes of the polytrope n = {n:g} do not converge to {_TOLERANCE:g}")


@with_quantities()
def nonradial_modes(
    index: float, gamma: float, degree: int = 2, pressure_modes: int = 4, gravity_modes: int = 4
) -> tuple[Mode, ...]:
    """Return the modes g_k ... g1, f, p1 ... p_j of one degree l >= 1 of the polytrope of `index`, by rising omega^2.

    gamma: Gamma1, constant. omega^2 in G M/R^3, with the full perturbation of gravity. Where Gamma1 > 1 + 1/n the
    star is stably stratified; where Gamma1 < 1 + 1/n all g modes are unstable, omega^2 < 0, g1 the fastest; where it
    equals 1 + 1/n there are none, and none are returned. Labels follow Cowling's approximation by continuity. With
    l = 1 there is no f mode: it would shift the whole star, which nothing resists.
    Measured: 2e-12 relative or better against Pekeris's exact values at n = 0, 5e-12 against shooting for n = 0.3 to
    3.5, all digits (1e-10) of independent ones for n = 1 to 3. ValueError for an index outside 0 <= n < 5, l < 1 or a
    negative number of modes; NumericalError for modes on which no two resolutions agree to 1e-9.
    Source: module text. Checked by tests/unit/bodies/test_oscillations.py, tests/physics/test_polytrope_modes.py.

    >>> print([mode.label for mode in nonradial_modes(2.0, 5 / 3, pressure_modes=1, gravity_modes=1)])
    ['g1', 'f', 'p1']
    """
    n, gamma = _checked(index, gamma)
    if not (degree >= 1 and degree % 1 == 0):
        raise ValueError(f"non-radial modes need a whole degree of 1 or more, not {degree!r}")
    if not all(number >= 0 and number % 1 == 0 for number in (pressure_modes, gravity_modes)):
        raise ValueError(f"numbers of modes are whole and not negative, not {pressure_modes!r} and {gravity_modes!r}")
    degree, pressure_modes, gravity_modes = int(degree), int(pressure_modes), int(gravity_modes)
    stratification = gamma * n / (n + 1) - 1
    buoyant = gravity_modes if abs(stratification) > _NEUTRAL else 0
    coarse = None
    for polynomials in RESOLUTIONS:
        fine = nonradial_spectrum(polytrope_elements(n, polynomials), gamma, degree)
        if coarse is not None:
            place = _fundamental(gamma, degree, coarse.elements, fine.elements, buoyant if stratification > 0 else 0)
            common, difference = _shared(coarse.values, fine.values, _RESEMBLANCE)
            if place is not None and (degree == 1 or place in common):
                above = common[common > place][:pressure_modes]
                sign = np.sign(stratification)
                # of l = 1 gravity takes the f mode down to 0, below the g modes of a stable star: one of them is here
                lower = common < place if degree > 1 or sign < 0 else common <= place
                below = common[lower & (sign * fine.values[common] > 0)]
                below = below[::-1][:buoyant] if sign > 0 else below[:buoyant]
                middle = [place] if degree > 1 else []
                wanted = [*middle, *above, *below]
                converged = np.all(difference[wanted] <= _TOLERANCE * np.abs(fine.values[wanted]))
                if converged and len(above) == pressure_modes and len(below) == buoyant:
                    labels = dict.fromkeys(middle, "f")
                    labels |= {mode: f"p{k}" for k, mode in enumerate(above, 1)}
                    labels |= {mode: f"g{k}" for k, mode in enumerate(below, 1)}
                    return tuple(_mode(labels[k], degree, fine, k, difference[k]) for k in sorted(labels))
        coarse = fine
    fundamental = "f, " if degree > 1 else ""
    raise NumericalError(
        f"{fundamental}{pressure_modes} p and {buoyant} g modes of degree {degree} of the polytrope n = {n:g} do not "
        f"converge to {_TOLERANCE:g}"
    )
