"""The audit of a scene finds what is called for, nothing else, and what was slipped in."""

import ast
import inspect
import shutil
from functools import cache
from pathlib import Path

import pytest

from astroinertia.audit import absence
from astroinertia.build.effects import effects_of
from astroinertia.effects.catalogue import CATALOGUE
from astroinertia.engines.numba_modules import neighbour_pass
from astroinertia.engines.terms import Output, PairTerm
from astroinertia.scene import load
from astroinertia.scene.plan import code_units

ROOT = Path(__file__).parent.parent.parent
SCENES = {
    "evrard": ["body.particles=200", "numerics.precision=float64"],
    "free_expansion": ["body.particles=200"],
    "riemann_ellipsoid": [],
    "crab_pulsar": [],
    "earth_precession": [],
}


def scene_of(name: str) -> load.schema.Scene:
    return load.load_file(ROOT / "sims" / f"{name}.toml", SCENES[name])


@cache
def audit_of(name: str) -> absence.Audit:
    """The audit of one of SCENES as it stands: each takes an interpreter of its own, that traces and compiles."""
    return absence.audited(scene_of(name))


FULL = ("free_expansion", "riemann_ellipsoid", "earth_precession", "crab_pulsar")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.full) if name in FULL else name for name in SCENES]
)
def test_effects_are_there_where_they_are_called_for_and_nowhere_else(name: str) -> None:
    scene, found = scene_of(name), audit_of(name)
    assert found.holds
    shares = {share.kind: share for share in found.shares}
    assert {kind for kind, share in shares.items() if share.listed} == set(scene.effects)
    assert set(shares) == {kind for kind, entry in CATALOGUE.items() if scene.model in entry.models} | set(
        scene.effects
    )
    for kind in scene.effects:
        in_closed_form = scene.model == "scaling" and kind in ("gravity", "pressure")
        assert (shares[kind].objects > 0) == (scene.model in CATALOGUE[kind].models and not in_closed_form), kind
        if scene.model == "sph":
            assert shares[kind].traced > 0 and shares[kind].arrays > 0, kind


def nothing(xp, r):
    return (r,)


def operations_of_pass(*terms: PairTerm) -> int:
    text = inspect.getsource(neighbour_pass("wendland_c2", terms, "mixed", False).module)
    kinds = ast.BinOp | ast.UnaryOp | ast.Compare | ast.BoolOp | ast.Call
    return sum(isinstance(node, kinds) for node in ast.walk(ast.parse(text)))


@pytest.mark.parametrize("name", ["evrard", "jacobi_by_viscosity", "keplerian_disc"])
def test_a_pass_with_all_effects_has_no_more_operations_than_its_parts(name: str) -> None:
    """What all share (the walk, separations, the kernel's slope) counts once: the whole is less than base and parts.

    The base is a pass whose one term computes nothing; the text is generated and counted, nothing is compiled.
    """
    scene = load.load_file(ROOT / "sims" / f"{name}.toml")
    terms = [effect.neighbour_terms for effect in effects_of(scene, code_units(scene)) if effect.neighbour_terms]
    base = operations_of_pass(PairTerm("nothing", nothing, (Output("acceleration", "central"),)))
    parts = [operations_of_pass(*own) - base for own in terms]
    whole = operations_of_pass(*(term for own in terms for term in own))
    assert len(terms) == 3 and min(parts) > 0
    assert whole < base + sum(parts)


NEW = '''
"""An effect that somebody adds."""

from dataclasses import dataclass
from typing import ClassVar

from astroinertia.effects.effect import Effect
from astroinertia.effects.entries import Entry
from astroinertia.engines.pytree import pytree


@pytree
@dataclass(frozen=True, eq=False)
class Newcomer(Effect):
    """A push of every particle."""

    kind: ClassVar[str] = "newcomer"
    external: ClassVar[bool] = True

    def acceleration(self, xp, fluid):
        return 0.0 * fluid.position + 1e-3


ENTRY = Entry("a push", {}, "particles", "", made=Newcomer)
'''


@pytest.mark.full
def test_a_new_effect_changes_no_operation_of_scenes_that_do_not_list_it(tmp_path: Path, monkeypatch) -> None:
    """A file is added to a copy of the package: programs stay the same, unless they ask for it."""
    copy = tmp_path / "astroinertia"
    shutil.copytree(ROOT / "astroinertia", copy)  # with its bytecode, which stays valid
    shutil.copytree(ROOT / "data", tmp_path / "data", ignore=shutil.ignore_patterns("pictures"))
    (copy / "effects" / "kinds" / "newcomer.py").write_text(NEW)
    scene = scene_of("free_expansion")
    before = audit_of("free_expansion")
    monkeypatch.setattr(absence.sys, "path", [str(tmp_path), *absence.sys.path])
    after = absence.audited(scene)
    assert (after.program, after.generated) == (before.program, before.generated)
    asking = scene.model_copy(update={"source": f"{scene.source}\n[effects.newcomer]\n"})
    answer = absence._asked(asking, None, 0)
    assert answer["traced"]["newcomer"] > 0 and answer["objects"]["newcomer"] > 0
    assert answer["program"] != before.program
