"""An axisymmetric fluid in Newton's gravity on spherical shells that move with the matter: for axisymmetric_core.py.

Newton's equations of an axisymmetric fluid with a plane of symmetry, on spherical shells cut into angles. The edges of
shells move with the mean of the matter at them, so that a spherical collapse is Lagrangian: what goes from shell to
shell, or from angle to angle, is the rest. It shares nothing with particles.

- Staggered: masses, thermal entropy A (P = P_cold(rho) + A rho^gamma_thermal) and specific angular momentum in cells,
  radial velocity u on the edges of shells, s = r v_theta on the faces between angles. Leapfrog; transport is
  conservative, upwind with van Leer's slopes, radial and angular in turn, velocities with the mean of the
  masses beside; what motion and matter lose in shocks by mixing is heat.
- Viscosity of von Neumann & Richtmyer: along the radius as a tensor without trace-free part in homologous flow
  (Tscharnuter & Winkler 1979, Comput. Phys. Commun. 18, 171), so that infall is not heated; along the angle quadratic.
- Gravity: the mass within, and the even Legendre terms to degree 8.
- The innermost shells (one in forty) are kept spherical and turn as one, for the sake of the step.
"""

from typing import NamedTuple

import numba
import numpy as np
from numpy.polynomial import legendre

G = 6.6743e-11
QUADRATIC, LINEAR, COURANT, COMPRESSION = 2.0, 0.3, 0.3, 0.02
DEGREES = (2, 4, 6, 8)
COLUMNS = ("time", "density", "moment_z", "energy", "momentum", "kinetic", "gravitational")


class Matter(NamedTuple):
    """P = K rho^gamma_1 to `nuclear`, from there with gamma_2, and A rho^gamma_thermal."""

    constant: float
    gamma_1: float
    nuclear: float
    gamma_2: float
    gamma_thermal: float


class Angles(NamedTuple):
    """Cells in angle: solid angles and mean sin^2 (M,); sin, sin cos at faces (M + 1,); Legendre terms (D, M).

    slopes (D, M + 1): of those terms, along theta at faces. core: how many shells are not cut.
    """

    core: int
    solid: np.ndarray
    squared: np.ndarray
    sine: np.ndarray
    product: np.ndarray
    means: np.ndarray
    slopes: np.ndarray


