"""Mass, centre and inertia of closed triangular meshes, exactly, by the divergence theorem.

A mesh is vertices (..., V, 3) in any consistent units and faces (F, 3): for each triangle the numbers of its corners,
anticlockwise as seen from outside. The surface of a cavity is seen from the cavity, so inside out; any other separate
part that is inside out counts as negative too, which shows only if the whole does. Leading axes of the vertices are a
batch of bodies with the same faces.
"""

from pathlib import Path
from typing import Any

import numpy as np

from astroinertia.errors import ArchiveError
from astroinertia.inertia.body import Body
from astroinertia.inertia.mean_squares import checked_points
from astroinertia.inertia.mesh_files import READERS, size_of_binary_stl
from astroinertia.inertia.tensor import inertia_from_second_moment
from astroinertia.process.known import is_known
from astroinertia.process.quantities import with_quantities
from astroinertia.storage.atomic import regular
from astroinertia.storage.bounded import plain_text

Array = Any

FORMATS = (".stl", ".obj", ".ply", ".off")
MAX_BYTES = 2**28  # of a file: 5 million triangles
_MOST_SUBDIVISIONS = 10  # of an icosphere: 21 million faces
_ROUNDINGS = 8.0  # roundings of the box around a mesh that its volume must exceed to differ from 0


@with_quantities()
def mesh_body(vertices: Array, faces: Array, mass: Array | None = None, density: Array | None = None) -> Body:
    """The homogeneous Body inside a closed mesh, of a given mass (...,) or density (...,), in the vertices' frame.

    The integrals over the volume are sums over tetrahedra from an inner reference point to each face (Mirtich 1996, J.
    Graphics Tools 1, 31, gives the same by the divergence theorem; Eberly 2002, Polyhedral Mass Properties): exact for
    the polyhedron, and without loss of digits far from the origin. Against a smooth body that the vertices lie on, the
    error falls as the square of the facets' size. Differentiable in jax by vertices, mass and density.
    Errors: ValueError where the mesh is open, its faces disagree on inside and outside or are inside out, or where not
    just one of mass and density is given. Checked by tests/unit/inertia/test_mesh.py.

    >>> body = mesh_body(*icosphere(4), mass=5.0)
    >>> print(body.inertia[2, 2].round(2))  # nearly a ball: (2/5) M R^2
    2.0
    """
    if (mass is None) == (density is None):
        raise ValueError("give either the mass or the density of a mesh")
    xp, amount, points = checked_points(
        density if mass is None else mass, vertices, (None, 3), "the vertices of a mesh"
    )
    faces = check_closed(faces, points.shape[-2])
    named = np.zeros(points.shape[-2], bool)
    named[faces] = True
    if not named.all():  # what no face names is no part of the body
        points, faces = points[..., named, :], (np.cumsum(named) - 1)[faces]
    with np.errstate(over="ignore", invalid="ignore"):  # what is too large is found as not finite
        reference, volume, shift, second = _volume_means(xp, points, faces)
        own = second - shift[..., :, None] * shift[..., None, :]
        shape = xp.broadcast_shapes(amount.shape, volume.shape)
        total = xp.broadcast_to(amount * volume if mass is None else amount, shape)
        centre = xp.broadcast_to(reference + shift, (*shape, 3))
        return Body(total, centre, total[..., None, None] * inertia_from_second_moment(own))


@with_quantities()
def mesh_volume(vertices: Array, faces: Array) -> Array:
    """The volume (...,) inside a closed mesh; errors as for `mesh_body`. Checked by tests/unit/inertia/test_mesh.py.

    >>> print(f"{mesh_volume(*icosphere(4)) / (4 / 3 * np.pi):.4f}")  # of 5120 faces
    0.9978
    """
    return mesh_body(vertices, faces, density=1.0).mass


