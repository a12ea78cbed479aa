"""Individual time steps beside global ones over the same interval: the speed-up, and what is kept.

    python tests/benchmarks/individual_steps.py --scene encounter --particles 30000 --keep

collapse: Evrard's, through its bounce. encounter: a gaseous star passes a small one of a thousandth of its volume and
more, whose particles need far shorter steps. bounce: sims/core_collapse.toml from before nuclear density until after,
with base steps as long as limits allow (its own are short for the sake of records). Both kinds of steps take turns, so
that other work on the machine falls on both; compilation, placing and records are apart. Ideal: N 2^k / sum 2^(k_i), of
the rungs as they change, with k the finest at each moment, even if it is that of a single particle. Saved: what the
global steps evaluated over what the individual ones did.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from evrard_cloud import GAS, cloud
from fair_times import machine, processor_clock, publish, rows_of

from astroinertia.bodies.polytrope import Polytrope
from astroinertia.build.assemble import prepare
from astroinertia.models.sph import block_step
from astroinertia.models.sph.block_step import Taken
from astroinertia.models.sph.evolution import Particles
from astroinertia.scene import load
from astroinertia.sph import profiles
from astroinertia.sph.placement import place

SHARES = ("share", "share_saved", "share_processor", "share_saved_processor")  # shown as percentages
TURNS = 8  # of either kind of steps in the interval
SIMS = Path(__file__).parents[2] / "sims"
INDEX = 1.5  # of both stars
SMALL_MASS, SMALL_RADIUS = 0.03, 0.01  # of the other star, in units of the first
DISTANCE, PERICENTRE = 1.5, 1.2  # of a parabolic passage, in radii of the first star
ENCOUNTER = f"""
name = "encounter"
units = "code"
[body]
kind = "table"
file = "stars.npz"
{GAS}[time]
end = 1.0
"""


def star(count: int, mass: float, radius: float, seed: int) -> dict[str, np.ndarray]:
    """A polytrope as particles on a lattice: mass (N,), place (N, 3) and specific internal energy u (N,)."""
    profile, body = profiles.polytrope(INDEX), Polytrope(INDEX, mass, radius)
    unit = place(profile, count, "lattice", seed)
    inside = np.minimum(np.linalg.norm(unit, axis=1), float(profile.radius(np.array(1.0 - 1e-4))))
    density = profile.density(inside) * mass / radius**3
    energy = INDEX * body.constant * density ** (1.0 / INDEX)
    return {"mass": np.full(count, mass / count), "place": unit * radius, "u": energy}


def encounter(particles: int, *settings: str) -> Particles:
    """Two stars on a parabola, a little before their pericentre; all particles have the same mass."""
    small = round(particles * SMALL_MASS / (1.0 + SMALL_MASS))
    stars = star(particles - small, 1.0, 1.0, 1), star(small, SMALL_MASS, SMALL_RADIUS, 2)
    total = 1.0 + SMALL_MASS
    tangential = np.sqrt(2.0 * total * PERICENTRE) / DISTANCE
    radial = np.sqrt(2.0 * total / DISTANCE - tangential**2)
    apart, passing = np.array([DISTANCE, 0.0, 0.0]), np.array([-radial, tangential, 0.0])
    shares = -SMALL_MASS / total, 1.0 / total
    place_of = np.concatenate([each["place"] + share * apart for each, share in zip(stars, shares, strict=True)])
    velocity = np.concatenate(
        [np.tile(share * passing, (len(each["u"]), 1)) for each, share in zip(stars, shares, strict=True)]
    )
    columns: dict[str, Any] = {name: np.concatenate([each[name] for each in stars]) for name in ("mass", "u")}
    columns |= dict(zip("xyz", place_of.T, strict=True)) | dict(zip(("vx", "vy", "vz"), velocity.T, strict=True))
    with tempfile.TemporaryDirectory() as folder:
        np.savez(Path(folder) / "stars.npz", **columns)
        (Path(folder) / "encounter.toml").write_text(ENCOUNTER, encoding="utf-8")
        body = prepare(load.load_file(Path(folder) / "encounter.toml", list(settings))).evolution
    assert isinstance(body, Particles)
    return body


def collapse(particles: int, *settings: str) -> Particles:
    """Evrard's cloud."""
    return cloud(particles, "mixed", *settings, placement="glass")


def bounce(particles: int, *settings: str) -> Particles:
    """The core of sims/core_collapse.toml, whose base steps nothing but its limits keep short."""
    text = (SIMS / "core_collapse.toml").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("free_fall_factor")]
    scene = load.loads("\n".join(lines), [f"body.particles={particles}", *settings])
    body = prepare(scene).evolution
    assert isinstance(body, Particles)
    return body


