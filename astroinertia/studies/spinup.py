"""Spin-up in one call: a scene by any model with its limits of rotation, a core that becomes a neutron star, shells.

Quantities are given as text with a unit ("1.4 Msun") or as numbers in SI; datasets are in SI.
"""

import math
import tempfile
from collections.abc import Iterable, Sequence
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from astroinertia import dataset as datasets
from astroinertia.accuracy.running import run_scene
from astroinertia.bodies import neutron_star_fits
from astroinertia.bodies.break_up import shedding_share, spun_up_polytrope
from astroinertia.bodies.neutron_stars import NeutronStar, stable_branch, star, star_of_mass
from astroinertia.bodies.polytrope import Polytrope
from astroinertia.bodies.tov import structure
from astroinertia.dataset.absent import with_absent
from astroinertia.dataset.variables import of_rows, variables
from astroinertia.errors import AbsentError, NumericalError, SceneError
from astroinertia.matter.compact_stars import SOLAR_LENGTH, Barotrope, read2009
from astroinertia.matter.degenerate import degenerate_electrons
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between
from astroinertia.rotation.collapsing_shells import shells_of
from astroinertia.rotation.spin_scaling import SpinUp, spin_up as whole
from astroinertia.scene import load
from astroinertia.scene.schema import Scene
from astroinertia.studies.spin_histories import Quantity, in_si
from astroinertia.units import GRAVITATIONAL_CONSTANT, SOLAR_MASS, quantity

_RADII = 200  # points of a period-radius curve
_SPECTRUM = 200


class Case(NamedTuple):
    """A body before and after: mass, radius, period and I/(M R^2), then radius and I/(M R^2); SI."""

    name: str
    mass: float
    radius: float
    period: float
    moment_ratio: float
    radius_after: float
    moment_ratio_after: float


def _case(name: str, mass: str, radius: str, period: str, ratio: float, after: str, ratio_after: float) -> Case:
    lengths = quantity(radius, "length"), quantity(after, "length")
    return Case(name, quantity(mass, "mass"), lengths[0], quantity(period, "time"), ratio, lengths[1], ratio_after)


def cases() -> tuple[Case, ...]:
    """Return the textbook collapses: whole stars, cores and white dwarfs to neutron stars, a cloud, a young planet.

    Moment ratios: 0.07 of the Sun, 0.0754 of an n = 3 polytrope (iron core), 0.1 to 0.2 of white dwarfs by mass, 0.35
    of neutron stars, 0.4 of a uniform cloud, 0.26 of an n = 1 polytrope (Jupiter).

    >>> print(cases()[1].name)
    iron core, 100 s
    """
    return (
        _case("Sun-like star to 12 km", "1 Msun", "695700 km", "25.4 d", 0.07, "12 km", 0.35),
        _case("iron core, 100 s", "1.4 Msun", "1500 km", "100 s", 0.0754, "12 km", 0.35),
        _case("iron core, 5 s", "1.4 Msun", "1500 km", "5 s", 0.0754, "12 km", 0.35),
        _case("white dwarf, 1 h, to 12 km", "1.4 Msun", "2000 km", "1 h", 0.1, "12 km", 0.35),
        _case("cloud to a disc", "1 Msun", "0.05 pc", "2e7 yr", 0.4, "1 au", 0.4),
        _case("young Jupiter", "1.898e27 kg", "140000 km", "39.7 h", 0.26, "69911 km", 0.26),
    )


@with_quantities()
def spin_up(
    scene: Scene | str | PathLike[str],
    model: str | None = None,
    settings: Sequence[str] = (),
    folder: str | PathLike[str] | None = None,
    shedding: str = "roche",
) -> xr.Dataset:
    """Run a scene and return its headline series with period, limits of rotation and flags along time.

    scene: a Scene or the path of one; model: "scaling", "ellipsoid" or "sph" instead of the scene's own; settings:
    further "key=value"; folder: where the run is kept (nowhere without it); shedding: see `with_limits`. SceneError
    where the model cannot answer the scene, NumericalError where it fails.

    >>> print(f"{1e3 * float(spin_up('sims/core_to_pulsar_scaling.toml').period[-1]):.2f} ms")
    7.71 ms
    """
    wanted = [*settings, *([] if model is None else [f"model={model}"])]
    if isinstance(scene, Scene):
        effects, text = scene.own_classes, scene.to_toml()
        chosen = load.loads(text, wanted, scene.origin, effects=effects) if wanted else scene
    else:
        chosen = load.load_file(scene, wanted)
    if folder is not None:
        return with_limits(datasets.open(run_scene(chosen, Path(folder))), shedding)
    with tempfile.TemporaryDirectory() as place:
        return with_limits(datasets.open(run_scene(chosen, Path(place) / chosen.name)), shedding)


