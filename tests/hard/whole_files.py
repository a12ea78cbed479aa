"""Small files of every kind that the package reads, all of them whole: what malformed ones are made of."""

import shutil
from importlib.util import find_spec
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import rebound
import trimesh

from astroinertia import dataset
from astroinertia.run.loop import run_scene
from astroinertia.scene import load, sweep
from astroinertia.storage.archive import Archive
from astroinertia.sweeps import ensemble
from tests import phantom_dump

ROOT = Path(__file__).parents[2]
SCENE = """\
name = "core"
model = "scaling"
[body]
kind = "power_law"
exponent = 1.0
mass = "1.4 Msun"
radius = "1500 km"
[body.rotation]
period = "30 s"
[effects.gravity]
[time]
end = "0.2 s"
[output]
series_every = "0.1 s"
checkpoint_seconds = 0.0
"""
SWEEP = '[sweep]\n"body.mass" = ["1 Msun", "2 Msun"]\n'
ROWS = 30


def whole_files(folder: Path, few: bool = False) -> list[tuple[str, Path]]:
    """Kind (a reader of malformed_child.py) and path of each; few: without those that take longer to make."""
    made = [*_tables(folder), *text_files(folder), *_meshes(folder), *orbit_files(folder)]
    return [*made, *_results(folder)] + ([] if few else _folders(folder))


def columns() -> dict[str, np.ndarray]:
    random = np.random.default_rng(1)
    return {"mass": np.full(ROWS, 2.0), **{name: random.normal(size=ROWS) for name in ("x", "y", "z", "vx")}}


def _tables(folder):
    own = columns()
    names, rows = ",".join(own), np.stack(list(own.values()), axis=1)
    np.savetxt(folder / "table.csv", rows, delimiter=",", header=f"{names}", comments="", fmt="%.9g")
    np.savez_compressed(folder / "table.npz", **own)
    with h5py.File(folder / "table.h5", "w") as file:
        for name, column in own.items():
            file.create_dataset(name, data=column, compression="gzip", chunks=(10,))
    with h5py.File(folder / "fields.h5", "w") as file:
        file["particles"] = np.rec.fromarrays(list(own.values()), names=names)
    with h5py.File(folder / "gadget.hdf5", "w") as file:
        header = file.create_group("Header")
        header.attrs["NumFilesPerSnapshot"], header.attrs["MassTable"] = 1, [2.0, 0, 0, 0, 0, 0]
        header.attrs.update({"UnitLength_in_cm": 3e21, "UnitMass_in_g": 2e43, "UnitVelocity_in_cm_per_s": 1e5})
        file["PartType0/Coordinates"] = file["PartType0/Velocities"] = rows[:, 1:4]
    for name, form in (("table.nc", "NETCDF4"), ("classic.nc", "NETCDF3_CLASSIC"), ("wide.nc", "NETCDF3_64BIT_OFFSET")):
        with netCDF4.Dataset(folder / name, "w", format=form) as file:
            file.createDimension("particle", ROWS)
            for column, values in own.items():
                file.createVariable(column, "f8", ("particle",))[:] = values
    names = ("table.csv", "table.npz", "table.h5", "fields.h5", "gadget.hdf5", "table.nc", "classic.nc", "wide.nc")
    density, energy = (each.ravel() for each in np.meshgrid(np.geomspace(1, 9, 5), np.geomspace(1, 4, 5)))
    grid = {"density": density, "internal_energy": energy, "pressure": density * energy}
    np.savez(folder / "equation.npz", **grid)
    np.savetxt(
        folder / "equation.csv",
        np.stack(list(grid.values()), axis=1),
        delimiter=",",
        header=",".join(grid),
        comments="",
    )
    equations = [("equation", folder / f"equation.{suffix}") for suffix in ("npz", "csv")]
    tables = [("table" if k % 2 else "matter", folder / name) for k, name in enumerate(names)]
    return tables + equations + (_dump(folder) if find_spec("sarracen") else [])


def _dump(folder):
    """A dump of Phantom with a sink; sarracen, an extra, reads it."""
    sink = {5: {name: [1.0] for name in ("x", "y", "z", "vx", "vy", "vz", "m")}}
    content = phantom_dump.dump(phantom_dump.header(), phantom_dump.gas(), sink)
    (folder / "star_00010").write_bytes(content)
    return [("matter", folder / "star_00010")]


def text_files(folder):
    (folder / "scene.toml").write_text(SCENE)
    (folder / "sweep.toml").write_text(SCENE.replace("[body]", f"{SWEEP}[body]", 1))
    radius = np.linspace(1, 9, 12)
    rows = "\n".join(f"{r:.6g},{r**3:.9g},{9 - r:.3g}" for r in radius)
    (folder / "profile.csv").write_text(f"radius (km), mass (kg), omega (rad/s)\n{rows}\n")
    for name, cut in (("example_mesa_profile.data", 30), ("example_kepler_presn", 30)):
        lines = (ROOT / "data" / name).read_text().splitlines()
        (folder / name).write_text("\n".join(lines[:cut]) + "\n")
    profiles = ("profile.csv", "example_mesa_profile.data", "example_kepler_presn")
    return [("scene", folder / "scene.toml"), ("scene", folder / "sweep.toml")] + [
        ("profile", folder / name) for name in profiles
    ]


def _meshes(folder):
    mesh = trimesh.creation.icosphere(subdivisions=0)
    for suffix in ("stl", "ply", "obj", "off"):
        mesh.export(folder / f"mesh.{suffix}")
    mesh.export(folder / "text.stl", file_type="stl_ascii")
    (folder / "text.ply").write_bytes(trimesh.exchange.ply.export_ply(mesh, encoding="ascii"))
    names = ("mesh.stl", "mesh.ply", "mesh.obj", "mesh.off", "text.stl", "text.ply")
    return [("matter", folder / name) for name in names]


def orbit_files(folder):
    bodies = rebound.Simulation()
    bodies.add(m=1.0)
    bodies.add(m=1e-3, a=1.0, e=0.1)
    for time in range(3):
        bodies.integrate(float(time))
        bodies.save_to_file(str(folder / "orbits.bin"), delete_file=time == 0)
    return [("orbits", folder / "orbits.bin")]


def _results(folder):
    """A finished run with particles: as it is, without the line behind its end, and as folders."""
    unfinished, finished = folder / "unfinished", folder / "finished"
    for place in (unfinished, finished):
        shutil.copytree(ROOT / "tests" / "data" / "format_2_run", place)
    with Archive.open(finished) as archive:
        file = dataset.finish(archive)
    content = file.read_bytes()
    (folder / "result.nc").write_bytes(content)
    (folder / "foreign.nc").write_bytes(content[: content.rindex(b"\nastroinertia-sha256")])
    return [("result", folder / "result.nc"), ("result", folder / "foreign.nc"), ("run", unfinished), ("run", finished)]


def _folders(folder):
    run_scene(load.loads(SCENE), folder / "core")
    asked = sweep.loads(SCENE.replace("[body]", f"{SWEEP}[body]", 1))
    ensemble.run_sweep(asked, folder / "sweep")
    return [("run", folder / "core"), ("sweep", folder / "sweep")]
