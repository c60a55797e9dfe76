"""Poses of a joint vector: each digit, each multiplicity, and that there are no others."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import isqrt
from typing import Any

from rpr_solver.contract import Progress, check_digits
from rpr_solver.errors import InputError
from rpr_solver.verify.angles import cos_sin, pi, radians
from rpr_solver.verify.boxes import Directions, Equations, Pair, zero_near
from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.closure import DEGREE, Closure
from rpr_solver.verify.intervals import Interval
from rpr_solver.verify.lines import direction
from rpr_solver.verify.manipulator import Geometry, exact
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.roots import Root, real_roots
from rpr_solver.verify.surds import ZERO, Poly, Surd
from rpr_solver.verify.system import Monomial, Trig

_ROOT = re.compile(r"sqrt\((.+)\)")
_ANGLES = ("alpha_deg", "theta1_deg", "theta2_deg", "theta3_deg")
_NAMES = (*_ANGLES, "b1_x", "b1_y")
_SPARE_BITS = 64
Vector = tuple[Interval, Interval]


def pose_claims(geometry: Geometry, document: Mapping[str, Any], progress: Progress) -> Iterator[Claim]:
    """The claims of a table of poses.

    Raises:
        InputError: naming a member that cannot be read.
    """
    progress(0, 1)
    squares = tuple(_square(document.get(f"l{leg}"), f"l{leg}") for leg in (1, 2, 3))
    closure = Closure.of(geometry, (squares[0], squares[1], squares[2]))
    yield from _Poses(closure, document).claims()
    progress(1, 1)


def _square(text: Any, field: str) -> Fraction:
    root = _ROOT.fullmatch(text) if isinstance(text, str) else None
    number = exact(root.group(1) if root else text, field)
    if number <= 0:
        raise InputError.of(field, f"is {text}; a leg length must be > 0")
    return number if root else number**2


@dataclass(frozen=True)
class _Listed:
    """A printed pose."""

    numbers: Mapping[str, Printed]
    multiplicity: int

    @classmethod
    def of(cls, pose: Mapping[str, Any], at: str) -> _Listed:
        multiplicity = pose.get("multiplicity")
        if not isinstance(multiplicity, int) or not 1 <= multiplicity <= DEGREE:
            raise InputError.of(f"{at}/multiplicity", "is no multiplicity; it is 1 to 6")
        return cls({name: Printed.of(pose.get(name), f"{at}/{name}") for name in _NAMES}, multiplicity)


class _Poses:
    def __init__(self, closure: Closure, document: Mapping[str, Any]) -> None:
        self.closure = closure
        self.document = document
        listed = document.get("poses")
        if not isinstance(listed, list) or not all(isinstance(pose, Mapping) for pose in listed):
            raise InputError.of("poses", "is not a list of poses")
        self.digits = check_digits(document.get("digits", 15))
        self.poses = [_Listed.of(pose, f"/poses/{n}") for n, pose in enumerate(listed)]
        self.groups: dict[str, list[int]] = {}
        for n, pose in enumerate(self.poses):
            self.groups.setdefault(pose.numbers["alpha_deg"].text, []).append(n)

    @cached_property
    def bits(self) -> int:
        """Bits well below the last printed digit."""
        halves = [x.half for pose in self.poses for x in pose.numbers.values() if x.half]
        least = min(halves, default=Fraction(1))
        sizes = (
            part.bit_length()
            for p in (self.closure.whole, *self.closure.numerators)
            for x in p.values()
            for part in x
        )
        return (least.denominator // least.numerator).bit_length() + max(sizes, default=0) + _SPARE_BITS

    def claims(self) -> Iterator[Claim]:
        yield self._polynomial()
        yield from self._numbers()
        boxes: dict[int, list[Pair]] = {}
        for alpha, members in self.groups.items():
            order = sum(self.poses[n].multiplicity for n in members)
            box = self._angle(alpha, order)
            if box is None:
                reason = f"no root of multiplicity {order} is proved near this angle"
                for n in members:
                    yield self._pose(n, ClaimStatus.REFUSED, reason)
                continue
            boxes.setdefault(order, []).append(box)
            yield from self._above(box, members)
        yield self._curves()
        yield self._complete(boxes)

    def _pose(self, n: int, status: ClaimStatus, reason: str) -> Claim:
        return Claim(f"/poses/{n}", "a pose with these digits and this multiplicity", status, reason)

    def _polynomial(self) -> Claim:
        claim, at = "the sixth-degree polynomial of direct kinematics", "/polynomial"
        polynomial = self.document.get("polynomial")
        try:
            right = isinstance(polynomial, Mapping) and self._proportional(polynomial)
        except (KeyError, TypeError, ValueError):
            right = False
        reason = "it is a multiple of the one derived from the legs" if right else "it is another"
        return Claim(at, claim, ClaimStatus.PROVED if right else ClaimStatus.REFUSED, reason)

    def _proportional(self, polynomial: Mapping[str, Any]) -> bool:
        a = [int(exact(x, "/polynomial")) for x in polynomial["coefficients"]]
        b = [int(exact(x, "/polynomial")) for x in polynomial.get("omega_coefficients", [0] * len(a))]
        omega = _ROOT.fullmatch(polynomial.get("omega", "sqrt(1)"))
        ring = self.closure.ring
        square = Fraction(exact(omega.group(1), "/polynomial") if omega else 0) / ring.radicand
        if not any(b):
            square = Fraction(1)
        k = Fraction(isqrt(square.numerator), isqrt(square.denominator))
        if len(a) != DEGREE + 1 or k * k != square:
            return False
        listed = [(x * k.denominator, y * k.numerator) for x, y in zip(a, b, strict=True)]
        lead = next(i for i, x in enumerate(self.closure.sextic) if x != ZERO)
        mine = self.closure.sextic
        scale: Surd = listed[lead]
        return scale != ZERO and all(
            ring.times(x, scale) == ring.times(y, mine[lead]) for x, y in zip(mine, listed, strict=True)
        )

    def _numbers(self) -> Iterator[Claim]:
        total = sum(pose.multiplicity for pose in self.poses)
        shape = {m: len(part) - 1 for m, part in self.closure.parts.items()}
        listed: dict[int, int] = {}
        factors = self.document.get("certificate", {}).get("factors", [])
        for factor in factors:
            listed[factor["multiplicity"]] = listed.get(factor["multiplicity"], 0) + factor["degree"]
        for at, claim, right in (
            ("/count", "the number of poses", self.document.get("count") == len(self.poses)),
            (
                "/count_with_multiplicity",
                "with multiplicity",
                self.document.get("count_with_multiplicity") == total,
            ),
            ("/certificate/factors", "degrees and multiplicities of the factors", listed == shape),
        ):
            status = ClaimStatus.PROVED if right else ClaimStatus.REFUSED
            yield Claim(at, claim, status, "counted" if right else "it is another")

    def _angle(self, alpha: str, order: int) -> Pair | None:
        """Cosine and sine of a proved α, the root of this multiplicity that rounds to the text."""
        part = self.closure.parts.get(order)
        if part is None:
            return None
        printed = Printed.of(alpha, "alpha_deg")
        equations = Equations.of(_half_angle_form(part), _SINE, self.closure.ring.radicand)
        box = zero_near(equations, printed.value / 2, Fraction(0), self.bits)
        if box is None:
            return None
        whole = box.alpha.scaled(2)
        degrees = whole.scaled(180).over(pi(whole.bits))
        if printed.is_zero:
            return cos_sin(whole) if degrees.contains(0) else None
        return cos_sin(whole) if printed.rounds(degrees, 360) else None

    def _above(self, alpha: Pair, members: Sequence[int]) -> Iterator[Claim]:
        """The poses at one α."""
        points = list(self._points(alpha))
        if len(points) != len(members):
            for n in members:
                yield self._pose(n, ClaimStatus.REFUSED, f"there are {len(points)} poses with this alpha")
            return
        regular = len(points) == 1
        for n in members:
            found = [self._digits(n, point, alpha) for point in points]
            best = min(found, key=lambda finding: finding is not None)
            if best is not None:
                yield self._pose(n, ClaimStatus.REFUSED, f"a digit of {best} is wrong")
            elif regular:
                yield self._pose(
                    n, ClaimStatus.PROVED, "alpha is in a proved box, B1 follows, each digit is right"
                )
            else:
                reason = (
                    "two poses share this alpha, where the linear equations are dependent beyond the digits"
                )
                yield self._pose(n, ClaimStatus.CHECKED, reason)

    def _at(self, alpha: Pair) -> Directions:
        one = Interval.of(1, alpha[0].bits), Interval.of(0, alpha[0].bits)
        return Directions(alpha, one, self.closure.ring.radicand)

    def _points(self, alpha: Pair) -> Iterator[Vector]:
        """The points B1 at one α, scaled."""
        at = self._at(alpha)
        determinant = at.value(self.closure.determinant)
        if determinant.sign:
            x, y = (at.value(n).over(determinant) for n in self.closure.numerators)
            yield x, y
            return
        bits = determinant.bits
        for vector, right in zip(self.closure.vectors, self.closure.right, strict=True):
            vx, vy = (at.value(p) for p in vector)
            norm = vx * vx + vy * vy
            if not norm.sign:
                continue
            # 2 v·X = right: X = foot + w (−vy, vx)
            shift = at.value(right).over(norm.scaled(2))
            square = Interval.of(self.closure.squares[0] * self.closure.unit**2, bits)
            x, y = vx * shift, vy * shift
            rest = (square - x * x - y * y).over(norm)
            if rest.upper < 0:
                return
            if not rest.sign:
                yield x, y
                return
            w = rest.root()
            yield x + w * vy, y - w * vx
            yield x - w * vy, y + w * vx
            return

    def _digits(self, n: int, point: Vector, alpha: Pair) -> str | None:
        """The first printed number of a pose that is wrong for a point, None if all are right."""
        at, numbers = self._at(alpha), self.poses[n].numbers
        vectors = [point]
        for vector in self.closure.vectors:
            vx, vy = (at.value(p) for p in vector)
            vectors.append((point[0] + vx, point[1] + vy))
        for name, leg in zip(_ANGLES[1:], vectors, strict=True):
            if not _points_to(numbers[name], leg):
                return name
        unit = Interval.of(self.closure.unit, alpha[0].bits)
        for name, value in zip(("b1_x", "b1_y"), point, strict=True):
            printed, x = numbers[name], value.over(unit)
            if not (x.contains(0) if printed.is_zero else printed.rounds(x)):
                return name
        lengths = [x for x in numbers.values() if not x.is_zero]
        return next((f"{x.text} (their number)" for x in lengths if x.digits != self.digits), None)

    def _curves(self) -> Claim:
        claim, curves = "the curves of poses", self.document.get("curves", [])
        angles = [str(curve.get("alpha_deg")) for curve in curves]
        mine = ["0" if t == 1 else "180" for t in (1, -1) if self._circle(t)]
        right = angles == mine
        reason = "both linear equations vanish there, and nowhere else" if right else "they are others"
        return Claim("/curves", claim, ClaimStatus.PROVED if right else ClaimStatus.REFUSED, reason)

    def _circle(self, cos: int) -> bool:
        """Whether both linear equations vanish at α = 0 or 180°, which is exact."""
        parts = [p for vector in self.closure.vectors for p in vector] + list(self.closure.right)
        return all(_value_on_axis(p, cos) == ZERO for p in parts)

    def _complete(self, boxes: Mapping[int, Sequence[Pair]]) -> Claim:
        claim = "these are all poses"

        def answer(status: ClaimStatus, reason: str) -> Claim:
            return Claim("/poses", claim, status, reason)

        doubt = False
        for order, part in self.closure.parts.items():
            listed = list(boxes.get(order, ()))
            for root in real_roots(self.closure.ring, part):
                line = self._line(part, root)
                here = [box for box in listed if all(x.meets(y) for x, y in zip(box, line, strict=True))]
                if len(here) > 1:
                    return answer(ClaimStatus.REFUSED, "two listed angles are one root")
                if here:
                    listed.remove(here[0])
                elif self._is_on_curve(line):
                    continue
                elif list(self._points(line)):
                    return answer(
                        ClaimStatus.REFUSED, "a real root of the polynomial has a pose that is not listed"
                    )
                else:
                    doubt = True
            if listed:
                return answer(ClaimStatus.REFUSED, "a listed angle is no root of the polynomial")
        if doubt:
            reason = "at a real root both points B1 are imaginary, the linear equations being dependent there"
            return answer(ClaimStatus.CHECKED, reason)
        return answer(ClaimStatus.PROVED, "each real root, by Descartes' rule of signs, has its listed poses")

    def _line(self, part: Poly, root: Root) -> Pair:
        return direction(self.closure.ring, part, root, self.bits)

    def _is_on_curve(self, line: Pair) -> bool:
        return any(self._circle(c) and line[0].contains(c) and line[1].contains(0) for c in (1, -1))


_SINE: Trig = {(0, 0, 0, 1): (1, 0)}
"""sin θ: the second equation of a problem in one angle."""


def _half_angle_form(part: Poly) -> Trig:
    """Σ p_k sinᵏβ cosⁿ⁻ᵏβ, the form of a polynomial in t = tan β, in normal form."""
    result: dict[Monomial, Surd] = {}
    size = len(part) - 1
    for k, (a, b) in enumerate(part):
        half, sine = divmod(k, 2)
        # sin² = 1 − cos², by the binomial theorem
        weight = 1
        for i in range(half + 1):
            key = (size - k + 2 * i, sine, 0, 0)
            c, d = result.get(key, ZERO)
            result[key] = (c + a * weight, d + b * weight)
            weight = -weight * (half - i) // (i + 1)
    return {key: x for key, x in result.items() if x != ZERO}


def _value_on_axis(p: Trig, cos: int) -> Surd:
    """The value at α = 0 (``cos`` = 1) or 180° (−1), exact."""
    a = sum(x[0] * cos**i for (i, j, _, _), x in p.items() if not j)
    b = sum(x[1] * cos**i for (i, j, _, _), x in p.items() if not j)
    return a, b


def _points_to(printed: Printed, vector: Vector) -> bool:
    """Whether the direction of a vector rounds to a printed angle."""
    bits = vector[0].bits
    cos, sin = cos_sin(radians(printed.value, bits))
    x, y = vector
    if (cos * x + sin * y).sign <= 0:
        return False
    norm = (x * x + y * y).root()
    if not norm.sign:
        return False
    off = (cos * y - sin * x).over(norm).greatest
    # |angle| ≤ |sin| + |sin|³ for small angles
    half = radians(printed.half, bits).lower if printed.half else 1 << 16
    return (off + off**3) * (1 << bits) < half
