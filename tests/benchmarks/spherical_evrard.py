"""Evrard's collapse in one dimension, by a grid that moves with the matter: the reference of `data/references.toml`.

    python tests/benchmarks/spherical_evrard.py

M = R = G = 1, rho = 1/(2 pi r), u = 0.05, gamma = 5/3 (Evrard 1988, MNRAS 235, 911). Edges r between shells of equal
width at the start, leapfrog, gravity of the enclosed mass, and the viscosity of von Neumann & Richtmyer as a tensor
without trace-free part in homologous flow (Tscharnuter & Winkler 1979, Comput. Phys. Commun. 18, 171). The internal
energy of a shell changes by (P + viscosity) dV, with its pressure half-way through the step, so that the total energy
is a check. It shares nothing with particles. What it prints: each quantity with 1000, 2000 and 4000 shells, the value
that these tend to, and how far the finest is from that.

    python tests/benchmarks/spherical_evrard.py --shells 200 --smoothed 3000 --tangential 0.2 --removed 1

Viscosity as wide as a smoothing length of so many particles, whose stress along the sphere is that part of the radial
one: -1/2 has no trace, and sums over approaching pairs have 0.2 (the square of the approach) to 1/3 (linear). --removed
takes the isotropic part out of the pressure, up to so many times that pressure.
"""

import argparse

import numba
import numpy as np

GAMMA, OPENING_ENERGY, END, EVERY = 5.0 / 3.0, 0.05, 3.0, 1e-3
QUADRATIC, LINEAR, COURANT, COMPRESSION = 2.0, 0.5, 0.25, 0.02
DIFFUSION = 0.15  # of the time in which viscosity crosses a shell, where it is wider than one
TRACELESS, ETA = -0.5, 1.1
COLUMNS = ("kinetic_energy", "internal_energy", "gravitational_energy", "moment_of_inertia", "density_max")


