"""Datasets: from a run's records in code units to xarray and netCDF in SI, and back from disk.

The headline series are a Dataset; the particles of the snapshots are another, in the group `snapshots` of the file.
"""

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from astroinertia.dataset import files as dataset_files, radii
from astroinertia.dataset.attitude import attitude_attributes, attitude_quantities
from astroinertia.dataset.bounds import ledger_warnings
from astroinertia.dataset.derived import PARTICLE_GAP_TOLERANCE, derived_quantities
from astroinertia.dataset.regions import QUANTITIES as REGIONAL, regional_quantities
from astroinertia.dataset.resolution import resolution_warnings
from astroinertia.dataset.schema import (
    COMPUTED,
    CONVENTIONS,
    FORMAT,
    INERTIAL,
    TIME_QUANTITY,
    attributes,
    code_units,
    converted,
    label,
    reason_for_absence,
)
from astroinertia.dataset.snapshots import RunFolder, append_snapshots
from astroinertia.dataset.waves import FAINT, too_faint, waves
from astroinertia.errors import ArchiveError
from astroinertia.inertia.evolution import gravitational_wave_strain, second_moment_acceleration
from astroinertia.inertia.principal import ROUND_OFF_GAP
from astroinertia.observables.quantities import (
    DERIVED,
    LABELS,
    OF_ATTITUDE,
    OF_EFFECTS,
    RECORDED,
    TIMESTEP_CRITERIA,
    Quantity,
)
from astroinertia.process import interrupts
from astroinertia.storage import trailer
from astroinertia.storage.archive import MANIFEST, SWEEP, Archive, file_of_sweep
from astroinertia.storage.atomic import archive_errors, hdf5_refusals
from astroinertia.units import DIMENSIONLESS, CodeUnits, display_unit

_OBSERVERS = ((0.0, 0.0), (np.pi / 2, 0.0))  # polar angle and azimuth of the schema's observers
_OF_THE_FRAME = (
    *("angular_momentum", "angular_velocity", "angular_speed", "rotational_energy", "rotational_to_gravitational"),
    *("momentum", "mixed_moment", "kinetic_tensor", "kinetic_energy", "spin_scaling", "figure_rotation_rate"),
    *("rotation_profile", "specific_angular_momentum_profile", "mode_pattern_speed", "bar_pattern_speed"),
    *("region_velocity", "region_angular_momentum", "region_angular_velocity", "region_rotational_energy"),
    *("region_mixed_moment", "region_kinetic_tensor", "region_rotational_to_gravitational"),
)
_TURNS = {"mode_phase": 2.0 * np.pi, "ring_mode_phase": 2.0 * np.pi, "bar_phase": np.pi}  # rad, known but for these
NO_VALUE = "the observable has no value for this body"
NOT_OF_A_RUN = "does not hold the records of a run"
Chunks = Mapping[str, int] | None


def open(path: Path | str, damaged: str = "raise", chunks: Chunks = None) -> xr.Dataset:
    """The headline series of a netCDF file, or of a run folder, finished or still in progress.

    damaged: what a damaged segment of a run folder does, "raise" (ArchiveError that names it) or "skip" (a warning, and
    its outputs are missing). chunks: as xarray takes them, for dask. The series are read at once either way: they are
    small beside the particles, and a file must not stay open whose labels were read (see open_snapshots). Raises
    ArchiveError if there is nothing to open.
    """
    path = Path(path)
    source = _source(path)
    if isinstance(source, Path):
        dataset = dataset_files.headline(source)
    else:
        with archive_errors(source.folder, NOT_OF_A_RUN):
            dataset = headline(_series(source, damaged), source.metadata)
        dataset.encoding["source"] = str(path)
    return dataset if chunks is None else dataset.chunk(chunks)


