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
# # A collapse experiment: what does it do to the moment of inertia, and which force did it?
#
# A cold, slowly turning cloud of gas falls together under its own weight, heats up, and springs back. We follow it with
# five hundred particles, which takes some seconds, and ask four questions that one meets in every collapse, be it of a
# cloud, a star or a stellar core:
#
# 1. how does the moment of inertia $I(t)$ change, and is its evolution equation obeyed;
# 2. does the spin rise as $1/I$, and how far does the popular $R^{-2}$ miss;
# 3. when does rotation become dynamically important, that is, what does $T/|W|$ do;
# 4. which force did it?
#
# Five hundred particles are enough for these questions, for they are about the body as a whole. They are far too few
# for its interior: the run itself says so, as we shall see.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import astroinertia
from astroinertia import plots, units
from astroinertia.bodies import maclaurin

# %matplotlib inline

# %% [markdown]
# ## The cloud
#
# One solar mass, uniform, 2000 au in radius. The gas is molecular hydrogen with helium, 2.33 hydrogen masses a
# particle. Below about 100 K molecular hydrogen has no excited rotation, so that $\gamma = 5/3$. (A real cloud radiates
# and stays isothermal until it is opaque, at about $10^{-13}$ g cm$^{-3}$: Larson 1969, MNRAS 145, 271. Ours is
# adiabatic from the beginning. That is what makes it spring back early, and keeps this experiment short.)
#
# A scene says all of that, and lists the effects that it calls for. What is not listed is absent from what is compiled
# and run.

# %%
scene = """
name = "collapsing_cloud"

[body]
kind = "uniform"
particles = 500
mass = "1 Msun"
radius = "2000 au"
specific_internal_energy = "2.2e4 m2 s-2"

[body.rotation]
law = "rigid"
t_over_w = 0.01

[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667

[effects.gravity]
[effects.pressure]
[effects.viscosity]

[numerics]
precision = "mixed"

[time]
end = "24000 yr"

[output]
series_every = "100 yr"
snapshot_every = "3000 yr"
"""


