"""The rigidly rotating polytrope of index 1: a spectral solution that has converged to 1e-11 (its source there)."""

import json
from pathlib import Path
from types import SimpleNamespace

TABLE = json.loads((Path(__file__).parent / "reference" / "rotating_polytropes.json").read_text())
SHEDDING = {"where": "mass shedding"}  # known to 1e-5


def exact_polytrope(**given) -> SimpleNamespace:
    """The body with this axis_ratio or rotation_parameter, or SHEDDING: names as of bodies.rotating_star."""
    inputs = {"n": 1, **given}
    (value,) = (row["value"] for row in TABLE if row["name"] == "n1_polytrope_spectral" and row["inputs"] == inputs)
    return SimpleNamespace(**value)
