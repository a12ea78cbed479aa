"""The materials of a scene: their tables of isentropes, made once."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.matter import finite_temperature, tillotson
from astroinertia.matter.isentropes import Isentropes, isentropes, tabulated
from astroinertia.matter.table_equation import read_equation
from astroinertia.scene.fluid_kinds.materials import Material, Materials
from astroinertia.scene.source import file_of_scene
from astroinertia.units import DIMENSIONLESS, CodeUnits

if TYPE_CHECKING:
    from astroinertia.matter.tabulated import Tabulated

_HOTTEST = 1e9  # J/kg, at the reference density: three times what stops two bodies that meet at 50 km/s
_THINNEST, _DENSEST = 1e-5, 30.0  # of the reference density
_NUCLEONS_HOTTEST = 1e16  # J/kg, a hundred MeV a nucleon: more than the shocks of a collapsing core leave
_NUCLEONS_FINE = 1e-4  # of the hottest: labels of matter of finite temperature are densest below a hundredth of an MeV
_STRETCHED = 0.5  # of it, the least density of matter that can be pulled: below, tension fades with the density


def materials(fluid: Materials, origin: str | None, units: CodeUnits) -> "Tabulated":
    """The equation of state of a scene's materials, in code units; files are relative to `origin`."""
    listed: tuple[Any, ...] = fluid.materials
    if units == DIMENSIONLESS:
        _refuse_units(listed, origin)
    tables = [_table(material, origin) for material in listed]
    made = tabulated(tables, units.unit("density"), units.unit("specific_energy"))
    made = replace(made, condensed=any(material.tillotson is not None for material in listed))
    if fluid.boundary_pressure is None or len(listed) == 1:
        return made
    return replace(made, standards=_standards(made, units.to_code(fluid.boundary_pressure, "pressure")))


def _standards(made: "Tabulated", pressure: float) -> np.ndarray:
    # The densities that materials have at that pressure, each on its coldest isentrope.
    from astroinertia.matter import planetary  # only here: JAX, which tables do without
    from astroinertia.matter.interior import isentrope  # only here: JAX, too

    standards = []
    for number, name in enumerate(made.names):
        try:
            standards.append(float(planetary.density(isentrope(made, number, 0.0), pressure)))
        except ValueError as error:
            raise SceneError(f"[equation_of_state] boundary_pressure, {name}: {error}.") from None
    return np.array(standards)


def _refuse_units(listed: tuple[Any, ...], origin: str | None) -> None:
    for material in listed:
        path = file_of_scene(origin, str(material.file))
        if material.file is None or finite_temperature.is_finite_temperature(path):
            continue
        if read_equation(path).stated:
            raise SceneError(
                f"[equation_of_state] materials: the file of {material.name} states units, but the scene has none "
                '(units = "code").'
            )


class Equation(NamedTuple):
    """A material's P(rho, u) as isentropes() take it, in SI; the coldest isentrope has `coldest` at the reference."""

    pressure: Callable[[float, np.ndarray], np.ndarray]
    reference_density: float
    energy_scale: float
    densities: tuple[float, float]
    greatest_energy: float
    coldest: float = 0.0


@lru_cache(maxsize=16)
def _table(material: Material, origin: str | None) -> Isentropes:
    made = equation(material, origin)
    try:
        return isentropes(material.name, *made)
    except ValueError as error:
        raise _refused(error) from None


def equation(material: Material, origin: str | None) -> Equation:
    """The equation of a material; its file is relative to `origin`."""
    try:
        return _of_file(material, origin) if material.tillotson is None else _of_tillotson(material)
    except ValueError as error:
        raise _refused(error) from None


def _refused(error: ValueError) -> SceneError:
    return SceneError(f"[equation_of_state] materials: {error}.")


def _of_tillotson(material: Material) -> Equation:
    matter: Any = getattr(tillotson, str(material.tillotson).upper())
    least, pressure = _THINNEST, matter.fluid_pressure_at
    if material.tension:
        least, pressure = _STRETCHED, matter.pressure_at
    reference = matter.reference_density
    return Equation(
        pressure, reference, matter.incipient_vaporisation, (least * reference, _DENSEST * reference),
        material.hottest or _HOTTEST,
    )  # fmt: skip


def _of_file(material: Material, origin: str | None) -> Equation:
    path, reference = file_of_scene(origin, str(material.file)), material.reference_density
    assert reference is not None  # the schema asks for it
    nucleons = finite_temperature.is_finite_temperature(path)
    if nucleons != (material.electron_fraction is not None):
        has = "needs an" if nucleons else "is no table that has an"
        raise ValueError(f"the file of {material.name} {has} electron_fraction")
    if nucleons:
        hot = finite_temperature.read_finite_temperature(path, float(material.electron_fraction or 0.0))
        table, function = hot, hot.function()
    else:
        plain = read_equation(path)
        table, function = plain, plain.function(material.tension)
    low, high = table.density[0], table.density[-1]
    if not low <= reference <= high:
        raise ValueError(f"the reference_density of {material.name} is outside the densities of its file")
    coldest = table.coldest(reference)
    hottest = material.hottest or table.hottest(reference) - coldest
    least = max(low, _STRETCHED * reference) if material.tension else low
    scale = hottest / 100  # labels are densest below
    if nucleons:
        hottest = material.hottest or min(hottest, _NUCLEONS_HOTTEST)
        scale = hottest * _NUCLEONS_FINE
    return Equation(function, reference, scale, (least, high), hottest, coldest)
