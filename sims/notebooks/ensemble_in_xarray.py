# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # An ensemble in xarray: which stellar cores leave a pulsar, and which a bar?
#
# One run answers one question. Many runs show what decides the outcome. Here a dozen iron cores shrink to neutron
# stars. They differ in how fast they turn before, in how centrally condensed they are, and in how large they are. All
# are answered by the model `scaling`, conservation laws in closed form, which takes a fraction of a second each; the
# same lines of analysis work on a sweep of particle runs.
#
# 1. A sweep, and what comes out of it: one dataset with a dimension for each parameter.
# 2. Selecting, interpolating and grouping by xarray; tables by pandas.
# 3. Which parameter matters: shares of the variance, in one line.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

import astroinertia
from astroinertia.bodies import ellipsoid_stability, maclaurin
from astroinertia.bodies.polytrope import Polytrope
from astroinertia.units import GRAVITATIONAL_CONSTANT

# %matplotlib inline

# %% [markdown]
# ## 1. The sweep
#
# Keys in `[sweep]` are those of the scene, and a grid takes every combination of their values. All cores fall to 1/3891
# of their moment of inertia: this takes a polytrope of 1.4 solar masses, 1500 km and $n = 3$ to that of a neutron star
# with the equation of state SLy (`studies.spinup.core_to_neutron_star` derives it, and six other ways to know it).

# %%
scene = """
name = "core_ensemble"
model = "scaling"

[sweep]
"body.index" = [1.5, 3.0]
"body.rotation.period" = { start = "3 s", stop = "300 s", number = 3, scale = "log" }
"body.radius" = ["1000 km", "2000 km"]

[body]
kind = "polytrope"
mass = "1.4 Msun"

[body.rotation]
law = "rigid"

[body.change]
times = ["0.25 s"]
factors = [2.57e-4]

[effects.gravity]
[effects.pressure]

[time]
end = "0.3 s"

[output]
series_every = "0.15 s"
"""

with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "scene.toml"
    path.write_text(scene)
    astroinertia.run_scene(path, Path(folder) / "run", progress=False)
    with astroinertia.open(Path(folder) / "run") as opened:
        cores = opened.load()

cores[["inertia_tensor", "rotational_to_gravitational"]].drop_attrs().drop_vars("failure")

# %% [markdown]
# The swept parameters are dimensions, in SI units, in front of those of every run. (`astroinertia.open_sweep` has the
# members one by one instead, each with its snapshots.) What ended where is a selection. All of them together:

# %%
ratio = cores.rotational_to_gravitational.isel(time=-1)
spin, moment = cores.angular_velocity.sel(i="z"), cores.inertia_tensor.sel(i="z", j="z")
spin_up = spin.isel(time=-1) / spin.isel(time=0)
shrinking = moment.isel(time=-1) / moment.isel(time=0)
print(f"the moment falls {float(1 / shrinking.mean()):.0f}-fold")
print(f"the spin rises {float(spin_up.min()):.0f} to {float(spin_up.max()):.0f}-fold")

# %% [markdown]
# How fast the pulsar turns depends on nothing but how fast its core did: $\omega\propto1/I$ whatever the body is.
# Whether it stays round is another matter. A rigidly turning polytrope has $T = \frac12 kMR^2\omega^2$ with its moment
# ratio $k$, and $|W| = \frac{3}{5-n}GM^2/R$ (Chandrasekhar 1939, *An Introduction to the Study of Stellar Structure*,
# chapter 4). If its moment shrinks by a factor $f$, $T$ grows as $1/f$ and $|W|$ as $f^{-1/2}$. So we expect
#
# $$\frac{T}{|W|} = \frac{(5-n)\,k(n)}{6}\,\frac{\omega_0^2R_0^3}{GM}\,f^{-1/2}.$$
#
# xarray lines up the dimensions by their names, so that this formula is the one below, for all members at once.

# %%
mass = cores.mass.isel(time=0)
k = xr.DataArray([Polytrope(float(n)).solution.moment_ratio for n in cores.body_index], dims="body_index")
rate = 2 * np.pi / cores.body_rotation_period
expected = (5 - cores.body_index) * k / 6 * rate**2 * cores.body_radius**3 / (GRAVITATIONAL_CONSTANT * mass)
expected = expected / np.sqrt(shrinking)
largest_error = float(abs(ratio / expected - 1).max())
print(f"largest difference from the formula: {largest_error:.0e}")

# %% [markdown]
# ## 2. Selecting, interpolating, grouping
#
# Homogeneous bodies become unstable to a bar, with friction where the Jacobi ellipsoids branch off, and by themselves
# beyond $e = 0.953$ (Chandrasekhar 1969, *Ellipsoidal Figures of Equilibrium*, chapter 5); centrally condensed bodies
# do so near the same $T/|W|$ (Tassoul 1978, *Theory of Rotating Stars*, chapter 10). The package computes both limits.

# %%
secular = maclaurin.bifurcation().rotational_to_gravitational
eccentricity = ellipsoid_stability.onset(maclaurin.from_eccentricity, 0.9, 0.99)
dynamical = maclaurin.from_eccentricity(eccentricity).rotational_to_gravitational
print(f"T/|W| = {secular:.4f} with friction, {dynamical:.4f} without")

