"""JAX computes in 64 bits within, whenever it is imported, and as before afterwards."""

import os
import subprocess
import sys

import jax
import jax.numpy as jnp
import pytest

from astroinertia.engines.double import in_double

IMPORTED_WITHIN = """
import sys, threading
from astroinertia.engines.double import in_double
with in_double():
    with in_double():
        assert "jax" not in sys.modules
        import jax.numpy as jnp
    print(jnp.zeros(1).dtype)
    thread = threading.Thread(target=lambda: print(jnp.zeros(1).dtype)); thread.start(); thread.join()
print(jnp.zeros(1).dtype)
"""
IMPORTED_AFTERWARDS = """
from astroinertia.engines.double import in_double
with in_double():
    pass
import jax.numpy as jnp
print(jnp.zeros(1).dtype)
with in_double():
    print(jnp.zeros(1).dtype)
"""


def printed(program, **variables):
    environment = os.environ | variables
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=environment)
    return done.stdout.split()


def test_jax_that_is_there_computes_in_64_bits_until_the_end():
    with jax.enable_x64(False):
        with in_double():
            assert jnp.zeros(1).dtype == "float64"
        assert jnp.zeros(1).dtype == "float32"


@pytest.mark.slow
def test_jax_that_is_imported_within_does_so_in_all_threads_until_the_outermost_end():
    assert printed(IMPORTED_WITHIN) == ["float64", "float64", "float32"]
    assert printed(IMPORTED_WITHIN, JAX_ENABLE_X64="true") == ["float64", "float64", "float64"]


@pytest.mark.slow
def test_jax_that_is_imported_afterwards_is_left_alone():
    assert printed(IMPORTED_AFTERWARDS) == ["float32", "float64"]
