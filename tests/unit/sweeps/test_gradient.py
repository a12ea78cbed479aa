"""Gradients against differences of whole runs, against what conservation says, and what is refused."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest

import astroinertia
from astroinertia.build.assemble import prepare
from astroinertia.effects import Effect, positive, pytree
from astroinertia.errors import SceneError
from astroinertia.sweeps import gradient as gradients
from astroinertia.sweeps.ensemble import run_sweep
from astroinertia.sweeps.gradient import members
from astroinertia.sweeps.sensitivity import sensitivity, sensitivity_sweep
from tests.plugin_example import EXAMPLE, distribution
from tests.sims import SIMS

CORE = astroinertia.load(SIMS / "core_to_pulsar_scaling.toml", ["output.series_every=10 ms"])
TOP = {
    "name": "top",
    "model": "rigid",
    "body": {
        "kind": "rigid",
        "mass": "2 kg",
        "radius": "0.1 m",
        "moment_ratios": [0.25, 0.26, 0.5],
        "rotation": {"period": "0.1 s", "wobble": "20 deg"},
    },
    "effects": {"constant_torque": {"vector": ["0.5 N m", "0 N m", "0.1 N m"], "frame": "body"}},
    "time": "0.2 s",
    "output": {"series_every": "0.2 s", "snapshot_every": "0.2 s"},
}
ASTEROID = {
    "name": "asteroid",
    "model": "rigid",
    "body": {
        "kind": "rigid",
        "mass": "1e13 kg",
        "radius": "1 km",
        "moment_ratios": [0.3, 0.4, 0.5],
        "rotation": {"period": "5 h", "wobble": "30 deg"},
    },
    "effects": {"internal_dissipation": {"time_scale": "3 d"}},
    "time": "1 d",
    "output": {"series_every": "1 d", "snapshot_every": "1 d"},
}
STAR = {
    "name": "star",
    "model": "ellipsoid",
    "units": "code",
    "body": {
        "kind": "polytrope",
        "index": 1.5,
        "mass": 1.0,
        "radius": 1.0,
        "axes": [1.0, 0.9, 0.8],
        "pressure_fraction": 0.8,
        "rotation": {"period": 12.0},
    },
    "equation_of_state": {"kind": "ideal", "gamma": 1.6},
    "effects": ["gravity", "pressure"],
    "time": 3.0,
    "output": {"series_every": 3.0, "snapshot_every": 3.0},
}
MOON = {
    **ASTEROID,
    "companions": [{"name": "moon", "mass": "3e12 kg", "semi_major_axis": "4 km", "eccentricity": 0.2}],
    "effects": ["gravity_gradient"],
    "orbits": {"back_reaction": True},
}
CLOUD = {
    "name": "cloud",
    "model": "sph",
    "units": "code",
    "body": {
        "kind": "uniform",
        "mass": 1.0,
        "radius": 1.0,
        "particles": 200,
        "placement": "glass",
        "relax": False,
        "specific_internal_energy": 0.3,
        "rotation": {"period": 8.0},
    },
    "equation_of_state": {"kind": "ideal"},
    "effects": {"gravity": {}, "pressure": {}, "viscosity": {"alpha_max": 0.8, "switch": "none", "limiter": "none"}},
    "numerics": {"engine": "xla", "free_fall_factor": 0.05},
    "time": 0.6,
    "output": {"series_every": 0.4, "snapshot_every": 0.5},
}
COLD = {
    **CLOUD,
    "name": "cold",
    "body": {**CLOUD["body"], "particles": 60},
    "effects": ["gravity"],
    "numerics": {"engine": "xla", "max_timestep": 0.1},
    "time": 0.3,
}
SETTLING = {**COLD, "effects": {"gravity": {}, "damping": {"time_scale": 0.3, "until": 0.17}}}
GAS = {
    **STAR,
    "name": "gas",
    "model": "sph",
    "body": {**STAR["body"], "particles": 200, "relax": False},
    "numerics": {"engine": "xla"},
    "time": 1.0,
    "output": {"series_every": 1.0, "snapshot_every": 1.0},
}
CASES = {
    "top": (TOP, ("body.rotation.period", "body.mass", "body.radius", "body.rotation.wobble")),
    "asteroid": (ASTEROID, ("body.rotation.period", "effects.internal_dissipation.time_scale")),
    "moon": (MOON, ("body.rotation.period", "body.mass", "companions.0.mass")),
    "star": (STAR, ("body.rotation.period", "equation_of_state.gamma", "body.mass", "body.pressure_fraction")),
    "gas of the star": (STAR, ("equation_of_state.gamma",)),
    "core": (CORE, ("body.rotation.period", "body.radius")),
    "gas": (GAS, ("body.rotation.period", "equation_of_state.gamma", "body.mass", "body.pressure_fraction")),
    "cloud": (CLOUD, ("body.rotation.period", "effects.viscosity.alpha_max", "body.specific_internal_energy")),
    "settling": (SETTLING, ("body.rotation.period", "effects.damping.time_scale")),
}
MIXED = {**GAS, "numerics": {"engine": "xla", "precision": "mixed"}}
SO_MANY_STEPS = {**GAS, "time": {"end": 1.0, "max_steps": 7}}
IN_REGIONS = {**GAS, "regions": {"core": {"innermost_mass": 0.5}}}
SERIES = ("inertia_tensor", "angular_velocity", "angular_momentum", "rotational_energy")


def scene(tables):
    return astroinertia.Scene(**tables) if isinstance(tables, dict) else tables


FULL = [pytest.param(name, marks=pytest.mark.full) for name in CASES if name != "core"]


@pytest.mark.slow
@pytest.mark.parametrize("name", [*FULL, "core"])
def test_gradients_are_those_of_differences_of_runs(name, tmp_path):
    """Twenty-four keys of nine scenes, at the end: to 1e-4 of the largest derivative or of the series itself."""
    tables, by = CASES[name]
    run = members(scene(tables), by)
    ours = sensitivity(run)
    theirs = sensitivity(astroinertia.open(run_sweep(sensitivity_sweep(tables, by, 0.003), tmp_path).file).load())
    assert ours.parameter.values.tolist() == list(by)
    for series in (*SERIES, *(("companion_position",) if name == "moon" else ())):
        answers, expected = (data[series].isel(time=-1).values for data in (ours, theirs))
        size = abs(run[series].isel(member=0, time=-1).values).max()
        for answer, right in zip(answers, expected, strict=True):
            assert abs(answer - right).max() < 1e-4 * max(abs(right).max(), size)
    assert max(abs(ours[series]).max() for series in SERIES) > 0.0


@pytest.mark.full
def test_gradients_of_particles_add_up_as_dimensions_ask():
    """Where M grows with R^3, times stay and lengths are R: three times d/d ln M and d/d ln R of I add up to 5 I."""
    run = members(scene(COLD), ("body.mass", "body.radius"))
    by_mass, by_radius = (sensitivity(run).isel(parameter=key, time=-1) for key in (0, 1))
    inertia, spin = (run[name].isel(member=0, time=-1).values for name in ("inertia_tensor", "angular_velocity"))
    np.testing.assert_allclose(
        3 * by_mass.inertia_tensor + by_radius.inertia_tensor, 5 * inertia, atol=1e-9 * inertia.max()
    )
    np.testing.assert_allclose(3 * by_mass.angular_velocity + by_radius.angular_velocity, 0.0, atol=1e-9 * spin.max())
    assert abs(by_mass.inertia_tensor / inertia - 1.0).values[2, 2] > 0.01  # gravity draws it together


@pytest.mark.slow
def test_a_gradient_is_in_the_units_of_the_scene_and_at_the_time_that_is_named():
    answer = astroinertia.gradient(CORE, of="angular_velocity.z@end", by=["body.rotation.period", "body.radius"])
    assert answer.parameter_value.values.tolist() == [30.0, 1500.0]
    assert answer.parameter_unit.values.tolist() == ["s", "km"]
    spin = float(answer.value)
    np.testing.assert_allclose(answer.gradient, [-spin / 30.0, 0.0], atol=1e-9 * spin)
    assert answer.gradient.attrs["units"] == "rad s-1 per parameter_unit"
    assert answer.gradient.attrs["long_name"] == "derivative of mean angular velocity by the parameter"
    assert (abs(answer.gradient - [-spin / 30.0, 0.0]) <= answer.gradient_error + 1e-12 * spin).all()
    early = astroinertia.gradient(CORE, of="inertia_tensor.zz @ 100 ms", by=["body.radius"])
    assert float(early.time) == pytest.approx(0.1)
    assert float(early.gradient[0]) == pytest.approx(2.0 * float(early.value) / 1500.0)


@pytest.mark.full
def test_members_of_which_some_have_waves_too_faint_for_a_spectrum_have_a_gradient():
    scene = astroinertia.load(SIMS / "core_to_pulsar_scaling.toml", ["output.series_every=0.1 s"])
    assert "frequency" not in members(scene, ["body.radius"]).sizes
    answer = astroinertia.gradient(scene, of="inertia_tensor.zz", by=["body.radius"])
    assert answer.gradient.values[0] * 1500 == pytest.approx(2.0 * answer.value.values, rel=1e-9)


@pytest.mark.slow
def test_a_torque_answers_to_the_mass_of_one_of_the_companions():
    """It is proportional to that."""
    aside = {**MOON, "companions": [{**MOON["companions"][0], "mean_anomaly": "1 rad"}]}
    answer = astroinertia.gradient(aside, of="torque gravity_gradient z@0 s", by=["companions.0.mass"])
    assert float(answer.gradient[0]) * 3e12 == pytest.approx(float(answer.value), rel=1e-8)


@pytest.mark.full
@pytest.mark.parametrize(("body", "wanted"), [(STAR, 0.8), (GAS, 0.45)], ids=["ellipsoid", "particles"])
def test_the_initial_spin_for_a_final_one_is_found_in_under_ten_evaluations(body, wanted):
    """Newton's method, from a period of 12, which is 0.52 at first, and in the end not what is wanted."""
    period, spins = 12.0, []
    while not spins or abs(spins[-1] / wanted - 1.0) > 1e-6:
        tables = {**body, "body": {**body["body"], "rotation": {"period": period}}}
        answer = astroinertia.gradient(tables, of="angular_velocity.z", by=["body.rotation.period"])
        spins.append(float(answer.value))
        assert len(spins) < 10
        period *= (wanted / spins[-1]) ** (spins[-1] / (float(answer.gradient[0]) * period))
    assert abs(spins[0] / wanted - 1.0) > 0.3


