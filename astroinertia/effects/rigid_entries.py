"""Effects that turn a rigid body, as the catalogue lists them."""

from collections.abc import Mapping

from astroinertia.effects import torque_sizes
from astroinertia.effects.entries import Entry
from astroinertia.units import LIGHT, REQUIRED, Option, not_negative, positive

_FRAME = Option("choice", "inertial", "the axes that it is given in", choices=("inertial", "body"))

RIGID: Mapping[str, Entry] = {
    "constant_torque": Entry(
        "astroinertia.effects.constant_torque",
        "ConstantTorque",
        "a constant torque, in space or in the body",
        {
            "vector": Option("torque", REQUIRED, "the torque", shape=(3,)),
            "frame": _FRAME,
            "begin": not_negative("time", 0.0, "when it begins"),
            "until": not_negative("time", None, "when it ends; never without it"),
        },
        "body",
        "Goldstein, Poole & Safko 2002, section 5.5",
        ("rigid", "scaling"),
        size=torque_sizes.CONSTANT_TORQUE,
        colour="yellow",
    ),
    "impulses": Entry(
        "astroinertia.effects.impulses",
        "Impulses",
        "angular momentum that is added at once, one or many times",
        {
            "angular_momentum": Option("angular_momentum", REQUIRED, "what is added each time", shape=(3,)),
            "time": positive("time", REQUIRED, "the first time"),
            "every": positive("time", None, "how long after each the next comes; only one without it"),
            "number": Option("dimensionless", 1e9, "how many come at most", minimum=1.0),
            "frame": _FRAME,
        },
        "body",
        "Goldstein, Poole & Safko 2002, section 1.1",
        ("rigid",),
        size=torque_sizes.IMPULSES,
        colour="purple",
    ),
    "pivot": Entry(
        "astroinertia.effects.pivot",
        "Pivot",
        "uniform gravity on a body that turns about a fixed point, such as a top or a pendulum",
        {
            "gravity": Option("acceleration", REQUIRED, "the acceleration of gravity", shape=(3,)),
            "arm": Option("length", REQUIRED, "from the fixed point to the centre of mass, in body axes", shape=(3,)),
        },
        "body",
        "Goldstein, Poole & Safko 2002, section 5.7",
        ("rigid",),
        size=torque_sizes.PIVOT,
        colour="vermillion",
    ),
    "dipole_braking": Entry(
        "astroinertia.effects.dipole_braking",
        "DipoleBraking",
        "the torque by which a pulsar slows down: of a magnetic dipole, or of any braking index",
        {
            "field": positive("magnetic_field", None, "field at the magnetic equator; or give period_derivative"),
            "radius": positive("length", None, "where the field is that"),
            "speed_of_light": positive("velocity", LIGHT, "c"),
            "magnetic_axis": Option(
                "dimensionless",
                None,
                "in body axes; at right angles to the spin without it",
                shape=(3,),
                models=("rigid", "scaling"),
            ),
            "period": positive("time", None, "rotation period at which the period grows by period_derivative"),
            "period_derivative": positive("dimensionless", None, "dP/dt, instead of a field"),
            "index": Option("dimensionless", 3.0, "braking index n: the torque goes with the n-th power of the spin"),
        },
        "body",
        "Goldreich 1970; Davis & Goldstein 1970; Michel & Goldwire 1970",
        ("sph", "rigid", "scaling"),
        size=torque_sizes.DIPOLE_BRAKING,
        colour="purple",
    ),
    "internal_dissipation": Entry(
        "astroinertia.effects.internal_dissipation",
        "InternalDissipation",
        "heat from the wobble of a body that is not quite rigid, which settles to its largest moment at fixed L",
        {
            "time_scale": positive("time", REQUIRED, "in which a small wobble falls by a factor e"),
            "rate": positive(
                "angular_velocity", None, "spin that this holds at, going with its power -3; at any spin without it"
            ),
        },
        "body",
        "Bloch, Krishnaprasad, Marsden & Ratiu 1996; Burns & Safronov 1973",
        ("rigid",),
        size=torque_sizes.INTERNAL_DISSIPATION,
        colour="orange",
    ),
    "gravity_gradient": Entry(
        "astroinertia.effects.gravity_gradient",
        "GravityGradient",
        "the torque of companions on a body that is no sphere, to its quadrupole",
        {},
        "body",
        "Murray & Dermott 1999, section 5.2",
        ("rigid",),
        size=torque_sizes.GRAVITY_GRADIENT,
        colour="blue",
        auto="always",
    ),
    "tidal_torque": Entry(
        "astroinertia.effects.tidal_torque",
        "TidalTorque",
        "the torque of companions on the tides that they raise, which lag behind",
        {
            "love_number": positive("dimensionless", REQUIRED, "k_2"),
            "radius": positive("length", REQUIRED, "equatorial radius of the body"),
            "time_lag": positive("time", None, "by which tides lag, the same at all frequencies; or give quality"),
            "quality": positive("dimensionless", None, "Q, the same at all frequencies; or give relaxation_time"),
            "relaxation_time": positive("time", None, "viscosity over rigidity of a body that flows as Maxwell's"),
            "exponent": Option(
                "dimensionless", None, "alpha of Andrade's creep on top of it", minimum=0.0, maximum=1.0, exclusive=True
            ),
            "fluid_love_number": positive(
                "dimensionless", 1.5, "k_2 were it fluid; love_number is then the elastic one"
            ),
        },
        "body",
        "Mignard 1979; Goldreich & Soter 1966; Efroimsky 2012",
        ("rigid",),
        size=torque_sizes.TIDAL_TORQUE,
        colour="green",
    ),
    "rotational_deformation": Entry(
        "astroinertia.effects.rotational_deformation",
        "RotationalDeformation",
        "the bulge of an elastic body, which follows its rotation at once and so slows its wobble",
        {
            "love_number": positive("dimensionless", REQUIRED, "k_2"),
            "radius": positive("length", REQUIRED, "equatorial radius of the body"),
            "rate": not_negative(
                "angular_velocity", 0.0, "rotation about the largest moment at which the body has its moments"
            ),
        },
        "body",
        "Munk & MacDonald 1960, chapter 6; Love 1909",
        ("rigid",),
        size=torque_sizes.ROTATIONAL_DEFORMATION,
        colour="vermillion",
    ),
}