grid = ratio.plot.line(
    "o-", x="body_rotation_period", hue="body_index", col="body_radius", xscale="log", yscale="log", figsize=(10, 4)
)
for axes, radius in zip(grid.axs.flat, cores.body_radius.values, strict=True):
    axes.axhspan(secular, dynamical, color="C1", alpha=0.25, lw=0)
    axes.axhspan(dynamical, float(ratio.max()) * 2, color="C3", alpha=0.2, lw=0)
    axes.set(xlabel="period before (s)", title=f"core of {radius / 1e3:.0f} km")
grid.axs.flat[0].set_ylabel("$T/|W|$ of the neutron star")
grid.figlegend.set_title("index n")
plt.show()

# %% [markdown]
# Orange: a bar by friction; red: a bar by itself. (The largest values are beyond what any bound body has, 0.5. The
# model only says what conservation of $L$ would ask for: rotation stops such a core before it is that small.)
#
# `interp` tells what lies between the members. $T/|W|$ is a power of the period, so we take it between logarithms,
# where a straight line is exact, and find the slowest core that still makes a bar. Nothing more is needed than to swap
# what is the coordinate and what is the value.

# %%
logarithms = np.log(ratio).assign_coords(body_rotation_period=np.log(ratio.body_rotation_period))
slope = logarithms.polyfit("body_rotation_period", 1).polyfit_coefficients.sel(degree=1)
between = float(np.exp(logarithms.interp(body_rotation_period=np.log(10.0)).sel(body_index=3.0, body_radius=1e6)))
critical = np.exp(
    logarithms.body_rotation_period.isel(body_rotation_period=0, drop=True)
    + (np.log(secular) - logarithms.isel(body_rotation_period=0, drop=True)) / slope
)
print(f"slope {float(slope.min()):.3f} to {float(slope.max()):.3f}; T/|W| = {between:.4f} for a period of 10 s")
critical.rename("longest period that makes a bar (s)").to_series().unstack().round(2)

# %% [markdown]
# And `groupby` sorts the members by what becomes of them: how many there are, and how their cores turned.

# %%
fates = np.array(["stays round", "bar by friction", "bar by itself"])
fate = xr.DataArray(fates[(ratio > secular).astype(int) + (ratio > dynamical)], ratio.coords, ratio.dims)
table = ratio.rename("ratio").to_dataframe().reset_index().assign(fate=fate.to_series().values)
summary = table.groupby("fate").agg(
    cores=("ratio", "count"),
    least_ratio=("ratio", "min"),
    largest_ratio=("ratio", "max"),
    shortest_period=("body_rotation_period", "min"),
    longest_period=("body_rotation_period", "max"),
)
summary.round(6)

# %% [markdown]
# `to_dataframe` has made a table with a line for each member, for whatever speaks pandas. The ranks of a dozen members
# already order the parameters (Spearman's coefficient, which asks only whether one rises with the other):

# %%
ranks = (
    table[["body_index", "body_rotation_period", "body_radius", "ratio"]].corr(method="spearman")["ratio"].drop("ratio")
)
ranks.round(2)

# %% [markdown]
# ## 3. Which parameter matters?
#
# The share of the variance that is a parameter's own, the *first-order index* of Sobol (2001, Mathematics and Computers
# in Simulation 55, 271), is the variance of the mean over all others, $S_p =
# \mathrm{Var}\,[\mathrm{E}(y\,|\,p)]/\mathrm{Var}\,y$. On a grid this is a line of xarray. What the shares leave of 1
# is due to parameters that act together.


# %%
def shares(y):
    """First-order shares of the variance of a DataArray over a grid, by dimension."""
    return {name: float(y.mean([other for other in y.dims if other != name]).var() / y.var()) for name in y.dims}


first_order, first_order_log = shares(ratio), shares(np.log(ratio))
for name in ratio.dims:
    print(f"{name:22s} {first_order[name]:6.1%} of T/|W|, {first_order_log[name]:6.1%} of its logarithm")
print(
    f"{'together':22s} {1 - sum(first_order.values()):6.1%}             {abs(1 - sum(first_order_log.values())):6.1%}"
)

# %%
figure, axes = plt.subplots(figsize=(7.5, 2.8), layout="constrained")
for row, found in (("$T/|W|$", first_order), (r"$\log\,T/|W|$", first_order_log)):
    left = 0.0
    parts = {**found, "together": max(0.0, 1 - sum(found.values()))}
    for colour, (name, share) in enumerate(parts.items()):
        axes.barh(row, share, left=left, color=f"C{colour}", label=name.replace("_", " ") if row == "$T/|W|$" else None)
        left += share
axes.set(xlabel="share of the variance", xlim=(0, 1), title="What decides whether a core makes a bar?")
axes.legend(ncols=4, loc="upper center", bbox_to_anchor=(0.5, -0.3), frameon=False)
plt.show()

# %% [markdown]
# $T/|W|$ is a *product* of powers, so its logarithm is a sum of terms of one parameter each: nothing is left over
# there, and this also checks the arithmetic. Of $T/|W|$ itself a good part is nobody's alone: how condensed a core is
# matters only if it turns fast. With particles the shares are not so tidy, and then they are the answer to "what must I
# know better?"
#
# Things to try: `samples = 64` with `{ log_uniform = [...] }` in place of lists is a Latin hypercube; `workers=4` in
# `run_scene` from a script (or `astroinertia run --workers 4`) shares the members out; `model = "ellipsoid"` lets each
# core find its own size.
