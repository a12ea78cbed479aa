"""The sums of a step are the same on every class of processors, whose programs differ.

Numba compiles for the processor that its environment names. What this machine cannot run is compiled all the same.
"""

import pickle

import numpy as np

from astroinertia.engines.processor import vector_bits
from astroinertia.gravity.direct import DIRECT_GRAVITY
from tests import pairs, processors
from tests.processors import ETA, KERNEL, PROCESSORS, TERMS

# Errors in units of the sum of the terms' sizes: rounding in float64, in float32 with differences of large numbers.
BARS = {"float64": 1e-11, "mixed": 1e-4}
# Multipoles' near pairs in float32 are up to 1.1e-3 off, where the processor estimates 1/r to 12 bits, and average out.
MULTIPOLE_BARS = {"float64": 1e-11, "mixed": 2e-4}


def all_pairs():
    """What the sums are, and the sums of the sizes of their terms, from all pairs in one array; of few besides."""
    _, fields = processors.fields_of_a_step()
    few = of_all_pairs({name: array[: processors.FEWER] for name, array in fields.items()})
    return of_all_pairs(fields) | {f"few {name}": value for name, value in few.items()}


def of_all_pairs(fields):
    """The same of these particles."""
    fields = dict(fields)
    solved = vars(pairs.density(KERNEL, fields["position"], fields["mass"], ETA))
    fields["smoothing_length"] = solved["smoothing_length"]
    values = dict(solved)
    sums = pairs.pair_sums(TERMS, fields, KERNEL, scale=True)
    values |= {f"{effect} {key}": value for effect, each in sums.items() for key, value in each.items()}
    gravity = pairs.pair_sums((DIRECT_GRAVITY,), fields, KERNEL, all_pairs=True, scale=True)["gravity"]
    return values | {f"direct {key}": value for key, value in gravity.items()}


def errors(found, expected):
    """The largest error of each sum over the sum of the sizes of its terms, or over the largest value."""
    result = {}
    for name, value in found.items():
        scale = expected.get(f"{name} scale", np.abs(expected[name]).max())
        difference = np.abs(value - expected[name])
        result[name] = np.max(
            difference / np.reshape(scale, np.shape(scale) + (1,) * (difference.ndim - np.ndim(scale)))
        )
    return result


def exceeding(found, bar):
    """Those that are not below a bar, with NaN among them."""
    return {name: error for name, error in found.items() if not error < bar}


def check(found, usual, expected):
    """The sums are those of all pairs; multipoles are those of another processor besides, opened at the same nodes."""
    assert set(found) == set(BARS)
    for precision, sums in found.items():
        fast = {key: value for key, value in sums.items() if key.startswith("multipole")}
        assert not exceeding(errors({key: sums[key] for key in sums if key not in fast}, expected), BARS[precision])
        scales = {f"{key} scale": expected[f"direct {key.split()[1]} scale"] for key in fast}
        assert not exceeding(errors(fast, usual[precision] | scales), MULTIPOLE_BARS[precision])
        direct, acceleration = expected["direct acceleration"], fast["multipole acceleration"]
        relative = np.linalg.norm(acceleration - direct, axis=1) / np.linalg.norm(direct, axis=1)
        assert 1e-6 < np.sqrt(np.mean(relative**2)) < processors.ACCURACY  # by expansions


def test_sums_of_a_step_are_the_same_on_every_processor(tmp_path):
    """One test, for all of them are compared with what the default settings give."""
    expected, usual = all_pairs(), tmp_path / "usual"
    processors.run_for({}, "compute", usual)
    sums, types = pickle.loads(usual.read_bytes())
    check(sums, sums, expected)
    for name, processor in PROCESSORS.items():
        if not processor.is_here:
            processors.run_for(processor.environment, "generate", usual)
        elif processor.bits != vector_bits():
            # Plain loops name no instruction of one family of processors.
            mode, kept = "compute" if processor.bits else "assemble", {"NUMBA_CACHE_DIR": str(tmp_path / name)}
            processors.run_for(processor.environment | kept, mode, tmp_path / "sums")
            found, others, *sizes = pickle.loads((tmp_path / "sums").read_bytes())
            check(found, sums, expected)
            if mode == "assemble":
                programs = {(name, function) for name, functions in others.items() for function in functions}
                assert set(sizes[0]) == programs == {(name, f) for name, functions in types.items() for f in functions}
                assert min(sizes[0].values()) > 1000
