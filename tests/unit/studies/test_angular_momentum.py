"""The spectrum of angular momentum."""

import numpy as np
import pytest
import xarray as xr

from astroinertia.sph.placement import place
from astroinertia.sph.profiles import uniform
from astroinertia.studies.angular_momentum import angular_momentum_spectrum


def snapshots(mass, *motions):
    """Particles as snapshots hold them."""
    position, velocity = (np.stack(arrays) for arrays in zip(*motions, strict=True))
    dims = ("snapshot_time", "particle")
    return xr.Dataset(
        {"mass": (dims, np.broadcast_to(mass, position.shape[:2])), "position": ((*dims, "i"), position),
         "velocity": ((*dims, "i"), velocity)},
        {"snapshot_time": np.arange(len(position), dtype=float)},
    )  # fmt: skip


def test_the_spectrum_of_a_rigid_sphere_is_mestels_and_stays_in_homologous_contraction():
    """M(<j) = 1 - (1 - j/(Omega R^2))^(3/2) of a uniform sphere; a drift, a place and unequal masses change nothing."""
    x = place(uniform(), 4000, "random", 1)
    spin = np.cross([0.0, 0.0, 0.7], x)
    data = snapshots(np.ones(4000), (x + 5.0, spin + 9.0), (0.1 * x, 10.0 * spin))
    found = angular_momentum_spectrum(data)
    named = data.assign_coords(i=list("xyz"))
    xr.testing.assert_allclose(angular_momentum_spectrum(named.isel(i=[2, 0, 1])), found, rtol=1e-12)
    share = found.mass_share.values
    np.testing.assert_allclose(found[0], 0.7 * (1 - (1 - share) ** (2 / 3)), atol=0.02)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9, atol=1e-12)
    heavy = snapshots(np.where(np.arange(4000) < 2000, 2.0, 1.0), (x, spin))
    twice = snapshots(np.ones(6000), (np.vstack([x, x[:2000]]), np.vstack([spin, spin[:2000]])))
    np.testing.assert_allclose(angular_momentum_spectrum(heavy), angular_momentum_spectrum(twice), atol=0.003)


def test_matter_that_changes_places_leaves_the_spectrum_but_a_torque_between_halves_does_not():
    x = place(uniform(), 1000, "random", 2)
    spin = np.cross([0.0, 0.0, 1.0], x)
    inside = np.hypot(x[:, 0], x[:, 1]) < 0.5
    slowed = np.where(inside[:, None], 0.5, 1.1) * spin
    order = np.random.default_rng(0).permutation(1000)
    found = angular_momentum_spectrum(snapshots(np.ones(1000), (x, spin), (x[order], spin[order]), (x, slowed)))
    np.testing.assert_allclose(found[1], found[0], atol=1e-12)
    assert abs(found[2] - found[0]).max() > 0.05


@pytest.mark.parametrize("points", [0, 2.5])
def test_a_spectrum_is_of_a_whole_number_of_points(points):
    """Two and a half of them were three, whose last was the end of the mass."""
    x = place(uniform(), 100, "random", 2)
    with pytest.raises(ValueError, match=f"a whole number of points, at least one, not {points}"):
        angular_momentum_spectrum(snapshots(np.ones(100), (x, x)), points)
