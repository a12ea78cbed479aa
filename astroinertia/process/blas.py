"""Linear algebra in one thread: small matrices take tens of times longer where several threads share each of them.

Threads of BLAS wait for one another in a busy loop, which other work on the machine draws out. The limit holds for
libraries that are loaded when a function is called, and only while it runs.
"""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

Given = ParamSpec("Given")
Result = TypeVar("Result")


def one_thread(function: Callable[Given, Result]) -> Callable[Given, Result]:
    """The same function, during which NumPy and SciPy use one thread for linear algebra; a call costs 0.3 ms more."""

    @wraps(function)
    def limited(*args: Given.args, **keywords: Given.kwargs) -> Result:
        with threadpool_limits(limits=1, user_api="blas"):
            return function(*args, **keywords)

    return limited