def collapse(
    shells: int, end: float = END, every: float = EVERY, smoothed: float = np.inf, tangential: float = TRACELESS,
    removed: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Times (T,) and what there is then (T, 5), by COLUMNS."""
    edges = np.linspace(0.0, 1.0, shells + 1)
    return _collapse(edges**2, edges, end, every, smoothed, tangential, removed)


@numba.njit(cache=True, error_model="numpy")
def _collapse(enclosed, r, end, every, smoothed, tangential, removed):
    shells = len(r) - 1
    mass = np.diff(enclosed)
    v, energy = np.zeros(shells + 1), np.full(shells, OPENING_ENERGY)
    volume, viscous, rate = np.zeros(shells), np.zeros(shells), np.zeros(shells + 1)
    even, old = np.zeros(shells), np.zeros(shells + 1)  # the isotropic part of the viscous stress
    for i in range(shells):
        volume[i] = 4 * np.pi / 3 * (r[i + 1] - r[i]) * (r[i + 1] ** 2 + r[i + 1] * r[i] + r[i] ** 2)
    rows = int(end / every + 0.5) + 1
    times, table = np.zeros(rows), np.zeros((rows, 5))
    time, step, row = 0.0, 1e-7, 0
    before = 0.0  # the step before: velocities are half a step behind edges
    while row < rows:
        longest = every
        for i in range(shells):
            density = mass[i] / volume[i]
            sound = np.sqrt(GAMMA * (GAMMA - 1) * energy[i])
            width, jump = r[i + 1] - r[i], v[i + 1] - v[i]
            flow = r[i + 1] ** 2 * v[i + 1] - r[i] ** 2 * v[i]
            # Of the rate (v/r)' that homologous flow lacks; the innermost shell has none.
            sheared = i > 0 and jump < 0 and flow < 0 and v[i + 1] * r[i] < v[i] * r[i + 1]
            wider = max(ETA / (smoothed * density) ** (1.0 / 3.0) / width, 1.0)
            across = wider * jump
            stress = density * across * (QUADRATIC * across - LINEAR * sound) if sheared else 0.0
            viscous[i] = 2.0 / 3.0 * (1.0 - tangential) * stress
            even[i] = (1.0 + 2.0 * tangential) / 3.0 * stress
            even[i] -= min(even[i], removed * (GAMMA - 1) * energy[i] * density)
            if wider > 1.0 and sheared:
                longest = min(longest, DIFFUSION * width / (wider * (LINEAR * sound - QUADRATIC * across)))
            longest = min(longest, COURANT * width / (sound + 4 * QUADRATIC * max(-jump, 0.0)))
            if flow != 0:
                longest = min(longest, COMPRESSION * abs((r[i + 1] ** 3 - r[i] ** 3) / (3 * flow)))
        if time >= row * every - 1e-12:
            times[row] = time
            table[row] = _row(enclosed, mass, r, v, energy, volume)
            row += 1
        step = min(1.1 * step, longest, row * every - time) if row * every > time else min(1.1 * step, longest)
        kick = 0.5 * (before + step)
        before = step
        rate[:] = v
        old[:] = v
        for i in range(1, shells + 1):
            inner = (GAMMA - 1) * energy[i - 1] * mass[i - 1] / volume[i - 1] + even[i - 1]
            outer = (GAMMA - 1) * energy[i] * mass[i] / volume[i] + even[i] if i < shells else 0.0
            around = 0.5 * (mass[i - 1] + mass[i]) if i < shells else 0.5 * mass[i - 1]
            below = (0.5 * (r[i - 1] + r[i])) ** 3 * viscous[i - 1]
            above = (0.5 * (r[i] + r[i + 1])) ** 3 * viscous[i] if i < shells else 0.0
            push = 4 * np.pi * (r[i] ** 2 * (outer - inner) + (above - below) / r[i]) / around
            within = enclosed[i] if i < shells else enclosed[i] - 0.25 * mass[i - 1]
            v[i] -= kick * (push + within / r[i] ** 2)
            rate[i] = 0.5 * (rate[i] + v[i]) / r[i]
        for i in range(shells):
            middle = 0.5 * (r[i] + r[i + 1])
            # As much as motion loses by it in this kick, whose mean velocities it takes.
            heat = -4 * np.pi * middle**3 * viscous[i] * kick * (rate[i + 1] - rate[i]) / mass[i]
            closing = r[i + 1] ** 2 * (old[i + 1] + v[i + 1]) - r[i] ** 2 * (old[i] + v[i])
            heat -= 2 * np.pi * even[i] * kick * closing / mass[i]
            a, b = r[i] + step * v[i], r[i + 1] + step * v[i + 1]
            new = 4 * np.pi / 3 * (b - a) * (b * b + b * a + a * a)
            squeeze = 0.5 * (GAMMA - 1) * (new - volume[i])
            # With the mean of the pressures before and after: implicit, and solved for the energy.
            energy[i] = (energy[i] * (1 - squeeze / volume[i]) + heat) / (1 + squeeze / new)
            volume[i] = new
        for i in range(1, shells + 1):
            r[i] += step * v[i]
        time += step
    return times, table


@numba.njit(cache=True, error_model="numpy")
def _row(enclosed, mass, r, v, energy, volume):
    kinetic, internal, potential, inertia = 0.0, 0.0, 0.0, 0.0
    for i in range(len(mass)):
        inside, density = v[i], mass[i] / volume[i]
        kinetic += 0.25 * mass[i] * (inside**2 + v[i + 1] ** 2)
        internal += mass[i] * energy[i]
        cubes, fifths = r[i + 1] ** 3 - r[i] ** 3, r[i + 1] ** 5 - r[i] ** 5
        sphere = 4 * np.pi / 3 * density
        free = (enclosed[i] - sphere * r[i] ** 3) * 0.5 * (r[i + 1] ** 2 - r[i] ** 2)
        potential -= 4 * np.pi * density * (free + sphere * fifths / 5)
        inertia += 2.0 / 3.0 * mass[i] * 0.6 * fifths / cubes
    return np.array((kinetic, internal, potential, inertia, mass[0] / volume[0]))


def figures(times: np.ndarray, table: np.ndarray) -> dict[str, float]:
    """Extrema with their times, by parabolas through three rows, and the moment of inertia at some times."""
    series = dict(zip(COLUMNS, table.T, strict=True))
    result = {}
    for name, sign in (("kinetic_energy", 1), ("internal_energy", 1), ("gravitational_energy", -1),
                       ("moment_of_inertia", -1)):  # fmt: skip
        values = sign * series[name]
        k = int(values.argmax())
        low, mid, high = values[k - 1 : k + 2]
        shift = 0.5 * (low - high) / (low - 2 * mid + high)
        result[f"{name}, extreme"] = sign * (mid - 0.25 * (low - high) * shift)
        result[f"{name}, its time"] = times[k] + shift * (times[1] - times[0])
    for time in (0.2, 0.7, 1.0, 1.5, 2.0, 3.0):
        result[f"moment_of_inertia at {time}"] = float(np.interp(time, times, series["moment_of_inertia"]))
    total = series["kinetic_energy"] + series["internal_energy"] + series["gravitational_energy"]
    result["largest change of the total energy"] = float(np.abs(total - total[0]).max())
    return result


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--shells", type=int, nargs="+", default=[1000, 2000, 4000])
    parser.add_argument(
        "--smoothed", type=float, default=np.inf, help="particles whose smoothing lengths it is as wide as"
    )
    parser.add_argument(
        "--tangential", type=float, default=TRACELESS, help="stress along the sphere over the radial one"
    )
    parser.add_argument("--removed", type=float, default=0.0, help="of its isotropic part, in units of the pressure")
    options = parser.parse_args()
    wide = options.smoothed, options.tangential, options.removed
    columns = [figures(*collapse(shells, END, EVERY, *wide)) for shells in options.shells]
    print(f"{'quantity':38}", *(f"{shells:>10}" for shells in options.shells), f"{'limit':>10}")
    for name in columns[0]:
        values = [figure[name] for figure in columns]
        steps = np.diff(values)
        ratio = steps[-2] / steps[-1] if len(steps) > 1 and steps[-1] else 2.0
        limit = values[-1] + (steps[-1] / max(ratio - 1, 1.0) if len(steps) else 0.0)
        print(f"{name:38}", *(f"{value:10.5f}" for value in values), f"{limit:10.5f}")


if __name__ == "__main__":
    main()
