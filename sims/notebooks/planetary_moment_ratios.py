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
# # Planetary moment ratios: what does C/(M R²) tell of the inside of a planet?
#
# Nobody has seen the core of a planet. But how a planet precesses, how it is flattened and how its moons and probes
# move give one number about its inside: its moment of inertia over $MR^2$. It is 0.4 for a uniform ball, and smaller
# the more mass is near the centre. This study asks
#
# 1. what the ratios of Earth and Mars are, and which is larger;
# 2. which interiors have the ratio of Mars, and what follows for its core;
# 3. what the Love number and $J_2$ add to that, and when they may stand in for the ratio.
#
# All measured numbers come from the package's table `data/planets.csv`, each with its uncertainty and source.

# %%
import re

import matplotlib.pyplot as plt
import numpy as np

from astroinertia.bodies import apsidal, clairaut
from astroinertia.bodies.earth import prem
from astroinertia.bodies.planets import body
from astroinertia.plots.moment_ratios import moment_ratio_figure
from astroinertia.studies import moment_ratio as study

# %matplotlib inline

# %% [markdown]
# ## 1. Published ratios, made comparable
#
# A ratio is of the polar moment $C$ or of the mean moment $I = (A+B+C)/3$, and for the equatorial or the mean radius.
# Between these the difference is as large as the measurement's error or larger, so each number carries its convention,
# and the study turns all of them into the mean moment over the mean radius. With $J_2 = (C-A)/(Ma^2)$ that is $I/(Ma^2)
# = C/(Ma^2) - \tfrac23 J_2$.

# %%
planets = study.moment_ratio(["Mercury", "Earth", "Moon", "Mars", "Jupiter", "Saturn"])
columns = ["published_moment_ratio", "moment_ratio", "moment_ratio_uncertainty", "polytropic_index", "source"]
planets[columns].to_dataframe().round(5)

# %%
ratio = planets.moment_ratio.to_series()
by_hand = {}
for name in ("Earth", "Mars"):
    one, row = body(name), body(name).adopted("polar_moment_ratio")
    by_hand[name] = (row.value - 2 / 3 * one.zonal_harmonic(row.radius)) * (row.radius / one.mean_radius) ** 2
    print(f"{name}: {by_hand[name]:.5f} by hand, {ratio[name]:.5f} in the table")

# %% [markdown]
# The ratio of Mars is the *larger* one, although some texts have it the other way round. Mars is less centrally
# condensed: it is smaller, so its rock is squeezed less, and its core is light and holds less of the mass. In the
# picture, ratios stand over the central density divided by the mean density. The line is that of polytropes,
# $P\propto\rho^{1+1/n}$ (Chandrasekhar 1939, *An Introduction to the Study of Stellar Structure*, chapter 4).

# %%
moment_ratio_figure(planets, study.polytropes())

# %% [markdown]
# For the Earth seismology knows the density at every depth. The moment of inertia of the model PREM (Dziewonski &
# Anderson 1981, Physics of the Earth and Planetary Interiors 25, 297) is therefore a check: $I =
# \tfrac{8\pi}{3}\int\rho r^4\,dr$ over $MR^2$.

# %%
prem_ratio = float(prem().moment_ratio)
print(f"PREM: {prem_ratio:.5f}, from gravity and precession: {ratio['Earth']:.5f}")

# %% [markdown]
# ## 2. Which interiors have the ratio of Mars?
#
# Two layers of uniform density have three unknowns (both densities and the core's radius), mass and moment are two
# equations: a family is left. With $x = r_c/R$ and mean density $\bar\rho$,
#
# $$\bar\rho = \rho_m + (\rho_c-\rho_m)x^3,\qquad \frac{I}{MR^2}\,\bar\rho = \tfrac25[\rho_m + (\rho_c-\rho_m)x^5].$$
#
# One call solves these for every density of the core. Its dimension is the parameter that we sweep over.

# %%
mars = body("Mars")
family = study.two_layer_sweep("Mars", {"core_density": np.linspace(5200.0, 8000.0, 57)})
x = family.core_radius / mars.mean_radius
left = family.mantle_density * (1 - x**5) + family.core_density * x**5
identity = float(abs(0.4 * left / mars.mean_density / ratio["Mars"] - 1).max())
print(f"the second equation holds to {identity:.0e}")

# %%
published = [row for row in mars.published["core_radius"] if np.isfinite(row.uncertainty)]
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
left.plot(family.core_density, family.core_radius / 1e3, lw=2, color="k", label="same mass and moment as Mars")
for colour, row in zip(("C0", "C1", "C2", "C3"), published, strict=False):
    low, high = ((row.value + sign * row.uncertainty) / 1e3 for sign in (-1, 1))
    left.axhspan(low, high, alpha=0.25, color=colour, lw=0, label=re.split(r"(?<=\d{4}) ", row.source)[0])
left.set(
    xlabel=r"density of the core (kg m$^{-3}$)", ylabel="radius of the core (km)", title="Cores that Mars may have"
)
left.legend(fontsize=8)
right.plot(family.core_density, family.mantle_density, lw=2, color="C3")
right.set(
    xlabel=r"density of the core (kg m$^{-3}$)",
    ylabel=r"density of the mantle (kg m$^{-3}$)",
    title="... and the mantle around it",
)
plt.show()

