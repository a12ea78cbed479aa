"""Sums, densities, gravity and derivatives of the xla engine on several devices, next to those on one: prints JSON.

XLA_FLAGS=--xla_force_host_platform_device_count=8 python tests/scale/device_sums.py 2 8
python tests/scale/device_sums.py 2 --host 0 127.0.0.1:9999     one of two processes with a device each
"""

import argparse
import json
import sys

import jax
import jax.numpy as jnp
import numpy as np

from astroinertia.engines.mesh import shared_out
from astroinertia.engines.xla import Engine
from astroinertia.gravity import multipole_xla
from tests.unit.engines.test_xla import FLOW, NEIGHBOURS

COUNT = 700


def answers(derivatives, few):
    """What the engine finds for a cloud that is dense in its middle, and derivatives of some of it: {name: array}.

    few: densities and one sum of each kind only, which compile in a third of the time.
    """
    random = np.random.default_rng(8)
    direction = random.normal(size=(COUNT, 3))
    position = direction / np.linalg.norm(direction, axis=1)[:, None] * random.uniform(size=COUNT)[:, None]
    engine = Engine(wide_leaf=32, pairs_in_chunk=1 << 12)
    guess = 1.2 * (4.0 * np.pi * np.maximum((position**2).sum(axis=1), 0.01) / COUNT) ** (1.0 / 3.0)
    order, arrangement = engine.arrange(position, guess)
    mass, position = jnp.full(COUNT, 1.0 / COUNT), jnp.asarray(position[order])
    found = engine.density(arrangement, "wendland_c2", position, mass, guess[order], 1.3, 1e-10, not few)
    fields = {
        "position": position,
        "mass": mass,
        "smoothing_length": found.smoothing_length,
        "velocity": jnp.asarray(random.normal(size=(COUNT, 3))),
        "weight": jnp.asarray(random.uniform(0.5, 1.5, COUNT)),
        "zeta_over_omega": jnp.asarray(random.uniform(-1.5, -0.5, COUNT)),
    }
    terms = (FLOW,) if few else NEIGHBOURS
    sums = engine.neighbour_sums(arrangement, "wendland_c2", terms, fields, virial=not few)
    if few:
        return {name: np.asarray(value) for name, value in (sums["flow"] | {"grad_h": found.grad_h}).items()}
    lists = multipole_xla.lists_for(engine, arrangement, mass, None, 1e-3)

    def points(position):
        given = "float64", lists, mass, position, found.smoothing_length
        return multipole_xla.points(*given) | {"virial": multipole_xla.virial(*given)}

    def heating(position):
        moved = {**fields, "position": position}
        return (engine.neighbour_sums(arrangement, "wendland_c2", (FLOW,), moved)["flow"]["heating"] ** 2).sum()

    def signalled(velocity):
        moving = {**fields, "velocity": velocity}
        return (engine.neighbour_sums(arrangement, "wendland_c2", (FLOW,), moving)["flow"]["signal"] ** 2).sum()

    def solved(position):
        return engine.density(arrangement, "wendland_c2", position, mass, guess[order], 1.3, 1e-10, False).density.sum()

    gathered = {f"{effect} {name}": value for effect, outputs in sums.items() for name, value in outputs.items()}
    gathered |= {f"gravity {name}": value for name, value in points(position).items()}
    gathered |= {"smoothing_length": found.smoothing_length, "grad_h": found.grad_h}
    if derivatives:
        gathered["derivative of heating"] = jax.grad(heating)(position)
        gathered["derivative of density"] = jax.grad(solved)(position)
        gathered["derivative of a largest"] = jax.grad(signalled)(jnp.asarray(fields["velocity"]))
    return {name: np.asarray(value) for name, value in gathered.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("counts", nargs="+", type=int)
    parser.add_argument("--host", nargs=2, metavar=("NUMBER", "COORDINATOR"), help="one of two processes")
    parser.add_argument("--derivatives", action="store_true")
    parser.add_argument("--few", action="store_true", help="some of the sums")
    chosen = parser.parse_args()
    if chosen.host:
        number, coordinator = chosen.host
        jax.distributed.initialize(coordinator, num_processes=2, process_id=int(number))
    with jax.enable_x64(True):
        alone = answers(chosen.derivatives, chosen.few)
        differences = {}
        for count in chosen.counts:
            with shared_out(count):
                shared = answers(chosen.derivatives, chosen.few)
                used = jax.sharding.get_abstract_mesh().shape["devices"]
            assert used == count
            differences[count] = {
                name: float(np.abs(shared[name] - value).max() / np.abs(value).max()) for name, value in alone.items()
            }
    sys.stdout.write(json.dumps(differences))


if __name__ == "__main__":
    main()
