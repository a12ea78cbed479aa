"""Effects that cannot be listed together, and why, in words."""

from collections.abc import Mapping
from typing import Any

from astroinertia.effects import catalogue
from astroinertia.effects.entries import Entry

# What would move a point mass as it moves particles; the waves besides are those of all masses, and jump where one of
# them is taken from the fluid.
FIELDS = ("rotating_frame", "tide", "external_field", "radiation_reaction")
# Relativity's weight is that of the fluid within each sphere: a star beside its companions has it, matter around sinks
# would lack theirs.
BESIDE = {"live companions": FIELDS, "sinks": (*FIELDS, "relativistic_potential")}


def beside_points(kind: str, points: str) -> str:
    """Why an effect cannot be listed with point masses that move; empty where it can."""
    return f"acts on the fluid alone, so it cannot be listed with {points}" if kind in BESIDE[points] else ""


def in_frame(effect: Any, frame: str) -> str:
    """Why an effect cannot be listed with what turns the frame; empty where it can."""
    return f"{effect.inertial}, so it cannot be listed with {frame}" if effect.inertial else ""


def beside_sinks(companions: Mapping[str, Any]) -> str:
    """Why companions with these options cannot be listed with sinks; empty where they can."""
    return "" if companions["motion"] == "live" else 'can be listed with sinks only if their motion is "live"'


def apart(kind: str, effects: Mapping[str, Mapping[str, Any]], entries: Mapping[str, Entry]) -> str:
    """Why an effect cannot be listed beside the others, all with their options; empty where it can."""
    others = {other: options for other, options in effects.items() if other != kind}
    if frame := next((other for other in others if getattr(entries[other].made, "turns_frame", False)), ""):
        return in_frame(catalogue.build(kind, effects[kind], entries), frame)
    if "sinks" in others:
        return beside_sinks(effects[kind]) if kind == "companions" else beside_points(kind, "sinks")
    live = others.get("companions", {}).get("motion") == "live"
    return beside_points(kind, "live companions") if live else ""
