"""Volume, mass, centre and inertia of closed meshes: this package against trimesh, in one run.

    python tests/benchmarks/mesh_inertia.py --subdivisions 3 5 7

An ellipsoid of 20 * 4^n facets, some way from the origin. Both start from plain arrays of vertices and faces; trimesh
neither merges nor mends them. The table is printed and written to tests/benchmarks/results/. Times are processor
times with one thread (OPENBLAS_NUM_THREADS=1), the best of several repeats. The check that the mesh is closed is timed
by itself: trimesh does it on request, `mesh_body` always. Errors are against the mesh's tensor in extended precision.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from astroinertia.inertia.mesh import check_closed, icosphere, mesh_body

RESULTS = Path(__file__).parent / "results"
SEMI_AXES, PLACE = np.array([1.0, 1.4, 0.6]), np.array([30.0, -20.0, 10.0])


def best_time(function: Callable[[], Any], repeats: int) -> float:
    """Shortest processor time of a call, which other work on the machine does not count into."""
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        function()
        times.append(time.process_time() - begin)
    return min(times)


def by_trimesh(vertices: np.ndarray, faces: np.ndarray) -> tuple[float, np.ndarray]:
    """Mass and inertia tensor for a density of 1."""
    mesh = trimesh.Trimesh(vertices, faces, process=False, validate=False)
    properties = mesh.mass_properties
    return properties["mass"], properties["inertia"]


def by_trimesh_checked(vertices: np.ndarray, faces: np.ndarray) -> tuple[float, np.ndarray]:
    """The same, where the mesh is closed and wound alike."""
    mesh = trimesh.Trimesh(vertices, faces, process=False, validate=False)
    if not mesh.is_volume:
        raise ValueError("not closed")
    return mesh.mass_properties["mass"], mesh.mass_properties["inertia"]


def ours(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same by this package."""
    body = mesh_body(vertices, faces, density=1.0)
    return body.mass, body.inertia


def extended(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Inertia tensor of the mesh for a density of 1, summed in long double."""
    a, b, c = (vertices.astype(np.longdouble)[faces[:, k]] - PLACE for k in range(3))
    six_volumes = (a * np.cross(b, c)).sum(1)
    total = a + b + c
    second = sum(np.einsum("f,fi,fj->ij", six_volumes, each, each) for each in (a, b, c, total)) / 120
    centre = six_volumes @ total / 24 / (six_volumes.sum() / 6)
    second = second - np.outer(centre, centre) * six_volumes.sum() / 6
    return (np.trace(second) * np.eye(3) - second).astype(float)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--subdivisions", nargs="+", type=int, default=[3, 5, 7])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--no-file", action="store_true", help="print the table only")
    chosen = parser.parse_args()
    lines = [
        f"# Inertia of meshes, against trimesh {trimesh.__version__}, one thread: processor time in ms",
        "",
        "| facets | ours, checked | of it the check | trimesh, unchecked | trimesh, checked | trimesh/ours, checked "
        "| error, ours | error, trimesh |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for level in chosen.subdivisions:
        vertices, faces = icosphere(level)
        vertices = vertices * SEMI_AXES + PLACE
        exact = extended(vertices, faces)
        mine, check, plain, theirs = (
            1e3 * best_time(function, chosen.repeats)
            for function in (
                lambda v=vertices, f=faces: ours(v, f),
                lambda v=vertices, f=faces: check_closed(f, len(v)),
                lambda v=vertices, f=faces: by_trimesh(v, f),
                lambda v=vertices, f=faces: by_trimesh_checked(v, f),
            )
        )
        errors = [abs(each(vertices, faces)[1] - exact).max() / abs(exact).max() for each in (ours, by_trimesh)]
        lines.append(
            f"| {len(faces)} | {mine:.3g} | {check:.3g} | {plain:.3g} | {theirs:.3g} | {theirs / mine:.2g} "
            f"| {errors[0]:.1e} | {errors[1]:.1e} |"
        )
    table = "\n".join(lines) + "\n"
    print(table)
    if not chosen.no_file:
        (RESULTS / "mesh_inertia.md").write_text(table)


if __name__ == "__main__":
    main()
