"""Operations of traced and of generated programs, counted by the effect that they belong to.

An effect's parts are traced within a scope of its name (effects.effect.scoped), and generated functions tell the module
that they come from. What belongs to no effect is listed under the name COMMON. Tests:
tests/unit/audit/test_operations.py.
"""

import ast
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from astroinertia.engines.numba_source import ORIGIN
from astroinertia.engines.terms import COMMON

SCOPE = re.compile(r"effect:(\w+)")
FREE = frozenset({"real", "float", "int"})  # calls in generated text that only give a number its type


def of_trace(program: Any, effect: str = COMMON) -> Counter[str]:
    """{effect: equations} of a jaxpr, those within loops and inner programs counted once each."""
    counts: Counter[str] = Counter()
    for equation in program.eqns:
        scopes = SCOPE.findall(str(equation.source_info.name_stack))
        own = scopes[-1] if scopes else effect
        inner = [part for value in equation.params.values() for part in _programs(value)]
        if inner:
            for part in inner:
                counts += of_trace(part, own)
        else:
            counts[own] += 1
    return counts


def _programs(value: Any) -> list[Any]:
    if hasattr(value, "eqns"):
        return [value]
    if hasattr(value, "jaxpr"):
        return [value.jaxpr]
    if isinstance(value, tuple | list):
        return [part for member in value for part in _programs(member)]
    return []


def of_text(text: str, owners: Mapping[str, str]) -> Counter[str]:
    """{effect: arithmetic operations, comparisons and calls} of the functions of a generated module.

    owners: {module that functions come from: effect}. What the engine itself writes around them is not counted.
    """
    counts: Counter[str] = Counter()
    lines = text.splitlines()
    for function in ast.parse(text).body:
        if not isinstance(function, ast.FunctionDef) or not function.decorator_list:
            continue
        above = lines[function.decorator_list[0].lineno - 2]
        if above.startswith(ORIGIN):
            counts[owners.get(above.removeprefix(ORIGIN).strip(), COMMON)] += _operations(function)
    return counts


def _operations(function: ast.FunctionDef) -> int:
    kinds = ast.BinOp | ast.UnaryOp | ast.Compare | ast.BoolOp
    return sum(
        isinstance(node, kinds) or (isinstance(node, ast.Call) and ast.unparse(node.func) not in FREE)
        for statement in function.body
        for node in ast.walk(statement)
    )


def added(counts: Iterable[Counter[str]]) -> dict[str, int]:
    """The sum of several counts, the most first."""
    total: Counter[str] = Counter()
    for count in counts:
        total += count
    return dict(total.most_common())
