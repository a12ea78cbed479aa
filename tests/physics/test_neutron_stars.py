"""Neutron stars against the textbook's equations integrated in another form, and against published stars and fits."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from astroinertia.bodies import neutron_star_fits as fits
from astroinertia.bodies.neutron_stars import maximum_mass, sequence, star, star_of_mass
from astroinertia.bodies.tov import structure
from astroinertia.matter.compact_stars import (
    constant_density,
    energy_polytrope,
    piecewise_polytrope,
    polytrope,
    read2009,
    read2009_table,
)


def textbook(constant: float, central_density: float) -> dict[str, float]:
    """A polytrope of gamma 2 by Hartle 1967, Hartle & Thorne 1968 and Hinderer 2008 as printed, in r, unscaled.

    Dragging as a second-order equation, tides as Hinderer's equation for y with the sound speed, the quadrupole in h_2
    and v_2 with the whole metric, the exterior in Legendre functions with their logarithms.
    """
    K = constant

    def matter(h):
        rho = max(math.expm1(h), 0.0) / (2 * K)
        return rho + K * rho**2, K * rho**2, rho

    def slopes(r, y, surface_nu, h_surface=0.0):
        m, h, drag, ddrag, tide, h_free, v_free, h_2, v_2, _ = y
        e, P, rho = matter(h)
        f = 1 - 2 * m / r
        dnu = 2 * (m + 4 * math.pi * r**3 * P) / (r**2 * f)
        nu = surface_nu - 2 * (h - h_surface)
        j2 = math.exp(-nu) * f
        dj2 = -8 * math.pi * r * (e + P) / f * j2
        dj_over_j = dj2 / (2 * j2)
        sound = 2 * P / (e + P) if P > 0 else 0.0
        stiff = (e + P) / sound if P > 0 else 1 / (2 * K)  # de/dh at the surface: (e + P)^2/(2P) -> 1/(2K)
        Q = 4 * math.pi / f * (5 * e + 9 * P + stiff) - 6 / (r**2 * f) - dnu**2
        on_h = -dnu + (8 * math.pi * (e + P) - 4 * m / r**3) / (f * dnu)
        drag_h = (dnu * r / 2 - 1 / (r * f * dnu)) * r**3 * j2 * ddrag**2 / 6
        drag_h -= (dnu * r / 2 + 1 / (r * f * dnu)) * r**2 * dj2 * drag**2 / 3
        drag_v = (1 / r + dnu / 2) * (-(r**3) * dj2 * drag**2 / 3 + j2 * r**4 * ddrag**2 / 6)
        return [
            4 * math.pi * r**2 * e,
            -dnu / 2,
            ddrag,
            -(4 / r + dj_over_j) * ddrag - 4 / r * dj_over_j * drag,
            -(tide**2 + tide / f * (1 + 4 * math.pi * r**2 * (P - e)) + r**2 * Q) / r,
            on_h * h_free - 4 * v_free / (r**2 * f * dnu),
            -dnu * h_free,
            on_h * h_2 - 4 * v_2 / (r**2 * f * dnu) + drag_h,
            -dnu * h_2 + drag_v,
            4 * math.pi * r**2 * rho / math.sqrt(f),
        ]

    def surface(r, y, *_):
        return y[1]

    surface.terminal = True
    h_c = math.log1p(2 * K * central_density)
    e, P, rho = matter(h_c)
    r = 1e-3
    start = [4 * math.pi / 3 * e * r**3, h_c - 2 * math.pi / 3 * (e + 3 * P) * r**2]
    start += [1.0, 16 * math.pi / 5 * (e + P) * r, 2.0, r**2, -2 * math.pi / 3 * (e + 3 * P) * r**4, 0.0, 0.0]
    start += [4 * math.pi / 3 * rho * r**3]
    nu = 0.0
    for _ in range(2):  # the second time with nu from the mass and radius of the first
        run = solve_ivp(slopes, (r, 100.0), start, "DOP853", events=surface, args=(nu,), rtol=3e-13, atol=1e-20)
        R, y = float(run.t[-1]), run.y[:, -1]
        nu = math.log(1 - 2 * y[0] / R)
    M, _, drag, ddrag, tide, h_free, v_free, h_2, v_2, rest = y.tolist()
    J = R**4 * ddrag / 6
    Omega = drag + 2 * J / R**3
    x = R / M - 1
    log = math.log((x + 1) / (x - 1))
    Q22 = 1.5 * (x**2 - 1) * log + (5 * x - 3 * x**3) / (x**2 - 1)
    Q21 = math.sqrt(x**2 - 1) * ((3 * x**2 - 2) / (x**2 - 1) - 1.5 * x * log)
    _, K_outside = np.linalg.solve(
        [[h_free, -Q22], [v_free, -2 * M / math.sqrt(R * (R - 2 * M)) * Q21]],
        [J**2 * (1 / (M * R**3) + 1 / R**4) - h_2, -(J**2) / R**4 - v_2],
    )
    C = M / R
    bracket = 2 - tide + 2 * C * (tide - 1)
    below = 2 * C * (6 - 3 * tide + 3 * C * (5 * tide - 8)) + 3 * (1 - 2 * C) ** 2 * bracket * math.log(1 - 2 * C)
    below += 4 * C**3 * (13 - 11 * tide + C * (3 * tide - 2) + 2 * C**2 * (1 + tide))
    return {
        "mass": M,
        "radius": R,
        "rest_mass": rest,
        "moment_of_inertia": J / Omega,
        "tidal_love_number": 8 / 5 * C**5 * (1 - 2 * C) ** 2 * bracket / below,
        "quadrupole_bar": (J**2 / M + 8 / 5 * K_outside * M**3) * M / J**2,
    }


@pytest.mark.parametrize("central_density", [4e-4, 1.28e-3, 6e-3])
def test_textbook_equations_give_the_same_star(central_density):
    body = star(polytrope(100.0, 2.0), central_rest_density=central_density)
    for name, value in textbook(100.0, central_density).items():
        accuracy = 1e-7 if name == "tidal_love_number" else 3e-9  # the printed formula for k2 cancels
        assert getattr(body, name) == pytest.approx(value, rel=accuracy), name


HINDERER = """0.7 0.1 0.1779, 0.7 0.15 0.1171, 0.7 0.2 0.0721, 1.0 0.1 0.122, 1.0 0.15 0.0776, 1.0 0.2 0.0459"""


@pytest.mark.parametrize("row", HINDERER.split(", "))
def test_love_numbers_of_hinderer(row):
    """Table 1 of the erratum of Hinderer 2008 (arXiv:0711.2420v4): P = K e^(1 + 1/n); the printed values hold to 1.5%.

    Its rows for n = 0.3 and 0.5 miss the Newtonian limits of stiff stars by more (0.5511 for 0.5532 at n = 0.3).
    """
    index, compactness, printed = map(float, row.split())
    equation = energy_polytrope(1.0, 1 + 1 / index)
    eta = brentq(lambda eta: structure(equation, eta).compactness - compactness, compactness / 2, 4 * compactness)
    assert star(equation, central_enthalpy=eta).tidal_love_number == pytest.approx(printed, rel=0.015)


@pytest.mark.full
def test_stars_of_read_2009():
    """Maximum masses and radii of 1.4 Msun for which Table III of Read et al. is quoted, with its error of each fit.

    SLy: 2.049 Msun (+0.02%) and 11.736 km (-0.21%) by the fit; H4 and MS1: 2.032, 13.774 and 2.767, 14.918 by the
    tables that were fitted (as quoted by Lackey & Wade 2015, PRD 91, 043002), which the fits match to about 1%.
    """
    sly = read2009("SLy")
    assert maximum_mass(sly).mass == pytest.approx(2.049 * 1.0002, rel=1e-3)
    assert star_of_mass(sly, 1.4).radius_km == pytest.approx(11.736 * 0.9979, rel=1e-3)
    for name, mass, radius in (("H4", 2.032, 13.774), ("MS1", 2.767, 14.918)):
        assert maximum_mass(read2009(name)).mass == pytest.approx(mass, rel=0.01)
        assert star_of_mass(read2009(name), 1.4).radius_km == pytest.approx(radius, rel=0.015)


@pytest.mark.full
def test_i_love_q():
    """Yagi & Yunes 2013: their fits hold to 1% for realistic equations of state from 1 Msun to the maximum mass."""
    for name in ("SLy", "APR4", "MPA1", "MS1", "H4", "ALF2"):
        equation = read2009(name)
        heaviest = maximum_mass(equation)
        for mass in (1.0, 1.4, 0.9 * heaviest.mass):
            body = star_of_mass(equation, mass)
            love, quadrupole = body.tidal_deformability, body.quadrupole_bar
            assert fits.moment_bar_of_love(love) == pytest.approx(body.moment_bar, rel=0.0101), (name, mass)
            assert fits.quadrupole_bar_of_love(love) == pytest.approx(quadrupole, rel=0.0101), (name, mass)
            assert fits.moment_bar_of_quadrupole(quadrupole) == pytest.approx(body.moment_bar, rel=0.0101), (name, mass)


@pytest.mark.full
def test_moments_of_inertia_of_the_fits():
    """Lattimer & Schutz and Breu & Rezzolla to their 3% for equations of state with maximum masses above 2 Msun."""
    for name in ("SLy", "APR4", "MPA1", "MS1"):
        for mass in (1.2, 1.4, 1.7):
            body = star_of_mass(read2009(name), mass)
            ratio, bar = body.moment_ratio, body.moment_bar
            assert fits.lattimer_schutz(body.mass, body.radius_km) == pytest.approx(ratio, rel=0.034), name
            assert fits.breu_rezzolla_moment_ratio(body.compactness) == pytest.approx(ratio, rel=0.034), name
            assert fits.breu_rezzolla_moment_bar(body.compactness) == pytest.approx(bar, rel=0.034), name


@pytest.mark.full
@pytest.mark.parametrize("every", [17, 1])
def test_every_equation_of_read_2009_has_its_stars(every):
    """Of all equations, or of two of them."""
    for name in list(read2009_table())[::every]:
        along = sequence(read2009(name), count=3)
        assert along.stable.all(), name
        mass, radius = along.column("mass"), along.column("radius_km")
        assert np.all(np.diff(mass) > 0) and 1.3 < mass[-1] < 2.8, name
        assert 8 < radius[-1] < 14.5, name
        assert np.all((along.column("compactness") < 0.36) & (along.column("tidal_deformability") > 1)), name


def test_turning_point_is_shared_by_both_masses():
    """M and M_b of a cold sequence turn at one central density."""
    equation = polytrope(100.0, 2.0)
    top = maximum_mass(equation)
    eta = top.structure.central_log_enthalpy
    step = 1e-3
    up, down = (structure(equation, math.expm1(eta * (1 + sign * step))) for sign in (1, -1))
    curvature = (up.mass + down.mass - 2 * top.mass) / step**2
    assert abs(up.mass - down.mass) / (2 * step) < 1e-3 * abs(curvature)
    assert abs(up.rest_mass - down.rest_mass) / (2 * step) < 1e-3 * abs(curvature)


def test_binding_of_neighbours():
    """dM = (1/(1 + z)) dM_b along a sequence of a cold equation of state: Zeldovich & Novikov's theorem.

    It ties the gravitational mass, the rest mass and the surface redshift together, with a density jump too.
    """
    for equation in (polytrope(100.0, 2.0), read2009("APR4"), constant_density(1e-3),
                     piecewise_polytrope(60.0, [2.0, 2.5], [5e-4], jumps=[1.5])):  # fmt: skip
        eta, step = 0.22, 1e-3
        here = star(equation, central_enthalpy=eta)
        stars = [structure(equation, eta * (1 + factor * step)) for factor in (-2, -1, 1, 2)]
        mass, rest = (np.array([getattr(one, name) for one in stars]) for name in ("mass", "rest_mass"))
        ratio = (8 * (mass[2] - mass[1]) - (mass[3] - mass[0])) / (8 * (rest[2] - rest[1]) - (rest[3] - rest[0]))
        assert ratio == pytest.approx(1 / (1 + here.redshift), rel=1e-7), equation.name
