"""The command `export`: its arguments, and what it writes and says. Printing is left to main.py."""

from pathlib import Path

from astroinertia.cli import result
from astroinertia.cli.parser import Add, Options

HELP = """\
formats:
  gadget   GADGET-2/4 snapshot in HDF5 (yt, pynbody, ...); needs the extra astroinertia[hdf5], as does swift
  swift    SWIFT snapshot in HDF5 (swiftsimio, pynbody)
  vtk      particles for ParaView: .vtp, and with --snapshot all a .pvd that plays them along their times
  csv      the headline series, one column a number with its unit; with --snapshot the particles, as a particle table
  zarr     everything, in chunks, for object stores and xarray.open_datatree; needs the extra astroinertia[zarr]

Numbers are those of the dataset, in SI and float64, bit for bit; files of dimensionless runs say that they are so.
Particles stay about the origin: where a SWIFT file is to start a run of SWIFT, InitialConditions:shift moves them.
Sinks and companions are in the headline series, not in snapshots. GADGET's and SWIFT's smoothing lengths follow their
definitions; the h of this package stands beside them as KernelScale(s). What is there already is never overwritten.
yt needs the units of GADGET files: yt.load(file, unit_base={"UnitLength_in_cm": 100, "UnitMass_in_g": 1000,
"UnitVelocity_in_cm_per_s": 100}); pynbody takes their time from cosmology, so prefer swift where the time matters.

GADGET and SWIFT snapshots, these and others', are read as particle tables: by `astroinertia moments`, and by a scene's
body of kind "table".

example: astroinertia export runs/pulsar_collapse --to gadget
         astroinertia export runs/pulsar_collapse --to vtk --snapshot all --output paraview
         astroinertia export runs/pulsar_collapse/pulsar_collapse.nc --to swift --snapshot 3 --output core.hdf5
         astroinertia export runs/pulsar_collapse --to csv
         astroinertia moments runs/pulsar_collapse/pulsar_collapse_gadget_027.hdf5
"""


def add_arguments(add: Add) -> None:
    """Add the options of `export`."""
    add("run", metavar="RUN", type=Path, help="folder of a run, or its netCDF file")
    add("--to", required=True, metavar="FORMAT", help="gadget, swift, vtk, csv or zarr")
    add("--snapshot", metavar="N", help="a snapshot's number from 0, last or all (default: last)")
    add(
        "--output", type=Path, metavar="PATH", help="file to write, or a folder for it (default: beside the run's file)"
    )


def report(options: Options) -> str:
    """What the command prints, once everything is written. SceneError or ArchiveError says what is wrong."""
    from astroinertia.interop.export import export

    with result.shown(options.run):
        files = export(options.run, options.to, options.snapshot, options.output)
    if len(files) > 3:
        return f"wrote {len(files)} files, {files[0]} to {files[-1]}"
    return "\n".join(f"wrote {path}" for path in files)
