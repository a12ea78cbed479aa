"""A look at the structure of an HDF5 file before netCDF opens it: is it a tree, and one that ends in this file?

netCDF follows whatever names lead to: links into other files, data that lies in other files, and links in a circle
until the process crashes. What this package writes has none of these. Here the groups of a file are walked in Python,
each object once, and nothing but objects of the file itself is let through; data and attributes are not looked at.
Source: HDF5 File Format Specification 3.0 (The HDF Group), sections II.A, III.A, III.C, III.D, III.G and IV.A.
Tests: tests/hard/test_hdf5_structure.py.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

MOST_OBJECTS = 5_000  # groups, datasets and types
DEEPEST = 16  # groups within each other; each takes netCDF some of the stack
_MOST_BLOCKS = 200_000  # pieces of the file that are read
_MOST_BYTES = 2**26  # of all these
_LARGEST_BLOCK = 2**24
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_NOWHERE = 2**64 - 1
_LINK_INFO, _LINK, _EXTERNAL, _LAYOUT, _CONTINUATION, _SYMBOL_TABLE = 0x02, 0x06, 0x07, 0x08, 0x10, 0x11
_HARD, _SOFT_ENTRY, _VIRTUAL = 0, 2, 3


def is_hdf5(path: Path) -> bool:
    """Whether a file begins as HDF5 does, and so as netCDF-4."""
    with path.open("rb") as file:
        return file.read(len(_SIGNATURE)) == _SIGNATURE


def check(path: Path) -> int:
    """How many objects a file has, or a ValueError that says why it is no tree; OSError where it cannot be read."""
    with path.open("rb") as file:
        pieces = _Pieces(file, path.stat().st_size)
        seen: set[int] = set()
        level = [_root(pieces)]
        for _ in range(DEEPEST):
            below = []
            for address in level:
                if address in seen:
                    raise ValueError("two names lead to the same object, perhaps in a circle")
                seen.add(address)
                below += _children(pieces, address)
                if len(seen) + len(below) > MOST_OBJECTS:
                    raise ValueError(f"it has more than {MOST_OBJECTS} objects")
            if not below:
                return len(seen)
            level = below
    raise ValueError(f"its groups are nested deeper than {DEEPEST} levels")


@dataclass
class _Pieces:
    """The bytes of a file, read a piece at a time and within bounds; messages are (type, body) pairs."""

    file: BinaryIO
    size: int
    blocks: int = 0
    read: int = 0

    def at(self, address: int, length: int, signature: bytes = b"") -> bytes:
        """So many bytes from an address on, which begin with a signature."""
        self.blocks, self.read = self.blocks + 1, self.read + length
        if self.blocks > _MOST_BLOCKS or self.read > _MOST_BYTES or length > _LARGEST_BLOCK:
            raise ValueError("its structure is larger than that of any result")
        if address + length > self.size:
            raise ValueError("it ends before its time, or refers to what is beyond its end")
        self.file.seek(address)
        block = self.file.read(length)
        if len(block) != length or not block.startswith(signature):
            raise ValueError("its structure is damaged")
        return block


def _number(content: bytes, begin: int, length: int = 8) -> int:
    if begin + length > len(content):
        raise ValueError("its structure is damaged")
    return int.from_bytes(content[begin : begin + length], "little")


def _root(pieces: _Pieces) -> int:
    """The address of the root group's header, from the superblock."""
    first = pieces.at(0, 16, _SIGNATURE)
    version = first[8]
    sizes, base, root = ((13, 24, 64), (13, 28, 68), (9, 12, 36), (9, 12, 36))[min(version, 3)]
    if version > 3 or first[sizes] != 8 or first[sizes + 1] != 8:
        raise ValueError("its superblock is of an unknown version, or has numbers of other than 8 bytes")
    block = pieces.at(0, root + 8)
    if _number(block, base) != 0:
        raise ValueError("its addresses do not count from its beginning")
    return _number(block, root)


