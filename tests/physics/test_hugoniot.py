"""Rock and iron that collide: states behind the shock lie on the Hugoniot curve of their equation of state.

Two streams of matter at its reference density, without pressure or heat, meet at x = 0, each with speed v. Conservation
of mass, momentum and energy across the shock (Melosh 1989, Impact Cratering, section 3.4) leaves P = v^2 rho rho_0/(rho
- rho_0) and E = v^2/2; with Tillotson's P(rho, E) that is one equation for rho. The particles know of P(rho, E) only by
their table of isentropes, and of the shock only by the heat that viscosity makes.
"""

from types import SimpleNamespace

import jax
import numpy as np
import pytest
from scipy.optimize import root_scalar

from astroinertia.effects import catalogue
from astroinertia.engines import numba_cpu, periodic
from astroinertia.matter import isentropes, tillotson
from astroinertia.models.sph.first_state import initial_state
from astroinertia.models.sph.sorting import rearranged
from astroinertia.models.sph.state import Problem
from astroinertia.models.sph.step import step
from astroinertia.sph.kernels import KERNELS
from astroinertia.test_problems.matter import filled

MATTER = {"iron": tillotson.IRON, "basalt": tillotson.BASALT}
DENSITY, ENERGY = 1e3, 1e6  # units: kg/m3 and J/kg, hence km/s and GPa
ACROSS = 3  # unit cells of the lattice
KERNEL = "wendland_c2"


def hugoniot(matter: tillotson.Tillotson, speed: float) -> SimpleNamespace:
    """Density, pressure and energy behind the shock that stops matter of that speed, and its way from the plane."""
    start, energy = float(matter.reference_density), 0.5 * speed**2 * ENERGY

    def excess(density: float) -> float:
        jump = speed**2 * ENERGY * density * start / (density - start)
        return float(matter.pressure_at(np.array(density), np.array(energy))) - jump

    with jax.enable_x64(True):
        density = root_scalar(excess, bracket=(1.01 * start, 8.0 * start), xtol=1e-12 * start).root
    pressure = speed**2 * ENERGY * density * start / (density - start)
    return SimpleNamespace(
        density=density / DENSITY,
        pressure=pressure / DENSITY / ENERGY,
        energy=energy / ENERGY,
        front=speed * start / (density - start),
    )


def collide(name: str, speed: float, along: int) -> SimpleNamespace:
    """Means over the middle half of what is between the plane and the shock when that has come a third of the way."""
    matter, exact = MATTER[name], hugoniot(MATTER[name], speed)
    lengths = np.array([2.0 * along, ACROSS, ACROSS])
    position = filled((2 * along, ACROSS, ACROSS), -0.5 * lengths, 0.5 * lengths)
    velocity = np.zeros_like(position)
    velocity[:, 0] = -speed * np.sign(position[:, 0])
    reference = float(matter.reference_density)
    table = isentropes.isentropes(
        name,
        matter.fluid_pressure_at,
        reference,
        matter.incipient_vaporisation,
        (1e-5 * reference, 30 * reference),
        1e9,
    )
    problem = Problem(
        effects=tuple(catalogue.build(kind, {}) for kind in ("pressure", "viscosity", "conduction")),
        equation_of_state=isentropes.tabulated([table], DENSITY, ENERGY).of(0.0),
        eta=1.3,
        courant=0.3,
        acceleration_factor=0.3,
        energy_factor=0.3,
        max_timestep=1.0,
        engine=periodic.Engine(numba_cpu.Engine(), tuple(lengths), KERNELS[KERNEL].support),
        kernel=KERNEL,
        smoothing_tolerance=1e-4,
    )
    mass = np.full(len(position), reference / DENSITY * np.prod(lengths) / len(position))
    state, arrangement = initial_state(problem, mass, position, velocity, np.zeros(len(position)))
    end = along / 3.0 / exact.front
    while float(state.time) < end * (1 - 1e-12):
        if int(state.step) % 16 == 0:
            state, arrangement = rearranged(problem, state)
        dt = min(float(state.rates.timestep), end - float(state.time))
        state = step(problem, arrangement, state, np.float64(dt))
    fluid = state.rates.fluid
    place = np.abs(fluid.position[:, 0]) / (exact.front * end)
    inside = (place > 0.25) & (place < 0.75)
    return SimpleNamespace(
        density=fluid.density[inside].mean() / exact.density,
        pressure=fluid.pressure[inside].mean() / exact.pressure,
        energy=fluid.internal_energy[inside].mean() / exact.energy,
        speed=np.abs(fluid.velocity[inside, 0]).mean() / speed,
    )


@pytest.mark.full
@pytest.mark.parametrize(("name", "speed"), [("iron", 1.0), ("iron", 3.0), ("basalt", 5.0)])
def test_states_behind_a_shock_lie_on_the_hugoniot_curve(name: str, speed: float) -> None:
    """From 43 to 198 GPa. With 8, 16 and 32 unit cells to the end of the stream iron at 3 km/s is off by +0.4, -1.5 and
    -0.5 % in density, +3.3, -4.9 and -0.4 % in pressure, +4.3, -3.1 and +2.1 % in energy, with what is left of the
    layers' motion falling from 12 to 8 and 4 % of the speed; with 16 the others are off by no more than 2.1, 4.6 and
    1.4 %, but that iron at 1 km/s, whose shock is weak, still rings with 17 %.
    """
    found = collide(name, speed, 16)
    assert abs(found.density - 1.0) < 0.03, found
    assert abs(found.pressure - 1.0) < 0.07, found
    assert abs(found.energy - 1.0) < 0.05, found
    assert found.speed < 0.25, found


def test_the_curve_itself_is_that_of_an_ideal_gas_where_tillotson_is_one() -> None:
    """With a alone P = a rho E: a strong shock compresses by (a + 2)/a whatever the speed, as gamma = 1 + a says."""
    gas = tillotson.Tillotson(1000.0, 0.5, 0.0, 0.0, 0.0, 1e7, 1e12, 2e12, 5.0, 5.0)
    found = hugoniot(gas, 3.0)
    assert found.density == pytest.approx(5.0, rel=1e-9)
    assert found.pressure == pytest.approx(0.5 * 5.0 * 4.5, rel=1e-9)  # a rho E
