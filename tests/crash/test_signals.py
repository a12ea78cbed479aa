"""Signals at any moment of any command: it ends, saves what is to be saved, and says so in one sentence."""

import random
import signal

import pytest

from tests.crash.signalled import COMMANDS, Counted, prepared, signalled

INT, TERM, USR1 = signal.SIGINT, signal.SIGTERM, signal.SIGUSR1
WAYS = [(INT,), (TERM,), (USR1,), (INT, INT), (TERM, TERM), (USR1, USR1), (INT, TERM), (TERM, INT), (TERM, USR1)]
LONG = {
    "run": 3.0,
    "run rigid": 5.0,
    "resume": 3.0,
    "tradeoff": 8.0,
    "verify": 5.0,
    "verify beside": 8.0,
    "movie": 5.0,
    "calibrate": 8.0,
}
COMPILING = 15.0  # processor seconds, in which a command that has nothing compiled before has some


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return prepared(tmp_path_factory.mktemp("signals"))


# Of a sweep: test_sweep_signals.py; of verify alone, while it compiles: below.
@pytest.mark.parametrize(
    ("name", "numbers", "after"),
    [
        ("run", (TERM, TERM), 2.5),
        ("resume", (INT,), 2.5),
        pytest.param("tradeoff", (INT, INT), 4.0, marks=pytest.mark.full),
        ("movie", (USR1,), 2.5),
        pytest.param("verify beside", (INT,), 4.0, marks=pytest.mark.full),
        pytest.param("calibrate", (TERM, TERM), 1.5, marks=pytest.mark.full),
    ],
)
def test_a_signal_ends_a_command_and_loses_nothing(place, name, numbers, after):
    signalled(place, name, numbers, after, Counted())


def test_a_signal_ends_a_command_that_compiles(place):
    signalled(place, "verify", (TERM,), 6.0, Counted(), cold=True)


@pytest.mark.full
def test_three_hundred_signals_at_any_moment(place, result):
    chance, counted = random.Random(1), Counted()
    while counted.number < 300:
        names = list(COMMANDS)
        chance.shuffle(names)
        for name in names:
            signalled(place, name, chance.choice(WAYS), chance.uniform(0.05, LONG.get(name, 2.0)), counted)
        for name in ("run", "verify"):
            signalled(place, name, chance.choice(WAYS), chance.uniform(2.0, COMPILING), counted, cold=True)
    result(signals=counted.number, slowest_end=counted.slowest, **counted.ended)
