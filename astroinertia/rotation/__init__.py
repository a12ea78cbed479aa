"""Tops, attitudes, precession, wobble, tides, spin-orbit, pulsars: what needs no scene."""
