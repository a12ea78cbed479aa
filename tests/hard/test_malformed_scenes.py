"""Malformed scenes: exit code 2, one clear sentence, no traceback, nothing written, in bounded time and memory."""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

from astroinertia.cli.main import main

ROOT = Path(__file__).parents[2]
GOOD = """\
name = "star"
[body]
kind = "polytrope"
particles = 1000
mass = "1.4 Msun"
radius = "1500 km"
index = 1.5
[body.rotation]
rate = "1 rad/s"
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = "1 s"
"""


def swap(old: str, new: str) -> str:
    assert old in GOOD
    return GOOD.replace(old, new)


def add(text: str) -> str:
    return GOOD + text


# name: (text or bytes of the scene file, words that the sentence must have)
TEXTS = {
    "wrong unit": (swap('"1500 km"', '"1500 kg"'), r"line 6: \[body\] radius: '1500 kg' is not a length"),
    "mass with a length unit": (swap('"1.4 Msun"', '"1.4 km"'), r"line 5.*'1.4 km' is not a mass"),
    "no unit": (swap('"1.4 Msun"', "1.4"), "must have a unit"),
    "number in quotes": (swap('"1.4 Msun"', '"1.4"'), "not a number and a unit"),
    "unknown unit": (swap("1500 km", "1500 kilofurlongs"), "not a unit that is known"),
    "unit of no mechanics": (swap("1500 km", "1500 K"), "not a unit of mechanics"),
    "logarithmic unit": (swap("1500 km", "15 mag"), "finite size"),
    "huge exponent": (swap("1500 km", "1500 m**1000000"), "exponent beyond 99"),
    "exponent of a hundred digits": (swap("1500 km", f"1 m**{'9' * 60}"), "exponent beyond 99"),
    "divided by zero in a unit": (swap("1500 km", "1 m**(1/0)"), "not a unit that is known"),
    "long quantity": (swap("1500 km", "1500 " + "km " * 200), "longer than"),
    "nan in a quantity": (swap("1.4 Msun", "nan Msun"), "not a finite number"),
    "overflow in a quantity": (swap("1.4 Msun", "1e400 Msun"), "not a finite number"),
    "underflow in a quantity": (swap("1.4 Msun", "1e-400 Msun"), "too small"),
    "number too large to calculate with": (swap("1.4 Msun", "1e250 kg"), "no larger than"),
    "hertz for an angular velocity": (swap("1 rad/s", "1 Hz"), "radians or turns"),
    "nan": (swap("index = 1.5", "index = nan"), r"\[body\] index"),
    "infinity": (swap("index = 1.5", "index = inf"), r"\[body\] index"),
    "nan in code units": (
        'name = "a"\nunits = "code"\n[time]\nend = nan\n[effects]\n',
        r"line 4: \[time\] end: must be a finite number",
    ),
    "units in code units": ('units = "code"\n' + GOOD, "must be a plain number"),
    "negative mass": (swap("1.4 Msun", "-1.4 Msun"), "must be positive"),
    "zero radius": (swap("1500 km", "0 km"), "must be positive"),
    "negative time": (swap('"1 s"', '"-1 s"'), "must be positive"),
    "unknown key": (swap("radius", "radios"), "did you mean 'radius'"),
    "unknown table": (add("[numeric]\n"), "did you mean 'numerics'"),
    "unknown effect": (swap("gravity", "gravitty"), "did you mean 'gravity'"),
    "unknown option of an effect": (add("[effects.viscosity]\nbetta = 1\n"), "did you mean 'beta'"),
    "unknown kind": (swap('"polytrope"', '"polytropic"'), "did you mean 'polytrope'"),
    "kind that names code": (swap('"ideal"', '"os.system"'), "must be one of ideal"),
    "effect that names code": (swap("gravity", '"astroinertia.errors"'), "not a known effect"),
    "no kind": (swap('kind = "ideal"', ""), "kind is missing"),
    "missing key": (swap('mass = "1.4 Msun"', ""), "mass is missing"),
    "missing table": (GOOD.partition("[time]")[0], r"\[time\] is missing"),
    "missing option of an effect": (add("[effects.damping]\n"), "time_scale is missing"),
    "key of another kind": (swap("index", "exponent"), "belongs to the kind power_law"),
    "two rotations": (swap("rate =", "t_over_w = 0.1\nrate ="), "exactly one of"),
    "no rotation given": (swap('rate = "1 rad/s"', ""), "none is given"),
    "axis of zero length": (swap("rate =", "axis = [0, 0, 0]\nrate ="), "zero length"),
    "too short a vector": (swap("rate =", "axis = [0, 1]\nrate ="), "longer list"),
    "text for a number": (swap("1000", '"many"'), "whole number"),
    "number for a text": (swap('"star"', "3"), "text in quotes"),
    "fraction of a particle": (swap("1000", "1000.5"), "whole number"),
    "too many particles": (swap("1000", "100000000000000000000"), "at most"),
    "integer of a thousand digits": (swap("1000", "9" * 1000), "at most|not TOML"),
    "true for a number": (swap("1.5", "true"), "must be a number"),
    "date for a number": (swap("1.5", "2026-01-01"), "must be a number"),
    "table for a number": (swap("1.5", "{a = 1}"), "must be a number"),
    "number for a table": (swap("[effects.gravity]", "[effects]\ngravity = 3"), "must be a table"),
    "name that leaves the folder": (swap('"star"', '"../../etc/star"'), "letters, digits"),
    "outputs without end": (add('[output]\nseries_every = "1e-30 s"\n'), "make it longer"),
    "both eta and neighbours": (add("[numerics]\neta = 1.2\nneighbours = 60\n"), "keep one"),
    "key given twice": (swap("index = 1.5", "index = 1.5\nindex = 2"), r"line 8.*not TOML"),
    "table given twice": (add("[body]\n"), "not TOML"),
    "unclosed string": (swap('"star"', '"star'), r"line 1.*not TOML"),
    "unclosed list": (swap("1.5", "[1.5"), "not TOML"),
    "no TOML at all": ('{"name": "star"}', "not TOML"),
    "impossible date": (swap("1.5", "2026-02-31"), "not TOML|must be a number"),
    "empty file": ("", "is missing"),
    "binary junk": (bytes(range(256)) * 16, "not UTF-8|not TOML"),
    "executable": (b"\x7fELF\x02\x01\x01" + b"\0" * 500, "not TOML"),
    "not UTF-8": (GOOD.encode() + "# Mönchmeyer\n".encode("latin-1"), r"line 16.*not UTF-8"),
    "UTF-16": (GOOD.encode("utf-16"), "not UTF-8"),
    "escape codes in a key": (add('"\\u001b[31m\\n" = 1\n'), "not a known key"),
    "long line": (add("# " + "x" * 2000 + "\n"), r"line 16.*longer than"),
    "long dotted key": (add("a" + ".a" * 32000 + " = 1\n"), "longer than"),
    "many long dotted keys": (add(("b" + ".a" * 500 + "\n= 1\n") * 50), "not TOML"),
    "tables nested deeply": (add("[" + ".".join("a" * 200) + "]\n"), "nested deeper"),
    "lists nested deeply": (add("[numerics]\neta = " + "[" * 500 + "]" * 500 + "\n"), "nested deeper"),
    "lists nested over many lines": (
        add("[numerics]\neta = " + "[\n" * 20000 + "]\n" * 10000),
        "nested deeper|not TOML",
    ),
    "large file": (GOOD + "# x\n" * 20000, "larger than the 64 KiB"),
}

