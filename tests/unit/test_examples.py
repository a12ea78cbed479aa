"""Examples in docstrings: every public function of the rooms below has one, and all of them are run.

Those of EXPENSIVE take half a second or more each and run with the full tests, the others together some thirty seconds
where nothing is compiled yet.

They are run in the namespace of their module, with `np`, in a folder that has sims/, the scenes, and two finished runs:
runs/star, a star that falls together (its dataset is `ds`), and runs/sweep, of two members.
"""

import ast
import doctest
import importlib
from pathlib import Path

import numpy as np
import pytest

import astroinertia

PACKAGE = Path(__file__).parents[2] / "astroinertia"
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
ROOMS = [
    *("__init__", "accuracy", "dataset/accessor", "inertia", "interop", "plots", "rotation", "sweeps"),
    *("scene/schema", "studies", "units"),
    *(
        "orbits/rebound_archive",
        "orbits/dense",
        "orbits/kepler",
        "orbits/particles",
        "orbits/simulation",
        "orbits/states",
    ),
    *("bodies/affine", "bodies/affine_motion"),
    *("bodies/apsidal", "bodies/clairaut", "bodies/cold_spheroid", "bodies/composite_polytrope", "bodies/darwin"),
    *("bodies/earth", "bodies/ellipsoid_gravity", "bodies/ellipsoid_secular", "bodies/ellipsoid_stability"),
    *("bodies/figures", "bodies/giant_planets", "bodies/inversion", "bodies/jacobi"),
    *("bodies/layered", "bodies/love_numbers", "bodies/maclaurin", "bodies/moment_ratios", "bodies/neutron_star_fits"),
    *("bodies/neutron_stars", "bodies/oscillations", "bodies/planets", "bodies/polytrope", "bodies/riemann"),
    *("bodies/bar_analysis", "bodies/homogeneous_ellipsoid"),
    *("bodies/hydrostatic", "bodies/roche", "bodies/roche_polytrope", "bodies/rotating_star"),
    *("bodies/rotating_sequence", "bodies/rotation_laws"),
    *("bodies/scf", "bodies/scf_mesh", "bodies/slow_rotation"),
    *("matter/barotropes", "matter/compact_stars", "matter/compact_tables", "matter/degenerate", "matter/planetary"),
    *("matter/rheology", "matter/tillotson"),
]
# Those of the rooms that would keep the ordinary tests waiting: what is compiled for a second, run or drawn.
EXPENSIVE = [
    *("accuracy/analysis", "accuracy/choice", "accuracy/error_bars", "accuracy/running", "accuracy/table"),
    *("accuracy/tradeoff", "interop/zarr_store", "plots", "sweeps/ensemble"),
    *("bodies/affine", "bodies/affine_motion", "bodies/hydrostatic", "bodies/rotating_sequence"),
    *("bodies/composite_polytrope", "bodies/giant_planets", "bodies/inversion", "bodies/neutron_stars"),
    *("matter/planetary", "sweeps/gradient", "sweeps/sensitivity"),
    *("bodies/apsidal", "bodies/clairaut", "bodies/earth", "bodies/ellipsoid_secular", "bodies/layered"),
    *("bodies/oscillations", "bodies/roche_polytrope", "bodies/rotating_star", "bodies/scf", "dataset/accessor"),
    *("inertia/realise", "interop/gadget", "interop/hdf5", "interop/paraview", "interop/swift", "interop/tables"),
    *("rotation/spin_orbit", "studies/flattening", "studies/moment_ratio", "studies/moments", "studies/ratio_tables"),
    *("studies/spinup", "sweeps/combined"),
]
# What only the package itself calls.
INSIDES = {
    "inertia.eigen",  # what principal axes and their gradients are computed with
    "inertia.mean_squares",  # what shapes are made with
    "inertia.prescribed",  # the curve of [body.change]
    "inertia.tensor.namespace",  # NumPy or JAX
    *("rotation.elliptic", "rotation.ripple"),  # what tops are computed with
    *(
        "rotation.ephemeris",
        "rotation.on_orbits",
        "rotation.precession.require_ellipse",
    ),  # companions of a scene; a check
    *("rotation.free_top.clock", "rotation.free_top.elliptic_functions", "rotation.free_top.checked_times"),
    *("bodies.apsidal.complement_slope", "bodies.apsidal.integrate_zone", "bodies.apsidal.core_zone"),
    *("bodies.ellipsoid_stability.steady_frame", "bodies.ellipsoid_stability.stiffness_and_gyration"),
    *("bodies.ellipsoid_stability.masses_of", "bodies.ellipsoid_stability.bar_equation"),
    "bodies.ellipsoid_stability.families",
    *("bodies.oscillations.radial_spectrum", "bodies.oscillations.nonradial_spectrum"),
    *("bodies.polytrope.central_series", "bodies.polytrope.nodes_of", "bodies.polytrope.hermite"),
    "bodies.polytrope.enclosing",
    "accuracy.affine_exact",  # exact answers of scenes, computed there
    *("accuracy.analysis.reference_of", "accuracy.tradeoff.stored_exact", "accuracy.measuring"),  # parts of a tradeoff
    "accuracy.tradeoff.predicted",  # what it has time for
    *("accuracy.choice_particles", "accuracy.choice_smooth", "accuracy.pilots"),  # how accuracy.choice looks
    *("plots.attitude.motion", "plots.attitude.nutation_and_precession", "plots.attitude.reference_direction"),
    *("plots.film", "plots.matter", "plots.render", "plots.axis_scales", "plots.shown_units", "plots.style"),
    *("plots.ellipsoid.polhode", "plots.error_bars.error_of", "plots.error_bars.shade"),
    *("plots.density.column_unit", "plots.density.draw_density", "plots.density.frame_view"),  # what figures share
    *("plots.density.moments_to_show", "plots.density.name_view", "plots.density.scale_of_colours"),
    *("plots.ellipsoid.draw_axes", "plots.ellipsoid.draw_curves", "plots.ellipsoid.draw_ellipsoid"),
    *("plots.ellipsoid.draw_inertia_ellipsoid", "plots.ellipsoid.draw_triad", "plots.ellipsoid.heading"),
    *("plots.ellipsoid.lit_ellipsoid", "plots.ellipsoid.view_of", "plots.error_bars.known_bars"),
    "plots.waves.undersampled",
    *(
        "sweeps.combined.write",
        "sweeps.members",
        "sweeps.worker",
        "sweeps.workers.side_by_side",
        "sweeps.cluster.by_cluster",
    ),  # parts of a sweep under way
    "studies.core_collapse.dynamics",
    *("studies.turning_planets.orbits", "studies.turning_planets.torque_of", "studies.turning_planets.axis_history"),
    "studies.relax.polytrope_problem",
}
# What takes seconds to minutes, or a run of its own: tests and scenes show it.
LONG = {
    *("bodies.neutron_stars.sequence", "bodies.neutron_stars.stable_branch"),
    "rotation.secular_spin.spin_history",
    "rotation.spice",  # needs kernels of the user's
    *("bodies.figures.figure_of_barotropes", "bodies.figures.figure_of_layered_body"),
    *("bodies.rotating_star.end_of_sequence", "bodies.rotating_star.rotating_star_with"),
    "bodies.break_up.polytropic_limit",
    "plots.precession.precession_figure",
    *("bodies.break_up.spun_up_polytrope", "rotation.tumbling.divergence"),
    *("studies.bar_mode", "studies.compressed_core", "studies.debris.orbital_energies", "studies.impact_remnant"),
    *("studies.core_collapse.core_collapse", "studies.core_collapse.core_scene", "studies.core_collapse.initial_star"),
    *("studies.core_collapse.with_bounce", "studies.interior_inference", "studies.love_number_of_fluid"),
    *("studies.obliquity", "studies.precession.precession", "studies.relax.relaxed_polytrope"),
    *("studies.sampling.sample", "studies.sampling.diagnostics", "studies.sampling.summary"),
    *("studies.slow_spin_up", "studies.spinup.core_to_neutron_star", "studies.spinup.star_of_baryons"),
}
SCENES = ["sims/one_star_three_models.toml", "sims/tennis_racket.toml"]  # of the expensive examples, and other files:
FILES = [*SCENES, "sims/core_to_pulsar_scaling.toml", "data/prem.csv"]
SWEEP = """
name = "sweep"
model = "scaling"
effects = {}

[sweep]
"body.index" = [1.5, 3.0]

[body]
kind = "polytrope"
mass = "1 Msun"
radius = "1 Rsun"

[body.rotation]
period = "1 d"

[time]
end = "1 d"

[output]
series_every = "1 d"
"""


