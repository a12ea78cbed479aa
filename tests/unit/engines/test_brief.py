"""Programs that run briefly: compiled without the emitters at top level, and the same function elsewhere."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.engines.brief import EMITTERS, brief, served

pytestmark = pytest.mark.usefixtures("float64")

OF_A_NUMBER = {
    "value": lambda function: function(2.0),
    "within jit": lambda function: jax.jit(lambda x: 3.0 * function(x))(2.0),
    "within jit, of what is known": lambda function: jax.jit(lambda x: x * function(2.0))(3.0),
    "grad": lambda function: jax.grad(function)(2.0),
    "grad within jit, of what is known": lambda function: jax.jit(jax.grad(lambda x: x * function(2.0)))(3.0),
    "grad, of what is known": lambda function: jax.grad(lambda x: x * function(2.0))(3.0),
    "jvp": lambda function: jax.jvp(function, (2.0,), (0.5,)),
    "vmap": lambda function: jax.vmap(function)(jnp.arange(1.0, 4.0)),
    "second derivative in a batch": lambda function: jax.vmap(jax.jit(jax.hessian(function)))(jnp.arange(1.0, 4.0)),
    "within scan": lambda function: jax.lax.scan(lambda x, _: (function(x), function(0.5)), 2.0, length=3),
}


def looped(x):
    return jax.lax.fori_loop(0, 3, lambda _, y: jnp.sin(y) * x, x)


@pytest.mark.slow
@pytest.mark.parametrize("way", OF_A_NUMBER)
def test_values_and_derivatives_are_those_of_the_function(way):
    found, expected = (OF_A_NUMBER[way](function) for function in (brief(looped), looped))
    for one, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14)


@pytest.mark.skipif(jax.default_backend() != "cpu", reason="other processors have no such emitters")
def test_the_program_that_runs_is_one_without_the_emitters():
    def alone(x):
        return 2.0 * jnp.cumsum(jnp.sin(x))

    array = jnp.arange(5.0)
    brief(alone)(array)
    (ran,) = programs("jit_alone")
    assert ran == jax.jit(alone, compiler_options={EMITTERS: False}).lower(array).compile().as_text()
    assert ran != jax.jit(alone).lower(array).compile().as_text()


def programs(name):
    """What the compiler has made of the programs of a name that are kept."""
    modules = [module for one in jax.devices()[0].client.live_executables() for module in one.hlo_modules()]
    return [module.to_string() for module in modules if module.name == name]


def test_a_compiler_without_the_option_does_without():
    unknown = "xla_cpu_no_such_option"
    assert not served(unknown)
    assert float(brief(looped, option=unknown)(2.0)) == float(jax.jit(looped)(2.0))


def test_settings_are_those_of_jit():
    @brief
    def plain(x, power):
        return x**power

    assert float(brief(lambda x, power: x**power, static_argnames="power")(3.0, power=2)) == 9.0
    assert plain.__name__ == "plain" and float(plain(3.0, power=2.0)) == 9.0
