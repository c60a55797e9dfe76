"""A search for documents that take long to verify: any numbers in any structure, some 100 kB of JSON.

    python -m tests.rpr_solver.verify.slow [--minutes 5] [--seed 1] [--seconds 10] [--of path]

Parts of true documents are repeated, their sides and other numbers made long or wrong, proofs of margins cut
into more parts, tubes made thin, paths run there and back, with thousands of ticks. Half of the documents are
a change of one of the slowest so far. Prints each that took longer than all before, in seconds of one core,
and exits with status 1 if one took too long.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import random
import re
import sys
import time
from collections.abc import Callable, Sequence
from copy import deepcopy
from functools import partial
from typing import Any

from tests.rpr_solver.verify import margin_forgeries, test_paths, test_singular_curves
from tests.rpr_solver.verify.forgeries import _BASES, Document, base, first_line

_LENGTH, _MOST, _KEPT = 100_000, 102_000, 8
assert margin_forgeries.MARGINS  # among the bases
Found = tuple[float, str, Document]
"""Seconds, what was done, and the document."""
_LISTS = (
    ("slices",),
    ("slices", 0, "cusps"),
    ("slices", 0, "degenerate_points"),
    ("transitions",),
    ("transitions", 0, "events"),
    ("intervals",),
    ("curves",),
    ("curves", 0, "points"),
    ("violations",),
    ("certificate", "full", "chains"),
    ("certificate", "full", "chains", 0, "tubes"),
    ("components",),
    ("components", 0, "strands"),
    ("components", 0, "strands", 0, "vertices"),
    ("regions",),
    ("aspects",),
    ("samples",),
    ("certificate", "arcs"),
    ("certificate", "motion"),
    ("certificate", "motion", 0, "speeds"),
)
_BASES_OF_ROOMS: dict[str, Callable[[], str]] = {
    **{f"path: {name}": partial(test_paths._text, name) for name in test_paths.PATHS | test_paths.WIDE},
    **{
        f"singular curves: {name}": partial(test_singular_curves._text, name)
        for name in test_singular_curves.SLICES
    },
}


def _base(name: str) -> Document:
    return json.loads(_BASES_OF_ROOMS[name]()) if name in _BASES_OF_ROOMS else base(name)


_EXACT = ("l1", "l2", "l3", "centre", "radius", "lower", "upper", "reach", "from", "to", "turn", "length")


def _number(draw: random.Random, digits: int) -> str:
    return f"{draw.randint(1, 60)}.{_decimals(draw, digits)}7"


def _decimals(draw: random.Random, digits: int) -> str:
    """As many as there are to be; Python prints no integer of more than 4300."""
    return "".join(draw.choices("0123456789", k=digits))


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


def _with_long_sides(draw: random.Random, value: Document) -> str:
    """Sides of many digits, all or some, and lengths of slices beside them."""
    digits, most = draw.choice([15, 20, 28, 40, 60, 90, 150, 390]), draw.choice([2, 6])
    geometry = value["geometry"]
    for side in draw.sample(("a2x", "a3x", "a3y", "d1", "d2", "d3"), most):
        whole = geometry[side].partition("/")[0].partition(".")[0]
        geometry[side] = f"{whole}.{_decimals(draw, digits)}7"
    text = ";".join(f"{k}={x}" for k, x in geometry.items())
    value["geometry_hash"] = "sha256:" + hashlib.sha256(f"3-RPR;{text}".encode()).hexdigest()
    return f"{most} sides of {digits} digits"


def _with_long_numbers(draw: random.Random, value: Document) -> str:
    digits, chance = draw.choice([20, 100, 390, 19_000]), draw.choice([0.1, 0.5, 1.0])
    value.update(_longer(draw, value, digits, chance))
    return f"numbers of {digits} digits"


def _with_more_cuts(draw: random.Random, value: Document) -> str:
    """Parts of a margin's proof are cut in two again and again: true claims, if they were so before."""
    full = value.get("certificate", {}).get("full", {})
    if "cuts" not in full:
        return ""
    cuts = full["cuts"][0]
    signs = [sign for sign in set(cuts) if sign != "."]
    while len(cuts) < _LENGTH - 5000 and signs:
        sign = draw.choice(signs)
        cuts = cuts.replace(".", f"{sign}..") if draw.random() < 0.8 else cuts.replace("..", f".{sign}..")
        if draw.random() < 0.1:
            break
    full["cuts"][0] = cuts[:_LENGTH]
    return "more cuts"


def _with_thin_tubes(draw: random.Random, value: Document) -> str:
    """Tubes whose radii have many digits, so that they are looked at with as many."""
    chains = value.get("certificate", {}).get("full", {}).get("chains", [])
    size = draw.choice([50, 300, 1000, 4000])
    for tube in (tube for chain in chains for tube in chain["tubes"]):
        tube["radii"] = [f"1e-{size}"] * 2
    return f"radii of 1e-{size}" if chains else ""


