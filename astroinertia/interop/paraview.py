"""Particles for ParaView: one VTK PolyData file in XML (.vtp) a snapshot, and a collection with their times (.pvd).

The arrays stand in the file as they are (appended and raw, as the VTK file formats have it), float64 bit for bit.
Tests: tests/unit/interop/test_export.py.
"""

import xml.etree.ElementTree as xml
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from astroinertia.interop.snapshots import Snapshot
from astroinertia.storage.atomic import write_whole

_TYPES = {"f8": "Float64", "f4": "Float32", "i8": "Int64", "i4": "Int32", "u8": "UInt64"}
_LENGTH_TYPE = np.dtype("<u8")  # of the number of bytes before each array


def write_vtp(snapshot: Snapshot, path: Path) -> None:
    """Write the particles of one snapshot as points, each with the scalars and vectors that the snapshot has.

    >>> import tempfile
    >>> from astroinertia.interop.snapshots import snapshots_of
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_vtp(next(iter(snapshots_of(Path("runs/star"), "last"))), Path(folder, "star.vtp"))
    ...     print(Path(folder, "star.vtp").stat().st_size > 1000)
    True
    """
    blocks: list[np.ndarray] = []
    file = _file("PolyData")
    data = xml.SubElement(file, "PolyData")
    time = xml.SubElement(xml.SubElement(data, "FieldData"), "DataArray", type="Float64", Name="TimeValue")
    time.attrib |= {"NumberOfTuples": "1", "format": "ascii"}
    time.text = repr(snapshot.time)
    count = snapshot.identity.size
    piece = xml.SubElement(data, "Piece", NumberOfPoints=str(count), NumberOfVerts=str(count))
    _array(xml.SubElement(piece, "Points"), "Points", snapshot.arrays["position"], blocks)
    vertices = xml.SubElement(piece, "Verts")
    _array(vertices, "connectivity", np.arange(count), blocks)
    _array(vertices, "offsets", np.arange(1, count + 1), blocks)
    fields = xml.SubElement(piece, "PointData", Scalars="density", Vectors="velocity")
    _array(fields, "identity", snapshot.identity, blocks)
    for name, values in snapshot.arrays.items():
        if name != "position":
            _array(fields, name, values, blocks)
    appended = xml.SubElement(file, "AppendedData", encoding="raw")
    appended.text = "_"
    head, tail = xml.tostring(file).split(b"_</AppendedData>")

    def fill(aside: Path) -> None:
        with aside.open("wb") as stream:
            stream.write(b'<?xml version="1.0"?>\n' + head + b"_")
            for block in blocks:
                stream.write(np.array(block.nbytes, dtype=_LENGTH_TYPE).tobytes())
                stream.write(block.tobytes())
            stream.write(b"</AppendedData>" + tail)

    write_whole(path, fill)


def write_pvd(times: Sequence[float], files: Sequence[Path], path: Path) -> None:
    """Write the collection that lets ParaView play several .vtp files of the same folder along their times.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_pvd([0.0], [Path("star.vtp")], Path(folder, "star.pvd"))
    ...     print("star.vtp" in Path(folder, "star.pvd").read_text())
    True
    """
    file = _file("Collection")
    collection = xml.SubElement(file, "Collection")
    for time, snapshot in zip(times, files, strict=True):
        xml.SubElement(collection, "DataSet", timestep=repr(time), part="0", file=snapshot.name)
    xml.indent(file)
    write_whole(path, lambda aside: xml.ElementTree(file).write(aside, xml_declaration=True, encoding="utf-8"))


def _file(kind: str) -> xml.Element:
    return xml.Element("VTKFile", type=kind, version="1.0", byte_order="LittleEndian", header_type="UInt64")


def _array(parent: xml.Element, name: str, values: np.ndarray, blocks: list[np.ndarray]) -> None:
    """Announce an array, and keep it for the end of the file."""
    block = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    offset = sum(earlier.nbytes + _LENGTH_TYPE.itemsize for earlier in blocks)
    components = str(values.shape[1] if values.ndim == 2 else 1)
    place = {"format": "appended", "offset": str(offset), "NumberOfComponents": components}
    xml.SubElement(parent, "DataArray", place, type=_TYPES[values.dtype.str[1:]], Name=name)
    blocks.append(block)
