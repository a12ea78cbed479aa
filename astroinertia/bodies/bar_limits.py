"""T/|W| of the Maclaurin spheroids at which a bar can grow; other bodies come close to these.

Source: Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, ch. 5. Tests: tests/unit/bodies/test_break_up.py.
"""

SECULAR = 0.1375  # by friction or by gravitational waves
DYNAMICAL = 0.2738  # by itself
