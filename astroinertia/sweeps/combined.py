"""The result of a sweep: the headline series of all members in one netCDF file, swept parameters as its dimensions.

A grid has a dimension for each parameter, which is its coordinate; other sweeps have the dimension `member`, with the
parameters along it. All members are on the same times (sweeps.common_times), NaN after their own end. Members are read
one at a time. Tests: tests/unit/sweeps/test_ensemble.py.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from astroinertia import dataset as datasets
from astroinertia.dataset.schema import CONVENTIONS, FORMAT
from astroinertia.errors import ArchiveError
from astroinertia.process import interrupts
from astroinertia.scene.sweep import GRID, Sweep, member
from astroinertia.scene.sweep_values import coordinate
from astroinertia.storage import trailer
from astroinertia.storage.archive import MANIFEST, final_name
from astroinertia.storage.atomic import hdf5_refusals, write_whole
from astroinertia.sweeps import common_times, folder as folders

OUTPUT = "output"
"""The dimension of records in older files, where members had other times."""
_KEPT = 256e6  # bytes of members that are kept in memory between the two times that they are looked at
_MOST_NAMED = 20  # members that are listed in an attribute
_TAKEN = {
    "measured_wall_time": ("s", "wall time that the member took"),
    "measured_memory": ("byte", "the most memory that the member's process held"),
}
_OF_MEMBERS = "ledger_warnings", "ended_early"  # sentences of a run, which the result has of each member
# Attributes of a run that tell of that run alone.
_OF_ONE_RUN = (
    *("scene", "plan", "overrides", "title", "choice", "effects", "absent", *_OF_MEMBERS),
    *("predicted_wall_time", "predicted_evolution_time", "predicted_memory", "predicted_steps", *_TAKEN),
)


def path(sweep: Sweep, folder: Path) -> Path:
    """Where the result is.

    >>> from astroinertia.sweeps.folder import read
    >>> print(path(read(Path("runs/sweep")), Path("runs/sweep")).name)
    sweep.nc
    """
    return folder / final_name({"name": sweep.name})


def write(sweep: Sweep, folder: Path, failures: Mapping[int, str]) -> Path:
    """Write the result of a sweep whose members are all finished or failed, whole or not at all."""
    files = {number: file for number in range(len(sweep.members)) if (file := folders.finished(folder, number))}
    layout, taken = _Layout(), np.full((len(sweep.members), len(_TAKEN)), np.nan)
    kept: dict[int, xr.Dataset] = {}
    said: dict[str, list[str]] = {name: [] for name in _OF_MEMBERS}
    room = _KEPT
    for number, file in files.items():
        data = datasets.open(file)
        if data.nbytes <= room:
            kept[number] = data
            room -= data.nbytes
        layout.note(data)
        taken[number] = [data.attrs.get(name, np.nan) for name in _TAKEN]
        for name, sentences in said.items():
            own = str(data.attrs.get(name, "")).splitlines()
            sentences += [f"{member(number)}: {sentence}" for sentence in own]
    times = common_times.common(layout.times) if files else np.zeros(0)
    layout.sizes["time"] = len(times)
    skeleton = _skeleton(sweep, failures, layout, taken, times)
    skeleton.attrs |= {name: "\n".join(sentences) for name, sentences in said.items() if sentences}

    @hdf5_refusals()
    def fill(aside: Path) -> None:
        between: list[int] = []
        skeleton.to_netcdf(aside, engine="netcdf4", format="NETCDF4")
        with netCDF4.Dataset(aside, "a") as target:
            made = {name: _variable(target, sweep, layout, name) for name in layout.variables}
            for number, file in files.items():
                data = kept.pop(number) if number in kept else datasets.open(file)
                data, interpolated = common_times.at_times(data, times)
                between += [number] if interpolated else []
                for name, variable in made.items():
                    if name in data.variables:
                        place = (*_place(sweep, number), *layout.places(data, name))
                        variable[place] = data.variables[name].values
            if between:
                target.setncattr("interpolated", _interpolated(between))
        trailer.append(aside, aside.stat().st_size)

    target = path(sweep, folder)
    with interrupts.held():
        write_whole(target, fill)
    return target


def is_written(sweep: Sweep, folder: Path, failures: Mapping[int, str]) -> bool:
    """Whether the result is there, whole, with the same members left out for the same reasons.

    One of before members that had failed were run again is right as far as it goes, and stays until it is replaced.

    >>> from astroinertia.sweeps.folder import read
    >>> sweep, place = read(Path("runs/sweep")), Path("runs/sweep")
    >>> print(is_written(sweep, place, {}), is_written(sweep, place, {1: "it sheds mass"}))
    True False
    """
    file = path(sweep, folder)
    if not trailer.is_whole(file):
        return False
    try:
        with xr.open_dataset(file) as data:
            noted = zip(data["member"].values.flat, data["failure"].values.flat, strict=True)
            return {int(number): str(why) for number, why in noted if why} == dict(failures)
    except (OSError, ValueError, KeyError):  # no such file as `write` makes
        return False


def at_end(data: xr.Dataset) -> xr.Dataset:
    """What each member ended with: the last record of every series that it has, without the dimension of records.

    Of a member that ended before others, the last that it has.

    >>> with xr.open_dataset("runs/sweep/sweep.nc") as data:
    ...     print(at_end(data).inertia_tensor.dims, data.sizes["time"])
    ('body_index', 'i', 'j') 2
    """
    records = OUTPUT if OUTPUT in data.dims else "time"
    series = data[[name for name, variable in data.data_vars.items() if records in variable.dims]]
    if records == "time":
        reached = data["mass"].notnull()
        return series.isel(time=data.sizes["time"] - 1 - reached.isel(time=slice(None, None, -1)).argmax("time"))
    return series.isel({OUTPUT: data["time"].notnull().sum(OUTPUT) - 1})  # of a member without any: of the padding


def open_members(folder: Path) -> xr.DataTree:
    """All members that have output, by name, with their snapshots, and at the root the parameters of each.

    >>> print(list(open_members(Path("runs/sweep")).children))
    ['member-0000', 'member-0001']
    """
    sweep = folders.read(folder)
    failures = {number: folders.failure(folder, number) for number in range(len(sweep.members))}
    failed = {number: failure.sentence for number, failure in failures.items() if failure}
    groups = {"/": xr.Dataset(coords=_along_members(sweep, failed))}
    for number in range(len(sweep.members)):
        place = folders.place(folder, number)
        if not (place / MANIFEST).exists():
            continue
        try:
            tree = datasets.open_tree(place)
        except ArchiveError:
            continue  # it failed before its first output
        groups |= {f"/{member(number)}{group.path.rstrip('/')}": group.to_dataset() for group in tree.subtree}
    return xr.DataTree.from_dict(groups)


@dataclass
class _Variable:
    """A variable of members: its dimensions, whether it is text, and the attributes that all agree on."""

    dims: tuple[str, ...]
    text: bool
    attrs: dict[str, Any]


@dataclass
class _Layout:
    """What members have in common: labels of each dimension, variables, attributes.

    labels: of dimensions that are labelled by texts or whole numbers, those of all members; sizes: of the others, the
    largest. times: of the records of each. shared: other real coordinates that are the same in all members; differing:
    those that are not.
    """

    labels: dict[str, list[Any]] = field(default_factory=dict)
    sizes: dict[str, int] = field(default_factory=dict)
    times: list[np.ndarray] = field(default_factory=list)
    shared: dict[str, xr.Variable] = field(default_factory=dict)
    differing: set[str] = field(default_factory=set)
    described: dict[str, dict[str, Any]] = field(default_factory=dict)
    variables: dict[str, _Variable] = field(default_factory=dict)
    attrs: dict[str, Any] | None = None

    def note(self, data: xr.Dataset) -> None:
        """Take up a member."""
        for name, size in data.sizes.items():
            self._note_dimension(str(name), size, data)
        for name in data.data_vars:
            self._note_variable(str(name), data.variables[name])
        attributes = {key: value for key, value in data.attrs.items() if key not in _OF_ONE_RUN}
        self.attrs = attributes if self.attrs is None else _agreed(self.attrs, attributes)

    def _note_dimension(self, dim: str, size: int, data: xr.Dataset) -> None:
        coordinate = data.variables.get(dim)  # an index is of a class of its own
        self.sizes[dim] = max(size, self.sizes.get(dim, 0))
        if coordinate is None:
            return
        self.described.setdefault(dim, dict(coordinate.attrs))
        if dim == "time":
            self.times.append(coordinate.values)
            return
        if coordinate.dtype.kind != "f":
            labels = self.labels.setdefault(dim, [])
            labels += [item for item in coordinate.values.tolist() if item not in labels]
            self.sizes[dim] = len(labels)
            return
        first = self.shared.setdefault(dim, coordinate)
        same = first.shape == coordinate.shape and np.allclose(first, coordinate, rtol=common_times.ROUND_OFF, atol=0.0)
        if not same:
            self.differing.add(dim)
        if dim in self.differing:
            self._note_variable(dim, coordinate)

    def _note_variable(self, name: str, variable: xr.Variable) -> None:
        noted = self.variables.get(name)
        if noted is None:
            dims = tuple(str(dim) for dim in variable.dims)
            self.variables[name] = _Variable(dims, variable.dtype.kind in "OUS", dict(variable.attrs))
        else:
            noted.attrs = _agreed(noted.attrs, variable.attrs)

    def dimension(self, dim: str) -> str:
        """The name of a dimension in the result."""
        return f"{dim}_index" if dim in self.differing else dim

    def places(self, data: xr.Dataset, name: str) -> tuple[Any, ...]:
        """Where a member's variable stands in that of the result, after the dimensions of the sweep."""
        return tuple(self._place(data, str(dim)) for dim in data.variables[name].dims)

    def _place(self, data: xr.Dataset, dim: str) -> Any:
        labels = self.labels.get(dim)
        if labels is None or dim not in data.variables:
            return slice(0, data.sizes[dim])
        places = [labels.index(item) for item in data.variables[dim].values.tolist()]
        return slice(0, len(places)) if places == list(range(len(places))) else places


