"""jax.numpy, imported when the first of its names is asked for: what only says what an effect is need not wait for it.

import astroinertia.engines.late_jnp as jnp
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jax.numpy import *  # noqa: F403  # pyright: ignore[reportWildcardImportFromLibrary]
else:

    def __getattr__(name: str) -> Any:
        import jax.numpy

        return getattr(jax.numpy, name)
