"""What the processor that numba compiles for can do.

That need not be the processor at hand: NUMBA_CPU_NAME and NUMBA_CPU_FEATURES name another. LLVM is asked, as only it
knows which instructions a name implies. Tests: tests/unit/engines/test_processor.py, tests/physics/test_processors.py.
"""

import llvmlite.binding as llvm
from numba.core import codegen, config

# Each program, compiled for a processor that has the vectors, holds the instruction on registers of that name.
PROBES = {
    512: (
        """
        declare <16 x i32> @llvm.experimental.vector.compress.v16i32(<16 x i32>, <16 x i1>, <16 x i32>)
        define <16 x i32> @probe(<16 x i32> %values, <16 x i1> %kept) "min-legal-vector-width"="512" {
          %closed = call <16 x i32> @llvm.experimental.vector.compress.v16i32(
            <16 x i32> %values, <16 x i1> %kept, <16 x i32> undef)
          ret <16 x i32> %closed
        }
        """,
        "vpcompressd",
        "zmm",
    ),
    256: (
        """
        define <8 x i32> @probe(<8 x i32> %a, <8 x i32> %b) {
          %sum = add <8 x i32> %a, %b
          ret <8 x i32> %sum
        }
        """,
        "vpaddd",
        "ymm",
    ),
}


def vector_bits() -> int:
    """Bits of the widest vectors that can be compacted: 512 with AVX-512, 256 with AVX2, 0 with neither.

    0 too where numba is switched off and programs run as Python.
    """
    if config.DISABLE_JIT:  # type: ignore[attr-defined]
        return 0
    return next((bits for bits, probe in PROBES.items() if _holds(*probe)), 0)


def target_machine() -> llvm.TargetMachine:
    """LLVM's machine for the processor that numba compiles for."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    features = config.CPU_FEATURES  # type: ignore[attr-defined]
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=config.CPU_NAME or llvm.get_host_cpu_name(),  # type: ignore[attr-defined]
        features=codegen.get_host_cpu_features() if features is None else features,
    )


def _holds(program: str, instruction: str, register: str) -> bool:
    assembly = target_machine().emit_assembly(llvm.parse_assembly(program))
    return any(instruction in line and register in line for line in assembly.splitlines())
