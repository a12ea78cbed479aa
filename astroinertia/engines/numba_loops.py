"""The text of the loops over pairs: one for each pass, fused from just the terms that it carries.

In every loop the target particle is i and the source j. Names of functions hold the names of the effects, so that an
effect which is not listed leaves no trace in what is compiled.
"""

from collections.abc import Sequence

from astroinertia.engines.numba_passes import (
    AXES,
    VIRIAL_AXES,
    Needs,
    listed,
    output_kinds,
    results,
    virial_effects,
)
from astroinertia.engines.numba_source import Sources
from astroinertia.engines.terms import KERNEL_NAMES, SEPARATION, PairTerm, argument_names, arguments

# The sources within reach of the target: their places in the table, the massless one to fill the last vector up, then
# what the pair functions ask for in rows of their own. Rows are compacted once, which is cheaper than gathers in the
# loop over pairs.
WITHIN_REACH = """
vectors = near_indices(
    search[0], search[1], search[2], reach2, x_i, y_i, z_i, reach2[s], count, index, index
)
vector_fill(index, vectors, count)
spread_rows(table, index, padded(vectors), rows)
"""
# The same where what is beyond reach counts too: both parts go by one key, so that no pair is missed or taken twice.
BY_KEY = """
for k in range(count):
    x_ij, y_ij, z_ij = x_i - all_x[k], y_i - all_y[k], z_i - all_z[k]
    key[k] = x_ij * x_ij + y_ij * y_ij + z_ij * z_ij - larger_of(reach2_i, all_reach2[k])
vectors = compressed_indices(0, key, count, index, 0)
"""
# How long a pair acts: the longer of two intervals closes and the longer of two opens; not at all where one particle
# rests, which a negative opening interval says, and without the first where one has just become active.
PAIR_TIME = """
longer = larger_of(field_closing_i, field_closing_j)
longer = where(longer < real(1e30), longer, real(0)) + larger_of(field_opening_i, field_opening_j)
pair_time = where((field_opening_i < real(0)) | (field_opening_j < real(0)), real(0), longer)
"""
LISTED = """
for k in range(vectors, padded(vectors)):
    index[k] = count
for k in range(padded(vectors)):
    j = index[k]
"""


def neighbour_loop(name: str, sources: Sources, terms: Sequence[PairTerm], needs: Needs, virial: bool) -> list[str]:
    """The loop over the targets of one leaf and the sources within reach of each; results have a row a target."""
    kinds = output_kinds(terms, needs.impulses)
    partners, _ = needs.sides
    filled = listed(results(terms, virial, needs.impulses))
    lines = [
        f"spread_rows = row_spreader({needs.spread}, 0)",
        "",
        "",
        "@njit(fastmath=LOOP_FLAGS, **PART)",
        f"def {name}(leaf, first, last, slots, count, table, rows, search, index{filled}):",
        "    widest_vectors()",
    ]
    lines += [f"    all_{row} = rows[{k}]" for k, row in enumerate(partners)]
    lines += [f"    reach2 = search[{4 + needs.table.index('reach2') % 4}]"]
    if virial:
        lines += [f"    total_{e}_{a}{b} = 0.0" for e in virial_effects(terms) for a, b in VIRIAL_AXES]
    lines += ["    for i in range(first, last):", "        s = slots[i - first]"]
    lines += [f"        {row}_i = table[s, {k}]" for k, row in enumerate(needs.table) if row != "mass" or virial]
    lines += _indented(2, WITHIN_REACH)
    lines += [f"        {line}" for line in _powers(needs, "i")]
    lines += [f"        {name} = real(0)" for name in _accumulators(kinds, terms, virial)]
    lines += ["        for j in range(padded(vectors)):"]
    lines += [f"            {line}" for line in _pair_lines(sources, terms, needs, "neighbour", virial)]
    lines += [f"        {line}" for line in _stores(kinds, "=")]
    if virial:
        lines += _virial_lines(terms)
    return [*lines, "", ""]


