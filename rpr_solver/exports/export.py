"""The script of a document for another system: what it is to compute, and a program with places for numbers.

A free leg has a base point a and a platform point m, both seen from the fixed leg, and the squared length
|L e(θ) + R(α) m − a|². Of m, x is rational and y is 0 or ±h, where h² is rational. Where one of the six
lengths is irrational, the plane is that of the slices instead (mathematics.md#the-norm-form): y is measured
in √ρ, all coordinates are a + b h, turns (c, s) have c² + ρ s² = 1, and angles begin at axes.

msolve gets polynomial equations, whose real solutions are the cusps of a slice. For the other systems there
are programs in ``programs/`` with places ``@NAME@``; those in Python share ``common.txt``. A line that begins
with ``@HEADING@``, ``@SLICE@``, ``@EVENT@`` or ``@SKIPPED@`` is repeated for each line of the heading, each
slice, each event or each window without a slice. One that begins with ``@PLAIN@`` is for six rational
numbers, one with ``@ROOTED@`` for others.

A program finds the cusps of a slice by the real roots of Res_t(J, E), as isolated by that system, and proves
each by Newton's method and Kantorovich's theorem, whose bounds are sums of coefficients: a zero of J and of E
along a leg with a regular Jacobian matrix, where the leg's gradient is not 0, is a cusp
(mathematics.md#simple-roots). It compares with half a unit of the last printed digit. What its digits do not
decide it tries again with twice and four times as many.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import partial
from importlib.resources import files
from math import atan2, cos, gcd, isqrt, lcm, radians, sqrt, tan
from typing import Any, TypedDict, Unpack

from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx

from rpr_solver.errors import InputError, shown
from rpr_solver.exact.quadratic import QuadraticNumber
from rpr_solver.exact.rationals import exact_str, short_between
from rpr_solver.model.joint_points import PoseKind, coordinate_names, free_legs
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.triangles import CW, article_lengths

_TURNS = (("20/29", "21/29"), ("28/53", "45/53"), ("33/65", "56/65"), ("12/37", "35/37"))
"""Cosine and sine of the angles from which half tangents may be taken: few triangles have these angles."""
_NEAR_INFINITY = 1e-6
_FINENESS = 16
"""Half tangents of these angles have such denominators, times √ρ."""
SWALLOWTAIL, CRITICAL = "swallowtail", "critical"
_SYSTEMS = {
    PoseKind.SWALLOWTAIL.value: SWALLOWTAIL,
    PoseKind.LIPS.value: CRITICAL,
    PoseKind.BEAK_TO_BEAK.value: CRITICAL,
}


def ratio(x: Fraction) -> str:
    """A rational as every system reads it exactly: a decimal would be a float there."""
    return str(x.numerator) if x.denominator == 1 else f"{x.numerator}/{x.denominator}"


Numbers = tuple[str, ...]
"""α and θ in degrees, and the lengths of the free legs, as a document prints them."""


@dataclass(frozen=True)
class Leg:
    """A free leg: its base point, and its platform point (x, y·h), seen from the fixed leg."""

    ax: str
    ay: str
    x: str
    y: int


Coordinate = tuple[Fraction, Fraction]
"""a and b of a + b h."""


@dataclass(frozen=True)
class Plane:
    """The plane of the slices of a manipulator with an irrational length.

    Attributes:
        rho, radicand: ρ and h².
        axes: the turns of the platform and of the fixed leg at which the angles are 0, up to their lengths.
        legs: ax, ay, x and y of the base point and the platform point of each free leg.
    """

    rho: int
    radicand: int
    axes: tuple[tuple[Coordinate, Coordinate], ...]
    legs: tuple[tuple[Coordinate, ...], ...]

    @classmethod
    def of(cls, m: Manipulator, fixed_leg: int) -> Plane:
        slice_map = SliceMap.of(m, fixed_leg)

        def coordinates(*numbers: QuadraticNumber[int]) -> tuple[Coordinate, ...]:
            return tuple((z.a / slice_map.scale, z.b / slice_map.scale) for z in numbers)

        axes = [[(Fraction(z.a), Fraction(z.b)) for z in axis] for axis in slice_map.axes]
        return cls(
            slice_map.rho,
            slice_map.radicand,
            tuple((x, y) for x, y in axes),
            tuple(coordinates(*leg.base, *leg.platform) for leg in (slice_map.f, slice_map.g)),
        )

    def value(self, z: Coordinate) -> float:
        """A coordinate, about."""
        return float(z[0]) + float(z[1]) * sqrt(self.radicand)

    @property
    def offsets(self) -> list[float]:
        """The angles of the axes, about."""
        return [atan2(self.value(y) * sqrt(self.rho), self.value(x)) for x, y in self.axes]

    def is_spurious(self, slices: Sequence[SliceTask], c: Fraction, s: Fraction) -> bool:
        """As :func:`_is_spurious`, about."""
        e = complex(c, float(s) * sqrt(self.rho))
        ax, ay, x, y = map(self.value, self.legs[0])
        a, size = complex(ax, ay * sqrt(self.rho)), abs(complex(x, y * sqrt(self.rho)))
        lengths = [float(Fraction(part.length)) for part in slices]
        gaps = [abs(abs(length * e - a) - size) / (length + abs(a)) for length in lengths]
        return min(abs((a.conjugate() * e).imag) / abs(a), *gaps) < _NEAR_INFINITY


@dataclass(frozen=True)
class SliceTask:
    """A slice: its length, its number of cusps, and the cusps; None if only their number is expected."""

    length: str
    count: int
    cusps: tuple[Numbers, ...] | None = None

    @property
    def exact(self) -> str:
        """The length as every system reads it exactly."""
        return ratio(Fraction(self.length))


@dataclass(frozen=True)
class EventTask:
    """A degenerate pose of a transition: its length, its system of equations, and its numbers."""

    length: str
    system: str
    numbers: Numbers


@dataclass(frozen=True)
class Problem:
    """The slices and events of one manipulator.

    Attributes:
        about: what it is, in lines without an end.
        fixed_leg: the leg of fixed length.
        names: of the coordinates, as a document has them.
        legs: the two free legs; none with a plane.
        square: h², exact.
        height: h if it is rational, else None; its sign is ``sign``.
        sign: of h.
        turns: cosine and sine of the α and the θ from which half tangents are taken: no expected pose is
            opposite to them, and no root of the resultant that every geometry has.
        digits: the significant digits of the expected numbers.
        skipped: windows without a slice, in words: their printed ends leave no room for one.
        plane: that of a manipulator with an irrational length.
    """

    about: tuple[str, ...]
    fixed_leg: int
    names: tuple[str, ...]
    legs: tuple[Leg, ...]
    square: str
    height: str | None
    sign: int
    turns: tuple[tuple[str, str], tuple[str, str]]
    digits: int
    slices: tuple[SliceTask, ...]
    events: tuple[EventTask, ...]
    skipped: tuple[str, ...]
    plane: Plane | None = None

    @property
    def precisions(self) -> tuple[int, ...]:
        """The decimal digits with which a script should work: the later ones if the first do not decide.

        A root of a quartic has a fourth of these digits at least, which are to be more than the document has.
        """
        first = max(120, 5 * self.digits)
        return first, 2 * first, 4 * first


def problem_of(document: Mapping[str, Any]) -> Problem:
    """The problem whose answer is a cusp table or a census.

    Raises:
        InputError: it is another document, has slices without an answer, or a curve of degenerate poses.
    """
    try:
        m, leg = Manipulator.from_json(document["geometry"], max_digits=1 << 20), document["fixed_leg"]
        m.geometry.apart_from_shared()
        slices, skipped = list(_slice_tasks(document, leg)), list[str]()
        if "slices" not in document:
            slices, skipped = _windows(document, leg)
        events = tuple(_event_tasks(document, leg))
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError.of("document", "is no cusp table and no census; give one as JSON") from None
    numbers = [cusp for part in slices for cusp in part.cusps or ()] + [event.numbers for event in events]
    known = article_lengths(m.to_json())
    lengths = "  ".join(f"{name} = {value}" for name, value in known.items())
    about = (
        f"3-RPR manipulator: {lengths}",
        f"leg {leg} fixed; solver version {document['solver_version']}",
    )
    done = document["digits"], tuple(slices), events, tuple(skipped)
    if not m.is_rational:
        plane = Plane.of(m, leg)
        turns = _turns_in(plane, numbers, slices)
        height = "1" if plane.radicand == 1 else None
        return Problem(
            about, leg, coordinate_names(leg), (), str(plane.radicand), height, 1, turns, *done, plane
        )
    *_, d1, d2, d3 = m.rational_lengths("a program")
    p = (d1**2 + d3**2 - d2**2) / (2 * d1)
    square = d3**2 - p**2
    sign = -1 if m.orientation == CW else 1
    root = Fraction(isqrt(square.numerator), isqrt(square.denominator))
    legs = _legs(m, leg, p)
    return Problem(
        about,
        leg,
        coordinate_names(leg),
        legs,
        ratio(square),
        ratio(sign * root) if root**2 == square else None,
        sign,
        (
            _turn([x[0] for x in numbers]),
            _turn([x[1] for x in numbers], lambda c, s: _is_spurious(legs[0], square, slices, c, s)),
        ),
        *done,
    )


def _legs(m: Manipulator, fixed_leg: int, p: Fraction) -> tuple[Leg, Leg]:
    a2x, a3x, a3y, d1, *_ = m.rational_lengths("a program")
    base = {1: (Fraction(0), Fraction(0)), 2: (a2x, Fraction(0)), 3: (a3x, a3y)}
    platform = {1: (Fraction(0), 0), 2: (d1, 0), 3: (p, 1)}
    (ax, ay), (mx, my) = base[fixed_leg], platform[fixed_leg]
    first, second = (
        Leg(ratio(bx - ax), ratio(by - ay), ratio(x - mx), y - my)
        for (bx, by), (x, y) in ((base[k], platform[k]) for k in free_legs(fixed_leg))
    )
    return first, second


def _turn(
    angles: Sequence[str], is_bad: Callable[[Fraction, Fraction], bool] | None = None
) -> tuple[str, str]:
    """The first turn to which none of the angles, and nothing bad, is opposite."""

    def apart(turn: tuple[str, str]) -> bool:
        c, s = map(Fraction, turn)
        at = atan2(float(s), float(c))
        if is_bad is not None and is_bad(-c, -s):
            return False
        return all(cos(radians(float(x)) - at) > _NEAR_INFINITY - 1 for x in angles)

    return next(filter(apart, _TURNS), _TURNS[0])


def _turns_in(
    plane: Plane, numbers: Sequence[Numbers], slices: Sequence[SliceTask]
) -> tuple[tuple[str, str], tuple[str, str]]:
    """As :func:`_turn` finds them, for both angles, of turns (c, s) with c² + ρ s² = 1."""
    root, turns = sqrt(plane.rho), []
    for x, y in _TURNS:
        half = tan(atan2(Fraction(y), Fraction(x)) / 2) / root
        t = Fraction(half).limit_denominator(_FINENESS * (isqrt(plane.rho) + 1))
        size = 1 + plane.rho * t * t
        turns.append(((1 - plane.rho * t * t) / size, 2 * t / size))

    def apart(k: int, turn: tuple[Fraction, Fraction]) -> bool:
        c, s = turn
        if k == 1 and plane.is_spurious(slices, -c, -s):
            return False
        at = atan2(float(s) * root, float(c)) - plane.offsets[k]
        return all(cos(radians(float(x[k])) - at) > _NEAR_INFINITY - 1 for x in numbers)

    (a, b), (c, d) = (next(filter(partial(apart, k), turns), turns[0]) for k in (0, 1))
    return (ratio(a), ratio(b)), (ratio(c), ratio(d))


def _is_spurious(leg: Leg, square: Fraction, slices: Sequence[SliceTask], c: Fraction, s: Fraction) -> bool:
    """Whether at an angle of the fixed leg a free one can be closed, or stretched along its base line."""
    ax, ay, platform = Fraction(leg.ax), Fraction(leg.ay), Fraction(leg.x) ** 2 + leg.y**2 * square
    lengths = [Fraction(part.length) for part in slices]
    return ax * s == ay * c or any((x * c - ax) ** 2 + (x * s - ay) ** 2 == platform for x in lengths)


def _slice_tasks(document: Mapping[str, Any], leg: int) -> Iterator[SliceTask]:
    name, names = f"l{leg}", coordinate_names(leg)
    if any(part["kind"] == PoseKind.CURVE for part in document.get("degenerate", ())):
        raise InputError.of(
            "document", "has a curve of degenerate poses: no system of equations stands for it"
        )
    for number, part in enumerate(document.get("slices", ())):
        if "error" in part:
            raise InputError.of(f"document.slices[{number}]", "has no answer")
        if any(point["kind"] == PoseKind.CURVE for point in part["degenerate_points"]):
            raise InputError.of(f"document.slices[{number}]", "has a whole curve of degenerate poses")
        cusps = tuple(tuple(cusp[x] for x in names) for cusp in part["cusps"])
        if len(cusps) != part["count"]:
            words = f"is {part['count']}, but {len(cusps)} cusps are listed"
            raise InputError.of(f"document.slices[{number}].count", words)
        yield SliceTask(part[name], part["count"], cusps)


def _windows(document: Mapping[str, Any], leg: int) -> tuple[list[SliceTask], list[str]]:
    """A slice in each window of a census; in words, the windows whose printed ends leave no room for one."""
    rounded = {transition[f"l{leg}"] for transition in document["transitions"]}
    slices: list[SliceTask] = []
    skipped: list[str] = []

    def wrong(end: str) -> Fraction:
        return half_unit(end) if end in rounded else Fraction(0)

    for part in document["intervals"]:
        low = Fraction(part["from"]) + wrong(part["from"])
        high = 3 * low + 1 if part["to"] is None else Fraction(part["to"]) - wrong(part["to"])
        if low < high:
            slices.append(SliceTask(exact_str(short_between(low, high)), part["count"]))
        else:
            window = f"L{leg} from {part['from']} to {part['to']}"
            skipped.append(f"{window}: no slice, as the ends are printed too near each other")
    return slices, skipped


def half_unit(number: str) -> Fraction:
    """Half a unit of the last place of a rounded number; ``"0"`` is exact."""
    return Fraction(10) ** int(Decimal(number).as_tuple().exponent) / 2 if number != "0" else Fraction(0)


def _event_tasks(document: Mapping[str, Any], leg: int) -> Iterator[EventTask]:
    for transition in document.get("transitions", ()):
        for event in transition["events"]:
            if event["kind"] in _SYSTEMS:
                numbers = tuple(event[x] for x in coordinate_names(leg))
                yield EventTask(transition[f"l{leg}"], _SYSTEMS[event["kind"]], numbers)


_RING = fmpq_mpoly_ctx.get(("s", "e", "h", "c", "d", "u", "v"), Ordering.lex)
"""c, s: cosine and sine of α; d, e: of θ; h: the height of the platform; (u, v): ∇J / |∇J|²."""
_S, _E, _H, _C, _D, _U, _V = _RING.gens()


def equations(problem: Problem) -> str:
    """The input of ``msolve -f``.

    Raises:
        InputError: the document is not a table of one slice.
    """
    tables = [part for part in problem.slices if part.cusps is not None]
    if len(problem.slices) != 1 or not tables:
        what = f"has {len(tables)} slices" if tables else "is a census"
        words = f"{what}, but msolve solves one system of equations; give a cusp table of one slice"
        raise InputError.of("document", words)
    names = ("c", "s", "d", "e", *(() if problem.height else ("h",)), "u", "v")
    polynomials = ",\n".join(map(_text, _system(problem)))
    return f"{','.join(names)}\n0\n{polynomials}\n"


def _system(problem: Problem) -> list[fmpq_mpoly]:
    """J = 0 where ∇J ≠ 0, and E = 0 along f and along g: one of them is 0 where ∇f = 0 or ∇g = 0."""
    height = _H if problem.height is None else _RING.constant(_rational(problem.height))
    rho = 1 if problem.plane is None else problem.plane.rho
    circles = rho * _S**2 + _C**2 - 1, rho * _E**2 + _D**2 - 1
    relations = (*circles, *((_H**2 - _rational(problem.square),) if problem.height is None else ()))

    def reduced(p: fmpq_mpoly) -> fmpq_mpoly:
        for relation in relations:
            p %= relation
        return p

    def slopes(p: fmpq_mpoly) -> tuple[fmpq_mpoly, fmpq_mpoly]:
        alpha = _C * p.derivative("s") - rho * _S * p.derivative("c")
        theta = _D * p.derivative("e") - rho * _E * p.derivative("d")
        return reduced(alpha), reduced(theta)

    def along(p: fmpq_mpoly, q: fmpq_mpoly) -> fmpq_mpoly:
        (p_alpha, p_theta), (q_alpha, q_theta) = slopes(p), slopes(q)
        return reduced(p_alpha * q_theta - p_theta * q_alpha)

    def square(ax: Any, ay: Any, x: Any, y: Any) -> fmpq_mpoly:
        length = _rational(problem.slices[0].exact)
        across = length * _D + x * _C - rho * y * _S - ax
        up = length * _E + x * _S + y * _C - ay
        return reduced(across**2 + rho * up**2)

    if problem.plane is None:
        points = [[*map(_rational, (leg.ax, leg.ay, leg.x)), leg.y * height] for leg in problem.legs]
    else:
        points = [
            [_rational(ratio(a)) + _rational(ratio(b)) * height for a, b in leg] for leg in problem.plane.legs
        ]
    f, g = (square(*leg) for leg in points)
    j = along(f, g)
    j_alpha, j_theta = slopes(j)
    smooth = (_U * j_alpha + _V * j_theta - 1, _U * j_theta - _V * j_alpha)
    return [j, along(f, j), along(g, j), *smooth, *relations]


def _rational(number: str) -> fmpq:
    top, _, bottom = number.partition("/")
    return fmpq(int(top), int(bottom or 1))


def _text(p: fmpq_mpoly) -> str:
    """A polynomial with integral coefficients that have no common factor."""
    numbers = p.coeffs()
    factor = fmpq(lcm(*(int(x.q) for x in numbers)), gcd(*(int(x.p) for x in numbers)))
    return str(p * factor).replace(" ", "")


SYSTEMS = ("maple", "msolve", "pari", "sage", "sympy")
"""Systems that compute cusps."""
ROBOTS: Mapping[str, tuple[str, ...]] = {
    "ros2-json": ("unit", "relative"),
    "ros2-yaml": ("unit", "relative"),
    "sdf": ("unit", "pose", "name"),
}
"""Descriptions for robots, of a path and of the machine at a pose, with their options."""

Fields = Mapping[str, str]
"""What is put at the places of a line, by name."""


class ExportOptions(TypedDict, total=False):
    """What descriptions for robots have beside their document.

    Attributes:
        unit: that of the geometry's lengths, which documents do not tell: ``"m"``, ``"cm"``, ``"mm"``,
            ``"in"``. Robots are described in metres.
        relative: of a path, whether positions are changes of lengths since its start
            (:func:`~rpr_solver.exports.trajectory.joint_trajectory`).
        pose: of a model, the number of the pose, from 1; 1 unless given.
        name: of a model, its name.
    """

    unit: str | None
    relative: bool | None
    pose: int | None
    name: str | None


def export(document: Mapping[str, Any], system: str, **options: Unpack[ExportOptions]) -> str:
    """A document for another system: a cusp table or a census as a script that repeats the computation, a
    path as a ``JointTrajectory`` of ROS 2, or the machine at a pose as a model of SDFormat.

    The script derives J and E from the geometry, eliminates, and finds the cusps of each slice by the means
    of that system. It compares them with those of the document; its last line is ``agrees``, ``differs`` or
    ``cannot decide with N digits``. msolve gets a system of equations instead, whose real solutions are the
    cusps.

    Args:
        document: a cusp table or a census, as JSON; for msolve a table of one slice; for ROS 2 a path, and
            for SDFormat all poses of a joint vector.
        system: ``"maple"``, ``"msolve"``, ``"pari"``, ``"sage"`` or ``"sympy"``; ``"ros2-json"``,
            ``"ros2-yaml"`` or ``"sdf"``.
        options: as :class:`ExportOptions` says, for robots.

    Raises:
        InputError: naming ``document``, ``system`` or an option.

    >>> from rpr_solver import EXAMPLES, table_document
    >>> print(export(table_document(EXAMPLES["zein-flat"], 10, digits=15), "pari").splitlines()[3])
    \\\\ Expected at L1 = 10: alpha_deg, theta1_deg, l2, l3
    """
    known = (*SYSTEMS, *ROBOTS)
    if system not in known:
        raise InputError.of("system", f"is {shown(system)}; it must be one of {', '.join(known)}")
    given: dict[str, Any] = {name: value for name, value in options.items() if value is not None}
    for name in given:
        if name not in ROBOTS.get(system, ()):
            raise InputError.of(name, f"says nothing about an export to {system}; leave it out")
    if system in ROBOTS:
        return _for_robots(document, system, given)
    problem = problem_of(document)
    if problem.plane is not None and system == "maple":
        Manipulator.from_json(document["geometry"], max_digits=1 << 20).rational_lengths("a program in Maple")
    if system == "msolve":
        return equations(problem)
    folder = files("rpr_solver.exports") / "programs"
    program, common = ((folder / f"{name}.txt").read_text(encoding="utf-8") for name in (system, "common"))
    program = program.replace("@COMMON@\n", common)
    return "".join(f"{line}\n" for line in _filled(program, problem, system))


def _for_robots(document: Mapping[str, Any], system: str, options: dict[str, Any]) -> str:
    # these load what moves along paths, which scripts need not
    from rpr_solver.exports.model import sdf
    from rpr_solver.exports.trajectory import trajectory_json, trajectory_yaml

    writers: dict[str, Callable[..., str]] = {
        "ros2-json": trajectory_json,
        "ros2-yaml": trajectory_yaml,
        "sdf": sdf,
    }
    return writers[system](document, options.pop("unit", None), **options)


def _filled(program: str, problem: Problem, system: str) -> Iterator[str]:
    """Yields the lines of a program with its places filled."""
    common = _common(problem, system)
    repeated: Mapping[str, list[Fields]] = {
        "PLAIN": [{}] if problem.plane is None else [],
        "ROOTED": [] if problem.plane is None else [{}],
        "HEADING": [{"TEXT": line} for line in _heading(problem)],
        "SLICE": list(_slices(problem)),
        "EVENT": list(_events(problem)),
        "SKIPPED": [{"TEXT": words} for words in problem.skipped],
    }
    for line in program.splitlines():
        repetition = re.fullmatch(r"@(HEADING|SLICE|EVENT|SKIPPED|PLAIN|ROOTED)@(.*)", line)
        if repetition is None:
            yield _put(line, common)
        else:
            for fields in repeated[repetition[1]]:
                yield _put(repetition[2], {**common, **fields}).rstrip()


def _put(line: str, fields: Fields) -> str:
    return re.sub(r"@(\w+)@", lambda place: fields[place[1]], line)


def _heading(problem: Problem) -> Iterator[str]:
    """What the script is about, and the cusps that it is to find."""
    yield from problem.about
    yield "It computes the cusps anew and compares them; the last line says whether it agrees."
    for part in problem.slices:
        if part.cusps is not None:
            yield f"Expected at L{problem.fixed_leg} = {part.length}: {', '.join(problem.names)}"
            yield from [f"  {'  '.join(cusp)}" for cusp in part.cusps] or ["  no cusp"]


def _common(problem: Problem, system: str) -> Fields:
    """The places that are the same throughout; a rational has another one for its two integers."""
    rationals = {"SQUARE": problem.square}
    for k, (c, s) in enumerate(problem.turns, 1):
        rationals |= {f"COS{k}": c, f"SIN{k}": s}
    for k, leg in enumerate(problem.legs, 1):
        rationals |= {f"AX{k}": leg.ax, f"AY{k}": leg.ay, f"X{k}": leg.x}
    unknown = {"pari": "Mod('h, 'h^2 - SQUARE)"}.get(system, "None")
    height = problem.height or ""
    rational = {"sympy": f"QQ({_pair(height)})", "sage": f'QQ("{height}")'}.get(system, height)
    return {
        **rationals,
        **{f"{name}_PAIR": _pair(number) for name, number in rationals.items()},
        **{f"Y{k}": str(leg.y) for k, leg in enumerate(problem.legs, 1)},
        **({} if problem.plane is None else _of_plane(problem.plane, system)),
        "HEIGHT": unknown if problem.height is None else rational,
        "SIGN": str(problem.sign),
        "PRECISION": str(problem.precisions[0]),
        "PRECISIONS": ", ".join(map(str, problem.precisions)),
        "LAST": str(problem.precisions[-1]),
        "LEG": str(problem.fixed_leg),
        "SLICES": str(len(problem.slices)),
        "TOTAL": str(len(problem.slices) + len(problem.events)),
    }


def _of_plane(plane: Plane, system: str) -> Fields:
    """The places of a plane: its coordinates in the words of a system."""

    def text(z: Coordinate) -> str:
        a, b = map(ratio, z)
        if system == "pari":
            return f"{a} + {b}*H"
        if system == "sage":
            return f'QQ("{a}") + QQ("{b}") * h'
        return f"R(QQ({_pair(a)})) + QQ({_pair(b)}) * h"

    axes = [[text(z) for z in axis] for axis in plane.axes]
    pairs = [[(int(a), int(b)) for a, b in axis] for axis in plane.axes]
    return {
        "RHO": str(plane.rho),
        "AXES": f"[{', '.join(f'[{x}, {y}]' for x, y in axes)}]" if system == "pari" else str(pairs),
        **{f"POINTS{k}": ", ".join(map(text, leg)) for k, leg in enumerate(plane.legs, 1)},
    }


def _slices(problem: Problem) -> Iterator[Fields]:
    for part in problem.slices:
        cusps = part.cusps or ()
        yield {
            "LENGTH": part.length,
            "EXACT": part.exact,
            "COUNT": str(part.count),
            "LISTED": str(int(part.cusps is not None)),
            "ROWS": f"[{', '.join(map(_row, cusps))}]",
            "TEXTS": str(list(cusps)),
        }


def _events(problem: Problem) -> Iterator[Fields]:
    for event in problem.events:
        numbers = {"ROW": _row(event.numbers), "TEXT": str(event.numbers)}
        yield {
            "LENGTH": event.length,
            "SYSTEM": event.system,
            "LENGTH_ROW": _with_half_unit(event.length),
            **numbers,
        }


def _row(numbers: tuple[str, ...]) -> str:
    return f"[{', '.join(map(_with_half_unit, numbers))}]"


def _with_half_unit(number: str) -> str:
    """A number with half a unit of its last place."""
    exponent = int(Decimal(number).as_tuple().exponent) - 1
    return f"[{number}, {'0' if number == '0' else f'5e{exponent}'}]"


def _pair(number: str) -> str:
    top, _, bottom = number.partition("/")
    return f"{top}, {bottom or 1}"
