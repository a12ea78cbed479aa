"""Neutron stars where solvers break: Buchdahl's limit, vanishing gravity, jumps, extreme gammas, edges of tables."""

import math

import numpy as np
import pytest

from astroinertia.bodies.neutron_stars import maximum_mass, star, star_of_mass
from astroinertia.bodies.polytrope import lane_emden
from astroinertia.bodies.tov import structure
from astroinertia.errors import NumericalError
from astroinertia.matter.compact_stars import (
    Barotrope,
    PowerLaw,
    constant_density,
    piecewise_polytrope,
    polytrope,
    read2009,
)

PROPERTIES = ("mass", "radius", "rest_mass", "moment_ratio", "tidal_love_number", "quadrupole_bar")


def agree(one, other, accuracy):
    for name in PROPERTIES:
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=accuracy), name


@pytest.mark.parametrize("below", [1e-2, 1e-4, 1e-6, 1e-8])
def test_up_to_buchdahls_limit(below):
    """Constant density with C -> 4/9: the pressure diverges, the star does not, and nothing of it jumps.

    The dragging at the centre becomes total, and Q M/J^2 comes within 2.2% of Kerr's 1 (Chandrasekhar & Miller 1974).
    """
    C = 4 / 9 * (1 - below)
    root = math.sqrt(1 - 2 * C)
    excess = 16 / 9 * below / (1 + 3 * root) * 9 / 2  # 3 root - 1 = (8 - 18 C)/(3 root + 1) without cancellation
    body = star(constant_density(1.0), central_enthalpy=(1 - root) / excess)
    assert body.compactness == pytest.approx(C, rel=1e-11)
    assert body.radius == pytest.approx(math.sqrt(3 * C / (4 * math.pi)), rel=1e-11)
    agree(body, star(constant_density(1.0), central_enthalpy=(1 - root) / excess, tolerance=3e-14), 2e-9)
    assert 0.6 < body.moment_ratio < 0.7993
    assert 1.0212 < body.quadrupole_bar < 1.06
    assert 0 < 1 - body.rotation.central_dragging < 0.1
    assert not body.causal
    if below < 1e-5:
        assert body.moment_ratio == pytest.approx(0.79917, abs=2e-5)
        assert body.rotation.central_dragging == pytest.approx(1, abs=1e-4)


@pytest.mark.parametrize("eta", [1e-4, 1e-8, 1e-12, 1e-16])
def test_no_gravity_to_speak_of(eta):
    """C from 1e-4 to 1e-16: the printed formulas for k2 and Q lose every digit, these must not."""
    equation = polytrope(1.0, 2.0)
    body = star(equation, central_enthalpy=eta)
    newton = star(equation, central_enthalpy=eta, relativistic=False)
    C = body.compactness
    assert body.moment_ratio == pytest.approx(lane_emden(1.0).moment_ratio, rel=3 * C + 1e-10)
    assert body.tidal_love_number == pytest.approx((15 / math.pi**2 - 1) / 2, rel=10 * C + 1e-10)
    assert body.rotation.quadrupole == pytest.approx(newton.rotation.quadrupole, rel=10 * C + 1e-10)
    assert body.mass == pytest.approx(newton.mass, rel=10 * C + 1e-10)
    assert body.quadrupole_bar * C == pytest.approx(
        newton.rotation.quadrupole / newton.moment_ratio**2, rel=20 * C + 1e-10
    )


@pytest.mark.full
def test_close_to_the_heaviest_star():
    """Masses within 1e-10 of the maximum have their star on the stable side; above it there is none."""
    for equation in (polytrope(100.0, 2.0), read2009("SLy")):
        top = maximum_mass(equation)
        for gap in (1e-6, 1e-8, 1e-10):
            body = star_of_mass(equation, top.mass * (1 - gap))
            assert body.mass == pytest.approx(top.mass * (1 - gap), rel=3e-11)
            away = 1 - body.structure.central_log_enthalpy / top.structure.central_log_enthalpy
            assert 0 < away < 5 * math.sqrt(gap)
        with pytest.raises(ValueError, match="stable stars have"):
            star_of_mass(equation, top.mass * (1 + 1e-9))


