"""Panels are measured once a layout, and stand where matplotlib's own axes would."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from astroinertia.plots import style


def drawn(kind: type[Figure]) -> Figure:
    """Curves with labels of many sizes, an image of fixed aspect, and a colour bar, laid out and drawn."""
    figure = kind(figsize=(7.0, 5.0), layout="constrained")
    (curves, picture), (below, beside) = figure.subplots(2, 2, width_ratios=[1.6, 1.0])
    curves.plot([0.0, 1.0], [1e-7, 3e5])
    curves.set(title="a title", ylabel="a long label\nof two lines", yscale="log")
    picture.imshow(np.eye(8), extent=(-1234.0, 1234.0, -1e5, 1e5), aspect=0.01)
    picture.set_xlabel("x")
    figure.colorbar(picture.images[0], ax=[picture, beside], location="bottom")
    below.plot([0.0, 1.0], [-12345.678, 98765.4], label="a curve")
    below.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    beside.plot([1.0, 2.0], [3.0, 4.0])
    figure.draw_without_rendering()
    return figure


def places(figure: Figure) -> np.ndarray:
    """Corners of all axes, in dots."""
    return np.array([axes.get_window_extent().extents for axes in figure.axes])


def test_panels_stand_where_plain_axes_do() -> None:
    ours, plain = drawn(style.Page), drawn(Figure)
    assert [type(axes) for axes in ours.axes[:4]] == [style.Panel] * 4
    np.testing.assert_allclose(places(ours), places(plain), atol=1.0)


def test_a_layout_measures_once_and_another_one_again(monkeypatch) -> None:
    counted = []
    usual = Axes.get_tightbbox
    monkeypatch.setattr(
        Axes, "get_tightbbox", lambda self, *args, **how: counted.append(self) or usual(self, *args, **how)
    )
    figure = drawn(style.Page)
    panels = figure.axes[:4]
    assert [counted.count(panel) for panel in panels] == [1, 1, 1, 1]
    before = places(figure)
    panels[0].set_ylabel("three\nlines\nnow, of which the last one is long enough to be seen\n")
    figure.draw_without_rendering()
    assert [counted.count(panel) for panel in panels] == [2, 2, 2, 2]
    assert places(figure)[0][0] > before[0][0] + 10.0  # it gives way to the label
