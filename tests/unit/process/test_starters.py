"""Which of the processes that MPI has started this one is, as starters tell."""

import pytest

from astroinertia.process.starters import is_first, started


@pytest.mark.parametrize(
    ("stated", "count", "first"),
    [
        ({}, 1, True),
        ({"PMI_SIZE": "3", "PMI_RANK": "0"}, 3, True),
        ({"PMI_SIZE": "3", "PMI_RANK": "2"}, 3, False),
        ({"OMPI_COMM_WORLD_SIZE": "2", "OMPI_COMM_WORLD_RANK": "1", "PMIX_RANK": "1"}, 2, False),
        ({"SLURM_STEP_NUM_TASKS": "4", "PMIX_RANK": "1"}, 4, False),
        ({"SLURM_STEP_NUM_TASKS": "4"}, 1, True),  # without MPI
        ({"PMI_RANK": "1"}, 1, True),
    ],
)
def test_processes_are_counted_as_their_starter_tells(stated, count, first, monkeypatch) -> None:
    for name in ("PMI_SIZE", "PMI_RANK", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK", "PMIX_RANK",
                 "SLURM_STEP_NUM_TASKS"):  # fmt: skip
        monkeypatch.delenv(name, raising=False)
    for name, value in stated.items():
        monkeypatch.setenv(name, value)
    assert (started(), is_first()) == (count, first)
