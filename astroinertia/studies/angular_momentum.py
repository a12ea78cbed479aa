"""How a body's angular momentum is spread over its mass, before and after: the spectrum j(M) of its snapshots.

Where no torque moves angular momentum from one ring of matter to another, as in an axisymmetric collapse without
viscosity, every ring keeps its own and the spectrum stays what it was (Mestel 1963, MNRAS 126, 553).
"""

import numpy as np
import xarray as xr

from astroinertia.dataset.arranged import from_x_to_z
from astroinertia.dataset.snapshots import present
from astroinertia.process.quantities import with_quantities


@with_quantities()
def angular_momentum_spectrum(snapshots: xr.Dataset, points: int = 50) -> xr.DataArray:
    """Return j (snapshot_time, mass_share): the specific angular momentum about z that a share of the mass is below.

    snapshots: as `dataset.open_snapshots` gives them; j is about the centre of mass and relative to its motion. points:
    shares of the mass, in the middles of as many equal parts; ValueError below 1 and for no whole number.

    >>> j = angular_momentum_spectrum(ds.inertia.snapshots)
    >>> print(bool((j.diff("mass_share") >= 0).all()))  # in rising order of j
    True
    """
    if points < 1 or points % 1 != 0:
        raise ValueError(f"a spectrum is of a whole number of points, at least one, not {points}")
    snapshots = from_x_to_z(snapshots)
    share = (np.arange(points) + 0.5) / points
    spectra = []
    for number in range(snapshots.sizes["snapshot_time"]):
        particles = present(snapshots.isel(snapshot_time=number))
        m = particles["mass"].values / particles["mass"].values.sum()
        vectors = (particles[name].transpose("particle", "i").values for name in ("position", "velocity"))
        x, v = (vector - m @ vector for vector in vectors)
        j = x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]
        order = np.argsort(j, kind="stable")
        spectra.append(np.interp(share, np.cumsum(m[order]) - 0.5 * m[order], j[order]))
    unit = "1" if snapshots["mass"].attrs.get("units") == "1" else "m2 s-1"
    return xr.DataArray(
        np.array(spectra),
        {"snapshot_time": snapshots["snapshot_time"], "mass_share": share},
        ("snapshot_time", "mass_share"),
        "specific_angular_momentum",
        {"units": unit, "long_name": "specific angular momentum about z that this share of the mass is below"},
    )
