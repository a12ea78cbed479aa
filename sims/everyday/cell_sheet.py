"""A sheet of cells in two dimensions that want an area, a perimeter and an inertia tensor; they grow, crawl and divide.

    python sims/everyday/cell_sheet.py --cells 16 --elongation 2 --output cell_sheet.png

Every cell is a polygon. Its energy is that of its area and of its outline (Farhadifar et al. 2007, Current Biology 17,
2095), cells push each other where they touch (Boromand et al. 2018, Physical Review Letters 121, 248003), and the
target tensor of the toolbox asks for an elongation in whatever direction. Everything is overdamped: vertices follow the
gradient. A cell that has doubled is cut through its centre along its short axis (Hertwig's rule), which the tensor
tells.
"""

import argparse
from functools import partial
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from astroinertia.inertia import shapes
from astroinertia.inertia.principal import principal_frame
from astroinertia.inertia.target import target_energy
from astroinertia.inertia.tensor import second_moment_from_inertia
from astroinertia.plots import style

VERTICES = 32
AREA = 1.0  # of a new cell
OF_AREA, OF_OUTLINE, OF_BENDS, OF_TENSOR, OF_CONTACT = 40.0, 8.0, 1.5, 60.0, 300.0  # stiffnesses
REACH = 0.18  # how near vertices of different cells may come before they push
STEP, BETWEEN = 8e-4, 100  # of time, and steps between looks at who divides
GROWTH, CRAWL = 1.2, 0.3  # of the target area a time, and speed


def areas(cells: jax.Array) -> jax.Array:
    """Areas (C,) of polygons (C, V, 2)."""
    following = jnp.roll(cells, -1, axis=1)
    return 0.5 * jnp.sum(cells[..., 0] * following[..., 1] - cells[..., 1] * following[..., 0], axis=1)


def tensors(cells: jax.Array) -> jax.Array:
    """Second moments of area (C, 3, 3) about the centroids."""
    return second_moment_from_inertia(shapes.polygon_plate(areas(cells), cells).inertia)


def energies(cells: jax.Array, wanted: jax.Array, elongation: float) -> jax.Array:
    """The energy of the sheet, with target areas (C,), 0 for places without a cell, and the ratio of axes wanted."""
    alive, wanted = wanted > 0, jnp.where(wanted > 0, wanted, AREA)
    area = areas(cells)
    edges = jnp.roll(cells, -1, axis=1) - cells
    sides = jnp.linalg.norm(edges, axis=-1)
    side = _outline(elongation) * jnp.sqrt(wanted)[:, None] / VERTICES
    bends = jnp.sum((jnp.roll(edges, -1, axis=1) - edges) ** 2, axis=-1) / side**2
    outline = OF_OUTLINE * (sides / side - 1) ** 2 + OF_BENDS * bends
    of_shape = OF_AREA * (area / wanted - 1) ** 2 + jnp.mean(outline, axis=1)
    target = jnp.diag(jnp.array([elongation, 1 / elongation, 0.0]))
    of_tensor = target_energy(
        tensors(cells) / wanted[:, None, None] ** 2,
        target,
        OF_TENSOR,
        0.0,
        free_size=True,
        normal=jnp.array([0.0, 0, 1]),
    )
    return jnp.sum(jnp.where(alive, of_shape + of_tensor, 0.0)) + _contacts(cells)


def _outline(ratio: float) -> float:
    """The length of an ellipse of area 1 (Ramanujan's)."""
    a, b = np.sqrt(ratio / np.pi), np.sqrt(1 / (ratio * np.pi))
    h = ((a - b) / (a + b)) ** 2
    return np.pi * (a + b) * (1 + 3 * h / (10 + np.sqrt(4 - 3 * h)))


def _contacts(cells: jax.Array) -> jax.Array:
    points = cells.reshape(-1, 2)
    owner = jnp.arange(len(points)) // VERTICES
    square = jnp.sum((points[:, None] - points[None]) ** 2, axis=-1)
    near = (owner[:, None] != owner[None]) & (square < REACH**2)
    return 0.25 * OF_CONTACT * jnp.sum(jnp.where(near, REACH - jnp.sqrt(jnp.where(near, square, 1.0)), 0.0) ** 2)


@partial(jax.jit, static_argnums=4)
def moved(cells: jax.Array, wanted: jax.Array, ways: jax.Array, growth: float, elongation: float) -> tuple:
    """Cells and their target areas after BETWEEN steps, and the energy; ways (C, 2) is where each crawls."""

    def step(state: tuple, _: None) -> tuple:
        now, area = state
        energy, slope = jax.value_and_grad(energies)(now, area, elongation)
        return (now - STEP * slope + STEP * CRAWL * ways[:, None], area * (1 + STEP * growth)), energy

    (cells, wanted), energy = jax.lax.scan(step, (cells, wanted), length=BETWEEN)
    return cells, wanted, energy


def halves(cell: np.ndarray) -> np.ndarray:
    """A polygon (V, 2) cut along its short axis, as two (2, V, 2) with the centroid in the narrow gap between them."""
    plate = shapes.polygon_plate(1.0, cell)
    _, axes = principal_frame(plate.inertia)
    along = axes[0, :2]  # the least moment: the long axis
    side = (cell - plate.centre[:2]) @ along
    return np.stack([_resampled(_above(cell, sign * side - 0.25 * REACH)) for sign in (1.0, -1.0)])