@pytest.mark.parametrize(
    ("tables", "of", "by", "sentence"),
    [
        (CORE, "angular_velocity.z", ["time.end"], "'time.end' says how the body is followed"),
        (CORE, "angular_velocity.z", [], "by must be a list of keys"),
        (CORE, "angular_velocity.z", "body.mass", "by must be a list of keys"),
        (CORE, "frequency of angular_velocity z", ["body.mass"], "a frequency has no gradient here"),
        (CORE, "spin", ["body.mass"], "'spin' is no series of the dataset; did you mean spin_axis"),
        (CORE, "angular_velocity.z@1 h", ["body.mass"], "the time of a gradient"),
        (CORE, "angular_velocity.z", ["body.period"], "body.period"),
        (SIMS / "evrard.toml", "inertia_tensor.zz", ["body.mass"], r"particles are .* with \[numerics\] engine = "),
        (MIXED, "inertia_tensor.zz", ["body.mass"], r"particles are .* with \[numerics\] precision = "),
        (SO_MANY_STEPS, "inertia_tensor.zz", ["body.mass"], r"\[time\] max_steps: where a run ends would jump"),
        (IN_REGIONS, "inertia_tensor.zz", ["body.mass"], "regions: what is within one changes"),
    ],
)
def test_what_cannot_be_differentiated_is_said_in_one_sentence(tables, of, by, sentence):
    with pytest.raises(SceneError, match=sentence) as refused:
        astroinertia.gradient(tables, of=of, by=by)
    assert "\n" not in str(refused.value)


