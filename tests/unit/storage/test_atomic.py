"""Files written aside: by several at once, and what killed processes leave."""

import pytest

from astroinertia.errors import ArchiveError
from astroinertia.storage.atomic import remove_leftovers, sha256, write_whole


def test_two_that_write_the_same_path_at_once_do_not_spoil_each_other(tmp_path):
    path, digests = tmp_path / "result.txt", {}

    def slow(aside):
        with aside.open("w") as stream:
            stream.write("the first, ")
            digests["second"] = write_whole(path, lambda other: other.write_text("the second"))
            assert path.read_text() == "the second" and sha256(path) == digests["second"]
            stream.write("whole")

    digests["first"] = write_whole(path, slow)
    assert path.read_text() == "the first, whole" and sha256(path) == digests["first"]
    assert list(tmp_path.iterdir()) == [path]


def test_nothing_stays_of_a_file_that_failed(tmp_path):
    path = tmp_path / "result.txt"

    def fail(aside):
        assert aside.parent == tmp_path  # a rename is whole only within one filesystem
        aside.write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(ArchiveError, match=r"result\.txt cannot be written: No space left on device"):
        write_whole(path, fail)
    assert not list(tmp_path.iterdir())


def test_leftovers_of_killed_processes_are_known_by_their_names(tmp_path):
    left = []
    with pytest.raises(ArchiveError):
        write_whole(tmp_path / "sweep.nc", lambda aside: left.append(aside.name))  # nothing is there to be renamed
    others = {"sweep.nc", "sweep.tmp", "my.sweep.nc.tmp", "sweep.nc.0123.tmp"}
    for name in (*left, *others, "sweep.nc.tmp"):
        (tmp_path / name).touch()
    remove_leftovers(tmp_path, ("sweep.nc",))
    assert {path.name for path in tmp_path.iterdir()} == others