def _there_and_back(draw: random.Random, value: Document) -> str:
    """A path that goes there and back many times, by as many laws of motion if there is one."""
    certificate = value.get("certificate", {})
    if "arcs" not in certificate:
        return ""
    arcs, number = certificate["arcs"], draw.choice([11, 101, 501, 999])
    back = [arc[::-1] for arc in arcs[::-1]]
    whole = (arcs + back) * number + arcs
    certificate["arcs"] = whole[: 999 - (999 - len(arcs)) % (2 * len(arcs))]
    if "motion" in certificate:
        speeds = [0, *draw.choices(range(1, 10), k=draw.choice([1, 20, 5000])), 0]
        law = {"shares": ["1"], "tick": "1", "speeds": speeds, "window": draw.choice([1, 2, 9999])}
        certificate["motion"] = [law] * len(certificate["arcs"])
        while len(json.dumps(certificate)) > _LENGTH - 10_000 and len(certificate["motion"]) > len(arcs):
            del certificate["arcs"][2 * len(arcs) :], certificate["motion"][len(certificate["arcs"]) :]
            law["speeds"] = [0, 1, 0]
    value["samples"][-1]["place"] = str(len(certificate["arcs"]))
    return f"{len(certificate['arcs'])} arcs"


def _with_tiny_or_huge(draw: random.Random, value: Document) -> str:
    """A clearance, a bound, a tolerance, a limit of motion or a deviation that is tiny or huge."""
    size = draw.choice(["0." + "0" * 300 + "1", "0.00000001", "1" + "0" * 300, "100000", "44.999"])
    places = [value.get(name) for name in ("clearance", "deviation", "sampling", "between", "point")]
    places += [value.get("motion", {}).get(name) for name in ("speed", "acceleration", "jerk")]
    rows = [row for row in places if isinstance(row, dict) and row]
    if "tolerance" in value and "regions" in value:
        value["thin_regions"], value["tolerance"] = draw.choice([1, 50]), draw.choice(["0.01", "0.0001"])
    if not rows:
        return ""
    row = draw.choice(rows)
    name = draw.choice([name for name in row if row[name] is not None])
    row[name] = size
    return f"{name} of {size[:12]}"


def _with_more_digits(draw: random.Random, value: Document) -> str:
    """All decimals with more digits than they have."""
    digits = draw.choice([30, 100, 400, 2000])
    own = value.get("digits", digits)
    if own >= digits:
        return ""

    def longer(x: Any) -> Any:
        if isinstance(x, dict):
            return {k: y if k in ("geometry", "geometry_hash") else longer(y) for k, y in x.items()}
        if isinstance(x, list):
            return [longer(y) for y in x]
        if not isinstance(x, str) or not re.fullmatch(r"-?[0-9]+\.[0-9]+(e[+-][0-9]+)?", x):
            return x
        mantissa, mark, exponent = x.partition("e")
        if len(mantissa.lstrip("-0.").replace(".", "")) != own:
            return x
        return mantissa + "".join(draw.choices("123456789", k=digits - own)) + mark + exponent

    value.update({**longer(value), "digits": digits})
    return f"{digits} digits"


_CHANGES: tuple[Callable[[random.Random, Document], str], ...] = (
    _with_long_sides,
    _with_long_sides,
    _with_long_numbers,
    _with_more_cuts,
    _with_thin_tubes,
    _with_more_digits,
    _there_and_back,
    _with_tiny_or_huge,
    lambda draw, value: f"{_repeated(draw, value)} repeated",
)


def document(
    draw: random.Random, slowest: Sequence[Found] = (), names: Sequence[str] = ()
) -> tuple[str, Document]:
    """A document and what was done to it."""
    if slowest and draw.random() < 0.5:
        _, name, whole = draw.choice(slowest)
        value, changes = deepcopy(whole), draw.sample(_CHANGES, 1)
    else:
        name = draw.choice(names or [*_BASES, *_BASES_OF_ROOMS])
        value, changes = _base(name), draw.sample(_CHANGES, draw.choice([1, 2, 3, 4]))
    return ", ".join([name, *filter(None, [change(draw, value) for change in changes])]), value


def main() -> int:
    """Searches."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=10, help="that one document may take")
    parser.add_argument("--of", default="", help="the beginning of the names of the documents to change")
    arguments = parser.parse_args()
    names = [name for name in (*_BASES, *_BASES_OF_ROOMS) if name.startswith(arguments.of)]
    draw, stop, n = random.Random(arguments.seed), time.monotonic() + 60 * arguments.minutes, 0
    slowest: list[Found] = []
    first_line(base("table"))  # SymPy is loaded
    while time.monotonic() < stop:
        done, value = document(draw, slowest, names)
        text = json.dumps(value)
        if len(text) > _MOST:
            continue
        start = time.process_time()
        line = first_line(text)
        taken, n = time.process_time() - start, n + 1
        if not slowest or taken > slowest[0][0]:
            print(f"{taken:6.2f} s, {len(text)} B: {done}: {line[:80]}", flush=True)
        slowest = sorted([*slowest, (taken, done, value)], key=lambda found: -found[0])[:_KEPT]
    longest = slowest[0][0] if slowest else 0
    print(f"{n} documents, {longest:.2f} s at most")
    return 1 if longest > arguments.seconds else 0


if __name__ == "__main__":
    sys.exit(main())