def leaf_loop(
    name: str, sources: Sources, terms: Sequence[PairTerm], needs: Needs, mode: str, virial: bool
) -> list[str]:
    """The loop over the targets of one node and the sources in its buffer, which adds to the results.

    mode: "near", pairs within reach by the terms' pair functions and the others by their far functions; "all", all
    pairs by their pair functions; "far", all by their far functions, with targets in a buffer of their own.
    """
    kinds = output_kinds(terms)
    target = "targets" if mode == "far" else "buffer"
    lines = [
        "@njit(fastmath=LOOP_FLAGS, **PART)",
        f"def {name}(leaf, first, last, slots, count, targets, buffer, key, index{listed(results(terms, virial))}):",
        "    widest_vectors()",
    ]
    lines += [f"    all_{row} = buffer[{k}]" for k, row in enumerate(needs.rows)]
    if virial:
        lines += [f"    total_{e}_{a}{b} = 0.0" for e in virial_effects(terms) for a, b in VIRIAL_AXES]
    lines += ["    for i in range(first, last):", f"        s = {'i - first' if mode == 'far' else 'slots[i - first]'}"]
    used = [row for row in needs.rows if row != "mass" or virial]
    lines += [f"        {row}_i = {target}[{needs.rows.index(row)}, s]" for row in used]
    lines += [f"        {line}" for line in _powers(needs, "i")]
    lines += [f"        {name} = real(0)" for name in _accumulators(kinds, terms, virial)]
    if mode == "near":
        lines += _indented(2, BY_KEY + LISTED)
        lines += [f"            {line}" for line in _pair_lines(sources, terms, needs, "listed", virial)]
    form = {"near": "rest", "all": "all", "far": "far"}[mode]
    lines += [f"        for j in range({'count' if form == 'rest' else 'padded(count)'}):"]
    lines += [f"            {line}" for line in _pair_lines(sources, terms, needs, form, virial)]
    lines += [f"        {line}" for line in _stores(kinds, "+=")]
    if virial:
        lines += _virial_lines(terms)
    return [*lines, "", ""]


def _virial_lines(terms: Sequence[PairTerm]) -> list[str]:
    lines = [
        f"        total_{e}_{a}{b} -= 0.5 * np.float64(mass_i) * np.float64(virial_{e}_{a}{b})"
        for e in virial_effects(terms)
        for a, b in VIRIAL_AXES
    ]
    for e in virial_effects(terms):
        lines += [f"    virial_{e}[leaf, {k}] += total_{e}_{a}{b}" for k, (a, b) in enumerate(VIRIAL_AXES)]
    return lines


def _indented(depth: int, text: str) -> list[str]:
    return ["    " * depth + line for line in text.strip().splitlines()]


