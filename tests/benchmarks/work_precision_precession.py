"""Error against time of spins over ages, of sections of spin and orbit, and of the integrated precession of Mars."""

import numpy as np
from precision_table import publish, table

from astroinertia.rotation.precession import ARCSECOND_PER_YEAR, JULIAN_YEAR
from astroinertia.rotation.secular_spin import spin_history
from astroinertia.rotation.spin_orbit import surface_of_section
from astroinertia.studies.obliquity import planetary_planes
from astroinertia.studies.precession import precession

ALPHA, NODE, LEAN = 20.0 * ARCSECOND_PER_YEAR, -18.85 * ARCSECOND_PER_YEAR, np.radians(5)
TIMES = np.linspace(0.0, 1e8 * JULIAN_YEAR, 101)
NAMES, MODES = planetary_planes()


def colombo(steps):
    return spin_history(TIMES, [0, np.sin(0.4), np.cos(0.4)], ALPHA, np.sin(LEAN / 2), NODE, 0.0, 0.0, steps)


def drift(found):
    energy = 0.5 * ALPHA * (found.axis * found.normal).sum(1) ** 2 + NODE * found.axis[:, 2]
    return float(np.abs(energy / energy[0] - 1).max())


def planet(name, alpha):
    k = NAMES.index(name)

    def run(steps):
        terms = MODES.amplitudes[k], MODES.rates, MODES.phases[k]
        return spin_history(TIMES[:11], [0.0, 0.4, 0.917], alpha * ARCSECOND_PER_YEAR, *terms, 0.0, steps)

    exact = run(192)
    return run, lambda found: float(np.abs(found.axis - exact.axis).max())


def section(eccentricity, asphericity):
    def run(steps):
        return surface_of_section(eccentricity, asphericity, np.zeros(20), np.linspace(2.5, 3.5, 20), 50, steps)

    exact = run(768)
    return run, lambda found: float(np.abs(found.rate - exact.rate).max())


def mars(steps):
    return float(precession("Mars", 18.9, steps)["precession_rate"].sel(part="all"))


exact = mars(40)
tables = [table("Colombo's top, 1e8 years: its integral", "steps a radian", (3, 6, 12, 24, 48), colombo, drift, 24)]
for name, alpha in (("Earth", 54.93), ("Mars", 8.403)):
    run, error = planet(name, alpha)
    tables.append(
        table(f"{name} on eight modes, 1e7 years: its axis", "steps a radian", (3, 6, 12, 24, 48), run, error, 24)
    )
for e, size in ((0.1, 0.2), (0.4, 0.2)):
    run, error = section(e, size)
    tables.append(
        table(f"section, e = {e}, omega_0 = {size}, 50 orbits", "steps an orbit", (24, 48, 96, 192), run, error, 96)
    )
tables.append(
    table("precession of Mars, 19 years", "kicks a day", (1, 2, 4, 6, 10), mars, lambda rate: abs(rate / exact - 1), 6)
)
publish("precession", tables)
