"""Closed meshes against closed forms, their order of convergence, far from the origin, and what is refused."""

import os
import time

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from astroinertia.errors import ArchiveError
from astroinertia.inertia import mesh, shapes
from tests.scripts import run_sim

CUBE = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
CUBE_FACES = np.array([
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
])  # fmt: skip


def box_mesh(sides):
    return CUBE * sides - 0.5 * np.asarray(sides), CUBE_FACES


def sheet(rings, across, wrapped):
    """Faces of a grid of vertices, rings by across, closed around each ring, and along the rings if wrapped."""
    grid = np.arange(rings * across).reshape(rings, across)
    grid = np.concatenate([grid, grid[:, :1]], axis=1)
    if wrapped:
        grid = np.concatenate([grid, grid[:1]], axis=0)
    a, b, c, d = grid[:-1, :-1].ravel(), grid[1:, :-1].ravel(), grid[1:, 1:].ravel(), grid[:-1, 1:].ravel()
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def torus_mesh(ring, tube, count):
    u = 2 * np.pi * np.arange(count) / count
    around, across = np.meshgrid(u, u, indexing="ij")
    distance = ring + tube * np.cos(across)
    vertices = np.stack([distance * np.cos(around), distance * np.sin(around), tube * np.sin(across)], -1)
    return vertices.reshape(-1, 3), sheet(count, count, wrapped=True)


def frustum_mesh(base, top, height, count):
    """A frustum with its base at z = 0 and vertices on the middle of base and top."""
    angle = 2 * np.pi * np.arange(count) / count
    circle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    vertices = np.concatenate([top * circle + [0, 0, height], base * circle, [[0, 0, height], [0, 0, 0]]])
    k, following = np.arange(count), np.roll(np.arange(count), -1)
    lids = [
        np.stack([0 * k + 2 * count, k, following], 1),
        np.stack([0 * k + 2 * count + 1, following + count, k + count], 1),
    ]
    return vertices, np.concatenate([sheet(2, count, wrapped=False), *lids])


def ellipsoid_mesh(semi_axes, level):
    vertices, faces = mesh.icosphere(level)
    return vertices * semi_axes, faces


def agree(found, expected, rtol):
    np.testing.assert_allclose(found.mass, expected.mass, rtol=rtol)
    size = np.sqrt(abs(expected.inertia).max() / abs(expected.mass))
    np.testing.assert_allclose(found.centre, expected.centre, rtol=0, atol=rtol * size)
    np.testing.assert_allclose(found.inertia, expected.inertia, rtol=0, atol=rtol * abs(expected.inertia).max())


def test_boxes_tetrahedra_and_prisms_are_exact():
    agree(mesh.mesh_body(*box_mesh([1.2, 0.5, 2.0]), mass=2.0), shapes.box(2.0, 1.2, 0.5, 2.0), 1e-15)
    agree(mesh.mesh_body(*box_mesh([1.2, 0.5, 2.0]), density=3.0), shapes.box(3.6, 1.2, 0.5, 2.0), 1e-15)
    corners = np.array([[0.2, 0.1, -0.3], [1.5, 0.0, 0.2], [0.4, 1.2, 0.1], [0.3, 0.5, 1.9]])
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    agree(mesh.mesh_body(corners, faces, mass=2.0), shapes.tetrahedron(2.0, corners), 3e-15)
    assert mesh.mesh_volume(corners, faces) == pytest.approx(np.linalg.det(corners[1:] - corners[0]) / 6, rel=1e-14)


@given(st.floats(-6, 6), st.floats(-6, 6), st.integers(0, 10**6))
def test_turned_moved_and_scaled_boxes_are_exact(mass, length, seed):
    mass, length = 10.0**mass, 10.0**length
    random = np.random.default_rng(seed)
    turn, shift = Rotation.random(rng=random).as_matrix(), length * random.normal(size=3)
    sides = length * random.uniform(0.1, 1.0, 3)
    vertices, faces = box_mesh(sides)
    found = mesh.mesh_body(vertices @ turn.T + shift, faces, mass=mass)
    agree(found, shapes.box(mass, *sides).rotated(turn).translated(shift), 1e-13)


