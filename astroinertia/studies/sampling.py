"""Sampling of a posterior with affine-invariant ensembles (emcee), and what says whether the samples can be believed.

Sources: Goodman & Weare 2010, CAMCoS 5, 65; Foreman-Mackey et al. 2013, PASP 125, 306 (emcee); Gelman et al. 2013,
Bayesian Data Analysis, sect. 11.4 (R-hat of split chains); Sokal 1996 (autocorrelation time).
"""

from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr

from astroinertia.errors import NumericalError, SceneError
from astroinertia.process.quantities import with_quantities

R_HAT_LIMIT = 1.01  # Vehtari et al. 2021, Bayesian Analysis 16, 667
QUANTILES = (0.05, 0.16, 0.5, 0.84, 0.95)
LEAST_AUTOCORRELATION_TIMES = 50  # draws of a chain over the time: below, emcee's estimate of it is not to be trusted


@with_quantities()
def sample(
    log_probability: Callable[[np.ndarray], np.ndarray],
    start: Callable[[np.random.Generator, int], np.ndarray],
    names: Sequence[str],
    draws: int = 2000,
    chains: int = 4,
    walkers: int = 32,
    seed: int = 0,
) -> xr.Dataset:
    """Return draws of a posterior: each name in (chain, walker, draw), with `log_probability` and the acceptance.

    log_probability: of positions (n, parameters), -inf where impossible, (n,). start: positions (walkers, parameters)
    from a generator and a number. A chain is an ensemble of its own; half as many draws again are thrown away first.
    SceneError without emcee, or for fewer walkers than twice the parameters; NumericalError for a start that is
    impossible. Whether the result is converged is in `diagnostics`; `interop.arviz.arviz_tree` has it as ArviZ does.
    """
    try:
        import emcee  # pyright: ignore[reportMissingImports]  an extra: only sampling needs it
    except ImportError:
        raise SceneError("sampling a posterior needs emcee: pip install 'astroinertia[inference]'") from None
    for name, count, least in (("draws", draws, 2), ("chains", chains, 1)):
        if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < least:
            raise SceneError(f"{name} must be a whole number, {least} at least, not {count!r:.60}")
    if walkers < 2 * len(names) or walkers % 2:
        raise SceneError(f"{len(names)} parameters need an even number of walkers, {2 * len(names)} at least")
    positions, densities, accepted = [], [], []
    for generator in np.random.default_rng(seed).spawn(chains):
        begin = np.asarray(start(generator, walkers), dtype=float)
        if not np.isfinite(np.broadcast_to(log_probability(begin), walkers)).all():
            raise NumericalError("the sampling begins where the posterior is zero")
        sampler = emcee.EnsembleSampler(
            walkers,
            len(names),
            log_probability,
            vectorize=True,
            # snooker and differential evolution keep curved and stretched posteriors moving (ter Braak & Vrugt 2008)
            moves=[(emcee.moves.StretchMove(), 0.4), (emcee.moves.DEMove(), 0.5), (emcee.moves.DESnookerMove(), 0.1)],
        )
        sampler.random_state = np.random.RandomState(int(generator.integers(2**31))).get_state()
        state = sampler.run_mcmc(begin, draws // 2)
        sampler.reset()
        sampler.run_mcmc(state, draws)
        positions.append(sampler.get_chain())
        densities.append(sampler.get_log_prob())
        accepted.append(sampler.acceptance_fraction)
    chain = np.moveaxis(np.stack(positions), 1, 2)
    dims = ("chain", "walker", "draw")
    return xr.Dataset(
        {name: (dims, chain[..., k]) for k, name in enumerate(names)}
        | {
            "log_probability": (dims, np.moveaxis(np.stack(densities), 1, 2)),
            "acceptance": (("chain", "walker"), np.stack(accepted)),
        },
        coords={"chain": np.arange(chains), "walker": np.arange(walkers), "draw": np.arange(draws)},
        attrs={"sampler": "emcee", "sampler_version": emcee.__version__, "seed": seed, "discarded_draws": draws // 2},
    )


@with_quantities()
def diagnostics(posterior: xr.Dataset, names: Sequence[str]) -> xr.Dataset:
    """Return, for each of `names`, autocorrelation time (draws), effective number of samples, R-hat and `converged`.

    R-hat compares the spread between halves of chains, each with all its walkers, to that within them: 1 when they
    agree. Converged: R-hat below 1.01 and chains of at least 50 autocorrelation times.
    """
    from emcee.autocorr import integrated_time  # pyright: ignore[reportMissingImports]

    draws = posterior.sizes["draw"]
    columns: dict[str, list[float]] = {"autocorrelation_time": [], "effective_samples": [], "r_hat": []}
    for name in names:
        values = posterior[name].transpose("chain", "walker", "draw").values
        times = [float(integrated_time(chain.T, has_walkers=True, quiet=True, tol=0)[0]) for chain in values]
        columns["autocorrelation_time"].append(max(times))
        columns["effective_samples"].append(values.size / max(times) if np.isfinite(max(times)) else 0.0)
        columns["r_hat"].append(r_hat(values))
    dataset = xr.Dataset({name: ("parameter", chain) for name, chain in columns.items()}, {"parameter": list(names)})
    long_enough = LEAST_AUTOCORRELATION_TIMES * dataset["autocorrelation_time"] <= draws
    dataset["converged"] = long_enough & (dataset["r_hat"] < R_HAT_LIMIT)
    return dataset


@with_quantities()
def r_hat(values: np.ndarray) -> float:
    """Return R-hat of values (chain, walker, draw): each chain in two halves, all walkers of a half together.

    >>> print(f"{r_hat(np.random.default_rng(1).normal(size=(4, 8, 500))):.2f}")  # chains that agree
    1.00
    """
    half = values.shape[2] // 2
    if half == 0:
        raise ValueError("R-hat compares halves of chains: it needs two draws at least")
    pieces = np.concatenate([values[:, :, :half], values[:, :, half : 2 * half]]).reshape(2 * len(values), -1)
    within = pieces.var(axis=1, ddof=1).mean()
    between = pieces.mean(axis=1).var(ddof=1)
    if within == 0.0:
        return 1.0 if between == 0.0 else np.inf
    count = pieces.shape[1]
    return float(np.sqrt((count - 1) / count + between / within))


@with_quantities()
def summary(posterior: xr.Dataset, names: Sequence[str]) -> xr.Dataset:
    """Return mean, standard deviation and the quantiles 0.05, 0.16, 0.5, 0.84, 0.95 of each of `names`.

    NumericalError for samples that have not converged: the sentence says which, and by how much.
    """
    if absent := [name for name in names if name not in posterior]:
        raise SceneError(f"there is no '{absent[0]}' among the samples; there is {', '.join(map(str, posterior))}")
    checks = diagnostics(posterior, names)
    bad = checks["parameter"].values[~checks["converged"].values]
    if len(bad):
        raise NumericalError(
            f"the samples have not converged: {', '.join(bad)} (autocorrelation time up to "
            f"{float(checks['autocorrelation_time'].max()):.0f} of {posterior.sizes['draw']} draws, "
            f"R-hat up to {float(checks['r_hat'].max()):.3f}); draw more"
        )
    stacked = posterior[list(names)].to_array("parameter")
    over = ("chain", "walker", "draw")
    return checks.assign(
        mean=stacked.mean(over), standard_deviation=stacked.std(over), quantiles=stacked.quantile(QUANTILES, over)
    )
