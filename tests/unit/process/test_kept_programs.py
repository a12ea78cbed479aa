"""What several processes compiled and kept is used side by side in one, on the processor that it was made for."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from astroinertia.process import kept_programs

# A program whose constant is part of a function that all generated modules share. For machines that have no
# instruction for it, what is tested here is a loop, which is compiled as a function of its own.
PROGRAM = '''
import sys
import numpy as np
from astroinertia.engines import numba_vectors
from astroinertia.engines.numba_cache import load_module

numba_vectors.COMPACTED_BITS = 0
from astroinertia.engines.numba_passes import header

TEXT = """
spread = row_spreader(4, {begin})


@njit(cache=True, nogil=True, error_model="numpy")
def taken(table, index, count, out):
    spread(table, index, count, out)
"""
table, out = np.arange(16.0 * 12).reshape(16, 12), np.empty((4, 16))
for begin in map(int, sys.argv[1:]):
    text = "\\n".join([*header("float64"), TEXT.format(begin=begin)])
    load_module(f"taken_{begin}", text).taken(table, np.arange(16), 16, out)
    print(begin, np.array_equal(out, table[:, begin : begin + 4].T))
'''

SUMS = """
import hashlib
import numpy as np
from astroinertia.effects.catalogue import build
from astroinertia.engines.numba_cpu import Engine

random = np.random.default_rng(4)
position, length = random.normal(size=(400, 3)), np.full(400, 0.3)
engine = Engine(precision="float64")
order, arrangement = engine.arrange(position, length)
fields = {"position": position[order], "mass": np.full(400, 1 / 400), "smoothing_length": length}
sums = engine.all_pair_sums(arrangement, "wendland_c2", build("gravity").all_pair_terms, fields, virial=True)["gravity"]
print(hashlib.sha256(b"".join(np.ascontiguousarray(sums[name]).tobytes() for name in sorted(sums))).hexdigest())
"""

# Of a library that the user's own program imports, and of a command: both keep what JAX compiles.
COMPILED = """
import sys
from astroinertia.process import kept_programs

kept_programs.keep_apart()
kept_programs.keep_apart()
import jax
import jax.numpy as jnp

print(kept_programs.processor())
print(jax.config.jax_compilation_cache_dir)
found = []
jax.monitoring.register_event_listener(lambda name, **_: found.append(name))
jax.jit(lambda x: jnp.sort(jnp.sin(x) @ jnp.cos(x)))(jnp.ones((20, 20))).block_until_ready()
print(sum(name.endswith("/cache_hits") for name in found), sum(name.endswith("/cache_misses") for name in found))
"""


def output_of(program: str, place, *arguments: str) -> str:
    """What a process prints that keeps its programs in a folder."""
    kept = {"NUMBA_CACHE_DIR": str(place / "numba"), "ASTROINERTIA_CACHE": str(place / "kernels")}
    command = [sys.executable, "-c", program, *arguments]
    return subprocess.run(command, env=os.environ | kept, capture_output=True, text=True, check=True).stdout


@pytest.mark.slow
def test_the_process_that_compiles_a_program_rounds_as_those_that_find_it(tmp_path):
    """A loop compiled by itself and within its caller once stood twice under one name, and rounded otherwise."""
    compiled = output_of(SUMS, tmp_path)
    assert (tmp_path / "numba").exists()
    assert output_of(SUMS, tmp_path) == compiled


@pytest.mark.full
def test_programs_that_different_processes_compiled_do_not_mix(tmp_path):
    """Functions made with other constants have the same name, types and, each in its process, number: once taken for
    each other, they gave wrong sums over pairs.
    """
    assert output_of(PROGRAM, tmp_path, "0") == "0 True\n"
    assert output_of(PROGRAM, tmp_path, "4") == "4 True\n"
    assert output_of(PROGRAM, tmp_path, "0", "4") == "0 True\n4 True\n"


def compiled(folder: Path) -> tuple[str, Path, int, int]:
    """Of a process that keeps JAX's programs under a folder: its processor, the folder it took, hits and misses."""
    kept = {"JAX_COMPILATION_CACHE_DIR": str(folder), "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0"}
    given = {name: value for name, value in os.environ.items() if name != "TF_CPP_MIN_LOG_LEVEL"}
    command = [sys.executable, "-c", COMPILED]
    done = subprocess.run(command, env=given | kept, capture_output=True, text=True, check=True)
    assert done.stderr == ""  # XLA's "could lead to execution errors such as SIGILL", 3 kB for each program
    processor, place, counts = done.stdout.splitlines()
    return processor, Path(place), *map(int, counts.split())


@pytest.mark.full
def test_programs_of_another_processor_are_not_read_and_nothing_is_said_of_ones_own(tmp_path):
    processor, place, _, misses = compiled(tmp_path)
    assert place == tmp_path / processor and misses > 0
    assert compiled(tmp_path) == (processor, place, misses, 0)
    place.rename(tmp_path / "another-processor")
    for each in (tmp_path / "another-processor").iterdir():
        each.replace(tmp_path / each.name)  # as one folder for all processors was
    assert compiled(tmp_path) == (processor, place, 0, misses)


@pytest.mark.full
def test_the_command_line_keeps_programs_by_processor_and_says_nothing_of_it(tmp_path):
    program = (
        "import sys; from astroinertia.cli.main import main; code = main(['ratios', '--body', 'Mars']); "
        "from astroinertia.process.kept_programs import processor; print(processor()); sys.exit(code)"
    )
    kept = {"ASTROINERTIA_CACHE": str(tmp_path)}
    given = {name: value for name, value in os.environ.items() if not name.startswith(("TF_CPP_MIN_LOG_LEVEL", "JAX_"))}
    before: dict = {}
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", program], env=given | kept, capture_output=True, text=True, check=True
        )
        assert [line for line in done.stderr.splitlines() if not line.endswith("ratios is at work")] == []
        (place,) = (tmp_path / "jax").iterdir()
        assert [place.name] == done.stdout.splitlines()[-1:]
        written = {each: each.stat().st_mtime_ns for each in place.iterdir() if each.name.endswith("-cache")}
        assert written and before in ({}, written)  # compiled once, and then read
        before = written
    cut = min(written, key=lambda each: each.stat().st_size)
    cut.write_bytes(cut.read_bytes()[:-1])  # as a process leaves it that is killed there
    done = subprocess.run([sys.executable, "-c", program], env=given | kept, capture_output=True, text=True, check=True)
    assert "cache" not in done.stderr


def test_a_place_that_cannot_be_written_keeps_nothing_and_the_users_own_comes_first(tmp_path, monkeypatch):
    for name in (kept_programs.FOLDER, kept_programs.LEAST):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "file").touch()
    kept_programs.keep(tmp_path / "file" / "jax")
    assert kept_programs.FOLDER not in os.environ
    monkeypatch.setenv(kept_programs.FOLDER, str(tmp_path / "own"))
    kept_programs.keep(tmp_path / "jax")
    assert Path(os.environ[kept_programs.FOLDER]).is_relative_to(tmp_path / "own") and not (tmp_path / "jax").exists()
    assert kept_programs.LEAST not in os.environ
