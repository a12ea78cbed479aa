"""Pair functions, written for any array namespace, turned into the source of compilable scalar functions.

The text of a function is taken with `inspect`, its xp argument is dropped, every number becomes one of the pair
precision, and whatever it calls by name is taken along. Only arithmetic, comparison and xp.where, maximum, minimum,
abs and sqrt are allowed, so what is not understood is refused with a sentence that says so.
"""

import ast
import inspect
import math
import textwrap
import types
from collections.abc import Callable, Mapping
from numbers import Integral, Real

NAMESPACE_CALLS = {"where": "where", "maximum": "maximum", "minimum": "minimum", "abs": "abs", "sqrt": "np.sqrt"}
ORIGIN = "# from "  # begins the line above a function in the generated text that tells its module
# Within a pair function sums keep their order, so that what is symmetric in i and j stays so.
PAIR_DECORATOR = '@njit(forceinline=True, error_model="numpy", fastmath=PAIR_FLAGS, **INNER)'


class Sources:
    """The collected text of functions and of all that they call; each function appears once.

    calls: what xp has, {name: name in the generated text}.
    """

    def __init__(self, calls: Mapping[str, str] = NAMESPACE_CALLS) -> None:
        self.calls = calls
        self.texts: list[str] = []
        self._names: dict[tuple[Callable, bool], str] = {}
        self._powers: set[int] = set()

    def add(self, function: Callable, wanted: str | None = None, reciprocal: bool = False) -> str:
        """Include a function of (xp, ...) and return the name it has in the generated text.

        reciprocal: also give it the argument `inverse_r`, in place of 1/r.
        """
        if (function, reciprocal) in self._names:
            return self._names[function, reciprocal]
        name = self._free_name(wanted or getattr(function, "__name__", "function"))
        self._names[function, reciprocal] = name
        self.texts.append(_translated(self, function, name, reciprocal))
        return name

    def power(self, exponent: int) -> str:
        """Name of the function that multiplies its argument by itself `exponent` times."""
        name = f"power_{exponent}"
        if exponent not in self._powers:
            self._powers.add(exponent)
            lines = [PAIR_DECORATOR, f"def {name}(x):", "    result = x"]
            for bit in bin(exponent)[3:]:  # the binary digits of the exponent below the leading one: square, multiply
                lines.append("    result = result * result")
                lines += ["    result = result * x"] if bit == "1" else []
            self.texts.append("\n".join([*lines, "    return result"]))
        return name

    def text(self) -> str:
        """The functions, callees first."""
        return "\n\n\n".join(self.texts)

    def _free_name(self, wanted: str) -> str:
        name, k = wanted, 2
        while name in self._names.values():
            name, k = f"{wanted}_{k}", k + 1
        return name


