"""The command `precession`: its arguments, and what it says and writes. Printing is left to main.py."""

import math
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from astroinertia.cli import result
from astroinertia.cli.parser import Add, Options
from astroinertia.errors import SceneError
from astroinertia.process.words import aligned

if TYPE_CHECKING:
    import xarray as xr

HELP = """\
The torque of a companion on the flattening of a spinning body turns its axis: the node of its equator goes back along
the plane of its orbit. The body goes around heavier companions, and lighter ones go around it: near
moons stay with the equator and add to its flattening, far ones act as the star does.

--body takes all numbers of the planets but Mercury, and the companions that matter, from the package's
tables; options beside it replace them. Another body of the tables (Ceres) has its own numbers, and needs companions.

A body of your own needs --mass, --radius, --period, --obliquity, and two of: --j2, --ellipticity, and --moment-ratio or
--polar-moment. J2 and the moment ratio go with --radius.

--companion is repeated for each, as "NAME, KEY=VALUE, ...", with the keys mass, semi_major_axis or period,
eccentricity, inclination (to the body's own orbit of what it goes around; of a moon to its mean plane) and node_period,
in which its node goes round once: the nutation is with that. The name alone is enough for a companion of --body from
the tables, and any body of the tables needs no mass.

Rates are means over all orbits, and over the turns of their nodes. A body that turns in step with its orbit, as the
Moon does, has another precession (rotation.cassini in Python).

example: astroinertia precession --body Saturn
         astroinertia precession --body Earth --companion Sun
         astroinertia precession --body Mars --moment-ratio 0.36367 --netcdf mars.nc
         astroinertia precession --body Ceres --companion "Sun, semi_major_axis=2.767 au, eccentricity=0.0785"
         astroinertia precession --mass "5.97e24 kg" --radius "6378 km" --period "23.93 h" --obliquity "23.4 deg" \\
             --j2 1.0826e-3 --moment-ratio 0.3307 --companion "Sun, semi_major_axis=1 au" \\
             --companion "moon, mass=7.35e22 kg, semi_major_axis=384400 km, inclination=5.1 deg, node_period=18.6 yr"
"""
_NEEDED = ("mass", "radius", "period", "obliquity")
_SHAPE = {"moment_ratio": "C", "polar_moment": "C", "j2": "J2", "ellipticity": "H"}  # two of the three are needed
_RATIOS = ("polar_moment_ratio", "mean_moment_ratio")
_YEAR = 31557600.0


def add_arguments(add: Add) -> None:
    """Add the options of `precession`."""
    add("--body", metavar="NAME", help="a body of the tables, such as Saturn")
    add("--mass", metavar="M", help='with its unit: "5.97e24 kg"')
    add("--radius", metavar="R", help='that J2 and the moment ratio are normalised with: "6378 km"')
    add("--period", metavar="P", help='of rotation: "23.93 h"')
    add("--obliquity", metavar="ANGLE", help='of the equator to the orbit: "23.4 deg"; above 90 deg: turns backwards')
    add("--j2", metavar="J2", help="degree-2 zonal coefficient of gravity, (C - A)/(M R^2)")
    add("--ellipticity", metavar="H", help="dynamical ellipticity, (C - A)/C")
    add("--moment-ratio", metavar="K", help="C/(M R^2), of the polar moment of inertia")
    add("--polar-moment", metavar="C", help='polar moment of inertia: "8.04e37 kg m2"')
    add("--companion", action="append", default=[], metavar="COMPANION",
        help="a companion by name, or as NAME, KEY=VALUE, ...; may be repeated")  # fmt: skip
    add("--netcdf", type=Path, metavar="FILE.nc", help="write everything as netCDF, in SI")


def report(options: Options) -> str:
    """What the command prints; the netCDF file is written first. SceneError for bad input."""
    from astroinertia.studies.own_precession import precession_of

    result.must_be_writable(options.netcdf, ".nc")
    name, numbers = _numbers(options)
    companions = _companions(options.companion, name)
    try:
        shown = precession_of(**numbers, companions=companions)
    except SceneError as error:
        raise SceneError(str(error).removeprefix("precession_of: ")) from None
    shown.attrs["body"] = name or "own body"
    result.write_netcdf(shown, options.netcdf)
    return _text(shown)


def _numbers(options: Options) -> tuple[str, dict[str, Any]]:
    """The name of a body of the tables, empty for another, and the arguments of precession_of but for companions."""
    numbers = {key: getattr(options, key) for key in (*_NEEDED, *_SHAPE) if getattr(options, key) is not None}
    name = ""
    if options.body is not None:
        name, table = _of_the_tables(options.body)
        shape = {_SHAPE[key] for key in numbers if key in _SHAPE}
        if "radius" in numbers and len(shape) < 2:
            raise SceneError(
                "--radius does not go with the J2 and the moment ratio of --body: say both, or leave it away"
            )
        for key in ("moment_ratio", "j2"):
            if len(shape | {_SHAPE[key]}) > 2 or _SHAPE[key] in shape:
                del table[key]
            else:
                shape.add(_SHAPE[key])
        numbers = table | numbers
    if missing := [key for key in _NEEDED if key not in numbers]:
        raise SceneError(f"--{missing[0]} is missing: name a body of the tables with --body, or say all of one's own")
    shape = [_SHAPE[key] for key in numbers if key in _SHAPE]
    if len(shape) != 2 or len({*shape}) != 2:
        raise SceneError("a shape takes two of --j2, --ellipticity and one of --moment-ratio and --polar-moment")
    return name, {"j2": None, "dynamical_ellipticity": numbers.pop("ellipticity", None)} | numbers


