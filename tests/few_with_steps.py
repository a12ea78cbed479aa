"""Few particles with steps of their own as many would have them: left out is what an interval takes by itself.

A run of so few takes global steps, as ends of intervals take it longer; tests are to see what intervals do.
"""

from astroinertia.sph import rung_costs

BALL = """
[[bodies]]
kind = "uniform"
particles = {count}
mass = {mass}
radius = {radius}
relax = false
specific_internal_energy = 0.1
position = [{place}, 0.0, 0.0]
"""
# A tiny ball far from a large one. Damping ends the first step early: the second one is then of all the rungs that the
# tiny ball needs as it expands.
MANY_RUNGS = (
    'name = "apart"\nunits = "code"\n'
    + BALL.format(count=120, mass=1.0, radius=1.0, place=0.0)
    + BALL.format(count=16, mass=1e-9, radius=3e-5, place=5.0)
    + '[equation_of_state]\nkind = "ideal"\n[effects.pressure]\n[effects.viscosity]\n'
    + "[effects.damping]\ntime_scale = 1e6\nuntil = 1e-4\n"
    + '[numerics]\ntimesteps = "individual"\nprecision = "float64"\n[time]\nend = 1.0\n'
    + "[output]\nseries_every = 1.0\nsnapshot_every = 1.0\n"
)
CHOICE = {"STEP": 0.0, "BEGUN": 0.0, "ENDED": 0.0, "PAYS": 0.75}


def split_few() -> None:
    """In this process, for as long as it lasts."""
    for name, value in CHOICE.items():
        setattr(rung_costs, name, value)
