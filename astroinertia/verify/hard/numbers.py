"""Hard cases of numbers: float32 pairs, huge and tiny units, far from the origin, many steps, steps that end."""

import numpy as np

from astroinertia.verify.hard.case import KEPT, Case
from astroinertia.verify.hard.clouds import ball, cloud, lattice, turning, two
from astroinertia.verify.hard.motions import SOUND

MIXED = ('numerics.precision="mixed"',)
FAR = 1e8  # what a rounding is of, there
POINT = (
    "effects.external_field.point_mass=1.0",
    "effects.external_field.softening=1e-30",
    "effects.external_field.origin=[0.0, 0.0, 0.0]",
)


def _of_units(mass: float, length: float):
    """A turning cloud in units so many times larger, with G = 1: its energies go as mass/length."""
    return cloud(
        length * ball(),
        length * turning(ball(), 0.5) * (mass / length**3) ** 0.5,
        0.1 * mass / length,
        np.full(64, mass / 64),
    )


def _time(mass: float, length: float) -> float:
    return (length**3 / mass) ** 0.5


NUMBERS: tuple[Case, ...] = (
    Case("float32 pairs", lambda: cloud(ball(), turning(ball(), 0.5)), settings=MIXED),
    Case("float32 pairs, a coincident pair", lambda: cloud(ball()[np.arange(64) // 2]), settings=MIXED),
    Case(
        "float32 pairs, densities of 1 to 1e12",
        lambda: cloud(np.concatenate([ball(32, 1, 1e-4), ball(32, 2)]), 0.0, np.repeat([1e4, 0.1], 32)),
        stable=KEPT + ", momentum to what float32 knows of the core, 6e-8 of 1e4 radii", settings=MIXED, steps=400,
        bars={"momentum": 6e-4, "angular_momentum": 6e-4},
    ),
    Case(
        "float32 pairs, head on at Mach 1000", lambda: two(4.0, 1e3 * SOUND, 0.0, 1.0), until=6.0 / SOUND / 1e3,
        settings=MIXED, steps=400,
    ),
    Case(
        "float32 pairs, far from the origin", lambda: cloud(ball() + FAR), stable=KEPT + " of the distance",
        settings=MIXED, bars={"ledger_closure": 1e-15 * FAR, "angular_momentum": 1e-13 * FAR},
    ),
    Case(
        "far from the origin", lambda: cloud(ball() + FAR), stable=KEPT + " of the distance",
        bars={"ledger_closure": 1e-15 * FAR, "angular_momentum": 1e-13 * FAR},
    ),
    Case(
        "all of it at 1e8 times the speed of sound", lambda: cloud(ball(), FAR), stable=KEPT + " of the speed",
        bars={"ledger_closure": 1e-15 * FAR, "angular_momentum": 1e-13 * FAR},
    ),
    Case("units of 1e30", lambda: _of_units(1e30, 1e30), until=_time(1e30, 1e30)),
    Case("units of 1e-30", lambda: _of_units(1e-30, 1e-30), until=_time(1e-30, 1e-30)),
    Case("masses of 1e-40", lambda: _of_units(1e-40, 1.0), until=_time(1e-40, 1.0)),
    Case("masses of 1e40", lambda: _of_units(1e40, 1.0), until=_time(1e40, 1.0)),
    Case("lengths of 1e-20", lambda: _of_units(1.0, 1e-20), until=_time(1.0, 1e-20)),
    Case("lengths of 1e20", lambda: _of_units(1.0, 1e20), until=_time(1.0, 1e20)),
    Case(
        "a thousand steps", lambda: cloud(lattice(), turning(lattice(), 0.3), 0.3), until=3.0, steps=1001,
        settings=("numerics.max_timestep=0.003",),
    ),
    Case(
        "a million steps", lambda: cloud(ball(16), turning(ball(16), 0.3), 0.3), until=1e4, steps=1_000_000,
        settings=("numerics.max_timestep=0.01",), long=True,
    ),
    Case(
        "a step that falls to nothing", lambda: cloud(ball()[:63].tolist() + [[1e-16, 0.0, 0.0]]),
        stable="stopped: says which effect, when and at which particle", settings=POINT, ends="effect external_field",
    ),
    Case(
        "speeds that overflow", lambda: cloud(ball(), 1e200 * ball()),
        stable="stopped: says which effect, when and at which particle", ends="particle",
    ),
    Case(
        "temperatures that overflow", lambda: cloud(ball(), 0.0, 1e308),
        stable="stopped: says which effect, when and at which particle", ends="particle",
    ),
)  # fmt: skip
