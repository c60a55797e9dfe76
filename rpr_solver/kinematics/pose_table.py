"""Direct kinematics: all real poses of a joint vector (L1, L2, L3), with their multiplicities.

>>> from rpr_solver import EXAMPLES, poses
>>> table = poses(EXAMPLES["innocenti"], "14.98", "15", "30", digits=15)
>>> [(p.alpha_deg, p.theta1_deg, p.multiplicity) for p in table.poses]
[('-130.806761043048', '23.6128999669840', 1), ('-5.27975966480067', '37.0140956869959', 1)]

The document of :meth:`PoseTable.to_json`::

    {"geometry": {…}, "geometry_hash": "sha256:…", "digits": 90, "solver_version": "…",
     "l1": "14.98", "l2": "15", "l3": "30", "count": 2, "count_with_multiplicity": 2,
     "poses": [{"alpha_deg": "…", "theta1_deg": "…", "theta2_deg": "…", "theta3_deg": "…",
                "b1_x": "…", "b1_y": "…", "multiplicity": 1}],
     "curves": [{"kind": "curve", "alpha_deg": "0", "description": "…"}],
     "polynomial": {"variable": "t = tan(alpha/2)", "degree": 6, "coefficients": ["…", …],
                    "omega": "sqrt(…)", "omega_coefficients": ["…", …]},
     "certificate": {"method": "balls", "factors": [{"degree": 6, "multiplicity": 1}],
                     "working_bits": …}}

Poses are sorted by α, then θ1. A pose's multiplicity is the number of poses that coalesce in it:
1 regular, 2 on a singular curve, 3 at a cusp. ``curves`` is empty but for congruent triangles
with equal legs; ``count`` is then the number of isolated poses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from decimal import Decimal
from fractions import Fraction
from math import isqrt

from rpr_solver.contract import DEFAULT_DIGITS, check_digits, document_head
from rpr_solver.errors import FieldProblem, InputError
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.rationals import exact_str, parse_exact
from rpr_solver.kinematics.closure import DEGREE, Closure
from rpr_solver.kinematics.fibre import DecimalPose, Fibre, fibre
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap

Exact = int | str | Decimal | Fraction


@dataclass(frozen=True)
class PlatformPose:
    """A pose in correctly rounded decimals: angles in degrees in (−180, 180], B1 in the user's unit."""

    alpha_deg: str
    theta1_deg: str
    theta2_deg: str
    theta3_deg: str
    b1_x: str
    b1_y: str
    multiplicity: int

    def to_json(self) -> dict[str, object]:
        """The document's pose object."""
        return asdict(self)


@dataclass(frozen=True)
class DirectPolynomial:
    """A(t) + ω B(t) = 0, t = tan(α/2): the sixth-degree polynomial of direct kinematics, exact.

    A form of degree 6: where the leading coefficients are 0, α = 180° is a root. ω² = ``radicand``;
    ``b`` is zero where the platform's height is rational.
    """

    a: tuple[int, ...]
    b: tuple[int, ...]
    radicand: int

    @classmethod
    def of(cls, sextic: QuadraticPoly) -> DirectPolynomial:
        """Always seven coefficients, ascending."""
        a, b = (tuple(int(part[i]) for i in range(DEGREE + 1)) for part in (sextic.a, sextic.b))
        return cls(a, b, sextic.radicand)

    def to_json(self) -> dict[str, object]:
        """Coefficients as decimal strings, ascending from the constant term."""
        result: dict[str, object] = {
            "variable": "t = tan(alpha/2)",
            "degree": DEGREE,
            "coefficients": [str(x) for x in self.a],
        }
        if any(self.b):
            result["omega"] = f"sqrt({self.radicand})"
            result["omega_coefficients"] = [str(x) for x in self.b]
        return result