@with_quantities()
@with_absent
def with_limits(dataset: xr.Dataset, shedding: str = "roche") -> xr.Dataset:
    """Return a run's dataset with its limits of rotation, as `dataset.inertia.rotation_limits` has them, where it does.

    >>> print(bool(with_limits(ds).kepler_fraction[0] < 1))
    True
    """
    with suppress(AbsentError):  # of rates in a frame that turns
        dataset = dataset.assign(dataset.inertia.rotation_limits(shedding).data_vars)
    return dataset


@with_quantities()
def period_against_radius(chosen: Iterable[Case] | None = None) -> xr.Dataset:
    """Return period, Kepler and shedding period along shrinking radius, dimensions case and step.

    The moment ratio goes from that before to that after as a power of the radius. barrier_radius is where the period
    would be that of an orbit: no smaller body. SceneError for an empty list.

    >>> print(f"{float(period_against_radius().period[1, -1]):.3f} s")  # an iron core of 100 s, at 12 km
    0.030 s
    """
    rows = list(cases() if chosen is None else chosen)
    if not rows:
        raise SceneError("there is no case to follow")
    columns = {name: np.array([getattr(row, name) for row in rows])[:, None] for name in Case._fields if name != "name"}
    share = np.linspace(0.0, 1.0, _RADII)
    radius = columns["radius"] * (columns["radius_after"] / columns["radius"]) ** share
    ratio = columns["moment_ratio"] * (columns["moment_ratio_after"] / columns["moment_ratio"]) ** share
    collapsed = whole(
        columns["moment_ratio"], columns["mass"], columns["radius"], columns["period"], ratio, columns["mass"], radius
    )
    wide = {
        "radius": (radius, "m", "radius"),
        "moment_ratio": (ratio, "1", "I/(M R^2)"),
        "period": (collapsed.period, "s", "period"),
        "kepler_period": (np.broadcast_to(collapsed.kepler_period, radius.shape), "s", "of an orbit at the equator"),
        "shedding_period": (np.broadcast_to(collapsed.shedding_period, radius.shape), "s", "of mass shedding, Roche"),
        "beyond_kepler": (collapsed.beyond_kepler, "1", "whether the equator turns faster than an orbit there"),
        "sheds_mass": (collapsed.sheds_mass, "1", "whether it turns faster than a condensed body can"),
    }
    narrow = {
        "mass": (columns["mass"][:, 0], "kg", "mass"),
        "angular_momentum": (collapsed.angular_momentum[:, 0], "kg m2 s-1", "angular momentum"),
        "barrier_radius": (collapsed.centrifugal_radius[:, -1], "m", "radius at which it would turn like an orbit"),
    }
    return xr.Dataset(
        variables(("case", "step"), wide) | variables("case", narrow),
        {"case": [row.name for row in rows]},
        {"title": "period against radius at constant angular momentum"},
    )


@with_quantities()
def core_to_neutron_star(
    core_mass: Quantity = "1.4 Msun",
    core_radius: Quantity | None = "1500 km",
    core_period: Quantity = "100 s",
    core_index: float = 3.0,
    remnant_radius: Quantity = "12 km",
    equations_of_state: Sequence[str] = ("SLy", "MPA1"),
    angular_momentum_share: float = 1.0,
) -> xr.Dataset:
    """Return what a polytropic core becomes, along `remnant`: one row for each way to know the star's moment.

    The core's mass is that of its baryons. Without core_radius it is a white dwarf of cold electrons, which has its own
    radius and moment (Newtonian; up to 1.45 solar masses), and core_index says nothing. Rows: a uniform sphere and an
    n = 1 polytrope of `remnant_radius`, that polytrope as the exact rotating figure (which swells), the fits by
    compactness of Lattimer & Schutz and of Breu & Rezzolla, and stars of Read et al.'s equations of state by TOV and
    Hartle, which keep the baryons and have their own radius. Flags: beyond_kepler, and sheds_mass by Roche, by the
    polytrope's own limit, or by Haensel et al. 2009 where the star is relativistic. Periods are NaN where no figure
    holds the angular momentum. SceneError for bad quantities.
    """
    mass, period, size = in_si(core_mass, "mass"), in_si(core_period, "time"), in_si(remnant_radius, "length")
    if core_radius is None:
        radius, ratio = _white_dwarf(mass / SOLAR_MASS)
    else:
        radius, ratio = in_si(core_radius, "length"), Polytrope(core_index).moment_of_inertia
    rows: list[dict] = []

    def add(name: str, mass_after: float, radius_after: float, ratio_after: float, limit: str) -> SpinUp:
        spun_up = whole(ratio, mass, radius, period, ratio_after, mass_after, radius_after, angular_momentum_share)
        rows.append(_row(name, spun_up, mass_after, radius_after, ratio_after, limit))
        return spun_up

    add("uniform sphere", mass, size, 0.4, "roche")
    soft = Polytrope(1.0)
    spun_up = add("polytrope n = 1", mass, size, soft.moment_of_inertia, "polytrope 1")
    rows.append(_figure(mass, size, float(spun_up.angular_momentum)))
    solar, kilometres = mass / SOLAR_MASS, size / 1e3
    compactness = solar * SOLAR_LENGTH / size
    fits = {
        "Lattimer & Schutz 2005": lambda: neutron_star_fits.lattimer_schutz(solar, kilometres),
        "Breu & Rezzolla 2016": lambda: neutron_star_fits.breu_rezzolla_moment_ratio(compactness),
    }
    for name, fit in fits.items():
        add(name, mass, size, float(fit()), "haensel_2009")
    for name in equations_of_state:
        born = star_of_baryons(read2009(name), solar)
        add(f"{name}, TOV and Hartle", born.mass_kg, 1e3 * born.radius_km, born.moment_ratio, "haensel_2009")
    return xr.Dataset(
        of_rows("remnant", rows, _REMNANT),
        {"remnant": [row["name"] for row in rows]},
        {
            "title": "a core that becomes a neutron star",
            "core_mass": mass,
            "core_radius": radius,
            "core_period": period,
            "core_moment_ratio": ratio,
            "angular_momentum_share": angular_momentum_share,
        },
    )


