"""Bodies that cannot be are refused by `plan`, and by a run before it does anything, with the limit."""

import jax
import pytest
import rebound

import astroinertia
from astroinertia.accuracy import choice
from astroinertia.bodies.break_up import polytropic_limit
from astroinertia.build import refusals
from astroinertia.build.assemble import prepare
from astroinertia.cli.main import main
from astroinertia.errors import ArchiveError, NumericalError, SceneError
from astroinertia.run import loop
from astroinertia.scene.load import load_file, loads
from tests.sims import SIMS

SCENE = """name = "fast"
model = "sph"
{units}[body]
{body}
[equation_of_state]
kind = "ideal"
[effects.gravity]
[effects.pressure]
[time]
end = 1.0
"""
POLYTROPE = 'kind = "polytrope"\nindex = 1.5\nparticles = 100\nmass = 1.0\nradius = 1.0\n[body.rotation]\n'
STAR = 'kind = "rotating_star"\nindex = 1.5\nparticles = 100\nmass = 1.0\nradius = 1.0\n'


def scene(body: str, units: str = 'units = "code"\n'):
    return loads(SCENE.format(body=body, units=units))


@pytest.fixture
def nothing_is_prepared(monkeypatch):
    def prepared(*_):
        raise AssertionError("the body was prepared")

    monkeypatch.setattr(loop, "prepare", prepared)
    monkeypatch.setattr(choice, "choose", prepared)


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (STAR + "axis_ratio = 0.5", "mass shedding.*least axis_ratio is 0.6151"),
        (
            STAR + "t_over_w = 0.2",
            r"\[body\] t_over_w of 0.2: .*mass shedding.*the most t_over_w is 0.05947, at axis ratio 0.6151",
        ),
        (
            STAR.replace("mass = 1.0", "mass = 2.0") + "rate = 1.6",
            r"\[body\] rate of 1.6: .*the most rate is 1.445, at",
        ),
        (
            STAR.replace("mass = 1.0", "mass = 4.0") + "period = 3.0",
            r"\[body\] period of 3: .*the least period is 3.074, at",
        ),
        (STAR + "rate = -0.05", r"\[body\] rate must not be negative, for a rotating_star turns about z"),
        (STAR + "angular_momentum = 9.0", r"\[body\] angular_momentum of 9: .*the most angular_momentum is 0.1349"),
        (POLYTROPE + "period = 11.0", r"1.08 times as fast .* at least 11.88, .*index 1.5 sheds mass"),
        (POLYTROPE + "rate = -0.6", "1.13 times as fast"),
        (POLYTROPE + "angular_momentum = 0.2", "angular_momentum is 1.19 times .* at most 0.168"),
        (POLYTROPE + "t_over_w = 0.1", "t_over_w is 1.68 times .* at most 0.05947"),
        (POLYTROPE.replace("1.5", "3.5") + "rate = 1.2", "1.2 times as fast .* an orbit at its equator"),
    ],
)
def test_a_body_beyond_break_up_is_refused_with_its_limit_before_anything(body, words, tmp_path, nothing_is_prepared):
    with pytest.raises(SceneError, match=words) as refused:
        astroinertia.run_scene(scene(body), tmp_path / "run")
    assert str(refused.value).count(". ") == 0
    assert not (tmp_path / "run").exists()


def test_what_can_be_is_not_refused_and_takes_no_figures_of_stars(monkeypatch) -> None:
    for body in (POLYTROPE + "rate = 0.5", POLYTROPE + "t_over_w = 0.05", POLYTROPE + "angular_momentum = 0.16"):
        monkeypatch.setattr("astroinertia.bodies.break_up.polytropic_limit", None)
        refusals.refuse_impossible(scene(body))
    # Without settling it may fly apart: that is what was wanted.
    refusals.refuse_impossible(scene(POLYTROPE.replace("[body.rot", "relax = false\n[body.rot") + "rate = 2.0"))


CORE = """name = "core"
body = {kind = "polytrope", index = 3, mass = "1.5 Msun", radius = "1500 km", particles = 100}
effects = {gravity = {}, pressure = {}}
time.end = "0.1 s"
"""