def test_cavities_and_separate_parts():
    (outer, faces), (inner, _) = box_mesh([2.0, 1.0, 3.0]), box_mesh([1.4, 0.4, 2.4])
    hollow = mesh.mesh_body(np.concatenate([outer, inner]), np.concatenate([faces, faces[:, ::-1] + 8]), mass=2.0)
    agree(hollow, shapes.hollow_box(2.0, 2.0, 1.0, 3.0, 0.3), 1e-14)
    pair = mesh.mesh_body(np.concatenate([outer, inner + 10.0]), np.concatenate([faces, faces + 8]), density=1.0)
    agree(pair, shapes.box(6.0, 2, 1, 3) + shapes.box(1.4 * 0.4 * 2.4, 1.4, 0.4, 2.4).translated([10.0] * 3), 1e-14)


@pytest.mark.parametrize("distance", [1e3, 1e6, 1e9])
def test_nothing_but_the_rounding_of_vertices_is_lost_far_from_the_origin(distance):
    vertices, faces = ellipsoid_mesh([1.0, 1.4, 0.6], 2)
    far = vertices + distance * np.array([1.0, -0.7, 0.4])
    near = mesh.mesh_body(vertices, faces, density=1.0)
    found = mesh.mesh_body(far, faces, density=1.0)
    rounding = np.finfo(float).eps * distance
    np.testing.assert_allclose(found.mass, near.mass, rtol=10 * rounding)
    np.testing.assert_allclose(found.inertia, near.inertia, rtol=0, atol=10 * rounding)


SMOOTH = {
    "ellipsoid": (lambda n: ellipsoid_mesh([1.0, 1.4, 0.6], n), shapes.ellipsoid(1.0, [1.0, 1.4, 0.6]), (2, 3, 4)),
    "torus": (lambda n: torus_mesh(1.4, 0.5, n), shapes.torus(1.0, 1.4, 0.5), (24, 48, 96)),
    "frustum": (
        lambda n: frustum_mesh(1.2, 0.5, 1.7, n),
        shapes.frustum(1.0, 1.2, 0.5, 1.7).translated([0, 0, 1.7 * 3.39 / (4 * 2.29)]),
        (24, 48, 96),
    ),
}  # facets are halved in size from one to the next


@pytest.mark.parametrize("name", SMOOTH)
def test_errors_fall_as_the_square_of_the_facets(name):
    build, smooth, levels = SMOOTH[name]
    bodies = [mesh.mesh_body(*build(level), density=1.0) for level in levels]
    unit = [mesh.mesh_body(*build(level), mass=1.0) for level in levels]
    volume = {"ellipsoid": 4 / 3 * np.pi * 0.84, "torus": 2 * np.pi**2 * 1.4 * 0.25, "frustum": np.pi / 3 * 1.7 * 2.29}[
        name
    ]
    for errors in (
        [1 - each.mass / volume for each in bodies],
        [abs(each.inertia - smooth.inertia).max() for each in unit],
    ):
        orders = np.log2(np.array(errors[:-1]) / errors[1:])
        np.testing.assert_allclose(orders, 2.0, atol=0.06)
        assert errors[-1] < 0.01
    assert all(abs(each.inertia - np.diag(np.diag(each.inertia))).max() < 1e-14 for each in unit)
    # The second order taken out, what is left is of fourth order.
    better = (4 * unit[-1].inertia - unit[-2].inertia) / 3
    np.testing.assert_allclose(better, smooth.inertia, rtol=0, atol=2e-5)
    np.testing.assert_allclose((4 * unit[-1].centre - unit[-2].centre) / 3, smooth.centre, rtol=0, atol=2e-5)


