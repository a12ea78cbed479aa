"""The command `sensitivity`: how a run answers to keys of its scene. Printing is left to main.py."""

from pathlib import Path
from typing import TYPE_CHECKING

from astroinertia.cli import result
from astroinertia.cli.parser import Add, Options, add_scene

if TYPE_CHECKING:
    from astroinertia.scene.schema import Scene
    from astroinertia.scene.sweep import Sweep

HELP = """\
Each key is moved by the step and by half of it, both ways: four runs a key, beside the scene itself, in one folder,
which the same command goes on with after an interruption. Printed is d ln X/d ln p at the end, with its estimated
error; sensitivity.nc in the folder has dX/d ln p of every series at every time. From Python, astroinertia.gradient
differentiates along one run instead, particles of the engine xla included (astroinertia guide sweeps).

examples: astroinertia sensitivity sims/core_to_pulsar_scaling.toml --by body.rotation.period --by body.radius
          astroinertia sensitivity star.toml --by equation_of_state.gamma --of "inertia_tensor z z" --step 0.02
"""


def add_arguments(add: Add) -> None:
    """Add the scene, the keys it answers to, what of it is printed, the step and the folder."""
    add_scene(add)
    add("--by", action="append", required=True, metavar="KEY",
        help="a key that the scene sets to a number or quantity, such as body.rotation.period; may be "
        "repeated")  # fmt: skip
    add("--of", action="append", default=[], metavar="NAME",
        help='what is printed: a series of the dataset and its labels, as in "inertia_tensor z z"; may be repeated '
        "(default: I_zz and the angular velocity)")  # fmt: skip
    add("--step", type=float, default=0.01, metavar="X", help="relative step of each key (default: 0.01)")
    add("--output", type=Path, metavar="DIR", help="folder of the runs (default: runs/NAME-sensitivity)")


def sweep_of(scene: "Scene", options: Options) -> tuple["Sweep", Path]:
    """The runs that tell, and their folder; what is to be printed is looked at before any of them."""
    from astroinertia.accuracy.selected_observables import parsed
    from astroinertia.errors import SceneError
    from astroinertia.sweeps.sensitivity import sensitivity_sweep
    from astroinertia.units import shown

    for name in options.of:
        if parsed(name, scene.observables).of_series:
            raise SceneError(f"--of '{shown(name)}': a frequency has no sensitivity here; name the series itself.")
    folder = options.output or Path("runs") / f"{scene.name}-sensitivity"
    return sensitivity_sweep(scene, options.by, options.step), folder


def report(scene: "Scene", folder: Path, file: Path, options: Options) -> list[str]:
    """The lines to print: a row for each number at the end, a column for each key; writes sensitivity.nc."""
    import numpy as np

    from astroinertia import dataset
    from astroinertia.accuracy.selected_observables import components, default_names, parsed, value
    from astroinertia.sweeps.sensitivity import sensitivity

    data = dataset.open(file).load()
    answers = sensitivity(data)
    widest = max(22, *(len(key) + 2 for key in options.by))
    lines = [f"{'d ln X / d ln p at the end':34}" + "".join(f"{key:>{widest}}" for key in options.by)]
    base = data.isel(member=0)
    for name in options.of or default_names(scene):
        observable = parsed(name, scene.observables)
        numbers = value(base, observable)
        columns = []
        for key in options.by:
            here = answers.sel(parameter=key)
            slope = value(here, observable)
            error = value(here.assign({observable.variable: here[f"{observable.variable}_error"]}), observable)
            columns.append((slope, error))
        scale = float(np.linalg.norm(numbers))
        for place, label in enumerate(components(base, observable)):
            if abs(numbers[place]) <= 1e-12 * scale:  # a component that is zero but for round-off
                continue
            cells = (f"{s[place] / numbers[place]:.6f} +- {abs(e[place] / numbers[place]):.0e}" for s, e in columns)
            lines.append(f"{label:34}" + "".join(f"{cell:>{widest}}" for cell in cells))
    target = folder / "sensitivity.nc"
    result.write_netcdf(answers, target)
    return [*lines, f"wrote {target}"]
