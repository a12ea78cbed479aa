"""Zarr: the whole dataset as a tree of arrays in chunks, for object stores and for reading in parallel.

Tests: tests/unit/interop/test_export.py.
"""

import errno
import shutil
import tempfile
from pathlib import Path

import xarray as xr

from astroinertia import dataset
from astroinertia.errors import ArchiveError, SceneError
from astroinertia.process import interrupts
from astroinertia.storage.atomic import TEMPORARY

FORMAT = 2  # the third has no text of fixed length yet, which the labels of dimensions are


def write_zarr(source: Path, path: Path) -> None:
    """Write headline series and snapshots of a run; a chunk holds one snapshot, and memory no more than a few.

    SceneError if zarr or dask is not installed, ArchiveError if the store cannot be written or is there already.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_zarr(Path("runs/star"), Path(folder, "star.zarr"))
    ...     with xr.open_datatree(Path(folder, "star.zarr"), engine="zarr") as tree:
    ...         print(tree.groups, bool((tree["inertia_tensor"] == ds.inertia_tensor).all()))
    ('/', '/snapshots') True
    """
    try:
        import dask  # noqa: F401  # pyright: ignore[reportMissingImports]
        import zarr  # noqa: F401  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise SceneError(
            f"{path}: Zarr needs zarr and dask; install them with: pip install 'astroinertia[zarr]'"
        ) from None
    groups = {"/": dataset.open(source)}
    particles = dataset.open_snapshots(source, chunks={"snapshot_time": 1})  # one passes through memory at a time
    if particles is not None:
        groups["/snapshots"] = particles.drop_encoding()
    try:
        aside = tempfile.mkdtemp(prefix=f"{path.name}.", suffix=TEMPORARY, dir=path.parent)
        with interrupts.leaving(lambda: shutil.rmtree(aside, ignore_errors=True)):
            try:
                store = Path(aside, path.name)  # whose permissions are those of any folder
                xr.DataTree.from_dict(groups).to_zarr(store, mode="w-", zarr_format=FORMAT, consolidated=True)
                store.rename(path)
            finally:
                shutil.rmtree(aside, ignore_errors=True)
    except OSError as error:
        if error.errno in (errno.EEXIST, errno.ENOTEMPTY, errno.ENOTDIR):
            raise ArchiveError(f"{path} is there already and is left as it is.") from error
        raise ArchiveError(f"{path} cannot be written: {error.strerror or error}.") from error
