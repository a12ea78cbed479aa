"""The engine of a periodic box against plain sums over the particles and all images that can be in reach."""

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from astroinertia.engines import numba_cpu, periodic
from astroinertia.engines.terms import Output, PairTerm
from astroinertia.errors import NumericalError
from astroinertia.sph.kernels import KERNELS
from tests import pairs

KERNEL, ETA, COUNT = "wendland_c2", 1.3, 70
SUPPORT = KERNELS[KERNEL].support


def exchange_pair(xp, v_r, dW_i, dW_j, W_j, heat_i, heat_j):
    """Something of every kind of output."""
    return (heat_i + heat_j) * (dW_i + dW_j), heat_j * W_j, xp.maximum(-v_r, 0.0), dW_i, dW_i


EXCHANGE = PairTerm(
    "exchange",
    exchange_pair,
    (
        Output("acceleration", "central"), Output("heating", "sum"), Output("signal", "max"),
        Output("position", "outer", of="position"), Output("velocity", "outer", of="velocity"),
    ),
)  # fmt: skip


def box(lengths: Any) -> tuple[periodic.Engine, dict[str, np.ndarray]]:
    """An engine, and particles of which some have left the box; a clump makes lengths uneven."""
    random = np.random.default_rng(2)
    size = np.where(np.isfinite(lengths), lengths, 1.0)
    position = random.uniform(-0.6, 0.6, (COUNT, 3)) * size
    position[: COUNT // 3] = (0.45, 0.4, -0.5) * size + 0.1 * random.normal(size=(COUNT // 3, 3)) * size.min()
    fields = {
        "position": position, "mass": random.uniform(0.5, 1.5, COUNT) / COUNT,
        "velocity": random.normal(size=(COUNT, 3)), "heat": random.uniform(0.5, 1.5, COUNT),
    }  # fmt: skip
    return periodic.Engine(numba_cpu.Engine(), lengths, SUPPORT), fields


def all_images(fields: dict[str, np.ndarray], lengths: Any, cells: int) -> dict[str, np.ndarray]:
    """The particles, brought back into the box, and after them every image that any length can reach."""
    steps = [range(-cells, cells + 1) if np.isfinite(length) else (0,) for length in lengths]
    shifts = sorted(product(*steps), key=lambda cell: any(cell))
    size = np.where(np.isfinite(lengths), lengths, 1.0)
    home = fields["position"] - np.where(np.isfinite(lengths), size * np.round(fields["position"] / size), 0.0)
    seen = {name: np.concatenate([array] * len(shifts)) for name, array in fields.items()}
    seen["position"] = np.concatenate([home + size * cell for cell in shifts])
    beyond = np.maximum(seen["position"] - home.max(axis=0), home.min(axis=0) - seen["position"]).max(axis=1)
    kept = beyond <= SUPPORT * fields["smoothing_length"].max()
    return {name: array[kept] for name, array in seen.items()}


CUBE, SLAB, THIN = (1.0, 1.0, 1.0), (1.0, np.inf, 0.7), (1.0, 1.0, 0.25)


@pytest.mark.slow
@pytest.mark.parametrize("images", [1, pytest.param(periodic.IMAGES_OF_FEW, marks=pytest.mark.full)])
@pytest.mark.parametrize(
    ("lengths", "cells"),
    [(CUBE, 2), (SLAB, 2), pytest.param(THIN, 5, marks=pytest.mark.full)],
    ids=["cube", "slab", "thin"],
)
def test_sums_and_densities_are_those_over_all_images(
    lengths: Any, cells: int, images: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a thin box a particle is in reach of its own images. By the programs of many, and by those of few."""
    monkeypatch.setattr(numba_cpu, "FEW", COUNT)
    engine, fields = box(lengths)
    engine = replace(engine, inner=replace(engine.inner, images=images))
    order, arrangement = engine.arrange(fields["position"], np.full(COUNT, 0.05))
    assert engine.inner._few(len(arrangement.images.source)) == (images > 1)
    fields = {name: array[order] for name, array in fields.items()}
    position, mass = fields["position"], fields["mass"]
    found = engine.density(arrangement, KERNEL, position, mass, np.full(COUNT, 0.05), ETA, 1e-14)
    h = fields["smoothing_length"] = found.smoothing_length
    seen = all_images(fields, lengths, cells)
    assert cells * min(lengths) > SUPPORT * h.max()  # so that the images below are all there are
    home = seen["position"][:COUNT]
    r = np.linalg.norm(home[:, None] - seen["position"][None], axis=2) / h[:, None]
    rho = (seen["mass"] * KERNELS[KERNEL].w(np, r)).sum(axis=1) / h**3
    assert np.abs(found.density / rho - 1).max() <= 1e-12
    assert np.abs(h / (ETA * (mass / rho) ** (1 / 3)) - 1).max() <= 1e-12
    expected = pairs.pair_sums((EXCHANGE,), seen, KERNEL, scale=True)["exchange"]
    listed = engine.listed(arrangement, KERNEL, position, h)
    sums = engine.neighbour_sums(listed, KERNEL, (EXCHANGE,), fields)["exchange"]
    for name in ("acceleration", "heating", "position", "velocity"):
        scale = expected[name + " scale"][:COUNT].max()
        assert np.abs(sums[name] - expected[name][:COUNT]).max() <= 1e-12 * scale, name
    assert np.abs(sums["signal"] - expected["signal"][:COUNT]).max() <= 1e-12
    assert np.abs(mass @ sums["acceleration"]).max() <= 1e-13 * (mass * expected["acceleration scale"][:COUNT]).sum()


@pytest.mark.full
def test_particles_that_move_on_are_found_without_sorting_them_again() -> None:
    """Images follow their particles, and are made again where they no longer reach far enough; for targets alone."""
    engine, fields = box(CUBE)
    order, arrangement = engine.arrange(fields["position"], np.full(COUNT, 0.08))
    fields = {name: array[order] for name, array in fields.items()}
    fields["position"] = fields["position"] + 0.3 * fields["velocity"]
    fields["smoothing_length"] = h = np.random.default_rng(4).uniform(0.05, 0.2, COUNT)
    expected = pairs.pair_sums((EXCHANGE,), all_images(fields, CUBE, 1), KERNEL)["exchange"]
    chosen = np.arange(0, COUNT, 4)
    for targets in (None, chosen):
        listed = engine.listed(arrangement, KERNEL, fields["position"], h, targets)
        sums = engine.neighbour_sums(listed, KERNEL, (EXCHANGE,), fields, targets=targets)["exchange"]
        rows = slice(None) if targets is None else chosen
        for name, array in sums.items():
            assert array == pytest.approx(expected[name][:COUNT][rows], rel=1e-11, abs=1e-9), name
    assert engine.stale(arrangement, fields["position"], h)
    near = engine.near(arrangement, KERNEL, fields["position"], h, chosen)
    apart = fields["position"][:, None] - fields["position"][None, chosen]
    r = np.linalg.norm(apart - np.round(apart), axis=2)
    assert near[(r < SUPPORT * np.maximum(h[:, None], h[None, chosen])).any(axis=1)].all()


def test_a_box_has_no_virial_tensor() -> None:
    engine, fields = box(CUBE)
    _, arrangement = engine.arrange(fields["position"], np.full(COUNT, 0.1))
    with pytest.raises(ValueError, match="no virial tensor"):
        engine.neighbour_sums(arrangement, KERNEL, (EXCHANGE,), fields, virial=True)
    with pytest.raises(ValueError, match="no end in a periodic box"):
        engine.all_pair_sums(arrangement, KERNEL, (EXCHANGE,), fields)


@pytest.mark.parametrize(
    ("lengths", "message"),
    [((1e-30, 1.0, 1.0), r"over 2.6e\+29 lengths of the box along x"), ((0.01, 0.01, 0.01), "each needs over")],
)
def test_a_box_much_smaller_than_its_particles_reach_is_refused(lengths: Any, message: str) -> None:
    """It would take all memory, or all time."""
    engine = periodic.Engine(numba_cpu.Engine(), lengths, SUPPORT)
    position = np.random.default_rng(1).uniform(-0.5, 0.5, (COUNT, 3)) * lengths
    with pytest.raises(NumericalError, match=message):
        engine.arrange(position, np.full(COUNT, 0.12))
