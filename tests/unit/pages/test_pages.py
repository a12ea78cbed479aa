"""Pages of a run: what strangers wrote stays text, nothing is loaded, and a real browser has nothing to complain of."""

import base64
import json
from html.parser import HTMLParser

import numpy as np
import pytest
import xarray as xr

from astroinertia.pages import page
from astroinertia.pages.report import CAPTIONS, write_report
from astroinertia.pages.view import MOST_PARTICLES, write_view
from astroinertia.plots import pictures, style
from astroinertia.plots.in_words import tables
from tests.browser import Browser
from tests.unit.affine_body import affine_run
from tests.unit.affine_datasets import headline, particles

ALL_FIGURES = tuple(pictures.FIGURES)
EVIL = "</pre></script><script>document.title = 'owned'</script><img src=x onerror=\"document.title='owned'\">&amp;'"
SCENE = f"name = 'star' # {EVIL}\n[body]\n"
HOSTILE = {"name": f"star {EVIL}", "description": EVIL, "scene": SCENE, "plan": f"plan: {EVIL}", "model": EVIL,
           "overrides": json.dumps([f"description={EVIL}"]), "versions": json.dumps({EVIL: EVIL}), "seed": EVIL,
           "resolution_warnings": EVIL}  # fmt: skip


@pytest.fixture(scope="module")
def series():
    return headline(affine_run()[0][::10])


@pytest.fixture(scope="module")
def snapshots():
    return particles(affine_run()[1]).isel(snapshot_time=slice(0, None, 4))


@pytest.fixture
def few_figures(monkeypatch):
    monkeypatch.setattr(pictures, "FIGURES", {"shape": lambda dataset: style.begin(dataset, "shape", (4.0, 3.0))})


