"""Meshes in OBJ, OFF, PLY and STL: vertices (V, 3) and faces (F, 3) of a file's bytes.

Faces of more corners become fans of triangles about their first. A file that ends early is refused, also where what is
left of it is closed, as of several bodies. Formats: Wavefront's "Object Files (.obj), version 3.0", Geomview's manual
("OFF files"), Turk 1994, "The PLY Polygon File Format", 3D Systems' "StereoLithography Interface Specification" (1988).
"""

import io
import re
import struct
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

Mesh = tuple[np.ndarray, np.ndarray]

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEAD = 84  # bytes of a binary STL file before its facets, the last four of which count them
_OFF = re.compile(rb"(ST)?C?N?OFF", re.IGNORECASE)  # of four or n dimensions is none of a body
_LONGEST_HEAD = 2**16  # bytes of a file in PLY
_ORDERS = {b"ascii": "", b"binary_little_endian": "<", b"binary_big_endian": ">"}
_LETTERS = {
    "char": "b",
    "uchar": "B",
    "short": "h",
    "ushort": "H",
    "int": "i",
    "uint": "I",
    "float": "f",
    "double": "d",
}
_BY_SIZE = {"int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "float32": "f"}
_KINDS = {name.encode(): letter for name, letter in (_LETTERS | _BY_SIZE | {"float64": "d"}).items()}
_LENGTH = "length of "
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
    for number, line in enumerate(io.BytesIO(_lines(content).replace(b"\\\n", b" ")), 1):
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
    lines = [words for line in io.BytesIO(_lines(content)) if (words := line.partition(b"#")[0].split())]
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
    """A file in STL, binary or of text; ValueError says what is wrong with it. Each facet has corners of its own.

    >>> lines = ["solid", "facet normal 0 0 1", "outer loop", "vertex 0 0 0", "vertex 1 0 0", "vertex 0 1 0"]
    >>> print(stl("\\n".join([*lines, "endloop", "endfacet", "endsolid"]).encode())[1].tolist())
    [[0, 1, 2]]
    """
    if size_of_binary_stl(content)[1] == len(content):
        places = np.frombuffer(content, _FACET, offset=_HEAD)["corners"].astype(float).reshape(-1, 3)
    else:
        places = _stl_of_text(content)
    return places, np.arange(len(places)).reshape(-1, 3)


class _Property(NamedTuple):
    """A number of an element of PLY or a list of them, by the letters of struct; size: that of a list's length."""

    name: bytes
    kind: str
    size: str | None


class _Element(NamedTuple):
    name: bytes
    count: int
    properties: list[_Property]


def ply(content: bytes) -> Mesh:
    """A file in PLY, binary or of text; ValueError says what is wrong with it. All but places and faces is passed over.

    >>> head = ["ply", "format ascii 1.0", "element vertex 4", *(f"property float {x}" for x in "xyz")]
    >>> head += ["element face 1", "property list uchar int vertex_indices", "end_header"]
    >>> print(ply("\\n".join([*head, "0 0 0", "1 0 0", "0 1 0", "1 1 0", "4 0 1 3 2"]).encode())[1].tolist())
    [[0, 1, 3], [0, 3, 2]]
    """
    elements, order, at = _head_of_ply(content)
    found = {}
    if order:
        for element in elements:
            found[element.name], at = _from_bytes(content, at, element, order)
        beyond = content[at:].strip()
    else:
        lines = [words for line in io.BytesIO(_lines(content[at:])) if (words := line.split())]
        for element in elements:
            found[element.name] = _from_words(lines[: element.count], element)
            del lines[: element.count]
        beyond = lines
    if beyond:
        raise ValueError("it has more than it announces")
    points, faces = found.get(b"vertex", {}), found.get(b"face", {})
    named = next((name for name in (b"vertex_indices", b"vertex_index") if name in faces), None)
    if named is None or not {b"x", b"y", b"z"} <= set(points):
        raise ValueError("it has no places of vertices, or no faces")
    places = np.column_stack([np.asarray(points[name]).astype(float).reshape(-1) for name in (b"x", b"y", b"z")])
    return places, _fans(faces[named])


def size_of_binary_stl(content: bytes) -> tuple[int, int]:
    """How many facets a file in binary STL announces, and the bytes that it has with them; as many as are there.

    >>> print(size_of_binary_stl(bytes(80) + b"\\2" + bytes(103)))
    (2, 184)
    """
    facets = int.from_bytes(content[80:_HEAD], "little")
    return facets, _HEAD + _FACET.itemsize * facets


READERS: Mapping[str, Callable[[bytes], Mesh]] = {".obj": obj, ".off": off, ".ply": ply, ".stl": stl}


def _head_of_ply(content: bytes) -> tuple[list[_Element], str, int]:
    """The elements, the order of bytes or "" where they are text, and where they begin."""
    begun = re.match(rb"ply[ \t]*(\r\n|\n|\r)", content)
    ended = begun and re.compile(begun[1] + rb"end_header[ \t]*" + begun[1]).search(content, 0, _LONGEST_HEAD)
    if not begun or not ended:
        raise ValueError("it has no head of PLY")
    elements: list[_Element] = []
    order = None
    for line in content[begun.end() : ended.start()].split(begun[1]):
        match line.split():
            case [b"format", kind, b"1.0"] if kind in _ORDERS:
                order = _ORDERS[kind]
            case [b"element", name, count] if count.isdigit():
                elements.append(_Element(name, int(count), []))
            case [b"property", b"list", size, kind, name] if elements and size in _KINDS and kind in _KINDS:
                elements[-1].properties.append(_Property(name, _KINDS[kind], _KINDS[size]))
            case [b"property", kind, name] if elements and kind in _KINDS:
                elements[-1].properties.append(_Property(name, _KINDS[kind], None))
            case [] | [b"comment" | b"obj_info", *_]:
                pass
            case _:
                raise ValueError(f"its head has the line {line.decode(errors='replace')!r:.80}")
    if order is None:
        raise ValueError("it does not say whether it is binary")
    return elements, order, ended.end()


def _from_words(rows: list[list[bytes]], element: _Element) -> dict[bytes, Any]:
    """Each property's values, row by row."""
    if len(rows) < element.count:
        raise ValueError(f"it announces {element.count} rows of {element.name.decode()}, and has {len(rows)}")
    found: dict[bytes, Any] = {one.name: [] for one in element.properties}
    for words in rows:
        at = 0
        for one in element.properties:
            size, at = (1, at) if one.size is None or at >= len(words) else (int(words[at]), at + 1)
            found[one.name].append(words[at : at + size])
            at += size
        if at != len(words):
            raise ValueError(f"a row of {element.name.decode()} has {len(words)} numbers instead of {at}")
    return found


def _from_bytes(content: bytes, at: int, element: _Element, order: str) -> tuple[dict[bytes, Any], int]:
    """Each property's values, row by row, and where they end."""
    try:
        alike = element.count and np.dtype(_fields(content, at, element, order))
        if alike and at + alike.itemsize * element.count <= len(content):
            table = np.frombuffer(content, alike, element.count, at)
            lengths = [table[name] for name in alike.names or () if name.startswith(_LENGTH)]
            if all((length == length[0]).all() for length in lengths):
                return {one.name: table[one.name.decode()] for one in element.properties}, at + table.nbytes
        found: dict[bytes, Any] = {one.name: [] for one in element.properties}
        for _ in range(element.count):
            for one in element.properties:
                size = 1
                if one.size is not None:
                    (size,) = struct.unpack_from(order + one.size, content, at)
                    at += struct.calcsize(order + one.size)
                packed = f"{order}{size}{one.kind}"
                found[one.name].append(struct.unpack_from(packed, content, at))
                at += struct.calcsize(packed)
    except struct.error:
        raise ValueError(f"it ends within the {element.count} rows of {element.name.decode()}") from None
    return found, at


def _fields(content: bytes, at: int, element: _Element, order: str) -> list[tuple]:
    """What a row is of, as numpy has it, if all have lists as long as the first."""
    fields = []
    for one in element.properties:
        name, size = one.name.decode(), 1
        if one.size is not None:
            (size,) = struct.unpack_from(order + one.size, content, at)
            fields.append((_LENGTH + name, order + one.size))
            at += struct.calcsize(order + one.size)
        fields.append((name, order + one.kind, (size,)))
        at += struct.calcsize(f"{order}{size}{one.kind}")
    return fields


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


def _fans(faces: Any) -> np.ndarray:
    """Triangles (F, 3) of faces, which are rows of an array where all have as many corners: a hundred times as fast."""
    if isinstance(faces, np.ndarray) and faces.shape[1] > 2:
        fans = [faces[:, [0, second, second + 1]] for second in range(1, faces.shape[1] - 1)]
        return np.stack(fans, axis=1).astype(np.int64).reshape(-1, 3)
    corners = array("q")
    for face in faces:
        _fan(corners, [int(corner) for corner in face])
    return np.array(corners, np.int64).reshape(-1, 3)


def _arrays(places: array, corners: array) -> Mesh:
    return np.array(places).reshape(-1, 3), np.array(corners, np.int64).reshape(-1, 3)
