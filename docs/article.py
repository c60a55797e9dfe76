"""Writes the parts of docs/article.md that hold figures, from proved computation.

python docs/article.py                  rewrite every part (ten seconds)
python docs/article.py --check [PART]   write nothing; exit 1 if a part is out of date

A part stands between ``<!-- name -->`` and ``<!-- end -->``.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from decimal import ROUND_DOWN, Decimal
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

from rpr_solver import EXAMPLES, Census, Manipulator, SliceTable, article_table, census, cusp_table

FILE = Path(__file__).with_name("article.md")
FIRST, SECOND = "innocenti", "zein-flat"
NAMES = {FIRST: "first", SECOND: "second"}

PRINTED: Mapping[tuple[str, str], Sequence[Sequence[str]]] = {
    key: [row.split() for row in rows.strip().splitlines()]
    for key, rows in {
        (FIRST, "14.98"): """
            50.67    -69.12   0.84  3.77
            -2.59    177.32  13.85  6.26
            -122.89  114.05  31.27 16.17
            57.48    133.77  30.44 26.61
            -0.59     15.46  16.02 29.56
            170.37   -10.65  17.98 26.44""",
        (FIRST, "34"): """
            -3.84   -167.01  33.22 19.00
            52.71    -61.76  19.46 22.68
            -1.07     15.43  35.00 48.64
            55.85    128.19  49.14 45.52""",
        (FIRST, "27"): """
            -0.95     15.47  28.01 41.63
            56.20    129.36  42.21 38.54
            -5.11   -168.45  26.31 11.84
            52.23    -63.22  12.56 15.71
            -168.17    8.70   5.92 29.74
            -125.54   43.86   7.98 27.36
            -113.95   63.88  13.96 21.66
            -129.36  103.65  35.57  4.80""",
        (SECOND, "3"): """
            12.52   -145.11  19.80 29.43
            156.76   -63.48  40.68 31.11
            -168.74   26.38  40.08 29.14
            -20.32   114.01  19.11 27.01""",
    }.items()
}
"""Tables 1 to 4 of the article: manipulator and L1 → α, θ1, L2, L3 of the cusps A, B, …"""

CLAIMED = {FIRST: 8, SECOND: 6}
"""The greatest numbers of cusps, as the article has them."""

FEW = {
    "base and platform flat": Manipulator(20, 6, 0, 7, 9, 16),
    "similar triangles": Manipulator(30, 0, 40, 15, 25, 20),
    "congruent triangles": Manipulator(30, 0, 40, 30, 50, 40),
    "A2 = (53, 0), A3 = (9, 34), d = 1, 1, 2": Manipulator(53, 9, 34, 1, 1, 2),
}
"""Manipulators with few cusps at all lengths."""


@cache
def slice_of(name: str, l1: str) -> SliceTable:
    """The table of a slice of a built-in manipulator."""
    return cusp_table(EXAMPLES[name], l1, digits=15)[0]


@cache
def census_of(name: str) -> Census:
    """The census of leg 1 of a built-in manipulator."""
    return census(EXAMPLES[name], digits=15)


@cache
def audit_of(name: str, l1: str) -> Mapping[str, Any]:
    """The audit of the article's own algorithm in a slice."""
    return article_table(EXAMPLES[name], l1, digits=15).audit


def cut(text: str) -> str:
    """A decimal without its digits after the second place.

    >>> cut("12.6528073"), cut("-0.598556")
    ('12.65', '-0.59')
    """
    return str(Decimal(text).quantize(Decimal("0.01"), ROUND_DOWN))


def rounded(text: str) -> str:
    """A decimal rounded to two places."""
    return str(Decimal(text).quantize(Decimal("0.01")))


def compared(name: str, l1: str) -> Iterator[tuple[Sequence[str], Sequence[str]]]:
    """Each row of a table of the article, with the cusp of the proved table that is nearest in θ1."""
    for row in PRINTED[name, l1]:
        theta = Decimal(row[1])
        cusp = min(slice_of(name, l1).cusps, key=lambda cusp: abs(Decimal(cusp.theta1_deg) - theta))
        yield row, cusp.coordinates


def tables() -> Iterator[str]:
    """The four tables, each number above the proved one."""
    for number, (name, l1) in enumerate(PRINTED, 1):
        yield f"Table {number}, the {NAMES[name]} manipulator at L1 = {l1}:"
        yield ""
        yield "| cusp | | α | θ1 | L2 | L3 |"
        yield "|---|---|---|---|---|---|"
        for k, (printed, proved) in enumerate(compared(name, l1)):
            cells = [a if a == cut(b) else f"**{a}**" for a, b in zip(printed, proved, strict=True)]
            yield f"| {'ABCDEFGH'[k]} | printed | {' | '.join(cells)} |"
            yield f"| | proved | {' | '.join(text[: text.index('.') + 9] for text in proved)} |"
        yield ""
    pairs = [pair for key in PRINTED for rows in compared(*key) for pair in zip(*rows, strict=True)]
    same, near = (sum(a == short(b) for a, b in pairs) for short in (cut, rounded))
    yield (
        f"Of the {len(pairs)} printed numbers {same} are the proved ones cut after the second place, "
        f"{near} the rounded ones: the article cut its digits. {len(pairs) - same} is wrong, in bold."
    )


def counts() -> Iterator[str]:
    """Every number of cusps of both manipulators, for all L1."""
    for name, which in NAMES.items():
        yield f"The {which} manipulator:"
        yield ""
        yield from intervals_of(name)
        yield ""


def eighteen() -> Iterator[str]:
    """Every number of cusps of the manipulator with eighteen."""
    yield from intervals_of("eighteen-cusps")


