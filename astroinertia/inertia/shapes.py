"""The standard shapes as bodies, in closed form: mass and sizes in, a `Body` out.

Every shape is centred at its centre of mass with its symmetry axis along z, unless its docstring says otherwise, and is
homogeneous. Mass and sizes are numpy or jax arrays (...,) in any consistent units, which broadcast; lists and numbers
do, too. A mass may be negative: a hole. In the docstrings <x^2> is the mean square of x over the mass, about the centre
of mass, and I_xx = m (<y^2> + <z^2>) and so on; the places of ends, edges and faces are given, so that
`rod(m, l).about([0, 0, l / 2])` is the tensor about an end. Sizes that are not finite or not positive are a ValueError
in numpy and eager jax; inside jit they are not seen. Checked by tests/unit/inertia/test_shapes.py against quadrature,
random points and the published tables in tests/reference/solids.json.
"""

from astroinertia.inertia.plates import (
    annulus,
    disc,
    elliptic_disc,
    hoop,
    point,
    polygon_plate,
    rectangular_plate,
    regular_polygon_plate,
    rod,
    triangle_plate,
)
from astroinertia.inertia.shells import (
    closed_can,
    cone_shell,
    frustum_shell,
    hemispherical_shell,
    homoeoid_shell,
    spherical_cap_shell,
    spherical_shell,
    thin_tube,
    torus_shell,
)
from astroinertia.inertia.solids import (
    box,
    capsule,
    cone,
    cylinder,
    ellipsoid,
    elliptic_cylinder,
    frustum,
    hemisphere,
    hollow_box,
    layered_sphere,
    paraboloid,
    prism,
    rectangular_pyramid,
    regular_polyhedron,
    solid_sphere,
    spherical_cap,
    spherical_sector,
    tetrahedron,
    thick_cylinder,
    thick_spherical_layer,
    torus,
)

__all__ = [
    "annulus", "box", "capsule", "closed_can", "cone", "cone_shell", "cylinder", "disc", "ellipsoid",
    "elliptic_cylinder", "elliptic_disc", "frustum", "frustum_shell", "hemisphere", "hemispherical_shell",
    "hollow_box", "homoeoid_shell", "hoop", "layered_sphere", "paraboloid", "point", "polygon_plate", "prism",
    "rectangular_plate", "rectangular_pyramid", "regular_polygon_plate", "regular_polyhedron", "rod", "solid_sphere",
    "spherical_cap", "spherical_cap_shell", "spherical_sector", "spherical_shell", "tetrahedron", "thick_cylinder",
    "thick_spherical_layer", "thin_tube", "torus", "torus_shell", "triangle_plate",
]  # fmt: skip