# %% [markdown]
# The moment alone allows cores from 1.6 to 2.4 thousand km. Seismology of the probe InSight picks one, and the family
# then says how dense that core is: read backwards, `interp` along the radius.

# %%
by_radius = family.swap_dims(core_density="core_radius").sortby("core_radius")
core_density = {row.source: float(by_radius.core_density.interp(core_radius=row.value)) for row in published}
for row in published:
    print(
        f"{row.value / 1e3:.0f} +- {row.uncertainty / 1e3:.0f} km ({row.source}): {core_density[row.source]:.0f} kg/m3"
    )

# %% [markdown]
# Two uniform layers are a caricature, so that these densities are too high: they also stand for what the weight above
# squeezes together, and for the light crust, both of which a real Mars has. The authors themselves give 5700 to 6300 kg
# m$^{-3}$ for the larger core and 6500 to 6650 beneath a molten layer. The order is right, and so is the moral: all of
# them are less dense than iron without any weight on it (7870 kg m$^{-3}$), so the core holds much of something light.
#
# ## 3. What do the Love number and $J_2$ add?
#
# A fluid planet answers to its own spin with $J_2 = k_2 m/3$ and the flattening $f = m(1+k_2)/2$, to first order in $m
# = \Omega^2R^3/(GM)$. The *fluid Love number* $k_2$ follows from the density by Clairaut's equation. Radau and Darwin
# found that it depends almost only on the moment ratio (Murray & Dermott 1999, *Solar System Dynamics*, eq. 4.112):
#
# $$\frac{I}{MR^2} \simeq \frac23\left[1-\frac25\sqrt{\frac{4-k_2}{1+k_2}}\right].$$
#
# Is that so? The family of part 2 has one ratio and quite different cores.

# %%
spread = float(family.love_number.max() / family.love_number.min() - 1)
radau = float(clairaut.radau_darwin_love_number(ratio["Mars"]))
print(f"k2 of the family: {float(family.love_number.mean()):.4f}, all within {spread:.1e}")
print(f"by Radau and Darwin: {radau:.4f}")

# %% [markdown]
# So it is: over the whole family $k_2$ differs by parts in ten thousand. **To know $k_2$ of a fluid planet is to know
# its moment ratio, and no more**: it cannot tell one core of the family from another. (The Love numbers that are
# measured, 0.169(6) for Mars (Konopliv et al. 2016, Icarus 274, 253), are of its *elastic* answer to the Sun's tide.
# Those do know whether the core is molten.)
#
# The other way round, $J_2$ and the spin give $k_2 = 3J_2/m$ and so the ratio of any planet that is fluid, without
# precession. How well that goes shows how fluid a planet is.

# %%
hydrostatic = planets.hydrostatic_moment_ratio.to_series()
off = (hydrostatic / ratio - 1).rename("hydrostatic over true ratio, less one")
off.drop(["Mercury", "Moon"]).round(4)

# %%
curve = np.linspace(0.22, 0.4, 100)
figure, axes = plt.subplots(figsize=(7.5, 4.8), layout="constrained")
axes.plot(curve, clairaut.radau_darwin_love_number(curve), "k", label="Radau and Darwin")
sequence = study.polytropes(np.linspace(0.0, 1.5, 7))
axes.plot(
    sequence.moment_ratio, [apsidal.love_number(float(n)) for n in sequence.index], "C2--", label="polytropes, exact"
)
for name, colour in (("Earth", "C0"), ("Mars", "C3"), ("Jupiter", "C1"), ("Saturn", "C4")):
    one = planets.sel(body=name)
    axes.plot(one.moment_ratio, one.fluid_love_number, "o", color=colour)
    axes.annotate(
        name, (one.moment_ratio, one.fluid_love_number), (-8, 5), textcoords="offset points", color=colour, ha="right"
    )
axes.set(xlabel="$I/(MR^2)$", ylabel="$k_2 = 3J_2/m$", title="What the figure says, and what the moment is")
axes.legend()
plt.show()

# %% [markdown]
# Earth lies on the curve to half a per cent: its mantle creeps. Mars lies above it. The volcanoes of Tharsis, held up
# by a stiff crust, make $J_2$ larger than the spin would, and whoever took Mars for a fluid would get a ratio 3 % too
# large, and a core far too small. (Saturn's 2 % are of another kind: it turns so fast, $m = 0.14$, that first order
# does not do.) Flattening alone gives the moment only in hydrostatic equilibrium.
#
# What always works is precession. It measures the dynamical ellipticity $H = (C-A)/C$, and $J_2 = (C-A)/(Ma^2)$, so
# that $C/(Ma^2) = J_2/H$ without any assumption. For the Earth:

# %%
earth = body("Earth")
ellipticity, published_ratio = earth.adopted("dynamical_ellipticity").value, earth.adopted("polar_moment_ratio")
from_precession = earth.zonal_harmonic(published_ratio.radius) / ellipticity
print(f"J2/H = {from_precession:.6f}, published C/(M a^2) = {published_ratio.value:.6f}")

# %% [markdown]
# Things to try: `study.two_layer_sweep("Moon", ...)`, and the same with layers that are compressed by their own weight,
# `astroinertia ratios --body Mars`; `studies.precession.precession("Mars")` for the rate behind $H$; posteriors of
# three layers in `studies.interior_inference`.