@pytest.mark.full
@pytest.mark.parametrize("digits", [5, 14])
def test_a_body_that_is_built_in_jumps_is_refused_and_one_of_round_off_is_not(digits, monkeypatch):
    """Jumps of 1e-4, as wide as the members are apart, are seen in the first state; of 1e-13, they are round-off."""

    def coarse(one, units):
        period = round(float(one.body.rotation.period), digits)
        return prepare(
            astroinertia.Scene(**{**TOP, "body": {**TOP["body"], "rotation": {"period": f"{period} s"}}}), units
        )

    monkeypatch.setattr(gradients, "prepare", coarse)
    if digits == 5:
        with pytest.raises(
            SceneError, match=r"'body.rotation.period' does not .* smoothly \(the body changes in jumps"
        ):
            astroinertia.gradient(TOP, of="angular_velocity.z", by=["body.rotation.period"])
    else:
        astroinertia.gradient(TOP, of="angular_velocity.z", by=["body.rotation.period"])


@pytest.mark.full
def test_blows_add_to_an_angular_momentum_and_not_to_its_derivative():
    """L = L_0 + blows, and L_0 goes as 1/period."""
    blows = {
        "angular_momentum": ["0.01 N m s", "0 N m s", "0.03 N m s"],
        "time": "0.05 s",
        "every": "0.06 s",
        "number": 2,
    }
    answers = [
        astroinertia.gradient(
            {**TOP, "effects": {"impulses": blows}}, of=f"angular_momentum.z@{when}", by=["body.rotation.period"]
        )
        for when in ("0 s", "end")
    ]
    first, last = (float(answer.value) for answer in answers)
    assert last - first == pytest.approx(2 * 0.03, rel=1e-10)
    assert [float(answer.gradient[0]) for answer in answers] == pytest.approx([-first / 0.1] * 2, rel=1e-8)


