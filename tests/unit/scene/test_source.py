"""Files that scenes name, and the text of scenes."""

import pytest

from astroinertia.build import assemble
from astroinertia.errors import SceneError
from astroinertia.scene.load import load_file, loads

FLUID = """\
name = "a"
[equation_of_state]
kind = "ideal"
gamma = 1.4
[effects.gravity]
[effects.pressure]
[time]
end = "1 s"
[body]
"""
TABLE = FLUID + 'kind = "table"\nfile = "~/particles.csv"\n'
UNITS = 'units = {mass = "1 Msun", length = "1 Rsun"}\n'
PROFILE = UNITS + FLUID + 'kind = "profile"\nfile = "~/star.csv"\nparticles = 500\n'
MATERIAL = """\
name = "a"
[equation_of_state]
kind = "materials"
materials = [{name = "matter", file = "~/rock.csv", reference_density = "3000 kg/m3"}]
[effects.gravity]
[effects.pressure]
[time]
end = "1 s"
[body]
kind = "uniform"
mass = "1e20 kg"
radius = "100 km"
particles = 500
"""
ORBITS = """\
name = "a"
model = "rigid"
[orbits]
archive = "~/orbits.bin"
[effects.gravity_gradient]
[time]
end = "1 d"
[body]
kind = "rigid"
mass = "1e20 kg"
radius = "100 km"
moment_ratios = [0.3, 0.35, 0.4]
rotation = {period = "1 d"}
"""


def test_a_particle_table_in_the_users_home_is_found(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "particles.csv").write_text("mass (kg),x (m),y (m),z (m)\n1,0,0,0\n1,1,0,0\n1,0,1,0\n1,0,0,1\n")
    (tmp_path / "star.toml").write_text(TABLE)
    scene = load_file("~/star.toml")
    assert scene.body.path(scene) == tmp_path / "particles.csv"
    assert scene.units.mass > 0.0  # of the file, which states them


@pytest.mark.parametrize(("text", "name"), [(PROFILE, "star.csv"), (MATERIAL, "rock.csv"), (ORBITS, "orbits.bin")])
def test_every_file_that_a_scene_names_is_looked_for_in_the_users_home(tmp_path, monkeypatch, text, name):
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / name).write_text("neither,of,these\n1,2,3\n")
    with pytest.raises(SceneError) as refused:
        assemble.prepare(loads(text, origin="/elsewhere"))
    assert name in str(refused.value)
    assert not any(absent in str(refused.value) for absent in ("there is no", "not there", "No such"))
