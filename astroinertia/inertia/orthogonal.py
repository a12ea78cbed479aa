"""Whether a matrix turns, and does not stretch.

Tests: tests/unit/rotation/test_attitude.py, tests/unit/inertia/test_body.py.
"""

from typing import Any

import numpy as np

from astroinertia.process.known import is_known

_ROUNDINGS = 1e3  # of the numbers given, by which the products of columns may be off


def require_orthogonal(matrix: Any, within: float = 0.0, may_mirror: bool = True) -> None:
    """ValueError unless a matrix (..., 3, 3) is orthogonal and, unless it may, does not mirror; unseen inside jax.jit.

    within: by which the products of its columns may be off, at the least their roundings.

    >>> require_orthogonal(np.diag([1.0, 1.0, -1.0]))
    """
    if not is_known(matrix):
        return
    rows = np.asarray(matrix)  # JAX would trace what is computed here of a constant inside a jit
    rows = rows.astype(np.result_type(rows, np.float32), copy=False)
    within = max(within, _ROUNDINGS * float(np.finfo(rows.dtype).eps))
    if rows.shape[-2:] != (3, 3):
        raise ValueError(f"a rotation matrix must be orthogonal, and this one is not: it is a matrix {rows.shape}")
    with np.errstate(over="ignore", invalid="ignore"):
        orthogonal = (abs(np.swapaxes(rows, -1, -2) @ rows - np.eye(3)) < within).all()
    if not orthogonal:
        raise ValueError("a rotation matrix must be orthogonal, and this one is not")
    if not may_mirror and (np.linalg.det(rows) < 0).any():
        raise ValueError("a rotation matrix must not mirror, and this one does")
