"""Scenes that are wrong in ways that nobody thought of: those of sims/, changed here and there by chance."""

import random
import re
from collections.abc import Iterator

from tests.scripts import SIMS

# What people, programs and enemies write where something else belongs.
VALUES = (
    "0", "-1", "1e308", "-1e-308", "inf", "-inf", "nan", "true", "[]", "{}", '""', "''", '" "', '"1 km"', '"-1 km"',
    '"0 kg"', '"1e400 m"', '"nan s"', '"1 m**99999"', '"1 m/(s-s)"', '"1.4 Msun km**-3"', "[1, 2, 3]",
    '["1 km", 2, "x"]', "[[[[1]]]]", "1979-05-27T07:32:00Z", "0x7fffffffffffffff", "9223372036854775808", "1" * 300,
    '"' + "k" * 900 + '"', '"\\u0000"', '"\\ud7ff"', '"../../etc/passwd"', '"/dev/zero"', '"__import__(\'os\')"',
    '"%s%n"', '"km"', '"1 rad/s"', "1_000", "{a = 1}", '{ kind = "polytrope" }', '"auto"', '"sph"', '"none"',
)  # fmt: skip
LINES = (
    "[body]", "[[body]]", "[effects.gravity]", "[effects]", "[a.b.c.d.e.f]", "[", "]]", "= 1", "a = ", "a.b.c.d = 1",
    "[body.rotation]", 'effects = "auto"', "accuracy = 0", "accuracy = 1e-400", "[numerics]", 'engine = "gpu"',
    "[companions]", "[[companions]]", "[time]", "end = 0", "\t\t", "\ufeff", "\x00", "# \x7f", "[sweep]",
    '"body.mass" = ["1 kg", "x"]', "[output]", "series_every = -1", "include = 'x'", "[__class__]", "__proto__ = 1",
)  # fmt: skip
_VALUE = re.compile(r"^(\s*[A-Za-z0-9_.\"-]+\s*=\s*)(.*)$")


def mutated(seed: int, count: int) -> Iterator[str]:
    """So many texts, each a scene of sims/ with one to four changes; the same ones for the same seed."""
    chance = random.Random(seed)
    texts = [path.read_text() for path in sorted(SIMS.glob("*.toml"))]
    for _ in range(count):
        text = chance.choice(texts)
        for _ in range(chance.randint(1, 4)):
            text = chance.choice(CHANGES)(chance, text)
        yield text


def _another_value(chance: random.Random, text: str) -> str:
    lines = text.split("\n")
    places = [k for k, line in enumerate(lines) if _VALUE.match(line)]
    if places:
        place = chance.choice(places)
        lines[place] = _VALUE.sub(lambda found: found[1] + chance.choice(VALUES), lines[place])
    return "\n".join(lines)


def _a_value_of_another_key(chance: random.Random, text: str) -> str:
    lines = text.split("\n")
    places = [k for k, line in enumerate(lines) if _VALUE.match(line)]
    if len(places) > 1:
        one, other = chance.sample(places, 2)
        value = _VALUE.match(lines[other])
        assert value is not None
        lines[one] = _VALUE.sub(lambda found: found[1] + value[2], lines[one])
    return "\n".join(lines)


def _a_line_less(chance: random.Random, text: str) -> str:
    lines = text.split("\n")
    del lines[chance.randrange(len(lines))]
    return "\n".join(lines)


def _a_line_moved(chance: random.Random, text: str) -> str:
    lines = text.split("\n")
    line = lines.pop(chance.randrange(len(lines))) if chance.random() < 0.5 else chance.choice(lines)
    lines.insert(chance.randint(0, len(lines)), line)
    return "\n".join(lines)


def _a_line_more(chance: random.Random, text: str) -> str:
    lines = text.split("\n")
    lines.insert(chance.randint(0, len(lines)), chance.choice(LINES))
    return "\n".join(lines)


def _another_letter(chance: random.Random, text: str) -> str:
    if not text:
        return text
    place = chance.randrange(len(text))
    return text[:place] + chance.choice("\"'[]{}=.,-+eE0 19_kms\n\\#\u00b5\u2126\u0301") + text[place + 1 :]


def _a_part_less(chance: random.Random, text: str) -> str:
    begin = chance.randrange(len(text) + 1)
    return text[:begin] + text[begin + chance.randrange(1, 200) :]


def _a_longer_number(chance: random.Random, text: str) -> str:
    numbers = list(re.finditer(r"\d+", text))
    if not numbers:
        return text
    found = chance.choice(numbers)
    other = chance.choice(("0", "1e9", "1e-30", "99999999999", found[0] * 20, "-" + found[0], found[0] + ".5.5"))
    return text[: found.start()] + other + text[found.end() :]


CHANGES = (
    _another_value, _another_value, _a_value_of_another_key, _a_line_less, _a_line_moved, _a_line_more,
    _another_letter, _a_part_less, _a_longer_number, _a_longer_number,
)  # fmt: skip
