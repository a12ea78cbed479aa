"""The numba engine against sums over all pairs in one array (tests/pairs.py), and what it promises besides."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from astroinertia.engines import numba_cache, numba_cpu, tree
from astroinertia.engines.numba_cpu import Engine
from astroinertia.engines.numba_modules import neighbour_pass
from astroinertia.engines.terms import Output, PairTerm
from astroinertia.gravity.direct import DIRECT_GRAVITY
from astroinertia.sph.kernels import KERNELS
from tests import pairs

KERNEL, ETA, COUNT = "wendland_c2", 1.3, 600
STEEPNESS = 3.0  # a number of the module that a pair function names


def helper(xp, x):
    return xp.sqrt(xp.abs(x) + 0.25) * STEEPNESS


def push_pair(xp, r, v_r, dW_i, dW_j, strength_i, strength_j):
    """Everything that a neighbour term may do: a helper, a power, a choice, three kinds of output."""
    approach = xp.minimum(v_r, 0.0)
    speed = helper(xp, strength_i + strength_j) - 2 * approach**3
    push = speed * xp.where(r > 0.01, approach, 0.5 * approach) * (dW_i + dW_j)
    return push, push * v_r, xp.maximum(speed, 0.0)


def shear_pair(xp, dW_i, x_ij, y_ij, z_ij):
    return dW_i, x_ij * y_ij * dW_i + z_ij


def lone_pair(xp, W_i, W_j, h_i, h_j, phi_i, phi_j, dphi_i, dphi_j):
    return W_i * h_j + W_j * h_i, phi_i + phi_j + dphi_i + dphi_j


def unlimited_pair(xp, r, strength_i, strength_j):
    """Does not vanish at the edge: the engine itself must leave out pairs beyond reach."""
    return 1.0 + r + strength_i * strength_j, 2.0 + strength_j


def spring_pair(xp, dW_i, dW_j, strength_i, strength_j):
    return dW_i + dW_j, strength_i + strength_j


SPRING = PairTerm("spring", spring_pair, (Output("acceleration", "central"), Output("energy", "sum")))
PUSH = PairTerm("push", push_pair, (Output("acceleration", "central"), Output("heat", "sum"), Output("signal", "max")))
SHEAR = PairTerm("shear", shear_pair, (Output("gradient", "outer", of="velocity"), Output("moment", "sum")))
LONE = PairTerm("lone", lone_pair, (Output("weight", "sum"), Output("acceleration", "central")))
ADDED = PairTerm("push", lone_pair, (Output("heat", "sum"), Output("acceleration", "central")))  # adds to PUSH
UNLIMITED = PairTerm("unlimited", unlimited_pair, (Output("acceleration", "central"), Output("most", "max")))
NEIGHBOUR_TERMS = (PUSH, SHEAR, LONE, UNLIMITED, ADDED)


def clustered(count=COUNT, seed=1):
    """A dense clump in a thin envelope, two particles in one place, and the mass of each."""
    random = np.random.default_rng(seed)
    position = random.normal(size=(count, 3))
    position[: count // 2] *= 0.04
    position[11] = position[10]
    return position, random.uniform(0.5, 1.5, count) / count


@pytest.fixture(scope="module")
def reference():
    """Positions in the engine's order, exact smoothing lengths, and every field that the terms name."""
    position, mass = clustered()
    order, arrangement = Engine().arrange(position, np.ones(COUNT))
    position, mass = position[order], mass[order]
    solved = pairs.density(KERNEL, position, mass, ETA)
    random = np.random.default_rng(3)
    fields = {
        "mass": mass,
        "position": position,
        "velocity": random.normal(size=(COUNT, 3)),
        "smoothing_length": solved.smoothing_length,
        "strength": random.uniform(1, 2, COUNT),
    }
    return arrangement, solved, fields


def largest_error(found, expected):
    """The largest error of any output in units of the sum of the sizes of its terms."""
    worst = 0.0
    for effect, outputs in found.items():
        for name, value in outputs.items():
            scale = expected[effect].get(f"{name} scale", np.abs(expected[effect][name]).max())
            if name in ("signal", "most"):
                scale = np.abs(expected[effect][name]).max()
            error = np.abs(value - expected[effect][name])
            assert np.isfinite(error).all(), (effect, name)
            worst = max(
                worst, np.max(error / np.reshape(scale, np.shape(scale) + (1,) * (error.ndim - np.ndim(scale))))
            )
    return worst


