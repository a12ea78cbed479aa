"""Relaxed bodies against exact polytropes, and the ways in which a relaxation can go wrong unnoticed.

Errors in I/(M R^2) with the quintic kernel on 113 neighbours and densities and gravity of fourth order, measured at
3000 and 10,000 particles: n = 1: -0.54, -0.25 %; n = 1.5: -0.39, -0.21 %; n = 3: +0.59, +0.18 %; in the radius-free
I W^2: -0.17, -0.06 %; -0.09, -0.02 %; +0.52, +0.30 %; in the central density within 0.5, 0.2 %. Second order has, with
1000 and 3000, 3.9, 1.9; 2.5, 1.1; 6, 3.6 % in I, and 13 % in the central density of n = 3. The results of full size
are in tests/results.
"""

import functools
import json
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest

from astroinertia.bodies.homologous_core import HomologousCore
from astroinertia.bodies.polytrope import Polytrope
from astroinertia.errors import NumericalError
from astroinertia.matter import gases
from astroinertia.models.sph import relaxation
from astroinertia.models.sph.relaxation import Rotation, Tolerances
from astroinertia.sph import profiles
from astroinertia.sph.placement import place
from astroinertia.storage import cache
from astroinertia.studies.relax import gas_of_polytrope, polytrope_problem, relaxed_polytrope
from tests.polytropes import errors

# A fresh relaxation each time: a cached one would not notice that the physics has changed.
relaxed = functools.partial(relaxed_polytrope, use_cache=False)
AT_1000 = {1.0: 0.013, 1.5: 0.009, 3.0: 0.014}


@pytest.mark.full
@pytest.mark.parametrize("index", [1.0, 1.5, 3.0])
def test_structure_converges_to_the_exact_polytrope(index):
    found = {count: errors(relaxed(index, count)) for count in (400, 1600)}
    for count, error in found.items():
        bar = 1.5 * AT_1000[index] * (1000 / count) ** 0.45
        assert abs(error["inertia"]) < bar
        assert abs(error["gravitational_energy"]) < bar
        assert abs(error["radius_free"]) < 2 * bar
        assert abs(error["central_density"]) < 2 * bar
    assert abs(found[1600]["inertia"]) < 0.65 * abs(found[400]["inertia"])


@pytest.mark.full
def test_a_star_of_index_three_is_as_large_and_dense_as_the_exact_one():
    """600 particles: +2.1 % in I, +0.48 % in I W^2, -0.5 % in the central density; 1000: +1.3, +0.57, -0.2 %.

    Second order makes I of 1000 6 % too large and their centre 13 % too thin.
    """
    error = errors(relaxed(3.0, 600))
    assert abs(error["inertia"]) < 0.03
    assert abs(error["radius_free"]) < 0.008
    assert abs(error["central_density"]) < 0.02


@pytest.mark.full
@pytest.mark.parametrize(("index", "limit"), [(1.0, 0.01), (1.5, 0.01), (3.0, 0.015)])
def test_structure_at_full_size(index, limit, result):
    counts = [3000, 10000, 30000]
    found = []
    for count in counts:
        body = relaxed(index, count, precision="mixed")
        found.append(errors(body))
        result(
            **{name: [error[name] for error in found] for name in found[0]},
            particles=counts[: len(found)],
            kernel=body.kernel,
            neighbours=body.neighbours,
            steps=body.relaxation_steps,
            residual=body.relaxation_residual,
        )
    slopes = {name: np.polyfit(np.log(counts), np.log([abs(e[name]) for e in found]), 1)[0] for name in found[0]}
    result(**{f"order_in_particles_{name}": -slope for name, slope in slopes.items()})
    assert abs(found[-1]["inertia"]) <= limit
    assert abs(found[-1]["radius_free"]) <= limit
    assert slopes["inertia"] < -1 / 3


def _start(index, count, scale=1.0):
    """A placed polytrope whose positions are stretched by `scale`, and its target."""
    profile = profiles.polytrope(index)
    position = place(profile, count)
    entropy = np.empty(count)
    entropy[np.argsort(np.linalg.norm(position, axis=1))] = gas_of_polytrope(index, count)[1]
    target = {"target_density": lambda enclosed: profile.density(profile.radius(enclosed)), "use_cache": False}
    return np.full(count, 1 / count), scale * position, entropy, target


def test_centre_of_mass_stays_where_it_was():
    mass, position, entropy, target = _start(1.5, 200)
    lopsided = position + [3.0, -2.0, 1.0] + 0.2 * np.maximum(position[:, :1], 0) * [1.0, 0.5, 0.0]
    body = relaxation.relax(polytrope_problem(1.5, 200), mass, lopsided, entropy, **target)
    assert np.abs(mass @ body.position - mass @ lopsided).max() < 1e-13
    assert body.report.centre_shift < 1e-13


