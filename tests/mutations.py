"""Files gone wrong: seeded mutations that a reader must refuse or read, never crash on."""

from __future__ import annotations

import re

NUMBERS = ("nan", "inf", "-1e308", "1e-320", "0", "", "1 2", "0x10", "1_0", "1e9", "٣")
WORDS = ("", "a" * 300, "../x", "universe", "\u202e", "0")


def mutations(text, rng, count):
    """Yield texts with one to three things wrong each."""
    for _ in range(count):
        changed = text
        for _ in range(int(rng.integers(1, 4))):
            changed = _STEPS[int(rng.integers(len(_STEPS)))](changed, rng) or text
        yield changed


def _span(text, rng):
    start, stop = sorted(int(k) for k in rng.integers(0, len(text) + 1, 2))
    return start, min(stop, start + 200)


def _cut(text, rng):
    start, stop = _span(text, rng)
    return text[:start] + text[stop:]


def _truncate(text, rng):
    return text[: int(rng.integers(0, len(text)))]


def _repeat(text, rng):
    start, stop = _span(text, rng)
    return text[:stop] + text[start:]


def _replace(text, rng, pattern, choices):
    if not (found := list(re.finditer(pattern, text))):
        return text
    match = found[int(rng.integers(len(found)))]
    choice = choices[int(rng.integers(len(choices)))]
    return text[: match.start()] + choice + text[match.end() :]


def _number(text, rng):
    return _replace(text, rng, r"-?\d+\.?\d*(e-?\d+)?", NUMBERS)


def _word(text, rng):
    return _replace(text, rng, r"[a-z_]\w+", [*WORDS, *re.findall(r"[a-z_]\w+", text)])


def _line(text, rng):
    lines = text.splitlines(keepends=True)
    first, second = (int(k) for k in rng.integers(0, len(lines), 2))
    lines[first], lines[second] = lines[second], lines[first]
    return "".join(lines)


def _drop_line(text, rng):
    lines = text.splitlines(keepends=True)
    del lines[int(rng.integers(len(lines)))]
    return "".join(lines)


def _twice(text, rng):
    lines = text.splitlines(keepends=True)
    at = int(rng.integers(len(lines)))
    return "".join([*lines[:at], lines[at], *lines[at:]])


_STEPS = (_cut, _truncate, _repeat, _number, _number, _word, _word, _line, _drop_line, _twice)