def of_particles(outputs):
    """What each particle has: all but the virial tensors, which every test asks for so that all share one program."""
    return [(name, value) for name, value in outputs.items() if name != "virial"]


@pytest.mark.full
def test_few_particles_have_the_sums_of_many(reference, monkeypatch):
    """By programs of their own, without lists of neighbours: the same bits, of all and of some; of far pairs nearly.

    Few that are part of many have the programs of many.
    """
    arrangement, solved, fields = reference
    some = np.arange(1, COUNT, 3)
    exact = pairs.pair_sums((DIRECT_GRAVITY,), fields, KERNEL, all_pairs=True, virial=True, scale=True)

    def found(engine):
        first = fields["position"], fields["mass"], 0.7 * solved.smoothing_length
        held = engine.listed(arrangement, KERNEL, fields["position"], fields["smoothing_length"])
        densities = [engine.density(arrangement, KERNEL, *first, ETA, 1e-10, targets=of) for of in (None, some)]
        sums = [
            engine.neighbour_sums(at, KERNEL, NEIGHBOUR_TERMS, fields, virial=True, targets=of)
            for at, of in ((held, None), (arrangement, some))
        ]
        lengths = [solution.smoothing_length for solution in densities]
        direct = engine.all_pair_sums(held, KERNEL, (DIRECT_GRAVITY,), fields, virial=True)
        assert largest_error(direct, exact) < 1e-13
        return held.lists, lengths + [each for of in sums for outputs in of.values() for each in outputs.values()]

    lists, few = found(Engine())
    monkeypatch.setattr(tree, "FEW", 0)
    listed, many = found(Engine().within(5000))
    assert lists is None
    assert 0 < listed.count.sum() < COUNT * listed.targets.leaves.size
    for one, other in zip(few[:2], many[:2], strict=True):  # those that outgrow their lists are solved for again there
        assert one == pytest.approx(other, rel=1e-13)
    assert all(np.array_equal(one, other) for one, other in zip(few[2:], many[2:], strict=True)) and len(few) > 10


@pytest.mark.slow
def test_a_wider_program_does_for_some_of_its_effects(reference, monkeypatch):
    arrangement, _, fields = reference
    wide, terms = Engine(programs=((SHEAR,), NEIGHBOUR_TERMS)), (LONE, UNLIMITED)
    without = {name: array for name, array in fields.items() if name != "velocity"}  # which others ask for
    plain = pairs.pair_sums(terms, fields, KERNEL, virial=True)
    carried = []
    for name in ("few_neighbour_pass", "neighbour_pass"):
        made = getattr(numba_cpu, name)
        monkeypatch.setattr(numba_cpu, name, lambda *given, made=made: (carried.append(given[1]), made(*given))[1])
    for few in (COUNT, COUNT - 1):
        monkeypatch.setattr(numba_cpu, "FEW", few)
        found = wide.neighbour_sums(arrangement, KERNEL, terms, without, virial=True)
        assert found.keys() == plain.keys() == {"lone", "unlimited"}
        for effect, outputs in plain.items():
            for name, value in outputs.items():
                assert found[effect][name] == pytest.approx(value, rel=1e-12, abs=1e-12 * np.abs(value).max()), (
                    effect,
                    name,
                )
    assert carried == [NEIGHBOUR_TERMS, NEIGHBOUR_TERMS]
    # PUSH alone is not all that adds to its effect there; and more particles have a program of their own.
    monkeypatch.setattr(numba_cpu, "carry_out", lambda *_: None)  # nothing is compiled of them
    wide.neighbour_sums(arrangement, KERNEL, (PUSH,), fields, virial=True)
    monkeypatch.setattr(numba_cpu, "CARRIED", COUNT - 1)
    wide.neighbour_sums(arrangement, KERNEL, terms, fields, virial=True)
    assert carried[2:] == [(PUSH,), terms]


def test_the_particle_set_is_clustered(reference):
    density = reference[1].density
    assert density.max() / density.min() > 1e4


