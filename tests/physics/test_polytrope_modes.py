"""Modes of polytropes against shooting: another formulation, another discretisation, the same omega^2.

The pointwise equations of motion are integrated from the centre and from the surface, together with Lane-Emden's; at an
eigenvalue the solutions join. With G = M = R = 1, rho for 4 pi rho, D the divergence and alpha = Gamma1 n/(n + 1) - 1:

    chi' = omega^2 xi_r - alpha g D,    xi_r' = D - 2 xi_r/x + l(l + 1) chi/(omega x)^2,    c^2 D = g xi_r + Phi' - chi,
    Phi'' = F - rho xi_r,               F' = -2 F/x + l(l + 1) (Phi' + rho chi/omega^2)/x^2.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from astroinertia.bodies.oscillations import nonradial_modes, radial_modes
from astroinertia.bodies.polytrope import lane_emden

INNER, OUTER = 2e-3, {True: 1e-10, False: 1e-6}  # x, and theta of soft and condensed bodies, where they begin
JOIN = 0.6  # x at which they meet


class Shooting:
    """The mismatch of the solutions from both ends as a function of omega^2."""

    def __init__(self, index, gamma, degree):
        self.n, self.gamma, self.ell, self.degree = index, gamma, degree * (degree + 1), degree
        solution = lane_emden(index)
        self.xi_1, self.total = solution.xi_1, solution.surface_mass
        self.density = self.xi_1**3 / self.total

    def structure(self, x, theta, mass):
        theta = max(theta, 0.0)
        sound_squared = self.gamma * theta * self.xi_1 / self.total / (self.n + 1)
        return self.density * theta**self.n, mass / x**2, sound_squared

    def slopes(self, x, state, omega2):
        theta, mass = state[0], state[1]
        rho, g, c2 = self.structure(x, theta, mass)
        rates = [-g * self.total / self.xi_1, rho * x**2]
        return np.concatenate([rates, self.motion(x, state[2:].reshape(-1, self.size), rho, g, c2, omega2).ravel()])

    def mismatch(self, omega2):
        ends = []
        for x, structure, vectors in (self.centre(omega2), self.surface(omega2)):
            begin = np.concatenate([structure, np.ravel(vectors)])
            run = solve_ivp(self.slopes, (x, JOIN), begin, args=(omega2,), method="DOP853", rtol=1e-13, atol=1e-18)
            assert run.success
            ends.append(run.y[:, -1])
        assert ends[0][:2] == pytest.approx(ends[1][:2], rel=1e-9)
        vectors = np.concatenate([end[2:].reshape(-1, self.size) for end in ends])
        return np.linalg.det(vectors / np.linalg.norm(vectors, axis=1)[:, None])

    def correction(self, omega2):
        """The step of a secant towards the true eigenvalue."""
        step = 1e-5 * abs(omega2)
        above, below = self.mismatch(omega2 + step), self.mismatch(omega2 - step)
        return -self.mismatch(omega2) * 2 * step / (above - below)

    def central_structure(self):
        inner = INNER / 10 if self.degree == 1 else INNER  # where g modes with l = 1 are largest
        xi = inner * self.xi_1
        theta = 1 - xi**2 / 6 + self.n * xi**4 / 120
        mass = xi**3 / 3 - self.n * xi**5 / 30
        return inner, [theta, mass / self.total]

    def outer_structure(self):
        theta = OUTER[self.n < 1]
        x = 1 / (1 + theta * self.xi_1 / self.total)
        above = self.density * theta**self.n * (1 - x) / (self.n + 1)
        return x, [theta, 1 - above]


class Radial(Shooting):
    """y = xi_r/x and the flux Gamma1 P x^4 y'."""

    size = 2

    def motion(self, x, vectors, rho, g, c2, omega2):
        y, flux = vectors.T
        soft = (3 * self.gamma - 4) * g / x - omega2
        return np.array([flux / (rho * c2 * x**4), soft * rho * x**4 * y]).T

    def centre(self, omega2):
        x, structure = self.central_structure()
        soft = (3 * self.gamma - 4) * self.density / 3 - omega2
        return x, structure, [1.0, soft * self.density * x**5 / 5]

    def surface(self, omega2):
        x, structure = self.outer_structure()
        soft = 3 * self.gamma - 4 - omega2
        return x, structure, [1.0, -soft * (1 - structure[1])]