@pytest.mark.full
def test_a_drift_of_the_centre_of_mass_is_noticed(monkeypatch):
    honest = relaxation._next_move
    monkeypatch.setattr(relaxation, "_next_move", lambda *given: honest(*given) + [1e-5, 0.0, 0.0])
    mass, position, entropy, target = _start(1.5, 500)
    with pytest.raises(NumericalError, match="centre of mass moved"):
        relaxation.relax(polytrope_problem(1.5, 500), mass, position, entropy, **target)


def test_a_neutral_body_of_the_wrong_size_is_not_accepted():
    """With gamma 4/3 an n = 3 polytrope is in balance at any size: small accelerations alone prove nothing."""
    mass, position, _, target = _start(3.0, 500, scale=1.6)
    problem = replace(polytrope_problem(3.0, 500), equation_of_state=gases.ideal(4 / 3))
    constant = np.full(500, Polytrope(3.0).constant)
    loose = Tolerances(residual=0.05, virial=0.1)
    with pytest.raises(NumericalError, match="density is off") as caught:
        relaxation.relax(problem, mass, position, constant, tolerances=loose, **target)
    assert "net acceleration" not in str(caught.value)
    assert "virial" not in str(caught.value)


@pytest.mark.full
def test_imposed_entropies_bring_a_body_of_the_wrong_size_back():
    mass, position, entropy, target = _start(3.0, 500, scale=1.3)
    body = relaxation.relax(polytrope_problem(3.0, 500), mass, position, entropy, **target)
    moment = mass @ ((body.position - mass @ body.position) ** 2).sum(axis=1) / 3
    assert moment == pytest.approx(profiles.polytrope(3.0).second_moment, rel=0.15)


@pytest.mark.full
def test_a_collapse_keeps_its_size_and_finds_its_pressure():
    """The gas of exponent 4/3 alone would swell or fall in; entropies that are 5 % off come to the same pressures."""
    core, profile = HomologousCore(1.0), profiles.homologous_core(1.0)
    mass, position = np.full(300, 1 / 300), place(profile, 300, seed=2)
    problem = replace(polytrope_problem(3.0, 300), equation_of_state=gases.ideal(4 / 3))
    bodies = [
        relaxation.relax(
            problem, mass, position, np.full(300, factor * core.constant), infall=core.deceleration,
            tolerances=Tolerances(residual=4e-3), use_cache=False,
        ) for factor in (1.0, 1.05)
    ]  # fmt: skip
    size = [(mass @ ((x - mass @ x) ** 2).sum(axis=1)) for x in (position, *(body.position for body in bodies))]
    assert size[1:] == pytest.approx([size[0]] * 2, rel=1e-12)
    one, other = (body.report for body in bodies)
    assert one.residual < 4e-3 and other.residual < 4e-3
    assert 1.05 * other.pressure == pytest.approx(one.pressure, rel=1e-3)
    assert 0.8 < one.pressure < 1.2 and one.pressure != 1.0
    # Pressure, gravity and what draws the body in are in balance, by virials of their own.
    assert one.virial < 0.02


def test_a_body_that_turns_too_fast_is_said_to_fly_apart_and_does_so_the_same_each_time():
    """It was said that its centre of mass had moved by 4e23 of its size, after 2000 steps and overflows."""
    mass, position, entropy, target = _start(1.0, 100)
    rotation = Rotation("rate", 3.0)  # of sqrt(G M / R^3): gravity holds nothing at its equator
    said = []
    for _ in range(2):
        with pytest.raises(NumericalError, match=r"flies apart: \d+ % of its mass .* slower rotation would be right$"):
            relaxation.relax(
                polytrope_problem(1.0, 100), mass, position, entropy, rotation=rotation, **target,
                listener=lambda report: said.append(astuple(report)),
            )  # fmt: skip
    half = len(said) // 2
    assert said[:half] == said[half:] and half < 100  # the same bits, and it stops before numbers overflow


def test_a_body_whose_pressure_is_too_great_is_said_to_fly_apart():
    mass, position, entropy, target = _start(1.0, 100)
    problem = replace(polytrope_problem(1.0, 100), equation_of_state=gases.ideal(1.2))
    with pytest.raises(NumericalError, match=r"it flies apart: \d+ % of its mass.*pressure, and less would be right$"):
        relaxation.relax(problem, mass, position, 1e3 * entropy, **target)


@pytest.mark.full
def test_too_few_steps_are_not_enough():
    with pytest.raises(NumericalError, match=r"net acceleration is still .* after 5 steps"):
        relaxed(1.5, 300, max_steps=5)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"residual": 0.1}, "net acceleration"),
        ({"residual": float("nan")}, "not finite"),
        ({"density_error": 1.0}, "density is off by 100%"),
        ({"centre_shift": 0.5}, "centre of mass moved by 0.5"),
        ({"virial": 0.3}, "virial theorem"),
        ({"growth": 12.0}, "flies apart"),
        ({"growth": float("nan")}, "flies apart"),
    ],
)
def test_every_figure_of_the_verdict_counts(change, complaint):
    fine = relaxation.Report(100, 1e-3, 0.05, 1e-14, 1e-3, 0.0)
    assert relaxation.verdict(fine, Tolerances(), 3000) == ""
    assert complaint in relaxation.verdict(replace(fine, **change), Tolerances(), 3000)


