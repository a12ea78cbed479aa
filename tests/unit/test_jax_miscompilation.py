"""A miscompilation that jax 0.10.2 has on CPU and that would corrupt energies silently: why it is excluded."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

# From 16385 rows on, jax 0.10.2 gives wrong values for a small matrix product, squared and summed, under jit and vmap.
ROWS = 16385


@pytest.mark.parametrize("rows", [ROWS - 1, ROWS, 3 * ROWS])
def test_squared_rows_of_a_small_matrix_product(rows):
    generator = np.random.default_rng(7)
    matrix, vectors = generator.normal(size=(3, 3)), generator.normal(size=(rows, 3))
    expected = ((vectors @ matrix.T) ** 2).sum(axis=1)
    with jax.enable_x64(True):
        compiled = jax.jit(jax.vmap(lambda row: jnp.sum((jnp.asarray(matrix) @ row) ** 2)))
        found = np.asarray(compiled(vectors))
    np.testing.assert_allclose(found, expected, rtol=1e-13)