def _of_the_tables(text: str) -> tuple[str, dict[str, Any]]:
    from astroinertia.bodies.planets import body

    one = body(text)
    if one.has("c22"):
        raise SceneError(f"{one.name} turns in step with its orbit, and its axis goes with the node of that: it has no "
                         "precession of its own (rotation.cassini in Python)")  # fmt: skip
    if not (all(map(one.has, ("j2", "rotation_rate", "obliquity"))) and any(map(one.has, _RATIOS))):
        raise SceneError(f"the tables lack what the precession of {one.name} takes: say all of a body of your own")
    j2 = one.adopted("j2")
    # Of a body that turns backwards the table counts the obliquity above 90 deg, so that its spin is positive.
    return one.name, {
        "mass": one.mass, "radius": j2.radius, "j2": j2.value, "obliquity": one.value("obliquity"),
        "moment_ratio": one.moment_ratio("polar", j2.radius).value,
        "period": 2.0 * math.pi / abs(one.angular_velocity),
    }  # fmt: skip


def _companions(texts: list[str], name: str) -> list[dict[str, Any]]:
    from astroinertia.bodies.mean_orbits import mean_companions

    usual = {companion["name"].lower(): companion for companion in mean_companions(name)}
    if texts:
        return [_companion(text, usual) for text in texts]
    if not usual:
        raise SceneError(
            "no companion is named whose torque would turn the axis: say --companion, which may be repeated"
        )
    return list(usual.values())


def _companion(text: str, usual: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """A companion as it is written, with what the tables know of it."""
    from astroinertia.bodies.mean_orbits import mass_of

    parts = [part.strip() for part in text.split(",")]
    name = "" if "=" in parts[0] else parts.pop(0)
    pairs = [part.partition("=") for part in parts]
    if wrong := [
        part for part, (key, _, value) in zip(parts, pairs, strict=True) if not (key.strip() and value.strip())
    ]:
        raise SceneError(f"--companion takes NAME, KEY=VALUE, ..., not '{wrong[0]:.40}' in '{text:.60}'")
    own: dict[str, Any] = {key.strip().replace("-", "_"): value.strip() for key, _, value in pairs}
    if len(own) < len(pairs):
        raise SceneError(f"--companion '{text:.60}' says something twice")
    name = own.pop("name", name)
    table = usual.get(name.lower(), {})
    if "semi_major_axis" in own or "period" in own:  # another orbit than that of the tables
        table = {"name": name}
    if name and "mass" not in own and "mass" not in table:
        with suppress(KeyError):
            own["mass"] = mass_of(name)
    return table | ({"name": name} if name and not table else {}) | own


def _text(shown: "xr.Dataset") -> str:
    arcsecond = math.pi / 648000.0

    def cell(value: float, form: str) -> str:
        return "" if math.isnan(value) else format(value, form)

    rows: list[tuple[str, ...]] = [
        ("companion", '"/yr', "share", "its orbit to the equator", 'nutation in longitude, "', 'in obliquity, "')
    ]
    whole = float(shown["total_rate"])
    for companion in shown["companion"].values:
        one = shown.sel(companion=companion)
        rate, tilt = float(one["precession_rate"]), math.degrees(float(one["tilt"]))
        swings = [float(one[f"nutation_{way}"]) / arcsecond for way in ("longitude", "obliquity")]
        rows.append(
            (
                str(companion), cell(rate * _YEAR / arcsecond, ".5g"), cell(100.0 * rate / whole, ".2f") + " %",
                f"{tilt:.4g} deg", *(cell(swing, ".4g") for swing in swings),
            )
        )  # fmt: skip
    relative = float(shown["relativity"])
    rows.append(("relativity", f"{relative * _YEAR / arcsecond:.5g}", f"{100.0 * relative / whole:.2f} %", "", "", ""))
    lines = [f"  {line}" for line in aligned(rows)]
    way = "back" if whole > 0 else "forward"
    total = f"the equator's node goes {way} by {abs(whole) * _YEAR / arcsecond:.5g} \"/yr, once round in "
    shape = f"(C - A)/C {float(shown['dynamical_ellipticity']):.6g}, C/(M R^2) {float(shown['moment_ratio']):.6g}"
    head = f"precession of {shown.attrs['body']}, {shape}"
    return "\n".join([head, *lines, f"{total}{float(shown['total_period']) / _YEAR:.5g} yr"])
