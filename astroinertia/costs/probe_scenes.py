"""The scenes that `calibrate` times."""

CLOUD = """
name = "cloud"
units = "code"
[body]
kind = "power_law"
exponent = 1.0
mass = 1.0
radius = 1.0
placement = "random"
relax = false
specific_internal_energy = 0.05
[equation_of_state]
kind = "ideal"
gamma = 1.6666666666666667
[effects.gravity]
method = "multipole"
[effects.pressure]
[effects.viscosity]
[time]
end = 2.0
"""
ELLIPSOID = """
name = "spheroid"
model = "ellipsoid"
units = "code"
[body]
kind = "uniform"
mass = 1.0
radius = 1.0
axes = [1.0, 1.0, 0.8]
[body.rotation]
rate = 0.3
[equation_of_state]
kind = "incompressible"
[effects.gravity]
[effects.pressure]
[time]
end = 1e3
"""
RIGID = """
name = "top"
model = "rigid"
units = "code"
[body]
kind = "rigid"
mass = 1.0
moments = [1.0, 2.0, 2.5]
[body.rotation]
rate = 1.0
axis = [0.1, 1.0, 0.1]
[effects]
[time]
end = 1e4
"""
COMPANION = """
[numerics]
integrator = "splitting"
[[companions]]
name = "moon"
mass = 0.1
semi_major_axis = 20.0
[effects.gravity_gradient]
"""
SCALING = """
name = "start"
model = "scaling"
units = "code"
[body]
kind = "polytrope"
index = 1.5
mass = 1.0
radius = 1.0
[body.rotation]
rate = 0.1
[effects.gravity]
[effects.pressure]
[time]
end = 1.0
[output]
series_every = 1.0
"""
