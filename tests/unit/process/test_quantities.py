"""Functions of the library take quantities and text with units, or refuse them by the argument's name."""

import ast
import importlib
import inspect
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import xarray as xr
from astropy import constants, units as u
from astropy.units import imperial

from astroinertia.bodies import darwin, giant_planets, jacobi, maclaurin, neutron_stars, riemann, roche
from astroinertia.bodies.break_up import polytropic_limit, polytropic_rate
from astroinertia.bodies.cold_spheroid import ColdSpheroid
from astroinertia.bodies.earth import prem
from astroinertia.bodies.homogeneous_ellipsoid import HomogeneousEllipsoid
from astroinertia.bodies.homologous_core import HomologousCore
from astroinertia.bodies.moment_ratios import volumetric_radius
from astroinertia.bodies.neutron_star_fits import kepler_period
from astroinertia.bodies.polytrope import Polytrope, lane_emden
from astroinertia.bodies.rotating_star import rotating_star_with
from astroinertia.errors import AstroinertiaError, SceneError
from astroinertia.inertia import balancing, shapes, spin, tensor
from astroinertia.inertia.body import Body
from astroinertia.inertia.jointed import Limb
from astroinertia.inertia.prescribed import change
from astroinertia.inertia.rolling import flywheel_energy, spinning_disc_stress
from astroinertia.inertia.target import target_energy_gradient
from astroinertia.matter import planetary, rheology, tillotson
from astroinertia.matter.barotropes import polytropic_matter
from astroinertia.matter.compact_stars import geometric_density, read2009
from astroinertia.process.quantities import DIMENSIONS, EXPONENTS, InputError, InputTypeError, with_quantities
from astroinertia.rotation.braking import Braking
from astroinertia.rotation.contraction import contracted_period, radius_at_temperature
from astroinertia.rotation.ephemeris import ephemeris_of
from astroinertia.rotation.glitches import glitch_size, least_superfluid_share
from astroinertia.rotation.pulsars import frequency_braking_index
from astroinertia.rotation.spin_orbit import capture_probability
from astroinertia.rotation.wobble import wobble_and_nutation
from astroinertia.units import DIMENSIONS as KNOWN, GRAVITATIONAL_CONSTANT
from tests.unit import test_examples as examples

ROOMS = ["inertia", "rotation", "studies", *(room for room in examples.ROOMS if room.startswith("bodies"))]
# In units with G = c = Msun = 1, where a mass is no mass in kg: their functions of masses say so themselves.
GEOMETRIC = ("bodies.neutron_stars.", "bodies.neutron_star_fits.", "bodies.slow_rotation.")
# These read text and quantities with sentences of their own.
BY_ITSELF = ("studies.own_precession.", "studies.moments.read_matter")


def functions() -> dict[str, Callable[..., Any]]:
    """Every public function of the rooms, by its full name."""
    listed = {}
    for name in examples.modules(ROOMS):
        module = importlib.import_module(f"astroinertia.{name}".removesuffix(".__init__"))
        tree = ast.parse(examples.source(name).read_text())
        names = [node.name for node in tree.body if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")]
        listed |= {
            f"{name}.{each}": getattr(module, each) for each in names if f"{name}.{each}" not in examples.INSIDES
        }
    return listed


def physical(function: Callable[..., Any]) -> list[str]:
    names = inspect.signature(function).parameters
    return [name for name in names if name in DIMENSIONS or name in EXPONENTS]


def decorated(function: Any) -> bool:
    while function is not None:
        if getattr(getattr(function, "__code__", None), "co_filename", "").endswith("process/quantities.py"):
            return True
        function = getattr(function, "__wrapped__", None)
    return False


def test_the_dimensions_of_names_are_known() -> None:
    assert set(DIMENSIONS.values()) <= set(KNOWN) and not set(DIMENSIONS) & set(EXPONENTS)


def test_every_public_function_of_physical_numbers_takes_quantities() -> None:
    others = (*GEOMETRIC, *BY_ITSELF)
    listed = {name: function for name, function in functions().items() if not name.startswith(others)}
    plain = [name for name, function in listed.items() if physical(function) and not decorated(function)]
    assert plain == []


@pytest.mark.parametrize("room", sorted({name.partition(".")[0] for name in functions()}))
def test_no_argument_of_any_of_them_loses_its_unit(room: str) -> None:
    """A temperature goes with none of them: each is refused by its name before anything is done."""
    tried = 0
    for name, function in functions().items():
        if not name.startswith(f"{room}.") or not decorated(function):
            continue
        for argument, parameter in inspect.signature(function).parameters.items():
            if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD) or "temperature" in argument:
                continue
            for wrong in (3.0 * u.K, [3.0 * u.K, 4.0 * u.K], np.ones(3) * u.K):
                with pytest.raises(InputError, match=rf"^{argument}: must be [^\n]*\.$"):
                    call(function, argument, wrong)
            tried += 1
    assert tried > 5


