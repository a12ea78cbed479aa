"""Proof of absence: what the program of a scene holds of each effect, called for or not, and what each one costs.

Everything is looked up in what was really made, traced and generated, by an interpreter of its own that has done
nothing else: the text of a scene is all that it is given. Tests: tests/unit/audit/test_operations.py,
tests/physics/test_audit.py.
"""

import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from astroinertia.audit.operations import COMMON
from astroinertia.errors import AstroinertiaError
from astroinertia.process.children import completed, imports_as_here
from astroinertia.scene.schema import Scene

STEPS = 8  # of which the median is taken for a cost


@dataclass(frozen=True)
class Share:
    """What is there of one effect: operations of a step as traced (xla) and as generated (numba), arrays of the state,
    and objects of its class in the memory of the program.

    seconds: of a step, that leaving it out saves; None where that was not measured.
    """

    kind: str
    listed: bool
    traced: int
    compiled: int
    arrays: int
    objects: int
    seconds: float | None = None

    @property
    def present(self) -> bool:
        """Whether anything of it is there."""
        return bool(self.traced or self.compiled or self.arrays or self.objects)


@dataclass(frozen=True)
class Audit:
    """All effects that the scene's model knows; what belongs to none; and a digest of the traced program.

    generated: names of the numba engine's modules, with the digests of their texts. seconds: of a step.
    """

    shares: tuple[Share, ...]
    common_traced: int
    common_compiled: int
    program: str
    generated: tuple[str, ...]
    seconds: float | None = None

    @property
    def holds(self) -> bool:
        """Whether nothing is there of any effect that the scene does not call for."""
        return not any(share.present for share in self.shares if not share.listed)


class AuditFailed(AstroinertiaError):
    """The scene could not be run for a step."""


def audited(scene: Scene) -> Audit:
    """The audit of a scene, without costs; raises AuditFailed with the reason where it cannot be run for a step."""
    counts = _asked(scene, None, 0)
    shares = tuple(
        Share(
            kind,
            kind in scene.effects,
            counts["traced"].get(kind, 0),
            counts["compiled"].get(kind, 0),
            counts["arrays"].get(kind, 0),
            counts["objects"][kind],
        )
        for kind, entry in scene.entries.items()
        if kind in scene.effects or scene.model in entry.models
    )
    common = counts["traced"].get(COMMON, 0), counts["compiled"].get(COMMON, 0)
    return Audit(shares, *common, counts["program"], tuple(counts["generated"]))


def with_costs(audit: Audit, scene: Scene, tell: Callable[[str], None]) -> Audit:
    """The audit of a scene of particles with what a step takes, and what it takes less without each effect.

    Effects that others are there for, such as the pressure that viscosity goes with, are left out together with them:
    their cost is given without that of the others. tell: hears what is being timed.
    """
    if scene.model != "sph":
        return audit
    tell("the whole step")
    whole = _asked(scene, None, STEPS)["seconds"]
    spent: dict[str, float | None] = {}
    for share in audit.shares:
        if share.listed and not any(share.kind in scene.entries[other].needs for other in scene.effects):
            tell(f"without {share.kind}")
            spent[share.kind] = whole - _asked(scene, share.kind, STEPS)["seconds"]
    shares = tuple(replace(share, seconds=spent.get(share.kind)) for share in audit.shares)
    return replace(audit, shares=shares, seconds=whole)


def _asked(scene: Scene, leave_out: str | None, steps: int) -> Mapping[str, Any]:
    if scene.own_classes:
        kinds = ", ".join(made.kind for made in scene.own_classes)
        raise AuditFailed(f"an audit knows what is built in or installed, not what is given from Python: {kinds}.")
    question = {
        "scene": scene.source,
        "overrides": list(scene.overrides),
        "origin": scene.origin,
        "leave_out": leave_out,
        "steps": steps,
    }
    run = completed(
        [sys.executable, "-P", "-m", "astroinertia.audit.child"],  # -P: not what lies in the working folder
        json.dumps(question),
        env=imports_as_here(),
    )
    if run.returncode:
        complaints = run.stderr.strip().splitlines()
        raise AuditFailed(
            f"the scene could not be run for a step: {complaints[-1] if complaints else 'no reason was given'}"
        )
    return json.loads(run.stdout.splitlines()[-1])
