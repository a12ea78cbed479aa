"""Figures of models without particles: a rigid body's attitude, and datasets that lack what a fluid has."""

import numpy as np
import pytest

from astroinertia import plots
from astroinertia.plots import pictures
from astroinertia.plots.attitude import attitude_figure, has_attitude, motion, nutation_and_precession
from tests.unit.affine_body import METADATA, affine_run
from tests.unit.affine_datasets import headline
from tests.unit.plots.test_plots import assert_legible
from tests.unit.rigid_body import RIGID, rigid_run

TOP = {"moments": (0.2, 0.2, 0.35), "spin": (0.3, 0.0, 1.0), "end": 12.0, "outputs": 240}
LEAST = {"time", "step", "mass", "inertia_tensor", "second_moment", "angular_momentum", "kinetic_energy",
         "total_energy", "wall_time"}  # fmt: skip


def free_top(**how):
    return headline(rigid_run(**how), {**RIGID, "dimensionless": True})


def empty(panel):
    """A panel without anything drawn in it but the axes' own lines."""
    lines = [line for line in panel.lines if len(np.atleast_1d(line.get_xdata())) > 2]
    drawn = [line for line in lines if np.isfinite(np.asarray(line.get_ydata(), dtype=float)).any()]
    return not (drawn or panel.collections or panel.images or panel.texts)


def test_rates_are_those_about_the_bodys_own_axes():
    """Symmetric top: omega_3 stays, omega_1 = 0.3 cos(n t), omega_2 = 0.3 sin(n t), n = (C - A)/A omega_3 = 0.75."""
    series = free_top(**TOP)
    found, time = motion(series), series["time"].values
    np.testing.assert_allclose(found.moments, [0.2, 0.2, 0.35], rtol=1e-12)
    expected = np.stack([0.3 * np.cos(0.75 * time), 0.3 * np.sin(0.75 * time), np.ones_like(time)], axis=-1)
    np.testing.assert_allclose(found.rates, expected, atol=1e-8)


def test_nutation_and_precession_are_those_of_the_free_top():
    """tan(nutation) = A omega_1/(C omega_3); precession about L at the rate L/A."""
    series = free_top(**TOP)
    nutation, precession, figure, name = nutation_and_precession(series)
    momentum = np.hypot(0.2 * 0.3, 0.35)
    assert figure == 2 and name == "the angular momentum"
    np.testing.assert_allclose(nutation, np.arctan2(0.2 * 0.3, 0.35), atol=1e-8)
    np.testing.assert_allclose(precession - precession[0], momentum / 0.2 * series["time"].values, atol=1e-7)


@pytest.mark.slow
def test_without_an_attitude_the_axes_of_the_inertia_tensor_do():
    records = rigid_run()
    with_it = motion(headline(records, RIGID))
    without = motion(headline([{k: v for k, v in each.items() if k != "attitude"} for each in records], RIGID))
    np.testing.assert_allclose(without.moments, with_it.moments, rtol=1e-12)
    signs = np.sign(without.rates[0] * with_it.rates[0])
    np.testing.assert_allclose(without.rates, signs * with_it.rates, rtol=1e-6, atol=1e-6 * abs(with_it.rates).max())


def test_the_path_lies_on_one_polhode():
    found = motion(free_top())
    energy = np.einsum("tk,k,tk->t", found.rates, found.moments, found.rates)
    momentum = ((found.moments * found.rates) ** 2).sum(-1)
    np.testing.assert_allclose(momentum / energy, momentum[0] / energy[0], rtol=1e-8)


CASES = {
    "racket": {},
    "symmetric": TOP,
    "sphere": {"moments": (0.3, 0.3, 0.3), "outputs": 60},
    "steady": {"spin": (0.0, 0.0, 1.0), "outputs": 60},
    "wobble": {"moments": (0.2, 0.2, 0.35), "spin": (3e-7, 0.0, 1.0), "end": 12.0, "outputs": 60},
    "sparse": {"end": 200.0, "outputs": 40},
    "one output": {"outputs": 1, "end": 1e-9},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n == "racket" else pytest.mark.full) for n in CASES])
def test_every_kind_of_attitude_can_be_drawn(name):
    series = free_top(**CASES[name])
    assert has_attitude(series)
    assert_legible(attitude_figure(series))


