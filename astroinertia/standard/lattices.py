"""Face-centred cubic lattices that fill boxes: particles close-packed, as a settled fluid of equal masses is."""

import numpy as np

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
    return tuple(int(step * max(1, round(length / (step * side)))) for length in lengths)  # type: ignore[return-value]


def centred(lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Low and high corner of a box around the origin."""
    half = 0.5 * np.asarray(lengths)
    return -half, half
