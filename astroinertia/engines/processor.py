"""What the processor that numba compiles for can do.

That need not be the processor at hand: NUMBA_CPU_NAME and NUMBA_CPU_FEATURES name another. LLVM is asked, as only it
knows which instructions a name implies. Tests: tests/unit/engines/test_processor.py, tests/physics/test_processors.py.
"""

import ctypes
import functools

import llvmlite.binding as llvm
import numpy as np
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

# 1/sqrt of a float32 as the processor estimates it, by bits of its vectors: up to 6e-5 off with AVX-512, 3.7e-4 else.
ROOTS = {
    512: """
    declare <4 x float> @llvm.x86.avx512.rsqrt14.ss(<4 x float>, <4 x float>, <4 x float>, i8)
    define float @root(float %x) {
      %given = insertelement <4 x float> zeroinitializer, float %x, i32 0
      %found = call <4 x float> @llvm.x86.avx512.rsqrt14.ss(
        <4 x float> %given, <4 x float> %given, <4 x float> zeroinitializer, i8 -1)
      %y = extractelement <4 x float> %found, i32 0
      ret float %y
    }
    """,
    256: """
    declare <4 x float> @llvm.x86.sse.rsqrt.ps(<4 x float>)
    define float @root(float %x) {
      %given = insertelement <4 x float> zeroinitializer, float %x, i32 0
      %found = call <4 x float> @llvm.x86.sse.rsqrt.ps(<4 x float> %given)
      %y = extractelement <4 x float> %found, i32 0
      ret float %y
    }
    """,
}
FEATURES = {512: "avx512f", 256: "avx2"}
SAMPLES = 4096  # over a factor of four, after which the estimates repeat


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


@functools.cache
def mean_estimates(bits: int) -> tuple[float, float]:
    """Of the estimate of 1/sqrt over the exact one, with vectors of so many bits: the mean, and that of the cube.

    Both are 1 where this processor has no such vectors. The argument's logarithm is uniform. Only the bounds of the
    errors, 2^-14 and 1.5 2^-12, are the same for all processors.
    """
    if not llvm.get_host_cpu_features().get(FEATURES[bits]):
        return 1.0, 1.0
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    here = llvm.Target.from_default_triple().create_target_machine(features=f"+{FEATURES[bits]}")
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(ROOTS[bits]), here)
    engine.finalize_object()
    root = ctypes.CFUNCTYPE(ctypes.c_float, ctypes.c_float)(engine.get_function_address("root"))
    x = np.exp2(2.0 * np.arange(SAMPLES) / SAMPLES).astype(np.float32).astype(float)
    share = np.array([root(value) for value in x]) * np.sqrt(x)
    return float(share.mean()), float((share**3).mean())
