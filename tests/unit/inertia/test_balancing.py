"""Balancing in two planes: the published case, what balance means for the tensor, and the best choice of holes."""

import itertools
import json
import subprocess
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st

from astroinertia.inertia import balancing
from astroinertia.inertia.body import Body

REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "balancing.json").read_text())
PLANES = (-0.2, 0.3)


def point(mass, place):
    return Body(np.asarray(mass), np.asarray(place, dtype=float), np.zeros((3, 3)))


def wheel(seed=0):
    """A disc with lumps, its centre off the axis and its axes tilted."""
    random = np.random.default_rng(seed)
    body = Body(np.asarray(12.0), np.array([0.0, 0.0, 0.05]), np.diag([0.3, 0.3, 0.55]))
    for mass, place in zip(random.uniform(0.01, 0.2, 4), random.uniform(-0.3, 0.3, (4, 3)), strict=True):
        body = body + point(mass, place)
    return body


def with_corrections(body, mass, angle, radii, planes, sign=1.0):
    for m, phi, radius, z in zip(mass, angle, radii, planes, strict=True):
        body = body + point(sign * m, [radius * np.cos(phi), radius * np.sin(phi), z])
    return body


def test_the_published_case():
    case = REFERENCE[0]
    size, phase, planes = np.array(case["inputs"]["unbalance (m r, phase deg, z)"]).T
    measured = balancing.phasors(size, np.radians(phase))
    correction = balancing.two_plane_correction(
        *balancing.unbalance_of_measurements(measured, planes), (case["inputs"]["za"], case["inputs"]["zb"])
    )
    mass, angle = balancing.correction_masses(correction, np.ones(2))
    expected = [case["value"][plane] for plane in "AB"]
    np.testing.assert_allclose(mass, [float(e["mr"]) for e in expected], rtol=1e-9)
    np.testing.assert_allclose(np.degrees(angle) % 360, [float(e["phase_deg"]) for e in expected], rtol=1e-9)


@pytest.mark.parametrize("remove", [False, True], ids=["added", "removed"])
def test_a_balanced_wheel_spins_about_a_principal_axis_through_its_centre(remove):
    body, radii = wheel(), np.array([0.25, 0.2])
    correction = balancing.two_plane_correction(*balancing.unbalance_of_body(body), PLANES)
    mass, angle = balancing.correction_masses(correction, radii, remove=remove)
    assert (mass > 0).all()
    balanced = with_corrections(body, mass, angle, radii, PLANES, -1.0 if remove else 1.0)
    before, after = (b.about(np.zeros(3)) for b in (body, balanced))
    assert abs(before[:2, 2]).min() > 1e-4
    np.testing.assert_allclose(after[:2, 2], 0.0, atol=1e-16)
    np.testing.assert_allclose(balanced.centre[:2], 0.0, atol=1e-16)
    assert abs(after[0, 1]) > 1e-5  # it need not vanish, and does not
    spin = np.array([0.0, 0.0, 100.0])
    np.testing.assert_allclose(np.cross(spin, after @ spin), 0.0, atol=1e-11)


def test_bearing_forces_are_the_forces_that_keep_the_wheel_on_its_axis():
    """Newton and Euler for the body: the bearings give M a and dL/dt about the origin; the wheel gives the opposite."""
    body, rate, bearings = wheel(1), 40.0, (-0.5, 0.7)
    forces = balancing.bearing_forces(*balancing.unbalance_of_body(body), rate, bearings)
    spin = np.array([0.0, 0.0, rate])
    pull = -body.mass * np.cross(spin, np.cross(spin, body.centre))
    torque = -np.cross(spin, body.about(np.zeros(3)) @ spin)
    at = np.array([[0, 0, z] for z in bearings])
    whole = np.column_stack([forces, np.zeros(2)])
    np.testing.assert_allclose(whole.sum(0), pull, rtol=1e-12)
    np.testing.assert_allclose(np.cross(at, whole).sum(0)[:2], torque[:2], rtol=1e-12)
    assert np.linalg.norm(forces) > 1.0


