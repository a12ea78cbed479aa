"""The plan to 1e9 particles: a model of time, memory and communication, from measured figures and stated hardware.

Printed by weak_scaling.py. What was measured is read from the tables in results/: the whole step, its memory, sorting.
"""

import math
import re
import textwrap

from fair_times import RESULTS, rows_of

from astroinertia.models.sph.evolution import STEPS_BETWEEN_SORTS
from astroinertia.sph.kernels import KERNELS

PARTICLES = 1_000_000_000
DEVICES = (1, 8, 64, 512, 4096)
# Hardware, a GPU of today's clusters. NVIDIA H200 data sheet (2024): memory; NVLink 900 GB/s, half of it each way,
# between the eight GPUs of a board. NVIDIA ConnectX-7 data sheet: NDR InfiniBand, 400 Gb/s to a GPU.
MEMORY = 141e9
INSIDE, BETWEEN = 450e9, 50e9  # bytes a second that a device receives
BOARD = 8
LATENCY = 10e-6  # s a message; assumed, on the slow side of what collective libraries are known for
FASTER = 100.0  # assumed: a GPU over the machine that was measured, since no GPU was
DENSITY_PASSES = 3  # a solve of the smoothing lengths from the last step's, with the loop's sums exchanged each time
HALO_VALUES = {"density": 5, "gradients": 8, "forces": 24}  # numbers of a halo particle that each pass reads again
LEAF, OPENING, ORDER = 32, 0.6, 4  # particles of a leaf of gravity, width over distance of nodes, order of expansions


TODAY = ["devices", "GB held", "computing (s)", "sorting, on every host (s)", "GB received", "adding up (s)",
         "efficiency"]  # fmt: skip
DOMAINS = ["devices", "particles each", "halo", "halo over own", "nodes of others", "GB held", "computing (s)",
           "MB received", "exchanging (ms)", "efficiency", f"if {FASTER:.0f} times as fast"]  # fmt: skip


def number(file: str, row: str, column: int) -> float:
    """A number in a kept table: of the first row that has this text, the column counted from 0."""
    line = next(line for line in (RESULTS / file).read_text().splitlines() if re.search(row, line))
    return float(line.strip("| ").split("|")[column])


def bandwidth(devices: int) -> float:
    """Bytes a second that a device receives from the others."""
    return INSIDE if devices <= BOARD else BETWEEN


def today(devices: int, rate: float, sorting: float, bytes_a_step: float, held: float) -> list[str]:
    """One row: every particle on every device, sums added up everywhere, sorting on the host of each."""
    computing = PARTICLES / devices / rate
    alone = PARTICLES / sorting / STEPS_BETWEEN_SORTS
    moved = 2.0 * (devices - 1) / devices * bytes_a_step * PARTICLES
    adding = moved / bandwidth(devices) + 2.0 * math.log2(devices) * LATENCY * (DENSITY_PASSES + 7)
    efficiency = (PARTICLES / rate + alone) / devices / (computing + alone + adding)
    return [
        f"{devices}", f"{PARTICLES * held / 1e9:.0f}", f"{computing:.3g}", f"{alone:.3g}", f"{moved / 1e9:.3g}",
        f"{adding:.3g}", f"{100 * efficiency:.3g} %",
    ]  # fmt: skip


def halo(particles: float, reach: float) -> float:
    """Particles within `reach` spacings outside of a cube of so many, its corners included."""
    return (particles ** (1 / 3) + 2.0 * reach) ** 3 - particles


def essential_nodes(particles: float, devices: int) -> float:
    """Nodes of other domains that a domain's gravity takes as wholes: along its faces, level by level, and far away.

    Faces: nodes of each width within width/OPENING of the faces, a fourth as many a level up. Far away: shells of width
    over distance OPENING, 4 pi / OPENING^3 of them for each factor e of distance.
    """
    faces = 6.0 * (particles / LEAF) ** (2 / 3) / OPENING / (1.0 - 0.25)
    return faces + 4.0 * math.pi / OPENING**3 * math.log(max(devices, 2)) / 3.0


def domains(devices: int, rate: float, sorting: float, held: float) -> list[str]:
    """One row: each device has the particles of a region, and what it needs of others."""
    particles = PARTICLES / devices
    kernel = KERNELS["wendland_c2"]
    near = halo(particles, kernel.support * kernel.eta) if devices > 1 else 0.0
    far = halo(particles, LEAF ** (1 / 3) / OPENING) if devices > 1 else 0.0
    nodes = essential_nodes(particles, devices) if devices > 1 else 0.0
    values = DENSITY_PASSES * HALO_VALUES["density"] + HALO_VALUES["gradients"] + HALO_VALUES["forces"]
    moments = math.comb(ORDER + 3, 3) + 5
    moved = 8.0 * (near * values + far * 4 + nodes * moments)
    messages = 26 * (DENSITY_PASSES + 3) + 2.0 * math.log2(devices) * 2 if devices > 1 else 0.0
    exchanging = moved / bandwidth(devices) + messages * LATENCY
    computing = particles / rate + particles / sorting / STEPS_BETWEEN_SORTS
    memory = (particles + max(near, far)) * held + nodes * moments * 8
    return [
        f"{devices}", f"{particles:.3g}", f"{near:.3g}", f"{near / particles:.2f}", f"{nodes:.3g}",
        f"{memory / 1e9:.3g}", f"{computing:.3g}", f"{moved / 1e6:.3g}", f"{1e3 * exchanging:.3g}",
        f"{100 * computing / (computing + exchanging):.3g} %",
        f"{100 * computing / (computing + FASTER * exchanging):.3g} %",
    ]  # fmt: skip


