"""What functions of the library do with arguments that have units, and with wrong ones: one decorator.

An argument is known by its name, and the names are the same everywhere. Results are numbers: in SI where what was given
had units.
"""

import functools
import inspect
import re
import sys
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from itertools import combinations
from types import NoneType, UnionType
from typing import Any, TypeVar, get_args, get_origin

import numpy as np

from astroinertia.errors import AstroinertiaError, SceneError

_NAMES = {
    "mass": "mass masses mass_before mass_after core_mass layer_masses enclosed_mass",
    "length": "radius radii mean_radius equatorial_radius outer_radii outer_radius inner_radius base_radius top_radius "
    "ring_radius tube_radius core_radius radius_before radius_after remnant_radius radius_at_rest locked_until "
    "disc_until diameter height "
    "width length semi_major_axis semi_major_axes semi_axes semi_axis_x semi_axis_y distance position positions "
    "vertices points origin offset edge wall planes softening crust_thickness",
    "density": "density densities mean_density mantle_density core_density outer_density shell_density crust_density "
    "central_density inner_densities outer_densities",
    "time": "period time times relaxation_time decay_time orbital_period core_period period_before period_at_birth age "
    "characteristic_age time_span length_of_day",
    "angular_velocity": "angular_velocity rotation_rate spin_rate node_rate crust_rate superfluid_rate forcing_rate "
    "mean_motion spin_rate_after",
    "moment_of_inertia": "inertia moments moment_of_inertia transverse_moment axial_moment second_moment moment "
    "inertia_change",
    "angular_momentum": "angular_momentum orbital_angular_momentum spin_angular_momentum mixed_moment",
    "energy": "kinetic_tensor virial_tensor second_moment_acceleration excess_energy gravitational_energy",
    "velocity": "velocity velocities sound_speed speed_of_light pressure_waves shear_waves",
    "acceleration": "acceleration gravity",
    "pressure": "pressure surface_pressure rigidity bulk_modulus",
    "rate": "frequency frequencies later_frequency growth_rate",
    "power": "luminosity",
    "torque": "torque",
    "viscosity": "kinematic_viscosity",
    "specific_angular_momentum": "specific_angular_momentum",
    "angle": "inclination inclinations obliquity incline tilt polar_angle azimuth mean_anomaly true_anomaly angle",
}
DIMENSIONS: dict[str, Any] = {name: dimension for dimension, names in _NAMES.items() for name in names.split()}
"""The dimension that an argument of a name has in SI, by its name in units.DIMENSIONS or by exponents."""
EXPONENTS = {
    "gravitational_constant": (-1, 3, -2),
    "gravitational_parameter": (0, 3, -2),
    "gm": (0, 3, -2),
    "accretion_rate": (1, 0, -1),
}
# How NumPy and JAX say that shapes do not go together.
_OF_SHAPES = re.compile(
    r"broadcast|shape mismatch|inhomogeneous|core dimension|einstein sum|einsum|remapped shapes|incompatible shapes"
    r"|values to unpack|tuple index out of range|too many indices|truth value of an array",
    re.IGNORECASE,
)
# How NumPy and SciPy say that numbers are not finite.
_OF_NAN = re.compile(
    r"infs or NaNs|Eigenvalues did not converge|SVD did not converge|check for nan|convert float NaN", re.IGNORECASE
)
# How docstrings state vectors and tensors: (3,), (N, 3), (..., 3, 3).
_OF_VECTORS = re.compile(r"\(3,|, 3[,)]")
_LOOKED_AT = (list, tuple, complex, bool, np.bool_, np.complexfloating, np.ma.MaskedArray)
_OTHER_PRECISION = (np.float16, np.float32, np.longdouble)
_COMPONENTS = ("principal", "i", "j")  # dimensions of vectors and tensors in datasets, in their order there
_AXES = ("x", "y", "z")  # labels of i and j, in their order
_MECHANICAL = {"kg", "m", "s", "rad"}
_EXACT = 2**53  # whole numbers up to here are numbers of float64
_F = TypeVar("_F", bound=Callable[..., Any])


class InputError(SceneError, ValueError):
    """An argument of a function of the library has a value that it cannot have."""


class InputTypeError(SceneError, TypeError):
    """An argument of a function of the library is missing, unknown, or of a wrong type."""