def _children(pieces: _Pieces, address: int) -> list[int]:
    """Addresses of the objects that a group names; none of a dataset or a type."""
    addresses: list[int] = []
    for kind, body in _messages(pieces, address):
        if kind == _EXTERNAL:
            raise ValueError("it has data in another file, which is not read")
        if kind == _LAYOUT and _number(body, 0, 1) >= 4 and _number(body, 1, 1) == _VIRTUAL:
            raise ValueError("it has data that are put together from other files, which are not read")
        if kind == _LINK:
            addresses.append(_linked(body))
        elif kind == _SYMBOL_TABLE:
            addresses += _symbols(pieces, _number(body, 0))
        elif kind == _LINK_INFO:
            begin = 10 if _number(body, 1, 1) & 1 else 2
            heap, names = _number(body, begin), _number(body, begin + 8)
            if heap != _NOWHERE:
                addresses += [_linked(link) for link in _dense(pieces, heap, names)]
    return addresses


def _messages(pieces: _Pieces, address: int) -> Iterator[tuple[int, bytes]]:
    """The messages of an object's header, of version 1 or 2."""
    begin = pieces.at(address, 6)
    modern = begin.startswith(b"OHDR")
    tracked = modern and begin[5] & 4
    if modern:
        start = 6 + 16 * bool(begin[5] & 32) + 4 * bool(begin[5] & 16)
        width = 1 << (begin[5] & 3)
        size = _number(pieces.at(address + start, width), 0, width)
        chunks = [(address + start + width, size)]
    else:
        head = pieces.at(address, 16)
        if head[0] != 1:
            raise ValueError("its structure is damaged")
        chunks = [(address + 16, _number(head, 8, 4))]
    prefix = (6 if tracked else 4) if modern else 8
    seen = set()
    while chunks:
        place, length = chunks.pop()
        if place in seen:
            raise ValueError("the parts of an object follow each other in a circle")
        seen.add(place)
        content, at = pieces.at(place, length), 0
        while at + prefix <= length:
            kind = content[at] if modern else _number(content, at, 2)
            size = _number(content, at + (1 if modern else 2), 2)
            body = content[at + prefix : at + prefix + size]
            if len(body) != size:
                raise ValueError("its structure is damaged")
            at += prefix + size
            if kind != _CONTINUATION:
                yield kind, body
                continue
            where, more = _number(body, 0), _number(body, 8)
            if modern:  # with a signature before its messages and a checksum after them
                pieces.at(where, 4, b"OCHK")
                where, more = where + 4, max(0, more - 8)
            chunks.append((where, more))


def _linked(body: bytes) -> int:
    """The address that a link leads to, in this file."""
    flags = _number(body, 1, 1)
    begin = 2
    kind = _HARD
    if flags & 8:
        kind, begin = _number(body, begin, 1), begin + 1
    if kind != _HARD:
        raise ValueError("it has links to paths or to other files, which are not followed")
    begin += 8 * bool(flags & 4) + bool(flags & 16)
    width = 1 << (flags & 3)
    return _number(body, begin + width + _number(body, begin, width))


def _symbols(pieces: _Pieces, root: int) -> Iterator[int]:
    """Addresses in a group of the old kind: the entries of the nodes below a B-tree of version 1."""
    waiting, seen = [root], set()
    while waiting:
        address = waiting.pop()
        if address in seen:
            raise ValueError("the parts of a group follow each other in a circle")
        seen.add(address)
        head = pieces.at(address, 24)
        if head.startswith(b"SNOD"):
            entries = pieces.at(address + 8, 40 * _number(head, 6, 2))
            for begin in range(0, len(entries), 40):
                if _number(entries, begin + 16, 4) == _SOFT_ENTRY:
                    raise ValueError("it has links to paths or to other files, which are not followed")
                yield _number(entries, begin + 8)
        elif head.startswith(b"TREE") and head[4] == 0:
            used = _number(head, 6, 2)
            body = pieces.at(address + 24, 16 * used + 8)
            waiting += [_number(body, 16 * k + 8) for k in range(used)]
        else:
            raise ValueError("its structure is damaged")


def _dense(pieces: _Pieces, heap: int, names: int) -> Iterator[bytes]:
    """The link messages of a large group, which lie in a fractal heap and are listed by a B-tree of version 2."""
    kept = _heap(pieces, heap)
    for record in _records(pieces, names):
        yield kept.read(record[4:])  # after the hash of the name