def numbers(path: Path, name: str) -> xr.DataArray:
    """One series of numbers of a file or a run folder, as it was recorded; ArchiveError where there is none of it."""
    source = _source(path)
    if isinstance(source, Path):
        return dataset_files.numbers(source, name)
    with archive_errors(source.folder, NOT_OF_A_RUN):
        return headline(_series(source, "raise"), source.metadata)[name]


def open_snapshots(path: Path | str, damaged: str = "raise", chunks: Chunks = None) -> xr.Dataset | None:
    """The particles of the snapshots, read when they are asked for; None if there are none.

    chunks: as xarray takes them, for dask; {} are those of the file, one snapshot each. damaged: as in `open`; in a run
    folder "raise" finds a damaged file when something of it is read, and "skip" reads all that there is at once.
    """
    source = _source(Path(path))
    if isinstance(source, Path):
        lazy = dataset_files.snapshots(source, chunks)
        return None if lazy is None else lazy.assign_coords(i=label("i"))
    with archive_errors(source.folder, NOT_OF_A_RUN):
        files = source.snapshots_unread(damaged)
        if not files:
            return None
        return xr.open_dataset(source.folder, engine=RunFolder, files=files, metadata=source.metadata, chunks=chunks)


def open_tree(path: Path | str, chunks: Chunks = None) -> xr.DataTree:
    """Headline series and, in the group `snapshots`, particles; with chunks, by dask."""
    groups = {"/": open(path, chunks=chunks)}
    snapshots = open_snapshots(path, chunks=chunks)
    return xr.DataTree.from_dict(groups if snapshots is None else {**groups, "/snapshots": snapshots})


def finish(
    archive: Archive,
    measured: Mapping[str, Any] | None = None,
    completed: Callable[[xr.Dataset], xr.Dataset] | None = None,
) -> Path:
    """Write the run's final netCDF file, whole or not at all, and return its path.

    measured: global attributes known only now, such as what the run took. completed: what adds to the headline series
    before they are written. Snapshots are copied segment by segment, so that memory holds one segment and the series.
    Outputs that a disk has damaged for good are listed in the attribute `lost_outputs`.
    """
    archive.must_be_writable()
    lost = {"lost_outputs": "\n".join(archive.lost)} if archive.lost else {}
    with archive_errors(archive.folder, NOT_OF_A_RUN):
        dataset = headline(_series(archive, "raise"), archive.metadata).assign_attrs({**(measured or {}), **lost})
    dataset = dataset if completed is None else completed(dataset)

    def fill(aside: Path) -> None:
        # Labels are characters, not strings: see open_snapshots.
        encoding: dict[str, dict[str, Any]] = {
            str(name): {"_FillValue": None} | ({"dtype": "S1"} if coord.dtype.kind == "U" else {})
            for name, coord in dataset.coords.items()
        }
        for name, variable in dataset.data_vars.items():
            if variable.size and variable.dtype.kind in "fi":
                encoding[str(name)] = {"zlib": True, "complevel": 4, "shuffle": True}
        for name, described in encoding.items():  # HDF5's own checksums, for whoever reads the file
            described["fletcher32"] = dataset[name].ndim > 0
        with hdf5_refusals():
            dataset.to_netcdf(aside, engine="netcdf4", format="NETCDF4", encoding=encoding)
            head = aside.stat().st_size
            count, layout = archive.snapshot_layout()
            if count:
                with netCDF4.Dataset(aside, "a") as file:
                    append_snapshots(file.createGroup("snapshots"), count, layout, archive)
        trailer.append(aside, head)

    with interrupts.held():
        return archive.finish(fill)


