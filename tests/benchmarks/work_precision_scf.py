"""Error against time of the self-consistent field solver: exact and converged stars by the degree of its harmonics."""

import sys
from pathlib import Path

from precision_table import publish, table

sys.path.insert(0, str(Path(__file__).parents[2]))  # run as a script: the tests' own bodies are beside it

from astroinertia.bodies import maclaurin
from astroinertia.bodies.rotating_star import RotatingStar
from astroinertia.bodies.rotation_laws import RIGID, RotationLaw
from astroinertia.bodies.scf import Resolution, solve_field
from astroinertia.matter.barotropes import polytropic_matter
from tests.exact_polytropes import exact_polytrope

DEGREES = (8, 16, 32, 48, 96)
DEFAULT = 48


def star(index: float, axis_ratio: float, degree: int, law: RotationLaw = RIGID) -> RotatingStar:
    """As many angles, and elements in proportion: what the degree can use. Coarse ones are not refused here."""
    resolution = Resolution(max(2, degree // 6), degree, degree)
    return RotatingStar(solve_field(polytropic_matter(index), axis_ratio, law, resolution))


def errors(found: RotatingStar, rate: float, moment: float, energy: float) -> float:
    """The largest relative error of Omega^2 a^3/(GM), C/(M a^2) and T/|W|."""
    return max(
        abs(found.rotation_parameter / rate - 1),
        abs(found.polar_moment_ratio_equatorial / moment - 1),
        abs(found.rotational_to_gravitational / energy - 1),
    )


def against(title: str, index: float, axis_ratio: float, exact, law: RotationLaw = RIGID, degrees=DEGREES) -> str:
    """A table by degree; `exact` has rotation_parameter, polar_moment_ratio_equatorial and T/|W|."""
    truth = exact.rotation_parameter, exact.polar_moment_ratio_equatorial, exact.rotational_to_gravitational
    return table(title, "degree", degrees, lambda degree: star(index, axis_ratio, degree, law),
                 lambda found: errors(found, *truth), DEFAULT)  # fmt: skip


def main() -> None:
    """Print the tables."""
    exact = exact_polytrope(rotation_parameter=0.25)
    hollow = RotationLaw("j_constant", 0.2)
    publish(
        "scf",
        [
            against("Maclaurin spheroid, axis ratio 0.8", 0.0, 0.8, maclaurin.from_axis_ratio(0.8)),
            against("n = 1, q = 0.25, against the spectral solution", 1.0, exact.axis_ratio, exact),
            against("n = 1.5 near mass shedding, axis ratio 0.62, against degree 160", 1.5, 0.62, star(1.5, 0.62, 160)),
            against("n = 3, axis ratio 0.7, against degree 160", 3.0, 0.7, star(3.0, 0.7, 160)),
            against(
                "n = 1.5, j-constant with A = 0.2, axis ratio 0.5, against degree 160",
                1.5,
                0.5,
                star(1.5, 0.5, 160, hollow),
                hollow,
            ),
            against(
                "Ring of n = 1.5, radii 0.5 to 1, against degree 160",
                1.5,
                -0.5,
                star(1.5, -0.5, 160),
                degrees=(32, 48, 64, 96),
            ),
        ],
    )


if __name__ == "__main__":
    main()