def _translated(sources: Sources, function: Callable, name: str, reciprocal: bool) -> str:
    try:
        node = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    except (OSError, SyntaxError) as error:
        raise ValueError(
            f"the source of {function.__qualname__} is not to be had: write it with def, in a file"
        ) from error
    if not isinstance(node, ast.FunctionDef):
        raise ValueError(f"{function.__qualname__} must be written with def, so that engines can compile its source")
    arguments = node.args
    if arguments.vararg or arguments.kwarg or arguments.kwonlyargs or arguments.defaults or not arguments.args:
        raise ValueError(f"{function.__qualname__} must have plain positional arguments, the first of them xp")
    parameters = inspect.signature(function).parameters
    if [argument.arg for argument in arguments.args] != list(parameters):
        raise ValueError(f"the file of {function.__qualname__} has changed since it was imported")
    namespace = arguments.args[0].arg
    node.name, node.decorator_list, node.returns = name, [], None
    arguments.args = [ast.arg(argument.arg) for argument in arguments.args[1:]]
    if reciprocal:
        arguments.args.append(ast.arg("inverse_r"))
    if isinstance(node.body[0], ast.Expr) and isinstance(node.body[0].value, ast.Constant):
        node.body = node.body[1:]
    local = {argument.arg for argument in arguments.args}
    local |= {n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    scope = dict(function.__globals__)
    for cell_name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        scope[cell_name] = cell.cell_contents
    groups = {key: getattr(parameter.annotation, "_fields", ()) for key, parameter in parameters.items()}
    translation = _Translation(sources, function.__qualname__, namespace, local, scope, groups, reciprocal)
    source = ast.unparse(ast.fix_missing_locations(translation.visit(node)))
    return f"{ORIGIN}{function.__module__}\n{PAIR_DECORATOR}\n{source}"


class _Translation(ast.NodeTransformer):
    """Rewrites the body of one function."""

    def __init__(
        self, sources: Sources, owner: str, namespace: str, local: set[str], scope: dict, groups: dict, reciprocal: bool
    ) -> None:
        self.sources, self.owner, self.namespace = sources, owner, namespace
        self.local, self.scope, self.groups, self.reciprocal = local, scope, groups, reciprocal

    def visit_Call(self, node: ast.Call) -> ast.AST:
        if node.keywords:
            raise self._refusal(node, "calls with keywords")
        arguments = [a for a in node.args if not (isinstance(a, ast.Name) and a.id == self.namespace)]
        node.args = [self.visit(a) for a in arguments]
        if isinstance(node.func, ast.Attribute) and self._is_namespace(node.func.value):
            if node.func.attr not in self.sources.calls:
                raise self._refusal(node, f"xp.{node.func.attr}")
            node.func = ast.parse(self.sources.calls[node.func.attr], mode="eval").body
            return node
        if isinstance(node.func, ast.Name) and node.func.id == "abs" and "abs" not in self.scope:
            return node
        callee = self._value(node.func)
        if not isinstance(callee, types.FunctionType):
            raise self._refusal(node, f"a call of {ast.unparse(node.func)}")
        node.func = ast.Name(self.sources.add(callee), ast.Load())
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return node if node.id in self.local else self._number(node, self._value(node))

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        fields = self.groups.get(node.value.id, ()) if isinstance(node.value, ast.Name) else ()
        if node.attr in fields:  # of a plain tuple in the generated text
            return ast.Subscript(node.value, ast.Constant(fields.index(node.attr)), ast.Load())
        if self._is_namespace(node.value) and node.attr == "pi":
            return self._number(node, math.pi)
        if self._is_namespace(node.value) and node.attr == "inf":
            return ast.parse("real(np.inf)", mode="eval").body
        return self._number(node, self._value(node))

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        component = node.slice.value if isinstance(node.slice, ast.Constant) else None
        if not isinstance(component, int):
            raise self._refusal(node, "a component whose number is not written out")
        node.value = self.visit(node.value)
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        return self._number(node, node.value)

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        if isinstance(node.op, ast.Pow):
            exponent = node.right.value if isinstance(node.right, ast.Constant) else None
            if not isinstance(exponent, int) or exponent < 1:
                raise self._refusal(node, "a power whose exponent is not a positive whole number")
            return ast.Call(ast.Name(self.sources.power(exponent), ast.Load()), [self.visit(node.left)], [])
        if isinstance(node.op, ast.Div):
            over_r = isinstance(node.right, ast.Name) and node.right.id == "r"
            if self.reciprocal and over_r and isinstance(node.left, ast.Constant) and node.left.value == 1:
                return ast.Name("inverse_r", ast.Load())
            divisor = node.right.value if isinstance(node.right, ast.Constant) else None
            if isinstance(divisor, Real) and divisor and not isinstance(node.left, ast.Constant):
                # Processors multiply in a fraction of the time.
                return ast.BinOp(self.visit(node.left), ast.Mult(), self._number(node, 1.0 / divisor))
        return self.generic_visit(node)

    def _is_namespace(self, node: ast.AST) -> bool:
        return isinstance(node, ast.Name) and node.id == self.namespace

    def _value(self, node: ast.AST) -> object:
        if isinstance(node, ast.Name) and node.id in self.scope:
            return self.scope[node.id]
        if isinstance(node, ast.Attribute):
            return getattr(self._value(node.value), node.attr, None)
        raise self._refusal(node, ast.unparse(node))

    def _number(self, node: ast.AST, value: object) -> ast.expr:
        if isinstance(value, bool) or not isinstance(value, Real):
            raise self._refusal(node, ast.unparse(node))
        if not math.isfinite(value):
            raise self._refusal(node, f"the number {value}")
        number = ast.Constant(int(value) if isinstance(value, Integral) else float(value))
        return ast.Call(ast.Name("real", ast.Load()), [number], [])

    def _refusal(self, node: ast.AST, what: str) -> ValueError:
        line = getattr(node, "lineno", 0)
        return ValueError(
            f"{self.owner}, line {line}: {what} cannot stand in a pair function; "
            f"arithmetic, numbers, other such functions and xp.{', '.join(self.sources.calls)} can"
        )
