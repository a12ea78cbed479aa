"""Every effect passes its own checks in both engines, and a bug planted in any of them is found under its name."""

import inspect
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.effects import catalogue
from astroinertia.effects.kinds import conduction, deleptonisation, gravity, pressure, shear_viscosity, viscosity
from astroinertia.effects.kinds.radiation_reaction import Waves
from astroinertia.engines import numba_cpu, xla
from astroinertia.engines.terms import argument_names, arguments
from astroinertia.gravity import direct
from astroinertia.gravity.point_masses import PointMasses
from astroinertia.matter.gases import Ideal
from astroinertia.models.sph.evaluate import (
    effect_accelerations,
    evaluated,
    internal_energy,
    potential_energies,
    virial_tensors,
)
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.sinks import no_sinks
from astroinertia.models.sph.sorting import rearranged
from astroinertia.models.sph.state import Problem
from astroinertia.models.sph.step import step
from tests import checks_of_effects as checks
from tests.pairs import BruteEngine

PARTICLES = 120
OPTIONS: dict[str, dict[str, Any]] = {
    "gravity": {},
    "pressure": {},
    "viscosity": {},
    "conduction": {},
    "damping": {"time_scale": 3.0, "rate": 0.4, "rate_change": 0.2, "axis": (1.0, 0.5, 2.0)},
    "rotating_frame": {"rate": 0.3, "axis": (1.0, 2.0, 3.0)},
    "tide": {"mass": 3.0, "position": (8.0, 1.0, 0.0), "period": 10.0, "eccentricity": 0.3, "softening": 0.1},
    "companions": {"motion": "live", "softening": 0.1},
    "sinks": {"density": 1.0, "radius": 1.0, "softening": 0.2},
    "external_field": {
        "uniform": (0.1, 0.2, 0.3),
        "quadratic": ((1.0, 0.2, 0.1), (0.2, 0.5, -0.3), (0.1, -0.3, -0.4)),
        "circular_speed": 1.0,
        "core": 0.5,
        "point_mass": 2.0,
        "softening": 0.3,
        "origin": (0.3, 0.2, 0.1),
    },
    "target_tensor": {
        "stiffness": 2.0,
        "axis_ratios": (3.0, 1.0, 2.0),
        "first_axis": (1.0, 0.3, 0.2),
        "second_axis": (0.0, 1.0, 1.0),
        "orientation_stiffness": 1.3,
    },
    "shear_viscosity": {"kinematic_viscosity": 0.3},
    "dipole_braking": {"speed_of_light": 1.0, "period": 3.0, "period_derivative": 0.2, "index": 2.5},
    "radiation_reaction": {"speed_of_light": 3.0},
    "relativistic_potential": {"speed_of_light": 6.0},
    "deleptonisation": {"mass_unit": 2e30, "length_unit": 1.26e5},
    "cooling": {"time_scale": 3.0, "floor": 0.1, "heating_rate": 0.1},
    "neutrino_loss": {"rate": 0.3, "thermal_energy": 0.2, "trapping_density": 1.0},
}
WITHOUT_FORCE = ("conduction", "cooling", "neutrino_loss")
INTERNAL = ("gravity", "pressure", "viscosity", "conduction", "target_tensor", "shear_viscosity", "deleptonisation")
POTENTIAL = (
    "gravity", "pressure", "rotating_frame", "tide", "companions", "sinks", "external_field", "target_tensor",
    "deleptonisation",
)  # fmt: skip


def effects() -> tuple[Any, ...]:
    return tuple(catalogue.build(kind, options) for kind, options in OPTIONS.items())


@cache
def particles() -> SimpleNamespace:
    """A triaxial, clustered, off-centre cloud in disordered motion, with unequal masses and entropies."""
    random = np.random.default_rng(7)
    clump = random.random(PARTICLES) < 0.3
    position = random.normal(size=(PARTICLES, 3)) * np.where(clump[:, None], 0.2, 1.0) * (1.0, 0.8, 0.6) + 0.3
    return SimpleNamespace(
        mass=random.uniform(0.5, 1.5, PARTICLES) / PARTICLES,
        position=position,
        velocity=random.normal(size=(PARTICLES, 3)) - 0.4 * position,
        entropy=random.uniform(0.2, 0.4, PARTICLES),
        displacement=random.normal(size=(PARTICLES, 3)),
    )


