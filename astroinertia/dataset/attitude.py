"""What follows from the attitude and the angular momentum of a rigid body: obliquity, precession, wobble, settling.

Series are in the units of their ingredients; what is one number of a run is an attribute of a series, in SI, with its
meaning beside it.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from astroinertia.dataset.sizes import largest_size
from astroinertia.inertia.principal import EQUAL_MOMENTS

Series = Mapping[str, np.ndarray]

_ALONG = 1e-9  # below this sine of the angle from z, L goes round nothing
_BESIDE = 0.1  # of how far L moves sideways: nearer to z than that it passes z rather than going round it
_FEW = 16  # records from which a course and an oscillation about it follow
_SMALL = 0.1  # rad: the wobble up to which it dies away by a factor e in one time
_GONE = 1e-14  # of the energy: round-off
_LEFT = 0.05  # of a line and a sine: what may be left of a motion that is said to be these
_SEARCHED = np.linspace(0.5, 2.5, 81)  # periods in the run, besides those near the largest of the spectrum
_ROUND_OFF = 1e-12  # of the sine of an angle: a nutation smaller than that is none


class Course(NamedTuple):
    """A steady rate and, about it, the oscillation that explains most: its amplitude and period."""

    rate: float
    amplitude: float
    period: float


def attitude_quantities(series: Series, held: bool, deforms: bool) -> dict[str, np.ndarray]:
    """Series (T,) by name, of `observables.quantities.OF_ATTITUDE`.

    held: at a pivot, so that it has no free motion. deforms: by its rotation, so that its wobble is as its attitude has
    it, where records are close enough. The last row of torque is that of the internal forces.
    """
    momentum = series["angular_momentum"]
    size = np.linalg.norm(momentum, axis=-1)
    level = np.hypot(momentum[:, 0], momentum[:, 1])
    pull = series["torque"][:, :-1].sum(axis=1)
    sideways = np.where(size > 0.0, momentum[:, :2].T / np.where(size > 0.0, size, 1.0), np.nan)
    sine = np.hypot(*sideways)
    way = largest_size(np.hypot(*(sideways.T - sideways[:, np.argmax(size > 0.0)]).T))
    tilted = (sine > _ALONG) & (np.min(sine, where=size > 0.0, initial=1.0) > _BESIDE * way)
    around = momentum[:, 0] * pull[:, 1] - momentum[:, 1] * pull[:, 0]
    moments, along = _in_body(series)
    inverse = np.where(moments > 0.0, 1.0 / np.where(moments > 0.0, moments, 1.0), 0.0)
    across = along[:, 0] ** 2 + along[:, 1] ** 2
    # Two or three of them where L may lie along any axis between.
    largest = moments > (1.0 - EQUAL_MOMENTS) * moments[:, 2:]
    off, on = (np.sqrt((along**2 * those).sum(axis=-1)) for those in (~largest, largest))
    turning = (along[:, :2] ** 2 * inverse[:, :2]).sum(axis=-1)
    free = {}
    if deforms and not held:
        period = _period_of_motion(series["time"], along)
        free = {} if period is None else {"wobble_period": period}
    elif not held:
        around_momentum = _over(size * turning, across, (across > (_ALONG * size) ** 2) & ~largest[:, 1])
        free = {"wobble_period": _wobble_period(moments, along), "free_precession_rate": around_momentum}
    all_of_them = {
        "obliquity": np.where(size > 0.0, np.arctan2(level, momentum[:, 2]), np.nan),
        "precession_rate": _over(around, level**2, tilted),
        "wobble_angle": np.where(size > 0.0, np.arctan2(off, on), np.nan),
        **free,
    }
    return {name: values for name, values in all_of_them.items() if not np.isnan(values).all()}


def attitude_attributes(series: Series) -> dict[str, dict[str, Any]]:
    """What is one number of the run, by the series that it is an attribute of; all in SI.

    series: time, angular_momentum, inertia_tensor, attitude and what `attitude_quantities` gives.
    """
    found: dict[str, dict[str, Any]] = {}
    time, momentum = series["time"], series["angular_momentum"]
    rate = series.get("precession_rate", np.zeros(1))
    if np.isfinite(rate).all() and rate.any() and len(time) >= _FEW:
        tilt = series["obliquity"]
        turned = np.unwrap(np.arctan2(momentum[:, 1], momentum[:, 0]))
        longitude, nodding = course(time, turned), course(time, tilt)
        if longitude is not None and abs(np.diff(turned)).max() < 0.5 * np.pi:
            found["precession_rate"] = {
                "mean": longitude.rate,
                "mean_comment": "steady rate of the longitude of L (rad s-1), but for its largest oscillation",
            }
        if nodding is not None and nodding.amplitude > _ROUND_OFF:
            found["obliquity"] = {
                "nutation_amplitude": nodding.amplitude,
                "nutation_period": nodding.period,
                "nutation_comment": "amplitude (rad) and period (s) of the largest oscillation of the obliquity",
            }
    settling = _settling_time(series) if "wobble_angle" in series else None
    if settling is not None:
        found["wobble_angle"] = {
            "settling_time": settling,
            "settling_time_comment": "time (s) in which a small wobble falls by a factor e, from the energy above "
            "that of rotation about the largest moment (Burns & Safronov 1973, MNRAS 165, 403)",
        }
    return found


def course(time: np.ndarray, values: np.ndarray) -> Course | None:
    """A line and one sine through values (T,) at times (T,) by least squares.

    None where records are too sparse, and where both leave much of the motion, as of one by several torques. The
    frequency is looked for near the largest of the spectrum and among a few turns in the whole run.
    """
    span = time[-1] - time[0]
    shift = (time - time[0]) / span - 0.5

    def fit(turns: float) -> tuple[float, np.ndarray]:
        phase = 2.0 * np.pi * turns * shift
        columns = np.stack([np.ones_like(shift), shift, np.sin(phase), np.cos(phase)], axis=1)
        numbers = np.linalg.lstsq(columns, values - values.mean(), rcond=None)[0]
        left = values - values.mean() - columns @ numbers
        return float(left @ left), numbers

    line = np.polyfit(shift, values, 1)
    flat = (values - np.polyval(line, shift)) * np.hanning(len(values))
    peak = int(np.argmax(abs(np.fft.rfft(flat))[1:])) + 1
    if peak > 0.4 * len(values):
        return None
    turns = min((*_SEARCHED, *np.linspace(max(peak - 1.0, 0.5), peak + 1.0, 81)), key=lambda turns: fit(turns)[0])
    for width in (0.02, 0.002, 0.0002):
        turns = min(turns + width * np.linspace(-1.0, 1.0, 21), key=lambda turns: fit(turns)[0])
    left, numbers = fit(turns)
    size = float(np.hypot(*numbers[2:]))
    if np.sqrt(left / len(values)) > _LEFT * (abs(numbers[1]) + size):
        return None
    return Course(float(numbers[1] / span), size, float(span / turns))


def _in_body(series: Series) -> tuple[np.ndarray, np.ndarray]:
    """Moments (T, 3) about the body's axes, ascending at the start, and L along them (T, 3)."""
    rows = series["attitude"]
    moments = np.einsum("tki,tij,tkj->tk", rows, series["inertia_tensor"], rows)
    order = np.argsort(moments[0], kind="stable")
    return moments[:, order], np.einsum("tki,ti->tk", rows, series["angular_momentum"])[:, order]