def angles(count: int, shells: int) -> Angles:
    """Equal angles from the pole to the equator, which stand for both hemispheres."""
    theta = np.linspace(0.0, np.pi / 2, count + 1)
    mu = np.cos(theta)
    mu[-1] = 0.0
    width = mu[:-1] - mu[1:]
    squared = 1.0 - (mu[:-1] ** 2 + mu[:-1] * mu[1:] + mu[1:] ** 2) / 3.0
    means, slopes = [], []
    for degree in DEGREES:
        term = legendre.Legendre.basis(degree)
        whole = term.integ()
        means.append((whole(mu[:-1]) - whole(mu[1:])) / width)
        slopes.append(-np.sin(theta) * term.deriv()(mu))
    return Angles(
        max(3, shells // 40),
        4 * np.pi * width,
        squared,
        np.sin(theta),
        np.sin(theta) * mu,
        np.array(means),
        np.array(slopes),
    )


@numba.njit(cache=True, error_model="numpy", inline="always")
def _state(density, entropy, matter):
    """Pressure and squared sound speed."""
    if density < matter.nuclear:
        cold, gamma = matter.constant * density**matter.gamma_1, matter.gamma_1
    else:
        stiff = matter.constant * matter.nuclear ** (matter.gamma_1 - matter.gamma_2)
        cold, gamma = stiff * density**matter.gamma_2, matter.gamma_2
    hot = entropy * density**matter.gamma_thermal
    return cold + hot, (gamma * cold + matter.gamma_thermal * hot) / density


@numba.njit(cache=True, error_model="numpy", inline="always")
def _energy(density, entropy, matter):
    """Specific internal energy."""
    one, two = matter.gamma_1 - 1, matter.gamma_2 - 1
    hot = entropy * density ** (matter.gamma_thermal - 1) / (matter.gamma_thermal - 1)
    if density < matter.nuclear:
        return matter.constant * density**one / one + hot
    start = matter.constant * matter.nuclear**one
    return start * (density / matter.nuclear) ** two / two + start / one - start / two + hot


@numba.njit(cache=True, error_model="numpy", inline="always")
def _upwind(before, behind, ahead, share):
    """The value that leaves the cell `behind`, of which `share` goes; `before` is upwind of it."""
    low, high = behind - before, ahead - behind
    slope = 2 * low * high / (low + high) if low * high > 0 else 0.0
    return behind + 0.5 * (1 - share) * slope


@numba.njit(cache=True, error_model="numpy", inline="always")
def _heat(a, m, density, i, j, energy, matter):
    """What matter about the edge i lost of its kinetic energy as it mixed goes to the cells on both sides."""
    power = matter.gamma_thermal - 1
    both = m[i - 1, j] + (m[i, j] if i < len(m) else 0.0)
    for k in range(i - 1, min(i + 1, len(m))):
        a[k, j] += energy / both * power / density[k, j] ** power


@numba.njit(cache=True, error_model="numpy", inline="always")
def _kept(a, i, j, energy, density, matter):
    """No less specific energy than what came together had."""
    power = matter.gamma_thermal - 1
    a[i, j] += max(energy - _energy(density, a[i, j], matter), 0.0) * power / density**power


@numba.njit(cache=True, error_model="numpy")
def _gravity(r, density, cells, harmonic, radial, inner, outer):
    """For each degree above 0, at edges: I/r^(l+1) and E r^l of the potential, and their slopes along r, in 4 pi G."""
    shells, count = density.shape
    for d in range(len(cells.means)):
        degree = 2 * (d + 1)
        total = 0.0
        harmonic[:] = 0.0
        for i in range(cells.core, shells):
            for j in range(count):
                harmonic[i] += density[i, j] * cells.means[d, j] * cells.solid[j]
            harmonic[i] /= 4 * np.pi  # rho_l / (2 l + 1)
        inner[d, 0] = 0.0
        for i in range(shells):
            total += harmonic[i] * (r[i + 1] ** (degree + 3) - r[i] ** (degree + 3)) / (degree + 3)
            inner[d, i + 1] = total / r[i + 1] ** (degree + 1)
        total = 0.0
        outer[d, shells] = 0.0
        for i in range(shells - 1, 0, -1):
            if degree == 2:
                total += harmonic[i] * np.log(r[i + 1] / r[i])
            else:
                total += harmonic[i] * (r[i + 1] ** (2 - degree) - r[i] ** (2 - degree)) / (2 - degree)
            outer[d, i] = total * r[i] ** degree
        outer[d, 0] = 0.0
        radial[d, 0] = 0.0
        for i in range(1, shells + 1):
            radial[d, i] = (degree * outer[d, i] - (degree + 1) * inner[d, i]) / r[i]


@numba.njit(cache=True, error_model="numpy")
def evolve(r, m, a, h, matter, cells, end, every, damping, t_over_w, until_bounce):
    """Follow the body in place; rows of COLUMNS, the greatest density, when it was and the moment then, and steps.

    damping: rate at which velocities fall; t_over_w: of a body that settles.

    until_bounce: end so long after the greatest density.
    """
    shells, count = m.shape
    solid, squared, sine, product = cells.solid, cells.squared, cells.sine, cells.product
    theta = 0.5 * np.pi / count
    u, s = np.zeros((shells + 1, count)), np.zeros((shells, count + 1))
    density, pressure, sound = np.zeros((shells, count)), np.zeros((shells, count)), np.zeros((shells, count))
    viscous, turned, rate = np.zeros((shells, count)), np.zeros((shells, count)), np.zeros((shells, count))
    flux, old = np.zeros((shells + 1, count)), np.zeros((shells, count))
    around, carried = np.zeros((shells + 1, count)), np.zeros((shells + 1, count))
    side = np.zeros((shells, count + 1))
    halves, path = np.zeros((shells + 1, count)), np.zeros(max(shells, count) + 2)
    w, within, square = np.zeros(shells + 1), np.zeros(shells + 1), np.zeros(shells)
    faces, kept, swept = np.zeros((shells + 1, count)), np.zeros((shells, count)), np.zeros(count + 1)
    degrees, harmonic = len(cells.means), np.zeros(shells)
    radial, inner, outer = (
        np.zeros((degrees, shells + 1)),
        np.zeros((degrees, shells + 1)),
        np.zeros((degrees, shells + 1)),
    )
    rows = int(end / every) + 3
    table = np.zeros((rows, 7))
    time, before, step, row, steps = 0.0, 0.0, 1e-6, 0, 0
    best, best_time, best_moment = 0.0, 0.0, 0.0
    while True:
        # What the cells hold.
        for i in range(shells):
            volume = (r[i + 1] ** 3 - r[i] ** 3) / 3
            square[i] = 0.2 * (r[i + 1] ** 5 - r[i] ** 5) / volume
            total = 0.0
            for j in range(count):
                density[i, j] = m[i, j] / (volume * solid[j])
                p, c = _state(density[i, j], a[i, j], matter)
                pressure[i, j], sound[i, j] = p, np.sqrt(c)
                rate[i, j] = h[i, j] / (square[i] * squared[j])
                total += m[i, j]
            within[i + 1] = within[i] + total
        _gravity(r, density, cells, harmonic, radial, inner, outer)
        if t_over_w > 0:  # settles: it turns as one body, so fast
            kinetic, potential = 0.0, 0.0
            for i in range(shells):
                for j in range(count):
                    kinetic += 0.5 * m[i, j] * square[i] * squared[j]
            potential = _binding(r, density, m, within, cells, inner, outer)
            spin = np.sqrt(t_over_w * abs(potential) / kinetic)
            for i in range(shells):
                for j in range(count):
                    rate[i, j] = spin
                    h[i, j] = spin * square[i] * squared[j]
        most, moment = 0.0, 0.0
        for i in range(shells):
            for j in range(count):
                most = max(most, density[i, j])
                moment += m[i, j] * square[i] * squared[j]
        if most > best:
            best, best_time, best_moment = most, time, moment
        finished = time >= end or (until_bounce > 0 and best > matter.nuclear and time > best_time + until_bounce)
        if time >= row * every or finished:
            table[row] = _record(time, r, u, s, m, a, h, rate, density, square, within, matter, cells, inner, outer)
            row += 1
        if finished:
            break
        # Viscosity and the step.
        longest = 0.02 * end
        for i in range(1, shells + 1):
            total, moving = 0.0, 0.0
            for j in range(count):
                around[i, j] = 0.5 * (m[i - 1, j] + (m[i, j] if i < shells else 0.0))
                total += around[i, j]
                moving += around[i, j] * u[i, j]
            w[i] = moving / total
        for i in range(shells):
            width, middle = r[i + 1] - r[i], 0.5 * (r[i] + r[i + 1])
            for j in range(count):
                jump = u[i + 1, j] - u[i, j]
                flow = r[i + 1] ** 2 * u[i + 1, j] - r[i] ** 2 * u[i, j]
                sheared = i > 0 and jump < 0 and flow < 0 and u[i + 1, j] * r[i] < u[i, j] * r[i + 1]
                viscous[i, j] = density[i, j] * jump * (QUADRATIC * jump - LINEAR * sound[i, j]) if sheared else 0.0
                across = max(abs(u[i, j] - w[i]), abs(u[i + 1, j] - w[i + 1]))
                longest = min(longest, COURANT * width / (sound[i, j] + across + 4 * QUADRATIC * abs(jump)))
                turned[i, j] = 0.0
                if i >= cells.core:
                    squeeze = (s[i, j + 1] - s[i, j]) / middle
                    if squeeze < 0:
                        turned[i, j] = QUADRATIC * density[i, j] * squeeze**2
                    fast = max(abs(s[i, j]), abs(s[i, j + 1])) / middle
                    longest = min(
                        longest, COURANT * middle * theta / (sound[i, j] + fast + 4 * QUADRATIC * abs(squeeze))
                    )
            squeezed = r[i + 1] ** 2 * w[i + 1] - r[i] ** 2 * w[i]
            if squeezed != 0:
                longest = min(longest, COMPRESSION * abs((r[i + 1] ** 3 - r[i] ** 3) / (3 * squeezed)))
        step = min(1.1 * step, longest)
        if not step > 1e-9 * every:
            break
        kick = 0.5 * (before + step)
        before = step
        # Kicks: pressure, viscosity, gravity, rotation.
        fall = 1.0 / (1.0 + damping * kick)
        for i in range(1, shells + 1):
            pull = -G * (within[i] if i < shells else 0.5 * (within[i] + within[i - 1])) / r[i] ** 2
            low, high = 0.5 * (r[i - 1] + r[i]), 0.5 * (r[i] + r[i + 1]) if i < shells else 0.0
            for j in range(count):
                halves[i, j] = u[i, j]
                above = pressure[i, j] if i < shells else 0.0
                push = r[i] ** 2 * (above - pressure[i - 1, j])
                push += ((high**3 * viscous[i, j] if i < shells else 0.0) - low**3 * viscous[i - 1, j]) / r[i]
                turn, slide = rate[i - 1, j], 0.5 * (s[i - 1, j] + s[i - 1, j + 1])
                if i < shells:
                    turn = 0.5 * (turn + rate[i, j])
                    slide = 0.5 * (slide + 0.5 * (s[i, j] + s[i, j + 1]))
                force = pull - push * solid[j] / around[i, j] + turn**2 * r[i] * squared[j] + slide**2 / r[i] ** 3
                for d in range(degrees):
                    force += 4 * np.pi * G * radial[d, i] * cells.means[d, j]
                u[i, j] = fall * (u[i, j] + kick * force)
        for i in range(1, cells.core):
            total, moving = 0.0, 0.0
            for j in range(count):
                total += around[i, j]
                moving += around[i, j] * u[i, j]
            for j in range(count):
                u[i, j] = moving / total
        total, moving = 0.0, 0.0
        for j in range(count):  # nothing leaves through the last edge
            total += around[shells, j]
            moving += around[shells, j] * u[shells, j]
        for j in range(count):
            u[shells, j] = moving / total
        for i in range(1, shells + 1):
            for j in range(count):
                halves[i, j] = 0.5 * (halves[i, j] + u[i, j])
        for i in range(shells if damping == 0 else 0):
            middle = 0.5 * (r[i] + r[i + 1])
            for j in range(count):
                if viscous[i, j] > 0:
                    below = halves[i, j] / r[i] if i > 0 else halves[1, j] / r[1]
                    heat = -solid[j] * middle**3 * viscous[i, j] * (halves[i + 1, j] / r[i + 1] - below) / m[i, j]
                    power = matter.gamma_thermal - 1
                    a[i, j] += kick * max(heat, 0.0) * power / density[i, j] ** power
                if turned[i, j] > 0:
                    heat = -turned[i, j] / density[i, j] * (s[i, j + 1] - s[i, j]) / (middle**2 * theta)
                    power = matter.gamma_thermal - 1
                    a[i, j] += kick * heat * power / density[i, j] ** power
        for i in range(cells.core, shells):
            middle = 0.5 * (r[i] + r[i + 1])
            for j in range(1, count):
                push = (pressure[i, j] + turned[i, j] - pressure[i, j - 1] - turned[i, j - 1]) / theta
                turn = 0.5 * (rate[i, j - 1] + rate[i, j])
                force = -push / (0.5 * (density[i, j - 1] + density[i, j])) + turn**2 * square[i] * product[j]
                for d in range(degrees):
                    depth = 0.5 * (inner[d, i] + outer[d, i] + inner[d, i + 1] + outer[d, i + 1])
                    force += 4 * np.pi * G * depth * cells.slopes[d, j]
                s[i, j] = fall * (s[i, j] + kick * force)
        # The edges move with their matter; what passes them is carried along the radius.
        for i in range(1, shells + 1):
            total, moving = 0.0, 0.0
            for j in range(count):
                total += around[i, j]
                moving += around[i, j] * u[i, j]
            w[i] = moving / total
        for i in range(1, shells):
            for j in range(count):
                reach = ((r[i] + u[i, j] * step) ** 3 - (r[i] + w[i] * step) ** 3) / 3
                k = i - 1 if reach > 0 else i
                back = max(k - 1, 0) if reach > 0 else min(k + 1, shells - 1)
                ahead = i if reach > 0 else i - 1
                share = abs(reach) * 3 / (r[k + 1] ** 3 - r[k] ** 3)
                faces[i, j] = _upwind(density[back, j], density[k, j], density[ahead, j], share)
                flux[i, j] = reach * solid[j] * faces[i, j]
                carried[i, j] = _upwind(a[back, j], a[k, j], a[ahead, j], share)
                halves[i, j] = _upwind(rate[back, j], rate[k, j], rate[ahead, j], share) * r[i] ** 2 * squared[j]
        for j in range(count):
            for i in range(shells):
                old[i, j] = m[i, j]
                new = m[i, j] + flux[i, j] - flux[i + 1, j]
                kept[i, j] = 0.0
                if damping == 0 and viscous[i, j] > 0:  # in shocks mixing must not lose energy of the matter either
                    own = ((r[i + 1] + u[i + 1, j] * step) ** 3 - (r[i] + u[i, j] * step) ** 3) / 3 * solid[j]
                    kept[i, j] = m[i, j] * _energy(m[i, j] / own, a[i, j], matter)
                    if i > 0:
                        kept[i, j] += flux[i, j] * _energy(faces[i, j], carried[i, j], matter)
                    if i + 1 < shells:
                        kept[i, j] -= flux[i + 1, j] * _energy(faces[i + 1, j], carried[i + 1, j], matter)
                a[i, j] = (m[i, j] * a[i, j] + flux[i, j] * carried[i, j] - flux[i + 1, j] * carried[i + 1, j]) / new
                h[i, j] = (m[i, j] * h[i, j] + flux[i, j] * halves[i, j] - flux[i + 1, j] * halves[i + 1, j]) / new
                m[i, j] = new
                if kept[i, j] > 0:
                    dense = new / (((r[i + 1] + w[i + 1] * step) ** 3 - (r[i] + w[i] * step) ** 3) / 3 * solid[j])
                    _kept(a, i, j, kept[i, j] / new, dense, matter)
        for j in range(count):  # velocities of edges, through the middles of shells
            for i in range(1, shells + 1):
                passing, value = 0.0, 0.0
                if i < shells:
                    passing = 0.5 * (flux[i, j] + flux[i + 1, j])
                    k, back, ahead = (i, i - 1, i + 1) if passing > 0 else (i + 1, min(i + 2, shells), i)
                    value = passing * _upwind(u[back, j], u[k, j], u[ahead, j], 0.0)
                carried[i, j] = value
            last = 0.5 * min(flux[1, j], 0.0) * u[1, j]
            for i in range(1, shells + 1):
                new = 0.5 * (m[i - 1, j] + (m[i, j] if i < shells else 0.0))
                value = around[i, j] * u[i, j] + last - carried[i, j]
                come = 0.5 * (flux[i - 1, j] + flux[i, j]) if i > 1 else 0.5 * flux[1, j]
                go = 0.5 * (flux[i, j] + flux[i + 1, j]) if i < shells else 0.0
                energy = around[i, j] * u[i, j] ** 2 - value**2 / new
                energy += (last**2 / come if come != 0 else 0.0) - (carried[i, j] ** 2 / go if go != 0 else 0.0)
                if damping == 0 and energy > 0:
                    _heat(a, m, density, i, j, 0.5 * energy, matter)
                last = carried[i, j]
                u[i, j] = value / new
                around[i, j] = new
        for j in range(1, count):
            for i in range(cells.core, shells + 1):  # s through the edges; the core has none
                passing = 0.5 * (flux[i, j - 1] + flux[i, j])
                k, back, ahead = (i - 1, i - 2, i) if passing > 0 else (i, min(i + 1, shells - 1), i - 1)
                path[i] = passing * _upwind(s[back, j], s[k, j], s[ahead, j], 0.0) if i < shells else 0.0
            for i in range(cells.core, shells):
                mass, new = 0.5 * (old[i, j - 1] + old[i, j]), 0.5 * (m[i, j - 1] + m[i, j])
                s[i, j] = (mass * s[i, j] + path[i] - path[i + 1]) / new
        for i in range(1, shells + 1):
            r[i] += w[i] * step
        # Along the angle.
        for i in range(cells.core, shells):
            volume, width = (r[i + 1] ** 3 - r[i] ** 3) / 3, r[i + 1] - r[i]
            for j in range(1, count):
                reach = 4 * np.pi * sine[j] * s[i, j] * width * step
                swept[j] = reach
                k = j - 1 if reach > 0 else j
                back = max(k - 1, 0) if reach > 0 else min(k + 1, count - 1)
                ahead = j if reach > 0 else j - 1
                share = abs(reach) / (volume * solid[k])
                one, two, three = (m[i, back] / solid[back], m[i, k] / solid[k], m[i, ahead] / solid[ahead])
                faces[i, j] = _upwind(one, two, three, share) / volume
                side[i, j] = reach * faces[i, j]
                rate[i, j] = _upwind(a[i, back], a[i, k], a[i, ahead], share)
                spin = _upwind(h[i, back] / squared[back], h[i, k] / squared[k], h[i, ahead] / squared[ahead], share)
                turned[i, j] = spin * sine[j] ** 2
            for j in range(count):
                old[i, j] = m[i, j]
                new = m[i, j] + side[i, j] - side[i, j + 1]
                come, go = (side[i, j] * rate[i, j] if j > 0 else 0.0), 0.0
                spun, gone = (side[i, j] * turned[i, j] if j > 0 else 0.0), 0.0
                if j + 1 < count:
                    go, gone = side[i, j + 1] * rate[i, j + 1], side[i, j + 1] * turned[i, j + 1]
                shocked = damping == 0 and viscous[i, j] > 0
                if shocked:
                    room = volume * solid[j] + swept[j + 1] - swept[j]
                    kept[i, j] = m[i, j] * _energy(m[i, j] / room, a[i, j], matter)
                    if j > 0:
                        kept[i, j] += side[i, j] * _energy(faces[i, j], rate[i, j], matter)
                    if j + 1 < count:
                        kept[i, j] -= side[i, j + 1] * _energy(faces[i, j + 1], rate[i, j + 1], matter)
                a[i, j] = (m[i, j] * a[i, j] + come - go) / new
                if shocked:
                    _kept(a, i, j, kept[i, j] / new, new / (volume * solid[j]), matter)
                h[i, j] = (m[i, j] * h[i, j] + spun - gone) / new
                m[i, j] = new
            for j in range(count):  # s through the middles of cells
                passing = 0.5 * (side[i, j] + side[i, j + 1])
                k, back, ahead = (j, max(j - 1, 0), j + 1) if passing > 0 else (j + 1, min(j + 2, count), j)
                path[j] = passing * _upwind(s[i, back], s[i, k], s[i, ahead], 0.0)
            for j in range(1, count):
                mass, new = 0.5 * (old[i, j - 1] + old[i, j]), 0.5 * (m[i, j - 1] + m[i, j])
                s[i, j] = (mass * s[i, j] + path[j - 1] - path[j]) / new
        for i in range(cells.core, shells + 1):  # u through the faces, with the mean of what passes above and below
            path[0], path[count] = 0.0, 0.0
            for j in range(1, count):
                passing = 0.5 * (side[i - 1, j] + (side[i, j] if i < shells else 0.0))
                k, back, ahead = (j - 1, max(j - 2, 0), j) if passing > 0 else (j, min(j + 1, count - 1), j - 1)
                halves[i, j] = passing
                path[j] = passing * _upwind(u[i, back], u[i, k], u[i, ahead], 0.0)
            for j in range(count):
                new = around[i, j] + (halves[i, j] if j > 0 else 0.0) - (halves[i, j + 1] if j + 1 < count else 0.0)
                value = around[i, j] * u[i, j] + path[j] - path[j + 1]
                energy = around[i, j] * u[i, j] ** 2 - value**2 / new
                energy += path[j] ** 2 / halves[i, j] if j > 0 and halves[i, j] != 0 else 0.0
                energy -= path[j + 1] ** 2 / halves[i, j + 1] if j + 1 < count and halves[i, j + 1] != 0 else 0.0
                if damping == 0 and energy > 0:
                    _heat(a, m, density, i, j, 0.5 * energy, matter)
                u[i, j] = value / new
        for i in range(cells.core):
            total, heat, turn = 0.0, 0.0, 0.0
            lever = 0.0
            for j in range(count):
                total += m[i, j]
                heat += m[i, j] * a[i, j]
                turn += m[i, j] * h[i, j]
                lever += solid[j] / (4 * np.pi) * squared[j]
            for j in range(count):
                m[i, j] = total * solid[j] / (4 * np.pi)
                a[i, j] = heat / total
                h[i, j] = turn / (total * lever) * squared[j]
        time += step
        steps += 1
    return table[:row], best, best_time, best_moment, steps


@numba.njit(cache=True, error_model="numpy")
def _binding(r, density, m, within, cells, inner, outer):
    """Gravitational energy: of the shells as if spherical, and half of mass times the rest of the potential."""
    shells, count = density.shape
    potential = 0.0
    for i in range(shells):
        mean = (within[i + 1] - within[i]) * 3 / (4 * np.pi * (r[i + 1] ** 3 - r[i] ** 3))
        sphere = 4 * np.pi / 3 * mean
        free = (within[i] - sphere * r[i] ** 3) * 0.5 * (r[i + 1] ** 2 - r[i] ** 2)
        potential -= 4 * np.pi * G * mean * (free + sphere * (r[i + 1] ** 5 - r[i] ** 5) / 5)
        for d in range(len(cells.means)):
            depth = 0.5 * (inner[d, i] + outer[d, i] + inner[d, i + 1] + outer[d, i + 1])
            for j in range(count):
                potential -= 0.5 * 4 * np.pi * G * depth * cells.means[d, j] * m[i, j]
    return potential


@numba.njit(cache=True, error_model="numpy")
def _record(time, r, u, s, m, a, h, rate, density, square, within, matter, cells, inner, outer):
    shells, count = m.shape
    potential = _binding(r, density, m, within, cells, inner, outer)
    kinetic, internal, moment, momentum, most = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(shells):
        middle = 0.5 * (r[i] + r[i + 1])
        for j in range(count):
            slide = 0.5 * (s[i, j] ** 2 + s[i, j + 1] ** 2) / middle**2
            speed = 0.5 * (u[i, j] ** 2 + u[i + 1, j] ** 2) + slide + h[i, j] * rate[i, j]
            kinetic += 0.5 * m[i, j] * speed
            internal += m[i, j] * _energy(density[i, j], a[i, j], matter)
            moment += m[i, j] * square[i] * cells.squared[j]
            momentum += m[i, j] * h[i, j]
            most = max(most, density[i, j])
    return np.array((time, most, moment, kinetic + internal + potential, momentum, kinetic, potential))
