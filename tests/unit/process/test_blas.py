"""Small dense linear algebra runs in one thread of BLAS, and leaves the caller's threads as they were."""

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from astroinertia.bodies import oscillations
from astroinertia.process import blas


def blas_threads() -> list[int]:
    return [each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"]


@pytest.fixture
def two_threads():
    with threadpool_limits(limits=2, user_api="blas"):
        if 2 not in blas_threads():
            pytest.skip("this machine's BLAS has one thread")
        yield


@pytest.mark.usefixtures("two_threads")
def test_the_limit_holds_within_the_call_and_ends_with_it_also_after_an_error():
    before = blas_threads()
    assert set(blas.one_thread(blas_threads)()) == {1}
    assert blas_threads() == before

    @blas.one_thread
    def singular():
        return np.linalg.inv(np.zeros((2, 2)))

    with pytest.raises(np.linalg.LinAlgError):
        singular()
    assert blas_threads() == before


@pytest.mark.usefixtures("two_threads")
def test_modes_of_a_star_are_found_in_one_thread(monkeypatch):
    """`nonradial_modes(3, 5/3)` took 16 to 43 s with two threads of two busy cores, and 1 s with one."""
    seen = []
    solve = oscillations.eigh
    monkeypatch.setattr(oscillations, "eigh", lambda *given: (seen.append(max(blas_threads())), solve(*given))[1])
    oscillations.radial_modes(1.0, 5.0 / 3.0, 1)
    oscillations.nonradial_modes(1.0, 5.0 / 3.0, 2, 0, 0)
    assert len(seen) > 4 and set(seen) == {1}
