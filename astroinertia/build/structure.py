"""What a run's description has of the body at the start, from which its radii follow later (dataset.radii).

Tests: tests/unit/dataset/test_radii.py.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from astroinertia.build.spheres import Star
from astroinertia.build.spin import rigid_moments
from astroinertia.models.protocol import Evolution
from astroinertia.observables.quantities import ENCLOSED, LAYERS_DEGREE
from astroinertia.scene.schema import Scene
from astroinertia.sph.profiles import Profile
from astroinertia.units import CodeUnits

_SHELLS, _SHELL_NODES = 512, 4


def structure(scene: Scene, units: CodeUnits, initial: Any) -> dict[str, float]:
    """Numbers without a unit, as far as the body has them; `initial` is that of spheres.sphere.

    equatorial_second_moment and polar_second_moment: sum m x^2 along an axis over M and the square of the semi-axis of
    the surface; mean_second_moment: tr Q/3 over M R^2, where only one radius is known. half_mass and enclosing_99: the
    mean radius of what encloses so much of the mass, over that of the surface; mean_radius: of the surface, in code
    units; radial_moment_2 and so on, of similar layers: the means of s^2 and so on over the mass, s the semi-axes over
    those of the surface. Several bodies together have none.
    """
    if scene.bodies:
        return {}
    if isinstance(initial, Star):
        star = initial.star
        shares = {
            "mean_radius": star.mean_radius,
            "half_mass": star.mean_radius_enclosing(0.5) / star.mean_radius,
            "enclosing_99": star.mean_radius_enclosing(ENCLOSED) / star.mean_radius,
        }
        if star.polar_radius == 0.0:  # a ring: as the sphere of its volume
            return {"mean_second_moment": star.mean_moment / 2 / (star.mass * star.mean_radius**2), **shares}
        along = star.equatorial_moment - star.polar_moment / 2
        return {
            "equatorial_second_moment": star.polar_moment / 2 / (star.mass * star.equatorial_radius**2),
            "polar_second_moment": along / (star.mass * star.polar_radius**2),
            **shares,
        }
    if initial is not None:
        profile = initial.profile
        half, most = (float(share) for share in profile.radius(np.array([0.5, ENCLOSED])))
        moment = float(profile.second_moment)
        return {
            "equatorial_second_moment": moment, "polar_second_moment": moment,
            "half_mass": half, "enclosing_99": most,
            "mean_radius": initial.radius * float(np.prod(getattr(scene.body, "axes", (1.0,)))) ** (1 / 3),
            **_radial_moments(profile),
        }  # fmt: skip
    body: Any = scene.body
    if not body.solid or body.radius is None:
        return {}
    size = units.to_code(body.mass, "mass") * units.to_code(body.radius, "length") ** 2
    return {"mean_second_moment": float(np.sum(rigid_moments(scene, units)[0])) / 6 / size}


def _radial_moments(profile: Profile) -> dict[str, float]:
    """1 - int l s^(l - 1) m(s) ds for even l, by Gauss's rule on shells narrow enough for jumps of the density."""
    nodes, weights = np.polynomial.legendre.leggauss(_SHELL_NODES)
    s = ((np.arange(_SHELLS)[:, None] + 0.5 * (nodes + 1)) / _SHELLS).ravel()
    enclosed = np.tile(0.5 * weights / _SHELLS, _SHELLS) * profile.enclosed(s)
    higher = {degree: 1 - degree * float(s ** (degree - 1) @ enclosed) for degree in range(4, LAYERS_DEGREE + 1, 2)}
    return {
        f"radial_moment_{degree}": value for degree, value in ({2: 3 * float(profile.second_moment)} | higher).items()
    }


def as_begun(structure: Mapping[str, float], evolution: Evolution) -> dict[str, float]:
    """The structure with enclosing_99 as the body has it that begins: particles at the surface are a layer within it.

    So the surface of particles at the start is that of the body which they stand for, however many they are.
    """
    snapshot = evolution.snapshot() if "mean_radius" in structure else None
    if snapshot is None:
        return dict(structure)
    from astroinertia.models.sph.extent import extent  # only where there are particles

    mass, position = snapshot["mass"], snapshot["position"]
    ellipsoid = extent(mass, position - mass @ position / mass.sum())["enclosing_ellipsoid"]
    if not np.isfinite(ellipsoid).all():
        return dict(structure)
    return {**structure, "enclosing_99": float(np.linalg.det(ellipsoid) ** (1 / 6)) / structure["mean_radius"]}
