"""Interiors and moment ratios: PREM, the flattening of a fluid Earth, ratios from measured gravity and precession."""

from astroinertia.bodies.earth import elastic_prem, prem, prem_figure
from astroinertia.bodies.love_numbers import YieldingBody, interior, love_numbers, seismic_body
from astroinertia.bodies.moment_ratios import polar_from_precession
from astroinertia.bodies.planets import body
from astroinertia.verify.comparison import Quantities

_PREM_CONSTANT = 6.6732e-11  # G of 1981, with which PREM's own table holds
# The Moon of Weber et al. 2011 in nine layers, as LOV3D has it (data/tests/moon/Moon_Weber.dat of
# github.com/mroviranavarro/LOV3D_multi): outer radius (km), density (g cm-3), v_p and v_s (km/s).
_MOON = (
    (240.0, 8.0, 4.3, 2.3), (330.0, 5.1, 4.1, 0.0), (480.0, 3.4, 7.5, 3.2), (999.1, 3.4, 8.5, 4.5),
    (1249.1, 3.4, 7.6, 4.4), (1499.1, 3.4, 7.8, 4.37), (1675.1, 3.22, 7.7, 4.44), (1703.1, 3.22, 7.7, 4.44),
    (1737.1, 2.8, 5.5, 3.2),
)  # fmt: skip
_STIFFER = 1e3  # moduli of their solid inner core over those of its waves


def preliminary_reference_earth() -> Quantities:
    """Moment ratio, pressure and gravity of PREM from its density."""
    earth = prem(_PREM_CONSTANT)
    return {
        "prem_moment_ratio": float(earth.moment_ratio),
        "prem_central_pressure": float(earth.pressure(0.0)) / 1e9,
        "prem_core_gravity": float(earth.gravity(3480e3)),
    }


def hydrostatic_earth() -> Quantities:
    """The flattening that PREM would have as a fluid, to all orders."""
    return {"earth_flattening": 1.0 / prem_figure().flattening}


def solar_system() -> Quantities:
    """Ratios as their authors normalise them, from other numbers of the table."""
    earth = body("Earth")
    precession = polar_from_precession(earth.value("j2"), earth.value("dynamical_ellipticity"))
    return {
        "earth_polar_ratio": precession,
        "earth_mean_ratio": earth.moment_ratio().value,
        "mars_mean_ratio": body("Mars").moment_ratio().value,
        "moon_mean_ratio": body("Moon").moment_ratio().value,
    }


def moon_of_nine_layers() -> YieldingBody:
    """The elastic Moon that LOV3D and a perturbation method were compared on, its solid inner core made stiff."""
    rows = [[1e3 * each for each in row] for row in _MOON]
    rows[0][2:] = [_STIFFER**0.5 * speed for speed in rows[0][2:]]
    radii, *columns = zip(*rows, strict=True)
    return seismic_body(radii, *([[value] for value in column] for column in columns))


def yielding_planets() -> Quantities:
    """Elastic Love numbers of the Earth and the Moon, and Mars's k2 by the layers that InSight heard."""
    k, h, _ = love_numbers(elastic_prem())
    moon, mars = (float(love_numbers(planet).k) for planet in (moon_of_nine_layers(), interior("Mars")))
    return {"prem_k2": float(k), "prem_h2": float(h), "moon_k2": moon, "mars_k2": mars}


COMPUTATIONS = (preliminary_reference_earth, hydrostatic_earth, solar_system, yielding_planets)
