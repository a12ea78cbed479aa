"""A star that is spun up slowly, held against the exact rotating stars of the same matter, mass and angular momentum.

Tests: tests/physics/test_slow_spin_up.py.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from astroinertia.bodies import maclaurin
from astroinertia.bodies.rotating_sequence import rotating_sequence
from astroinertia.dataset.variables import variables
from astroinertia.errors import SceneError
from astroinertia.process.quantities import with_quantities

RATES = tuple(np.linspace(0.2, 0.9, 8))
_TEXTS = {
    "time": "when it turned so fast",
    "angular_momentum": "L/(G M^3 R)^(1/2), R the radius at rest",
    "angular_velocity": "L/I_zz in units of (G M/R^3)^(1/2)",
    "angular_velocity_exact": "that of the exact star of the same angular momentum",
    "axis_ratio": "(Q_zz/Q_xx)^(1/2) of second moments",
    "axis_ratio_exact": "that of the exact star of the same angular momentum",
    "rotational_to_gravitational": "T/|W|",
    "rotational_to_gravitational_exact": "that of the exact star of the same angular momentum",
    "axis_ratio_maclaurin": "that of the Maclaurin spheroid with this T/|W|",
    "disordered_energy": "kinetic energy other than that of rigid rotation, over |W|",
    "axis_ratio_error": "over the exact, less one",
    "rotational_to_gravitational_error": "over the exact, less one",
    "maclaurin_error": "axis ratio over that of the Maclaurin spheroid with this T/|W|, less one",
}


@with_quantities()
def along_sequence(dataset: xr.Dataset, index: float, rates: Sequence[float] = RATES) -> xr.Dataset:
    """Return what a polytrope that is spun up about z was when it first turned at these shares of the shedding rate.

    dataset: a run that began with the star at rest; index: its polytropic index. Units are G = M = 1 and the radius at
    rest. Exact are stars of the self-consistent field with the same mass, entropy and angular momentum. SceneError
    where the star never turned so fast.
    """
    star = rotating_sequence(index)
    shedding = star.figures[:, 0].max()
    mass, radius = float(dataset["mass"][0]), float(dataset.attrs["reference_radius"])
    gravity = float(dataset.attrs["gravitational_constant"])
    momentum = dataset["angular_momentum"].sel(i="z").values / (gravity * mass**3 * radius) ** 0.5
    second = dataset["second_moment"].values / (mass * radius**2)
    across, along = (second[:, 0, 0] + second[:, 1, 1]) / 2, second[:, 2, 2]
    spin = momentum / (2 * across)
    rows = [_first(spin >= share * shedding, share) for share in rates]
    energy, bound = dataset["kinetic_energy"].values[rows], -dataset["gravitational_energy"].values[rows]
    columns = {
        "time": dataset["time"].values[rows] * (gravity * mass / radius**3) ** 0.5,
        "angular_momentum": momentum[rows],
        "angular_velocity": spin[rows],
        "axis_ratio": np.sqrt(along[rows] / across[rows]),
        "rotational_to_gravitational": momentum[rows] * spin[rows] / 2 * gravity * mass**2 / radius / bound,
    }
    exact = star.at(columns["angular_momentum"])
    for name in ("angular_velocity", "axis_ratio", "rotational_to_gravitational"):
        columns[f"{name}_exact"] = exact[name]
    for name in ("axis_ratio", "rotational_to_gravitational"):
        columns[f"{name}_error"] = columns[name] / exact[name] - 1
    share = columns["rotational_to_gravitational"]
    liquid = np.array([maclaurin.from_energy_ratio(float(ratio)).c_over_a for ratio in share])
    columns |= {"axis_ratio_maclaurin": liquid, "disordered_energy": energy / bound - share}
    columns["maclaurin_error"] = columns["axis_ratio"] / liquid - 1
    return xr.Dataset(
        variables("rate", {name: (columns[name], "1", text) for name, text in _TEXTS.items()}),
        variables("rate", {"rate": (list(rates), "1", "angular velocity over that of mass shedding")}),
        {"title": f"a polytrope of index {index:g}, spun up slowly"},
    )


def _first(reached: np.ndarray, share: float) -> int:
    rows = np.flatnonzero(reached)
    if not len(rows):
        raise SceneError(f"the star never turned at {share:g} of the rate at which it sheds mass")
    return int(rows[0])
