"""A scene without an effect has nothing of it: no object, no operation in what is compiled, no bit of the results.

Each test first shows that it finds an effect that is listed.
"""

import json
import re
import subprocess
import sys
import textwrap
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

from astroinertia.build import sph as start_sph
from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.engines import numba_modules, xla
from astroinertia.engines.terms import COMMON
from astroinertia.gravity.point_masses import PointMasses
from astroinertia.models.sph.evaluate import virial_tensors
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.sinks import no_sinks
from astroinertia.models.sph.sorting import arranged
from astroinertia.models.sph.state import Problem
from astroinertia.models.sph.step import step
from astroinertia.scene import load, plan
from tests.pairs import BruteEngine

ROOT = Path(__file__).parent.parent.parent
SCENE = """
name = "called_for"
units = "code"
[body]
kind = "uniform"
particles = 64
mass = 1.0
radius = 1.0
relax = false
placement = "random"
specific_internal_energy = 0.3
velocity_gradient = [[-0.3, -0.5, 0.0], [0.5, -0.3, 0.1], [0.0, 0.0, -0.4]]
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
[time]
end = 1.0
"""
TABLES = {
    "gravity": "",
    "pressure": "",
    "viscosity": "",
    "conduction": "",
    "damping": "time_scale = 3.0\nrate = 0.4",
    "rotating_frame": "rate = 0.3",
    "tide": "mass = 3.0\nposition = [8.0, 1.0, 0.0]\nperiod = 10.0",
    "companions": 'motion = "live"\n[[companions]]\nname = "moon"\nmass = 0.1\nsemi_major_axis = 8.0',
    "sinks": "density = 1e6\nradius = 1.0",
    "external_field": "point_mass = 2.0\nsoftening = 0.3",
    "target_tensor": "stiffness = 2.0\naxis_ratios = [2.0, 1.0, 1.0]",
    "shear_viscosity": "kinematic_viscosity = 0.1",
    "dipole_braking": "speed_of_light = 1.0\nperiod = 3.0\nperiod_derivative = 0.2",
    "radiation_reaction": "speed_of_light = 3.0",
    "relativistic_potential": "speed_of_light = 6.0",
    "deleptonisation": "mass_unit = 2e30\nlength_unit = 1.26e5",
    "cooling": "time_scale = 3.0\nfloor = 0.1",
    "neutrino_loss": 'law = "diffusion"\ntime_scale = 3.0\ndensity = 0.1',
}
PARTICLE_EFFECTS = tuple(kind for kind, entry in CATALOGUE.items() if "sph" in entry.models)
# What a compiled program could hold of an effect, whatever its name: its functions, fields, memories and kernels.
TRACES = {
    "gravity": r"gravity|direct_pair|direct_far|point_pair|less_point|softening_pair|zeta_over_omega|"
    r"\bd?phi_[ij]\b|_phi\b|_dphi\b",
    "pressure": r"pressure_pair|pressure_weight|out_pressure|curved_pair|curvature",
    "viscosity": r"(?<!shear_)(?<!kinematic_)viscosity|gradient_pair|trend_pair|reconstructed_pair|guarded_pair|"
    r"strain_",
    "conduction": r"conduction|relative_velocity_pair|shear_limited_pair|pressure_jump_pair",
    "shear_viscosity": r"shear_viscosity|kinematic_viscosity",
    "deleptonisation": r"deleptonisation|lepton_",
}
HALVES = (
    (
        "gravity",
        "pressure",
        "damping",
        "tide",
        "companions",
        "target_tensor",
        "shear_viscosity",
        "dipole_braking",
        "relativistic_potential",
        "deleptonisation",
    ),
    (
        "pressure",
        "viscosity",
        "conduction",
        "rotating_frame",
        "external_field",
        "cooling",
        "neutrino_loss",
        "radiation_reaction",
    ),
)


def scene_text(listed: Any) -> str:
    return SCENE + "".join(f"[effects.{kind}]\n{TABLES[kind]}\n" for kind in listed)


