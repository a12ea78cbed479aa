"""A sweep of a scaling law, whose members take no time."""

from astroinertia.scene import sweep as sweeps

SCENE = """\
name = "core"
model = "scaling"
[sweep]
{sweep}
[body]
kind = "power_law"
exponent = 1.0
mass = "1.4 Msun"
radius = "1500 km"
[body.rotation]
period = "30 s"
[body.change]
times = ["0.2 s"]
factors = [0.5]
[effects.gravity]
[time]
end = "0.2 s"
[output]
series_every = "0.1 s"
checkpoint_seconds = 0.0
"""
GRID = '"body.mass" = ["1 Msun", "2 Msun"]\n"body.rotation.period" = ["10 s", "20 s"]'


def made(text=GRID, overrides=()):
    found = sweeps.loads(SCENE.replace("{sweep}", text), overrides)
    assert found is not None
    return found