@pytest.mark.parametrize("jump", [1.0 + 1e-9, 1.2, 2.0])
def test_centres_beside_a_jump(jump):
    """Just above a jump the dense core is tiny: the star tends to the one just below, with the cube of the core.

    A density jump above 3/2 (1 + P/e) makes the mass fall there at once (Seidov 1971, Sov. Astron. 15, 347).
    """
    equation = piecewise_polytrope(60.0, [2.0, 2.5], [5e-4], jumps=[jump])
    edge = equation.edges[1]
    at = star(equation, central_enthalpy=edge)
    previous = math.inf
    for above in (1e-3, 1e-6, 1e-9, 1e-13):
        body = star(equation, central_enthalpy=edge * (1 + above))
        difference = max(abs(getattr(body, name) / getattr(at, name) - 1) for name in PROPERTIES)
        assert difference < 8 * above + 3e-11
        assert difference < previous + 3e-11
        previous = difference
    pressure, energy = float(equation.pressure(edge)), float(equation.energy_density(edge))
    up = structure(equation, edge * (1 + 1e-5)).mass / at.mass - 1
    assert (up < 0) == (jump > 1.5 * (1 + pressure / energy))


def test_many_jumps():
    """Thirty jumps of density, each met exactly: the tolerance alone decides, as for a smooth star."""
    densities = np.geomspace(1e-5, 1e-3, 30)
    equation = piecewise_polytrope(90.0, [2.0] * 31, densities.tolist(), jumps=[1.02] * 30)
    best = star(equation, central_rest_density=2.5e-3, tolerance=3e-14)
    agree(star(equation, central_rest_density=2.5e-3), best, 1e-10)
    agree(star(equation, central_rest_density=2.5e-3, tolerance=1e-7), best, 1e-5)


@pytest.mark.parametrize("gamma", [1.22, 4 / 3, 5.0, 50.0, 1e6])
def test_soft_and_stiff(gamma):
    """From n = 4.5 (R is 100 scale lengths, k2 below 1e-3) to all but incompressible, where the surface is a cliff."""
    equation = polytrope(1.0, gamma)
    eta = 1e-4 if gamma < 2 else 0.1
    body = star(equation, central_enthalpy=eta)
    agree(body, star(equation, central_enthalpy=eta, tolerance=3e-14), 1e-8)
    if gamma == 1e6:
        rigid = star(constant_density(float(equation.rest_density(eta))), central_enthalpy=eta)
        agree(body, rigid, 1e-4)
    newton = star(equation, central_enthalpy=eta, relativistic=False)
    assert newton.moment_ratio == pytest.approx(lane_emden(1 / (gamma - 1)).moment_ratio, rel=2e-9)


@pytest.mark.parametrize(("gamma", "eta", "relativistic"), [(1.2, 1e-3, False), (1.2, 1e-3, True), (1.1, 0.1, True),
                                                            (1.1, 1e-9, False), (1.21, 2.0, True)])  # fmt: skip
def test_stars_without_a_surface_are_refused(gamma, eta, relativistic):
    """n = 5 and above have none, and relativity takes it from somewhat stiffer ones (Nilsson & Uggla 2000)."""
    with pytest.raises(NumericalError, match="no surface that can be found"):
        star(polytrope(1.0, gamma), central_enthalpy=eta, relativistic=relativistic)


@pytest.mark.full
def test_beyond_the_stable_stars():
    """Central eta of 100 to 1e6: the relativistic spiral to a finite mass and radius (Harrison et al. 1965, ch. 5)."""
    equation = polytrope(100.0, 2.0)
    stars = [star(equation, central_enthalpy=eta) for eta in (1e2, 1e4, 1e6)]
    masses = np.array([one.mass for one in stars])
    assert np.all(np.isfinite(masses)) and np.ptp(masses) < 0.05 * masses[0]
    assert abs(masses[2] - masses[1]) < 0.1 * abs(masses[1] - masses[0])
    for one in stars:
        agree(
            one, star(equation, central_enthalpy=math.expm1(one.structure.central_log_enthalpy), tolerance=1e-13), 1e-8
        )


def test_edges_of_what_is_given():
    """The last enthalpy itself is inside, one rounding further is refused; nothing is extrapolated."""
    table = Barotrope("short", (0.0, 0.25), (PowerLaw(1e-3, 0.25, 0.0, 1.0),))
    assert star(table, central_enthalpy=0.25).mass > 0
    with pytest.raises(ValueError, match=r"lies outside 0 to 0\.25"):
        star(table, central_enthalpy=math.nextafter(0.25, 1))
    with pytest.raises(ValueError, match="above the largest that it covers"):
        star(table, central_rest_density=1.001e-3)
    with pytest.raises(ValueError, match="positive and finite"):
        star(table, central_enthalpy=math.inf)
    with pytest.raises(ValueError, match="positive and finite"):
        star(table, central_enthalpy=0.0)
