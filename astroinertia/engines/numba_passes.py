"""What a generated module of the numba engine begins with, and what its loops must have at hand.

What a term asks for by name is all that is loaded.
"""

import inspect
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from astroinertia.engines import numba_vectors
from astroinertia.engines.numba_cache import load_module, taken_from
from astroinertia.engines.templates import template
from astroinertia.engines.terms import KERNEL_NAMES, SEPARATION, PairTerm, argument_names, side_of

AXES = "xyz"
INTERVALS = ("closing", "opening")
VIRIAL_AXES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def effect_names(terms: Iterable[PairTerm]) -> list[str]:
    """The effects of the terms, each once, in alphabetical order."""
    return sorted({term.effect for term in terms})


def output_kinds(terms: Sequence[PairTerm], impulses: bool = False) -> dict[tuple[str, str], str]:
    """{(effect, output): how} of all results; terms of one effect may add to the same output.

    "symmetric" is an outer product of separations with themselves.
    impulses: with a second result for each that can be multiplied by a time.
    """
    kinds: dict[tuple[str, str], str] = {}
    for term in terms:
        for output in term.outputs:
            earlier = kinds.get((term.effect, output.name))
            if earlier not in (None, output.how) or earlier == "max":
                raise ValueError(f"output {output.name} of effect {term.effect} comes twice and cannot be added up")
            kinds[term.effect, output.name] = output.how
    asymmetric = {(t.effect, o.name) for t in terms for o in t.outputs if o.of != "position"}
    kinds = {k: "symmetric" if how == "outer" and k not in asymmetric else how for k, how in kinds.items()}
    if impulses:
        kinds |= {(e, f"{name}_impulse"): how for (e, name), how in kinds.items() if how in ("central", "sum")}
    return kinds


def virial_effects(terms: Sequence[PairTerm]) -> list[str]:
    """The effects with a central output, which have a virial tensor."""
    return sorted({effect for (effect, _), how in output_kinds(terms).items() if how == "central"})