@pytest.mark.parametrize(
    ("matter", "refused"),
    [
        ('kind = "hybrid", gamma_1 = 1.28, nuclear_density = "2e14 g/cm3"', r"gamma_1 of 1.28 .*set gamma_1 = \"4/3\""),
        ('kind = "polytropic", gamma = 1.3', r"gamma of 1.3 stands for electrons .*\[effects.deleptonisation\]"),
        ('kind = "hybrid", gamma_1 = "4/3", nuclear_density = "2e14 g/cm3"', ""),
        ('kind = "hybrid", gamma_1 = 1.333, nuclear_density = "2e14 g/cm3"', ""),
        ('kind = "ideal", gamma = 1.3', ""),
    ],
)
def test_electrons_are_not_lost_twice(matter, refused) -> None:
    core = CORE + f"equation_of_state = {{{matter}}}\n"
    refusals.refuse_impossible(loads(core))
    losing = loads(core, ["effects.deleptonisation.fit='G15'"])
    if not refused:
        refusals.refuse_impossible(losing)
    else:
        with pytest.raises(SceneError, match=refused) as caught:
            refusals.refuse_impossible(losing)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("material", "fraction", "refused"),
    [
        ('file = "t.h5", reference_density = "1e10 g/cm3", electron_fraction = 0.42', 0.4971, "material hot has 0.42"),
        ('file = "t.h5", reference_density = "1e10 g/cm3", electron_fraction = 0.42', 0.42, ""),
        ('tillotson = "iron"', 0.4971, "material hot states none: both must be the same"),
    ],
)
def test_electrons_are_taken_from_matter_that_has_them(material, fraction, refused) -> None:
    core = CORE + f'equation_of_state = {{kind = "materials", materials = [{{name = "hot", {material}}}]}}\n'
    losing = loads(core, [f"effects.deleptonisation.electron_fraction={fraction}"])
    if not refused:
        refusals._refuse_lost_twice(losing)
    else:
        with pytest.raises(SceneError, match=refused):
            refusals.refuse_impossible(losing)


@pytest.mark.parametrize(
    ("fluid", "heat", "refused"),
    [
        ('kind="isothermal", sound_speed=0.3', "specific_internal_energy=0.5", "kind isothermal follows from the dens"),
        ('kind="polytropic", gamma=2', "specific_internal_energy=0.5", "the kind polytropic follows from the density"),
        ('kind="piecewise_polytropic", densities=[1.0], gammas=[2, 3]', "specific_internal_energy=0.5", "be warm"),
        ('kind="isothermal", sound_speed=0.3', "pressure_fraction=0.5", r"\] sound_speed gives the pressure"),
        ('kind="polytropic", gamma=2, constant=0.2', "pressure_fraction=0.5", r"\] constant gives the pressure"),
        ('kind="polytropic", gamma=2', "pressure_fraction=0.5", ""),
        ('kind="hybrid", nuclear_density=9.0', "specific_internal_energy=0.5", ""),
    ],
)
def test_heat_that_would_not_count_is_refused(fluid, heat, refused) -> None:
    asked = [f"equation_of_state={{{fluid}}}", f"body.{heat}"]
    whole = SCENE.format(body=POLYTROPE + "rate = 0.1", units='units = "code"\n')
    if not refused:
        refusals.refuse_impossible(loads(whole, asked))
    else:
        with pytest.raises(SceneError, match=refused):
            loads(whole, asked)


def test_what_counts_as_surely_held_is_below_the_limit() -> None:
    limit = polytropic_limit(1.5)
    held = dict(refusals._SURELY_HELD)[1.5]
    for most, exact in zip(held, (limit.rate, limit.angular_momentum, limit.rotational_to_gravitational), strict=True):
        assert exact * 0.99 < most < exact


def test_a_gas_without_heat_that_nothing_holds_is_refused_first() -> None:
    free = SCENE.format(body=POLYTROPE + "rate = 0.1", units='units = "code"\n').replace("[effects.gravity]\n", "")
    with pytest.raises(SceneError, match="without gravity there is no equilibrium to take it from"):
        refusals.refuse_impossible(loads(free))
    refusals.refuse_impossible(loads(free, ["body.entropy=0.3"]))
    refusals.refuse_impossible(
        loads(free.replace("[effects.pressure]\n", "[effects.shear_viscosity]\nkinematic_viscosity = 1.0\n"))
    )


def test_matter_beyond_all_numbers_is_refused_in_words() -> None:
    thin = 'kind = "polytrope"\nindex = 0\nmass = 0.2\nradius = 4e18\nparticles = 84'
    steep = 'kind = "hybrid"\ngamma_1 = 8.669\ngamma_2 = 9.3\nnuclear_density = 2e-4'
    text = SCENE.format(body=thin, units='units = "code"\n').replace('kind = "ideal"', steep)
    with pytest.raises(SceneError, match="in units of the body: its numbers lead beyond the largest that there are"):
        refusals.refuse_impossible(loads(text))


