"""Eighty wrong inputs from Python: each is one sentence of the package's own error class that names the argument."""

from typing import Any

import numpy as np
import pytest
from astropy import units as u

import astroinertia
from astroinertia.bodies import inversion, jacobi, neutron_star_fits, polytrope, rotating_star, rotation_laws
from astroinertia.errors import AstroinertiaError, SceneError
from astroinertia.inertia import balancing, principal, realise, solids, tensor
from astroinertia.matter import barotropes
from astroinertia.rotation import free_top, pulsars, spin_scaling
from astroinertia.studies import moment_ratio

BODY = {"kind": "polytrope", "index": 1.5, "mass": 1 * u.Msun, "radius": 1 * u.Rsun, "particles": 100}
REST = {"equation_of_state": {"kind": "ideal"}, "effects": ["gravity", "pressure"], "time": 1 * u.h}
ROTATION = {"period": 1 * u.d}
MOMENTS = ["1 kg m2", "2 kg m2", "3 kg m2"]
TOP = {
    "model": "rigid", "effects": [], "time": "10 s", "output": {"series_every": "5 s"},
    "body": {"kind": "rigid", "mass": "1 kg", "moments": MOMENTS, "rotation": {"rate": "1 rad/s"}},
}  # fmt: skip


def scene(**keys: Any) -> Any:
    return lambda _: astroinertia.Scene({"body": BODY, **REST, **keys})


def body(**keys: Any) -> Any:
    return scene(body={**BODY, **keys})


def run(scene: Any = TOP, place: Any = None, **options: Any) -> Any:
    return lambda folder: astroinertia.run_scene(scene, folder / "run" if place is None else place, **options)


