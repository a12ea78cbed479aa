"""The xla engine against plain sums over all pairs, its lists, its derivatives and what it holds in memory."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.effects.kinds.gravity import SOFTENING
from astroinertia.engines import numba_cpu
from astroinertia.engines.terms import Output, PairTerm
from astroinertia.engines.xla import Engine
from astroinertia.gravity.direct import DIRECT_GRAVITY
from tests import pairs

pytestmark = pytest.mark.usefixtures("float64")

COUNT = 220
SINGLE = float(np.finfo(np.float32).eps)


def flow_pair(xp, v_r, x_ij, z_ij, W_i, dW_j, weight_i, weight_j):
    """Every way to gather at once, with an asymmetry that a swap of the two sides would show."""
    push = (weight_i + 2.0 * weight_j) * dW_j * (1.0 + xp.abs(x_ij) + z_ij * z_ij)
    return push, weight_j * W_i * (1.0 + xp.abs(v_r)), xp.maximum(v_r, 0.0) + weight_i * weight_j, push


FLOW = PairTerm(
    "flow",
    flow_pair,
    (
        Output("acceleration", "central"),
        Output("heating", "sum"),
        Output("signal", "max"),
        Output("gradient", "outer", of="velocity"),
    ),
)
NEIGHBOURS = (FLOW, SOFTENING)


def clustered(count, seed=3):
    """Two balls of points, far from each other, with rho ~ r^-2 and two of them coincident."""
    random = np.random.default_rng(seed)
    direction = random.normal(size=(count, 3))
    position = direction / np.linalg.norm(direction, axis=1)[:, None] * random.uniform(size=count)[:, None]
    position[count // 2 :] += [4.0, 0.0, 0.0]
    position[count // 4] = position[0]
    return position


def body(engine, kernel="cubic", count=COUNT):
    """An arrangement and the fields of its particles, smoothing lengths by the plain reference."""
    random = np.random.default_rng(4)
    position, mass = clustered(count), random.uniform(0.5, 1.5, count) / count
    lengths = pairs.density(kernel, position, mass, 1.2, softening=False).smoothing_length
    order, arrangement = engine.arrange(position, lengths)
    fields = {
        "position": position[order],
        "mass": mass[order],
        "smoothing_length": lengths[order],
        "velocity": random.normal(size=(count, 3)),
        "weight": random.uniform(0.5, 1.5, count),
        "zeta_over_omega": random.uniform(-1.5, -0.5, count),
    }
    return arrangement, fields


def assert_close(found, expected, bar):
    """Every output within `bar` of the sum of the sizes of its terms; a virial within it of its largest component."""
    for effect, outputs in found.items():
        for name, value in outputs.items():
            error = np.abs(np.asarray(value) - expected[effect][name])
            scale = expected[effect].get(f"{name} scale")
            if scale is None or name == "signal":
                scale = np.abs(expected[effect][name]).max()
            else:
                scale = scale.reshape(scale.shape + (1,) * (error.ndim - 1))
            assert np.all(error <= bar * scale), (effect, name, np.max(error / scale))


@pytest.mark.slow
@pytest.mark.parametrize("kernel", ["cubic", pytest.param("wendland_c6", marks=pytest.mark.full)])
def test_sums_are_those_over_all_pairs(kernel):
    engine = Engine(wide_leaf=32)
    arrangement, fields = body(engine, kernel)
    assert not engine.stale(arrangement, fields["position"], fields["smoothing_length"])
    assert arrangement.far.leaf.shape[0] > 0
    found = engine.neighbour_sums(arrangement, kernel, NEIGHBOURS, fields, virial=True)
    assert_close(found, pairs.pair_sums(NEIGHBOURS, fields, kernel, virial=True, scale=True), 1e-13)
    found = engine.all_pair_sums(arrangement, kernel, (DIRECT_GRAVITY,), fields, virial=True)
    expected = pairs.pair_sums((DIRECT_GRAVITY,), fields, kernel, all_pairs=True, virial=True, scale=True)
    assert_close(found, expected, 1e-13)


@pytest.mark.slow
def test_lists_that_are_out_of_date_lose_no_pair():
    """Particles thrown far about, and a kernel that reaches further than the lists, change the cost alone."""
    engine = Engine(wide_leaf=32)
    arrangement, fields = body(engine)
    fields["position"] = clustered(COUNT, seed=9)
    assert engine.stale(arrangement, fields["position"], fields["smoothing_length"])
    found = engine.neighbour_sums(arrangement, "cubic", NEIGHBOURS, fields, virial=True)
    assert_close(found, pairs.pair_sums(NEIGHBOURS, fields, "cubic", virial=True, scale=True), 1e-13)
    found = engine.all_pair_sums(arrangement, "cubic", (DIRECT_GRAVITY,), fields)
    expected = pairs.pair_sums((DIRECT_GRAVITY,), fields, "cubic", all_pairs=True, scale=True)
    assert_close(found, expected, 1e-13)
    arrangement, fields = body(engine)
    found = engine.neighbour_sums(arrangement, "quintic", NEIGHBOURS, fields)
    assert_close(found, pairs.pair_sums(NEIGHBOURS, fields, "quintic", scale=True), 1e-13)


@pytest.mark.full
@pytest.mark.parametrize("guess", [1e-3, 0.2, 30.0])
def test_smoothing_lengths_do_not_depend_on_the_guess(guess):
    engine, position = Engine(), clustered(COUNT)
    mass = np.random.default_rng(4).uniform(0.5, 1.5, COUNT) / COUNT
    order, arrangement = engine.arrange(position, np.full(COUNT, 0.2))
    position, mass = position[order], mass[order]
    found = engine.density(arrangement, "cubic", position, mass, np.full(COUNT, guess), 1.2, 1e-13, True)
    expected = pairs.density("cubic", position, mass, 1.2)
    for name in ("smoothing_length", "density", "grad_h", "zeta"):
        assert np.max(np.abs(getattr(found, name) / getattr(expected, name) - 1.0)) < 2e-14, name


@pytest.mark.full
def test_light_particles_beside_heavy_ones_have_lengths():
    """Their kernels end just short of a heavy neighbour; steps that go to and fro between two lengths must end, too."""
    engine, position = Engine(), np.random.default_rng(5).normal(size=(COUNT, 3))
    mass = np.where(np.arange(COUNT) % 40 == 0, 1e-8, 1.0) / COUNT
    order, arrangement = engine.arrange(position, np.full(COUNT, 0.6))
    position, mass = position[order], mass[order]
    found = engine.density(arrangement, "wendland_c2", position, mass, np.full(COUNT, 0.6), 1.3, 1e-12, False)
    content = np.asarray(found.density) * np.asarray(found.smoothing_length) ** 3 / mass
    assert np.max(np.abs(content / 1.3**3 - 1.0)) < 1e-8


@pytest.mark.full
def test_the_tolerance_is_kept():
    engine = Engine()
    arrangement, fields = body(engine)
    h = fields["smoothing_length"]
    for tolerance in (1e-2, 1e-8):
        found = engine.density(arrangement, "cubic", fields["position"], fields["mass"], 1.3 * h, 1.2, tolerance, False)
        assert np.max(np.abs(found.smoothing_length / h - 1.0)) < tolerance


@pytest.mark.full
def test_mixed_precision_costs_single_precision_rounding():
    """A pair value goes through some 30 roundings, of which the kernel's slope (below 10) amplifies a few."""
    engine = Engine(precision="mixed", wide_leaf=32)
    arrangement, fields = body(engine)
    found = engine.neighbour_sums(arrangement, "cubic", NEIGHBOURS, fields, virial=True)
    expected = pairs.pair_sums(NEIGHBOURS, fields, "cubic", virial=True, scale=True)
    assert_close(found, expected, 50 * SINGLE)
    error = np.abs(found["flow"]["heating"] - expected["flow"]["heating"]) / expected["flow"]["heating scale"]
    assert np.max(error) > 0.01 * SINGLE  # pairs are in single precision indeed
    assert found["flow"]["acceleration"].dtype == np.float64
    position, mass, h = fields["position"], fields["mass"], fields["smoothing_length"]
    solved = engine.density(arrangement, "cubic", position, mass, 1.1 * h, 1.2, 1e-10, True)
    assert np.max(np.abs(solved.smoothing_length / h - 1.0)) < 30 * SINGLE


