"""What answers take beside special shapes, at every distance from them: the table has no cliffs.

    python -m benchmarks.cliffs --machines 600 --seed 1
    python -m benchmarks.cliffs --machines 24 --kind census --kind margin --exponents 16 40
    python -m benchmarks.cliffs --machines 100 --kind census --out census.ndjson
    python -m benchmarks.cliffs --pooled *.ndjson

Machines are drawn from twelve special shapes × distances × orders of the corners × spellings (three sides
of either triangle, roots among them, one of them changed by 10^-exponent of itself; or the article's six
numbers, rounded to so many digits). Each is asked one kind of question, about a random leg, mostly at a
random length, else at one that is special. Every question is computed in a process of its own, which ends
after 12 seconds of processor time.

Prints a line for each answer that takes more than 3 seconds, differs from its estimate by more than a
factor of 4, is cut, fails, or does not say which special shape is near, with its question as an item of a
batch (`benchmarks.cost --again`). Then the table of shapes and kinds: the median and the longest of the
times. Then for each kind how many took long, were refused, do not say what is near, or have an estimate
within a factor of 4; and the refusals.
"""

from __future__ import annotations

import argparse
import json
import statistics
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from math import isqrt
from pathlib import Path
from random import Random
from typing import Any

from benchmarks.cost import LEAST, measured, read, valkey
from rpr_solver import Manipulator, cusp_table, poses
from rpr_solver.contract import LENGTHS
from rpr_solver.errors import InputError, SolverError
from rpr_solver.exact.rationals import exact_str
from rpr_solver.triangles import CommonFrame
from rpr_solver.triangles.near import own_shapes
from worker.process.horse import load_solver

KINDS = (
    "census",
    "margin",
    "assembly-modes",
    "cusp-curves",
    "check",
    "path",
    "singular-curves",
    "design",
)
EXPONENTS = (1, 3, 6, 9, 12, 14, 16, 20, 25, 30, 40)
LIMIT, LONG = 12.0, 3.0
"""Seconds of processor time: of the process, and what is long."""
_NEAR = 4
"""By which factor a time may differ from its estimate."""
Squares = tuple[Fraction, Fraction, Fraction]
"""The squared sides of a triangle, |12|, |23| and |31|."""


@dataclass(frozen=True)
class Drawn:
    """A machine of a special shape: squared sides, and whether the platform has the sense of the base."""

    base: Squares
    platform: Squares
    turned: bool = False


@dataclass(frozen=True)
class Shape:
    """A special shape.

    Attributes:
        draw: a machine that has it.
        near: the name by which a document says that it is near, if it says so.
    """

    draw: Callable[[Random], Drawn]
    near: str | None = None


def _squares(*sides: Fraction) -> Squares:
    a, b, c = (side * side for side in sides)
    return a, b, c


def _number(rng: Random) -> Fraction:
    return Fraction(rng.randint(20, 240), rng.choice((10, 10, 5, 3)))


def _triangle(rng: Random) -> Squares:
    """Rational sides, or the corners of a lattice, whose sides are roots."""
    if rng.random() < 0.3:
        (x, y), z = (rng.randint(1, 12), rng.randint(1, 12)), rng.randint(2, 14)
        return Fraction(z * z), Fraction((x - z) ** 2 + y * y), Fraction(x * x + y * y)
    a, b = _number(rng), _number(rng)
    return _squares(a, b, abs(a - b) + min(a, b) * Fraction(rng.randint(4, 16), 10))


def _times(squares: Squares, factor: Fraction) -> Squares:
    a, b, c = (square * factor for square in squares)
    return a, b, c


def _flat(rng: Random) -> Squares:
    a, b = _number(rng), _number(rng)
    return _squares(*rng.sample((a, b, a + b), 3))


def _similar(rng: Random) -> Drawn:
    base, factor = _triangle(rng), _number(rng) / 10
    return Drawn(base, _times(base, factor if rng.random() < 0.3 else factor * factor))


def _congruent(rng: Random) -> Drawn:
    base = _triangle(rng)
    return Drawn(base, base)


def _mirrored(drawn: Drawn) -> Drawn:
    return Drawn(drawn.base, drawn.platform, turned=True)


