"""The command `moments`: its arguments, and what it says and writes. Printing is left to main.py."""

import json
import math
from pathlib import Path

from astroinertia.cli import result
from astroinertia.cli.parser import Add, Options
from astroinertia.errors import SceneError

AXES = {"x": [1.0, 0.0, 0.0], "y": [0.0, 1.0, 0.0], "z": [0.0, 0.0, 1.0]}

HELP = """\
files:
  .csv .ecsv .npz .nc .h5   columns mass, x, y, z (or position, of three numbers a particle)
  .hdf5                     also a snapshot of GADGET or SWIFT, of one type of particles; in SI if it states its units
  a dump of Phantom         whatever it is called; sinks count as points; needs the extra astroinertia[phantom]
  .stl .obj .ply .off       a closed mesh, homogeneous inside
  runs/NAME or its .nc      a snapshot of a run

All moments are about one point. I/(M R^2) takes for R the distance of the outermost particle from the centre of mass,
or for a mesh the radius of the sphere of the same volume, unless --radius gives one; the output says which.
--gravity-field has C_lm and S_lm of all degrees up to DEGREE about that point, with the same R, and J_l = -C_l0 not
normalised; --normalization is 4pi (geodesy), ortho, schmidt or unnorm, without the phase of Condon and Shortley.
POINT, R and RHO are in the units of the file; R and RHO may have their own, such as "2 g/cm3", where these are known.
Axes of equal moments are undefined, and printed so.

example: astroinertia moments particles.csv
         astroinertia moments particles.h5 --units Msun,Rsun --axis z --plot star.png
         astroinertia moments asteroid.stl --density 2000 --units kg,m --about=-1,0,2.5
         astroinertia moments asteroid.stl --gravity-field 8 --radius 300
         astroinertia moments runs/pulsar_collapse --snapshot 0 --json
"""


def add_arguments(add: Add) -> None:
    """Add the options of `moments`."""
    add("file", metavar="FILE", type=Path, help="particle table, mesh, netCDF file or folder of a run")
    add("--about", metavar="POINT", help="point x,y,z that all moments are about (default: the centre of mass)")
    add("--axis", help="one more moment, about this axis through that point: x, y, z or a vector 1,1,0")
    add("--units", metavar="MASS,LENGTH", help="units of the file; results are then in SI (kg, m)")
    add("--radius", type=_number, metavar="R", help="the radius of the ratio I/(M R^2)")
    add("--density", type=_number, metavar="RHO", help="density of the inside of a mesh (default: 1)")
    add("--snapshot", type=int, metavar="N", help="snapshot of a run, from 0 (default: the last)")
    add(
        "--gravity-field", type=int, metavar="DEGREE", help="spherical harmonics of the gravity field up to this degree"
    )
    add("--normalization", metavar="NAME", help="of these: 4pi, ortho, schmidt or unnorm (default: 4pi)")
    add("--principal-axes", action="store_true", help="these in the principal axes, z that of the largest moment")
    add("--plot", type=Path, metavar="FILE.png", help="draw the inertia ellipsoid with its polhodes")
    add("--json", action="store_true", help="print everything as JSON")
    add(
        "--output", type=Path, metavar="FILE.nc",
        help="write everything as netCDF, over another netCDF file that is there unless it is the result of a run",
    )  # fmt: skip


def report(options: Options) -> str:
    """What the command prints; the picture and the netCDF file are written first. SceneError for bad input."""
    from astroinertia.plots.body_summary import body_summary, plain_values
    from astroinertia.storage import overwriting
    from astroinertia.studies.moments import PLAIN, moments, read_matter

    result.must_be_writable(options.plot, ".png")
    result.must_be_writable(options.output, ".nc")
    if options.gravity_field is None and (options.principal_axes or options.normalization is not None):
        given = "--principal-axes" if options.principal_axes else "--normalization"
        raise SceneError(f"{given} is of spherical harmonics: ask for them by --gravity-field DEGREE.")
    units = PLAIN if options.units is None else _pair(options.units)
    axis = None if options.axis is None else AXES.get(options.axis) or _vector("--axis", options.axis)
    about = None if options.about is None else _vector("--about", options.about)
    if options.output is not None:
        overwriting.check(options.output, overwriting.NETCDF, options.file)
    matter = read_matter(options.file, units, options.snapshot, options.density)
    size, radius = matter.file_length, options.radius
    try:
        body = moments(
            matter,
            None if about is None else [size * coordinate for coordinate in about],
            axis,
            size * radius if isinstance(radius, float) else radius,
            options.gravity_field,
            options.normalization or "4pi",
            options.principal_axes,
        )
    except ValueError as error:
        raise SceneError(f"{options.file}: {error}") from error
    if options.plot is not None:
        from astroinertia.inertia.tensor import require_plausible
        from astroinertia.plots.ellipsoid import ellipsoid_figure
        from astroinertia.plots.style import save

        if not (body["principal_moments"][-1] > 0 and body["mass"] > 0):
            raise SceneError(f"{options.file} is a point without moments of inertia, so there is nothing to draw")
        try:
            require_plausible(body["inertia_tensor"].values)
        except ValueError as error:
            raise SceneError(f"{options.file} has a tensor that is not drawn: {error}") from None
        save(ellipsoid_figure(body, matter.points, options.file.stem), options.plot)
    result.write_netcdf(body, options.output)
    return json.dumps(plain_values(body), indent=2) if options.json else body_summary(body)


def _number(text: str) -> float | str:
    """A plain number, or text with a unit as it is."""
    try:
        return float(text)
    except ValueError:
        return text


def _vector(name: str, text: str) -> list[float]:
    try:
        vector = [float(part) for part in text.split(",")]
    except ValueError:
        vector = []
    if len(vector) != 3 or not all(map(math.isfinite, vector)):
        raise SceneError(f"{name} takes three numbers such as 0,0,1, not '{text:.40}'")
    return vector


def _pair(text: str) -> tuple[str, str]:
    mass, comma, length = (part.strip() for part in text.partition(","))
    if not (mass and comma and length):
        raise SceneError(f"--units takes a unit of mass and one of length such as kg,m, not '{text:.40}'")
    return mass, length
