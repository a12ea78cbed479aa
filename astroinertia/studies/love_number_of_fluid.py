"""Love numbers measured on particles: how far does a static tide draw out a polytrope of so many of them?

A tide of the potential mu (-2 x^2 + y^2 + z^2)/2 gives the body moments with Q_xx - (Q_yy + Q_zz)/2 = k2 mu R^5, G = 1,
for its own field at degree 2 is k2 (R/r)^5 times that of the tide. The particles are settled in the tide and in one of
the opposite sign, from the same start: half the difference is free of the quadrupole that they have by chance, and of
what the tide does to second order. Everything is in units of the body's mass and its radius at rest.
Tests: tests/physics/test_fluid_tides.py.
"""

from dataclasses import replace

import numpy as np
import xarray as xr

from astroinertia.bodies.apsidal import love_number
from astroinertia.effects import catalogue
from astroinertia.models.sph import relaxation
from astroinertia.studies.relax import polytrope_problem, relaxed_polytrope

_AT_REST = 5e-4  # net acceleration over gravity, in which the star alone is settled
_OF_TIDE = 0.01  # the same in the tide, over mu: what is left of the tide unbalanced
_MOST_STEPS = 6000


def love_number_of_fluid(
    index: float, particles: int, tide: float = 0.01, kernel: str = "wendland_c2", seed: int = 1
) -> xr.Dataset:
    """Return k2 of a polytrope of so many particles, `love_number`, with its exact value as an attribute.

    second_moment (sign, i, j) is that in the tides +mu and -mu; moment_of_inertia_ratio is I over that of the exact
    body at rest, which tells how much smaller the particles' body is: k2 goes as R^5. NumericalError where the body
    does not settle.
    """
    tolerances = relaxation.Tolerances(residual=_AT_REST, density_error=np.inf)
    options = {"kernel": kernel, "order": "second", "seed": seed}  # fourth order is stiff against a tide
    star = relaxed_polytrope(index, particles, tolerances=tolerances, max_steps=_MOST_STEPS, **options)
    alone = polytrope_problem(index, particles, kernel)
    mass, moments = star.mass.values, []
    for sign in (1.0, -1.0):
        matrix = (np.diag([-2.0, 1.0, 1.0]) * sign * tide).tolist()
        field = catalogue.build("external_field", {"quadratic": matrix})
        settled = relaxation.relax(
            replace(alone, effects=(*alone.effects, field)),
            mass,
            star.position.values,
            star.entropy.values,
            tolerances=relaxation.Tolerances(residual=_OF_TIDE * tide, density_error=np.inf, virial=np.inf),
            max_steps=_MOST_STEPS,
        )
        position = settled.position - mass @ settled.position / mass.sum()
        moments.append((mass[:, None] * position).T @ position)
    stretch = [q[0, 0] - (q[1, 1] + q[2, 2]) / 2 for q in moments]
    inertia = star.moment_of_inertia
    return xr.Dataset(
        {
            "love_number": ((), (stretch[0] - stretch[1]) / (2 * tide), {"exact": love_number(index)}),
            "second_moment": (("sign", "i", "j"), np.array(moments)),
            "moment_of_inertia_ratio": float(np.trace(inertia.values)) / 3 / inertia.attrs["exact_at_rest"],
        },
        coords={"sign": [1.0, -1.0], "i": list("xyz"), "j": list("xyz")},
        attrs={
            "title": f"Love number of a polytrope of index {index:g}, of particles",
            "particles": particles, "tide": tide, "kernel": kernel, "seed": seed,
        },
    )  # fmt: skip