def intervals_of(name: str) -> Iterator[str]:
    """The census of a built-in manipulator as a table."""
    yield "| L1 from | to | cusps | transition at the end |"
    yield "|---|---|---|---|"
    for row in census_of(name).rows():
        stop, kind = row["to_text"] or "∞", row["transition_at_end"] or ""
        yield f"| {row['from_text']} | {stop} | {row['count']} | {kind} |"


def count_at(table: Census, length: Fraction) -> int:
    """The number of cusps of a slice that is no transition."""
    return table.counts[sum(Fraction(t.length) < length for t in table.transitions)]


def scan() -> Iterator[str]:
    """The slices of the article's scan, by their numbers of cusps."""
    lengths = [Fraction(n, 10) for n in range(1, 501)]
    found = {name: Counter(count_at(census_of(name), x) for x in lengths) for name in NAMES}
    numbers = sorted({n for counter in found.values() for n in counter})
    yield f"| slices of the scan with | {' | '.join(f'{n} cusps' for n in numbers)} |"
    yield f"|---|{'---|' * len(numbers)}"
    for name, which in NAMES.items():
        yield f"| the {which} manipulator | {' | '.join(str(found[name][n] or '–') for n in numbers)} |"
    for name, claimed in CLAIMED.items():
        more = [row for row in census_of(name).rows() if row["count"] > claimed]
        met = sum(any(row["from"] < x < row["to"] for x in lengths) for row in more)
        yield ""
        yield (
            f"The {NAMES[name]} manipulator has more than {claimed} cusps in {len(more)} "
            f"{'interval' if len(more) == 1 else 'intervals'}; the scan meets {met}."
        )


def maxima() -> Iterator[str]:
    """The greatest numbers of cusps with leg 1 fixed, and where they occur."""
    yield "| built-in manipulator | greatest number of cusps | L1 from | to | width |"
    yield "|---|---|---|---|---|"
    for name in EXAMPLES:
        table = census_of(name)
        most = max(table.counts)
        for row in table.rows():
            if row["count"] == most:
                low, high = Decimal(row["from_text"]), Decimal(row["to_text"])
                yield f"| `{name}` | {most} | {low} | {high} | {high - low:.2g} |"


def few() -> Iterator[str]:
    """The greatest numbers of cusps of these, whichever leg is fixed."""
    yield "| manipulator | most cusps with leg 1, 2, 3 fixed | degenerate, with leg 1 fixed |"
    yield "|---|---|---|"
    for what, m in FEW.items():
        found = [census(m, fixed_leg=leg, digits=15) for leg in (1, 2, 3)]
        most = ", ".join(str(max(table.counts)) for table in found)
        degenerate = "; ".join(repr(part)[12:-1] for part in found[0].degenerate)
        yield f"| {what} | {most} | {degenerate or '–'} |"


def factors() -> Iterator[str]:
    """The eliminant of degree 96 of the first slice, factor by factor."""
    audit = audit_of(FIRST, "14.98")
    yield "| degree | power | zeros | real roots | couples kept | rejected |"
    yield "|---|---|---|---|---|---|"
    for part in audit["factors"]:
        verdicts = Counter(couple["verdict"] for couple in part["couples"])
        origin = part["origin"].replace("|", r"\|")
        numbers = part["real_roots"], verdicts["kept"] or "–", verdicts["rejected"] or "–"
        yield f"| {part['degree']} | {part['multiplicity']} | {origin} | {' | '.join(map(str, numbers))} |"
    terms = " + ".join(f"{part['degree']}·{part['multiplicity']}" for part in audit["factors"])
    yield ""
    yield f"{terms} = {sum(part['degree'] * part['multiplicity'] for part in audit['factors'])}."


def conjecture() -> Iterator[str]:
    """The couples of all four slices, by factor."""
    yield "| slice | real roots of Q | cusps above | couples above other factors | cusps among these |"
    yield "|---|---|---|---|---|"
    for name, l1 in PRINTED:
        *others, q = audit_of(name, l1)["factors"]
        assert q["origin"] == "Q"
        kept = sum(couple["verdict"] == "kept" for couple in q["couples"])
        couples = [couple for part in others for couple in part["couples"]]
        wrong = sum(couple["verdict"] == "kept" for couple in couples)
        roots = q["real_roots"]
        yield f"| {NAMES[name]} manipulator, L1 = {l1} | {roots} | {kept} | {len(couples)} | {wrong} |"


PARTS: Mapping[str, Callable[[], Iterable[str]]] = {
    "tables": tables,
    "counts": counts,
    "scan": scan,
    "maxima": maxima,
    "eighteen": eighteen,
    "few": few,
    "factors": factors,
    "conjecture": conjecture,
}


def written(text: str, names: Iterable[str]) -> str:
    """The page with some parts written anew.

    Raises:
        ValueError: the page has no place for a part.
    """
    for name in names:
        part = "\n".join(PARTS[name]()).strip()
        place = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end -->\n)", re.DOTALL)
        if not place.search(text):
            raise ValueError(f"{FILE.name} has no place for {name}")
        text = place.sub(lambda found, part=part: f"{found[1]}{part}\n{found[2]}", text)
    return text


def main(arguments: list[str] | None = None) -> int:
    """Write or check the page; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("part", nargs="*", choices=[*PARTS, []], help=argparse.SUPPRESS)
    parser.add_argument("--check", action="store_true", help="only compare")
    chosen = parser.parse_args(arguments)
    before = FILE.read_text(encoding="utf-8")
    after = written(before, chosen.part or PARTS)
    if not chosen.check:
        FILE.write_text(after, encoding="utf-8")
    elif after != before:
        print("docs/article.md is out of date: run `python docs/article.py`", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
