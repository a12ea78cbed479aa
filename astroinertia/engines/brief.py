"""Programs of JAX that run briefly: compiled sooner for CPUs, where some then run slower.

The fusion emitters are XLA's newer code generator for CPUs. With them a program takes 1.6 to 2.7 times as long to
compile and runs up to 1.8 times as fast (jaxlib 0.10.1). One that runs for less time than it is compiled for does
better without them. Tests: tests/unit/engines/test_brief.py.
"""

import functools
from collections.abc import Callable
from typing import Any

import jax
from jax.core import Tracer

EMITTERS = "xla_cpu_use_fusion_emitters"


def brief(function: Callable, *, option: str = EMITTERS, **settings: Any) -> Callable:
    """jax.jit with its settings, but without the emitters: where programs are for CPUs and the compiler has the option.

    JAX takes no options for a part of another program: within jax.jit, jax.grad and the like this is jax.jit alone.
    Not for programs that run for long.

    >>> print(brief(lambda x: 2.0 * x)(3.0))
    6.0
    """
    usual = jax.jit(function, **settings)
    sooner = jax.jit(function, compiler_options={option: False}, **settings)

    @functools.wraps(function)
    def called(*args: Any, **kwargs: Any) -> Any:
        return (sooner if served(option) and _by_itself(args, kwargs) else usual)(*args, **kwargs)

    return called


@functools.cache
def served(option: str) -> bool:
    """Whether programs are for CPUs and their compiler has an option that can be off."""
    if jax.default_backend() != "cpu":
        return False
    try:
        jax.jit(lambda: 0, compiler_options={option: False}).lower().compile()
    except jax.errors.JaxRuntimeError:
        return False
    return True


def _by_itself(*arguments: Any) -> bool:
    """Whether a program of these arguments is no part of another."""
    values = (*jax.tree.leaves(arguments), _number())
    return not any(isinstance(value, Tracer) for value in values)


_number = jax.jit(lambda: 0)  # its value is not known where all is part of another program, whatever the arguments