@pytest.mark.parametrize(
    ("precision", "bar"), [("float64", 1e-13), pytest.param("mixed", 3e-6, marks=pytest.mark.slow)]
)
@pytest.mark.parametrize("off", [1.0, 0.2, 6.0])
def test_smoothing_lengths_and_what_follows_agree_with_bisection(reference, precision, bar, off):
    """Guesses nearly right, far too small and far too large lead to the same root."""
    arrangement, solved, fields = reference
    guess = solved.smoothing_length * off * np.random.default_rng(5).uniform(0.9, 1.1, COUNT)
    found = Engine(precision).density(
        arrangement, KERNEL, fields["position"], fields["mass"], guess, ETA, 1e-14, softening=True
    )
    assert np.max(np.abs(found.smoothing_length / solved.smoothing_length - 1)) < bar
    assert np.max(np.abs(found.density / solved.density - 1)) < 3 * bar
    assert np.max(np.abs(found.grad_h / solved.grad_h - 1)) < 3 * bar
    assert np.max(np.abs(found.zeta / solved.zeta - 1)) < 3 * bar
    rho = fields["mass"] * (ETA / found.smoothing_length) ** 3
    assert np.max(np.abs(found.density / rho - 1)) < 3 * bar


@pytest.mark.slow
def test_a_loose_tolerance_is_kept_and_zeta_is_absent_unless_asked_for(reference):
    arrangement, solved, fields = reference
    found = Engine().density(
        arrangement, KERNEL, fields["position"], fields["mass"], 1.1 * solved.smoothing_length, ETA, 1e-3, False
    )
    error = np.max(np.abs(found.smoothing_length / solved.smoothing_length - 1))
    assert 1e-12 < error < 1e-3
    assert found.zeta is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("precision", "bar"), [("float64", 1e-13), pytest.param("mixed", 1e-4, marks=pytest.mark.full)]
)
def test_neighbour_sums_of_every_kind(reference, precision, bar):
    """central, sum, max, outer and virial, of pairs closer than the larger support, coincident ones among them."""
    arrangement, _, fields = reference
    found = Engine(precision).neighbour_sums(arrangement, KERNEL, NEIGHBOUR_TERMS, fields, virial=True)
    expected = pairs.pair_sums(NEIGHBOUR_TERMS, fields, KERNEL, virial=True, scale=True)
    assert {e: set(o) for e, o in found.items()} == {e: {n for n in o if "scale" not in n} for e, o in expected.items()}
    added = pairs.pair_sums((ADDED,), fields, KERNEL, scale=True)["push"]
    alone = pairs.pair_sums((PUSH,), fields, KERNEL, scale=True)["push"]
    for name in ("acceleration scale", "heat scale"):  # of two terms that add to one output
        expected["push"][name] = added[name] + alone[name]
    assert largest_error(found, expected) < bar
    assert "virial" not in Engine(precision).neighbour_sums(arrangement, KERNEL, (SHEAR,), fields)["shear"]


@pytest.mark.parametrize(
    ("precision", "bar"), [("float64", 1e-13), pytest.param("mixed", 1e-5, marks=pytest.mark.full)]
)
def test_direct_gravity(reference, precision, bar):
    arrangement, _, fields = reference
    found = Engine(precision).all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), fields, virial=True)
    expected = pairs.pair_sums((DIRECT_GRAVITY,), fields, KERNEL, all_pairs=True, virial=True, scale=True)
    assert largest_error(found, expected) < bar


@pytest.mark.full
def test_all_pairs_without_a_far_form_and_of_other_kinds(reference):
    arrangement, _, fields = reference
    found = Engine().all_pair_sums(arrangement, KERNEL, (UNLIMITED, LONE), fields)
    expected = pairs.pair_sums((UNLIMITED, LONE), fields, KERNEL, all_pairs=True, scale=True)
    assert largest_error(found, expected) < 1e-13


def test_steps_and_records_of_few_particles_share_a_program(reference, monkeypatch):
    """Of many each has its own: virial tensors take time that steps have no use for."""
    arrangement, _, fields = reference
    asked = []
    places = {"neighbour_pass": 3, "all_pairs_pass": 3, "few_neighbour_pass": 2, "few_all_pairs_pass": 2}
    real = {name: getattr(numba_cpu, name) for name in places}

    def noting(name):
        return lambda *several: (asked.append(several[places[name]]), real[name](*several))[1]

    for name in real:
        monkeypatch.setattr(numba_cpu, name, noting(name))
    engine, sums = Engine(), []
    for virial in (False, True):
        sums.append(engine.neighbour_sums(arrangement, KERNEL, NEIGHBOUR_TERMS, fields, virial=virial))
        sums.append(engine.all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), fields, virial=virial))
    assert COUNT <= numba_cpu.FEW and asked == [True] * 4
    for plain, full in ((sums[0], sums[2]), (sums[1], sums[3])):
        for effect, outputs in full.items():
            assert set(outputs) - set(plain[effect]) <= {"virial"} and "virial" not in plain[effect]
            for name, values in plain[effect].items():
                np.testing.assert_array_equal(values, outputs[name])
    asked.clear()
    monkeypatch.setattr(numba_cpu, "FEW", COUNT - 1)
    monkeypatch.setattr(numba_cpu, "carry_out", lambda *_: None)  # nothing is compiled of it
    engine.neighbour_sums(arrangement, KERNEL, NEIGHBOUR_TERMS, fields)
    engine.all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), fields)
    assert asked == [False, False]


