"""A place for numba's programs where the package belongs to somebody else and there is no home."""

import os
import pwd
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from numba import config

from astroinertia.engines import numba_place
from astroinertia.process.cache_directory import cache_directory

SOURCE = "from numba import njit\n\n\n@njit(cache=True)\ndef twice(x):\n    return 2 * x\n"


@pytest.fixture
def nowhere(monkeypatch):
    """An account without a home, an installation that it may not write to, and numba without a directory of its own."""
    monkeypatch.setattr(numba_place, "PACKAGE", Path("/dev/null/astroinertia"))
    monkeypatch.setattr(config, "CACHE_DIR", "")
    monkeypatch.setenv("HOME", "/dev/null")
    for name in ("XDG_CACHE_HOME", "ASTROINERTIA_CACHE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    return monkeypatch


def test_numba_writes_where_generated_modules_are_kept(nowhere, tmp_path):
    nowhere.syspath_prepend(str(tmp_path))
    (tmp_path / "module_of_somebody_else.py").write_text(SOURCE)
    numba_place.give_a_place()
    place = Path(config.CACHE_DIR)
    assert os.environ["NUMBA_CACHE_DIR"] == str(place) and stat.S_IMODE(place.stat().st_mode) == 0o700
    from module_of_somebody_else import twice  # only here: made above

    assert twice(2.0) == 4.0 and Path(twice.stats.cache_path).is_relative_to(place)


def test_numba_has_it_as_soon_as_it_is_imported(nowhere):
    code = (
        "import pathlib, sys, astroinertia\nfrom astroinertia.engines import numba_place\n"
        "assert 'numba' not in sys.modules\nnumba_place.PACKAGE = pathlib.Path('/dev/null/astroinertia')\n"
        "import numba\nprint(numba.config.CACHE_DIR)"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()
    assert said and not Path(said).exists()  # it went with the process


@pytest.mark.parametrize("where", ["package", "home", "own"])
def test_a_place_that_numba_has_is_left_to_it(nowhere, tmp_path, where):
    if where == "package":
        nowhere.setattr(numba_place, "PACKAGE", tmp_path)
    elif where == "home":
        nowhere.setenv("HOME", str(tmp_path / "to" / "be" / "made"))
    else:
        nowhere.setattr(config, "CACHE_DIR", str(tmp_path))
    before = config.CACHE_DIR
    numba_place.give_a_place()
    assert before == config.CACHE_DIR and not os.environ["NUMBA_CACHE_DIR"] and not list(tmp_path.iterdir())


def test_a_user_whom_the_system_does_not_know_keeps_nothing_in_the_folder_they_stand_in(nowhere):
    def unknown(uid):
        raise KeyError(uid)

    nowhere.delenv("HOME")
    nowhere.setattr(pwd, "getpwuid", unknown)
    assert cache_directory() == Path("/dev/null/.cache/astroinertia")
    numba_place.give_a_place()
    assert Path(config.CACHE_DIR).is_absolute()