@pytest.mark.slow
def test_a_slight_wobble_is_drawn_by_itself():
    """omega_1/omega_3 = 3e-7 cos(0.75 t) is 62 mas, which nobody sees beside omega_3."""
    series = free_top(**CASES["wobble"])
    figure = attitude_figure(series)
    panel, angle = figure.axes[0], next(axes for axes in figure.axes if axes.get_ylabel() == "nutation (mas)")
    nutation = nutation_and_precession(series)[0][0]  # the axis from L, steady: C/A times as little or as much
    assert nutation > 1e-8 and angle.lines[0].get_ydata()[0] == pytest.approx(np.degrees(nutation) * 3.6e6)
    assert "mas" in panel.get_ylabel()
    drawn = next(line for line in panel.lines if line.get_label().startswith("axis 1"))
    expected = np.degrees(3e-7) * 3.6e6 * np.cos(0.75 * series["time"].values)
    np.testing.assert_allclose(drawn.get_ydata(), expected, atol=1e-3)


def test_a_picture_is_the_same_in_whatever_order_components_stand():
    series = free_top(end=3.0, outputs=40)
    figures = [attitude_figure(given) for given in (series, series.isel(i=[2, 0, 1], j=[1, 2, 0]))]
    lines = [[line for axes in figure.axes for line in axes.lines] for figure in figures]
    for one, other in zip(*lines, strict=True):
        np.testing.assert_allclose(np.asarray(one.get_ydata()), np.asarray(other.get_ydata()), atol=1e-12)


def test_round_off_is_not_drawn_as_a_wobble():
    panel = attitude_figure(free_top(**CASES["wobble"] | {"spin": (3e-16, 0.0, 1.0)})).axes[0]
    assert "Wobble" not in panel.get_title(loc="left") + panel.get_title()
    assert max(abs(line.get_ydata()).max() for line in panel.lines if line.get_label().startswith("axis 3")) > 0.9


def test_only_rigid_bodies_that_turn_have_an_attitude():
    assert not has_attitude(headline(affine_run()[0][:3]))
    still = [{**each, "angular_momentum": np.zeros(3)} for each in rigid_run()[:3]]
    assert not has_attitude(headline(still, RIGID))


def variants():
    records = rigid_run()[::10]
    bare = [{name: each[name] for name in LEAST} for each in records]
    return {
        "rigid": (records, RIGID, ["inertia", "spin", "attitude", "ledger", "shape", "energy", "waves"]),
        "scaling": (bare, {**RIGID, "model": "scaling", "effects": []}, ["inertia", "spin", "shape", "energy"]),
        "skipped": (
            affine_run()[0][::20], {**METADATA, "skipped_effects": {"viscosity": "numerical"}},
            ["inertia", "spin", "ledger", "shape", "energy", "profiles", "waves"],
        ),
    }  # fmt: skip


@pytest.mark.parametrize(
    "name", ["scaling", *(pytest.param(name, marks=pytest.mark.full) for name in ("rigid", "skipped"))]
)
def test_what_a_model_lacks_is_left_out_and_no_panel_is_empty(name, tmp_path, monkeypatch):
    records, metadata, expected = variants()[name]
    series = headline(records, metadata)
    figures = {}  # as they would be saved: to lay them out takes long
    monkeypatch.setattr(pictures, "save", lambda figure, path: figures.setdefault(path.stem, figure) and path)
    assert [path.stem for path in plots.write_all(series, tmp_path)] == expected
    for figure, drawn in figures.items():
        if figure not in ("inertia", "spin", "attitude", "shape"):  # elsewhere the same
            assert_legible(drawn)
        assert not any(empty(panel) for panel in drawn.axes), figure
    summary = plots.summary(series)
    assert "nan" not in summary
    assert ("ledger closure" in summary) == (name != "scaling")
    assert "viscosity" not in summary
    assert ("; dL: " in summary) == ("largest dL" in summary)  # what a heading means stands below it, and nothing else


@pytest.mark.slow
@pytest.mark.parametrize("name", ["inertia", "spin", "shape", "attitude"])
def test_legends_lie_beside_curves_that_fill_their_panels(name):
    assert_legible(pictures.FIGURES[name](free_top(moments=(0.1, 0.2, 0.28), spin=(0.01, 1.0, 0.01), end=200.0)))
