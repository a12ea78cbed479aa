"""Both engines give the same fluid, effect by effect, for a clustered body with a density contrast of 10^4."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.effects.catalogue import build
from astroinertia.engines import numba_cpu, xla
from astroinertia.engines.terms import COMMON
from astroinertia.matter.gases import Ideal
from astroinertia.models.sph.evaluate import effect_accelerations, evaluated as evaluated_of_particles
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.sorting import rearranged
from astroinertia.models.sph.state import Problem
from tests import pairs

pytestmark = pytest.mark.usefixtures("float64")

COUNT, KERNEL, ETA = 900, "wendland_c2", 1.3
CONTRAST = 1e4
SINGLE = float(np.finfo(np.float32).eps)
# The loops over pairs of the first are those of most scenes; with conduction, they are compiled for this alone.
FEWER = ("gravity", "pressure", "viscosity", "damping", "tide")
ALL = ("gravity", "pressure", "viscosity", "conduction", "damping", "tide")
PASSES = (("gradient_terms", False), ("neighbour_terms", False), ("all_pair_terms", True))


@pytest.fixture(params=[FEWER, pytest.param(ALL, marks=pytest.mark.full)], ids=["fewer", "with conduction"])
def kinds(request):
    """The effects of the fluid."""
    return request.param


def particles():
    """A cuspy rotating ball with unequal masses, cool enough that no effect is negligible."""
    random = np.random.default_rng(11)
    direction = random.normal(size=(COUNT, 3))
    radius = random.uniform(0.05, 1.0, COUNT)
    position = direction / np.linalg.norm(direction, axis=1)[:, None] * (radius**1.5)[:, None]
    mass = random.uniform(0.5, 1.5, COUNT)
    velocity = np.cross([0.0, 0.0, 1.0], position) + 0.5 * random.normal(size=(COUNT, 3))
    return mass / mass.sum(), position, velocity, random.uniform(0.05, 0.1, COUNT)


def problem(engine, kinds):
    options = {
        "damping": {"time_scale": 0.3},
        "tide": {"mass": 20.0, "position": (3.0, 0.0, 0.0), "softening": 0.1},
    }
    return Problem(
        effects=tuple(build(kind, options.get(kind, {})) for kind in kinds),
        equation_of_state=Ideal(5 / 3),
        eta=ETA,
        courant=0.3,
        acceleration_factor=0.25,
        energy_factor=0.25,
        max_timestep=1.0,
        engine=engine,
        kernel=KERNEL,
        smoothing_tolerance=1e-13,
    )


def evaluated_twice(problem):
    """The first state, evaluated again: now the viscosity's switch knows accelerations and the trend of the flow.

    Outside the one program that evaluates, xla compiles hundreds of small ones: it is given a first state that is made
    without it, but for smoothing lengths, which it finds from a guess.
    """
    compiled = problem.engine.name == "xla"
    first = replace(problem, engine=numba_cpu.Engine(precision="float64")) if compiled else problem
    state, arrangement = initial_state(first, *particles())
    if not compiled:
        return evaluated_of_particles(problem, arrangement, state, problem.engine.xp.zeros(()))
    state = jax.tree.map(jnp.asarray, replace(state, smoothing_length=1.1 * state.smoothing_length))
    state, arrangement = rearranged(problem, state)
    return jax.jit(evaluated_of_particles)(problem, arrangement, state, jnp.zeros(()))


@cache
def evaluated(name, precision, kinds):
    """The fluid, accelerations and heating of one engine, in the order of the particles' identities."""
    with jax.enable_x64(True):
        module = {"numba_cpu": numba_cpu, "xla": xla}[name]
        state = evaluated_twice(problem(module.Engine(precision=precision), kinds))
        rates = jax.tree.map(np.asarray, state.rates)
        order = np.argsort(np.asarray(state.identity))
        accelerations = effect_accelerations(np, rates)
        heating = [None if q is None else q[order] for q in rates.heating]
        fluid = {
            field: getattr(rates.fluid, field)[order]
            for field in ("smoothing_length", "density", "grad_h", "zeta", "pressure", "internal_energy")
        }
        return SimpleNamespace(
            acceleration=dict(zip(kinds, (a[order] for a in accelerations), strict=True)),
            heating=dict(zip(kinds, heating, strict=True)),
            fluid=fluid,
            timestep=float(rates.timestep),
        )


