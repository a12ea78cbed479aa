"""Few particles with steps of their own as many would have them: left out is what an interval takes by itself.

A run of so few takes global steps, as ends of intervals take it longer; tests are to see what intervals do.
"""

from astroinertia.sph import rung_costs

CHOICE = {"STEP": 0.0, "BEGUN": 0.0, "ENDED": 0.0, "PAYS": 0.75}


def split_few() -> None:
    """In this process, for as long as it lasts."""
    for name, value in CHOICE.items():
        setattr(rung_costs, name, value)
