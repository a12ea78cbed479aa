"""The curves on the inertia ellipsoid are the paths of free rotation, and the figures are legible for every body."""

import numpy as np
import pytest

from astroinertia.inertia.body import Body
from astroinertia.plots.balance import balance_figure
from astroinertia.plots.ellipsoid import ellipsoid_figure, polhode
from astroinertia.studies.moments import Matter, moments
from tests.unit.plots.test_plots import assert_legible

MOMENTS = np.array([1.0, 1.7, 2.4])


@pytest.mark.parametrize("around", [0, 2])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.999])
def test_polhodes_keep_energy_and_angular_momentum(around, share):
    curve = polhode(MOMENTS, share, around)
    energy, momentum = (MOMENTS * curve**2).sum(-1), ((MOMENTS * curve) ** 2).sum(-1)
    np.testing.assert_allclose(energy, 1.0, rtol=1e-13)
    middle = MOMENTS[1]
    np.testing.assert_allclose(momentum, MOMENTS[around] + share**2 * (middle - MOMENTS[around]), rtol=1e-13)


@pytest.mark.parametrize("around", [0, 2])
def test_polhodes_run_where_eulers_equations_go(around):
    curve = polhode(MOMENTS, 0.6, around, points=4001)
    flow = np.cross(MOMENTS * curve, curve) / MOMENTS  # d omega / dt = I^-1 (I omega x omega)
    step = np.gradient(curve, axis=1, edge_order=2)
    cosine = (flow * step).sum(-1) / np.linalg.norm(flow, axis=-1) / np.linalg.norm(step, axis=-1)
    np.testing.assert_allclose(abs(cosine), 1.0, rtol=1e-6)


def test_the_separatrix_passes_through_the_intermediate_axis():
    curve = polhode(MOMENTS, 1.0, 2)
    np.testing.assert_allclose(abs(curve[:, 60]), [[0, MOMENTS[1] ** -0.5, 0]] * 2, atol=1e-7)


def matter_of(semi_axes, mass=2.0, turn=0.7):
    cosine, sine = np.cos(turn), np.sin(turn)
    matrix = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]]) @ np.array(
        [[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]]
    )
    squares = np.square(semi_axes) * mass / 5
    inertia = matrix @ np.diag(squares.sum() - squares) @ matrix.T
    points = np.random.default_rng(8).normal(size=(300, 3)) * np.asarray(semi_axes) @ matrix.T
    return Matter(
        Body(np.float64(mass), np.array([1e4, 0, 0]), inertia),
        points + [1e4, 0, 0],
        1.0,
        "stated",
        ("kg", "m"),
        1e-7,
        "x",
    )


BODIES = {
    "triaxial": (3.0, 2.0, 1.2),
    "oblate": (2.0, 2.0, 1.0),
    "prolate": (1.0, 1.0, 3.0),
    "sphere": (1.0, 1.0, 1.0),
    "rod": (1.0, 1e-9, 1e-9),
    "plate": (2.0, 1.0, 0.0),
    "line": (1.0, 0.0, 0.0),
    "large": (3e9, 2e9, 1e9),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=() if name in ("triaxial", "rod", "plate") else pytest.mark.full) for name in BODIES],
)
def test_every_body_can_be_drawn(name):
    matter = matter_of(BODIES[name])
    figure = ellipsoid_figure(moments(matter), matter.points, name)
    assert_legible(figure)
    texts = " ".join(text.get_text() for text in figure.findobj(lambda each: hasattr(each, "get_text")))
    assert ("undefined" in texts) == (name in ("oblate", "prolate", "sphere", "rod", "line"))


def rotor(products, centre):
    inertia = np.diag([3.0, 3.1, 5.0])
    inertia[0, 2] = inertia[2, 0] = products[0]
    inertia[1, 2] = inertia[2, 1] = products[1]
    return Body(np.float64(20.0), np.asarray(centre, float), inertia)


@pytest.mark.full
@pytest.mark.parametrize("after", [rotor((1e-17, 0), (0, 0, 0.1)), rotor((0.02, 0.01), (1e-4, 0, 0))])
def test_balancing_is_drawn_with_its_two_vectors(after):
    before = rotor((0.04, -0.022), (0.002, 0.0015, 0.01))
    figure = balance_figure(before, after, name="wheel")
    assert_legible(figure)
    static, dynamic, moved = figure.axes
    # arrows run from the axis to M c and to -(I_xz, I_yz) about the origin, which the offset changes by M c_x c_z
    assert static.texts[0].xy == pytest.approx((0.04, 0.03))
    assert dynamic.texts[0].xy == pytest.approx((-0.04 + 20 * 0.002 * 0.01, 0.022 + 20 * 0.0015 * 0.01))
    for panel, vector in ((static, after.mass * after.centre[:2]), (dynamic, -after.about(np.zeros(3))[:2, 2])):
        dots = [line.get_xydata()[0] for line in panel.lines if len(line.get_xdata()) == 1]
        ends = [np.asarray(text.xy) for text in panel.texts] + dots
        np.testing.assert_allclose(ends[1], vector, rtol=1e-6, atol=1e-12)
    assert all(line.get_xdata().min() >= 1e-17 for line in moved.lines if len(line.get_xdata()) == 5)
