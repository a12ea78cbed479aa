"""Runs are recognised by the physics of their scenes, and held against converged answers as far as they went."""

import numpy as np
import pytest
import xarray as xr

from astroinertia.dataset import converged
from astroinertia.scene import load
from tests.sims import SIMS

SHIPPED = [answer.name for answer in converged.references()]
NUMERICAL = (
    "body.particles=777", "body.seed=5", "body.placement=random", "body.relax=false", "numerics.neighbours=90",
    "numerics.kernel=wendland_c4", "numerics.courant=0.2", "numerics.precision=float64", "effects.gravity.order=fourth",
    "effects.viscosity.alpha_max=0.8", "output.checkpoint_seconds=5", "time.max_steps=1000",
)  # fmt: skip


def scene(name, *settings):
    text = (SIMS / f"{name}.toml").read_text(encoding="utf-8")
    quoted = [
        line if line[-1].isdigit() or line.endswith("false") else line.replace("=", '="') + '"' for line in settings
    ]
    return load.loads(text.replace("eta = 1.1", "neighbours = 45"), quoted)


def dataset(name, series, *settings):
    """A run of a shipped scene with these series along `time`; its moments are those of a sphere."""
    count = len(series["time"])
    moment = series.get("moment", np.linspace(1.0, 0.5, count))[:, None, None] * np.eye(3)
    variables = {key: ("time", values) for key, values in series.items() if key != "moment"}
    variables["inertia_tensor"] = (("time", "i", "j"), moment)
    return xr.Dataset(variables, attrs={"scene": scene(name, *settings).to_toml()})


def evrard(end=2.0, count=101, *settings):
    """Energies that peak between records, as parabolas do: kinetic 0.46 at t = 0.871."""
    time = np.linspace(0.0, end, count)
    series = {
        "time": time,
        "kinetic_energy": 0.46 - (time - 0.871) ** 2,
        "internal_energy": 1.7 - (time - 1.1) ** 2,
        "gravitational_energy": -2.5 + (time - 1.0) ** 2,
        "moment": 0.04 + (time - 1.1) ** 2,
    }
    return dataset("evrard", series, *settings)


def rows(data):
    return {row.name if row.name[0] != " " else "time": row for row in reversed(converged.distances(data))}


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_scene_has_its_converged_answer(name):
    assert converged.reference(dataset(name, {"time": np.zeros(3)})).name == name


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize("setting", NUMERICAL)
def test_numerical_choices_leave_the_answer_as_it_is(name, setting):
    assert converged.reference(dataset(name, {"time": np.zeros(3)}, setting)).name == name


def test_of_the_shipped_answers_only_those_of_bodies_alike_are_read_and_once(monkeypatch):
    run, read = dataset("evrard", {"time": np.zeros(3)}, "body.seed=77"), []
    loads = load.loads
    monkeypatch.setattr(load, "loads", lambda text: read.append(text) or loads(text))
    assert converged.reference(run).name == "evrard"
    assert converged.distances(run) == []
    assert len(read) == 2  # the run's own, and that of the answer


def test_another_end_leaves_the_answer_as_it_is():
    assert converged.reference(dataset("evrard", {"time": np.zeros(3)}, "time.end=2.5")).name == "evrard"


@pytest.mark.parametrize(
    ("name", "setting"),
    [
        ("evrard", "body.mass=1.01"),
        ("evrard", "body.specific_internal_energy=0.06"),
        ("evrard", "body.exponent=1.2"),
        ("evrard", "equation_of_state.gamma=1.4"),
        ("evrard", "body.rotation.rate=0.5"),
        ("pulsar_collapse", "body.mass=1.41 Msun"),
        ("pulsar_collapse", "body.pressure_fraction=0.85"),
        ("pulsar_collapse", "body.rotation.t_over_w=0.003"),
        ("pulsar_collapse", "equation_of_state.gamma_2=2.6"),
        ("core_collapse", "body.mass=3.0e30 kg"),
        ("core_collapse", "body.axis_ratio=0.7"),
        ("core_collapse", "equation_of_state.gamma_2=2.6"),
    ],
)
def test_other_physics_has_no_answer(name, setting):
    law = ("body.rotation.law=rigid",) if "rotation" in setting else ()
    assert converged.reference(dataset(name, {"time": np.zeros(3)}, *law, setting)) is None


def test_a_bounce_is_that_of_the_densest_record():
    """I falls from 5e41 as a parabola to 1.36e41 at 86 ms; one record, at 82 ms, is the densest."""
    time = np.linspace(0.0, 92.0, 93) * 1e-3
    density = np.where(time < 82e-3, 1e13, 3e17) + 1e17 * (np.abs(time - 82e-3) < 1e-6)
    moment = 1.36e41 + 3.64e41 * (1.0 - time / 86e-3) ** 2
    result = rows(dataset("pulsar_collapse", {"time": time, "density_max": density, "moment": moment}))
    assert result["time of bounce"].run == pytest.approx(82e-3, rel=1e-12)
    assert result["density at bounce"].run == pytest.approx(4e17, rel=1e-12)
    assert result["I_zz at bounce"].run == pytest.approx(1.36e41 + 3.64e41 * (4 / 86) ** 2, rel=1e-12)
    assert result["fall of I_zz, start over minimum"].run == pytest.approx(5.0 / 1.36, rel=1e-12)
    assert result["fall of I_zz, start over minimum"].unit == "1"


def test_an_effect_more_is_other_physics_and_a_numerical_device_is_not():
    time = {"time": np.zeros(3)}
    assert converged.reference(dataset("evrard", time, "effects.shear_viscosity.kinematic_viscosity=0.1")) is None
    assert converged.reference(dataset("evrard", time, "effects.conduction.coefficient=1.0")).name == "evrard"


def test_a_result_without_a_readable_scene_has_no_answer():
    bare = xr.Dataset({"time": ("time", np.zeros(3))})
    assert converged.reference(bare) is None
    assert converged.reference(bare.assign_attrs(scene='kind = "power_law" but no scene')) is None
    assert converged.reference(bare.assign_attrs(scene=5)) is None


def test_extremes_between_records_are_those_of_the_parabola():
    result = rows(evrard(count=34))
    assert result["maximum kinetic energy"].run == pytest.approx(0.46, rel=1e-12)
    assert result["maximum kinetic energy"].distance == pytest.approx(0.46 / 0.4520 - 1.0, rel=1e-12)
    assert result["time"].run == pytest.approx(0.871, rel=1e-12)
    assert result["minimum gravitational energy"].run == pytest.approx(-2.5, rel=1e-12)
    assert result["minimum gravitational energy"].distance < 0.0, "a well that is too shallow is nearer to zero"
    assert result["mean moment of inertia at t = 1.5"].run == pytest.approx(0.04 + 0.16, rel=1e-12)


def test_what_a_run_has_not_come_to_is_left_out():
    """It ends at t = 1.04: before its internal energy is largest, before t = 1.5, and with its minimum moment ahead."""
    names = set(rows(evrard(1.04)))
    assert {"maximum kinetic energy", "mean moment of inertia at t = 1"} <= names
    assert not any("internal" in name or "1.5" in name or "least mean" in name for name in names)
    rising = evrard().assign(kinetic_energy=("time", np.linspace(0.0, 1.0, 101)))
    assert "maximum kinetic energy" not in rows(rising), "an extreme in the last record may not be one"


def test_a_quantity_that_the_model_does_not_have_is_left_out():
    names = rows(evrard().assign(kinetic_energy=("time", np.full(101, np.nan))))
    assert "maximum kinetic energy" not in names
    assert "maximum internal energy" in names