def beside(problem: Problem) -> dict[str, Any]:
    """Two companions that move, a sink, and waves that were seen."""
    xp = problem.engine.xp
    place, mass = xp.asarray([[1.5, 0.3, -0.4], [-0.5, 2.0, 0.6]]), xp.asarray([0.7, 0.2])
    sink = {name: xp.asarray(value) for name, value in {
        "mass": [0.4], "position": [[0.2, -0.7, 0.5]], "velocity": [[0.1, 0.0, 0.2]],
        "spin": [[0.0, 0.0, 0.1]],
    }.items()}  # fmt: skip
    one, none = xp.asarray(1.0), xp.zeros((3, 3))
    return {
        "companions": PointMasses(mass, place, 0.1 * place[::-1], xp.asarray(0.1)),
        "sinks": replace(no_sinks(0.2, PARTICLES), **sink),
        "radiation_reaction": Waves(-one, one, none, none, np.ones(2), np.full(2, 16.0), 4.0 * one),
    }


def problem_of(engine: Any, listed: tuple[Any, ...]) -> Problem:
    return Problem(
        effects=listed,
        equation_of_state=Ideal(5 / 3),
        eta=1.2,
        courant=0.3,
        acceleration_factor=0.3,
        energy_factor=0.3,
        max_timestep=1.0,
        engine=engine,
        kernel="cubic",
        smoothing_tolerance=1e-14,
    )


def at_first(engine: Any, listed: tuple[Any, ...]) -> tuple[Problem, Any, Any]:
    """The problem, its state (after one small step, so that the viscosity has seen accelerations), its arrangement."""
    cloud, problem = particles(), problem_of(engine, listed)
    state, arrangement = initial_state(
        problem, cloud.mass, cloud.position, cloud.velocity, cloud.entropy, None, beside(problem)
    )
    return problem, step(problem, arrangement, state, problem.engine.xp.asarray(1e-3)), arrangement


def checked(problem: Problem, state: Any, arrangement: Any, virials: Any = None, applied: Any = None) -> Any:
    """Checks (a) and (b), with the recorded virial tensors and the applied accelerations as they are, or as given."""
    fluid, xp = state.rates.fluid, problem.engine.xp
    accelerations = applied or effect_accelerations(xp, state.rates)
    virials = virials or virial_tensors(problem, arrangement, fluid)
    return checks.effect_checks(
        problem.effects, fluid.mass, fluid.position, fluid.velocity, accelerations, virials, state.rates.heating
    )


@cache
def plain() -> tuple[Problem, Any, Any, dict[str, Any]]:
    """What `at_first` gives of all effects by the sums over all pairs, and the recorded virial tensors."""
    problem, state, arrangement = at_first(BruteEngine(), effects())
    return problem, state, arrangement, virial_tensors(problem, arrangement, state.rates.fluid)


# The engines compile long for all effects at once: test_conservation has most of them in numba_cpu, too.
COMPILED = [pytest.param(engine, marks=pytest.mark.full) for engine in ("numba_cpu", "xla")]


@pytest.mark.parametrize("engine", ["brute", *COMPILED])
def test_every_effect_passes_its_checks(engine: str) -> None:
    with jax.enable_x64(True):
        made = {"brute": BruteEngine, "numba_cpu": numba_cpu.Engine, "xla": xla.Engine}[engine]()
        found = checked(*at_first(made, effects()))
        assert [check.effect for check in found] == list(OPTIONS)
        assert checks.failing(found) == {}, found
        for check in found:  # no check passes because it compares nothing
            assert check.virial is not None
            assert (check.net_force is not None) == (check.effect in INTERNAL)
            assert (check.dissipation is not None) == (check.effect in ("viscosity", "conduction", "shear_viscosity"))


