"""Torques on a rigid body, by both integrators: against closed forms, and the energy that each has done."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from astroinertia.inertia.prescribed import change
from tests.rigid import ADAPTIVE, SPLITTING, attitude, effect, momentum, spin, under_way

# Each combination of effects is compiled: some tests list an effect that does nothing, and share another's program.
pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("float64")]

# Each is compiled for each torque; that they agree where all torques act: tests/physics/test_rigid_motion.py.
both = pytest.mark.parametrize(
    "settings", [SPLITTING, pytest.param(ADAPTIVE, marks=pytest.mark.full)], ids=["splitting", "adaptive"]
)
TOP, SPIN = [1.0, 2.0, 3.0], [0.5, 0.2, 1.0]
NEVER = 1000.0  # a time after the end of every run


def accounted(run):
    """The record, in which no effect's share of the energy may be missing."""
    record = run.record(0.0)
    assert abs(record["integration_energy_error"]) < 1e-10 * max(1.0, record["kinetic_energy"])
    return record


@pytest.mark.full
@both
def test_a_constant_torque_adds_to_the_angular_momentum_while_it_acts(settings):
    torque = effect("constant_torque", vector=[0.1, -0.3, 0.2], begin=1.0, until=3.5)
    thruster = effect("constant_torque", vector=[1.0, 1.0, 1.0], frame="body", begin=NEVER, until=2.0 * NEVER)
    run = under_way(TOP, SPIN, torque, thruster, settings=settings)
    start = momentum(run)
    run.advance(0.7)
    assert momentum(run) == pytest.approx(start, abs=1e-15)
    run.advance(2.0)
    assert momentum(run) == pytest.approx(start + np.array([0.1, -0.3, 0.2]), abs=1e-13)
    run.advance(5.0)
    assert momentum(run) == pytest.approx(start + 2.5 * np.array([0.1, -0.3, 0.2]), abs=1e-13)
    accounted(run)


@both
def test_a_thruster_along_a_principal_axis_spins_the_body_up(settings):
    torque = effect("constant_torque", vector=[1.0, 1.0, 1.0], begin=NEVER, until=2.0 * NEVER)
    thruster = effect("constant_torque", vector=[0.0, 0.0, 0.6], frame="body", begin=0.0, until=NEVER)
    run = under_way(TOP, [0.0, 0.0, 0.5], torque, thruster, settings=settings)
    run.advance(4.0)
    assert spin(run) == pytest.approx([0.0, 0.0, 1.3], abs=1e-12)
    assert accounted(run)["work"] == pytest.approx([0.0, 1.5 * (1.3**2 - 0.25), 0.0], rel=1e-12)


@both
def test_impulses_come_when_they_are_due(settings):
    blows = effect("impulses", angular_momentum=[0.0, 0.0, 1.0], time=1.0, every=0.5, number=3.0)
    nothing = effect("internal_dissipation", time_scale=30.0)  # about the axis of the largest moment
    run = under_way([1.0, 1.0, 2.0], [0.0, 0.0, 1.0], blows, nothing, settings=settings)
    for time, expected in ((0.9, 2.0), (1.0, 3.0), (1.4, 3.0), (10.0, 5.0)):
        run.advance(time)
        assert momentum(run)[2] == pytest.approx(expected, abs=1e-14)
    assert accounted(run)["work"][0] == pytest.approx((25.0 - 4.0) / 4.0)


@both
def test_a_pendulum_has_the_period_of_the_elliptic_integral(settings):
    # A heavy body without spin on a pivot, let go at 2 radians.
    quarter = ellipk(np.sin(1.0) ** 2) / np.sqrt(3.0 / 2.0)
    quaternion = (np.cos(1.0), np.sin(1.0), 0.0, 0.0)
    hung = effect("pivot", gravity=[0.0, 0.0, -1.0], arm=[0.0, 0.0, -1.0])
    run = under_way([2.0, 2.5, 4.0], np.zeros(3), hung, settings=settings, quaternion=quaternion, mass=3.0,
                    arm=np.array([0.0, 0.0, -1.0]))  # fmt: skip
    opening = accounted(run)["total_energy"]
    run.advance(quarter)
    record = accounted(run)
    assert record["centre_of_mass"] == pytest.approx([0.0, 0.0, -1.0], abs=1e-9)
    assert record["total_energy"] == pytest.approx(opening, abs=1e-11)
    run.advance(4.0 * quarter)
    assert attitude(run)[2, 2] == pytest.approx(np.cos(2.0), abs=1e-9)