@pytest.mark.parametrize("level", [0, 1, 3])
def test_icosphere(level):
    vertices, faces = mesh.icosphere(level, 2.0)
    assert faces.shape == (20 * 4**level, 3) and len(vertices) == len(faces) // 2 + 2
    np.testing.assert_allclose(np.linalg.norm(vertices, axis=1), 2.0, rtol=1e-14)
    assert mesh.mesh_volume(vertices, faces) == pytest.approx(ConvexHull(vertices).volume, rel=1e-12)


def test_batches_precision_and_jax():
    vertices, faces = ellipsoid_mesh([1.0, 1.4, 0.6], 1)
    scales = np.array([[1.0], [2.0]])
    batch = mesh.mesh_body(vertices * scales[:, None], faces, density=np.array([[1.0, 3.0]]).T)
    assert batch.mass.shape == (2, 2) and batch.inertia.shape == (2, 2, 3, 3) and batch.centre.shape == (2, 2, 3)
    agree(jax.tree.map(lambda leaf: leaf[1, 1], batch), mesh.mesh_body(2 * vertices, faces, density=3.0), 1e-14)
    single = mesh.mesh_body(vertices.astype(np.float32), faces, mass=1.0)
    assert {leaf.dtype for leaf in jax.tree.leaves(single)} == {np.dtype(np.float32)}
    for size in (1e-11, 1e11):  # whose fifth powers are no numbers of single precision
        scaled = mesh.mesh_body((size * vertices).astype(np.float32), faces, mass=1.0).inertia.astype(float)
        np.testing.assert_allclose(scaled / size**2, single.inertia, atol=1e-5 * single.inertia.max())
    with jax.enable_x64(True):
        traced = jax.jit(lambda x: mesh.mesh_body(x, faces, density=2.0))(jnp.asarray(vertices))
    agree(jax.tree.map(np.asarray, traced), mesh.mesh_body(vertices, faces, density=2.0), 1e-14)


@pytest.mark.full
def test_derivatives_by_the_vertices():
    vertices, faces = ellipsoid_mesh([1.0, 1.4, 0.6], 1)
    vertices = vertices + [0.3, -0.2, 0.5]
    spin = np.array([0.3, -0.5, 0.2])
    cross = np.array([[0, -spin[2], spin[1]], [spin[2], 0, -spin[0]], [-spin[1], spin[0], 0]])

    def function(x):
        return mesh.mesh_body(x, faces, density=2.0)

    with jax.enable_x64(True):
        place = jnp.asarray(vertices)
        found, grown = jax.jvp(function, (place,), (place,))
        _, turned = jax.jvp(function, (place,), (place @ cross.T,))
        slope = jax.grad(lambda x: function(x).mass)(place)
        found, grown, turned, slope = jax.tree.map(np.asarray, (found, grown, turned, slope))
    # Growth: volume goes as the third power, inertia as the fifth. Rotation: dI/dt = W I - I W.
    np.testing.assert_allclose(grown.mass, 3 * found.mass, rtol=1e-13)
    np.testing.assert_allclose(grown.inertia, 5 * found.inertia, rtol=0, atol=1e-12)
    np.testing.assert_allclose(turned.inertia, cross @ found.inertia - found.inertia @ cross, rtol=0, atol=1e-12)
    # The volume's slope at a vertex is a third of the areas of its faces, as vectors.
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    expected = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(expected, faces[:, k], 2.0 * np.cross(b - a, c - a) / 6)
    np.testing.assert_allclose(slope, expected, rtol=0, atol=1e-14)


FLAT = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]) @ Rotation.from_rotvec([0.3, 0.4, 0.5]).as_matrix()