def _rotating_reference():
    path = Path(__file__).parents[1] / "reference" / "rotating_polytropes.json"
    table = [entry for entry in json.loads(path.read_text()) if entry["name"] == "n1_polytrope_rotating"]
    (value,) = (entry["value"] for entry in table if 0.155 in entry["inputs"].values())
    return value


@pytest.mark.full
@pytest.mark.parametrize("count", [500, 2000])
def test_rotating_equilibrium_has_the_figure_of_the_exact_one(count):
    """Rigid n = 1 body at q = 0.155: its moments, T/|W|, and the rate over the central density.

    Flattening and rate are off by 6.8 and 6.2 % with 1000 particles, 4.1 and 3.8 % with 2000: as N^-0.7; and so with
    500.
    """
    exact = _rotating_reference()
    share, fewer = exact["T_W"], (2000 / count) ** 0.7
    body = relaxed(1.0, count, Rotation("t_over_w", share))
    tensor = body.moment_of_inertia.values
    assert float(body.rotational_to_gravitational) == pytest.approx(share, rel=1e-9)
    assert abs(tensor[0, 1]) + abs(tensor[0, 2]) + abs(tensor[1, 2]) < 0.01 * tensor[2, 2]
    flattening = 1 - 0.5 * (tensor[0, 0] + tensor[1, 1]) / tensor[2, 2]
    assert flattening == pytest.approx(1 - exact["Ixx_MRe2"] / exact["Izz_MRe2"], rel=0.05 * fewer)
    rate = body.relaxation_rate
    velocity = rate * np.cross([0.0, 0.0, 1.0], body.position.values)
    np.testing.assert_allclose(body.velocity.values, velocity, rtol=0, atol=1e-12)
    assert rate**2 / (4 * np.pi * float(body.central_density)) == pytest.approx(
        exact["Omega2_4piGrhoc"], rel=0.04 * fewer
    )
    still = (
        3 * body.moment_of_inertia.attrs["exact_at_rest"] * (1 - AT_1000[1.0] * (1000 / count) ** 0.45)
    )  # as large as so many make it
    assert np.trace(tensor) > 1.05 * still


@pytest.mark.full
def test_rotation_by_rate_and_by_angular_momentum_are_one_equilibrium():
    by_rate = relaxed(1.0, 200, Rotation("rate", 0.3))
    momentum = float((by_rate.mass.values @ np.cross(by_rate.position.values, by_rate.velocity.values))[2])
    by_momentum = relaxed(1.0, 200, Rotation("angular_momentum", momentum))
    assert by_momentum.relaxation_rate == pytest.approx(0.3, rel=0.01)


def test_differential_rotation_relaxes_on_its_own_law():
    body = relaxed(1.5, 200, Rotation("rate", 0.6, scale=0.5, law="j_constant"))
    x, v = body.position.values, body.velocity.values
    w2 = (x[:, :2] ** 2).sum(axis=1)
    np.testing.assert_allclose(np.linalg.norm(v, axis=1), 0.6 / (1 + w2 / 0.25) * np.sqrt(w2), rtol=1e-9)


def test_a_relaxed_body_is_kept_and_reported(tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "cache_directory", lambda: tmp_path)
    mass, position, entropy, _ = _start(1.5, 300)
    problem, heard = polytrope_problem(1.5, 300), []
    first = relaxation.relax(problem, mass, position, entropy, listener=heard.append)
    assert [report.steps for report in heard] == list(range(first.report.steps + 1))
    assert heard[-1].residual < heard[0].residual / 5
    again = relaxation.relax(problem, mass, position, entropy, listener=heard.append)
    assert again.cached
    assert not first.cached
    assert again.report == first.report or np.isnan(again.report.density_error)
    np.testing.assert_array_equal(again.position, first.position)
    other = relaxation.relax(replace(problem, eta=1.01 * problem.eta), mass, position, entropy)
    assert not other.cached
    files = list(cache.cache_directory().glob("relaxed-*.npz"))
    assert len(files) == 2


@pytest.mark.full
def test_rearranging_does_not_change_whose_entropy_is_whose():
    """Entropy rises outwards in a relaxed n = 3 body exactly as it was dealt out by mass shell."""
    body = relaxed(3.0, 200)
    radius = np.linalg.norm(body.position.values, axis=1)
    order = np.argsort(body.entropy.values)
    assert np.corrcoef(np.arange(200), np.argsort(np.argsort(radius[order])))[0, 1] > 0.98
