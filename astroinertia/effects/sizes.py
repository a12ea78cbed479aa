"""How large every effect is in a scene: a dimensionless number, and by what part I and spin would change without it.

Upper estimates, within a factor of MARGIN: what is secular grows with the run, what a collapse makes large counts as
soon as the run is as long as the fall. How each is found stands beside its options, in its module of
effects.kinds.
"""

from dataclasses import dataclass

from astroinertia.effects.characteristic import OF_ZONE, Characteristic
from astroinertia.effects.measure import Measure, Options

MARGIN = 3.0  # by which estimates may be wrong: an effect counts from a third of the accuracy on


@dataclass(frozen=True)
class Size:
    """An effect's number and its name, the change if it were left out, how that is found, and what is not known.

    change is None where `unknown` says what the scene does not tell, and number where it means nothing.
    """

    name: str
    number: float | None
    change: float | None
    formula: str
    source: str
    unknown: str = ""

    def counts(self, accuracy: float) -> bool:
        """Whether leaving the effect out could cost that accuracy; so it is, too, where that is not known."""
        return self.change is None or self.change * MARGIN > accuracy


def effect_size(measure: Measure | None, body: Characteristic, options: Options | None = None) -> Size:
    """The size of an effect with these options (None: it is not listed, and has none).

    measure: the effect's; without one its size is not known.
    """
    if measure is None:
        return Size("", None, None, "", "", "the effect states no size")
    if "zone" in measure.needs and not body.deforms:
        return Size(measure.name, None, 0.0, "what keeps its size or shape does not yield to it", measure.source)
    missing = [name for name in measure.needs if getattr(body, name) is None]
    if not missing and options is None and measure.options:
        return _unknown(measure, "it needs numbers of its own")
    values = {} if options is None else options
    missing += [name for name in measure.options if values.get(name) is None]
    if missing:
        return _unknown(measure, f"the scene does not state its {_called(missing[0], body)}")
    try:
        number, change = measure.function(body, values)
    except (TypeError, KeyError, ZeroDivisionError, OverflowError):  # options that contradict: said when it is built
        return _unknown(measure, "its options do not say")
    return Size(measure.name, number, change, measure.formula, measure.source)


def _called(missing: str, body: Characteristic) -> str:
    """What messages call a number that is missing: of the zone, what it lacks."""
    if missing == "zone":
        missing = next((called for name, called in OF_ZONE.items() if getattr(body, name) is None), "extent")
    return missing.replace("_", " ")


def _unknown(measure: Measure, what: str) -> Size:
    return Size(measure.name, None, None, measure.formula, measure.source, what)
