"""What effects that exchange heat with the surroundings share."""

from astroinertia.effects.characteristic import Characteristic
from astroinertia.effects.kinds.pressure import pressure_size
from astroinertia.effects.measure import within_all


def changing_time(xp, h, energy, gain, decay):
    """u/|du/dt| of matter that cools; of matter that is heated, the time in which that moves it by h, besides.

    Matter whose heat does not change, for it has none or is as cold as it can become, has no limit.
    """
    rate = gain - decay * energy
    size = xp.maximum(xp.abs(rate), 1e-100)
    spread = xp.where(rate > 0.0, xp.power(h * h / size, 1.0 / 3.0), 0.0)
    return (xp.where(rate == 0.0, 1e100, energy / size + spread),)


def heat_change(body: Characteristic, share: float) -> float:
    """What a share of the heat means to the size: R ~ A^(1/(3 gamma - 4)) of what is bound; no more than pressure."""
    zone = body.zone
    bound = zone is not None and zone.weight > zone.pressure
    steep = 2.0 / max(3.0 * body.gamma - 4.0, 0.5) if bound or zone is None or zone.imbalance < 0.5 else 2.0
    return within_all(min(1.0, steep * share) * pressure_size(body, {})[1])