def test_momentum_is_kept_to_round_off(reference):
    arrangement, _, fields = reference
    mass = fields["mass"][:, None]
    for sums in (
        Engine().neighbour_sums(arrangement, KERNEL, NEIGHBOUR_TERMS, fields, virial=True),
        Engine().all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), fields, virial=True),
    ):
        for outputs in (outputs for outputs in sums.values() if "acceleration" in outputs):
            force = mass * outputs["acceleration"]
            assert np.abs(force.sum(axis=0)).max() < 1e-15 * np.abs(force).sum()


# In mixed precision these terms would be compiled for this alone; those of fluids: tests/physics/test_engines_agree.py.
@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float64", pytest.param("mixed", marks=pytest.mark.full)])
def test_the_number_of_threads_changes_no_bit(precision):
    position, mass = clustered(3000)
    results = []
    for threads in (1, 2, 3):
        engine = Engine(precision, threads=threads)
        order, arrangement = engine.arrange(position, np.ones(3000))
        x, m = position[order], mass[order]
        solved = engine.density(arrangement, KERNEL, x, m, np.full(3000, 0.1), ETA, 1e-6, True)
        fields = {"mass": m, "position": x, "smoothing_length": solved.smoothing_length, "velocity": -x}
        fields["strength"] = solved.density
        sums = engine.neighbour_sums(arrangement, KERNEL, NEIGHBOUR_TERMS, fields, virial=True)
        sums |= engine.all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), fields, virial=True)
        results.append([*vars(solved).values(), *(value for outputs in sums.values() for value in outputs.values())])
    for other in results[1:]:
        assert all(np.array_equal(one, two) for one, two in zip(results[0], other, strict=True))


def test_a_pass_over_little_is_left_to_one_thread(monkeypatch):
    """Sums of few of many particles, and the packing of many more of them, which takes far less time."""
    used = []
    monkeypatch.setattr(numba_cpu, "carry_out", lambda _, threads, *arguments: used.append(threads))
    engine = Engine("mixed", threads=2)
    for count, wanted in ((200, (1, 1)), (1500, (1, 2, 2)), (3000, (2, 2, 2))):
        position, mass = clustered(count)
        fields = {"mass": mass, "position": position, "velocity": -position, "strength": mass}
        fields["smoothing_length"] = np.ones(count)
        arrangement = engine.subset(None, np.arange(count), fields["smoothing_length"])
        engine.neighbour_sums(arrangement, KERNEL, NEIGHBOUR_TERMS, fields)
        engine.all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), fields)
        *lists, packing, neighbours, all_pairs = used  # there are none of very few
        assert packing == 1 and (*lists, neighbours, all_pairs) == wanted
        used.clear()


@pytest.mark.parametrize("name", ["position", "velocity", "smoothing_length", "strength", "mass"])
def test_what_is_not_a_number_shows_in_the_result(reference, name):
    arrangement, _, fields = reference
    spoilt = {key: value.copy() for key, value in fields.items()}
    spoilt[name][200] = np.nan
    sums = Engine().neighbour_sums(arrangement, KERNEL, NEIGHBOUR_TERMS, spoilt, virial=True)
    assert any(np.isnan(value).any() for outputs in sums.values() for value in outputs.values())
    if name != "mass":
        assert np.isnan(sums["push"]["acceleration"][200]).any()
        assert name == "smoothing_length" or np.isnan(sums["push"]["signal"][200])
    if name in ("position", "mass"):
        gravity = Engine().all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), spoilt, virial=True)["gravity"]
        assert np.isnan(gravity["acceleration"]).any()
        found = Engine().density(
            arrangement,
            KERNEL,
            spoilt["position"],
            np.abs(spoilt["mass"]),
            fields["smoothing_length"],
            ETA,
            1e-10,
            True,
        )
        assert np.isnan(found.smoothing_length[200])


