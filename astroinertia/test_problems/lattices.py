"""Face-centred cubic lattices that fill boxes: particles close-packed, as a settled fluid of equal masses is."""

import math

import numpy as np

from astroinertia.errors import SceneError

MOST_OVER = 8.0  # times the number of particles that was asked for, or the fewest that a body has
FEWEST = 16.0
BASIS = np.array([[0.25, 0.25, 0.25], [0.75, 0.75, 0.25], [0.75, 0.25, 0.75], [0.25, 0.75, 0.75]])  # of a unit cell


def filled(cells: tuple[int, int, int], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Positions (4 n_x n_y n_z, 3) of a lattice with so many unit cells from one corner of a box to the other."""
    corners = np.stack(np.meshgrid(*(np.arange(n) for n in cells), indexing="ij"), axis=-1).reshape(-1, 1, 3)
    fractions = (corners + BASIS).reshape(-1, 3) / np.array(cells)
    return low + fractions * (np.asarray(high) - low)


def cells_for(count: float, lengths: np.ndarray, even: bool = False) -> tuple[int, int, int]:
    """Unit cells along each side of a box, as near to cubes as it allows, that hold about so many particles."""
    side = (np.prod(lengths) * 4.0 / count) ** (1 / 3)
    step = 2 if even else 1
    cells = tuple(int(step * max(1, round(length / (step * side)))) for length in lengths)
    # A side shorter than a cell has one all the same, and with it many more particles than were asked for.
    if 4 * math.prod(cells) > MOST_OVER * max(count, FEWEST):
        raise SceneError(
            f"a box of {' by '.join(f'{length:.3g}' for length in lengths)} is too flat for a lattice of about "
            f"{count:.0f} particles: it would have {4 * math.prod(cells):.3g}; make its sides more alike, or ask for "
            "more particles."
        )
    return cells  # type: ignore[return-value]


def in_box(position: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Where particles (N, 3), or their images, lie in a box around the origin that repeats itself."""
    return position - lengths * np.round(position / lengths)


def centred(lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Low and high corner of a box around the origin."""
    half = 0.5 * np.asarray(lengths)
    return -half, half
