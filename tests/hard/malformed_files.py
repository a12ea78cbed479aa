"""Malformed files without end: whole ones changed by chance, and folders whose hashes agree with their mistakes."""

import hashlib
import io
import json
import os
import random
import shutil
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from astroinertia.storage import manifest as manifests
from tests.hard.malformed_bytes import changed

VALUES = (
    None, True, -1, 0, 1, 2**63, 10**400, 1e308, float("nan"), "", "x", "../../outside", "/etc/passwd", "/dev/zero",
    "member-0000", "segment-000001.npz", "a\nb", "\ud800", [], {}, [[]], [1, "x"], {"a": 1}, "x" * 5000,
)  # fmt: skip
DTYPES = ("<f8", ">f8", "<f4", "<i8", "<u1", "<c16", "<U3", "|S4", "|b1", "<M8[s]", "|V8", "[('a','<f8')]")
SHAPES = ((), (0,), (1,), (2,), (3, 3), (20, 3), (1, 20, 3), (2, 2, 2, 2, 2), (10**9,), (2**62, 4), (-1,), (3,) * 40)


def malformed(whole: list[tuple[str, Path]], folder: Path, seed: int, count: int) -> Iterator[tuple[str, Path]]:
    """Kind and path of so many, one after the other in the same place; the same ones for the same seed."""
    chance = random.Random(seed)
    for number in range(count):
        kind, source = whole[number % len(whole)]
        path = folder / source.name
        if path.is_dir():
            shutil.rmtree(path)
        if source.is_dir():
            shutil.copytree(source, path)
            chance.choice((_a_file_changed, _a_value_changed, _an_array_changed))(path, chance)
        else:
            content = source.read_bytes()
            other = _with_other_arrays(content, chance) if path.suffix == ".npz" and chance.random() < 0.5 else None
            path.write_bytes(other or changed(content, chance))
        yield kind, path


def _a_file_changed(folder, chance):
    path = chance.choice(_files(folder))
    path.write_bytes(changed(path.read_bytes(), chance))
    if chance.random() < 0.7:
        rehashed(path.parent)


def _a_value_changed(folder, chance):
    """Another value, or none, somewhere in a JSON file."""
    path = chance.choice([each for each in _files(folder) if each.suffix == ".json"])
    content = json.loads(path.read_text())
    for _ in range(chance.choice((1, 1, 3))):
        place, key = chance.choice(list(_places(content)) or [(None, None)])
        if place is not None and chance.random() < 0.2:
            del place[key]
        elif place is not None:
            place[key] = chance.choice(VALUES)
    path.write_text(json.dumps(content))
    if path.name in (manifests.MANIFEST, manifests.COPY):
        rehashed(path.parent, content)


def _an_array_changed(folder, chance):
    """Another shape, dtype or number of values in a segment or a checkpoint."""
    found = [each for each in _files(folder) if each.suffix == ".npz"]
    if found:
        path = chance.choice(found)
        path.write_bytes(_with_other_arrays(path.read_bytes(), chance))
        rehashed(path.parent)


def _places(content):
    for key in list(content) if isinstance(content, dict) else range(len(content)):
        yield content, key
        if isinstance(content[key], dict | list):
            yield from _places(content[key])


def _files(folder):
    return sorted(Path(place) / name for place, _, names in os.walk(folder) for name in names if name != "lock")


def rehashed(folder: Path, content=None) -> None:
    """Give the manifest, or this one, the hashes of the files as they are now, and its own."""
    path = folder / manifests.MANIFEST
    if content is None:
        try:
            content = json.loads(path.read_text())
            for entry in [*content["segments"], *filter(None, content["checkpoints"]), content["final"]]:
                if entry is not None:
                    entry["sha256"] = hashlib.sha256((folder / entry["file"]).read_bytes()).hexdigest()
        except (OSError, ValueError, KeyError, TypeError):
            return
    if isinstance(content, dict):
        content.pop("sha256", None)
        content["sha256"] = hashlib.sha256(json.dumps(content).encode()).hexdigest()
    for name in (manifests.MANIFEST, manifests.COPY):
        (folder / name).write_text(json.dumps(content))


def _with_other_arrays(content: bytes, chance: random.Random) -> bytes:
    """An npz file in which one array says that it is another, or is another."""
    with zipfile.ZipFile(io.BytesIO(content)) as bundle:
        members = {entry.filename: bundle.read(entry) for entry in bundle.infolist()}
    name = chance.choice(list(members))
    if not name.endswith(".npy"):
        members[name] = json.dumps(chance.choice(VALUES)).encode()
    elif chance.random() < 0.5:
        text = f"{{'descr': {_described(chance)}, 'fortran_order': {chance.random() < 0.3}, "
        text += f"'shape': {chance.choice(SHAPES)}, }}"
        members[name] = npy(text, members[name][128:])
    elif chance.random() < 0.2:
        del members[name]
    else:
        shape = chance.choice([each for each in SHAPES if -1 not in each and np.prod(each, dtype=float) < 1e3])
        stream = io.BytesIO()
        np.lib.format.write_array(stream, np.full(shape, chance.choice((0.0, -1.0, 1e308, np.nan, np.inf))))
        members[name] = stream.getvalue()
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as bundle:
        for each, data in members.items():
            bundle.writestr(each, data)
    return stream.getvalue()


def npy(header: str, data: bytes) -> bytes:
    """An npy stream with any text for its header."""
    text = header.encode()
    text += b" " * (-(len(text) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + data


def _described(chance):
    kind = chance.choice(DTYPES)
    return kind if kind.startswith("[") else repr(kind)
