"""Hard cases of particles: each states what stable means, and all are held to the same figures.

Tests: tests/hard/test_particles_hard.py, tests/unit/verify/hard/test_hard.py.
"""

from astroinertia.verify.hard.arrangements import PLACES
from astroinertia.verify.hard.motions import MOTIONS
from astroinertia.verify.hard.numbers import NUMBERS

FAMILIES = {"Where particles lie": PLACES, "How they move": MOTIONS, "Numbers": NUMBERS}
CASES = {case.name: case for cases in FAMILIES.values() for case in cases}
