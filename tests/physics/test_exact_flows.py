"""Fluids with exact or converged answers: expanding and oscillating ellipsoids, a cold collapse, Evrard's cloud."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.evolve import evolve, prepared
from tests.tradeoff_scenes import TOY_STAR

ROOT = Path(__file__).parent.parent.parent
REFERENCE = ROOT / "tests" / "reference"

FAMILIES = {"dyson": "dyson_ellipsoid", "cold": "cold_spheroid", "toy_star": None}


def scene_text(family: str) -> str:
    name = FAMILIES[family]
    return TOY_STAR if name is None else (ROOT / "sims" / f"{name}.toml").read_text()


def ellipsoid_errors(family: str, particles: int, *settings: str) -> dict[str, float]:
    """Largest relative errors of I_zz, of the semi-axes and of L_z/I_zz over the reference's times."""
    case = json.loads((REFERENCE / f"{family}.json").read_text())
    share = case["inputs"]["mass_second_moment_c2"]  # Q = share M a^2 along each axis
    # The cold family is followed to the compression by 10 in volume that is asked of it (t = 0.9).
    rows = [row for row in case["value"] if row["t"] > 0 and row["rho_over_rho0"] < 11]
    records = evolve(prepared(scene_text(family), f"body.particles={particles}", *settings), [row["t"] for row in rows])
    errors: dict[str, list[float]] = {"I_zz": [], "axes": [], "rate": []}
    for row, record in zip(rows, records, strict=True):
        axes = np.sqrt(np.linalg.eigvalsh(record["second_moment"])[::-1] / share)
        errors["I_zz"].append(abs(record["inertia_tensor"][2, 2] / row["Izz"] - 1))
        errors["axes"].append(np.max(np.abs(axes / np.array(row["a"]) - 1)))
        rate = record["angular_momentum"][2] / record["inertia_tensor"][2, 2]
        errors["rate"].append(abs(rate / row["omega_Lz_over_Izz"] - 1))
    return {name: float(np.max(values)) for name, values in errors.items()}


def order(counts: list[int], errors: list[float]) -> float:
    """Fitted order of the error in the resolution N^(1/3)."""
    return float(-np.polyfit(np.log(counts) / 3, np.log(errors), 1)[0])


EVRARD = (ROOT / "sims" / "evrard.toml").read_text()


def evrard_peaks(particles: int, *settings: str) -> dict[str, Any]:
    """Peaks of kinetic and thermal energy and their times, and their errors against the one-dimensional reference."""
    start = prepared(EVRARD, f"body.particles={particles}", *settings)
    times = np.arange(0.6, 1.3001, 0.01)
    records = evolve(start, list(times))
    found: dict[str, Any] = {}
    reference = json.loads((REFERENCE / "evrard.json").read_text())["value"]
    for name, key in (("kinetic_energy", "K_max"), ("internal_energy", "U_max")):
        values = np.array([record[name] for record in records])
        top = int(np.clip(np.argmax(values), 1, len(values) - 2))
        a, b, _ = np.polyfit(times[top - 1 : top + 2] - times[top], values[top - 1 : top + 2], 2)
        height, when = values[top] - b**2 / (4 * a), times[top] - b / (2 * a)
        exact, _, exact_time = reference[key].partition(" at t=")
        found[name] = float(height)
        found[f"{name}_error"] = float(height / float(exact) - 1)
        found[f"{name}_time_error"] = float(when / float(exact_time) - 1)
    found["energy_error"] = float(abs(records[-1]["total_energy"] / -0.6166667 - 1))
    found["steps"] = int(records[-1]["step"])
    return found


# Largest errors of I_zz and the axes at 3000 particles, half as much again as measured: 0.0034 and 0.0057; 0.0197 and
# 0.0157; 0.0175 and 0.0113. From 1000 particles on they fell with an order of 2.2, 2.0 and 2.0 in N^(1/3).
BARS = {"dyson": (0.0050, 0.0086), "cold": (0.030, 0.024), "toy_star": (0.027, 0.017)}


FEWER = {"toy_star": (250, 800)}  # with the bars of the order 2 in N^(1/3)
COLD = pytest.param("cold", marks=pytest.mark.full(inputs=["sims/cold_spheroid.toml"]))  # a minute


@pytest.mark.parametrize("family", [pytest.param("dyson", marks=pytest.mark.full), COLD, "toy_star"])
def test_an_ellipsoid_follows_its_exact_solution_and_converges(family: str) -> None:
    counts = FEWER.get(family, (1000, 3000))
    coarse, fine = (ellipsoid_errors(family, count) for count in counts)
    i_zz, axes = np.array(BARS[family]) * (3000 / counts[1]) ** (2 / 3)
    assert fine["I_zz"] < i_zz, fine
    assert fine["rate"] < i_zz, fine
    assert fine["axes"] < axes, fine
    assert order(counts, [coarse["I_zz"], fine["I_zz"]]) > 1.5, (coarse, fine)


