"""What the commands write beside a run's own file."""

import subprocess
import sys

import pytest

DISK_FULL = """
import resource, sys
from pathlib import Path
import numpy as np, xarray as xr
from astroinertia.cli.result import write_netcdf
from astroinertia.errors import ArchiveError
from astroinertia.interop.hdf5 import Column, write_hdf5

data = xr.Dataset({"a": ("x", np.random.default_rng(0).normal(size=20_000))})
for size in (1000, 30_000, 100_000):  # of 170 kB
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
    for write in (
        lambda: write_netcdf(data, Path(sys.argv[1], "moments.nc")),
        lambda: write_hdf5(Path(sys.argv[1], "snapshot.hdf5"), {}, {"a": Column(data["a"].values, {})}),
    ):
        try:
            write()
        except ArchiveError as error:
            print(error)
"""


@pytest.mark.slow
def test_a_full_disk_is_reported_in_a_sentence_and_what_was_there_is_kept(tmp_path):
    done = subprocess.run(
        [sys.executable, "-B", "-c", DISK_FULL, str(tmp_path)], capture_output=True, text=True, check=False
    )
    lines = done.stdout.splitlines()
    assert len(lines) == 6 and all("cannot be written" in line and "disk full" in line for line in lines)
    assert not list(tmp_path.iterdir())
