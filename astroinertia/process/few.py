"""How many particles are few: compiling programs for them takes longer than running these."""

# Measured in a collapse with 1000 particles: a step takes 4.4 ms in mixed precision, 6.5 ms in float64, 7.1 ms with the
# virial tensors of records; one more precision takes 6 s to compile, and programs for records alone 5 s.
FEW = 1000