def _permuted(rng: Random) -> Drawn:
    base = _triangle(rng)
    a, b, c = rng.choice(((0, 2, 1), (1, 2, 0), (2, 0, 1), (2, 1, 0), (1, 0, 2)))
    return Drawn(base, (base[a], base[b], base[c]), rng.random() < 0.5)


def _isosceles(rng: Random) -> Drawn:
    a, b, c, d = (_number(rng) for _ in range(4))
    base, platform = _squares(min(a, 2 * b - Fraction(1, 7)), b, b), _squares(min(c, d), d, d)
    turn = rng.randrange(3)
    return Drawn(base, (platform[turn], platform[turn - 2], platform[turn - 1]), rng.random() < 0.5)


def _equilateral(rng: Random) -> Drawn:
    base, platform = (Fraction(rng.randint(1, 30)) * rng.choice((1, 3, 4, 9)) for _ in range(2))
    return Drawn((base, base, base), (platform, platform, platform), rng.random() < 0.2)


def _right_isosceles(rng: Random) -> Drawn:
    base, platform = (Fraction(rng.randint(1, 30)) * rng.choice((1, 2, 4, 9)) for _ in range(2))
    return Drawn((base, base, 2 * base), (platform, platform, 2 * platform), rng.random() < 0.2)


def _right(rng: Random) -> Drawn:
    a, b, c, d = (_number(rng) for _ in range(4))
    return Drawn((a * a, b * b, a * a + b * b), (c * c, d * d, c * c + d * d), rng.random() < 0.5)


SHAPES = {
    "similar": Shape(_similar, "similar"),
    "similar, mirrored": Shape(lambda rng: _mirrored(_similar(rng))),
    "congruent": Shape(_congruent, "congruent"),
    "congruent, mirrored": Shape(lambda rng: _mirrored(_congruent(rng)), "mirrored"),
    "sides permuted": Shape(_permuted),
    "flat base": Shape(lambda rng: Drawn(_flat(rng), _triangle(rng)), "flat"),
    "flat platform": Shape(lambda rng: Drawn(_triangle(rng), _flat(rng)), "flat"),
    "both flat": Shape(lambda rng: Drawn(_flat(rng), _flat(rng)), "flat"),
    "isosceles": Shape(_isosceles, "isosceles"),
    "equilateral pair": Shape(_equilateral, "equilateral"),
    "right isosceles pair": Shape(_right_isosceles, "right isosceles"),
    "right angles": Shape(_right),
}