@pytest.mark.parametrize(("particles", "enough"), [((64,), False), ((65,), True), ((40, 20), False), ((30, 40), True)])
def test_particles_too_few_for_their_kernel_are_refused_exactly_where_a_run_would_fail(particles, enough) -> None:
    """With eta = 3 a particle needs 64.6 times its own mass around it, of all bodies together."""
    star = 'kind = "polytrope", index = 1.5, relax = false, radius = 1.0'
    bodies = [
        f"{{{star}, particles = {number}, mass = {number}.0, position = [{place}.0, 0.0, 0.0]}}"
        for place, number in enumerate(particles)
    ]
    listed = f"bodies = [{', '.join(bodies)}]" if len(bodies) > 1 else f"body = {bodies[0]}"
    matter = 'equation_of_state = {kind = "ideal"}\neffects = {gravity = {}, pressure = {}}\n'
    few = loads(f'name = "few"\nunits = "code"\n{listed}\n{matter}numerics = {{eta = 3.0}}\ntime.end = 1.0\n')
    if enough:
        refusals.refuse_impossible(few)
        prepare(few)
    else:
        with pytest.raises(SceneError, match=r"too few: with eta = 3 there must be more than 64\.6 times"):
            refusals.refuse_impossible(few)
        with pytest.raises(NumericalError, match="no smoothing length is long enough"):
            prepare(few)


def test_a_layer_hotter_than_the_table_of_its_material_is_refused() -> None:
    planet = load_file(SIMS / "rocky_planet.toml", ["body.layers.1.isentrope=0.9e9 J/kg"])
    refusals.refuse_impossible(planet)
    hot = load_file(SIMS / "rocky_planet.toml", ["body.layers.1.isentrope=1.1e9 J/kg"])
    with pytest.raises(SceneError, match=r"layer of rock has an isentrope of 1.1e\+09 .* reach to 1e\+09"):
        refusals.refuse_impossible(hot)


def test_a_share_of_the_energy_of_gravity_needs_gravity() -> None:
    turning = SCENE.format(body=POLYTROPE + "t_over_w = 0.01", units='units = "code"\n')
    refusals.refuse_impossible(loads(turning))
    with pytest.raises(SceneError, match="t_over_w needs a self-gravitating body"):
        refusals.refuse_impossible(loads(turning.replace("[effects.gravity]\n", ""), ["body.entropy=0.3"]))


def test_a_material_that_its_file_does_not_fit_is_refused_first(tmp_path) -> None:
    rows = "".join(f"{rho},{u},{0.4 * rho * u}\n" for rho in (1e3, 2e3, 4e3, 8e3) for u in (1e4, 1e5, 1e6, 1e7))
    (tmp_path / "t.csv").write_text("density,internal_energy,pressure\n" + rows)
    rock = CORE + 'equation_of_state = {kind = "materials", materials = [{name = "rock", file = "t.csv", %s}]}\n'
    refusals.refuse_impossible(loads(rock % 'reference_density = "2e3 kg/m3"', origin=str(tmp_path)))
    with pytest.raises(SceneError, match="the reference_density of rock is outside the densities of its file"):
        refusals.refuse_impossible(loads(rock % 'reference_density = "2 kg/m3"', origin=str(tmp_path)))
    thin = rock.replace("1500 km", "1e9 km") % 'reference_density = "2e3 kg/m3"'
    with pytest.raises(SceneError, match=r"too far below 1e\+03 kg m-3, where the table of its material ends"):
        refusals.refuse_impossible(loads(thin, origin=str(tmp_path)))


@pytest.mark.parametrize(
    ("matter", "radius", "refused"),
    [
        ('kind = "polytropic", gamma = 2', 1.5, 'constant = "from body" is not the same for all bodies'),
        ('kind = "polytropic", gamma = 2', 1.0, ""),
        ('kind = "polytropic", gamma = 2, constant = 0.3', 1.5, ""),
        (
            'kind = "piecewise_polytropic", densities = [1.0], gammas = [1.0000000000000002, 2]',
            1.0,
            "must be above 1, by",
        ),
    ],
)
def test_matter_that_bodies_cannot_share_is_refused_first(matter, radius, refused) -> None:
    star = 'kind = "polytrope", index = 1, mass = 1.0, particles = 100'
    bodies = f"bodies = [{{{star}, radius = 1.0}}, {{{star}, radius = {radius}, position = [9.0, 0.0, 0.0]}}]\n"
    text = f'name = "two"\nunits = "code"\n{bodies}equation_of_state = {{{matter}}}\n'
    two = loads(text + "effects = {gravity = {}, pressure = {}}\ntime.end = 1.0\n")
    if not refused:
        refusals.refuse_impossible(two)
    else:
        with pytest.raises(SceneError, match=refused):
            refusals.refuse_impossible(two)