def test_a_key_that_moves_the_time_of_a_torque_is_refused():
    tables = {**TOP, "effects": {"constant_torque": {"vector": ["1 N m", "0 N m", "0 N m"], "begin": "0.05 s"}}}
    with pytest.raises(SceneError, match=r"does not change the run smoothly \(the times at which torques begin"):
        astroinertia.gradient(tables, of="angular_velocity.z", by=["effects.constant_torque.begin"])


@pytest.mark.slow
def test_a_key_that_moves_the_end_of_an_effect_is_refused():
    tables = {**STAR, "effects": {"gravity": {}, "pressure": {}, "damping": {"time_scale": 0.3, "until": 0.2}}}
    with pytest.raises(SceneError, match=r"does not change the run smoothly \(the times at which effects begin or end"):
        astroinertia.gradient(tables, of="angular_momentum.z", by=["effects.damping.until"])


@pytree
@dataclass(frozen=True, eq=False)
class Motor(Effect):
    """A torque about z for a while."""

    strength: Any = 0.5
    lasts: Any = 1.25
    kind: ClassVar[str] = "motor"
    external: ClassVar[bool] = True
    models: ClassVar = ("rigid",)
    options: ClassVar = {
        "strength": positive("torque", 0.5, "of the torque"),
        "lasts": positive("time", 1.25, "how long"),
    }

    def breaks(self, start, end):
        """When it ends."""
        return (float(self.lasts),) if start < self.lasts <= end else ()

    def during(self, start, end):
        """Nothing after that."""
        return self if end <= self.lasts else replace(self, strength=0.0)

    def torque(self, body):
        """About z."""
        return self.strength * np.array([0.0, 0.0, 1.0])


