"""Bodies that have a wanted inertia tensor: point masses, ellipsoids, layered ellipsoids, and fits of any parameters.

Tensors are about the centre of mass, (3, 3), in numpy and any consistent units; bodies are centred at the origin, in
the same axes. A tensor that no body has is refused with the inequality that fails (`tensor.require_plausible`).
Checked by tests/unit/inertia/test_realise.py.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from astroinertia.inertia.gravity_field import GravityField, layered_field
from astroinertia.inertia.principal import principal_frame
from astroinertia.inertia.tensor import inertia_from_second_moment, require_plausible, second_moment_from_inertia
from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import with_quantities
from astroinertia.process.roots import root_between

Array = Any

ROUND_OFF = 1e-14  # share of the largest second moment that the others, differences of moments, cannot tell from 0
SAME = 1e-12  # relative difference of two numbers that are meant to be equal
# Corners of a cube that make a regular tetrahedron: their mean is 0, and that of x (x) x is the unit tensor.
TETRAHEDRON = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])


@dataclass(frozen=True)
class LayeredEllipsoid:
    """Layers between similar ellipsoids, from the inside out: semi_axes (n, 3) of their outer faces, densities (n,).

    axes (3, 3): directions of the semi-axes as rows. One layer is a homogeneous ellipsoid.

    >>> print(f"{homogeneous_ellipsoid(np.diag([5.0, 10.0, 13.0]), mass=5.0).mass:.4f}")
    5.0000
    """

    semi_axes: np.ndarray
    densities: np.ndarray
    axes: np.ndarray

    @property
    def mass(self) -> float:
        """M = sum (rho_k - rho_k+1) 4 pi/3 a_k b_k c_k."""
        return float(self._masses().sum())

    @property
    def inertia(self) -> np.ndarray:
        """About the centre, (3, 3): full ellipsoids of the steps in density, Q = M a (x) a/5 each, put together."""
        values = self._masses() @ self.semi_axes**2 / 5.0
        return inertia_from_second_moment(np.einsum("k,ki,kj->ij", values, self.axes, self.axes))

    @with_quantities()
    def gravity_field(self, degree: int, radius: float) -> GravityField:
        """The field about the centre, with a reference radius."""
        return layered_field(self.densities, self.semi_axes, degree, radius).rotated(self.axes.T)

    def _masses(self) -> np.ndarray:
        steps = self.densities - np.append(self.densities[1:], 0.0)
        return 4.0 / 3.0 * np.pi * steps * self.semi_axes.prod(1)


@with_quantities()
def point_masses(inertia: Array, mass: float | None = None, radius: float | None = None) -> tuple[Array, Array]:
    """The fewest point masses with a tensor: masses (n,) and positions (n, 3) about their centre, all equally far off.

    inertia (3, 3). They are one more than the dimensions that the body extends in: two for a rod, three for a lamina,
    four for a solid; they lie at the distance sqrt(tr Q/M) from the centre. Give the total mass, or that distance as
    `radius`, from which the mass follows; with both, what mass is left over lies at the centre as one point more.
    ValueError: an impossible tensor; neither given; a mass and radius with M r^2 < tr Q, which no points have.
    Source: equimomental systems (Routh 1905, Dynamics of a System of Rigid Bodies, Elementary Part, articles 33 to 43);
    for a lamina an isosceles triangle on a circle, for which the same equations have one solution.

    >>> mass, position = point_masses(np.diag([3.0, 4.0, 5.0]), mass=2.0)
    >>> print(len(mass), np.diag(np.einsum("n,ni,nj->ij", mass, position, position)).round(12))  # tr(I)/2 - I
    4 [3. 2. 1.]
    """
    second, axes = _principal_second_moments(inertia)
    total = second.sum()
    for name, value in (("mass", mass), ("radius", radius)):
        if value is not None and not 0 < value < np.inf:
            raise ValueError(f"the {name} must be positive and finite, and is {value:g}")
    if total == 0.0:
        if mass is None:
            raise ValueError("a tensor of zeros is that of one point, whose mass must be given")
        return np.array([mass]), np.zeros((1, 3))
    if radius is None:
        if mass is None:
            raise ValueError("point masses need a total mass, a radius or both")
        outer = mass
    else:
        outer = total / radius**2
    share, place = _unit_points(second / outer)
    masses, places = outer * share, place @ axes
    if mass is None or abs(mass - outer) <= SAME * outer:
        return masses, places
    if mass < outer:
        raise ValueError(
            f"no points within this radius have this tensor: mass x radius^2 >= tr(I)/2 fails, for "
            f"{mass * radius**2:.6g} < {total:.6g}"  # type: ignore[operator]
        )
    return np.append(masses, mass - outer), np.concatenate([places, np.zeros((1, 3))])


@with_quantities()
def homogeneous_ellipsoid(inertia: Array, mass: float | None = None, density: float | None = None) -> LayeredEllipsoid:
    """The homogeneous ellipsoid with this tensor and this mass, or this density; longest semi-axis first.

    a_k^2 = 5 Q_k/M; a density gives M^(5/2) = rho 4 pi/3 5^(3/2) sqrt(Q_1 Q_2 Q_3). ValueError: an impossible tensor;
    not exactly one of mass and density; a flat tensor, I_1 + I_2 = I_3, for which the density would be infinite.

    >>> print(homogeneous_ellipsoid(np.diag([5.0, 10.0, 13.0]), mass=5.0).semi_axes.round(12))
    [[3. 2. 1.]]
    """
    if (mass is None) == (density is None):
        raise ValueError("an ellipsoid needs its mass or its density, and not both")
    second, axes = _solid(inertia)
    if density is not None:
        require_positive(density=density)
        mass = float((density * 4.0 / 3.0 * np.pi * 5.0**1.5) ** 0.4 * (second**0.2).prod())
    assert mass is not None
    require_positive(mass=mass)
    semi_axes = np.sqrt(5.0 * second / mass)
    with np.errstate(over="ignore", under="ignore"):
        found = float(np.divide.reduce([mass / (4.0 / 3.0 * np.pi), *semi_axes]))
    if not 0.0 < found < np.inf:
        raise ValueError(f"the semi-axes are {semi_axes}, and the density lies beyond what numbers hold")
    return LayeredEllipsoid(semi_axes[None], np.array([found]), axes)


@with_quantities()
def layered_ellipsoid(
    inertia: Array, mass: float, densities: Sequence[float], boundaries: Sequence[float] | None = None
) -> LayeredEllipsoid:
    """The ellipsoid of similar layers with this tensor, mass and densities, given from the inside out.

    Two layers or more. The inner boundaries keep the proportions `boundaries`, ascending, one fewer than layers (evenly
    spaced where they are not given), and grow together until the body has the tensor; of two solutions, which layers
    lighter than those around them can have, the smaller core. With x the outermost inner boundary over the surface and
    p the proportions to it, f_n = rho_out + sum (rho_k - rho_k+1) (x p_k)^n,

        M = 4 pi/3 r^3 f_3,   (Q_1 Q_2 Q_3)^(1/3) = M r^2/5 f_5/f_3,   r^3 = a b c,

    of which f_5 f_3^(-5/3) = rho_h^(-2/3) is left, where rho_h is the density of the homogeneous ellipsoid with this
    tensor and mass. ValueError: an impossible or flat tensor, densities that are not positive, and a rho_h out of
    reach, with what it would have to lie between.

    >>> print(layered_ellipsoid(0.36 * np.eye(3), 1.0, (0.5, 0.2)).semi_axes[:, 0].round(4))  # core, and surface
    [0.4878 1.0065]
    """
    require_positive(densities=densities)
    values = np.array(densities)
    proportions = np.arange(1.0, len(values)) if boundaries is None else np.asarray(boundaries, dtype=float)
    if len(values) < 2 or len(proportions) != len(values) - 1:
        raise ValueError("a layered ellipsoid needs two densities or more, and one boundary fewer than densities")
    if proportions[0] <= 0 or (np.diff(proportions) <= 0).any():
        raise ValueError("the boundaries of the layers must be positive and ascend")
    proportions = proportions / proportions[-1]
    plain = homogeneous_ellipsoid(inertia, mass=mass)
    wanted = float(plain.densities[0])
    steps = (values[:-1] - values[1:]) / wanted

    def sums(x: float) -> tuple[float, float]:
        third, fifth = (values[-1] / wanted + steps @ (x * proportions) ** power for power in (3, 5))
        return float(third), float(fifth)

    def share(x: float) -> float:  # of the wanted density that the homogeneous ellipsoid of such layers has
        third, fifth = sums(x)
        return third * (third / fifth) ** 1.5

    # f_5 f_3^(-5/3) turns at most once, where x^2 sum steps p^5 = sum steps p^3.
    third, fifth = steps @ proportions**3, steps @ proportions**5
    turn = [(third / fifth) ** 0.5] if fifth != 0 and 0 < third / fifth < 1 else []
    ends = [0.0, *turn, 1.0]
    shares = [share(end) for end in ends]
    reached = [value - 1.0 for value in shares]
    x = next((end for end, value in zip(ends, reached, strict=True) if abs(value) <= SAME), None)
    if x is None:
        part = next((k for k in range(len(ends) - 1) if reached[k] * reached[k + 1] < 0), None)
        if part is None:
            low, high = (value * wanted for value in (min(shares), max(shares)))
            raise ValueError(
                f"no such layers have this tensor and mass: a homogeneous ellipsoid with them has the density "
                f"{wanted:.6g}, and {low:.6g} <= {wanted:.6g} <= {high:.6g} fails"
            )
        x = root_between(lambda x: share(x) - 1.0, ends[part], ends[part + 1], 1e-16)
    third, fifth = sums(x)
    outer = plain.semi_axes[0] * (third / fifth) ** 0.5
    return LayeredEllipsoid(np.append(x * proportions, 1.0)[:, None] * outer, values, plain.axes)


@with_quantities()
def two_layer_ellipsoid(inertia: Array, mass: float, mean_density: float, outer_density: float) -> LayeredEllipsoid:
    """The ellipsoid of two layers with this tensor, mass, mean density and density of the outer layer.

    Its size follows from the mean density; core radius x and core density from k = 2 (Q_1 Q_2 Q_3)^(1/3)/(M r^2), which
    for a sphere is I/(M R^2): x^2 = (5/2 k rho_mean - rho_out)/(rho_mean - rho_out), rho_core = rho_out +
    (rho_mean - rho_out)/x^3 (e.g. Murray & Dermott 1999, Solar System Dynamics, section 4.5). ValueError: an impossible
    or flat tensor, equal densities, and a core of impossible size or density, with the inequality that fails.

    >>> density = 3 / (4 * np.pi)  # of a ball with M = R = 1, whose core is denser
    >>> earth = two_layer_ellipsoid(0.33 * np.eye(3), 1.0, density, 0.8 * density)
    >>> print(earth.semi_axes[:, 0].round(3), (earth.densities / density).round(3))
    [0.354 1.   ] [5.325 0.8  ]
    """
    second, axes = _solid(inertia)
    require_positive(mass=mass, mean_density=mean_density, outer_density=outer_density)
    size = (3.0 * mass / (4.0 * np.pi * mean_density)) ** (1.0 / 3.0)
    mean = float(np.cbrt(second).prod())
    if mean_density == outer_density:
        raise ValueError("an outer layer as dense as the whole leaves no core to be found")
    squared = (5.0 * mean / (mass * size**2) * mean_density - outer_density) / (mean_density - outer_density)
    if not 0.0 < squared < 1.0:
        raise ValueError(f"no core has this tensor: 0 < x^2 < 1 fails for its radius x, for x^2 = {squared:.6g}")
    core = outer_density + (mean_density - outer_density) / squared**1.5
    if core <= 0.0:
        raise ValueError(f"no core has this tensor: its density > 0 fails, for it would be {core:.6g}")
    outer = size * np.sqrt(second / mean)
    return LayeredEllipsoid(np.stack([squared**0.5 * outer, outer]), np.array([core, outer_density]), axes)


@dataclass(frozen=True)
class Fit:
    """Parameters found, in the structure of the first ones; their tensor (3, 3); misfit |I - I_wanted|/|I_wanted|.

    >>> import jax.numpy as jnp
    >>> print(fit_to_tensor(lambda a: a * jnp.eye(3), 1.0, 4.0 * np.eye(3)).misfit < 1e-6)
    True
    """

    parameters: Any
    inertia: np.ndarray
    misfit: float
    evaluations: int


@with_quantities()
def fit_to_tensor(
    inertia_of: Callable[[Any], Array], start: Any, inertia: Array, bounds: tuple[Any, Any] | None = None
) -> Fit:
    """Parameters whose tensor is nearest to the wanted one, by least squares with exact gradients.

    inertia_of: a function of jax from parameters to a tensor (3, 3), for example of a scene's body after some steps of
    the xla engine; start: first parameters, an array or any pytree; bounds: least and greatest, structured alike. The
    distance is the Frobenius norm. A wanted tensor that is not reached shows in the misfit; an impossible one is a
    ValueError. Scipy's trust-region reflective method (Branch, Coleman & Li 1999, SIAM J. Sci. Comput. 21, 1).

    >>> import jax.numpy as jnp
    >>> fit = fit_to_tensor(lambda a: jnp.diag(a**2), np.ones(3), np.diag([9.0, 16.0, 16.0]))
    >>> print(fit.parameters.round(6))
    [3. 4. 4.]
    """
    import jax  # only here: those who fit nothing need not wait for it
    import jax.numpy as jnp
    from jax.flatten_util import ravel_pytree

    require_plausible(inertia)
    wanted = np.asarray(inertia, dtype=float)
    rows, columns = np.triu_indices(3)
    # Elements off the diagonal stand for two each.
    weight = np.where(rows == columns, 1.0, np.sqrt(2.0)) / np.linalg.norm(wanted)
    with jax.enable_x64(True):
        first, structured = ravel_pytree(jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype=float), start))

        def tensor(flat: Array) -> Array:
            return inertia_of(structured(flat))

        value = jax.jit(tensor)
        slope = jax.jit(jax.jacfwd(tensor) if first.size <= len(rows) else jax.jacrev(tensor))
        limits = (-np.inf, np.inf) if bounds is None else tuple(np.asarray(ravel_pytree(side)[0]) for side in bounds)
        fit = least_squares(
            lambda flat: weight * (np.asarray(value(flat)) - wanted)[rows, columns],
            np.asarray(first),
            jac=lambda flat: weight[:, None] * np.asarray(slope(flat))[rows, columns],  # type: ignore[arg-type]
            bounds=limits,
            x_scale="jac",
            ftol=1e-15,
            xtol=1e-15,
            gtol=1e-15,
        )
        parameters = jax.tree.map(np.asarray, structured(jnp.asarray(fit.x)))
        reached = np.asarray(value(fit.x))
    return Fit(parameters, reached, float(np.linalg.norm(fit.fun)), int(fit.nfev))


def _principal_second_moments(inertia: Array) -> tuple[np.ndarray, np.ndarray]:
    # Descending, with their axes as rows; round-off below zero is taken away.
    require_plausible(inertia)
    _, axes = principal_frame(np.asarray(inertia, dtype=float))
    second = np.einsum("ki,ij,kj->k", axes, second_moment_from_inertia(np.asarray(inertia, dtype=float)), axes)
    return np.where(second > ROUND_OFF * second.max(), second, 0.0), axes


def _solid(inertia: Array) -> tuple[np.ndarray, np.ndarray]:
    second, axes = _principal_second_moments(inertia)
    if second[-1] == 0.0:
        low, middle, high = np.linalg.eigvalsh(np.asarray(inertia, dtype=float))
        raise ValueError(
            f"a body with a volume has I_1 + I_2 > I_3, and {low:.6g} + {middle:.6g} > {high:.6g} fails: it is flat"
        )
    return second, axes


def _unit_points(second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    # Shares of the mass, and places in the principal axes, of points with these second moments per mass, descending.
    one, other, least = second
    if least > 0.0:
        return np.full(4, 0.25), TETRAHEDRON * np.sqrt(second)
    if other == 0.0:
        return np.full(2, 0.5), np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]) * np.sqrt(one)
    # Two equal points at the angles +-(pi - b) and a lone one at 0: balance and Q_xx = R^2 cos b give all.
    radius, cosine = np.sqrt(one + other), one / (one + other)
    sine = np.sqrt(other * (2.0 * one + other)) / (one + other)
    places = radius * np.array([[1.0, 0.0, 0.0], [-cosine, sine, 0.0], [-cosine, -sine, 0.0]])
    return np.array([cosine, 0.5, 0.5]) / (1.0 + cosine), places
