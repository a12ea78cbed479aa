"""A signal to all processes of a sweep at once, as terminals, `timeout` and schedulers send it: members are saved."""

import os
import re
import signal
import subprocess
import sys
import time
from contextlib import suppress

import pytest

from astroinertia.scene.sweep import member
from astroinertia.storage.archive import Archive
from tests.crash.signalled import SWEEP

COMMAND = "import sys; from astroinertia.cli.main import main; sys.exit(main())"
WORKERS = 2
SCENE = SWEEP.replace("100.0", "1e4") + "checkpoint_seconds = 1e6\n"


@pytest.mark.full
def test_members_under_way_in_workers_are_saved_when_all_processes_get_a_signal(tmp_path):
    pytest.importorskip("distributed")
    (tmp_path / "sweep.toml").write_text(SCENE)
    arguments = ["run", str(tmp_path / "sweep.toml"), "--workers", str(WORKERS), "--output", str(tmp_path / "run")]
    under_way = [tmp_path / "run" / member(number) for number in range(WORKERS)]
    end = time.monotonic() + 200.0
    command = [sys.executable, "-c", COMMAND, *arguments]
    with subprocess.Popen(command, start_new_session=True, stderr=subprocess.PIPE, text=True) as sweep:
        try:
            while not all(any(place.glob("checkpoint-*")) for place in under_way):  # that of the beginning
                assert sweep.poll() is None and time.monotonic() < end
                time.sleep(0.1)
            time.sleep(2.0)  # some steps
            for _ in range(2):
                os.killpg(sweep.pid, signal.SIGTERM)
            _, complaint = sweep.communicate(timeout=120.0)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(sweep.pid, signal.SIGKILL)
    assert sweep.returncode == 130
    shares = re.search(r"stopped by SIGTERM with 0 of \d members done and (.*), and is saved in", complaint).group(1)
    assert [share.split(" at ")[0] for share in shares.split(", ")] == [member(number) for number in range(WORKERS)]
    assert all(0.0 < float(share.split(" at ")[1].removesuffix("%")) < 100.0 for share in shares.split(", "))
    for place in under_way:
        with Archive.open(place) as found:  # let go of by its worker
            assert found.read_checkpoint()[1]["series"] > 1
    assert not (tmp_path / "run" / member(WORKERS)).exists()
