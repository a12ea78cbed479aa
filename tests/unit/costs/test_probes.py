"""What calibrations time."""

import pytest

from astroinertia.costs import probes
from astroinertia.costs.machine import SHIPPED_SECONDS
from astroinertia.process.stopwatch import Seconds


@pytest.mark.full
def test_intervals_are_timed_even_where_they_do_not_pay(monkeypatch):
    """Runs of so few particles choose global steps, which have no ends of intervals within."""
    monkeypatch.setattr(probes, "BY_THEMSELVES", 64)
    monkeypatch.setattr(probes, "MANY", 128)
    monkeypatch.setattr(probes, "EVALUATIONS", 400)
    found, of_base_steps = [], probes._of_base_steps
    monkeypatch.setattr(probes, "_of_base_steps", lambda *which: found.append(of_base_steps(*which)) or found[-1])
    probes._individual({name: Seconds(*cost) for name, cost in SHIPPED_SECONDS.items()})
    assert [ends >= 8.0 for ends, *_ in found] == [True, False, True, False]
