"""The exact families of affine bodies, from scene to record, against independent integrations of their equations."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from astroinertia.bodies import roche
from astroinertia.build import ellipsoid as start_ellipsoid
from astroinertia.scene import load, plan
from tests import affine_scenes
from tests.affine_scenes import semi_axes, started
from tests.evolve import advanced

REFERENCE = Path(__file__).parent.parent / "reference"
TIGHT = 1e-11  # of the 1e-9: measured 3e-13 at most
SCALARS = {"Lz": "angular_momentum", "K": "kinetic_energy", "W": "gravitational_energy", "U": "internal_energy"}
SCALARS |= {"E": "total_energy"}
# Neither along an axis nor symmetric: the axes tilt in all directions.
TILTED = np.array([[0.2, -0.7, 0.3], [0.4, -0.1, -0.5], [-0.6, 0.2, -0.1]])


def reference(name: str) -> dict[str, Any]:
    for path in (REFERENCE / each for each in ("riemann.json", "dyson.json", "toy_star.json", "cold.json")):
        entries = json.loads(path.read_text())
        for entry in entries if isinstance(entries, list) else [entries]:
            if entry["name"] == f"{name}_visible":
                return entry
    raise KeyError(name)


def scene_of(entry: dict[str, Any]) -> str:
    inputs = entry["inputs"]
    axes, gradient, given = np.diag(inputs["F0"]), inputs["L0"], inputs["par"]
    if inputs["family"] == "A":
        return affine_scenes.compressible(axes, gradient, given["gamma"], given["eps0"])
    if inputs["family"] == "B":
        return affine_scenes.isentropic(axes, gradient, given["gamma"], given["h0"], given["k"])
    return {"C": affine_scenes.cold, "D": affine_scenes.incompressible}[inputs["family"]](axes, gradient)


@pytest.mark.full
@pytest.mark.parametrize("name", ["riemann_A", "dyson_B", "toystar3d_B", "dirichlet_D", "cold_C"])
def test_exact_family_from_scene_to_record(name: str) -> None:
    entry = reference(name)
    body, opening = started(scene_of(entry)), None
    assert body.approximation.startswith("exact")
    for row in entry["value"]:
        if row["t"] > 0:
            advanced(body, row["t"])
        record = body.record(opening)
        opening = record["potential_energy"]
        second, inertia = record["second_moment"], record["inertia_tensor"]
        found = [second[0, 0], second[1, 1], second[2, 2], second[0, 1]]
        np.testing.assert_allclose(found, row["I_second_moment"], rtol=TIGHT, atol=TIGHT * inertia[2, 2])
        np.testing.assert_allclose(semi_axes(body), row["a"], rtol=TIGHT)
        np.testing.assert_allclose(np.diag(inertia), [row["Ixx"], row["Iyy"], row["Izz"]], rtol=TIGHT)
        for here, there in SCALARS.items():
            if here in row:
                value = record[there][2] if here == "Lz" else record[there]
                np.testing.assert_allclose(value, row[here], rtol=TIGHT, err_msg=f"{here} at {row['t']}")
        assert record["ledger_closure"] < 1e-13
        assert record["virial_mismatch"].max() < 1e-15
        scale = max(abs(row["K"]), abs(row.get("W", 0.0)), abs(row.get("U", 0.0)))
        assert abs(record["integration_energy_error"]) < 1e-12 * scale


def integrated(acceleration: Callable, start: np.ndarray, gradient: Any, until: float) -> np.ndarray:
    """F at a time, by scipy's integrator from d2F/dt2 of F."""

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        at, moving = y.reshape(2, 3, 3)
        return np.concatenate([moving.ravel(), acceleration(at, moving).ravel()])

    first = np.concatenate([start.ravel(), (np.asarray(gradient) @ start).ravel()])
    return solve_ivp(rate, (0, until), first, method="DOP853", rtol=1e-13, atol=1e-14).y[:9, -1].reshape(3, 3)