def without(kind: str) -> tuple[str, ...]:
    """All others, but for those that act beside it alone."""

    def needs(other: str) -> bool:
        return kind in CATALOGUE[other].needs and not CATALOGUE[other].numerical

    return tuple(other for other in TABLES if other != kind and not needs(other))


def owners(listed: Any) -> set[str]:
    """Whom sums over pairs may be of: the effects, and of all together the velocity gradient, which viscosity needs."""
    return set(listed) | ({COMMON} if "viscosity" in listed else set())


def in_a_fresh_process(program: str, *arguments: str) -> Any:
    """What a program prints last, as JSON, run by an interpreter that has imported nothing yet."""
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program), *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout.splitlines()[-1])


# Objects and modules

IMPORTS = """
    import gc, json, sys
    from collections import Counter
    from dataclasses import replace
    import numpy as np
    from astroinertia.cli import main
    from astroinertia.run import loop
    from astroinertia.build import sph as start_sph
    from astroinertia.effects import catalogue
    from astroinertia.models.sph import record
    from astroinertia.models.sph.evaluate import virial_tensors
    from astroinertia.models.sph.first_state import initial_state
    from astroinertia.models.sph.sorting import arranged
    from astroinertia.models.sph.state import Problem
    from astroinertia.models.sph.step import step
    from astroinertia.scene import load, plan
    from tests.pairs import BruteEngine
    found = []
    def made():
        objects = Counter(map(type, gc.get_objects()))
        return [kind for kind, entry in catalogue.CATALOGUE.items() if objects[entry.made]]
    def imported():
        rooms = ("astroinertia.gravity.", "astroinertia.models.sph.sinks")
        return sorted(name for name in sys.modules if name.startswith(rooms))
    found.append([made(), imported()])
    for text in json.loads(sys.argv[1]):
        scene = load.loads(text)
        plan.plan(scene)
        problem, _ = start_sph.problem_of(scene, plan.code_units(scene))
        problem = replace(problem, engine=BruteEngine())
        random = np.random.default_rng(0).normal(size=(2, 24, 3))
        points = {}
        if "companions" in problem.effect_names:
            from astroinertia.gravity.point_masses import PointMasses
            place = 8.0 * np.eye(3)
            points["companions"] = PointMasses(np.ones(3), place, 0.0 * place, np.float64(0.1))
        if "sinks" in problem.effect_names:
            from astroinertia.models.sph.sinks import no_sinks
            points["sinks"] = no_sinks(0.1, 24)
        state, arrangement = initial_state(
            problem, np.ones(24), random[0], random[1], np.ones(24), points=points
        )
        state = step(problem, arrangement, state, 1e-3)
        record.series_record(problem, arrangement, state, None)
        found.append([made(), imported()])
    print(json.dumps(found))
"""
# Pair functions and sums over few points, which effects are described with.
ALWAYS = {f"astroinertia.gravity.{name}" for name in ("clamped_points", "direct", "point_masses")}
ALONGSIDE = {"sinks": {"astroinertia.models.sph.sinks"}}


@pytest.mark.parametrize(
    "backwards", [False, pytest.param(True, marks=pytest.mark.full)], ids=["in order", "in reverse"]
)
def test_only_listed_effects_are_made_and_only_what_they_need_is_imported(backwards: bool) -> None:
    """Effects listed one after the other, each scene run for a step: objects and modules come with them, not before.

    In both orders, so that of any two effects each is seen without the other, but for one that acts beside the other
    alone.
    """
    order = PARTICLE_EFFECTS[:: -1 if backwards else 1]
    beside = {kind: [name for name in order if kind not in without(name)] for kind in order}  # and itself
    kinds = sorted(order, key=lambda kind: max(map(order.index, beside[kind])) + 0.5 * (len(beside[kind]) > 1))
    texts = [scene_text(kinds[: k + 1]) for k in range(len(kinds))]
    found = in_a_fresh_process(IMPORTS, json.dumps(texts))
    assert found[0] == [[], sorted(ALWAYS)]
    expected = set(ALWAYS)
    for k, (made, modules) in enumerate(found[1:]):
        expected |= ALONGSIDE.get(kinds[k], set())
        assert set(made) == set(kinds[: k + 1])
        assert set(modules) == expected, kinds[k]


