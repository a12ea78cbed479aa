"""What a callback is given of a run: a body at one moment, in SI with units. Tests: tests/unit/run/test_callback.py."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from astroinertia.dataset.derived import derived_quantities
from astroinertia.dataset.regions import QUANTITIES as REGIONAL
from astroinertia.dataset.schema import (
    SNAPSHOT,
    TIME_QUANTITY,
    attributes,
    code_units,
    converted,
    reason_for_absence,
)
from astroinertia.dataset.series import frame_of, gap_tolerance
from astroinertia.effects.particle_names import CENTRE_VELOCITY, OF_PARTICLES as SEEN
from astroinertia.errors import AbsentError
from astroinertia.observables.quantities import DERIVED, OF_EFFECTS, RECORDED, Quantity
from astroinertia.scene.problems import nearest
from astroinertia.units import DIMENSIONLESS, astropy_quantity

# Of those that a function of a force has, the ones that snapshots have; and entropies.
OF_PARTICLES = {many: one for many, one in (SEEN | {"entropies": "entropy"}).items() if one in SNAPSHOT}


class RunState:
    """A body at one moment of its run: quantities of astropy in SI (without units where the scene is in code units).

    time; step; model, and effects, whose order is that of rows. Every quantity of the headline series has its name, as
    in a dataset: inertia_tensor (3, 3), angular_momentum (3,), total_energy, ledger_closure, virial_tensor (E, 3, 3)
    and so on, also those that follow, such as principal_moments (3,), and centre_of_mass_velocity (3,). Of particles
    there are positions (N, 3), velocities (N, 3), masses (N,), densities (N,), smoothing_lengths, internal_energies,
    entropies and pressures, in the order of their identities, without those that sinks have accreted. A function that
    serves as a force gets the same names (effects.by_function). What a body does not have raises AbsentError, which
    says why, so that hasattr tells. All are copies: what is done to them changes nothing in the run.
    """

    def __init__(
        self, time: float, step: int, series: Mapping[str, Any], particles: Mapping[str, Any] | None,
        metadata: Mapping[str, Any],
    ) -> None:  # fmt: skip
        self._time, self.step, self._metadata = time, step, metadata
        self.model, self.effects = str(metadata.get("model")), tuple(metadata.get("effects", ()))
        self._series = {name: np.array(value) for name, value in series.items()}
        if particles is not None:
            present = np.isfinite(particles["mass"])
            particles = {name: np.array(array)[present] for name, array in particles.items() if name != "time"}
        self._particles = particles

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        if name == "time":
            return self._quantity(np.array(self._time), TIME_QUANTITY)
        if name == CENTRE_VELOCITY:
            return self.momentum / self.mass
        if name in OF_PARTICLES:
            return self._of_particles(name)
        schema = self._schema
        value = self._series.get(name)
        if value is None and name in DERIVED:
            value = self._derived.get(name)
        if name in schema and value is not None and not (value.dtype.kind == "f" and np.isnan(value).all()):
            return self._quantity(value, schema[name])
        if name not in schema:
            raise AbsentError(f"a state has no {name!r}; {nearest(name, sorted(dir(self)))}")
        metadata = self._metadata
        reason = metadata.get("absent", {}).get(name) or schema[name].absent.get(self.model)
        reason = reason or reason_for_absence(name, list(self.effects), self._dimensionless, frame_of(metadata))
        raise AbsentError(f"this state has no {name}: {reason}.")

    def __dir__(self) -> list[str]:
        known = [name for name in (*self._series, *self._derived) if name in self._schema]
        particles = [many for many, one in OF_PARTICLES.items() if self._particles and one in self._particles]
        moving = [CENTRE_VELOCITY] if {"momentum", "mass"} <= set(known) else []
        return list(dict.fromkeys(["time", "step", "model", "effects", *known, *moving, *particles]))

    def __repr__(self) -> str:
        particles = "" if self._particles is None else f", {len(self._particles['mass'])} particles"
        return f"RunState(time={self.time:.6g}, step={self.step}, model={self.model!r}{particles})"

    @cached_property
    def _schema(self) -> dict[str, Quantity]:
        own = {name: Quantity.of_description(said) for name, said in self._metadata.get("observables", {}).items()}
        return {**RECORDED, **DERIVED, **OF_EFFECTS, **REGIONAL, **own}

    @cached_property
    def _derived(self) -> dict[str, np.ndarray]:
        single = {name: value[None] for name, value in self._series.items()}
        radius, structure = (self._metadata.get(name) for name in ("reference_radius", "structure"))
        derived = derived_quantities(single, gap_tolerance(self._metadata), radius, structure or {})
        return {name: array[0] for name, array in derived.items()}

    @property
    def _dimensionless(self) -> bool:
        return code_units(self._metadata) == DIMENSIONLESS

    def _of_particles(self, name: str) -> Any:
        if self._particles is None:
            raise AbsentError(f"this state has no {name}: the model {self.model} has no particles.")
        return self._quantity(self._particles[OF_PARTICLES[name]], SNAPSHOT[OF_PARTICLES[name]])

    def _quantity(self, value: np.ndarray, quantity: Quantity) -> Any:
        in_si = np.array(converted(value, quantity, code_units(self._metadata)))
        return astropy_quantity(in_si, attributes(quantity, self._metadata)["units"])