@cache
def reference(kinds):
    """Sums over all pairs in one array at each stage of an evaluation, with the sums of the sizes of the terms."""
    with jax.enable_x64(True):
        brute = _Scaled()
        state = evaluated_twice(problem(brute, kinds))
        return brute.fields, brute.sums, state.rates.fluid


class _Scaled(pairs.BruteEngine):
    """The plain engine, which keeps what it was last asked for and the scale of what it gave."""

    def __init__(self):
        self.fields, self.sums = {}, {}

    def density(self, arrangement, kernel, position, mass, guess, eta, tolerance, softening):
        if not hasattr(self, "known"):  # the same positions each time
            self.known = pairs.density(kernel, position, mass, eta, softening)
        return self.known

    def neighbour_sums(self, arrangement, kernel, terms, fields, virial=False):
        return self._kept(terms, fields, kernel, False)

    def all_pair_sums(self, arrangement, kernel, terms, fields, virial=False):
        return self._kept(terms, fields, kernel, True)

    def _kept(self, terms, fields, kernel, all_pairs):
        found = pairs.pair_sums(terms, fields, kernel, all_pairs=all_pairs, virial=True, scale=True)
        self.fields[terms], self.sums[terms] = fields, found
        return {
            effect: {name: value for name, value in outputs.items() if "scale" not in name and name != "virial"}
            for effect, outputs in found.items()
        }


def worst(found, expected):
    """Largest errors, {(effect, output): error / sum of |terms|}."""
    errors = {}
    for effect, outputs in found.items():
        for name, value in outputs.items():
            error, scale = np.abs(np.asarray(value) - expected[effect][name]), expected[effect].get(f"{name} scale")
            if scale is None or name == "signal":
                scale = np.max(np.abs(expected[effect][name]))
            else:
                scale = scale.reshape(scale.shape + (1,) * (error.ndim - 1))
            assert np.all(scale > 0.0), (effect, name)
            errors[effect, name] = float(np.max(error / scale))
    return errors


def pass_errors(name, precision, kinds):
    """Errors of every pass of an evaluation, all engines being given the same fields."""
    engine = {"numba_cpu": numba_cpu, "xla": xla}[name].Engine(precision=precision)
    errors = {}
    for terms, fields in reference(kinds)[0].items():
        order, arrangement = engine.arrange(fields["position"], fields["smoothing_length"])
        order = np.asarray(order)
        back = np.argsort(order)
        method = engine.neighbour_sums if all(term.far is None for term in terms) else engine.all_pair_sums
        given = {field: np.asarray(value)[order] for field, value in fields.items()}
        found = method(arrangement, KERNEL, terms, given, virial=True)
        sorted_back = {
            effect: {n: v if n == "virial" else np.asarray(v)[back] for n, v in outputs.items()}
            for effect, outputs in found.items()
        }
        errors |= worst(sorted_back, reference(kinds)[1][terms])
    return errors


@pytest.mark.full
def test_the_particle_set_is_hard(kinds):
    """A density contrast of 10^4, and no effect without weight in the sum."""
    fluid = evaluated("numba_cpu", "float64", kinds).fluid
    assert fluid["density"].max() / fluid["density"].min() > CONTRAST
    sizes = {
        kind: np.sqrt((a**2).sum(axis=1).mean()) for kind, a in evaluated("xla", "float64", kinds).acceleration.items()
    }
    total = np.sqrt((sum(evaluated("xla", "float64", kinds).acceleration.values()) ** 2).sum(axis=1).mean())
    heats = {
        kind: np.sqrt((q**2).mean()) for kind, q in evaluated("xla", "float64", kinds).heating.items() if q is not None
    }
    assert set(heats) == {"viscosity", "conduction"} & set(kinds)
    assert all(size > 1e-3 * total for kind, size in sizes.items() if kind != "conduction"), sizes
    assert min(heats.values()) > 1e-3 * max(heats.values()), heats


