"""Whether the pair terms of an effect of the user's own are such as the engine can carry out.

Tests: tests/unit/test_effects_door.py.
"""

from collections import defaultdict
from typing import Any, get_args

import numpy as np

from astroinertia.effects.effect import Effect
from astroinertia.engines.numba_source import Sources
from astroinertia.engines.terms import COMMON, PairTerm, Reduction, arguments
from astroinertia.errors import SceneError
from astroinertia.units import failure, shown

_GATHERED = {"acceleration": "central", "heating": "sum", "signal": "max"}  # what the sums of a step are taken for


def refuse_wrong_terms(effect: Effect, engine: str) -> None:
    """SceneError, in a sentence, where a pair term of an effect is none, or none that the engine can carry out."""
    for part in ("gradient_terms", "neighbour_terms", "all_pair_terms"):
        try:
            for term in getattr(effect, part):
                if not isinstance(term, PairTerm):
                    raise ValueError(f"{shown(repr(term), 60)} is no PairTerm")
                _refuse_wrong(term, effect.kind, part != "gradient_terms")
                for function in (term.pair, term.far) if engine == "numba_cpu" else ():
                    if function is not None:
                        Sources().add(function)
        except ValueError as error:
            raise SceneError(f"{part} of the effect '{effect.kind}': {shown(str(error), 300)}.") from error
        except Exception as error:  # whatever a property and a function of the user's own do
            raise SceneError(f"the part {part} of the effect '{effect.kind}' failed ({failure(error)}).") from error


def _refuse_wrong(term: PairTerm, kind: str, forces: bool) -> None:
    if term.effect not in (kind, COMMON):
        raise ValueError(f"a pair term is of the effect {term.effect!r}, and not of its own")
    for output in term.outputs:
        if output.how not in get_args(Reduction):
            raise ValueError(f"{output.name} is gathered as {output.how!r}, not as {', '.join(get_args(Reduction))}")
        if forces and output.how != (how := _GATHERED.get(output.name, output.how)):
            raise ValueError(f"{output.name} is gathered as {output.how!r}, and must be as {how!r}")
        if forces and output.how == "central" and output.name != "acceleration":
            raise ValueError(f"{output.name} is gathered as 'central', and would move nothing: call it acceleration")
    for function in (term.pair, term.far):
        if function is None:
            continue
        scalars: Any = defaultdict(lambda: np.float64(1.0))
        given = arguments(function, scalars)
        with np.errstate(all="ignore"):
            values = function(np, *given)
        if not isinstance(values, tuple) or len(values) != len(term.outputs):
            raise ValueError(f"{function.__name__} must return a tuple of {len(term.outputs)}, a number an output")
