"""Units that values are shown in, and how they are set."""

import re
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.units import readable

LARGEST_PLAIN, SMALLEST_PLAIN = 1e4, 1e-2  # between which numbers are written out
_SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_POWER = re.compile(r"\b(kg|rad|Pa|m|s|K|J(?=-)|N)(-?\d)\b|\^(-?\d+)")  # J2 is no power of joules


def unit_of(variable: xr.DataArray) -> str:
    """The unit of a variable."""
    return str(variable.attrs.get("units", "1"))


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


def raised(words: str) -> str:
    """Text with powers of units raised: "10^41 kg m2" as "10⁴¹ kg m²"."""
    return _POWER.sub(lambda match: (match[1] or "") + (match[2] or match[3]).translate(_SUPERSCRIPTS), words)
