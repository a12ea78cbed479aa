"""What the catalogue of effects is made of: an entry for each, which stands beside its class."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Literal

from astroinertia.effects.measure import Measure
from astroinertia.errors import AstroinertiaError, SceneError
from astroinertia.units import Option, choice, failure

Cost = Literal["particles", "neighbours", "all pairs", "body"]
Pace = Callable[[Mapping[str, Any]], tuple[float, float | None]]


@dataclass(frozen=True)
class Entry:
    """One effect: one line on what it is, its options, the loop it needs and its source.

    models: those that have it. A numerical device of particles is not physics: other models need it not and skip it.
    size: how its size in a scene is estimated; None where it states none. colour: that of figures, of plots.style; a
    spare one without it. pace: from its options, the time that steps must resolve and until when (None: to the end),
    where these follow from options alone. auto: where `effects = "auto"` considers it that is not among a scene's
    candidates: "always", where there are "companions", or where bodies or kinds of matter are "touching". needs: the
    effects that it cannot be without. gradients: whether it asks for a pass over gradients, from its options.
    limit_power: of the number of particles, that its time-step limit falls with. presses: whether it adds to the
    pressure of matter, `further_pressure` of its class. added_weight: from a body and its options, what it adds to |W|
    over |W|, None where that is not known. package: name and version of the one that it comes from, empty
    where it was given from Python or is of this package. rank: its place in lists; those of one rank by their names.
    made: its class.
    """

    text: str
    options: Mapping[str, Option]
    cost: Cost
    source: str
    models: tuple[str, ...] = ("sph",)
    numerical: bool = False
    size: Measure | None = None
    colour: str = ""
    pace: Pace | None = None
    auto: Literal["", "always", "companions", "touching"] = ""
    needs: tuple[str, ...] = ()
    gradients: Callable[[Mapping[str, Any]], bool] | None = None
    limit_power: float = 0.0
    presses: bool = False
    added_weight: Callable[[Any, Mapping[str, Any]], float | None] | None = None
    package: str = ""
    rank: int = 100
    made: Any = field(kw_only=True)

    @property
    def origin(self) -> str:
        """Where it comes from, in words; empty for an effect of this package."""
        module, thing = self.made.__module__, "function" if hasattr(self.made, "function") else "class"
        if module.startswith("astroinertia.effects.kinds."):
            return ""
        return self.package or f"the {thing} {self.made.__qualname__} of {module}, given from Python"

    @property
    def described(self) -> str:
        """What it is, where it comes from, and where its equations do."""
        return "; ".join(filter(None, [self.text, f"from {self.origin}", self.source]))

    def build(self, options: Mapping[str, Any]) -> Any:
        """The thing with these options; ValueError, in one sentence, where they contradict each other."""
        with self.at_work(ValueError):
            return self.made.from_options(dict(options))

    @contextmanager
    def at_work(self, *said: type[Exception]) -> Iterator[None]:
        """Within, what a class that is not of this package fails with is a SceneError that names it; all but `said`."""
        try:
            yield
        except (AstroinertiaError, *said):
            raise
        except Exception as error:
            if not self.origin:
                raise
            raise SceneError(f"the {self.made.kind} of {self.origin} failed ({failure(error)}).") from error


FRAME = choice("the axes that it is given in", "inertial", "body")  # of torques
AXIS = (0.0, 0.0, 1.0)
FORCE_ERROR = 2e-4  # of gravity, wanted rms of |da|/|a|: less than the fluid's own discretisation leaves
