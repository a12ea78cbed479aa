"""The inertia ellipsoid with principal axes and polhodes, beside the body that has these moments."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from astroinertia.dataset.absent import with_absent
from astroinertia.inertia.principal import principal_frame, undefined_axes
from astroinertia.inertia.tensor import about_centre
from astroinertia.plots import style

AXES = (style.VERMILLION, style.GREEN, style.BLUE)  # of the least, the intermediate and the greatest moment
SHARES = (0.22, 0.44, 0.64, 0.82, 0.94)  # of the way from an axis to the separatrix
LEAST_MOMENT = 0.02  # of the greatest; the ellipsoid of a thinner rod is drawn as if it were this thick
MOST_POINTS = 4000
_PIXELS = 700
_ARROW = 0.3
_VIEWER = np.array([0.50, 0.74, 0.45])  # direction to the eye, in the principal axes: none is seen end on
_LIGHT = np.array([-0.35, 0.55, 0.76])  # in the picture: rightwards, upwards, towards the eye
BODY_COLOUR, INERTIA_COLOUR = "#d9c8a9", "#c3d3e6"


@with_absent
def ellipsoid_figure(dataset: xr.Dataset, points: np.ndarray | None = None, name: str = "") -> Figure:
    """The equivalent homogeneous ellipsoid and the inertia ellipsoid, from the same side.

    dataset: as studies.moments gives it. points (N, 3): matter to show around the first, in the same unit.

    >>> from astroinertia.studies.moments import moments, read_matter
    >>> figure = ellipsoid_figure(moments(read_matter("runs/star")))
    >>> print([text.get_text() for text in figure.axes[0].texts][6])
    Homogeneous ellipsoid with this tensor
    """
    moments, axes = dataset["principal_moments"].values, dataset["principal_axes"].transpose("principal", "i").values
    defined = dataset["axis_defined"].values.astype(bool)
    view = view_of(axes)
    own = (axes, defined) if dataset.attrs["about"] == "centre of mass" else _own_axes(dataset)
    with style.styled():
        figure = style.page(f"{name}: inertia ellipsoid" if name else "inertia ellipsoid", (11.0, 6.0))
        left, right = figure.subplots(1, 2)
        _body(left, dataset, *own, view, points)
        _inertia(right, moments, axes, defined, view)
        for panel in (left, right):
            draw_triad(panel, view)
        figure.supxlabel(_caption(dataset), fontsize=9.5, color=style.INK, x=0.012, ha="left")
        return figure


def view_of(axes: np.ndarray) -> np.ndarray:
    """Rows: rightwards, upwards and towards the eye; the axis of the greatest moment stands upright."""
    towards = _VIEWER @ axes / np.linalg.norm(_VIEWER)
    upwards = axes[2] - (axes[2] @ towards) * towards
    upwards /= np.linalg.norm(upwards)
    return np.stack([np.cross(upwards, towards), upwards, towards])


def _own_axes(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """The principal axes about the centre of mass, as rows, and whether each has a direction of its own."""
    offset = dataset["origin"].values - dataset["centre_of_mass"].values
    moments, axes = principal_frame(about_centre(dataset["inertia_tensor"].values, dataset["mass"].values, offset))
    return axes, ~undefined_axes(moments, dataset.attrs["gap_tolerance"])


def _body(panel, dataset: xr.Dataset, axes, defined, view, points) -> None:
    lengths = dataset["semi_axes"].values
    scale, unit = style.scale_of(style.unit_of(dataset["semi_axes"]), lengths)
    reach = float(lengths.max()) or 1.0
    if points is not None:
        shown = points[np.linspace(0, len(points) - 1, min(len(points), MOST_POINTS)).astype(int)]
        offset = shown - dataset["centre_of_mass"].values
        seen = offset @ view.T / reach
        reach *= min(max(1.0, float(np.quantile(np.linalg.norm(seen, axis=1), 0.999))), 3.0)
        seen = offset @ view.T / reach
        near = seen[np.linalg.norm(seen, axis=1) <= 1.15]
        size = float(np.clip(3000 / len(shown), 1.0, 24.0))
        panel.scatter(near[:, 0], near[:, 1], s=size, color=style.GREY, linewidth=0, alpha=0.7, zorder=1)
    thick = np.maximum(lengths / reach, 4e-3)  # a rod or a disc keeps a visible edge
    draw_ellipsoid(panel, thick, axes, view, BODY_COLOUR, alpha=1.0 if points is None else 0.82)
    draw_axes(panel, thick, axes, defined, view)
    about = "this tensor" if dataset.attrs["about"] == "centre of mass" else "the tensor about the centre of mass"
    heading(panel, f"Homogeneous ellipsoid with {about}")
    axis_lengths = [f"{value / scale:.4g}" for value in lengths]
    _note(panel, "semi-axes " + ", ".join(axis_lengths) + ("" if unit == "1" else f" {style.raised(unit)}"))


def _inertia(panel, moments, axes, defined, view) -> None:
    floored = np.maximum(moments, LEAST_MOMENT * moments[2])
    draw_inertia_ellipsoid(panel, floored, axes, defined, view, SHARES, AXES, (1.1, 1.9))
    heading(panel, "Inertia ellipsoid $x$·$I$·$x$ = 1, and polhodes")
    text = {
        2: "free rotation is stable about 1 and 3; about 2 it runs off along the black curve",
        1: "two moments are equal: the polhodes are circles about the third axis",
        0: "all moments are equal: free rotation is steady about any axis",
    }[int(defined[0]) + int(defined[2])]
    _note(panel, f"a thin rod: drawn with a least moment of {LEAST_MOMENT:g} of the greatest"
                 if moments[0] < LEAST_MOMENT * moments[2] else text)  # fmt: skip


def lit_ellipsoid(lengths, axes, view, colour: str, pixels: int = _PIXELS) -> tuple[np.ndarray, float]:
    """A picture (pixels, pixels, 4) of an ellipsoid lit from above on the left, and half its width.

    For every pixel, where the line of sight meets it first; axes are rows (3, 3), as those of a view are.
    """
    shape = _shape(lengths, axes, view)
    extent = float(np.sqrt(np.diag(np.linalg.inv(shape))[:2]).max()) * 1.01
    grid = (np.arange(pixels) + 0.5) / pixels * 2 * extent - extent
    u, v = np.meshgrid(grid, grid)
    flat = np.stack([u, v, np.zeros_like(u)], axis=-1)
    linear = flat @ shape[:, 2]
    constant = np.einsum("...i,ij,...j->...", flat, shape, flat) - 1.0
    discriminant = linear**2 - shape[2, 2] * constant
    flat[..., 2] = (np.sqrt(np.maximum(discriminant, 0.0)) - linear) / shape[2, 2]
    normal = flat @ shape
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    light = _LIGHT / np.linalg.norm(_LIGHT)
    bright = 0.62 + 0.38 * np.maximum(normal @ light, 0.0)
    halfway = (light + [0, 0, 1]) / np.linalg.norm(light + [0, 0, 1])
    gleam = 0.35 * np.maximum(normal @ halfway, 0.0) ** 40
    image = np.zeros((*u.shape, 4))
    image[..., :3] = np.clip(bright[..., None] * to_rgb(colour) + gleam[..., None], 0.0, 1.0)
    image[..., 3] = discriminant > 0
    return image, extent


def _shape(lengths, axes, view) -> np.ndarray:
    """The matrix of an ellipsoid x.S.x = 1 in the axes of the picture."""
    return np.einsum("ki,k,kj->ij", axes @ view.T, lengths**-2, axes @ view.T)


def draw_ellipsoid(panel, lengths, axes, view, colour: str, alpha: float = 1.0) -> None:
    """An ellipsoid with its outline, lit from above on the left."""
    shape = _shape(lengths, axes, view)
    image, extent = lit_ellipsoid(lengths, axes, view, colour)
    image[..., 3] *= alpha
    panel.imshow(image, extent=(-extent, extent, -extent, extent), origin="lower", zorder=2, interpolation="bilinear")
    # The outline is the shadow of the ellipsoid, whose shape is the block of the inverse in the plane.
    values, vectors = np.linalg.eigh(np.linalg.inv(shape)[:2, :2])
    turn = np.linspace(0, 2 * np.pi, 361)
    outline = vectors * np.sqrt(values) @ np.stack([np.cos(turn), np.sin(turn)])
    panel.plot(*outline, color=style.GREY, linewidth=0.9, zorder=3)
    panel.set(aspect="equal", xlim=(-1.48, 1.48), ylim=(-1.3, 1.38))
    panel.axis("off")


def draw_inertia_ellipsoid(
    panel, moments, axes, defined, view, shares=(0.3, 0.6, 0.85), colours=(style.GREY,) * 3, widths=(0.7, 1.3)
) -> float:
    """The ellipsoid x.I.x = 1 with its axes, polhodes about those that are defined, and the separatrix between them.

    moments (3,) ascending, axes as rows; shares of the way from an axis to the separatrix, and widths of polhodes and
    separatrix. Returns what lengths on it are divided by.
    """
    lengths = 1.0 / np.sqrt(moments)
    reach = float(lengths.max())
    draw_ellipsoid(panel, lengths / reach, axes, view, INERTIA_COLOUR)
    for around in (0, 2):
        for share in shares if defined[around] else ():
            curves = polhode(moments, share, around) @ axes
            draw_curves(panel, curves, moments, axes, view, reach, colours[around], widths[0])
    if defined[0] and defined[2]:
        draw_curves(panel, polhode(moments, 1.0, 2) @ axes, moments, axes, view, reach, style.INK, widths[1])
    draw_axes(panel, lengths / reach, axes, defined, view)
    return reach


def draw_curves(panel, curves, moments, axes, view, reach, colour, width) -> None:
    """Curves on the ellipsoid, faint on its far side."""
    normal = np.einsum("cpi,ki,k,kj->cpj", curves, axes, moments, axes)
    facing = normal @ view[2] > 0
    for curve, front in zip(curves / reach, facing, strict=True):
        u, v = view[:2] @ curve.T
        panel.plot(np.where(front, u, np.nan), np.where(front, v, np.nan), color=colour, linewidth=width, zorder=4)
        panel.plot(
            np.where(front, np.nan, u), np.where(front, np.nan, v), color=colour, linewidth=0.6 * width, alpha=0.28,
            linestyle=(0, (2, 2)), zorder=4,
        )  # fmt: skip


def draw_axes(panel, lengths, axes, defined, view) -> None:
    """Arrows from the surface outwards, numbered; dashed and grey where the direction is arbitrary."""
    for k in range(3):
        direction = view @ axes[k]
        direction = direction if direction[2] > 0 else -direction  # the end that is seen
        begin, end = direction[:2] * lengths[k], direction[:2] * (lengths[k] + _ARROW)
        colour = AXES[k] if defined[k] else style.GREY
        panel.annotate(
            "", end, begin, arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 2.2, "shrinkA": 0,
                                        "shrinkB": 0, "linestyle": "-" if defined[k] else (0, (2, 1.5))},
            zorder=6,
        )  # fmt: skip
        beyond = end + 0.085 * (end - begin) / np.linalg.norm(end - begin)
        panel.text(
            *beyond, f"{k + 1}", color=colour, fontsize=12, fontweight="bold", ha="center", va="center", zorder=7,
            path_effects=[withStroke(linewidth=2.5, foreground="white")],
        )  # fmt: skip


def draw_triad(panel, view) -> None:
    """The axes x, y and z of the frame, in the corner."""
    corner, length = np.array([-1.2, -0.86]), 0.17
    for k, letter in enumerate("xyz"):
        end = corner + length * view[:2, k]
        panel.plot(*np.stack([corner, end], axis=1), color=style.GREY, linewidth=1.2, zorder=5)
        size = np.linalg.norm(view[:2, k])
        beyond = end + 0.075 * view[:2, k] / max(size, 0.3)
        panel.text(*beyond, letter, color=style.GREY, fontsize=9, ha="center", va="center", zorder=5)


def heading(panel, text: str) -> None:
    """The title of a panel without axes."""
    panel.text(0.0, 1.0, text, transform=panel.transAxes, va="top", fontsize=10.5, fontweight="bold", color=style.INK)


def _note(panel, text: str) -> None:
    panel.text(0.5, 0.0, text, transform=panel.transAxes, ha="center", va="bottom", fontsize=9, color=style.GREY)


def _caption(dataset: xr.Dataset) -> str:
    moments: Any = dataset["principal_moments"]
    scale, unit = style.scale_of(style.unit_of(moments), moments.values)
    values = "   ".join(f"$I_{k + 1}$ = {value / scale:.5g}" for k, value in enumerate(moments.values))
    undefined = [str(k + 1) for k in range(3) if not bool(dataset["axis_defined"].values[k])]
    text = f"{values}" + ("" if unit == "1" else f"  {style.raised(unit)}")
    return text + (f"     axes {', '.join(undefined)}: undefined, the moments are equal" if undefined else "")


_FAMILIES = ((0, 1, 2), (2, 1, 0))  # axis that a family circles, the intermediate one, and the other


def polhode(moments: np.ndarray, share: float, around: int, points: int = 241) -> np.ndarray:
    """The two closed curves of a polhode, (2, points, 3), in the principal axes, on the ellipsoid sum I_k x_k^2 = 1.

    moments (3,), ascending and positive; x = omega / sqrt(2 T). around: 0 or 2, the axis that the curves circle, that
    of the least or of the greatest moment; the other moments must differ from its own. share: from 0, the axis itself,
    to 1, the separatrix through the intermediate axis.
    Along a polhode |I x|^2 = D = L^2 / (2 T) is constant, so that two of the x_k^2 follow from the third: Poinsot
    (1834); Landau & Lifshitz, Mechanics, section 37. Checked by tests/unit/plots/test_inertia.py.
    """
    lone, middle, other = next(family for family in _FAMILIES if family[0] == around)
    lone_moment, middle_moment, other_moment = moments[lone], moments[middle], moments[other]
    turn = np.linspace(0.0, 2.0 * np.pi, points)
    curve = np.zeros((2, points, 3))
    across = share**2 * abs(lone_moment - middle_moment)  # |D - I| for the moment that the curves circle
    curve[..., middle] = np.sqrt(across / (middle_moment * abs(lone_moment - middle_moment))) * np.sin(turn)
    curve[..., other] = np.sqrt(across / (other_moment * abs(lone_moment - other_moment))) * np.cos(turn)
    rest = 1.0 - middle_moment * curve[0, :, middle] ** 2 - other_moment * curve[0, :, other] ** 2
    curve[..., lone] = np.array([[1.0], [-1.0]]) * np.sqrt(np.maximum(rest, 0.0) / lone_moment)
    return curve