@dataclass(frozen=True)
class PoseTable:
    """All real poses of one joint vector. ``squares`` are L1², L2², L3²."""

    manipulator: Manipulator
    squares: tuple[Fraction, Fraction, Fraction]
    digits: int
    poses: tuple[PlatformPose, ...]
    curves: tuple[Mapping[str, str], ...]
    polynomial: DirectPolynomial = field(repr=False)
    certificate: Mapping[str, object] = field(repr=False)

    @property
    def count(self) -> int:
        """The number of different real poses."""
        return len(self.poses)

    @property
    def count_with_multiplicity(self) -> int:
        """The number of real poses, each counted as often as poses coalesce in it."""
        return sum(pose.multiplicity for pose in self.poses)

    def to_json(self) -> dict[str, object]:
        """The document described at the top of this module."""
        lengths = {f"l{leg}": _length_text(square) for leg, square in enumerate(self.squares, 1)}
        return {
            **document_head(self.manipulator, self.digits),
            **lengths,
            "count": self.count,
            "count_with_multiplicity": self.count_with_multiplicity,
            "poses": [pose.to_json() for pose in self.poses],
            "curves": [dict(curve) for curve in self.curves],
            "polynomial": self.polynomial.to_json(),
            "certificate": dict(self.certificate),
        }


def poses(
    manipulator: Manipulator, l1: Exact, l2: Exact, l3: Exact, *, digits: int = DEFAULT_DIGITS
) -> PoseTable:
    """All real poses with the given leg lengths, exactly counted.

    Args:
        manipulator: the geometry.
        l1: the length of leg 1, exact (see :func:`parse_exact`), > 0; likewise ``l2`` and ``l3``.
        l2: the length of leg 2.
        l3: the length of leg 3.
        digits: significant digits of every printed number, 15 to 10000.

    Raises:
        InputError: a length is no exact number or not positive, or ``digits`` is out of range.
        SolverError: the joint vector could not be decided; nothing was guessed.
    """
    lengths = _positive({"l1": l1, "l2": l2, "l3": l3})
    return _table(manipulator, [length**2 for length in lengths], digits)


def poses_of_squares(
    manipulator: Manipulator,
    l1_squared: Exact,
    l2_squared: Exact,
    l3_squared: Exact,
    *,
    digits: int = DEFAULT_DIGITS,
) -> PoseTable:
    """As :func:`poses`, for exact squares of the leg lengths: the legs may then be irrational.

    Raises:
        InputError: a square is no exact number or not positive, or ``digits`` is out of range.
        SolverError: the joint vector could not be decided.
    """
    squares = {"l1_squared": l1_squared, "l2_squared": l2_squared, "l3_squared": l3_squared}
    return _table(manipulator, _positive(squares), digits)


def _positive(values: Mapping[str, Exact]) -> list[Fraction]:
    problems: list[FieldProblem] = []
    result = []
    for name, value in values.items():
        try:
            number = parse_exact(value, name)
        except InputError as error:
            problems.extend(error.problems)
            continue
        if number <= 0:
            problems.append(FieldProblem(name, f"is {exact_str(number)}; a leg length must be > 0"))
        result.append(number)
    if problems:
        raise InputError(problems)
    return result


def _table(manipulator: Manipulator, squares: Sequence[Fraction], digits: int) -> PoseTable:
    check_digits(digits)
    s1, s2, s3 = squares
    closure = Closure.of(SliceMap.of(manipulator), squares)
    found = fibre(closure, digits)
    return PoseTable(
        manipulator,
        (s1, s2, s3),
        digits,
        tuple(_platform_pose(pose) for pose in found.poses),
        _curves(found, s1),
        DirectPolynomial.of(closure.sextic),
        _certificate(found),
    )


def _platform_pose(pose: DecimalPose) -> PlatformPose:
    alpha, theta1, theta2, theta3, x, y = pose.texts
    return PlatformPose(alpha, theta1, theta2, theta3, x, y, pose.multiplicity)


def _curves(found: Fibre, s1: Fraction) -> tuple[Mapping[str, str], ...]:
    if found.circle_at is None:
        return ()
    description = (
        f"the platform is translated with B1 anywhere on the circle of radius {_length_text(s1)} about A1"
    )
    return ({"kind": PoseKind.CURVE.value, "alpha_deg": str(found.circle_at), "description": description},)


def _certificate(found: Fibre) -> dict[str, object]:
    """How the count is proved: the form's factors over ℚ(ω), and the precision that told them apart."""
    return {
        "method": found.method,
        "factors": [{"degree": degree, "multiplicity": times} for degree, times in found.factors],
        "working_bits": max((pose.bits for pose in found.poses), default=0),
    }


def _length_text(square: Fraction) -> str:
    n, d = square.numerator, square.denominator
    root = Fraction(isqrt(n), isqrt(d))
    return exact_str(root) if root * root == square else f"sqrt({exact_str(square)})"
