"""The text of the fused loops of the numba engine: one module for a pass and just the terms that it carries.

In every loop the target particle is i and the source j. What a term asks for by name is all that is computed. Names of
functions hold the names of the effects, so that an effect which is not listed leaves no trace in what is compiled.
"""

import inspect
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from astroinertia.engines import numba_parts
from astroinertia.engines.numba_source import Sources, argument_names
from astroinertia.engines.terms import PairTerm

AXES = "xyz"
SEPARATION = ("x_ij", "y_ij", "z_ij")
GROUP = 8  # neighbouring leaves that walk the tree together
PAIR_NAMES = ("r", "x_ij", "y_ij", "z_ij")  # always at hand
KERNEL_NAMES = {"W": ("w", 3), "dW": ("dw", 4), "phi": ("phi", 1), "dphi": ("dphi", 2)}
VIRIAL_AXES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
LOOP_FLAGS = "{'reassoc', 'contract', 'nsz', 'arcp', 'afn'}"  # never nnan or ninf: NaN must survive


def effect_names(terms: Iterable[PairTerm]) -> list[str]:
    """The effects of the terms, each once, in alphabetical order."""
    return sorted({term.effect for term in terms})


def output_kinds(terms: Iterable[PairTerm]) -> dict[tuple[str, str], str]:
    """{(effect, output): how} of all results; terms of one effect may add to the same output."""
    kinds: dict[tuple[str, str], str] = {}
    for term in terms:
        for output in term.outputs:
            known = kinds.setdefault((term.effect, output.name), output.how)
            if known != output.how:
                raise ValueError(f"output {output.name} of effect {term.effect} is gathered in two ways")
    return kinds


def virial_effects(terms: Iterable[PairTerm]) -> list[str]:
    """The effects with a central output, which have a virial tensor."""
    return sorted({effect for (effect, _), how in output_kinds(terms).items() if how == "central"})


@dataclass
class Needs:
    """What the loop over pairs must have at hand, by the names of the pair functions' arguments."""

    kernel: Any
    terms: Sequence[PairTerm]
    functions: Sequence
    masked: bool
    kernels: dict[str, list[str]] = field(default_factory=lambda: {"i": [], "j": []})
    scalars: list[str] = field(default_factory=list)
    vectors: list[str] = field(default_factory=list)
    lengths: bool = False
    approach: bool = False

    def __post_init__(self) -> None:
        for name in sorted({n for f in self.functions for n in argument_names(f)}):
            stem, _, side = name.rpartition("_")
            if name in ("r", "inverse_r", *SEPARATION):
                continue
            if name == "v_r":
                self.approach = True
            elif side not in ("i", "j") or not stem:
                raise ValueError(f"pair functions cannot ask for {name}: it ends neither in _i nor in _j")
            elif stem in KERNEL_NAMES:
                self.kernels[side].append(stem)
            elif stem == "h":
                self.lengths = True
            elif stem not in self.scalars:
                self.scalars.append(stem)
        of = {output.of for term in self.terms for output in term.outputs if output.how == "outer"}
        if None in of:
            raise ValueError("an output gathered as 'outer' must say of which field")
        self.vectors = sorted({str(name) for name in of} | ({"velocity"} if self.approach else set()))

    @property
    def rows(self) -> list[str]:
        """Rows of the source buffer."""
        rows = [*AXES, "mass"]
        rows += ["reach2"] if self.masked else []
        rows += ["inverse_h"] if self.kernels["i"] or self.kernels["j"] else []
        rows += ["h"] if self.lengths else []
        rows += [f"vector_{name}_{axis}" for name in self.vectors for axis in AXES]
        return rows + [f"field_{name}" for name in self.scalars]

    @property
    def arrays(self) -> list[str]:
        """Per-particle arrays that the pass is given besides position, mass and smoothing_length."""
        return [f"vector_{name}" for name in self.vectors] + [f"field_{name}" for name in self.scalars]


