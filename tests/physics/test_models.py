"""What holds for every model without particles, shown on every scene of sims that one of them answers."""

import numpy as np
import pytest

import astroinertia
from astroinertia import dataset
from astroinertia.observables.quantities import DERIVED, RECORDED
from astroinertia.scene import load
from astroinertia.scene.schema import Scene
from astroinertia.storage.archive import Archive
from tests.sims import SIMS, single_scenes

SCENES = sorted(path.stem for path in single_scenes() if load.load_file(path).model != "sph")
# Those that take the least; the others, which compile as long: test-full.
FEW = ("core_to_pulsar_scaling", "crab_pulsar")
CRASH_AT = 4  # the checkpoint at which a run is made to crash


def shortened(name: str) -> Scene:
    whole = load.load_file(SIMS / f"{name}.toml")
    unit = "" if whole.dimensionless else " s"
    end, every = (f"{value!r}{unit}" for value in (whole.time.end / 20, whole.time.end / 200))
    return load.load_file(
        SIMS / f"{name}.toml", [f"time.end={end}", f"output.series_every={every}", "output.checkpoint_seconds=0"]
    )


@pytest.mark.parametrize("name", [pytest.param(name, marks=() if name in FEW else pytest.mark.full) for name in SCENES])
def test_a_run_that_crashes_goes_on_bit_for_bit_and_has_the_whole_schema(name, tmp_path, monkeypatch):
    scene = shortened(name)
    whole = dataset.open(astroinertia.run_scene(scene, tmp_path / "whole"))
    assert set(whole.data_vars) >= set(RECORDED) | set(DERIVED)
    for variable in whole.data_vars.values():
        if variable.dtype.kind == "f" and variable.size and np.isnan(variable.values).all():
            assert variable.attrs["reason"]
    assert whole.attrs["approximation"] and whole.sizes["time"] == 11

    save, saved = Archive.write_checkpoint, []

    def crash(archive, arrays, scalars):
        saved.append(scalars)
        if len(saved) == CRASH_AT:
            raise OSError("the power is gone")
        save(archive, arrays, scalars)

    monkeypatch.setattr(Archive, "write_checkpoint", crash)
    with pytest.raises(OSError, match="power"):
        astroinertia.run_scene(scene, tmp_path / "parts")
    monkeypatch.undo()
    parts = dataset.open(astroinertia.resume(tmp_path / "parts"))
    assert parts.sizes == whole.sizes
    for variable in whole.data_vars:
        if variable != "wall_time":
            np.testing.assert_array_equal(parts[variable].values, whole[variable].values, err_msg=str(variable))
