"""Exported snapshots as other programs read them: mass, L and I of what they hand back are those of the dataset.

Files are opened without any argument. Each program is in the extra interop-test, and its cases are skipped where it is
not installed.
"""

import warnings
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
    whole = pytest.importorskip("pynbody").load(str(path))
    gas = whole.gas
    units = {"mass": "kg", "pos": "m", "vel": "m s**-1"}
    read = [np.asarray(gas[name].in_units(unit)) for name, unit in units.items()]
    return (*read, whole.properties["time"].in_units("s"))


def by_swiftsimio(path):
    whole = pytest.importorskip("swiftsimio").load(str(path))
    gas = whole.gas
    masses, places = gas.masses.to_value("kg"), gas.coordinates.to_value("m")
    return masses, places, gas.velocities.to_value("m/s"), whole.metadata.time.to_value("s")


def by_yt(path):
    yt = pytest.importorskip("yt")
    yt.set_log_level("error")
    whole = yt.load(str(path))
    gas = whole.all_data()
    units = {"Masses": "kg", "Coordinates": "m", "Velocities": "m/s"}
    read = [gas["PartType0", name].to_value(unit) for name, unit in units.items()]
    return (*read, whole.current_time.to_value("s"))


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


def test_pynbody_finds_the_units_of_gadget_files(tmp_path, request):
    pynbody = pytest.importorskip("pynbody")
    (path,) = export(request.getfixturevalue("run"), "gadget", "last", tmp_path)
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message=".*units")
        gas = pynbody.load(str(path)).gas
        found = {name: gas[name].units for name in ("pos", "vel", "mass", "rho", "u", "iord")}
    assert found["u"].ratio("m**2 s**-2") == pytest.approx(1e6)
    assert found["iord"].ratio("1") == 1.0


@pytest.mark.parametrize(("to", "read"), CASES, ids=lambda value: getattr(value, "__name__", value))
def test_mass_angular_momentum_and_inertia_are_those_of_the_dataset(to, read, tmp_path, request):
    pytest.importorskip(read.__name__.removeprefix("by_"))  # before anything is run
    run = request.getfixturevalue("run")
    (path,) = export(run, to, "last", tmp_path)
    mass, position, velocity, *time = (np.array(each, dtype=float) for each in read(path))
    last = astroinertia.open(run).isel(time=-1)
    if time:  # the tables and ParaView's files have none that those programs hand back
        np.testing.assert_allclose(time[0], last["time"], rtol=ROUND_OFF)
    assert float(last.inertia.snapshots["snapshot_time"][-1]) == float(last["time"])
    centre = tensor.centre_of_mass(mass, position)
    own = tensor.inertia_tensor(mass, position, centre)
    np.testing.assert_allclose(mass.sum(), last["mass"], rtol=ROUND_OFF)
    np.testing.assert_allclose(own, last["inertia_tensor"], rtol=0, atol=ROUND_OFF * np.abs(own).max())
    spin = angular_momentum(mass, position - centre, velocity - (mass @ velocity) / mass.sum())
    scale = (mass * np.linalg.norm(position, axis=1) * np.linalg.norm(velocity, axis=1)).sum()
    np.testing.assert_allclose(spin, last["angular_momentum"], rtol=0, atol=ROUND_OFF * scale)
    assert np.linalg.norm(spin) > 1e-2 * scale  # it turns, so that a velocity of zero would be seen