# The reciprocal root keeps clear of 0 without a branch: 1/r is finite there and is multiplied by separations of 0.
ROOTS = {
    "float64": """
@njit(forceinline=True)
def inverse_distance(r2):
    return reciprocal_root(where(r2 > 1e-290, r2, 1e-290))

""",
    "mixed": """
@njit(forceinline=True, error_model="numpy", fastmath={'contract', 'nsz', 'arcp', 'afn'})
def inverse_distance(r2):
    return np.float32(1) / np.sqrt(where(r2 > np.float32(1e-36), r2, np.float32(1e-36)))

""",
}


def header(precision: str) -> list[str]:
    """The opening of a generated module: the shared parts and the pair precision."""
    symmetric = "{'contract', 'nsz', 'arcp', 'afn'}" if precision == "mixed" else "{'contract', 'nsz'}"
    return [
        inspect.getsource(numba_parts),
        "",
        ROOTS[precision],
        f"real = np.{'float32' if precision == 'mixed' else 'float64'}",
        f"PAIR_FLAGS = {symmetric}",
        f"LOOP_FLAGS = {LOOP_FLAGS}",
        f"GROUP = {GROUP}",
        f"RELATIVE = {precision == 'mixed'}",
        "",
        "",
    ]


def loader(name: str, needs: Needs, precision: str) -> list[str]:
    """A function that copies sources into the rows of a buffer, relative to an origin particle in mixed precision."""
    lines = [
        '@njit(**PART)',
        f"def {name}(found, count, origin, buffer, x, y, z, mass, smoothing_length, support{_listed(needs.arrays)}):",
        "    widest_vectors()",
        "    if padded(count) + 2 * LANES > buffer.shape[1]:",
        f"        buffer = np.empty(({len(needs.rows)}, 2 * count + 3 * LANES), real)",
    ]
    mixed = precision == "mixed"
    for k, row in enumerate(needs.rows):
        stem, _, axis = row.rpartition("_")
        before: list[str] = []
        if row in AXES:
            before = [f"    zero = {row}[origin]"] if mixed else []
            value = f"at({row}, found[k])"
        elif row.startswith("vector_"):
            a = AXES.index(axis)
            before = [f"    zero = {stem}[origin, {a}]"] if mixed else []
            value = f"{stem}[found[k], {a}]"
        else:
            value = {
                "reach2": "(support * at(smoothing_length, found[k])) ** 2",
                "inverse_h": "1.0 / at(smoothing_length, found[k])",
                "h": "at(smoothing_length, found[k])",
            }.get(row, f"at({row}, found[k])")
        lines += [*before, f"    row = buffer[{k}]", "    for k in range(count):"]
        lines += [f"        row[k] = real({value}{' - zero' if before else ''})"]
        # A massless copy of the last source stands at the loose end: as finite as the source itself.
        lines += ["    for k in range(count, padded(count) + LANES):"]
        lines += [f"        row[k] = {'real(0)' if row == 'mass' else 'row[count - 1]'}"]
    return [*lines, "    return buffer", "", ""]


