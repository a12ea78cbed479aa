"""Profiles of stars from codes of stellar evolution: tables of shells with mass, density, pressure and rotation.

Four formats are recognized by what the file holds, also where gzip has packed it:

    MESA    profile.data: a line of numbers 1 2 3 ..., one of names and one of values of the whole star, an empty line,
            then numbers, names and a row a zone, from the surface inwards (cgs; mass and radius in those of the Sun,
            which are msun and rsun among the values of the whole star, where these have them)
            or a saved model (.mod): comments, a line with "-- model for mesa/star", what the whole star has, names and
            a row a zone, with natural logarithms; its mass is in that of the Sun, which it does not state
    KEPLER  presupernova files of Woosley & Heger: names such as "cell outer total mass" at least two blanks apart, then
            "1:" and a row a cell, from the centre outwards (cgs; --- for what is not there); a last row without a
            radius is the wind
    CSV     names with units in the first line that is not a comment (#), or in the comment right before numbers, such
            as "radius (km), mass [Msun], omega (rad/s)"; rows either way round

Radius and enclosed mass are those of the outer edge of a shell, as these codes have them, and so are angular velocities
of MESA and specific angular momenta; the density of a shell is its mass over its volume, and a column of densities is
what that is checked against. Rows of one and the same mass, as rounded numbers have at a star's surface, are one shell
out to the outermost. Tests:
tests/unit/sph/test_progenitor.py.
"""

import itertools
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.sph.profiles import Profile
from astroinertia.storage.columns import HEAD_WITH_UNIT, check_there, is_number, plain_number, suffix_of, text_file
from astroinertia.units import ATOMIC_MASS, BOLTZMANN_CONSTANT, SOLAR_MASS, SOLAR_RADIUS, quantity, shown

MAX_BYTES = 2**26
MAX_SHELLS = 200_000
FEWEST_SHELLS = 8
MAX_LINE = 2**16  # characters; MESA writes some 40 a column, and may have hundreds
_SAME_DENSITY = 0.2  # of ln rho, between mass over volume and the table's own: wrong units are farther off
_GRAM, _CM = 1e-3, 1e-2
_MAX_HEAD = 100  # lines of comments before the names; KEPLER's own writer has some twenty

# Names in a file, and what a number there is in SI: a factor, or with the base of what is the logarithm of a number.
MESA = {
    "mass_grams": ("mass", _GRAM),
    "radius_cm": ("radius", _CM),
    "logR_cm": ("radius", (10.0, _CM)),
    "radius_km": ("radius", 1e3),
    "density": ("density", 1e3),
    "rho": ("density", 1e3),
    "logRho": ("density", (10.0, 1e3)),
    "logD": ("density", (10.0, 1e3)),
    "pressure": ("pressure", 0.1),
    "logP": ("pressure", (10.0, 0.1)),
    "temperature": ("temperature", 1.0),
    "logT": ("temperature", (10.0, 1.0)),
    "energy": ("internal_energy", 1e-4),
    "logE": ("internal_energy", (10.0, 1e-4)),
    "omega": ("omega_of_edge", 1.0),
    "log_omega": ("omega_of_edge", (10.0, 1.0)),
    "j_rot": ("specific_angular_momentum", 1e-4),
    "log_j_rot": ("specific_angular_momentum", (10.0, 1e-4)),
}
SAVED_MESA = {
    "dq": ("share", 1.0),  # of the mass, of a zone
    "lnR": ("radius", (math.e, _CM)),
    "lnd": ("density", (math.e, 1e3)),
    "lnT": ("temperature", (math.e, 1.0)),
    "omega": ("omega_of_edge", 1.0),
    "j_rot": ("specific_angular_momentum", 1e-4),
}
_OF_THE_SUN = {  # by the values of the whole star that say how much that is, in cgs
    "mass": ("mass", "msun"),
    "logM": ("mass", "msun"),
    "log_mass": ("mass", "msun"),
    "radius": ("radius", "rsun"),
    "logR": ("radius", "rsun"),
}
KEPLER = {
    "cell outer total mass": ("mass", _GRAM),
    "cell outer tot. mass": ("mass", _GRAM),  # of newer files that Phantom writes
    "cell outer radius": ("radius", _CM),
    "cell density": ("density", 1e3),
    "cell pressure": ("pressure", 0.1),
    "cell temperature": ("temperature", 1.0),
    "cell specific energy": ("internal_energy", 1e-4),
    "cell spec. int. energy": ("internal_energy", 1e-4),  # of files that Phantom writes
    "cell angular velocity": ("omega", 1.0),
}
CSV = {
    "radius": "length",
    "mass": "mass",
    "density": "density",
    "pressure": "pressure",
    "internal_energy": "specific_energy",
    "temperature": "K",
    "omega": "angular_velocity",
    "specific_angular_momentum": "specific_angular_momentum",
}
_ALIASES = {"u": "internal_energy", "j": "specific_angular_momentum", "rho": "density"}
Columns = dict[str, np.ndarray]