# The numba engine


class Recorder(BruteEngine):
    """Keeps what the model asks of its engine."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, tuple, bool]] = []
        self.softening: set[bool] = set()

    def density(self, arrangement: Any, kernel: str, *rest: Any) -> Any:
        self.softening.add(rest[-1])
        return super().density(arrangement, kernel, *rest)

    def neighbour_sums(self, arrangement: Any, kernel: str, terms: Any, fields: Any, virial: bool = False) -> Any:
        self.asked.append((kernel, tuple(terms), virial))
        return super().neighbour_sums(arrangement, kernel, terms, fields, virial)

    def all_pair_sums(self, arrangement: Any, kernel: str, terms: Any, fields: Any, virial: bool = False) -> Any:
        self.asked.append((kernel, tuple(terms), virial))
        return super().all_pair_sums(arrangement, kernel, terms, fields, virial)


def problem_of(listed: Any, engine: Any) -> Problem:
    scene = load.loads(scene_text(listed))
    return replace(start_sph.problem_of(scene, plan.code_units(scene))[0], engine=engine)


def started(listed: Any, engine: Any) -> tuple[Problem, Any, Any]:
    problem, random = problem_of(listed, engine), np.random.default_rng(0).normal(size=(2, 48, 3))
    place = 8.0 * np.eye(3)
    points = {
        "companions": PointMasses(np.ones(3), place, 0.0 * place, np.float64(0.1)),
        "sinks": no_sinks(0.1, 48),
    }
    beside = {kind: each for kind, each in points.items() if kind in listed}
    return problem, *initial_state(problem, np.ones(48) / 48, random[0], random[1], np.ones(48), points=beside)


@cache
def generated(listed: tuple[str, ...]) -> tuple[set[str], str, set[str]]:
    """Effects in the term lists, text and symbols of all that the numba engine generates for a scene's step."""
    engine = Recorder()
    problem, state, arrangement = started(listed, engine)
    state = step(problem, arrangement, state, np.float64(1e-3))
    virial_tensors(problem, arrangement, state.rates.fluid)
    effects = {term.effect for _, terms, _ in engine.asked for term in terms}
    modules = [numba_modules.density_pass(problem.kernel, "float64", softening)[0] for softening in engine.softening]
    for kernel, terms, virial in engine.asked:
        far = all(term.far for term in terms)
        make = numba_modules.all_pairs_pass if far else numba_modules.neighbour_pass
        modules.append(make(kernel, terms, "float64", virial)[0])
        of_few = numba_modules.few_all_pairs_pass if far else numba_modules.few_neighbour_pass
        modules.append(of_few(kernel, terms, virial).module)
    # Comments are for readers; only what is compiled counts.
    texts = [re.sub(r"#.*", "", Path(str(module.__file__)).read_text()) for module in modules]
    return effects, "\n".join(texts), {name for module in modules for name in vars(module)}


@pytest.mark.parametrize("kind", TRACES)
def test_the_generated_loops_have_nothing_of_an_effect_that_is_not_listed(kind: str) -> None:
    effects, text, symbols = generated(tuple(TABLES))
    assert kind in effects
    assert re.search(TRACES[kind], text)
    assert any(re.search(TRACES[kind], symbol) for symbol in symbols)
    effects, text, symbols = generated(without(kind))
    assert effects == owners(set(TRACES) & set(without(kind)))
    assert re.search(TRACES[kind], text) is None, re.search(TRACES[kind], text)
    assert [symbol for symbol in symbols if re.search(TRACES[kind], symbol)] == []


# The xla engine


