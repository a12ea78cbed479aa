"""The look at an HDF5 file before netCDF opens it: it finds just what h5py finds, and refuses what leads elsewhere."""

import h5py
import numpy as np
import pytest

from astroinertia.storage import hdf5_structure
from tests.hard.whole_files import ROOT


def written(path, names, version, ordered):
    """Groups and datasets, some of them with long names, a part of them removed again."""
    with h5py.File(path, "w", libver=version, track_order=ordered) as file:
        group = file.create_group("snapshots", track_order=ordered)
        for k in range(names):
            file.create_group(f"a group with a longer name than others {k}" if k % 3 else f"g{k}")
        for k in range(names // 2):
            group[f"d{k}"] = k
        for k in range(1, names, 5):
            if k % 3:
                del file[f"a group with a longer name than others {k}"]


def objects(path):
    found = ["/"]
    with h5py.File(path) as file:
        file.visit(lambda name: found.append(name))
    return len(found)


@pytest.mark.parametrize("version", ["earliest", "v108", "latest"])
@pytest.mark.parametrize("ordered", [False, True])
def test_every_object_is_found_in_every_form_of_groups(tmp_path, version, ordered):
    """Few names lie in the header of a group, more in a tree with a heap, very many in trees of several levels."""
    for names in (1, 8, 9, 100, 1500):
        written(tmp_path / "file.h5", names, version, ordered)
        assert hdf5_structure.check(tmp_path / "file.h5") == objects(tmp_path / "file.h5")


def test_old_results_are_trees():
    path = ROOT / "tests" / "data" / "format_1.nc"
    assert hdf5_structure.check(path) == objects(path) > 50


def test_what_leads_elsewhere_is_refused_wherever_it_is(tmp_path):
    outside = tmp_path / "outside.h5"
    with h5py.File(outside, "w") as file:
        file["a"] = np.ones(3)

    def external(group):
        group.create_dataset("x", (3,), "f8", external=[(str(outside), 0, 24)])

    def virtual(group):
        layout = h5py.VirtualLayout((3,), "f8")
        layout[:] = h5py.VirtualSource(str(outside), "a", (3,))
        group.create_virtual_dataset("x", layout)

    wrong = {
        "not followed": [lambda group: group.update(x=h5py.ExternalLink(str(outside), "a"))],
        "to paths": [lambda group: group.update(x=h5py.SoftLink("/snapshots"))],
        "another file": [external],
        "other files": [virtual],
        "circle": [lambda group: group.update(x=group), lambda group: group.update(x=group.parent)],
    }
    for version in ("earliest", "latest"):
        for names in (1, 100):
            for said, changes in wrong.items():
                for change in changes:
                    written(tmp_path / "file.h5", names, version, True)
                    with h5py.File(tmp_path / "file.h5", "a") as file:
                        change(file.create_group("last"))
                    with pytest.raises(ValueError, match=said):
                        hdf5_structure.check(tmp_path / "file.h5")


def test_an_end_that_is_cut_off_and_too_much_are_refused(tmp_path):
    path = tmp_path / "file.h5"
    written(path, 100, "v108", True)
    content = path.read_bytes()
    for length in range(16, len(content) // 2, 997):
        path.write_bytes(content[:length])
        with pytest.raises(ValueError, match=r"ends before its time|damaged"):
            hdf5_structure.check(path)
    with h5py.File(path, "w") as file:
        for k in range(hdf5_structure.MOST_OBJECTS + 1):
            file.create_group(str(k))
    with pytest.raises(ValueError, match="objects"):
        hdf5_structure.check(path)
    with h5py.File(path, "w") as file:
        file.create_group("/".join("g" * (hdf5_structure.DEEPEST + 1)))
    with pytest.raises(ValueError, match="levels"):
        hdf5_structure.check(path)
