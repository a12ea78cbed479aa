"""Bodies driven to a prescribed elongation and orientation, in space and in a plane, keep their momentum."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from astroinertia.cli.main import main
from astroinertia.errors import SceneError
from astroinertia.models.sph.evolution import Particles
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.record import series_record
from tests.evolve import evolve, prepared

SCENE = """
name = "made_to_order"
units = "code"
[body]
kind = "uniform"
particles = 200
mass = 2.0
radius = 1.0
axes = [1.0, 0.8, 0.9]
placement = "random"
relax = false
velocity_gradient = [[0.1, -0.4, 0.0], [0.4, 0.0, 0.2], [0.0, -0.2, -0.1]]
[equation_of_state]
kind = "ideal"
[effects.target_tensor]
stiffness = 100.0
{options}
{damping}
[time]
end = 4.0
"""
DAMPED = "[effects.damping]\ntime_scale = 0.1\n[numerics]\nmax_timestep = 0.02"
AXES = "first_axis = [1.0, 1.0, 0.5]\nsecond_axis = [-1.0, 1.5, 0.25]"  # which is along [-11.5, 11, 1] across the first


def driven(options: str, damping: str = DAMPED, end: float = 4.0) -> tuple[dict[str, Any], dict[str, Any]]:
    """The first and last record of a body driven from an ellipsoid that turns, off the origin and moving."""
    start = prepared(SCENE.format(options=options, damping=damping))
    state = start.state
    moved, arrangement = initial_state(
        start.problem, state.mass, state.position + (3.0, -2.0, 1.0), state.velocity + (0.2, 0.1, -0.3), state.entropy
    )
    start = Particles(start.problem, moved, arrangement, start.end)
    return series_record(start.problem, arrangement, moved, None), evolve(start, [end])[-1]


def ratios_and_axes(second_moment: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Semi-axes over the longest, descending, and their directions as rows."""
    values, vectors = np.linalg.eigh(second_moment)
    lengths = np.sqrt(np.maximum(values[::-1], 0.0))
    return lengths / lengths[0], vectors[:, ::-1].T


def momentum_change(first: dict[str, Any], last: dict[str, Any]) -> float:
    return np.linalg.norm(last["momentum"] - first["momentum"]) / np.linalg.norm(first["momentum"])


@pytest.mark.full
def test_a_body_reaches_a_prescribed_elongation_and_orientation() -> None:
    first, last = driven(f"axis_ratios = [2.0, 1.0, 1.4]\n{AXES}")
    ratios, axes = ratios_and_axes(last["second_moment"])
    np.testing.assert_allclose(ratios, [1.0, 0.7, 0.5], rtol=1e-6)
    long, short = np.array([1.0, 1.0, 0.5]), np.array([-11.5, 11.0, 1.0])
    assert abs(axes[0] @ long) / np.linalg.norm(long) > 1.0 - 1e-9
    assert abs(axes[2] @ short) / np.linalg.norm(short) > 1.0 - 1e-9
    assert momentum_change(first, last) < 1e-12
    assert np.linalg.norm(last["momentum"]) > 0.5  # it moves all the while


def test_a_body_reaches_prescribed_moments() -> None:
    first, last = driven(f"moments = [1.0, 1.6, 1.9]\n{AXES}\norientation_stiffness = 30.0")
    np.testing.assert_allclose(np.linalg.eigvalsh(last["inertia_tensor"]), [1.0, 1.6, 1.9], rtol=1e-6)
    axis = np.array([1.0, 1.0, 0.5]) / 1.5  # of the least moment
    np.testing.assert_allclose(last["inertia_tensor"] @ axis, 1.0 * axis, rtol=1e-5)
    assert momentum_change(first, last) < 1e-12


