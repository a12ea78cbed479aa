"""One file of the package is all that another effect, kind of body or of equation of state, or observable takes."""

import subprocess
import sys
from pathlib import Path

import pytest

from astroinertia.scene import kinds
from astroinertia.scene.initial_body import Body

PACKAGE = Path(kinds.__file__).parents[1]
CUSP = '''
"""Bodies with a cusp."""
from typing import Literal
from pydantic import Field
from astroinertia.scene.body_kinds.stretched import Sized, profiles
from astroinertia.scene.dimensional import Real

class CuspBody(Sized):
    """A cusp of the density."""
    kind: Literal["cusp"]
    steepness: Real = Field(default=1.0, description="how steep it is")
    def profile(self):
        return profiles().power_law(self.steepness)
'''
MONATOMIC = '''
"""Monatomic gases."""
from typing import Literal
from astroinertia.scene.fluids import Fluid

class MonatomicGas(Fluid):
    """P = A rho^(5/3)."""
    kind: Literal["monatomic"]
    @property
    def thermal_gamma(self):
        return 5 / 3
    def matter(self, units, constant):
        from astroinertia.matter import gases
        return gases.ideal(5 / 3)
'''
RESISTANCE = '''
"""Resistance of a medium at rest."""
from dataclasses import dataclass
from typing import Any
from astroinertia.effects import REQUIRED, Dimension, Effect, Entry, Measure, positive, pytree

@pytree
@dataclass(frozen=True, eq=False)
class Resistance(Effect):
    """a = -k v."""
    strength: Any
    kind = "resistance"
    external = True
    def affine_force(self, body):
        return -self.strength * body.second_moment * body.rate

ENTRY = Entry(
    "resistance of a medium at rest", {"strength": positive(Dimension(0, 0, -1), REQUIRED, "acceleration over speed")},
    "particles", "Newton 1687", ("ellipsoid",), made=Resistance,
    size=Measure("strength times run", "that", "", lambda body, options: (0.0, options["strength"] * body.end)),
)
'''
RUNS = """
import sys, astroinertia, numpy as np
import astroinertia.effects.kinds, astroinertia.scene.body_kinds, astroinertia.scene.fluid_kinds
astroinertia.effects.kinds.__path__.append(sys.argv[4])
astroinertia.scene.body_kinds.__path__.append(sys.argv[1])
astroinertia.scene.fluid_kinds.__path__.append(sys.argv[2])
from astroinertia.observables import quantities
quantities.RECORDED["elongation"] = quantities.Quantity(  # as if a line more stood there
    ("time",), None, "1", "logarithm of the largest second moment over the least",
    of=lambda body: np.ptp(np.log(np.linalg.eigvalsh(body.second_moment))),
)

SCENE = '''
name = "cusp"
model = "ellipsoid"
units = "code"
[body]
kind = "power_law"
exponent = 1.0
mass = 1.0
radius = 1.0
axes = [1.0, 1.0, 0.8]
pressure_fraction = 0.9
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[effects.damping]
time_scale = 2.0
frame = "inertial"
[time]
end = 0.5
[output]
series_every = 0.1
'''
OTHER = SCENE.replace('"power_law"\\nexponent = 1.0', '"cusp"').replace('"ideal"', '"monatomic"')
OTHER = OTHER.replace('damping]\\ntime_scale = 2.0\\nframe = "inertial"', "resistance]\\nstrength = 0.5")
from astroinertia.guide import effects_reference, scene_reference
assert "acceleration over speed" in effects_reference.text()
from astroinertia.scene import example, load, plan
assert 'kind = "cusp"' in scene_reference.text() and 'kind = "monatomic"' in scene_reference.text()
assert "kind cusp: how steep it is" in example.example_text()
lines = plan.plan(load.loads(OTHER)).text()
assert "cusp" in lines and "P = A rho^(5/3)" in lines and "strength times run" in lines, lines
try:
    load.loads(OTHER, ["body.kind='cups'"])
except astroinertia.errors.SceneError as error:
    assert "did you mean 'cusp'" in str(error), error
runs = []
for number, text in enumerate((SCENE, OTHER)):
    with astroinertia.open(astroinertia.run_scene(load.loads(text), f"{sys.argv[3]}/{number}")) as run:
        runs.append(run.load())
for name in ("inertia_tensor", "internal_energy"):
    one, other = (run[name].values for run in runs)
    assert np.allclose(one, other, rtol=1e-9), name
    assert not np.allclose(one[0], one[-1], rtol=1e-3), name
seen = np.linalg.eigvalsh(runs[1].second_moment.values)
assert np.allclose(runs[1].elongation, np.log(seen[:, -1] / seen[:, 0]), rtol=1e-12)
assert runs[1].elongation.long_name.startswith("logarithm of the largest")
print("both ran")
"""


@pytest.mark.full
def test_an_effect_a_body_an_equation_of_state_and_an_observable_are_one_file_each(tmp_path) -> None:
    for folder, text in (("bodies", CUSP), ("fluids", MONATOMIC), ("effects", RESISTANCE)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / ("resistance.py" if folder == "effects" else "another.py")).write_text(text)
    folders = (tmp_path / "bodies", tmp_path / "fluids", tmp_path, tmp_path / "effects")
    arguments = [sys.executable, "-c", RUNS, *map(str, folders)]
    done = subprocess.run(arguments, capture_output=True, text=True, cwd=PACKAGE.parent)
    assert done.stdout.endswith("both ran\n"), done.stderr


def test_kinds_come_in_the_order_of_their_rank_and_then_of_their_names() -> None:
    bodies = kinds.kinds_of("body_kinds", Body)
    assert list(bodies)[:3] == ["polytrope", "homologous_core", "uniform"]
    ranks = [made.rank for made in bodies.values()]
    assert ranks == sorted(set(ranks)) and len(bodies) == 11