@with_quantities()
def check_closed(faces: Array, vertices: int) -> np.ndarray:
    """The faces (F, 3) as an array of numbers, or a ValueError with one sentence on why they enclose no volume.

    Each edge must be walked as often one way as the other. vertices: how many there are.
    Checked by tests/unit/inertia/test_mesh.py.

    >>> try:
    ...     check_closed(np.array([[0, 1, 2]]), 3)
    ... except ValueError as error:
    ...     print(error)
    the mesh is not closed: the edge between vertices 0 and 1 belongs to one face only
    """
    faces = np.asarray(faces)
    if faces.ndim != 2 or faces.shape[1] != 3 or not len(faces) or faces.dtype.kind not in "iu":
        raise ValueError(f"faces must be whole numbers of shape (F, 3), not {faces.dtype} of shape {faces.shape}")
    if faces.min() < 0 or faces.max() >= vertices:
        raise ValueError(f"faces name vertices {faces.min()} to {faces.max()}, but there are {vertices}")
    start = faces.astype(np.int64)
    end = np.roll(start, -1, axis=1)
    edges = (np.minimum(start, end) * vertices + np.maximum(start, end)).ravel()
    order = np.argsort(edges, kind="stable")
    edges, ways = edges[order], np.sign(end - start).ravel()[order]
    first = np.flatnonzero(np.diff(edges, prepend=-1))
    balance = np.add.reduceat(ways, first)
    if balance.any():
        at = int(np.flatnonzero(balance)[0])
        low, high = divmod(int(edges[first[at]]), vertices)
        count = int(np.append(first, len(edges))[at + 1] - first[at])
        if count % 2:
            owners = "one face only" if count == 1 else f"{count} faces, an odd number"
            raise ValueError(f"the mesh is not closed: the edge between vertices {low} and {high} belongs to {owners}")
        raise ValueError(
            f"the faces are not wound alike: those that share the edge between vertices {low} and {high} "
            "disagree on which side is inside"
        )
    return faces