@pytest.mark.parametrize(
    ("vertices", "faces", "sentence"),
    [
        (CUBE, CUBE_FACES[1:], r"not closed: the edge between vertices 0 and 1 belongs to one face only"),
        (CUBE, np.concatenate([CUBE_FACES, CUBE_FACES[:1]]), "belongs to 3 faces, an odd number"),
        (CUBE, np.concatenate([CUBE_FACES[:1, ::-1], CUBE_FACES[1:]]), "wound alike.* vertices 0 and 1 disagree"),
        (CUBE, CUBE_FACES[:, ::-1], r"inside out: reverse each of them, as in faces\[:, ::-1\]"),
        (FLAT, np.array([(0, 1, 2), (2, 1, 0)]), "encloses no volume"),
        (CUBE * 1e-150, CUBE_FACES, "too small: its volume is below what a number holds"),
        (CUBE * 1e150, CUBE_FACES, "too large: its volume is beyond what a number holds"),
        (CUBE, CUBE_FACES + 1, "faces name vertices 1 to 8, but there are 8"),
        (CUBE, CUBE_FACES * 1.0, r"faces must be whole numbers of shape \(F, 3\), not float64 of shape \(12, 3\)"),
        (CUBE, CUBE_FACES[:0], "faces must be whole numbers"),
        (np.where(CUBE > 0, np.nan, CUBE), CUBE_FACES, "the vertices of a mesh must be finite"),
        (CUBE[:, :2], CUBE_FACES, r"must have shape \(..., n, 3\), not \(8, 2\)"),
    ],
)
def test_what_is_no_body_is_refused_with_a_sentence(vertices, faces, sentence):
    with pytest.raises(ValueError, match=sentence):
        mesh.mesh_body(vertices, faces, mass=1.0)


@pytest.mark.parametrize("arguments", [{}, {"mass": 1.0, "density": 1.0}])
def test_mass_or_density(arguments):
    with pytest.raises(ValueError, match="either the mass or the density"):
        mesh.mesh_body(CUBE, CUBE_FACES, **arguments)


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "off"])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_files(tmp_path, ending, scale):
    trimesh = pytest.importorskip("trimesh")
    vertices, faces = ellipsoid_mesh(np.array([1.0, 1.4, 0.6]) * scale, 2)
    path = tmp_path / f"body.{ending}"
    options = {"digits": 26} if ending in ("obj", "off") else {}
    trimesh.Trimesh(vertices, faces, process=False).export(str(path), **options)
    found = mesh.mesh_body(*mesh.read_mesh(path), mass=1.0)
    single = ending in ("stl", "ply")  # which hold 32 bits
    agree(found, mesh.mesh_body(vertices, faces, mass=1.0), 1e-6 if single else 1e-12)
    assert len(mesh.read_mesh(path)[0]) == len(vertices)


def test_trimesh_agrees():
    trimesh = pytest.importorskip("trimesh")
    vertices, faces = torus_mesh(1.4, 0.5, 24)
    theirs = trimesh.Trimesh(vertices + 3.0, faces, process=False)
    theirs.density = 2.0
    found = mesh.mesh_body(vertices + 3.0, faces, density=2.0)
    np.testing.assert_allclose(found.mass, theirs.mass, rtol=1e-12)
    np.testing.assert_allclose(found.centre, theirs.center_mass, rtol=1e-12)
    np.testing.assert_allclose(found.inertia, theirs.moment_inertia, rtol=0, atol=1e-11)


def test_a_file_that_is_no_mesh(tmp_path):
    path = tmp_path / "body.stl"
    path.write_text("this is no mesh")
    for wrong in (path, tmp_path / "none.obj"):
        with pytest.raises(ArchiveError, match=rf"{wrong.name} cannot be read as a mesh"):
            mesh.read_mesh(wrong)


@pytest.mark.parametrize("head", ["OFF\n12 8 18", "# a nut\n\nOFF 12 8 18  # counts"])
def test_a_file_of_triangles_quadrangles_and_hexagons_is_read(tmp_path, head):
    angles = np.arange(6) * np.pi / 3
    corners = [(np.cos(angle), np.sin(angle), z) for z in (0.0, 1.0) for angle in angles]
    sides = [[i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6)]
    faces = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *sides[:5], sides[5][:3], [sides[5][k] for k in (0, 2, 3)]]
    lines = [head.replace(" 8 ", " 9 "), *(" ".join(map(repr, map(float, corner))) for corner in corners)]
    lines += [f"{len(face)} {' '.join(map(str, face))} 255 0 0" for face in faces]
    (tmp_path / "nut.off").write_text("\n".join(lines))
    body = mesh.mesh_body(*mesh.read_mesh(tmp_path / "nut.off"), density=1.0)
    assert float(body.mass) == pytest.approx(1.5 * 3**0.5, rel=1e-14)
    assert body.centre == pytest.approx([0.0, 0.0, 0.5], abs=1e-15)
    (tmp_path / "nut.off").write_text("\n".join(lines[:-2]))
    with pytest.raises(ArchiveError, match="announces 12 vertices and 9 faces, and has 19 of both"):
        mesh.read_mesh(tmp_path / "nut.off")
    (tmp_path / "nut.off").write_text("\n".join(lines[:-2]).replace(" 9 ", " 7 "))
    with pytest.raises(ValueError, match="not closed"):
        mesh.mesh_body(*mesh.read_mesh(tmp_path / "nut.off"), density=1.0)