class Parts(HTMLParser):
    """Elements with their attributes, text by the element that it is in, and declarations."""

    def __init__(self, markup):
        super().__init__()
        self.elements, self.open, self.texts = [], [], {}
        self.feed(markup)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in ("meta", "link", "img", "input", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, "elements are closed in the order in which they are opened"

    def handle_data(self, data):
        self.texts.setdefault(self.open[-1] if self.open else "", []).append(data)

    def count(self, tag):
        return sum(name == tag for name, _ in self.elements)


def assert_alone(parts):
    """Nothing is loaded from elsewhere, and no attribute is a script."""
    for _, attributes in parts.elements:
        assert not [name for name in attributes if name.startswith("on")]
        for name in ("src", "href", "action", "data", "poster", "srcset"):
            assert (attributes.get(name) or "data:").startswith(("data:", "#"))
    (policy,) = [a["content"] for tag, a in parts.elements if tag == "meta" and "http-equiv" in a]
    assert policy.startswith("default-src 'none'; ")
    assert not parts.open


@pytest.mark.slow
def test_a_report_tells_all_of_the_run_and_is_one_file(series, snapshots, few_figures, tmp_path):
    path, snapshots = tmp_path / "report.html", snapshots.isel(snapshot_time=[0])
    count = write_report(series.assign_attrs(plan="effects:\n  gravity"), snapshots, path)
    parts = Parts(path.read_text())
    assert_alone(parts)
    assert count == parts.count("img") == 3  # the shape, slices and projections
    assert [a["alt"] for tag, a in parts.elements if tag == "img"] == [
        CAPTIONS[name] for name in ("shape", "density", "projection")
    ]
    assert set(CAPTIONS) == {*ALL_FIGURES, "density", "projection", "exact"}
    for _, attributes in (each for each in parts.elements if each[0] == "img"):
        assert base64.b64decode(attributes["src"].removeprefix("data:image/png;base64,"))[:4] == b"\x89PNG"
    cells = set(parts.texts["td"])
    for table in tables(series):
        assert {cell for row in table.rows for cell in row[1:]} <= cells
    assert "effects:\n  gravity" in parts.texts["pre"]
    assert series.attrs["scene"] in parts.texts["pre"]


def test_what_strangers_wrote_is_shown_and_does_nothing(series, few_figures, tmp_path):
    path = tmp_path / "report.html"
    write_report(series.assign_attrs(HOSTILE), None, path)
    parts = Parts(path.read_text())
    assert_alone(parts)
    assert not parts.count("script")
    assert parts.count("img") == 1
    assert SCENE in parts.texts["pre"]
    assert HOSTILE["plan"] in parts.texts["pre"]
    assert HOSTILE["name"] in parts.texts["h1"]
    assert EVIL in parts.texts["p"]
    assert EVIL in parts.texts["td"]


def test_attributes_that_are_not_what_they_should_be_are_shown_as_they_are(series, few_figures, tmp_path):
    odd = series.assign_attrs(overrides="{not json", versions="[1", plan=3.5)
    write_report(odd, None, tmp_path / "report.html")
    assert "3.5" in Parts((tmp_path / "report.html").read_text()).texts["pre"]


def view_of(series, snapshots, path):
    write_view(series, snapshots, path)
    parts = Parts(path.read_text())
    data, script = parts.texts["script"]
    return parts, json.loads(data), script


def test_a_view_holds_the_particles_where_they_are(series, snapshots, tmp_path):
    parts, data, _ = view_of(series, snapshots, tmp_path / "view.html")
    assert_alone(parts)
    assert len(data["frames"]) == snapshots.sizes["snapshot_time"]
    for number, frame in enumerate(data["frames"]):
        found = np.frombuffer(base64.b64decode(frame["points"]), "<i2").reshape(-1, 3) * frame["span"] / 32767
        position = snapshots["position"].isel(snapshot_time=number).transpose("particle", "i").values
        position = position - position.mean(axis=0)
        assert len(found) == len(position) <= MOST_PARTICLES
        # All are equally dense, and so in their own order.
        np.testing.assert_allclose(found, position, atol=1e-4 * frame["span"])
        colours = np.frombuffer(base64.b64decode(frame["colours"]), np.uint8)
        assert (np.diff(colours.astype(int)) >= 0).all()  # the densest are drawn last
        assert colours.max() < len(data["map"])


def test_a_view_of_very_many_particles_holds_some_of_them(series, snapshots, tmp_path):
    many = snapshots.isel(particle=np.arange(3 * MOST_PARTICLES) % snapshots.sizes["particle"])
    _, data, _ = view_of(series, many.isel(snapshot_time=[0]), tmp_path / "view.html")
    assert len(base64.b64decode(data["frames"][0]["colours"])) == MOST_PARTICLES


def test_a_view_says_nothing_of_a_power_of_ten_where_there_is_no_spin(series, tmp_path):
    share = xr.DataArray(np.linspace(0.0, 1e-6, series.sizes["time"]), dims="time")
    spun_up = series.assign({name: series[name] * share for name in ("angular_momentum", "angular_velocity")})
    _, data, _ = view_of(spun_up.assign_attrs(precision="float64"), None, tmp_path / "view.html")
    assert "mean angular velocity 0 rad s⁻¹" in data["frames"][0]["caption"]
    assert "× 10⁻" in data["frames"][-1]["caption"]


def test_a_view_shows_what_strangers_wrote_and_runs_one_script(series, tmp_path):
    evil = series.assign_attrs(HOSTILE)
    evil["time"].attrs["units"] = EVIL
    parts, data, script = view_of(evil, None, tmp_path / "view.html")
    assert_alone(parts)
    assert parts.count("script") == 2
    assert parts.count("img") == 0
    assert EVIL in data["frames"][0]["caption"]
    assert script == (page.HERE / "view.js").read_text()
    assert EVIL in "".join(parts.texts["h1"])


def test_powers_of_units_are_raised():
    assert style.raised("moment (10^41 kg m2)") == "moment (10⁴¹ kg m²)"
    assert style.raised("J2 (10^-3), J kg-1, 2 J-1") == "J2 (10⁻³), J kg⁻¹, 2 J⁻¹"
    assert (
        style.raised("mean angular velocity (rad s-1), 1/R^2, m 2, sum2")
        == "mean angular velocity (rad s⁻¹), 1/R², m 2, sum2"
    )


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with Browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


def quiet(browser, path):
    """The page asked for itself and for what it holds, and nothing went wrong."""
    assert browser.requests[0] == path.as_uri()
    assert all(url.startswith("data:") for url in browser.requests[1:])
    assert browser.complaints == []


def test_a_browser_shows_the_report_without_a_request_or_a_complaint(series, few_figures, browser, tmp_path):
    path = tmp_path / "report.html"
    write_report(series.assign_attrs(HOSTILE), None, path)
    browser.open(path)
    quiet(browser, path)
    assert browser.value("document.title").startswith("star </pre>")
    assert browser.value("[...document.images].map((image) => image.naturalWidth > 300)") == [True]
    assert browser.value("document.documentElement.scrollWidth <= window.innerWidth")
    # And were markup to get in, it would not run.
    path.write_text(path.read_text().replace("<main>", "<main><script>document.title = 'owned'</script>"))
    browser.open(path)
    assert browser.value("document.title") != "owned"
    assert any("Content Security Policy" in complaint for complaint in browser.complaints)
    browser.complaints.clear()


def test_a_browser_turns_the_body_without_a_request_or_a_complaint(series, snapshots, browser, tmp_path):
    path = tmp_path / "view.html"
    write_view(series.assign_attrs(HOSTILE), snapshots, path)
    browser.open(path)
    quiet(browser, path)

    def lit():
        """Dots that are drawn, and where their middle is."""
        browser.value("draw()")
        return browser.value(
            "(() => { const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d');"
            "copy.drawImage(canvas, 0, 0); let sum = 0, x = 0;"
            "const image = copy.getImageData(0, 0, canvas.width, canvas.height).data;"
            "for (let k = 0; k < image.length; k += 4) if (image[k + 3]) { sum++; x += (k / 4) % canvas.width; }"
            "return [sum, x / sum, canvas.width]; })()"
        )

    drawn, middle, width = lit()
    assert drawn > 2000
    assert middle == pytest.approx(width / 2, rel=0.05)
    browser.value("look(0, 0)")
    browser.drag((300, 300), (480, 300))  # 180 pixels are one radian
    assert browser.value("yaw") == pytest.approx(-1.0)
    text, long = browser.value(
        "(() => { const texts = [], ends = [], [write, to] = [pen.fillText, pen.lineTo];"
        "pen.fillText = (text) => texts.push(text); pen.lineTo = (x) => ends.push(x);"
        "drawScale(1 / (0.02 * data.lengths[0][0]), 100); [pen.fillText, pen.lineTo] = [write, to];"
        "return [texts[0], ends[0] - 20]; })()"
    )
    assert 0 < long <= 150  # pixels
    number, _, unit = text.partition(" ")
    assert float(number) * {name: size for size, name in browser.value("data.lengths")}[unit] == pytest.approx(
        long * 0.02 * browser.value("data.lengths[0][0]")
    )
    before = browser.value("byId('now').textContent")
    browser.value("show(2); draw()")
    assert browser.value("byId('now').textContent") != before
    browser.value("byId('pole').click(); draw()")
    assert browser.value("pitch") == pytest.approx(np.pi / 2)
    without = lit()[0]
    browser.value("byId('shell').click()")
    assert lit()[0] > without + 500
    browser.value("byId('play').click()")
    assert browser.value("byId('play').textContent") == "Pause"
    quiet(browser, path)
