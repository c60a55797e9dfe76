"""The long run of exports: true documents beside degenerate shapes, and altered ones, in other systems.

    python -m tests.rpr_solver.exports.long_run [--documents 300] [--first 0] [--seed 1] [--systems pari,…]
        [--roots]

With ``--roots`` manipulators are by points, sides and roots, and lengths are random or beside transitions.

Document n is the same in every run with the same seed, so that a run may be done in parts (``--first``). It
is a table or a census of a manipulator that is random, degenerate, or beside a degenerate family by 1e-2 to
1e-12; at lengths beside special ones and beside transitions, by 1e-6 to 1e-30 of them. Of every second one a
number, a count or a cusp is changed. A true document must never differ, and 95 of 100 must agree; one that
was changed must differ, or be left open where the true one is. Systems other than PARI get the tables of one
slice. Of msolve's solutions only the angles are compared, with those of true documents. Prints every failure
as it is found, then the numbers, and exits with status 1 if there was a failure.
"""

from __future__ import annotations

import argparse
import copy
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from random import Random
from typing import Any

from rpr_solver import InputError, Manipulator, SolverError, census, exact_str, table_document
from rpr_solver.exports.export import half_unit
from tests.rpr_solver.long_run import manipulator
from tests.support.degenerate import MAKERS, beside, draws, special_lengths
from tests.support.scripts import installed, verdict
from tests.support.triangle_spellings import manipulator_with_roots

Document = dict[str, Any]
OPEN = "cannot decide"


def machine(rng: Random) -> tuple[str, Manipulator]:
    """What it is, and a manipulator."""
    family = rng.choice(list(MAKERS))
    way = rng.random()
    if way < 0.2:
        return "random", manipulator(rng)
    if way < 0.35:
        return family, dict(draw for draw, _ in zip(draws(rng), MAKERS, strict=False))[family]
    exponent = rng.randint(2, 12)
    return f"1e-{exponent} beside {family}", beside(rng, family, exponent)


def document(number: int, seed: int, *, roots: bool) -> tuple[str, Document]:
    """Document n of a seed, and what it is; the first draw that can be exported."""
    rng = Random(f"{seed} {number}")
    while True:
        name, m = ("roots", manipulator_with_roots(rng)) if roots else machine(rng)
        leg, digits = rng.choice((1, 2, 3)), rng.choice((15, 20, 30))
        try:
            if number % 4 == 3:
                whole = census(m, fixed_leg=leg, digits=digits).to_json()
                if _can_be_exported(whole):
                    return f"census of {name}", whole
                continue
            if number % 4 == 2:
                places = [Fraction(t.length) for t in census(m, fixed_leg=leg, digits=40).transitions]
                of, where = 40, "transitions"
            elif roots:
                places, of, where = [Fraction(rng.randint(200, 2500), 100)], 30, "a length"
            else:
                places, of, where = special_lengths(m), 30, "special lengths"
            if not places:
                continue
            lengths = [_beside(rng, rng.choice(places), of) for _ in range(rng.randint(1, 3))]
            found = table_document(m, sorted(set(lengths)), fixed_leg=leg, digits=digits)
            if _can_be_exported(found):
                return f"table beside {where} of {name}", found
        except (InputError, SolverError):
            continue


def _beside(rng: Random, length: Fraction, most: int) -> str:
    share = Fraction(rng.choice((-1, 1)) * rng.randint(1, 9), 10 ** rng.randint(6, most))
    return exact_str(round(length * (1 + share), most + 2))


def _can_be_exported(document: Document) -> bool:
    """Whether each slice has an answer, and there is no whole curve of degenerate poses."""
    slices = document.get("slices", ())
    points = [
        *document.get("degenerate", ()),
        *(x for part in slices for x in part.get("degenerate_points", ())),
    ]
    return all("error" not in part for part in slices) and all(x["kind"] != "curve" for x in points)


