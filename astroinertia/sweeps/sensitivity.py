"""How a run answers to its parameters: derivatives of every series by keys of the scene, from runs on either side.

Each key is moved by a relative step h and by h/2, both ways. With D(h) the central difference, (4 D(h/2) - D(h))/3 is
of fourth order in h (Richardson 1911, Philosophical Transactions A 210, 307), and its difference from D(h/2) bounds the
error where the runs are smooth in the key. Particles answer with noise, too, which a larger step makes smaller; that
difference shows it. A `sensitivity_sweep` is run as any sweep, by `sweeps.ensemble.run_sweep`. Tests:
tests/unit/sweeps/test_sensitivity.py.
"""

import difflib
from collections.abc import Sequence
from os import PathLike
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.engines.variational import SIDES, derivative
from astroinertia.errors import SceneError
from astroinertia.scene import load, source
from astroinertia.scene.changed import with_settings
from astroinertia.scene.schema import Scene
from astroinertia.scene.sweep import Sweep, loads
from astroinertia.scene.sweep_values import scaled, value_text
from astroinertia.sweeps.combined import variable_name
from astroinertia.units import shown, unit_of

STEP = 0.01


def sensitivity_sweep(
    scene: Scene | dict[str, Any] | str | PathLike[str], by: Sequence[str], step: float = STEP
) -> Sweep:
    """The sweep that tells how a scene answers to keys such as "body.rotation.period": four runs a key, and its own.

    Member 0 is the scene as it is, without error bars; those of a key follow, in the order of variational.SIDES.

    step: relative, above 0 and at most 0.5. SceneError for a key that the scene does not set, or that is no number or
    quantity other than 0, and for a step with which a member is no valid scene.

    >>> sweep = sensitivity_sweep("sims/core_to_pulsar_scaling.toml", ["body.rotation.period"])
    >>> print(len(sweep.members), sweep.members[1][0], sweep.members[2][0])
    5 29.7 s 29.85 s
    """
    if not 0.0 < step <= 0.5:
        raise SceneError(f"the step must be above 0 and at most 0.5, not {step:g}.")
    if not by or len(set(by)) < len(by):
        raise SceneError("sensitivity needs keys of the scene to answer to, each once, such as body.rotation.period.")
    chosen = scene if isinstance(scene, Scene) else load.of(scene)
    if chosen.output.error_bars:  # of each run by itself, and not of what differs between runs
        chosen = with_settings(chosen, ["output.error_bars=false"])
    text = chosen.to_toml()
    tables = source.parse(text, chosen.name)
    base = {key: value_of(tables, key) for key in by}
    members = [base] + [base | {key: _moved(key, base[key], 1 + side * step)} for key in by for side in SIDES]
    rows = (", ".join(f'"{key}" = {value_text(value)}' for key, value in member.items()) for member in members)
    listed = ",\n".join(f"    {{{row}}}" for row in rows)
    text = f"{text}\n[sweep]\nmembers = [\n{listed},\n]\n"
    sweep = loads(text, origin=chosen.origin, name=chosen.name, own=chosen.own_classes)
    assert sweep is not None
    return sweep


def sensitivity(data: xr.Dataset) -> xr.Dataset:
    """Derivatives by the logarithm of each parameter, dX/d ln p, from the result of a `sensitivity_sweep`.

    Every series X (member, time, ...) of the result becomes X (parameter, time, ...) in its own units, and X_error its
    estimated error; `value` (parameter,) is each parameter in the scene. d ln X/d ln p follows by
    `data.isel(member=0)`. SceneError for another dataset. Error: of order step^4 where runs are smooth in the
    parameter.

    >>> import astroinertia, pathlib, tempfile
    >>> from astroinertia.sweeps.ensemble import run_sweep
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sweep = sensitivity_sweep("sims/core_to_pulsar_scaling.toml", ["body.rotation.period"])
    ...     data = astroinertia.open(run_sweep(sweep, pathlib.Path(folder)).file).load()
    >>> answer, spin = sensitivity(data).angular_velocity, data.angular_velocity.isel(member=0)
    >>> print((answer / spin).isel(time=-1).sel(i="z").values.round(6))  # as 1/period
    [-1.]
    """
    keys = [key.strip() for key in str(data.attrs.get("sweep_parameters", "")).split(",") if key.strip()]
    names = [variable_name(key) for key in keys]
    if data.sizes.get("member") != 1 + len(SIDES) * len(keys) or any(name not in data.coords for name in names):
        raise SceneError(
            "sensitivity needs the result of a sensitivity sweep, with four members a key and the scene's own."
        )
    numbers = [
        name
        for name, variable in data.items()
        if {"member", "time"} <= set(variable.dims) and variable.dtype.kind == "f"
    ]
    answers = []
    for place, name in enumerate(names):
        members = data.isel(member=slice(1 + len(SIDES) * place, 1 + len(SIDES) * (place + 1)))
        base = float(data[name].values[0])
        steps = members[name].values / base - 1
        if not np.allclose(steps / steps[-1], SIDES, atol=1e-6):
            raise SceneError(f"the members of {keys[place]} are not those of a sensitivity sweep.")
        answers.append(_derivative(members[numbers], float(steps[-1])))
    result = xr.concat(answers, xr.Variable("parameter", keys, {"long_name": "key of the scene"}))
    values = [float(data[name].values[0]) for name in names]
    units = [unit_of(data[name]) for name in names]
    result = result.assign_coords(value=("parameter", values), value_units=("parameter", units))
    for name in numbers:
        text = data[name].attrs.get("long_name", name)
        result[name].attrs = {
            **data[name].attrs,
            "long_name": f"derivative of {text} by the logarithm of the parameter",
        }
        result[f"{name}_error"].attrs = {"units": unit_of(data[name]), "long_name": f"error of {name}"}
    return result


def value_of(tables: dict[str, Any], key: str) -> Any:
    """What the tables of a scene set a key to; SceneError where they do not.

    >>> print(value_of({"companions": [{"mass": "1 Msun"}]}, "companions.0.mass"))
    1 Msun
    """
    here: Any = tables
    parts = key.split(".")
    for place, part in enumerate(parts):
        if isinstance(here, list):  # its entries are numbered, as --set has them
            here = {str(number): item for number, item in enumerate(here)}
        if not isinstance(here, dict) or part not in here:
            near = difflib.get_close_matches(part[:64], here, n=1, cutoff=0.75) if isinstance(here, dict) else []
            meant = ".".join([*parts[:place], *near, *parts[place + 1 :]])
            hint = f"did you mean '{shown(meant)}'?" if near else "set it, so that it can be moved."
            raise SceneError(f"'{shown(key)}' is not set in the scene; {hint}")
        here = here[part]
    return here


def _moved(key: str, value: Any, factor: float) -> Any:
    try:
        return scaled(value, factor)
    except SceneError as error:
        raise SceneError(f"'{shown(key)}' {error}") from None


def _derivative(members: xr.Dataset, step: float) -> xr.Dataset:
    """The fourth-order derivative of four members, at -h, -h/2, h/2 and h, and its distance from that of h/2."""
    best, error = derivative([members.isel(member=place, drop=True) for place in range(len(SIDES))], step)
    return best.merge(error.rename({name: f"{name}_error" for name in error.data_vars}))