@pytest.mark.full
def test_smoothing_lengths_and_densities_agree(kinds):
    numba_fluid, xla_fluid = (evaluated(name, "float64", kinds).fluid for name in ("numba_cpu", "xla"))
    expected = reference(kinds)[2]
    for field, bar in (("smoothing_length", 1e-13), ("density", 1e-12), ("grad_h", 1e-12), ("zeta", 1e-12)):
        assert np.max(np.abs(numba_fluid[field] / xla_fluid[field] - 1.0)) < bar, field
        assert np.max(np.abs(xla_fluid[field] / getattr(expected, field) - 1.0)) < bar, field


@pytest.mark.parametrize("name", ["numba_cpu", "xla"])
def test_every_pass_is_right_to_rounding(name, kinds):
    errors = pass_errors(name, "float64", kinds)
    summed = {"gravity", "pressure", "viscosity", "conduction"} & set(kinds)
    assert {effect for effect, _ in errors} == summed | {COMMON}  # the velocity gradient, for viscosity
    assert max(errors.values()) < 1e-12, errors


def test_accelerations_and_heating_agree_effect_by_effect(kinds):
    """Whole evaluations, each engine with its own densities, gradients and switches."""
    one, other = (evaluated(name, "float64", kinds) for name in ("numba_cpu", "xla"))
    scales = {}
    for sums in reference(kinds)[1].values():
        for effect, outputs in sums.items():
            for name in ("acceleration", "heating"):
                if outputs.get(f"{name} scale") is not None and outputs[name].ndim < 3:
                    scales[effect, name] = scales.get((effect, name), 0.0) + outputs[f"{name} scale"]
    for kind in kinds:
        scale = scales.get((kind, "acceleration"), np.linalg.norm(one.acceleration[kind], axis=1))
        error = np.linalg.norm(one.acceleration[kind] - other.acceleration[kind], axis=1)
        assert np.all(error <= 1e-11 * scale), kind
        if one.heating[kind] is not None:
            error = np.abs(one.heating[kind] - other.heating[kind])
            assert np.all(error <= 1e-11 * scales[kind, "heating"]), kind
    assert one.timestep == pytest.approx(other.timestep, rel=1e-12)


@pytest.mark.full
@pytest.mark.parametrize("name", ["numba_cpu", "xla"])
def test_mixed_precision_costs_what_single_precision_pairs_cost(name, kinds):
    """A pair value goes through some 30 roundings, a few of them amplified by the slope of the kernel (below 10)."""
    errors = pass_errors(name, "mixed", kinds)
    assert max(errors.values()) < 100 * SINGLE, errors
    mixed, exact = evaluated(name, "mixed", kinds), evaluated(name, "float64", kinds)
    assert np.max(np.abs(mixed.fluid["smoothing_length"] / exact.fluid["smoothing_length"] - 1.0)) < 30 * SINGLE
    assert 1e-3 * SINGLE < np.max(np.abs(mixed.fluid["density"] / exact.fluid["density"] - 1.0)) < 100 * SINGLE
    # Each side of a pair is rounded by itself: what is left of the net force is a random sum of roundings.
    mass = particles()[0]
    for kind in ("gravity", "pressure", "viscosity"):
        acceleration = mixed.acceleration[kind]
        net = np.linalg.norm(mass @ acceleration)
        assert net < SINGLE * (mass @ np.linalg.norm(acceleration, axis=1)), kind