def test_particles_far_from_all_others_and_many_in_one_place():
    """An outlier's smoothing length grows until it holds; where no root is left, h is tiny but finite."""
    position, mass = clustered(200)
    position[0] = (80.0, -30.0, 20.0)
    position[50:58] = position[50]
    order, arrangement = Engine().arrange(position, np.ones(200))
    found = Engine().density(arrangement, KERNEL, position[order], mass[order], np.full(200, 1e-3), ETA, 1e-12, True)
    expected = pairs.density(KERNEL, position[order], mass[order], ETA)
    piled = np.isin(order, np.arange(50, 58))
    assert all(np.isfinite(value).all() for value in vars(found).values())
    assert np.max(np.abs(found.smoothing_length / expected.smoothing_length - 1)[~piled]) < 1e-11
    assert found.smoothing_length[piled].max() < 1e-5
    fields = {"mass": mass[order], "position": position[order], "smoothing_length": found.smoothing_length}
    gravity = Engine().all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), fields, virial=True)["gravity"]
    assert np.isfinite(gravity["acceleration"]).all() and np.isfinite(gravity["potential"]).all()


def test_few_particles_and_no_terms():
    position, mass = clustered(12)
    order, arrangement = Engine().arrange(position, np.ones(12))
    solved = Engine().density(arrangement, KERNEL, position[order], mass[order], np.ones(12), ETA, 1e-14, True)
    expected = pairs.density(KERNEL, position[order], mass[order], ETA)
    assert np.max(np.abs(solved.smoothing_length / expected.smoothing_length - 1)) < 1e-13
    assert Engine().neighbour_sums(arrangement, KERNEL, (), {}) == {}
    with pytest.raises(ValueError, match="too few"):
        Engine().density(
            Engine().arrange(position[:3], np.ones(3))[1], KERNEL, position[:3], mass[:3], np.ones(3), ETA, 1
        )


def test_leaves_loosen_as_particles_mix_but_not_as_a_body_shrinks():
    position, _ = clustered(2000)
    h = np.full(2000, 0.1)
    order, arrangement = Engine().arrange(position, h)
    x = position[order]
    assert not Engine().stale(arrangement, x, h)
    assert not Engine().stale(arrangement, 1e-3 * x, 1e-3 * h)
    assert Engine().stale(arrangement, x + 0.5 * np.random.default_rng(1).normal(size=x.shape), h)


def test_a_term_leaves_no_trace_where_it_is_not_listed(reference):
    with_push = neighbour_pass(KERNEL, NEIGHBOUR_TERMS, "float64", True).module
    without = neighbour_pass(KERNEL, (SHEAR,), "float64", False).module
    assert hasattr(with_push, "neighbour_pass_lone_push_shear_unlimited") and hasattr(without, "neighbour_pass_shear")
    assert "push" in Path(str(with_push.__file__)).read_text() and "helper" in vars(with_push)
    assert "push" not in Path(str(without.__file__)).read_text() and "helper" not in vars(without)


def keyword_pair(xp, r):
    return (xp.where(condition=r > 1, x=r, y=0.0),)


def forbidden_pair(xp, r):
    return (xp.exp(-r),)


def fraction_pair(xp, r):
    return (r**0.5,)


def nameless_pair(xp, temperature):
    return (temperature,)


@pytest.mark.parametrize(
    ("pair", "sentence"),
    [
        (keyword_pair, "keywords"),
        (forbidden_pair, r"xp\.exp"),
        (fraction_pair, "power"),
        (nameless_pair, "temperature"),
        (np.add, "plain Python function"),
        (lambda xp, r: (r,), "written with def"),
    ],
)
def test_what_cannot_be_compiled_is_refused_with_a_reason(reference, pair, sentence):
    term = PairTerm("odd", pair, (Output("value", "sum"),))
    with pytest.raises(ValueError, match=sentence):
        Engine().neighbour_sums(reference[0], KERNEL, (term,), reference[2])


