"""What particles stand for, on a grid: density on a plane, column density along a line of sight, and the flow."""

import numpy as np
from numba import njit

from astroinertia.sph.kernels import KERNELS

FEWEST = 8  # particles around a point that a velocity is fitted to
BEYOND = 1.0  # spreads of their velocities from the mean
KERNEL = KERNELS["cubic"]
_WIDE = 32.0  # pixels from which on a column is as good as its integral
_SUMS = {"reassoc", "contract", "nsz"}  # sums in any order, several numbers at a time
_kernel = njit(KERNEL.w)


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
    Tests: tests/unit/plots/test_render.py.
    """
    centres, size, u, v, w = _seen(position, smoothing_length, plane, reach, pixels)
    near = abs(w) < KERNEL.support * size
    image = np.zeros((pixels, pixels))
    u, v, w, size, mass = (np.ascontiguousarray(array[near]) for array in (u, v, w, size, mass))
    _add_slice(u, v, w, size, mass, KERNEL.support, centres, image)
    return image


def column_density(
    position: np.ndarray,
    mass: np.ndarray,
    smoothing_length: np.ndarray,
    plane: tuple[int, int],
    reach: float,
    pixels: int,
) -> np.ndarray:
    """Mass per area along the line of sight onto a plane, (pixels, pixels), second axis first.

    Arguments as for `density_slice`. A particle's mass is shared out over the pixels that its column reaches, inside
    the picture or not, in proportion to the column through its kernel at their centres: so the sum over all pixels is
    the mass of what is seen, to rounding, at any resolution. Tests: tests/unit/plots/test_render.py.
    """
    centres, size, u, v, _ = _seen(position, smoothing_length, plane, reach, pixels)
    image = np.zeros((pixels, pixels))
    u, v, size, mass = (np.ascontiguousarray(array) for array in (u, v, size, mass))
    _add_columns(u, v, size, mass, KERNEL.support, centres, image)
    return image


def _seen(position, smoothing_length, plane, reach, pixels):
    width = 2.0 * reach / pixels
    centres = (np.arange(pixels) + 0.5) * width - reach
    depth = ({0, 1, 2} - set(plane)).pop()
    size = np.maximum(smoothing_length, width)
    return centres, size, position[:, plane[0]], position[:, plane[1]], position[:, depth]


@njit(cache=True, error_model="numpy")
def _covered(low, high, begin, width):
    """First and last number of the pixels whose centres lie between two places; the picture may end before."""
    return int(np.ceil((low - begin) / width)), int(np.floor((high - begin) / width))


@njit(cache=True, error_model="numpy")
def _add_slice(u, v, w, size, mass, support, centres, image):
    count, width = centres.size, centres[1] - centres[0]
    for k in range(u.size):
        h, radius = size[k], support * size[k]
        low, high = _covered(v[k] - radius, v[k] + radius, centres[0], width)
        for row in range(max(low, 0), min(high, count - 1) + 1):
            beside = (centres[row] - v[k]) ** 2 + w[k] ** 2
            if beside >= radius**2:
                continue
            chord = np.sqrt(radius**2 - beside)
            left, right = _covered(u[k] - chord, u[k] + chord, centres[0], width)
            left, right = max(left, 0), max(min(right, count - 1) + 1, 0)
            places, line, weight = centres[left:right], image[row, left:right], mass[k] / h**3
            for column in range(np.uint64(line.size)):  # an unsigned number, and parts of arrays: several at a time
                line[column] += weight * _kernel(np, np.sqrt((places[column] - u[k]) ** 2 + beside) / h)


@njit(cache=True, error_model="numpy")
def _add_columns(u, v, size, mass, support, centres, image):
    count, width = centres.size, centres[1] - centres[0]
    for k in range(u.size):
        radius = support * size[k]
        left, right = _covered(u[k] - radius, u[k] + radius, centres[0], width)
        low, high = _covered(v[k] - radius, v[k] + radius, centres[0], width)
        if right < 0 or left >= count or high < 0 or low >= count:
            continue
        # The particle's middle is at 0 from here on, and lengths are in its radius.
        x, y, step = (centres[0] - u[k]) / radius, (centres[0] - v[k]) / radius, width / radius
        inside = left >= 0 and right < count and low >= 0 and high < count
        if inside or radius < _WIDE * width:
            total = 0.0
            for row in range(low, high + 1):
                depth = 1.0 - (y + row * step) ** 2
                first, last = _across(x, step, depth)
                total += _row_of_columns(last - first + 1, x + first * step, step, depth)
        else:
            total = (size[k] / width) ** 2  # the sum over pixels far outside that nobody sees is its integral
        share = mass[k] / (total * width**2)
        for row in range(max(low, 0), min(high, count - 1) + 1):
            depth = 1.0 - (y + row * step) ** 2
            first, last = _across(x, step, depth)
            first, last = max(first, 0), max(min(last, count - 1) + 1, 0)
            _add_row_of_columns(image[row, first:last], x + first * step, step, depth, share)


@njit(cache=True, error_model="numpy")
def _across(x, step, depth):
    """First and last number of the pixels of a row whose centres a particle reaches, as `_column` has its t there."""
    chord = np.sqrt(max(depth, 0.0))
    return _covered(-chord, chord, x, step)


@njit(cache=True, error_model="numpy", fastmath=_SUMS)
def _row_of_columns(count, x, step, depth):
    total = 0.0
    for column in range(count):
        total += _column(depth - (x + column * step) ** 2)
    return total


@njit(cache=True, error_model="numpy", fastmath=_SUMS)
def _add_row_of_columns(line, x, step, depth, share):
    for column in range(np.uint64(line.size)):  # an unsigned number: several at a time
        line[column] += share * _column(depth - (x + np.int64(column) * step) ** 2)


@njit(cache=True, error_model="numpy", fastmath=_SUMS)
def _column(t):
    """The integral of the cubic spline along a line, times h^2, at t = 1 - (q/2)^2, q h being its distance.

    The spline's outer piece, of which the column falls as t^(7/2) to its edge, and what the inner one adds. Polynomials
    by least squares, within 5e-5 of the integral; what they get wrong is shared out with the mass.
    """
    outer = max(t, 0.0)
    inner = max(4.0 * t - 3.0, 0.0)  # 1 - q^2
    rest = 0.13986266 + outer * (-0.41051405 + outer * (1.1355323 + outer * (-1.3612643 + outer * 0.72656946)))
    rest = 0.1455112 + outer * (0.097336376 + outer * (0.057094273 + outer * rest))
    more = 0.19991956 + inner * (-0.22833504 + inner * 0.089272767)
    more = -0.049321925 + inner * (-0.064219796 + inner * more)
    return outer**3 * np.sqrt(outer) * rest + inner**4 * more


def flow(
    position: np.ndarray, velocity: np.ndarray, mass: np.ndarray, smoothing_length: np.ndarray,
    plane: tuple[int, int], reach: float, cells: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Cell centres (cells,) and the in-plane velocity there, two of (cells, cells), NaN where no matter tells it.

    A weighted linear fit to the particles around each point: exact for a rigid rotation or a homologous collapse,
    however the particles lie (moving least squares; Lancaster & Salkauskas 1981, Mathematics of Computation 37, 141).
    What it says far beyond the velocities of these particles, as it may where they all lie on one side, is left out.
    """
    width = 2.0 * reach / cells
    centres = (np.arange(cells) + 0.5) * width - reach
    depth = ({0, 1, 2} - set(plane)).pop()
    size = np.maximum(smoothing_length, 0.5 * width)
    near = np.flatnonzero(abs(position[:, depth]) < 2 * size)
    in_plane = np.full((2, cells, cells), np.nan)
    for row, y in enumerate(centres):
        strip = near[abs(position[near, plane[1]] - y) < 2 * size[near]]
        for column, x in enumerate(centres):
            point = np.zeros(3)
            point[plane[0]], point[plane[1]] = x, y
            offset = (position[strip] - point) / size[strip, None]
            weight = mass[strip] / size[strip] ** 3 * KERNEL.w(np, np.linalg.norm(offset, axis=1))
            inside = weight > 0
            if inside.sum() < FEWEST:
                continue
            root = np.sqrt(weight[inside])[:, None]
            basis = np.column_stack([np.ones(inside.sum()), offset[inside] * size[strip][inside, None] / width])
            moved = velocity[strip][inside][:, plane]
            fit = np.linalg.lstsq(root * basis, root * moved, rcond=1e-3)[0]
            round_off = 1e-9 * abs(moved).max()  # where all move alike, that is all by which they differ
            if (abs(fit[0] - moved.mean(axis=0)) <= BEYOND * np.ptp(moved, axis=0) + round_off).all():
                in_plane[:, row, column] = fit[0]
    return centres, in_plane[0], in_plane[1]