@dataclass
class Course:
    """A run under way, and what it took."""

    body: Particles
    opening: dict[str, Any]
    seconds: float = 0.0
    processor_seconds: float = 0.0
    steps: int = 0
    energy_error: float = 0.0
    inertia: list[float] = field(default_factory=list)

    def advance(self, enough: float, until: float) -> None:
        """To a time or past it, but no further than the other one, and what there is then."""
        begin, begin_processor = time.perf_counter(), processor_clock()
        while self.body.time < enough * (1.0 - 1e-14):
            self.body.advance(until)
            self.steps += 1
        self.seconds += time.perf_counter() - begin
        self.processor_seconds += processor_clock() - begin_processor
        record = self.body.record(self.opening["potential_energy"])
        self.energy_error = max(self.energy_error, abs(record["total_energy"] / self.opening["total_energy"] - 1.0))
        self.inertia.append(record["inertia_tensor"][2, 2])


# How a scene is made, of how many particles, and the interval.
SCENES: dict[str, tuple[Callable[..., Particles], int, float, float]] = {
    "collapse": (collapse, 10_000, 0.0, 1.1),
    "encounter": (encounter, 30_000, 0.0, 0.06),
    "bounce": (bounce, 3000, 0.205, 0.214),
}


def measured(
    scene: str, particles: int | None = None, begin: float | None = None, end: float | None = None
) -> dict[str, float]:
    """One interval of a scene by both kinds of steps, from the same state, which individual steps have led to."""
    make, usual, first, last = SCENES[scene]
    particles = usual if particles is None else particles
    begin, end = first if begin is None else begin, last if end is None else end
    bodies = {kind: make(particles, f'numerics.timesteps="{kind}"') for kind in ("global", "individual")}
    steps: list[Taken] = []

    def base_step(*arguments: Any, **named: Any) -> Any:
        found = block_step.step(*arguments, **named)
        steps.append(found[2])
        return found

    one = bodies["individual"]
    one.base_step = base_step
    while one.time < begin:
        one.advance(begin)
    bodies["global"].state, bodies["global"].arrangement = one.state, one.arrangement
    kept = one.state, one.arrangement
    for body in bodies.values():
        body.rehearse()  # compiles what steps of several intervals need, which may come late
        body.advance(end)
        body.state, body.arrangement = kept
    steps.clear()
    courses = {kind: Course(body, body.record(None)) for kind, body in bodies.items()}
    each, all_alike = courses["individual"], courses["global"]
    for enough in np.linspace(begin, end, TURNS + 1)[1:]:
        each.advance(float(enough), end)
        all_alike.advance(each.body.time, each.body.time)
    evaluations = sum(taken.evaluations for taken in steps)
    ends = sum(taken.ends for taken in steps)
    ideal, saved = particles * ends / evaluations, particles * all_alike.steps / evaluations
    reached = all_alike.seconds / each.seconds
    by_processor = all_alike.processor_seconds / each.processor_seconds
    return {
        "particles": particles,
        "ideal": ideal,
        "saved": saved,
        "reached": reached,
        "share": reached / ideal,
        "share_saved": reached / saved,
        "share_processor": by_processor / ideal,
        "share_saved_processor": by_processor / saved,
        "global_steps": all_alike.steps,
        "finest_steps": ends,
        "base_steps": each.steps,
        "global_seconds": all_alike.seconds,
        "seconds": each.seconds,
        "inertia": float(np.max(np.abs(np.array(each.inertia) / np.array(all_alike.inertia) - 1.0))),
        "energy_global": all_alike.energy_error,
        "energy": each.energy_error,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument("--particles", nargs="+", type=int, default=[None])
    parser.add_argument("--begin", type=float, help="of the interval")
    parser.add_argument("--end", type=float, help="of the interval")
    parser.add_argument("--keep", action="store_true", help="write the table")
    chosen = parser.parse_args()
    rows = []
    for scene in chosen.scene:
        for particles in chosen.particles:
            found = measured(scene, particles, chosen.begin, chosen.end)
            rows.append([
                scene, *(found[name] for name in ("particles", "global_steps", "finest_steps", "base_steps")),
                *(f"{found[name]:.3g}" for name in ("global_seconds", "seconds", "ideal", "saved", "reached")),
                *(f"{100 * found[name]:.0f} %" for name in SHARES),
                *(f"{found[name]:.1e}" for name in ("inertia", "energy_global", "energy")),
            ])  # fmt: skip
    head = [
        "scene", "particles", "global steps", "finest steps", "base steps", "global (s)", "individual (s)", "ideal",
        "saved", "reached", "of the ideal", "of what was saved", "of the ideal by processor time", "of what was saved",
        "I_zz apart", "energy error, global", "individual",
    ]  # fmt: skip
    text = f"# Individual time steps beside global ones\n\n{machine()}.\n\n"
    publish("individual_steps", text + rows_of(head, rows), chosen.keep)


if __name__ == "__main__":
    main()
