"""Pair sums the plain way: every pair of particles in one array, a reference apart from the engines."""

from types import SimpleNamespace

import numpy as np

from astroinertia.engines.terms import argument_names, arguments
from astroinertia.sph.kernels import KERNELS


def _arguments(function, scalars, fields):
    """What a pair function asks for by name: pair scalars (N, N), or a field's values at i (rows) or j (columns)."""
    values = {}
    for name in argument_names(function):
        if name in scalars:
            values[name] = scalars[name]()
        elif name.endswith("_i"):
            values[name] = fields[name[:-2]][:, None] + 0 * fields["mass"][None, :]
        else:
            values[name] = fields[name[:-2]][None, :] + 0 * fields["mass"][:, None]
    return arguments(function, values)


def pair_sums(terms, fields, kernel, all_pairs=False, virial=False, scale=False):
    """{effect: {output: array}} of pair terms, as an engine gives it; with `scale`, also the sums of |m_j q|.

    fields as for an engine, in any floating type (np.longdouble for a reference beyond float64).
    """
    kernel = KERNELS[kernel]
    mass, h = fields["mass"], fields["smoothing_length"]
    separation = fields["position"][:, None, :] - fields["position"][None, :, :]
    r = np.sqrt((separation**2).sum(axis=-1))
    direction = separation / np.where(r > 0, r, 1)[:, :, None]
    h_i, h_j = h[:, None] + 0 * r, h[None, :] + 0 * r
    reach = np.ones(r.shape, bool) if all_pairs else r < kernel.support * np.maximum(h_i, h_j)
    scalars = {"r": lambda: r, "h_i": lambda: h_i, "h_j": lambda: h_j}
    scalars["v_r"] = lambda: ((fields["velocity"][:, None] - fields["velocity"][None]) * direction).sum(axis=-1)
    scalars |= {f"{axis}_ij": lambda k=k: separation[:, :, k] for k, axis in enumerate("xyz")}
    for side, length in (("i", h_i), ("j", h_j)):
        q = r / length
        scalars |= {
            f"W_{side}": lambda q=q, length=length: kernel.w(np, q) / length**3,
            f"dW_{side}": lambda q=q, length=length: kernel.dw(np, q) / length**4,
            f"d2W_{side}": lambda q=q, length=length: kernel.d2w(np, q) / length**5,
            f"phi_{side}": lambda q=q, length=length: kernel.phi(np, q) / length,
            f"dphi_{side}": lambda q=q, length=length: kernel.dphi(np, q) / length**2,
        }
    results = {}
    for term in terms:
        mine = results.setdefault(term.effect, {})
        for output, value in zip(term.outputs, term.pair(np, *_arguments(term.pair, scalars, fields)), strict=True):
            value = np.where(reach, value, 0)
            weighted = value * mass[None, :]
            if output.how == "central":
                result = -(weighted[:, :, None] * direction).sum(axis=1)
                if virial:
                    terms_of_it = (0.5 * mass[:, None] * weighted * r)[:, :, None, None]
                    tensor = -(terms_of_it * direction[..., :, None] * direction[..., None, :]).sum(axis=(0, 1))
                    mine["virial"] = mine.get("virial", 0) + tensor
            elif output.how == "sum":
                result = weighted.sum(axis=1)
            elif output.how == "max":
                result = np.where(np.eye(len(mass), dtype=bool), 0, value).max(axis=1)
            else:
                change = fields[output.of][:, None, :] - fields[output.of][None, :, :]
                result = np.einsum("ij,ija,ijb->iab", weighted, change, direction)
            mine[output.name] = mine[output.name] + result if output.name in mine else result
            if scale:
                mine[output.name + " scale"] = np.abs(weighted).sum(axis=1)
    return results


def density(kernel, position, mass, eta, softening=True):
    """Smoothing lengths with h = eta (m/rho)^(1/3) by bisection to the last bit, and what follows from them."""
    kernel = KERNELS[kernel]
    r = np.sqrt(((position[:, None, :] - position[None, :, :]) ** 2).sum(axis=-1))

    def sums(h):
        return (mass * kernel.w(np, r / h[:, None])).sum(axis=1) / h**3

    low = np.full(len(mass), 1e-5 * r.max())
    high = np.full(len(mass), 1e2 * r.max())
    for _ in range(60):
        middle = np.sqrt(low * high)
        too_small = sums(middle) * middle**3 < mass * eta**3
        low, high = np.where(too_small, middle, low), np.where(too_small, high, middle)
    h = np.sqrt(low * high)
    q = r / h[:, None]
    rho = sums(h)
    slope = -(mass * (3 * kernel.w(np, q) + q * kernel.dw(np, q))).sum(axis=1) / h**4
    potential_slope = -(mass * (kernel.phi(np, q) + q * kernel.dphi(np, q))).sum(axis=1) / h**2
    zeta = -h / (3 * rho) * potential_slope if softening else None
    return SimpleNamespace(smoothing_length=h, density=rho, grad_h=1 + h / (3 * rho) * slope, zeta=zeta)


class BruteEngine:
    """An engine made of the sums above, for a few hundred particles."""

    name, xp, precision, bounded = "brute", np, "float64", True

    def arrange(self, position, smoothing_length):
        return np.arange(len(position)), None

    def stale(self, arrangement, position, smoothing_length):
        return False

    def density(self, arrangement, kernel, position, mass, guess, eta, tolerance, softening):
        return density(kernel, position, mass, eta, softening)

    def neighbour_sums(self, arrangement, kernel, terms, fields, virial=False):
        return pair_sums(terms, fields, kernel, virial=virial)

    def all_pair_sums(self, arrangement, kernel, terms, fields, virial=False):
        return pair_sums(terms, fields, kernel, all_pairs=True, virial=virial)
