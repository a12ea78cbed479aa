"""How many particles are few: compiling programs for them takes longer than running these."""

# Measured in a collapse: with 1000 particles a step takes 4.4 ms in mixed precision, 6.5 ms in float64, 7.1 ms with the
# virial tensors of records. What more particles need takes 36 s to compile, what few need 4.5 s, and makes a step of
# 500 a sixth longer.
FEW = 1000
