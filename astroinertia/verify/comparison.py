"""Cross-checks carried out: each section computes its quantities now, and every one is held to its reference."""

import importlib
import json
import math
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

from astroinertia.process.children import started
from astroinertia.verify.references import Reference, references

Pair = tuple[float, float]  # the quantity here, and as another program computed it beside
Quantities = Mapping[str, float | Pair]
Computation = Callable[[], Quantities]

SECTIONS: dict[str, str] = {
    "constants": "Constants and units, against astropy and CODATA",
    "polytropes": "Polytropes: structure, Love numbers, modes",
    "ellipsoids": "Homogeneous ellipsoids: Maclaurin, Jacobi, Roche",
    "figures": "Rotating figures of compressible bodies",
    "interiors": "Interiors and moment ratios of the Earth and the planets",
    "neutron_stars": "Neutron stars in general relativity",
    "ellipsoid_motion": "Ellipsoids that move: instability, Riemann's figures, collapse",
    "tops": "Free and heavy tops: closed forms, and an integrator against them",
    "rebound": "Gravity, orbits and spins, against REBOUND",
    "precession": "Precession, wobble and spin states of planets, moons and pulsars",
    "turning_planets": "The Earth and Mars integrated under Sun, Moon and planets",
    "pulsars": "Pulsars, accretion and collapse",
    "exact_motions": "Exact motions of ellipsoids, from scene to record",
    "particles": "A short run of particles: what its ledger says",
}
"""Sections by the name of their module, with a title; `python -m astroinertia verify --only NAME` runs one."""

BESIDE = ("exact_motions", "particles")
"""The sections that together take as long as all others, and share no programs with them."""


class Verdict(StrEnum):
    """How a cross-check ended."""

    AGREES = "agrees"
    DIFFERS = "differs"
    FAILED = "not computed"


@dataclass(frozen=True)
class Comparison:
    """One quantity beside its reference; difference as the reference's measure says; `problem` says why it failed."""

    reference: Reference
    here: float
    there: float
    difference: float
    verdict: Verdict
    problem: str = ""

    def plain(self) -> dict[str, Any]:
        """All of it as numbers and texts that JSON can hold; what was not computed is None."""
        content = asdict(self.reference)
        content["reference"] = content.pop("value")
        numbers = {"here": self.here, "reference": self.there, "difference": self.difference}
        content |= {name: value if math.isfinite(value) else None for name, value in numbers.items()}
        return content | {"verdict": str(self.verdict), "problem": self.problem}


@dataclass(frozen=True)
class Section:
    """The comparisons of one section, and the seconds that they took."""

    name: str
    title: str
    comparisons: tuple[Comparison, ...]
    seconds: float

    @property
    def holds(self) -> bool:
        """Whether every verdict is good."""
        return all(comparison.verdict is Verdict.AGREES for comparison in self.comparisons)


def compare_sections(names: Sequence[str], begin: Callable[[str], None]) -> Iterator[Section]:
    """The sections in this order, each as soon as it is there; those of BESIDE last, by a second process meanwhile.

    begin: hears the title of each before it is computed, or waited for.
    """
    beside = [name for name in names if name in BESIDE]
    here = [name for name in names if name not in BESIDE]
    if not beside or not here:
        here, beside = list(names), []
    only = [word for name in beside for word in ("--only", name)]
    command = [sys.executable, "-m", "astroinertia", "verify", *only, "--json"]
    with started(command) if beside else nullcontext() as process:
        for name in here:
            begin(SECTIONS[name])
            yield compare_section(name)
        if process is not None:
            begin(" and ".join(SECTIONS[name] for name in beside))
            yield from _sections_of(beside, process)


def _sections_of(names: Sequence[str], process: "subprocess.Popen[str]") -> Iterator[Section]:
    """Sections as the process that computes them says."""
    output, errors = process.communicate()
    rows, seconds, problem = {}, {}, ""
    try:
        content = json.loads(output)
        rows, seconds = {row["key"]: row for row in content["comparisons"]}, content["sections"]
    except ValueError:
        problem = (errors.strip().splitlines() or [f"its process ended with {process.returncode}"])[-1]
    for name in names:
        compared = tuple(_compared(reference, rows.get(reference.key, {}), problem) for reference in references()[name])
        yield Section(name, SECTIONS[name], compared, seconds.get(name, 0.0))


def _compared(reference: Reference, row: Mapping[str, Any], problem: str) -> Comparison:
    here, there = row.get("here"), row.get("reference")
    computed = None if here is None else (here, math.nan if there is None else there)
    return compare(reference, computed, row.get("problem", problem))


def compare_section(name: str) -> Section:
    """Compute a section's quantities and compare each with its reference; KeyError for a section there is not.

    A computation that fails does not stop the others: its quantities get the verdict "not computed" and its words.
    """
    title, started = SECTIONS[name], time.monotonic()
    values: dict[str, float | Pair] = {}
    problems: list[str] = []
    try:
        computations: tuple[Computation, ...] = importlib.import_module(f"astroinertia.verify.{name}").COMPUTATIONS
    except ImportError as error:
        computations, problems = (), [str(error)]
    for computation in computations:
        try:
            values |= computation()
        except Exception as error:  # whatever is broken is what this is here to tell
            problems.append(f"{type(error).__name__}: {error}")
    compared = tuple(compare(row, values.get(row.key), "; ".join(problems)) for row in references()[name])
    return Section(name, title, compared, time.monotonic() - started)


def compare(reference: Reference, computed: float | Pair | None, problem: str = "") -> Comparison:
    """One quantity, or the pair of it and what another program found, held to the reference."""
    if computed is None:
        words = problem or "nothing computes it"
        return Comparison(reference, math.nan, reference.value, math.nan, Verdict.FAILED, words)
    here, there = computed if isinstance(computed, tuple) else (computed, reference.value)
    here, there = float(here), float(there)
    difference = here - there
    if reference.measure == "relative":
        difference = difference / there if there else math.nan
    elif reference.measure == "below":
        difference = here
    good = abs(difference) <= reference.tolerance  # false for NaN
    return Comparison(reference, here, there, difference, Verdict.AGREES if good else Verdict.DIFFERS)