@cache
def traced(listed: tuple[str, ...], compiled: bool) -> str:
    """The program of one step: as traced, with the scopes that its operations stand in, or as compiled."""
    with jax.enable_x64(True):
        problem, state, arrangement = started(listed, BruteEngine())
        engine = xla.Engine()
        _, pairs = engine.arrange(state.position, state.smoothing_length)
        problem = problem_of(listed, engine)
        state = jax.tree.map(jax.numpy.asarray, state)
        arrangement = arranged(problem, pairs, state)
        trace = jax.jit(step).trace(problem, arrangement, state, jax.numpy.asarray(1e-3))
        return trace.lower().compile().as_text() if compiled else trace.jaxpr.pretty_print(name_stack=True)


def scopes(program: str) -> set[str]:
    return set(re.findall(r"effect:(\w+)", program))


@pytest.mark.full
@pytest.mark.parametrize("kind", PARTICLE_EFFECTS)
def test_the_traced_step_has_no_operation_of_an_effect_that_is_not_listed(kind: str) -> None:
    assert kind in scopes(traced(PARTICLE_EFFECTS, False))
    assert scopes(traced(without(kind), False)) == owners(set(PARTICLE_EFFECTS) & set(without(kind)))


@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=pytest.mark.full)], ids=["traced", "compiled"])
def test_a_step_has_operations_of_listed_effects_only(compiled: bool) -> None:
    """Two halves of the catalogue: each effect is found in the program of one of them, and not in the other's."""
    assert set(HALVES[0]) | set(HALVES[1]) == set(PARTICLE_EFFECTS) - {"sinks"}  # which xla refuses
    assert set(HALVES[0]) & set(HALVES[1]) == {"pressure"}
    for listed in (*HALVES, ("gravity", "viscosity", "sinks")):
        if not (compiled and "sinks" in listed):
            assert scopes(traced(listed, compiled)) == owners(listed)


# Results

RESULTS = """
    import gc, hashlib, json, sys
    from pathlib import Path
    from astroinertia.build import assemble
    from astroinertia.effects import catalogue
    from astroinertia.models.sph.step import step
    from astroinertia.scene import load
    if sys.argv[1] == "among others":
        from astroinertia.gravity import multipole, tree
        others = catalogue.build("gravity"), catalogue.build("viscosity")
    start = assemble.prepare(load.load_file("sims/free_expansion.toml", ["body.particles=200"])).evolution
    state = start.state
    for _ in range(5):
        state = step(start.problem, start.arrangement, state, state.rates.timestep)
    bits = hashlib.sha256()
    for array in (state.position, state.velocity, state.entropy, state.smoothing_length, state.time):
        bits.update(array.tobytes())
    kernels = {Path(module.__file__).stem for name, module in list(sys.modules.items()) if "_pass_" in name}
    made = set(map(type, gc.get_objects()))
    print(json.dumps({
        "bits": bits.hexdigest(),
        "made": [kind for kind, entry in catalogue.CATALOGUE.items() if entry.made in made],
        "gravity": [name for name in sys.modules if name.startswith("astroinertia.gravity.")],
        "passes": sorted(kernels),
        "zeta": state.rates.fluid.zeta is not None,
        "sums": sorted(state.rates.fluid.sums),
    }))
"""


def test_free_expansion_builds_no_gravity_and_does_not_depend_on_what_else_is_there() -> None:
    alone, among_others = (in_a_fresh_process(RESULTS, which) for which in ("alone", "among others"))
    assert alone["made"] == ["pressure"]
    assert set(alone["gravity"]) == ALWAYS
    assert among_others["made"] == ["gravity", "pressure", "viscosity"]
    assert set(among_others["gravity"]) > ALWAYS
    assert alone["sums"] == among_others["sums"] == ["pressure"]
    assert alone["zeta"] is False
    assert any("neighbour_pass_pressure" in name for name in alone["passes"])
    assert not any("gravity" in name or "all_pairs" in name or "softening" in name for name in alone["passes"])
    assert alone["bits"] == among_others["bits"]