def plan(a_particle: dict[str, float], held: float) -> str:
    """The plan as text; a_particle: measured bytes that a device receives in each pass; held: bytes a particle."""
    rate = 1e6 * number("whole_step.md", r"1000000 \| whole step, mixed", 4)
    sorting = 1e6 * number("pair_throughput_xla.md", r"arrange", 3)
    lean = number("memory.md", r"1000000 \| mixed", 3)
    received = sum(size * (DENSITY_PASSES if name == "density" else 1) for name, size in a_particle.items())
    kernel, edge = KERNELS["wendland_c2"], LEAF ** (1 / 3) / OPENING
    crossing, moments = sorting * STEPS_BETWEEN_SORTS / rate, math.comb(ORDER + 3, 3) + 5
    all_here = [today(devices, rate, sorting, received, held) for devices in DEVICES]
    apart = [domains(devices, rate, sorting, held) for devices in DEVICES]
    enough = [row[0] for row in apart if float(row[5]) < MEMORY / 1e9]
    far, board = 4.0 * math.pi / OPENING**3, f"{INSIDE / 1e9:.0f} GB/s between the {BOARD} of a board"
    reach = kernel.support * kernel.eta
    parts = [
        f"# On paper: {PARTICLES:.0e} particles",
        f"Measured, and read from the tables beside: a whole step {rate / 1e6:.3g} million particles a second "
        "(numba_cpu, mixed precision, two cores, a million particles), sorting with lists of neighbours "
        f"{sorting / 1e6:.3g} million a second (xla, on the host, once in {STEPS_BETWEEN_SORTS} steps), {lean:.0f} "
        f"bytes a particle in a step (numba_cpu). From the table above, 8 devices: {held:.0f} bytes a particle held in "
        f"the xla engine's most expensive pass, and {received:.0f} bytes a particle received in a step, with "
        f"{DENSITY_PASSES} passes for the smoothing lengths. Stated: {MEMORY / 1e9:.0f} GB a device and {board} "
        f"(NVIDIA's data sheet of the H200), {BETWEEN / 1e9:.0f} GB/s between boards (ConnectX-7, 400 Gb/s). Assumed: "
        f"{1e6 * LATENCY:.0f} us a message. No GPU was measured: a device computes as fast as the two cores did, and "
        f"the last column of the second table asks what is left if it were {FASTER:.0f} times as fast.",
        "A message of n bytes takes alpha + n beta. An all-reduce by a ring gives every device 2 (P - 1)/P of the "
        "array, and takes 2 log2(P) alpha at least.",
        "## As it is: every particle on every device",
        rows_of(TODAY, all_here),
        f"What breaks first is memory: a device holds {MEMORY / held / 1e6:.0f} million particles at most, however "
        f"many devices there are. Next comes sorting, which every host does for all particles: beyond {crossing:.0f} "
        "devices it takes longer than the rest of a step. Then the sums, which do not shrink with their number.",
        "## With domains: each device the particles of a region",
        "A halo of w spacings has (n + 2 w)^3 - n^3 particles with n = (N/P)^(1/3), about 6 (N/P)^(2/3) w; "
        f"w = {reach:.2f} for the kernel (support times eta) and {edge:.2f} for gravity's near leaves of {LEAF}. Of "
        f"the rest of the body a device needs nodes: those along its faces, level by level, and {far:.0f} for each "
        f"factor e of distance beyond, {moments} numbers each at order {ORDER}. A step exchanges halos "
        f"{DENSITY_PASSES + 2} times and gravity's once, each with 26 neighbours, and two sums of a few numbers.",
        rows_of(DOMAINS, apart),
        f"Memory suffices from {enough[0] if enough else 'more'} of these devices on. Not in the model: that regions "
        "of a collapsing body differ in their work, and particles that change their device.",
        "What would have to be built: particles cut along a space-filling curve and moved when they leave, sorted and "
        "listed by each device for itself; the exchange of halos, and of its derivatives; trees of others as far as a "
        "device needs them; initial bodies placed by parts; segments and checkpoints written by every host. The ledger "
        "and the time step are sums and a smallest over particles already.",
    ]
    return "\n\n".join(part.rstrip() if part[0] in "|#" else textwrap.fill(part, 118) for part in parts) + "\n"
