"""Gravity by this code and by others, behind one face: a setting and a set of points in, accelerations (N, 3) out.

Each code is judged against a direct sum with its own softening, so that only its method's error shows. Peers come with
`pip install .[bench]`; one that is not there is left out, in so many words.
"""

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from point_sets import PointSet

from astroinertia.sph.kernels import KERNELS, Kernel

KERNEL = "cubic"  # the one softening that pytreegrav knows, too
SUPPORT = KERNELS[KERNEL].support
REBOUND_SOFTENING = 0.01  # Plummer's, one for all points: REBOUND has no other


@dataclass(frozen=True)
class Code:
    """One way to find accelerations.

    settings: knobs from coarse to fine. action(points, setting) prepares a call that does all the work of one
    evaluation and returns accelerations (N, 3) in the order of the points; reference(points, sample) is the direct sum
    for the points of those indices. most: points beyond which it takes too long for a comparison.
    """

    name: str
    package: str
    settings: tuple[Any, ...]
    action: Callable[[PointSet, Any], Callable[[], np.ndarray]]
    reference: Callable[[PointSet, np.ndarray], np.ndarray]
    most: int = 10**8

    @property
    def present(self) -> bool:
        """Whether its package is installed."""
        return importlib.util.find_spec(self.package) is not None


def present(codes: tuple[Code, ...]) -> list[Code]:
    """Those that are installed; says which are not."""
    for code in codes:
        if not code.present:
            print(f"{code.name} is left out: {code.package} is not installed (pip install '.[bench]').\n")
    return [code for code in codes if code.present]


@njit(error_model="numpy")
def far_and_near(
    position: np.ndarray, mass: np.ndarray, reach: np.ndarray, sample: np.ndarray, softening: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Accelerations (n, 3) by all points out of reach of both, and the rows and columns of the pairs within reach."""
    total, count = np.zeros((len(sample), 3)), 0
    rows, columns = np.empty(1024, np.int64), np.empty(1024, np.int64)
    for row in range(len(sample)):
        i = sample[row]
        x, y, z, own = position[i, 0], position[i, 1], position[i, 2], reach[i]
        for j in range(len(mass)):
            a, b, c = position[j, 0] - x, position[j, 1] - y, position[j, 2] - z
            square = a * a + b * b + c * c
            if square < max(own, reach[j]) ** 2:
                if count == len(rows):
                    rows, columns = np.concatenate((rows, rows)), np.concatenate((columns, columns))
                rows[count], columns[count] = row, j
                count += 1
            elif j != i:
                square += softening * softening
                pull = mass[j] / (square * np.sqrt(square))
                total[row, 0] += pull * a
                total[row, 1] += pull * b
                total[row, 2] += pull * c
    return total, rows[:count], columns[:count]


def kernel_softened(points: PointSet, sample: np.ndarray, kernel: Kernel = KERNELS[KERNEL]) -> np.ndarray:
    """Direct sum with the mean of both points' kernels, as this code softens (Price & Monaghan 2007, eq. 24)."""
    h = points.smoothing_length
    total, rows, columns = far_and_near(points.position, points.mass, kernel.support * h, sample, 0.0)
    apart = points.position[columns] - points.position[sample[rows]]
    r, own, other = np.linalg.norm(apart, axis=1), h[sample[rows]], h[columns]
    slope = 0.5 * (kernel.dphi(np, r / own) / own**2 + kernel.dphi(np, r / other) / other**2)
    np.add.at(total, rows, (points.mass[columns] * slope / np.where(r > 0.0, r, 1.0))[:, None] * apart)
    return total


def direct_sum(points: PointSet, setting: str) -> Callable[[], np.ndarray]:
    """This code's sum over all pairs, in the precision of `setting`."""
    from astroinertia.engines.numba_cpu import Engine
    from astroinertia.gravity.direct import DIRECT_GRAVITY

    engine = Engine(precision=setting)
    order, arrangement = engine.arrange(points.position, points.smoothing_length)
    fields = {
        "mass": points.mass[order],
        "position": points.position[order],
        "smoothing_length": points.smoothing_length[order],
    }
    back = np.argsort(order)

    def act() -> np.ndarray:
        sums = engine.all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), fields)
        return sums["gravity"]["acceleration"][back]

    return act


def multipole_sum(points: PointSet, setting: float, precision: str = "mixed") -> Callable[[], np.ndarray]:
    """This code's multipoles at a wanted error, tree included, with the strengths that the last step would give."""
    from astroinertia.engines.threads import available_threads
    from astroinertia.gravity import multipole

    def act(strength: np.ndarray | None) -> np.ndarray:
        return multipole.gravity(
            points.mass, points.position, points.smoothing_length, KERNEL, setting, strength,
            available_threads(), precision=precision,
        )[0]  # fmt: skip

    strength = np.linalg.norm(act(None), axis=1)
    return lambda: act(strength)


