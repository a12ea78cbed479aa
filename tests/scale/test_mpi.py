"""A run that mpirun starts: the bits of one process, whoever is stopped or killed, and with whom it goes on."""

import os
import shutil
import signal
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import astroinertia
from astroinertia.engines import mpi
from astroinertia.engines.together import ALONE
from astroinertia.errors import SceneError
from astroinertia.models.sph.evolution import STEPS_BETWEEN_SORTS
from astroinertia.storage.archive import Archive
from tests.scale.commands import ROOT, begun, ended, started

CLOUD = (
    "evrard", "body.particles=1500", "effects.gravity.method='multipole'", "numerics.precision='float64'",
    "output.checkpoint_seconds=0",
)  # fmt: skip
BLOCKS = (*CLOUD, "time.max_steps=3", "numerics.timesteps='individual'")
STEPS = 4 * STEPS_BETWEEN_SORTS  # runs stop where particles are sorted: a signalled one must come there before its end
STEPPED = (*CLOUD, f"time.max_steps={STEPS}")
SORTED = (*CLOUD, f"time.max_steps={STEPS_BETWEEN_SORTS + 1}")  # particles are sorted once more


def mpiexec():
    """The starter beside this Python, or else the machine's."""
    pytest.importorskip("mpi4py", exc_type=ImportError)
    beside = Path(sys.executable).parent / "mpiexec"
    found = str(beside) if beside.exists() else shutil.which("mpiexec")
    if found is None:
        pytest.skip("there is no mpiexec")
    return found


def several(count, folder, scene, *options):
    """A run by so many processes that MPI starts; without a scene what goes on."""
    return started(folder, scene, *options, starter=(mpiexec(), "-n", str(count)))


def processes_of(folder):
    """The processes of the run in that folder, by number; Linux alone tells of them."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
            status = (entry / "stat").read_text()
        except OSError:
            continue
        if str(folder).encode() in words and b"astroinertia" in words and words[0] == sys.executable.encode():
            found.append((int(status.rsplit(")", 1)[1].split()[19]), int(entry.name)))  # by the time of their start
    return [number for _, number in sorted(found)]


def under_way(folder, process):
    """Wait until the run has taken some steps and saved them."""
    while process.poll() is None and len(list(folder.glob("checkpoint-*"))) < 2:
        time.sleep(0.02)


def assert_same_runs(one, other):
    """The same bits of the state and of all that was recorded."""
    states = [Archive.view(folder).read_checkpoint()[0] for folder in (one, other)]
    assert set(states[0]) == set(states[1])
    for name, array in states[0].items():
        np.testing.assert_array_equal(array, states[1][name], err_msg=name)
    datasets = [astroinertia.open(folder).drop_vars("wall_time") for folder in (one, other)]
    assert datasets[0].equals(datasets[1])


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A run by one process that nothing happened to."""
    folder = tmp_path_factory.mktemp("undisturbed") / "run"
    ended(started(folder, STEPPED))
    return folder


@pytest.mark.parametrize("scene", [SORTED, pytest.param(BLOCKS, marks=pytest.mark.full)], ids=["global", "individual"])
def test_a_run_by_two_processes_has_the_bits_of_one(tmp_path, scene):
    ended(started(alone := tmp_path / "alone", scene))
    said, _ = ended(several(2, tmp_path / "both", scene))
    assert said.count("wrote") == 1
    names = [sorted(path.name for path in each.iterdir()) for each in (alone, tmp_path / "both")]
    assert names[0] == names[1]
    assert_same_runs(alone, tmp_path / "both")


@pytest.mark.full
@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="the processes are found in /proc")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_stopped_and_killed_runs_go_on_with_other_numbers_of_processes(tmp_path, undisturbed, number):
    folder = tmp_path / "stopped"
    process = several(2, folder, STEPPED)
    under_way(folder, process)
    os.kill(processes_of(folder)[-1], number)  # one of the two
    begun = time.monotonic()
    if number == signal.SIGTERM:
        _, complaints = ended(process, 130)
        assert complaints.count("stopped by SIGTERM") == 1
    else:
        process.communicate(timeout=120)
        assert process.returncode not in (0, 130)
        assert time.monotonic() - begun < 60.0  # the other one does not wait for it
    assert int(Archive.view(folder).read_checkpoint()[0][".step"]) < STEPS
    ended(several(3, folder, None) if number == signal.SIGTERM else started(folder, None))
    assert_same_runs(undisturbed, folder)


