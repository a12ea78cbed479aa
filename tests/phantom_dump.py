"""Dumps of Phantom for tests: bytes written by the format's description (Phantom's documentation, "dumpfile")."""

import numpy as np

COUNT = 7
RANDOM = np.random.default_rng(31)
PARTICLES = {name: RANDOM.normal(size=COUNT) for name in ("x", "y", "z", "vx", "vy", "vz")} | {
    "u": RANDOM.random(COUNT)
}
SMOOTHING = np.full(COUNT, 0.5, np.float32)  # Phantom writes h in single precision
UNITS = {"udist": 6.957e10, "umass": 1.98841e33, "utime": 1594.0, "umagfd": 1.0}  # a solar radius and mass, G about 1
MASS = 0.125
TYPES = ("i4", "i1", "i2", "i4", "i8", "f8", "f4", "f8")  # in a dump's order: the first and the sixth are the defaults
MARKS = (60769, 60878, 60878, 1, 690706)  # integer, real, integer, version, integer


def record(content):
    tag = np.int32(len(content)).tobytes()
    return tag + content + tag


def dump(header, *blocks, order="<", real="f8", integer="i4", processes=1):
    """A dump's bytes: header by name, blocks of columns by name; repeated names end in a number, as sarracen has it."""
    types = (integer, *TYPES[1:5], real, *TYPES[6:])
    swapped = [np.dtype(order + each) for each in types]

    def of(kind, values):
        return np.asarray(values, dtype=swapped[kind]).tobytes()

    def closed(content):
        tag = np.asarray(len(content), dtype=f"{order}i4").tobytes()
        return tag + content + tag

    def named(names):
        return "".join(name.partition("#")[0].ljust(16) for name in names).encode()

    identifier = "FT:Phantom:2026.0.0:0000000 (hydro): 01/01/2026 00:00:00.0".ljust(100).encode()
    opening = b"".join(of(kind, mark) for kind, mark in zip((0, 5, 0, 0, 0), MARKS, strict=True))
    content = closed(opening) + closed(identifier)
    for kind in range(len(types)):
        of_kind = header.get(kind, {})
        content += closed(np.asarray(len(of_kind), dtype=f"{order}i4").tobytes())
        if of_kind:
            content += closed(named(of_kind)) + closed(of(kind, list(of_kind.values())))
    content += closed(np.asarray(len(blocks), dtype=f"{order}i4").tobytes())
    for first in range(0, len(blocks), len(blocks) // processes):
        of_process = blocks[first : first + len(blocks) // processes]
        for block in of_process:
            length = max((len(values) for columns in block.values() for values in columns.values()), default=0)
            numbers = [len(block.get(kind, {})) for kind in range(len(types))]
            content += closed(np.asarray(length, f"{order}i8").tobytes() + np.asarray(numbers, f"{order}i4").tobytes())
        for block in of_process:
            for kind in range(len(types)):
                for name, values in block.get(kind, {}).items():
                    content += closed(named([name])) + closed(of(kind, values))
    return content


def header(masses=(MASS,), units=UNITS, processes=1):
    masses = {f"massoftype#{kind}": mass for kind, mass in enumerate(masses)}
    return {0: {"nparttot": COUNT, "nblocks": processes}, 5: {"time": 0.0, **masses}, 7: units}


def gas(kinds=None, smoothing=SMOOTHING, particles=PARTICLES):
    small = {} if kinds is None else {1: {"itype": kinds}}
    return {0: {"iorig": np.arange(COUNT)}, **small, 5: particles, 6: {"h": smoothing}}