def with_quantities(**in_units: str | None) -> Callable[[_F], _F]:
    """Decorates a function of the library, or a class, that takes numbers in SI, or in any units that go together.

    Quantities of astropy, and text such as "3 km", become numbers in SI by the names of arguments (DIMENSIONS), also in
    tables and lists; a quantity of another dimension, or where a plain number is meant, is refused by the argument's
    name. So are complex numbers, truth values and masked entries where a physical quantity is meant. Lists of numbers
    become arrays where an array is meant, and whole numbers of physical quantities real ones. in_units: arguments that
    are in other units than SI, each with it ("Msun"), None for one that takes plain numbers alone, or "SI" for one of
    any dimension of mass, length and time. A default
    gravitational constant of 1 becomes that of SI where anything had a unit, also that of a body which `**scale` gives
    its mass, mean radius and constant. What is wrong with arguments is an InputError or InputTypeError, which are
    ValueError and TypeError, too; arrays whose shapes do not go together are named with these shapes.
    """

    def decorated(function: Any) -> Any:
        if inspect.isclass(function):
            function.__init__ = decorated(function.__init__)
            return function
        taken: list[_Arguments] = []

        @functools.wraps(function)
        def called(*args: Any, **options: Any) -> Any:
            if any(map(_needs_a_look, args)) or any(map(_needs_a_look, options.values())):
                taken[:] = taken or [_Arguments(function, in_units)]
                args, options = taken[0].in_si(args, options)
            try:
                return function(*args, **options)
            except (TypeError, ValueError, AttributeError, IndexError, ZeroDivisionError) as error:
                if isinstance(error, AstroinertiaError) and not isinstance(error, InputTypeError):
                    raise
                refusal = _refusal(function, args, options, error)
                if refusal is None:
                    raise
                raise refusal from error

        return called

    return decorated


