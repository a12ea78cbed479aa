"""The command `ratios`: its arguments, and what it says and writes. Printing is left to main.py."""

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from astroinertia.cli import result
from astroinertia.cli.parser import Add, Options
from astroinertia.errors import SceneError

if TYPE_CHECKING:
    import numpy as np

    from astroinertia.bodies.planets import SolarSystemBody

HELP = """\
All ratios are I/(M R^2) of the mean moment I = (A + B + C)/3 for the mean radius R, whatever the source is normalised
with; `--body` shows the published number, too. Of the models, "hydrostatic" is what J2 (of a moon: C22) and the spin
say for a fluid, and the core is that of uniform layers with the published ratio and one assumed density.

Two uniform layers follow from two of core density, mantle density, core radius and ratio. With one of the first three
the ratio is the published one; with two of them it is a prediction, to be compared with it, and files are those of a
sweep of one value. Another ratio alone goes with what the table assumes of the layers. A value is a number in kg/m3 or
km, or has its unit: "7 g/cm3".

The error of a core has two parts. One is that of the inputs, carried through. The other is the model's: what uniform
layers leave out, which is estimated by compressing them by their own weight, and by a third layer.

A planet of your own is given by --mass, --radius (the mean one) and, unless two of densities and core radius are, by
--moment-ratio; errors are standard deviations. A crust makes three layers of it.

A sweep runs over values from START to STOP, COUNT of them, of core_density, mantle_density, core_radius, moment_ratio,
mass or radius; several sweeps make a grid. Values that no body can have are NaN in the file.

example: astroinertia ratios --body Mars
         astroinertia ratios --body Mars --compressed
         astroinertia ratios --body Mars --core-density 7000
         astroinertia ratios --body Mars --core-density 7000 --mantle-density 3400
         astroinertia ratios --mass "5.97e24 kg" --radius "6371 km" --moment-ratio 0.3307 --core-density 11000
         astroinertia ratios --plot ratios.png --netcdf ratios.nc --csv ratios.csv
         astroinertia ratios --body Mars --sweep core_density=5500:8000:26 --netcdf mars.nc --plot mars.png
"""
_DENSITIES, _LENGTHS = ("core_density", "mantle_density"), ("core_radius", "radius", "crust_thickness")
_UNCERTAIN = ("radius", "moment_ratio", *_DENSITIES)
_LAYERS = (*_DENSITIES, "core_radius", "moment_ratio")
_OWN = ("mass", "radius", "crust_thickness", "crust_density", *(f"{name}_error" for name in _UNCERTAIN))
_PARAMETERS = (*_DENSITIES, "core_radius", "moment_ratio", "mass", "radius")
_MOST_VALUES = 100_000


def add_arguments(add: Add) -> None:
    """Add the options of `ratios`."""
    add("--body", metavar="NAME", help="one body in detail, such as Mars (default: a table of all)")
    add("--mass", metavar="M", help="mass of a planet of your own, in kg or with its unit")
    add("--radius", metavar="R", help="mean radius of a planet of your own, in km or with its unit")
    add("--core-density", metavar="RHO", help="density of the core, in kg/m3 or with its unit")
    add("--mantle-density", metavar="RHO", help="density of the mantle, in kg/m3 or with its unit")
    add("--core-radius", metavar="R", help="radius of the core, in km or with its unit")
    add(
        "--moment-ratio",
        metavar="K",
        type=float,
        help="I/(M R^2) of a planet of your own, or another than the published",
    )
    for name in _UNCERTAIN:
        add(f"--{_option(name)}-error", metavar="E", help=f"its standard deviation, as --{_option(name)} is given")
    add("--crust-thickness", metavar="D", help="thickness of a crust of a planet of your own, in km or with its unit")
    add("--crust-density", metavar="RHO", help="density of that crust, in kg/m3 or with its unit")
    add("--sweep", action="append", default=[], metavar="NAME=START:STOP:COUNT",
        help="two-layer models of the body along a parameter; may be repeated")  # fmt: skip
    add(
        "--compressed",
        action="store_true",
        help="invert the same ratio and density to a core with compressed layers, too",
    )
    add("--dask", action="store_true", help="compute a sweep in parallel chunks")
    add("--csv", type=Path, metavar="FILE.csv", help="write what is shown as CSV, in SI")
    add("--netcdf", type=Path, metavar="FILE.nc", help="write what is shown as netCDF, in SI")
    add(
        "--plot",
        type=Path,
        metavar="FILE.png",
        help="draw ratios against central condensation, or a sweep over its values",
    )
    add("--markdown", action="store_true", help="print the table of all bodies as Markdown")


