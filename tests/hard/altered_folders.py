"""Run folders that are stopped half-way, and the same ones altered by somebody who makes their hashes fit."""

import io
import json
import random
import shutil
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from astroinertia.accuracy.running import run_scene
from astroinertia.scene import load
from astroinertia.storage import manifest as manifests
from tests.hard.malformed_files import VALUES, _places, rehashed

GAS = '[equation_of_state]\nkind = "ideal"\n[effects.gravity]\n[effects.pressure]\n[effects.viscosity]\n'
ENDS = "[output]\nseries_steps = 1\ncheckpoint_seconds = 0.0\n"
BODY = """\
units = "code"
[body]
kind = "power_law"
exponent = 1.0
particles = 40
mass = 1.0
radius = 1.0
relax = false
specific_internal_energy = 0.05
[body.rotation]
rate = 0.2
"""
SCENES = {
    "global": f'name = "global"\n{BODY}{GAS}[time]\nend = 2.0\nmax_steps = LAST\n{ENDS}',
    "individual": f'name = "individual"\n{BODY}{GAS}[regions.inner]\ninnermost_mass = 0.5\n'
    f'[numerics]\ntimesteps = "individual"\n[time]\nend = 2.0\nmax_steps = LAST\n{ENDS}',
    "sinks": f'name = "sinks"\n{BODY.replace("0.05", "1e-4").replace("40", "150")}{GAS}'
    f"[effects.sinks]\ndensity = 3.0\nradius = 0.45\n[time]\nend = 2.0\nmax_steps = LAST\n{ENDS}",
    "companion": f'name = "companion"\n{BODY}{GAS}[effects.companions]\nmotion = "orbit"\n'
    '[[companions]]\nname = "moon"\nmass = 0.5\nsemi_major_axis = 5.0\n'
    f"[time]\nend = 2.0\nmax_steps = LAST\n{ENDS}",
    "ellipsoid": f'name = "ellipsoid"\nmodel = "ellipsoid"\n{BODY}{GAS.replace("[effects.viscosity]", "")}'
    f"[time]\nend = LAST\n{ENDS.replace('series_steps = 1', 'series_every = 2.0')}",
    "rigid": """\
name = "rigid"
model = "rigid"
units = "code"
[body]
kind = "rigid"
mass = 1.0
radius = 1.0
moment_ratios = [0.3, 0.32, 0.35]
rotation = { rate = 1.0, axis = [0, 1, 1] }
[[companions]]
name = "moon"
mass = 0.01
semi_major_axis = 5.0
[orbits]
back_reaction = true
[effects.gravity_gradient]
[numerics]
integrator = "splitting"
[time]
end = LAST
[output]
series_every = 2.0
checkpoint_seconds = 0.0
""",
    "scaling": f'name = "scaling"\nmodel = "scaling"\n{BODY}{GAS.replace("[effects.viscosity]", "")}'
    f"[time]\nend = LAST\n{ENDS.replace('series_steps = 1', 'series_every = 2.0')}",
}
HALF, WHOLE = "12", "20"  # steps of some, time of others
NUMBERS = (np.nan, np.inf, -np.inf, 0.0, -1.0, 1e308, -1e308, 1e90, 1e-308, 5e-324)
INTEGERS = (-1, 0, 1, 7, 2**31, 2**62, -(2**63))


def stopped_folders(folder: Path, names: tuple[str, ...] = tuple(SCENES)) -> dict[str, Path]:
    """Runs of each kind that have come to their middle: to the end of a scene that ends earlier, but for its file."""
    made = {}
    for name in names:
        place = made[name] = folder / name
        run_scene(load.loads(SCENES[name].replace("LAST", HALF)), place).unlink()
        content = json.loads((place / manifests.MANIFEST).read_text())
        content["metadata"]["scene"] = load.loads(SCENES[name].replace("LAST", WHOLE)).to_toml()
        rehashed(place, content | {"final": None})
    return made


