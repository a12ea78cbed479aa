"""What settings will take, guessed from those already run."""

import math
from collections.abc import Mapping

from astroinertia.accuracy.knobs import Knob, Setting, Value

_UNKNOWN = 1.0  # s, of a setting before any other was run
_LEAST = 1e-3  # s, that every setting takes


def predicted(setting: Setting, knob: Knob, base: float, taken: Mapping[tuple[str, Value], float]) -> float:
    """Seconds that a setting will take.

    taken: seconds by (knob, value) of what was run; base: those of the base, NaN before it was run. Along a knob whose
    two most expensive settings are known their power law goes on; else the knob's own guess is scaled.
    """
    timed = [(knob.cost(value), taken[knob.name, value]) for value in knob.values if (knob.name, value) in taken]
    timed = sorted((guess, seconds) for guess, seconds in timed if math.isfinite(seconds))
    wanted = knob.cost(setting.value)
    if not timed:
        return max(_LEAST, base * wanted / knob.cost(knob.default)) if math.isfinite(base) else _UNKNOWN
    guess, seconds = (
        timed[-1] if wanted >= timed[-1][0] else min(timed, key=lambda pair: abs(math.log(pair[0] / wanted)))
    )
    growth = 1.0
    if len(timed) > 1 and timed[-1][0] > timed[0][0] and wanted > timed[-1][0]:
        (first, low), (last, high) = timed[-2], timed[-1]
        growth = math.log(max(high, _LEAST) / max(low, _LEAST)) / math.log(last / first) if last > first else 1.0
    return max(_LEAST, seconds * (wanted / guess) ** min(max(growth, 0.0), 2.0))