def _decimal_root(square: Fraction, digits: int) -> Fraction:
    """A root, rounded to about so many significant digits."""
    places = digits + 4
    root = Fraction(isqrt(square.numerator * 10 ** (2 * places) // square.denominator), 10**places)
    size = len(str(int(root))) if root >= 1 else 0
    return round(root, max(digits - size, 1))


def _by_sides(rng: Random, drawn: Drawn, exponent: int) -> dict[str, Any]:
    """One of the six sides changed."""
    squares, changed = [*drawn.base, *drawn.platform], rng.randrange(6)
    squares[changed] *= (1 + Fraction(rng.choice((-1, 1)), 10**exponent)) ** 2
    sides = [_side(square) for square in squares]
    turn = {"orientation": "cw"} if drawn.turned else {}
    return {"base": {"sides": sides[:3]}, "platform": {"sides": sides[3:]}, **turn}


def _side(square: Fraction) -> str:
    root = Fraction(isqrt(square.numerator), isqrt(square.denominator))
    if root * root == square:
        return exact_str(root)
    above, below = square.numerator * square.denominator, square.denominator
    return f"sqrt({above})/{below}" if below > 1 else f"sqrt({above})"


def _by_six(drawn: Drawn, exponent: int) -> dict[str, Any]:
    """Six numbers, rounded."""
    a, b, c = drawn.base
    across, up = (a + c - b) / 2, c - (a + c - b) ** 2 / (4 * a)
    # A3x = (A1A2 · A1A3) / |A1A2|
    a3x = _decimal_root(across * across / a, exponent) * (1 if across > 0 else -1)
    numbers = [_decimal_root(a, exponent), a3x, _decimal_root(up, exponent)]
    numbers += [_decimal_root(square, exponent) for square in drawn.platform]
    texts = dict(zip(LENGTHS, map(exact_str, numbers), strict=True))
    return {**texts, "orientation": "cw" if drawn.turned else "ccw"}


def machine(rng: Random, shape: Shape, exponent: int) -> tuple[dict[str, Any], Manipulator]:
    """A machine beside a shape, in any order of its corners and either spelling."""
    while True:
        drawn, turn, back = shape.draw(rng), rng.randrange(3), rng.random() < 0.5
        base, platform = (
            (squares[turn], squares[turn - 2], squares[turn - 1]) for squares in (drawn.base, drawn.platform)
        )
        if back:
            base, platform = base[::-1], platform[::-1]
        ordered = Drawn(base, platform, drawn.turned)
        spelled = (
            _by_six(ordered, exponent)
            if exponent > 1 and rng.random() < 0.5
            else _by_sides(rng, ordered, exponent)
        )
        try:
            one = Manipulator.from_json(spelled)
            CommonFrame.of(one.geometry)
        except InputError:  # no triangles, or no coordinates over one field
            continue
        return spelled, one


def question(rng: Random, kind: str, spelled: dict[str, Any], one: Manipulator) -> dict[str, Any] | None:
    """A question of a kind about a machine; None if it cannot be asked."""
    leg = rng.choice((1, 2, 3))
    sides = [Fraction(side) for side in one.doubles() if side]
    size = sum(map(abs, sides), Fraction(0)) / len(sides)
    length = round(size * Fraction(rng.randint(20, 260), 100), 2)
    if rng.random() < 0.3:
        length = round(abs(rng.choice(sides) + rng.choice((-1, 0, 1)) * rng.choice(sides)), 6) or length
    at = {f"l{leg}": exact_str(length), "fixed_leg": leg}
    body: dict[str, Any] = {"geometry": spelled}
    span = {"from": exact_str(length), "to": exact_str(2 * length)}
    requirement = {"range": span, "max_cusps": rng.choice((0, 2, 4)), "fixed_leg": leg}
    match kind:
        case "census":
            return {**body, "fixed_leg": leg}
        case "cusp-curves":
            return {**body, "fixed_leg": leg, "digits": 15, "range": span}
        case "check":
            return {**body, "requirement": requirement}
        case "design":
            wanted = {"objective": "longest-range", "vary": "5%", "budget": {"censuses": 3}}
            return {**body, **wanted, "requirement": requirement}
        case "path":
            return _path(rng, body, one, leg, length)
        case _:
            return {**body, **at}


def _path(
    rng: Random, body: dict[str, Any], one: Manipulator, leg: int, length: Fraction
) -> dict[str, Any] | None:
    """A loop round a cusp, or a path from pose to pose."""
    try:
        [table] = cusp_table(one, length, fixed_leg=leg, digits=15)
    except SolverError:
        return None
    if table.cusps and rng.random() < 0.5:
        return {**body, f"l{leg}": exact_str(length), "fixed_leg": leg, "cusp": "A", "samples": 21}
    for _ in range(40):
        lengths = [length * Fraction(rng.randint(60, 140), 100) for _ in range(3)]
        lengths[leg - 1] = length
        if len(poses(one, *lengths, digits=15).poses) > 1:
            legs = {f"l{n}": exact_str(x) for n, x in enumerate(lengths, 1)}
            return {**body, **legs, "fixed_leg": leg, "from": 1, "to": 2, "samples": 21}
    return None


def _says(shape: Shape, exponent: int, one: Manipulator, document: dict[str, Any]) -> bool:
    """Whether a document says how near the shape is, unless the machine has it."""
    if exponent < 8 or shape.near is None:
        return True
    if shape.near in {name for name, _ in own_shapes(one.geometry)}:
        return True
    return any(
        near["shape"] == shape.near and float(near["distance"]) < 10.0 ** (4 - exponent)
        for near in document.get("near", ())
    )


@dataclass(frozen=True)
class Answer:
    """What one question took: a line of a file.

    Attributes:
        shape, exponent: beside what, and the distance.
        kind, request: the question.
        taken, estimate: seconds.
        ended: how it ended, as :func:`benchmarks.cost.measured` says, with the reason of a refusal.
        says: whether it says which special shape is near.
    """

    shape: str
    exponent: int
    kind: str
    taken: float
    estimate: float
    ended: str
    says: bool
    request: dict[str, Any]

    @property
    def ratio(self) -> float:
        """Of the time and its estimate."""
        return max(self.taken, LEAST) / self.estimate

    @property
    def is_priced(self) -> bool:
        """Whether the estimate is right within a factor; what is refused early takes as little as it can."""
        return self.ratio < _NEAR and (self.ratio > 1 / _NEAR or self.ended != "answered")

    def __str__(self) -> str:
        remark = "" if self.says else " (does not say what is near)"
        item = json.dumps({"kind": self.kind, "request": self.request})
        times = f"{self.taken:6.2f} s for {self.estimate:.2f}"
        return f"{times}: {self.shape}, 1e-{self.exponent}, {self.ended}{remark}: {item}"


def ask(rng: Random, name: str, kind: str, exponents: Sequence[int], url: str) -> Answer:
    """Ask a random question of a kind beside a shape."""
    request = None
    while request is None:
        exponent = rng.choice(exponents)
        spelled, one = machine(rng, SHAPES[name], exponent)
        body = question(rng, kind, spelled, one)
        # the service refuses what would cost too much
        request = None if body is None else read(kind, body)
    taken, ended, document = measured(request, url, LIMIT)
    says = document is None or _says(SHAPES[name], exponent, one, document)
    estimate = max(request.cost.whole, LEAST)
    return Answer(name, exponent, kind, taken, estimate, ended, says, request=body or {})


def report(answers: Sequence[Answer]) -> None:
    """Print the tables."""
    names = [name for name in SHAPES if any(one.shape == name for one in answers)]
    kinds = [kind for kind in KINDS if any(one.kind == kind for one in answers)]
    print("\nmedian and longest, in seconds")
    print(" " * 22 + "".join(f"{kind:>16}" for kind in kinds))
    for name in names:
        cells = ([x.taken for x in answers if (x.shape, x.kind) == (name, kind)] for kind in kinds)
        row = (f"{statistics.median(x):8.2f}{max(x):8.2f}" if x else " " * 16 for x in cells)
        print(f"{name:22}" + "".join(row))
    heads = ("number", "median", "longest", f"> {LONG:g} s", "> 10 s", "refused", "near missed", "priced")
    print("\n" + " " * 16 + "".join(f"{head:>12}" for head in heads))
    for kind in kinds:
        own = [x for x in answers if x.kind == kind]
        times = [x.taken for x in own]
        counts = (
            sum(x > LONG for x in times),
            sum(x > 10 for x in times),
            sum(x.ended != "answered" for x in own),
            sum(not x.says for x in own),
            sum(x.is_priced for x in own),
        )
        figures = f"{len(own):12}{statistics.median(times):12.2f}{max(times):12.2f}"
        print(f"{kind:16}{figures}" + "".join(f"{count:12}" for count in counts))
    for (kind, ended), count in sorted(Counter((x.kind, x.ended) for x in answers).items()):
        if ended != "answered":
            print(f"{kind}: {count} {ended}")


def main() -> None:
    """Ask, and print what takes long and the table."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--machines", type=int, default=600)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", action="append", choices=KINDS, help="only this kind; may be given again")
    parser.add_argument(
        "--shape", action="append", choices=SHAPES, help="only this shape; may be given again"
    )
    parser.add_argument("--exponents", type=int, nargs="+", default=EXPONENTS)
    parser.add_argument("--out", type=Path, help="a file to which each answer is added, a line each")
    parser.add_argument("--pooled", type=Path, nargs="+", help="print the tables of such files only")
    options = parser.parse_args()
    if options.pooled:
        lines = [line for path in options.pooled for line in path.read_text().splitlines()]
        answers = [Answer(**json.loads(line)) for line in lines]
        for one in answers:
            if one.taken > LONG or not one.says or not one.is_priced:
                print(one)
        report(answers)
        return
    load_solver()
    rng, answers = Random(options.seed), []
    names, kinds = options.shape or list(SHAPES), options.kind or KINDS
    with valkey() as url:
        for number in range(options.machines):
            name, kind = names[number % len(names)], kinds[number // len(names) % len(kinds)]
            one = ask(rng, name, kind, options.exponents, url)
            answers.append(one)
            if options.out is not None:
                with options.out.open("a") as file:
                    file.write(json.dumps(asdict(one)) + "\n")
            if one.taken > LONG or one.ended != "answered" or not one.says or not one.is_priced:
                print(one, flush=True)
    report(answers)


if __name__ == "__main__":
    main()
