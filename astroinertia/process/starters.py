"""The processes that a starter of MPI (mpirun, srun) has started, as its variables tell.

Tests: tests/unit/process/test_starters.py.
"""

import os

_SIZES = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE")  # what Open MPI, and MPICH and Slurm's PMI, tell the processes
_NUMBERS = ("OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK")


def started() -> int:
    """How many processes MPI has started, this one among them; 1 without it."""
    counts = [os.environ.get(name, "") for name in _SIZES]
    if "PMIX_RANK" in os.environ:
        counts.append(os.environ.get("SLURM_STEP_NUM_TASKS", ""))
    return max((int(count) for count in counts if count.isdecimal()), default=1)


def is_first() -> bool:
    """Whether this process is the first of them, or the only one."""
    return started() == 1 or all(os.environ.get(name, "0") == "0" for name in _NUMBERS)