def _agreed(one: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in one.items() if key in other and np.array_equal(value, other[key])}


def _interpolated(members: list[int]) -> str:
    names = [str(number) for number in members[:_MOST_NAMED]]
    names += [f"{len(members) - _MOST_NAMED} more"] if len(members) > _MOST_NAMED else []
    return (
        f"recorded at other times: members {', '.join(names)}; between their records values are linear in time, "
        "directions, phases and numbers those of the nearest record"
    )


def _skeleton(
    sweep: Sweep, failures: Mapping[int, str], layout: _Layout, taken: np.ndarray, times: np.ndarray
) -> xr.Dataset:
    """The result without what members recorded: its coordinates, what each member took, and what it says of itself."""
    coords: dict[str, Any] = {}
    along, dims, order = _along_members(sweep, failures), ("member",), np.arange(len(sweep.members))
    if sweep.kind == GRID:
        orders = [_order(values) for values in sweep.axes]
        for key, values, places in zip(sweep.keys, sweep.axes, orders, strict=True):
            coords[variable_name(key)] = _parameter(key, [values[place] for place in places], variable_name(key))
        dims, order = tuple(coords), order.reshape([len(values) for values in sweep.axes])[np.ix_(*orders)]
        coords |= {name: (dims, along[name].values[order], along[name].attrs) for name in ("member", "failure")}
    else:
        coords = along
    for dim, labels in layout.labels.items():
        coords[dim] = (dim, np.array(labels), layout.described[dim])
    if len(times):
        coords["time"] = ("time", times, layout.described["time"])
    for dim, values in layout.shared.items():
        if dim not in layout.differing:
            coords[dim] = values
    attrs = {
        **(layout.attrs or {"astroinertia_format": FORMAT, "Conventions": CONVENTIONS}),
        "title": f"{sweep.name}: a sweep of {len(sweep.members)} members",
        "scene": sweep.source,
        "sweep": sweep.kind,
        "sweep_parameters": ", ".join(sweep.keys),
        "failed_members": len(failures),
    }
    costs = {
        name: (dims, taken[order, place], {"units": unit, "long_name": text})
        for place, (name, (unit, text)) in enumerate(_TAKEN.items())
    }
    return xr.Dataset(costs, coords, attrs)


