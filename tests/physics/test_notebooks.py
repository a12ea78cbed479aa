"""The notebooks of sims/notebooks: executed, what they claim, and whether the written ones are of their sources."""

import base64
import json
import re
import socket
from pathlib import Path

import nbformat
import pytest
from nbclient.exceptions import CellExecutionError

from sims.notebooks.execute import executed, notebook, sources, write

STRICT = "import warnings\nwarnings.simplefilter('error')"
TELL = """import json
found = {{name: globals()[name] for name in {names}}}
print(json.dumps(found, default=lambda x: dict(x) if len(x.shape) else float(x)))
"""
LARGEST = 400_000  # bytes of a written notebook, which a page of it loads at once
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
SAME = 0.03  # between machines: five hundred particles amplify what rounding begins
ROUND_OFF = 1e-5  # smaller numbers are errors, and any of them is as good as another


def claims_of(source, names):
    """Execute a source with warnings as errors: the variables named, and the notebook."""
    found = executed(source, before=STRICT, after=TELL.format(names=names))
    outputs = found.cells.pop().outputs
    return json.loads(outputs[0].text), found


def written(source):
    return nbformat.read(source.with_suffix(".ipynb"), as_version=4)


def by_name(name):
    (source,) = [each for each in sources() if each.stem == name]
    return source


def texts(cell):
    for output in cell.get("outputs", ()):
        yield output.text if output.output_type == "stream" else output.data.get("text/plain", "")


def same_text(one, other):
    """Whether two outputs say the same: words alike, numbers but for rounding that a collapse amplifies."""
    words = [re.sub(r"[-\s]+", " ", NUMBER.sub("#", text)) for text in (one, other)]
    numbers = [[float(number) for number in NUMBER.findall(text)] for text in (one, other)]
    close = (
        abs(a - b) <= SAME * max(abs(a), abs(b)) or max(abs(a), abs(b)) < ROUND_OFF
        for a, b in zip(*numbers, strict=False)
    )
    return words[0] == words[1] and all(close)


def assert_written_is(source, found):
    """The written notebook shows what its source gives today: as many pictures, and the same words and numbers."""
    for cell, now in zip(written(source).cells, found.cells, strict=True):
        pictures = [sum("image/png" in each.get("data", {}) for each in one.get("outputs", ())) for one in (cell, now)]
        assert pictures[0] == pictures[1], cell.source
        for text, today in zip(texts(cell), texts(now), strict=True):
            assert same_text(text, today), f"{text}\n{today}"


@pytest.mark.full(inputs=["sims/notebooks/collapse_experiment.py", "sims/notebooks/collapse_experiment.ipynb"])
def test_collapse_experiment():
    names = [
        *("compression", "closure", "change_of_momentum", "spin_up", "by_inertia", "by_radius", "peak_ratio"),
        *("scaled_peak", "secular", "unexplained", "energy_error", "free_fall_time", "against_gravity"),
        *("heated", "gained"),
    ]
    source = by_name("collapse_experiment")
    claimed, found = claims_of(source, names)
    assert claimed["compression"] > 10
    assert claimed["closure"] < 1e-12
    assert claimed["change_of_momentum"] < 1e-7
    assert claimed["spin_up"] == pytest.approx(claimed["by_inertia"], rel=1e-6)
    assert claimed["by_radius"] > 1.03 * claimed["spin_up"]
    assert claimed["peak_ratio"] < claimed["scaled_peak"] < claimed["secular"]
    assert claimed["peak_ratio"] > 3 * 0.01  # which is T/|W| at the start
    assert claimed["unexplained"] < 1e-12
    pushed = claimed["against_gravity"]
    assert pushed.pop("gravity") == -1
    assert sum(pushed.values()) == pytest.approx(1.0, abs=0.02)  # dI/dt is zero at both ends
    assert pushed["pressure"] > pushed["motion"] > 5 * pushed["viscosity"] > 0
    assert claimed["heated"]["gravity"] == 0
    assert sum(claimed["heated"].values()) == pytest.approx(claimed["gained"], rel=1e-6)
    assert 0.2 < claimed["heated"]["viscosity"] / claimed["gained"] < 0.6
    assert claimed["energy_error"] < 2e-3
    assert claimed["free_fall_time"] == pytest.approx(15.8e3 * 3.156e7, rel=0.01)
    assert_written_is(source, found)


