"""Tops, attitudes, precession, wobble, tides, spin-orbit, pulsars: what needs no scene."""

from astroinertia.process.renamed import MovedModules

MovedModules({f"{__name__}.{name}": f"astroinertia.bodies.{name}" for name in ("bar_limits", "break_up")})