def call(function: Callable[..., Any], argument: str, value: Any) -> Any:
    """Call with that argument; the others are what no function could work with."""
    parameters = inspect.signature(function).parameters.values()
    single = [one for one in parameters if one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD)]
    taken = {one.name: value if one.name == argument else object() for one in single}
    args = [taken[one.name] for one in single if one.kind is one.POSITIONAL_ONLY]
    return function(*args, **{one.name: taken[one.name] for one in single if one.kind is not one.POSITIONAL_ONLY})


def values(result: Any) -> Any:
    """Numbers of a result, to be compared."""
    if hasattr(result, "data_vars"):
        return np.concatenate([np.ravel(v.values) for v in result.data_vars.values() if v.dtype.kind == "f"])
    if isinstance(result, tuple):
        return np.concatenate([np.ravel(np.asarray(part, dtype=float)) for part in result])
    if isinstance(result, np.ndarray | float | np.floating) or hasattr(result, "__array__"):
        return np.asarray(result, dtype=float)
    fields = getattr(result, "__dataclass_fields__", None) or result._fields
    parts = [getattr(result, name) for name in fields]
    return np.concatenate([np.ravel(np.asarray(part, float)) for part in parts if np.asarray(part).dtype.kind in "fi"])


CM3 = u.g / u.cm**3
# Functions that the guide shows: their arguments in SI, and the same with units.
SHOWN = {
    "studies.moment_ratio.two_layer_sweep": (
        ("Mars", {"core_density": [6000.0, 7000.0]}), ("Mars", {"core_density": [6.0, 7.0] * CM3}),
    ),
    "bodies.inversion.two_layers": (
        (3933.5, 0.3634), {"mean_density": 3.9335 * CM3, "moment_ratio": 36.34 * u.percent},
        {"mantle_density": 3500.0}, {"mantle_density": "3500 kg/m3"},
    ),
    "bodies.polytrope.Polytrope": ((3.0, 2e30, 7e8, GRAVITATIONAL_CONSTANT), (3.0, 2e27 * u.t, 700_000 * u.km)),
    "bodies.rotation_laws.RotationLaw": (("j_constant", 1e6), ("j_constant", 1000 * u.km)),
    "bodies.neutron_star_fits.lattimer_schutz": ((1.4, 12.0), (1.4 * u.Msun, 12_000 * u.m)),
    "inertia.solids.cylinder": ((1000.0, 0.5, 1.0), (1 * u.t, 50 * u.cm, "1 m")),
    "inertia.tensor.inertia_tensor": (
        (np.array([1.0, 2.0]), np.eye(3)[:2] * 1e3), ([1.0, 2.0] * u.kg, np.eye(3)[:2] * u.km),
    ),
    "inertia.principal.principal_frame": ((np.diag([1.0, 2.0, 3.0]),), (np.diag([1e4, 2e4, 3e4]) * u.kg * u.cm**2,)),
    "inertia.balancing.correction_masses": (
        (np.array([[1.0, 0.0], [0.0, 2.0]]), [0.1, 0.1]), (np.array([[1.0, 0.0], [0.0, 2.0]]), [10, 10] * u.cm),
    ),
    "inertia.realise.point_masses": (
        (np.diag([1.0, 2.0, 2.5]), 3.0), (np.diag([1.0, 2.0, 2.5]) * u.kg * u.m**2, 3e3 * u.g),
    ),
    "rotation.pulsars.characteristic_age": ((0.033, 4.2e-13), (33 * u.ms, 4.2e-13)),
    "rotation.pulsars.dipole_period_derivative": ((0.033, 4e8), (33 * u.ms, 4e12 * u.G)),
    "rotation.accretion.magnetospheric_radius": ((1e4, 1e14), (1e8 * u.G, 1e17 * u.g / u.s)),
    "rotation.precession.geodetic_precession_of_binary": (
        (9e3, 1.6e20, 1.7e20), (2.5 * u.h, 1.6e11 * u.km**3 / u.s**2, 1.7e11 * u.km**3 / u.s**2),
    ),
    "rotation.heavy_top.steady_precession_rates": (
        (1.0, 2.0, 1.0, np.pi / 6, 50.0), (1.0, 2.0, 1.0, 30 * u.deg, 50 * u.rad / u.s),
    ),
    "inertia.rolling.bursting_rate": ((1e9, 8000.0, 0.5), (1 * u.GPa, 8 * u.g / u.cm**3, 50 * u.cm)),
    "inertia.pivoted.pendulum_period": (
        (shapes.rod(1.0, 1.5), (0, 0, 0.75)), (shapes.rod(1.0, 1.5), (0, 0, 0.75)),
        {"amplitude": np.pi / 2}, {"amplitude": 90 * u.deg},
    ),
    "rotation.spin_scaling.centrifugal_radius": ((1e15, 2e30), (1e19 * u.cm**2 / u.s, 2e27 * u.t)),
}  # fmt: skip