def _accumulators(kinds: dict, terms: Sequence[PairTerm], virial: bool) -> list[str]:
    names = []
    for (effect, output), how in kinds.items():
        suffixes = {
            "central": [f"_{a}" for a in AXES],
            "outer": [f"_{a}{b}" for a in AXES for b in AXES],
            "symmetric": [f"_{AXES[a]}{AXES[b]}" for a, b in VIRIAL_AXES],
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
    if {"dW", "d2W"} & set(needs.kernels[side]):
        lines.append(f"inverse_h4_{side} = inverse_h2_{side} * inverse_h2_{side}")
    if "d2W" in needs.kernels[side]:
        lines.append(f"inverse_h5_{side} = inverse_h4_{side} * inverse_h_{side}")
    return lines


def _kernel_lines(sources: Sources, needs: Needs, side: str) -> list[str]:
    lines = [f"q_{side} = r * inverse_h_{side}"] if needs.kernels[side] else []
    for stem in needs.kernels[side]:
        attribute, power = KERNEL_NAMES[stem]
        function = sources.add(getattr(needs.kernel, attribute))
        factor = f"inverse_h{power if power > 1 else ''}_{side}"
        lines.append(f"{stem}_{side} = {function}(q_{side}) * {factor}")
    return lines


def _pair_lines(sources: Sources, terms: Sequence[PairTerm], needs: Needs, form: str, virial: bool) -> list[str]:
    """One pair; form: "neighbour" (sources in rows of their own), "listed" (sources by their places), "rest" (beyond
    reach, by far functions), "all" or "far".
    """
    far = form in ("rest", "far")

    def source(row: str) -> str:
        return f"at(all_{row}, j)" if form == "listed" else f"all_{row}[j]"

    lines = [f"{a}_ij = {a}_i - {source(a)}" for a in AXES]
    lines += ["r2 = x_ij * x_ij + y_ij * y_ij + z_ij * z_ij", f"mass_j = {source('mass')}"]
    if form == "rest":
        lines += ["within = key[j] < real(0)", "mass_j = where(within, real(0), mass_j)"]
        lines += ["r2 = where(within, larger_of(reach2_i, all_reach2[j]), r2)"]
    lines += ["inverse_r = inverse_distance(r2)", "r = r2 * inverse_r"]
    if any(output.of == "position" for term in terms for output in term.outputs):
        lines += [f"vector_position_{a}_ij = {a}_ij" for a in AXES]
    for name in needs.vectors:
        lines += [f"vector_{name}_{a}_ij = vector_{name}_{a}_i - {source(f'vector_{name}_{a}')}" for a in AXES]
    scalars = [row for row in needs.rows if row.startswith(("field_", "inverse_h")) or row == "h"]
    lines += [f"{row}_j = {source(row)}" for row in scalars if form != "neighbour" or row in needs.sides[0]]
    lines += _powers(needs, "j")
    for side in "ij":
        lines += _kernel_lines(sources, needs, side)
    if needs.approach:
        products = " + ".join(f"vector_velocity_{a}_ij * {a}_ij" for a in AXES)
        lines.append(f"v_r = ({products}) * inverse_r")
    calls, values = _calls(sources, terms, far)
    lines += [*calls, "mass_over_r = mass_j * inverse_r"]
    kinds = output_kinds(terms)
    for (effect, name), parts in values.items():
        lines += _reduction(f"sum_{effect}_{name}", kinds[effect, name], parts, form)
    if needs.impulses:
        lines += _indented(0, PAIR_TIME)
        for (effect, name), parts in values.items():
            lines += _impulse(f"sum_{effect}_{name}", parts[0][1].how)
    return lines + (_stress_lines(terms, values) if virial else [])


def _calls(sources: Sources, terms: Sequence[PairTerm], far: bool) -> tuple[list[str], dict[tuple[str, str], list]]:
    """The calls of all terms, and the values that they give, with their outputs, by effect and output."""
    lines, values = [], {}
    for k, term in enumerate(terms):
        function = term.far if far and term.far else term.pair
        name = sources.add(function, f"{term.effect}_{'far' if far else 'pair'}_{k}", reciprocal=far)
        grouped = arguments(function, {n: _argument(n) for n in argument_names(function)})
        called = [value if isinstance(value, str) else f"({', '.join(value)},)" for value in grouped]
        called += ["inverse_r"] if far else []
        targets = [f"value_{k}_{n}" for n in range(len(term.outputs))]
        lines.append(f"{', '.join(targets)}, = {name}({', '.join(called)})")
        for value, output in zip(targets, term.outputs, strict=True):
            values.setdefault((term.effect, output.name), []).append((value, output))
    return lines, values


def _stress_lines(terms: Sequence[PairTerm], values: dict[tuple[str, str], list]) -> list[str]:
    lines = []
    for effect in virial_effects(terms):
        parts = [v for (e, _), pairs in values.items() if e == effect for v, o in pairs if o.how == "central"]
        lines.append(f"stress_{effect} = mass_over_r * ({' + '.join(parts)})")
        for a, b in VIRIAL_AXES:
            lines.append(f"virial_{effect}_{a}{b} += stress_{effect} * ({AXES[a]}_ij * {AXES[b]}_ij)")
    return lines


def _reduction(total: str, how: str, parts: list, form: str) -> list[str]:
    value = " + ".join(v for v, _ in parts)
    if how == "central":
        lines = [f"{total}_force = mass_over_r * ({value})"]
        return lines + [f"{total}_{a} += {total}_force * {a}_ij" for a in AXES]
    if how == "sum":
        return [f"{total}_part = mass_j * ({value})", f"{total} += {total}_part"]
    if how == "max":
        own = {
            "neighbour": ["index[j] == index.dtype.type(s)"],
            "listed": ["j == s"],
            "all": ["j == s"],
            "rest": ["within"],
        }
        excluded = ["j >= vectors" if form == "neighbour" else "j >= count", *own.get(form, [])]
        condition = " | ".join(f"({e})" for e in excluded)
        return [f"{total} = maximum({total}, where({condition}, real(0), {v}))" for v, _ in parts]
    lines = []
    for k, (v, output) in enumerate(parts):
        lines.append(f"{total}_weight_{k} = mass_over_r * {v}")
        for a in AXES:
            lines.append(f"{total}_{k}_{a} = {total}_weight_{k} * vector_{output.of}_{a}_ij")
            partners = AXES if how == "outer" else AXES[AXES.index(a) :]
            lines += [f"{total}_{a}{b} += {total}_{k}_{a} * {b}_ij" for b in partners]
    return lines


def _impulse(total: str, how: str) -> list[str]:
    if how == "central":
        return [f"{total}_impulse_{a} += (pair_time * {total}_force) * {a}_ij" for a in AXES]
    return [f"{total}_impulse += pair_time * {total}_part"] if how == "sum" else []


def _argument(name: str) -> str:
    stem, _, side = name.rpartition("_")
    plain = name in ("r", "v_r", *SEPARATION) or stem in KERNEL_NAMES or stem == "h"
    return name if plain else f"field_{stem}_{side}"


def _stores(kinds: dict, sign: str) -> list[str]:
    lines = []
    for (effect, output), how in kinds.items():
        out, total = f"out_{effect}_{output}", f"sum_{effect}_{output}"
        if how == "central":
            lines += [f"{out}[i, {k}] {sign} -np.float64({total}_{a})" for k, a in enumerate(AXES)]
        elif how == "sum":
            lines.append(f"{out}[i] {sign} np.float64({total})")
        elif how == "max":
            value = f"maximum({out}[i], np.float64({total}))" if sign == "+=" else f"np.float64({total})"
            lines.append(f"{out}[i] = {value}")
        else:
            for k, a in enumerate(AXES):
                for n, b in enumerate(AXES):
                    element = f"{b}{a}" if how == "symmetric" and n < k else f"{a}{b}"
                    lines.append(f"{out}[i, {k}, {n}] {sign} np.float64({total}_{element})")
    return lines