def test_missing_fields_and_wrong_choices_are_named(reference):
    arrangement, _, fields = reference
    fields = {name: value for name, value in fields.items() if name != "strength"}
    with pytest.raises(ValueError, match="strength"):
        Engine().neighbour_sums(arrangement, KERNEL, (SHEAR, PUSH), fields)
    with pytest.raises(ValueError, match="added up"):
        Engine().neighbour_sums(arrangement, KERNEL, (PUSH, PUSH), fields)
    with pytest.raises(ValueError, match="there is no kernel"):
        Engine().neighbour_sums(arrangement, "top_hat", (SHEAR,), fields)
    with pytest.raises(ValueError, match="precision"):
        Engine("float16")


def test_generated_code_is_kept_where_nobody_else_can_write(tmp_path, monkeypatch):
    kept = tmp_path / "kernels"
    monkeypatch.setenv("ASTROINERTIA_CACHE", str(kept))
    assert numba_cache.kernel_directory() == kept
    assert kept.stat().st_mode & 0o777 == 0o700
    kept.chmod(0o777)
    with pytest.raises(PermissionError, match="others may write"):
        numba_cache.kernel_directory()
    kept.chmod(0o700)
    monkeypatch.setattr(os, "getuid", lambda: kept.stat().st_uid + 1)
    with pytest.raises(PermissionError, match="another user"):
        numba_cache.kernel_directory()
    monkeypatch.undo()
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("ASTROINERTIA_CACHE", str(blocked / "kernels"))
    assert numba_cache.kernel_directory() != blocked / "kernels"


@pytest.mark.slow
def test_a_second_process_compiles_nothing_again(reference):
    """The cache serves a new interpreter: numba reports hits and no misses for the entry function."""
    Engine().neighbour_sums(reference[0], KERNEL, (SHEAR,), reference[2])
    program = """
import numpy as np
from astroinertia.engines.numba_modules import few_neighbour_pass
from tests.unit.engines.test_numba_cpu import *
position, mass = clustered(50)
engine = Engine()
order, arrangement = engine.arrange(position, np.ones(50))
fields = {"mass": mass, "position": position[order], "velocity": position, "smoothing_length": np.ones(50)}
engine.neighbour_sums(arrangement, KERNEL, (SHEAR,), fields)
stats = few_neighbour_pass(KERNEL, (SHEAR,), False).sums.stats
print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["1", "0"]


@pytest.mark.parametrize("some", [[0], [3, 4, 250, 599], "even", "none"])
def test_targets_have_the_rows_that_they_have_among_all(reference, some):
    """Sources are all particles, whoever the targets are; the boxes of few are smaller, and nothing else changes."""
    arrangement, solved, fields = reference
    targets = {"even": np.arange(0, COUNT, 2), "none": np.arange(0)}[some] if isinstance(some, str) else np.array(some)
    guess = solved.smoothing_length * np.random.default_rng(5).uniform(0.8, 1.2, COUNT)
    given = (KERNEL, fields["position"], fields["mass"], guess, ETA, 1e-14, True)
    for one, every in zip(
        vars(Engine().density(arrangement, *given, targets=targets)).values(),
        vars(Engine().density(arrangement, *given)).values(),
        strict=True,
    ):
        assert one.shape == targets.shape
        assert np.all(np.abs(one / every[targets] - 1) < 1e-13)
    found = Engine().neighbour_sums(arrangement, KERNEL, NEIGHBOUR_TERMS, fields, virial=True, targets=targets)
    expected = pairs.pair_sums(NEIGHBOUR_TERMS, fields, KERNEL)
    for effect, outputs in found.items():
        for name, value in of_particles(outputs):
            full = expected[effect][name]
            assert value.shape == (len(targets), *full.shape[1:])
            assert np.all(np.abs(value - full[targets]) < 1e-12 * np.abs(full).max())
    with pytest.raises(ValueError, match="ascending"):
        Engine().density(arrangement, *given, targets=[5, 4])


@pytest.mark.parametrize("precision", ["float64", pytest.param("mixed", marks=pytest.mark.slow)])
def test_a_subset_is_an_arrangement_of_its_particles(reference, precision):
    arrangement, solved, fields = reference
    engine = Engine(precision)
    some = np.flatnonzero(np.random.default_rng(9).uniform(size=COUNT) < 0.4)
    part = engine.subset(arrangement, some, solved.smoothing_length[some])
    fewer = {name: value[some] for name, value in fields.items()}
    found = engine.neighbour_sums(part, KERNEL, (SHEAR,), fewer)
    expected = pairs.pair_sums((SHEAR,), fewer, KERNEL, scale=True)
    assert largest_error(found, expected) < {"float64": 1e-13, "mixed": 1e-4}[precision]
    assert not engine.stale(part, fewer["position"], fewer["smoothing_length"])


@pytest.mark.slow
def test_impulses_take_the_longer_intervals_of_a_pair_and_keep_momentum(reference):
    """Both parts of a pair's interval, particles that rest or have just become active; plain sums stay as they are."""
    arrangement, _, fields = reference
    random = np.random.default_rng(4)
    closing, opening = 2.0 ** -random.integers(0, 6, (2, COUNT))
    closing[random.uniform(size=COUNT) < 0.1] = 1e100
    opening[random.uniform(size=COUNT) < 0.1] = -1.0
    ends = np.maximum(closing[:, None], closing[None])
    times = np.where(ends < 1e100, ends, 0.0) + np.maximum(opening[:, None], opening[None])
    times = np.where(np.minimum(opening[:, None], opening[None]) < 0.0, 0.0, times)
    found = Engine().neighbour_sums(arrangement, KERNEL, (SPRING,), fields, interval=(closing, opening))["spring"]
    apart = fields["position"][:, None] - fields["position"][None]
    r = np.sqrt((apart**2).sum(axis=2))
    h, mass, strength = fields["smoothing_length"], fields["mass"], fields["strength"]
    slopes = [KERNELS[KERNEL].dw(np, r / side) / side**4 for side in (h[:, None], h[None])]
    weight = mass[None] * sum(slopes) / np.where(r > 0, r, 1)
    near = r < 2.0 * np.maximum(h[:, None], h[None])
    total = np.where(near, mass[None] * (strength[:, None] + strength[None]), 0.0)
    expected = {
        "acceleration": -np.einsum("ij,ija->ia", weight, apart),
        "acceleration_impulse": -np.einsum("ij,ija->ia", weight * times, apart),
        "energy": total.sum(axis=1),
        "energy_impulse": (total * times).sum(axis=1),
    }
    assert set(found) == set(expected)
    for name, value in expected.items():
        assert np.abs(found[name] - value).max() < 1e-13 * np.abs(value).max(), name
    impulse = mass[:, None] * found["acceleration_impulse"]
    assert np.abs(impulse.sum(axis=0)).max() < 1e-15 * np.abs(impulse).sum()


