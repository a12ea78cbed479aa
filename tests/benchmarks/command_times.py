"""Processor time of the commands that run nothing, warm: what a user waits for, most of it imports.

    python tests/benchmarks/command_times.py --keep

Each command is run in processes of its own, five times, and the least is taken: other work on the machine only adds to
a time. The run that is shown, a star that collapses to a pulsar in 500 particles, is made first: it spins and sends
waves, so that it has nine pictures. `--label` names the column that is written,
so that two versions stand beside each other.
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from fair_times import RESULTS, machine, publish, rows_of

SIMS = Path(__file__).parents[2] / "sims"
KEPT = RESULTS / "command_times.json"
NOTE = """\
Seconds of processor time of one process, user and system. dask was installed, as for the tests: xarray imports it with
its first variable, which takes 0.3 s that an installation without extras does not spend. Of the first column, show and
compare were measured on the same machine at a load of 2. What show takes now is of two processes side by side: 4.6 to
6.0 s of wall time on a quiet machine, for the nine pictures of 3000 particles.

"""
COMMANDS = {
    "--help": [],
    "moments, 1000 particles": ["moments", "particles.csv"],
    "ratios": ["ratios"],
    "ratios --sweep, 26 points": ["ratios", "--body", "Mars", "--sweep", "core_density=5500:8000:26", "--netcdf",
                                  "mars.nc"],
    "plan": ["plan", str(SIMS / "evrard.toml")],
    "show, nine pictures": ["show", "run", "--output", "pictures"],
    "compare, two runs": ["compare", "run", "run/pulsar_collapse.nc"],
}  # fmt: skip


def processor_time(arguments: list[str], folder: Path) -> float:
    """Seconds that one command takes in a process of its own."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "astroinertia", *(arguments or ["--help"])]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measured(rounds: int) -> dict[str, float]:
    """The least time of each command, by its name; all take turns."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        points = np.random.default_rng(1).normal(size=(1000, 3)) * [1, 2, 3]
        table = np.c_[np.ones(1000), points]
        np.savetxt(folder / "particles.csv", table, delimiter=",", header="mass,x,y,z", comments="")
        scene = str(SIMS / "pulsar_collapse.toml")
        processor_time(["run", scene, "--set", "body.particles=500", "--output", "run"], folder)
        times = [{name: processor_time(command, folder) for name, command in COMMANDS.items()} for _ in range(rounds)]
    return {name: min(one[name] for one in times) for name in COMMANDS}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--label", default="now (s)", help="head of the column")
    parser.add_argument("--keep", action="store_true", help="write the table, with the columns kept before")
    chosen = parser.parse_args()
    columns = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    columns[chosen.label] = {"times": measured(chosen.rounds), "machine": machine()}
    if chosen.keep:
        KEPT.write_text(json.dumps(columns, indent=1) + "\n")
    rows = [
        [name, *(f"{column['times'][name]:.2f}" if name in column["times"] else "" for column in columns.values())]
        for name in COMMANDS
    ]
    machines = "".join(f"\n{label}: {column['machine']}.\n" for label, column in columns.items())
    text = "# Processor time of quick commands\n\n" + NOTE + rows_of(["command", *columns], rows) + machines
    publish("command_times", text, chosen.keep)


if __name__ == "__main__":
    main()
