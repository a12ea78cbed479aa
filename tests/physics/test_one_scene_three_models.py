"""One scene answered by scaling, ellipsoid and sph: the same schema, the same body, the laws that all of them keep."""

from pathlib import Path

import numpy as np
import pytest

from astroinertia import run_scene
from astroinertia.cli.main import main
from astroinertia.dataset import open as open_run
from astroinertia.observables.quantities import DERIVED, RECORDED
from astroinertia.plots import summary
from astroinertia.scene import load

SCENE = Path(__file__).parents[2] / "sims" / "one_star_three_models.toml"
SMALL = ["body.particles=500", 'time.end="40 min"']  # to the first rebound and a little beyond
# Settings that only some models have.
NUMERICS = {"kernel", "neighbours", "seed", "tolerance", "body_particles", "resolution_warnings"}
MODELS = ("scaling", "ellipsoid", "sph")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("runs")


@pytest.fixture(scope="module")
def runs(folder):
    text = SCENE.read_text()
    return {
        model: open_run(run_scene(load.loads(text, [*SMALL, f'model="{model}"']), folder / model)) for model in MODELS
    }


def test_the_schemas_agree(runs):
    """Names, dimensions, kinds, units and meanings; what a model lacks is NaN throughout, and says why."""
    first = runs["sph"]
    for model, found in runs.items():
        assert set(found.data_vars) == set(first.data_vars) >= {*RECORDED, *DERIVED}, model
        assert set(found.coords) == set(first.coords)
        assert set(found.attrs) ^ set(first.attrs) <= NUMERICS, model
        assert set(found["effect"].values) - {"rigidity"} == {"gravity", "pressure", "viscosity"}
        for name, variable in found.data_vars.items():
            other = first[name]
            assert variable.dims == other.dims, (model, name)
            assert variable.dtype == other.dtype, (model, name)
            for attribute in ("units", "long_name", "comment"):
                assert variable.attrs.get(attribute) == other.attrs.get(attribute), (model, name)
            absent = bool(variable.size) and variable.dtype.kind == "f" and bool(variable.isnull().all())
            assert absent == ("reason" in variable.attrs), (model, name)
            assert not absent or len(str(variable.attrs["reason"])) > 10


def test_all_start_from_the_same_star_and_keep_its_angular_momentum(runs):
    exact = runs["ellipsoid"]
    for model, found in runs.items():
        assert float(found["mass"][0]) == pytest.approx(float(exact["mass"][0]), rel=1e-12)
        moment = found.inertia.about_axis("spin").values
        assert moment[0] == pytest.approx(exact.inertia.about_axis("spin").values[0], rel=0.03), model
        momentum = found["angular_momentum"].transpose("time", "i").values
        np.testing.assert_allclose(momentum, momentum[0] + np.zeros_like(momentum), atol=1e-12 * abs(momentum).max())
        spin = found.inertia.spin_rate().values
        np.testing.assert_allclose(spin * moment, spin[0] * moment[0], rtol=2e-3, err_msg=model)


def test_the_first_rebound_is_the_same_to_a_few_percent(runs):
    least = {model: found.inertia.about_axis("spin") for model, found in runs.items()}
    depth = {model: float(series.min() / series[0]) for model, series in least.items()}
    assert 0.28 < depth["scaling"] < depth["ellipsoid"] < 0.32
    assert depth["sph"] == pytest.approx(depth["ellipsoid"], rel=0.1)
    assert float(abs(runs["scaling"]["ellipsoid_flattening"]).max()) < 1e-12
    assert 0.02 < float(runs["ellipsoid"]["ellipsoid_flattening"].max()) < 0.04


def test_the_command_lays_them_over_each_other(runs, folder, tmp_path, capsys):
    picture = tmp_path / "three.png"
    assert main(["compare", *(str(folder / model) for model in MODELS), "--plot", str(picture)]) == 0
    printed = capsys.readouterr().out
    shown = summary(runs["sph"])
    for name in ("mean angular velocity", "flattening, equivalent ellipsoid", "maximum density"):
        assert name in printed and name in shown
    assert "moment of inertia about the spin axis" in printed
    assert "differences are from 'sph, 500 particles'" in printed
    assert picture.stat().st_size > 50_000
