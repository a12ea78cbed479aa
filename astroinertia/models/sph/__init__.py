"""The particle fluid: its state, what is evaluated of it, and how it is stepped."""