@pytest.mark.parametrize("name", SHOWN)
def test_units_change_nothing_but_how_numbers_are_written(name: str) -> None:
    module, _, own = name.rpartition(".")
    function = getattr(importlib.import_module(f"astroinertia.{module}"), own)
    plain, with_units, *options = SHOWN[name]
    first, second = options or ({}, {})
    expected = function(*plain, **first)
    actual = function(**with_units, **second) if isinstance(with_units, dict) else function(*with_units, **second)
    np.testing.assert_allclose(values(actual), values(expected), rtol=1e-12)


@with_quantities(years="yr", share=None)
def sample(
    mass: float,
    radius: Any = 2.0,
    *,
    years: float = 1.0,
    share: float = 0.5,
    gravitational_constant: float = 1.0,
    index: int = 3,
    about: dict | None = None,
) -> Any:
    if index < 0:
        raise ValueError("index must not be negative")
    return mass + 0.0, radius, years, share, gravitational_constant, about


def nutation(love_number: Any, core_share: Any) -> Any:
    return wobble_and_nutation(1 / 304.5, 7.3e-5, love_number, 0.938, core_share)


@with_quantities()
def counted(count: int) -> Any:
    return range(count)


def test_a_default_gravitational_constant_is_that_of_si_where_there_are_units() -> None:
    assert sample(2.0, 3.0)[4] == 1.0
    assert sample(2.0 * u.kg)[4] == GRAVITATIONAL_CONSTANT
    assert sample(2.0 * u.kg, gravitational_constant=2.0)[4] == 2.0
    assert sample(2.0, gravitational_constant=constants.G)[4] == constants.G.value


@with_quantities()
def of_size_one(
    mass: float = 1.0, radius: float = 1.0, density: float = 1.0, gravitational_constant: float = 1.0
) -> Any:
    return mass, radius, density, gravitational_constant


def test_what_is_left_at_one_is_not_a_kilogram_or_a_metre_where_something_has_a_unit() -> None:
    assert of_size_one(2.0) == (2.0, 1.0, 1.0, 1.0)
    assert of_size_one("2 kg", "3 km", "2 kg/m3") == (2.0, 3000.0, 2.0, GRAVITATIONAL_CONSTANT)
    for given in ({"mass": "2 kg"}, {"mass": 2.0, "radius": 3 * u.km}):
        missing = next(name for name in ("mass", "radius", "density") if name not in given)
        with pytest.raises(InputError, match=f"{missing} of of_size_one is needed, too, where .* given with a unit"):
            of_size_one(**given)
    with pytest.raises(InputError, match=r"radius of .* is needed, too, where mass is given with a unit"):
        Polytrope(1.5, mass="1 Msun")
    with pytest.raises(InputError, match="mass and a radius are needed, too, where angular_velocity is given"):
        maclaurin.from_angular_velocity("1e-6 rad/s")
    assert maclaurin.from_axis_ratio(0.8 * u.one).mass == 1.0


def test_tables_lists_text_and_units_of_their_own() -> None:
    texts = sample("3 t", [1 * u.km, 2.0], years=365.25 * u.day, share=50 * u.percent)
    assert isinstance(texts[1], np.ndarray)  # where an array is meant
    assert (texts[0], texts[1].tolist(), *texts[2:4]) == (3000.0, [1000.0, 2.0], 1.0, 0.5)
    assert sample(1.0, about={"mass": 3 * u.t, "other": 2})[5] == {"mass": 3000.0, "other": 2}
    assert sample(1.0, about={"crust_density_uncertainty": "2 g/cm3"})[5] == pytest.approx(
        {"crust_density_uncertainty": 2000.0}
    )