def report(options: Options) -> str:
    """What the command prints; files are written first. SceneError for bad input."""
    for file, suffix in ((options.csv, ".csv"), (options.netcdf, ".nc"), (options.plot, ".png")):
        result.must_be_writable(file, suffix)
    layers, own = _known(options, _LAYERS), _known(options, _OWN)
    _check_own(options, layers, own)
    one = options.body if options.body is not None or not own else _own_planet(layers, own)
    _check_goes_together(options, layers, one)
    from astroinertia.bodies.planets import body, solar_system
    from astroinertia.studies import ratio_tables
    from astroinertia.studies.core_inversion import restated
    from astroinertia.studies.moment_ratio import moment_ratio, polytropes, two_layer_sweep

    if options.sweep and one is not None:
        swept = [_sweep(text) for text in options.sweep]
        values = dict(swept)
        if len(values) < len(swept):
            raise SceneError("--sweep takes each parameter once")
        shown = two_layer_sweep(one, values, layers, options.dask).compute()
        text = ratio_tables.sweep_text(shown)
    elif one is not None:
        planet = body(one) if isinstance(one, str) else one
        stated = layers if isinstance(one, str) else {} if _inverted(layers) else _without_ratio(layers)
        inverts = {*stated} <= {"moment_ratio", "core_density"} or {*stated} <= {"moment_ratio", "mantle_density"}
        if options.compressed and not inverts:
            raise SceneError("--compressed inverts a ratio: it takes one of --core-density and --mantle-density alone")
        text = ratio_tables.body_text(planet, stated, options.compressed)
        if inverts:
            shown = moment_ratio([restated(planet, stated)])
        else:
            shown = two_layer_sweep(planet, {name: [value] for name, value in stated.items()})
    else:
        shown = moment_ratio()
        text = ratio_tables.markdown(shown) if options.markdown else ratio_tables.solar_system_text(shown)
    if options.plot is not None:
        from astroinertia.plots.moment_ratios import moment_ratio_figure
        from astroinertia.plots.ratio_sweep import ratio_sweep_figure
        from astroinertia.plots.style import save

        bodies = moment_ratio() if one is None or isinstance(one, str) else moment_ratio([*solar_system(), one])
        save(ratio_sweep_figure(shown) if options.sweep else moment_ratio_figure(bodies, polytropes()), options.plot)
    result.write_netcdf(shown, options.netcdf)
    if options.csv is not None:
        from astroinertia.storage import overwriting
        from astroinertia.storage.atomic import write_whole

        overwriting.check(options.csv, overwriting.CSV)
        write_whole(options.csv, lambda aside: shown.to_dataframe().to_csv(aside))
    return text


def _check_goes_together(options: Options, layers: dict[str, float], one: Any) -> None:
    """SceneError for options that go with one body, with none or with a sweep, and have it not."""
    if one is None and (layers or options.sweep):
        raise SceneError(
            "a density, a radius, a ratio or a sweep is of one body: name it with --body, or say --mass and --radius"
        )
    if options.sweep and options.netcdf is None and options.csv is None and options.plot is None:
        raise SceneError("a sweep needs a file to go to: --netcdf FILE.nc, --csv FILE.csv or --plot FILE.png")
    if options.compressed and (one is None or options.sweep):
        raise SceneError("--compressed is for one body in detail: name it with --body, without --sweep")
    if options.dask and not options.sweep:
        raise SceneError("--dask is for sweeps: add --sweep")
    if options.markdown and one is not None:
        raise SceneError("--markdown is for the table of all bodies: leave the body away")


