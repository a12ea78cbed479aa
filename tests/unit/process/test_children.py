"""Programs that a command starts: they end with it, and a signal to it is its own."""

import os
import sys

from astroinertia.process.children import completed, started

GROUP = "import os; print(os.getpgid(0))"
READER = "import sys; print(sys.stdin.read()[::-1], end='')"


def test_a_signal_to_the_group_of_a_command_is_no_failure_of_its_child():
    assert int(completed([sys.executable, "-c", GROUP]).stdout) != os.getpgid(0)


def test_a_program_is_given_a_text_and_its_words_are_returned():
    assert completed([sys.executable, "-c", READER], "ertrof").stdout == "fortre"


def test_a_program_that_is_not_waited_for_is_ended():
    with started([sys.executable, "-c", READER]) as child:
        assert child.poll() is None
    assert child.returncode < 0