def test_measurements_are_vectors_one_a_plane():
    """U and D are those of points at the planes, on both sides of the origin."""
    measured, planes = np.array([[0.01, 0.002], [0.004, -0.03]]), np.array([-0.1, 0.3])
    points = point(1.0, [0.01, 0.002, -0.1]) + point(1.0, [0.004, -0.03, 0.3])
    np.testing.assert_allclose(
        balancing.unbalance_of_measurements(measured, planes), balancing.unbalance_of_body(points), rtol=1e-14
    )
    with pytest.raises(ValueError, match=r"each of the planes \(2,\) needs a vector of two components, not \(2,\)"):
        balancing.unbalance_of_measurements([0.01, 0.02], [-0.1, 0.1])


def test_only_the_products_with_the_axis_count():
    body = Body(np.asarray(3.0), np.zeros(3), np.array([[2.0, 0.7, 0.0], [0.7, 1.5, 0.0], [0.0, 0.0, 3.0]]))
    for vector in balancing.unbalance_of_body(body):
        assert (vector == 0.0).all()


@pytest.mark.slow
@given(
    st.integers(0, 10**6),
    st.floats(-6, 6),
    st.floats(-6, 6),
    st.floats(-1, 1),
    st.floats(0.01, 3),
)
def test_the_equivalent_in_two_planes_is_the_same_unbalance(seed, mass, length, plane, apart):
    """Over twelve decades of mass and of length, in a batch."""
    random, mass, length = np.random.default_rng(seed), 10.0**mass, 10.0**length
    static, dynamic = mass * length * random.normal(size=(2, 5, 2))
    dynamic = dynamic * length
    planes = (plane * length, (plane + apart) * length)
    vectors = balancing.two_plane_equivalent(static, dynamic, planes)
    size = abs(vectors).sum(-2)
    assert (abs(vectors.sum(-2) - static) <= 1e-14 * size).all()
    assert (abs(planes[0] * vectors[:, 0] + planes[1] * vectors[:, 1] - dynamic) <= 1e-13 * 4 * length * size).all()


@pytest.mark.slow
def test_batches_and_jax_give_the_same():
    jax = pytest.importorskip("jax")
    static, dynamic = np.random.default_rng(4).normal(size=(2, 6, 2))
    whole = balancing.two_plane_correction(static, dynamic, PLANES)
    np.testing.assert_array_equal(whole[3], balancing.two_plane_correction(static[3], dynamic[3], PLANES))
    forces = balancing.bearing_forces(static, dynamic, np.arange(6.0), PLANES)
    np.testing.assert_allclose(forces[3], balancing.bearing_forces(static[3], dynamic[3], 3.0, PLANES), rtol=1e-14)
    single = np.ones(2, dtype=np.float32)
    assert balancing.bearing_forces(single, single, 3.0, PLANES).dtype == np.float32
    with jax.enable_x64(True):
        slope = jax.jacobian(lambda u: balancing.two_plane_correction(u, jax.numpy.asarray(dynamic[0]), PLANES))
        np.testing.assert_allclose(
            slope(jax.numpy.asarray(static[0])), [-0.6 * np.eye(2), -0.4 * np.eye(2)], rtol=1e-14
        )


# Holes

ANGLES = np.radians(np.arange(0, 360, 60.0))
HOLES = {"radii": np.repeat([0.25, 0.2], 3), "angle": ANGLES, "position": np.repeat(PLANES, 3)}


def residual_of(body, masses):
    for m, radius, phi, z in zip(masses, HOLES["radii"], HOLES["angle"], HOLES["position"], strict=True):
        body = body + point(m, [radius * np.cos(phi), radius * np.sin(phi), z])
    return balancing.two_plane_equivalent(*balancing.unbalance_of_body(body), PLANES)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "masses"), [(3, (0.05, 0.12)), (4, (-0.02, -0.05, -0.11))], ids=["added", "drilled"])
