"""Rotating core collapse by the name of a model: from a rotating equilibrium through bounce.

A name such as "A1B3G3" is one of the grid of Zwerger & Mueller (1997, A&A 320, 209), which Dimmelmeier, Font & Mueller
(2002, A&A 393, 523) took over: an n = 3 polytrope of central density 1e10 g/cm^3 with P = K rho^(4/3), K = 4.897e14 in
cgs, in rotational equilibrium under the law j_constant with scale A and T/|W| = B. It falls because below nuclear
density the exponent is then gamma_1 = G at the same K. Mass and radius follow from K, the density and the rotation.

With "G15" or "N13" in place of G, as in "A1B3G15", the exponent stays 4/3, and the core falls as it loses electrons
where it becomes denser, by the fits of Liebendoerfer (2005, ApJ 633, 1042): of a relativistic star (G15), with the
effective relativistic potential beside Newton's gravity, or of one in Newton's gravity alone (N13).
The scales A2 to A4 and the values of B have not been checked against the paper's own table yet.
Tests: tests/unit/studies/test_core_collapse.py, tests/physics/test_core_collapse.py.
"""

import math
import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.signal import find_peaks

from astroinertia import dataset as datasets
from astroinertia.accuracy.running import run_scene
from astroinertia.bodies.polytrope import Polytrope
from astroinertia.bodies.rotating_star import RotatingStar, rotating_star_with
from astroinertia.bodies.rotation_laws import RotationLaw
from astroinertia.dataset.absent import with_absent
from astroinertia.dataset.rotational_share import rotational_share
from astroinertia.dataset.variables import variables
from astroinertia.errors import SceneError
from astroinertia.matter.barotropes import polytropic_matter
from astroinertia.matter.cold_matter import CORE_COLLAPSE
from astroinertia.process.quantities import with_quantities
from astroinertia.scene import load
from astroinertia.storage import cache
from astroinertia.units import GRAVITATIONAL_CONSTANT

INDEX = 3.0
CENTRAL_DENSITY = 1.0e13  # kg/m^3
SCALES = {"A1": 5.0e7, "A2": 1.0e6, "A3": 5.0e5, "A4": 1.0e5}  # m
ROTATIONS = {"B1": 0.0025, "B2": 0.005, "B3": 0.009, "B4": 0.018, "B5": 0.04}  # T/|W|
FITS = ("G15", "N13")  # of deleptonisation
EXPONENTS = {"G1": 1.325, "G2": 1.32, "G3": 1.31, "G4": 1.30, "G5": 1.28, **dict.fromkeys(FITS, 4.0 / 3.0)}  # gamma_1
# s: past the bounce of B3
_ENDS = {"G1": 0.130, "G2": 0.100, "G3": 0.075, "G4": 0.060, "G5": 0.050, "G15": 0.130, "N13": 0.135}
_SAME_RADIUS = 1e-4  # from step to step, which leaves a thousandth of that
_CLEAR = 0.05  # of the greatest density: what a maximum stands out by
_REBOUND = 1.0 / 3.0  # of the density at bounce: a core that falls below has bounced as a whole
_AGAIN = 3.0  # times its least density: a core that reaches it falls again
_FEWEST = 16  # particles that a scene may have
_CORE = 0.1  # of the nuclear density: what is denser at bounce is the core that bounces
_NEAR = 0.005  # s, about the bounce, in which its signal is looked for


@dataclass(frozen=True)
class CoreModel:
    """One model, in SI: rotation scale A (m), T/|W| (0: at rest), gamma_1, fit of the deleptonisation ("": none)."""

    name: str
    scale: float
    rotation: float
    gamma_1: float
    fit: str = ""

    @property
    def end(self) -> float:
        """Time to follow it for, s: past the bounce, and for fast rotators until they fall again."""
        slow = next(end for code, end in _ENDS.items() if EXPONENTS[code] == self.gamma_1 and self.fit in ("", code))
        return slow if self.rotation < ROTATIONS["B4"] else 2.0 * slow


@with_quantities()
def core_model(name: str) -> CoreModel:
    """Return a model by its name, "A1B3G3", "A1B3G15", or "G3" for the core at rest; SceneError for another name.

    >>> print(core_model("A1B3G3"))
    CoreModel(name='A1B3G3', scale=50000000.0, rotation=0.009, gamma_1=1.31, fit='')
    """
    match = re.fullmatch(r"(?:(A\d)(B\d))?([GN]\d{1,2})", name)
    scale, rotation, exponent = match.groups() if match else ("", "", "")
    if exponent not in EXPONENTS or (rotation and (scale not in SCALES or rotation not in ROTATIONS)):
        raise SceneError(
            "a core has a name such as A1B3G3 (A1 to A4, B1 to B5, G1 to G5, or G15 and N13 with deleptonisation) or, "
            f'at rest, G3, not "{name}"'
        )
    fit = exponent if exponent in FITS else ""
    return CoreModel(name, SCALES.get(scale, math.inf), ROTATIONS.get(rotation, 0.0), EXPONENTS[exponent], fit)


