"""Scenes with mistakes that chance made: refused in a sentence or planned, within seconds, and nothing is written."""

import time
from pathlib import Path

import pytest

from astroinertia.cli.main import main
from astroinertia.costs.machine import peak_memory
from tests.hard.mutated_scenes import mutated
from tests.scripts import SIMS

SLOWEST = SIMS / "core_collapse.toml"  # the scene of sims/ whose plan takes longest, once all is imported
LONGEST = 2.0  # plans of it, in processor time
MOST = 300e6  # bytes more than before


def planned(seed, count, folder, capsys):
    """Figures of so many plans; fails at the first that is not as it should be."""
    scene = folder / "scene.toml"
    codes = {0: 0, 2: 0}
    _, slowest = (seconds_of_plan(SLOWEST)[1] for _ in range(2))  # the first one imports
    capsys.readouterr()
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins again: what ran before may have held more
    longest, before = 0.0, peak_memory()
    for text in mutated(seed, count):
        scene.write_text(text, encoding="utf-8", errors="surrogatepass")
        code, seconds = seconds_of_plan(scene)
        complaint = capsys.readouterr().err
        if seconds > LONGEST * slowest:  # what it imported, or a slow moment of the machine, does not come again
            seconds = min(seconds, seconds_of_plan(scene)[1])
            capsys.readouterr()
        longest = max(longest, seconds)
        assert code in codes, (text, complaint)
        codes[code] += 1
        if code:
            assert complaint.startswith("astroinertia: ") and complaint.count("\n") == 1, (text, complaint)
    assert [path.name for path in folder.iterdir()] == ["scene.toml"]
    more = peak_memory() - before
    assert longest < LONGEST * slowest and more < MOST
    return {
        "planned": codes[0], "refused": codes[2], "longest_seconds": round(longest, 2),
        "longest_over_slowest_shipped": round(longest / slowest, 2), "more_bytes": more,
    }  # fmt: skip


def seconds_of_plan(scene):
    """Exit code of its plan, and the seconds of processor time that it took."""
    begun = time.process_time()
    code = main(["plan", str(scene)])
    return code, time.process_time() - begun


def test_scenes_with_a_mistake_are_planned_or_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    found = planned(1, 40, tmp_path, capsys)
    assert found["refused"] > 20 and found["planned"] > 2  # most changes are mistakes, but not all


def test_a_needle_without_a_moment_about_itself_is_planned(tmp_path):
    text = (SIMS / "riemann_ellipsoid.toml").read_text()
    needle = text.replace("axes = [1.3729520210870014,", "axes = [1e19,")
    assert needle != text
    (tmp_path / "needle.toml").write_text(needle)
    assert main(["plan", str(tmp_path / "needle.toml")]) == 0


@pytest.mark.full(inputs=["tests/hard/mutated_scenes.py"])
def test_ten_thousand_of_them(tmp_path, monkeypatch, capsys, result):
    monkeypatch.chdir(tmp_path)
    result(**planned(2, 10_000, tmp_path, capsys))
