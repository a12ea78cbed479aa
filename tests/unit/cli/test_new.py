"""`new` names a scene as its file is named: else two scenes copied from one would claim the same run folder."""

import tomllib

import pytest

from astroinertia.cli.main import main
from astroinertia.scene import load
from astroinertia.storage.data_tables import scenes


@pytest.mark.parametrize("ready_made", [[], ["--from", "evrard"], ["--from", "earth_precession"]])
@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("mine.toml", "mine"),
        ("a much longer name, of 2 cores & 3 moons.toml", "a_much_longer_name__of_2_cores___3_moons"),
        ("-v1.2.toml", "v1_2"),
        (f"{80 * 'x'}.toml", 64 * "x"),
    ],
)
def test_a_new_scene_has_the_name_of_its_file(tmp_path, ready_made, file, name):
    assert main(["new", *ready_made, str(tmp_path / file)]) == 0
    assert load.load_file(tmp_path / file).name == name


def test_nothing_but_the_name_is_another(tmp_path):
    """Of companions, which have names of their own, too."""
    main(["new", "--from", "earth_precession", str(tmp_path / "mine.toml")])
    copied = tomllib.loads((tmp_path / "mine.toml").read_text())
    assert copied.pop("name") == "mine"
    original = tomllib.loads(scenes()["earth_precession"].read_text())
    assert original.pop("name") == "earth_precession" and copied == original


def test_a_name_without_letters_and_the_screen_leave_it_as_it_is(tmp_path, capsys):
    main(["new", "--from", "evrard", str(tmp_path / "___.toml")])
    assert load.load_file(tmp_path / "___.toml").name == "evrard"
    main(["new", "--from", "evrard"])
    assert 'name = "evrard"' in capsys.readouterr().out