def test_plan_refuses_in_one_sentence_and_knows_the_star_that_will_be(tmp_path, capsys) -> None:
    file = tmp_path / "star.toml"
    file.write_text(SCENE.format(body=STAR + "axis_ratio = 0.8", units='units = "code"\n'))
    assert main(["plan", str(file)]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["T/|W|", "0.0375"] in lines  # not 0.0587, of a Maclaurin spheroid
    assert main(["plan", str(file), "--set", "body.axis_ratio=0.5"]) == 2
    caught = capsys.readouterr()
    assert "mass shedding" in caught.err and caught.err.count("\n") == 1 and not caught.out


def test_a_table_without_heat_and_a_folder_that_is_taken_are_refused_first(tmp_path, nothing_is_prepared) -> None:
    table = "mass,x,y,z\n" + "".join(f"1,{k % 2},{k % 3},{k % 5}\n" for k in range(8))
    (tmp_path / "t.csv").write_text(table)
    file = tmp_path / "table.toml"
    file.write_text(SCENE.format(body='kind = "table"\nfile = "t.csv"', units='units = "code"\n'))
    with pytest.raises(SceneError, match="a table without a column u needs specific_internal_energy or entropy"):
        astroinertia.run_scene(file, tmp_path / "run")
    (tmp_path / "t.csv").write_text(table.replace("mass", "weight"))
    with pytest.raises(SceneError, match="mass"):
        refusals.refuse_impossible(load_file(file))
    taken = tmp_path / "taken"
    taken.mkdir()
    (taken / "fast.nc").write_text("of another run")
    wanted = SCENE.format(body=STAR + "axis_ratio = 0.5", units='units = "code"\naccuracy = 1e-2\n')
    with pytest.raises(ArchiveError, match="already holds a result"):
        astroinertia.run_scene(loads(wanted), taken)


TUMBLING = """name = "tumbling"
model = "rigid"
[body]
kind = "rigid"
mass = "1e15 kg"
{size}
[effects.gravity_gradient]
[time]
end = "1 h"
"""


MOON = """[[companions]]
name = "moon"
mass = "1e10 kg"
position = ["8 km", "6 km", "0 km"]
velocity = ["0 m/s", "0 m/s", "3 m/s"]
"""
ORBIT = """[[companions]]
name = "moon"
mass = "1e10 kg"
semi_major_axis = "{axis} km"
eccentricity = 0.9
mean_anomaly = "{anomaly} deg"
"""
COMES = r"companion moon comes within the body .* least distance from its centre is 3e\+04 m"
RATIOS = 'radius = "{} km"\nmoment_ratios = [0.3, 0.35, 0.4]'
MOMENTS = 'moments = ["{0} kg m2", "{0} kg m2", "{0} kg m2"]'  # without a radius, as of a homogeneous body
ARCHIVE = '[orbits]\narchive = "orbits.bin"\n'


@pytest.mark.parametrize(("size", "less", "more"), [(RATIOS, 9, 11), (MOMENTS, 3.24e22, 4.84e22)])
def test_a_companion_within_a_rigid_body_is_refused_before_anything(
    size, less, more, tmp_path, nothing_is_prepared
) -> None:
    stated = TUMBLING + MOON
    refusals.refuse_impossible(loads(stated.format(size=size.format(less))))
    with pytest.raises(SceneError, match=r"companion moon begins 1e\+04 m .*radius of the rigid body, 1.1e\+04 m"):
        astroinertia.run_scene(loads(stated.format(size=size.format(more))), tmp_path / "run")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("axis", "anomaly", "end", "refused"),
    [
        (300, 180, 4, ""),  # the period is 11 h
        (300, 180, 6, COMES),
        (300, 20, 8, ""),  # it has been there
        (300, 20, 11, COMES),
        (1200, 180, 200, ""),
    ],
)
def test_a_companion_that_comes_within_a_rigid_body_is_refused(axis, anomaly, end, refused) -> None:
    stated = TUMBLING.replace("1e15", "1e19").replace("1 h", f"{end} h").format(size=RATIOS.format(100))
    stated += ORBIT.format(axis=axis, anomaly=anomaly)
    if not refused:
        refusals.refuse_impossible(loads(stated))
    else:
        with pytest.raises(SceneError, match=refused) as caught:
            refusals.refuse_impossible(loads(stated))
        assert "more than the radius of the rigid body, 1e+05 m." in str(caught.value)
        assert str(caught.value).count(". ") == 0


