"""Nothing that a file says acts on the terminal."""

import io
import json

import netCDF4
import numpy as np
import pytest
from rich.table import Table
from rich.text import Text

from astroinertia.cli import main as cli
from astroinertia.cli.screen import visible

EVIL = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202eevil\r\x08"


def acts(text):
    return [each for each in text if each in EVIL and each not in "]0;owned[2J31mevil"]


def test_words_numbers_and_lines_stay():
    text = "ρ = 10⁴¹ kg m², I/(M R²)\n\tcentre\u00a0of mass\n"
    assert visible(text) == text
    assert visible(text, lines=False).count("?") == 3
    assert not acts(visible(EVIL)) and "evil" in visible(EVIL)


def test_what_the_console_shows_is_clean_and_its_own_colours_stay():
    stream = io.StringIO()
    console = cli._Console(file=stream, force_terminal=True, color_system="standard")
    table = Table(EVIL, title=Text(EVIL))
    table.add_row(Text(EVIL, style="red"))
    console.print(table, Text(EVIL), EVIL)
    text = stream.getvalue()
    assert "\x1b[31m" in text  # the style
    assert "\x1b]" not in text and "\x1b[2J" not in text and "\x07" not in text and "\u202e" not in text


@pytest.fixture
def table(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with netCDF4.Dataset("evil.nc", "w") as file:
        file.astroinertia_format = 1
        file.scene = EVIL
        file.createDimension("time", 2)
        file.createVariable("time", "f8", ("time",)).long_name = EVIL
        snapshots = file.createGroup("snapshots")
        for name, size in (("snapshot_time", 1), ("particle", 4), ("i", 3)):
            snapshots.createDimension(name, size)
        time = snapshots.createVariable("snapshot_time", "f8", ("snapshot_time",))
        time[:], time.units = 0.0, EVIL
        mass = snapshots.createVariable("mass", "f8", ("snapshot_time", "particle"))
        mass[:], mass.units = 1.0, EVIL
        snapshots.createVariable("position", "f8", ("snapshot_time", "particle", "i"))[:] = np.eye(4, 3)
    return tmp_path


@pytest.mark.parametrize("command", ["moments", "show", "report"])
def test_attributes_do_not_reach_the_terminal(table, capsys, command):
    cli.main([command, "evil.nc"])
    said = capsys.readouterr()
    assert said.out + said.err
    assert not acts(said.out + said.err)


def test_why_a_member_failed_does_not_reach_the_terminal(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    scene = 'name = "s"\nmodel = "scaling"\n[sweep]\n"body.mass" = ["1 Msun"]\n[body]\nkind = "power_law"\n'
    scene += 'exponent = 1.0\nmass = "1 Msun"\nradius = "9 km"\n[effects.gravity]\n[time]\nend = "1 s"\n'
    (tmp_path / "s.toml").write_text(scene)
    assert cli.main(["run", "s.toml", "--output", "sweep"]) == 1  # it collapses
    (tmp_path / "sweep/member-0000/failure.json").write_text(json.dumps({"sentence": EVIL, "lasting": True}))
    capsys.readouterr()
    cli.main(["resume", "sweep"])
    said = capsys.readouterr()
    assert "evil" in said.out + said.err
    assert not acts(said.out + said.err)


def test_a_terminal_without_a_character_shows_another_for_it(monkeypatch, capsys):
    """As in a locale without UTF-8: nothing is lost but that character."""
    shown = {}
    for encoding in ("utf-8", "ascii"):
        stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
        monkeypatch.setattr("sys.stdout", stream)
        assert cli.main(["guide", "ledger"]) == 0
        shown[encoding] = stream.buffer.getvalue().decode(encoding)
    assert not shown["utf-8"].isascii() and not capsys.readouterr().err
    assert shown["ascii"] == shown["utf-8"].encode("ascii", "replace").decode()
