"""Classes of processors, and a program that computes the sums of a step as numba compiles them for one of them.

`python -m tests.processors compute FILE` writes the sums and the types that the programs were compiled for.
`python -m tests.processors assemble FILE` also has LLVM make programs for arm64 of them, which it verifies.
`python -m tests.processors generate FILE` compiles the same programs for those types and runs none of them: for
processors that the machine does not have.
"""

import os
import pickle
import platform
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from llvmlite import binding as llvm
from numba import njit
from numba.core.dispatcher import Dispatcher

from astroinertia.effects.gradients import VELOCITY_GRADIENT
from astroinertia.effects.kinds.pressure import PRESSURE
from astroinertia.effects.kinds.viscosity import GUARDED
from astroinertia.engines import numba_cache, numba_modules, numba_vectors
from astroinertia.engines.few import FEW
from astroinertia.engines.numba_cpu import Engine
from astroinertia.engines.numba_passes import virial_effects
from astroinertia.engines.terms import argument_names
from astroinertia.gravity import multipole
from astroinertia.gravity.direct import DIRECT_GRAVITY
from tests.full_results import LEVELS

ROOT = Path(__file__).parent.parent
ARM64 = "aarch64-unknown-linux-gnu"
KERNEL, ETA, COUNT = "wendland_c2", 1.3, 1200
FEWER = 500
assert COUNT > FEW > FEWER  # which have programs of their own
PRECISIONS = ("float64", "mixed")
TERMS = (VELOCITY_GRADIENT, PRESSURE, GUARDED)  # every way to gather, in one program
# Of the expansions. Those that runs take are of order 5: longer sums by the same code, and twice as long to compile.
ORDER, TOLERANCE, ACCURACY = 3, 1e-3, 2e-4


@dataclass(frozen=True)
class Processor:
    """A class of processors: LLVM's name for it, the features that tell it, and the vectors that it closes up."""

    name: str
    features: tuple[str, ...]
    bits: int

    @property
    def environment(self):
        """What makes numba compile for it."""
        return {"NUMBA_CPU_NAME": self.name, "NUMBA_CPU_FEATURES": ""}

    @property
    def is_here(self):
        """Whether this machine runs its programs."""
        features = llvm.get_host_cpu_features()
        return all(features.get(name) for name in self.features)


ALL = {
    "generic": Processor("x86-64", (), 0),
    "AVX2": Processor("x86-64-v3", LEVELS["x86-64-v3"], 256),
    "AVX-512": Processor("x86-64-v4", (*LEVELS["x86-64-v3"], *LEVELS["x86-64-v4"]), 512),
}
PROCESSORS = ALL if platform.machine() in ("x86_64", "AMD64") else {}  # else LLVM does not know those names


def fields_of_a_step():
    """A dense clump in a thin envelope with two particles in one place, in the order of an arrangement, and that.

    Every field that a pair function of TERMS names has random values.
    """
    random = np.random.default_rng(1)
    position = random.normal(size=(COUNT, 3))
    position[: COUNT // 2] *= 0.04
    position[11] = position[10]
    order, arrangement = Engine().arrange(position, np.ones(COUNT))
    fields = {
        "position": position[order],
        "mass": random.uniform(0.5, 1.5, COUNT) / COUNT,
        "velocity": random.normal(size=(COUNT, 3)),
        "acceleration": random.normal(size=(COUNT, 3)),
        "smoothing_length": random.uniform(0.5, 2.0, COUNT),
    }
    named = {name for term in TERMS for name in argument_names(term.pair)}
    for name in sorted(name[:-2] for name in named if name.endswith(("_i", "_j"))):
        if name not in ("W", "dW", "phi", "dphi", "h"):
            fields.setdefault(name, random.uniform(1.0, 2.0, COUNT))
    return arrangement, fields


def multipole_program(precision):
    """That of a coarse error and many particles."""
    return multipole._module(ORDER, precision, multipole._estimated(1e-3, precision, multipole.AVERAGED))


def sums_of_a_step(precision):
    """Every sum over neighbours, over all pairs and by multipoles, by name."""
    arrangement, fields = fields_of_a_step()
    engine = Engine(precision)
    position, mass = fields["position"], fields["mass"]
    found = vars(engine.density(arrangement, KERNEL, position, mass, fields["smoothing_length"], ETA, 1e-14, True))
    lengths = found["smoothing_length"]
    fields["smoothing_length"] = lengths
    listed = engine.listed(arrangement, KERNEL, position, lengths)
    outputs = engine.neighbour_sums(listed, KERNEL, TERMS, fields)
    found |= {f"{effect} {key}": value for effect, each in outputs.items() for key, value in each.items()}
    direct = engine.all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), fields)["gravity"]
    found |= {f"direct {key}": value for key, value in direct.items()}
    strength = np.linalg.norm(direct["acceleration"], axis=1)
    particles = multipole._Particles(mass, position, lengths, None, precision, None)
    program = multipole_program(precision)
    fast = particles.sums(program, ORDER, TOLERANCE, multipole.OPENING, strength, KERNEL)
    found |= dict(zip(("multipole acceleration", "multipole potential"), fast, strict=True))
    return found | sums_of_few(fields)


