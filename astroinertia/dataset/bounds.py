"""Whether a run's ledger closes, in sentences that name the figure.

Measured: over the scenes of sims/ the closure stays below 1e-12 and over the hard cases below 1e-8; the mismatch of
virial tensors is round-off, and up to 1e-4 for gravity by multipoles; the energy is kept to 6e-3 of the largest energy.
Forces that cancel to nothing are round-off themselves, as shear viscosity is in a body that turns rigidly: of float32
pairs it is 1e-2 of their sizes, at a virial tensor of 1e-10 of gravity's.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from astroinertia.dataset.sizes import largest_size

CLOSURE = 1e-6  # of the largest inertia tensor
MISMATCH = 1e-3  # of the sum of m |x| |a|
NOTHING = 1e-6  # of the largest virial tensor of an output: an effect that does less is not judged
ENERGY = 0.05  # of the largest energy
ALL = 0.1  # of what is missing, by which what one effect has done may differ from it
FAR = 1e6  # sizes of a body, a distance from the origin at which squares are rounded to 1e-4 of the body's
SHORTER = "take shorter time steps, or a smaller tolerance where [numerics] has one"
ENERGIES = ("kinetic_energy", "internal_energy", "gravitational_energy", "potential_energy")


def ledger_warnings(series: Mapping[str, np.ndarray], effects: Sequence[str]) -> list[str]:
    """Sentences about records in any units: what passes its bound, and by how much; none where all is well."""
    warnings = []
    closure = largest_size(series.get("ledger_closure"))
    if closure > CLOSURE:
        warnings.append(
            f"the ledger does not close: the inertia tensor that it evolves is off by {closure:.2g} of the largest one "
            f"(at most {CLOSURE:g} is round-off); {_remedy(series)}."
        )
    mismatches = np.atleast_2d(np.asarray(series.get("virial_mismatch", np.nan), dtype=float))
    if mismatches.shape[-1] == len(effects):
        mismatches = np.where(_does_nothing(series.get("virial_tensor"), mismatches.shape), np.nan, mismatches)
        for effect, column in zip(effects, mismatches.T, strict=True):
            if (mismatch := largest_size(column)) > MISMATCH:
                warnings.append(
                    f"the virial tensor of {effect} is off by {mismatch:.2g} from the sum over its forces (at most "
                    f"{MISMATCH:g} is round-off): do not trust what this effect is said to do."
                )
    scale = max((largest_size(series.get(name)) for name in ENERGIES), default=0.0)
    error = largest_size(series.get("integration_energy_error"))
    if error > ENERGY * scale > 0.0:
        warnings.append(
            f"integration lost or made {error / scale:.2g} of the largest energy (at most {ENERGY:g} is usual): "
            f"{_owner(series, effects) or SHORTER}."
        )
    return warnings


def _owner(series: Mapping[str, np.ndarray], effects: Sequence[str]) -> str:
    """Whose energy is not that of its work, where one effect's is all that is missing; empty where that is not so."""
    error = np.asarray(series["integration_energy_error"], dtype=float)
    done = [np.asarray(series.get(name, np.nan), dtype=float) for name in ("work", "heating")]
    if any(each.shape != (*error.shape, len(effects)) for each in done):
        return ""
    worst = int(np.nanargmax(abs(error)))
    missing = abs(done[0][worst] + done[1][worst] - error[worst]) < ALL * abs(error[worst])
    if missing.sum() != 1:
        return ""
    return (
        f"that is what {effects[int(np.argmax(missing))]} has done, with no energy that makes up for it; an effect of "
        "your own needs its potential_energy, or external = True if it works from outside"
    )


def _remedy(series: Mapping[str, np.ndarray]) -> str:
    """What helps a ledger to close."""
    with np.errstate(all="ignore"):
        square = np.trace(np.asarray(series.get("second_moment", np.nan * np.eye(3)[None])), axis1=-2, axis2=-1)
        size = np.sqrt(square / np.asarray(series.get("mass", np.nan)))
        away = largest_size(np.linalg.norm(series.get("centre_of_mass", np.zeros((1, 3))), axis=-1) / size.flat[0])
    if away > FAR:
        return (
            f"the body is {away:.2g} of its sizes from the origin, where its shape is rounded away: begin nearer to "
            "the origin, or move with it"
        )
    return SHORTER


def message(attributes: Mapping[Any, Any], of: str) -> str:
    """The warnings that a dataset's attributes keep of its "ledger" or "resolution", a line each; empty without any."""
    kept = str(attributes.get(f"{of}_warnings", ""))
    return "\n".join(f"warning: {sentence}" for sentence in kept.splitlines())


def doubtful(closure: float, energy_error: float) -> str:
    """What passes its bound while a run goes, in a few words; NaN is what a model does not have."""
    passed = (("ledger", closure, CLOSURE), ("energy", energy_error, ENERGY))
    names = [name for name, figure, bound in passed if figure > bound]
    return f"{' and '.join(names)} NOT CLOSED" if names else ""


def _does_nothing(tensors: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Of each output and effect, whether its virial tensor is as good as zero beside the largest one.

    One that is nothing but zeros is not of forces that cancel, but of none, or wrong.
    """
    if tensors is None or np.shape(tensors) != (*shape, 3, 3):
        return np.zeros(shape, bool)
    sizes = np.abs(np.asarray(tensors, dtype=float)).max(axis=(-1, -2))
    return (sizes > 0.0) & (sizes < NOTHING * np.fmax.reduce(sizes, axis=-1, initial=0.0)[..., None])