@pytest.mark.full
def test_planetary_moment_ratios():
    names = ["by_hand", "prem_ratio", "identity", "spread", "radau", "from_precession", "core_density"]
    source = by_name("planetary_moment_ratios")
    claimed, found = claims_of(source, names)
    assert claimed["by_hand"]["Mars"] == pytest.approx(0.3643, abs=1e-4)
    assert claimed["by_hand"]["Earth"] == pytest.approx(0.33071, abs=1e-5)
    assert claimed["by_hand"]["Mars"] > claimed["by_hand"]["Earth"]
    assert claimed["prem_ratio"] == pytest.approx(claimed["by_hand"]["Earth"], rel=1e-3)
    assert claimed["identity"] < 1e-12
    assert claimed["spread"] < 1e-3  # over a family whose cores differ by half of their radius
    assert claimed["from_precession"] == pytest.approx(0.3306975, abs=1e-6)
    assert all(5700 < density < 7870 for density in claimed["core_density"].values())
    assert_written_is(source, found)


@pytest.mark.full(inputs=["sims/notebooks/ensemble_in_xarray.py", "sims/notebooks/ensemble_in_xarray.ipynb"])
def test_ensemble_in_xarray():
    names = ["secular", "dynamical", "largest_error", "first_order", "first_order_log"]
    source = by_name("ensemble_in_xarray")
    claimed, found = claims_of(source, names)
    assert claimed["secular"] == pytest.approx(0.137528, abs=1e-6)
    assert claimed["dynamical"] == pytest.approx(0.273821, abs=1e-5)  # Chandrasekhar 1969: e = 0.952887
    assert claimed["largest_error"] < 1e-12
    assert sum(claimed["first_order_log"].values()) == pytest.approx(1.0, abs=1e-9)
    assert 0.3 < sum(claimed["first_order"].values()) < 0.9
    log_variances = {"body_rotation_period": 8 / 3, "body_radius": (3 * 0.30103) ** 2 / 4}  # of 2 lg P and 3 lg R
    shares = claimed["first_order_log"]
    assert shares["body_radius"] / shares["body_rotation_period"] == pytest.approx(
        log_variances["body_radius"] / log_variances["body_rotation_period"], rel=1e-5
    )
    assert_written_is(source, found)


@pytest.mark.parametrize("source", sources(), ids=lambda source: source.stem)
def test_written_notebooks_are_those_of_their_sources(source):
    """After a change of a source, `make notebooks` writes them again."""
    cells = [(cell.cell_type, cell.source) for cell in written(source).cells]
    assert cells == [(cell.cell_type, cell.source) for cell in notebook(source).cells]


@pytest.mark.parametrize("source", sources(), ids=lambda source: source.stem)
def test_written_notebooks_are_small_and_hold_nothing_of_the_machine(source):
    path = source.with_suffix(".ipynb")
    assert path.stat().st_size < LARGEST
    found = written(source)
    pictures = [
        base64.b64decode(output.data["image/png"])
        for cell in found.cells
        for output in cell.get("outputs", ())
        if "image/png" in output.get("data", {})
    ]
    assert len(pictures) >= 2 and all(picture.startswith(b"\x89PNG") for picture in pictures)
    for cell in found.cells:
        for output in cell.get("outputs", ()):
            output.get("data", {}).pop("image/png", None)  # base64, in which any short name may turn up
    text = nbformat.writes(found)
    places = (str(Path.home()), str(Path(__file__).parents[2]), "/tmp", "site-packages", socket.gethostname())
    assert not [place for place in places if len(place) > 2 and place in text]
    assert set(found.metadata) == {"kernelspec", "language_info"}
    assert not [cell for cell in found.cells if cell.metadata]


def test_notebooks_that_fail_or_warn_are_not_written(tmp_path):
    source = tmp_path / "one.py"
    source.write_text("# %%\nx = 1\n\n# %%\nassert x == 2\n")
    with pytest.raises(CellExecutionError, match="assert x == 2"):
        write(source)
    source.write_text("# %%\nimport warnings\n\nwarnings.warn('seen by readers')\n")
    with pytest.raises(ValueError, match="seen by readers"):
        write(source)
    assert not source.with_suffix(".ipynb").exists()
    source.write_text("# %%\nx = 1\nx + 1\n")
    assert nbformat.read(write(source), as_version=4).cells[0].outputs[0].data["text/plain"] == "2"