def test_subsets_of_one_size_share_their_arrangement(reference):
    arrangement, solved, _ = reference
    chosen = [np.arange(first, first + 100) for first in (0, 50)]
    one, other = (Engine().subset(arrangement, some, solved.smoothing_length[some]) for some in chosen)
    assert one is other


def test_lists_are_shared_by_passes_and_serve_positions_that_move_a_little(reference, monkeypatch):
    """Shared lists give what each pass by itself gives; made for longer lengths, they outlast moves."""
    monkeypatch.setattr(numba_cpu, "FEW", 0)  # who have no lists
    arrangement, solved, fields = reference
    engine, h = Engine(), solved.smoothing_length
    position, mass = fields["position"].copy(), fields["mass"]
    listed = engine.listed(arrangement, KERNEL, position, 1.3 * h)
    position += 0.1 * h[:, None] * np.random.default_rng(8).uniform(-1, 1, (COUNT, 3))
    fields = {**fields, "position": position}
    some = np.arange(0, COUNT, 97)
    for targets in (None, some):
        guess = 0.95 * h
        shared = engine.density(listed, KERNEL, position, mass, guess, ETA, 1e-14, True, targets=targets)
        alone = engine.density(arrangement, KERNEL, position, mass, guess, ETA, 1e-14, True, targets=targets)
        for one, other in zip(vars(shared).values(), vars(alone).values(), strict=True):
            assert np.all(np.abs(one / other - 1) < 1e-13)
        assert engine._holding(listed, listed.everyone, KERNEL, position, h) is listed.lists
        shared = engine.neighbour_sums(listed, KERNEL, NEIGHBOUR_TERMS, fields, virial=True, targets=targets)
        expected = pairs.pair_sums(NEIGHBOUR_TERMS, fields, KERNEL)
        for effect, outputs in shared.items():
            for name, value in of_particles(outputs):
                full = expected[effect][name]
                assert np.all(np.abs(value - (full if targets is None else full[some])) < 1e-12 * np.abs(full).max())
