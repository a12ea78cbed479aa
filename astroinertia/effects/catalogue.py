"""Every effect that a scene can list: its options, where it lives and what it costs, as plain data.

A scene never names code: it names a kind, which is looked up here, and only that kind's module is imported.
"""

import importlib
from collections.abc import Mapping
from typing import Any

from astroinertia.effects import sizes
from astroinertia.effects.entries import AXIS as AXIS, FORCE_ERROR as FORCE_ERROR, Entry as Entry
from astroinertia.effects.heat_entries import HEAT
from astroinertia.effects.rigid_entries import RIGID
from astroinertia.units import (
    ALL_MODELS as ALL_MODELS,
    LIGHT as LIGHT,
    REQUIRED as REQUIRED,
    Default as Default,
    Option as Option,
    not_negative,
    positive,
)

CATALOGUE: Mapping[str, Entry] = {
    "gravity": Entry(
        "astroinertia.effects.gravity",
        "Gravity",
        "self-gravity of the body (particles are softened by their own kernel)",
        {
            "method": Option(
                "choice",
                "auto",
                "how particles attract each other: direct sums over all pairs, exact and N^2; multipole expansions of "
                "far groups, to an error that is asked for; auto is what takes less time",
                choices=("auto", "direct", "multipole"),
                models=("sph",),
            ),
            "force_error": Option(
                "dimensionless",
                FORCE_ERROR,
                "of multipole: wanted rms of the relative error of the accelerations",
                minimum=1e-8,
                maximum=0.03,
                models=("sph",),
            ),
            "softening": Option(
                "length",
                None,
                "smoothing length of every particle, kept as it is, where no effect acts between neighbours; without "
                "it, lengths follow the density",
                minimum=0.0,
                exclusive=True,
                models=("sph",),
            ),
            "order": Option(
                "choice",
                "second",
                "order in the smoothing length of the error of the binding energy: fourth takes out what softening "
                "leaves out of it",
                choices=("second", "fourth"),
                models=("sph",),
            ),
        },
        "all pairs",
        "Price & Monaghan 2007; Dehnen 2014",
        ALL_MODELS,
        size=sizes.GRAVITY,
        colour="blue",
        auto="always",
    ),
    "pressure": Entry(
        "astroinertia.effects.pressure",
        "Pressure",
        "pressure gradient of the fluid",
        {
            "order": Option(
                "choice",
                "second",
                "order in the smoothing length of the error of densities: fourth takes out what smoothing adds to them",
                choices=("second", "fourth"),
                models=("sph",),
            ),
            "gradients": Option(
                "choice",
                "kernel",
                "the kernel's own slope, which keeps the entropy of smooth flow exact; or integral, of a matrix that "
                "straightens out how neighbours lie: less noise in subsonic flow, no surface tension at contacts",
                choices=("kernel", "integral"),
                models=("sph",),
            ),
        },
        "neighbours",
        "Springel & Hernquist 2002",
        ALL_MODELS,
        size=sizes.PRESSURE,
        gradients=lambda options: options["order"] == "fourth" or options["gradients"] == "integral",
        colour="vermillion",
        auto="always",
        limit_power=1.0 / 3.0,
    ),
    "viscosity": Entry(
        "astroinertia.effects.viscosity",
        "Viscosity",
        "artificial viscosity, which captures shocks",
        {
            "alpha_max": positive("dimensionless", 1.0, "linear coefficient in a shock"),
            "alpha_min": not_negative(
                "dimensionless", 0.0, "linear coefficient far from shocks, which damps noise; limiters leave it"
            ),
            "beta": not_negative("dimensionless", 4.0, "quadratic coefficient, as a multiple of the linear one"),
            "decay_length": positive("dimensionless", 10.0, "smoothing lengths over which the coefficient decays"),
            "switch": Option(
                "choice",
                "cullen_dehnen",
                "how the coefficient follows the flow: with shocks, or constant at alpha_max",
                choices=("cullen_dehnen", "none"),
            ),
            "limiter": Option(
                "choice",
                "reconstruction",
                "what keeps viscosity out of smooth flow: reconstruction sees only the jump that linear flow on both "
                "sides leaves, guarded_reconstruction more where particles are closer than they should be, balsara "
                "weakens it where the flow turns rather than converges",
                choices=("reconstruction", "guarded_reconstruction", "balsara", "none"),
            ),
        },
        "neighbours",
        "Cullen & Dehnen 2010; Monaghan 1997; Balsara 1995",
        numerical=True,
        size=sizes.VISCOSITY,
        colour="green",
        auto="always",
        needs=("pressure",),
        limit_power=1.0 / 3.0,
        gradients=lambda options: options["switch"] != "none" or options["limiter"] != "none",
    ),
    "conduction": Entry(
        "astroinertia.effects.conduction",
        "Conduction",
        "artificial conduction, which smooths jumps of thermal energy",
        {
            "coefficient": not_negative("dimensionless", 1.0, "strength of the exchange of thermal energy"),
            "signal": Option(
                "choice",
                "relative_velocity",
                "speed of the exchange: relative_velocity leaves a star in equilibrium alone, pressure_jump is for "
                "contact discontinuities without gravity",
                choices=("relative_velocity", "pressure_jump"),
            ),
        },
        "neighbours",
        "Price 2008; Wadsley, Veeravalli & Couchman 2008",
        numerical=True,
        size=sizes.CONDUCTION,
        colour="orange",
        auto="touching",
        needs=("pressure",),
        limit_power=1.0 / 3.0,
    ),
    "damping": Entry(
        "astroinertia.effects.damping",
        "Damping",
        "drag towards rest or rigid rotation, for relaxation",
        {
            "time_scale": positive("time", REQUIRED, "time over which velocities decay by a factor e"),
            "rate": Option("angular_velocity", None, "rotation rate that velocities decay to; to rest without it"),
            "rate_change": Option("angular_acceleration", None, "constant change of that rate with time, from time 0"),
            "axis": Option("dimensionless", AXIS, "axis of that rotation", shape=(3,)),
            "until": not_negative("time", None, "when the damping ends; never without it"),
            "frame": Option(
                "choice",
                "centre_of_mass",
                "what the velocities are relative to",
                choices=("centre_of_mass", "inertial"),
            ),
        },
        "particles",
        "Gingold & Monaghan 1977",
        ("sph", "ellipsoid"),
        size=sizes.DAMPING,
        colour="purple",
        pace=lambda options: (options["time_scale"], options["until"]),
    ),
    "rotating_frame": Entry(
        "astroinertia.effects.rotating_frame",
        "RotatingFrame",
        "centrifugal, Coriolis and Euler forces of a frame that rotates about its origin",
        {
            "rate": Option("angular_velocity", REQUIRED, "rotation rate of the frame at time 0"),
            "rate_change": Option("angular_acceleration", None, "constant change of that rate with time"),
            "axis": Option("dimensionless", AXIS, "axis of the rotation", shape=(3,)),
        },
        "particles",
        "Landau & Lifshitz 1976, Mechanics, eq. 39.7",
        ("sph", "ellipsoid"),
        size=sizes.ROTATING_FRAME,
        colour="yellow",
    ),
    "tide": Entry(
        "astroinertia.effects.tide",
        "Tide",
        "a point mass nearby, fixed or on a Kepler orbit about the origin (ellipse, parabola or hyperbola)",
        {
            "mass": positive("mass", REQUIRED, "mass of the perturber"),
            "position": Option("length", REQUIRED, "where it is: fixed, or at its pericentre", shape=(3,)),
            "period": positive("time", None, "orbital period; without it the perturber stays where it is"),
            "eccentricity": Option("dimensionless", 0.0, "of the orbit", minimum=0.0, maximum=100.0),
            "normal": Option("dimensionless", AXIS, "normal of the orbit", shape=(3,)),
            "mean_anomaly": Option("dimensionless", 0.0, "at time 0, in radians from the pericentre"),
            "pericentre_time": Option("time", None, "when a parabola or hyperbola (eccentricity >= 1) is nearest"),
            "softening": not_negative("length", 0.0, "Plummer softening of the perturber"),
            "frame": Option(
                "choice",
                "tidal",
                "tidal: relative to the acceleration of the origin, which falls freely; direct: the whole attraction",
                choices=("tidal", "direct"),
            ),
        },
        "particles",
        "Murray & Dermott 1999, chapter 2",
        ("sph", "ellipsoid"),
        size=sizes.TIDE,
        colour="sky",
    ),
    "companions": Entry(
        "astroinertia.effects.companions",
        "Companions",
        "the scene's [[companions]] as point masses beside the fluid",
        {
            "motion": Option(
                "choice",
                "orbit",
                "orbit: on the orbits that REBOUND finds, where the body is a point mass; live: they feel the fluid's "
                "gravity, and move with it",
                choices=("orbit", "live"),
            ),
            "frame": Option(
                "choice",
                "direct",
                "direct: inertial, with the centre of mass of all at rest; tidal: the body is at the origin, which "
                "falls freely",
                choices=("tidal", "direct"),
            ),
            "softening": not_negative("length", 0.0, "Plummer softening of the companions"),
        },
        "particles",
        "Rein & Liu 2012; Hernquist & Katz 1989",
        size=sizes.COMPANIONS,
        auto="companions",
    ),
    "sinks": Entry(
        "astroinertia.effects.sinks",
        "Sinks",
        "point masses that take the place of collapsing matter, and accrete what falls into them",
        {
            "density": positive("density", REQUIRED, "above which bound, converging matter becomes a sink"),
            "radius": positive("length", REQUIRED, "within which a sink accretes what is bound to it"),
            "softening": not_negative("length", 0.0, "Plummer softening of the sinks"),
            "number": Option("dimensionless", 16.0, "of sinks, at most", minimum=1.0, maximum=1000.0),
        },
        "particles",
        "Bate, Bonnell & Price 1995",
        size=sizes.SINKS,
    ),
    "external_field": Entry(
        "astroinertia.effects.external_field",
        "ExternalField",
        "a given gravitational field: uniform, quadratic, logarithmic or of a softened point mass, or their sum",
        {
            "uniform": Option("acceleration", None, "uniform acceleration g", shape=(3,)),
            "quadratic": Option(
                "inverse_time_squared", None, "symmetric matrix A of the potential (x - o).A.(x - o)/2", shape=(3, 3)
            ),
            "circular_speed": positive("velocity", None, "v of the potential v^2/2 ln(|x - o|^2 + core^2)"),
            "core": positive("length", None, "core radius of that potential"),
            "point_mass": positive("mass", None, "M of the potential -M/sqrt(|x - o|^2 + softening^2)"),
            "softening": positive("length", None, "softening of that potential"),
            "origin": Option("length", (0.0, 0.0, 0.0), "origin o of all of them", shape=(3,)),
        },
        "particles",
        "Binney & Tremaine 2008, sections 2.2 and 2.3",
        ("sph", "ellipsoid"),
        size=sizes.EXTERNAL_FIELD,
        colour="purple",
    ),
    "target_tensor": Entry(
        "astroinertia.effects.target_tensor",
        "TargetTensor",
        "a force that drives the body's inertia tensor to a given elongation, orientation or size",
        {
            "stiffness": positive(
                "inverse_time_squared", REQUIRED, "acceleration per distance, of size and elongation"
            ),
            "axis_ratios": Option(
                "dimensionless",
                None,
                "ratios of the semi-axes that the body is to have, at any size",
                shape=(3,),
                minimum=0.0,
                exclusive=True,
            ),
            "moments": Option(
                "moment_of_inertia",
                None,
                "principal moments that it is to have; give these or axis_ratios",
                shape=(3,),
                minimum=0.0,
            ),
            "first_axis": Option(
                "dimensionless",
                None,
                "where the first of them is to point; without it any orientation will do",
                shape=(3,),
            ),
            "second_axis": Option("dimensionless", None, "where the second is, what is across the first", shape=(3,)),
            "orientation_stiffness": positive(
                "inverse_time_squared", None, "of the orientation; as stiffness without it"
            ),
            "normal": Option(
                "dimensionless", None, "of the plane that alone is driven; all space without it", shape=(3,)
            ),
        },
        "particles",
        "Zajac, Jones & Glazier 2003; Merks et al. 2006",
        size=sizes.TARGET_TENSOR,
        colour="orange",
    ),
    "shear_viscosity": Entry(
        "astroinertia.effects.shear_viscosity",
        "ShearViscosity",
        "viscosity of the fluid itself, which particles have along their separations: L is kept",
        {"kinematic_viscosity": not_negative("viscosity", REQUIRED, "nu, the same everywhere")},
        "neighbours",
        "Espanol & Revenga 2003; Cleary & Monaghan 1999; Chandrasekhar 1969, section 37",
        ("sph", "ellipsoid"),
        size=sizes.SHEAR_VISCOSITY,
        colour="green",
        limit_power=2.0 / 3.0,
    ),
    "radiation_reaction": Entry(
        "astroinertia.effects.radiation_reaction",
        "RadiationReaction",
        "loss of energy and angular momentum to gravitational waves, by the quadrupole",
        {"speed_of_light": positive("velocity", LIGHT, "c; smaller than it is, all goes faster")},
        "body",
        "Burke & Thorne 1970; Misner, Thorne & Wheeler 1973, eq. 36.8",
        ("sph", "ellipsoid"),
        size=sizes.RADIATION_REACTION,
        colour="orange",
        auto="always",
    ),
    "relativistic_potential": Entry(
        "astroinertia.effects.relativistic_potential",
        "RelativisticPotential",
        "general relativity's stronger gravity in the mean over spheres, beside Newton's (one round body)",
        {"speed_of_light": positive("velocity", LIGHT, "c; smaller than it is, the body is more compact")},
        "body",
        "Marek, Dimmelmeier, Janka, Mueller & Buras 2006, case A",
        size=sizes.RELATIVISTIC_POTENTIAL,
        colour="sky",
        needs=("gravity",),
    ),
    "deleptonisation": Entry(
        "astroinertia.effects.deleptonisation",
        "Deleptonisation",
        "electrons that a collapsing core loses as it becomes denser, with what neutrinos take and push",
        {
            "fit": Option(
                "choice",
                "G15",
                "which electron fraction belongs to a density: that of a star of 15 solar masses in general "
                "relativity (G15), or of 13 in Newton's gravity (N13)",
                choices=("G15", "N13"),
            ),
            "electron_fraction": Option(
                "dimensionless",
                0.4971,
                "of the matter that the equation of state is of: it has the pressure of 4.897e14 (rho cm3/g)^(4/3) "
                "dyn/cm2 at 0.4971; gamma_1 is then 4/3",
                minimum=0.0,
                maximum=1.0,
                exclusive=True,
            ),
            "escape_energy": not_negative("energy", None, "that a neutrino carries off; 10 MeV without it"),
            "trapping_density": positive("density", None, "above which neutrinos stay; 2e12 g/cm3 without it"),
            "mass_unit": positive("mass", None, "of a scene in code units: what 1 is, in kg"),
            "length_unit": positive("length", None, "of a scene in code units: what 1 is, in m"),
        },
        "neighbours",
        "Liebendoerfer 2005; Shapiro & Teukolsky 1983",
        size=sizes.DELEPTONISATION,
        needs=("pressure",),
        presses=True,
    ),
    **HEAT,
    **RIGID,
}


def load(kind: str, entries: Mapping[str, Entry] = CATALOGUE) -> type:
    """The class of an effect, importing its module and no other effect's; KeyError for an unknown kind."""
    entry = entries[kind]
    return entry.made or getattr(importlib.import_module(entry.module), entry.class_name)


def build(kind: str, options: Mapping[str, Any] | None = None, entries: Mapping[str, Entry] = CATALOGUE) -> Any:
    """The effect from options in code units, defaults filled in; ValueError where options are missing or contradict.

    entries: of the effects that are known, those of a scene (Scene.entries).
    """
    remaining = dict(options or {})
    values = {}
    for name, option in entries[kind].options.items():
        value = remaining.pop(name, option.default)
        if isinstance(value, Default):
            raise ValueError(f"{name} is missing: {option.text}")
        values[name] = value
    if remaining:
        raise ValueError(f"{next(iter(remaining))} is not an option of {kind}")
    return load(kind, entries).from_options(values)