@dataclass(frozen=True)
class Progenitor:
    """Shells from the centre outwards, in SI: mass inside and radius of each outer edge (K,), which both rise.

    pressure, internal_energy (per mass) and angular_velocity (K,) where the file tells them, else None.
    """

    mass: np.ndarray
    radius: np.ndarray
    pressure: np.ndarray | None = None
    internal_energy: np.ndarray | None = None
    angular_velocity: np.ndarray | None = None

    @property
    def density(self) -> np.ndarray:
        """Mass over volume of each shell, (K,)."""
        return np.diff(self.mass, prepend=0.0) / (4 / 3 * np.pi * np.diff(self.radius**3, prepend=0.0))

    def inner(self, mass: float) -> "Progenitor":
        """What lies within an enclosed mass; the shell that it cuts keeps its density. ValueError beyond the table."""
        if not 0 < mass <= self.mass[-1]:
            raise ValueError(f"the profile has {self.mass[-1]:.6g} kg, not the {mass:.6g} kg asked for")
        last = int(np.searchsorted(self.mass, mass * (1 - 1e-12)))
        edge = np.interp(mass, np.append(0.0, self.mass), np.append(0.0, self.radius**3)) ** (1 / 3)

        def cut(values: np.ndarray | None) -> np.ndarray | None:
            return None if values is None else values[: last + 1]

        return Progenitor(
            np.append(self.mass[:last], mass), np.append(self.radius[:last], edge), cut(self.pressure),
            cut(self.internal_energy), cut(self.angular_velocity),
        )  # fmt: skip

    @property
    def angular_momentum(self) -> float:
        """sum of 2/3 omega r^2 dm over shells of even density; 0 without rotation."""
        if self.angular_velocity is None:
            return 0.0
        return float((self.angular_velocity * 2 / 3 * self._mean_square * np.diff(self.mass, prepend=0.0)).sum())

    @property
    def rotational_energy(self) -> float:
        """sum of 1/3 omega^2 r^2 dm over shells of even density; 0 without rotation."""
        if self.angular_velocity is None:
            return 0.0
        return float((self.angular_velocity**2 / 3 * self._mean_square * np.diff(self.mass, prepend=0.0)).sum())

    def pressure_in_balance(self, gravitational_constant: float) -> np.ndarray:
        """The pressure (K,) that holds up what is above the middle of each shell, in radius: int rho G m / r^2 dr."""
        edges = np.append(0.0, self.radius)
        middle = 0.5 * (edges[1:] + edges[:-1])
        even = 4 / 3 * np.pi * self.density
        core = self.mass - even * self.radius**3  # m = core + even r^3 within a shell

        def weight(low: np.ndarray, high: np.ndarray) -> np.ndarray:
            # The innermost has no core: its 1/low is infinite.
            hollow = np.where(low > 0.0, core / np.where(low > 0.0, low, 1.0) - core / high, 0.0)
            return gravitational_constant * self.density * (hollow + even * (high**2 - low**2) / 2)

        above = np.cumsum(weight(edges[:-1], edges[1:])[::-1])[::-1]
        return weight(middle, edges[1:]) + np.append(above[1:], 0.0)

    @property
    def moment_of_inertia(self) -> float:
        """About any axis through the centre."""
        return float((2 / 3 * self._mean_square * np.diff(self.mass, prepend=0.0)).sum())

    @property
    def _mean_square(self) -> np.ndarray:
        fifth, third = (np.diff(self.radius**n, prepend=0.0) for n in (5, 3))
        return 0.6 * fifth / third

    def profile(self) -> Profile:
        """The mass profile of unit mass and radius, of shells of even density."""
        m, r = self.mass / self.mass[-1], self.radius / self.radius[-1]
        inside, cubes = np.append(0.0, m), np.append(0.0, r) ** 3
        even = np.diff(inside) / (4 / 3 * np.pi * np.diff(cubes))
        # -integral of m dm / r, exactly
        low, high = np.append(0.0, r[:-1]), r
        core = inside[:-1] - 4 / 3 * np.pi * even * low**3
        binding = 4 * np.pi * even * (core * (high**2 - low**2) / 2 + 4 / 3 * np.pi * even * (high**5 - low**5) / 5)
        return Profile(
            name=f"shells {np.array([m, r]).tobytes().hex()}",
            enclosed=lambda s: np.interp(np.clip(s, 0.0, 1.0) ** 3, cubes, inside),
            radius=lambda share: np.cbrt(np.interp(share, inside, cubes)),
            density=lambda s: np.where(
                np.asarray(s) <= 1.0, even[np.minimum(np.searchsorted(r, s, side="left"), len(even) - 1)], 0.0
            ),
            second_moment=self.moment_of_inertia / 2 / (self.mass[-1] * self.radius[-1] ** 2),
            gravitational_energy=-float(binding.sum()),
        )

    def at(self, values: np.ndarray, s: np.ndarray) -> np.ndarray:
        """A column at s = r/R: of the shells' middles in volume, linear in between, level beyond the first and last."""
        cubes = np.append(0.0, self.radius**3)
        middle = np.cbrt(0.5 * (cubes[1:] + cubes[:-1])) / self.radius[-1]
        return np.interp(s, middle, values)