class _Arguments:
    """The arguments of a function, with the dimensions that they have."""

    def __init__(self, function: Any, in_units: Mapping[str, str | None]) -> None:
        self.signature, self.in_units = inspect.signature(function), in_units
        self.function = function.__qualname__.removesuffix(".__init__")
        parameters = self.signature.parameters.items()
        # What is text itself; not a table by names, whose values may be numbers.
        self.texts = {name for name, parameter in parameters if "str" in str(parameter.annotation).split("Mapping")[0]}
        self.labelled = {name for name, parameter in parameters if "DataArray" in str(parameter.annotation)}
        self.complex = {name for name, parameter in parameters if "complex" in str(parameter.annotation)}
        self.arrays = {name for name, parameter in parameters if _may_be_array(parameter)}
        self.numbers = {
            name for name, parameter in parameters if {*_kinds(parameter.annotation)} - {NoneType} in ({float}, {int})
        }
        scale = self.signature.parameters.get("scale")  # passed on to the scaling of a figure: mass, mean radius, G
        self.scales = scale is not None and scale.kind is scale.VAR_KEYWORD
        self.counts = {name for name, parameter in parameters if parameter.annotation is int}
        self.of_vectors = bool(_OF_VECTORS.search((inspect.getdoc(function) or "").partition(">>>")[0]))

    def in_si(self, args: Any, options: Any) -> tuple[Any, Any]:
        """The arguments as numbers; SceneError names one that cannot be."""
        try:
            bound = self.signature.bind(*args, **options)
        except TypeError:
            return args, options  # which the call itself says
        units = import_module("astroinertia.units")  # which stands above this room, and is loaded by who needs it
        before = dict(bound.arguments)
        by_place = {name: value for name, value in before.items() if name not in self.labelled and _is_series(value)}
        dims = _dims_in_order(by_place.values())
        before |= {name: _arranged(value, dims) for name, value in by_place.items()}
        _must_go_together({name: before[name] for name in by_place})
        for name, value in before.items():
            bound.arguments[name] = self._number(name, value, units)
        with_unit = [name for name, value in before.items() if bound.arguments[name] is not value]
        for name, value in bound.arguments.items():
            if name not in self.labelled and _is_series(value):
                value = value.values[()] if self.of_vectors or _is_by_place(value) else _bare(value)
            bound.arguments[name] = self._real(name, value)
        gravity = self.signature.parameters.get("gravitational_constant")
        if with_unit and gravity is not None and gravity.default == 1.0 and gravity.name not in before:
            self._refuse_ones(before, with_unit[0])
            bound.arguments[gravity.name] = units.GRAVITATIONAL_CONSTANT
        if with_unit and self.scales:
            scale = bound.arguments.get("scale", {})
            physical = [*scale, *(name for name in with_unit if DIMENSIONS.get(name, "angle") != "angle")]
            if physical and len(scale) < 2 and scale.keys() <= {"mass", "mean_radius"}:
                needed = {"mass": "mean_radius is", "mean_radius": "mass is"}.get(physical[0], "mass and a radius are")
                raise InputError(f"{needed} needed, too, where {physical[0]} is given with a unit.")
            bound.arguments["scale"] = {"gravitational_constant": units.GRAVITATIONAL_CONSTANT} | scale
        return bound.args, bound.kwargs

    def _refuse_ones(self, given: Mapping[str, Any], with_unit: str) -> None:
        """InputError where a mass or a size is left at 1 of any units, and something else has a unit."""
        for name, parameter in self.signature.parameters.items():
            if name in DIMENSIONS and parameter.default == 1.0 and name not in given:
                raise InputError(f"{name} of {self.function} is needed, too, where {with_unit} is given with a unit.")

    def _number(self, name: str, value: Any, units: Any) -> Any:
        if hasattr(type(value), "data_vars"):
            return value  # a dataset, whose variables say their units to whoever reads them
        if isinstance(value, Mapping) and any(map(_may_have_unit, value.values())):
            of_one = name in DIMENSIONS or name in self.in_units  # such as masses by the names of bodies
            table = {key: self._number(name if of_one else str(key), item, units) for key, item in value.items()}
            return value if all(table[key] is item for key, item in value.items()) else table
        if isinstance(value, list | tuple) and any(map(_may_have_unit, value)):
            numbers = [self._number(name, item, units) for item in value]
            return value if all(one is other for one, other in zip(numbers, value, strict=True)) else numbers
        if not _may_have_unit(value) or isinstance(value, Mapping | list | tuple):
            return value
        of = name.removesuffix("_uncertainty")
        dimension = DIMENSIONS.get(of) or (units.Dimension(*EXPONENTS[of]) if of in EXPONENTS else None)
        if isinstance(value, str):
            return self._text(name, value, units, dimension)
        if _is_labelled(value):
            own = None if dimension is None else units.si_unit(dimension)
            meant, unit = self.in_units.get(name, own), value.attrs["units"]
            if name in self.labelled or unit in ("", "1") or (meant is None and name not in self.in_units):
                return value
            if unit == meant:
                return _bare(value)
        quantity = self._said(name, lambda: units.with_unit(value))
        if name in self.in_units:
            return self._said(name, lambda: self._in_own(units, quantity, name))
        return self._said(name, lambda: units.in_si(quantity, dimension))

    def _text(self, name: str, value: str, units: Any, dimension: Any) -> Any:
        if name in self.texts or _is_number(value):
            return value
        if self.in_units.get(name) is not None:
            return self._said(name, lambda: self._in_own(units, units.parsed(value), name))
        if name in self.in_units or dimension is None:
            return value
        return self._said(name, lambda: units.quantity(value, dimension))

    def _in_own(self, units: Any, quantity: Any, name: str) -> Any:
        """The numbers of a quantity in the unit that its argument has."""
        unit = self.in_units[name]
        if unit != "SI":
            return units.in_unit(quantity, unit)
        if not {str(base) for base in quantity.si.unit.bases} <= _MECHANICAL:
            raise SceneError(f"must be in units of mass, length and time, not in {quantity.unit}.")
        return units.in_unit(quantity, str(quantity.si.unit))

    def _real(self, name: str, value: Any) -> Any:
        """The value, a list of numbers as an array where one is meant; InputError where a quantity cannot be so."""
        if name in self.numbers and _is_one_number(value):
            # A number in single precision would round what it is multiplied with.
            value = int(value) if value.dtype.kind in "iu" else float(value)
        if isinstance(value, list | tuple) and (name in self.arrays or _is_physical(name)):
            try:
                array = _array_of(value)
            except (ValueError, TypeError):  # rows of differing length, which some mean
                return value
            value = array if name in self.arrays and array.dtype.kind in "iufcb" and array.size else value
        if isinstance(value, bool | np.bool_) and (name in self.numbers or _is_physical(name)):
            raise InputError(f"{name} must be a number, not {bool(value)}.")
        if isinstance(value, str) and name in self.numbers:
            wanted = _wanted(self.signature.parameters[name], value)
            raise InputTypeError(f"{name} of {self.function} must be {wanted}, not {value!r:.60}.")
        if not (_is_physical(name) or name in self.in_units):
            return value
        kind = _dtype_kind(value)
        may_be_complex = name in self.complex or DIMENSIONS.get(name) == "rate"  # what dies away has such a frequency
        if (isinstance(value, complex) or kind == "c") and not may_be_complex:
            raise InputError(f"{name} must be real, not complex.")
        if kind == "b":
            raise InputError(f"{name} must be an array of numbers, not of True and False.")
        if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
            raise InputError(f"{name} has masked entries; give those that are not, as of {name}.compressed().")
        if name in self.counts:
            return value
        whole: Any = value
        # Products of whole numbers overflow, without a word.
        return 1.0 * whole if kind in ("i", "u") or type(value) is int else value

    @staticmethod
    def _said(name: str, convert: Callable[[], Any]) -> Any:
        try:
            return convert()
        except SceneError as error:
            raise InputError(f"{name}: {error}") from None


