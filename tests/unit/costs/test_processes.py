"""What a plan says of several processes, beside what they were measured to work and to be sent."""

import re
from pathlib import Path

import pytest

from astroinertia.cli.main import main
from astroinertia.costs import machine, processes
from astroinertia.costs.evaluations import evaluation
from astroinertia.costs.prediction import predict
from astroinertia.process.stopwatch import total
from astroinertia.scene import load

SIMS = Path(__file__).parents[3] / "sims"
TABLE = Path(__file__).parents[2] / "benchmarks" / "results" / "processes.md"
ROW = re.compile(r"\| (\d+) \| (mixed|float64) \| (\d+) \| [\d.e-]+ \| ([\d.]+) \| (\d+) \|$", re.MULTILINE)


def cloud(particles: int, *settings: str):
    return load.load_file(SIMS / "evrard.toml", (f"body.particles={particles}", *settings))


def measured():
    """Particles, precision, processes, share of the work of one alone, bytes received a step and particle."""
    rows = [(int(row[0]), row[1], int(row[2]), float(row[3]), float(row[4])) for row in ROW.findall(TABLE.read_text())]
    assert {processes for _, _, processes, _, _ in rows} >= {1, 2, 4}
    return rows


def work(scene, particles: int, count: int) -> float:
    costs = processes.shared_out(machine.shipped(), count)
    return total(evaluation(scene, particles, costs).values()).processor


def test_what_a_process_works_and_is_sent_is_as_measured():
    for particles, precision, count, share, received in measured():
        scene = cloud(particles, f"numerics.precision='{precision}'")
        assert work(scene, particles, count) / work(scene, particles, 1) == pytest.approx(share, rel=0.15)
        assert processes.received(particles, count) / particles == pytest.approx(received, rel=0.15)


@pytest.mark.slow
def test_one_process_takes_what_it_takes_without_others_and_more_take_less_until_they_only_wait():
    scene = cloud(100_000)
    alone = predict(scene, machine.shipped())
    assert alone is not None and alone == predict(scene, machine.shipped(), 1)
    assert not alone.received
    times = []
    for count in (1, 2, 4, 64):
        prediction = predict(scene, machine.shipped(), count)
        assert prediction is not None
        assert prediction.steps == alone.steps
        assert prediction.memory == alone.memory
        times.append(prediction.wall_time)
    assert times == sorted(times, reverse=True)
    assert times[0] / times[-1] < 10.0  # what is not shared out stays


def test_few_particles_are_not_shared_out():
    scene = cloud(1000)
    assert predict(scene, machine.shipped(), 4) == predict(scene, machine.shipped())
    assert predict(scene, machine.shipped(), 2) != predict(scene, machine.shipped())


def test_a_plan_says_it_and_refuses_what_processes_do_not_share(capsys):
    evrard = str(SIMS / "evrard.toml")
    assert main(["plan", evrard, "--set", "body.particles=100000", "--processes", "4"]) == 0
    assert "30 MB" in capsys.readouterr().out
    for words, reason in (
        ((evrard, "--processes", "0"), "at least 1"),
        ((str(SIMS / "hyperion.toml"), "--processes", "2"), "engine numba_cpu"),
        ((evrard, "--set", "numerics.engine='xla'", "--processes", "2"), "engine numba_cpu"),
        ((str(SIMS / "pulsar_births.toml"), "--processes", "2"), "--workers"),
    ):
        assert main(["plan", *words]) == 2
        assert reason in " ".join(capsys.readouterr().err.split())
