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

Numbers are those of the dataset, float64, in SI; those of GADGET's files are in its default units, kpc, 10^10 solar
masses and km/s, which its readers take for granted. Files of dimensionless runs are in code units, and say so.
Particles stay about the origin: where a SWIFT file is to start a run of SWIFT, InitialConditions:shift moves them.
Sinks and companions are in the headline series, not in snapshots. GADGET's and SWIFT's smoothing lengths follow their
definitions; the h of this package stands beside them as KernelScale(s). Existing files are never overwritten.
yt and pynbody open GADGET's files, and pynbody and swiftsimio SWIFT's, with units and time and without arguments.

GADGET and SWIFT snapshots, these and others', are read as particle tables: by `astroinertia moments`, and by a scene's
body of kind "table".

example: astroinertia export runs/pulsar_collapse --to gadget
         astroinertia export runs/pulsar_collapse --to vtk --snapshot all --output paraview
         astroinertia export runs/pulsar_collapse/pulsar_collapse.nc --to swift --snapshot 3 --output core.hdf5
         astroinertia export runs/pulsar_collapse --to csv
         astroinertia moments runs/pulsar_collapse/pulsar_collapse_gadget_023.hdf5
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
