"""Numbers at their extremes: each plan ends well, or is refused in one sentence, in time and within its memory."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from astroinertia.cli import main as cli
from astroinertia.errors import SceneError
from astroinertia.scene.load import load_file, loads
from astroinertia.scene.plan import plan
from astroinertia.storage.columns import Columns
from astroinertia.test_problems.matter import standard
from tests.sims import SIMS

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("share", "most"), [(0.005, 300), pytest.param(1.0, 7200, marks=pytest.mark.full)], ids=["a sample", "all"]
)
def test_plans_of_extreme_numbers_end_well_or_with_one_sentence(share: float, most: int) -> None:
    """In a process of its own: tests/extreme_numbers.py bounds time and memory, and names what went wrong."""
    command = [sys.executable, "-m", "tests.extreme_numbers", str(share), "11"]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=most, check=True)
    *wrong, counts = map(json.loads, ended.stdout.splitlines())
    assert not wrong
    assert set(counts) == {"planned", "refused"}
    assert min(counts.values()) > 0.1 * sum(counts.values()) > 1500 * share


@pytest.mark.parametrize(
    ("scene", "setting", "said"),
    [
        ("static_star", "body.radius=1e-55", "[body] radius: must be at least 1e-35 in the units of the run"),
        ("asteroid_settles", "body.rotation.axis=[0.0, 0.0, 1e199]", "must be a finite number, and no larger than"),
        ("boss_bodenheimer", 'equation_of_state.sound_speed="1e46 km/s"', "must be at most 1e+35 in the units of the"),
        ("free_expansion", "body.entropy=1e150", "[body] entropy: must be at most 1e+35 in the units of the run"),
        (
            "evrard",
            "time.end=1e-40",
            "[time] end: must be at least 1e-35 in the units of the run, in which it is 1e-40",
        ),
        ("roche_disruption", 'effects.tide.mass="1e99 kg"', "[effects.tide] mass: must be at most 1e+35"),
    ],
)
def test_numbers_beyond_what_arithmetic_bears_are_refused_where_they_stand(
    scene: str, setting: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["plan", str(SIMS / f"{scene}.toml"), "--set", setting]) == 2
    (sentence,) = capsys.readouterr().err.splitlines()
    assert said in sentence
    assert setting.partition("=")[0] in sentence


def test_code_units_out_of_range_are_refused() -> None:
    with pytest.raises(SceneError, match=r"\[body\] makes the run's unit of length 1e-50 in SI, which must be between"):
        load_file(SIMS / "boss_bodenheimer.toml", ['body.radius="1e-50 m"'])


@pytest.mark.parametrize("text", ["0.0", "1e-300"])
def test_what_may_be_zero_may_be_as_good_as_zero(text: str) -> None:
    scene = load_file(SIMS / "evrard.toml", [f"body.specific_internal_energy={text}"])
    assert scene.body.specific_internal_energy == float(text)


def test_real_bodies_from_electrons_to_clusters_of_galaxies_are_allowed() -> None:
    text = """
name = "any"
model = "scaling"
body = {{ kind = "uniform", mass = "{} kg", radius = "{} m", rotation = {{ period = "{} s" }} }}
effects = {{ gravity = {{}} }}
time = {{ end = "{} s" }}
"""
    for mass, radius, period, end in ((9e-31, 3e-15, 1e-20, 1.0), (1e46, 1e23, 1e17, 1e18), (3e30, 1e4, 1e-3, 3e17)):
        assert loads(text.format(mass, radius, period, end)).body.mass == mass  # type: ignore[union-attr]


@pytest.mark.parametrize("problem", ["gresho", "sedov", "square", "kelvin_helmholtz", "sod"])
def test_particles_of_a_flat_box_are_counted_before_they_are_placed(problem: str) -> None:
    """A lattice has a cell at least along each side: without a limit a flat box has thousands of times more."""

    with pytest.raises(SceneError, match=r"too flat for a lattice of about \d+ particles: it would have .*e\+"):
        standard(problem).place(100, np.array([1e-9, 1.0, 0.25]), 5 / 3)
    assert len(standard(problem).place(100, np.array([1.0, 1.0, 0.25]), 5 / 3).mass) < 800


@pytest.mark.slow
def test_a_star_whose_law_lets_it_not_turn_at_all_is_refused_with_the_limit() -> None:
    """j constant outside of 1e-30 km is no rotation: no period is the least."""
    with pytest.raises(SceneError, match=r"the least axis_ratio is 1\."):
        plan(load_file(SIMS / "core_collapse.toml", ["body.scale=1e-30 km"]))


def test_repeated_columns_are_named() -> None:
    columns = Columns("the table", ("mass", "x"), ("u",), 10)
    with pytest.raises(
        SceneError, match=r"the table t\.csv has columns more than once, namely x; its columns are mass"
    ):
        columns.check(Path("t.csv"), ["mass", "x", "x"])
    with pytest.raises(SceneError, match="has unknown columns colour; its"):
        columns.check(Path("t.csv"), ["mass", "x", "colour"])
