"""Error against time of Clairaut's equation in layered bodies and of planets in hydrostatic equilibrium.

python tests/benchmarks/work_precision_layered.py --keep
"""

import math

import numpy as np
from precision_table import publish, table
from scipy.special import spherical_jn

from astroinertia.bodies.clairaut import DEFAULT_STEPS as CLAIRAUT_STEPS, love_number
from astroinertia.bodies.earth import prem
from astroinertia.bodies.hydrostatic import DEFAULT_STEPS as PLANET_STEPS, planet_from_masses
from astroinertia.bodies.layered import linear_layers, polynomial_layers
from astroinertia.matter.planetary import IRON_HCP, PEROVSKITE, Murnaghan

G, EARTH_MASS = 6.6743e-11, 5.9722e24


def of_clairaut() -> list[str]:
    """Love numbers by steps a layer: exact for n = 1; against 64 steps elsewhere."""
    series = np.zeros(29)
    series[::2] = [(-1) ** k * math.pi ** (2 * k) / math.factorial(2 * k + 1) for k in range(15)]
    sine = polynomial_layers([1.0], [series])
    slope = math.pi * spherical_jn(8, math.pi, derivative=True) / spherical_jn(8, math.pi)
    steep = linear_layers([0.05, 1.0], [100.0, 1.0], [90.0, 0.1])
    cases = [
        ("k_2 of the polytrope n = 1 (exact)", sine, 2, 15 / math.pi**2 - 1),
        ("k_8 of the polytrope n = 1 (exact)", sine, 8, (8 - slope) / (9 + slope)),
        ("k_2 of PREM (against 64 steps)", prem(), 2, float(love_number(prem(), 2, 64))),
        ("k_2 of a dense core under a steep mantle (against 64 steps)", steep, 2, float(love_number(steep, 2, 64))),
        ("k_8 of the same", steep, 8, float(love_number(steep, 8, 64))),
    ]
    return [
        table(
            title,
            "steps a layer",
            (1, 2, 4, CLAIRAUT_STEPS, 8, 16),
            lambda steps, body=body, degree=degree: float(love_number(body, degree, steps)),
            lambda found, exact=exact: abs(found / exact - 1),
            CLAIRAUT_STEPS,
        )
        for title, body, degree, exact in cases
    ]


def of_planets() -> list[str]:
    """The moment of inertia by steps a layer: a closed form, and an Earth against 16 steps."""
    rho_0, modulus, x = 3000.0, 2e11, 1.3
    k = math.sqrt(4 * math.pi * G * rho_0**2 / modulus)
    central = rho_0 * x / math.sin(x)
    mass = 4 * math.pi * central / k**3 * (math.sin(x) - x * math.cos(x))
    moment = 8 * math.pi / 3 * central / k**5 * ((3 * x**2 - 6) * math.sin(x) - (x**3 - 6 * x) * math.cos(x))

    def earth(steps):
        masses = [0.325 * EARTH_MASS, 0.675 * EARTH_MASS]
        return planet_from_masses(masses, [IRON_HCP, PEROVSKITE], gravitational_constant=G, steps=steps)

    def exact(steps):
        return planet_from_masses([mass], [Murnaghan(rho_0, modulus, 2.0)], gravitational_constant=G, steps=steps)

    settled = earth(16)
    core, love = float(settled.moment_ratio), float(love_number(settled.layered()))
    settings = (1, 2, 4, PLANET_STEPS, 8)
    return [
        table("I of a planet of one Murnaghan material, K' = 2 (exact)", "steps a layer", settings, exact,
              lambda found: abs(float(found.mean_moment) / moment - 1), PLANET_STEPS),
        table("I/(M R^2) of an Earth of iron and perovskite (against 16 steps)", "steps a layer", settings, earth,
              lambda found: abs(float(found.moment_ratio) / core - 1), PLANET_STEPS),
        table("k_2 of the same by its layered body (against 16 steps)", "steps a layer", settings, earth,
              lambda found: abs(float(love_number(found.layered())) / love - 1), PLANET_STEPS),
    ]  # fmt: skip


if __name__ == "__main__":
    publish("layered", of_clairaut() + of_planets())
