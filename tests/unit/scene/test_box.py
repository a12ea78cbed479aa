"""A scene in a periodic box: what it may hold, and what a run in it keeps."""

import subprocess
import sys

import numpy as np
import pytest

from astroinertia.build import sph as start_sph
from astroinertia.build.assemble import model_description, prepare
from astroinertia.errors import SceneError
from astroinertia.models.checkpoint import flattened
from astroinertia.models.sph.evolution import Particles
from astroinertia.scene import load
from astroinertia.scene.plan import plan

pytestmark = pytest.mark.usefixtures("steps_differ")

SCENE = """
name = "box"
units = "code"
[body]
kind = "standard"
problem = "sod"
particles = 400
[equation_of_state]
kind = "ideal"
[box]
lengths = [2.0, 0.5, 0.5]
[effects.pressure]
[effects.viscosity]
[effects.conduction]
[time]
end = 0.2
"""


def started(*settings: str) -> Particles:
    body = prepare(load.loads(SCENE, settings)).evolution
    assert isinstance(body, Particles)
    return body


@pytest.mark.slow
@pytest.mark.parametrize("steps", ["global", "individual"])
def test_a_run_in_a_box_keeps_momentum_energy_and_ledger(steps: str) -> None:
    """A tube that moves along all axes, and leaves its box meanwhile: all is kept to round-off, energy to 1 %."""
    body = started(f"numerics.timesteps={steps}", "body.velocity=[30.0, 8.0, -12.0]")
    first = body.record(None)
    while body.time < 0.025 * (1 - 1e-12):
        body.advance(0.025)
    last = body.record(first["potential_energy"])
    size = float(body.state.mass @ np.linalg.norm(body.state.velocity, axis=1))
    assert np.abs(last["momentum"] - first["momentum"]).max() <= 1e-13 * size
    assert last["ledger_closure"] <= 1e-13
    thermal = first["internal_energy"]
    lost = last["total_energy"] - first["total_energy"]
    assert abs(lost) <= 0.01 * thermal
    assert abs(lost - last["integration_energy_error"]) <= 1e-12 * first["total_energy"]
    assert np.ptp(body.state.position[:, 0]) < 2.5  # it went on as one
    assert body.state.position[:, 0].mean() == pytest.approx(0.75, abs=1e-9)
    assert np.isnan(last["virial_tensor"]).all()
    assert "no place of its own" in model_description(body)["absent"]["virial_tensor"]


@pytest.mark.full
def test_where_the_box_begins_changes_nothing() -> None:
    """The same particles half a box further on: the same flow, to round-off."""
    # Switch and reconstruction ask for signs of div v and v_r, which are those of round-off where nothing moves yet.
    plain = ("effects.viscosity.switch=none", "effects.viscosity.limiter=balsara")
    exact = ("numerics.smoothing_tolerance=1e-14", *plain)
    one, other = started(*exact), started(*exact, "body.position=[1.0, 0.25, 0.1]")
    for body in (one, other):
        for _ in range(6):
            body.advance(body.end)
    for name, tolerance in (("velocity", 1e-11), ("smoothing_length", 1e-12)):
        mine, theirs = (getattr(body.state, name)[np.argsort(body.state.identity)] for body in (one, other))
        assert mine == pytest.approx(theirs, abs=tolerance, rel=1e-9)


@pytest.mark.slow
def test_a_box_goes_on_from_a_checkpoint_bit_for_bit() -> None:
    scene = load.loads(SCENE)
    body = started()
    for _ in range(16):
        body.advance(body.end)
    assert body.resumable
    other = start_sph.resumed(scene, prepare(scene).units, body.arrays())
    for each in (body, other):
        for _ in range(5):
            each.advance(each.end)
    mine, theirs = flattened(body.state), flattened(other.state)
    assert all(np.array_equal(mine[name], theirs[name]) for name in mine)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("effects.gravity.method=direct", "[effects.gravity] cannot act in a periodic box, where only neighbours do"),
        ("numerics.engine=xla", "[box] needs the engine numba_cpu"),
        ("box.periodic=xq", "[box] periodic"),
        ("box.periodic=xy", "the problem sod fills a box that is periodic along all axes"),
        ("body.problem=noh", "the problem noh ends by itself and has no box"),
        ("body.entropy=1.0", "has entropy, but a standard problem has a state of its own"),
        ("body.kind=uniform", "[body]"),
    ],
)
def test_what_cannot_be_in_a_box_is_refused_in_a_sentence(change: str, message: str) -> None:
    with pytest.raises(SceneError) as refused:
        load.loads(SCENE, (change,))
    assert message in str(refused.value), refused.value


def test_an_explosion_that_is_empty_inside_is_refused() -> None:
    """Of gamma 7 and more there is no such flow, and just below it none that quadrature resolves."""
    explosion = ("body.problem=sedov", "box.lengths=[1.0, 1.0, 1.0]")
    for gamma in (7.0, 8.0):
        with pytest.raises(SceneError, match=rf"sedov must be at most 6\.8, not {gamma:g}: from 7 on"):
            load.loads(SCENE, (*explosion, f"equation_of_state.gamma={gamma}"))
    load.loads(SCENE, (*explosion, "equation_of_state.gamma=6.8"))
    load.loads(SCENE, ("equation_of_state.gamma=8.0",))


def test_the_plan_tells_of_the_box() -> None:
    assert "lengths: 2 x 0.5 x 0.5 (repeats itself along x, y, z)" in plan(load.loads(SCENE)).text()


@pytest.mark.slow
def test_a_scene_without_a_box_has_no_trace_of_one() -> None:
    """No module of boxes or of standard problems is imported; that of a box is, in this process at least."""
    program = (
        "import sys; from astroinertia.build.assemble import prepare; from astroinertia.scene import load; "
        "prepare(load.loads(sys.argv[1])); "
        "print([name for name in sys.modules if name.startswith('astroinertia.')])"
    )
    plain = SCENE.replace("[box]\nlengths = [2.0, 0.5, 0.5]\n", "")
    plain = plain.replace('"standard"\nproblem = "sod"', '"uniform"\nmass = 1.0\nradius = 1.0\nentropy = 1.0')
    done = subprocess.run([sys.executable, "-c", program, plain], capture_output=True, text=True, check=True)
    assert "'astroinertia.engines.numba_cpu'" in done.stdout
    started()
    for name in ("astroinertia.engines.periodic", "astroinertia.test_problems.matter"):
        assert name in sys.modules and f"'{name}'" not in done.stdout
    assert "'astroinertia.test_problems.noh'" not in done.stdout


@pytest.mark.parametrize("axes", ["yx", "xyzz", "", "w"])
def test_axes_that_are_none_are_refused_by_those_that_there_are(axes: str) -> None:
    with pytest.raises(SceneError, match=r"periodic: .*(did you mean '[xyz]+'|one of xyz, xy, xz, yz, x, y, z)"):
        load.loads(SCENE, [f'box.periodic="{axes}"'])
