"""The affine body: a homogeneous ellipsoid, or the tensor-virial approximation of another body."""
