"""Inertia tensors of many snapshots of particles: this package against plain NumPy, in memory and from a file.

    python tests/benchmarks/inertia_tensors.py --snapshots 200
    python tests/benchmarks/inertia_tensors.py --snapshots 10000 --no-memory    # 10,000 snapshots of 1e5 particles

In memory, all start from the same arrays. From the file, NumPy reads one snapshot after the other, as a careful script
would, and `moments_series` streams. The file holds a body that turns like a rigid one, so that its principal moments
are known; as a pattern of particles that repeats itself, it packs into little room, but is unpacked and read in full.
The table is printed and written to tests/benchmarks/results/. Times are wall times, the best of several repeats in
memory and of one from the file. For meshes against trimesh see mesh_inertia.py.
"""

import argparse
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from astroinertia.costs.machine import peak_memory
from astroinertia.engines.threads import available_threads
from astroinertia.inertia import tensor
from astroinertia.studies.moments_series import moments_series

RESULTS = Path(__file__).parent / "results"
PATTERN = 1000  # particles after which they repeat: within the 32 kB that zlib looks back
IN_MEMORY = 20  # snapshots


def plain_numpy(mass: np.ndarray, position: np.ndarray) -> np.ndarray:
    """The tensor (3, 3) about the centre of mass as one writes it by hand: matrix products, one snapshot."""
    relative = position - mass @ position / mass.sum()
    second = (mass[:, None] * relative).T @ relative
    return np.trace(second) * np.eye(3) - second


def by_einsum(mass: np.ndarray, position: np.ndarray) -> np.ndarray:
    """The same from the textbook's formula with one call of einsum for each term."""
    relative = position - np.average(position, axis=0, weights=mass)
    squared = np.einsum("n,ni,ni->", mass, relative, relative)
    return squared * np.eye(3) - np.einsum("n,ni,nj->ij", mass, relative, relative)


def best_time(function: Callable[[], Any], repeats: int) -> float:
    """Shortest time of a call, after one that compiles."""
    function()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        function()
        times.append(time.perf_counter() - begin)
    return min(times)


def body(particles: int) -> np.ndarray:
    """A pattern of points (PATTERN, 3) of three unequal axes, repeated to (particles, 3)."""
    pattern = np.random.default_rng(1).normal(size=(min(PATTERN, particles), 3)) * [3.0, 2.0, 1.0]
    return np.resize(pattern, (particles, 3))


def turned(points: np.ndarray, angle: float) -> np.ndarray:
    """Points (N, 3) turned about z."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return points @ np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]])


def write_file(path: Path, snapshots: int, particles: int) -> np.ndarray:
    """A turning body, one chunk a snapshot; the principal moments (3,) that it has throughout."""
    points, mass = body(particles), np.full(particles, 1.0 / particles)
    with netCDF4.Dataset(path, "w") as file:
        for name, size in (("snapshot_time", snapshots), ("particle", particles), ("i", 3)):
            file.createDimension(name, size)
        file.createVariable("mass", "f8", ("particle",))[:] = mass
        position = file.createVariable(
            "position", "f8", ("snapshot_time", "particle", "i"), zlib=True, complevel=1, chunksizes=(1, particles, 3)
        )
        for index in range(snapshots):
            position[index] = np.resize(turned(points[:PATTERN], 0.01 * index), (particles, 3))
    return np.linalg.eigvalsh(plain_numpy(mass, points))


def in_memory(particles: int, repeats: int) -> list[tuple[str, float]]:
    """Names and seconds a snapshot."""
    position = np.stack([turned(body(particles), 0.01 * index) for index in range(IN_MEMORY)])
    mass = np.full((IN_MEMORY, particles), 1.0 / particles)
    given = xr.Dataset(
        {"position": (("snapshot_time", "particle", "i"), position), "mass": (("snapshot_time", "particle"), mass)}
    )
    ways = {
        "NumPy, einsum": lambda: [by_einsum(*one) for one in zip(mass, position, strict=True)],
        "NumPy, matrix products": lambda: [plain_numpy(*one) for one in zip(mass, position, strict=True)],
        "tensor.inertia_tensor": lambda: [tensor.inertia_tensor(*one) for one in zip(mass, position, strict=True)],
        "moments_series": lambda: moments_series(given),
    }
    return [(name, best_time(way, repeats) / IN_MEMORY) for name, way in ways.items()]


def from_file(path: Path, known: np.ndarray, with_numpy: bool) -> tuple[list[tuple[str, float]], float, float]:
    """Names and seconds in all; the growth of the peak memory while streaming; the worst error of a moment."""
    with xr.open_dataset(path) as opened:
        moments_series(opened.isel(snapshot_time=slice(2)))  # compiles
        before, begin = peak_memory(), time.perf_counter()
        found = moments_series(opened)
        rows = [("moments_series, streamed", time.perf_counter() - begin)]
        grown = peak_memory() - before
    error = float(abs(found["principal_moments"].values / known - 1.0).max())
    if with_numpy:
        begin = time.perf_counter()
        with netCDF4.Dataset(path) as file:
            mass, position = np.asarray(file["mass"][:]), file["position"]
            tensors = [plain_numpy(mass, np.asarray(position[index])) for index in range(position.shape[0])]
        np.linalg.eigh(np.stack(tensors))
        rows.insert(0, ("netCDF4 and NumPy, one snapshot after the other", time.perf_counter() - begin))
    return rows, grown, error


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--snapshots", type=int, default=200, help="in the file")
    parser.add_argument("--particles", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--folder", type=Path, help="where the file is kept meanwhile")
    parser.add_argument("--no-memory", action="store_true", help="leave out the comparison in memory")
    parser.add_argument("--no-numpy", action="store_true", help="stream the file only")
    parser.add_argument("--no-file", action="store_true", help="print the table only")
    chosen = parser.parse_args()
    load = f"{os.getloadavg()[0]:.1f}"
    lines = [f"# Inertia tensors of particles, x86-64, {available_threads()} cores, load {load}, wall time", ""]
    if not chosen.no_memory:
        rows = in_memory(chosen.particles, chosen.repeats)
        lines += [f"| {IN_MEMORY} snapshots of {chosen.particles} particles, in memory | ms a snapshot "
                  "| times as fast as NumPy |", "|---|---|---|"]  # fmt: skip
        reference = dict(rows)["NumPy, matrix products"]
        lines += [f"| {name} | {1e3 * seconds:.3g} | {reference / seconds:.2g} |" for name, seconds in rows] + [""]
    with tempfile.TemporaryDirectory(dir=chosen.folder) as folder:
        path = Path(folder) / "snapshots.nc"
        known = write_file(path, chosen.snapshots, chosen.particles)
        packed, size = path.stat().st_size, 24.0 * chosen.snapshots * chosen.particles
        rows, grown, error = from_file(path, known, not chosen.no_numpy)
    lines += [f"| {chosen.snapshots} snapshots of {chosen.particles} particles, {size / 1e9:.3g} GB unpacked, "
              f"{packed / 1e9:.2g} GB on disk | s | million particles/s |", "|---|---|---|"]  # fmt: skip
    count = chosen.snapshots * chosen.particles
    lines += [f"| {name} | {seconds:.3g} | {count / seconds / 1e6:.3g} |" for name, seconds in rows] + [""]
    lines.append(f"Streaming, the peak of the memory rose by {grown / 1e6:.0f} MB; moments are right to {error:.1e}.")
    text = "\n".join(lines) + "\n"
    print(text)
    if not chosen.no_file:
        RESULTS.mkdir(exist_ok=True)
        (RESULTS / f"inertia_tensors_{chosen.snapshots}.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
