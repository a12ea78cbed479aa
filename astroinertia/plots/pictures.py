"""All pictures that a dataset has something for."""

from collections.abc import Callable, Collection, Iterator
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from astroinertia.dataset.absent import with_absent
from astroinertia.dataset.picture_methods import as_drawn, missing_named
from astroinertia.dataset.waves import FAINTEST
from astroinertia.plots.attitude import attitude_figure, has_attitude
from astroinertia.plots.axis_scales import angular_momentum_scale, has_values, wave_scale
from astroinertia.plots.energy import energy_figure
from astroinertia.plots.error_bars import error_bars_figure, known_bars
from astroinertia.plots.ledger import ledger_figure
from astroinertia.plots.moments import inertia_figure
from astroinertia.plots.profiles import profiles_figure
from astroinertia.plots.shape import shape_figure
from astroinertia.plots.spin import spin_figure
from astroinertia.plots.standard import standard_figure
from astroinertia.plots.style import save
from astroinertia.plots.waves import waves_figure
from astroinertia.storage.atomic import made_folder

FIGURES: dict[str, Callable[[xr.Dataset], Figure]] = {
    "inertia": inertia_figure,
    "spin": spin_figure,
    "attitude": attitude_figure,
    "ledger": ledger_figure,
    "shape": shape_figure,
    "energy": energy_figure,
    "profiles": profiles_figure,
    "waves": waves_figure,
    "error_bars": error_bars_figure,
}
"""File names and the figures that need the headline series only."""
OF_PARTICLES = ("density", "projection", "exact")
"""Those that need the particles."""
ROUND_OFF = 1e-13  # of the waves that all motion and all forces would send in one direction
_NEEDED = {"waves": "gw_strain_plus", "profiles": "radius_profile", "energy": "total_energy", "ledger": "virial_tensor"}


@with_absent
def figures(
    dataset: xr.Dataset, snapshots: xr.Dataset | None = None, only: Collection[str] = (*FIGURES, *OF_PARTICLES)
) -> Iterator[tuple[str, Figure]]:
    """Every figure that the dataset has something for, by file name.

    snapshots: the particles; found beside the series by themselves when the dataset was opened from a file or folder.
    only: the names of those that are wanted.

    >>> print([name for name, _ in figures(ds)])
    ['inertia', 'spin', 'ledger', 'shape', 'energy', 'profiles', 'waves', 'density', 'projection']
    >>> print([name for name, _ in figures(ds, only=["waves", "spin"])])
    ['spin', 'waves']
    """
    dataset = as_drawn(dataset)
    with missing_named("figures are drawn"):
        wanted = [name for name in FIGURES if name in only]
        yield from ((name, FIGURES[name](dataset)) for name in wanted if _has_something(dataset, name))
        if not any(name in only for name in OF_PARTICLES):
            return
        snapshots = dataset.inertia.snapshots if snapshots is None else snapshots
        if snapshots is not None:
            from astroinertia.plots.density import density_figure, projection_figure  # brings numba along

            drawn = (density_figure, projection_figure, standard_figure)
            for name, figure in zip(OF_PARTICLES, drawn, strict=True):
                made = figure(dataset, snapshots) if name in only else None
                if made is not None:
                    yield name, made


@with_absent
def write_all(
    dataset: xr.Dataset, folder: Path | str, snapshots: xr.Dataset | None = None,
    only: Collection[str] = (*FIGURES, *OF_PARTICLES),
) -> list[Path]:  # fmt: skip
    """Write every picture that the dataset has something for as a PNG into a folder, and return the paths.

    only: the names of those that are wanted.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     print(len(write_all(ds, folder)), "pictures")
    9 pictures
    """
    folder = made_folder(Path(folder))
    return [save(figure, folder / f"{name}.png") for name, figure in figures(dataset, snapshots, only)]


def _has_something(dataset: xr.Dataset, name: str) -> bool:
    if name == "attitude":
        return has_attitude(dataset)
    if name == "error_bars":
        return bool(known_bars(dataset))
    if name == "spin" and not angular_momentum_scale(dataset)[1]:
        return False
    if name == "waves" and has_values(dataset, "gw_strain_plus"):
        largest = max(float(abs(dataset[f"gw_strain_{kind}"]).max()) for kind in ("plus", "cross"))
        return largest > max(FAINTEST, ROUND_OFF * wave_scale(dataset))
    needed = _NEEDED.get(name)
    return needed is None or has_values(dataset, needed)