def initial_star(model: CoreModel) -> tuple[float, float, float]:
    """Return mass (kg), equatorial radius (m) and axis ratio of the core's equilibrium; NumericalError without one.

    In units of mass M, radius R and G the star has a density d and pressure p where it is densest; K and the central
    density fix M = (K d^(4/3)/(p G))^(3/2) and R, on which the law's scale in units of R depends in turn. The outcome
    is kept in the user's cache.
    """
    pressed = CORE_COLLAPSE["reference_pressure"] / CORE_COLLAPSE["reference_density"] ** (4 / 3)  # K
    if model.rotation == 0.0:
        star = Polytrope(INDEX)
        return *_sized(pressed, star.central_density, star.central_pressure, star.central_density), 1.0
    key = cache.content_key(
        scale=model.scale, rotation=model.rotation, index=INDEX, density=CENTRAL_DENSITY, constant=pressed, version=1
    )
    if (stored := cache.load("core", key)) is not None:
        mass, radius, ratio = (float(value) for value in stored["star"])
        return mass, radius, ratio
    radius = 1.6e6
    while True:
        unit = _unit_star(model, radius)
        central = float(unit.density(0.0, 0.0))
        mass, next_radius = _sized(pressed, unit.max_density, unit.max_pressure, central)
        if abs(next_radius / radius - 1.0) < _SAME_RADIUS:
            cache.save("core", key, {"star": np.array([mass, next_radius, unit.field.axis_ratio])})
            return mass, next_radius, unit.field.axis_ratio
        radius = next_radius


def _sized(constant: float, density: float, pressure: float, central: float) -> tuple[float, float]:
    mass = (constant * density ** (4 / 3) / (pressure * GRAVITATIONAL_CONSTANT)) ** 1.5
    return mass, (central * mass / CENTRAL_DENSITY) ** (1 / 3)


def _unit_star(model: CoreModel, radius: float) -> RotatingStar:
    law = RotationLaw("j_constant", model.scale / radius)
    return rotating_star_with("rotational_to_gravitational", model.rotation, polytropic_matter(INDEX), law)


@with_quantities()
def core_scene(name: str, particles: int = 3000, end: float | None = None) -> str:
    """Return the scene of a model as TOML text, to be run as it stands; end in s."""
    if isinstance(particles, float) or particles < _FEWEST:
        raise ValueError(f"particles must be a whole number of at least {_FEWEST}, not {particles}")
    model = core_model(name)
    mass, radius, ratio = initial_star(model)
    gamma = model.gamma_1
    constant = CORE_COLLAPSE["reference_pressure"] / CORE_COLLAPSE["reference_density"] ** gamma
    if model.rotation:
        body = f'kind = "rotating_star"\nlaw = "j_constant"\nscale = "{model.scale!r} m"\naxis_ratio = {ratio!r}'
    else:
        body = 'kind = "polytrope"'
    further = f'[effects.deleptonisation]\nfit = "{model.fit}"\n' if model.fit else ""
    further += "[effects.relativistic_potential]\n" if model.fit == "G15" else ""
    source = (
        "with electrons captured as of Liebendoerfer (2005)" if model.fit else "of the grid of Zwerger & Mueller (1997)"
    )
    return f"""name = "core_{name}"
description = "Core collapse {name} {source}."

[body]
{body}
index = {INDEX!r}
particles = {particles}
mass = "{mass:.10g} kg"
radius = "{radius:.10g} m"
relax = false # it falls at once, and n = 3 of exponent 4/3 has no size of its own to settle to

[equation_of_state]
kind = "hybrid"
gamma_1 = {gamma!r}
gamma_2 = {CORE_COLLAPSE["gamma_2"]!r}
gamma_thermal = {CORE_COLLAPSE["gamma_thermal"]!r}
nuclear_density = "{CORE_COLLAPSE["nuclear_density"]!r} kg m-3"
constant = "{constant!r} kg({1 - gamma:.15g}) m({3 * gamma - 1:.15g}) s-2"

[effects.gravity]
order = "fourth" # smoothing would take part of the binding, and add to the pressure
[effects.pressure]
order = "fourth"
[effects.viscosity]
{further}
[numerics]
precision = "auto"
timesteps = "individual"
neighbours = 150 # with densities of fourth order more of them cost time alone, and particles keep better order
free_fall_factor = 0.1 # records after base steps: every 4 ms at first, and every 0.02 ms at the bounce

[time]
end = "{model.end if end is None else end!r} s"

[regions.inner]
innermost_mass = "0.5 Msun"

[regions.core]
density_above = "{_CORE * CORE_COLLAPSE["nuclear_density"]!r} kg m-3"

[output]
series_steps = 1
snapshot_every = "5 ms"
"""


