"""What waits for a package is done once, at the end of its import, or at once where it is there."""

import subprocess
import sys

import pytest

from astroinertia.process.imports import once_imported


def test_what_waits_is_done_once_at_the_end_of_the_import(tmp_path, monkeypatch):
    (tmp_path / "a_late_package.py").write_text("ready = True\n")
    monkeypatch.syspath_prepend(tmp_path)
    seen = []

    def note():
        seen.append(sys.modules["a_late_package"].ready)

    once_imported("a_late_package", note)
    once_imported("a_late_package", note)
    assert not seen
    import a_late_package

    assert a_late_package.ready and seen == [True]
    once_imported("a_late_package", note)  # which is there by now
    assert seen == [True, True]


@pytest.mark.slow
@pytest.mark.parametrize("order", ["astroinertia, xarray as xr", "xarray as xr, astroinertia"])
def test_datasets_have_the_accessor_whichever_package_is_imported_first(order):
    program = (
        f"import {order}; import sys; assert astroinertia and 'astroinertia.dataset.accessor' not in sys.modules;"
        "print(*(hasattr(each, 'inertia') for each in (xr.Dataset, xr.DataTree)))"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", program], capture_output=True, text=True, check=False)
    assert done.stdout == "True True\n", done.stderr


def test_a_package_that_is_imported_later_is_not_imported_by_this_one():
    program = "import sys, astroinertia; print('xarray' in sys.modules, 'numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "False False\n"
