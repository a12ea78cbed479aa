"""A cooling star contracts homologously: its spin goes as 1/I, and leaves R^-2 by what happens to I/(M R^2)."""

import numpy as np
import pytest

from astroinertia import dataset as datasets
from astroinertia.bodies.rotating_star import rotating_star_with
from astroinertia.bodies.scf_matter import polytropic_matter
from astroinertia.run import run_scene
from astroinertia.scene.load import load_file

SCENE = "sims/contracting_star.toml"


def contracted(folder, *settings):
    """Series of a run, and along it: mean radius over that at first, spin, and the moment about the axis."""
    data = datasets.open(run_scene(load_file(SCENE, settings), folder / "run")).load()
    radius = data.mean_radius.values / data.mean_radius.values[0]
    # The spin from the particles' motion shell by shell, not from L: sum of L_k Omega_k over sum of L_k.
    share = data.specific_angular_momentum_profile
    spin = ((share * data.rotation_profile).sum("radius_bin") / share.sum("radius_bin")).values
    return data, radius, spin, data.inertia.about_axis("z").values


def check(data, radius, spin, moment, homology):
    """What holds at any size: omega I, and what is missing from R^-2; returns the largest errors of both."""
    kept = data.inertia.spin_rate().values * data.inertia.about_axis(data.angular_momentum.values[0]).values
    constant = np.abs(kept / kept[0] - 1).max()
    left = spin / spin[0] * radius**2 - 1  # omega R^2 against its first value
    ratio = moment / moment[0] / radius**2  # of I/(M R^2)
    expected = 1 / ratio - 1
    return constant, np.abs(left - expected).max(), np.abs(expected).max(), homology


def test_the_spin_of_a_contracting_star_goes_as_its_inertia(tmp_path):
    """A factor 8 in radius with 200 particles: omega I to 1e-6, and the rest within a tenth of itself."""
    settings = ["body.particles=200", "effects.cooling.time_scale='65 d'", "time.end='41.4 d'"]
    data, radius, spin, moment = contracted(tmp_path, *settings)
    constant, error, missing, _ = check(data, radius, spin, moment, None)
    assert radius.min() < 1 / 7
    assert constant < 1e-6
    assert error < 0.1 * missing
    # The books: cooling takes what the virial theorem leaves to be radiated, half of the energy set free.
    freed = np.abs(data.gravitational_energy.values[[0, -1]])
    radiated = -data.heating.sel(effect="cooling").values[-1]
    assert radiated == pytest.approx(0.5 * (freed[1] - freed[0]), rel=0.05)
