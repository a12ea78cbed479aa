"""How far a run is, on a terminal that is narrow and where there is none."""

import io
import re

import nbformat
import pytest
from nbclient import NotebookClient
from rich.console import Console

from astroinertia.process import activity
from astroinertia.run import loop, meter as meters
from astroinertia.run.meter import Meter
from astroinertia.scene.load import load_file
from tests.sims import SIMS


def lines(width, act):
    """What a terminal of so many columns shows at the end, without what moves its cursor."""
    text = io.StringIO()
    with Meter(Console(file=text, force_terminal=True, width=width)) as meter:
        act(meter)
        meter.bar.refresh()
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text.getvalue()).replace("\r", "\n").splitlines()


def test_a_narrow_terminal_shortens_words_and_never_the_time():
    progress = loop.Progress(0.5, 1.0, 230, 20.0, 1e-4, 1e-15, 1e3, limited_by="viscosity at radius 0.03", to_go=12.0)
    shown = lines(72, lambda meter: meter.tell(progress))
    last = [line for line in shown if "12 s to go" in line][-1]
    assert " 50%" in last and "0:00:0" in last and last.rstrip().endswith("…")
    assert max(map(len, shown)) <= 72


def test_before_the_first_step_a_model_is_said_to_do_what_it_does():
    said = {
        name: meters.preparing(load_file(SIMS / f"{name}.toml"))
        for name in ("evrard", "star_and_companion", "tennis_racket", "earth_precession", "riemann_ellipsoid")
    }
    assert {name for name, words in said.items() if "settling" in words} == {"evrard", "star_and_companion"}
    assert {name for name, words in said.items() if "orbits of its companions" in words} == {
        "star_and_companion", "earth_precession",
    }  # fmt: skip


def test_densities_are_shown_in_their_unit():
    reported = loop.Progress(0.5, 1.0, 230, 20.0, 1e-4, 1e-15, 6.9e16, density_unit="kg m-3")
    assert any("densest 6.9e+16 kg m-3 " in line for line in lines(160, lambda meter: meter.tell(reported)))
    nothing = loop.Progress(0.5, 1.0, 230, 20.0, 1e-4, 1e-15, float("nan"), density_unit="kg m-3")
    assert not any("densest" in line for line in lines(160, lambda meter: meter.tell(nothing)))


def test_what_compiles_is_shown_while_it_does():
    def compiling(meter):
        activity.begin("compiling density pass")
        meter.bar.refresh()
        activity.end("compiling density pass")

    shown = lines(90, compiling)
    assert any("compiling density pass" in line for line in shown)
    assert meters.PREPARING in shown[-1]


@pytest.mark.slow
def test_a_line_where_there_is_no_terminal_says_what_compiles(monkeypatch):
    monkeypatch.setattr(meters, "LONGEST_SILENCE", 0.1)
    text = io.StringIO()
    activity.begin("compiling density pass")
    with Meter(Console(file=text)) as meter:
        meter.voice.ended.wait(0.5)
    activity.end("compiling density pass")
    assert "compiling density pass" in text.getvalue()


def test_lines_come_more_often_than_words_that_work_goes_on_and_the_last_one_once():
    assert meters.SECONDS_BETWEEN_LINES < meters.LONGEST_SILENCE
    text = io.StringIO()
    with Meter(Console(file=text, width=200)) as meter:
        for part in ("", "companion run 1 of 1"):
            for share, seconds in ((0.0, 0.0), (0.5, 1.0), (0.8, 7.0), (0.9999999999999, 8.0), (1.0, 8.1)):
                meter.tell(loop.Progress(3.0 * share, 3.0, 10, seconds, 1e-4, 1e-15, 1e3, part=part))
    shown = [line.split()[0] for line in text.getvalue().splitlines()]
    assert shown == 2 * ["0.0%", "80.0%", "100.0%"]


IN_A_NOTEBOOK = """
import astroinertia
body = {"kind": "rigid", "mass": "1 kg", "moments": ["1 kg m2", "2 kg m2", "3 kg m2"], "rotation": {"rate": "1 rad/s"}}
scene = {"name": "top", "model": "rigid", "body": body, "effects": [], "numerics": {"integrator": "splitting"},
         "time": "4 s", "output": {"series_every": "1 s"}}
"""


@pytest.mark.full
def test_a_cell_of_a_notebook_shows_a_bar_by_itself_or_nothing(tmp_path):
    cells = [f"astroinertia.run_scene(scene, {str(tmp_path / name)!r}{more}).name"
             for name, more in (("shown", ""), ("silent", ", progress=False"))]  # fmt: skip
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in (IN_A_NOTEBOOK, *cells)])
    NotebookClient(notebook, timeout=300).execute()
    (bar, name), (alone,) = (cell.outputs for cell in notebook.cells[1:])
    assert bar.output_type == "display_data" and '<progress value="1.0000">' in bar.data["text/html"]
    assert bar.data["text/plain"].startswith("100 %")
    assert name.data["text/plain"] == alone.data["text/plain"] == "'top.nc'"