_REMNANT = {
    "mass": ("kg", "gravitational mass"),
    "radius": ("m", "radius at rest, or equatorial radius of the rotating figure"),
    "moment_ratio": ("1", "I/(M R^2) with that radius"),
    "moment_of_inertia": ("kg m2", "I"),
    "moment_fall": ("1", "I before over I after"),
    "period": ("s", "period"),
    "kepler_period": ("s", "period of an orbit at the equator of the star at rest"),
    "shedding_period": ("s", "shortest period without loss of mass"),
    "period_over_kepler": ("1", "period over Kepler's"),
    "rotational_energy": ("J", "energy of the rotation"),
    "beyond_kepler": ("1", "whether its equator would turn faster than an orbit"),
    "sheds_mass": ("1", "whether it would lose mass at its equator"),
}


def _row(name: str, spun_up: SpinUp, mass: float, radius: float, ratio: float, limit: str) -> dict:
    shedding = float(spun_up.kepler_period) / shedding_share(limit)
    return {
        "name": name,
        "mass": mass,
        "radius": radius,
        "moment_ratio": ratio,
        "moment_of_inertia": float(spun_up.moment_after),
        "moment_fall": float(spun_up.moment_fall),
        "period": float(spun_up.period),
        "kepler_period": float(spun_up.kepler_period),
        "shedding_period": shedding,
        "period_over_kepler": float(spun_up.period_over_kepler),
        "rotational_energy": float(spun_up.rotational_energy),
        "beyond_kepler": bool(spun_up.beyond_kepler),
        "sheds_mass": abs(float(spun_up.period)) < shedding,
    }


def _figure(mass: float, radius: float, momentum: float) -> dict:
    """The n = 1 polytrope as it is with its rotation."""
    at_rest = Polytrope(1.0, mass, radius).moment_of_inertia
    spun_up = whole(1.0, 1.0, math.sqrt(at_rest), 2 * math.pi * at_rest / momentum, 1.0, mass, radius)
    row = _row("polytrope n = 1, rotating figure", spun_up, mass, radius, 1.0, "polytrope 1")
    try:
        figure = spun_up_polytrope(1.0, mass, radius, momentum, GRAVITATIONAL_CONSTANT)
    except NumericalError:
        lost = dict.fromkeys(("radius", "moment_ratio", "moment_of_inertia", "moment_fall", "period",
                              "period_over_kepler", "rotational_energy"), math.nan)  # fmt: skip
        return row | lost | {"sheds_mass": True, "beyond_kepler": False}
    period = 2 * math.pi / figure.angular_velocity
    return row | {
        "radius": figure.equatorial_radius,
        "moment_ratio": figure.polar_moment_ratio_equatorial,
        "moment_of_inertia": figure.polar_moment,
        "moment_fall": math.nan,
        "period": period,
        "period_over_kepler": period / row["kepler_period"],
        "rotational_energy": figure.kinetic_energy,
        "beyond_kepler": False,
        "sheds_mass": False,
    }


