"""Direct kinematics: all real poses of a joint vector (L1, L2, L3), with their multiplicities.

The document of :meth:`PoseTable.to_json`::

    {"geometry": {…}, "geometry_hash": "sha256:…", "digits": 90, "solver_version": "…",
     "l1": "14.98", "l2": "15", "l3": "30", "count": 2, "count_with_multiplicity": 2,
     "poses": [{"alpha_deg": "…", "theta1_deg": "…", "theta2_deg": "…", "theta3_deg": "…",
                "b1_x": "…", "b1_y": "…", "multiplicity": 1,
                "x": "…", "y": "…", "phi_deg": "…"}],
     "curves": [{"kind": "curve", "alpha_deg": "0", "description": "…"}],
     "polynomial": {"variable": "t = tan(alpha/2)", "degree": 6, "coefficients": ["…", …],
                    "omega": "sqrt(…)", "omega_coefficients": ["…", …]},
     "certificate": {"method": "balls", "factors": [{"degree": 6, "multiplicity": 1}]}}

Poses are sorted by α, then θ1. A pose's multiplicity is the number of poses that coalesce in it:
1 regular, 2 on a singular curve, 3 at a cusp. ``x``, ``y`` and ``phi_deg`` are there if base or platform
were given by points. With condition numbers (:mod:`rpr_solver.model.conditioning`) there are
``"condition": {"length_scale": "sqrt(…)", "reference": "centroid"}``, and in each pose ``clearance_deg`` and
``condition``, which is null at a singular pose. ``curves`` is empty except for congruent triangles with equal
legs, and where the platform can turn about a joint that legs share, with ``"any"`` as ``alpha_deg``;
``count`` is then the number of isolated poses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from typing import Any, TypedDict

from rpr_solver.contract import DEFAULT_DIGITS, check_digits, document_head
from rpr_solver.exact.factors import FactorShape, shapes_json
from rpr_solver.exact.numerals import integer_text
from rpr_solver.exact.rationals import Exact, exact_str, parse_all, parse_positive, rational_sqrt
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.conditioning import condition_json
from rpr_solver.model.fibre import DEGREE, Closure, DecimalPose, Fibre, fibre
from rpr_solver.model.given_poses import digits_before, in_given_frame
from rpr_solver.model.joint_points import PoseKind
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import Row, counted, html_table, shortened, with_floats
from rpr_solver.notebook.figure import Figure, Pictured, draw
from rpr_solver.triangles import UserFrame


class PoseCertificate(TypedDict):
    """The proof of a table of poses: the factors of the sextic over ℚ(ω).

    ``method`` is ``"balls"`` if all roots are simple, else ``"exact"``.
    """

    method: str
    factors: list[FactorShape]


@dataclass(frozen=True)
class PlatformPose:
    """A pose, as correctly rounded decimals.

    Attributes:
        alpha_deg: the orientation of the platform, the angle of B1B2; angles are in degrees in (−180, 180].
        theta1_deg, theta2_deg, theta3_deg: the angles of the legs.
        b1_x, b1_y: the point B1, in the user's unit.
        multiplicity: the number of poses that coalesce in it: 1 regular, 2 on a singular curve, 3 at a cusp.
        x, y, phi_deg: where base or platform were given by points, the place of the platform's frame in that
            of the base, and its angle (:class:`~rpr_solver.triangles.UserFrame`); else None.
        condition: the condition number; None if it is infinite, or not asked for
            (:func:`~rpr_solver.paths.pose_conditions.with_condition`).
        clearance_deg: a proved lower bound of the distance to the nearest singular pose with the same L1:
            that far, in degrees, α and θ1 may change together. None if not asked for.

    >>> from rpr_solver import EXAMPLES, poses
    >>> poses(EXAMPLES["zein-flat"], 20, 20, 20, digits=15).poses[0]
    <PlatformPose alpha_deg=-121.85755… theta1_deg=32.522491… multiplicity=1>
    """

    alpha_deg: str
    theta1_deg: str
    theta2_deg: str
    theta3_deg: str
    b1_x: str
    b1_y: str
    multiplicity: int
    x: str | None = None
    y: str | None = None
    phi_deg: str | None = None
    condition: str | None = None
    clearance_deg: str | None = None

    def __repr__(self) -> str:
        angles = f"alpha_deg={shortened(self.alpha_deg)} theta1_deg={shortened(self.theta1_deg)}"
        return f"<PlatformPose {angles} multiplicity={self.multiplicity}>"

    def to_json(self) -> dict[str, Any]:
        """The document's pose object."""
        found = {name: value for name, value in asdict(self).items() if value is not None}
        return found if self.clearance_deg is None else {**found, "condition": self.condition}


