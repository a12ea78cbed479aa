"""Figures are drawn without a warning for every kind of run, keep their text apart, and show the right numbers."""

import json
import re
from io import BytesIO

import matplotlib
import numpy as np
import pytest
import xarray as xr
from IPython.core.formatters import PNGFormatter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image

from astroinertia import plots
from astroinertia.errors import AbsentError, SceneError
from astroinertia.observables.quantities import RECORDED
from astroinertia.plots import density, pictures, style, waves
from astroinertia.plots.axis_scales import angular_momentum_scale
from astroinertia.plots.in_words import tables
from astroinertia.plots.matter import matter, reach
from tests.sims import SIMS
from tests.unit.affine_body import METADATA, affine_run
from tests.unit.affine_datasets import headline, particles


@pytest.fixture(autouse=True)
def _matplotlib_is_left_as_it_was():
    before = dict(matplotlib.rcParams)
    yield
    assert dict(matplotlib.rcParams) == before


@pytest.fixture(scope="module")
def series():
    return headline(affine_run()[0])


@pytest.fixture(scope="module")
def snapshots():
    return particles(affine_run()[1])


def texts(figure):
    """All visible text with its place on the page, in pixels, after drawing."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    found = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
    # Tick labels beyond an axis's limits exist, but are not drawn.
    hidden = set()
    for panel in [each for axes in figure.axes for each in (axes, *axes.child_axes)]:
        for axis in (panel.xaxis, panel.yaxis):
            ticks = {id(label) for tick in axis._update_ticks() for label in (tick.label1, tick.label2)}
            every = [tick for kind in (axis.majorTicks, axis.minorTicks) for tick in kind]
            hidden |= {id(label) for tick in every for label in (tick.label1, tick.label2)} - ticks
    return [(text.get_text(), text.get_window_extent(renderer)) for text in found if id(text) not in hidden]


def assert_legible(figure):
    """No text leaves the page or lies on another, and no legend lies on a line."""
    page = figure.bbox
    placed = texts(figure)
    for name, box in placed:
        assert box.x0 > page.x0 - 1, f"{name!r} leaves the page on the left"
        assert box.x1 < page.x1 + 1, f"{name!r} leaves the page on the right"
        assert box.y0 > page.y0 - 1, f"{name!r} leaves the page below"
        assert box.y1 < page.y1 + 1, f"{name!r} leaves the page above"
    for number, (name, box) in enumerate(placed):
        for other, lies in placed[number + 1 :]:
            across = min(box.x1, lies.x1) - max(box.x0, lies.x0)
            upward = min(box.y1, lies.y1) - max(box.y0, lies.y0)
            assert across < 2 or upward < 2, f"{name!r} lies on {other!r}"
    for panel in figure.axes:
        legend = panel.get_legend()
        curves = [line for line in panel.lines if len(line.get_xdata()) > 2]  # not those that mark a time
        for line in curves if legend else ():
            path = line.get_path().transformed(line.get_transform()).cleaned(remove_nans=True)
            hidden = path.intersects_bbox(legend.get_window_extent(), filled=False)
            assert not hidden, f"the legend of {panel.get_title(loc='left')!r} lies on {line.get_label()!r}"


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in ("spin", "energy", "inertia", "ledger") else pytest.mark.full)
        for name in list(pictures.FIGURES)
    ],
)
def test_figures_are_legible(series, name):
    figure = pictures.FIGURES[name](series)
    assert figure.axes
    assert_legible(figure)


@pytest.mark.slow
@pytest.mark.parametrize("draw", [pytest.param(plots.density_figure, marks=pytest.mark.full), plots.projection_figure])
def test_pictures_of_the_fluid_are_legible(draw, series, snapshots):
    assert_legible(draw(series, snapshots))


def test_a_name_with_signs_of_formulae_is_a_name(series):
    figure = pictures.FIGURES["spin"](series.assign_attrs(name=r"cost$ \frac{$ <b>"))
    assert any(r"cost$ \frac{$ <b>" in text for text, _ in texts(figure))


@pytest.mark.slow
def test_write_all_writes_a_png_of_each_figure(series, snapshots, tmp_path, monkeypatch):
    def empty(dataset, _=None):
        return style.begin(dataset, "a figure", (4.0, 3.0))

    # One as it is; that all can be drawn is shown by the tests of each.
    monkeypatch.setattr(
        pictures, "FIGURES", dict.fromkeys(pictures.FIGURES, empty) | {"shape": pictures.FIGURES["shape"]}
    )
    for name in ("density_figure", "projection_figure"):
        monkeypatch.setattr(density, name, empty)
    written = plots.write_all(series.isel(time=slice(0, None, 10)), tmp_path / "pictures", snapshots=snapshots)
    # Only rigid bodies have an attitude, and only runs that were asked for them error bars.
    fluid = [name for name in pictures.FIGURES if name not in ("attitude", "error_bars")]
    assert [path.name for path in written] == [*(f"{name}.png" for name in fluid), "density.png", "projection.png"]
    for path in written:
        assert path.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_a_picture_is_laid_out_and_drawn_once(series, tmp_path, monkeypatch):
    drawn, draw = [], Figure.draw
    monkeypatch.setattr(Figure, "draw", lambda self, renderer: drawn.append(1) or draw(self, renderer))
    figure = pictures.FIGURES["waves"](series)
    with Image.open(style.save(figure, tmp_path / "waves.png")) as picture:
        assert picture.mode == "RGB"  # nothing shows through
        assert picture.size == tuple(figure.get_size_inches() * style.RESOLUTION)
    assert len(drawn) == 1


def variants():
    records = affine_run()[0]
    code = {**METADATA, "dimensionless": True}
    still = [{**record, "angular_momentum": np.zeros(3)} for record in records[:3]]
    free = [{**record, "gravitational_energy": np.nan} for record in records[::40]]
    for record in free:
        per_effect = [name for name, quantity in RECORDED.items() if "effect" in quantity.dims]
        record.update({name: np.asarray(record[name])[:0] for name in per_effect})
    return {
        "one output": (records[:1], METADATA),
        "one output, dimensionless, without spin": (still[:1], code),
        "two outputs": (records[:2], METADATA),
        "dimensionless": (records[::10], code),
        "without spin": (still, METADATA),
        "no effects": (free, {**METADATA, "effects": []}),
        "rotating frame": (records[::20], {**METADATA, "effects": ["gravity", "pressure", "rotating_frame"]}),
        "an effect of the user's": (records[::20], {**METADATA, "effects": ["gravity", "pressure", "my_wind"]}),
        "another size": (records[::20], {**METADATA, "code_units": {"mass": 1e23, "length": 1e3, "G": 6.7e-11}}),
    }


KINDS = {
    "one output, dimensionless, without spin": "slow",
    "no effects": "full", "one output": "full", "dimensionless": "full", "without spin": "full",
    "two outputs": "full", "rotating frame": "full", "an effect of the user's": "full", "another size": "full",
}  # fmt: skip


@pytest.mark.full
@pytest.mark.parametrize("name", [pytest.param(name, marks=getattr(pytest.mark, mark)) for name, mark in KINDS.items()])
def test_every_kind_of_run_can_be_drawn(name):
    records, metadata = variants()[name]
    found = headline(records, metadata)
    for draw in pictures.FIGURES.values():
        assert_legible(draw(found))
    text = plots.summary(found)
    assert "nan" not in text
    assert len(text.splitlines()) > 8


def test_a_notebook_shows_a_figure_without_pyplot(series):
    figure = pictures.FIGURES["inertia"](series)
    before = figure.dpi
    png = PNGFormatter()(figure)
    with Image.open(BytesIO(png)) as opened:
        assert opened.format == "PNG"
        np.testing.assert_allclose(opened.size, figure.get_size_inches() * style.NOTEBOOK, atol=1.0)
        assert len(np.unique(np.asarray(opened))) > 50
    assert figure.dpi == before


def test_the_summary_tells_the_accuracy_that_was_asked_for_and_why_more_is_stated(series):
    kept = {"accuracy": "0.01 of I_zz; stated 2.1e-02", "stated": "2.1e-02 is\nstated", "price": "3 s for the run"}
    lines = plots.summary(series.assign_attrs(choice=json.dumps(kept))).splitlines()
    first = lines.index("settings chosen for an accuracy of 0.01 of I_zz; stated 2.1e-02.")
    assert lines[first + 1] == "2.1e-02 is stated."
    without = plots.summary(series)
    for other in ("no JSON", "[1, 2]", '{"accuracy": 7}', "[" * 100_000):
        assert plots.summary(series.assign_attrs(choice=other)) == without


def test_the_summary_tells_the_numbers(series):
    text = plots.summary(series)
    assert text.startswith("affine star: a homogeneous ellipsoid collapses and bounces")
    rows = {line[:34].strip(): line[34:].split() for line in text.splitlines() if len(line) > 34}
    spin = series.inertia.spin_rate()
    assert [float(cell) for cell in rows["mean angular velocity (rad s-1)"]] == pytest.approx(
        [spin.values[0], spin.values.min(), spin.values.max(), spin.values[-1]], rel=1e-4
    )
    largest = float(abs(series["gravitational_energy"]).max())
    change = float(abs(series["total_energy"] - series["total_energy"][0]).max()) / largest
    assert float(rows["change of the total energy"][0]) == pytest.approx(change, rel=1e-2)
    assert "tide" in text


@pytest.mark.parametrize("columns", [60, 80])
def test_the_summary_fits_a_narrow_terminal_with_the_same_numbers(series, columns):
    for table in tables(series):
        if columns == 60 and table.title == "The ledger of effects":
            continue  # its heads alone are as wide
        wide, narrow = table.text(), table.text(columns)
        assert max(map(len, narrow.splitlines())) <= columns
        assert narrow.split() == wide.split()
        assert table.text(200) == wide
    assert plots.summary(series, 200) == plots.summary(series)


@pytest.mark.parametrize("share", [0.285, 0.26])
def test_the_names_of_limits_are_not_where_the_curve_begins(series, share):
    """Of a bar that starts just above the limit, and just below it."""
    bar = series.drop_dims("radius_bin").assign(
        rotational_to_gravitational=xr.full_like(series["rotational_to_gravitational"], share)
    )
    figure = bar.inertia.plot_spin()
    (box,) = [box for text, box in texts(figure) if text.startswith("dynamical")]
    panel = figure.axes[-1]
    height = panel.transData.transform((0.0, share))[1]
    assert not box.y0 < height < box.y1


def test_the_summary_tells_how_regions_turn(series):
    """Each by the size of its own mean angular velocity at the end, in the unit that is said below."""
    times, names = series.sizes["time"], ["core", "envelope"]
    rate = np.zeros((times, 2, 3))
    rate[-1] = [[3.0, 0.0, 4.0], [0.0, 0.0, 0.25]]
    own = {"region_mass": "kg", "region_rotational_to_gravitational": "1", "region_density_max": "kg m-3",
           "region_ledger_closure": "1"}  # fmt: skip
    regional = {name: (("time", "region"), np.ones((times, 2)), {"units": unit}) for name, unit in own.items()}
    regional["region_angular_velocity"] = (("time", "region", "i"), rate, {"units": "rad s-1"})
    text = plots.summary(series.assign(regional).assign_coords(region=names))
    lines = [line.split() for line in text.splitlines() if line.strip()]
    rows = {line[0]: line for line in lines if line[0] in names}
    assert (rows["core"][2], rows["envelope"][2]) == ("5", "0.25")
    assert "mean angular velocities in rad s-1" in text


@pytest.mark.parametrize(
    ("unit", "largest", "factor", "shown"),
    [
        ("s", 0.12, 1e-3, "ms"),
        ("s", 12.0, 1.0, "s"),
        ("s", 1800.0, 60.0, "min"),
        ("s", 21600.0, 3600.0, "h"),
        ("s", 1e5, 3600.0, "h"),
        ("s", 3e5, 86400.0, "d"),
        ("s", 3.2e13, 31557600e6, "Myr"),
        ("m", 1.5e6, 1e3, "km"),
        ("m", 0.3, 1e-2, "cm"),
        ("m", 2e11, 149597870700.0, "au"),
        ("kg m2", 3.4e38, 1e38, "10^38 kg m2"),
        ("rad s-1", 359.0, 1.0, "rad s-1"),
        ("1", 0.0024, 1e-3, "10^-3"),
        ("J", 0.0, 1.0, "J"),
        ("J", np.nan, 1.0, "J"),
    ],
)
def test_units_are_those_that_readers_think_in(unit, largest, factor, shown):
    assert style.scale_of(unit, np.array([0.0, -largest])) == (pytest.approx(factor), shown)


def test_curves_that_lie_on_each_other_are_all_seen(series):
    same = series["inertia_rate"].sel(i="x", j="x")
    figure = pictures.FIGURES["inertia"](series.assign(inertia_rate=same.drop_vars(["i", "j"]).expand_dims(i=3, j=3)
                                         .transpose("time", "i", "j").assign_coords(i=list("xyz"), j=list("xyz"))
                                         .assign_attrs(series["inertia_rate"].attrs)))  # fmt: skip
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    box = figure.axes[1].bbox
    image = np.asarray(canvas.buffer_rgba())[::-1, :, :3][int(box.y0) : int(box.y1), int(box.x0) : int(box.x1)]
    for colour in style.COMPONENTS:
        wanted = 255 * np.array(matplotlib.colors.to_rgb(colour))
        assert (abs(image - wanted).max(axis=-1) < 12).sum() > 60, colour


@pytest.mark.parametrize(("turns", "drift", "band"), [(20, 0.0, False), (900, 0.0, True), (900, 1e3, False)])
def test_a_curve_that_fills_its_panel_is_the_band_between_its_extremes(turns, drift, band):
    """One that turns often within its own width stays a line; the band has both bounds all along."""
    axes = matplotlib.figure.Figure().subplots()
    times = np.linspace(0.0, 1.0, 4000)
    style.curve(axes, times, np.sin(2 * np.pi * turns * times) + drift * times, color="red", label="wobble")
    assert (len(axes.collections), len(axes.lines)) == ((1, 0) if band else (0, 1))
    assert axes.get_legend_handles_labels()[1] == ["wobble"]
    if band:
        low, high = axes.collections[0].get_paths()[0].get_extents().get_points()
        np.testing.assert_allclose([low, high], [[0.0, -1.0], [1.0, 1.0]], atol=1e-3)


def test_panels_share_an_axis_of_time_also_where_the_last_is_empty(series):
    """Angular momentum that effects give to round-off: the panel says so in little room, and keeps its times."""
    nothing = series.assign(mixed_impulse=1e-40 * series["mixed_impulse"] + 1e-60)
    figure = pictures.FIGURES["ledger"](nothing)
    figure.canvas.draw()
    top, last = figure.axes[0], figure.axes[-1]
    assert "to round-off" in last.texts[0].get_text() and not len(last.get_yticks())
    assert len(last.get_xticks()) > 2 and last.get_xlim() == top.get_xlim()
    assert last.get_position().height < 0.4 * top.get_position().height
    assert_legible(figure)


def test_a_spin_that_changes_by_round_off_is_flat(series):
    noise = 1.0 + 1e-14 * np.sin(np.arange(series.sizes["time"]))
    steady = series.assign(
        {
            name: series[name].isel(time=[0] * len(noise)).assign_coords(time=series.time)
            for name in ("inertia_tensor", "angular_velocity", "mean_radius", "principal_moments", "spin_axis")
        }
    )
    momentum = series["angular_momentum"].isel(time=[0] * len(noise)).assign_coords(time=series.time)
    figure = pictures.FIGURES["spin"](
        steady.assign(angular_momentum=(momentum * xr.DataArray(noise, dims="time")).assign_attrs(momentum.attrs))
    )
    low, high = figure.axes[0].get_ylim()
    assert 1.01 < high / low < 1.03


@pytest.mark.parametrize(("records", "few"), [(9, True), (200, False)])
def test_waves_of_too_few_records_are_marked(records, few, series):
    phase = np.linspace(0.0, 6 * np.pi, records)
    strain = xr.DataArray(np.sin(phase), dims="time")
    assert waves.undersampled([strain, 0.1 * strain]) is few


@pytest.mark.parametrize(
    ("draw", "named"), [(plots.density_figure, "density"), (plots.projection_figure, "column density")]
)
def test_the_bar_of_densities_is_logarithmic_and_has_a_unit(draw, named, series, snapshots):
    figure = draw(series, snapshots)
    bars = [
        axes.get_xlabel() for axes in figure.axes if axes.get_label() == "<colorbar>" and axes.get_xscale() == "log"
    ]
    assert any(re.fullmatch(rf"{named} \(.*kg m⁻[²³]\)", label) for label in bars), bars


@pytest.mark.full
def test_waves_of_too_few_records_have_dots_and_words(series):
    more = series.interp(time=np.linspace(*series["time"].values[[0, -1]], 2000))
    for drawn, few in ((series, True), (more, False)):
        figure = pictures.FIGURES["waves"](drawn)
        assert ("too few records" in " ".join(text for text, _ in texts(figure))) is few
        assert (figure.axes[0].lines[0].get_marker() == "o") is few


def test_units_are_set_with_superscripts():
    assert style.raised("10^38 kg m2 s-1") == "10³⁸ kg m² s⁻¹"
    assert style.label("axis ratio", "1") == "axis ratio"
    assert style.number(2.4e-21, 2) == "2.4 × 10⁻²¹"


def test_outputs_to_draw_include_both_ends_and_the_greatest_density(series):
    chosen = style.picked_times(series, 9)
    assert chosen[0] == 0
    assert chosen[-1] == series.sizes["time"] - 1
    assert int(np.argmax(series["density_max"].values)) in chosen
    assert (np.diff(chosen) > 0).all()


def test_sinks_are_stars_where_they_are_at_the_time_of_a_picture(series, snapshots):
    """The second sink is made after the first picture; the middle of a picture is not that of the coordinates."""
    places = np.full((series.sizes["time"], 2, 3), np.nan)
    places[:, 0] = [1e9, 2e9, 3e9]
    places[series.sizes["time"] // 2 :, 1] = [-1e9, 0.0, 0.0]
    with_two = series.assign(sink_position=(("time", "sink", "i"), places))
    panels = density.projection_figure(with_two, snapshots).axes[:6]
    stars = [next(line for line in axes.lines if line.get_marker() == "*").get_xydata() for axes in panels]
    assert len(stars[0]) == 1 and len(stars[2]) == 2
    last = snapshots.isel(snapshot_time=-1)
    weight = (last["mass"] * last["density"]).values
    middle = weight @ last["position"].values / weight.sum()
    scale = style.scale_of("m", reach(matter(last, densest=True)))[0]
    np.testing.assert_allclose(stars[2], (places[-1] - middle)[:, [0, 2]] / scale, rtol=1e-12)


def test_the_summary_has_what_sinks_hold_and_what_all_keep_together(series):
    times = series.sizes["time"]
    mass = np.full((times, 3), np.nan)
    mass[-1, :2] = 2e30, 1e30
    whole = np.tile([0.0, 3.0, 4.0], (times, 1))
    whole[-1, 1] += 5e-3
    size, _ = angular_momentum_scale(series)
    with_sinks = series.assign(sink_mass=(("time", "sink"), mass, {"units": "kg"}),
                               system_angular_momentum=(("time", "i"), size * whole))  # fmt: skip
    lines = plots.summary(with_sinks).splitlines()
    assert next(line.split()[-1] for line in lines if line.startswith("mass of the sinks (10^30 kg)")) == "3"
    assert "  and of all bodies together                  9.99e-04  of its largest" in lines
    # What they exchange adds up to nothing but round-off: that is no share of itself.
    exchanged = with_sinks.assign(system_angular_momentum=(("time", "i"), 1e-16 * size * (whole - whole[0])))
    (line,) = (line for line in plots.summary(exchanged).splitlines() if "of all bodies together" in line)
    assert line.split()[5] == "5.00e-19" and "of its largest" not in line
    assert "together" not in plots.summary(series) and "sinks" not in plots.summary(series)


def test_snapshots_to_show(snapshots):
    from astroinertia.plots.density import moments_to_show

    densest = int(np.argmax(snapshots["density"].values.max(axis=1)))
    assert [index for index, _ in moments_to_show(snapshots)] == [0, densest, snapshots.sizes["snapshot_time"] - 1]
    assert moments_to_show(snapshots.isel(snapshot_time=[0])) == [(0, "start")]
    falling = moments_to_show(snapshots.isel(snapshot_time=slice(densest, None)))
    assert falling[0] == (0, "start, densest snapshot")


@pytest.mark.slow
def test_numbers_of_four_digits_below_a_small_picture_do_not_touch(series, snapshots):
    """Of a planet, 8000 km from its middle to its edge; and the speed is written out."""
    first = snapshots.isel(snapshot_time=[0])
    lengths = 8.6e6 / reach(matter(first.isel(snapshot_time=0), densest=True))
    speeds = 5.5e3 / float(abs(first["velocity"]).max())
    wide = {name: first[name] * lengths for name in ("position", "smoothing_length")}
    wide["velocity"] = first["velocity"] * speeds
    wide = first.assign({name: new.assign_attrs(first[name].attrs) for name, new in wide.items()})
    figure = series.inertia.plot_density(snapshots=wide)
    assert any("(km)" in text for text, _ in texts(figure))
    assert_legible(figure)
    assert not any("e+" in text for text, _ in texts(figure))


@pytest.mark.slow
def test_accessor_draws_the_same_figures(series, snapshots):
    for name in ("inertia", "spin", "ledger", "shape", "energy", "waves", "profiles"):
        assert getattr(series.inertia, f"plot_{name}")().axes
    assert series.inertia.plot_density(snapshots=snapshots.isel(snapshot_time=[0])).axes
    for part in (series.isel(time=[-1]), series.isel(time=slice(-2, None))):
        figure = part.inertia.plot_density(snapshots=snapshots)  # of the times of the dataset, or the nearest
        assert [title for axes in figure.axes if (title := axes.get_title(loc="left"))] == ["snapshot, 323.5 ms"]
    with pytest.raises(AbsentError, match="no snapshots"):
        series.inertia.plot_density()


def test_the_summary_of_a_problem_with_a_converged_answer_has_the_distance_to_it(series):
    scene = (SIMS / "evrard.toml").read_text(encoding="utf-8")
    longer = series.assign_coords(time=("time", 10.0 * series["time"].values))
    shown = plots.summary(longer.assign_attrs(scene=scene))
    assert "distance to the converged answer" in shown
    assert "spherical grid" in shown, "where the numbers come from"
    assert "converged answer" not in plots.summary(series)


def test_effects_of_one_run_have_colours_of_their_own():
    names = ["gravity", "damping", "external_field", "mine", "impulses", "viscosity"]  # three of which are purple
    colours = [style.effect_colour(name, names) for name in names]
    assert len(set(colours)) == len(names)
    assert colours[:2] == [style.EFFECTS["gravity"], style.EFFECTS["damping"]]


@pytest.mark.slow
def test_a_part_of_a_run_is_drawn_or_what_is_missing_is_named(series, snapshots):
    late = series.where(series.time >= float(series.time[2]))  # no values at the times before
    assert [name for name, _ in plots.figures(late)] == [name for name, _ in plots.figures(series)]
    assert plots.summary(late, 80)
    at_rest = series.isel(time=0)
    still = {name: 0.0 * at_rest[name] for name in ("momentum", "angular_momentum", "kinetic_energy", "kinetic_tensor")}
    assert plots.summary(at_rest.assign(still), 80)
    assert dict(plots.figures(series.isel(time=0)))
    for name, made in (("work", plots.figures), ("total_energy", plots.summary)):
        with pytest.raises(AbsentError, match=rf"a part is missing: .*{name}"):
            list(made(series.drop_vars(name)))
    some = snapshots.isel(particle=slice(0, 200), snapshot_time=1)
    assert plots.density_figure(series, some).axes
    with pytest.raises(AbsentError, match=r"of particles .* a part is missing: .*smoothing_length"):
        plots.projection_figure(series, snapshots.drop_vars("smoothing_length"))


def test_a_run_with_masked_times_keeps_its_spectrum_and_one_without_values_is_refused(series):
    """Dataset.where spreads a spectrum, which has no times, along those of the mask."""
    masked = series.where((series.time < series.time[3]) | (series.time > series.time[9]))
    assert "time" in masked.gw_characteristic_strain.dims
    panels = [figure.axes[-1] for figure in (masked.inertia.plot_waves(), series.inertia.plot_waves())]
    found, known = (panel.lines[0].get_xydata() for panel in panels)
    np.testing.assert_array_equal(found, known)
    for empty, lacks in ((series.isel(time=[]), "times"), (series.where(series.time < 0), "values")):
        for made in (plots.summary, lambda data: list(pictures.figures(data))):
            with pytest.raises(SceneError, match=f"nothing is recorded in this dataset: it has no {lacks}"):
                made(empty)
