"""A run, from its first state to its last."""