def energy(engine, arrangement, fields, position):
    """A scalar of h, density and sums over neighbours and over all pairs."""
    h, mass = fields["smoothing_length"], fields["mass"]
    solved = engine.density(arrangement, "cubic", position, mass, h, 1.2, 1e-13, False)
    now = {**fields, "position": position, "smoothing_length": solved.smoothing_length, "weight": solved.density}
    near = engine.neighbour_sums(arrangement, "cubic", NEIGHBOURS, now)
    all_pairs = engine.all_pair_sums(arrangement, "cubic", (DIRECT_GRAVITY,), now)
    return scalar([near, all_pairs])


def scalar(sums):
    """One number of many arrays."""
    return sum(jnp.log1p(value**2).mean() for value in jax.tree.leaves(sums))


def assert_slope(function, gradient, fields):
    """The gradient against a difference of the function along a random direction."""
    at, direction = jnp.asarray(fields["position"]), random_direction(fields)
    # The coincident pair flies apart along the direction: keep it together, r is not smooth there.
    together = jnp.asarray(np.flatnonzero((fields["position"] == clustered(COUNT)[0]).all(axis=1)))
    direction = direction.at[together].set(direction[together[0]])
    width = 1e-8
    difference = (function(at + width * direction) - function(at - width * direction)) / (2 * width)
    assert np.all(np.isfinite(gradient))  # although two particles coincide
    assert float((gradient * direction).sum()) == pytest.approx(float(difference), rel=1e-6)