def read_progenitor(path: str | Path, mean_molecular_weight: float | None = None) -> Progenitor:
    """The shells of a file; SceneError that says what is wrong with it.

    Where it has no pressure but temperatures, the pressure is that of an ideal gas of that molecular weight, if given.
    """
    path = Path(path)
    name = shown(str(path), 200)
    check_there(path, "stellar profile")
    if path.stat().st_size > MAX_BYTES:
        raise SceneError(f"stellar profile {name} is larger than {MAX_BYTES >> 20} MiB")
    with text_file(path, f"stellar profile {name}", MAX_BYTES) as file:
        lines = list(itertools.islice(iter(lambda: file.readline(MAX_LINE + 1), ""), MAX_SHELLS + 101))
    if any(len(line) > MAX_LINE for line in lines):
        raise SceneError(f"stellar profile {name} has a line of more than {MAX_LINE} characters")
    if len(lines) > MAX_SHELLS + 100:
        raise SceneError(f"stellar profile {name} has more than {MAX_SHELLS} shells")
    lines = [line.rstrip("\r\n") for line in lines]
    try:
        columns = _columns(path, lines)
        return _checked(columns, mean_molecular_weight)
    except ValueError as error:
        raise SceneError(f"stellar profile {name}: {error}") from None


def _columns(path: Path, lines: list[str]) -> Columns:
    if suffix_of(path) == ".csv":
        return _csv(lines)
    for number, line in enumerate(lines[:_MAX_HEAD]):
        if re.search(r"cell outer tot(al|\.) mass", line):
            return _kepler(line, lines[number + 1 :])
        if "-- model for mesa/star" in line:
            return _saved_mesa(lines[number + 1 :])
    first = lines[0].split() if lines else []
    if len(lines) > 6 and first and first == [str(k + 1) for k in range(len(first))]:
        return _recognised(lines[5].split(), [line.split() for line in lines[6:] if line.strip()], _mesa(lines))
    raise ValueError(
        "this is none of the known formats: a MESA profile.data or .mod, a KEPLER presupernova file, or a .csv"
    )


def _mesa(lines: list[str]) -> dict:
    """MESA, with what the file says of the Sun, whose mass in versions of MESA differs by up to 4e-4."""
    said = dict(zip(lines[1].split(), lines[2].split(), strict=False))
    sun = {"msun": SOLAR_MASS, "rsun": SOLAR_RADIUS}
    for name, unit in (("msun", _GRAM), ("rsun", _CM)):
        if name in said and (values := _numbers([said[name]], name)) is not None:
            sun[name] = float(values[0]) * unit
    return MESA | {
        name: (kind, (10.0, sun[of]) if name.startswith("log") else sun[of]) for name, (kind, of) in _OF_THE_SUN.items()
    }


