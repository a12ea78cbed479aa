"""A year of hourly records of a tumbling asteroid: wall time of runs, cold and warm, and of solve_ivp beside them.

Each run is `run_scene` in a process of its own, from its imports to its file; cold is with nothing compiled before.
solve_ivp (DOP853) integrates Euler's equations with the same dissipation and gravity gradient and gives attitude and L
at the same hours, and nothing else. Run on a machine that does nothing else: python tests/benchmarks/rigid_records.py
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

SCENE = """
name = "tumbling_asteroid"
model = "rigid"
[body]
kind = "rigid"
mass = "1.9e13 kg"
radius = "1.22 km"
moment_ratios = [0.236, 0.730, 0.760]
rotation = { period = "5.4 d", axis = [0.9, 0.3, 0.3] }
[effects.internal_dissipation]
time_scale = "100 d"
[numerics]
integrator = "INTEGRATOR"
order = 6
[time]
end = "365.25 d"
[output]
series_every = "1 h"
"""
SUN = """
[[companions]]
name = "Sun"
mass = "1.98841e30 kg"
semi_major_axis = "2.53 au"
eccentricity = 0.634
[effects.gravity_gradient]
"""
DAY, GRAVITATION = 86400.0, 6.6743e-11


def run(scene: Path, cache: Path) -> tuple[float, float]:
    """Seconds of wall and of processor time of `astroinertia run`, imports and file included."""
    kept = {"JAX_COMPILATION_CACHE_DIR": str(cache / "jax"), "NUMBA_CACHE_DIR": str(cache / "numba")}
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "astroinertia", "run", str(scene), "--output", f"{folder}/run"]
        begun, before = time.monotonic(), os.times()
        subprocess.run(command, env=os.environ | kept, check=True, capture_output=True)
        after = os.times()
        used = after.children_user + after.children_system - before.children_user - before.children_system
        return time.monotonic() - begun, used


def by_solve_ivp(with_sun: bool) -> tuple[float, float, float]:
    """Seconds of wall and of processor time, and the change of |L| in the run, for the same body."""
    moments = np.array([0.236, 0.730, 0.760])  # over M R^2, which leaves the motion alone
    axis = np.array([0.9, 0.3, 0.3])
    m = moments * (2.0 * np.pi / (5.4 * DAY)) * axis / np.linalg.norm(axis)
    excess = 0.5 * (1.0 / moments[0] + 1.0 / moments[1]) - 1.0 / moments[2]
    mu, major, eccentricity = GRAVITATION * 1.98841e30, 2.53 * 1.495978707e11, 0.634

    def sun(now: float) -> np.ndarray:
        mean = np.sqrt(mu / major**3) * now
        anomaly = mean
        for _ in range(12):
            anomaly -= (anomaly - eccentricity * np.sin(anomaly) - mean) / (1.0 - eccentricity * np.cos(anomaly))
        flat = np.sqrt(1.0 - eccentricity**2)
        return major * np.array([np.cos(anomaly) - eccentricity, flat * np.sin(anomaly), 0.0])

    def rate(now: float, state: np.ndarray) -> np.ndarray:
        q, m = state[:4], state[4:]
        omega = m / moments
        beyond = np.cross(m, omega) / (100.0 * DAY * (m @ m) * excess)
        turn = omega + beyond
        w, v = q[0], q[1:]
        torque = np.zeros(3)
        if with_sun:
            place = sun(now)
            towards = place / np.linalg.norm(place)
            u = towards - 2.0 * w * np.cross(v, towards) + 2.0 * np.cross(v, np.cross(v, towards))
            torque = 3.0 * mu / np.linalg.norm(place) ** 3 * np.cross(u, moments * u)
        turned = 0.5 * np.concatenate([[-v @ turn], w * turn + np.cross(v, turn)])
        return np.concatenate([turned, np.cross(m, turn) + torque])

    start = np.concatenate([[1.0, 0.0, 0.0, 0.0], m])
    times = 3600.0 * np.arange(8767)
    begun, used = time.monotonic(), time.process_time()
    unit = np.concatenate([np.ones(4), np.full(3, np.linalg.norm(m))])
    done = solve_ivp(rate, (0.0, times[-1]), start, "DOP853", times, rtol=1e-12, atol=1e-14 * unit)
    taken, used = time.monotonic() - begun, time.process_time() - used
    sizes = np.linalg.norm(done.y[4:], axis=0)
    return taken, used, float(abs(sizes[-1] / sizes[0] - 1.0))


def main() -> None:
    """Write the table."""
    lines = ["| scene | integrator | cold | warm | solve_ivp, motion alone |", "|---|---|---|---|---|"]
    with tempfile.TemporaryDirectory() as folder:
        for name, more in (("dissipation", ""), ("dissipation, gravity gradient of the Sun", SUN)):
            *alone, _ = by_solve_ivp(bool(more))
            for integrator in ("splitting", "adaptive"):
                scene, cache = Path(folder) / "scene.toml", Path(folder) / f"{integrator}{len(more)}"
                scene.write_text(SCENE.replace("INTEGRATOR", integrator) + more)
                cold, *warm = (run(scene, cache) for _ in range(3))
                cells = (f"{wall:.1f} ({used:.1f})" for wall, used in (cold, min(warm), alone))
                lines.append(f"| {name} | {integrator} | {' | '.join(cells)} |")
                print(lines[-1], flush=True)
    head = "# A year of hourly records (8767) of a tumbling asteroid\n\n"
    head += "Seconds of wall time, on a machine that may be shared, and of processor time in brackets.\n\n"
    result = Path(__file__).parent / "results" / "rigid_records.md"
    result.write_text(head + "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