def random_direction(fields):
    return jnp.asarray(np.random.default_rng(6).normal(size=fields["position"].shape))


@pytest.mark.full
def test_reverse_derivatives_of_sums_are_right():
    """At given smoothing lengths: tests/physics/test_variational.py differentiates through those that are solved."""
    engine = Engine(wide_leaf=32, motion=0.05)
    arrangement, fields = body(engine)

    def sums(position):
        now = {**fields, "position": position}
        near = engine.neighbour_sums(arrangement, "cubic", (FLOW,), now)
        return scalar([near, engine.all_pair_sums(arrangement, "cubic", (DIRECT_GRAVITY,), now)])

    both = jax.jit(jax.value_and_grad(sums))
    assert_slope(lambda position: both(position)[0], both(jnp.asarray(fields["position"]))[1], fields)


@pytest.mark.full
def test_forward_and_reverse_derivatives_agree_and_are_right():
    engine = Engine(wide_leaf=32, motion=0.05)
    arrangement, fields = body(engine)
    at, direction = jnp.asarray(fields["position"]), random_direction(fields)
    function = jax.jit(lambda position: energy(engine, arrangement, fields, position))
    gradient = jax.jit(jax.grad(function))(at)
    _, forward = jax.jvp(function, (at,), (direction,))
    assert float((gradient * direction).sum()) == pytest.approx(float(forward), rel=1e-11)
    assert_slope(function, gradient, fields)


@pytest.mark.full
def test_reverse_mode_stores_no_pairs():
    engine = Engine(wide_leaf=32, pairs_in_chunk=2048)
    arrangement, fields = body(engine)
    at = jnp.asarray(fields["position"])
    _, pullback = jax.vjp(lambda position: energy(engine, arrangement, fields, position), at)
    stored = sum(array.size for array in jax.tree.leaves(pullback))
    listed = sum(array.size for array in jax.tree.leaves(arrangement))
    assert stored < 6 * listed + 100 * COUNT
    assert arrangement.neighbours.leaf.shape[0] > 8  # several chunks


@pytest.mark.slow
def test_results_have_the_same_bits_each_time_and_hardly_depend_on_chunks():
    results = []
    for chunk in (4096, 4096, 1 << 17):
        engine = Engine(pairs_in_chunk=chunk)
        arrangement, fields = body(engine)
        results.append(engine.neighbour_sums(arrangement, "cubic", (SOFTENING,), fields)["gravity"]["acceleration"])
    if jax.default_backend() == "cpu":  # a GPU adds up the sums of a leaf in any order
        assert np.array_equal(results[0], results[1])
    assert np.max(np.abs(results[0] - results[1])) < 1e-13 * np.max(np.abs(results[0]))
    assert np.max(np.abs(results[0] - results[2])) < 1e-13 * np.max(np.abs(results[0]))