def _records(pieces: _Pieces, address: int) -> Iterator[bytes]:
    """The records of a B-tree of version 2, by name or by order: 4 or 8 bytes and the place in the heap."""
    head = pieces.at(address, 38, b"BTHD")
    node, size, depth = _number(head, 6, 4), _number(head, 10, 2), _number(head, 12, 2)
    root, count, total = _number(head, 16), _number(head, 24, 2), _number(head, 26)
    if head[5] != 5 or size != 11 or depth > 8 or not 64 <= node <= _LARGEST_BLOCK or total > MOST_OBJECTS:
        raise ValueError("the list of a group is damaged, or larger than that of any result")
    # How many bytes the counts of a node below take: by the most records that a node at each depth can hold.
    most = [(node - 10) // size]
    width = _bytes_of(most[0])
    totals, widths = [most[0]], [0]
    for _ in range(depth):
        own = (node - 10 - (8 + width + widths[-1])) // (size + 8 + width + widths[-1])
        totals.append(own + (own + 1) * totals[-1])
        widths.append(_bytes_of(totals[-1]))
    waiting = [(root, count, depth)] if root != _NOWHERE else []
    seen: set[int] = set()
    while waiting:
        place, count, level = waiting.pop()
        if place in seen:
            raise ValueError("the parts of a group follow each other in a circle")
        seen.add(place)
        content = pieces.at(place, node, b"BTIN" if level else b"BTLF")
        for k in range(count):
            if 6 + (k + 1) * size > node:
                raise ValueError("its structure is damaged")
            yield content[6 + k * size : 6 + (k + 1) * size]
        if level:
            below = 8 + width + widths[level - 1]
            for k in range(count + 1):
                begin = 6 + count * size + k * below
                waiting.append((_number(content, begin), _number(content, begin + 8, width), level - 1))


def _bytes_of(number: int) -> int:
    return max(1, (number.bit_length() + 7) // 8)


@dataclass
class _Heap:
    """A fractal heap's managed objects: blocks, rows of which double in size, make up one range of offsets."""

    pieces: _Pieces
    blocks: list[tuple[int, int, int]]  # first offset, size and address of each direct block
    offset_bytes: int
    length_bytes: int

    def read(self, place: bytes) -> bytes:
        """An object by its place: a byte of flags, its offset and its length."""
        if place[0] & 0xF0:
            raise ValueError("a name is longer than any of a result")
        offset = _number(place, 1, self.offset_bytes)
        length = _number(place, 1 + self.offset_bytes, self.length_bytes)
        for first, size, address in self.blocks:
            if first <= offset and offset + length <= first + size:
                return self.pieces.at(address + offset - first, length)
        raise ValueError("its structure is damaged")


def _heap(pieces: _Pieces, address: int) -> _Heap:
    head = pieces.at(address, 142, b"FRHP")
    filters, largest_object = _number(head, 7, 2), _number(head, 10, 4)
    width, least, most = _number(head, 110, 2), _number(head, 112), _number(head, 120)
    bits, rows = _number(head, 128, 2), _number(head, 140, 2)
    root = _number(head, 132)
    powers = all(number > 0 and number & (number - 1) == 0 for number in (width, least, most))
    if filters or not powers or not least <= most <= _LARGEST_BLOCK or width > 1024 or bits > 64 or rows > 64:
        raise ValueError("the list of a group is packed, or damaged")
    offset_bytes = (bits + 7) // 8
    blocks: list[tuple[int, int, int]] = []
    waiting = [] if root == _NOWHERE else [(0, root, rows)]
    while waiting:
        first, place, rows = waiting.pop()
        if not rows:
            pieces.at(place, 4, b"FHDB")
            blocks.append((first, least, place))
            continue
        size = least
        content = pieces.at(place, 13 + offset_bytes + 8 * width * rows, b"FHIB")
        for row in range(rows):
            size = least << max(0, row - 1)
            for column in range(width):
                below = _number(content, 13 + offset_bytes + 8 * (width * row + column))
                if size > most:  # a block of blocks: only of a group of very many names
                    if below != _NOWHERE:
                        raise ValueError("a group has more names than any of a result")
                elif below != _NOWHERE:
                    pieces.at(below, 4, b"FHDB")
                    blocks.append((first, size, below))
                first += size
    return _Heap(pieces, blocks, offset_bytes, _bytes_of(min(most, largest_object)))