def sums_of_few(given):
    """Sums over neighbours and all pairs of some of the particles, which have programs of their own in float64."""
    fields, engine = {name: array[:FEWER].copy() for name, array in given.items()}, Engine()
    _, arrangement = engine.arrange(fields["position"], np.ones(FEWER))  # in the order that they have: any leaves do
    guess = fields["position"], fields["mass"], fields["smoothing_length"]
    solved = vars(engine.density(arrangement, KERNEL, *guess, ETA, 1e-14, True))
    found = {f"few {name}": value for name, value in solved.items()}
    fields["smoothing_length"] = solved["smoothing_length"]
    outputs = engine.neighbour_sums(arrangement, KERNEL, TERMS, fields)
    found |= {f"few {effect} {key}": value for effect, each in outputs.items() for key, value in each.items()}
    direct = engine.all_pair_sums(arrangement, KERNEL, (DIRECT_GRAVITY,), fields)["gravity"]
    return found | {f"few direct {key}": value for key, value in direct.items()}


def programs():
    """The generated modules of those sums in both precisions, by name."""
    modules = {"lists": sys.modules[numba_modules.lists_pass().py_func.__module__]}
    for precision in PRECISIONS:
        made = [
            numba_modules.density_pass(KERNEL, precision, True)[0],
            numba_modules.neighbour_pass(KERNEL, TERMS, precision, False).module,
            numba_modules.all_pairs_pass(KERNEL, (DIRECT_GRAVITY,), precision, False).module,
            multipole_program(precision),
            multipole._softening(KERNEL, precision),
        ]
        modules |= {f"{precision} {module.__name__.rpartition('_')[0]}": module for module in made}
    few = [
        numba_modules.density_pass(KERNEL, "float64", True, few=True)[0],
        numba_modules.few_neighbour_pass(KERNEL, TERMS, bool(virial_effects(TERMS))).module,
        numba_modules.few_all_pairs_pass(KERNEL, (DIRECT_GRAVITY,), True).module,
    ]
    return modules | {module.__name__.rpartition("_")[0]: module for module in few}


def entries(module):
    """The functions of a module that Python calls, by name, with the types of arguments that they were compiled for."""
    functions = {name: value for name, value in vars(module).items() if isinstance(value, Dispatcher)}
    called = {name: value for name, value in functions.items() if "no_cpython_wrapper" not in value.targetoptions}
    return {name: value.signatures for name, value in called.items() if value.signatures}


def compute(file):
    """Write the sums in both precisions, and the types that each program was compiled for."""
    found = {precision: sums_of_a_step(precision) for precision in PRECISIONS}
    modules = programs()
    kept = {name for name in sys.modules if (numba_cache.kernel_directory() / f"{name}.py").exists()}
    assert {name for name in kept if not name.startswith("parts_")} == {each.__name__ for each in modules.values()}
    Path(file).write_bytes(pickle.dumps((found, {name: entries(module) for name, module in modules.items()})))


def assemble(file):
    """As `compute`; writes the sizes of the programs for arm64 besides.

    What numba keeps from another process has no text: with a folder of its own for that, this process compiles all.
    """
    compute(file)
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(ARM64).create_target_machine(cpu="generic")
    target = f'target datalayout = "{machine.target_data}"\ntarget triple = "{ARM64}"\n'
    sizes = {}
    for name, module in programs().items():
        for function, signatures in entries(module).items():
            lowered = njit(**numba_vectors.PART)(getattr(module, function).py_func)  # no code for this machine
            for signature in signatures:
                lowered.compile(signature)
                text = lowered.overloads[signature].library.get_llvm_str()
                program = llvm.parse_assembly(target + re.sub(r"^target \w+ = .*\n", "", text, flags=re.MULTILINE))
                program.verify()
                sizes[name, function] = len(machine.emit_assembly(program))
    Path(file).write_bytes(pickle.dumps((*pickle.loads(Path(file).read_bytes()), sizes)))


def generate(file):
    """Compile the programs for the types that `compute` wrote, and run none."""
    types = pickle.loads(Path(file).read_bytes())[1]
    modules = programs()
    assert set(types) == set(modules)
    for name, functions in types.items():
        assert functions
        for function, signatures in functions.items():
            for signature in signatures:
                getattr(modules[name], function).compile(signature)


def run_for(environment, *arguments):
    """Run this program in a process that compiles for another processor."""
    command = [sys.executable, "-m", "tests.processors", *map(str, arguments)]
    done = subprocess.run(command, cwd=ROOT, env=os.environ | environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]


if __name__ == "__main__":
    {"compute": compute, "assemble": assemble, "generate": generate}[sys.argv[1]](sys.argv[2])
