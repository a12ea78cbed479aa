"""Standard problems with SWIFT (Schaller et al. 2024, MNRAS 530, 2378): the same particles, in its own files.

SWIFT is neither part of this package nor needed by it. Its scheme SPHENIX (Borrow et al. 2022, MNRAS 511, 2367) is
built by

    ./configure --disable-mpi --disable-hand-vec --with-hydro=sphenix --with-kernel=quartic-spline \\
        --with-hydro-dimension=3 --with-adiabatic-index=5/3 --with-ext-potential=point-mass-softened

Boxes that are thinner than three of its cells are repeated, which does not change the flow.
"""

import subprocess
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
from scipy.spatial import KDTree

from astroinertia.test_problems.keplerian_disc import SOFTENING
from astroinertia.test_problems.matter import Matter

REACH = 2.018932  # of the quartic spline, in SWIFT's smoothing lengths (Dehnen & Aly 2012, table 1)
LARGE = 4.0  # side of the box around matter that ends by itself
GRAVITY = 6.67430e-8  # SWIFT's constant in these units: the point mass is to have G M = 1
STEPS = 50  # at least, in a run
UNITS = """\
InternalUnitSystem:
  UnitMass_in_cgs: 1
  UnitLength_in_cgs: 1
  UnitVelocity_in_cgs: 1
  UnitCurrent_in_cgs: 1
  UnitTemp_in_cgs: 1
"""
# Courant number and the rest as in SWIFT's own examples.
PARAMETERS = (
    UNITS
    + """\
Scheduler:
  max_top_level_cells: 64
TimeIntegration:
  time_begin: 0.
  time_end: {end}
  dt_min: 1e-12
  dt_max: {longest}
Snapshots:
  basename: flow
  time_first: 0.
  delta_time: {every}
Statistics:
  delta_time: {end}
SPH:
  resolution_eta: {eta}
  CFL_condition: 0.1
  h_max: {widest}
InitialConditions:
  file_name: start.hdf5
  periodic: 1
PointMassPotential:
  useabspos: 1
  position: [{middle}, {middle}, {middle}]
  mass: {mass}
  timestep_mult: 0.03
  softening: {softening}
"""
)


def run(
    program: Path, folder: Path, matter: Matter, lengths: np.ndarray, neighbours: float, end: float, every: float,
    attracted: bool = False, room: float = 3.5,
) -> list[SimpleNamespace]:  # fmt: skip
    """Flows (time, position, velocity, density, pressure, mass) of the first copy of the box, in the order given.

    attracted: by the point mass; room: how many reaches of the kernel the box must have, for which it is repeated.
    """
    folder.mkdir(parents=True, exist_ok=True)
    boxed = bool(np.isfinite(lengths).all())
    size = lengths if boxed else np.full(3, LARGE)
    eta = (neighbours * 3.0 / (4.0 * np.pi)) ** (1 / 3) / REACH
    widest = KDTree(matter.position).query(matter.position, k=2)[0][:, 1].max()  # spacing of the thinnest gas
    copies = np.maximum(np.ceil(room * REACH * eta * widest / size), 1).astype(int) if boxed else np.ones(3, int)
    cells = np.stack(np.meshgrid(*(np.arange(n) for n in copies), indexing="ij"), axis=-1).reshape(-1, 3)
    home = np.mod(matter.position + 0.5 * size, size)
    position = np.concatenate([home + cell * size for cell in cells])
    write_start(folder / "start.hdf5", position, matter, len(cells), size * copies, eta * widest)
    given = {"end": end, "every": every, "longest": end / STEPS, "eta": eta, "middle": LARGE / 2, "mass": 1 / GRAVITY}
    given["widest"] = 0.3 * float((size * copies).min()) / REACH  # lone particles that fly off
    (folder / "flow.yml").write_text(PARAMETERS.format(**given, softening=SOFTENING))
    flags = ["--external-gravity"] if attracted else []
    command = [str(program.absolute()), "--hydro", "--limiter", *flags, "--threads=1", "flow.yml"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"SWIFT says: {done.stdout[-500:]} {done.stderr[-500:]}")
    return [_read(path, len(matter.mass), size) for path in sorted(folder.glob("flow_????.hdf5"))]


def write_start(path: Path, position: np.ndarray, matter: Matter, copies: int, size: np.ndarray, h: float) -> None:
    count = len(position)
    with h5py.File(path, "w") as file:
        header = file.create_group("/Header").attrs
        header["BoxSize"], header["Dimension"] = size, 3
        header["NumPart_Total"] = header["NumPart_ThisFile"] = np.array([count, 0, 0, 0, 0, 0])
        header["NumPart_Total_HighWord"], header["MassTable"] = np.zeros(6, int), np.zeros(6)
        header["Time"], header["NumFilesPerSnapshot"], header["Flag_Entropy_ICs"] = 0.0, 1, 0
        units = file.create_group("/Units").attrs
        for name in ("length in cgs (U_L)", "mass in cgs (U_M)", "time in cgs (U_t)", "current in cgs (U_I)"):
            units[f"Unit {name}"] = 1.0
        units["Unit temperature in cgs (U_T)"] = 1.0
        group = file.create_group("/PartType0")
        group["Coordinates"] = position
        group["Velocities"] = np.concatenate([matter.velocity] * copies).astype("f")
        group["Masses"] = np.concatenate([matter.mass] * copies).astype("f")
        group["InternalEnergy"] = np.concatenate([matter.internal_energy] * copies).astype("f")
        group["SmoothingLength"] = np.full(count, h, "f")
        group["ParticleIDs"] = np.arange(1, count + 1, dtype="L")


def _read(path: Path, count: int, size: np.ndarray) -> SimpleNamespace:
    names = {"position": "Coordinates", "velocity": "Velocities", "density": "Densities", "pressure": "Pressures"}
    with h5py.File(path) as file:
        group = file["/PartType0"]
        chosen = np.argsort(group["ParticleIDs"][:])[:count]
        arrays = {name: group[key][:][chosen].astype(float) for name, key in (names | {"mass": "Masses"}).items()}
        time = float(file["/Header"].attrs["Time"][0])
    arrays["position"] -= 0.5 * size
    return SimpleNamespace(time=time, **arrays)
