"""What every scene conserves and accounts for, step by step, whatever it lists."""

from functools import cache
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

from astroinertia.build.assemble import prepare
from astroinertia.models.sph.evaluate import effect_accelerations, potential_energies, virial_tensors
from astroinertia.models.sph.record import energy_budget, series_record, works_from_outside
from astroinertia.models.sph.sorting import rearranged, stale
from astroinertia.models.sph.state import State
from astroinertia.models.sph.step import step
from astroinertia.scene import load
from astroinertia.scene.scales import code_units
from tests import checks_of_effects as checks
from tests.evolve import prepared
from tests.potentials import slopes
from tests.sims import single_scenes

SIMS = sorted(path for path in single_scenes() if load.load_file(path).model == "sph")
STEPS = 100  # the full test takes 1200, in both engines
# Few scenes that have every effect between them; the full test has all.
FEW = (
    "collapse_to_sink", "contracting_star", "deleptonising_core", "jacobi_by_viscosity", "made_to_order",
    "neutron_star", "pulsar_collapse", "roche_limit", "sod", "star_and_companion", "tidal_disruption",
)  # fmt: skip


def run_steps(path: Path, steps: int, particles: int, engine: str) -> dict[str, Any]:
    """Evolve a scene for so many steps, or to its end; its ledger's figures, and the largest values on the way."""
    bodies = [f"bodies.{number}" for number in range(len(load.load_file(path).bodies))] or ["body"]
    settings = [f"{body}.particles={particles // len(bodies)}" for body in bodies]
    settings += [f"numerics.engine={engine}", "numerics.precision=float64", "numerics.timesteps=global"]
    scene = load.load_file(path, settings)
    end, start = code_units(scene).to_code(scene.time.end, "time"), prepare(scene).evolution
    problem, state, arrangement = start.problem, start.state, start.arrangement
    first = series_record(problem, arrangement, state, None)
    largest_momentum, largest_spin = 0.0, 0.0
    mismatch, failing = first["virial_mismatch"], own_checks(problem, arrangement, state)
    record = first
    for number in range(1, steps + 1):
        if number % 16 == 1 or stale(problem, arrangement, state):
            state, arrangement = rearranged(problem, state)
        state = step(problem, arrangement, state, state.rates.timestep)
        speed = np.linalg.norm(np.asarray(state.velocity), axis=1)
        largest_momentum = max(largest_momentum, float(np.asarray(state.mass) @ speed))
        reach = np.linalg.norm(np.asarray(state.position), axis=1)
        largest_spin = max(largest_spin, float(np.asarray(state.mass) @ (reach * speed)))
        ended = float(state.time) >= end
        if ended or number % (steps // 5) == 0:
            record = series_record(problem, arrangement, state, first["potential_energy"])
            mismatch = np.maximum(mismatch, record["virial_mismatch"])
            failing |= own_checks(problem, arrangement, state)
        if ended:
            break
    names = list(problem.effect_names)
    outside = [effect.kind for effect in problem.effects if effect.external]
    unseen = works_from_outside(problem, potential_energies(problem, state))
    energy = abs(first["total_energy"])
    lost = (record["work"] + record["heating"])[unseen].sum()
    before, now = (each["kinetic_energy"] + np.nan_to_num(each["internal_energy"]) for each in (first, record))
    before, now = before + first["potential_energy"], now + record["potential_energy"]
    accounted = now - before - lost - record["integration_energy_error"]
    # A body that hardly turns has only round-off to keep: its scale is then the sum of |x||v|.
    spin = max(np.linalg.norm(first["angular_momentum"]), 1e-3 * largest_spin)
    inertia = np.linalg.norm(record["inertia_tensor_evolved"] - record["inertia_tensor"])
    return {
        "effects": names,
        "steps": number,
        "closure": record["ledger_closure"],
        "closure_now": inertia / np.linalg.norm(record["inertia_tensor"]),
        "energy_account": abs(accounted) / max(energy, record["kinetic_energy"]),
        "failing": failing,
        "mismatch": dict(zip(names, mismatch, strict=True)),
        "momentum": np.linalg.norm(record["momentum"] - first["momentum"]) / largest_momentum,
        "spin": np.linalg.norm(record["angular_momentum"] - first["angular_momentum"]) / spin,
        "internal": not outside,
        "bounded": problem.engine.bounded,
        # Programs of xla take long to compile: there, test_effect_checks compares potentials with accelerations.
        "slopes": slopes_of_potentials(problem, state) if engine == "numba_cpu" else {},
        "viscous": "viscosity" in names,
    }


def slopes_of_potentials(problem: Any, state: Any) -> dict[str, float]:
    """Of all effects whose work is that of a potential, which that of pressure by gradients from a matrix is not."""
    without = {effect.kind for effect in problem.effects if effect.needs_heat}
    return {kind: slope for kind, slope in slopes(problem, state).items() if kind not in without}


def own_checks(problem: Any, arrangement: Any, state: Any) -> dict[str, Any]:
    """Which of each effect's own checks fail: its virial tensor by two routes, the symmetries of internal forces."""
    xp, fluid, rates = problem.engine.xp, state.rates.fluid, state.rates
    accelerations, virials = (
        effect_accelerations(xp, rates),
        virial_tensors(problem, arrangement, fluid),
    )
    found = checks.failing(
        checks.effect_checks(
            problem.effects, fluid.mass, fluid.position, fluid.velocity, accelerations, virials, rates.heating
        )
    )
    if problem.engine.bounded:
        return found
    # Through the faces of a box pairs turn each other, and have no virial tensor.
    left = {kind: tuple(name for name in names if name not in ("virial", "torque")) for kind, names in found.items()}
    return {kind: names for kind, names in left.items() if names}


def check(figures: dict[str, Any]) -> None:
    assert figures["failing"] == {}, figures
    assert figures["closure"] <= 1e-12, figures
    assert figures["closure_now"] <= 1e-11, figures
    assert figures["energy_account"] <= 1e-11, figures
    # Differences over 1e-4 h leave 1e-7 (falling as their square), for any effect and scene.
    assert max(np.abs(list(figures["slopes"].values())), default=0.0) <= 1e-6, figures
    if figures["internal"]:
        assert figures["momentum"] <= 1e-13, figures
    if figures["bounded"]:
        assert max(figures["mismatch"].values()) <= 1e-11, figures
        assert not figures["internal"] or figures["spin"] <= 1e-11, figures


def test_the_few_scenes_have_every_effect_that_any_scene_lists() -> None:
    listed = {path.stem: set(load.load_file(path).effects) for path in SIMS}
    assert set().union(*(listed[name] for name in FEW)) == set().union(*listed.values())
    assert any(load.load_file(path).box is not None for path in SIMS if path.stem in FEW)


# Those that compile loops over pairs for themselves alone, or are much like another one: test_effect_checks has their
# effects by plain sums, test_box the ledger of sod.
LONGER = (
    "contracting_star", "deleptonising_core", "jacobi_by_viscosity", "made_to_order", "neutron_star",
    "pulsar_collapse", "sod", "tidal_disruption",
)  # fmt: skip


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.full) if name in LONGER else name for name in FEW]
)
def test_the_ledger_of_scenes_with_every_effect_closes(name: str) -> None:
    """Ledger against direct sums, each effect's virial tensor by two routes, energy, momentum and spin."""
    path = next(path for path in SIMS if path.stem == name)
    check(run_steps(path, STEPS, 300, "numba_cpu"))