@dataclass(frozen=True)
class DirectPolynomial:
    """A(t) + ω B(t) = 0, t = tan(α/2)/√ρ: the sixth-degree polynomial of direct kinematics, exact.

    If the triangles have axes of their own, α is measured from them, as :attr:`variable` says. The degree 6
    is formal: if the leading coefficients are 0, t = ∞ is a root.

    Attributes:
        a, b: the seven integer coefficients of A and of B, from the constant term; B is zero if the height
            of the platform is rational.
        radicand: ω².
        variable: the definition of t.

    >>> from rpr_solver import EXAMPLES, poses
    >>> poses(EXAMPLES["zein-flat"], 20, 20, 20, digits=15).polynomial
    <DirectPolynomial of degree 6 in tan(alpha/2) over ℤ>
    """

    a: tuple[int, ...]
    b: tuple[int, ...]
    radicand: int
    variable: str = "t = tan(alpha/2)"

    @classmethod
    def of(cls, closure: Closure) -> DirectPolynomial:
        """The sextic of the closure equations."""
        sextic, slice_map = closure.sextic, closure.slice_map
        a, b = (tuple(int(part[i]) for i in range(DEGREE + 1)) for part in (sextic.a, sextic.b))
        variable, _, _ = Bridge.of(slice_map).tangents(slice_map.fixed_leg).partition(", ")
        return cls(a, b, sextic.radicand, variable)

    def __repr__(self) -> str:
        field = f"ℤ[sqrt({shortened(integer_text(self.radicand))})]" if any(self.b) else "ℤ"
        return f"<DirectPolynomial of degree {DEGREE} in {self.variable[4:]} over {field}>"

    def to_json(self) -> dict[str, Any]:
        """Coefficients as decimal strings, ascending from the constant term."""
        parts = {"degree": DEGREE, "coefficients": [str(x) for x in self.a]}
        omega = {"omega": f"sqrt({self.radicand})", "omega_coefficients": [str(x) for x in self.b]}
        return {"variable": self.variable, **parts, **(omega if any(self.b) else {})}


@dataclass(frozen=True)
class PoseTable(Pictured):
    """All real poses of one joint vector.

    Proved: these are all real poses, and every multiplicity and every printed digit is right.

    Attributes:
        manipulator: the geometry.
        squares: L1², L2², L3², exact, in the user's unit.
        digits: significant digits of every printed number.
        poses: the poses by α, then by θ1.
        curves: the curves of poses where the platform is movable with all legs locked: of congruent triangles
            with equal legs, or about a joint that legs share; ``count`` is then the number of isolated poses.
        polynomial: the sextic.
        certificate: how the table is proved.
        length_scale: λ of the condition numbers, exact; None without these.

    >>> from rpr_solver import EXAMPLES, poses
    >>> poses(EXAMPLES["zein-flat"], 20, 20, 20, digits=15)
    <PoseTable L1=20 L2=20 L3=20: 2 poses, 15 digits>
    """

    manipulator: Manipulator
    squares: tuple[Fraction, Fraction, Fraction]
    digits: int
    poses: tuple[PlatformPose, ...]
    curves: tuple[Mapping[str, str], ...]
    polynomial: DirectPolynomial
    certificate: PoseCertificate
    length_scale: str | None = None

    def __repr__(self) -> str:
        legs = " ".join(f"{name.upper()}={shortened(text)}" for name, text in self.lengths.items())
        repeated = self.count_with_multiplicity
        several = f" ({repeated} with multiplicity)" if repeated != self.count else ""
        return f"<PoseTable {legs}: {counted(self.count, 'pose')}{several}, {self.digits} digits>"

    @property
    def lengths(self) -> dict[str, str]:
        """The leg lengths by name, exact: ``"14.98"``, ``"46/3"`` or ``"sqrt(2)"``, in the user's unit."""
        return {f"l{leg}": _length_text(square) for leg, square in enumerate(self.squares, 1)}

    @property
    def count(self) -> int:
        """The number of different real poses."""
        return len(self.poses)

    @property
    def count_with_multiplicity(self) -> int:
        """The number of real poses, counted with multiplicity."""
        return sum(pose.multiplicity for pose in self.poses)

    def to_json(self) -> dict[str, Any]:
        """The document described at the top of this module."""
        return {
            **document_head(self.manipulator, self.digits),
            **self.lengths,
            "count": self.count,
            "count_with_multiplicity": self.count_with_multiplicity,
            **({} if self.length_scale is None else {"condition": condition_json(self.length_scale)}),
            "poses": [pose.to_json() for pose in self.poses],
            "curves": [dict(curve) for curve in self.curves],
            "polynomial": self.polynomial.to_json(),
            "certificate": dict(self.certificate),
        }

    def rows(self) -> list[Row]:
        """A row for each pose, for ``pandas.DataFrame(table.rows())``.

        Lengths and angles are floats; ``alpha_deg_text`` has all digits of ``alpha_deg``, and so on.
        """
        return with_floats({**self.lengths, **pose.to_json()} for pose in self.poses)

    def _repr_html_(self) -> str:
        notes = [f"α = {curve['alpha_deg']}: {curve['description']}" for curve in self.curves]
        return html_table(
            repr(self)[1:-1], [pose.to_json() for pose in self.poses], notes, first=self.manipulator.remark
        )

    def figure(self, pose: int = 1) -> Figure:
        """A picture of the manipulator at one pose, with the other poses behind it.

        Args:
            pose: the number of the pose, from 1, in the order of ``poses``.

        Raises:
            InputError: naming ``pose``: there is no such pose.
        """
        return draw(self.to_json(), pose=pose)


