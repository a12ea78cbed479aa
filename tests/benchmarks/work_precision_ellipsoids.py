"""Error against time of the homogeneous ellipsoids: the step of the sums over ln u is their one knob."""

import mpmath
from precision_table import publish, table

from astroinertia.bodies import darwin, ellipsoid_gravity, jacobi, roche

STEPS = (2.0, 1.5, 1.0, 0.75, 0.5, 0.375, 0.25)
DEFAULT = ellipsoid_gravity._LOG_STEP


def symbol(axes):
    """B_13 in thirty digits."""
    with mpmath.workdps(40):
        a, b, c = (mpmath.mpf(axis) ** 2 for axis in axes)
        first, third = (
            mpmath.sqrt(a * b * c) * 2 / 3 * mpmath.elliprd(*others, one) for others, one in (((b, c), a), ((a, b), c))
        )
        return float((a * first - c * third) / (a - c))


def at_step(action):
    """The action with a given step; nothing is remembered from an earlier one."""

    def run(step):
        ellipsoid_gravity._LOG_STEP = step
        for cache in (jacobi._unit, roche._limit, darwin._axes_squared):
            cache.cache_clear()
        return action()

    return run


def one_symbol(axes):
    exact, squares = symbol(axes), [axis**2 for axis in axes]
    return table(
        f"B_13 of axes {axes}, against thirty digits",
        "step of ln u",
        STEPS,
        at_step(lambda: ellipsoid_gravity.index_integral(squares, (0, 2), 1)),
        lambda value: abs(float(value) / exact - 1),
        DEFAULT,
    )


def figure(name, action, exact):
    return table(name, "step of ln u", STEPS, at_step(action), lambda body: abs(body.omega2 / exact - 1), DEFAULT)


finest = at_step(darwin.contact)(0.2)

# Independent values of fifteen and of thirteen digits: tests/reference/ellipsoids.json
publish(
    "ellipsoids",
    [
        one_symbol((1.0, 1.0, 0.999)),
        one_symbol((1.0, 0.5, 1e-4)),
        figure("Jacobi ellipsoid of b/a = 0.5, Omega^2", lambda: jacobi.from_axis_ratio(0.5), 0.309557013747839),
        figure("Roche limit of p = 0, Omega^2", lambda: roche.limit(0.0), 0.09009299712128),
        figure("Darwin ellipsoids in contact, Omega^2, against a step of 0.2", darwin.contact, finest.omega2),
    ],
)