@pytest.mark.full
def test_the_shadow_on_a_plane_is_driven_and_nothing_across_it() -> None:
    normal = np.array([0.0, 0.6, 0.8])
    options = "axis_ratios = [3.0, 1.0, 1.0]\nfirst_axis = [0.6, 0.64, -0.48]\nsecond_axis = [0.8, -0.48, 0.36]"
    options += "\nnormal = [0.0, 0.6, 0.8]"
    first, last = driven(options)
    plane = np.array([[0.6, 0.64, -0.48], [0.8, -0.48, 0.36]])
    shadow = plane @ last["second_moment"] @ plane.T
    np.testing.assert_allclose(shadow[0, 0] / shadow[1, 1], 9.0, rtol=1e-5)
    assert abs(shadow[0, 1]) < 1e-5 * shadow[0, 0]
    assert momentum_change(first, last) < 1e-12
    # Undamped, what moves along the normal moves freely: Q_nn follows from Q, P and K of the start.
    first, last = driven(options, damping="", end=2.0)
    second, mixed, kinetic = (
        normal @ first[name] @ normal for name in ("second_moment", "mixed_moment", "kinetic_tensor")
    )
    assert normal @ last["second_moment"] @ normal == pytest.approx(second + 4.0 * mixed + 4.0 * kinetic, rel=1e-11)


def test_a_free_orientation_conserves_angular_momentum_and_a_given_one_does_not() -> None:
    first, last = driven("axis_ratios = [2.0, 1.0, 1.5]", damping="", end=1.0)
    size = np.linalg.norm(first["angular_momentum"])
    assert np.linalg.norm(last["angular_momentum"] - first["angular_momentum"]) < 1e-12 * size
    assert momentum_change(first, last) < 1e-12
    first, last = driven(f"axis_ratios = [2.0, 1.0, 1.5]\n{AXES}", damping="", end=1.0)
    assert np.linalg.norm(last["angular_momentum"] - first["angular_momentum"]) > 0.1 * size
    assert momentum_change(first, last) < 1e-12


@pytest.mark.full
def test_energy_is_conserved_to_second_order_in_the_step() -> None:
    errors = []
    for step in (0.004, 0.002):
        first, last = driven(f"axis_ratios = [2.0, 1.0, 1.4]\n{AXES}", f"[numerics]\nmax_timestep = {step}", 0.5)
        errors.append(last["total_energy"] - first["total_energy"])
        assert errors[-1] == pytest.approx(last["integration_energy_error"], abs=1e-11 * first["total_energy"])
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.2)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ("", "needs one of axis_ratios and moments"),
        ("axis_ratios = [1.0, 1.0, 2.0]\nmoments = [1.0, 1.0, 1.0]", "needs one of axis_ratios and moments"),
        ("moments = [1.0, 2.1, 1.0]", r"no body has these moments: 1 \+ 1 < 2\.1"),
        ("moments = [0.0, 0.0, 0.0]", "must not all be zero"),
        ("axis_ratios = [1.0, 1.0, 2.0]\nfirst_axis = [1.0, 0.0, 0.0]", "needs both first_axis and second_axis"),
        ("axis_ratios = [1.0, 1.0, 2.0]\norientation_stiffness = 1.0", "needs first_axis and second_axis"),
        (
            "axis_ratios = [1.0, 1.0, 2.0]\nfirst_axis = [1.0, 1.0, 0.0]\nsecond_axis = [2.0, 2.0, 0.0]",
            "must not be parallel",
        ),
        ("axis_ratios = [1.0, 0.0, 2.0]", "must be more than 0"),
        ("axis_ratios = [1.0, 1.0, 2.0]\nnormal = [0.0, 0.0, 0.0]", "zero length"),
        (
            "moments = [0.0, 0.2, 0.2]\nfirst_axis = [0.0, 0.0, 1.0]\nsecond_axis = [1.0, 0.0, 0.0]\n"
            "normal = [0.0, 0.0, 1.0]",
            "no extent in the plane across normal",
        ),
    ],
)
def test_impossible_targets_are_refused(options: str, sentence: str) -> None:
    with pytest.raises(SceneError, match=sentence):
        prepared(SCENE.format(options=options, damping=DAMPED))


@pytest.mark.full
def test_the_star_made_to_order_runs_and_is_shown(tmp_path: Path) -> None:
    """It starts at rest and is turned: no scaling law has a spin to begin with."""
    scene = Path(__file__).parents[2] / "sims" / "made_to_order.toml"
    settings = ["--set", "body.particles=150", "--set", "time.end=0.3"]
    assert main(["run", str(scene), "--output", str(tmp_path / "run"), *settings]) == 0
    assert main(["show", str(tmp_path / "run")]) == 0
    assert {"ledger.png", "spin.png", "shape.png"} <= {path.name for path in (tmp_path / "run").iterdir()}