@pytest.mark.full
@both
def test_a_pulsar_brakes_as_its_index_says(settings):
    # P^(n-1) grows in proportion to time.
    for index in (3.0, 2.5):
        nothing = effect("internal_dissipation", time_scale=30.0, rate=1.0)  # about the axis of the largest moment
        brake = effect("dipole_braking", period=2.0, period_derivative=0.01, index=index, speed_of_light=1.0)
        run = under_way([1.0, 1.0, 1.2], [0.0, 0.0, np.pi], nothing, brake, settings=settings)
        run.advance(100.0)
        grown = 1.0 + (index - 1.0) * 0.01 * 100.0 / 2.0
        assert 2.0 * np.pi / spin(run)[2] == pytest.approx(2.0 * grown ** (1.0 / (index - 1.0)), rel=1e-10)
        accounted(run)


@pytest.mark.full
@both
def test_a_dipole_in_vacuum_brakes_and_aligns_its_star(settings):
    # Of a spherical star: omega cos(chi) stays, and d omega/dt = -k sin^2(chi) omega^3 / I.
    chi, strength = 0.7, 8.0 * np.pi / 3.0 * 0.1**2
    brake = effect("dipole_braking", field=0.1, radius=1.0, speed_of_light=1.0,
                   magnetic_axis=[np.sin(chi), 0.0, np.cos(chi)])  # fmt: skip
    run = under_way([1.0, 1.0, 1.0], [0.0, 0.0, 2.0], brake, settings=settings)
    run.advance(5.0)
    rate = np.linalg.norm(spin(run))
    along = attitude(run).T @ [np.sin(chi), 0.0, np.cos(chi)] @ momentum(run)
    kept = 2.0 * np.cos(chi)
    assert along == pytest.approx(kept, rel=1e-11)

    def elapsed(omega):  # the integral of d omega / (omega (omega^2 - kept^2))
        return (0.5 * np.log(1.0 - kept**2 / omega**2)) / kept**2

    assert (elapsed(2.0) - elapsed(rate)) / strength == pytest.approx(5.0, rel=1e-10)
    accounted(run)


@pytest.mark.parametrize("settings", [SPLITTING, ADAPTIVE], ids=["splitting", "adaptive"])
def test_dissipation_in_what_is_nearly_a_sphere_follows_its_own_equation(settings):
    """L and omega are so nearly parallel that what they are each rounded to would turn the body's axes, and did."""
    inverse = 1.0 / np.array([1.0, 1.0 + 1e-7, 1.0 + 2e-7])
    excess = 0.5 * (inverse[0] + inverse[1]) - inverse[2]

    def slope(time, m):  # m x (omega + s), by the differences of inverse moments
        across = np.array([(inverse[2] - inverse[1]) * m[1] * m[2], (inverse[0] - inverse[2]) * m[2] * m[0],
                           (inverse[1] - inverse[0]) * m[0] * m[1]])  # fmt: skip
        return across + np.cross(m, across) / (m @ m * excess)

    blows = effect("impulses", angular_momentum=[1.0, 0.0, 0.0], time=NEVER, every=1.0)
    start = np.array([1e-3, 1.0, 1e-4])
    run = under_way(1.0 / inverse, start, blows, effect("internal_dissipation", time_scale=1.0), settings=settings)
    run.advance(8.0)
    exact = solve_ivp(slope, (0.0, 8.0), start / inverse, method="DOP853", rtol=1e-12, atol=1e-15).y[:, -1]
    assert attitude(run) @ momentum(run) == pytest.approx(exact, abs=1e-8)
    assert momentum(run) == pytest.approx(start / inverse, abs=1e-14)


@both
def test_dissipation_keeps_the_angular_momentum_and_heats(settings):
    blows = effect("impulses", angular_momentum=[1.0, 0.0, 0.0], time=NEVER, every=1.0)
    run = under_way(TOP, [1.0, 0.05, 0.05], blows, effect("internal_dissipation", time_scale=5.0), settings=settings)
    start, opening = momentum(run), accounted(run)["kinetic_energy"]
    energies = [opening]
    for k in range(12):
        run.advance(10.0 * (k + 1))
        record = accounted(run)
        energies.append(record["kinetic_energy"])
        assert record["heating"][1] == pytest.approx(opening - energies[-1], abs=1e-12)
        assert momentum(run) == pytest.approx(start, abs=1e-14)
    assert (np.diff(energies) < 1e-13).all()
    # From the least to the largest moment, through the separatrix: all that L allows.
    assert energies[-1] == pytest.approx(start @ start / 6.0, rel=1e-12)
    assert abs(spin(run)[2]) == pytest.approx(np.linalg.norm(start) / 3.0, rel=1e-12)