def altered(document: Document, rng: Random) -> Document:
    """The document with one number or one count that is wrong, or with a cusp too many or too few."""
    changed = copy.deepcopy(document)
    slices = changed.get("slices") or [part for part in changed["intervals"] if _has_room(part)]
    rows = [cusp for part in changed.get("slices", ()) for cusp in part["cusps"]]
    rows += [e for t in changed.get("transitions", ()) for e in t["events"] if e["kind"] in COMPARED]
    if rows and rng.random() < 0.6:
        row = rng.choice(rows)
        name = rng.choice([name for name in row if name != "kind" and row[name] != "0"])
        row[name] = _with_another_digit(row[name], rng)
        return changed
    part = rng.choice(slices)
    if "cusps" not in part:
        part["count"] += rng.choice((-2, 2)) if part["count"] > 1 else 2
    elif part["cusps"] and rng.random() < 0.7:
        part["cusps"].pop(rng.randrange(part["count"]))
        part["count"] -= 1
    else:
        names = part["cusps"][0] if part["cusps"] else _no_cusp(changed["fixed_leg"])
        part["cusps"].append({name: _with_another_digit(text, rng) for name, text in names.items()})
        part["count"] += 1
    return changed


def _has_room(window: Document) -> bool:
    """Whether the printed ends of a window leave room for a slice: else its count is not compared."""
    low, high = window["from"], window["to"]
    return high is None or Fraction(low) + half_unit(low) < Fraction(high) - half_unit(high)


COMPARED = ("swallowtail", "lips", "beak-to-beak")
"""The kinds of degenerate poses of a census that programs compare."""


def _no_cusp(leg: int) -> dict[str, str]:
    first, second = (f"l{k}" for k in (1, 2, 3) if k != leg)
    number = "12.3456789012345"
    return {"alpha_deg": number, f"theta{leg}_deg": number, first: number, second: number}


def _with_another_digit(text: str, rng: Random) -> str:
    """A number of which one significant digit is another, in any place."""
    mantissa, exponent, power = text.partition("e")
    digits = [k for k, x in enumerate(mantissa) if x.isdigit() and mantissa[: k + 1].strip("-0.")]
    k = rng.choice(digits)
    other = rng.choice([x for x in "123456789" if x != mantissa[k]])
    return f"{mantissa[:k]}{other}{mantissa[k + 1 :]}{exponent}{power}"


def verdicts(
    number: int, seed: int, systems: list[str], folder: Path, *, roots: bool
) -> Iterator[tuple[str, str, str, str]]:
    """What it is, the system, the verdict on the document, and that on the altered one, or nothing."""
    name, true = document(number, seed, roots=roots)
    wrong = altered(true, Random(f"altered {seed} {number}")) if number % 2 else None
    for system in systems:
        if system == "pari" or len(true.get("slices", ())) == 1:
            other = "" if wrong is None or system == "msolve" else verdict(wrong, system, folder)
            yield name, system, verdict(true, system, folder), other


def main() -> int:
    """Runs all documents."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--documents", type=int, default=300)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--systems", default="pari,sympy,sage,msolve")
    parser.add_argument("--roots", action="store_true", help="manipulators by points, sides and roots")
    arguments = parser.parse_args()
    systems = [system for system in arguments.systems.split(",") if installed(system)]
    counts, failures = Counter[tuple[str, str, str]](), 0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(arguments.first, arguments.first + arguments.documents):
            before = time.monotonic()
            asked = number, arguments.seed, systems, Path(folder)
            for name, system, true, wrong in verdicts(*asked, roots=arguments.roots):
                counts[system, "true", true] += 1
                failed = true not in ("agrees", OPEN)
                if wrong:
                    counts[system, "altered", wrong] += 1
                    failed |= wrong != "differs" and (wrong, true) != (OPEN, OPEN)
                failures += failed
                words = f"{number} ({name}), {system}: {true}{f', altered: {wrong}' if wrong else ''}"
                print(f"{'WRONG ' if failed else ''}{words}, {time.monotonic() - before:.1f} s", flush=True)
    for (system, of, said), count in sorted(counts.items()):
        print(f"{system}, {of}: {said} {count}")
    for system in systems:
        asked = sum(count for (own, of, _), count in counts.items() if (own, of) == (system, "true"))
        if counts[system, "true", "agrees"] < 0.95 * asked:
            print(f"{system}: fewer than 95 % agree")
            failures += 1
    missing = ", ".join(sorted(set(arguments.systems.split(",")) - set(systems)))
    print(f"{failures} failures" + (f"; not installed: {missing}" if missing else ""))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