def _known(options: Options, names: tuple[str, ...]) -> dict[str, float]:
    texts = {name: getattr(options, name) for name in names}
    return {
        name: _number(f"--{_option(name)}", name.removesuffix("_error"), str(value))
        for name, value in texts.items()
        if value is not None
    }


def _option(name: str) -> str:
    return name.replace("_", "-")


def _check_own(options: Options, layers: dict[str, float], own: dict[str, float]) -> None:
    """SceneError where what is said of a planet of one's own does not go together."""
    if not own:
        return
    if options.body is not None:
        raise SceneError(f"--{_option(next(iter(own)))} is of a planet of your own: leave --body away")
    if "mass" not in own or "radius" not in own:
        raise SceneError("a planet of your own needs --mass and --radius")
    for name in own:
        value = name.removesuffix("_error")
        if value not in own and value not in layers:
            raise SceneError(f"--{_option(name)} needs --{_option(value)}")
    if ("crust_thickness" in own) != ("crust_density" in own):
        raise SceneError("a crust needs --crust-thickness and --crust-density")
    if "crust_density" in own and (not _inverted(layers) or options.sweep):
        raise SceneError(
            "a crust is of three layers: say --moment-ratio and one of --core-density and --mantle-density"
        )
    if "crust_thickness" in own and own["crust_thickness"] >= own["radius"]:
        raise SceneError("--crust-thickness is not below --radius")


def _inverted(layers: dict[str, float]) -> bool:
    """Whether a core is found from the ratio and one assumed density."""
    return "moment_ratio" in layers and len(layers) == 2 and "core_radius" not in layers


def _without_ratio(layers: dict[str, float]) -> dict[str, float]:
    return {name: value for name, value in layers.items() if name != "moment_ratio"}


def _own_planet(layers: dict[str, float], own: dict[str, float]) -> "SolarSystemBody":
    from astroinertia.bodies.planets import own_body

    numbers = {**layers, **own}
    mass, radius = numbers.pop("mass"), numbers.pop("radius")
    if not _inverted(layers):
        numbers = {name: value for name, value in numbers.items() if name.startswith("moment_ratio")}
    names = {"moment_ratio": "mean_moment_ratio", "radius": "mean_radius"}
    rows = {}
    for key, value in numbers.items():
        name = key.removesuffix("_error")
        rows[names.get(name, name) + "_uncertainty" * key.endswith("_error")] = value
    return own_body("own planet", mass, radius, **rows)


def _number(option: str, name: str, text: str) -> float:
    """The SI value of a plain number in the usual unit of the quantity, or of a number with its unit; positive."""
    from astroinertia.units import quantity

    scale, kind, unit = (1e3, "length", "km") if name in _LENGTHS else (1.0, "density", "kg/m3")
    if name in ("mass", "moment_ratio"):
        scale, kind, unit = 1.0, "mass" if name == "mass" else "dimensionless", "kg" if name == "mass" else "no unit"
    try:
        value = scale * float(text)
    except ValueError:
        value = quantity(text, kind)
    if not (math.isfinite(value) and value > 0):
        raise SceneError(f"{option} takes a positive number in {unit}, not '{text:.40}'")
    return value


def _sweep(text: str) -> "tuple[str, np.ndarray]":
    import numpy as np

    parts = re.fullmatch(r"\s*([a-z_]+)\s*=([^:]+):([^:]+):\s*(\d{1,9})\s*", text)
    if not parts:
        raise SceneError(f"--sweep takes NAME=START:STOP:COUNT such as core_density=6000:9000:7, not '{text:.60}'")
    name, start, stop, count = parts.groups()
    if name not in _PARAMETERS:
        raise SceneError(f"--sweep has no parameter '{name}'; it has {', '.join(_PARAMETERS)}")
    if not 1 <= int(count) <= _MOST_VALUES:
        raise SceneError(f"--sweep takes 1 to {_MOST_VALUES} values of a parameter, not {count}")
    first, last = (_number("--sweep", name, bound.strip()) for bound in (start, stop))
    return name, np.linspace(first, last, int(count))