def engines_of(path: Path) -> tuple[str, ...]:
    """Those that take the scene: xla has neither sinks nor periodic boxes."""
    scene = load.load_file(path)
    return ("numba_cpu",) if "sinks" in scene.effects or scene.box is not None else ("numba_cpu", "xla")


BOTH = [pytest.param(path, engine, id=f"{path.stem}-{engine}") for path in SIMS for engine in engines_of(path)]


@pytest.mark.full
@pytest.mark.parametrize(("path", "engine"), BOTH)
def test_the_ledger_closes_in_both_engines(path: Path, engine: str, result) -> None:
    with jax.enable_x64(True):
        figures = run_steps(path, 1200, 600, engine)
    result(engine=engine, particles=600, **figures)
    check(figures)


SMOOTH = """
name = "smooth"
units = "code"
[body]
kind = "polytrope"
index = 1.0
particles = 200
mass = 1.0
radius = 1.0
relax = false
axes = [1.05, 1.0, 0.95]
[body.rotation]
rate = 0.3
[equation_of_state]
kind = "ideal"
gamma = 2.0
[effects.gravity]
[effects.pressure]
[numerics]
smoothing_tolerance = 1e-12
kernel = "wendland_c4"
[time]
end = 1.0
"""
END = 0.5


@cache
def largest_energy_error(factor: float) -> float:
    """The largest relative energy error on the way to the end with time-step factors scaled by `factor`."""
    start = prepared(SMOOTH, f"numerics.courant={0.4 * factor}", f"numerics.acceleration_factor={0.4 * factor}")
    problem, state, arrangement = start.problem, start.state, start.arrangement
    opening = energy_budget(problem, state)["total"]
    worst = 0.0
    state, arrangement = rearranged(problem, state)
    while float(state.time) < END:
        state: State = step(problem, arrangement, state, state.rates.timestep)
        worst = max(worst, abs(energy_budget(problem, state)["total"] / opening - 1))
    return worst


def test_the_energy_error_falls_with_the_square_of_the_step() -> None:
    errors = [largest_energy_error(2.0**-k) for k in (1, 2, 3)]
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all(np.abs(orders - 2.0) <= 0.1), (errors, orders)


def met(factor: float, every: float) -> tuple[float, int]:
    """The largest relative energy error up to the end, and the steps, where every multiple of `every` is met."""
    body = prepared(SMOOTH, f"numerics.courant={0.4 * factor}", f"numerics.acceleration_factor={0.4 * factor}")
    opening = energy_budget(body.problem, body.state)["total"]
    worst = 0.0
    for target in [*np.arange(every, END - 1e-9, every), END]:
        while body.time < target * (1.0 - 1e-14):
            body.advance(target)
            worst = max(worst, abs(energy_budget(body.problem, body.state)["total"] / opening - 1))
    return worst, body.steps


@pytest.mark.full
@pytest.mark.parametrize("every", [0.031, 0.11])
def test_it_does_so_where_steps_are_shortened_to_meet_times(every: float) -> None:
    """Times that no step divides: the same order in the steps that are taken, and no more error than without."""
    runs = [met(2.0**-k, every) for k in (1, 2, 3)]
    errors, steps = (np.array(column, dtype=float) for column in zip(*runs, strict=True))
    orders = np.log(errors[:-1] / errors[1:]) / np.log(steps[1:] / steps[:-1])
    assert np.all(np.abs(orders - 2.0) <= 0.2), (errors, steps, orders)
    assert errors[-1] <= 1.05 * largest_energy_error(0.125)
