"""A cooling star contracts homologously: its spin goes as 1/I, and leaves R^-2 by what happens to I/(M R^2).

Measured with 500 particles, the scene as it stands, down to 1/51 of the radius: |L| to 1e-15, what is missing from R^-2
8.8 %, equal to the change of I/(M R^2) to 1e-5 for the mean angular velocity and to 1e-3 for the spin of shells.
"""

from pathlib import Path

import numpy as np
import pytest

from astroinertia import dataset as datasets
from astroinertia.run.loop import run_scene
from astroinertia.scene.load import load_file

SCENE = "sims/contracting_star.toml"


def contracted(folder, *settings):
    """Of a run: the dataset, R_0/R, largest change of |L|, and omega R^2 and M R^2/I over their first values, less 1.

    The last is omega R^2 by the spin of shells, sum L_k Omega_k / sum L_k, which owes nothing to the inertia tensor.
    """
    data = datasets.open(run_scene(load_file(Path(__file__).parents[2] / SCENE, settings), folder / "run")).load()
    radius = data.mean_radius.values / data.mean_radius.values[0]
    momentum = np.linalg.norm(data.angular_momentum.values, axis=1)
    moment, spin = data.inertia.about_axis("z").values, data.angular_velocity.values[:, 2]
    share = data.specific_angular_momentum_profile
    shells = ((share * data.rotation_profile).sum("radius_bin") / share.sum("radius_bin")).values
    changed = spin / spin[0] * radius**2 - 1
    by_shells = shells / shells[0] * radius**2 - 1
    return (
        data,
        1 / radius,
        np.abs(momentum / momentum[0] - 1).max(),
        changed,
        radius**2 * moment[0] / moment - 1,
        by_shells,
    )


@pytest.mark.full
def test_the_spin_of_a_contracting_star_goes_as_its_inertia(tmp_path):
    """A factor of 8 with 200 particles: omega I to 1e-6, what R^-2 misses to 1 %, half of the freed energy radiated."""
    settings = ["body.particles=200", "effects.cooling.time_scale='65 d'", "time.end='41.5 d'"]
    data, smaller, constant, changed, expected, by_shells = contracted(tmp_path, *settings)
    assert smaller.max() > 7
    assert constant < 1e-6
    missing = np.abs(expected).max()
    assert np.abs(changed - expected).max() < 0.01 * missing
    assert np.abs(by_shells - expected).max() < 0.2 * missing
    # E = W/2 in equilibrium with gamma 5/3, turning or not.
    freed = np.abs(data.gravitational_energy.values[[0, -1]])
    radiated = -data.heating.sel(effect="cooling").values[-1]
    assert radiated == pytest.approx(0.5 * (freed[1] - freed[0]), rel=0.10)  # 0.955: the star pulsates


@pytest.mark.full(inputs=["sims/contracting_star.toml"])
def test_a_contraction_by_fifty_at_full_size(tmp_path, result):
    """The scene with 1000 particles: a factor of 50 from T/|W| = 0.08 %, omega I to 1e-6 and the deviation to 1 %."""
    data, smaller, constant, changed, expected, by_shells = contracted(tmp_path, "body.particles=1000")
    reached = int(np.argmax(smaller >= 50))
    share, limits = data.rotational_to_gravitational.values, data.inertia.rotation_limits("polytrope 1.5")
    result(
        smaller=smaller.max(), constant=constant, deviation=changed[reached], expected=expected[reached],
        shells=by_shells[reached], share=[share[0], share[reached]], kepler=limits.kepler_fraction.values[reached],
        sheds_mass=bool(limits.sheds_mass.values.any()),
    )  # fmt: skip
    assert smaller.max() >= 50 and share[0] <= 0.002
    assert constant < 1e-6
    assert np.abs(changed - expected).max() < 0.01 * np.abs(expected).max()
    assert np.abs(by_shells[reached] - expected[reached]) < 0.05 * np.abs(expected[reached])
