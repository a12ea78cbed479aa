"""What users' functions see of particles, in the plural, beside the same of the whole body in the singular.

A function that serves as a force (effects.by_function) and one that a run calls (run.state) have them by these names.
Tests: tests/unit/run/test_callback.py.
"""

OF_PARTICLES = {
    "masses": "mass",
    "positions": "position",
    "velocities": "velocity",
    "densities": "density",
    "smoothing_lengths": "smoothing_length",
    "internal_energies": "internal_energy",
    "pressures": "pressure",
    "sound_speeds": "sound_speed",
}
CENTRE_VELOCITY = "centre_of_mass_velocity"
