"""Units that values are shown in, and how they are set."""

import re
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.units import readable

LARGEST_PLAIN, SMALLEST_PLAIN = 1e4, 1e-2  # between which numbers are written out
ROUND_OFF = 1e-15  # of what numbers of size 1 are the difference of: some units in the last place
DIFFERENCES = ("surface_flattening", "ellipsoid_flattening", "zonal_harmonic_2")  # of such numbers
_SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_POWER = re.compile(r"\b(kg|rad|Pa|m|s|K|J(?=-)|N)(-?\d)\b|\^(-?\d+)")  # J2 is no power of joules


def scale_of(unit: str, *values: Any) -> tuple[float, str]:
    """What to divide values by, and the unit they are then in, so that the largest is a number one likes to read."""
    sizes = [float(np.nanmax(abs(np.asarray(v)))) for v in values if np.isfinite(np.asarray(v)).any()]
    largest = max(sizes, default=0.0)
    if largest == 0.0 or not np.isfinite(largest):
        return 1.0, unit
    if (prefixed := readable(unit, largest)) is not None:
        return prefixed
    if SMALLEST_PLAIN <= largest < LARGEST_PLAIN:
        return 1.0, unit
    exponent = int(np.floor(np.log10(largest)))
    return 10.0**exponent, f"10^{exponent}" if unit == "1" else f"10^{exponent} {unit}"


def cleared(values: Any, size: float = 1.0) -> np.ndarray:
    """Values, of which those that are nothing but round-off beside `size` are 0; NaN stays."""
    values = np.asarray(values, dtype=float)
    return np.where(abs(values) <= ROUND_OFF * size, 0.0, values)


def beyond_round_off(series: xr.DataArray) -> np.ndarray:
    """A series of a dataset; one that is a difference of numbers of size 1 is 0 where it is nothing but round-off."""
    return cleared(series.values) if series.name in DIFFERENCES else series.values


def written(value: float, factor: float, unit: str, digits: int = 4) -> str:
    """A value in the unit that it is shown in, as running text has it; nothing has no power of ten.

    >>> print(written(3.21e41, 1e41, "10^41 kg m2"), written(0.0, 1e41, "10^41 kg m2"), sep=", ")
    3.21 × 10^41 kg m2, 0 kg m2
    """
    power, _, name = unit.partition(" ") if unit.startswith("10^") else ("", "", unit)
    parts = [f"× {power}" if power and value else "", "" if name == "1" else name]
    return " ".join([f"{value / factor + 0.0:.{digits}g}", *(part for part in parts if part)])


def raised(words: str) -> str:
    """Text with powers of units raised: "10^41 kg m2" as "10⁴¹ kg m²"."""
    return _POWER.sub(lambda match: (match[1] or "") + (match[2] or match[3]).translate(_SUPERSCRIPTS), words)