def altered_folders(whole: dict[str, Path], folder: Path, seed: int, count: int) -> Iterator[Path]:
    """So many altered folders, one after the other in the same place; the same ones for the same seed."""
    chance = random.Random(seed)
    names = list(whole)
    for number in range(count):
        path = folder / names[number % len(names)]
        if path.is_dir():
            shutil.rmtree(path)
        shutil.copytree(whole[path.name], path)
        content = json.loads((path / manifests.MANIFEST).read_text())
        alter = chance.choice((_state, _state, _state, _counters, _description, _scene, _output, _entries))
        alter(path, content, chance)
        yield path


def _state(path, content, chance):
    """Something else in the arrays of the last checkpoint; of both, since the one before stands in for it."""
    for entry in filter(None, content["checkpoints"]):
        _npz_changed(path / entry["file"], random.Random(chance.randrange(2**32)), lambda name: name.endswith(".npy"))
    rehashed(path)


def _counters(path, content, chance):
    for entry in filter(None, content["checkpoints"]):
        _npz_changed(path / entry["file"], chance, lambda name: not name.endswith(".npy"))
    rehashed(path)


def _output(path, content, chance):
    _npz_changed(path / chance.choice(content["segments"])["file"], chance, lambda name: name.endswith(".npy"))
    rehashed(path)


def _description(path, content, chance):
    _value_changed(content["metadata"], chance)
    rehashed(path, content)


def _entries(path, content, chance):
    _value_changed({name: content[name] for name in ("segments", "checkpoints")}, chance)
    rehashed(path, content)


def _scene(path, content, chance):
    """Another scene for the same state: a number is another one, or a line is gone."""
    lines = content["metadata"]["scene"].splitlines()
    number = chance.randrange(len(lines))
    if chance.random() < 0.3:
        del lines[number]
    else:
        key, sign, _ = lines[number].partition("=")
        values = ("0", "1", "-1", "1e99", "1e-99", "17", '"x"', "[]", "true", "0.3", "64")
        lines[number] = f"{key}{sign} {chance.choice(values)}" if sign else lines[number].replace("effects", "output")
    content["metadata"]["scene"] = "\n".join(lines)
    rehashed(path, content)


def _value_changed(content, chance):
    place, key = chance.choice(list(_places(content)))
    if chance.random() < 0.2:
        del place[key]
    else:
        place[key] = chance.choice(VALUES)


def _npz_changed(path, chance, is_meant):
    with zipfile.ZipFile(path) as bundle:
        members = {entry.filename: bundle.read(entry) for entry in bundle.infolist()}
    name = chance.choice([each for each in members if is_meant(each)])
    if name.endswith(".npy"):
        other = _other_array(np.load(io.BytesIO(members[name])), members, chance)
        if other is None:
            del members[name]
        else:
            stream = io.BytesIO()
            np.lib.format.write_array(stream, np.ascontiguousarray(other) if other.ndim else other)
            members[name] = stream.getvalue()
    else:
        content = json.loads(members[name])
        _value_changed(content, chance)
        members[name] = json.dumps(content).encode()
    with zipfile.ZipFile(path, "w") as bundle:
        for each, data in members.items():
            bundle.writestr(each, data)


def _other_array(array, members, chance):
    """An array of another type, shape or sign, or with other numbers in it; None where it is to be left out."""
    kind = chance.choice(("type", "shape", "number", "number", "number", "all", "sign", "swapped", "gone"))
    if kind == "type":
        kinds = ("f4", "i4", "u1", "c16", "bool", "U5", "S3", "M8[s]", ">f8", "i8", "f8")
        return np.zeros(array.shape, chance.choice(kinds))
    if kind == "shape":
        shapes = ((), (0,), (3,), (1, *array.shape), array.shape[::-1], (*array.shape, 3), (100, 3), (2, 2, 2, 2))
        return np.resize(array, chance.choice(shapes)) if array.size else np.ones(3, array.dtype)
    if kind == "swapped":
        other = chance.choice([each for each in members if each.endswith(".npy")])
        return np.load(io.BytesIO(members[other]))
    if kind == "gone" or array.dtype.kind not in "fiu":
        return None
    if kind == "sign":
        return -array
    values = NUMBERS if array.dtype.kind == "f" else INTEGERS
    made = np.array(array)
    value = np.array(chance.choice(values)).astype(array.dtype)
    if kind == "all" or not made.ndim or not made.size:
        made[...] = value
    else:
        made.reshape(-1)[chance.randrange(made.size)] = value
    return made