@pytest.mark.full(inputs=["sims/dyson_ellipsoid.toml", "sims/cold_spheroid.toml"])
@pytest.mark.parametrize("family", BARS)
def test_an_ellipsoid_converges_at_full_size(family: str, result) -> None:
    """3000 to 30,000 particles; the Dyson ellipsoid within 1 % in I_zz."""
    counts = [3000, 10000, 30000]
    errors = {count: ellipsoid_errors(family, count) for count in counts}
    for name in ("I_zz", "axes", "rate"):
        result(**{f"{name}_{count}": errors[count][name] for count in counts})
        result(**{f"order_{name}": order(counts, [errors[count][name] for count in counts])})
    assert errors[30000]["I_zz"] <= 0.01
    assert order(counts, [errors[count]["I_zz"] for count in counts]) >= 1.0


UNBIASED = ('effects.pressure.order="fourth"', 'numerics.neighbours="rising"')


@pytest.mark.full
def test_a_toy_star_converges_with_rising_neighbours() -> None:
    """Measured at 1000 and 3000 particles: I_zz 0.0089 and 0.0059, axes 0.036 and 0.020; second order: I_zz 0.036."""
    coarse, fine = (ellipsoid_errors("toy_star", count, *UNBIASED) for count in (1000, 3000))
    assert coarse["I_zz"] < 0.013
    assert fine["I_zz"] < 0.009
    assert order([1000, 3000], [coarse["axes"], fine["axes"]]) > 1.2, (coarse, fine)


@pytest.mark.full
def test_a_toy_star_converges_with_rising_neighbours_to_ten_thousand(result) -> None:
    """Order at least 0.8 in N^(1/3) from each size to the next, of I_zz and of the axes."""
    counts = [1000, 3000, 10000]
    errors = [ellipsoid_errors("toy_star", count, *UNBIASED) for count in counts]
    for name in ("I_zz", "axes"):
        orders = [order(counts[k : k + 2], [error[name] for error in errors[k : k + 2]]) for k in (0, 1)]
        result(**{name: [error[name] for error in errors], f"orders_{name}": orders})
        assert min(orders) >= 0.8


WHOLE = ('effects.viscosity.stress="whole"', "effects.viscosity.alpha_max=1.0")


@pytest.mark.full
def test_shocks_of_evrards_cloud_heat_the_gas_by_what_they_should() -> None:
    """1000 particles: the peaks were 4.6 and 9.8 % low when measured, and with the whole stress 16.3 and 17.5 %.

    With Monaghan's means in the viscosity and second order besides they were 20.4 and 24.7 % low.
    """
    peaks = evrard_peaks(1000)
    assert abs(peaks["kinetic_energy_error"]) < 0.055, peaks
    assert abs(peaks["internal_energy_error"]) < 0.11, peaks


@pytest.mark.full
def test_shocks_of_evrards_cloud_do_not_heat_the_gas_ahead_of_them() -> None:
    """With the whole stress, which viscosity has by default, 1000 particles."""
    peaks = evrard_peaks(1000, *WHOLE)
    assert abs(peaks["kinetic_energy_error"]) < 0.175, peaks
    assert abs(peaks["internal_energy_error"]) < 0.185, peaks


@pytest.mark.full
def test_evrards_cloud_collapses_and_bounces() -> None:
    """3000 particles: the kinetic peak was 2.1 % low and the thermal one 4.8 % low when measured."""
    peaks = evrard_peaks(3000)
    assert abs(peaks["kinetic_energy_error"]) < 0.03, peaks
    assert abs(peaks["internal_energy_error"]) < 0.06, peaks
    assert abs(peaks["kinetic_energy_time_error"]) < 0.03, peaks
    assert abs(peaks["internal_energy_time_error"]) < 0.01, peaks
    assert peaks["energy_error"] < 1e-3, peaks


@pytest.mark.full(inputs=["sims/evrard.toml"])
@pytest.mark.parametrize(("particles", "bar"), [(10_000, 0.05), (30_000, 0.025)])
def test_evrards_peaks_are_right(particles: int, bar: float, result: Any) -> None:
    """Within 5 and 2.5 %."""
    peaks = evrard_peaks(particles)
    result(**peaks)
    assert abs(peaks["kinetic_energy_error"]) < bar
    assert abs(peaks["internal_energy_error"]) < bar
    assert peaks["energy_error"] < 1e-3


@pytest.mark.full(inputs=["sims/evrard.toml"])
def test_evrards_peaks_with_the_whole_stress_at_full_size(result) -> None:
    """3000 to 30,000 particles: peaks within 10 %, order at least 0.5 in N^(1/3)."""
    counts = [3000, 10000, 30000]
    found = {}
    for count in counts:
        found[count] = evrard_peaks(count, *WHOLE)
        result(**{f"{name}_{count}": value for name, value in found[count].items()})
    orders = {
        name: order(counts, [abs(found[count][f"{name}_error"]) for count in counts])
        for name in ("kinetic_energy", "internal_energy")
    }
    result(**{f"order_{name}": value for name, value in orders.items()})
    assert abs(found[30000]["kinetic_energy_error"]) <= 0.1
    assert abs(found[30000]["internal_energy_error"]) <= 0.1
    assert min(orders.values()) >= 0.5
