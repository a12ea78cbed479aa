"""What SPICE kernels say of a body: its pole and spin from a PCK, its companions' orbits from an SPK.

The kernels are files of the user's (NAIF has them at naif.jpl.nasa.gov); none is shipped. The toolkit is that of the
extra `spice`. Kernels that a program has loaded into SPICE by itself count beside those that are named here, and stay
loaded. Sources: Acton et al. 2018, Planet. Space Sci. 150, 9; the toolkit's required reading PCK and SPK; rotational
elements in a PCK are those of the IAU's working group (Archinal et al. 2018, CMDA 130, 22).
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from astroinertia.errors import SceneError
from astroinertia.process.quantities import with_quantities
from astroinertia.rotation.ephemeris import Ephemeris, ephemeris_of

Kernels = str | Path | Sequence[str | Path]

_ICRF = "J2000"  # SPICE's name of these axes
_MOST_FRAMES = 10_000  # that binary PCK files have orientations of
_PLANETS = range(1, 10)  # numbers of the centres of mass of planets with their moons; 100 times as much and 99: planets


class Orientation(NamedTuple):
    """Pole of a body in ICRF axes, rad and (3,), and its rate of rotation about it, rad s-1, below 0 if backwards.

    The pole is the IAU's: of a planet or moon the one north of the invariable plane.
    """

    right_ascension: float
    declination: float
    pole: np.ndarray
    spin_rate: float


@with_quantities()
def orientation(kernels: Kernels, name: str, time: float = 0.0) -> Orientation:
    """The pole and the spin of a body at a time, s from 2000-01-01 12:00 TDB, from a text or binary PCK.

    name: as SPICE has it ("Mars", "IO", "499"). SceneError for what the kernels lack, for what is no kernel, and where
    spiceypy is not installed.
    """
    with loaded(kernels) as spice:
        turn = spice.tisbod(_ICRF, _number(spice, name), time)
        axes, angular_velocity = spice.xf2rav(turn)
        pole = np.array(axes[2])
        return Orientation(
            float(np.arctan2(pole[1], pole[0]) % (2 * np.pi)), float(np.arcsin(pole[2])), pole,
            float(angular_velocity @ pole),
        )  # fmt: skip


@with_quantities(companions="kg")
def orbits(
    kernels: Kernels, name: str, companions: Mapping[str, float], times: tuple[float, float],
    axes: np.ndarray | None = None, tolerance: float = 1e-8,
) -> Ephemeris:  # fmt: skip
    """Orbits of companions relative to a body from an SPK, as `rotation.ephemeris` tabulates them: SI.

    companions: their masses by SPICE's names, in kg, or GM with what uses G = 1. times: the first and the last, s
    from 2000-01-01 12:00 TDB. axes (3, 3): rows in ICRF axes; those themselves unless given. A planet is the centre of
    mass of it and its moons, but for the body itself, where the kernels have its own centre. tolerance: of the table,
    over the distance. SceneError as for `orientation`.
    """
    with loaded(kernels) as spice:
        observer = _centre(spice, name, times[0])
        targets = [_companion(_number(spice, each)) for each in companions]

        def states(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return _states(spice, targets, observer, at, axes)

        return ephemeris_of(states, *times, companions, tolerance)


@with_quantities()
def state(kernels: Kernels, name: str, about: str, time: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Position (3,) in m and velocity (3,) in m s-1 of a companion relative to the body `about`, in ICRF axes.

    As for `orbits`.
    """
    with loaded(kernels) as spice:
        target, observer = _companion(_number(spice, name)), _centre(spice, about, time)
        place, speed = _states(spice, [target], observer, np.array([time]), None)
        return place[0, 0], speed[0, 0]


@with_quantities()
def obliquity(kernels: Kernels, name: str, around: str = "Sun", time: float = 0.0) -> float:
    """Angle in rad between the spin of a body and the normal of its orbit, above pi/2 if it turns backwards.

    Needs a PCK and an SPK; as for `orientation`.
    """
    turning = orientation(kernels, name, time)
    spin = np.sign(turning.spin_rate) * turning.pole
    normal = np.cross(*state(kernels, around, name, time))
    return float(np.arctan2(np.linalg.norm(np.cross(spin, normal)), spin @ normal))


def has_orbits(kernels: Kernels) -> bool:
    """Whether there is an SPK among the kernels."""
    with loaded(kernels) as spice:
        return spice.ktotal("SPK") > 0


def has_orientation(kernels: Kernels, name: str) -> bool:
    """Whether the kernels have the pole of a body, at whatever time."""
    with loaded(kernels) as spice:
        number, found = _number(spice, name), spice.cell_int(_MOST_FRAMES)
        for place in range(spice.ktotal("PCK")):  # binary ones; those of text are in the pool
            spice.pckfrm(spice.kdata(place, "PCK")[0], found)
        return number in found or spice.bodfnd(number, "POLE_RA")


@contextmanager
def loaded(kernels: Kernels) -> Iterator[Any]:
    """The module spiceypy with the kernels loaded, until the end of the block; its errors become SceneError."""
    try:
        import spiceypy  # pyright: ignore[reportMissingImports]  an extra: only kernels need it
    except ImportError:
        raise SceneError("SPICE kernels need spiceypy: pip install 'astroinertia[spice]'") from None
    files = [kernels] if isinstance(kernels, str | Path) else list(kernels)
    done: list[str] = []
    try:
        for file in map(str, files):
            spiceypy.furnsh(file)
            done.append(file)
        yield spiceypy
    except spiceypy.SpiceyError as error:
        said = getattr(error, "long", "") or str(error)
        raise SceneError(f"SPICE kernels: {' '.join(said.split()).partition('. ')[0].rstrip('.')}") from None
    finally:
        for file in reversed(done):
            spiceypy.unload(file)


def _number(spice: Any, name: str) -> int:
    try:
        return int(spice.bods2c(name))
    except spice.NotFoundError:
        raise SceneError(f"SPICE knows no body {name!r}") from None


def _companion(number: int) -> int:
    """Of a planet the centre of mass of it and its moons, whose mass is that of all of them."""
    return number // 100 if number % 100 == 99 and number // 100 in _PLANETS else number


def _centre(spice: Any, name: str, time: float) -> int:
    """The body's own centre where the kernels have it, else that of it and its moons; the Earth's own in any case."""
    number = _number(spice, name)
    if number != 399 and _companion(number) != number:
        try:
            spice.spkgeo(number, time, _ICRF, _companion(number))
        except spice.SpiceyError:
            return _companion(number)
    return number


def _states(
    spice: Any, targets: Sequence[int], observer: int, times: np.ndarray, axes: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities (T, N, 3), SI, without the time of light."""
    rows = np.array([[spice.spkgeo(target, time, _ICRF, observer)[0] for target in targets] for time in times])
    place, speed = 1e3 * rows[..., :3], 1e3 * rows[..., 3:]
    return (place, speed) if axes is None else (place @ axes.T, speed @ axes.T)