@cache
def exact_changes() -> dict[str, float]:
    """The exact change of every potential energy along the displacement, by forward differentiation through XLA."""
    cloud, listed = particles(), tuple(e for e in effects() if e.kind in POTENTIAL)
    with jax.enable_x64(True):
        # The plain engine makes the state: outside the one program that is wanted, xla compiles hundreds of small ones.
        plain, problem = problem_of(BruteEngine(), listed), problem_of(xla.Engine(), listed)
        state, _ = initial_state(
            plain, cloud.mass, cloud.position, 0 * cloud.velocity, cloud.entropy, None, beside(plain)
        )
        state, arrangement = rearranged(problem, jax.tree.map(jnp.asarray, state))

        def energies(position: Any) -> dict[str, Any]:
            moved = evaluated(problem, arrangement, replace(state, position=position), jnp.zeros(()))
            return {**potential_energies(problem, moved), "pressure": internal_energy(problem, moved)}

        displacement = jnp.asarray(cloud.displacement)[state.identity]
        return checks.potential_changes(energies, state.position, displacement)


def potential_found(listed: tuple[Any, ...]) -> Any:
    cloud, problem = particles(), problem_of(BruteEngine(), listed)
    state, _ = initial_state(
        problem, cloud.mass, cloud.position, 0 * cloud.velocity, cloud.entropy, None, beside(problem)
    )
    accelerations = [np.zeros((PARTICLES, 3)) if a is None else a for a in state.rates.acceleration]
    displacement = cloud.displacement[state.identity]
    return checks.potential_checks(listed, state.mass, accelerations, displacement, exact_changes())


def test_every_potential_differentiates_to_its_acceleration() -> None:
    found = potential_found(effects())
    assert [check.effect for check in found] == list(POTENTIAL)
    assert checks.failing(found) == {}, found


@pytest.mark.parametrize("kind", [kind for kind in OPTIONS if kind not in WITHOUT_FORCE])
@pytest.mark.parametrize("element", [(0, 0), (1, 2), (2, 1)])
def test_a_bug_in_the_recorded_virial_tensor_is_named(kind: str, element: tuple[int, int]) -> None:
    problem, state, arrangement, virials = plain()
    broken = np.array(virials[kind])
    broken[element] += 1e-8 * np.linalg.norm(broken)
    assert set(checks.failing(checked(problem, state, arrangement, {**virials, kind: broken}))) == {kind}
    assert set(checks.failing(checked(problem, state, arrangement, {**virials, kind: -virials[kind]}))) == {kind}


@pytest.mark.parametrize("kind", [kind for kind in OPTIONS if kind not in WITHOUT_FORCE])
def test_a_bug_in_the_applied_acceleration_is_named(kind: str) -> None:
    problem, state, arrangement, virials = plain()
    accelerations = list(effect_accelerations(np, state.rates))
    number = problem.effect_names.index(kind)
    broken = accelerations[number].copy()
    broken[17, 1] *= 1.0 + 1e-6
    accelerations[number] = broken
    assert set(checks.failing(checked(problem, state, arrangement, virials, accelerations))) == {kind}


class Broken:
    """An effect with one of its parts replaced, and all else as it was."""

    def __init__(self, effect: Any, **parts: Any) -> None:
        self.effect, self.parts = effect, parts

    def __getattr__(self, name: str) -> Any:
        parts = object.__getattribute__(self, "parts")
        return parts[name] if name in parts else getattr(object.__getattribute__(self, "effect"), name)

    def during(self, start: float, end: float) -> Any:
        """The same, broken, at all times."""
        return self


def with_broken(kind: str, **parts: Any) -> tuple[Any, ...]:
    return tuple(Broken(effect, **parts) if effect.kind == kind else effect for effect in effects())


def flipped(term: Any, output: str = "acceleration") -> Any:
    """A pair term with the sign of one output turned, in what is applied and in what is recorded alike."""
    signs = [-1.0 if o.name == output else 1.0 for o in term.outputs]
    return _changed(term, lambda arguments, values: tuple(s * v for s, v in zip(signs, values, strict=True)))


def one_sided(term: Any, output: str) -> Any:
    """A pair term with one output that depends on the order of the pair."""
    chosen = [o.name == output for o in term.outputs]

    def biased(arguments: dict[str, Any], values: tuple) -> tuple:
        factor = 1.0 + 1e-6 * arguments[next(name for name in arguments if name.endswith("_i"))]
        return tuple(v * factor if yes else v for v, yes in zip(values, chosen, strict=True))

    return _changed(term, biased)