@pytest.mark.parametrize(
    ("call", "kind", "sentence"),
    [
        (lambda: sample(3 * u.km), InputError, "mass: must be a mass, not 3 km; write for example"),
        (lambda: sample("3"), InputTypeError, "mass of sample must be a number, not '3'."),
        (lambda: sample("3 talent"), InputError, "mass: 'talent' is not a unit that is known here."),
        (lambda: sample("heavy"), InputError, "mass: 'heavy' is not a number and a unit"),
        (lambda: sample(1.0, [1 * u.s, 2 * u.s]), InputError, "radius: must be a length, not 1 s"),
        (lambda: sample(1.0, np.ones(2) * u.s), InputError, "radius: must be a length, not an array in s"),
        (lambda: sample(1.0, years=3 * u.m), InputError, "years: must be in yr, or in units of that kind, not 3"),
        (lambda: sample(1.0, share=3 * u.m), InputError, "share: must be a plain number, not 3.0 m."),
        (lambda: sample(1.0, index=3 * u.m), InputError, "index: must be a plain number, not 3 m."),
        (lambda: sample(1.0, about={"mass": 3 * u.m}), InputError, "mass: must be a mass, not 3 m"),
        (lambda: sample(1.0, index=-1), InputError, "index must not be negative"),
        (lambda: sample(), InputTypeError, "sample: missing a required argument: 'mass'."),
        (lambda: sample(1.0, mas=1.0), InputTypeError, "sample: got an unexpected keyword argument 'mas'."),
        (lambda: sample(1, 2, 3), InputTypeError, "sample: too many positional arguments; it takes mass, radius."),
        (lambda: sample(None), InputTypeError, "mass of sample must be a number, not None."),
        (lambda: sample({}, 2.0), InputTypeError, "mass of sample must be a number, not something of the type dict."),
        (lambda: sample(1.0, index="x"), InputTypeError, "index of sample must be a whole number, not 'x'."),
        (lambda: nutation(0.3, None), InputTypeError, "core_share of wobble_and_nutation must be a number, not None."),
        (lambda: nutation("x", 0.1), InputTypeError, "love_number of wobble_and_nutation must be a number, not some"),
        (lambda: counted(2.5), InputTypeError, "count of counted must be a whole number, not 2.5."),
        (lambda: counted(np.float64("nan")), InputTypeError, "count of counted must be a whole number, not"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence_that_names_the_argument(call: Any, kind: type, sentence: str) -> None:
    with pytest.raises(AstroinertiaError) as caught:
        call()
    assert type(caught.value) is kind and isinstance(caught.value, SceneError)
    assert str(caught.value).startswith(sentence) and "\n" not in str(caught.value)
    assert isinstance(caught.value, ValueError if kind is InputError else TypeError)


WHOLE = {"list": list, "array": np.asarray, "int32": partial(np.asarray, dtype=np.int32), "jax": jnp.asarray}


@pytest.mark.parametrize("made", WHOLE.values(), ids=WHOLE)
def test_whole_numbers_do_not_overflow(made: Any) -> None:
    """m d^2 of 1e12 kg at 5 km is 2.5e19 kg m2, beyond 64 bits, and a mass of 6e24 kg no number that these hold."""
    exact = np.diag([1.0, 1.0 + 2.5e19, 1.0 + 2.5e19])
    assert tensor.about_point(np.eye(3), 10**12, made([5000, 0, 0])) == pytest.approx(exact, rel=1e-6)
    assert tensor.point_inertia(6 * 10**24, made([2, 0, 0]))[1, 1] == pytest.approx(2.4e25, rel=1e-6)
    assert tensor.point_inertia(np.int64(10**12), made([5000, 0, 0]))[1, 1] == pytest.approx(2.5e19, rel=1e-6)
    assert float(tensor.invariants(made(np.diag([3 * 10**7] * 3)))[2]) == pytest.approx(2.7e22, rel=1e-6)


def test_a_number_of_things_stays_a_whole_number() -> None:
    @with_quantities()
    def counted(points: int, mass: float) -> tuple[Any, float]:
        return range(points), mass

    assert counted(np.int64(3), 2) == (range(3), 2.0)


def test_errors_that_are_no_fault_of_arguments_stay_what_they_are() -> None:
    @with_quantities()
    def broken(mass: float) -> float:
        return mass + [][0] + "text"  # pyright: ignore[reportOperatorIssue]

    @with_quantities()
    def confused(mass: float) -> float:
        return "text" + mass  # type: ignore[operator]

    with pytest.raises(IndexError):
        broken(1.0)
    with pytest.raises(TypeError, match="can only concatenate") as caught:
        confused(1.0)
    assert not isinstance(caught.value, AstroinertiaError)


def test_a_unit_that_counts_turns_or_radians_is_refused() -> None:
    @with_quantities()
    def turning(angular_velocity: float) -> float:
        return angular_velocity

    assert turning(180 * u.deg / u.s) == pytest.approx(np.pi)
    with pytest.raises(InputError, match="angular_velocity: must be an angular velocity, not 3 Hz"):
        turning(3 * u.Hz)


MASS, RADIUS = 1 * u.Msun, "1 Rsun"
SCALED: dict[str, Callable[..., Any]] = {
    "maclaurin": partial(maclaurin.from_axis_ratio, 0.8),
    "jacobi": partial(jacobi.from_axis_ratio, 0.8),
    "riemann": partial(riemann.irrotational, 0.8),
    "roche": partial(roche.limit, 0.0),
    "contact": darwin.contact,
    "closest": darwin.closest,
    "secular": darwin.secular_limit,
    "rescaled": maclaurin.from_axis_ratio(0.8).rescaled,
}


@pytest.mark.parametrize("made", SCALED.values(), ids=SCALED)
def test_figures_that_are_scaled_by_quantities_have_the_gravitational_constant_of_si(made: Any) -> None:
    plain = {"mass": MASS.to_value("kg"), "mean_radius": u.R_sun.to("m")}
    expected = made(**plain, gravitational_constant=GRAVITATIONAL_CONSTANT)
    assert made(mass=MASS, mean_radius=RADIUS).angular_velocity == pytest.approx(expected.angular_velocity, rel=1e-12)
    assert made(**plain).gravitational_constant == 1.0
    assert made(mass=MASS, gravitational_constant=2.0).gravitational_constant == 2.0


def test_a_star_that_is_sought_by_its_spin_has_it_in_si() -> None:
    found = rotating_star_with("spin", 3e-4, polytropic_matter(1.5), mass=MASS, equatorial_radius=RADIUS)
    assert found.flattening == pytest.approx(0.12782, abs=1e-4)


def circle(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities (T, 1, 3) on a circle."""
    angle = 1e-4 * times
    place = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], -1)[:, None]
    return place, 1e-4 * np.cross([0.0, 0.0, 1.0], place)


HALF = 0.5 * u.R_sun
LENGTH = HALF.to_value("m")
STAR = Polytrope(1.5, MASS, RADIUS)
EARTH = prem()
BRAKING = Braking(188.0, -2.4e-9, (2.51,), (1.0,))
CIRCLE = ephemeris_of(circle, 0.0, 2 * u.hour, {"moon": 0.01})


def turned_about(point: Any) -> Any:
    return Body(1.0, np.ones(3), np.eye(3)).rotated([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], point).centre


METHODS: dict[str, tuple[Callable[..., Any], Any, Any]] = {
    "Polytrope.density": (STAR.density, HALF, LENGTH),
    "Polytrope.enclosed_mass": (STAR.enclosed_mass, HALF, LENGTH),
    "Polytrope.radius_enclosing": (STAR.radius_enclosing, 0.5 * MASS, 0.5 * STAR.mass),
    "LayeredBody.gravity": (EARTH.gravity, 6371 * u.km, 6.371e6),
    "LayeredBody.pressure": (EARTH.pressure, "3480 km", 3.48e6),
    "Braking.history": (BRAKING.history, [0.0, 1000.0] * u.yr, np.array([0.0, 3.15576e10])),
    "kepler_period": (partial(kepler_period, MASS), 1 * u.au, 149597870700.0),
    "planetary.density": (partial(planetary.density, planetary.IRON_HCP), 100 * u.GPa, 1e11),
    "geometric_density": (geometric_density, 1e15 * u.g / u.cm**3, 1e18),
    "volumetric_radius": (partial(volumetric_radius, 1e3, 1e3), 1 * u.km, 1e3),
    "flywheel_energy": (partial(flywheel_energy, shapes.disc(1.0, 1.0)), 30 * u.cycle / u.min, np.pi),
    "Vinet.density": (planetary.IRON_HCP.density, 300 * u.GPa, 3e11),
    "Murnaghan.density": (planetary.Murnaghan(1e3, 1e10, 4.0).density, 1 * u.GPa, 1e9),
    "BirchMurnaghan.pressure": (planetary.FORSTERITE.pressure, 4 * u.g / u.cm**3, 4e3),
    "Tillotson.pressure": (tillotson.GRANITE.pressure, 3 * u.g / u.cm**3, 3e3),
    "Ephemeris.position": (CIRCLE.position, [1.0] * u.hour, np.array([3600.0])),
    "Ephemeris.velocity": (CIRCLE.velocity, [1.0] * u.hour, np.array([3600.0])),
    "Change.factor": (change([0.0, 7200.0], [1.0, 0.5]).factor, 1 * u.hour, 3600.0),
    "Change.derivatives": (change([0.0, 7200.0], [1.0, 0.5]).derivatives, 1 * u.hour, 3600.0),
    "Body.rotated": (turned_about, [1, 0, 0] * u.km, [1e3, 0, 0]),
    "glitch_size": (partial(glitch_size, 0.01, angular_velocity=70.0), 1 * u.deg / u.s, np.pi / 180),
    "least_superfluid_share": (partial(least_superfluid_share, characteristic_age=1e12), 2e-7 / u.day, 2e-7 / 86400),
    "frequency_braking_index": (
        partial(frequency_braking_index, 30.0, second_derivative=1e-20),
        -0.02 * u.Hz / u.yr,
        -0.02 / 31557600.0,
    ),
    "target_energy_gradient": (
        lambda target: target_energy_gradient(np.ones(3), np.eye(3), target, 1.0),
        np.eye(3) * u.g * u.m**2,
        1e-3 * np.eye(3),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize(("call", "given", "number"), METHODS.values(), ids=METHODS)
def test_methods_and_functions_in_si_read_units(call: Any, given: Any, number: Any) -> None:
    with jax.enable_x64(True):  # in which materials' own methods compute as they are asked to
        np.testing.assert_allclose(call(given), call(number), rtol=1e-12)
    with pytest.raises(InputError):
        call(3.0 * u.K)


# No user calls these, and inner loops do.
OF_INSIDES = {"GivenDensity", "Hydrostatic", "Law", "Material", "Mesh", "MomentumLaw", "RotationLaw"}


def methods(made: type) -> dict[str, Any]:
    public = {key: method for key, method in vars(made).items() if not key.startswith("_")}
    return {key: method for key, method in public.items() if inspect.isfunction(method)}


def test_every_public_method_of_physical_numbers_takes_quantities() -> None:
    """An array of numpy that is made of a Quantity has lost its unit without a word."""
    plain = set()
    for name in examples.modules(["bodies", "inertia", "rotation"]):
        module = importlib.import_module(f"astroinertia.{name}".removesuffix(".__init__"))
        own = [made for made in vars(module).values() if inspect.isclass(made) and made.__module__ == module.__name__]
        for made in own:
            bare = [method for method in methods(made).values() if physical(method) and not decorated(method)]
            plain |= {made.__name__} if bare and not made.__name__.startswith("_") else set()
    assert plain == OF_INSIDES


def test_series_of_a_dataset_are_read_by_the_unit_that_they_say() -> None:
    def series(unit: str) -> xr.DataArray:
        return xr.DataArray([3.0, 4.0], dims="x", attrs={"units": unit})

    assert np.asarray(sample(1.0, series("km"))[1]).tolist() == [3000.0, 4000.0]
    own = sample(1.0, series("m"))[1]
    assert own.dims == ("x",) and own.attrs == {}  # what follows from it is no length
    assert sample(1.0, series("1"))[1].values.tolist() == [3.0, 4.0]  # of a run without units
    with pytest.raises(InputError, match=r"^radius: must be a length, not an array in kg"):
        sample(1.0, series("kg"))


def test_text_is_read_where_an_argument_is_in_a_unit_of_its_own() -> None:
    assert sample(1.0, years="730.5 d")[2] == pytest.approx(2.0)
    with pytest.raises(InputError, match=r"^years: must be in yr, or in units of that kind, not 3\.0 km\.$"):
        sample(1.0, years="3 km")
    with pytest.raises(InputError, match=r"^years: 'soon' is not a number and a unit that is known here\.$"):
        sample(1.0, years="soon")


def test_units_that_astropy_has_and_does_not_read_are_known() -> None:
    assert sample(1 * imperial.lb)[0] == pytest.approx(0.45359237)
    assert sample(2 * u.def_unit("stone", 6.35 * u.kg))[0] == pytest.approx(12.7)
    with pytest.raises(InputError, match=r"^mass: must be a mass, not 1 lb / s"):
        sample(1 * imperial.lb / u.s)


def test_frequencies_of_tides_and_wobbles_are_in_radians() -> None:
    assert rheology.maxwell(60 * u.deg / u.s, 2.0) == pytest.approx(rheology.maxwell(np.pi / 3, 2.0))
    assert rheology.maxwell("1 cycle/s", 2.0) == pytest.approx(rheology.maxwell(2 * np.pi, 2.0))
    with pytest.raises(InputError, match=r"^frequency: must be in rad/s"):
        rheology.maxwell(1 * u.Hz, 2.0)


def test_series_of_tensors_of_a_dataset_are_turned_time_by_time() -> None:
    """A product of labelled arrays sums over all that has one name in both, time included."""
    tensors = xr.DataArray(np.arange(18.0).reshape(2, 3, 3), dims=("time", "i", "j"), attrs={"units": "kg m2"})
    tensors = 0.5 * (tensors + tensors.rename(i="j", j="i"))
    axes = np.stack([np.eye(3), [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])
    turned = tensor.rotated(tensors.transpose("i", "j", "time"), xr.DataArray(axes, dims=("time", "principal", "i")))
    values = tensors.transpose("time", "i", "j").values
    np.testing.assert_allclose(turned, [turn @ one @ turn.T for turn, one in zip(axes, values, strict=True)])


def test_bodies_and_materials_made_of_quantities_have_their_numbers() -> None:
    iron = planetary.Vinet(8.3 * u.g / u.cm**3, 156.2 * u.GPa, 6.08)
    assert vars(iron) == vars(planetary.Vinet(8300.0, pytest.approx(156.2e9), 6.08))
    assert float(planetary.density(iron, 100 * u.GPa)) == pytest.approx(10995.1, rel=1e-5)
    assert planetary.BirchMurnaghan(8300.0, 1e11, 5.0, -(5e-11 / u.Pa)).second_derivative == -5e-11
    with pytest.raises(InputError, match=r"^coefficient: must be a plain number"):
        planetary.ModifiedPolytrope(1000.0, 3 * u.kg)
    braked = Braking((200 * u.rad / u.s).to("deg/s"), (-1e-9 * u.rad / u.s**2).to("deg/s2"), (3.0,), (1.0,))
    assert braked.rate(100.0) == pytest.approx(-1.25e-10)
    ball = Body(2 * u.g, [0, 0, 1.0] * u.cm, np.eye(3) * u.g * u.cm**2)
    assert (ball + Body(0.001, np.zeros(3), np.zeros((3, 3)))).centre[2] == pytest.approx(0.01 * 2 / 3)
    core = HomologousCore(0.5, mass=1.4 * u.Msun, radius=1500 * u.km)
    assert core.gravitational_constant == GRAVITATIONAL_CONSTANT and core.radius == 1.5e6
    limb = Limb(ball, joint=[0, 0, 30] * u.cm)
    assert limb.joint[2] == pytest.approx(0.3)
    sphere = HomogeneousEllipsoid(1.0, 1.0, 0.0, 1 * u.M_earth, 6371 * u.km)
    assert sphere.gravitational_energy == pytest.approx(-2.24e32, rel=1e-2)
    assert ColdSpheroid(1 * u.pc, 0.5 * u.pc, 0.0, 1 * u.Msun).free_fall_time == pytest.approx(3.70e14, rel=1e-2)
    jupiter = giant_planets.measured_field("Jupiter")
    assert replace(jupiter, equatorial_radius=jupiter.equatorial_radius / 1e3 * u.km).rotation_parameter == (
        pytest.approx(jupiter.rotation_parameter)
    )
    dense = neutron_stars.star(read2009("SLy"), central_rest_density=1e15 * u.g / u.cm**3)
    central = geometric_density(1e18)
    assert dense.mass == neutron_stars.star(read2009("SLy"), central_rest_density=central).mass
    for number in (np.array(central), xr.DataArray(central)):  # in geometric units, whatever holds it
        assert dense.mass == neutron_stars.star(read2009("SLy"), central_rest_density=number).mass


def test_masses_in_single_precision_have_moments_in_si() -> None:
    """A solar mass times the square of a solar radius is beyond float32."""
    mass, places = np.ones(4, "f4") * u.Msun, np.eye(4, 3, dtype="f4") * u.Rsun
    found = tensor.inertia_tensor(mass, places)
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found, tensor.inertia_tensor(mass.astype(float), places.astype(float)), rtol=1e-6)
    assert sample(1.0, years=np.float32(1e30) * u.Gyr)[2] == pytest.approx(1e39, rel=1e-6)


@pytest.mark.parametrize("call", [lane_emden, polytropic_limit, polytropic_matter, lambda n: polytropic_rate(n, 0.8)])
def test_an_index_in_an_array_of_one_is_a_number(call: Any) -> None:
    for made in (np.array, jnp.array):
        assert call(made(1.5)) == call(1.5) and call(made(1)) == call(1)


@pytest.mark.parametrize("call", [maclaurin.from_angular_momentum, maclaurin.from_angular_velocity])
def test_a_number_in_single_precision_is_as_good_as_one_in_double(call: Any) -> None:
    """Beside one in single precision, NumPy computes in that: the ends of the search were beyond its range."""
    for number in (np.float32(0.25), np.array(0.25, "f4"), xr.DataArray(np.float32(0.25))):
        np.testing.assert_array_equal(call(number).axes, call(0.25).axes)


def test_radii_until_which_something_holds_are_lengths_and_rates_over_the_mean_motion_numbers() -> None:
    period = contracted_period(8 * u.day, 2 * u.Rsun, 1 * u.Rsun, 1.5 * u.Rsun)
    assert period == pytest.approx(8 * 86400.0 / 1.5**2)
    with pytest.raises(InputError, match=r"^locked_until: must be a length"):
        contracted_period(8 * u.day, 2 * u.Rsun, 1 * u.Rsun, 100 * u.day)
    with pytest.raises(InputError, match=r"^equilibrium_rate: must be a plain number"):
        capture_probability(1.5, 0.2, 0.02, 1.2 * u.rad / u.s)
    turned = change(np.array([0, 1, 2]) * u.day, [1, 2, 3.0])
    assert turned.factor(86400.0) == pytest.approx(2.0)


def test_a_figure_that_has_a_mass_with_a_unit_needs_its_radius() -> None:
    """A radius of 1 would be one metre."""
    with pytest.raises(InputError, match=r"^mean_radius is needed, too, where mass is given with a unit\.$"):
        maclaurin.from_axis_ratio(0.9, mass=1 * u.Mearth)


def test_tables_of_masses_by_the_names_of_bodies_are_masses() -> None:
    def circle(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        turned = [np.stack([np.cos(t), np.sin(t), 0 * t], -1) for t in (times, times + np.pi / 2)]
        return turned[0][:, None], turned[1][:, None]

    for given, mass in (("2 g", 2e-3), (3.0 * u.Mearth, 3.0 * constants.M_earth.value), (0.5, 0.5)):
        assert ephemeris_of(circle, 0.0, 1.0, {"radius": given}).mass == pytest.approx([mass], rel=1e-12)


SAME_NUMBERS: dict[str, tuple[Callable[..., Any], tuple[Any, ...], tuple[Any, ...]]] = {
    "a rotational energy of lists": (spin.rotational_energy, ([[1, 0, 0], [0, 2, 0], [0, 0, 4]], None, [0, 0, 12]),
                                     (np.diag([1.0, 2.0, 4.0]), None, np.array([0.0, 0.0, 12.0]))),
    "a momentum's and a rate's energy": (spin.rotational_energy, (None, [0, 0, 3], [0, 0, 12]),
                                         (None, np.array([0.0, 0.0, 3.0]), np.array([0.0, 0.0, 12.0]))),
    "the velocity of a centre": (tensor.centre_of_mass, ([1.0, 3.0], [[0, 0, 0], [4, 0, 0]] * u.km / u.s),
                                 ([1.0, 3.0], np.array([[0.0, 0, 0], [4e3, 0, 0]]))),
    "a mixed moment": (tensor.mixed_moment, ([1.0, 3.0], [[0, 0, 0], [4, 0, 0]] * u.km,
                                             [[0, 0, 0], [0, 1, 0]] * u.km / u.s),
                       ([1.0, 3.0], np.array([[0.0, 0, 0], [4e3, 0, 0]]), np.array([[0.0, 0, 0], [0, 1e3, 0]]))),
    "a disc that turns": (spinning_disc_stress, (7800.0, 0.5, 1000.0 * u.cycle / u.min),
                          (7800.0, 0.5, 1000.0 * 2.0 * np.pi / 60.0)),
    "an unbalance in g mm": (balancing.two_plane_correction,
                             ([6.0, 0.0] * u.g * u.mm, [0.0, 1e3] * u.g * u.mm**2, ["-10 cm", "10 cm"]),
                             (np.array([6e-6, 0.0]), np.array([0.0, 1e-6]), (-0.1, 0.1))),
    "measurements in g mm": (balancing.unbalance_of_measurements, ([[10, 0], [10, 0]] * u.g * u.mm, [-1.0, 1.0]),
                             (np.array([[1e-5, 0.0], [1e-5, 0.0]]), np.array([-1.0, 1.0]))),
    "a Hayashi track": (radius_at_temperature, (1 * u.Myr, 1 * u.Msun, 3 * u.Rsun, 4000 * u.K),
                        (3.15576e13, constants.M_sun.value, 3 * constants.R_sun.value, 4000.0)),
}  # fmt: skip


@pytest.mark.parametrize("name", SAME_NUMBERS)
def test_units_and_lists_give_the_numbers_of_arrays_in_si(name: str) -> None:
    function, given, plain = SAME_NUMBERS[name]
    for found, expected in zip(np.atleast_1d(function(*given)), np.atleast_1d(function(*plain)), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_a_star_is_sought_by_a_period_with_a_unit() -> None:
    solar = {"mass": 1 * u.Msun, "equatorial_radius": 1 * u.Rsun}
    found = rotating_star_with("period", 4 * u.hour, polytropic_matter(1.5), **solar)
    assert found.angular_velocity == pytest.approx(2.0 * np.pi / 14400.0, rel=1e-9)


def test_an_array_where_one_number_is_meant_is_named() -> None:
    with pytest.raises(InputTypeError, match="c_over_a"):
        maclaurin.from_axis_ratio(np.array([0.5, 0.6]))