def modules(rooms):
    """The modules of the rooms, without those of INSIDES and LONG."""
    found = []
    for room in rooms:
        path = PACKAGE / room
        files = path.rglob("*.py") if path.is_dir() else [path.with_suffix(".py")]
        found += [".".join(each.relative_to(PACKAGE).with_suffix("").parts) for each in files if each.stat().st_size]
    return sorted(set(found) - INSIDES - LONG)


def source(name):
    return PACKAGE / f"{name.replace('.', '/')}.py"


def without_example(name):
    """Public functions, and public methods of accessors, that show no example, nor are in that of their class.

    Other classes are what functions return: their examples are those of the functions.
    """
    tree = ast.parse(source(name).read_text())
    bodies = [(tree.body, "")]
    bodies += [(each.body, examples_of(each)) for each in tree.body if getattr(each, "name", "").endswith("Accessor")]
    functions = [(each, shown) for body, shown in bodies for each in body if isinstance(each, ast.FunctionDef)]
    missing = [each.name for each, shown in functions if not examples_of(each) and f".{each.name}(" not in shown]
    return [each for each in missing if not each.startswith("_") and f"{name}.{each}" not in INSIDES | LONG]


def examples_of(node):
    return "".join(each.source for each in doctest.DocTestParser().get_examples(ast.get_docstring(node) or ""))


