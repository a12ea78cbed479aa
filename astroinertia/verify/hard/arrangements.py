"""Hard cases of where particles lie: few, coincident, in a plane, on a line, at points, apart, of unequal masses."""

import numpy as np

from astroinertia.verify.hard.case import KEPT, Case
from astroinertia.verify.hard.clouds import COUNT, ball, cloud, every_other, first, lattice, line, turning, two

FEW = "refused: a particle cannot be smoothed over matter that is not there"
TREE = ('effects.gravity.method="multipole"',)
MANY = 512  # enough for trees of gravity to have several levels


def _with(position: np.ndarray, *extra: tuple[float, float, float]) -> np.ndarray:
    return np.concatenate([position[: len(position) - len(extra)], np.array(extra)])


def _shell() -> np.ndarray:
    places = ball()
    return places / np.linalg.norm(places, axis=1, keepdims=True)


def _in_one_place(size: int, count: int = COUNT) -> np.ndarray:
    return ball(count)[np.arange(count) // size]


PLACES: tuple[Case, ...] = (
    Case("one particle", lambda: cloud(np.zeros((1, 3))), stable=FEW, ends="no smoothing length is long enough"),
    Case("two particles", lambda: cloud([[0, 0, 0], [1, 0, 0]]), stable=FEW, ends="no smoothing length is long enough"),
    Case("two in one place", lambda: cloud(np.zeros((2, 3))), stable=FEW, ends="no smoothing length is long enough"),
    Case("eight particles", lambda: cloud(ball(8))),
    Case("sixteen particles", lambda: cloud(ball(16))),
    Case("fewer than neighbours asked for", lambda: cloud(ball(64)), settings=("numerics.neighbours=400",)),
    Case(
        "all in one place", lambda: cloud(np.zeros((COUNT, 3))), stable="refused: no length to smooth over",
        ends="all particles lie in one place",
    ),
    Case("a coincident pair", lambda: cloud(_with(ball(), tuple(ball()[0])))),
    Case("every particle twice", lambda: cloud(_in_one_place(2))),
    Case("every particle four times", lambda: cloud(_in_one_place(4))),
    Case(
        "eight in each place", lambda: cloud(_in_one_place(8)), stable="refused: no smoothing length is short enough",
        ends="no smoothing length is short enough",
    ),
    Case("a pair a rounding apart", lambda: cloud(_with(ball(), tuple(ball()[0] * (1.0 + 1e-15))))),
    Case("two bodies in one place", lambda: two(0.0, 0.0)),
    *(
        Case(
            f"a coincident pair, {text}", lambda: cloud(_in_one_place(2)), own_program=True,
            settings=(f'numerics.kernel="{kernel}"',),
        )
        for text, kernel in (("cubic spline", "cubic"), ("quintic spline", "quintic"), ("Wendland C6", "wendland_c6"))
    ),
    Case("a lattice", lambda: cloud(lattice())),
    Case("a thin shell", lambda: cloud(_shell())),
    Case("all on a line", lambda: cloud(line())),
    Case("all in a plane", lambda: cloud(ball() * [1.0, 1.0, 0.0])),
    Case("all in a tilted plane", lambda: cloud(ball() - np.outer(ball().sum(axis=1) / 3.0, np.ones(3)))),
    Case("a tree on a line", lambda: cloud(line(MANY)), settings=TREE, steps=8, bars={"angular_momentum": 1e-4}),
    Case(
        "a tree in a plane", lambda: cloud(ball(MANY) * [1.0, 1.0, 0.0]), settings=TREE, steps=8,
        bars={"angular_momentum": 1e-4},
    ),
    Case(
        "a tree of points of four", lambda: cloud(_in_one_place(4, MANY)), settings=TREE, steps=8,
        bars={"angular_momentum": 1e-4},
    ),
    Case("a thin disc", lambda: cloud(ball() * [1.0, 1.0, 1e-3])),
    Case("a thin disc that turns", lambda: cloud(ball() * [1.0, 1.0, 1e-3], turning(ball() * [1.0, 1.0, 0.0], 1.0))),
    Case("a needle", lambda: cloud(ball() * [1e-3, 1e-3, 1.0])),
    Case(
        "a needle end over end",
        lambda: cloud(ball() * [1e-3, 1e-3, 1.0], turning(ball() * [0.0, 0.0, 1.0], 1.0, (1.0, 0.0, 0.0))),
    ),
    Case("one particle far away", lambda: cloud(_with(ball(), (1e4, 0.0, 0.0)))),
    Case("no neighbours near", lambda: cloud(1e3 * ball()), until=1e3),
    Case("two clumps 1e6 apart", lambda: two(1e6, 0.0)),
    Case(
        "a density contrast of 1e12",
        lambda: cloud(np.concatenate([ball(32, 1, 1e-4), ball(32, 2)]), 0.0, np.repeat([1e4, 0.1], 32)), steps=400,
    ),
    Case("a mass ratio of 1e8", lambda: cloud(ball(), mass=np.where(every_other(), 1.0, 1e-8)), steps=300),
    Case("one particle of 1e-8", lambda: cloud(ball(), mass=np.where(first(), 1e-8, 1.0))),
    Case(
        "one particle of 1e8", lambda: cloud(ball(), mass=np.where(first(), 1.0, 1e-8)), stable=FEW,
        ends="no smoothing length is long enough",
    ),
    Case(
        "three equal moments throughout", lambda: cloud(lattice()),
        stable=KEPT + "; the axes are reported as undefined", bars={"gap": 1e-10},
        finding=lambda body, before, after: {"gap": _gap(after)},
    ),
    Case(
        "two equal moments throughout", lambda: cloud(lattice() * [1.0, 1.0, 0.5], turning(lattice(), 0.5)),
        bars={"gap": 1e-10}, finding=lambda body, before, after: {"gap": _gap(after)},
    ),
    Case("the longest smoothing lengths", lambda: cloud(ball()), settings=("numerics.eta=1.6",)),
    Case("the shortest smoothing lengths", lambda: cloud(ball()), settings=("numerics.eta=0.9",)),
)  # fmt: skip


def _gap(record) -> float:
    """The smallest difference of principal moments over the largest moment."""
    moments = np.linalg.eigvalsh(record["inertia_tensor"])
    return float(np.diff(moments).min() / moments[-1])