class Nonradial(Shooting):
    """xi_r, chi, Phi' and F = Phi'' + rho xi_r."""

    size = 4

    def motion(self, x, vectors, rho, g, c2, omega2):
        radial, chi, field, flux = vectors.T
        divergence = (g * radial + field - chi) / c2
        stratification = self.gamma * self.n / (self.n + 1) - 1
        return np.array([
            divergence - 2 * radial / x + self.ell * chi / (omega2 * x**2),
            omega2 * radial - stratification * g * divergence,
            flux - rho * radial,
            -2 * flux / x + self.ell * (field + rho * chi / omega2) / x**2,
        ]).T  # fmt: skip

    def centre(self, omega2):
        x, structure = self.central_structure()
        power = self.degree
        first = [1.0, omega2 * x / power, 0.0, self.density]
        second = [0.0, 0.0, x, power]
        return x, structure, [first, second]

    def surface(self, omega2):
        x, structure = self.outer_structure()
        _, g, c2 = self.structure(x, *structure)
        vectors = []
        for radial, field in ((1.0, 0.0), (0.0, 1.0)):
            chi, flux = g * radial + field, -(self.degree + 1) * field / x
            pull = omega2 * radial + 4 * g * radial / x - g * self.ell * chi / (omega2 * x**2) - flux
            vectors.append([radial, chi - c2 * pull / (self.gamma * g), field, flux])
        return x, structure, vectors


@pytest.mark.full
@pytest.mark.parametrize(("index", "gamma"), [(0.3, 1.6), (1.5, 5 / 3), (2.7, 1.45), (3.5, 5 / 3)])
def test_radial_modes_by_shooting(index, gamma):
    shooting = Radial(index, gamma, 0)
    for mode in radial_modes(index, gamma):
        correction = shooting.correction(mode.squared_frequency)
        assert abs(correction / mode.squared_frequency) < 1e-10


@pytest.mark.parametrize(
    ("index", "gamma", "degree"),
    [
        pytest.param(0.3, 4.5, 2, marks=pytest.mark.full),
        pytest.param(0.7, 5 / 3, 3, marks=pytest.mark.full),
        (1.5, 5 / 3, 4),
        pytest.param(2.7, 5 / 3, 2, marks=pytest.mark.full),
        pytest.param(2.7, 1.3, 3, marks=pytest.mark.full),
        pytest.param(3.5, 1.4, 2, marks=pytest.mark.full),
        (2.0, 5 / 3, 1),
        pytest.param(0.7, 5 / 3, 1, marks=pytest.mark.full),
        pytest.param(3.5, 5 / 3, 1, marks=pytest.mark.full),
    ],
    ids=[
        "stable-soft",
        "unstable",
        "neutral",
        "stable",
        "unstable-condensed",
        "condensed",
        "dipole",
        "dipole-unstable",
        "dipole-condensed",
    ],
)
def test_nonradial_modes_by_shooting(index, gamma, degree):
    shooting = Nonradial(index, gamma, degree)
    for mode in nonradial_modes(index, gamma, degree, 2, 2):
        correction = shooting.correction(mode.squared_frequency)
        assert abs(correction / mode.squared_frequency) < 1e-10


@pytest.mark.parametrize("gamma", [1.2, 2.5, 4.0])
@pytest.mark.parametrize("degree", [2, 3, 8])
def test_homogeneous_spheres(gamma, degree):
    """Pekeris 1938, for many gamma and degrees."""
    modes = {mode.label: mode.squared_frequency for mode in nonradial_modes(0, gamma, degree, 4, 3)}
    assert modes["f"] == pytest.approx(2 * degree * (degree - 1) / (2 * degree + 1), rel=1e-12)
    for order in range(4):
        half = -2 + gamma / 2 * (order * (2 * degree + 2 * order + 5) + 2 * degree + 3)
        root = math.hypot(half, math.sqrt(degree * (degree + 1)))
        assert modes[f"p{order + 1}"] == pytest.approx(half + root, rel=5e-12)
        if order < 3:
            assert modes[f"g{order + 1}"] == pytest.approx(half - root, rel=1e-11)


@pytest.mark.full
@pytest.mark.parametrize(("index", "degree"), [(1.0, 2), (2.5, 4), (3.0, 2), (3.5, 3)])
def test_labels_count_the_nodes(index, degree):
    """p_k and g_k have k nodes in the radial displacement, and each kind turns (xi_r, p') its own way."""
    gamma = max(5 / 3, 1.1 * (1 + 1 / index))
    n, solution = index, lane_emden(index)
    for mode in nonradial_modes(index, gamma, degree, 5, 5):
        xi = mode.radius * solution.xi_1
        gravity = solution.mass_at(xi) / solution.surface_mass / mode.radius**2
        enthalpy = solution.theta_at(xi) * solution.xi_1 / solution.surface_mass
        pressure = gravity * mode.radial - gamma * enthalpy / (n + 1) * mode.divergence
        change = np.diff(np.sign(mode.radial)) / 2
        turns = -np.sum(change * np.sign(pressure[:-1]))
        wanted = 0 if mode.label == "f" else (1 if mode.label[0] == "p" else -1) * int(mode.label[1:])
        assert turns == wanted
