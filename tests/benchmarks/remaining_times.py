"""What a run says that it has still to go, against what it then took, when 25, 50 and 75 % of its time were over.

    NUMBA_NUM_THREADS=1 python tests/benchmarks/remaining_times.py --keep

Runs go by a clock of processor time, which other work on the machine leaves alone but for the caches that are shared.
Preparing a run is no part of them; compile before (`astroinertia warm`, or run this twice).
"""

import argparse
import json
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace

from fair_times import RESULTS, machine as machine_in_words, publish, rows_of
from predicted_steps import fewer

from astroinertia.run import loop
from astroinertia.scene import load

SIMS = Path(__file__).parents[2] / "sims"
KEPT = RESULTS / "remaining_times.json"
SHARES = 0.25, 0.5, 0.75  # of a run's time
WITHIN = 1.5
SCENES = {
    "bar_mode": 500, "boss_bodenheimer": 500, "cold_spheroid": 1000, "collapse_to_sink": 500, "core_collapse": 500,
    "dyson_ellipsoid": 2000, "evrard": 500, "homologous_collapse": 500, "keplerian_disc": 500, "kelvin_helmholtz": 500,
    "neutron_star": 500, "noh": 1000, "one_star_three_models": 500, "progenitor_collapse": 500,
    "protostellar_disc": 500, "rotating_star": 1000, "sod": 1000, "square": 500, "tidal_disruption": 500,
}  # fmt: skip


def reported(name: str, particles: int) -> list[tuple[float, float]]:
    """When a run reported, and what it had to go, in seconds since its first step; the end of it last."""
    scene = fewer(load.load_file(SIMS / f"{name}.toml"), particles)
    seen: list[tuple[float, float]] = []
    with tempfile.TemporaryDirectory() as folder:
        loop.run_scene(scene, Path(folder) / "run", lambda each: seen.append((time.process_time(), each.to_go)))
    return [(now - seen[0][0], to_go) for now, to_go in seen]


def row_of(seen: list[tuple[float, float]]) -> dict[str, list[float] | float]:
    """The whole time, what was shown when each share of it was over, and what there was to come."""
    whole = seen[-1][0]
    moments = [next(each for each in seen if each[0] >= share * whole) for share in SHARES]
    return {"seconds": whole, "shown": [to_go for _, to_go in moments], "left": [whole - now for now, _ in moments]}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[""], help="parts of names")
    parser.add_argument("--keep", action="store_true", help="write the table, with the rows kept before")
    chosen = parser.parse_args()
    loop.clock = SimpleNamespace(monotonic=time.process_time)  # type: ignore[assignment]
    rows = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    for name in [name for name in SCENES if any(word in name for word in chosen.only)]:
        rows[name] = row_of(reported(name, SCENES[name]))
        print(name, rows[name], flush=True)
        if chosen.keep:
            KEPT.write_text(json.dumps(rows, indent=1) + "\n")
    cells, good = [], 0
    for name, row in sorted(rows.items()):
        ratios = [shown / left for shown, left in zip(row["shown"], row["left"], strict=True)]
        good += (within := all(1.0 / WITHIN <= ratio <= WITHIN for ratio in ratios))
        pairs = [f"{shown:.2g} for {left:.2g}" for shown, left in zip(row["shown"], row["left"], strict=True)]
        cells.append([name, SCENES[name], f"{row['seconds']:.2g}", *pairs, *(f"{ratio:.2f}" for ratio in ratios),
                      "" if within else "out"])  # fmt: skip
    shares = [f"{100 * share:.0f} %" for share in SHARES]
    head = ["scene", "particles", "seconds", *(f"shown at {share} (s)" for share in shares),
            *(f"ratio at {share}" for share in shares), ""]  # fmt: skip
    text = f"# Seconds to go, shown and true\n\n{rows_of(head, cells)}\n"
    text += f"{good} of {len(cells)} scenes are within a factor of {WITHIN} at all three moments.\n"
    publish("remaining_times", f"{text}\n{machine_in_words()}\n", chosen.keep)


if __name__ == "__main__":
    main()
