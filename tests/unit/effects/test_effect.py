"""What the parts of a user's own effect may give, and what is said of what they may not."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from astropy import units

from astroinertia.effects import Effect, pytree
from astroinertia.effects.own import EFFECTS
from astroinertia.errors import NumericalError, SceneError
from tests.unit.points import at


def made(**parts: Any) -> Any:
    """An effect with these parts."""
    return pytree(dataclass(frozen=True, eq=False)(type("Odd", (Effect,), {"kind": "odd", **parts})))()


def fluid_of(velocity: float = 0.0) -> SimpleNamespace:
    fluid = at([[1.0, 2.0, 3.0], [0.0, 1.0, 0.0]], velocity=np.full((2, 3), velocity), time=0.5)
    fluid.internal_energy = np.ones(2)
    return fluid


def test_lists_and_whole_numbers_are_arrays_of_numbers() -> None:
    down = made(acceleration=lambda self, xp, fluid: [[0, 0, -1]] * len(fluid.mass))
    found = down.acceleration(np, fluid_of())
    assert found.dtype == np.float64 and np.array_equal(found, [[0.0, 0.0, -1.0]] * 2)
    assert made(timestep=lambda self, xp, fluid: 1).timestep(np, fluid_of()) == 1
    turn = made(models=("rigid",), torque=lambda self, body: [0.0, body.time, 1])
    with jax.enable_x64(True):
        found = jax.jit(lambda time: turn.torque(SimpleNamespace(time=time)))(jnp.asarray(2.0))
        assert found.dtype == np.float64 and np.array_equal(found, [0.0, 2.0, 1.0])


@pytest.mark.parametrize(
    ("part", "given", "words"),
    [
        ("acceleration", lambda fluid: fluid.position * 1j, "an acceleration of complex128"),
        ("acceleration", lambda fluid: [["a", "b", "c"]] * 2, "an acceleration of str"),
        ("exchange", lambda fluid: (fluid.mass > 0.0, 0.0), "an exchange of bool"),
        ("timestep", lambda fluid: 1j, "a timestep of complex128"),
        ("acceleration", lambda fluid: fluid.position * units.Unit("m/s2"), "an acceleration of quantities in m / s2"),
        ("acceleration", lambda fluid: [[1.0, 2.0, 3.0], [1.0, 2.0]], "an acceleration of lists of different lengths"),
    ],
)
def test_what_is_no_real_number_is_refused(part: str, given: Any, words: str) -> None:
    odd = made(**{part: lambda self, xp, fluid: given(fluid)})
    with pytest.raises(SceneError, match=f"the effect 'odd' gave {words}.*, not of real numbers"):
        getattr(odd, part)(np, fluid_of())


@pytest.mark.parametrize(
    ("part", "given", "words"),
    [
        ("acceleration", lambda fluid: fluid.position / 0.0, "an acceleration"),
        ("exchange", lambda fluid: (np.nan * fluid.mass, 0.0), "an exchange"),
        ("exchange", lambda fluid: (0.0, np.inf), "an exchange"),
        ("timestep", lambda fluid: np.nan, "a timestep"),
    ],
)
def test_what_is_not_finite_is_said_of_the_effect_that_gave_it(part: str, given: Any, words: str) -> None:
    """And not of the effect that met with it, a step later; what the state has brought is not its own."""
    odd = made(**{part: lambda self, xp, fluid: given(fluid)})
    with np.errstate(all="ignore"):
        with pytest.raises(NumericalError, match=f"'odd' gave {words} that is not finite") as raised:
            getattr(odd, part)(np, fluid_of())
        assert (raised.value.effect, raised.value.time) == ("odd", 0.5)
        getattr(odd, part)(np, fluid_of(velocity=np.nan))
    assert np.isinf(made(timestep=lambda self, xp, fluid: np.inf).timestep(np, fluid_of()))


def test_a_class_without_a_part_is_refused_with_the_part_that_it_may_mean() -> None:
    """Such an effect would do nothing, without a word."""
    with pytest.raises(SceneError, match=r"Odd is no effect: it has none of the parts of an effect.*torque[.]$"):
        EFFECTS.entry_of(made())
    with pytest.raises(SceneError, match="accelerations is not among them; did you mean 'acceleration'"):
        EFFECTS.entry_of(made(accelerations=lambda self, xp, fluid: -fluid.position))
    assert EFFECTS.entry_of(made(timestep=lambda self, xp, fluid: 1.0)).made.kind == "odd"


def test_a_part_cannot_write_to_the_particles_of_the_run() -> None:
    """As `x = fluid.position; x -= ...` would; what it may return of them can be written to again."""

    def shifted(self, xp, fluid):
        x = fluid.position
        x -= 0.1
        return -x

    fluid = fluid_of()
    fluid.memory = {"age": np.zeros(2)}
    before = fluid.position.copy()
    with pytest.raises(SceneError, match=r"the part acceleration of the effect 'odd' failed .*read-only"):
        made(acceleration=shifted).acceleration(np, fluid)
    assert np.array_equal(fluid.position, before) and fluid.position.flags.writeable
    with pytest.raises(SceneError, match="read-only"):
        made(remember=lambda self, xp, fluid, span: fluid.memory["age"].sort()).remember(np, fluid, 0.0)
    assert made(acceleration=lambda self, xp, fluid: fluid.velocity).acceleration(np, fluid) is fluid.velocity
    flat = made(acceleration=lambda self, xp, fluid: np.broadcast_to([0.0, 0.0, 1.0], (2, 3)))
    assert flat.acceleration(np, fluid).flags.writeable
    fields = made(fields=lambda self, xp, fluid: {"x": fluid.position[:, 0], "mass": fluid.mass}).fields(np, fluid)
    assert fields["x"].flags.writeable and fields["mass"] is fluid.mass


def test_breaks_are_those_that_are_to_come() -> None:
    """A run would else stand still at a time that is past, or give an impulse at each of its steps."""
    switched = made(breaks=lambda self, start, end: [3, 1.0, 2.0])
    assert switched.breaks(0.0, 5.0) == (3.0, 1.0, 2.0)
    assert switched.breaks(1.0, 2.0) == (2.0,)
    for wrong in (1.0, [None], ["soon"], [np.nan]):
        with pytest.raises(SceneError, match="the effect 'odd' gave breaks that are no list of times"):
            made(breaks=lambda self, start, end, wrong=wrong: wrong).breaks(0.0, 1.0)
