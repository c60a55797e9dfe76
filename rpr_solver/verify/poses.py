"""Poses of a joint vector: all are found anew, and each printed one must be another of them.

With B1 = X, v₂ = R(α) b₂ − A2 and v₃ likewise, the legs are |X|² = s₁, |X + v₂|² = s₂, |X + v₃|² = s₃. The
differences are linear in X, so X = n / det; then |n|² = s₁ det², of degree 3 in cos α and sin α, holds at
every pose. SymPy expands the squares. Lengths are multiplied by ``unit``, squares by its square.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from typing import Any

from rpr_solver.contract import Progress
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, finding, judged, matching, worked
from rpr_solver.verify.core.intervals import Interval, degrees
from rpr_solver.verify.core.krawczyk import Directions, Pair, direction, enclosed
from rpr_solver.verify.core.numbers import HALF_WAY, Geometry, bits_of, first_wrong
from rpr_solver.verify.core.reader import Record, spend
from rpr_solver.verify.core.roots import Root, formal_parts, has_root, real_roots
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.surds import ZERO, Poly, Ring, Surd, negative, plus, primitive
from rpr_solver.verify.core.system import Trig, in_half_tangent, longest, normal_form, variables
from rpr_solver.verify.permanent import Field
from rpr_solver.verify.tables import form_of, proportional, sorted_turns

DEGREE = 6
_ANGLES = ("theta1_deg", "theta2_deg", "theta3_deg")
_NAMES = ("alpha_deg", *_ANGLES, "b1_x", "b1_y")
_SPARE_BITS = 64
Vector = tuple[Interval, Interval]


@dataclass(frozen=True)
class Found:
    """A pose above a real root of the polynomial, computed independently.

    Attributes:
        order: the multiplicity of the root.
        part: the factor of the polynomial with the root.
        root: the root.
        alpha: cosine and sine of α.
        side: at α = 0 or 180°, if the linear equations are dependent, on which side of the line's foot B1 is.
        point: B1, scaled.
        multiplicity: of the pose; None if that is open.
        regular: whether the linear equations alone give B1.
    """

    order: int
    part: Poly
    root: Root
    alpha: Pair
    side: int
    point: Vector
    multiplicity: int | None
    regular: bool


@dataclass(frozen=True)
class Closure:
    """The closure equations, as trigonometric polynomials in α.

    Attributes:
        vectors: v₂ and v₃, by their components.
        right: the right hand sides of 2 vᵢ · X = rightᵢ.
        determinant: det = 4 v₂ × v₃.
        numerators: n = det · X.
        whole: |n|² − s₁ det².
        upright: the y-components of the legs, times det.
    """

    geometry: Geometry
    squares: tuple[Fraction, Fraction, Fraction]
    unit: int
    ring: Ring
    vectors: tuple[tuple[Trig, Trig], tuple[Trig, Trig]]
    right: tuple[Trig, Trig]
    determinant: Trig
    numerators: tuple[Trig, Trig]
    whole: Trig
    upright: tuple[Trig, Trig, Trig]

    @classmethod
    def of(cls, geometry: Geometry, squares: tuple[Fraction, Fraction, Fraction]) -> Closure:
        """Derives the equations from squared lengths in the user's unit."""
        spend(10_000, 4 * geometry.bits)
        symbols = variables(geometry, squares)
        (ca, sa), unit = symbols.alpha, symbols.unit
        x, y = symbols.theta  # used as the unknown B1
        scaled = [int(square * unit**2) for square in squares]
        vectors, lines = [], []
        for leg in (2, 3):
            (mx, my), (ax, ay) = symbols.platform[leg - 1], symbols.base[leg - 1]
            v = ca * mx - sa * my - ax, sa * mx + ca * my - ay
            difference = (x + v[0]) ** 2 + (y + v[1]) ** 2 - x**2 - y**2
            constant = difference.subs([(x, 0), (y, 0)]) - (scaled[leg - 1] - scaled[0])
            lines.append((difference.diff(x), difference.diff(y), -constant))
            vectors.append(v)
        (a, b, e), (c, d, f) = lines
        determinant, n = a * d - b * c, (e * d - f * b, f * a - e * c)
        whole = n[0] ** 2 + n[1] ** 2 - scaled[0] * determinant**2

        def trig(p: Any) -> Trig:
            return normal_form(symbols, p)

        return cls(
            geometry,
            squares,
            unit,
            Ring(symbols.radicand),
            ((trig(vectors[0][0]), trig(vectors[0][1])), (trig(vectors[1][0]), trig(vectors[1][1]))),
            (trig(e), trig(f)),
            trig(determinant),
            (trig(n[0]), trig(n[1])),
            trig(whole),
            (trig(n[1]), *(trig(n[1] + v[1] * determinant) for v in vectors)),  # type: ignore[arg-type]
        )

    @cached_property
    def sextic(self) -> tuple[Surd, ...]:
        """The form of degree 6 in t = tan(α/2), primitive: seven coefficients."""
        row = in_half_tangent(self.whole, DEGREE // 2, lambda _k, _m: 1)
        short = primitive(row)
        return short + ((0, 0),) * (DEGREE + 1 - len(short))

    @cached_property
    def parts(self) -> dict[int, Poly]:
        """Multiplicity → the form of the roots with it, a root at α = 180° as a leading zero."""
        return formal_parts(self.ring, self.sextic)

    @cached_property
    def roots(self) -> list[tuple[int, Poly, Root, bool]]:
        """Order, form and root of each angle α of poses, and whether the linear equations give one pose."""
        ring, flat = self.ring, _on_half_tangents(self.determinant)
        return [
            (order, part, root, not has_root(ring, part, root, flat))
            for order, part in self.parts.items()
            for root in real_roots(ring, part)
            if not _is_undirected(self, root)  # the poses there are a whole curve, or none
        ]

    def found(self, bits: int) -> tuple[list[Found], str]:
        """All poses but those on curves, and what is open about their number."""
        found, doubt = [], ""
        for order, part, root, regular in self.roots:
            alpha = direction(self.ring, part, root, bits)
            points = list(self._points(alpha, regular, root.axis))
            if None in points:
                doubt = "above a root where the linear equations are dependent two points may be one"
            multiplicity = order if len(points) == 1 else 1 if order == 2 else None
            if None in points:
                multiplicity = None
            found += [Found(order, part, root, alpha, *x, multiplicity, regular) for x in points if x]
        return found, doubt

    def values(self, found: Found, fine: int) -> dict[str, Interval]:
        """The numbers of a pose by their names, angles in degrees, to ``fine`` bits."""
        at, (x, y), unit = self.at(found.alpha), found.point, Interval.of(self.unit, found.alpha[0].bits)
        legs = [found.point, *((x + at.value(p), y + at.value(q)) for p, q in self.vectors)]
        angles = (degrees(enclosed(vector, fine)) for vector in (found.alpha, *legs))
        return dict(zip(_NAMES, (*angles, x.over(unit), y.over(unit)), strict=True))

    def vanishes(self, found: Found, name: str) -> bool:
        """Whether a number of a pose, which may be 0, is 0 exactly; True if that is open."""
        if name == "alpha_deg":
            return found.root.axis == 1
        if not found.regular and found.root.axis:
            return self._vanishes_on_axis(found, name)
        own = dict(zip(_NAMES[1:], (*self.upright, *self.numerators), strict=True))[name]
        return not found.regular or has_root(self.ring, found.part, found.root, _on_half_tangents(own))

    def at(self, alpha: Pair) -> Directions:
        """A direction α, to evaluate functions of it at."""
        one = Interval.of(1, alpha[0].bits), Interval.of(0, alpha[0].bits)
        return Directions(alpha, one, self.ring.radicand)

    def _line(self, cos: int) -> int:
        """The number of the first vector that is not 0 at α = 0 or 180°, exactly."""
        return 0 if any(_value_on_axis(p, cos) != ZERO for p in self.vectors[0]) else 1

    def _on_axis(self, cos: int) -> tuple[Surd, Surd, Surd, Surd, Surd]:
        """At α = 0 or 180° v of the line 2 v·X = r, r, |v|², and κ² with 2 |v|² X = r v ± κ (−v_y, v_x)."""
        times, k = self.ring.times, self._line(cos)
        x, y, r = (_value_on_axis(p, cos) for p in (*self.vectors[k], self.right[k]))
        norm = plus(times(x, x), times(y, y))
        reach = times((int(4 * self.squares[0] * self.unit**2), 0), norm)
        return x, y, r, norm, plus(reach, negative(times(r, r)))

    def _vanishes_on_axis(self, found: Found, name: str) -> bool:
        """Whether a number of a pose on the line of dependent equations at α = 0 or 180° is 0."""
        cos, times = found.root.axis, self.ring.times
        x, y, r, norm, square = self._on_axis(cos)
        if name == "b1_x":
            number = times(r, x), times((-found.side, 0), y)
        else:
            leg = _ANGLES.index(name) if name in _ANGLES else 0
            beyond = _value_on_axis(self.vectors[leg - 1][1], cos) if leg else ZERO
            number = plus(times(r, y), times((2, 0), times(norm, beyond))), times((found.side, 0), x)
        return not Field(self.ring, square).sign(number)

    def _points(self, alpha: Pair, regular: bool, cos: int) -> Iterator[tuple[int, Vector] | None]:
        """The points B1 at one α, scaled, each with its side; with None if they are not separated.

        ``cos`` is that of α if this is exactly 0 or 180°, else 0.
        """
        at = self.at(alpha)
        if regular:
            determinant = at.value(self.determinant)
            if not determinant.sign:
                yield None
                return
            x, y = (at.value(n).over(determinant) for n in self.numerators)
            yield 0, (x, y)
            return
        bits = at.bits
        for k, (vector, right) in enumerate(zip(self.vectors, self.right, strict=True)):
            if cos and k != self._line(cos):
                continue
            vx, vy = (at.value(p) for p in vector)
            norm = vx * vx + vy * vy
            if not norm.sign:
                continue
            # 2 v·X = right: X = foot + w (−vy, vx)
            shift = at.value(right).over(norm.scaled(2))
            square = Interval.of(self.squares[0] * self.unit**2, bits)
            x, y = vx * shift, vy * shift
            rest = (square - x * x - y * y).over(norm)
            if cos and self._on_axis(cos)[-1] == ZERO:
                yield 0, (x, y)
                return
            if rest.upper < 0:
                return
            if not rest.sign:
                yield None
                yield 0, (x, y)
                return
            w = rest.root()
            yield -1, (x + w * vy, y - w * vx)
            yield 1, (x - w * vy, y + w * vx)
            return
        yield None


def pose_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of a table of poses."""
    progress(0, 1)
    yield from _Poses(document.geometry, document.members).claims()
    progress(1, 1)


class _Poses:
    def __init__(self, geometry: Geometry, members: Record) -> None:
        self.geometry, self.members = geometry, members
        self.poses: Sequence[Record] = members["poses"]

    @cached_property
    def closure(self) -> Closure:
        """The equations."""
        first, second, third = (self.members[f"l{leg}"] for leg in (1, 2, 3))
        return Closure.of(self.geometry, (first, second, third))

    @cached_property
    def fine(self) -> int:
        """Bits well below the last printed digit."""
        return bits_of((pose[name] for pose in self.poses for name in _NAMES), _SPARE_BITS)

    @cached_property
    def bits(self) -> int:
        """The same where the coefficients are long."""
        return self.fine + longest(self.closure.whole, *self.closure.numerators)

    def claims(self) -> Iterator[Claim]:
        claim = "the sixth-degree polynomial of direct kinematics"
        yield worked("/polynomial", claim, self._polynomial)
        yield from self._numbers()
        curves = self.members["curves"]
        yield worked("/curves", "the curves of poses", lambda: _curves(self.closure, curves))
        right = sorted_turns([pose["alpha_deg"].value for pose in self.poses])
        yield judged("/poses", "the poses are sorted by alpha", right, "as printed")
        claim = "a pose with these digits and this multiplicity"
        for n in range(len(self.poses)):
            yield worked(f"/poses/{n}", claim, partial(self._pose, n))
        yield worked("/poses", "these are all poses", self._complete)

    @cached_property
    def _all(self) -> tuple[list[Found], str, list[int | None], list[list[str | None]]]:
        """All poses, what is open about their number, and what each printed pose is, or what is wrong."""
        for bits in (self.bits, 4 * self.bits):  # roots may be far closer than the digits
            found, doubt = self.closure.found(bits)
            if not doubt and len(found) == len(self.poses):
                break
        values = [self.closure.values(x, self.fine) for x in found]
        pairs = list(zip(found, values, strict=True))
        wrong = [[self._wrong(pose, *pair, doubted=False) for pair in pairs] for pose in self.poses]
        return found, doubt, matching(wrong, range(len(found)), lambda row, k: row[k] is None), wrong

    def _pose(self, n: int) -> Finding:
        pose, (found, _, chosen, wrong) = self.poses[n], self._all
        k = chosen[n]
        if k is None:
            names = ", ".join(dict.fromkeys(filter(None, wrong[n]))) or "no pose is left for it"
            reason = f"it is none of the {len(found)} poses that are found anew: wrong in {names}"
            return ClaimStatus.REFUSED, reason
        if self._wrong(pose, found[k], self.closure.values(found[k], self.fine), doubted=True):
            return ClaimStatus.CHECKED, HALF_WAY
        if found[k].multiplicity is None:
            reason = "two poses share this alpha, and their multiplicities are known in sum only"
            return ClaimStatus.CHECKED, reason
        exact = found[k].regular or found[k].root.axis
        if not exact and any(pose[name].is_zero for name in _NAMES[1:]):
            reason = "the linear equations are dependent there; that numbers are 0 is beyond the digits"
            return ClaimStatus.CHECKED, reason
        return ClaimStatus.PROVED, "another pose for each, above an isolated root, with right digits"

    def _complete(self) -> Finding:
        found, doubt, chosen, _ = self._all
        if len(found) != len(self.poses) or None in chosen:
            return ClaimStatus.REFUSED, f"there are {len(found)} other than on curves"
        if doubt:
            return ClaimStatus.CHECKED, doubt
        return ClaimStatus.PROVED, "each real root, by Descartes' rule of signs, has its listed poses"

    def _polynomial(self) -> Finding:
        form = form_of(self.closure.ring, self.members["polynomial"])
        right = form is not None and proportional(self.closure.ring, form, self.closure.sextic)
        return finding(right, "it is a multiple of the one derived from the legs")

    def _numbers(self) -> Iterator[Claim]:
        listed: Counter[int] = Counter()
        for factor in self.members["certificate"]["factors"]:
            listed[factor["multiplicity"]] += factor["degree"]
        total = sum(pose["multiplicity"] for pose in self.poses)
        right = self.members["count"] == len(self.poses)
        yield judged("/count", "the number of poses", right, "counted")
        at, right = "/count_with_multiplicity", self.members["count_with_multiplicity"] == total
        yield judged(at, "with multiplicity", right, "counted")

        def shaped() -> Finding:
            return finding({m: len(p) - 1 for m, p in self.closure.parts.items()} == listed, "counted")

        claim = "the degrees of all factors of a multiplicity, in sum"
        yield worked("/certificate/factors", claim, shaped)

    def _wrong(
        self, pose: Record, found: Found, values: Mapping[str, Interval], *, doubted: bool
    ) -> str | None:
        """The first number of a printed pose that is wrong for one that was found, None if all are right."""
        if found.multiplicity not in (None, pose["multiplicity"]) or pose["multiplicity"] > found.order:
            return "multiplicity"
        return first_wrong(pose, values, partial(self.closure.vanishes, found), doubted=doubted)


def number_of_poses(geometry: Geometry, squares: tuple[Fraction, Fraction, Fraction]) -> int | None:
    """The number of poses of squared lengths; None if two coalesce, or are not told apart."""
    closure = Closure.of(geometry, squares)
    if not any(map(any, closure.sextic)) or any(_circle(closure, t) for t in (1, -1)):
        return None
    if all(regular for *_, regular in closure.roots):
        return len(closure.roots) if all(order == 1 for order, *_ in closure.roots) else None
    found, doubt = closure.found(_SPARE_BITS + 4 * longest(closure.whole, *closure.numerators))
    return None if doubt or any(pose.multiplicity != 1 for pose in found) else len(found)


def _curves(closure: Closure, listed: Sequence[Record]) -> Finding:
    mine = ["0" if t == 1 else "180" for t in (1, -1) if _circle(closure, t)]
    right = [curve["alpha_deg"] for curve in listed] == mine
    return finding(right, "both linear equations vanish there, and nowhere else")


def _circle(closure: Closure, cos: int) -> bool:
    """Whether both linear equations vanish at α = 0 or 180°, which is exact."""
    return _no_vectors(closure, cos) and all(_value_on_axis(p, cos) == ZERO for p in closure.right)


def _no_vectors(closure: Closure, cos: int) -> bool:
    return all(_value_on_axis(p, cos) == ZERO for vector in closure.vectors for p in vector)


def _is_undirected(closure: Closure, root: Root) -> bool:
    """Whether v₂ = v₃ = 0 at a root: v₂ is 0 at α = 0 or 180° only."""
    return root.axis != 0 and _no_vectors(closure, root.axis)


def _on_half_tangents(p: Trig) -> tuple[Surd, ...]:
    """A polynomial in α as one in t = tan(α/2), of formal degree."""
    return in_half_tangent(p, max((i + j for i, j, _, _ in p), default=0), lambda _cos, _sin: 1)


def _value_on_axis(p: Trig, cos: int) -> Surd:
    """The value at α = 0 (``cos`` = 1) or 180° (−1), exact."""
    a = sum(x[0] * cos**i for (i, j, _, _), x in p.items() if not j)
    b = sum(x[1] * cos**i for (i, j, _, _), x in p.items() if not j)
    return a, b