def test_what_several_processes_cannot_do_is_a_sentence(tmp_path):
    _, complaints = ended(several(2, tmp_path / "run", (*STEPPED, "numerics.engine='xla'")), 2)
    assert complaints.count("for xla run with --coordinator auto") == 1
    _, complaints = ended(started(tmp_path / "run", STEPPED, OMPI_COMM_WORLD_SIZE="2"), 2)
    assert "MPI has started 2 processes, but mpi4py knows of 1" in complaints
    # One of the two has another kind of processor, or says so.
    text = "import sys; from astroinertia.engines import mpi; mpi.processor = lambda: 'other'; "
    text += "from astroinertia.cli.main import main; sys.exit(main(sys.argv[1:]))"
    words = ["run", str(ROOT / "sims" / "evrard.toml"), "--output", str(tmp_path / "run")]
    mine, other = ([mpiexec(), "-n", "1", sys.executable, "-m", "astroinertia"], [sys.executable, "-c", text])
    _, complaints = ended(begun([*mine, *words, ":", "-n", "1", *other, *words]), 2)
    assert complaints.count("need the same processors and versions of packages; theirs differ") == 1
    assert not (tmp_path / "run").exists()
    (tmp_path / "run").write_text("")  # which the first alone comes upon
    _, complaints = ended(several(2, tmp_path / "run", STEPPED), 2)
    assert complaints.count("astroinertia: ") == 1 and "first process" not in complaints


def test_what_is_said_of_arguments_and_plans_is_said_once(tmp_path):
    scene = str(ROOT / "sims" / "core_to_pulsar_scaling.toml")
    command = [mpiexec(), "-n", "2", sys.executable, "-m", "astroinertia"]
    said, complaints = ended(begun([*command, "run", scene, "--outptu", str(tmp_path / "run")]), 2)
    assert not said and complaints.count("unrecognized arguments: --outptu") == 1
    said, _ = ended(begun([*command, "plan", scene]))
    assert said.count("effects called for") == 1
    said, complaints = ended(begun([*command, "plan", scene, "--set", "time.end=much"]), 2)
    assert not said and complaints.count("[time] end") == 1


def test_one_that_fails_by_itself_says_why_before_it_ends_the_others(tmp_path):
    text = "import sys; from astroinertia.engines import mpi; mpi._PATIENCE = 1.0\n"
    text += "from astroinertia.models.sph.evolution import Particles; from astroinertia.errors import NumericalError\n"
    text += "def advance(*_): raise NumericalError('this one alone has failed')\n"
    text += "Particles.advance = advance if sys.argv.pop(1) == 'fails' else Particles.advance\n"
    text += "from astroinertia.cli.main import main; sys.exit(main(sys.argv[1:]))"
    words = ["run", str(ROOT / "sims" / "evrard.toml"), "--output", str(tmp_path / "run")]
    words += ["--set", "body.particles=100", "--set", "effects.gravity.method='multipole'"]
    one, other = ([sys.executable, "-c", text, each, *words] for each in ("goes on", "fails"))
    process = begun([mpiexec(), "-n", "1", *one, ":", "-n", "1", *other])
    _, complaints = process.communicate(timeout=300)
    assert process.returncode not in (0, 130)
    assert complaints.count("this one alone has failed") == 1


def test_what_it_takes_is_named_where_it_is_missing(monkeypatch):
    monkeypatch.setenv("PMI_SIZE", "4")
    monkeypatch.setitem(sys.modules, "mpi4py", None)
    sentence = "MPI has started 4 processes of this run, which need mpi4py: pip install 'astroinertia\\[mpi\\]'"
    with pytest.raises(SceneError, match=sentence), mpi.joined():
        pass
    assert mpi.together() is ALONE


@pytest.mark.parametrize(("cores", "bound", "given", "threads"), [
    (8, 8, None, "2"), (2, 2, None, "1"), (8, 2, None, None), (8, 8, "3", "3"),
])  # fmt: skip
def test_processes_of_a_machine_share_its_cores(monkeypatch, cores, bound, given, threads):
    """Unless something else has bound them to cores of their own, or their threads are set."""
    monkeypatch.setattr(os, "cpu_count", lambda: cores)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(bound)), raising=False)
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    if given:
        monkeypatch.setenv("NUMBA_NUM_THREADS", given)
    mpi._share_cores(4)
    assert os.environ.get("NUMBA_NUM_THREADS") == threads


def test_without_mpi_nothing_of_it_is_imported(tmp_path):
    text = (
        "import sys; from astroinertia.cli.main import main; code = main(sys.argv[1:]); "
        "sys.exit(code or 'mpi4py' in sys.modules)"
    )
    words = ["run", str(ROOT / "sims" / "core_to_pulsar_scaling.toml"), "--output", str(tmp_path / "run")]
    ended(begun([sys.executable, "-c", text, *words]))
