"""Source text of pair functions as numba gets it."""

import re

from astroinertia.engines.numba_source import Sources
from astroinertia.sph.kernels import KERNELS


def halved_thirds(xp, q):
    return q / 3.0 / 2, 5.0 / 7.0 * q, 7.0 / q


def test_what_is_divided_by_a_number_is_multiplied_by_its_reciprocal() -> None:
    sources = Sources()
    sources.add(halved_thirds)
    text = sources.text()
    assert f"q * real({1 / 3!r}) * real(0.5), real(5.0) / real(7.0) * q, real(7.0) / q" in text


def test_potential_and_gradient_of_a_kernel_divide_by_the_same() -> None:
    for kernel in KERNELS.values():
        sources = Sources()
        for function in (kernel.phi, kernel.dphi):
            sources.add(function)
        over = re.findall(r"/ ([^r(].*?)\b", sources.text())
        assert over == ["p", "p"], kernel.name
