"""Densities that are sums of standard volumes, which stay sharp where materials meet.

A sum of masses smooths the jump of the density from one material to another, and so the pressures on both sides are
wrong. The volumes m/s, with s the density that a particle's material has at one pressure (that of all boundaries,
about), have a sum that does not jump: how much matter is compressed is nearly the same on both sides. So

    rho_i = s_i sum_j (m_j/s_j) W(r_ij, h_i),   rho_i h_i^3 = m_i eta^3,

which is the sum of masses where all particles are of one material. (Ott & Schnetter 2003, arXiv:physics/0303112, and
Solenthaler & Pajarola 2008, Proc. Symp. Computer Animation, 211, have the number of particles for the volume, of one
size; the masses here are equal and the volumes are not.) From the internal energy sum_i m_i u(rho_i) follows

    a_i = -sum_j m_j [s_i P_i/(Omega_i rho_i^2) dW_i/s_j + s_j P_j/(Omega_j rho_j^2) dW_j/s_i] rhat,

symmetric in i and j: momentum and angular momentum are exact, and work is what internal energy loses. Every other force
that follows from how the density changes has the same factors: the weight of a particle's own side is multiplied by its
s, and by the partner's volume per mass 1/s.

A particle may have a factor c of its own, that stays with it: rho_i = c_i s_i sum_j (m_j/s_j) W and rho_i h_i^3 =
c_i m_i eta^3, and c_i s_i stands for its own s_i in forces. With it sums at a free surface, where neighbours are
missing, are as large as the density there (build.surfaces).
"""

from typing import Any

Array = Any
DENSITY_FACTOR = "density_factor"
"""The c of particles among what effects keep of them, (N,)."""


def own_density(fluid: Any) -> Array:
    """c s, (N,)."""
    factor = fluid.memory.get(DENSITY_FACTOR)
    return fluid.standard_density if factor is None else factor * fluid.standard_density


def weighed(fields: dict[str, Array], fluid: Any, *weights: str) -> dict[str, Array]:
    """The fields of a pair term of volumes: those weights times c s, the others, and the volume per mass, all (N,)."""
    own = own_density(fluid)
    return {name: own * array if name in weights else array for name, array in fields.items()} | {
        "volume": 1.0 / fluid.standard_density
    }