def run(text):
    """Run a scene and return its dataset and its particles, all in memory."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.toml"
        path.write_text(text)
        astroinertia.run_scene(path, Path(folder) / "run", progress=False)
        tree = astroinertia.open_tree(Path(folder) / "run").load()
        tree.close()
    return tree.to_dataset(), tree["snapshots"].to_dataset() if "snapshots" in tree.children else None


cloud, particles = run(scene)

# %% [markdown]
# Two numbers to expect, before looking at the result: how warm this gas is, and within which time pressureless gas of
# this density falls into a point, $t_\mathrm{ff} = \sqrt{3\pi/(32 G\rho)}$ (the period of an orbit that is a straight
# line, halved). What is held up by pressure takes longer.

# %%
MOLECULE = 2.33 * units.ATOMIC_MASS
specific_energy = float(cloud.internal_energy[0] / cloud.mass[0])
temperature = 2 / 3 * specific_energy * MOLECULE / units.BOLTZMANN_CONSTANT
radius = units.quantity("2000 au", "length")
density = float(cloud.mass[0]) / (4 / 3 * np.pi * radius**3)
free_fall_time = np.sqrt(3 * np.pi / (32 * units.GRAVITATIONAL_CONSTANT * density))
kyr = units.quantity("1000 yr", "time")
print(f"temperature {temperature:.1f} K, free-fall time {free_fall_time / kyr:.1f} kyr")

# %% [markdown]
# ## 1. The moment of inertia, by its own evolution equation
#
# With the second moment $Q = \sum m\,x\otimes x$ and $I = \mathrm{tr}(Q)\,1 - Q$, the tensor virial theorem
# (Chandrasekhar 1969, *Ellipsoidal Figures of Equilibrium*, chapter 2) is an equation of motion of the inertia tensor,
#
# $$\ddot Q = 2K + \sum_e (V_e + V_e^T),\qquad V_e = \sum m\,x\otimes a_e ,$$
#
# with one $3\times3$ matrix $V_e$ for every effect. It is integrated beside the particles. In the first panel, lines
# are that and dots are the plain sum over the particles; the third shows how far they are from each other.

# %%
cloud.inertia.plot_inertia()

# %%
moment = cloud.inertia.about_axis("z")
bounce = int(np.argmin(moment.values))
time = cloud.time / kyr
compression = float(moment[0] / moment[bounce])
closure = float(cloud.ledger_closure.max())
print(f"I_zz falls {compression:.0f}-fold in {float(time[bounce]):.1f} kyr")
print(f"evolved and summed differ by at most {closure:.0e}")

# %% [markdown]
# ## 2. The spin
#
# No effect in this scene can turn an isolated cloud, so the angular momentum $L$ stays, and the mean angular velocity
# $\omega = I^{-1}L$ rises exactly as $1/I$. The law $\omega\propto R^{-2}$ needs more: that the cloud keeps its shape
# and profile. Beside the fluid, we let the model `scaling` answer the same question. It takes conservation laws and
# nothing else, and shrinks the body as we tell it: here as the particles did, at twelve instants.

# %%
picked = np.unique(np.linspace(0, bounce, 13).astype(int))[1:]
times = [f"{each:.6e} s" for each in cloud.time.values[picked]]
factors = [float(each) for each in (moment / moment[0]).values[picked]]
shrinking = f"""
[body.change]
times = {times}
factors = {factors}
""".replace("'", '"')
scaling, _ = run(
    scene.replace('name = "collapsing_cloud"', 'name = "scaled_cloud"\nmodel = "scaling"')
    .replace("[body.rotation]", shrinking + "\n[body.rotation]")
    .replace("[effects.viscosity]\n", "")
)

# %%
spin, scaled_spin = cloud.inertia.spin_rate(), scaling.inertia.spin_rate()
momentum = cloud.angular_momentum.sel(i="z")
change_of_momentum = float(abs(momentum / momentum[0] - 1).max())
spin_up = float(spin[bounce] / spin[0])
by_inertia = float(cloud.inertia.spin_scaling("inertia")[bounce] / spin[0])
by_radius = float(cloud.inertia.spin_scaling("radius")[bounce] / spin[0])
print(f"L changes by {change_of_momentum:.0e}")
print(f"the spin rises {spin_up:.2f}-fold; 1/I says {by_inertia:.2f}, R^-2 says {by_radius:.2f}")

# %% [markdown]
# $R^{-2}$ is off, though not by much, because the cloud is no longer uniform or round when it turns about: the mean
# radius is that of a homogeneous ellipsoid with the same second moments, and rotation has flattened that.
#
# ## 3. When does rotation matter?
#
# If a body shrinks without changing its shape or profile, its energy of rotation $T = L^2/2I$ grows as $R^{-2}$ and
# $|W|$ as $R^{-1}$, so $T/|W|\propto R^{-1}\propto I^{-1/2}$: rotation always wins in the end. Homogeneous bodies then
# meet two limits, both exact (Chandrasekhar 1969, chapter 5): where the Jacobi ellipsoids branch off, friction lets a
# bar grow; beyond the second a bar grows by itself.

# %%
ratio, scaled_ratio = cloud.rotational_to_gravitational, scaling.rotational_to_gravitational
secular = maclaurin.bifurcation().rotational_to_gravitational
homologous = float(ratio[0]) * np.sqrt(moment[0] / moment)
needed = (secular / float(ratio[0])) ** 2

figure, (upper, lower) = plt.subplots(2, 1, figsize=(7.5, 6.5), sharex=True, layout="constrained")
upper.semilogy(time, spin / spin[0], lw=4, alpha=0.4, label="particles")
upper.semilogy(time, moment[0] / moment, "--", color="C1", label="$I_0/I$")
falling = scaling.time <= cloud.time[bounce]
upper.semilogy(scaling.time[falling] / kyr, (scaled_spin / scaled_spin[0])[falling], "k:", label="model scaling")
upper.set(ylabel=r"angular velocity over its first value, $\omega/\omega_0$", title="Spin-up of a collapsing cloud")
lower.plot(time, ratio, lw=2, label="particles")
lower.plot(scaling.time[falling] / kyr, scaled_ratio[falling], "k:", label="model scaling")
lower.axhline(secular, color="C3", lw=1)
lower.text(0.2, secular, "Jacobi ellipsoids branch off", color="C3", va="bottom")
lower.set(xlabel="time (kyr)", ylabel="$T/|W|$", ylim=(0, 0.16))
for axes in (upper, lower):
    axes.axvline(float(time[bounce]), color="grey", lw=0.8, ls=":")
    axes.legend(loc="center left")
plt.show()

peak_ratio, scaled_peak = float(ratio[bounce]), float(homologous[bounce])
print(f"T/|W| at the turning point: {peak_ratio:.4f}; by scaling {scaled_peak:.4f}")
print(f"a bar could grow only if I fell {needed:.0f}-fold")

# %% [markdown]
# The fluid stays a little below the scaling law: its centre is denser than the scaled cloud's, which makes $|W|$ larger
# at the same $I$. Neither comes near a bar; pressure turned the cloud about long before rotation could.
#
# ## 4. Which force did it?
#
# The ledger answers that without any interpretation. The share of effect $e$ in $\ddot I$ is $\mathrm{tr}(S_e)\,1 -
# S_e$ with $S_e = V_e + V_e^T$, motion has the share of $2K$, and these add up to the whole exactly. Integrated from
# the start to the turning point, where $\dot I = 0$ again, they say what each has done.

# %%
shares = cloud.inertia.acceleration_shares("z")
unexplained = float(abs(shares.sum("share") - cloud.inertia_acceleration.sel(i="z", j="z")).max() / abs(shares).max())
done = shares.isel(time=slice(0, bounce + 1)).integrate("time").to_series()
against_gravity = (done / -done["gravity"]).round(3)
print(f"what the shares leave unexplained: {unexplained:.0e} of the largest")
against_gravity

# %%
cloud.inertia.plot_ledger()

# %% [markdown]
# Gravity pulled. Of what it did, motion undid two fifths ($2K$ is never negative: whatever moves parts sooner or
# later), pressure more than half, and viscosity a thirtieth. The torque of each is round-off, so none of them turned
# the cloud: it spins faster only because $I$ is smaller.
#
# Viscosity looks unimportant for $I$. For the energy it is not: it is what turns the shock's motion into heat, and the
# ledger of energy shows how much.

# %%
heated = cloud.heating.isel(time=bounce).to_series()
gained = float(cloud.internal_energy[bounce] - cloud.internal_energy[0])
energy_error = float(abs(cloud.total_energy - cloud.total_energy[0]).max() / abs(cloud.gravitational_energy).max())
for effect, heat in heated.items():
    print(f"{effect:10s} {heat / gained:6.1%} of the heat that the cloud has at its turning point")
print(f"energy is kept to {energy_error:.0e} of the deepest binding")

# %% [markdown]
# ## What it looks like, and what not to trust
#
# Column densities, side-on and pole-on, with the principal axes of the homogeneous ellipsoid with the same tensor.

# %%
plots.projection_figure(cloud, particles)

# %%
print(cloud.attrs["resolution_warnings"])

# %% [markdown]
# The run has looked at its own particles and warns that five hundred of them may fall apart into pieces that are no
# physics. $I$, $L$ and $T/|W|$ of the whole cloud are another matter, and to see how well *these* are known, run it
# again with `particles = 2000`, or let `astroinertia run --error-bars` do that for you.
#
# Things to try: a colder cloud (`specific_internal_energy`) falls deeper and spins up more; with `t_over_w = 0.1` it
# becomes a disc; without `[effects.viscosity]` there is no shock and the particles stream through each other.
