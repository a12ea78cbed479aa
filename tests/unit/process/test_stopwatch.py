"""What is timed is timed once, wherever it is called, and what was watched is as it was afterwards."""

import time

import pytest

from astroinertia.process.stopwatch import Seconds, Stopwatch, total, watched


class Base:
    def inherited(self):
        return self.slow(0.02)

    def slow(self, seconds):
        """Takes its time."""
        time.sleep(seconds)
        return seconds


class Worker(Base):
    def whole(self):
        time.sleep(0.02)
        return self.slow(0.05) + self.inherited()

    def fails(self):
        raise ValueError("no")


def test_parts_are_counted_once_and_add_up_to_the_whole():
    watch, worker = Stopwatch("whole"), Worker()
    places = {(Worker, "whole"): "whole", (Worker, "inherited"): "other", (Base, "slow"): lambda _, s: f"slow {s}"}
    with watched(watch, places):
        begin = time.perf_counter()
        assert worker.whole() == 0.07
        taken = time.perf_counter() - begin
    assert watch.seconds.keys() == {"whole", "other", "slow 0.05"}  # within `other` nothing is a part of its own
    assert total(watch.seconds.values()).wall == pytest.approx(taken, rel=0.02)
    assert watch.seconds["whole"].wall == pytest.approx(0.02, abs=0.015)
    assert 0.05 <= watch.seconds["slow 0.05"].wall < 0.065
    assert total(watch.seconds.values()).processor < 0.03  # it slept
    worker.whole()
    assert total(watch.seconds.values()).wall < 1.1 * taken


def test_what_was_watched_is_as_it_was_and_an_error_ends_a_part():
    before, watch = dict(vars(Worker)), Stopwatch()
    places = {(Worker, "fails"): "fails", (Worker, "slow"): lambda *_: "", (Worker, "inherited"): "inherited"}
    with watched(watch, places):
        assert Worker.slow.__doc__ == "Takes its time."
        assert Worker().slow(0.0) == 0.0 and not watch.seconds  # a part without a name is none
        with pytest.raises(ValueError, match="no"):
            Worker().fails()
    assert dict(vars(Worker)) == before and set(watch.seconds) == {"fails"}
    assert watch.timed("later", lambda: 3) == 3  # what failed is not under way any more
    assert set(watch.seconds) == {"fails", "later"}


def test_seconds_are_of_two_clocks():
    assert 2.0 * (Seconds(1.0, 2.0) + Seconds(0.5, 0.25)) == Seconds(3.0, 4.5)