def leaf_loop(name: str, sources: Sources, terms, needs: Needs, mode: str, virial: bool) -> list[str]:
    """The loop over the targets of one leaf and the sources in its buffer; mode "neighbour", "near" or "far"."""
    kinds = output_kinds(terms)
    far = mode == "far"
    results = [f"out_{effect}_{output}" for effect, output in kinds]
    results += [f"virial_{effect}" for effect in virial_effects(terms)] if virial else []
    target = "targets" if far else "buffer"
    lines = [
        "@njit(fastmath=LOOP_FLAGS, **PART)",
        f"def {name}(leaf, first, last, slot, count, targets, buffer, key, index{_listed(results)}):",
        "    widest_vectors()",
        "    vectors = padded(count)",
    ]
    lines += [f"    all_{row} = buffer[{k}]" for k, row in enumerate(needs.rows)]
    if virial:
        lines += [f"    total_{e}_{a}{b} = 0.0" for e in virial_effects(terms) for a, b in VIRIAL_AXES]
    lines += ["    for i in range(first, last):", "        s = slot + i - first"]
    used = [row for row in needs.rows if row != "mass" or virial]
    lines += [f"        {row}_i = {target}[{needs.rows.index(row)}, s]" for row in used]
    lines += [f"        {line}" for line in _powers(needs, "i")]
    accumulators = _accumulators(kinds, terms, virial)
    lines += [f"        {name} = real(0)" for name in accumulators]
    if needs.masked:
        lines += [
            "        for k in range(count):",
            *(f"            {a}_ij = {a}_i - all_{a}[k]" for a in AXES),
            "            r2 = x_ij * x_ij + y_ij * y_ij + z_ij * z_ij",
            "            key[k] = r2 - larger_of(reach2_i, all_reach2[k])",
            "        vectors = compressed_indices(0, key, filled_up(key, count), index, 0)",
            "        for k in range(vectors, padded(vectors)):",
            "            index[k] = count",
            "        vectors = padded(vectors)",
            "        for k in range(vectors):",
            "            j = index[k]",
        ]
    else:
        lines += ["        for j in range(vectors):"]
    lines += [f"            {line}" for line in _pair_lines(sources, terms, needs, mode, virial)]
    lines += [f"        {line}" for line in _stores(kinds)]
    if virial:
        lines += [
            f"        total_{e}_{a}{b} -= 0.5 * np.float64(mass_i) * np.float64(virial_{e}_{a}{b})"
            for e in virial_effects(terms)
            for a, b in VIRIAL_AXES
        ]
        for e in virial_effects(terms):
            lines += [f"    virial_{e}[leaf, {k}] += total_{e}_{a}{b}" for k, (a, b) in enumerate(VIRIAL_AXES)]
    return [*lines, "", ""]


def _listed(names: Iterable[str]) -> str:
    return "".join(f", {name}" for name in names)


def _accumulators(kinds: dict, terms, virial: bool) -> list[str]:
    names = []
    for (effect, output), how in kinds.items():
        suffixes = {
            "central": [f"_{a}" for a in AXES],
            "outer": [f"_{a}{b}" for a in AXES for b in AXES],
        }.get(how, [""])
        names += [f"sum_{effect}_{output}{suffix}" for suffix in suffixes]
    if virial:
        names += [f"virial_{e}_{a}{b}" for e in virial_effects(terms) for a, b in VIRIAL_AXES]
    return names


def _powers(needs: Needs, side: str) -> list[str]:
    # Powers of 1/h, made in the same way on both sides, so that they round alike.
    largest = max((KERNEL_NAMES[stem][1] for stem in needs.kernels[side]), default=0)
    lines = []
    if largest >= 2:
        lines.append(f"inverse_h2_{side} = inverse_h_{side} * inverse_h_{side}")
    if "W" in needs.kernels[side]:
        lines.append(f"inverse_h3_{side} = inverse_h2_{side} * inverse_h_{side}")
    if "dW" in needs.kernels[side]:
        lines.append(f"inverse_h4_{side} = inverse_h2_{side} * inverse_h2_{side}")
    return lines


def _kernel_lines(sources: Sources, needs: Needs, side: str) -> list[str]:
    lines = [f"q_{side} = r * inverse_h_{side}"] if needs.kernels[side] else []
    for stem in needs.kernels[side]:
        attribute, power = KERNEL_NAMES[stem]
        function = sources.add(getattr(needs.kernel, attribute))
        factor = f"inverse_h{power if power > 1 else ''}_{side}"
        lines.append(f"{stem}_{side} = {function}(q_{side}) * {factor}")
    return lines


