"""Posterior samples in the layout that ArviZ reads: a DataTree with the groups of its InferenceData schema.

Source: the InferenceData schema specification (python.arviz.org, "InferenceData schema specification"). ArviZ itself is
not needed for it: a DataTree is xarray's.
"""

from datetime import UTC, datetime
from importlib.metadata import version

import numpy as np
import xarray as xr

from astroinertia.errors import SceneError

_ORDER = ("chain", "draw")


def arviz_tree(posterior: xr.Dataset) -> xr.DataTree:
    """The draws of `studies.sampling.sample` or `studies.interior_inference` as ArviZ has them.

    posterior: each parameter in (chain, walker, draw), with `log_probability` and `acceptance`. Groups: `posterior`,
    all parameters in (chain, draw); `sample_stats`, with the log density `lp` and each chain's `acceptance_rate`; where
    interiors were inferred, `observed_data`, the means of what was observed, and `constant_data`, its deviations, the
    priors and `small_m`. Each walker is a chain, as in ArviZ's own reader of emcee, and the coordinates `ensemble` and
    `walker` say which: walkers of one ensemble help each other on, and R-hat between them is no test of convergence
    (`studies.sampling.r_hat` compares ensembles).

    ArviZ 1 takes the tree as it is; before, `arviz.InferenceData.from_datatree(tree)` does.

    >>> dims = ("chain", "walker", "draw")
    >>> draws = xr.Dataset({"ratio": (dims, np.ones((2, 8, 50))), "log_probability": (dims, np.zeros((2, 8, 50)))})
    >>> draws["acceptance"] = ("chain", "walker"), np.full((2, 8), 0.4)
    >>> tree = arviz_tree(draws)
    >>> print(list(tree), dict(tree["posterior"].sizes))
    ['posterior', 'sample_stats'] {'chain': 16, 'draw': 50}
    """
    for dim in ("chain", "walker", "draw"):
        if dim not in posterior.dims:
            raise SceneError(f"the draws are not along '{dim}'; one of them is kept by a list, as in isel({dim}=[0])")
    chains, walkers = posterior.sizes["chain"], posterior.sizes["walker"]
    coordinates = {
        "chain": np.arange(chains * walkers),
        "draw": np.arange(posterior.sizes["draw"]),
        "ensemble": ("chain", np.repeat(np.arange(chains), walkers)),
        "walker": ("chain", np.tile(np.arange(walkers), chains)),
    }
    variables = {name: _by_walker(values) for name, values in posterior.data_vars.items()}
    if lacking := [name for name in ("log_probability", "acceptance") if name not in variables]:
        raise SceneError(f"the draws have no '{lacking[0]}', which those of studies.sampling.sample have")
    stats = {"lp": variables.pop("log_probability"), "acceptance_rate": variables.pop("acceptance")}
    stats["lp"].attrs["long_name"] = "logarithm of the posterior density, but for a constant"
    stats["acceptance_rate"].attrs["long_name"] = "share of proposals that were accepted"
    groups = {
        "posterior": xr.Dataset(variables, coordinates, posterior.attrs),
        "sample_stats": xr.Dataset(stats, coordinates),
        "observed_data": xr.Dataset(_observed(posterior)),
        "constant_data": xr.Dataset(_constants(posterior)),
    }
    groups = {name: group for name, group in groups.items() if group.data_vars}
    for group in groups.values():
        group.attrs |= _origin(posterior)
    return xr.DataTree.from_dict(groups)


def _by_walker(values: xr.DataArray) -> xr.Variable:
    """The same numbers with each walker of each chain as a chain."""
    ordered = values.transpose("chain", "walker", ...)
    dims = _ORDER[: ordered.ndim - 1]
    return xr.Variable(dims, ordered.values.reshape(-1, *ordered.shape[2:]), dict(values.attrs))


def _observed(posterior: xr.Dataset) -> dict[str, xr.Variable]:
    return {
        str(name): xr.Variable((), values.attrs["observed_mean"], _description(values))
        for name, values in posterior.data_vars.items()
        if "observed_mean" in values.attrs
    }


def _constants(posterior: xr.Dataset) -> dict[str, xr.Variable]:
    """What is given beside the means: each number of a distribution by the name of its attribute."""
    found = {
        f"{name}_{attribute}": xr.Variable((), value, _description(values))
        for name, values in posterior.data_vars.items()
        for attribute, value in values.attrs.items()
        if attribute == "observed_deviation" or attribute.startswith("prior_")
    }
    if "small_m" in posterior.attrs:
        found["small_m"] = xr.Variable((), posterior.attrs["small_m"], {"units": "1", "long_name": "Omega^2 R^3/(GM)"})
    return found


def _description(values: xr.DataArray) -> dict[str, str]:
    return {key: values.attrs[key] for key in ("units", "long_name") if key in values.attrs}


def _origin(posterior: xr.Dataset) -> dict[str, str]:
    """The attributes that the schema asks of every group."""
    attributes = {
        "created_at": datetime.now(UTC).isoformat(),
        "creation_library": "astroinertia",
        "creation_library_version": version("astroinertia"),
        "creation_library_language": "Python",
    }
    if "sampler" in posterior.attrs:
        attributes["inference_library"] = posterior.attrs["sampler"]
        attributes["inference_library_version"] = posterior.attrs["sampler_version"]
    return attributes
