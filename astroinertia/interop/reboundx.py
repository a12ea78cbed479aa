"""A gravity field as REBOUNDx has it in its force `gravitational_harmonics`.

Source: Tamayo et al. 2020, MNRAS 491, 2885. Tests: tests/unit/interop/test_reboundx.py, tests/physics/test_reboundx.py.
"""

from astroinertia.inertia.gravity_field import GravityField
from astroinertia.process.quantities import with_quantities


@with_quantities()
def gravitational_harmonics(field: GravityField) -> dict[str, float]:
    """J2, J4 and R_eq by the names of a particle's parameters in REBOUNDx, R_eq in the field's unit of length.

    They are about z of the field; REBOUNDx takes z of the simulation for it, or the direction of the parameter Omega.
    It knows no other harmonics: what is not symmetric about z, odd degrees, and J6 and beyond are left out. ValueError
    for a field below degree 4.

    >>> from astroinertia.bodies.earth import prem_figure
    >>> parameters = gravitational_harmonics(prem_figure().gravity_field())
    >>> print({name: f"{value:.5g}" for name, value in parameters.items()})
    {'J2': '0.0010718', 'J4': '-2.9467e-06', 'R_eq': '6.3781e+06'}
    """
    if field.degree < 4:
        raise ValueError(f"gravitational_harmonics takes J2 and J4, and the field ends at degree {field.degree}")
    return {"J2": field.zonal_harmonic(2), "J4": field.zonal_harmonic(4), "R_eq": field.radius}
