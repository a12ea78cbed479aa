"""Exported snapshots as other programs read them: mass, L and I of what they hand back are those of the dataset.

Each program is in the extra interop-test, and its cases are skipped where it is not installed.
"""

from pathlib import Path

import numpy as np
import pytest

import astroinertia
from astroinertia.inertia import tensor
from astroinertia.inertia.spin import angular_momentum
from astroinertia.interop.export import export

SCENE = Path(__file__).parents[2] / "sims" / "pulsar_collapse.toml"
SETTINGS = ["body.particles=150", "time.end=10 ms", 'output.snapshot_every="5 ms"']
ROUND_OFF = 1e-12

pytestmark = pytest.mark.filterwarnings("ignore")  # of the other programs, of which there are many


def by_pynbody(path):
    pynbody = pytest.importorskip("pynbody")
    gas = pynbody.load(str(path)).gas
    return (np.asarray(gas[name].in_units(unit)) for name, unit in (("mass", "kg"), ("pos", "m"), ("vel", "m s**-1")))


def by_swiftsimio(path):
    gas = pytest.importorskip("swiftsimio").load(str(path)).gas
    return gas.masses.to_value("kg"), gas.coordinates.to_value("m"), gas.velocities.to_value("m/s")


def by_yt(path):
    yt = pytest.importorskip("yt")
    yt.set_log_level("error")
    with_units = {"UnitLength_in_cm": 100.0, "UnitMass_in_g": 1000.0, "UnitVelocity_in_cm_per_s": 100.0}
    all_data = yt.load(str(path), unit_base=with_units).all_data()
    units = {"Masses": "kg", "Coordinates": "m", "Velocities": "m/s"}
    return (all_data["PartType0", name].to_value(unit) for name, unit in units.items())


def by_sarracen(path):
    table = pytest.importorskip("sarracen").read_csv(str(path), comment="#")
    return table["mass"].values, table[["x", "y", "z"]].values, table[["vx", "vy", "vz"]].values


def by_vtk(path):
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    found = reader.GetOutput()
    assert found.GetNumberOfVerts() == found.GetNumberOfPoints()
    mass, velocity = (vtk_to_numpy(found.GetPointData().GetArray(name)) for name in ("mass", "velocity"))
    return mass, vtk_to_numpy(found.GetPoints().GetData()), velocity


CASES = [
    ("gadget", by_pynbody),
    ("gadget", by_yt),
    ("swift", by_pynbody),
    ("swift", by_swiftsimio),
    ("csv", by_sarracen),
    ("vtk", by_vtk),
]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "core"
    astroinertia.run_scene(astroinertia.load(SCENE, SETTINGS), folder)
    return folder


@pytest.mark.parametrize(("to", "read"), CASES, ids=lambda value: getattr(value, "__name__", value))
def test_mass_angular_momentum_and_inertia_are_those_of_the_dataset(to, read, tmp_path, request):
    pytest.importorskip(read.__name__.removeprefix("by_"))  # before anything is run
    run = request.getfixturevalue("run")
    (path,) = export(run, to, "last", tmp_path)
    mass, position, velocity = (np.array(each, dtype=float) for each in read(path))
    last = astroinertia.open(run).isel(time=-1)
    assert float(last.inertia.snapshots["snapshot_time"][-1]) == float(last["time"])
    centre = tensor.centre_of_mass(mass, position)
    own = tensor.inertia_tensor(mass, position, centre)
    np.testing.assert_allclose(mass.sum(), last["mass"], rtol=ROUND_OFF)
    np.testing.assert_allclose(own, last["inertia_tensor"], rtol=0, atol=ROUND_OFF * np.abs(own).max())
    spin = angular_momentum(mass, position - centre, velocity - (mass @ velocity) / mass.sum())
    scale = (mass * np.linalg.norm(position, axis=1) * np.linalg.norm(velocity, axis=1)).sum()
    np.testing.assert_allclose(spin, last["angular_momentum"], rtol=0, atol=ROUND_OFF * scale)
    assert np.linalg.norm(spin) > 1e-2 * scale  # it turns, so that a velocity of zero would be seen
