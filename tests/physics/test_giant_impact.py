"""A giant impact: what it leaves, and that the ledger of mass, angular momentum and energy closes over it."""

import math
from pathlib import Path

import numpy as np
import pytest

from astroinertia import dataset as datasets
from astroinertia.run.loop import run_scene
from astroinertia.scene import load
from astroinertia.studies.impact_remnant import remnant
from astroinertia.units import GRAVITATIONAL_CONSTANT

SCENE = Path(__file__).parents[2] / "sims" / "giant_impact.toml"
CONDENSED = 1340.0  # kg/m^3, half the density of granite without pressure
SHARE = 0.13  # of the particles, and of the mass, in the impactor


CORRECTED = ("equation_of_state.boundary_pressure='5 GPa'", "bodies.0.surface=full", "bodies.1.surface=full")
LUNAR = 7.346e22  # kg


def after(count, end, folder, *settings):
    """The series and what is left after a time, of so many particles."""
    settings = [
        f"bodies.0.particles={round((1 - SHARE) * count)}", f"bodies.1.particles={round(SHARE * count)}", *settings
    ]  # fmt: skip
    file = run_scene(load.load_file(SCENE, [*settings, f"time.end='{end}'", "output.snapshot_every='30 min'"]), folder)
    snapshots = datasets.open_snapshots(file)
    assert snapshots is not None
    last = snapshots.isel(snapshot_time=-1).load()
    mass, position, velocity, density = (last[name].values for name in ("mass", "position", "velocity", "density"))
    left = remnant(mass, position, velocity, density, CONDENSED, GRAVITATIONAL_CONSTANT)
    return datasets.open(file).load(), left, mass, last["material"].values


def ledger_closes(series, momentum, energy):
    spin = series.angular_momentum.values
    assert np.linalg.norm(spin - spin[0], axis=1).max() < momentum * np.linalg.norm(spin[0])
    assert np.ptp(series.total_energy.values) < energy * np.abs(series.gravitational_energy.values).max()
    assert series.ledger_closure.max() < 1e-12


@pytest.mark.full
def test_an_impact_spins_a_planet_up_and_its_ledger_closes(tmp_path):
    """500 particles, 3 h: angular momentum to 1e-13, energy to 1e-3 (measured 2e-4 over the whole day).

    The planet is by then most of the mass and turns with the orbit; what turns in all is what there was.
    """
    series, left, mass, _ = after(500, "3 h", tmp_path / "run")
    ledger_closes(series, 1e-13, 1e-3)
    assert (left.planet.astype(int) + left.disc + left.escaped == 1).all()
    assert mass[left.planet].sum() > 0.85 * mass.sum()
    total = series.angular_momentum.values[0]
    assert left.planet_angular_momentum @ total > 0.1 * (total @ total)
    assert left.angular_velocity @ total > 0
    assert series.jeans_ratio.isnull().all()  # rock under tension is no gas


@pytest.mark.full(inputs=["sims/giant_impact.toml"])
def test_what_an_impact_leaves_settles_with_particles(tmp_path, result):
    """From 1000 to 2000: spin period within 10 %, moment ratio within 1 %; measured 2.5 and 0.3 %.

    The disc is of 10 to 50 particles, and its mass only bracketed: rock, without iron, 0.5 to 4 % of all.
    """
    periods, ratios, discs, flattenings = [], [], [], []
    for count in (1000, 2000):
        series, left, mass, material = after(count, "24 h", tmp_path / str(count))
        ledger_closes(series, 1e-13, 1e-3)
        periods.append(2 * math.pi / float(np.linalg.norm(left.angular_velocity)) / 3600)
        ratios.append(left.moment_ratio)
        flattenings.append(left.flattening)
        discs.append(float(mass[left.disc].sum() / mass.sum()))
        assert (material[left.disc] == 1).mean() > 0.9  # 0 is iron
    result(period_hours=periods, moment_ratio=ratios, flattening=flattenings, disc_share=discs)
    assert periods[1] == pytest.approx(periods[0], rel=0.10)
    assert ratios[1] == pytest.approx(ratios[0], rel=0.01)
    assert all(0.005 < disc < 0.04 for disc in discs)


@pytest.mark.full(inputs=["sims/giant_impact.toml"])
@pytest.mark.parametrize("settings", [(), CORRECTED], ids=["smoothed", "corrected"])
def test_three_placements_leave_one_planet_and_discs_that_differ(tmp_path, result, settings):
    """1000 particles. Measured twice, with code that differs in round-off: discs of 1.63 +- 0.16 and 1.73 +- 0.75 lunar
    masses, with corrected densities 1.71 +- 0.35 and 1.95 +- 0.08: such an impact is chaotic.

    Among three spin periods differ by 3 to 9 %, moment ratios by 0.3 to 0.5 %. The mean of three discs is held to three
    of its standard errors by the largest scatter.
    """
    periods, ratios, discs = [], [], []
    for seed in (1, 2, 3):
        seeds = (f"bodies.0.seed={seed}", f"bodies.1.seed={seed + 100}")
        series, left, mass, material = after(1000, "24 h", tmp_path / str(seed), *seeds, *settings)
        ledger_closes(series, 1e-13, 1e-3)
        periods.append(2 * math.pi / float(np.linalg.norm(left.angular_velocity)) / 3600)
        ratios.append(left.moment_ratio)
        discs.append(float(mass[left.disc].sum() / LUNAR))
        assert (material[left.disc] == 1).mean() > 0.9
    result(period_hours=periods, moment_ratio=ratios, disc_lunar_masses=discs)
    assert np.ptp(periods) < 0.2 * np.mean(periods)
    assert np.ptp(ratios) < 0.01 * np.mean(ratios)
    assert np.mean(discs) == pytest.approx(1.75, abs=1.3)