def _above(cell: np.ndarray, side: np.ndarray) -> np.ndarray:
    corners = []
    for here, there, one, two in zip(cell, np.roll(cell, -1, 0), side, np.roll(side, -1), strict=True):
        if one >= 0:
            corners.append(here)
        if one * two < 0:
            corners.append(here + (there - here) * one / (one - two))
    return np.array(corners)


def _resampled(polygon: np.ndarray) -> np.ndarray:
    closed = np.concatenate([polygon, polygon[:1]])
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    at = np.linspace(0, length[-1], VERTICES, endpoint=False)
    return np.stack([np.interp(at, length, closed[:, k]) for k in range(2)], -1)


def grown(count: int, elongation: float, seed: int) -> tuple[list[np.ndarray], list[float]]:
    """Sheets from one cell to `count`, one at every division, the last at rest; and the energy as it comes to rest."""
    rng = np.random.default_rng(seed)
    angle = np.linspace(0, 2 * np.pi, VERTICES, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle)], -1) * np.sqrt(AREA / np.pi)
    places = 100.0 * np.arange(count)  # those without a cell yet are far from all others
    cells = circle + np.stack([places, 0 * places], -1)[:, None]
    cells = cells + 0.01 * rng.standard_normal(cells.shape)
    wanted, number, sheets = np.where(places == 0, AREA, 0.0), 1, []
    while number < count:
        way = rng.uniform(0, 2 * np.pi, count)
        ways = np.stack([np.cos(way), np.sin(way)], -1) * (wanted > 0)[:, None]
        cells, wanted, _ = map(np.array, moved(cells, wanted, ways, GROWTH, elongation))
        full = np.flatnonzero(wanted >= 2 * AREA * rng.uniform(0.9, 1.1, count))[: count - number]
        if full.size:
            sheets.append(cells[:number].copy())
        for mother in full:
            cells[mother], cells[number] = halves(cells[mother])
            wanted[mother] = wanted[number] = 0.5 * wanted[mother]
            number += 1
    energy: list[float] = []
    for _ in range(25):
        cells, wanted, now = map(np.asarray, moved(cells, wanted, np.zeros((count, 2)), 0.0, elongation))
        energy.extend(now)
    return [*sheets, cells], energy


def elongations(cells: np.ndarray) -> np.ndarray:
    """The ratio (C,) of the longer to the shorter semi-axis of every cell, from its second moments."""
    values = np.linalg.eigvalsh(np.asarray(tensors(jnp.asarray(cells)))[:, :2, :2])
    return np.sqrt(values[:, 1] / values[:, 0])


def picture(sheets: list[np.ndarray], energy: list[float], elongation: float) -> Figure:
    """The sheet at a few sizes, coloured by elongation, and the energy as the last comes to rest."""
    shown = [sheets[k] for k in np.unique(np.linspace(1, len(sheets) - 1, 3).astype(int))]
    with style.styled():
        figure = style.page(f"Cells that want an elongation of {elongation:g}", (11.0, 4.0))
        panels = figure.subplots(1, len(shown) + 1)
        reach = 1.1 * abs(shown[-1] - shown[-1].mean((0, 1))).max()
        for axes, cells in zip(panels, shown, strict=False):
            drawn = PolyCollection(cells - cells.mean((0, 1)), array=elongations(cells), cmap="viridis",
                                   edgecolor=style.INK, linewidth=0.8, clim=(1, 1.5 * elongation))  # fmt: skip
            axes.add_collection(drawn)
            axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", title=f"{len(cells)} cells")
            axes.axis("off")
        figure.colorbar(drawn, ax=panels[-2], location="bottom", label="elongation", shrink=0.8)
        panels[-1].semilogy(STEP * np.arange(len(energy)), energy, color=style.BLUE)
        panels[-1].set(xlabel="time without growth", ylabel="energy", title="Coming to rest")
        return figure


def main() -> None:
    """Grow the sheet, print what its cells have become, and save the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=16, help="at the end (default: 16)")
    parser.add_argument("--elongation", type=float, default=2.0, help="ratio of axes wanted (default: 2)")
    parser.add_argument("--seed", type=int, default=1, help="of crawling and dividing (default: 1)")
    parser.add_argument("--output", type=Path, help="a PNG to write")
    chosen = parser.parse_args()
    if not 2 <= chosen.cells <= 200 or not 1 <= chosen.elongation <= 4:
        parser.error("the cells must be between 2 and 200, and the elongation between 1 and 4")
    with jax.enable_x64(True):
        sheets, energy = grown(chosen.cells, chosen.elongation, chosen.seed)
        reached = elongations(sheets[-1])
        figure = picture(sheets, energy, chosen.elongation)
    print(
        f"{len(sheets[-1])} cells, elongation {reached.mean():.3f} +- {reached.std():.3f}, wanted {chosen.elongation:g}"
    )
    print(f"energy at rest {energy[-1]:.4f}, {np.sum(np.diff(energy) > 0)} steps of {len(energy)} went up")
    if chosen.output:
        print(f"picture: {style.save(figure, chosen.output)}")


if __name__ == "__main__":
    main()