def test_lists_hold_all_neighbours_and_margins():
    engine = Engine(motion=0.03, growth=0.05)
    arrangement, fields = body(engine)
    tiles = arrangement.neighbours
    listed = np.zeros((COUNT + 1, COUNT + 1), bool)
    slots, used = np.asarray(tiles.slots), int(tiles.used)
    sources = np.asarray(tiles.sources)[:used].reshape(-1, tiles.sources.shape[2])
    for leaf, members in zip(np.asarray(tiles.leaf)[:used].ravel(), sources, strict=True):
        listed[np.ix_(slots[leaf], members)] = True
    position, h = fields["position"], fields["smoothing_length"]
    distance = np.linalg.norm(position[:, None] - position[None], axis=2)
    reach = 2.0 * h * 1.05
    within = distance < np.maximum(reach[:, None], reach[None]) + 0.03 * 2.0 * (h[:, None] + h[None])
    assert np.all(listed[:COUNT, :COUNT][within])
    assert listed[:COUNT, :COUNT].mean() < 1.0
    assert not engine.stale(arrangement, position + np.array([5.0, 0.0, 0.0]), h * 1.04)
    assert engine.stale(arrangement, position, h * 1.06)
    assert engine.stale(arrangement, position + 0.07 * h[:, None] * np.sign(position), h)


@pytest.mark.slow
def test_an_effect_is_named_in_the_compiled_program_where_it_is_listed_and_only_there():
    engine = Engine()
    arrangement, fields = body(engine)

    def program(terms):
        lowered = jax.jit(lambda f: engine.neighbour_sums(arrangement, "cubic", terms, f)).lower(fields)
        return lowered.compile().as_text()

    both, one = program(NEIGHBOURS), program((SOFTENING,))
    assert "effect:flow" in both
    assert "effect:gravity" in both
    assert "effect:gravity" in one
    assert "effect:flow" not in one


@pytest.mark.full
def test_what_is_not_a_number_stays_so_and_the_solve_ends():
    engine = Engine()
    arrangement, fields = body(engine)
    position = fields["position"].copy()
    position[7] = np.nan
    solved = engine.density(
        arrangement, "cubic", position, fields["mass"], fields["smoothing_length"], 1.2, 1e-6, False
    )
    assert np.isnan(solved.density[7])


def test_single_precision_by_oversight_is_refused():
    with jax.enable_x64(False), pytest.raises(ValueError, match="64 bits"):
        Engine().arrange(clustered(9), np.full(9, 0.5))
    with pytest.raises(ValueError, match="precision"):
        Engine(precision="float32")  # type: ignore[arg-type]


def test_what_a_pair_function_asks_for_and_is_not_there_is_named_as_the_other_engine_names_it():
    def warm(xp, W_i, temperature_j):
        return (W_i * temperature_j,)

    def sideless(xp, r, temperature):
        return (r * temperature,)

    def approaching(xp, v_r):
        return (v_r,)

    position, length = clustered(30), np.full(30, 0.5)
    fields = {"mass": length, "position": position, "smoothing_length": length}
    for pair, output, sentence in (
        (warm, Output("value", "sum"), "asks for the field temperature, which is not among mass, position, smoothing_"),
        (approaching, Output("value", "outer", of="spin"), "asks for the field (spin|velocity)"),
        (approaching, Output("value", "sum"), "asks for the field velocity"),
        (sideless, Output("value", "sum"), "cannot ask for temperature: it ends neither in _i nor in _j"),
    ):
        for engine in (Engine(), numba_cpu.Engine()):
            arrangement = engine.arrange(position, length)[1]
            with pytest.raises(ValueError, match=sentence):
                engine.neighbour_sums(arrangement, "cubic", (PairTerm("odd", pair, (output,)),), fields)


@pytest.mark.full
def test_few_particles():
    engine = Engine()
    for count in (1, 17):
        order, arrangement = engine.arrange(clustered(count), np.full(count, 0.5))
        position, mass = clustered(count)[order], np.ones(count)
        solved = engine.density(arrangement, "cubic", position, mass, np.full(count, 0.5), 1.2, 1e-13, True)
        # Up to five particles have too little mass for any length; the solve gives up on them with a finite one.
        assert np.all(np.isfinite(solved.smoothing_length))
    expected = pairs.density("cubic", position, mass, 1.2)
    assert np.max(np.abs(solved.smoothing_length / expected.smoothing_length - 1.0)) < 1e-13