def headline(series: Mapping[str, np.ndarray], metadata: Mapping[str, Any]) -> xr.Dataset:
    """The headline dataset of records in code units (time leading), with everything that follows from them, in SI.

    Quantities of the schema that were not recorded are NaN with a reason; recorded ones that the schema does not know
    are kept as they are, in code units, and say so.
    """
    units, effects = code_units(metadata), list(metadata.get("effects", []))
    frame, tolerance = frame_of(metadata), gap_tolerance(metadata)
    absent, regions = metadata.get("absent", {}), metadata.get("regions", {})
    values = {name: np.asarray(array) for name, array in series.items()}
    unclosed = ledger_warnings(values, effects)
    values |= derived_quantities(values, tolerance, metadata.get("reference_radius"), metadata.get("structure", {}))
    # As angles go on, means over a time and lines between records are what they seem to be.
    values |= {name: _continued(values[name], turn) for name, turn in _TURNS.items() if name in values}
    attitude = metadata.get("model") == "rigid" and {"attitude", "torque"} <= set(values)
    if attitude:
        values |= attitude_quantities(values, "pivot" in effects, "rotational_deformation" in effects)
    if regions:
        values |= regional_quantities(values, tolerance)
    if units != DIMENSIONLESS and frame == INERTIAL and {"kinetic_tensor", "virial_tensor"} <= set(values):
        sent = _gravitational_waves(values, units)
        if too_faint(sent["gw_strain_plus"], sent["gw_strain_cross"]):
            absent = absent | dict.fromkeys(sent, FAINT)
        else:
            values |= sent
    frequency, time = values.pop("gw_frequency", np.zeros(1)), values.pop("time")
    sizes = _sizes(values, effects) | {"time": len(time), "region": len(regions), "frequency": len(frequency)}
    variables = _variables(values, metadata, sizes, absent)
    _annotate(variables, tolerance, metadata)
    seconds = converted(time, TIME_QUANTITY, units)
    if attitude:
        names = ("angular_momentum", "inertia_tensor", "attitude", *OF_ATTITUDE)
        whole = {name: variables[name][1] for name in names if name in variables} | {"time": seconds}
        for name, found in attitude_attributes(whole).items():
            variables[name][2].update(found)
    attrs = global_attributes(metadata, units, frame)
    particles = min(metadata.get("body_particles") or [math.inf])
    if warnings := resolution_warnings(series, metadata.get("neighbours"), particles, bool(metadata.get("box"))):
        attrs["resolution_warnings"] = "\n".join(warnings)
    if unclosed:
        attrs["ledger_warnings"] = "\n".join(unclosed)
    return xr.Dataset(variables, coords=_coordinates(variables, metadata, seconds, frequency), attrs=attrs)


def _continued(angles: np.ndarray, turn: float) -> np.ndarray:
    """Angles (T, ...) that are known but for whole turns, with those that are nearest to the record before."""
    steps = np.nan_to_num(np.diff(angles, axis=0, prepend=angles[:1]))
    return angles - turn * np.cumsum(np.round(steps / turn), axis=0)


def _gravitational_waves(values: Mapping[str, np.ndarray], units: CodeUnits) -> dict[str, np.ndarray]:
    """The strain that the schema's observers see, and what the waves carry off, in SI."""
    acceleration = second_moment_acceleration(values["kinetic_tensor"], values["virial_tensor"].sum(axis=1))
    acceleration, gravity = units.to_si(acceleration, "energy"), units.gravitational_constant
    plus, cross = zip(
        *(gravitational_wave_strain(acceleration, *angles, gravitational_constant=gravity) for angles in _OBSERVERS),
        strict=True,
    )
    carried = waves(units.to_si(values["time"], "time"), acceleration, gravity)
    strains = {"gw_strain_plus": np.stack(plus, axis=-1), "gw_strain_cross": np.stack(cross, axis=-1)}
    return strains | {f"gw_{name}": array for name, array in carried._asdict().items()}


