"""Work of the xla engine shared out over devices, of one host or of several.

Particles are on every device, chunks of pairs on one: device d of D takes chunks d, d + D, d + 2 D, ... of every pass,
and the sums of all of them are added up everywhere. A pass sends only these sums, some ten numbers a particle. Which
devices there are is the mesh that compiled code is called under, so that a program for one device holds nothing of it.
Tests: tests/scale/test_devices.py.
"""

from collections.abc import Callable
from typing import Any

import jax
from jax.sharding import PartitionSpec
from jax.tree_util import DictKey

from astroinertia.engines.mesh import AXIS

Array = Any


def sums_of_chunks(chunks_from: Callable[[Any, Array | int, int], Any], arrays: Any) -> Any:
    """What chunks_from(arrays, first, stride) returns, arrays or trees of them, added up over all chunks.

    In a dictionary what stands under the key "max" is the largest instead. arrays: all that it works with.
    """
    count = jax.sharding.get_abstract_mesh().shape.get(AXIS, 1)
    if count == 1:
        return chunks_from(arrays, 0, 1)

    def mine(arrays: Any) -> Any:
        return jax.tree.map_with_path(_joined, chunks_from(arrays, jax.lax.axis_index(AXIS), count))

    # What the devices hold in common is not distinguished within conditionals: its derivative would be summed over
    # devices inside of them, where not all devices come by.
    whole = PartitionSpec()
    return jax.shard_map(mine, in_specs=(whole,), out_specs=whole, check_vma=False)(arrays)


def _joined(path: tuple, array: Array) -> Array:
    if path and path[0] == DictKey("max"):
        return _largest(array)
    return jax.lax.psum(array, AXIS)


@jax.custom_jvp
def _largest(array: Array) -> Array:
    """The largest over devices. To gather all of them would send as many arrays as there are devices."""
    return jax.lax.pmax(array, AXIS)


@_largest.defjvp
def _largest_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    # Of the device that has it; where several do, as JAX has it for an array, the mean.
    (mine,), (change,) = primals, tangents
    largest = _largest(mine)
    has = (mine == largest).astype(mine.dtype)
    return largest, jax.lax.psum(change * has / jax.lax.psum(has, AXIS), AXIS)
