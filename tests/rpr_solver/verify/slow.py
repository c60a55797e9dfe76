"""A search for documents that take long to verify: any numbers in any structure, some 100 kB of JSON.

    python -m tests.rpr_solver.verify.slow [--minutes 5] [--seed 1] [--seconds 10]

Parts of true documents are repeated, their numbers made long or wrong. Prints each document that took longer
than all before, in seconds of one core, and exits with status 1 if one took too long.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import random
import sys
import time
from copy import deepcopy
from typing import Any

from tests.rpr_solver.verify.forgeries import _BASES, base, first_line

_LENGTH = 100_000
_LISTS = (
    ("slices",),
    ("slices", 0, "cusps"),
    ("slices", 0, "degenerate_points"),
    ("slices", 0, "certificate", "full", "real_roots"),
    ("transitions",),
    ("transitions", 0, "events"),
    ("intervals",),
    ("curves",),
    ("curves", 0, "points"),
    ("violations",),
    ("certificate", "full", "events"),
    ("certificate", "full", "samples"),
    ("certificate", "full", "chains"),
    ("certificate", "full", "chains", 0, "tubes"),
)
_EXACT = ("l1", "l2", "l3", "centre", "radius", "lower", "upper", "reach", "from", "to")


def _number(draw: random.Random, digits: int) -> str:
    whole = draw.randint(1, 60)
    return f"{whole}.{draw.randrange(10**digits):0{digits}}7"


def _longer(draw: random.Random, value: Any, digits: int, chance: float) -> Any:
    """The value with long numbers in some of the places of exact ones."""
    if isinstance(value, dict):
        return {
            name: _number(draw, digits)
            if name in _EXACT and isinstance(item, str) and draw.random() < chance
            else _longer(draw, item, digits, chance)
            for name, item in value.items()
        }
    if isinstance(value, list):
        return [_longer(draw, item, digits, chance) for item in value]
    return value


def _repeated(draw: random.Random, document: Any) -> str:
    """Repeats an element of a list until the document is long; says of which."""
    places = []
    for path in _LISTS:
        found: Any = document
        for step in path:
            try:
                found = found[step]
            except (KeyError, IndexError, TypeError):
                break
        else:
            if found:
                places.append((path, found))
    if not places:
        return "nothing"
    path, rows = draw.choice(places)
    room = _LENGTH - len(json.dumps(document))
    one = len(json.dumps(rows[0])) + 2
    for n in range(max(0, room // one)):
        row = deepcopy(rows[n % len(rows)])
        if isinstance(row, dict) and draw.random() < 0.9:
            for name in ("l1", "l2"):
                if isinstance(row.get(name), str) and "cusp" not in row:
                    row[name] = f"{n + 1}.{draw.randint(1, 9)}"
        rows.append(row)
    return "/".join(map(str, path))


def document(draw: random.Random) -> tuple[str, Any]:
    """A document and what was done to it."""
    name = draw.choice(list(_BASES))
    value, done = base(name), [name]
    if draw.random() < 0.5:
        digits = draw.choice([20, 60, 150, 390])
        for side in ("a2x", "a3y", "d1", "d2"):
            whole = value["geometry"][side].split(".")[0]
            value["geometry"][side] = f"{whole}.{draw.randrange(10**digits)}7"
        text = ";".join(f"{k}={x}" for k, x in value["geometry"].items())
        value["geometry_hash"] = "sha256:" + hashlib.sha256(f"3-RPR;{text}".encode()).hexdigest()
        done.append(f"sides of {digits} digits")
    if draw.random() < 0.3:
        digits, chance = draw.choice([20, 100, 390]), draw.choice([0.1, 1.0])
        value = _longer(draw, value, digits, chance)
        done.append(f"numbers of {digits} digits")
    if draw.random() < 0.7:
        done.append(f"{_repeated(draw, value)} repeated")
    return ", ".join(done), value


def main() -> int:
    """Searches."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=10, help="that one document may take")
    arguments = parser.parse_args()
    draw, stop, longest, n = random.Random(arguments.seed), time.monotonic() + 60 * arguments.minutes, 0.0, 0
    first_line(base("table"))  # SymPy is loaded
    while time.monotonic() < stop:
        done, value = document(draw)
        text = json.dumps(value)
        start = time.process_time()
        line = first_line(text)
        taken, n = time.process_time() - start, n + 1
        if taken > longest:
            longest = taken
            print(f"{taken:6.2f} s, {len(text)} B: {done}: {line[:80]}", flush=True)
    print(f"{n} documents, {longest:.2f} s at most")
    return 1 if longest > arguments.seconds else 0


if __name__ == "__main__":
    sys.exit(main())