@pytest.mark.full
def test_tilted_compressible_body() -> None:
    axes, gamma, central = np.array([1.3, 0.9, 0.7]), 1.4, 0.3
    # U = (2/5) central/(gamma - 1) (J/J_0)^(1 - gamma) of unit mass, and q = 1/5.
    volume = axes.prod()

    def acceleration(at: np.ndarray, _: np.ndarray) -> np.ndarray:
        ratio = np.linalg.det(at) / volume
        return affine_scenes.gravity_of(at) + 2.0 * central * ratio ** (1 - gamma) * np.linalg.inv(at).T

    rows = Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix()
    body = started(affine_scenes.compressible(axes, TILTED, gamma, central), f"body.axes_at_start={rows.tolist()}")
    advanced(body, 1.7)
    wanted = integrated(acceleration, rows.T @ np.diag(axes) @ rows, TILTED, 1.7)
    np.testing.assert_allclose(body.state.deformation, wanted, atol=1e-11)


@pytest.mark.full
def test_tilted_incompressible_body_keeps_volume_circulation_and_all_it_should() -> None:
    axes, still = np.array([1.25, 1.0, 0.8]), TILTED
    gradient = still - np.trace(still) / 3 * np.eye(3)

    def acceleration(at: np.ndarray, moving: np.ndarray) -> np.ndarray:
        free, inverse = affine_scenes.gravity_of(at), np.linalg.inv(at)
        flow = moving @ inverse
        push = (np.trace(flow @ flow) - np.trace(inverse @ free)) / np.trace(inverse @ inverse.T)
        return free + push * inverse.T

    body = started(affine_scenes.incompressible(axes, gradient))
    first = body.record(None)
    advanced(body, 2.0)
    np.testing.assert_allclose(
        body.state.deformation, integrated(acceleration, np.diag(axes), gradient, 2.0), atol=2e-11
    )
    opening = np.array(body.state.deformation).T @ np.array(body.state.rate)
    for until in (100.0, 200.0):
        advanced(body, until)
    last = body.record(first["potential_energy"])
    closing = np.array(body.state.deformation).T @ np.array(body.state.rate)
    assert abs(np.linalg.det(np.array(body.state.deformation)) - axes.prod()) < 1e-12
    np.testing.assert_allclose(last["angular_momentum"], first["angular_momentum"], atol=1e-11)
    np.testing.assert_allclose(closing - closing.T, opening - opening.T, atol=1e-10)
    np.testing.assert_allclose(last["total_energy"], first["total_energy"], rtol=1e-11)
    assert np.isnan(last["internal_energy"]) and "incompressible" in body.absent["internal_energy"]


def test_a_checkpoint_goes_on_bit_for_bit() -> None:
    scene = load.loads(affine_scenes.compressible([1.3, 0.9, 0.7], TILTED, 1.4, 0.3))
    units = plan.code_units(scene)
    with jax.enable_x64(True):
        whole = start_ellipsoid.evolution(scene, units)
        advanced(whole, 0.4)
        again = start_ellipsoid.resumed(scene, units, whole.arrays())
        for body in (whole, again):
            advanced(body, 0.9)
    one, other = whole.record(0.0), again.record(0.0)
    assert one.keys() == other.keys()
    assert all(np.array_equal(np.asarray(one[name]), np.asarray(other[name]), equal_nan=True) for name in one)


@pytest.mark.parametrize("mass_ratio", [pytest.param(mass_ratio, marks=pytest.mark.full) for mass_ratio in (0.01, 1.0)])
def test_a_roche_ellipsoid_keeps_pointing_at_its_companion(mass_ratio: float) -> None:
    """A figure of Roche 2 % outside the limit, in the tide of a companion on the circular orbit that goes with it."""
    figure = roche.at_distance(mass_ratio, 1.02 * roche.limit(mass_ratio).scaled_distance)
    spin, distance = figure.angular_velocity, figure.distance
    gradient = spin * np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    tide = f"[effects.tide]\nmass = {1 / mass_ratio!r}\nposition = [{distance!r}, 0.0, 0.0]\n"
    tide += f"period = {2 * np.pi / spin!r}\n"
    body = started(affine_scenes.incompressible(figure.axes, gradient, tide))
    advanced(body, 10.0)
    np.testing.assert_allclose(semi_axes(body), figure.axes, rtol=1e-10)
    left = np.linalg.svd(np.array(body.state.deformation))[0][:, 0]
    assert abs(np.sin(np.arctan2(left[1], left[0]) - spin * 10.0)) < 1e-10
    np.testing.assert_allclose(body.state.centre, 0.0, atol=1e-15)