OVERRIDES = {
    "no value": (["body.mass"], "key=value"),
    "empty value": (["body.mass="], "key=value"),
    "no key": (["=3"], "names joined by dots"),
    "quoted key": (['"body".mass=3'], "names joined by dots"),
    "into a number": (["body.index.x=3"], "not a table"),
    "two keys in one": (["body.index=1\nrelax=false"], "one line"),
    "nested value": (["body.index=" + "[" * 300 + "]" * 300], "nested deeper"),
    "long value": (["name=" + "x" * 5000], "at most 1024"),
    "wrong unit": (["body.mass=3 km"], "not a mass"),
    "unknown key": (["body.masss=3 kg"], "did you mean 'mass'"),
}


def tree(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


def is_one_sentence(printed: str) -> bool:
    """One printable line that ends with a full stop or a question mark and has no other sentence in it."""
    line = printed.removesuffix("\n")
    prefix = "astroinertia: "
    return (
        line.startswith(prefix)
        and line.endswith((".", "?"))
        and line.isprintable()
        and not re.search(r"[.!?] +[A-Z]", line)
    )


@pytest.fixture
def refused(elsewhere, capsys):
    """Runs the command in a folder; it must refuse as it should, and the sentence must have the words."""

    def check(arguments, words, silent=True):
        before, started = tree(elsewhere), time.perf_counter()
        assert main(arguments) == 2
        assert time.perf_counter() - started < 5.0
        printed = capsys.readouterr()
        assert printed.out == "" or not silent
        assert is_one_sentence(printed.err), printed.err
        assert re.search(words, printed.err), printed.err
        assert "Traceback" not in printed.err
        assert len(printed.err) < 600
        assert tree(elsewhere) == before

    return check


def test_the_scene_that_is_spoilt_is_good(elsewhere, capsys):
    (elsewhere / "scene.toml").write_text(GOOD)
    assert main(["plan", "scene.toml"]) == 0


@pytest.mark.quick
@pytest.mark.parametrize("command", ["plan", "run"])
@pytest.mark.parametrize("name", TEXTS)
def test_malformed_text(name, command, elsewhere, refused):
    text, words = TEXTS[name]
    (elsewhere / "scene.toml").write_bytes(text if isinstance(text, bytes) else text.encode())
    refused([command, "scene.toml"], words)


@pytest.mark.quick
@pytest.mark.parametrize("name", OVERRIDES)
def test_malformed_overrides(name, elsewhere, refused):
    overrides, words = OVERRIDES[name]
    (elsewhere / "scene.toml").write_text(GOOD)
    refused(["run", "scene.toml", *(part for item in overrides for part in ("--set", item))], words)


@pytest.mark.quick
def test_no_file(elsewhere, refused):
    refused(["run", "nosuch.toml"], "there is no file")


@pytest.mark.quick
def test_misspelt_file_name(elsewhere, refused):
    (elsewhere / "scene.toml").write_text(GOOD)
    refused(["run", "scenes.toml"], "the nearest name is scene.toml")


@pytest.mark.quick
def test_directory(elsewhere, refused):
    (elsewhere / "folder").mkdir()
    refused(["run", "folder"], "is a directory")


@pytest.mark.quick
def test_pipe_is_not_waited_for(elsewhere, refused):
    os.mkfifo(elsewhere / "pipe")
    refused(["run", "pipe"], "not a regular file")


@pytest.mark.quick
@pytest.mark.parametrize("device", ["/dev/zero", "/dev/null", "/dev/stdin"])
def test_link_to_a_device(device, elsewhere, refused):
    (elsewhere / "link").symlink_to(device)
    refused(["run", "link"], "not a regular file|is missing")


@pytest.mark.quick
def test_link_to_itself(elsewhere, refused):
    (elsewhere / "loop").symlink_to("loop")
    refused(["run", "loop"], "cannot be read")


@pytest.mark.quick
@pytest.mark.parametrize(
    "name", ["a\0b", "x" * 5000, "line\nbreak", "\udcff"], ids=["nul", "long", "newline", "surrogate"]
)
def test_impossible_file_names(name, elsewhere, refused):
    refused(["run", name], "cannot be read|there is no file")


@pytest.mark.quick
@pytest.mark.skipif(os.geteuid() == 0, reason="no file can be made unreadable for the superuser")
def test_unreadable_file(elsewhere, refused):
    (elsewhere / "scene.toml").write_text(GOOD)
    (elsewhere / "scene.toml").chmod(0)
    refused(["run", "scene.toml"], "cannot be read")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["effects.damping={time_scale='1 s', axis=[0, 0, 0], rate='1 rad/s'}"], "damping"),
        (["effects.external_field={core='1 km'}"], "external_field"),
        (["body={kind='table', file='nosuch.csv'}", "units={mass='1 Msun', length='1 km'}"], "nosuch.csv"),
        (["body={kind='table', file='/dev/zero'}", "units={mass='1 Msun', length='1 km'}"], "/dev/zero"),
    ],
    ids=["zero axis of damping", "core without speed", "missing table", "table that is a device"],
)
def test_what_only_the_build_can_see(settings, words, elsewhere, refused):
    (elsewhere / "scene.toml").write_text(GOOD)
    overrides = [part for item in settings for part in ("--set", item)]
    refused(["run", "scene.toml", *overrides], words, silent=False)


