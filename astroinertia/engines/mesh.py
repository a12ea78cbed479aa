"""The devices that passes of the xla engine are shared out over (engines.devices), as a mesh of JAX."""

from collections.abc import Iterator
from contextlib import contextmanager

from astroinertia.errors import SceneError

AXIS = "devices"


@contextmanager
def shared_out(count: int) -> Iterator[None]:
    """Within it, passes of the xla engine are shared out over this many devices; SceneError where there are fewer.

    After jax.distributed.initialize devices of all processes count, and every process must do the same.
    """
    if count == 1:
        yield
        return
    import jax  # only here: one device may need none
    from jax.sharding import AxisType

    present = jax.device_count()
    if count > present or (jax.process_count() > 1 and count != present):
        raise SceneError(f"numerics.devices is {count}, but JAX has {present} {jax.default_backend()} device(s) here.")
    with jax.set_mesh(jax.make_mesh((count,), (AXIS,), devices=jax.devices()[:count], axis_types=(AxisType.Auto,))):
        yield
