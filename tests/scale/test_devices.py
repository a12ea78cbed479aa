"""Work that is shared out over devices, and over hosts, gives what one device gives."""

import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import jax
import pytest

from astroinertia.engines.mesh import shared_out
from astroinertia.errors import SceneError

HERE = Path(__file__).parent
BAR = 1e-13
VIRTUAL = {"XLA_FLAGS": "--xla_force_host_platform_device_count=8"}


def started(*arguments, **variables):
    """The program of sums on several devices, by itself: the number of devices is fixed when JAX starts."""
    command = [sys.executable, str(HERE / "device_sums.py"), *arguments]
    environment = {**os.environ, "JAX_PLATFORMS": "cpu", "PYTHONPATH": str(HERE.parents[1]), **variables}
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def differences_of(process):
    """{number of devices: {quantity: its largest difference over its largest value}}."""
    output, complaints = process.communicate(timeout=1200)
    assert process.returncode == 0, complaints
    return json.loads(output[output.index("{") :])


def assert_alike(found, quantities):
    for count, differences in found.items():
        assert len(differences) == quantities, differences
        worst = max(differences, key=differences.get)
        assert differences[worst] <= BAR, (count, worst, differences[worst])


@pytest.mark.full
def test_eight_devices_find_what_one_finds():
    """Densities, and sums and a largest over neighbours; the full test has gravity and derivatives, too."""
    assert_alike(differences_of(started("8", "--few", **VIRTUAL)), 5)


@pytest.mark.full
def test_any_number_of_devices_finds_what_one_finds_with_derivatives(result):
    found = differences_of(started("2", "4", "8", "--derivatives", **VIRTUAL))
    result(largest_difference={count: max(each.values()) for count, each in found.items()})
    assert_alike(found, 13)


@pytest.mark.full
def test_two_processes_find_what_one_finds(result):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        place = f"127.0.0.1:{free.getsockname()[1]}"
    both = [started("2", "--host", number, place) for number in ("0", "1")]
    found = [differences_of(process) for process in both]
    result(largest_difference=[max(each["2"].values()) for each in found])
    for each in found:
        assert_alike(each, 10)


RUNS = """
import sys
import numpy as np
import astroinertia
from astroinertia.scene.load import load_file

settings = ["body.particles=200", "body.relax=false", "numerics.engine='xla'", "time.max_steps=4"]
one, two = (
    astroinertia.open(
        astroinertia.run_scene(load_file(sys.argv[1], [*settings, f"numerics.devices={n}"]), f"{sys.argv[2]}/{n}")
    )
    for n in (1, 2)
)
for name in ("inertia_tensor", "angular_momentum", "kinetic_tensor", "virial_tensor"):
    difference = np.abs(two[name].values - one[name].values).max() / np.abs(one[name].values).max()
    assert difference <= 1e-13, (name, difference)
"""


@pytest.mark.full
def test_a_run_on_two_devices_is_that_on_one(tmp_path):
    scene = HERE.parents[1] / "sims" / "rotating_star.toml"
    environment = {**os.environ, "JAX_PLATFORMS": "cpu", "PYTHONPATH": str(HERE.parents[1]), **VIRTUAL}
    command = [sys.executable, "-c", RUNS, str(scene), str(tmp_path)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_more_devices_than_there_are_is_reported():
    count = jax.device_count() + 1
    with pytest.raises(SceneError, match=f"numerics.devices is {count}, but"), shared_out(count):
        pass