@with_quantities(end="s")
def core_collapse(
    name: str,
    particles: int = 3000,
    end: float | None = None,
    settings: Sequence[str] = (),
    folder: str | PathLike[str] | None = None,
) -> xr.Dataset:
    """Run a model by name and return its series with what the bounce was like (see `with_bounce`).

    end: in s; settings: further "key=value" of the scene; folder: where the run is kept (nowhere without it).
    SceneError for a bad name or setting, NumericalError where the core has no equilibrium or the run fails.
    """
    scene = load.loads(core_scene(name, particles, end), list(settings))
    if folder is not None:
        return with_bounce(datasets.open(run_scene(scene, Path(folder))))
    with tempfile.TemporaryDirectory() as place:
        return with_bounce(datasets.open(run_scene(scene, Path(place) / scene.name)).load())


@with_absent
def with_bounce(dataset: xr.Dataset) -> xr.Dataset:
    """Return a collapse's dataset with rotational_share and gw_amplitude along time, and the bounce as attributes.

    rotational_share: T/|W| with T of the rotation shell by shell, which for cores that turn differentially is more than
    rotational_to_gravitational. gw_amplitude: A20 in m, the axisymmetric part of the strain,
    h_plus = sqrt(15/pi) sin^2(theta) A20/(8 D) (Zwerger & Mueller 1997; Dimmelmeier et al. 2002). Attributes:
    bounce_time, bounce_density, bounce_rotational_share, bounce_mean_angular_velocity, bounce_inner_spin and
    bounce_inner_radius (of the innermost 0.5 solar masses, where the run has that region), bounce_core_mass (kg, of
    what is denser than a tenth of nuclear density, likewise); about the bounce largest_rotational_share, which is
    less noisy than the share when the one densest particle is densest, least_gw_amplitude and largest_gw_amplitude;
    and dynamics, "no bounce", "multiple bounce", "rapid" or "regular" (see `dynamics`).
    """
    time, density = dataset["time"].values, dataset["density_max"].values
    share = rotational_share(dataset)
    amplitude = 8.0 * math.sqrt(math.pi / 15.0) * dataset.inertia.strain(math.pi / 2)["plus"].values
    series = {
        "rotational_share": (share, "1", "T/|W|, T of the rotation shell by shell"),
        "gw_amplitude": (amplitude, "m", "gravitational-wave amplitude A20"),
    }
    course = dataset.assign(variables("time", series))
    kind, at = dynamics(time, density, amplitude)
    attributes: dict[str, float | str] = {"dynamics": kind}
    if at is not None:
        near = np.abs(time - time[at]) < _NEAR
        attributes |= {
            "bounce_time": float(time[at]),
            "bounce_density": float(density[at]),
            "bounce_rotational_share": float(share[at]),
            "largest_rotational_share": float(share[near].max()),
            "bounce_mean_angular_velocity": float(dataset.inertia.spin_rate().values[at]),
            "least_gw_amplitude": float(amplitude[near].min()),
            "largest_gw_amplitude": float(amplitude[near].max()),
        }
        if "region" in dataset.dims and "inner" in dataset["region"]:
            inner = dataset.sel(region="inner").isel(time=at)
            attributes["bounce_inner_spin"] = float(np.linalg.norm(inner["region_angular_velocity"]))
            attributes["bounce_inner_radius"] = float(inner["region_volume_radius"])
        if "region" in dataset.dims and "core" in dataset["region"]:
            attributes["bounce_core_mass"] = float(dataset["region_mass"].sel(region="core")[at])
    return course.assign_attrs(attributes)


def dynamics(time: np.ndarray, density: np.ndarray, amplitude: np.ndarray) -> tuple[str, int | None]:
    """Return the type of a collapse and where in its series (T,) the first bounce is.

    The types of Moenchmeyer et al. (1991) and Zwerger & Mueller (1997): "multiple bounce" (II), where centrifugal force
    throws the core back as a whole, to less than a third of its density at bounce, and it falls again; "rapid" (III),
    where the signal about the bounce is more positive than negative; otherwise "regular" (I), whose signal has its
    largest, negative, peak at the bounce of matter stiffer than any rotation. The core of a rapid collapse is small and
    its signal weak: with few particles noise decides (A1B3G5: 1000 are too few, 3000 enough).
    """
    peaks, _ = find_peaks(density, prominence=_CLEAR * density.max())
    if not len(peaks):
        return "no bounce", None
    bounce = int(peaks[0])
    after = density[bounce:]
    lowest = int(after.argmin())
    falls_again = after[lowest:].max() > _AGAIN * after[lowest]
    if after[lowest] < _REBOUND * density[bounce] and falls_again:
        return "multiple bounce", bounce
    near = amplitude[np.abs(time - time[bounce]) < _NEAR]
    return ("rapid" if near.max() > -near.min() else "regular"), bounce
