"""Moment ratios as text: the table of the solar system, one body in detail, and the guide's table in Markdown.

Tests: tests/unit/cli/test_ratios.py.
"""

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr

from astroinertia.bodies.moment_ratios import UNIFORM
from astroinertia.bodies.planets import OWN, SolarSystemBody, body
from astroinertia.errors import SceneError
from astroinertia.process.words import aligned
from astroinertia.studies.core_inversion import core_inversion, restated
from astroinertia.studies.core_model_error import (
    NO_MODEL_ERROR,
    CoreModelError,
    core_model_error,
    matter_as_dense,
    model_error_of,
)
from astroinertia.studies.moment_ratio import TWO_LAYERS, fluid_love_number, hydrostatic_moment_ratio, polytropic_index
from astroinertia.studies.two_layers import impossible

NOTHING = "-"
_EXACT = 1e-7  # of the radius of a body, by which the errors of what is stated change a core that has none
_COLUMNS = (
    "body",
    "I/(M R^2)",
    "known how",
    "hydrostatic",
    "polytrope",
    "core",
    "model error",
    "published core",
    "rho_c/mean",
)
_UNDER = (
    "I: mean moment; R: mean radius. hydrostatic: what J2 (C22) and the spin say for a fluid; - where it is none.\n"
    "polytrope: index n with this ratio. core: of uniform layers with this ratio, in km, with the errors of the\n"
    "inputs (16th to 84th percentile). model error: what compression and a third layer, left out, change of it.\n"
    "rho_c/mean: density at the centre over the mean, as published, else of the layers' core, else of the polytrope.\n"
    f"A uniform sphere has {UNIFORM:g}; `--body NAME` shows sources, radii and what is assumed."
)
_MARKDOWN_COLUMNS = ("body", "mean radius (km)", "I/(M R²)", "published as", "known how", "hydrostatic", "n", "source")