def _wobble_period(moments: np.ndarray, along: np.ndarray) -> np.ndarray:
    """4 K(k) over the rate of the elliptic functions: Landau & Lifshitz, Mechanics, section 37."""
    from scipy.special import ellipk  # only here: most files that are opened are of no rigid body

    low, middle, high = moments.T
    square = along**2
    positive = low > 0.0
    # L^2 - 2 T I_1 and 2 T I_3 - L^2, in which no digits cancel.
    above = (square * (1.0 - low[:, None] / np.where(moments > 0.0, moments, 1.0))).sum(axis=-1)
    below = (square * (high[:, None] / np.where(moments > 0.0, moments, 1.0) - 1.0)).sum(axis=-1)
    about_high = (high - middle) * above >= (middle - low) * below
    fast = np.where(about_high, (high - middle) * above, (middle - low) * below)
    slow = np.where(about_high, (middle - low) * below, (high - middle) * above)
    turns = positive & (fast > 0.0)
    rate = np.sqrt(_over(fast, low * middle * high, turns))
    return 4.0 * ellipk(_over(slow, fast, turns)) / rate


def _period_of_motion(time: np.ndarray, along: np.ndarray) -> np.ndarray | None:
    """The time of the turn of L about the axis of the largest moment that is nearest to each record.

    None where there is no whole turn, and where L turns too far from one record to the next, or back.
    """
    phase = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
    phase = np.copysign(1.0, phase[-1] - phase[0]) * phase
    steps = np.diff(phase)
    if phase[-1] - phase[0] < 2.0 * np.pi or not (steps > 0.0).all() or steps.max() > 0.5 * np.pi:
        return None
    from scipy.interpolate import CubicSpline  # only here: most files that are opened are of no rigid body

    passes, middle = CubicSpline(phase, time), np.clip(phase, phase[0] + np.pi, phase[-1] - np.pi)
    return passes(middle + np.pi) - passes(middle - np.pi)


def _settling_time(series: Series) -> float | None:
    """From the slope of the logarithm of the energy above the least, where the wobble is small and dies away."""
    moments, along = _in_body(series)
    if not (moments > 0.0).all():
        return None
    above = 0.5 * (along**2 / moments * (1.0 - moments / moments[:, 2:])).sum(axis=-1)
    energy = 0.5 * (along**2 / moments).sum(axis=-1)
    small = (series["wobble_angle"] < _SMALL) & (above > _GONE * energy)
    if small.sum() < _FEW or not (np.diff(above[small]) < 0.0).all():
        return None
    return float(-2.0 / np.polyfit(series["time"][small], np.log(above[small]), 1)[0])


def _over(numerator: np.ndarray, denominator: np.ndarray, where: np.ndarray) -> np.ndarray:
    return np.where(where, numerator / np.where(where, denominator, 1.0), np.nan)
