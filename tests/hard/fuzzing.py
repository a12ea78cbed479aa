"""Looks for inputs that readers do not expect, led by the code that they reach (atheris, the extra `fuzz`).

    python -m tests.hard.fuzzing READER SECONDS SEEDS CORPUS FINDINGS      in a process of its own, which libFuzzer ends

SEEDS: folder of inputs to begin with; CORPUS: folder for those that reach code that others have not; FINDINGS: file
with a line of JSON for each error that is none of the package's own, and for what takes too long.
"""

import hashlib
import json
import os
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path

import atheris
import numpy  # noqa: F401  now, so that it is not instrumented: that takes half a minute

MODULES = (
    "astroinertia.scene", "astroinertia.units", "astroinertia.storage.columns", "astroinertia.sph.table",
    "astroinertia.matter.table_equation", "astroinertia.sph.progenitor", "astroinertia.storage.bounded",
    "astroinertia.storage.manifest", "astroinertia.storage.atomic", "astroinertia.storage.hdf5_structure",
    "astroinertia.storage.trailer", "tomllib", "json", "zipfile", "csv",
)  # fmt: skip
LONGEST = 2.0  # seconds of processor time

with atheris.instrument_imports(include=list(MODULES)):
    from astroinertia.errors import ArchiveError, AstroinertiaError
    from astroinertia.matter.table_equation import read_equation
    from astroinertia.scene import load, sweep
    from astroinertia.sph.progenitor import read_progenitor
    from astroinertia.sph.table import read_table
    from astroinertia.storage import hdf5_structure, manifest, trailer


def of_scene(path):
    if sweep.load_file(path) is None:
        load.load_file(path)


def of_manifest(path):
    """With its own hash, which no fuzzer finds."""
    try:
        content = json.loads(path.read_bytes())
    except (ValueError, RecursionError):
        return
    if isinstance(content, dict):
        content.pop("sha256", None)
        content["sha256"] = hashlib.sha256(json.dumps(content).encode()).hexdigest()
        path.write_text(json.dumps(content))
    manifest.read_file(path)


def of_structure(path):
    trailer.check(path)
    try:
        hdf5_structure.check(path)
    except ValueError as error:  # as dataset_files.py and table_netcdf.py do
        raise ArchiveError(str(error)) from None


READERS = {
    "scene": (".toml", of_scene),
    "csv": (".csv", read_table),
    "npz": (".npz", read_table),
    "equation": (".csv", read_equation),
    "profile": (".data", lambda path: read_progenitor(path, 1.3)),
    "columns": (".csv", lambda path: read_progenitor(path, 1.3)),
    "manifest": (".json", of_manifest),
    "structure": (".nc", of_structure),
}


def main(reader, seconds, seeds, corpus, findings):
    warnings.simplefilter("error")
    suffix, read = READERS[reader]
    folder = tempfile.TemporaryDirectory(dir=Path(corpus).parent)
    path = Path(folder.name) / f"input{suffix}"
    known = set()

    def one(content):
        path.write_bytes(content)
        begun = time.process_time()
        said = None
        try:
            read(path)
        except AstroinertiaError:
            pass
        except Exception as error:
            said = traceback.format_exc()
            where = (type(error).__name__, *traceback.extract_tb(error.__traceback__)[-1][:2])
        if said is None and time.process_time() - begun > LONGEST:
            said, where = f"took {time.process_time() - begun:.1f} s", ("slow",)
        if said is not None and where not in known:
            known.add(where)
            with Path(findings).open("a") as file:
                file.write(json.dumps({"reader": reader, "said": said, "content": content.hex()}) + "\n")

    # Memory above that of an idle process ends it, as an error.
    idle = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") >> 20
    limits = [f"-max_total_time={seconds}", f"-rss_limit_mb={idle + 300}", "-malloc_limit_mb=4000", "-timeout=60"]
    atheris.Setup([sys.argv[0], *limits, "-seed=1", "-max_len=20000", "-print_final_stats=1", corpus, seeds], one)
    atheris.Fuzz()


if __name__ == "__main__":
    # In a fork: the peak memory of a process, by which libFuzzer judges, begins with that of the one that started it.
    if child := os.fork():
        sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
    main(*sys.argv[1:])
