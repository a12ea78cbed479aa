"""Problems of hydrodynamics with known solutions, on which trusted codes are tested: one file a problem.

A problem has `place(count, lengths, gamma)`, its particles at time 0 (about as many as asked for, in a box of those
lengths), `exact(position, time, lengths, gamma)`, and `compared(position, time, lengths)`, where that solution holds.
All in code units.
"""