def _array_of(numbers: Any) -> Any:
    """A list of numbers as an array: of JAX where one has no value yet, as in a transformation."""
    try:
        return np.asarray(numbers)
    except TypeError as error:
        jax = sys.modules.get("jax")  # where it is not imported, nothing is of it
        if jax is None or not isinstance(error, jax.errors.TracerArrayConversionError):
            raise
        return jax.numpy.asarray(numbers)


def _is_one_number(value: Any) -> bool:
    """Whether it is a number of another precision than float64, or one in an array without dimensions."""
    made = type(value)
    if made in _OTHER_PRECISION:
        return True
    return (made is np.ndarray or _is_of_jax(value)) and not value.ndim and value.dtype.kind in "fiu"


def _is_of_jax(value: Any) -> bool:
    """Whether it is an array of JAX that has values, as none has in a transformation."""
    jax = sys.modules.get("jax")  # where it is not imported, nothing is of it
    return jax is not None and isinstance(value, jax.Array) and not isinstance(value, jax.core.Tracer)


def _kinds(annotation: Any) -> tuple[Any, ...]:
    """The types of a union, or the one that it is."""
    return get_args(annotation) if isinstance(annotation, UnionType) else (annotation,)


def _may_be_array(parameter: inspect.Parameter) -> bool:
    return parameter.annotation in (Any, Any | None)


