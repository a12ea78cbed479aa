"""Equilibrium structure: polytropes, layers, ellipsoids, figures, rotating and compact stars, the planets' table."""

from astroinertia.process.renamed import MovedModules

_MATTER = {
    "barotropes": "barotropes", "scf_matter": "barotropes", "equations_of_state": "compact_stars",
    "tabulated_equation": "compact_tables", "degenerate": "degenerate", "materials": "planetary",
    "tillotson": "tillotson",
}  # fmt: skip
MovedModules({f"{__name__}.{before}": f"astroinertia.matter.{now}" for before, now in _MATTER.items()})
