"""Gravity alone: error against time of this code and of pytreegrav, REBOUND and jaxFMM, on four sets of points.

    python tests/benchmarks/gravity_peers.py --points 10000 --keep

Every code's errors are relative, |a - a_direct| / |a_direct|, on the same sample of points, against a direct sum with
its own softening. Codes take turns in one run and the shortest time of each setting counts, tree building included
(jaxFMM: its lists are made beforehand). With --keep tables and a picture go to tests/benchmarks/results.
"""

import argparse
from collections.abc import Callable
from typing import Any

import numpy as np
from fair_times import RESULTS, best_times, clock_of, machine, publish, rows_of
from gravity_codes import CODES, DIRECT, OURS, QUADRUPOLE, present
from point_sets import SETS, PointSet, point_set

SAMPLE = 2000  # enough for a 99th percentile
JUDGED = 0.7  # pytreegrav's quadrupole at this opening angle is what ratios are taken to
Row = dict[str, Any]


def errors(found: np.ndarray, reference: np.ndarray) -> Row:
    """Relative errors: median, rms, 99th percentile and largest."""
    relative = np.linalg.norm(found - reference, axis=1) / np.linalg.norm(reference, axis=1)
    return {
        "median": np.median(relative),
        "rms": np.sqrt(np.mean(relative**2)),
        "p99": np.percentile(relative, 99),
        "largest": relative.max(),
    }


def compared(
    points: PointSet, codes: list[Any], rounds: int, sample: np.ndarray, clock: Callable[[], float]
) -> list[Row]:
    """A row for each code and setting: time and errors."""
    actions, rows = {}, []
    for code in codes:
        if len(points.mass) > code.most:
            print(f"{code.name} is left out: {len(points.mass)} points take it too long.\n")
            continue
        reference = code.reference(points, sample)
        for setting in code.settings:
            act = code.action(points, setting)
            actions[code.name, setting] = act
            rows.append({"code": code.name, "setting": setting, **errors(act()[sample], reference)})
    times = best_times(actions, rounds, clock, compiled=True)
    for row in rows:
        row["seconds"] = times[row["code"], row["setting"]]
    return rows


def ratios(rows: list[Row]) -> str:
    """How many times faster than pytreegrav's quadrupole this code is, at settings with no larger error of any kind."""
    ours = [row for row in rows if row["code"] == OURS.name]
    lines = []
    for peer in (row for row in rows if row["code"] == QUADRUPOLE.name):
        equal = [row for row in ours if all(row[kind] <= peer[kind] for kind in ("median", "rms", "p99"))]
        if equal:
            fastest = min(equal, key=lambda row: row["seconds"])
            lines.append(f"{peer['rms']:.1e}: {peer['seconds'] / fastest['seconds']:.1f}")
        else:
            lines.append(f"{peer['rms']:.1e}: no setting here has smaller errors")
    return ", ".join(lines)


def picture(all_rows: dict[str, list[Row]], points: int) -> None:
    """Error against time, a panel for each set."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(2, 2, figsize=(9.5, 8.0), sharex=True, sharey=True, layout="constrained")
    for panel, (name, rows) in zip(panels.flat, all_rows.items(), strict=False):
        for number, code in enumerate(CODES):
            mine = [row for row in rows if row["code"] == code.name]
            if not mine or code is DIRECT:
                continue
            style = {"color": "black", "linewidth": 2.2} if code is OURS else {"color": f"C{number}", "linewidth": 1.2}
            seconds, rms = [row["seconds"] for row in mine], [max(row["rms"], 1e-9) for row in mine]
            panel.loglog(seconds, rms, marker="o", markersize=3.5, label=code.name, **style)
        panel.set_title(name, fontsize=10)
        panel.grid(alpha=0.3)
        panel.set_ylim(3e-8, 1e-1)
    for panel in panels.flat[len(all_rows) :]:
        panel.remove()
    for panel in panels[1]:
        panel.set_xlabel("time of one evaluation (s)")
    for panel in panels[:, 0]:
        panel.set_ylabel("rms relative error of the acceleration")
    panels[0, 0].legend(fontsize=8)
    figure.savefig(RESULTS / f"gravity_peers_{points}.png", dpi=90)
    pyplot.close(figure)


def shown(rows: list[Row], judged: float) -> str:
    """The table of one set."""
    cells = [
        [
            row["code"],
            row["setting"],
            f"{1e3 * row['seconds']:.4g}",
            f"{row['seconds'] / judged:.3g}",
            *(f"{row[kind]:.1e}" for kind in ("median", "rms", "p99", "largest")),
        ]
        for row in rows
    ]
    return rows_of(["code", "setting", "time (ms)", "ratio", "median", "rms", "99th percentile", "largest"], cells)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=10_000)
    parser.add_argument("--sets", nargs="+", choices=tuple(SETS), default=list(SETS))
    parser.add_argument("--codes", nargs="+", choices=[code.name for code in CODES], default=[c.name for c in CODES])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--processor-time", action="store_true", help="count processor time, not wall time")
    parser.add_argument("--keep", action="store_true", help="write the tables and a picture")
    chosen = parser.parse_args()
    codes = present(tuple(code for code in CODES if code.name in chosen.codes))
    sample = np.sort(np.random.default_rng(5).choice(chosen.points, min(SAMPLE, chosen.points), replace=False))
    clock, kind = clock_of(chosen.processor_time)
    all_rows, tables = {}, []
    for name in chosen.sets:
        rows = compared(point_set(name, chosen.points), codes, chosen.rounds, sample, clock)
        judged = [r["seconds"] for r in rows if r["code"] == QUADRUPOLE.name and r["setting"] == JUDGED]
        table = shown(rows, judged[0] if judged else float("nan"))
        faster = (
            f"\nTimes faster than pytreegrav's quadrupole at its error: {ratios(rows)}.\n"
            if judged and OURS in codes
            else ""
        )
        all_rows[name] = rows
        tables.append(f"**{name}**\n\n{table}{faster}")
        print(tables[-1], flush=True)  # the whole takes long
    text = f"# Gravity alone, {chosen.points} points\n\n{machine()}; {kind}, the shortest of {chosen.rounds} rounds in "
    text += f"which all take turns. Ratio: to pytreegrav's quadrupole at {JUDGED}.\n\n" + "\n".join(tables)
    publish(f"gravity_peers_{chosen.points}", text, chosen.keep)
    if chosen.keep:
        picture(all_rows, chosen.points)


if __name__ == "__main__":
    main()