def test_a_companion_that_another_pushes_into_a_rigid_body_is_refused_before_the_first_step() -> None:
    """Kozai and Lidov: a star on an inclined orbit makes the moon's round orbit so narrow that it meets the body."""
    star = 'name = "star"\nmass = 1.0\nsemi_major_axis = 30.0\ninclination = 1.3\n'
    moon = 'name = "moon"\nmass = 1e-3\nsemi_major_axis = 5.0\n'
    body = 'kind = "rigid"\nmass = 1.0\nradius = 1.0\nmoment_ratios = [0.39, 0.395, 0.4]\n'
    text = f'name = "kozai"\nmodel = "rigid"\nunits = "code"\n[body]\n{body}[effects.gravity_gradient]\n'
    pair = loads(f"{text}[time]\nend = 8000.0\n[[companions]]\n{moon}[[companions]]\n{star}")
    refusals.refuse_impossible(pair)
    with pytest.raises(SceneError, match=r"companion moon comes within the body at 6470, .* rigid body, 1: end"):
        prepare(pair)


@pytest.mark.slow
@pytest.mark.parametrize("integrator", ["splitting", "adaptive"])
def test_a_companion_that_the_body_acts_on_does_not_come_within_it_unseen(integrator) -> None:
    """As above, by a heavier star, and between two records: as REBOUND has the three as points, which differ little."""
    star = 'name = "star"\nmass = 10.0\nsemi_major_axis = 25.0\ninclination = 1.5\n'
    moon = 'name = "moon"\nmass = 1e-3\nsemi_major_axis = 5.0\n'
    body = 'kind = "rigid"\nmass = 1.0\nradius = 1.0\nmoment_ratios = [0.399, 0.3995, 0.4]\n'
    text = f'name = "kozai"\nmodel = "rigid"\nunits = "code"\n[body]\n{body}[effects.gravity_gradient]\n'
    text += (
        f'[time]\nend = 1500.0\n[numerics]\nintegrator = "{integrator}"\n[[companions]]\n{moon}[[companions]]\n{star}'
    )
    with pytest.raises(SceneError, match=r"companion moon comes within the body at 143\.4, "):
        prepare(loads(text))
    coupled = loads(text, ["orbits.back_reaction=true"])
    refusals.refuse_impossible(coupled)
    with jax.enable_x64(True):
        run = prepare(coupled).evolution
        run.advance(140.0)
        with pytest.raises(
            NumericalError, match=r"companion moon comes within the rigid body, .*\(time 14[34]\.?\d*\)"
        ):
            run.advance(1500.0)
    outside = loads(
        text.replace("radius = 1.0", "radius = 0.05").replace("end = 1500.0", "end = 160.0"),
        ["orbits.back_reaction=true"],
    )
    with jax.enable_x64(True):
        run = prepare(outside).evolution
        run.advance(160.0)
    assert run.time == 160.0


def test_a_companion_of_an_archive_within_a_rigid_body_is_refused(tmp_path) -> None:
    bodies = rebound.Simulation()
    bodies.units = ("kg", "km", "s")
    bodies.add(m=1e15, name="body")
    bodies.add(m=1e10, x=10.0, vy=3e-3, name="moon")
    bodies.save_to_file(str(tmp_path / "orbits.bin"))
    refusals.refuse_impossible(loads((TUMBLING + ARCHIVE).format(size=RATIOS.format(9)), origin=str(tmp_path)))
    with pytest.raises(SceneError, match=r"companion moon begins 1e\+04 m"):
        refusals.refuse_impossible(loads((TUMBLING + ARCHIVE).format(size=RATIOS.format(11)), origin=str(tmp_path)))


def test_error_bars_of_closed_forms_are_refused_before_a_run_and_a_sweep(tmp_path, capsys):
    for number, name in enumerate(("core_to_pulsar_scaling", "pulsar_births")):
        for command in ("plan", "run"):
            place = ["--output", str(tmp_path / str(number))] if command == "run" else []
            assert main([command, f"sims/{name}.toml", "--error-bars", *place]) == 2
            assert "the model scaling has no error bars: its answers are closed forms" in capsys.readouterr().err
    assert not any(tmp_path.iterdir())


def test_a_mean_over_spheres_is_for_one_body() -> None:
    """About the centre of mass of two stars, which lies between them, it would pull both to nothing."""
    merger = load_file(SIMS / "binary_merger.toml", ["effects.relativistic_potential={}"])
    with pytest.raises(SceneError, match=r"relativistic_potential\] is the mean .*: it is for one \[body\]"):
        refusals.refuse_impossible(merger)
    refusals.refuse_impossible(load_file(SIMS / "neutron_star.toml"))
