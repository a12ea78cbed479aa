"""What a process is busy with: the outermost of what goes on, and nothing once it is over."""

import numpy as np
import pytest
from numba import njit

from astroinertia.engines import numba_cache  # which listens to numba
from astroinertia.process import activity


def test_the_outermost_of_what_goes_on_is_named():
    begun = "compiling a pass", "compiling a part of it"
    for words in begun:
        activity.begin(words)
    assert activity.current() == begun[0]
    for words in reversed(begun):
        activity.end(words)
    assert activity.current() == ""


@pytest.mark.slow
def test_what_numba_compiles_is_named_while_it_does_and_not_again(monkeypatch):
    assert numba_cache
    heard = []
    begin = activity.begin
    monkeypatch.setattr(activity, "begin", lambda words: (heard.append(words), begin(words)))

    @njit
    def sum_of_squares(x):
        return (x * x).sum()

    assert sum_of_squares(np.ones(3)) == sum_of_squares(np.ones(3)) == 3.0
    assert heard.count("compiling sum of squares") == 1
    assert activity.current() == ""