@pytest.mark.slow
@pytest.mark.parametrize(("ending", "size"), [("obj", 900), ("stl", 900), ("off", 200), ("ply", 200), ("obj", 200)])
def test_a_file_of_holes_is_refused_at_once(tmp_path, ending, size):
    path = tmp_path / f"holes.{ending}"
    path.write_text("ply\nformat ascii 1.0\n" if ending == "ply" else "v 0 0 0\n")
    with path.open("r+b") as file:
        file.truncate(size * 2**20)
    begun = time.process_time()
    with pytest.raises(ArchiveError, match=r"larger than 256 MiB|neither binary nor text"):
        mesh.read_mesh(path)
    assert time.process_time() - begun < 10.0  # a search for numbers takes minutes


def test_only_the_geometry_is_read(tmp_path, capfd):
    os.mkfifo(tmp_path / "pipe")
    vertices, faces = ellipsoid_mesh([1.0, 1.4, 0.6], 1)
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    (tmp_path / "body.obj").write_text("\n".join(["mtllib pipe", "usemtl pipe", *lines]))
    pytest.importorskip("trimesh").Trimesh(vertices, faces, process=False).export(tmp_path / "body.ply")
    head, _, body = (tmp_path / "body.ply").read_bytes().partition(b"\n")
    (tmp_path / "body.ply").write_bytes(head + b"\ncomment TextureFile pipe\n" + body)
    for name in ("body.obj", "body.ply"):  # a pipe that is opened is waited for
        assert len(mesh.read_mesh(tmp_path / name)[1]) == len(faces)
    assert capfd.readouterr() == ("", "")


def test_the_script_of_the_asteroid(tmp_path):
    printed = run_sim("asteroid_mesh.py", "--subdivisions", 4, "--output", tmp_path / "asteroid.png")
    moments = [
        float(line.split()[1]) for line in printed.splitlines() if line.startswith(("smallest", "middle", "largest"))
    ]
    assert len(moments) == 3 and moments == sorted(moments)
    # The craters and hills change the ellipsoid that they are on by some per cent.
    plain = np.diag(shapes.ellipsoid(2150.0 * 4 / 3 * np.pi * 290 * 215 * 175, [290.0, 215.0, 175.0]).inertia)
    np.testing.assert_allclose(moments, plain, rtol=0.2)
    assert "It settles about the axis of the largest moment" in printed
    assert (tmp_path / "asteroid.png").stat().st_size > 20_000
    assert "--density" in run_sim("asteroid_mesh.py", "--help")
    assert "cannot be read as a mesh" in run_sim("asteroid_mesh.py", "--mesh", tmp_path / "none.stl", code=2)


@pytest.mark.parametrize("place", [1e5, 1e6])
def test_vertices_that_no_face_names_are_no_part_of_the_body(place):
    vertices, faces = mesh.icosphere(2)
    alone = mesh.mesh_body(vertices, faces, density=6.0)
    for where in (0, 70, len(vertices)):
        more = np.insert(vertices, where, place, axis=0)
        found = mesh.mesh_body(more, faces + (faces >= where), density=6.0)
        assert found.mass == alone.mass
        np.testing.assert_array_equal(found.inertia, alone.inertia)
