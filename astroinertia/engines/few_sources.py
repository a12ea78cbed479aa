"""What sums of few particles are given, put in rows and columns by numpy, which compiles nothing for it.

Tests: tests/unit/engines/test_numba_cpu.py, tests/unit/engines/test_templates.py.
"""

from collections.abc import Sequence

import numpy as np

from astroinertia.engines.numba_parts import LINE
from astroinertia.engines.numba_passes import AXES, Needs
from astroinertia.engines.numba_vectors import LANES


def sources_of(
    position: np.ndarray,
    mass: np.ndarray,
    smoothing_length: np.ndarray,
    names: Sequence[str] = (),
    arrays: Sequence[np.ndarray] = (),
) -> dict[str, np.ndarray]:
    """All that may be asked of particles by name, numbers (N,) and vectors (N, 3); names, arrays: what else."""
    return {"position": position, "mass": mass, "h": smoothing_length, **dict(zip(names, arrays, strict=True))}


def rows_of(names: Sequence[str], sources: dict[str, np.ndarray], support: float) -> np.ndarray:
    """The rows (K, M) of those names, M > N: massless copies of the last particle stand at the loose end.

    As vectors may go five times their width beyond the last source; rows do not all fall on the same lines of a cache.
    """
    count = len(sources["mass"])
    rows = _whole_lines(len(names), -(-count // LANES) * LANES + 5 * LANES | LANES)
    for row, name in zip(rows, names, strict=True):
        row[:count] = _row(name, sources, support)
    rows[:, count:] = rows[:, count - 1 : count]
    rows[list(names).index("mass"), count:] = 0.0
    return rows


def tables_of(needs: Needs, sources: dict[str, np.ndarray], support: float) -> tuple[np.ndarray, np.ndarray]:
    """Of a sum over neighbours: a line (N + 1, width) a particle, the last massless, and rows (8, M) to search.

    Those are the first four columns of the table and the four among which squared reaches are.
    """
    rows = rows_of(needs.table, sources, support)
    table = np.zeros((len(sources["mass"]) + 1, needs.width))
    table[:, : len(rows)] = rows[:, : len(table)].T
    search = _whole_lines(8, rows.shape[1])
    reaches = rows[needs.reaches : needs.reaches + 4]
    search[:4], search[4 : 4 + len(reaches)] = rows[:4], reaches
    return table, search


def _whole_lines(rows: int, columns: int) -> np.ndarray:
    """An array (rows, columns) that begins on a line of the cache: no vector straddles two."""
    flat = np.zeros(rows * columns + LINE // 8)
    first = -flat.ctypes.data % LINE // 8
    return flat[first : first + rows * columns].reshape(rows, columns)


def _row(name: str, sources: dict[str, np.ndarray], support: float) -> np.ndarray:
    if name in AXES:
        return sources["position"][:, AXES.index(name)]
    if name == "inverse_h":
        return 1.0 / sources["h"]
    if name == "reach2":
        return (support * sources["h"]) * (support * sources["h"])
    if name.startswith("vector_"):
        vector, _, axis = name.rpartition("_")
        return sources[vector][:, AXES.index(axis)]
    return sources[name]
