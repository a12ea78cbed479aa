"""The ledger of a region: what acts on its matter, what crosses its edge, and who belongs to it."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from astroinertia.errors import SceneError
from astroinertia.inertia.tensor import inertia_tensor
from astroinertia.ledger import regions as region_ledger
from astroinertia.ledger.moments import Ledgers, after_drift, after_kick, moments, open_ledger, whole
from astroinertia.models.sph import membership
from astroinertia.scene import load
from astroinertia.scene.plan import plan

SCENE = """
name = "parts"
[body]
kind = "uniform"
mass = "1 Msun"
radius = "1000 km"
particles = 100
[equation_of_state]
kind = "ideal"
[effects.gravity]
[regions.core]
innermost_mass = "0.5 Msun"
[regions.dense]
density_above = "1e9 g/cm3"
[regions.remnant]
bound = true
internal_energy = true
[time]
end = "1 s"
"""


def cloud(count=60, seed=5):
    random = np.random.default_rng(seed)
    mass = random.uniform(0.5, 1.5, count) / count
    return mass, random.normal(size=(count, 3)) + [2.0, 0.0, -1.0], random.normal(size=(count, 3)) + [0.1, 0.4, 0.0]


def test_the_ledger_of_a_region_closes_while_its_members_change():
    """300 kicks and drifts, a membership drawn again every third: evolved moments are those of the members."""
    mass, position, velocity = cloud()
    random = np.random.default_rng(1)
    member = (random.random(60) < 0.5).astype(float)
    region = region_ledger.open_region_ledger(mass, position, velocity, member, 2)
    start = region_ledger.region_moments(mass, position, velocity, member)
    for step in range(300):
        dt = random.uniform(0.001, 0.003)
        increments = [-dt * position, 0.2 * dt * random.normal(size=position.shape)]
        after = velocity + sum(increments)
        region = region.kicked(np, mass * member, position, velocity, after, increments)
        velocity = after
        position = position + dt * velocity
        region = region.drifted(np, dt)
        if step % 3 == 0:
            new = (random.random(60) < random.uniform(0.1, 0.9)).astype(float)
            region = region.exchanged(mass, position, velocity, member, new)
            member = new
    second, mixed, kinetic = region_ledger.region_moments(mass, position, velocity, member)
    ledger = region.ledger
    assert np.abs(ledger.second_moment.total - second).max() < 1e-13 * float(ledger.largest_inertia)
    assert np.abs(ledger.mixed_moment.total - mixed).max() < 1e-12 * np.abs(mixed).max()
    assert np.abs(ledger.kinetic_tensor.total - kinetic).max() < 1e-12 * np.abs(kinetic).max()

    # Free motion leaves L alone: its change is what effects did and what crossed the edge, and not the one without the
    # other.
    def axial(tensor):
        return tensor - tensor.T

    turned = axial(mixed - start[1])
    by_effects = axial(ledger.mixed_impulse.total.sum(axis=0))
    crossed = axial(region.flux.mixed_moment)
    size = np.abs(turned).max()
    assert np.abs(turned - by_effects - crossed).max() < 1e-12 * size
    assert np.abs(turned - by_effects).max() > 0.1 * size


def test_the_ledgers_close_where_some_particles_are_kicked_and_places_are_rounded():
    """As with individual steps: a body and a part of it, that move, kicked by two effects in parts and in turn."""
    mass, position, velocity = cloud()
    random = np.random.default_rng(3)
    member = (random.random(60) < 0.5).astype(float)
    region = region_ledger.open_region_ledger(mass, position, velocity, member, 2)
    ledgers = Ledgers(open_ledger(np, mass, position, velocity, 2), {"part": region})
    parts = {"body": mass, "part": mass * member}
    energy = {name: 0.5 * (m @ (velocity**2).sum(axis=1)) for name, m in parts.items()}
    sizes = {name: [] for name in parts}
    for dt in (0.4, -0.4, 0.2):  # the second time is that of the largest tensor
        active = random.random(60) < 0.5
        increments = [random.normal(size=(active.sum(), 3)), -3.0 * position[active]]
        before, about = velocity[active], whole(np, mass, position, velocity)
        after = before + 0.1 * sum(increments)
        kicked = mass[active], {"part": member[active]}, position[active], before, after, increments, 0.1, about
        velocity[active] = after
        position = position + dt * velocity
        ledgers = ledgers.kicked(np, *kicked).drifted(np, dt).heated(np.array([0.0, dt]))
        for name, m in parts.items():
            sizes[name].append(np.linalg.norm(inertia_tensor(m, position)))
    moved = position + 1e-9 * random.normal(size=position.shape)
    after = whole(np, mass, moved, velocity)
    for part in (active, ~active):
        rounded = mass[part], {"part": member[part]}, position[part], moved[part], velocity[part], 0.0, after
        ledgers = ledgers.rounded(np, *rounded)
    before, moved = moved, moved + 0.1 * velocity + 1e-9 * random.normal(size=position.shape)
    ledgers = ledgers.drifted(np, 0.1).rounded(np, mass, {"part": member}, before, moved, velocity, 0.1, None)
    found = {"body": ledgers.body, "part": ledgers.regions["part"].ledger}
    for name, m in parts.items():
        direct = region_ledger.region_moments(m, moved, velocity, m > 0)
        ledger = found[name]
        for tensor, wanted in zip(
            (ledger.second_moment, ledger.mixed_moment, ledger.kinetic_tensor), direct, strict=True
        ):
            np.testing.assert_allclose(tensor.total, wanted, rtol=0, atol=2e-14 * np.abs(wanted).max())
        gain = 0.5 * (m @ (velocity**2).sum(axis=1)) - energy[name]
        assert ledger.work.total.sum() == pytest.approx(gain, rel=1e-12)
        started = np.linalg.norm(inertia_tensor(m, cloud()[1]))
        assert ledger.largest_inertia == pytest.approx(max(sizes[name]), rel=1e-13)
        assert np.argmax(sizes[name]) == 1 and max(sizes[name]) > started
    assert ledgers.body.heating.total == pytest.approx([0.0, 0.2])


def test_what_crosses_an_edge_is_the_difference_of_the_moments():
    """The flux, from those that enter and leave alone, against direct sums over all members before and after."""
    mass, position, velocity = cloud()
    random = np.random.default_rng(2)
    old, new = ((random.random(60) < share).astype(float) for share in (0.6, 0.5))
    region = region_ledger.open_region_ledger(mass, position, velocity, old, 1)
    found = region_ledger.crossing(region.whole, mass, position, velocity, new - old)
    before, after = (region_ledger.region_moments(mass, position, velocity, member) for member in (old, new))
    for flux, one, other in zip(
        (found.second_moment, found.mixed_moment, found.kinetic_tensor), before, after, strict=True
    ):
        assert np.allclose(flux, other - one, rtol=0, atol=1e-14)
    assert found.mass == pytest.approx(mass @ (new - old), abs=1e-15)


def test_a_region_may_be_empty_and_fill_again():
    mass, position, velocity = cloud()
    nobody, everybody = np.zeros(60), np.ones(60)
    region = region_ledger.open_region_ledger(mass, position, velocity, nobody, 1)
    pull = -0.1 * position
    region = region.kicked(np, mass * nobody, position, velocity, velocity + pull, [pull]).drifted(np, 0.1)
    assert not np.any(region.ledger.second_moment.total)
    assert not np.any(region.ledger.largest_inertia)
    velocity = velocity + pull
    position = position + 0.1 * velocity
    region = region.exchanged(mass, position, velocity, nobody, everybody)
    assert np.allclose(region.ledger.mixed_moment.total, moments(mass, position, velocity)[1], rtol=0, atol=1e-14)
    size = np.linalg.norm(inertia_tensor(mass, position))
    assert region.ledger.largest_inertia == pytest.approx(size, rel=1e-14)
    here = region.whole.centre
    region = region.exchanged(mass, position, velocity, everybody, nobody)
    assert region.ledger.largest_inertia == pytest.approx(size, rel=1e-14)
    assert np.array_equal(region.whole.centre, here)  # where its matter was last
    assert np.abs(region.ledger.second_moment.total).max() < 1e-14
    assert region.whole.mass == 0.0 and region.flux.mass == pytest.approx(0.0, abs=1e-15)


def test_a_region_of_everything_is_the_body():
    mass, position, velocity = cloud()
    everybody = np.ones(60)
    region, ledger = (
        region_ledger.open_region_ledger(mass, position, velocity, everybody, 1),
        open_ledger(np, mass, position, velocity, 1),
    )
    increments = [0.03 * np.cos(position)]
    after = velocity + increments[0]
    region = region.kicked(np, mass, position, velocity, after, increments).drifted(np, 0.2)
    ledger = after_drift(np, after_kick(np, ledger, mass, position, velocity, after, increments), 0.2)
    for name in ("second_moment", "mixed_moment", "kinetic_tensor", "mixed_impulse"):
        assert np.allclose(getattr(region.ledger, name).total, getattr(ledger, name).total, rtol=0, atol=1e-14)


@pytest.mark.slow
def test_the_compiled_ledger_is_that_of_numpy():
    """What a step of the xla engine does to them: a kick and a drift, traced and compiled."""
    mass, position, velocity = cloud()
    member = (np.arange(60) % 3 > 0).astype(float)
    region = region_ledger.open_region_ledger(mass, position, velocity, member, 1)
    after = velocity + 0.03 * np.cos(position)

    def step(xp, region, position, before, after):
        return region.kicked(xp, mass * member, position, before, after, [after - before]).drifted(xp, 0.2)

    with jax.enable_x64(True):
        compiled = jax.jit(partial(step, jnp))(region, position, velocity, after)
    for one, two in zip(
        jax.tree.leaves(step(np, region, position, velocity, after)), jax.tree.leaves(compiled), strict=True
    ):
        assert np.allclose(one, two, rtol=0, atol=1e-13)


def test_the_innermost_mass_is_as_near_as_particles_allow():
    mass, position, _ = cloud()
    centre = np.array([2.0, 0.0, -1.0])
    member = membership.innermost(mass, position, centre, 0.4)
    assert abs(mass @ member - 0.4) <= 0.5 * mass.max()
    away = np.linalg.norm(position - centre, axis=1)
    assert away[member > 0].max() < away[member == 0].min()
    assert membership.innermost(mass, position, centre, 5.0).all()
    assert not membership.innermost(mass, position, centre, 1e-6).any()


def test_the_densest_point_is_the_middle_of_the_clump():
    random = np.random.default_rng(4)
    position = np.concatenate([random.normal(size=(900, 3)), [5.0, 1.0, 0.0] + 0.05 * random.normal(size=(100, 3))])
    density = np.exp(-0.5 * (position**2).sum(axis=1)) + 50 * np.exp(
        -0.5 * ((position - [5.0, 1.0, 0.0]) ** 2).sum(axis=1) / 0.05**2
    )
    found = membership.densest_point(np.ones(1000), position, density)
    assert np.linalg.norm(found - [5.0, 1.0, 0.0]) < 0.02


def test_what_is_bound_is_found_in_rounds():
    """A tight pair, a particle bound to the whole but not to the pair alone, and one that flies off."""
    mass = np.array([1.0, 1.0, 0.01, 5.0])
    position = np.array([[0.0, 0, 0], [1.0, 0, 0], [0.5, 3.0, 0], [0.5, 6.0, 0]])
    velocity = np.array([[0.0, 0.3, 0], [0.0, -0.3, 0], [1.5, 0, 0], [9.0, 0, 0]])

    def potential(chosen):
        apart = np.linalg.norm(position[chosen][:, None] - position[chosen][None], axis=-1)
        return -np.divide(mass[chosen][None], apart, out=np.zeros_like(apart), where=apart > 0).sum(axis=1)

    calls = []

    def counted(chosen):
        calls.append(len(chosen))
        return potential(chosen)

    member = membership.bound(mass, velocity, 0.0, counted, potential(np.arange(4)))
    assert member.tolist() == [1.0, 1.0, 0.0, 0.0]
    assert len(calls) >= 2
    hot = membership.bound(mass, velocity, np.array([0.0, 9.0, 0.0, 0.0]), potential, potential(np.arange(4)))
    assert hot[1] == 0.0


def test_scenes_name_their_regions_and_the_plan_tells_them():
    scene = load.loads(SCENE)
    assert scene.regions["core"].innermost_mass == pytest.approx(0.5 * 1.98841e30, rel=1e-4)
    assert scene.regions["dense"].density_above == pytest.approx(1e12)
    text = plan(scene).text()
    assert "core: the innermost 9.94205e+29 kg about the densest point" in text
    assert "remnant: what is bound to itself, internal energy counted" in text


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ('regions.core.innermost_mas = "1 kg"', "did you mean 'innermost_mass'"),
        ("regions.core.bound = true", "exactly one of innermost_mass, density_above and bound"),
        ('regions.core.innermost_mass = "1 km"', "[regions.core] innermost_mass"),
        ('regions.dense.centre = "densest"', "only innermost_mass uses"),
        ("regions.core.internal_energy = true", "only bound uses"),
        ('regions."no name".bound = true', "no name"),
        ('model = "ellipsoid"', "a part of a body of particles"),
    ],
)
def test_regions_that_make_no_sense_are_refused(change, message):
    with pytest.raises(SceneError) as refused:
        load.loads(SCENE, [change])
    assert message in str(refused.value)


def test_bound_needs_gravity():
    with pytest.raises(SceneError, match="bound needs gravity"):
        load.loads(SCENE.replace("[effects.gravity]", "[effects.pressure]"))
