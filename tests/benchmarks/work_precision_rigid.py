"""Error against time of both integrators of rigid motion, on three problems with closed forms.

Run: python tests/benchmarks/work_precision_rigid.py [--keep]
"""

import jax
import numpy as np
from precision_table import publish, table

from astroinertia.effects import catalogue
from astroinertia.models.rigid import body as rigid
from astroinertia.models.rigid.evolution import RigidBody, Settings
from astroinertia.rotation import free_attitude, free_top, heavy_top
from astroinertia.rotation.attitude import attitude_of_quaternion, quaternion

STEPS = (10.0, 20.0, 40.0, 80.0)
ORDERS = (2, 4, 6, 8)
TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12, 1e-14)
PERIODS = 100
ROWS = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # of a top whose own axis has the least moment


def free(moments: tuple, spin: tuple):
    """How a free body is made, when it ends and its exact attitude then."""
    top = free_top.free_top(moments, spin)
    end = PERIODS * free_top.period(top)

    def make(settings: Settings) -> RigidBody:
        return RigidBody(rigid.body(1.0, moments), [1.0, 0.0, 0.0, 0.0], np.multiply(moments, spin), settings)

    return make, end, free_attitude.attitude(top, np.array([end]))[0]


def heavy():
    """The same of a top that nods: 30 time units, some six nutations."""
    top = heavy_top.heavy_top(2.0, 0.5, 1.2, 1.2, [0.3, 0.7, 4.0])
    pull = catalogue.build("pivot", {"gravity": [0.0, 0.0, -0.4], "arm": [0.0, 0.0, 1.0]})
    start, exact = heavy_top.attitude(top, np.array([0.0, 30.0]))
    moments = np.array([0.5, 2.0, 2.0])
    body = rigid.body(3.0, moments, effects=(pull,), axes=ROWS.T, arm=ROWS @ [0.0, 0.0, 1.0])

    def make(settings: Settings) -> RigidBody:
        return RigidBody(body, quaternion(ROWS @ start), moments * (ROWS @ [0.3, 0.7, 4.0]), settings)

    return make, 30.0, ROWS @ exact


def main() -> None:
    problems = {
        "Free body 1:2:3, 100 wobbles next to the middle axis": free((1.0, 2.0, 3.0), (0.1, 1.0, 0.1)),
        "Free body 1:2:3, 100 wobbles about the long axis": free((1.0, 2.0, 3.0), (1.0, 0.2, 0.3)),
        "Heavy top": heavy(),
    }
    tables = []
    for title, (make, end, exact) in problems.items():

        def run(settings: Settings, make=make, end=end) -> RigidBody:
            body = make(settings)
            body.advance(end)
            return body

        def error(body: RigidBody, exact=exact) -> float:
            return float(np.abs(np.asarray(attitude_of_quaternion(body.state.quaternion)) - exact).max())

        for order in ORDERS:
            tables.append(
                table(f"{title}: splitting of order {order}", "steps in a rotation", STEPS,
                      lambda steps, order=order, run=run: run(Settings("splitting", 1e-12, steps, order)), error, 40.0)
            )  # fmt: skip
        tables.append(
            table(f"{title}: adaptive, order 8(7)", "tolerance", TOLERANCES,
                  lambda tolerance, run=run: run(Settings("adaptive", tolerance)), error, 1e-12)
        )  # fmt: skip
    publish("rigid", tables)


if __name__ == "__main__":
    with jax.enable_x64(True):
        main()