@both
@pytest.mark.parametrize("rate", [None, 2.0])
def test_a_small_wobble_decays_in_the_time_that_is_given(settings, rate):
    settles = effect("internal_dissipation", time_scale=7.0, rate=rate)
    if rate is None:
        acts = effect("impulses", angular_momentum=[1.0, 0.0, 0.0], time=NEVER, every=1.0), settles
    else:
        acts = settles, effect("dipole_braking", period=2.0, period_derivative=1e-30, speed_of_light=1.0)
    run = under_way([1.0, 1.0, 1.3], [1e-4, 0.0, 2.0], *acts, settings=settings)
    run.advance(14.0)
    assert np.hypot(*spin(run)[:2]) == pytest.approx(1e-4 * np.exp(-2.0), rel=1e-6)


@pytest.mark.full
@both
def test_the_bulge_of_an_elastic_body_slows_its_wobble(settings):
    # The wobble of a small angle has the rate Omega (C - A - D Omega^2) / (A + D Omega^2): no bulge follows the pole.
    deformability, rate = 0.05, 1.5
    bulge = effect("rotational_deformation", love_number=3.0 * deformability, radius=1.0, rate=rate)
    assert bulge.deformability == pytest.approx(deformability)
    observed = np.array([1.0, 1.0, 1.4])
    rest = observed + deformability * rate**2 * np.array([1.0, 1.0, -2.0]) / 3.0
    stiffened = rest + 2.0 / 3.0 * deformability * rate**2
    run = under_way(rest, stiffened / rest * [1e-5, 0.0, rate], bulge, settings=settings, spin=rate,
                    deformability=deformability)  # fmt: skip
    wobble = rate * (0.4 - deformability * rate**2) / (1.0 + deformability * rate**2)
    record = accounted(run)
    assert np.linalg.eigvalsh(record["inertia_tensor"]) == pytest.approx(observed, rel=1e-9)
    assert spin(run) == pytest.approx([1e-5, 0.0, rate], rel=1e-9)
    opening = spin(run)
    run.advance(2.0 * np.pi / wobble)
    assert spin(run) == pytest.approx(opening, abs=3e-13)
    assert accounted(run)["total_energy"] == pytest.approx(record["total_energy"], rel=1e-13)


@pytest.mark.full
@both
def test_a_skater_turns_faster_and_does_work(settings):
    push = effect("constant_torque", vector=[1.0, 1.0, 1.0], begin=NEVER, until=2.0 * NEVER)
    run = under_way([1.0, 1.5, 2.0], [0.0, 0.0, 1.0], push, settings=settings,
                    change=change([1.0, 2.0, 3.0], [1.0, 0.5, 0.25]))  # fmt: skip
    run.advance(2.0)
    factor = float(run.body.change.factor(2.0))
    assert spin(run)[2] == pytest.approx(1.0 / factor, rel=1e-12)
    record = accounted(run)
    own = 0.5 * np.trace(record["kinetic_tensor"]) - 0.5 * 2.0 / factor
    assert own > 0.01  # of the arms that move in
    assert record["work"] == pytest.approx([0.0, record["kinetic_energy"] - 1.0], rel=1e-11)
    run.advance(5.0)
    assert accounted(run)["kinetic_energy"] == pytest.approx(4.0, rel=1e-11)


@both
def test_a_changing_size_and_a_torque_act_together(settings):
    # L_z = tau t about a principal axis, whatever the size.
    push = effect("constant_torque", vector=[0.0, 0.0, 0.4], begin=0.0, until=NEVER)
    run = under_way(TOP, [0.0, 0.0, 1.0], push, settings=settings, change=change([1.0, 2.0, 4.0], [1.0, 2.0, 0.5]))
    run.advance(3.3)
    assert spin(run)[2] * 3.0 * float(run.body.change.factor(3.3)) == pytest.approx(3.0 + 0.4 * 3.3, rel=1e-12)
    accounted(run)


@both
def test_a_run_goes_on_from_a_checkpoint_bit_for_bit(settings):
    blows = effect("impulses", angular_momentum=[0.3, 0.0, 0.0], time=1.5, every=2.0)

    def fresh():
        return under_way(TOP, SPIN, blows, effect("internal_dissipation", time_scale=30.0), settings=settings)

    whole, first, second = fresh(), fresh(), fresh()
    for time in (1.0, 2.0, 3.0, 4.0):
        whole.advance(time)
    first.advance(1.0)
    first.advance(2.0)
    second.resume(first.arrays())
    second.advance(3.0)
    second.advance(4.0)
    left, right = whole.arrays(), second.arrays()
    assert all((left[name] == right[name]).all() for name in left)
