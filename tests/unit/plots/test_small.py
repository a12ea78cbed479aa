"""A picture that is asked for smaller than its own size is the same picture, smaller."""

import itertools

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from PIL import Image

from astroinertia.plots import pictures
from astroinertia.plots.small import resize
from astroinertia.plots.style import RESOLUTION, styled
from tests.unit.affine_body import affine_run
from tests.unit.affine_datasets import headline, particles
from tests.unit.plots.test_attitude import free_top
from tests.unit.plots.test_plots import assert_legible, texts

SLOW = pytest.mark.full
NAMES = ["inertia", "spin", *(pytest.param(name, marks=SLOW) for name in ("ledger", "shape", "energy", "waves"))]


@pytest.fixture(scope="module")
def series():
    found = headline(affine_run()[0])
    for name, share in (("inertia_tensor", 0.05), ("angular_velocity", 0.02)):
        found[f"{name}_error"] = share * abs(found[name])
    return found


def smallest_type(figure):
    return min(text.get_fontsize() for text in figure.findobj(Text) if text.get_text().strip())


def pixels(figure, resolution):
    with styled():
        figure.set_dpi(resolution)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].astype(float)


@pytest.mark.slow
@pytest.mark.parametrize("size", [(3.4, 4), pytest.param((6, 4), marks=SLOW), (10, 3)])
@pytest.mark.parametrize("name", NAMES)
def test_small_pictures_are_legible(series, name, size):
    figure = getattr(series.inertia, f"plot_{name}")(size=size)
    assert tuple(figure.get_size_inches()) == size
    assert_legible(figure)


@pytest.mark.slow
@pytest.mark.parametrize("size", [(3.4, 4), pytest.param((6, 4), marks=SLOW), pytest.param((10, 3), marks=SLOW)])
@pytest.mark.parametrize("name", ["density", "attitude", "profiles"])
def test_small_pictures_of_other_panels_are_legible(series, name, size):
    shown = free_top(moments=(0.1, 0.2, 0.28), spin=(0.01, 1.0, 0.01), end=200.0) if name == "attitude" else series
    options = {"snapshots": particles(affine_run()[1])} if name == "density" else {}
    figure = getattr(shown.inertia, f"plot_{name}")(size=size, **options)
    assert_legible(figure)
    assert smallest_type(figure) >= 4.5 or name == "attitude"


@pytest.mark.slow
@pytest.mark.parametrize("widths", [(1.0, 5.0), (0.8, 2.5)])
def test_texts_of_one_line_have_a_space_between_them_in_the_file(series, widths):
    """Letters have other widths by the dots of a file than by the few of a figure that nobody has asked for one."""
    parts = particles(affine_run()[1]).isel(snapshot_time=[0, 5, 9])
    spread = xr.DataArray(np.linspace(*widths, parts.sizes["particle"]), dims="particle")  # of densities, by decades
    shown = parts.assign(position=parts["position"] * spread)
    figure = series.inertia.plot_density(size=(3.4, 4.0), snapshots=shown)
    figure.set_dpi(RESOLUTION * 12.3 / 3.4)
    boxes = [box for _, box in texts(figure)]
    for one, other in itertools.combinations(boxes, 2):
        height = min(one.height, other.height)
        if min(one.y1, other.y1) - max(one.y0, other.y0) > 0.5 * height:
            assert max(one.x0, other.x0) - min(one.x1, other.x1) > 0.2 * height
    assert smallest_type(figure) >= 4.5


@pytest.mark.slow
@pytest.mark.parametrize("name", ["inertia", "shape", pytest.param("spin", marks=SLOW)])
def test_a_smaller_picture_of_more_dots_an_inch_has_the_same_pixels(series, name):
    own, small = pictures.FIGURES[name](series), pictures.FIGURES[name](series)
    resize(small, tuple(0.8 * own.get_size_inches()))
    difference = abs(pixels(own, 80) - pixels(small, 100))
    assert difference.mean() < 0.2  # of 255, from rounding; a line or a margin that kept its length makes more
    assert (difference > 128).mean() < 1e-3


@pytest.mark.slow
def test_small_type_stays_near_6_points_and_a_larger_picture_keeps_its_type(series):
    series = series.drop_vars(["inertia_tensor_error", "angular_velocity_error"])  # and so the notes beside titles
    width, height = pictures.FIGURES["inertia"](series).get_size_inches()
    for share, least in ((0.9, 0.9 * 8), (0.5, 6.0), (0.4, 5.0), (1.0, 8.0), (1.5, 8.0)):
        figure = series.inertia.plot_inertia(size=(share * width, share * height))
        assert smallest_type(figure) == pytest.approx(least)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["energy", pytest.param("ledger", marks=SLOW)])
def test_titles_wider_than_a_column_are_in_several_lines(series, name):
    figure = getattr(series.inertia, f"plot_{name}")(size=(3.4, 4.0))
    assert_legible(figure)
    assert smallest_type(figure) >= 5.5  # of 5 where no title is broken


@pytest.mark.slow
def test_type_that_has_no_room_is_smaller(series):
    own = series.inertia.plot_inertia(size=(3.4, 2.6))
    assert_legible(own)  # three panels within 2.6 inches, whose axes' names would run into each other
    assert smallest_type(own) == 4.5


@pytest.mark.slow
@pytest.mark.parametrize("size", [None, (3.4, 3.25)])
def test_a_picture_for_a_column_is_written_with_as_many_dots_as_a_full_one(series, tmp_path, size):
    series.inertia.plot_inertia(size=size, path=tmp_path / "inertia.png")
    with Image.open(tmp_path / "inertia.png") as written:
        assert abs(written.width - 9 * RESOLUTION) <= 1 and written.info["dpi"][0] >= RESOLUTION - 1
