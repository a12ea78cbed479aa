"""Operations of programs are counted under the effect that they belong to."""

import jax
import jax.numpy as jnp

from astroinertia.audit.operations import COMMON, of_text, of_trace
from astroinertia.effects.kinds import pressure, viscosity
from astroinertia.engines.numba_source import Sources


def program(x: jax.Array) -> jax.Array:
    with jax.named_scope("effect:tide"):
        x = x * 2.0 + 1.0

    def body(carried: jax.Array, _: None) -> tuple[jax.Array, None]:
        with jax.named_scope("effect:gravity"):
            return carried - 3.0, None

    x, _ = jax.lax.scan(body, x, None, length=4)
    return x / 7.0


def test_equations_of_a_trace_are_counted_by_scope_and_within_loops() -> None:
    counts = of_trace(jax.jit(program).trace(jnp.ones(3)).jaxpr.jaxpr)
    assert counts == {"tide": 2, "gravity": 1, COMMON: 1}


def test_operations_of_generated_functions_are_counted_by_the_module_that_they_come_from() -> None:
    """A pair function that calls one of another effect's module has that one counted there."""
    sources = Sources()
    for term in pressure.Pressure().neighbour_terms:
        sources.add(term.pair)
    text = sources.text() + "\n\n\n@njit\ndef engine(x):\n    return x + x\n"
    owners = {pressure.__name__: "pressure", viscosity.__name__: "viscosity"}
    counts = of_text(text, owners)
    assert set(counts) == {"pressure"} and counts["pressure"] >= 3
