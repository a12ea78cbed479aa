"""The accessor's pictures: what all of them take, and how one is drawn."""

import functools
import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import xarray as xr

from astroinertia.dataset.by_member import begun, must_be_of_one_run
from astroinertia.errors import AbsentError, SceneError

OPTIONS = {
    "start": "time from which on it is drawn: a quantity, text such as '2 min', or a number in the dataset's unit",
    "end": "time up to which it is drawn, likewise",
    "size": "width and height in inches",
    "path": "a file to write the picture to as well; its ending says how (.png, .pdf, .svg)",
}
"""What every plot takes, by keyword."""
OF_PARTICLES = {"snapshots": "the particles, where they are not those of the dataset's file"}


def picture(module: str, function: str, of_particles: bool = False) -> Callable[[Callable], Callable]:
    """Make a method of the accessor draw by a function of a module of `plots`, which is only then imported.

    The method says what is seen, in its docstring; what it takes is added there, and anything else is refused.
    """
    options = OPTIONS | (OF_PARTICLES if of_particles else {})

    def made(plot: Callable) -> Callable:
        @functools.wraps(plot)
        def drawn(accessor: Any, size: Any = None, path: Any = None, **others: Any) -> Any:
            for name in others:
                if name not in options:
                    raise SceneError(f"{plot.__name__} has no option {name!r}; it has {', '.join(options)}.")
            must_be_of_one_run(accessor.dataset, "a picture")
            if of_particles and others.get("snapshots") is None:
                others["snapshots"] = accessor.snapshots
                if others["snapshots"] is None:
                    raise AbsentError("this dataset has no snapshots to draw.")
            draw = getattr(import_module(f"astroinertia.plots.{module}"), function)
            with missing_named(f"{plot.__name__} is drawn"):
                figure = draw(**accessor._drawn(**others))
            share = 1.0 if size is None else import_module("astroinertia.plots.small").resize(figure, _size(size))
            if path is not None:  # of as many dots as `show` gives it, also where it is smaller
                figure.savefig(path, dpi=import_module("astroinertia.plots.style").RESOLUTION / share)
            return figure

        listed = "\n".join(f"{name}: {text}." for name, text in options.items())
        drawn.__doc__ = (
            f"{inspect.cleandoc(plot.__doc__ or '')}\n\n"
            f"Returns the matplotlib Figure. Options, by keyword:\n\n{listed}\n"
        )
        return drawn

    return made


@contextmanager
def missing_named(made: str) -> Iterator[None]:
    """AbsentError that names what is missing of a dataset of which a part was taken, for the KeyError of xarray's."""
    try:
        yield
    except KeyError as error:  # which begins with what is missing
        raise AbsentError(
            f"{made} from all series of a run with their attributes, as astroinertia.open gives them, and of this "
            f"dataset a part is missing: {str(error.args[0]).split('. ')[0]}."
        ) from error


def as_drawn(dataset: xr.Dataset) -> xr.Dataset:
    """What pictures and words are made of: a run in the order of its times, from its first record with a value on."""
    return begun(dataset.inertia.dataset.sortby("time"))


def _size(size: Any) -> tuple[float, float]:
    try:
        width, height = (float(length) for length in size)
    except (TypeError, ValueError):
        raise SceneError(f"size must be width and height in inches, not {size!r:.60}.") from None
    if not (0.0 < width < 1000.0 and 0.0 < height < 1000.0):
        raise SceneError(f"size must be width and height in inches, not {size!r:.60}.")
    return width, height
