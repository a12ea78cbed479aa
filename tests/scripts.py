"""How tests run the scripts in sims/: as a user does, but in the same process, which spares the imports."""

import contextlib
import io
import runpy
from pathlib import Path
from unittest import mock

import jax

SIMS = Path(__file__).parents[1] / "sims"


def run_sim(name, *options, code=0):
    """What a script printed, to either stream; it must end with this exit code and leave JAX as it was."""
    printed, ended = io.StringIO(), 0
    with (
        mock.patch("sys.argv", [name, *map(str, options)]),
        contextlib.redirect_stdout(printed),
        contextlib.redirect_stderr(printed),
    ):
        try:
            runpy.run_path(str(SIMS / name), run_name="__main__")
        except SystemExit as stopped:
            ended = stopped.code or 0
    assert ended == code, printed.getvalue()
    assert not jax.config.jax_enable_x64, f"{name} has changed the precision of everything after it"
    return printed.getvalue()