# Run in a process of its own: prints the exit code and the peak memory in MiB.
MEASURED = """
import sys
from astroinertia.cli.main import main
code = main(sys.argv[1:])
# not ru_maxrss, which begins with the size of the process that started this one
with open("/proc/self/status") as status:
    peak = next(line for line in status if line.startswith("VmHWM:"))
print(code, int(peak.split()[1]) / 1024)
"""


@pytest.mark.parametrize(
    "name",
    [
        "long dotted key",
        pytest.param("many long dotted keys", marks=pytest.mark.full),
        pytest.param("lists nested over many lines", marks=pytest.mark.full),
        "large file",
        pytest.param("binary junk", marks=pytest.mark.full),
        "wrong unit",
    ],
)
def test_time_and_memory_stay_bounded(name, elsewhere):
    text, _ = TEXTS[name]
    (elsewhere / "scene.toml").write_bytes(text if isinstance(text, bytes) else text.encode())
    _bounded(elsewhere, "scene.toml")


@pytest.mark.full
@pytest.mark.parametrize("keys", ["a.a", "[a.a", "a = {a.a"], ids=["keys", "tables", "inline"])
def test_the_worst_that_the_limits_let_through_stays_bounded(keys, elsewhere):
    # dotted keys cost memory with the square of their length: 64 lines of 1 KiB are the worst case
    begin, end = {"a.a": ("", " = 1"), "[a.a": ("[", "]"), "a = {a.a": ("a{} = {{", " = 1}}")}[keys]
    lines = []
    for number in range(62):
        head = begin.format(number) if "{}" in begin else begin
        lines.append(f"{head}k{number}{'.a' * 495}{end.replace('}}', '}')}".replace("{{", "{"))
    (elsewhere / "scene.toml").write_text("\n".join(lines))
    assert (elsewhere / "scene.toml").stat().st_size > 60000
    _bounded(elsewhere, "scene.toml")