@pytest.fixture(scope="module")
def workplace(tmp_path_factory):
    """A folder with scenes and finished runs."""
    folder = tmp_path_factory.mktemp("examples")
    (folder / "sims").mkdir()
    for scene in (PACKAGE.parent / "sims").iterdir():
        (folder / "sims" / scene.name).symlink_to(scene)
    core = folder / "sims" / "core_to_pulsar_scaling.toml"  # with fewer records, which no example counts
    text = core.read_text().replace('"1 ms"', '"10 ms"')
    core.unlink()
    core.write_text(text)
    settings = ["body.particles=100", "time.end='20 min'", "output.snapshot_every='10 min'"]
    star = astroinertia.load(folder / SCENES[0], settings)
    astroinertia.run_scene(star, folder / "runs/star")
    (folder / "sweep.toml").write_text(SWEEP)
    astroinertia.run_scene(folder / "sweep.toml", folder / "runs/sweep")
    return folder


def examples_within(name):
    """How many examples a module has in all its docstrings."""
    nodes = ast.walk(ast.parse(source(name).read_text()))
    parser, documented = doctest.DocTestParser(), (ast.Module, ast.ClassDef, ast.FunctionDef)
    return sum(
        len(parser.get_examples(ast.get_docstring(each) or "")) for each in nodes if isinstance(each, documented)
    )


def tried(name):
    """How many examples of a module were run, and how many of them failed."""
    module = importlib.import_module(f"astroinertia.{name}".removesuffix(".__init__"))
    with astroinertia.open("runs/star") as star:
        found = doctest.testmod(module, extraglobs={"np": np, "ds": star}, optionflags=FLAGS)
    return found.attempted, found.failed


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(modules(ROOMS)) - set(modules(EXPENSIVE))))
def test_examples_print_what_they_say(name, workplace, monkeypatch):
    monkeypatch.chdir(workplace)
    assert tried(name) == (examples_within(name), 0)


@pytest.mark.full(inputs=[*FILES, *(str(source(name).relative_to(PACKAGE.parent)) for name in modules(EXPENSIVE))])
def test_expensive_examples_print_what_they_say(workplace, monkeypatch, result):
    monkeypatch.chdir(workplace)
    found = {name: tried(name) for name in modules(EXPENSIVE)}
    result(examples=sum(attempted for attempted, _ in found.values()), modules=len(found))
    assert found == {name: (examples_within(name), 0) for name in found}


@pytest.mark.parametrize("name", modules(ROOMS))
def test_every_public_function_has_an_example(name):
    assert without_example(name) == []
