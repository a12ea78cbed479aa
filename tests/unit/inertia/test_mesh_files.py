"""Files of meshes by the letter of their formats: a box of known moments in each, and files that end early."""

import struct

import numpy as np
import pytest

from astroinertia.errors import ArchiveError
from astroinertia.inertia import mesh

SIDES, CORNER = np.array([2.0, 3.0, 5.0]), np.array([1.0, -2.0, 0.5])
PLACES = [CORNER + SIDES * (x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
TRIANGLES = [corners for a, b, c, d in QUADS for corners in ((a, b, c), (a, c, d))]
BESIDE = np.array([10.0, 0.0, 0.0])


def of_line(numbers):
    return " ".join(repr(float(number)) for number in numbers)


def points(moved=0.0):
    return [f"v {of_line(place + moved)}" for place in PLACES]


def faces(first=1):
    return ["f " + " ".join(str(corner + first) for corner in face) for face in QUADS]


def solid(name="box", moved=0.0):
    lines = [f"solid {name}"]
    for face in TRIANGLES:
        corners = [f"vertex {of_line(PLACES[corner] + moved)}" for corner in face]
        lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    return [*lines, f"endsolid {name}"]


def read(tmp_path, ending, lines, end="\n"):
    path = tmp_path / f"box.{ending}"
    path.write_bytes(lines if isinstance(lines, bytes) else end.join(lines).encode())
    return mesh.mesh_body(*mesh.read_mesh(path), density=1.0)


def is_the_box(body):
    x, y, z = SIDES**2
    assert float(body.mass) == pytest.approx(30.0, rel=1e-14)
    assert body.centre == pytest.approx(CORNER + SIDES / 2, rel=1e-14)
    np.testing.assert_allclose(body.inertia, np.diag([y + z, x + z, x + y]) * 30.0 / 12.0, rtol=1e-13, atol=1e-12)


@pytest.mark.parametrize(
    "lines",
    [
        points() + faces(),
        points() + faces(first=-8),
        [line for face in QUADS for line in (*(points()[corner] for corner in face), "f -4 -3 -2 -1")],
        ["\ufeff# of an editor", *("\t" + line.replace(" ", "\t") + " # a remark" for line in points() + faces())],
        [line.replace(" ", "/1/2 ").replace("f/1/2 ", "f ") + "/1/2" if line[0] == "f" else line + " 0.1 0.2 0.3"
         for line in points() + faces()],
        points() + [" ".join(line.split()[:3]) + " \\\n" + " ".join(line.split()[3:]) for line in faces()],
    ],
)  # fmt: skip
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_obj(tmp_path, lines, end):
    is_the_box(read(tmp_path, "obj", [line.replace("\n", end) for line in lines], end))


def test_corners_that_count_back_are_of_the_vertices_so_far(tmp_path):
    body = read(tmp_path, "obj", [*points(), *faces(first=-8), *points(BESIDE), *faces(first=-8)])
    assert float(body.mass) == pytest.approx(60.0, rel=1e-14)
    assert body.centre == pytest.approx(CORNER + SIDES / 2 + BESIDE / 2, rel=1e-14)


def test_vertices_are_numbered_from_1_in_obj(tmp_path):
    with pytest.raises(ArchiveError, match="line 9 names vertex 0, but they are numbered from 1"):
        read(tmp_path, "obj", points() + faces(first=0))


@pytest.mark.parametrize("name", ["", "box of mine", "vertex 1 2 3", "a facet, an endsolid"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_stl_of_text(tmp_path, name, end):
    is_the_box(read(tmp_path, "stl", solid(name), end))
    is_the_box(read(tmp_path, "stl", [line.upper() for line in solid(name)], end))


def test_binary_stl_may_begin_as_text_does(tmp_path):
    facets = [struct.pack("<12fH", 0, 0, 0, *np.ravel([PLACES[corner] for corner in face]), 7) for face in TRIANGLES]
    content = b"solid box".ljust(80) + struct.pack("<I", 12) + b"".join(facets)
    is_the_box(read(tmp_path, "stl", content))
    with pytest.raises(ArchiveError, match="as binary STL its 12 facets take 684 bytes, and it has 674"):
        read(tmp_path, "stl", content[:-10])


PLY = """\
ply
format {kind} 1.0
comment element vertex 3
obj_info made by hand
element vertex 8
property double z
property uchar red
property double x
property float quality
property double y
element face {count}
property uchar flags
property list uchar {index} vertex_index
property list int float texcoord
property short material
element edge 1
property int vertex1
property int vertex2
end_header
"""


def polygons(kind, rows, index="int", end="\n"):
    """A box in PLY with more about vertices and faces than their places and corners."""
    letters = {"int": "i", "uint": "I", "ushort": "H", "uchar": "B"}[index]
    order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[kind]

    def packed(form, *values):
        return f"{' '.join(map(repr, values))}{end}".encode() if kind == "ascii" else struct.pack(order + form, *values)

    content = PLY.format(kind=kind, count=len(rows), index=index).replace("\n", end).encode()
    for x, y, z in PLACES:
        content += packed("dBdfd", float(z), 9, float(x), 0.5, float(y))
    for row in rows:
        content += packed(f"BB{len(row)}{letters}i2fh", 3, len(row), *row, 2, 0.25, 0.75, -4)
    return content + packed("ii", 0, 1)


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_ply(tmp_path, kind, end):
    is_the_box(read(tmp_path, "ply", polygons(kind, QUADS, end=end)))
    is_the_box(read(tmp_path, "ply", polygons(kind, TRIANGLES, "ushort", end)))
    is_the_box(read(tmp_path, "ply", polygons(kind, [*QUADS[:3], *TRIANGLES[6:]], "uint", end)))
    is_the_box(read(tmp_path, "ply", polygons(kind, [*TRIANGLES[:6], *QUADS[3:]], "uchar", end)))


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize("rows", [QUADS, [*TRIANGLES[:6], *QUADS[3:]]])
def test_ply_that_is_not_whole(tmp_path, kind, rows):
    content = polygons(kind, rows)
    for wrong in (
        content[:-12],
        content + b"1 2 3",
        content.replace(b"face %d" % len(rows), b"face 900"),
        content[:90],
    ):
        with pytest.raises(ArchiveError, match=r"cannot be read as a mesh: (it|a row of face) "):
            read(tmp_path, "ply", wrong)
    for count in (b"1000000000000", b"-1"):
        with pytest.raises(ArchiveError, match="cannot be read as a mesh"):
            read(tmp_path, "ply", content.replace(b"vertex 8", b"vertex " + count))


def test_what_is_left_of_a_file_that_ends_early_is_no_body(tmp_path):
    two = solid() + solid(moved=BESIDE)
    assert float(read(tmp_path, "stl", two).mass) == pytest.approx(60.0, rel=1e-14)
    for fewer, sentence in ((1, "solids 1 end"), (4, "24 facets 23 end, and they have 71 corners")):
        with pytest.raises(ArchiveError, match=f"it is not whole: of its .*{sentence}"):
            read(tmp_path, "stl", two[:-fewer])
    rows = [*(of_line(place + moved) for moved in (0.0, BESIDE) for place in PLACES)]
    rows += [f"4 {' '.join(str(corner + first) for corner in face)}" for first in (0, 8) for face in QUADS]
    assert float(read(tmp_path, "off", ["OFF", "16 12 0", *rows]).mass) == pytest.approx(60.0, rel=1e-14)
    with pytest.raises(ArchiveError, match="announces 16 vertices and 12 faces, and has 22 of both"):
        read(tmp_path, "off", ["OFF", "16 12 0", *rows[:-6]])


def test_off_of_other_dimensions_is_refused(tmp_path):
    rows = [f"{of_line(place)} 2" for place in PLACES] + [f"4 {' '.join(map(str, face))}" for face in QUADS]
    is_the_box(read(tmp_path, "off", ["COFF", "8 6 0", *rows]))
    with pytest.raises(ArchiveError, match="begins with '4OFF' instead of OFF"):
        read(tmp_path, "off", ["4OFF", "8 6 0", *rows])
