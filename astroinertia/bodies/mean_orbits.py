"""What planets go around and which moons go around them, on mean orbits: `data/mean_orbits.csv`."""

from typing import Any

from astroinertia.bodies.planets import solar_system
from astroinertia.storage.data_tables import data_rows
from astroinertia.units import GRAVITATIONAL_CONSTANT

_ORBIT = ("semi_major_axis", "eccentricity", "inclination", "node_period")


def mean_companions(name: str) -> list[dict[str, Any]]:
    """Return the companions of a body: tables of name, mass (kg) and mean orbit, as `precession_of` takes them.

    What the body goes around comes first. Empty for a body without an orbit in the table.

    >>> print([companion["name"] for companion in mean_companions("Mars")])
    ['Sun', 'Phobos', 'Deimos']
    """
    orbits = data_rows("mean_orbits.csv")
    pairs = [(row["around"], row) for row in orbits if row["body"] == name]
    if pairs:
        pairs += [(row["body"], row) for row in orbits if row["around"] == name]
    return [
        {"name": other, "mass": mass_of(other)} | {key: row[key] for key in _ORBIT if row[key]} for other, row in pairs
    ]


def mass_of(name: str) -> float:
    """Return the mass in kg of a body of `data/planets.csv` or of this table; KeyError for one of neither."""
    if name in solar_system():
        return solar_system()[name].mass
    for row in data_rows("mean_orbits.csv"):
        if row["body"] == name:
            return 1e9 * float(row["gm_km3_s2"]) / GRAVITATIONAL_CONSTANT
    raise KeyError(f"no table has the mass of {name}")