def _pair_lines(sources: Sources, terms, needs: Needs, mode: str, virial: bool) -> list[str]:
    far = mode == "far"

    def source(row: str) -> str:
        return f"at(all_{row}, j)" if needs.masked else f"all_{row}[j]"

    lines = [f"{a}_ij = {a}_i - {source(a)}" for a in AXES]
    lines += ["r2 = x_ij * x_ij + y_ij * y_ij + z_ij * z_ij", "inverse_r = inverse_distance(r2)", "r = r2 * inverse_r"]
    lines += [f"mass_j = {source('mass')}"]
    for name in needs.vectors:
        lines += [f"vector_{name}_{a}_ij = vector_{name}_{a}_i - {source(f'vector_{name}_{a}')}" for a in AXES]
    lines += [f"{row}_j = {source(row)}" for row in needs.rows if row.startswith(("field_", "inverse_h")) or row == "h"]
    lines += _powers(needs, "j")
    for side in "ij":
        lines += _kernel_lines(sources, needs, side)
    if needs.approach:
        products = " + ".join(f"vector_velocity_{a}_ij * {a}_ij" for a in AXES)
        lines.append(f"v_r = ({products}) * inverse_r")
    values: dict[tuple[str, str], list] = {}
    for k, term in enumerate(terms):
        function = term.far if far else term.pair
        name = sources.add(function, f"{term.effect}_{'far' if far else 'pair'}_{k}", reciprocal=far)
        called = [_argument(n) for n in argument_names(function)] + (["inverse_r"] if far else [])
        targets = [f"value_{k}_{n}" for n in range(len(term.outputs))]
        lines.append(f"{', '.join(targets)}, = {name}({', '.join(called)})")
        for value, output in zip(targets, term.outputs, strict=True):
            values.setdefault((term.effect, output.name), []).append((value, output))
    lines.append("mass_over_r = mass_j * inverse_r")
    for (effect, name), parts in values.items():
        lines += _reduction(f"sum_{effect}_{name}", parts, needs, mode)
    if virial:
        for effect in virial_effects(terms):
            parts = [v for (e, _), pairs in values.items() if e == effect for v, o in pairs if o.how == "central"]
            lines.append(f"stress_{effect} = mass_over_r * ({' + '.join(parts)})")
            for a, b in VIRIAL_AXES:
                lines.append(f"virial_{effect}_{a}{b} += stress_{effect} * ({AXES[a]}_ij * {AXES[b]}_ij)")
    return lines


def _reduction(total: str, parts, needs: Needs, mode: str) -> list[str]:
    how = parts[0][1].how
    value = " + ".join(v for v, _ in parts)
    if how == "central":
        lines = [f"{total}_force = mass_over_r * ({value})"]
        return lines + [f"{total}_{a} += {total}_force * {a}_ij" for a in AXES]
    if how == "sum":
        return [f"{total} += mass_j * ({value})"]
    if how == "max":
        excluded = ["j >= count"] + (["j == s"] if mode != "far" else [])
        condition = " | ".join(f"({e})" for e in excluded)
        return [f"{total} = maximum({total}, where({condition}, real(0), {v}))" for v, _ in parts]
    lines = []
    for k, (v, output) in enumerate(parts):
        lines.append(f"{total}_weight_{k} = mass_over_r * {v}")
        for a in AXES:
            lines.append(f"{total}_{k}_{a} = {total}_weight_{k} * vector_{output.of}_{a}_ij")
            lines += [f"{total}_{a}{b} += {total}_{k}_{a} * {b}_ij" for b in AXES]
    return lines


def _argument(name: str) -> str:
    stem, _, side = name.rpartition("_")
    plain = name in ("r", "v_r", *SEPARATION) or stem in KERNEL_NAMES or stem == "h"
    return name if plain else f"field_{stem}_{side}"


def _stores(kinds: dict) -> list[str]:
    lines = []
    for (effect, output), how in kinds.items():
        out, total = f"out_{effect}_{output}", f"sum_{effect}_{output}"
        if how == "central":
            lines += [f"{out}[i, {k}] -= np.float64({total}_{a})" for k, a in enumerate(AXES)]
        elif how == "sum":
            lines.append(f"{out}[i] += np.float64({total})")
        elif how == "max":
            lines.append(f"{out}[i] = maximum({out}[i], np.float64({total}))")
        else:
            for k, a in enumerate(AXES):
                lines += [f"{out}[i, {k}, {n}] += np.float64({total}_{a}{b})" for n, b in enumerate(AXES)]
    return lines