def _is_number(text: str) -> bool:
    """Whether text is a plain number, which some functions take for the sake of its digits."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def _is_physical(name: str) -> bool:
    return name in DIMENSIONS or name in EXPONENTS


def _needs_a_look(value: Any) -> bool:
    """Whether it may have a unit, is a list, or holds what is no plain real number; quick for numbers and arrays."""
    made = type(value)
    if made is float:
        return False
    if made is int:
        return abs(value) > _EXACT
    if made is np.ndarray:
        return value.dtype.kind != "f" or not value.ndim
    return (
        isinstance(value, _LOOKED_AT)
        or _dtype_kind(value) in ("i", "u")
        or _is_one_number(value)
        or _may_have_unit(value)
        or _is_series(value)
    )


def _dtype_kind(value: Any) -> str | None:
    return getattr(getattr(value, "dtype", None), "kind", None)


def _may_have_unit(value: Any) -> bool:
    """Whether it has a unit, or is text or holds other values, so that a closer look is needed; quick for numbers."""
    made = type(value)
    if made is float or made is int:
        return False
    if isinstance(value, list | tuple):
        return len(value) < 1000 and any(map(_may_have_unit, value))
    return (
        made is str or made is dict or hasattr(made, "to_astropy") or hasattr(made, "magnitude") or _is_quantity(made)
    ) or _is_labelled(value)


def _is_labelled(value: Any) -> bool:
    """Whether it is a series of a dataset that says its unit."""
    return hasattr(type(value), "attrs") and "units" in value.attrs


def _bare(series: Any) -> Any:
    """The series without name and attributes, which are not those of what is computed from it."""
    series = series.copy(deep=False)
    series.name, series.attrs = None, {}
    return series


def _has_components(value: Any) -> bool:
    """Whether it is a series of vectors or tensors of a dataset."""
    return hasattr(type(value), "dims") and hasattr(value, "values") and any(dim in _COMPONENTS for dim in value.dims)


def _is_series(value: Any) -> bool:
    made = type(value)
    return hasattr(made, "dims") and hasattr(value, "values") and not hasattr(made, "data_vars")


def _dims_in_order(values: Iterable[Any]) -> tuple[str, ...]:
    """The dimensions of the first series of vectors or tensors, components last; none without one."""
    first = next((value for value in values if _is_series(value) and _has_components(value)), None)
    others = () if first is None else (dim for dim in first.dims if dim not in _COMPONENTS)
    return () if first is None else (*others, *_COMPONENTS)


def _arranged(value: Any, dims: tuple[str, ...]) -> Any:
    """A series with its dimensions in this order, those that are not among them first, and x, y, z in theirs.

    Arrays go by place.
    """
    ordered = tuple(sorted(value.dims, key=lambda dim: dims.index(dim) if dim in dims else -1))
    value = value if ordered == value.dims else value.transpose(*ordered)
    for dim in ("i", "j"):
        labels = [] if dim not in value.dims or dim not in value.coords else value.coords[dim].values.tolist()
        if labels != list(_AXES) and sorted(map(str, labels)) == list(_AXES):
            value = value.sel({dim: list(_AXES)})
    return value


def _must_go_together(series: Mapping[str, Any]) -> None:
    """InputError where two series have other values of a dimension that they share, such as other times."""
    for (one, first), (other, second) in combinations(series.items(), 2):
        for dim in {*first.dims} & {*second.dims} & {*first.coords} & {*second.coords}:
            if not np.array_equal(first.coords[dim].values, second.coords[dim].values):
                raise InputError(f"{one} and {other} have different values of {dim}; choose those that both have.")


def _is_by_place(series: Any) -> bool:
    """Whether a series is one value, or of vectors or tensors: labelled products sum over what has one name in both."""
    return not series.ndim or _has_components(series)


def _is_quantity(made: type) -> bool:
    units = sys.modules.get("astropy.units")  # where it is not imported, nothing is of it
    return units is not None and issubclass(made, (units.Quantity, units.UnitBase))


def _refusal(function: Any, args: Any, options: Any, error: Exception) -> SceneError | None:
    """The error to raise for one that a call ended with, where its arguments are to blame."""
    name = function.__qualname__.removesuffix(".__init__")
    first = _first(error)
    of_value, of_text = type(error) is ValueError, "could not convert string to float" in str(error)
    of_nan = isinstance(error, ValueError) and bool(_OF_NAN.search(str(error)))
    of_shapes = isinstance(first, IndexError | ZeroDivisionError) or bool(_OF_SHAPES.search(str(first)))
    if of_nan:
        return _not_finite(function, args, options)
    if of_value and not of_text and not of_shapes:
        return InputError(str(error))
    if isinstance(error, ValueError) and not of_text and not of_shapes:
        return None
    signature = inspect.signature(function)
    try:
        bound = signature.bind(*args, **options)
    except TypeError as wrong:
        listed = [
            key for key, one in signature.parameters.items() if key != "self" and one.kind <= one.POSITIONAL_OR_KEYWORD
        ]
        hint = f"; it takes {', '.join(listed) or 'none'}" if "too many" in str(wrong) else ""
        return InputTypeError(f"{name}: {wrong}{hint}.")
    if any(f"unexpected keyword argument '{key}'" in str(first) for key in options):  # passed on by the function
        return InputTypeError(f"{name}: {str(first).partition('() ')[2]}.")
    if (wrong := _of_wrong_type(signature, bound.arguments, str(error) if of_text else "")) is not None:
        return InputTypeError(f"{wrong[0]} of {name} must be {wrong[1]}.")
    if of_shapes and (misfit := _misfit(signature, bound.arguments, function, first)) is not None:
        return InputTypeError(f"{name} {misfit}.")
    return InputError(str(error)) if of_value else None


def _of_wrong_type(signature: Any, given: Mapping[str, Any], of_text: str) -> tuple[str, str] | None:
    """The first argument of a wrong type, and what it must be and is; None where there is none.

    of_text: what NumPy says of a text that is no number, empty where it says no such thing.
    """
    for key, value in given.items():  # first, for a count is rarely what an error speaks of
        if not _may_be(signature.parameters[key], value):
            return key, f"a whole number, not {value!r:.60}"
    for key, value in given.items():
        if isinstance(value, str) and repr(value) in of_text:
            return key, f"a number, not {value!r:.60}"
        if (wanted := _wanted(signature.parameters[key], value)) is not None:
            return key, f"{wanted}, not {_kind(value)}"
    for key, value in given.items():
        if isinstance(value, str) and _may_be_array(signature.parameters[key]):
            return key, f"a number or an array, not {value!r:.60}"
    return None


def _not_finite(function: Any, args: Any, options: Any) -> InputError | None:
    """The error that names the first argument which is not finite throughout; None where all are."""
    bound = inspect.signature(function).bind(*args, **options)
    for key, value in bound.arguments.items():
        numbers = np.asarray(value) if _is_numeric(value) else np.zeros(0)
        if numbers.dtype.kind == "f" and (wrong := numbers[~np.isfinite(numbers)]).size:
            return InputError(
                f"{key} of {function.__qualname__.removesuffix('.__init__')} must be finite, not {wrong[0]}."
            )
    return None


def _first(error: BaseException) -> BaseException:
    """What a refusal of a function within came from, or the error itself."""
    while isinstance(error, InputTypeError) and error.__cause__ is not None:
        error = error.__cause__
    return error


def _misfit(signature: Any, given: Mapping[str, Any], function: Any, error: BaseException) -> str | None:
    """What is wrong with the shapes of arguments, or with a zero among them; None where nothing is known of that."""
    if isinstance(error, ZeroDivisionError):
        zeros = [key for key, value in given.items() if isinstance(value, float | int | np.number) and value == 0]
        return f"divides by 0: {' or '.join(zeros)} must be another number" if zeros else None
    for key, value in given.items():
        if isinstance(value, list | tuple) and len({np.shape(row) for row in value}) > 1:
            return f"needs rows of one length for {key}"
    shapes = {key: np.shape(value) for key, value in given.items() if not isinstance(value, str) and _is_numeric(value)}
    if not any(shape or _may_be_array(signature.parameters[key]) for key, shape in shapes.items()):
        return None
    meant = {key: re.search(rf"\b{key}`? (\([^()]*\))", inspect.getdoc(function) or "") for key in shapes}
    stated = ", ".join(f"{key} {found[1]}" for key, found in meant.items() if found)
    taken = ", ".join(f"{key} {shape}" for key, shape in shapes.items())
    return f"does not take arrays of these shapes: {taken}" + (f"; it takes {stated}" if stated else "")


def _wanted(parameter: inspect.Parameter, value: Any) -> str | None:
    """What an argument must be that is clearly of a wrong type; None where it is not."""
    if value is parameter.default or parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
        return None
    made = parameter.annotation
    if get_origin(made) is Callable and callable(value):
        return None
    kinds = _kinds(made)
    listed = [kind for kind in map(get_origin, kinds) if isinstance(kind, type) and issubclass(kind, Iterable)]
    if listed and not _is_one_of(value, (*listed, *(kind for kind in kinds if isinstance(kind, type)))):
        return "a table (a dict)" if all(issubclass(kind, Mapping) for kind in listed) else "a list"
    named = all(isinstance(kind, type) and kind not in (Any, object, parameter.empty) for kind in kinds)
    physical = _is_physical(parameter.name)
    if (named and _is_one_of(value, (*kinds, float, int) if complex in kinds else kinds)) or not (named or physical):
        return None
    single = named and set(kinds) <= {float, int, NoneType} and np.ndim(value) > 0
    if (physical or float in kinds or int in kinds) and _is_numeric(value) and not single:
        return None
    words = {int: "a whole number", str: "text", bool: "True or False", NoneType: "None"}
    words |= dict.fromkeys((float, complex), "a number")
    return " or ".join(words.get(kind, f"a {kind.__name__}") for kind in kinds) if named else "a number or an array"


def _may_be(parameter: inspect.Parameter, value: Any) -> bool:
    """False for a number that has a fraction, or is infinite, where a whole one is meant."""
    made = parameter.annotation
    counts = int in (get_args(made) or (made,)) and float not in get_args(made)
    return not counts or not isinstance(value, float | np.floating) or float(value).is_integer()


def _is_one_of(value: Any, kinds: tuple[type, ...]) -> bool:
    try:
        return isinstance(value, kinds)
    except TypeError:  # of a protocol: what is plain is none
        return not isinstance(value, str | float | int | list | tuple | dict | NoneType)


def _is_numeric(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return all(map(_is_numeric, value))
    dtype = getattr(value, "dtype", None)
    return not isinstance(value, complex) and (hasattr(value, "__float__") if dtype is None else dtype.kind in "fiub")


def _kind(value: Any) -> str:
    return "None" if value is None else f"something of the type {type(value).__name__}"
