"""Where Sun, Moon and planets were at J2000 and how they moved: `data/j2000_states.csv`, about any of them, in SI."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from astroinertia.storage.data_tables import data_rows

MEAN_OBLIQUITY = np.radians(84381.406 / 3600.0)  # of the ecliptic at J2000: Capitaine et al. 2003, A&A 412, 567
EARTH_PARAMETER = 398600.435507e9  # GM in m3 s-2, DE440: Park et al. 2021, AJ 161, 105


class State(NamedTuple):
    """GM (m3 s-2, with all moons), position (3,) in m and velocity (3,) in m s-1."""

    gravitational_parameter: float
    position: np.ndarray
    velocity: np.ndarray


def ecliptic_axes() -> np.ndarray:
    """The axes (3, 3) of the mean ecliptic and equinox of J2000 as rows, in ICRF (equatorial) axes."""
    c, s = np.cos(MEAN_OBLIQUITY), np.sin(MEAN_OBLIQUITY)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])


def states(about: str = "Earth", axes: np.ndarray | None = None) -> dict[str, State]:
    """Sun, Moon and planets by name, relative to one of them, which is not among them; 2000-01-01 12:00 TDB.

    axes (3, 3): rows in ICRF axes, those of the ecliptic unless given. The Moon is there for the Earth alone; for other
    bodies Earth and Moon are one, at their centre of mass. KeyError for a body that is not in the table.
    Source: DE440, Park et al. 2021, AJ 161, 105.
    """
    turn, table = ecliptic_axes() if axes is None else np.asarray(axes), _table()
    if about == "Earth":
        return {name: State(gm, turn @ place, turn @ speed) for name, (gm, place, speed) in table.items()}
    if about not in table or about == "Moon":
        raise KeyError(f"the table has no orbits about {about}; it has the Sun, the Earth and the other planets")
    moon = table["Moon"]
    both = moon.gravitational_parameter + EARTH_PARAMETER
    share = moon.gravitational_parameter / both
    centre = State(both, share * moon.position, share * moon.velocity)
    others = {("Earth" if name == "Moon" else name): (centre if name == "Moon" else one) for name, one in table.items()}
    origin = others.pop(about)
    return {
        name: State(gm, turn @ (place - origin.position), turn @ (speed - origin.velocity))
        for name, (gm, place, speed) in others.items()
    }


@lru_cache(maxsize=1)
def _table() -> dict[str, State]:
    return {
        row["body"]: State(
            1e9 * float(row["gm_km3_s2"]),
            1e3 * np.array([float(row[f"{axis}_km"]) for axis in "xyz"]),
            1e3 * np.array([float(row[f"v{axis}_km_s"]) for axis in "xyz"]),
        )
        for row in data_rows("j2000_states.csv")
    }
