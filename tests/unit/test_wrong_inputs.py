"""A hundred and sixty wrong inputs from Python: each is one sentence of the package's own error class, with a name."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
import xarray as xr
from astropy import units as u

import astroinertia
from astroinertia.bodies import (
    clairaut,
    giant_planets,
    inversion,
    jacobi,
    layered,
    love_numbers,
    maclaurin,
    moment_ratios,
    neutron_star_fits,
    planets,
    polytrope,
    roche,
    rotating_star,
    rotation_laws,
)
from astroinertia.errors import AstroinertiaError, SceneError
from astroinertia.inertia import (
    balancing,
    evolution,
    gravity_field,
    mesh,
    plates,
    principal,
    realise,
    rolling,
    solids,
    spin,
    target,
    tensor,
)
from astroinertia.matter import barotropes, rheology
from astroinertia.rotation import (
    attitude,
    cassini,
    collapsing_shells,
    contraction,
    free_top,
    polhodes,
    pulsar_table,
    pulsars,
    spin_orbit,
    spin_scaling,
    wobble,
)
from astroinertia.studies import (
    core_collapse,
    core_inversion,
    interior_inference,
    moment_ratio,
    own_precession,
    sampling,
)

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
    "a name that no file can have": (lambda _: astroinertia.open("x" * 300), "cannot be looked at"),
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
    "an index of NumPy's below none": (lambda _: polytrope.Polytrope(np.float64(-1)), "not -1.0"),
    "an axis ratio of NumPy's": (lambda _: jacobi.from_axis_ratio(np.float64(1.5)), "not 1.5"),
    "matter of a negative index": (lambda _: barotropes.polytropic_matter(-1), "index"),
    "two moment ratios": (lambda _: inversion.two_layers(3933.5, [0.36, 0.3], mantle_density=3500.0), "moment_ratio"),
    "a spin in words": (
        lambda _: rotating_star.rotating_star_with("spin", "fast", barotropes.polytropic_matter(1.5)),  # pyright: ignore[reportArgumentType]
        "value: 'fast'",
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
}


HOLES = np.ma.masked_array([1.0, 2.0, 3.0], mask=[False, True, False])
RAGGED = [[1.0, 2.0, 3.0], [4.0, 5.0]]
PAIR = layered.constant_layers([1.0, 2.0], [2.0, 1.0])
LIQUID = barotropes.polytropic_matter(1.5)
TURNING = free_top.free_top([1, 2, 3], [1, 0.1, 0])


def top(**keys: Any) -> Any:
    return lambda _: astroinertia.Scene({**TOP, **keys})


def at_start(**rotation: Any) -> Any:
    return top(body={**TOP["body"], "rotation": {"rate": "1 rad/s", **rotation}})


def moments(values: Any) -> Any:
    return top(body={**TOP["body"], "moments": values * u.kg * u.m**2})


def done(function: Any, *args: Any, **options: Any) -> Any:
    return lambda _: function(*args, **options)


# The same of what is odder: holes, rows of differing length, arrays of other packages, numbers that are none.
ODD: dict[str, tuple[Any, str]] = {
    # scenes
    "axes with a hole": (body(axes=HOLES), "axes"),
    "a ragged matrix": (body(velocity_gradient=RAGGED), "velocity_gradient"),
    "masses in two dimensions": (body(mass=[[1.0]] * u.kg), "mass"),
    "a series without unit": (body(mass=xr.DataArray(2e30)), "mass"),
    "a series of masses": (body(mass=xr.DataArray([2e30, 1.0], attrs={"units": "kg"})), "mass"),
    "indices of JAX": (body(index=jnp.array([1.0, 2.0])), "index"),
    "an index of JAX that is none": (body(index=jnp.nan), "index"),
    "true for a mass": (body(mass=True), "mass"),
    "more particles than atoms": (body(particles=10**400), "particles"),
    "fewer particles than none": (body(particles=-5), "particles"),
    "a complex mass": (body(mass=(1 + 1j) * u.kg), "mass"),
    "a magnitude for a mass": (body(mass=5 * u.mag), "mass"),
    "the logarithm of a length for a mass": (body(mass=3 * u.dex(u.m)), "mass"),
    "no mass at all": (body(mass=[] * u.kg), "mass"),
    "effects in a list in a list": (scene(effects=[["gravity"]]), "effects"),
    "an effect without kind": (scene(effects=[{"alpha": 1}]), "kind"),
    "a span of NumPy's time": (scene(time=np.timedelta64(5, "s")), "end"),
    "a name with a folder": (scene(name="a/b"), "name"),
    "moments with a hole": (moments(np.array([1.0, np.nan, 3.0])), "moments"),
    "moments of no body": (moments(np.array([1.0, 1.0, 3.0])), "moments"),
    "a matrix of moments": (moments(np.eye(3)), "moments"),
    "no axis": (at_start(axis=[0, 0, 0]), "axis"),
    "an axis by its name": (at_start(axis="z"), "axis"),
    "a wobble in seconds": (at_start(wobble=3 * u.s), "wobble"),
    "records every so often": (top(output={"series_every": [1, 2] * u.s}), "series_every"),
    "a companion without mass": (top(companions=[{"name": "x"}]), "mass"),
    # run_scene and its like
    "a run into nowhere": (run(place=""), "folder"),
    "a run into a name with NUL": (run(place="a\0b"), "folder"),
    "a run of a dataset": (run(xr.Dataset()), "scene"),
    "calls at no time": (run(callback=print, every=np.nan * u.s), "every"),
    "calls every true": (run(callback=print, every=True), "every"),
    "calls of nothing": (run(every=1 * u.s), "every"),
    "text for effects": (run(effects="gravity"), "effects"),
    "a function of nothing": (run(effects=[lambda: 1]), "lambda"),
    "infinitely many workers": (run(workers=np.inf), "workers"),
    "settings by number": (done(astroinertia.load, "sims/evrard.toml", {3: 4}), "3"),
    "a list of results": (done(astroinertia.open, ["a"]), "path"),
    "a result with NUL": (done(astroinertia.open, "a\0b"), "path"),
    "a gradient by no key": (done(astroinertia.gradient, TOP, "kinetic_energy@end", []), "by must"),
    # tensors
    "three masses at four places": (done(tensor.inertia_tensor, np.ones(3), np.ones((4, 3))), "position (4, 3)"),
    "places in a plane": (done(tensor.inertia_tensor, np.ones(3), np.ones((3, 2))), "position (3, 2)"),
    "ragged places": (done(tensor.inertia_tensor, [1, 2], RAGGED), "position"),
    "one number for a place": (done(tensor.inertia_tensor, 1.0, 2.0), "position ()"),
    "complex places": (done(tensor.inertia_tensor, [1.0], [[1j, 0, 0]]), "position"),
    "a mass with a hole": (done(tensor.inertia_tensor, HOLES, np.ones((3, 3))), "mass"),
    "true and false masses": (done(tensor.inertia_tensor, np.array([True, False]), np.ones((2, 3))), "mass"),
    "None among masses": (done(tensor.inertia_tensor, np.array([1, None]), np.ones((2, 3))), "mass"),
    "no particles": (done(tensor.inertia_tensor, [], []), "position (0,)"),
    "an origin in a plane": (done(tensor.inertia_tensor, np.ones(2), np.ones((2, 3)), origin=[0, 0]), "origin (2,)"),
    "places of JAX in a plane": (done(tensor.inertia_tensor, jnp.ones(3), jnp.ones((3, 2))), "position (3, 2)"),
    "a rotation by a vector": (done(tensor.rotated, np.eye(3), [1, 0, 0]), "matrix (3,)"),
    "the moment about no axis": (done(tensor.moment_about, np.eye(3), [0, 0, 0]), "axis"),
    "the moment about z": (done(tensor.moment_about, np.eye(3), "z"), "axis"),
    "the moment about two numbers": (done(tensor.moment_about, np.eye(3), [0, 1]), "axis (2,)"),
    "an offset in a plane": (done(tensor.about_point, np.eye(3), 1.0, [1, 2]), "offset (2,)"),
    "moments for a tensor": (done(principal.principal_moments, [1, 2, 3]), "inertia (3,)"),
    "a complex tensor": (done(principal.principal_frame, np.eye(3) * 1j), "inertia"),
    "a profile of two lengths": (done(tensor.radial_profile_inertia, [0, 1, 2], [1, 2]), "density"),
    "a grid without coordinates": (done(tensor.grid_inertia, np.ones((2, 2, 2))), "density"),
    "L in a plane": (done(spin.angular_velocity, np.eye(3), [1, 2]), "angular_momentum (2,)"),
    "waves at no distance": (done(evolution.gravitational_wave_strain, np.eye(3), 1.0, 0.0, 0.0), "distance"),
    "two squares": (done(target.target_tensor, [1, 2]), "squares (2,)"),
    # solids and meshes
    "an imaginary sphere": (done(solids.solid_sphere, 1.0, 2j), "radius"),
    "two masses, three radii": (done(solids.cylinder, np.ones(2), np.ones(3), 1.0), "radius (3,)"),
    "ragged semi-axes": (done(solids.ellipsoid, 1.0, RAGGED), "semi_axes"),
    "three and a half corners": (done(plates.regular_polygon_plate, 1.0, 1.0, 3.5), "corners"),
    "cut a half and once": (done(mesh.icosphere, 1.5), "subdivisions"),
    "cut fifty times": (done(mesh.icosphere, 50), "subdivisions"),
    "a mesh of a number": (done(mesh.read_mesh, 3), "path"),
    "axes that are none": (done(gravity_field.ellipsoid_field, 1.0, [3, np.nan, 1], 2, 1.0), "semi-axes"),
    "rolling inwards": (done(rolling.rolling_coefficient, solids.solid_sphere(1.0, 1.0), -1.0), "radius"),
    "rolling a word": (done(rolling.rolling_coefficient, "sphere", 1.0), "body"),
    # rotation
    "a rate in words": (done(free_top.free_top, [1, 2, 3], ["fast", 0, 0]), "fast"),
    "a moment that is none": (done(free_top.free_top, [1, 2, np.nan], [1, 0, 0]), "moments"),
    "the period of a list": (done(free_top.period, [1, 2, 3]), "top"),
    "less than a point": (done(polhodes.polhode, TURNING, points=-3), "points"),
    "two angles": (done(attitude.attitude_of_euler_angles, [1, 2]), "angles (2,)"),
    "the quaternion of a vector": (done(attitude.quaternion, [1, 2, 3]), "attitude (3,)"),
    "a hyperbola": (done(cassini.hansen_coefficient, 1.5, 1.0), "eccentricity"),
    "a round orbit, in words": (done(spin_orbit.overlap_asphericity, "round"), "eccentricity"),
    "a pulsar by number": (done(pulsar_table.pulsar, 5), "name"),
    "nobody's pulsar": (done(pulsar_table.pulsar, "nobody"), "nobody"),
    "periods and rates that differ": (done(pulsars.characteristic_age, [1.0, 2.0], [1e-15] * 3), "period (2,)"),
    "a Love number in words": (done(wobble.chandler_wobble, "big"), "love_number"),
    "no shells": (done(collapsing_shells.mass_quadrature, 0), "count"),
    "a polytrope without end": (done(contraction.binding_factor, 7.0), "index"),
    # bodies
    "true for an index": (done(polytrope.Polytrope, True), "index"),
    "indices of a polytrope": (done(polytrope.Polytrope, [1.0, 2.0]), "index"),
    "eccentricities": (done(maclaurin.from_eccentricity, [0.1, 0.2]), "eccentricity"),
    "a spheroid's size": (done(maclaurin.from_eccentricity, 0.5, size=1.0), "size"),
    "less than no satellite": (done(roche.limit, -2.0), "mass ratio"),
    "no layers": (done(layered.constant_layers, [], []), "outer_radii (0,)"),
    "layers that are missing": (done(layered.constant_layers, [1, 2, 3], [1, 2]), "densities"),
    "a name for layers": (done(clairaut.love_number, "Earth"), "body"),
    "no steps": (done(clairaut.love_number, PAIR, steps=0), "steps"),
    "no radius": (done(moment_ratios.convert_moment_ratio, 0.3, 0.0, 1.0), "from_radius"),
    "no planet": (done(planets.body, None), "name"),
    "Vulcan": (done(planets.body, "Vulcan"), "Vulcan"),
    "the inside of Vulcan": (done(love_numbers.interior, "Vulcan"), "Vulcan"),
    "a planet that weighs less than nothing": (done(planets.own_body, "x", -1.0, 1.0), "mass"),
    "a planet by number": (done(planets.own_body, 3, 1e24, 1e6), "name"),
    "a ratio that is none": (done(planets.own_body, "x", 1e24, 1e6, mean_moment_ratio=np.nan), "mean_moment_ratio"),
    "a law in words": (done(rotating_star.rotating_star, LIQUID, 0.6, "rigid"), "law"),
    "harmonics of Mars": (done(giant_planets.measured_field, "Mars"), "Mars"),
    "a planet's name for its field": (done(giant_planets.giant_planet, "Jupiter"), "field"),
    "creep into the past": (done(rheology.andrade, 1.0, relaxation_time=-1.0), "relaxation_time"),
    # studies
    "an index for indices": (done(moment_ratio.polytropes, 1.5), "indices"),
    "a number for names": (done(moment_ratio.moment_ratio, 5), "names"),
    "a letter of a planet": (done(moment_ratio.moment_ratio, "M"), "'M'"),
    "a name for companions": (
        done(own_precession.precession_of, "5e26 kg", "6e7 m", 0.01, "10 h", "26 deg", moment_ratio=0.2,
             companions="Sun"),
        "companions",
    ),
    "a core of less than no particles": (done(core_collapse.core_scene, "A1B3G15", particles=-5), "particles"),
    "the core of a name": (done(core_inversion.core_inversion, "Mars"), "one"),
    "text for uses": (done(interior_inference.infer_body, "Mars", use="moment_ratio"), "use"),
    "chains in words": (done(sampling.r_hat, "a"), "values"),
}  # fmt: skip
ALL = WRONG | ODD


def test_there_are_a_hundred_and_sixty_of_them() -> None:
    assert len(WRONG) >= 80 and len(ODD) >= 100 and not set(WRONG) & set(ODD)


@pytest.mark.parametrize("name", ALL)
def test_a_wrong_input_is_one_sentence_that_names_the_argument(name: str, tmp_path: Any) -> None:
    call, named = ALL[name]
    with pytest.raises(AstroinertiaError) as caught:
        call(tmp_path)
    sentence = str(caught.value)
    assert isinstance(caught.value, SceneError) and "\n" not in sentence
    assert named in sentence and 15 < len(sentence) < 300
    assert not list(tmp_path.iterdir())