def variable_name(key: str) -> str:
    """How a swept key of a scene is called in datasets: body.mass is body_mass, for names in netCDF have no dots.

    >>> print(variable_name("body.mass"))
    body_mass
    """
    name = key.replace(".", "_").replace("-", "_")
    return name if "." in key else f"scene_{name}"


def _along_members(sweep: Sweep, failures: Mapping[int, str]) -> dict[str, Any]:
    """Parameters, numbers and failures of members, along the dimension member."""
    numbers = range(len(sweep.members))
    attributes = {
        variable_name(key): _parameter(key, [values[place] for values in sweep.members], "member")
        for place, key in enumerate(sweep.keys)
    }
    why = {"long_name": "why the numbers of a member are missing; empty where they are not"}
    return {
        **attributes,
        "member": xr.Variable("member", np.array(numbers), {"long_name": "number of the member, and of its folder"}),
        "failure": xr.Variable("member", np.array([failures.get(k, "") for k in numbers], dtype=object), why),
    }


def _parameter(key: str, values: Iterable[Any], dim: str) -> xr.Variable:
    array, unit = coordinate(list(values))
    return xr.Variable(dim, array, {"long_name": key, **({} if unit is None else {"units": unit})})


def _variable(target: netCDF4.Dataset, sweep: Sweep, layout: _Layout, name: str) -> Any:
    """A variable of the result, empty; a member a chunk, so that one can be read by itself."""
    variable = layout.variables[name]
    swept = tuple(variable_name(key) for key in sweep.keys) if sweep.kind == GRID else ("member",)
    dims = tuple(layout.dimension(dim) for dim in variable.dims)
    sizes = [layout.sizes[dim] for dim in variable.dims]
    for dim, size in zip(dims, sizes, strict=True):
        if dim not in target.dimensions:
            target.createDimension(dim, size)
    shape = (*swept, *dims)
    if variable.text:
        made = target.createVariable(name, str, shape)
    elif not all(sizes):
        made = target.createVariable(name, "f8", shape, fill_value=np.nan)
    else:
        chunks = [1] * len(swept) + sizes
        made = target.createVariable(
            name, "f8", shape, compression="zlib", complevel=4, chunksizes=chunks, fill_value=np.nan, fletcher32=True
        )
    attrs = {key: value for key, value in variable.attrs.items() if key not in ("_FillValue", "dtype")}
    beside = [index for index in layout.differing if index != name and layout.dimension(index) in dims]
    made.setncatts(attrs | {"coordinates": " ".join(["failure", *sorted(beside)])})
    return made


def _place(sweep: Sweep, number: int) -> tuple[int, ...]:
    if sweep.kind != GRID:
        return (number,)
    places = np.unravel_index(number, [len(axis) for axis in sweep.axes])
    return tuple(int(np.argmax(_order(axis) == place)) for axis, place in zip(sweep.axes, places, strict=True))


def _order(values: Sequence[Any]) -> np.ndarray:
    """The values of an axis in the order of its coordinate: numbers that go up and down are sorted, for xarray."""
    array, unit = coordinate(values)
    steps = np.diff(array) if unit is not None else np.ones(1)
    return np.arange(len(values)) if (steps > 0).all() or (steps < 0).all() else np.argsort(array, kind="stable")
