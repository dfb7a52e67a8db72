# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Odd JSON: what parses and should not pass, and what should not even parse."""

from __future__ import annotations

import json
from random import Random
from typing import Any

from .mutate import ODD

_SPELLED = (
    *("NaN", "Infinity", "-Infinity", "1e400", "-1e400", "1e-400", "-0", "-0.0", "1E+2", "0.1", "2.0", "-1"),
    *("9" * 400, "9" * 4300, "9" * 5000, "-" + "9" * 5000, "1" + "0" * 308, "1e308", "3.4028236e38"),
    *("true", "null", "{}", "[]", '""', '"' + "a" * 3000 + '"', r'"\ud800"', r'"\udfff\ud800"', '"ü☃🦄"'),
    *(
        r'"\u0000"',
        r'"a\nb"',
        r'"\u001b[31m"',
        r'"\u2028"',
        '"../../x"',
        '"/etc/passwd"',
        r'"C:\\x"',
        '"con"',
    ),
    *("[" * 50 + "]" * 50, "[" * 400 + "]" * 400, "[" * 990 + "]" * 990, "[" * 5000 + "]" * 5000),
    *('{"a":' * 900 + "1" + "}" * 900, "[" * 100_000),
)
_SPLICED = (*"\ufeff\0", "//", *",:\"{}[]\\\n'\x85é", "")
_MARK = "\ue000"  # a value that stands for a spelled one


def mutate_json(data: bytearray, random: Random) -> None:
    """Change a value, a key or the text of the JSON `data`."""
    text = data.decode("utf-8")
    if random.random() < 0.15:
        data[:] = _spliced(text, random).encode("utf-8", "surrogatepass")
        return
    document = json.loads(text)
    replaced: dict[str, str] = {}
    for _ in range(random.choice((1, 1, 2, 3))):
        document = _changed(document, random, replaced)
    indent = random.choice((None, 2)) if len(text) < 5000 else None
    text = json.dumps(document, ensure_ascii=random.random() < 0.5, indent=indent)
    for mark, spelled in replaced.items():
        text = text.replace(json.dumps(mark), spelled).replace(f'"{mark}"', spelled)
    if random.random() < 0.1:
        text = text.replace("{", '{"version": 1, "texels": [1, 1], ', 1)  # keys twice
    data[:] = text.encode("utf-8", "surrogatepass")


def _spliced(text: str, random: Random) -> str:
    place = random.randrange(len(text) + 1)
    if random.random() < 0.3:
        return text.encode(random.choice(("utf-16", "utf-8-sig"))).decode("latin-1")
    between: str = random.choice((*_SPLICED, *_SPELLED))
    return text[:place] + between + text[place + random.choice((0, 0, 1, 5)) :]


def _changed(document: Any, random: Random, replaced: dict[str, str]) -> Any:
    """The document with one place of it altered."""
    holder, key = _somewhere(document, random)
    if holder is None:
        return _value(document, random, replaced)
    deed = random.randrange(6)
    if deed == 0:
        del holder[key]
    elif deed == 1 and isinstance(holder, dict):
        holder[random.choice((str(key) + "s", "", "x" * 200, "a\nb", "é"))] = holder.pop(key)
    elif deed == 1:
        holder.insert(key, holder[key])
    else:
        holder[key] = _value(holder[key], random, replaced)
    return document


def _somewhere(document: Any, random: Random) -> tuple[Any, Any]:
    """A container in the document and a key of it; None where there is none."""
    places: list[tuple[Any, Any]] = []
    waiting = [document]
    while waiting:
        holder = waiting.pop()
        if isinstance(holder, dict | list) and holder:
            keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
            places += ((holder, key) for key in keys)
            waiting += (holder[key] for key in keys)
    return random.choice(places) if places else (None, None)


def _value(before: Any, random: Random, replaced: dict[str, str]) -> Any:
    """Something in the place of `before`."""
    deed = random.randrange(8)
    if isinstance(before, int) and not isinstance(before, bool) and deed < 4:
        return random.choice((before + 1, before - 1, before * 2, -before, *ODD))
    if isinstance(before, float) and deed < 3:
        return random.choice((before * 1e30, -before, 0.0, before * 1e-30))
    if isinstance(before, list) and before and deed < 3:
        more = before * random.choice((2, 10, 300)) if len(before) < 30 else before[:-1]
        return random.choice(
            (more if all(map(_is_single, before)) else before * 2, before[:-1], before[::-1])
        )
    if isinstance(before, str) and deed < 3 and len(before) < 1000:
        return random.choice((before + "x", before[:-1], before.upper(), before + "\n", before * 50, ""))
    mark = f"{_MARK}{len(replaced)}{_MARK}"
    replaced[mark] = random.choice(_SPELLED)
    return mark


def _is_single(value: Any) -> bool:
    return not isinstance(value, dict | list)
