"""Equilibrium structure: polytropes, layers, ellipsoids, figures, rotating and compact stars, the planets' table."""
