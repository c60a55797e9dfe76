"""What forgers share: numbers with another digit, and a geometry with the hash that belongs to it."""

from __future__ import annotations

import hashlib
import random
import re
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from tests.support.mutations import other_digit

Document = Any
Forged = tuple[str, str] | None
"""What was done, and the beginning of a pointer that must be named; None if nothing was changed."""
Forge = Callable[[random.Random, Document], Forged]


def digit(draw: random.Random, row: Document, fixed: str) -> str | None:
    """Another digit of one number of a row."""
    names = [
        name
        for name, text in row.items()
        if name != fixed and isinstance(text, str) and name not in ("kind",) and text != "0"
    ]
    if not names:
        return None
    name = draw.choice(names)
    new = other_digit(draw, row[name])
    if new.lstrip("-0.")[:1] == "" or Fraction(new) == Fraction(row[name]):
        return None
    row[name] = new
    return name


def rehashed(document: Document) -> None:
    text = ";".join(f"{name}={text}" for name, text in document["geometry"].items())
    document["geometry_hash"] = "sha256:" + hashlib.sha256(f"3-RPR;{text}".encode()).hexdigest()


def leading_digit(draw: random.Random, text: str) -> str | None:
    """A number with another digit among its first four, so that no printed digit hides the change."""
    first = next((k for k, letter in enumerate(text) if letter in "123456789"), len(text))
    places = [k for k, letter in enumerate(text[: first + 5]) if letter in "12345678" and k >= first]
    if not places:
        return None
    k = draw.choice(places)
    return f"{text[:k]}{int(text[k]) + 1}{text[k + 1 :]}"


def is_fooled(line: str, at: str) -> bool:
    """Whether a first line calls a false document established, or does not name the false claim."""
    if line.startswith("REFUSED"):
        return False
    line = line.partition("; not read")[0]
    together = re.sub(r"/[0-9]+", "/*", at)
    return line.startswith("ESTABLISHED") or not (at in line or together in line)