@with_quantities()
def icosphere(subdivisions: int, radius: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 3) on a sphere about the origin and faces (F, 3): an icosahedron, each face cut in 4 so many times.

    F = 20 * 4^subdivisions, V = F/2 + 2. Checked by tests/unit/inertia/test_mesh.py.

    >>> print([array.shape for array in icosphere(2)])  # 20 faces cut in 4 twice
    [(162, 3), (320, 3)]
    """
    if not 0 <= subdivisions <= _MOST_SUBDIVISIONS or subdivisions % 1 != 0:
        raise ValueError(f"subdivisions must be a whole number from 0 to {_MOST_SUBDIVISIONS}, not {subdivisions}")
    golden = (1 + np.sqrt(5)) / 2
    signs = [(one, two) for one in (-1, 1) for two in (-golden, golden)]
    vertices = np.array(
        [np.roll((0.0, one, two), turn) for turn in range(3) for one, two in signs]
    )  # three golden rectangles
    distances = np.linalg.norm(vertices[:, None] - vertices[None], axis=-1)
    near = np.isclose(distances, 2.0)
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] & near[j, k] & near[k, i]
    ]
    faces = np.array([f if np.linalg.det(vertices[list(f)]) > 0 else f[::-1] for f in faces])
    for _ in range(int(subdivisions)):
        vertices, faces = _quartered(vertices, faces)
    return radius * vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces


@with_quantities()
def read_mesh(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 3) and faces (F, 3) of a file in STL, OBJ, PLY or OFF; its units are kept.

    Vertices at the very same place are one afterwards, as closed meshes need and STL does not store. An ArchiveError
    says what is wrong with a file. Checked by tests/unit/inertia/test_mesh_files.py.

    >>> import os, tempfile
    >>> lines = ["OFF", "4 4 0", "0 0 0", "1 0 0", "0 1 0", "0 0 1", "3 0 2 1", "3 0 1 3", "3 0 3 2", "3 1 2 3"]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "corner.off")
    ...     _ = path.write_text(os.linesep.join(lines))
    ...     print(f"{mesh_volume(*read_mesh(path)):.6f}")  # a tetrahedron: 1/6
    0.166667
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise ArchiveError(
            f"{path} cannot be read as a mesh: it must be a {', '.join(FORMATS[:-1])} or {FORMATS[-1]} file"
        )
    content = _content(path)
    try:
        vertices, faces = READERS[path.suffix.lower()](content)
    except Exception as failure:  # what is wrong with a file shows in many ways
        raise ArchiveError(f"{path} cannot be read as a mesh: {plain_text(failure)}") from failure
    if not len(faces):
        raise ArchiveError(f"{path} cannot be read as a mesh: it has no faces")
    if faces.ndim != 2 or vertices.shape[1:] != (3,) or faces.min() < 0 or faces.max() >= len(vertices):
        raise ArchiveError(f"{path} cannot be read as a mesh: a face has a corner that is not there")
    places, numbers = _distinct(vertices + 0.0)  # + 0.0: -0 and 0 are one place
    return places, numbers[faces]


def _content(path: Path) -> bytes:
    """The bytes of a file of a mesh; ArchiveError where they are too many, or none of any mesh."""
    try:
        regular(path)
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise ArchiveError(f"{path} is larger than {MAX_BYTES >> 20} MiB, more than any mesh that is read")
        content = path.read_bytes()
    except OSError as failure:
        raise ArchiveError(f"{path} cannot be read as a mesh: {failure.strerror or failure}") from failure
    # A file of holes, or of anything else that is no text, would be searched for numbers for minutes.
    if not _is_binary(path.suffix.lower(), content) and b"\0" in content:
        why = "it is neither binary nor text as such files are"
        if path.suffix.lower() == ".stl":
            facets, expected = size_of_binary_stl(content)
            why = f"as binary STL its {facets} facets take {expected} bytes, and it has {size}"
        raise ArchiveError(f"{path} cannot be read as a mesh: {why}")
    return content


def _is_binary(suffix: str, content: bytes) -> bool:
    if suffix == ".stl":
        return size_of_binary_stl(content)[1] == len(content)
    return suffix == ".ply" and b"format binary_" in content[:200]


def _distinct(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The different ones of points (N, 3), sorted, and each one's number among them; np.unique takes far longer."""
    order = np.lexsort(points.T[::-1])
    ordered = points[order]
    first = np.ones(len(points), bool)
    first[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    numbers = np.empty(len(points), np.int64)
    numbers[order] = np.cumsum(first) - 1
    return ordered[first], numbers


def _volume_means(xp: Any, points: Array, faces: np.ndarray) -> tuple[Array, Array, Array, Array]:
    """The reference point, the volume, and the means of x and x x over it, x relative to that point."""
    reference = points.mean(-2)
    local = points - reference[..., None, :]
    a, b, c = (xp.take(local, faces[:, k], axis=-2) for k in range(3))
    six_volumes = (a * xp.cross(b, c)).sum(-1)
    volume = six_volumes.sum(-1) / 6
    _check_volume(xp, points, volume)
    # By shares of the volume: fifth powers of lengths may overflow or vanish in single precision.
    shares = six_volumes / (6 * volume[..., None])
    total = a + b + c
    # A tetrahedron with one corner at 0 has the means x = s/4 and x x = (aa + bb + cc + ss)/20.
    second = sum(xp.swapaxes(corner * shares[..., None], -1, -2) @ corner for corner in (a, b, c, total))
    first = (shares[..., None, :] @ total)[..., 0, :]
    return reference, volume, first / 4, 0.5 * (second + xp.swapaxes(second, -1, -2)) / 20


def _check_volume(xp: Any, points: Array, volume: Array) -> None:
    if not is_known(volume):
        return
    box = xp.prod(points.max(-2) - points.min(-2), axis=-1)
    if not (xp.isfinite(box) & xp.isfinite(volume)).all():
        raise ValueError("the mesh is too large: its volume is beyond what a number holds")
    if ((box == 0.0) & (points.max(-2) > points.min(-2)).all(-1)).any():
        raise ValueError("the mesh is too small: its volume is below what a number holds")
    if (abs(volume) <= _ROUNDINGS * xp.finfo(volume.dtype).eps * box).any():
        raise ValueError("the mesh encloses no volume")
    if (volume < 0).any():
        raise ValueError("the faces of the mesh are inside out: reverse each of them, as in faces[:, ::-1]")


def _quartered(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each triangle cut in 4 at the middles of its edges."""
    edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    unique, numbers = np.unique(edges, axis=0, return_inverse=True)
    a, b, c = faces.T
    ab, bc, ca = (numbers.reshape(-1, 3) + len(vertices)).T
    quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return (
        np.concatenate([vertices, vertices[unique].mean(1)]),
        np.concatenate([np.stack(corners, axis=1) for corners in quarters]),
    )
