"""Changes of a file's bytes by chance: what disks, networks, editors and enemies do to a file that was whole."""

import random
import struct

NUMBERS = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 2**40, 2**63 - 1, 2**64 - 1)

DIGITS = (b"nan", b"-inf", b"1e999", b"-0", b"9" * 20, b"1e-320", b"\xb2", b"", b"0x1", b",", b"\n", b"1e200")


def changed(content: bytes, chance: random.Random) -> bytes:
    """The content with one to four changes, which may undo each other."""
    for _ in range(chance.choice((1, 1, 2, 4))):
        content = chance.choice(CHANGES)(content, chance)
    return content


def _flipped(content, chance):
    if not content:
        return content
    found = bytearray(content)
    for _ in range(chance.choice((1, 1, 1, 8, 64))):
        found[chance.randrange(len(found))] ^= 1 << chance.randrange(8)
    return bytes(found)


def _cut_off(content, chance):
    return content[: chance.randrange(len(content) + 1)]


def _torn(content, chance):
    """A block that was never written: zeros, or what was there before."""
    size = chance.choice((16, 512, 4096))
    begin = chance.randrange(len(content) + 1) // size * size
    other = chance.randrange(len(content) + 1) // size * size
    block = chance.choice((bytes(size), b"\xff" * size, content[other : other + size]))
    return content[:begin] + block[: max(0, len(content) - begin)] + content[begin + size :]


def _inserted(content, chance):
    begin = chance.randrange(len(content) + 1)
    return content[:begin] + chance.randbytes(chance.choice((1, 2, 8, 100))) + content[begin:]


def _removed(content, chance):
    begin = chance.randrange(len(content) + 1)
    return content[:begin] + content[begin + chance.choice((1, 2, 8, 100)) :]


def _number(content, chance):
    """A number of 1 to 8 bytes that is another now, as sizes and addresses are."""
    size, form = chance.choice(((1, "<B"), (2, "<H"), (4, "<I"), (8, "<Q"), (4, ">I"), (2, ">H")))
    begin = chance.randrange(len(content) + 1)
    number = chance.choice(NUMBERS) % 2 ** (8 * size)
    return content[:begin] + struct.pack(form, number) + content[begin + size :]


def _repeated(content, chance):
    begin = chance.randrange(len(content) + 1)
    block = content[begin : begin + chance.choice((1, 16, 300))]
    return content[:begin] + block * chance.choice((2, 3, 50)) + content[begin:]


def _digits(content, chance):
    """Another number where a text has one."""
    places = [k for k, byte in enumerate(content[:100_000]) if 48 <= byte <= 57]
    if not places:
        return _flipped(content, chance)
    begin = chance.choice(places)
    return content[:begin] + chance.choice(DIGITS) + content[begin + 1 :]


CHANGES = (_flipped, _flipped, _cut_off, _torn, _inserted, _removed, _number, _number, _repeated, _digits)