def test_a_device_is_not_read_to_its_end(elsewhere):
    _bounded(elsewhere, "/dev/zero")


def _bounded(folder: Path, scene: str):
    before = tree(folder)
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, "run", scene],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=30,
        stdin=subprocess.DEVNULL,
        check=False,
    )
    code, memory = done.stdout.split()
    assert int(code) == 2
    assert is_one_sentence(done.stderr), done.stderr
    assert float(memory) < 500.0
    assert tree(folder) == before


def test_the_installed_command_returns_the_code(elsewhere):
    (elsewhere / "scene.toml").write_text(swap("1500 km", "1500 kg"))
    command = Path(sys.executable).parent / "astroinertia"
    arguments = [str(command)] if command.exists() else [sys.executable, "-m", "astroinertia"]
    done = subprocess.run(
        [*arguments, "run", "scene.toml"],
        cwd=elsewhere,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert is_one_sentence(done.stderr)


def test_a_signal_of_many_sentences_is_seen():
    assert is_one_sentence("astroinertia: scene.toml, line 3: the mass is wrong.\n")
    assert not is_one_sentence("astroinertia: the mass is wrong. It must be positive.\n")
    assert not is_one_sentence("astroinertia: one\nastroinertia: two.\n")
    assert not is_one_sentence("Traceback (most recent call last):\n")
