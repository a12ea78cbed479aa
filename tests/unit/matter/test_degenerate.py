"""White dwarfs of cold electrons: Chandrasekhar's table and limits."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from astroinertia.bodies import neutron_stars
from astroinertia.bodies.polytrope import lane_emden
from astroinertia.matter.compact_stars import SOLAR_LENGTH, geometric_density
from astroinertia.matter.degenerate import degenerate_electrons


def test_the_equation_of_state_is_the_electrons_integral():
    gas = degenerate_electrons()
    scale = gas.pieces[0].scale
    for x in (1e-8, 1e-3, 0.03, 0.0501, 0.2, 0.4999, 0.5001, 1.0, 30.0):
        eta = scale * x * x / (math.sqrt(1 + x * x) + 1)
        density, pressure, _ = gas.pieces[0].at(eta)
        exact = quad(lambda y: y**4 / math.sqrt(1 + y * y), 0, x, epsabs=0, epsrel=1e-13)[0]
        assert pressure / (gas.pieces[0].density * scale * exact) == pytest.approx(1, rel=2e-14)
        # dP = rho0 d eta, the first law, by differences.
        step = 1e-5 * eta
        slope = (gas.pieces[0].at(eta + step)[1] - gas.pieces[0].at(eta - step)[1]) / (2 * step)
        assert slope / density == pytest.approx(1, rel=1e-9)
    with pytest.raises(ValueError, match="at least one nucleon"):
        degenerate_electrons(0.5)


def test_density_scale_is_that_of_the_textbook():
    # rho = 1.948e6 mu_e x^3 g/cm3 with m_u (Shapiro & Teukolsky 1983, eq. 2.3.9)
    gas = degenerate_electrons(1.0).pieces[0]
    assert gas.density == pytest.approx(float(geometric_density(0.974e9)), rel=1e-3)


@pytest.mark.slow
def test_chandrasekhars_dwarfs():
    gas = degenerate_electrons()
    # Newtonian, dense: the limiting mass 5.836/mu_e^2 Msun of Chandrasekhar, as an n = 3 polytrope.
    heavy = neutron_stars.star(gas, central_enthalpy=1e-1, relativistic=False)
    assert heavy.mass == pytest.approx(5.836 / 4, rel=4e-3)
    assert heavy.moment_ratio == pytest.approx(lane_emden(3.0).moment_ratio, rel=2e-2)
    light = neutron_stars.star(gas, central_enthalpy=1e-8, relativistic=False)
    assert light.moment_ratio == pytest.approx(lane_emden(1.5).moment_ratio, rel=1e-3)
    # Chandrasekhar 1939, table 24: eta_1 and -eta_1^2 phi' by 1/y_0^2, with y_0^2 = 1 + x_c^2.
    piece = gas.pieces[0]
    length = math.sqrt(piece.scale / (4 * math.pi * piece.density))
    for inverse, edge, mass in ((0.05, 4.4601, 1.7096), (0.2, 3.7271, 1.2430), (0.5, 3.5330, 0.7070)):
        enthalpy = piece.scale * (inverse**-0.5 - 1)
        star = neutron_stars.star(gas, central_enthalpy=enthalpy, relativistic=False)
        assert star.mass == pytest.approx(4 * math.pi * piece.density * length**3 * mass, rel=1e-4)
        assert star.radius_km == pytest.approx(length * edge * inverse**0.5 * SOLAR_LENGTH / 1e3, rel=1e-4)
    # In general relativity the heaviest dwarf is unstable at 2.3e10 g/cm3 (mu_e = 2) and has 1.42 to 1.44 Msun.
    top = neutron_stars.maximum_mass(gas)
    assert top.mass == pytest.approx(1.43, abs=0.02)
    assert np.isfinite(top.moment_ratio) and top.radius_km == pytest.approx(1.0e3, rel=0.3)