def _variables(
    values: dict[str, np.ndarray], metadata: Mapping[str, Any], sizes: Mapping[str, int], absent: Mapping[str, str]
) -> dict[str, tuple]:
    """(dimensions, array, attributes) of each: the schema's, the user's own, and what neither knows."""
    units, effects, frame = code_units(metadata), list(metadata.get("effects", [])), frame_of(metadata)
    skipped, variables = metadata.get("skipped_effects", {}), {}
    schema = RECORDED | DERIVED | (REGIONAL if metadata.get("regions") else {})
    own = metadata.get("observables", {})
    own = {name: Quantity.of_description(said) for name, said in own.items() if name not in schema}
    for name, quantity in (schema | own).items():
        attrs = attributes(quantity, metadata)
        if frame != INERTIAL and name in _OF_THE_FRAME:
            attrs["comment"] = "; ".join(
                part for part in (attrs.get("comment"), "relative to the rotating frame") if part
            )
        array = values.pop(name, None)
        if array is None:
            array = np.full([sizes[dim] for dim in quantity.dims], np.nan)
        if array.dtype.kind == "f" and array.size and np.isnan(array).all():
            lacks = NO_VALUE if name in own else absent.get(name) or quantity.absent.get(str(metadata.get("model")))
            attrs["reason"] = lacks or reason_for_absence(name, effects, units == DIMENSIONLESS, frame)
        if skipped and "effect" in quantity.dims:
            array = np.concatenate([array, np.full((len(array), len(skipped), *array.shape[2:]), np.nan)], axis=1)
            attrs["skipped_effects"] = "; ".join(f"{kind}: {reason}" for kind, reason in skipped.items())
        variables[name] = (quantity.dims, converted(array, quantity, units), attrs)
    for name, origin in metadata.get("own_observables", {}).items():
        if name in own:
            variables[name][2]["origin"] = origin
    for name, quantity in (OF_EFFECTS | OF_ATTITUDE).items():
        if name in values:
            array = converted(values.pop(name), quantity, units)
            variables[name] = (quantity.dims, array, attributes(quantity, metadata))
    for name, array in values.items():
        dims = ("time", *(f"{name}_{axis}" for axis in range(array.ndim - 1)))
        attrs = {"long_name": name.replace("_", " "), "comment": "not in the schema; code units"}
        variables[name] = (dims, array, attrs)
    return variables


def _coordinates(
    variables: Mapping[str, tuple], metadata: Mapping[str, Any], seconds: np.ndarray, frequency: np.ndarray
) -> dict[str, Any]:
    """Times, labels, and the names of what there are several of."""
    # No standard_name: CF's "time" is a date, in units "since" an epoch, and this is not.
    shown = {} if code_units(metadata) == DIMENSIONLESS else {"display_unit": display_unit("s", seconds)}
    coords: dict[str, Any] = {"time": ("time", seconds, attributes(TIME_QUANTITY, metadata) | shown)}
    coords |= {name: label(name) for name in LABELS}
    effects = [*metadata.get("effects", []), *metadata.get("skipped_effects", {})]
    coords["effect"] = ("effect", np.array(effects, dtype=str), {"long_name": "effect"})
    coords["frequency"] = ("frequency", frequency, {"units": "Hz", "long_name": "frequency of the waves"})
    bins = {"long_name": "shell of equal mass, outwards"}
    coords["radius_bin"] = ("radius_bin", np.arange(variables["radius_profile"][1].shape[1]), bins)
    if "sink_mass" in variables:
        coords["sink"] = ("sink", np.arange(variables["sink_mass"][1].shape[1]), {"long_name": "sink, by age"})
    if "companion_position" in variables:
        count = variables["companion_position"][1].shape[1]
        names = metadata.get("companions") or [str(k + 1) for k in range(count)]  # older runs have no names of archives
        coords["companion"] = ("companion", np.array(names, dtype=str), {"long_name": "companion"})
    if regions := metadata.get("regions", {}):
        meaning = "; ".join(f"{name}: {text}" for name, text in regions.items())
        coords["region"] = ("region", np.array(list(regions), dtype=str), {"long_name": "region", "comment": meaning})
    return coords