def _changed(term: Any, change: Any) -> Any:
    # The brute-force engine asks for arguments by the names in the signature.
    names = argument_names(term.pair)

    def pair(xp: Any, *values: Any) -> tuple:
        scalars = dict(zip(names, values, strict=True))
        return change(scalars, term.pair(xp, *arguments(term.pair, scalars)))

    signature = inspect.Signature(
        [inspect.Parameter(name, inspect.Parameter.POSITIONAL_ONLY) for name in ("xp", *names)]
    )
    pair.__signature__ = signature  # type: ignore[attr-defined]
    return replace(term, pair=pair)


PAIRS = {
    "gravity": ("all_pair_terms", direct.DIRECT_GRAVITY, "acceleration"),
    "pressure": ("neighbour_terms", pressure.PRESSURE, "acceleration"),
    "viscosity": ("neighbour_terms", viscosity.RECONSTRUCTED, "acceleration"),
    "conduction": ("neighbour_terms", conduction.RELATIVE_VELOCITY, "heating"),
    "shear_viscosity": ("neighbour_terms", shear_viscosity.SHEAR_VISCOSITY, "acceleration"),
    "deleptonisation": ("neighbour_terms", deleptonisation.LEPTONS, "acceleration"),
}


@pytest.mark.parametrize("kind", PAIRS)
def test_a_pair_force_that_is_not_antisymmetric_is_named(kind: str) -> None:
    place, term, output = PAIRS[kind]
    broken = with_broken(kind, **{place: (one_sided(term, output),)})
    found = checks.failing(checked(*at_first(BruteEngine(), broken)))
    assert set(found) == {kind}, found
    expected = "dissipation" if kind == "conduction" else "net_force"
    assert expected in found[kind]


@pytest.mark.parametrize("kind", POTENTIAL)
def test_a_wrong_sign_in_a_force_with_a_potential_is_named(kind: str) -> None:
    if kind in PAIRS:
        place, term, _ = PAIRS[kind]
        broken = with_broken(kind, **{place: (flipped(term),)})
    else:
        true = catalogue.build(kind, OPTIONS[kind])
        broken = with_broken(kind, acceleration=lambda xp, fluid: -true.acceleration(xp, fluid))
    assert checks.failing(potential_found(broken)) == {kind: ("potential",)}


@pytest.mark.parametrize("kind", ["gravity", "pressure"])
def test_a_missing_term_of_variable_smoothing_lengths_is_named(kind: str) -> None:
    """Without Omega and zeta the forces are off by far more than the bar."""
    true = catalogue.build(kind, OPTIONS[kind])

    def fields(xp: Any, fluid: Any) -> dict[str, Any]:
        return true.fields(xp, replace(fluid, grad_h=np.ones_like(fluid.grad_h), zeta=0.0 * fluid.density))

    found = potential_found(with_broken(kind, fields=fields))
    assert checks.failing(found) == {kind: ("potential",)}
    assert next(check.potential for check in found if check.effect == kind) > 1e-4


def test_a_wrong_sign_in_the_softening_term_is_named() -> None:
    """A term that is a small part of its effect, and whose error leaves momentum and the virial tensor in order."""
    broken = with_broken("gravity", neighbour_terms=(flipped(gravity.SOFTENING),))
    assert checks.failing(potential_found(broken)) == {"gravity": ("potential",)}


@pytest.mark.parametrize("kind", ["viscosity", "shear_viscosity"])
def test_a_wrong_sign_in_a_viscous_force_is_named(kind: str) -> None:
    place, term, _ = PAIRS[kind]
    broken = with_broken(kind, **{place: (flipped(term),)})
    assert checks.failing(checked(*at_first(BruteEngine(), broken))) == {kind: ("dissipation",)}


@pytest.mark.parametrize("kind", ["damping", "rotating_frame"])
def test_a_wrong_sign_in_a_drag_matrix_is_named(kind: str) -> None:
    true = catalogue.build(kind, OPTIONS[kind])
    broken = with_broken(kind, drag=lambda fluid: -true.drag(fluid))
    assert checks.failing(checked(*at_first(BruteEngine(), broken))) == {kind: ("virial",)}


def test_a_figure_that_is_not_a_number_fails() -> None:
    assert checks.EffectCheck("gravity", virial=float("nan")).failures() == ("virial",)
