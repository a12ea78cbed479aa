"""The scripts of sims/everyday/: what they print is what is known, and their pictures are drawn."""

import re

import pytest

from tests.scripts import run_sim


@pytest.fixture
def printed(tmp_path):
    def run(name, *options):
        lines = run_sim(f"everyday/{name}.py", *options, "--output", tmp_path / "picture.png")
        assert (tmp_path / "picture.png").stat().st_size > 20_000
        return lines

    return run


def numbers(text, pattern):
    """The numbers in the line that the pattern is in."""
    (line,) = [line for line in text.splitlines() if re.search(pattern, line)]
    return [float(number) for number in re.findall(r"(?<![\w.])-?\d+\.?\d*(?:e[+-]\d+)?", line)]


@pytest.mark.slow
def test_pendulums_give_gravity(printed):
    lines = printed("pendulums")
    assert numbers(lines, "gravity from them")[0] == pytest.approx(9.80665, abs=1e-6)
    assert numbers(lines, "Bessel")[1] == pytest.approx(9.80665, abs=1e-6)
    _, upper, lower, length = numbers(lines, "bob at")
    assert upper == lower and length == pytest.approx(1.0)  # the distance of the edges


@pytest.mark.parametrize("cylinders", ["1", pytest.param("4", marks=pytest.mark.full)])
def test_a_flywheel_of_the_moment_by_the_formula_smooths_to_a_hundredth(printed, cylinders):
    lines = printed("flywheel", "--cylinders", cylinders)
    assert numbers(lines, "that disc")[1] == pytest.approx(1.0, abs=4e-3)


def test_beams_sag_as_their_curves_say(printed):
    rows = [line.rsplit(None, 5) for line in printed("beams").splitlines()[1:6]]
    for _, _, _, down, _, curve in rows:
        assert float(down) == pytest.approx(float(curve), abs=1e-3)
    flat, edge = (float(row[1]) for row in (rows[0], rows[2]))
    assert flat == pytest.approx(6 * 2**3 / 12, abs=1e-3) and edge == pytest.approx(2 * 6**3 / 12, abs=1e-3)
    assert float(rows[3][4]) != 0  # an angle sags sideways, too


@pytest.mark.full
def test_limbs_turn_bodies(printed):
    lines = printed("limbs")
    most, least, first, last = numbers(lines, "skater")
    assert first * most == pytest.approx(15.0, abs=0.01) and last * least == pytest.approx(15.0, abs=0.02)
    assert numbers(lines, "cat")[1] == pytest.approx(180.0, abs=0.01)


@pytest.mark.full
def test_tops_sleep_and_rise(printed):
    lines = printed("tops", "--seconds", 1)
    assert numbers(lines, "0.9 of")[-1] > 30 and numbers(lines, "1.05 of")[-1] < 5
    start, end = numbers(lines, "on a peg")[:2]
    assert end < 0.65 * start
    assert "gained between records 0e+00" in lines
    assert numbers(lines, "Jellett")[0] < 1e-9


@pytest.mark.full
def test_cells_grow_divide_and_come_to_rest(printed):
    lines = printed("cell_sheet", "--cells", 2)
    count, mean, scatter, wanted = numbers(lines, "elongation")
    assert count == 2 and 1.5 < mean < 2.0 == wanted and scatter < 0.3
    assert numbers(lines, "at rest")[1] == 0  # no step went up


@pytest.mark.slow
def test_a_galaxy_is_its_parts(printed):
    lines = printed("galaxy", "--stars", 50_000)
    for star, exact in zip(numbers(lines, "of the stars"), numbers(lines, "closed form {3}"), strict=True):
        assert star == pytest.approx(exact, abs=0.05)
    minor, thin, angle = numbers(lines, "within 1")[1:]
    assert thin < minor < 0.9 and angle == pytest.approx(35.0, abs=5.0)
    ours, exact = numbers(lines, "mean angular")
    assert ours == pytest.approx(exact, rel=0.02)


def test_a_convecting_star_is_taken_apart(printed):
    lines = printed("convecting_star", "--particles", 2000)
    assert max(numbers(lines, "residual flow")) < 1e-13
    assert abs(numbers(lines, "less all")[0]) < 1e-12
    assert numbers(lines, "angular velocity [0-9-]")[1:3] == pytest.approx([0.3, 1.0], abs=0.02)