def global_attributes(metadata: Mapping[str, Any], units: CodeUnits, frame: str) -> dict[str, Any]:
    """What the file says of where it came from: enough to repeat the run. Lists and tables are JSON text."""
    elsewhere = (
        "effects", "companions", "regions", "skipped_effects", "absent", "code_units", "dimensionless", "observables",
        "structure", "history",
    )  # fmt: skip
    described = {name: value for name, value in metadata.items() if name not in elsewhere}
    plain = {
        name: value if isinstance(value, str | int | float) and not isinstance(value, bool) else json.dumps(value)
        for name, value in described.items()
        if value is not None
    }
    if "reference_radius" in plain:
        plain["reference_radius"] = units.to_si(described["reference_radius"], "length")
    model, engine, precision = (str(metadata.get(name, "unknown")) for name in ("model", "engine", "precision"))
    dimensionless = units == DIMENSIONLESS
    return {
        "Conventions": CONVENTIONS,
        "title": f"{metadata['name']}: inertia tensor and ledger of forces",
        "source": f"astroinertia, model {model}, engine {engine}, precision {precision}",
        "history": "\n".join([COMPUTED, *metadata.get("history", [])]),
        "astroinertia_format": FORMAT,
        **plain,
        "frame": frame,
        "units_system": "dimensionless, G = 1" if dimensionless else "SI",
        "code_unit_mass": units.mass,
        "code_unit_length": units.length,
        "code_unit_time": units.time,
        "gravitational_constant": units.gravitational_constant,
        "code_units_comment": "the run was computed with G = 1 in these units (kg, m, s unless dimensionless)",
    }


def frame_of(metadata: Mapping[str, Any]) -> str:
    """Name of the frame that vectors and tensors are in."""
    rotating = "rotating_frame" in metadata.get("effects", [])
    return metadata.get("frame") or ("rotating with the scene's rotating_frame" if rotating else INERTIAL)


def gap_tolerance(metadata: Mapping[str, Any]) -> float:
    """How near principal moments must be to count as equal: by how exact the model's moments are."""
    usual = PARTICLE_GAP_TOLERANCE if metadata.get("model") == "sph" else ROUND_OFF_GAP
    return float(metadata.get("principal_gap_tolerance") or usual)


def _annotate(variables: dict, tolerance: float, metadata: Mapping[str, Any]) -> None:
    for name in ("principal_moments", "principal_axes", "principal_gap", "figure_rotation_rate"):
        variables[name][2]["tolerance"] = tolerance
    for name, attrs in radii.conventions(variables, metadata).items():
        variables[name][2].update(attrs)
    limits = [*metadata.get("effects", []), *TIMESTEP_CRITERIA]
    if "reason" not in variables["timestep_limit"][2]:
        flags = {"flag_values": np.arange(float(len(limits))), "flag_meanings": " ".join(limits)}
        variables["timestep_limit"][2].update(flags)


def _sizes(values: Mapping[str, np.ndarray], effects: list[str]) -> dict[str, int]:
    profiles = [values[name] for name, q in RECORDED.items() if "radius_bin" in q.dims and name in values]
    labelled = {name: len(labels) for name, (labels, _) in LABELS.items()}
    return {**labelled, "effect": len(effects), "radius_bin": profiles[0].shape[1] if profiles else 1}


def _series(archive: Archive, damaged: str) -> dict[str, np.ndarray]:
    parts = list(archive.read_series(damaged))
    if not parts:
        raise ArchiveError(f"{archive.folder} holds no output yet.")
    names = dict.fromkeys(name for part in parts for name in part)
    return {name: np.concatenate([part[name] for part in parts]) for name in names if all(name in p for p in parts)}


def _source(path: Path) -> Path | Archive:
    """The netCDF file to read, or the run folder where there is none that holds all."""
    if (path / SWEEP).exists():
        return file_of_sweep(path)
    if path.is_dir():
        archive = Archive.view(path)
        return archive.finished or archive
    if not path.exists():
        raise ArchiveError(f"{path} does not exist; give a netCDF file or a run folder.")
    if path.name == MANIFEST:
        return _source(path.parent)
    return path
