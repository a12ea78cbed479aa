"""Rotating, self-gravitating fluid bodies and the evolution of their inertia tensor.

    astroinertia.run_scene(scene, folder)  run a scene file or a Scene; returns the netCDF file
    astroinertia.resume(folder)            go on with an interrupted run
    astroinertia.load(path, settings)      a scene from a TOML file, validated
    astroinertia.open(path)                the headline series of a run, an xarray Dataset with the accessor `.inertia`
    astroinertia.open_tree(path)           the same with the snapshots, an xarray DataTree

Nothing is imported or set until one of them is called.
"""

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

    from astroinertia.run import Listener
    from astroinertia.scene.schema import Scene

__all__ = ["load", "open", "open_tree", "resume", "run_scene"]


def load(path: str | PathLike[str], settings: Sequence[str] = ()) -> "Scene":
    """The scene in a TOML file, with "key.path=value" settings put in; SceneError says what is wrong."""
    from astroinertia.scene.load import load_file

    return load_file(path, settings)


def run_scene(
    scene: "Scene | str | PathLike[str]", folder: str | PathLike[str], listener: "Listener | None" = None
) -> Path:
    """Run a scene, or the scene in a file, in a new folder; returns the netCDF file that it leaves.

    Where the scene asks for an accuracy, its settings are chosen first, by pilot runs in a folder beside.
    """
    from astroinertia.accuracy.running import run_scene as carry_out
    from astroinertia.scene.schema import Scene

    chosen = scene if isinstance(scene, Scene) else load(scene)
    if chosen.wants_choice:
        from astroinertia.accuracy.choice import choose, pilots_beside

        chosen = choose(chosen, pilots_beside(Path(folder))).scene
    return carry_out(chosen, Path(folder), listener)


def resume(folder: str | PathLike[str], listener: "Listener | None" = None) -> Path:
    """Go on with an interrupted run; returns its netCDF file."""
    from astroinertia.accuracy.running import resume as go_on

    return go_on(Path(folder), listener)


def open(path: str | PathLike[str], chunks: "Mapping[str, int] | None" = None) -> "xr.Dataset":
    """The headline series of a netCDF file or a run folder, with the accessor `.inertia`; with chunks, for dask."""
    from astroinertia import accessor, dataset

    assert accessor  # importing it registers it
    return dataset.open(Path(path), chunks=chunks)


def open_tree(path: str | PathLike[str], chunks: "Mapping[str, int] | None" = None) -> "xr.DataTree":
    """Headline series and, in the group `snapshots`, the particles; with chunks ({} for those of the file), by dask."""
    from astroinertia import accessor, dataset

    assert accessor
    return dataset.open_tree(Path(path), chunks=chunks)
