"""Meshes in OBJ, OFF and STL: vertices (V, 3) and faces (F, 3) of a file's bytes; PLY is read by trimesh, in mesh.py.

Faces of more corners become fans of triangles about their first. A file that ends early is refused, also where what is
left of it is closed, as of several bodies. Formats: Wavefront's "Object Files (.obj), version 3.0", Geomview's manual
("OFF files"), 3D Systems' "StereoLithography Interface Specification" (1988).
Tests: tests/unit/inertia/test_mesh_files.py.
"""

import re
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

Mesh = tuple[np.ndarray, np.ndarray]

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEAD = 84  # bytes of a binary STL file before its facets, the last four of which count them
_OFF = re.compile(rb"(ST)?C?N?OFF", re.IGNORECASE)  # of four or n dimensions is none of a body
_WORDS_OF_STL = re.compile(
    rb"(?im)^[ \t]*(?:(?P<end>end)?solid\b.*$)|\b(?P<open>facet)\b|\b(?P<close>endfacet)\b"
    rb"|\bvertex\s+(?P<x>\S+)\s+(?P<y>\S+)\s+(?P<z>\S+)"
)


def obj(content: bytes) -> Mesh:
    """A file in OBJ; ValueError says what is wrong with it. A corner may count back from the vertices before it.

    >>> lines = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 1 1 0", "f -4 -3 -1 -2"]
    >>> print(obj("\\n".join(lines).encode())[1].tolist())
    [[0, 1, 3], [0, 3, 2]]
    """
    places, corners, count = array("d"), array("q"), 0
    for number, line in enumerate(re.sub(rb"\\\n", b" ", _lines(content)).split(b"\n"), 1):
        word, *rest = line.partition(b"#")[0].split() or [b""]
        if word == b"v":
            places.extend(_three(rest, "line", number))
            count += 1
        elif word == b"f":
            face = [int(corner.partition(b"/")[0]) for corner in rest]
            if 0 in face:
                raise ValueError(f"line {number} names vertex 0, but they are numbered from 1")
            _fan(corners, [corner - 1 if corner > 0 else count + corner for corner in face])
    return _arrays(places, corners)


def off(content: bytes) -> Mesh:
    """A file in OFF of text; ValueError says what is wrong with it. Colours and normals are passed over.

    >>> lines = ["OFF", "4 1 0", "0 0 0", "1 0 0", "0 1 0", "1 1 0", "4 0 1 3 2"]
    >>> print(off("\\n".join(lines).encode())[1].tolist())
    [[0, 1, 3], [0, 3, 2]]
    """
    lines = [words for line in _lines(content).split(b"\n") if (words := line.partition(b"#")[0].split())]
    if lines and not lines[0][0].isdigit():
        word, *rest = lines.pop(0)
        if not _OFF.fullmatch(word):
            raise ValueError(f"it begins with {word.decode(errors='replace')!r:.20} instead of OFF")
        lines[:0] = [rest] if rest else []
    try:
        points, faces = map(int, lines[0][:2])
    except (IndexError, ValueError):
        raise ValueError("it does not begin with numbers of vertices and faces") from None
    rows = lines[1 + points : 1 + points + faces]
    if min(points, faces) < 0 or len(rows) < faces:
        raise ValueError(f"it announces {points} vertices and {faces} faces, and has {len(lines) - 1} of both")
    places, corners = array("d"), array("q")
    for number, words in enumerate(lines[1 : 1 + points]):
        places.extend(_three(words, "vertex", number))
    for number, (size, *words) in enumerate(rows):
        face = [int(corner) for corner in words[: int(size)]]
        if len(face) != int(size):
            raise ValueError(f"face {number} announces {int(size)} corners and has {len(face)}")
        _fan(corners, face)
    return _arrays(places, corners)


def stl(content: bytes) -> Mesh:
    """A file in STL, binary or of text; ValueError says what is wrong with it."""
    if size_of_binary_stl(content)[1] == len(content):
        places = np.frombuffer(content, _FACET, offset=_HEAD)["corners"].astype(float).reshape(-1, 3)
    else:
        places = _stl_of_text(content)
    return places, np.arange(len(places)).reshape(-1, 3)


def size_of_binary_stl(content: bytes) -> tuple[int, int]:
    """How many facets a file in binary STL announces, and the bytes that it has with them; as many as are there.

    >>> print(size_of_binary_stl(bytes(80) + b"\\2" + bytes(103)))
    (2, 184)
    """
    facets = int.from_bytes(content[80:_HEAD], "little")
    return facets, _HEAD + _FACET.itemsize * facets


READERS: Mapping[str, Callable[[bytes], Mesh]] = {".obj": obj, ".off": off, ".stl": stl}


def _stl_of_text(content: bytes) -> np.ndarray:
    places = array("d")
    counts = {"solid": 0, "end": 0, "open": 0, "close": 0}
    for found in _WORDS_OF_STL.finditer(_lines(content)):
        if found["x"] is not None:
            places.extend(_three(found.group("x", "y", "z"), "vertex", len(places) // 3))
        else:
            counts[found.lastgroup or "solid"] += 1
    corners, facets = len(places) // 3, counts["open"]
    if facets != counts["close"] or 3 * facets != corners:
        ended = f"of its {facets} facets {counts['close']} end, and they have {corners} corners"
        raise ValueError(f"it is not whole: {ended}")
    if counts["solid"] != counts["end"]:
        raise ValueError(f"it is not whole: of its {counts['solid']} solids {counts['end']} end")
    return np.array(places).reshape(-1, 3)


def _lines(content: bytes) -> bytes:
    """Text with the ends of lines that any system has as one, and without a mark of its encoding."""
    return content.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def _three(words: Sequence[bytes], what: str, number: int) -> Iterator[float]:
    if len(words) < 3:
        raise ValueError(f"{what} {number} has {len(words)} coordinates")
    return map(float, words[:3])


def _fan(corners: array, face: list[int]) -> None:
    for second, third in pairwise(face[1:]):
        corners.extend((face[0], second, third))


def _arrays(places: array, corners: array) -> Mesh:
    return np.array(places).reshape(-1, 3), np.array(corners, np.int64).reshape(-1, 3)
