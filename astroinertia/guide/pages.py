"""The pages of the guide: which there are, and the text of each. Two are written from the program when they are read.

A page is Markdown and lies beside this file, so that it ships with the package. Its links are relative to the
repository, where pictures and scenes are; `readable` is the page for a reader who has the installed package alone.
Tests: tests/unit/guide/test_guide.py.
"""

import difflib
import importlib
import re
from collections.abc import Callable, Mapping
from pathlib import Path

from astroinertia.errors import SceneError

TOPICS: Mapping[str, str] = {
    "first-run": "from a scene to a dataset and pictures: the commands, exit codes, notebooks",
    "overview": "what is in the package, and how its parts are arranged",
    "scene": "reference of scenes: every key with its unit, default and limits",
    "effects": "reference of effects: what each is, its options and its source",
    "choosing-effects": 'which effects a scene needs: plan, effects = "auto", proof of absence',
    "models": "four models for one scene: particles, ellipsoid, rigid body, scaling laws",
    "ledger": "the evolution equation of the inertia tensor, and which effect did what",
    "collapse": "collapse, spin-up and other experiments with the fluid",
    "precession": "tops, precession of planets, wobble, pulsars: rotation without particles",
    "moment-ratios": "I/(M R^2), J2 and Love numbers of planets and stars from their interiors",
    "inertia-toolbox": "inertia tensors of particles, meshes and solids; balancing; bodies made to order",
    "sweeps": "many runs at once: grids, Latin hypercubes, lists, workers, clusters",
    "xarray-analysis": "results in xarray: opening, selecting, plotting, units",
    "file-formats": "what is read and written: run folders, netCDF, snapshots of other codes",
    "accuracy": "how accurate results are, what accuracy costs, error bars",
    "performance": "how fast it is, and what a run will take",
    "own-effects": "physics of your own: effects, matter, bodies and observables, and what needs no code",
    "limits": "what the program cannot do, and where it is weak",
}
WRITTEN_WHEN_READ: Mapping[str, str] = {
    "scene": "astroinertia.guide.scene_reference",
    "effects": "astroinertia.guide.effects_reference",
}
"""Topics whose text is the `text()` of a module."""

_PICTURE = re.compile(r"!\[[^\]]*\]\([^)]*\)")
_LINK = re.compile(r"(?<!!)\[([^\]]+)\]\(([^)\s]+)\)")


def page(topic: str) -> str:
    """A page of the guide as Markdown, as it lies in the repository; SceneError names the topic nearest to a wrong one.

    >>> page("ledger").splitlines()[0]
    '# The ledger'
    """
    if topic not in TOPICS:
        raise SceneError(f"'{topic:.40}' is no topic of the guide; {_nearest(topic)}")
    if topic in WRITTEN_WHEN_READ:
        return importlib.import_module(WRITTEN_WHEN_READ[topic]).text()
    return Path(__file__).with_name(f"{topic}.md").read_text(encoding="utf-8")


def readable(topic: str) -> str:
    """A page without what only the repository has: pictures go, and links to pages become the command that shows them.

    >>> "](" in readable("ledger")
    False
    """
    return outside_code(page(topic), _plain)


def outside_code(text: str, change: Callable[[str], str]) -> str:
    """The text with every line changed that is not in a block of code; a line of which nothing is left goes.

    >>> outside_code("a\\n```\\na\\n```", str.upper)
    'A\\n```\\na\\n```\\n'
    """
    lines, code = [], False
    for line in text.splitlines():
        fence = line.lstrip().startswith("```")
        changed = line if code or fence else change(line)
        code ^= fence
        if changed.strip() or not line.strip():
            lines.append(changed)
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)) + "\n"


def _plain(line: str) -> str:
    return _LINK.sub(_without_target, _PICTURE.sub("", line))


def _without_target(link: re.Match[str]) -> str:
    text, target = link.groups()
    topic = target.partition("#")[0].removesuffix(".md")
    if topic in TOPICS:
        return f"{text} (`astroinertia guide {topic}`)"
    return f"{text} ({target})" if "://" in target and target not in text else text


def _nearest(topic: str) -> str:
    word = topic.lower()[:64]
    named = [known for known in TOPICS if word in known.split("-")]
    close = named or difflib.get_close_matches(word, TOPICS, n=1, cutoff=0.6)
    return f"did you mean '{close[0]}'?" if close else f"its topics are {', '.join(TOPICS)}."
