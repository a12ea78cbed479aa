"""A sweep of full size: workers of a LocalCluster, one of which is killed in the middle of a member."""

import os
import signal
import time
from pathlib import Path

import pytest
import xarray as xr

from astroinertia import dataset
from astroinertia.scene import sweep as sweeps
from astroinertia.storage.archive import LOCK
from astroinertia.sweeps import ensemble, folder

SIDE = 8
KILL_AFTER = 20  # members
RECORDS = 6
SCENE = f"""
name = "tumbling"
description = "Free bodies of {SIDE} shapes that begin to turn at {SIDE} rates about nearly their middle axis."
model = "rigid"
units = "code"
[sweep]
"body.moments" = [{", ".join(f"[1.0, 2.0, {2.1 + 0.1 * k:.1f}]" for k in range(SIDE))}]
"body.rotation.rate" = {{start = 0.25, stop = 2.0, number = {SIDE}}}
[body]
kind = "rigid"
mass = 1.0
[body.rotation]
axis = [0.01, 1.0, 0.0]
[effects]
[time]
end = 5.0
[output]
series_every = 1.0
checkpoint_seconds = 0.0
"""


def member_under_way(process):
    """The member whose lock a process holds and the records it has saved, if these are some but not all, or None."""
    for file in process.open_files():
        path = Path(file.path)
        segments = len(list(path.parent.glob("segment-*.npz"))) if path.name == LOCK else 0
        if 2 <= segments <= RECORDS - 2:
            return path.parent.name, segments
    return None


@pytest.mark.full
def test_a_killed_worker_changes_nothing(tmp_path, result):
    psutil = pytest.importorskip("psutil")
    pytest.importorskip("distributed")
    sweep = sweeps.loads(SCENE)
    assert sweep is not None and len(sweep.members) == SIDE**2
    begun = time.monotonic()
    assert not ensemble.run_sweep(sweep, tmp_path / "serial").failures
    serial = time.monotonic() - begun
    killed = []

    def kill(standing):
        end = time.monotonic() + 5.0  # by then workers have nothing left to do; the next member may be caught
        while standing.done >= KILL_AFTER and not killed and time.monotonic() < end:
            for process in psutil.Process().children(recursive=True):
                try:
                    found = member_under_way(process)
                except (psutil.Error, OSError):
                    continue
                if found:
                    os.kill(process.pid, signal.SIGKILL)
                    killed.append(found)
                    break

    begun = time.monotonic()
    found = ensemble.run_sweep(sweep, tmp_path / "workers", workers=2, listener=kill)
    assert killed and not found.failures
    times = ["wall_time", "measured_wall_time", "measured_memory"]
    one, other = (dataset.open(tmp_path / name).drop_vars(times) for name in ("serial", "workers"))
    xr.testing.assert_identical(one, other)
    member, segments = killed[0]
    whole = dataset.open(folder.finished(tmp_path / "workers", int(member[-4:])))
    assert whole.sizes["time"] == RECORDS
    result(
        members=len(sweep.members), workers=2, killed_after=KILL_AFTER, killed_in=member,
        records=RECORDS, saved_then=segments,
        serial_seconds=round(serial, 1), workers_seconds=round(time.monotonic() - begun, 1),
        variables_identical=len(one.data_vars), numbers_identical=int(sum(v.size for v in one.data_vars.values())),
    )  # fmt: skip