def poses(
    manipulator: Manipulator, l1: Exact, l2: Exact, l3: Exact, *, digits: int = DEFAULT_DIGITS
) -> PoseTable:
    """All real poses with the given leg lengths, counted by proof: the direct kinematics.

    Args:
        manipulator: the geometry.
        l1: the length of leg 1, exact (see :data:`Exact`), > 0, in the user's unit.
        l2: the length of leg 2.
        l3: the length of leg 3.
        digits: significant digits of every printed number, 15 to 10000; all are proved.

    Raises:
        InputError: naming ``manipulator``, each length, or ``digits``.
        SolverError: the joint vector could not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> table = poses(EXAMPLES["innocenti"], "14.98", 15, 30, digits=15)
    >>> [(p.alpha_deg, p.theta1_deg, p.multiplicity) for p in table.poses]
    [('-130.806761043048', '23.6128999669840', 1), ('-5.27975966480067', '37.0140956869959', 1)]
    """
    lengths = parse_all({"l1": l1, "l2": l2, "l3": l3}, parse_positive)
    return _table(manipulator, [length**2 for length in lengths.values()], digits)


def poses_of_squares(
    manipulator: Manipulator,
    l1_squared: Exact,
    l2_squared: Exact,
    l3_squared: Exact,
    *,
    digits: int = DEFAULT_DIGITS,
) -> PoseTable:
    """As :func:`poses`, from the exact squares of leg lengths, which may be irrational.

    Args:
        manipulator: the geometry.
        l1_squared: L1², exact, > 0, in the user's unit squared; likewise ``l2_squared``, ``l3_squared``.
        l2_squared: L2².
        l3_squared: L3².
        digits: significant digits of every printed number, 15 to 10000; all are proved.

    Raises:
        InputError: naming ``manipulator``, each square, or ``digits``.
        SolverError: the joint vector could not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> poses_of_squares(EXAMPLES["innocenti"], 225, 200, 900, digits=15)
    <PoseTable L1=15 L2=sqrt(200) L3=30: 2 poses, 15 digits>
    """
    squares = {"l1_squared": l1_squared, "l2_squared": l2_squared, "l3_squared": l3_squared}
    return _table(manipulator, list(parse_all(squares, parse_positive).values()), digits)


def _table(manipulator: Manipulator, squares: Sequence[Fraction], digits: int) -> PoseTable:
    digits = check_digits(digits)
    s1, s2, s3 = squares
    closure = Closure.of(SliceMap.of(manipulator, with_shared=True), squares)
    solution = fibre(closure, digits)
    found = list(map(_platform_pose, solution.poses))
    if frame := UserFrame.of(manipulator.geometry):
        found = _in_given_frame(frame, found, fibre(closure, digits_before(digits)), digits)
    return PoseTable(
        manipulator,
        (s1, s2, s3),
        digits,
        tuple(found),
        _curves(solution, s1, manipulator),
        DirectPolynomial.of(closure),
        {"method": solution.method, "factors": shapes_json(solution.factors)},
    )


def _platform_pose(pose: DecimalPose) -> PlatformPose:
    alpha, theta1, theta2, theta3, x, y = pose.texts
    return PlatformPose(alpha, theta1, theta2, theta3, x, y, pose.multiplicity)


def _in_given_frame(
    frame: UserFrame, found: Sequence[PlatformPose], finer: Fibre, digits: int
) -> list[PlatformPose]:
    """The poses with x, y and φ, from the same with more digits."""
    placed = []
    for pose, known in zip(found, map(_platform_pose, finer.poses), strict=True):
        x, y, phi = in_given_frame(frame, (known.alpha_deg, known.b1_x, known.b1_y), digits)
        placed.append(replace(pose, x=x, y=y, phi_deg=phi))
    return placed


def _curves(solution: Fibre, s1: Fraction, manipulator: Manipulator) -> tuple[Mapping[str, str], ...]:
    if solution.turns:
        description = f"the platform turns about {manipulator.geometry.shared_joints} with all legs locked"
        return ({"kind": PoseKind.CURVE.value, "alpha_deg": "any", "description": description},)
    if solution.circle_at is None:
        return ()
    description = (
        f"the platform is translated with B1 anywhere on the circle of radius {_length_text(s1)} about A1"
    )
    return ({"kind": PoseKind.CURVE.value, "alpha_deg": str(solution.circle_at), "description": description},)


def _length_text(square: Fraction) -> str:
    root = rational_sqrt(square)
    return f"sqrt({exact_str(square)})" if root is None else exact_str(root)