@pytest.mark.slow
def test_an_effect_from_python_is_differentiated_as_one_of_the_package(tmp_path):
    body = {"kind": "rigid", "mass": 1.0, "radius": 1.0, "moment_ratios": [0.3, 0.35, 0.4], "rotation": {"rate": 0.3}}
    motor = astroinertia.Scene(
        name="motor", units="code", model="rigid", body=body, effects=[Motor()], time=3.0, output={"series_every": 1.0}
    )
    found = astroinertia.gradient(motor, "angular_momentum.z@end", ["effects.motor.strength"])
    assert float(found.value) == pytest.approx(0.4 * 0.3 + 0.5 * 1.25, rel=1e-12)
    assert float(found.gradient[0]) == pytest.approx(1.25, rel=1e-9)  # L = L0 + strength times how long
    with pytest.raises(SceneError, match="the times at which torques begin, end or strike differ"):
        astroinertia.gradient(motor, "angular_momentum.z@end", ["effects.motor.lasts"])
    with pytest.raises(SceneError, match="a sweep takes what is built in or installed, and nothing of your own"):
        run_sweep(sensitivity_sweep(motor, ["body.rotation.rate"]), tmp_path / "runs")


@pytree
@dataclass(frozen=True, eq=False)
class Boost(Effect):
    """An acceleration along x for a while, which `during` alone says."""

    strength: Any = 2.0
    lasts: Any = 0.17
    kind: ClassVar[str] = "boost"
    external: ClassVar[bool] = True
    options: ClassVar = {
        "strength": positive("acceleration", 2.0, "of all particles"),
        "lasts": positive("time", 0.17, "how long"),
    }

    def breaks(self, start, end):
        """When it ends."""
        return (float(self.lasts),) if start < self.lasts <= end else ()

    def during(self, start, end):
        """Nothing after that."""
        return self if end <= self.lasts else replace(self, strength=0.0)

    def acceleration(self, xp, fluid):
        """Along x."""
        return xp.zeros_like(fluid.position) + self.strength * xp.asarray([1.0, 0.0, 0.0])


@pytest.mark.slow
def test_a_strength_counts_while_during_alone_lets_an_effect_act():
    boosted = astroinertia.Scene(**{**COLD, "effects": ["gravity", Boost()]})
    found = astroinertia.gradient(boosted, "momentum.x@end", ["effects.boost.strength"])
    assert float(found.value) == pytest.approx(2.0 * 0.17, rel=1e-9)  # of a mass of 1
    assert float(found.gradient[0]) == pytest.approx(0.17, rel=1e-9)


@pytest.mark.slow
def test_a_wobble_and_its_period_have_gradients():
    """A free top keeps its wobble, and does all in a time that goes as the period of its rotation."""
    turning = {"period": "1 d", "wobble": "0.3 rad"}
    body = {"kind": "rigid", "mass": "1 kg", "moments": ["1 kg m2", "1 kg m2", "2 kg m2"], "rotation": turning}
    top = {"name": "top", "model": "rigid", "body": body, "effects": [], "time": "1 h"}
    wobble = astroinertia.gradient(top, "wobble_angle", ["body.rotation.wobble", "body.rotation.period"])
    assert wobble.gradient.values == pytest.approx([1.0, 0.0], abs=1e-9)
    period = astroinertia.gradient(top, "wobble_period", ["body.rotation.period"])
    assert float(period.gradient[0]) == pytest.approx(float(period.value), rel=1e-8)


@pytest.mark.slow
def test_an_observable_of_an_installed_package_has_a_gradient(tmp_path, monkeypatch):
    """The phase of the quadrupole of a body that turns is the rate times the time."""
    distribution(tmp_path, "quadrupole_phase = quadrupole_phase:QuadrupolePhase", group="observables")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.syspath_prepend(EXAMPLE)
    body = {"kind": "rigid", "mass": 1.0, "moments": [1.0, 2.0, 2.5], "rotation": {"rate": 0.7}}
    turning = {"name": "turning", "model": "rigid", "units": "code", "body": body, "effects": [], "time": 2.0}
    scene = turning | {"observables": ["quadrupole_phase"]}
    answer = astroinertia.gradient(scene, "quadrupole_phase", ["body.rotation.rate"])
    assert float(answer.gradient[0]) == pytest.approx(2.0, abs=1e-9)
