"""What a run's description has of the body at the start, from which its radii follow later (dataset.radii).

Tests: tests/unit/dataset/test_radii.py.
"""

from typing import Any

import numpy as np

from astroinertia.build.spheres import Star
from astroinertia.build.spin import rigid_moments
from astroinertia.observables.quantities import ENCLOSED
from astroinertia.scene.schema import Scene
from astroinertia.units import CodeUnits


def structure(scene: Scene, units: CodeUnits, initial: Any) -> dict[str, float]:
    """Numbers without a unit, as far as the body has them; `initial` is that of spheres.sphere.

    equatorial_second_moment and polar_second_moment: sum m x^2 along an axis over M and the square of the semi-axis of
    the surface; mean_second_moment: tr Q/3 over M R^2, where only one radius is known. half_mass and enclosing_99: the
    mean radius of what encloses so much of the mass, over that of the surface.
    """
    if isinstance(initial, Star):
        star = initial.star
        shares = {
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
        }  # fmt: skip
    body: Any = scene.body
    if not body.solid or body.radius is None:
        return {}
    size = units.to_code(body.mass, "mass") * units.to_code(body.radius, "length") ** 2
    return {"mean_second_moment": float(np.sum(rigid_moments(scene, units)[0])) / 6 / size}