def test_no_other_choice_of_holes_is_better(seed, masses):
    """Wheels whose best choices have 3 and 4 holes, so that fewer are worse."""
    body = wheel(seed)
    best = balancing.best_holes(*balancing.unbalance_of_body(body), PLANES, masses=masses, **HOLES)
    np.testing.assert_allclose(best.residual, residual_of(body, best.mass), atol=1e-15)
    choices = np.array(list(itertools.product((0.0, *masses), repeat=6)))
    alone = residual_of(body, np.zeros(6))
    of_holes = np.array([residual_of(body, hole) - alone for hole in np.eye(6)])  # residuals go as the masses
    every = np.linalg.norm((alone + np.tensordot(choices, of_holes, 1)).reshape(len(choices), -1), axis=1)
    assert every[-1] == pytest.approx(np.linalg.norm(residual_of(body, choices[-1])), rel=1e-12)
    assert best.size == pytest.approx(every.min(), rel=1e-12)
    assert np.linalg.norm(best.residual) == pytest.approx(best.size)
    assert best.size < 0.8 * np.linalg.norm(alone)
    for most in (0, 1, 2, 3):
        few = balancing.best_holes(*balancing.unbalance_of_body(body), PLANES, masses=masses, most=most, **HOLES)
        allowed = np.count_nonzero(choices, axis=1) <= most
        assert few.size == pytest.approx(every[allowed].min(), rel=1e-12)
        assert np.count_nonzero(few.mass) <= most


def test_holes_that_can_balance_do_and_balanced_wheels_are_left_alone():
    true = np.array([0.05, 0.0, 0.12, 0.0, 0.05, 0.12])
    still = np.zeros(2)
    unbalance = [-(part) for part in balancing.unbalance_of_body(drilled(true))]
    best = balancing.best_holes(*unbalance, PLANES, masses=(0.05, 0.12), **HOLES)
    assert best.size < 1e-15
    assert (balancing.best_holes(still, still, PLANES, masses=(0.05, 0.12), **HOLES).mass == 0).all()


def drilled(masses):
    body = None
    for m, radius, phi, z in zip(masses, HOLES["radii"], HOLES["angle"], HOLES["position"], strict=True):
        if m:
            other = point(m, [radius * np.cos(phi), radius * np.sin(phi), z])
            body = other if body is None else body + other
    return body


# Refusals


def test_what_cannot_be_balanced_is_refused():
    with pytest.raises(ValueError, match=r"both are at 0\.3"):
        balancing.two_plane_correction(np.ones(2), np.ones(2), (0.3, 0.3))
    with pytest.raises(ValueError, match="radii of the corrections must be positive"):
        balancing.correction_masses(np.ones((2, 2)), np.array([0.1, 0.0]))
    many = {name: np.repeat(values, 8) for name, values in HOLES.items()}
    with pytest.raises(ValueError, match="48 holes with 2 masses for each are too many"):
        balancing.best_holes(np.ones(2), np.ones(2), PLANES, masses=(0.05, 0.12), **many)


@pytest.mark.full(inputs=["sims/balanced_wheel.py"])
@pytest.mark.parametrize("extra", [[], ["--remove"]], ids=["weights are added", "weights are removed"])
def test_the_balanced_wheel_of_sims(extra, tmp_path):
    picture = tmp_path / "wheel.png"
    script = Path(__file__).parents[3] / "sims" / "balanced_wheel.py"
    command = [sys.executable, str(script), "--speed", "3000", "--output", str(picture), *extra]
    done = subprocess.run(command, cwd=script.parents[1], capture_output=True, text=True, check=True)
    lines = [line for line in done.stdout.splitlines() if line.startswith(("I_xz", "I_yz", "force"))]
    before, corrected, clips = np.array([[float(word) for word in line.split()[-3:]] for line in lines]).T
    np.testing.assert_allclose(before[2:], [9 * 109, 9 * 8.86], rtol=5e-3)  # nine times those at 1000
    assert (abs(corrected) < 1e-12 * abs(before)).all()
    assert np.linalg.norm(clips[2:]) < 0.15 * np.linalg.norm(before[2:])
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert (" off at " in done.stdout) == bool(extra)


