"""Writes the stellar profiles in data/: an n = 3 polytrope that turns, as MESA and KEPLER would write it.

    python sims/progenitor_tables.py [FOLDER]

The star has 2 Msun and 3000 km, shells that turn at 4 rad/s / (1 + (r / 1000 km)^2), and the polytrope's own pressure;
it is an example of the formats, and no model of a star. Columns are those that such files have and that are read from
them, with the units of these codes: see astroinertia/sph/progenitor.py.
"""

import sys
from pathlib import Path

import numpy as np

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS, SOLAR_RADIUS

SHELLS = 160
MASS, RADIUS, INDEX = 2.0 * SOLAR_MASS, 3.0e6, 3.0


def shells() -> dict[str, np.ndarray]:
    """Outer edges and middles of shells, from the centre outwards, in SI."""
    star = Polytrope(INDEX, MASS, RADIUS, GRAVITATIONAL_CONSTANT)
    share = np.linspace(0.0, 1.0, SHELLS + 1)[1:]
    mass = MASS * share**2 * (3.0 - 2.0 * share)  # thin shells at the centre and at the surface
    radius = np.append(star.radius_enclosing(mass[:-1]), RADIUS)
    density = np.diff(mass, prepend=0.0) / (4 / 3 * np.pi * np.diff(radius**3, prepend=0.0))
    pressure = star.constant * density ** (1 + 1 / INDEX)
    middle = np.cbrt(0.5 * (radius**3 + np.append(0.0, radius[:-1]) ** 3))
    turning, of_edge = (4.0 / (1.0 + (at / 1e6) ** 2) for at in (middle, radius))
    return {
        "mass": mass, "radius": radius, "density": density, "pressure": pressure,
        "energy": INDEX * pressure / density, "omega": turning, "omega of edge": of_edge,
    }  # fmt: skip


def mesa(star: dict[str, np.ndarray]) -> str:
    """A profile.data: surface first, mass and radius in those of the Sun, logarithms and cgs."""
    head = {"model_number": 1, "num_zones": SHELLS, "star_mass": MASS / SOLAR_MASS}
    columns = {
        "zone": np.arange(SHELLS, 0, -1.0),
        "mass": star["mass"] / SOLAR_MASS,
        "logR": np.log10(star["radius"] / SOLAR_RADIUS),
        "logRho": np.log10(star["density"] * 1e-3),
        "logP": np.log10(star["pressure"] * 10),
        "energy": star["energy"] * 1e4,
        "omega": star["omega of edge"],
        "j_rot": 2 / 3 * star["omega of edge"] * star["radius"] ** 2 * 1e4,
    }

    def line(words) -> str:
        return "".join(f"{word:>25}" for word in words)

    rows = np.array(list(columns.values())).T[::-1]
    return "\n".join([
        line(range(1, len(head) + 1)), line(head), line(f"{value:.12g}" for value in head.values()), "",
        line(range(1, len(columns) + 1)), line(columns), *(line(f"{value:.15e}" for value in row) for row in rows), "",
    ])  # fmt: skip


def kepler(star: dict[str, np.ndarray]) -> str:
    """A presupernova file: centre first, cgs, --- where a star has no such thing."""
    columns = {
        "cell outer total mass": star["mass"] * 1e3,
        "cell outer radius": star["radius"] * 1e2,
        "cell outer velocity": np.zeros(SHELLS),
        "cell density": star["density"] * 1e-3,
        "cell temperature": None,
        "cell pressure": star["pressure"] * 10,
        "cell specific energy": star["energy"] * 1e4,
        "cell specific entropy": None,
        "cell angular velocity": star["omega"],
        "stability": None,
    }
    lines = ["VERSION 10104   example: a polytrope of index 3", "  grid " + "".join(f"{name:<25}" for name in columns)]
    for k in range(SHELLS):
        cells = ("---" if values is None else f"{values[k]:.16E}" for values in columns.values())
        lines.append(f"{k + 1:5d}: " + "".join(f"{cell:<25}" for cell in cells))
    return "\n".join(lines) + "\n"


def main(folder: Path) -> None:
    """Write both files."""
    star = shells()
    for name, text in (("example_mesa_profile.data", mesa(star)), ("example_kepler_presn", kepler(star))):
        (folder / name).write_text(text, encoding="utf-8")
        print(folder / name)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent.parent / "data")
