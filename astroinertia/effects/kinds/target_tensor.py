"""A force that drives the body's second moment towards a prescribed one: to an elongation, an orientation, a size."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from astroinertia.effects import Characteristic, Effect, Entry, Found, Measure, Options, pytree, within_all
from astroinertia.effects.effect import moments
from astroinertia.inertia import target
from astroinertia.inertia.tensor import require_plausible
from astroinertia.units import REQUIRED, Option, positive

PARALLEL = 1e-6  # sine of the angle below which two directions do not span a plane
FLAT = 1e-12  # share of a target in a plane below which there is nothing of it there


@pytree
@dataclass(frozen=True, eq=False)
class TargetTensor(Effect):
    """a = A (x - c), A = -2 dE/dQ, of the penalty energy E in `astroinertia.inertia.target`, where its sources are.

    The target has the given principal moments, or the axis ratios of an ellipsoid at any size; along given axes, or
    along those that the body has. Near the target the body's strain swings at sqrt(4/3 stiffness) if it is round; with
    `damping` it comes to rest there. There is no net force, and a torque only towards given axes.
    """

    stiffness: Any
    axis_ratios: Any = None
    moments: Any = None
    first_axis: Any = None
    second_axis: Any = None
    orientation_stiffness: Any = None
    normal: Any = None

    kind: ClassVar[str] = "target_tensor"
    whole_body: ClassVar[bool] = True

    @property
    def central(self):
        """The virial tensor is symmetric where the orientation is free."""
        return self.first_axis is None

    @classmethod
    def from_options(cls, options):
        """Refuses no target or two, impossible moments, axes that are not two, and a stiffness of no axes."""
        if (options["axis_ratios"] is None) == (options["moments"] is None):
            raise ValueError("it needs one of axis_ratios and moments")
        if options["moments"] is not None:
            require_plausible(np.diag(options["moments"]))
            if not any(options["moments"]):
                raise ValueError("the moments must not all be zero")
        first, second = options["first_axis"], options["second_axis"]
        if (first is None) != (second is None):
            raise ValueError("it needs both first_axis and second_axis, or neither")
        if first is None:
            if options["orientation_stiffness"] is not None:
                raise ValueError("an orientation_stiffness needs first_axis and second_axis")
        elif np.linalg.norm(np.cross(first, second)) <= PARALLEL * np.linalg.norm(first) * np.linalg.norm(second):
            raise ValueError("first_axis and second_axis must not be parallel or zero")
        effect = cls(**options)
        if effect.normal is not None:
            across = np.asarray(effect.normal)
            wanted = effect.wanted(np)["target"]
            along = across @ wanted @ across / (across @ across)
            if np.trace(wanted) - along <= FLAT * np.trace(wanted):
                raise ValueError("the target has no extent in the plane across normal")
        return effect

    def axes(self, xp):
        """The target's axes as rows, (3, 3): the first as given, the second as near to the given one as it can be.

        In a plane without given axes the third is its normal, and the first anywhere in it. None where any will do.
        """
        if self.first_axis is None and self.normal is None:
            return None
        if self.first_axis is None:
            normal = xp.asarray(self.normal)
            first = xp.cross(xp.eye(3, dtype=normal.dtype)[xp.argmin(xp.abs(normal))], normal)  # far from parallel
            second = xp.cross(normal, first)
        else:
            first, second = xp.asarray(self.first_axis), xp.asarray(self.second_axis)
        first = first / xp.sqrt(first @ first)
        second = second - (first @ second) * first
        second = second / xp.sqrt(second @ second)
        return xp.stack([first, second, xp.cross(first, second)])

    def wanted(self, xp):
        """Arguments of the functions of `astroinertia.inertia.target` that say what is wanted."""
        if self.moments is None:
            values = xp.asarray(self.axis_ratios) ** 2
        else:
            values = 0.5 * xp.sum(xp.asarray(self.moments)) - xp.asarray(self.moments)
        return {
            "target": target.target_tensor(values, self.axes(xp)),
            "stiffness": self.stiffness,
            "orientation_stiffness": 0.0 if self.first_axis is None else self.orientation_stiffness,
            "free_size": self.moments is None,
            "normal": self.normal,
        }

    def matrix(self, xp, fluid):
        """A of the acceleration."""
        return target.target_matrix(moments(fluid)[0], **self.wanted(xp))

    def acceleration(self, xp, fluid):
        """A (x - c)."""
        return (fluid.position - fluid.centre) @ self.matrix(xp, fluid)

    def potential_energy(self, xp, fluid):
        """E of the second moment."""
        return target.target_energy(moments(fluid)[0], **self.wanted(xp))

    def virial(self, xp, fluid):
        """V = Q A."""
        return moments(fluid)[0] @ self.matrix(xp, fluid)

    def timestep(self, xp, fluid):
        """1/frequency of the fastest swing about the target that a body of this elongation can have."""
        wanted = self.wanted(xp)
        second, aim = moments(fluid)[0], wanted["target"]
        size = xp.trace(second) if self.moments is None else xp.trace(aim)
        stiffest = self.stiffness
        if self.orientation_stiffness is not None:
            stiffest = xp.maximum(xp.asarray(self.stiffness), self.orientation_stiffness)
        share = xp.sqrt(xp.sum(second**2)) / xp.where(size > 0, size, 1.0)
        matrix = self.matrix(xp, fluid)
        return 1.0 / xp.sqrt(4.0 * stiffest * share + xp.sqrt(xp.sum(matrix**2)) + 1e-60)


def _size(body: Characteristic, options: Options) -> Found:
    assert body.dynamical_time is not None
    number = options["stiffness"] * body.dynamical_time**2
    return number, within_all(options["stiffness"] * min(body.end, body.dynamical_time) ** 2)


ENTRY = Entry(
    "a force that drives the body's inertia tensor to a given elongation, orientation or size",
    {
        "stiffness": positive("inverse_time_squared", REQUIRED, "acceleration per distance, of size and elongation"),
        "axis_ratios": Option(
            "dimensionless", None, "ratios of the semi-axes that the body is to have, at any size", shape=(3,),
            minimum=0.0, exclusive=True,
        ),
        "moments": Option(
            "moment_of_inertia", None, "principal moments that it is to have; give these or axis_ratios",
            shape=(3,), minimum=0.0,
        ),
        "first_axis": Option(
            "dimensionless", None, "where the first of them points, beside second_axis; without both any way will do",
            shape=(3,),
        ),
        "second_axis": Option(
            "dimensionless", None, "where the second is, what is across the first; beside first_axis", shape=(3,)
        ),
        "orientation_stiffness": positive("inverse_time_squared", None, "of the orientation; as stiffness without it"),
        "normal": Option(
            "dimensionless", None, "of the plane that alone is driven, and the third axis where none is given; without "
            "it all space", shape=(3,), nonzero=True,
        ),
    },
    "particles", "Zajac, Jones & Glazier 2003; Merks et al. 2006", colour="orange", made=TargetTensor, rank=13,
    size=Measure(
        "stiffness times R^3/(G M)", "stiffness times t^2, or t_dyn^2",
        "Zajac, Jones & Glazier 2003", _size, ("mass", "radius"), ("stiffness",),
    ),
)  # fmt: skip