# What is done, and what the sentence must name.
WRONG: dict[str, tuple[Any, str]] = {
    # types
    "a number for a body": (scene(body=3), "body"),
    "a list for a body": (scene(body=[BODY]), "body"),
    "an object for a mass": (body(mass=object()), "mass"),
    "a complex index": (body(index=1 + 2j), "index"),
    "a date for a radius": (body(radius=np.datetime64("2026-01-01")), "radius"),
    "bytes for a kind": (body(kind=b"polytrope"), "kind"),
    "a function for a kind": (body(kind=print), "kind"),
    "true for a number of particles": (body(particles=np.True_), "particles"),
    "None among axes": (body(axes=[1, None, 1]), "axes[1]"),
    "a set of effects": (scene(effects={"gravity"}), "effects"),
    "a number among effects": (scene(effects=["gravity", 3]), "effects[1]"),
    "no options of an effect": (scene(effects={"gravity": None}), "gravity"),
    "a number for a key": (body(rotation={3: 4}), '"3"'),
    "text that is no Unicode": (scene(name="\ud800"), "name"),
    "a file for a scene": (lambda _: astroinertia.Scene("scene.toml"), "scene"),  # pyright: ignore[reportArgumentType]
    # shapes
    "two axes": (body(axes=np.ones(2)), "axes"),
    "two masses": (body(mass=[1, 2] * u.kg), "mass"),
    "an array of times": (scene(time=[1, 2] * u.s), "end"),
    "a flat matrix": (body(velocity_gradient=np.zeros(9) / u.s), "velocity_gradient"),
    "a velocity of two": (body(velocity=[1, 2] * u.m / u.s), "velocity"),
    "a million axes": (body(axes=np.zeros(10**6)), "axes"),
    "deep nests": (scene(body={"a": {"b": {"c": {"d": {"e": {"f": {"g": 1}}}}}}}), "[body]"),
    # units
    "a mass in km": (body(mass=3 * u.km), "mass"),
    "a mass without unit": (body(mass=2e30), "mass"),
    "a temperature for a radius": (body(radius=3 * u.K), "radius"),
    "a period in hertz": (body(rotation={"rate": 3 * u.Hz}), "rate"),
    "an index in kg": (body(index=3 * u.kg), "index"),
    "text without number": (body(radius="large"), "radius"),
    "quantities in code units": (scene(units="code"), "mass"),
    "units of another package": (body(mass=type("Q", (), {"magnitude": 3, "units": "kg"})()), "mass"),
    # ranges
    "a mass that is not finite": (body(mass=np.nan * u.kg), "mass"),
    "a negative radius": (body(radius=-1 * u.m), "radius"),
    "an index of 7": (body(index=7), "index"),
    "half a particle": (body(particles=100.5), "particles"),
    "infinitely many particles": (body(particles=np.inf), "particles"),
    "an exponent of 1/0": (scene(equation_of_state={"kind": "ideal", "gamma": "1/0"}), "gamma"),
    "no time": (scene(time=0 * u.s), "end"),
    "T/|W| of 2": (body(rotation={"t_over_w": 2.0}), "t_over_w"),
    # names
    "an unknown key": (scene(bdy=3), "bdy"),
    "an unknown option": (scene(effects=[{"kind": "viscosity", "alpha": 1}]), "alpha"),
    "an unknown effect": (scene(effects=["gravty"]), "gravty"),
    "an effect twice": (scene(effects=["gravity", "gravity"]), "gravity"),
    "two rotations": (body(rotation={**ROTATION, "t_over_w": 0.1}), "period and t_over_w"),
    # run_scene
    "a run of a number": (run(3), "scene"),
    "a run into a number": (run(place=3), "folder"),
    "a callback that is none": (run(callback=3), "callback"),
    "a callback every metre": (run(callback=print, every=3 * u.m), "every"),
    "no steps between calls": (run(callback=print, every=0), "every"),
    "progress in words": (run(progress="some"), "progress"),
    "a number of effects": (run(effects=3), "effects"),
    "a number of observables": (run(observables=3), "observables"),
    "a number for matter": (run(matter=3), "matter"),
    "a number for a body of one's own": (run(body=3), "body"),
    "a listener that is none": (run(listener=3), "listener"),
    "workers in words": (run(workers="two"), "workers"),
    "half a worker": (run(workers=1.5), "workers"),
    "no workers": (run(workers=0), "workers"),
    "a number for a cluster": (run(cluster=3), "cluster"),
    "a branch of a number": (lambda folder: astroinertia.branch(3, folder / "run"), "run must"),  # pyright: ignore[reportArgumentType]
    "a branch heard by text": (lambda folder: astroinertia.branch("run", folder / "b", listener="me"), "listener"),  # pyright: ignore[reportArgumentType]
    "workers that resume": (lambda folder: astroinertia.resume(folder, workers="two"), "workers"),  # pyright: ignore[reportArgumentType]
    # results
    "a number to open": (lambda _: astroinertia.open(3), "path"),  # pyright: ignore[reportArgumentType]
    "a tree of a number": (lambda _: astroinertia.open_tree(3), "path"),  # pyright: ignore[reportArgumentType]
    "a sweep of a number": (lambda _: astroinertia.open_sweep(3), "path"),  # pyright: ignore[reportArgumentType]
    "a gradient of a number": (lambda _: astroinertia.gradient(TOP, 3, ["body.mass"]), "of must"),  # pyright: ignore[reportArgumentType]
    "a gradient by a number": (lambda _: astroinertia.gradient(TOP, "energy", 4), "by must"),  # pyright: ignore[reportArgumentType]
    "a gradient by text": (lambda _: astroinertia.gradient(TOP, "energy", "body.mass"), "by must"),
    # library functions
    "an index in words": (lambda _: polytrope.Polytrope("three"), "index of Polytrope"),  # pyright: ignore[reportArgumentType]
    "no index": (lambda _: polytrope.Polytrope(None), "index of Polytrope"),  # pyright: ignore[reportArgumentType]
    "an index below none": (lambda _: polytrope.Polytrope(-1), "index"),
    "matter of a negative index": (lambda _: barotropes.polytropic_matter(-1), "index"),
    "two moment ratios": (lambda _: inversion.two_layers(3933.5, [0.36, 0.3], mantle_density=3500.0), "moment_ratio"),
    "a spin in words": (
        lambda _: rotating_star.rotating_star_with("spin", "fast", barotropes.polytropic_matter(1.5)),  # pyright: ignore[reportArgumentType]
        "value of rotating_star_with",
    ),
    "a density in km": (lambda _: moment_ratio.two_layer_sweep("Mars", {"core_density": 7 * u.km}), "core_density"),
    "a number for a planet": (lambda _: moment_ratio.two_layer_sweep(4, {"core_density": [7e3]}), "name"),
    "no values": (lambda _: moment_ratio.two_layer_sweep("Mars"), "values"),  # pyright: ignore[reportCallIssue]
    "an unknown density": (lambda _: inversion.two_layers(3933.5, 0.36, mantel_density=1.0), "mantel_density"),  # pyright: ignore[reportCallIssue]
    "a ratio in kg": (lambda _: jacobi.from_axis_ratio(0.5 * u.kg), "b_over_a"),
    "a mass in metres": (lambda _: neutron_star_fits.lattimer_schutz(1.4 * u.m, 12.0), "mass"),
    "a scale in seconds": (lambda _: rotation_laws.RotationLaw("j_constant", 3 * u.s), "scale"),
    "a radius in kg": (lambda _: solids.cylinder(1 * u.kg, 3 * u.kg, 1 * u.m), "radius"),
    "a height in words": (lambda _: solids.cylinder(1.0, 2.0, "tall"), "height"),
    "positions in seconds": (lambda _: tensor.inertia_tensor([1, 2] * u.kg, np.eye(3)[:2] * u.s), "position"),
    "no masses": (lambda _: tensor.inertia_tensor(None, np.eye(3)), "mass"),
    "an inertia tensor in kg": (lambda _: principal.principal_frame(np.eye(3) * u.kg), "inertia"),
    "an inertia tensor in words": (lambda _: realise.point_masses("round"), "inertia"),
    "radii in kelvin": (lambda _: balancing.correction_masses(np.ones((2, 2)), [1, 2] * u.K), "radii"),
    "a period in metres": (lambda _: pulsars.characteristic_age(33 * u.m, 4e-13), "period"),
    "two moments": (lambda _: free_top.free_top([1.0, 2.0], [1.0, 0.0, 1.0]), "three principal moments"),
    "joules": (lambda _: spin_scaling.centrifugal_radius(3 * u.J, 1e30), "specific_angular_momentum"),
}  # fmt: skip


def test_there_are_eighty_of_them() -> None:
    assert len(WRONG) >= 80


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_input_is_one_sentence_that_names_the_argument(name: str, tmp_path: Any) -> None:
    call, named = WRONG[name]
    with pytest.raises(AstroinertiaError) as caught:
        call(tmp_path)
    sentence = str(caught.value)
    assert isinstance(caught.value, SceneError) and "\n" not in sentence
    assert named in sentence and 15 < len(sentence) < 300
    assert not list(tmp_path.iterdir())
