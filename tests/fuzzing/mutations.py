"""Ways to break a file: bits, cuts, repeats, lines, numbers, counts in headers."""

import re
import struct
from collections.abc import Sequence
from random import Random

NUMBERS = ("nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "-1", "0", "1.5", "1e999", "2147483648")
NUMBERS += ("9223372036854775808", "-9223372036854775809", "9" * 40, "9" * 400, "0x10", "1_000", "\u0663")
NUMBERS += ("true", "[]", "{}", "null", '""')
NUMBER = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
WORDS = (
    *(struct.pack("<f", value) for value in (float("nan"), float("inf"), 3e38)),
    *(struct.pack("<d", value) for value in (float("nan"), 1e308)),
    *(struct.pack("<i", value) for value in (-1, 2**31 - 1)),
    *(struct.pack("<q", 2**63 - 1), b"\xff" * 8, b"\0" * 8),
)
HEADER = 400
"""Bytes at the start in which counts are looked for."""
LONGEST = 1 << 20
LAS_HEADER = 375
"""Bytes of the header of LAS 1.4."""


def mutated(rng: Random, data: bytes, tokens: Sequence[bytes] = ()) -> bytes:
    """The data with one to four changes; at most `LONGEST` bytes.

    Parameters
    ----------
    rng
    data
    tokens
        Words of the format, which are put in.
    """
    for _ in range(rng.choice((1, 1, 1, 2, 3, 4))):
        data = rng.choice(CHANGES)(rng, data, tokens)[:LONGEST]
    return data


def mutated_header(rng: Random, data: bytes, tokens: Sequence[bytes] = ()) -> bytes:
    """The data with a changed header of as many bytes, or cut.

    For packed points of surveying: lazrs takes what memory the packed bytes ask for, and ends the process
    where there is none.
    """
    if rng.random() < 0.2:
        return _cut(rng, data, tokens)
    return mutated(rng, data[:LAS_HEADER], tokens)[:LAS_HEADER].ljust(LAS_HEADER, b"\0") + data[LAS_HEADER:]


def _flip(rng, data, _tokens):
    if not data:
        return bytes([rng.randrange(256)])
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 8))):
        out[rng.randrange(len(out))] ^= 1 << rng.randrange(8)
    return bytes(out)


def _cut(rng, data, _tokens):
    return data[: rng.randrange(len(data) + 1)]


def _block(rng, data):
    start = rng.randrange(len(data) + 1)
    return start, min(len(data), start + rng.choice((1, 2, 4, 12, 60, 400)))


def _repeat(rng, data, _tokens):
    start, end = _block(rng, data)
    return data[:end] + data[start:end] * rng.choice((1, 2, 30)) + data[end:]


def _drop(rng, data, _tokens):
    start, end = _block(rng, data)
    return data[:start] + data[end:]


def _move(rng, data, _tokens):
    start, end = _block(rng, data)
    place = rng.randrange(len(data) + 1)
    return data[:place] + data[start:end] + data[place:]


def _number(rng, data, _tokens, most=None):
    found = list(NUMBER.finditer(data, 0, len(data) if most is None else min(most, len(data))))
    if not found:
        return _flip(rng, data, ())
    match = rng.choice(found)
    return data[: match.start()] + rng.choice(NUMBERS).encode() + data[match.end() :]


def _count(rng, data, _tokens):
    return _number(rng, data, (), HEADER)


def _larger(rng, data, _tokens):
    found = [m for m in NUMBER.finditer(data, 0, min(HEADER, len(data))) if m.group().isdigit()]
    if not found:
        return _repeat(rng, data, ())
    match = rng.choice(found)
    text = str(min(int(match.group()[:30]) * rng.choice((2, 1000, 10**9)) + rng.choice((0, 1)), 10**40))
    return data[: match.start()] + text.encode() + data[match.end() :]


def _word(rng, data, _tokens):
    place = rng.randrange(len(data) + 1)
    word = rng.choice(WORDS)
    return data[:place] + word + data[place + len(word) :]


def _line(rng, data, _tokens):
    lines = data.split(b"\n")
    first, second = rng.randrange(len(lines)), rng.randrange(len(lines))
    change = rng.randrange(4)
    if change == 0:
        lines[first], lines[second] = lines[second], lines[first]
    elif change == 1:
        del lines[first]
    elif change == 2:
        lines.insert(second, lines[first])
    else:
        words = lines[first].split(b" ")
        rng.shuffle(words)
        lines[first] = b" ".join(words[: rng.randrange(len(words) + 1)] or [b""])
    return b"\n".join(lines)


def _token(rng, data, tokens):
    place = rng.randrange(len(data) + 1)
    token = rng.choice(tokens) if tokens else bytes(rng.randrange(256) for _ in range(rng.randrange(1, 6)))
    return data[:place] + token + data[place + rng.choice((0, 0, len(token))) :]


CHANGES = (_flip, _cut, _repeat, _drop, _move, _number, _number, _count, _larger, _word, _line, _token)