def _white_dwarf(mass: float) -> tuple[float, float]:
    """Radius in m and I/(M R^2) of cold carbon and oxygen of so many solar masses."""
    try:
        dwarf = star_of_mass(degenerate_electrons(), mass, relativistic=False)
    except ValueError as error:
        raise SceneError(f"there is no such white dwarf: {error}.") from None
    return 1e3 * dwarf.radius_km, dwarf.moment_ratio


@with_quantities(rest_mass="Msun")
def star_of_baryons(equation_of_state: Barotrope, rest_mass: float) -> NeutronStar:
    """Return the stable neutron star of a rest mass (solar masses), to 1e-10; ValueError where there is none."""
    branch = stable_branch(equation_of_state)

    def excess(log_enthalpy: float) -> float:
        enthalpy = min(max(math.exp(log_enthalpy), branch.lowest), branch.highest)
        return structure(equation_of_state, enthalpy).rest_mass / rest_mass - 1

    low, high = math.log(branch.lowest), math.log(branch.highest)
    least, most = excess(low), excess(high)
    if least > 0 or most < 0:
        raise ValueError(
            f"equation of state {equation_of_state.name}: stable stars have rest masses of "
            f"{rest_mass * (1 + least):.6g} to {rest_mass * (1 + most):.6g} solar masses, not {rest_mass:.6g}"
        )
    return star(equation_of_state, central_enthalpy=math.exp(root_between(excess, low, high, 1e-11, 1e-11)))


@with_quantities()
def shell_collapse(
    mass: Quantity = "1.4 Msun",
    radius: Quantity = "1500 km",
    period: Quantity = "100 s",
    index: float = 3.0,
    radius_after: Quantity = "12 km",
    index_after: float = 1.0,
    count: int = 160,
) -> xr.Dataset:
    """Return a rigid polytrope that collapses to another shell by shell, along `shell`, with its spectrum of j.

    angular_velocity_after is what each shell turns at if it keeps its own angular momentum, and rigid_angular_velocity
    what all do once they are locked together; critical marks shells that would turn faster than an orbit where they
    fall to, and centrifugal_radius is where those stop. spectrum is the mass below each j, the same after. SceneError
    for bad quantities.

    >>> star = shell_collapse()
    >>> print(f"{float(star.enclosed_mass[-1]) / 1.98841e30:.2f}")  # solar masses
    1.40
    """
    total, size, turn = in_si(mass, "mass"), in_si(radius, "length"), in_si(period, "time")
    final = in_si(radius_after, "length")
    before = shells_of(Polytrope(index, total, size, GRAVITATIONAL_CONSTANT), 2 * math.pi / turn, count)
    after = before.collapsed(Polytrope(index_after, total, final).radius_enclosing(before.enclosed_mass))
    locked = after.locked()
    highest = before.equatorial_specific_angular_momentum.max()
    specific_momenta = np.linspace(0.0, highest, _SPECTRUM)
    along = {
        "radius": (before.radius, "m", "radius before"),
        "radius_after": (after.radius, "m", "radius after"),
        "specific_angular_momentum": (
            before.equatorial_specific_angular_momentum, "m2 s-1", "specific angular momentum at the equator"),
        "angular_velocity": (before.angular_velocity, "rad s-1", "angular velocity before"),
        "angular_velocity_after": (after.angular_velocity, "rad s-1", "angular velocity after"),
        "kepler_fraction": (after.keplerian_fraction, "1", "rate after over that of an orbit at the shell"),
        "critical": (after.critical, "1", "whether the shell turns faster than an orbit where it falls to"),
        "centrifugal_radius": (after.centrifugal_radius, "m", "where its equator would turn like an orbit"),
        "rigid_kepler_fraction": (locked.keplerian_fraction, "1", "the same when the shells are locked together"),
    }  # fmt: skip
    spectra = {
        "spectrum": (before.spectrum(specific_momenta), "kg", "mass of lower specific angular momentum"),
        "spectrum_after": (after.spectrum(specific_momenta), "kg", "the same after the collapse"),
    }
    return xr.Dataset(
        variables("shell", along) | variables("j", spectra),
        variables("shell", {"enclosed_mass": (before.enclosed_mass, "kg", "mass inside")})
        | variables("j", {"j": (specific_momenta, "m2 s-1", "specific angular momentum about the axis")}),
        {
            "title": "a collapse in which each shell keeps its angular momentum",
            "angular_momentum": after.angular_momentum,
            "rigid_angular_velocity": after.mean_angular_velocity,
            "shear_energy": after.shear_energy,
            "rotational_energy_before": before.rotational_energy,
            "rotational_energy_after": after.rotational_energy,
            "rotational_energy_rigid": locked.rotational_energy,
        },
    )