def solar_system_text(dataset: xr.Dataset) -> str:
    """Return the table that the command prints, from `studies.moment_ratio.moment_ratio`.

    >>> from astroinertia.studies.moment_ratio import moment_ratio
    >>> print("Mars" in solar_system_text(moment_ratio(["Mars"])))
    True
    """
    rows = [_COLUMNS] + [_row(dataset.isel(body=k)) for k in range(dataset.sizes["body"])]
    below = ["-" * max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join([*aligned([rows[0], below, *rows[1:]]), "", _UNDER])


def markdown(dataset: xr.Dataset) -> str:
    """Return the same bodies as a Markdown table with the published ratio, its radius and its source.

    >>> from astroinertia.studies.moment_ratio import moment_ratio
    >>> print(markdown(moment_ratio(["Mars"])).splitlines()[-1][:30])
    | Mars | 3389.5 | 0.36428(11)
    """
    lines = [f"| {' | '.join(_MARKDOWN_COLUMNS)} |", "|---" * len(_MARKDOWN_COLUMNS) + "|"]
    for k in range(dataset.sizes["body"]):
        one = dataset.isel(body=k)
        letter = "C" if str(one["published_kind"].values) == "polar" else "I"
        radius = float(one["published_radius"]) / 1e3
        cells = (
            str(one["body"].values),
            f"{float(one['mean_radius']) / 1e3:.7g}",
            _with_error(float(one["moment_ratio"]), float(one["moment_ratio_uncertainty"])),
            f"{letter} {float(one['published_moment_ratio']):.7g} at {radius:.7g} km",
            str(one["status"].values),
            _plain(float(one["hydrostatic_moment_ratio"]), ".4f"),
            _plain(float(one["polytropic_index"]), ".2f"),
            str(one["source"].values),
        )
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def body_text(one: str | SolarSystemBody, parameters: Mapping[str, float], compressed: bool = False) -> str:
    """Return one body in detail; parameters: of two layers in SI, by name. SceneError for layers that cannot be.

    compressed: with the core of compressed layers as well, of the same ratio and density, which takes seconds.

    >>> print(body_text("Mars", {}).splitlines()[0])
    Mars: mass 6.41691e+23 kg, mean radius 3389.5 km, mean density 3934 kg/m3
    """
    one = body(one) if isinstance(one, str) else one
    lines = [
        f"{one.name}: mass {one.mass:.6g} kg, mean radius {one.mean_radius / 1e3:.6g} km, "
        f"mean density {one.mean_density:.5g} kg/m3",
        "",
        f"I/(M R^2), mean moment, R = {one.mean_radius / 1e3:.6g} km",
        *_published_lines(one),
        f"  {UNIFORM:<21g} uniform sphere",
    ]
    ratio = one.moment_ratio().value if _has_ratio(one) else math.nan
    love = fluid_love_number(one)
    if math.isfinite(love):
        hydrostatic = hydrostatic_moment_ratio(love)
        lines.append(
            f"  {hydrostatic:<21.5f} hydrostatic: fluid k2 = {love:.4f} from gravity and spin, "
            f"{100 * (hydrostatic / ratio - 1):+.1f} % of the published"
        )
    elif one.has("rotation_rate"):
        lines.append("  no hydrostatic value: gravity and spin are not those of a fluid, or not known")
    if math.isfinite(ratio):
        lines.append(f"  polytrope with this ratio: n = {_plain(float(polytropic_index(ratio)), '.3f')}")
    of_table = {*parameters} <= {"moment_ratio"}
    lines += ["", *(_assumed_lines(restated(one, parameters)) if of_table else _layer_lines(one, parameters))]
    if compressed:
        lines += ["", *_compressed_lines(restated(one, parameters))]
    if one.has("core_radius"):
        lines += ["", "published core radius"]
        for row in one.published["core_radius"]:
            error = f" +- {_km(one.mean_radius, row.uncertainty)}" if math.isfinite(row.uncertainty) else ""
            note = f" ({row.note})" if row.note else ""
            lines.append(f"  {f'{_km(one.mean_radius, row.value)}{error} km':<21} {row.status}, {row.source}{note}")
    return "\n".join(lines)


def sweep_text(dataset: xr.Dataset) -> str:
    """Return what a sweep holds, in a few lines.

    >>> from astroinertia.studies.moment_ratio import two_layer_sweep
    >>> print(sweep_text(two_layer_sweep("Mars", {"core_density": [6000.0, 7000.0]})).splitlines()[0])
    two-layer models of Mars along core_density: 2 of 2 possible
    """
    possible = dataset["core_mass_fraction"].notnull()
    lines = [
        f"{dataset.attrs['title']} along {' and '.join(map(str, dataset.sizes))}: "
        f"{int(possible.sum())} of {possible.size} possible"
    ]
    for name in ("moment_ratio", "core_radius", "core_density", "mantle_density"):
        if bool(possible.any()):
            scale, unit = (1e3, "km") if name.startswith("core_radius") else (1.0, dataset[name].attrs["units"])
            ends = [f"{float(end) / scale:.6g}" for end in (dataset[name].min(), dataset[name].max())]
            ends = " to ".join(dict.fromkeys(ends))
            lines.append(f"  {name.replace('_', ' '):<16} {ends} {'' if unit == '1' else unit}".rstrip())
    return "\n".join(lines)


def _row(one: xr.Dataset) -> tuple[str, ...]:
    def value(name: str) -> float:
        return float(one[name])

    radius = value("mean_radius")
    core = NOTHING
    if math.isfinite(centre := value("core_radius")):
        up, down = value("core_radius_high") - centre, centre - value("core_radius_low")
        core = f"{_km(radius, centre)} +{_km(radius, up)} -{_km(radius, down)}"
    published = NOTHING
    if math.isfinite(value("published_core_radius")):
        published = _km(radius, value("published_core_radius"))
        if math.isfinite(error := value("published_core_radius_uncertainty")):
            published += f" +- {_km(radius, error)}"
    return (
        str(one["body"].values),
        _with_error(value("moment_ratio"), value("moment_ratio_uncertainty")),
        str(one["status"].values),
        _plain(value("hydrostatic_moment_ratio"), ".4f"),
        _plain(value("polytropic_index"), ".2f"),
        core,
        _km(radius, value("core_radius_model_error"), "+") if core != NOTHING else NOTHING,
        published,
        _plain(value("central_condensation"), ".3g"),
    )


def _has_ratio(one: SolarSystemBody) -> bool:
    return one.has("mean_moment_ratio") or one.has("polar_moment_ratio")


def _published_lines(one: SolarSystemBody) -> list[str]:
    if not _has_ratio(one):
        return []
    published = sorted(
        (
            (name[:-13], row)
            for name in ("polar_moment_ratio", "mean_moment_ratio")
            for row in one.published.get(name, ())
        ),
        key=lambda pair: not pair[1].adopted,
    )
    lines = []
    for ratio, (kind, row) in zip(one.moment_ratio_rows(), published, strict=True):
        letter = "C" if kind == "polar" else "I"
        if row.status == OWN:
            exact = not math.isfinite(ratio.uncertainty)
            stated = f"{ratio.value:.7g}" if exact else _with_error(ratio.value, ratio.uncertainty, " +- ")
            lines.append(f"  {stated:<21} as stated")
            continue
        lines.append(
            f"  {_with_error(ratio.value, ratio.uncertainty, ' +- '):<21} {ratio.status}, {ratio.source}: "
            f"{letter}/(M R^2) = {row.value:.7g} for {row.radius / 1e3:.7g} km" + (f" ({row.note})" if row.note else "")
        )
    return lines


def _assumed_lines(one: SolarSystemBody) -> list[str]:
    layers = core_inversion(one)
    if not layers.assumed:
        return ["no core is inverted: nothing is assumed for its layers; give --core-density or --mantle-density"]
    if not math.isfinite(layers.core_radius):
        _refuse(one, layers.assumed)
    exact = layers.core_radius_high - layers.core_radius_low < _EXACT * one.mean_radius
    radius, density = one.mean_radius, one.mean_density
    lines = [
        f"{'three' if one.has('crust_density') else 'two'} uniform layers with the {_whose(one)} ratio, assumed: "
        f"{layers.assumed}",
        f"  core radius          {_km(radius, layers.core_radius)} km, "
        + (
            "the inputs as exact (--core-density-error and the like state their errors)"
            if exact
            else f"between {_km(radius, layers.core_radius_low)} and {_km(radius, layers.core_radius_high)} km "
            "by the errors of the inputs (16th and 84th percentile)"
        ),
        *_model_error_lines(one, model_error_of(one)),
        f"  core density         {_rounded(density, layers.core_density)}"
        f"{_spread(density, layers.core_density_deviation)} kg/m3",
        f"  mantle density       {_rounded(density, layers.mantle_density)}"
        f"{_spread(density, layers.mantle_density_deviation)} kg/m3",
        f"  fluid k2             {layers.love_number:.4f}",
    ]
    if layers.possible_share < 0.995:
        lines.append(f"  {100 * (1 - layers.possible_share):.0f} % of what the errors allow has no such layers at all")
    return lines


def _rounded(size: float, value: float, sign: str = "") -> str:
    """A value with so many decimals as a size of its kind has three digits with, and none for large ones."""
    return f"{value:{sign}.{max(0, 2 - math.floor(math.log10(size)))}f}"


def _km(radius: float, metres: float, sign: str = "") -> str:
    """A length in km, of a body of this radius in m."""
    return _rounded(radius / 1e3, metres / 1e3, sign)


def _spread(size: float, deviation: float) -> str:
    return f" +- {_rounded(size, deviation)}" if deviation > 0.0 else ""


def _compressed_lines(one: SolarSystemBody) -> list[str]:
    from astroinertia.studies.compressed_core import compressed_core

    core, uniform = compressed_core(one), core_inversion(one)
    radius, density = one.mean_radius, one.mean_density
    matter = " and of ".join(matter_as_dense(density)[0] for density in (uniform.core_density, uniform.mantle_density))
    return [
        f"the same with layers compressed by their weight, bulk moduli of {matter}",
        f"  core radius          {_km(radius, core.core_radius)}"
        f"{_spread(radius / 1e3, core.core_radius_deviation / 1e3)} km",
        f"  core density         {_rounded(density, core.core_density)} kg/m3, "
        f"{_rounded(density, core.central_density)} at the centre",
        f"  mantle density       {_rounded(density, core.mantle_density)} kg/m3, "
        f"{_rounded(density, core.mantle_reference_density)} uncompressed",
        f"  fluid k2             {core.love_number:.4f}",
    ]


def _model_error_lines(one: SolarSystemBody, beyond: CoreModelError) -> list[str]:
    if not math.isfinite(beyond.both):
        return []
    both, compression, layer = (
        _km(one.mean_radius, change, "+") for change in (beyond.both, beyond.compression, beyond.third_layer)
    )
    return [
        f"  model error          {both} km, by what uniform layers leave out:",
        f"    compression        {compression} km alone, of layers compressed by their weight",
        f"    a third layer      {layer} km alone, of a mantle a tenth denser in its lower half",
    ]


def _refuse(one: SolarSystemBody, assumed: str) -> None:
    """SceneError for a body whose ratio no layers have with what is assumed of them."""
    values = {name: one.value(name) for name in ("core_density", "mantle_density") if one.has(name)}
    ratio = one.moment_ratio().value
    why = None if one.has("crust_density") else impossible(one.mean_density, moment_ratio=ratio, **values)
    raise SceneError(f"no uniform layers of {one.name} are like this: {why or f'I/(M R^2) {ratio:g} with {assumed}'}")


def _whose(one: SolarSystemBody) -> str:
    return "stated" if one.moment_ratio().status == OWN else "published"


def _layer_lines(one: SolarSystemBody, parameters: Mapping[str, float]) -> list[str]:
    inputs = dict(parameters)
    predicted = len(inputs) == 2 and "moment_ratio" not in inputs
    known = _has_ratio(one)
    if len(inputs) == 1 and "moment_ratio" not in inputs and known:
        inputs["moment_ratio"] = one.moment_ratio().value
    if len(inputs) != 2:
        taken = "--core-density, --mantle-density and --core-radius, or from one of them with --moment-ratio"
        raise SceneError(f"two layers of {one.name} follow from {'one or two' if known else 'two'} of {taken}")
    ratio_known = {("core_radius_ratio" if name == "core_radius" else name): value for name, value in inputs.items()}
    if "core_radius" in inputs:
        ratio_known["core_radius_ratio"] = inputs["core_radius"] / one.mean_radius
    why = impossible(one.mean_density, **ratio_known)
    if why is not None:
        raise SceneError(f"no two layers of {one.name} are like this: {why}")
    outputs = {
        name: float(value)
        for name, value in TWO_LAYERS.function(mass=one.mass, radius=one.mean_radius, **inputs).items()
    }
    compared = predicted or "moment_ratio" in parameters
    comparison = _comparison(one, outputs["moment_ratio"]) if compared else f", as {_whose(one)}"
    assumed = {name: value for name, value in inputs.items() if name in ("core_density", "mantle_density")}
    beyond = NO_MODEL_ERROR
    if "moment_ratio" in inputs and assumed:
        beyond = core_model_error(one.mean_density, one.mean_radius, inputs["moment_ratio"], None, **assumed)
    return [
        f"two uniform layers with {' and '.join(_quantity_text(name, value) for name, value in parameters.items())}",
        f"  I/(M R^2)            {outputs['moment_ratio']:.5f}{comparison}",
        f"  core radius          {_km(one.mean_radius, outputs['core_radius'])} km, "
        f"{outputs['core_radius'] / one.mean_radius:.4f} of the body's",
        *_model_error_lines(one, beyond),
        f"  core density         {_rounded(one.mean_density, outputs['core_density'])} kg/m3, "
        f"{100 * outputs['core_mass_fraction']:.1f} % of the mass",
        f"  mantle density       {_rounded(one.mean_density, outputs['mantle_density'])} kg/m3",
        f"  fluid k2             {outputs['love_number']:.4f}",
        *_hydrostatic_lines(one, outputs["love_number"]),
    ]


def _comparison(one: SolarSystemBody, ratio: float) -> str:
    if not _published_lines(one):
        return ""
    known = one.moment_ratio()
    off = ratio - known.value
    sigmas = f", {abs(off) / known.uncertainty:.1f} standard deviations" if math.isfinite(known.uncertainty) else ""
    return f", {off:+.5f} of the {_whose(one)}{sigmas}"


def _hydrostatic_lines(one: SolarSystemBody, love_number: float) -> list[str]:
    if one.synchronous or not one.has("rotation_rate"):
        return []
    measured = f" (measured {one.zonal_harmonic(one.mean_radius):.4g})" if one.has("j2") else ""
    return [f"  hydrostatic J2       {one.small_m * love_number / 3:.4g}{measured}, to first order"]


def _quantity_text(name: str, value: float) -> str:
    if name == "core_radius":
        return f"core radius {value / 1e3:g} km"
    if name == "moment_ratio":
        return f"I/(M R^2) {value:g}"
    return f"{name.replace('_', ' ')} {value:g} kg/m3"


def _plain(value: float, form: str) -> str:
    return format(value, form) if np.isfinite(value) else NOTHING


def _with_error(value: float, error: float, between: str = "(") -> str:
    """0.36428(11), or with another sign between the two."""
    if not math.isfinite(error):
        return f"{value:.4g}"
    digits = max(0, 1 - math.floor(math.log10(error)))
    if between == "(":
        return f"{value:.{digits}f}({round(error * 10**digits)})"
    return f"{value:.{digits}f}{between}{error:.{digits}f}"
