"""Files that somebody made to do harm: to fill the memory, to read or write elsewhere, to run code, never to end."""

import json
import os
import pickle
import struct
import zipfile
from pathlib import Path

import h5py
import netCDF4
import numpy as np

from astroinertia.storage import manifest as manifests
from tests.hard.malformed_files import npy, rehashed
from tests.hard.whole_files import columns

SECRET = np.array([3.25, 1.0, 2.0, 4.0])


class _RunsCode:
    """What a pickle does when it is read: it makes a file."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.system, (f"touch {self.path}",)


def crafted_files(folder: Path, whole: dict[str, Path], outside: Path, few: bool = False) -> list[tuple[str, Path]]:
    """Kind and path of each; none of them is to be read. outside: a folder that is not to be looked into.

    whole: whole_files.py's by name. few: without those that take longer to make, for they are large.
    """
    with h5py.File(outside / "secret.h5", "w") as file:
        file["snapshots/mass"] = SECRET
        for name in columns():
            file[name] = SECRET
    (outside / "secret.raw").write_bytes(SECRET.tobytes())
    (outside / "secret.csv").write_text("mass,x,y,z\n1,2,3,4\n" * 1)
    made = [*_npz(folder, outside), *_hdf5(folder, outside)]
    if not few:
        made += [*_bombs(folder), *_texts(folder)]
    return [*made, *_meshes(folder, outside), *_runs(folder, whole, outside), *_sweeps(folder, whole, outside)]


def _bombs(folder):
    """Little on the disk that says it is much: zeros that are packed, values that were never written."""
    with zipfile.ZipFile(folder / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as bundle:
        data = npy("{'descr': '<f8', 'fortran_order': False, 'shape': (9000000,), }", bytes(72_000_000))
        bundle.writestr("mass.npy", data)
    for suffix, name in (("h5", "bomb"), ("hdf5", "chunk")):
        with h5py.File(folder / f"{name}.{suffix}", "w") as file:
            for column in columns():
                if name == "bomb":
                    file.create_dataset(column, (9_000_000,), "f8", chunks=(1_000_000,), compression="gzip")
                else:
                    chunks = (20_000_000 if column == "mass" else 10,)
                    file.create_dataset(
                        column, (10,), "f8", np.ones(10), maxshape=(None,), chunks=chunks, compression="gzip"
                    )
    with netCDF4.Dataset(folder / "bomb.nc", "w") as file:
        file.createDimension("particle", 9_000_000)
        for column in columns():
            file.createVariable(column, "f8", ("particle",), compression="zlib")
    with netCDF4.Dataset(folder / "result-bomb.nc", "w") as file:
        file.astroinertia_format = 1
        file.createDimension("time", 2_000_000_000)
        for name in ("time", "mass", "inertia_tensor"):
            file.createVariable(name, "f8", ("time",), compression="zlib")
    made = [("table", folder / name) for name in ("bomb.npz", "bomb.h5", "chunk.hdf5", "bomb.nc")]
    return [*made, ("matter", folder / "bomb.nc"), ("result", folder / "result-bomb.nc")]


def _texts(folder):
    (folder / "line.csv").write_bytes(b"mass,x,y,z\n" + b"1" * 40_000_000)
    (folder / "columns.csv").write_text(",".join(f"c{k}" for k in range(1_000_000)))
    (folder / "wide.csv").write_text("mass,x,y,z\n" + "1," * 500)
    (folder / "latin.csv").write_bytes("mass,x,y,z\n1,2,3,é\n".encode("latin-1"))
    (folder / "quoted.csv").write_text('mass,x,y,z\n"' + "1\n" * 200_000)
    (folder / "lines.csv").write_text("\n" * 10_000_000)
    (folder / "lines.data").write_text("\n" * 10_000_000)
    (folder / "deep.toml").write_text("a = " + "[" * 900)
    (folder / "dotted.toml").write_text("a" + ".a" * 30_000 + " = 1")
    tables = [("table", folder / f"{name}.csv") for name in ("line", "columns", "wide", "latin", "quoted", "lines")]
    profiles = [("profile", folder / name) for name in ("lines.csv", "line.csv", "lines.data", "latin.csv")]
    equations = [("equation", folder / name) for name in ("line.csv", "columns.csv")]
    return [*tables, *profiles, *equations, ("scene", folder / "deep.toml"), ("scene", folder / "dotted.toml")]


def _npz(folder, outside):
    plain = {name: npy("{'descr': '<f8', 'fortran_order': False, 'shape': (30,), }", values.tobytes())
             for name, values in columns().items()}  # fmt: skip
    code = np.array([_RunsCode(outside / "ran")], dtype=object)
    headers = {
        "pickle": npy("{'descr': '|O', 'fortran_order': False, 'shape': (1,), }", pickle.dumps(code)),
        "huge": npy("{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }", b""),
        "wrapped": npy("{'descr': '<f8', 'fortran_order': False, 'shape': (4294967296, 4294967296), }", b""),
        "wide": npy("{'descr': '<U1000000000', 'fortran_order': False, 'shape': (1,), }", b""),
        "code": npy("__import__('os').system('touch ran')", b""),
        "deep": npy("{'descr': " + "(" * 3000 + ")" * 3000 + "}", b""),
        "nothing": b"",
    }
    for name, header in headers.items():
        with zipfile.ZipFile(folder / f"{name}.npz", "w") as bundle:
            for each, data in {**plain, "mass": header}.items():
                bundle.writestr(f"{each}.npy", data)
    with zipfile.ZipFile(folder / "paths.npz", "w") as bundle:
        for each, data in plain.items():
            bundle.writestr(f"{each}.npy", data)
        bundle.writestr("../../outside/escaped.npy", plain["mass"])
    os.mkfifo(folder / "pipe.npz")
    (folder / "device.csv").symlink_to("/dev/zero")
    names = (*headers, "paths", "pipe")
    return [("table", folder / f"{name}.npz") for name in names] + [("table", folder / "device.csv")]


def _hdf5(folder, outside):
    """Links of each kind, data elsewhere, circles, and groups in groups in groups."""
    secret, own = outside / "secret.h5", list(columns())
    made = []
    for suffix in ("h5", "nc"):
        paths = [folder / f"{name}.{suffix}" for name in ("links", "raw", "virtual", "circle", "deep", "soft")]
        with h5py.File(paths[0], "w") as file:
            for name in own:
                file[name] = h5py.ExternalLink(str(secret), name)
        with h5py.File(paths[1], "w") as file:
            for name in own:
                file.create_dataset(name, shape=(4,), dtype="f8", external=[(str(outside / "secret.raw"), 0, 32)])
        with h5py.File(paths[2], "w") as file:
            for name in own:
                layout = h5py.VirtualLayout(shape=(4,), dtype="f8")
                layout[:] = h5py.VirtualSource(str(secret), name, shape=(4,))
                file.create_virtual_dataset(name, layout)
        with h5py.File(paths[3], "w") as file:
            file.create_group("a")["b"] = file["/"]
        with h5py.File(paths[4], "w") as file:
            file["/".join(["g"] * 3000)] = SECRET
        with h5py.File(paths[5], "w") as file:
            file["mass"] = h5py.SoftLink("/mass")
        made += [("table", path) for path in paths]
        made += [(kind, path) for path in paths for kind in ("result", "matter") if suffix == "nc"]
    with h5py.File(folder / "result-links.nc", "w") as file:
        file.attrs["astroinertia_format"] = 1
        file["snapshots"] = h5py.ExternalLink(str(secret), "/snapshots")
    return [*made, ("result", folder / "result-links.nc")]


def _meshes(folder, outside):
    """Counts that no file holds, and names of other files."""
    (folder / "count.stl").write_bytes(bytes(80) + struct.pack("<I", 2**32 - 1) + bytes(50))
    head = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
    coordinates = "".join(f"property double {axis}\n" for axis in "xyz")
    (folder / "count.ply").write_text(
        f"{head}{coordinates}element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    (folder / "counts.ply").write_text(
        head.replace("binary_little_endian", "ascii") + f"{coordinates}end_header\n1 2 3\n"
    )
    (folder / "count.off").write_text("OFF\n4000000000 4000000000 0\n0 0 0\n")
    (folder / "other.obj").write_text(f"mtllib {outside}/secret.csv\nusemtl x\nv 0 0 0\nf 1 1 1\n")
    (folder / "far.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2000000000\n")
    return [("matter", folder / f"{name}") for name in
            ("count.stl", "count.ply", "counts.ply", "count.off", "other.obj", "far.obj")]  # fmt: skip


def _runs(folder, whole, outside):
    made = []

    def run(name, *steps):
        place = folder / name
        place.mkdir()
        for path in whole["unfinished"].iterdir():
            (place / path.name).write_bytes(path.read_bytes())
        content = json.loads((place / manifests.MANIFEST).read_text())
        for step in steps:
            step(place, content)
        rehashed(place, content)
        made.append(("run", place))

    def named(path):
        return lambda place, content: content["segments"][0].update(file=path)

    def linked(name):
        def step(place, content):
            target = outside / f"of-{place.name}"
            target.write_bytes((place / name).read_bytes() if (place / name).exists() else b"precious")
            (place / name).unlink(missing_ok=True)
            (place / name).symlink_to(target)

        return step

    run("up", named("../../outside/secret.csv"))
    run("absolute", named(str(outside / "secret.csv")))
    run("upper-checkpoint", lambda _, content: content["checkpoints"][0].update(file=f"../{outside.name}/secret.csv"))
    run("final", lambda _, content: content.update(final={"file": "../outside/x.nc", "sha256": "", "segments": 2}))
    run("linked", linked("segment-000001.npz"))
    run("linked-checkpoint", linked("checkpoint-000004.npz"))
    run("linked-lock", linked("lock"))
    run("pipe", lambda place, _: ((place / "segment-000001.npz").unlink(), os.mkfifo(place / "segment-000001.npz")))
    run("directory", lambda place, _: ((place / "segment-000001.npz").unlink(), (place / "segment-000001.npz").mkdir()))
    for name, text in (("deep", "[" * 200_000), ("many", "[" + "[]," * 5_000_000 + "[]]"), ("no", "\x00" * 1000)):
        place = folder / f"{name}-json"
        place.mkdir()
        (place / manifests.MANIFEST).write_text(text)
        made.append(("run", place))
    place = folder / "linked-manifest"
    place.mkdir()
    (place / manifests.MANIFEST).symlink_to(whole["unfinished"] / manifests.MANIFEST)
    return [*made, ("run", place)]


def _sweeps(folder, whole, outside):
    if "sweep" not in whole:
        return []
    content = json.loads((whole["sweep"] / "sweep.json").read_text())
    made = []
    changes = {
        "name": {"name": 3}, "version": {"version": "x"}, "members": {"members": [[1, 2, 3]]}, "many": {"axes": [[]]},
        "values": {"members": [["1 Msun"], [{"a": 1}]]}, "keys": {"keys": [["body"]]}, "text": {"text": None},
    }  # fmt: skip
    for name, change in changes.items():
        place = folder / f"sweep-{name}"
        place.mkdir()
        (place / "sweep.json").write_text(json.dumps({**content, **change}))
        made.append(("sweep", place))
    for name in ("deep", "linked"):
        place = folder / f"sweep-{name}"
        place.mkdir()
        (place / "sweep.json").write_text("[" * 200_000 if name == "deep" else json.dumps(content))
        (place / "member-0000").symlink_to(whole["core"])
        made.append(("sweep", place))
    return made