def _saved_mesa(lines: list[str]) -> Columns:
    words = [line.split() for line in lines]
    said = {row[0]: row[1] for row in words[:_MAX_HEAD] if len(row) > 1}
    if "R_center" in said:
        raise ValueError("it is a saved model of MESA whose core is cut out (R_center)")
    mass = _numbers([said.get("M/Msun", "-")], "M/Msun")
    place = next((k for k, row in enumerate(words[:_MAX_HEAD]) if {"lnR", "dq"} <= {*row}), len(words))
    names, rows = words[place : place + 1], itertools.takewhile(len, words[place + 1 :])  # then of the model before it
    columns = _recognised(["row", *itertools.chain(*names)], list(rows), SAVED_MESA)
    if mass is None or "share" not in columns:
        raise ValueError("it is a saved model of MESA without its mass (M/Msun) or shells (lnR and dq)")
    with np.errstate(over="ignore", invalid="ignore"):
        columns["mass"] = mass * SOLAR_MASS * np.cumsum(columns.pop("share")[::-1])[::-1]
    return columns


def _kepler(header: str, lines: list[str]) -> Columns:
    # In some files brackets with a number stand about each name, which is padded on either side.
    names = re.findall(r"\[\s*\d+\s+(.*?)\s*\]", header) or re.split(r"\s{2,}", header.strip(" #"))
    names = [name.removeprefix("grid ").strip() for name in names if name]
    rows = [line.replace(":", " ").split() for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if names[0] != "grid":
        names = ["grid", *names]
    wanted = max(k for k, name in enumerate(names) if name in KEPLER) + 1
    short = next((k for k, row in enumerate(rows) if len(row) < wanted), None)
    if short is not None:
        raise ValueError(f"row {short + 1} has {len(rows[short])} values, fewer than the {wanted} that are read")
    outer = names.index("cell outer radius") if "cell outer radius" in names else None
    if outer is not None and rows and not rows[-1][outer].strip("-"):  # the wind has a mass and no radius
        rows = rows[:-1]
    return _recognised(names[:wanted], [row[:wanted] for row in rows], KEPLER)


def _recognised(names: list[str], rows: list[list[str]], table: dict) -> Columns:
    wrong = next((k for k, row in enumerate(rows) if len(row) != len(names)), None)
    if wrong is not None:
        raise ValueError(f"row {wrong + 1} has {len(rows[wrong])} values, not {len(names)}")
    columns: Columns = {}
    for k, name in enumerate(names):
        if name not in table or table[name][0] in columns:
            continue
        kind, factor = table[name]
        values = _numbers([row[k] for row in rows], name)
        if values is not None:
            power, scale = factor if isinstance(factor, tuple) else (None, factor)
            with np.errstate(over="ignore"):
                columns[kind] = (values if power is None else power**values) * scale
    return columns


def _csv(lines: list[str]) -> Columns:
    held = [k for k, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")]
    if not held:
        raise ValueError("it is empty")
    rows = [lines[k].split(",") for k in held]
    before = lines[held[0] - 1].strip() if held[0] else ""
    if before.startswith("#") and is_number(rows[0][0]):  # as savetxt of NumPy writes the head
        rows.insert(0, before.removeprefix("#").split(","))
    columns: Columns = {}
    for k, title in enumerate(rows[0]):
        parts = HEAD_WITH_UNIT.fullmatch(title)
        unit = "" if parts is None else (parts[2] or parts[3]).strip()
        if parts is None:
            raise ValueError(f"the column '{shown(title.strip())}' must be a name and a unit, such as \"radius (km)\"")
        kind = _ALIASES.get(parts[1].lower(), parts[1].lower())
        if kind not in CSV or kind in columns:
            problem = "there already" if kind in columns else f"not one of {', '.join(CSV)}"
            raise ValueError(f"the column '{shown(parts[1])}' is {problem}")
        values = _numbers([row[k] if len(row) == len(rows[0]) else "a row of another length" for row in rows[1:]], kind)
        if values is None:
            raise ValueError(f"the column '{kind}' is empty")
        if CSV[kind] == "K":
            if unit != "K":
                raise ValueError("temperatures must be in K")
            columns[kind] = values
        else:
            try:
                columns[kind] = values * quantity(f"1 {unit}", CSV[kind])
            except SceneError as error:
                raise ValueError(f"the unit of {kind}: {error}") from None
    return columns


def _numbers(words: list[str], name: str) -> np.ndarray | None:
    # Nothing at all may be known of a quantity; a part of it may not be missing.
    if all(word.strip("-") == "" for word in words):
        return None
    values = np.empty(len(words))
    for k, word in enumerate(words):
        try:
            values[k] = plain_number(re.sub(r"(?<=\d)[dD](?=[+-]?\d)", "e", word))
        except ValueError:
            raise ValueError(f"{name} of row {k + 1} is not a number but '{shown(word.strip())}'") from None
    return values


def _checked(columns: Columns, molecular_weight: float | None) -> Progenitor:
    if "radius" not in columns or not ({"mass", "density"} & columns.keys()):
        raise ValueError("it needs a column of radius and one of enclosed mass or of density")
    count = len(columns["radius"])
    if not FEWEST_SHELLS <= count <= MAX_SHELLS:
        raise ValueError(f"it has {count} shells, not {FEWEST_SHELLS} to {MAX_SHELLS}")
    _refuse_not_finite(columns)
    columns, rows = _outwards(columns)

    def refuse_where(wrong: np.ndarray, what: str) -> None:
        if wrong.any():
            raise ValueError(what.format(f"row {rows[int(np.argmax(wrong))]}"))

    radius = columns["radius"]
    refuse_where(np.diff(radius, prepend=0.0) <= 0, "the radius does not rise at {}")
    volume = 4 / 3 * np.pi * np.diff(radius**3, prepend=0.0)
    if "density" in columns:
        outside = "density of {} is not positive: it is that of the shell out to the row's radius"
        refuse_where(columns["density"] <= 0, outside)
    if "mass" not in columns:
        columns["mass"] = np.cumsum(columns["density"] * volume)
    mass = columns["mass"]
    refuse_where(np.diff(mass, prepend=0.0) <= 0, "the mass does not rise at {}")
    if "density" in columns:
        _same_density(columns["density"], np.diff(mass, prepend=0.0) / volume)
    for name in ("pressure", "temperature", "internal_energy"):
        if name in columns:
            refuse_where(columns[name] <= 0, name + " of {} is not positive")
    pressure = columns.get("pressure")
    if pressure is None and "temperature" in columns and molecular_weight is not None:
        density = np.diff(mass, prepend=0.0) / volume
        pressure = density * BOLTZMANN_CONSTANT * columns["temperature"] / (molecular_weight * ATOMIC_MASS)
    return Progenitor(mass, radius, pressure, columns.get("internal_energy"), _rotation(columns))


def _refuse_not_finite(columns: Columns) -> None:
    for name, values in columns.items():
        if not np.isfinite(values).all() or np.abs(values).max() > 1e200:
            raise ValueError(f"{name} of row {int(np.argmin(np.isfinite(values))) + 1} is not finite, or too large")


def _outwards(columns: Columns) -> tuple[Columns, np.ndarray]:
    """Shells from the centre outwards, and the rows of the file that they are in, for what is said of them."""
    rows: Any = np.arange(len(columns["radius"])) + 1

    def chosen(which: Any) -> tuple[Columns, np.ndarray]:
        return {name: values[which] for name, values in columns.items()}, rows[which]

    if columns["radius"][0] > columns["radius"][-1]:
        columns, rows = chosen(slice(None, None, -1))
    if columns["radius"][0] == 0.0:  # a row for the centre itself is no shell
        columns, rows = chosen(slice(1, None))
    if "mass" in columns and (outermost := np.append(np.diff(columns["mass"]) != 0.0, True)).sum() >= FEWEST_SHELLS:
        columns, rows = chosen(outermost)
    return columns, rows


def _rotation(columns: Columns) -> np.ndarray | None:
    """The angular velocity of shells as a file states it, or from that of their edges; None where it states none."""
    of_edge = columns.get("omega_of_edge")
    if of_edge is None and "specific_angular_momentum" in columns:
        # j is the mean over the surface of a sphere
        of_edge = 1.5 * columns["specific_angular_momentum"] / columns["radius"] ** 2
    if "omega" in columns or of_edge is None:
        return columns.get("omega")
    return 0.5 * (of_edge + np.append(of_edge[:1], of_edge[:-1]))


def _same_density(stated: np.ndarray, implied: np.ndarray) -> None:
    apart = float(np.median(np.abs(np.log(stated / implied))))
    if apart > _SAME_DENSITY:
        raise ValueError(f"its densities are {np.exp(apart):.3g} times off what its masses and radii say")
