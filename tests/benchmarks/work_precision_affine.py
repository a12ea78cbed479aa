"""Error against time of affine bodies: the tolerance of a step is their knob; compilation is not counted."""

import json
import math
import sys
from pathlib import Path

import numpy as np
from precision_table import publish, table

sys.path.insert(0, str(Path(__file__).parents[2]))  # run as a script: the tests' own scenes are beside it

from tests import affine_scenes
from tests.evolve import advanced

REFERENCE = Path(__file__).parents[1] / "reference"
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 1e-14)
DEFAULT = 1e-12
SPIN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


def problem(title, scene, until, wanted):
    """The table of one scene: error of the second moments (xx, yy, zz, xy) at a time."""
    body = affine_scenes.started(scene)
    start = body.arrays()

    def run(tolerance):
        body.resume(start)
        body.tolerance = tolerance
        advanced(body, until)
        return body.record(0.0)["second_moment"]

    def error(second):
        found = np.array([second[0, 0], second[1, 1], second[2, 2], second[0, 1]])
        return np.abs(found - wanted).max() / np.abs(wanted).max()

    return table(title, "tolerance", TOLERANCES, run, error, DEFAULT)


def family(name):
    entries = json.loads((REFERENCE / "riemann.json").read_text())
    entry = next(entry for entry in entries if entry["name"] == f"{name}_visible")
    return entry["inputs"], entry["value"][-1]


def compressible():
    given, last = family("riemann_A")
    scene = affine_scenes.compressible(np.diag(given["F0"]), given["L0"], given["par"]["gamma"], given["par"]["eps0"])
    title = f"Compressible Riemann ellipsoid, to t = {last['t']:g}, against an independent integration"
    return problem(title, scene, last["t"], np.array(last["I_second_moment"]))


def incompressible():
    given, last = family("dirichlet_D")
    scene = affine_scenes.incompressible(np.diag(given["F0"]), given["L0"])
    title = f"Dirichlet's incompressible ellipsoid, to t = {last['t']:g}, against an independent integration"
    return problem(title, scene, last["t"], np.array(last["I_second_moment"]))


def collapse():
    """The cold sphere: r = cos^2 b at t = (b + sin(2 b)/2) (2/pi) t_ff."""
    angle = math.acos(0.01)  # until r = 1e-4
    until = (angle + math.sin(2 * angle) / 2) / math.sqrt(2)
    moment = 0.2 * math.cos(angle) ** 4
    scene = affine_scenes.cold([1.0, 1.0, 1.0], 0.0 * SPIN)
    title = "Cold sphere, until its radius is 1e-4 of that at the start, against the closed form"
    return problem(title, scene, until, np.array([moment, moment, moment, 0.0]))


publish("affine", [compressible(), incompressible(), collapse()])
