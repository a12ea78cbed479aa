"""Slices through particles: the density and velocity that the particles stand for, on a grid."""

import numpy as np

FEWEST = 8  # particles around a point that a velocity is fitted to


def density_slice(
    position: np.ndarray,
    mass: np.ndarray,
    smoothing_length: np.ndarray,
    plane: tuple[int, int],
    reach: float,
    pixels: int,
) -> np.ndarray:
    """Density on the plane through the origin spanned by two axes, (pixels, pixels), second axis first.

    position (N, 3) relative to the middle of the picture, mass (N,), smoothing_length (N,); `reach` is half the width.
    sum_j m_j W(|x - x_j|, h_j) with the cubic spline (Monaghan 1992, ARA&A 30, 543), h_j at least the width of a pixel.
    """
    width = 2.0 * reach / pixels
    centres = (np.arange(pixels) + 0.5) * width - reach
    depth = ({0, 1, 2} - set(plane)).pop()
    size = np.maximum(smoothing_length, width)
    u, v, w = position[:, plane[0]], position[:, plane[1]], position[:, depth]
    near = (abs(w) < 2 * size) & (abs(u) < reach + 2 * size) & (abs(v) < reach + 2 * size)
    density = np.zeros((pixels, pixels))
    for x, y, z, h, m in zip(u[near], v[near], w[near], size[near], mass[near], strict=True):
        columns = slice(*np.searchsorted(centres, (x - 2 * h, x + 2 * h)))
        rows = slice(*np.searchsorted(centres, (y - 2 * h, y + 2 * h)))
        squared = (centres[columns] - x) ** 2 + ((centres[rows] - y) ** 2)[:, None] + z * z
        density[rows, columns] += m / h**3 * _cubic_spline(np.sqrt(squared) / h)
    return density


def flow(
    position: np.ndarray, velocity: np.ndarray, mass: np.ndarray, smoothing_length: np.ndarray,
    plane: tuple[int, int], reach: float, cells: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Cell centres (cells,) and the in-plane velocity there, two of (cells, cells), NaN where there is no matter.

    A weighted linear fit to the particles around each point: exact for a rigid rotation or a homologous collapse,
    however the particles lie (moving least squares; Lancaster & Salkauskas 1981, Mathematics of Computation 37, 141).
    """
    width = 2.0 * reach / cells
    centres = (np.arange(cells) + 0.5) * width - reach
    depth = ({0, 1, 2} - set(plane)).pop()
    size = np.maximum(smoothing_length, 0.5 * width)
    near = np.flatnonzero(abs(position[:, depth]) < 2 * size)
    found = np.full((2, cells, cells), np.nan)
    for row, y in enumerate(centres):
        strip = near[abs(position[near, plane[1]] - y) < 2 * size[near]]
        for column, x in enumerate(centres):
            point = np.zeros(3)
            point[plane[0]], point[plane[1]] = x, y
            offset = (position[strip] - point) / size[strip, None]
            weight = mass[strip] / size[strip] ** 3 * _cubic_spline(np.linalg.norm(offset, axis=1))
            inside = weight > 0
            if inside.sum() < FEWEST:
                continue
            root = np.sqrt(weight[inside])[:, None]
            basis = np.column_stack([np.ones(inside.sum()), offset[inside] * size[strip][inside, None] / width])
            fit = np.linalg.lstsq(root * basis, root * velocity[strip][inside][:, plane], rcond=1e-3)[0]
            found[:, row, column] = fit[0]
    return centres, found[0], found[1]


def _cubic_spline(q: np.ndarray) -> np.ndarray:
    return (np.maximum(2 - q, 0.0) ** 3 - 4 * np.maximum(1 - q, 0.0) ** 3) / (4 * np.pi)