def test_grades_of_balance_are_those_of_the_standard():
    """A turbine's rotor of 3600 kg at 3000 revolutions a minute may have 28.65 kg mm by the grade 2.5."""
    allowed = balancing.permissible_unbalance(3600.0, 2.0 * np.pi * 50.0, 2.5)
    assert 1e3 * allowed == pytest.approx(28.65, abs=0.01)
    assert balancing.permissible_unbalance("3600 kg", "3000 rpm", 2.5) == pytest.approx(allowed, rel=1e-12)
    turned = allowed * np.array([[0.6, 0.8], [0.0, -0.5]])
    grades = balancing.balance_grade(turned, 3600.0, 2.0 * np.pi * 50.0)
    np.testing.assert_allclose(grades, [2.5, 1.25], rtol=1e-13)
    backwards = -2.0 * np.pi * 50.0  # of which both were below 0
    assert balancing.permissible_unbalance(3600.0, backwards, 2.5) == allowed
    np.testing.assert_array_equal(balancing.balance_grade(turned, 3600.0, backwards), grades)
    assert float(jax.grad(lambda mass: balancing.permissible_unbalance(mass, 100.0))(2.0)) == pytest.approx(6.3e-5)
    for wrong, name in (((-1.0, 1.0), "mass"), ((1.0, 1.0, -6.3), "grade")):
        with pytest.raises(ValueError, match=f"{name} must not be negative"):
            balancing.permissible_unbalance(*wrong)
    with pytest.raises(ValueError, match="mass must not be negative"):
        balancing.balance_grade(turned, -3600.0, 1.0)


def test_holes_that_lie_nowhere_are_named():
    one = (np.array([0.006, 0.0]), np.zeros(2), (-0.1, 0.1))
    with pytest.raises(ValueError, match="position of best_holes must be finite, not nan"):
        balancing.best_holes(*one, [0.3, 0.3], [0.0, np.pi], [0.0, np.nan], (0.01,))


def test_one_hole_is_chosen_or_not_and_no_hole_is_refused():
    one = (np.array([0.006, 0.0]), np.zeros(2), (-0.1, 0.1))
    holes = balancing.best_holes(*one, [0.3], [np.pi], [0.0], (0.01,))
    assert holes.mass.tolist() == [0.01] and holes.size == pytest.approx(0.003 / np.sqrt(2))
    assert balancing.best_holes(*one, [0.3], [0.0], [0.0], (0.01,)).mass.tolist() == [0.0]
    for holes, masses, most in (([], (0.01,), None), ([0.3], (), None), ([0.3], (0.01,), -1)):
        with pytest.raises(ValueError, match="at least one hole and one mass"):
            balancing.best_holes(*one, holes, holes, holes, masses, most)


@pytest.mark.slow
def test_corrections_can_be_compiled():
    static, planes = jnp.array([0.006, 0.002]), jnp.array([-0.1, 0.3])

    def corrections(planes, radii):
        return balancing.correction_masses(balancing.two_plane_correction(static, 0.1 * static, planes), radii)

    radii = jnp.array([0.3, 0.2])
    for compiled, plain in zip(jax.jit(corrections)(planes, radii), corrections(planes, radii), strict=True):
        np.testing.assert_allclose(compiled, plain, rtol=1e-6)


def test_a_body_made_by_hand_has_its_unbalance():
    static, dynamic = balancing.unbalance_of_body(Body(3.0, np.array([0.1, 0.0, 0.0]), np.eye(3)))
    assert static.tolist() == pytest.approx([0.3, 0.0])
    assert dynamic.tolist() == [0.0, 0.0]