def pytreegrav_action(quadrupole: bool) -> Callable[[PointSet, Any], Callable[[], np.ndarray]]:
    """pytreegrav's tree, its building included, at the opening angle of the setting."""

    def prepare(points: PointSet, setting: float) -> Callable[[], np.ndarray]:
        from pytreegrav import Accel

        reach = SUPPORT * points.smoothing_length
        return lambda: Accel(
            points.position, points.mass, reach, theta=setting, quadrupole=quadrupole, parallel=True, method="tree"
        )

    return prepare


def pytreegrav_direct(points: PointSet, sample: np.ndarray) -> np.ndarray:
    """pytreegrav's own sum over all pairs."""
    from pytreegrav import AccelTarget

    reach = SUPPORT * points.smoothing_length
    return AccelTarget(
        points.position[sample], points.position, points.mass, reach[sample], reach, method="bruteforce", parallel=True
    )


def rebound_action(gravity: str) -> Callable[[PointSet, Any], Callable[[], np.ndarray]]:
    """One step of REBOUND's leapfrog, too short to move anything: its tree is built and walked once, on one thread."""

    def prepare(points: PointSet, setting: float) -> Callable[[], np.ndarray]:
        import rebound

        simulation = rebound.Simulation()
        simulation.integrator, simulation.dt, simulation.softening = "leapfrog", 1e-30, REBOUND_SOFTENING
        simulation.root_size = 2.1 * float(np.abs(points.position).max())
        simulation.gravity = gravity
        if gravity == "tree":
            simulation.opening_angle2 = setting**2
        for mass, (x, y, z) in zip(points.mass, points.position, strict=True):
            simulation.add(m=mass, x=x, y=y, z=z)

        def act() -> np.ndarray:
            simulation.steps(1)
            # Seen in place, since copying out of Python objects would take longer than the sum.
            return _rebound_view(simulation)

        return act

    return prepare


def _rebound_view(simulation: Any) -> np.ndarray:
    import ctypes

    import rebound

    size = ctypes.sizeof(rebound.Particle) // 8
    raw = np.ctypeslib.as_array(
        ctypes.cast(ctypes.addressof(simulation.particles[0]), ctypes.POINTER(ctypes.c_double)), (simulation.N, size)
    )
    return raw[:, 6:9]


def plummer_softened(points: PointSet, sample: np.ndarray) -> np.ndarray:
    """Direct sum with REBOUND's softening."""
    return far_and_near(points.position, points.mass, np.zeros_like(points.mass), sample, REBOUND_SOFTENING)[0]


def jaxfmm_action(points: PointSet, setting: tuple[int, float]) -> Callable[[], np.ndarray]:
    """jaxFMM at (order, opening angle) in float64, its lists made beforehand, as it is meant to be used; unsoftened."""
    import jax
    import jaxfmm

    with jax.enable_x64(True):
        order, theta = setting
        position, mass = jax.numpy.asarray(points.position), jax.numpy.asarray(points.mass)
        evaluate = jaxfmm.plan(position, err_tol=1e-3, field=True, verbose=False, verify=False, p=order, theta=theta)

    def act() -> np.ndarray:
        with jax.enable_x64(True):
            # Its field is that of charges: repelling, over 4 pi.
            return -4.0 * np.pi * np.asarray(jax.block_until_ready(evaluate(mass)))

    return act


def unsoftened(points: PointSet, sample: np.ndarray) -> np.ndarray:
    """Direct sum of point masses."""
    return far_and_near(points.position, points.mass, np.zeros_like(points.mass), sample, 0.0)[0]


ANGLES = (1.0, 0.7, 0.5, 0.35, 0.25)
OURS = Code(
    "astroinertia", "astroinertia", (3e-3, 1e-3, 6e-4, 3e-4, 2e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6), multipole_sum,
    kernel_softened,
)  # fmt: skip
DIRECT = Code("astroinertia direct", "astroinertia", ("mixed", "float64"), direct_sum, kernel_softened, 200_000)
MONOPOLE = Code("pytreegrav monopole", "pytreegrav", ANGLES, pytreegrav_action(False), pytreegrav_direct)
QUADRUPOLE = Code("pytreegrav quadrupole", "pytreegrav", ANGLES, pytreegrav_action(True), pytreegrav_direct)
REBOUND_TREE = Code("REBOUND tree", "rebound", ANGLES[:-1], rebound_action("tree"), plummer_softened, 200_000)
REBOUND_DIRECT = Code("REBOUND direct", "rebound", (0.0,), rebound_action("basic"), plummer_softened, 20_000)
JAXFMM = Code("jaxFMM", "jaxfmm", ((3, 0.85), (5, 0.7), (7, 0.6)), jaxfmm_action, unsoftened, 200_000)
CODES = (OURS, DIRECT, MONOPOLE, QUADRUPOLE, REBOUND_TREE, REBOUND_DIRECT, JAXFMM)