@dataclass
class Needs:
    """What the loop over pairs must have at hand, by the names of the pair functions' arguments."""

    kernel: Any
    terms: Sequence[PairTerm]
    functions: Sequence
    masked: bool
    impulses: bool = False
    kernels: dict[str, list[str]] = field(default_factory=lambda: {"i": [], "j": []})
    scalars: list[str] = field(default_factory=list)
    vectors: list[str] = field(default_factory=list)
    lengths: bool = False
    approach: bool = False

    def __post_init__(self) -> None:
        for name in sorted({n for f in self.functions for n in argument_names(f)}):
            if name in ("r", *SEPARATION):
                continue
            if name == "v_r":
                self.approach = True
                continue
            stem, side = side_of(name)
            if stem in KERNEL_NAMES:
                self.kernels[side].append(stem)
            elif stem == "h":
                self.lengths = True
            elif stem not in self.scalars:
                self.scalars.append(stem)
        self.scalars += INTERVALS if self.impulses else ()
        of = {output.of for term in self.terms for output in term.outputs if output.how == "outer"}
        if None in of:
            raise ValueError("an output gathered as 'outer' must say of which field")
        self.vectors = sorted({str(name) for name in of - {"position"}} | ({"velocity"} if self.approach else set()))

    @cached_property
    def rows(self) -> list[str]:
        """Rows of the source buffer of a sum over all pairs."""
        rows = [*AXES, "mass"]
        rows += ["reach2"] if self.masked else []
        rows += ["inverse_h"] if self.kernels["i"] or self.kernels["j"] else []
        rows += ["h"] if self.lengths else []
        rows += [f"vector_{name}_{axis}" for name in self.vectors for axis in AXES]
        return rows + [f"field_{name}" for name in self.scalars]

    @cached_property
    def sides(self) -> tuple[list[str], list[str]]:
        """Rows of a table of sources, x, y, z first: those that partners are asked for, and the target's alone."""
        arguments = {name for function in self.functions for name in argument_names(function)}
        arguments |= {f"{name}_j" for name in INTERVALS}
        partners = [*AXES, "mass", *(f"vector_{name}_{axis}" for name in self.vectors for axis in AXES)]
        partners += ["inverse_h"] if self.kernels["j"] else []
        partners += ["h"] if "h_j" in arguments else []
        partners += [f"field_{name}" for name in self.scalars if f"{name}_j" in arguments]
        return partners, [row for row in self.rows if row not in partners]

    @cached_property
    def table(self) -> list[str]:
        """Columns of a table of sources: all rows of `sides`."""
        return [row for side in self.sides for row in side]

    @cached_property
    def width(self) -> int:
        """Columns that a table has room for: whole vectors of four."""
        return -(-len(self.table) // 4) * 4

    @cached_property
    def spread(self) -> int:
        """Rows that what partners are asked for is spread to: whole vectors of four."""
        return -(-len(self.sides[0]) // 4) * 4

    @cached_property
    def reaches(self) -> int:
        """The column that begins the four of which one is the squared reach."""
        return self.table.index("reach2") // 4 * 4

    @cached_property
    def results(self) -> dict[tuple[str, str], str]:
        """How each result is gathered: output_kinds."""
        return output_kinds(self.terms, self.impulses)

    @cached_property
    def fields(self) -> list[tuple[str, bool]]:
        """The fields of particles that `arrays` are, and whether each is of vectors."""
        return [(name, True) for name in self.vectors] + [(name, False) for name in self.scalars]

    @cached_property
    def arrays(self) -> list[str]:
        """Per-particle arrays that the pass is given besides position, mass and smoothing_length."""
        return [f"vector_{name}" for name in self.vectors] + [f"field_{name}" for name in self.scalars]


def header(precision: str) -> list[str]:
    """The opening of a generated module, which takes the shared parts of that precision from one that they have.

    Numba takes as long for what is shared as for a pass: it is compiled once a process.
    """
    vectors = re.sub(
        r"COMPACTED_BITS = .*", f"COMPACTED_BITS = {numba_vectors.COMPACTED_BITS}", inspect.getsource(numba_vectors)
    )
    shared = [template(f"engines/numba_{part}.py") for part in ("tables", "parts", precision)]
    return [taken_from(load_module(f"parts_{precision}", "\n".join([vectors, *shared]))), "", ""]


def loader(name: str, needs: Needs, precision: str, arrays: Sequence[str]) -> list[str]:
    """A function that copies sources into the rows of a buffer, in mixed precision relative to a centre.

    Vectors are then relative to those of the particle `origin`. arrays: what it is given, not less than is needed.
    """
    lines = [
        "@njit(**PART)",
        f"def {name}(indices, count, centre, origin, buffer, x, y, z, mass, h, support{listed(arrays)}):",
    ]
    mixed = precision == "mixed"
    for k, row in enumerate(needs.rows):
        stem, _, axis = row.rpartition("_")
        if row in AXES:
            call = f"load_row({row}, indices, count, {f'centre[{k}]' if mixed else '0.0'}"
        elif row.startswith("vector_"):
            a = AXES.index(axis)
            call = f"load_component({stem}, {a}, indices, count, {f'{stem}[origin, {a}]' if mixed else '0.0'}"
        else:
            call = {
                "reach2": "load_square(h, indices, count, support",
                "inverse_h": "load_inverse(h, indices, count",
            }.get(row, f"load_row({row}, indices, count, 0.0")
        lines.append(f"    {call}, buffer[{k}])")
    lines += [
        "    mass_row = buffer[3]",
        "    for k in range(count, padded(count) + LANES):",
        "        mass_row[k] = 0",
    ]
    return [*lines, "", ""]


def packer(needs: Needs) -> list[str]:
    """Functions that put all that is asked of a particle side by side: `pack` for all of them, `pack_row` for one."""
    parameters = f"position, h, mass, support{listed(needs.arrays)}, table"
    lines = ["@njit(forceinline=True, **PART)", f"def pack_row(i, k, {parameters}):"]
    for column, row in enumerate(needs.table):
        stem, _, axis = row.rpartition("_")
        value = {
            "inverse_h": "1.0 / h[i]",
            "reach2": "(support * h[i]) * (support * h[i])",
            **{a: f"position[i, {n}]" for n, a in enumerate(AXES)},
        }.get(row, f"{stem}[i, {AXES.index(axis)}]" if row.startswith("vector_") else f"{row}[i]")
        lines.append(f"    table[k, {column}] = {value}")
    lines += [f"    table[k, {column}] = 0.0" for column in range(len(needs.table), needs.width)]
    lines += [
        "",
        "",
        "@njit(**ENTRY)",
        f"def pack(counter, {parameters}):",
        "    while True:",
        "        first = PACKED * take(counter)",
        "        if first >= len(mass):",
        "            break",
        "        for i in range(first, min(len(mass), first + PACKED)):",
        f"            pack_row(i, i, {parameters})",
    ]
    return [*lines, "", ""]


def origin(name: str, needs: Needs, precision: str) -> list[str]:
    """A function that sets what a leaf's table is relative to: in mixed precision its middle and its vectors."""
    lines = ["@njit(**PART)", f"def {name}(centre, table, i, zero):"]
    if precision == "mixed":
        lines += [f"    zero[{k}] = centre[{k}]" for k in range(3)]
        vectors = (k for k, row in enumerate(needs.sides[0]) if row.startswith("vector_"))
        lines += [f"    zero[{k}] = table[i, {k}]" for k in vectors]
    return [*lines, "    return", "", ""]


def listed(names: Iterable[str]) -> str:
    """Further arguments."""
    return "".join(f", {name}" for name in names)


def results(terms: Sequence[PairTerm], virial: bool, impulses: bool = False) -> list[str]:
    """The arrays that a pass fills."""
    names = [f"out_{effect}_{output}" for effect, output in output_kinds(terms, impulses)]
    return names + ([f"virial_{effect}" for effect in virial_effects(terms)] if virial else [])
