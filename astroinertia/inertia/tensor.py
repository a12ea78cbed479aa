"""Inertia tensors and what follows from them: pure functions of arrays, numpy or jax, any consistent units.

Tensors have shape (..., 3, 3); leading axes are batches. Each function says about which point and in which axes its
tensor is. Source, where none is given: Goldstein, Poole & Safko (2002), Classical Mechanics, chapter 5. Checked by
tests/unit/inertia/test_tensor.py and, over twelve decades of mass and length, by test_identities.py.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from astroinertia.inertia.orthogonal import require_orthogonal
from astroinertia.process.known import is_known
from astroinertia.process.quantities import with_quantities
from astroinertia.process.vectors import of_any_length, require_components

if TYPE_CHECKING:
    from xarray import DataArray

Array = Any

_ROUND_OFF = 1e-12  # share of the largest moment by which sums over many points may miss an equality
_GAUSS_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(3)  # exact to degree 5: r^4 times a linear density
_LABELS = ["x", "y", "z"]


def namespace(*arrays: Array) -> Any:
    """The module that arrays belong to: jax.numpy where one of them does, else numpy, as for lists and numbers."""
    namespaces = (array.__array_namespace__() for array in arrays if hasattr(array, "__array_namespace__"))
    return next((module for module in namespaces if module is not np), np)


@with_quantities()
def inertia_from_second_moment(second_moment: Array) -> Array:
    """I = tr(Q) 1 - Q; linear, so it also turns dQ/dt into dI/dt and d2Q/dt2 into d2I/dt2.

    >>> print(np.diag(inertia_from_second_moment(np.diag([1.0, 2.0, 4.0]))))  # tr(Q) 1 - Q
    [6. 5. 3.]
    """
    xp = namespace(second_moment)
    x, y, z = (second_moment[..., k, k] for k in range(3))
    # I_xx = Q_yy + Q_zz and not tr(Q) - Q_xx, in which a thin rod along x would lose the digits of its thickness.
    diagonal = xp.stack([y + z, z + x, x + y], axis=-1)
    return xp.where(xp.eye(3, dtype=bool), diagonal[..., None, :], -second_moment)


@with_quantities()
def second_moment_from_inertia(inertia: Array) -> Array:
    """Q = tr(I)/2 1 - I, the inverse of `inertia_from_second_moment`.

    >>> print(np.diag(second_moment_from_inertia(np.diag([6.0, 5.0, 3.0]))))  # the inverse
    [1. 2. 4.]
    """
    xp = namespace(inertia)
    x, y, z = (inertia[..., k, k] for k in range(3))
    diagonal = 0.5 * xp.stack([y + z - x, z + x - y, x + y - z], axis=-1)
    return xp.where(xp.eye(3, dtype=bool), diagonal[..., None, :], -inertia)


@with_quantities()
def point_inertia(mass: Array, position: Array) -> Array:
    """m (|x|^2 1 - x (x) x), (..., 3, 3): the inertia tensor about the origin of point masses.

    mass (...,) and position (..., 3). With the whole mass and a shift it is the term of the parallel-axis theorem.

    >>> print(np.diag(point_inertia(2.0, np.array([0.0, 0.0, 3.0]))))  # m r^2 across, none along
    [18. 18.  0.]
    """
    xp = namespace(mass, position)
    x = xp.asarray(position)
    return xp.asarray(mass)[..., None, None] * inertia_from_second_moment(x[..., :, None] * x[..., None, :])


@with_quantities(position="SI")
def centre_of_mass(mass: Array, position: Array, weights: Array | None = None) -> Array:
    """Centre of mass (..., 3) of particles: mass (..., N), position (..., N, 3), weights (..., N) that multiply mass.

    One number as the mass is that of each particle. Any vector will do for position: with velocities it is the velocity
    of the centre. A total mass of 0 gives NaN.

    >>> print(centre_of_mass(np.array([1.0, 3.0]), np.array([[0.0, 0, 0], [4.0, 0, 0]])))
    [3. 0. 0.]
    """
    xp = namespace(mass, position, weights)
    centre = _centred(xp, _weighted(xp, mass, weights), xp.asarray(position))[0]
    return xp.stack(centre, axis=-1)


@with_quantities()
def second_moment(mass: Array, position: Array, origin: Array | None = None, weights: Array | None = None) -> Array:
    """Q = sum m x (x) x, (..., 3, 3), of particles about a point.

    mass (..., N), or one number that each particle has; position (..., N, 3); origin (..., 3), the centre of mass where
    none is given; weights (..., N) that multiply mass, such as 0 or 1 for a selection. In the axes of the positions.

    >>> print(second_moment(np.array([1.0, 1.0]), np.array([[-2.0, 0, 0], [2.0, 0, 0]]))[0, 0])  # 2 m x^2
    8.0
    """
    return mixed_moment(mass, position, position, origin, origin, weights)


@with_quantities(left="SI", right="SI", left_origin="SI", right_origin="SI")
def mixed_moment(
    mass: Array,
    left: Array,
    right: Array,
    left_origin: Array | None = None,
    right_origin: Array | None = None,
    weights: Array | None = None,
) -> Array:
    """sum m a (x) b, (..., 3, 3), of vectors (..., N, 3) that particles carry, each relative to its origin (..., 3).

    mass (..., N). Where no origin is given the vectors are relative to their mass-weighted mean. P has positions and
    velocities, K velocities twice, V_e positions and accelerations. weights (..., N) multiply mass.

    >>> x, v = np.array([[1.0, 0, 0], [-1.0, 0, 0]]), np.array([[0, 3.0, 0], [0, -3.0, 0]])
    >>> print(mixed_moment(np.ones(2), x, v)[0, 1])  # sum m x v_y: L_z, as sum m y v_x is 0
    6.0
    """
    xp = namespace(mass, left, right, left_origin, right_origin, weights)
    mass = _weighted(xp, mass, weights)
    a = _relative(xp, mass, left, left_origin)
    b = a if right is left and right_origin is left_origin else _relative(xp, mass, right, right_origin)
    weighted = [mass * component for component in a]
    # Sums along the last axis, where numpy adds pairwise and keeps digits that a running sum loses.
    rows = [[(weighted[i] * b[j]).sum(-1) if i <= j or a is not b else None for j in range(3)] for i in range(3)]
    full = [[rows[i][j] if rows[i][j] is not None else rows[j][i] for j in range(3)] for i in range(3)]
    return xp.stack([xp.stack(row, axis=-1) for row in full], axis=-2)


@with_quantities()
def inertia_tensor(mass: Array, position: Array, origin: Array | None = None, weights: Array | None = None) -> Array:
    """I = sum m (|x|^2 1 - x (x) x), (..., 3, 3), of particles about a point.

    mass (..., N), or one number that each particle has; position (..., N, 3); origin (..., 3), the centre of mass where
    none is given; weights (..., N) that multiply mass, such as 0 or 1 for a selection. In the axes of the positions.

    >>> print(np.diag(inertia_tensor(np.ones(2), np.array([[-1.0, 0, 0], [1.0, 0, 0]]))))  # a dumbbell along x
    [0. 2. 2.]
    """
    return inertia_from_second_moment(second_moment(mass, position, origin, weights))


@with_quantities(origin=None)
def grid_inertia(density: "DataArray", coordinates: Sequence[str] = ("x", "y", "z"), origin: Any = None) -> Any:
    """Mass, centre of mass and inertia tensor of a density on a rectangular grid: xarray in, xarray out.

    density: DataArray with the dimensions `coordinates`, whose coordinates are the centres of cells, ascending or
    descending, evenly spaced or not (walls lie midway between centres); its other dimensions are batches. origin (3,),
    plain numbers in the unit of the coordinates, the centre of mass where none is given. Returns a Dataset with mass
    (...), centre_of_mass (..., i) and inertia_tensor (..., i, j) about the origin, in the axes of the grid. Exact for a
    density that is constant in each cell. ValueError where a dimension has fewer than two cells or is not ascending or
    descending.

    >>> import xarray as xr
    >>> cells = np.array([-0.5, 0.5])  # a cube with sides of 2, of density 1: M (b^2 + c^2) / 12
    >>> cube = xr.DataArray(np.ones((2, 2, 2)), {"x": cells, "y": cells, "z": cells})
    >>> print(f"{grid_inertia(cube).inertia_tensor[2, 2]:.4f}")
    5.3333
    """
    import xarray as xr  # only here: nobody else who uses tensors need wait for it

    if not isinstance(density, xr.DataArray):
        raise ValueError(f"density must be a DataArray of xarray with coordinates, not a {type(density).__name__}")
    centres, widths = {}, {}
    lengths = {str(density[name].attrs.get("units", "")) for name in coordinates if name in density.coords} - {""}
    if len(lengths) > 1:
        raise ValueError(f"the coordinates must be in one unit, not in {' and '.join(sorted(lengths))}")
    for name in coordinates:
        if name not in density.coords or density.sizes.get(name, 0) < 2:
            raise ValueError(f"the density needs a coordinate {name!r} of two or more cells")
        values = np.asarray(density[name].values, dtype=float)
        step = np.diff(values)
        if not ((step > 0).all() or (step < 0).all()):
            raise ValueError(f"the coordinate {name!r} is neither ascending nor descending")
        walls = np.concatenate([values[:1] - step[:1] / 2, values[1:] - step / 2, values[-1:] + step[-1:] / 2])
        centres[name] = xr.DataArray((walls[1:] + walls[:-1]) / 2, {name: density[name].values}, [name])
        widths[name] = xr.DataArray(abs(np.diff(walls)), {name: density[name].values}, [name])

    def integral(factors: Mapping[str, Any]) -> Any:
        return xr.dot(density, *(factors.get(name, 1.0) * widths[name] for name in coordinates), dim=list(coordinates))

    mass = integral({})
    # Twice, the second time around the first result, which keeps the digits of a body far from the grid's origin.
    middle = {name: float(centres[name].mean()) for name in coordinates}
    centre = {name: middle[name] + integral({name: centres[name] - middle[name]}) / mass for name in coordinates}
    about = centre if origin is None else dict(zip(coordinates, origin, strict=True))
    offset = {name: centres[name] - about[name] for name in coordinates}
    square = {name: offset[name] ** 2 + widths[name] ** 2 / 12 for name in coordinates}
    i, j = (xr.IndexVariable(name, _LABELS) for name in "ij")
    rows = [
        xr.concat([integral({a: square[a]} if a == b else {a: offset[a], b: offset[b]}) for b in coordinates], j)
        for a in coordinates
    ]
    second = xr.concat(rows, i).transpose(..., "i", "j")
    tensor = second.copy(data=inertia_from_second_moment(second.data))
    place = xr.concat(list(centre.values()), i).transpose(..., "i")
    origin_text = "the centre of mass" if origin is None else f"({', '.join(f'{float(x):g}' for x in origin)})"
    body = xr.Dataset({"mass": mass, "centre_of_mass": place, "inertia_tensor": tensor})
    body["inertia_tensor"].attrs = {"long_name": "inertia tensor", "origin": origin_text, "frame": "axes of the grid"}
    units = density.attrs.get("units"), density[coordinates[0]].attrs.get("units")
    if None not in units:
        if any(str(text)[:1].isdigit() and text != "1" for text in units):
            raise ValueError(f"units of a grid have no factors: {units[1]} and {units[0]}")
        body["mass"].attrs["units"], body["inertia_tensor"].attrs["units"] = (f"{units[1]}{n} {units[0]}" for n in "35")
        body["centre_of_mass"].attrs["units"] = units[1]
    return body


@with_quantities()
def radial_profile_inertia(radius: Array, density: Array) -> tuple[Array, Array]:
    """Mass (...,) and inertia tensor (..., 3, 3) about its centre of a sphere with a radial density profile.

    radius (n,), ascending, not negative; density (..., n) at these radii, linear between them and 0 outside of them.
    M = 4 pi int rho r^2 dr and I = (8 pi / 3) int rho r^4 dr, exact for that density. ValueError for other radii, and
    for densities that are not finite.

    >>> r = np.linspace(0.0, 1.0, 1001)
    >>> mass, moment = radial_profile_inertia(r, np.ones_like(r))[:2]
    >>> print((moment / mass).round(6))  # of a uniform ball: (2/5) R^2
    [[0.4 0.  0. ]
     [0.  0.4 0. ]
     [0.  0.  0.4]]
    """
    xp = namespace(radius, density)
    radius, density = xp.asarray(radius), xp.asarray(density)
    if is_known(radius) and not (
        radius.ndim == 1 and radius.size > 1 and radius[0] >= 0 and radius[-1] < np.inf and (xp.diff(radius) > 0).all()
    ):
        raise ValueError("the radii must be two or more, ascending, not negative and finite")
    if is_known(density) and not xp.isfinite(density).all():
        raise ValueError("the densities of a profile must be finite")
    if density.shape[-1:] != radius.shape:
        raise ValueError(f"density must have a value at each of the {radius.size} radii, not the shape {density.shape}")
    share = xp.asarray(0.5 * (1 + _GAUSS_NODES), dtype=density.dtype)
    width = xp.diff(radius)[:, None]
    at = radius[:-1, None] + width * share
    value = density[..., :-1, None] + (density[..., 1:, None] - density[..., :-1, None]) * share
    part = value * at**2 * width * xp.asarray(0.5 * _GAUSS_WEIGHTS, dtype=density.dtype)
    mass, moment = 4 * np.pi * part.sum((-2, -1)), 8 * np.pi / 3 * (part * at**2).sum((-2, -1))
    return mass, moment[..., None, None] * xp.eye(3, dtype=moment.dtype)


@with_quantities()
def about_point(inertia: Array, mass: Array, offset: Array) -> Array:
    """From the tensor (..., 3, 3) about the centre of mass to that about a point at `offset` (..., 3) from it.

    The parallel-axis theorem with its full outer product, I + M (d^2 1 - d (x) d); mass (...,).

    >>> print(np.diag(about_point(np.eye(3), 2.0, np.array([0.0, 0.0, 3.0]))))  # Steiner: + m d^2 across
    [19. 19.  1.]
    """
    return inertia + point_inertia(mass, offset)


@with_quantities()
def about_centre(inertia: Array, mass: Array, offset: Array) -> Array:
    """From the tensor (..., 3, 3) about a point to that about the centre of mass, at `offset` (..., 3) from it.

    The inverse of `about_point`. Digits that the shift has lost do not come back: the error is a rounding of
    M d^2.

    >>> print(np.diag(about_centre(np.diag([19.0, 19.0, 1.0]), 2.0, np.array([0.0, 0.0, 3.0]))))  # Steiner, back
    [1. 1. 1.]
    """
    return inertia - point_inertia(mass, offset)


@with_quantities()
def rotated(inertia: Array, matrix: Array) -> Array:
    """R I R^T, (..., 3, 3): the tensor of the body turned by R (..., 3, 3) about the point that I is about.

    The transposed matrix gives the tensor of the same body in the turned axes. A matrix that is not orthogonal is a
    ValueError.

    >>> quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    >>> print(np.diag(rotated(np.diag([1.0, 2.0, 3.0]), quarter)))  # R I R^T: x and y change places
    [2. 1. 3.]
    """
    require_orthogonal(matrix)
    turned = matrix @ inertia @ namespace(inertia, matrix).swapaxes(matrix, -1, -2)
    return 0.5 * twice_symmetric(turned)  # products round, and a tensor stays symmetric


@with_quantities()
def twice_symmetric(tensor: Array) -> Array:
    """T + T^T: the rate of Q from P, and the share of V_e in d2Q/dt2.

    >>> print(twice_symmetric(np.array([[1.0, 2, 0], [0, 0, 0], [0, 0, 0]]))[:2, :2].tolist())  # V + V^T
    [[2.0, 2.0], [2.0, 0.0]]
    """
    return tensor + namespace(tensor).swapaxes(tensor, -1, -2)


@with_quantities()
def axial_vector(tensor: Array) -> Array:
    """eps_ijk T_jk, (..., 3): the angular momentum in P and the torque in V_e.

    >>> print(axial_vector(np.array([[0.0, 5, 0], [0, 0, 0], [0, 0, 0]])))  # eps_ijk V_jk
    [0. 0. 5.]
    """
    differences = [tensor[..., 1, 2] - tensor[..., 2, 1], tensor[..., 2, 0] - tensor[..., 0, 2]]
    return namespace(tensor).stack([*differences, tensor[..., 0, 1] - tensor[..., 1, 0]], axis=-1)


@with_quantities()
def moment_about(inertia: Array, axis: Array) -> Array:
    """n.I.n about the axis n (..., 3), which need not be a unit vector, through the point that I is about.

    >>> print(moment_about(np.diag([1.0, 2.0, 3.0]), np.array([1.0, 1.0, 0.0])))  # n.I.n, for any length of n
    1.5
    """
    require_components(axis=axis)
    xp = namespace(inertia, axis)
    size = abs(axis).max(-1, keepdims=True)  # whose square may overflow
    if is_known(size) and (size == 0).any():
        raise ValueError("the axis of a moment of inertia must not be the vector 0")
    axis = axis / size
    return xp.einsum("...i,...ij,...j->...", axis, inertia, axis) / (axis**2).sum(-1)


@with_quantities()
def invariants(inertia: Array) -> Array:
    """Trace, sum of principal minors and determinant, (..., 3): the same in all axes.

    >>> print([float(each) for each in invariants(np.diag([1.0, 2.0, 3.0]))])  # sum, sum of products, product
    [6.0, 11.0, 6.0]
    """
    (xx, xy, xz), (yy, yz), (zz,) = ([inertia[..., i, j] for j in range(i, 3)] for i in range(3))
    minors = [yy * zz - yz * yz, zz * xx - xz * xz, xx * yy - xy * xy]
    determinant = xx * minors[0] - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    return namespace(inertia).stack([xx + yy + zz, minors[0] + minors[1] + minors[2], determinant], axis=-1)


@with_quantities()
def require_plausible(inertia: Array) -> None:
    """Refuse a tensor (..., 3, 3) that no body of positive mass has; ValueError that names what fails.

    It must be finite, symmetric and positive, and no principal moment may exceed the sum of the other two, each to
    1e-12 of the largest. Inside jit a tensor is not seen, and so not refused.

    >>> try:
    ...     require_plausible(np.diag([1.0, 1.0, 2.1]))
    ... except ValueError as error:
    ...     print(error)
    no body has these moments: 1 + 1 < 2.1, and none may exceed the sum of the other two
    """
    if not is_known(inertia):
        return
    tensor = np.asarray(inertia, dtype=float)
    if tensor.shape[-2:] != (3, 3) or not np.isfinite(tensor).all():
        raise ValueError("an inertia tensor has 3 x 3 finite components")
    size = abs(tensor).max((-2, -1), keepdims=True)
    if (abs(tensor - np.swapaxes(tensor, -1, -2)) > _ROUND_OFF * size).any():
        raise ValueError("an inertia tensor is symmetric, and this one is not")
    moments = np.linalg.eigvalsh(tensor).reshape(-1, 3)
    for low, middle, high in moments:
        if low < -_ROUND_OFF * max(-low, high):
            raise ValueError(f"principal moments are not negative, and this tensor has {low:.6g}")
        if low + middle < high * (1 - _ROUND_OFF):
            digits = 6 if f"{low + middle:.6g}" != f"{high:.6g}" else 16
            shown = " + ".join(f"{moment:.{digits}g}" for moment in (low, middle)) + f" < {high:.{digits}g}"
            raise ValueError(f"no body has these moments: {shown}, and none may exceed the sum of the other two")


@with_quantities()
def radius_of_gyration(moment: Array, mass: Array) -> Array:
    """sqrt(I / M), (...,): the distance from the axis at which the mass has the moment (...,) about it.

    >>> print(radius_of_gyration(8.0, 2.0))  # sqrt(I / m)
    2.0
    """
    xp = namespace(moment, mass)
    return xp.sqrt(xp.asarray(moment) / mass)


@with_quantities()
def equivalent_ring(inertia: Array, mass: Array, axis: Array) -> tuple[Array, Array]:
    """Radius (...,) and tensor (..., 3, 3) about its centre of the thin ring with this mass and this moment about axis.

    inertia (..., 3, 3) about a point of the axis (..., 3); mass (...,). The ring lies around the axis and has half its
    moment about a diameter.

    >>> print(equivalent_ring(np.diag([1.0, 1.0, 8.0]), 2.0, np.array([0.0, 0.0, 1.0]))[0])  # sqrt(I_zz / m)
    2.0
    """
    xp = namespace(inertia, axis)
    axis = xp.asarray(axis)
    moment = moment_about(inertia, axis)
    axis = of_any_length(axis)
    along = axis[..., :, None] * axis[..., None, :] / (axis**2).sum(-1)[..., None, None]
    ring = 0.5 * moment[..., None, None] * (xp.eye(3, dtype=along.dtype) + along)
    return radius_of_gyration(moment, mass), ring


@with_quantities()
def equivalent_semi_axes(mass: Array, moments: Array) -> Array:
    """Semi-axes (..., 3) of the homogeneous ellipsoid with this mass and these principal moments, in their order.

    a_k^2 = 5 Q_k / M with Q_k = (I_1 + I_2 + I_3)/2 - I_k; nan where that is negative beyond rounding, as no body has a
    moment above the sum of the other two.

    >>> print(equivalent_semi_axes(5.0, np.array([5.0, 10.0, 13.0])))  # of the ellipsoid with axes 3, 2 and 1
    [3. 2. 1.]
    """
    require_components(moments=moments)
    xp = namespace(mass, moments)
    moments = xp.asarray(moments)
    squares = 5.0 * (0.5 * moments.sum(-1, keepdims=True) - moments) / xp.asarray(mass)[..., None]
    # The root of a safe number first: at a flat body's 0 the root has no derivative, and 0 passes on none.
    lengths = xp.where(squares <= 0, 0.0, xp.sqrt(xp.where(squares <= 0, 1.0, squares)))
    return xp.where(squares < -1e-6 * abs(squares).max(-1, keepdims=True), xp.nan, lengths)


def _weighted(xp: Any, mass: Array, weights: Array | None) -> Array:
    return xp.asarray(mass) if weights is None else xp.asarray(mass) * xp.asarray(weights)


def _relative(xp: Any, mass: Array, vector: Array, origin: Array | None) -> list[Array]:
    """The three components (..., N) of vectors (..., N, 3) relative to an origin (..., 3)."""
    vector = xp.asarray(vector)
    if origin is None:
        return _centred(xp, mass, vector)[1]
    about = xp.asarray(origin)
    _require_three(vector, about)
    return [vector[..., k] - about[..., k, None] for k in range(3)]


def _centred(xp: Any, mass: Array, vector: Array) -> tuple[list[Array], list[Array]]:
    """Components (...,) of the weighted mean of vectors (..., N, 3), and (..., N) of the vectors relative to it."""
    _require_three(vector)
    mass = xp.broadcast_to(mass, np.broadcast_shapes(mass.shape, vector.shape[:-1]))  # one number is that of each
    total = mass.sum(-1)
    share = mass / xp.where(total != 0, total, xp.nan)[..., None]
    nowhere = 0.0 if mass.shape[-1] else xp.nan  # of no particles a sum is 0
    centre, relative = [], []
    for k in range(3):
        # Twice, the second time around the first result: a body far from the origin keeps the digits that its
        # coordinates have, and its vectors are relative to the mean itself, not to the mean as rounded.
        near = (share * vector[..., k]).sum(-1)
        offset = vector[..., k] - near[..., None]
        rest = (share * offset).sum(-1)
        centre.append(near + rest + nowhere)
        relative.append(offset - rest[..., None])
    return centre, relative


def _require_three(*vectors: Array) -> None:
    """IndexError unless all have three components; without it a fourth is left out, and JAX makes up a third."""
    for vector in vectors:
        if vector.shape[-1:] != (3,):
            raise IndexError(f"vectors have three components, not the shape {vector.shape}")
