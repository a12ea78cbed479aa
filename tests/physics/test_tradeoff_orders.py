"""Orders that `tradeoff` finds from real runs are those of theory, and the sources of error are the true ones."""

import pytest

from astroinertia.accuracy.analysis import analysed
from astroinertia.accuracy.tradeoff import carry_out
from tests.tradeoff_scenes import CASES

SCENES = {case.name: case for case in CASES}


def found(name, folder, *settings, only=(), minutes=60.0, observables=()):
    table = carry_out(SCENES[name].scene(*settings), folder, minutes, observables, only)
    return table, analysed(table).judged


def sources(judged):
    return {source.knob.name: source for source in judged.sources}


@pytest.mark.full
def test_the_error_of_an_ellipsoid_goes_as_its_tolerance(tmp_path):
    """Riemann's figure against its closed form, over eight decades of the error. Measured: orders 1.07 and 1.03."""
    table, judged = found("riemann", tmp_path, "time.end=30.0", only=["tolerance"])
    for each in judged:
        assert "closed form" in each.reference.source
        law = sources(each)["tolerance"].law
        assert law.points >= 6
        assert law.order == pytest.approx(1.0, abs=0.15)
    assert not any(run.failure for run in table.measured.values())


@pytest.mark.full
@pytest.mark.parametrize("order", [2, 4])
def test_the_error_of_a_top_goes_as_its_steps(order, tmp_path):
    """A tennis racket in its first second, short of its flip, against Jacobi's functions."""
    settings = (f"numerics.order={order}", "time.end='0.5 s'", "numerics.steps_per_rotation=80")
    _, judged = found("rigid_top", tmp_path, *settings, only=["steps_per_rotation"])
    for each in judged:
        law = sources(each)["steps_per_rotation"].law
        assert law.points >= 4
        assert law.order == pytest.approx(order, abs=0.2)
        assert sources(each)["steps_per_rotation"] is each.limiting


@pytest.mark.full(inputs=["tests/tradeoff_scenes.py", "sims/dyson_ellipsoid.toml"])
def test_the_error_of_a_fluid_goes_as_its_particles_and_its_steps(result, tmp_path):
    """Steps of one length: others are divided so that they end at outputs, in parts that differ from factor to factor.

    Measured: orders 2.15 and 2.001; with steps that follow the flow 2.28 and 1.45.
    """
    settings = ("body.particles=1000", "numerics.max_timestep=0.02")
    table, (inertia, rate) = found(
        "dyson", tmp_path, *settings, only=["timestep_factor", "smoothing_tolerance", "precision"]
    )
    for name, each in (("inertia", inertia), ("rate", rate)):
        sources_found = sources(each)
        result(
            **{f"{name}_{knob}_order": source.law.order for knob, source in sources_found.items() if source.law.points}
        )
        result(**{f"{name}_{knob}_error": source.error for knob, source in sources_found.items()})
        assert each.limiting.knob.name == "particles"
        assert sources_found["particles"].law.order == pytest.approx(2.0, abs=0.7)
        assert sources_found["timestep_factor"].law.order == pytest.approx(2.0, abs=0.1)
        # What is known of the default is that of the exact flow: a hundredth of it is the steps'.
        assert sources_found["timestep_factor"].error < 0.1 * sources_found["particles"].error
    together = [setting for setting in table.measured if setting.knob == "balanced"]
    assert together
