"""Direct kinematics: the question, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from pydantic import ConfigDict, Field

from service.schemas.model import Model
from service.schemas.numbers import Digits, Length, digits_field
from service.schemas.points import Decimal, GeometryText, optional
from service.schemas.questions import Examples, Question
from worker.answers.documents import POSES
from worker.answers.requests import Kind


class PosesRequest(Question):
    """A manipulator and the lengths of its legs."""

    expected: ClassVar[str] = "send an object with geometry, l1, l2 and l3"
    kinds: ClassVar[Sequence[Kind]] = (POSES,)
    examples: ClassVar[Examples] = {
        "legs": (
            "The article's first manipulator with three given legs",
            {"l1": 14.98, "l2": 15, "l3": 30, "digits": 30},
        )
    }

    l1: Length = Field(description="Length of leg 1; > 0.")
    l2: Length = Field(description="Length of leg 2; > 0.")
    l3: Length = Field(description="Length of leg 3; > 0.")
    digits: Digits = digits_field()

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        return self.model_dump()


class Pose(Model):
    """A pose of the platform. Angles are degrees in (−180, 180]."""

    alpha_deg: Decimal = Field(description="Orientation of the platform.")
    theta1_deg: Decimal = Field(description="Angle of leg 1.")
    theta2_deg: Decimal = Field(description="Angle of leg 2.")
    theta3_deg: Decimal = Field(description="Angle of leg 3.")
    b1_x: Decimal = Field(description="x of the platform's point B1.")
    b1_y: Decimal = Field(description="y of the platform's point B1.")
    multiplicity: int = Field(
        description="Number of poses that coalesce here: 1 regular, 2 on a singular curve, 3 at a cusp."
    )


class PoseCurve(Model):
    """A whole curve of poses: congruent triangles with equal legs have one."""

    kind: str
    alpha_deg: str
    description: str


class PosePolynomial(Model):
    """The polynomial of direct kinematics, exact: Σ (coefficients[i] + omega · omega_coefficients[i]) tⁱ."""

    variable: str
    degree: int
    coefficients: list[str]
    omega: str | None = optional("The square root; missing if it is rational.")
    omega_coefficients: list[str] | None = optional(
        "The coefficients of the square root; missing if it is rational."
    )


class PoseCertificate(Model):
    """The proof of the count."""

    model_config = ConfigDict(extra="allow")

    method: str
    factors: list[dict[str, Any]]
    working_bits: int


class PoseTable(Model):
    """All real poses of one joint vector, sorted by α, then θ1."""

    geometry: GeometryText
    geometry_hash: str
    digits: int
    solver_version: str
    l1: str
    l2: str
    l3: str
    count: int = Field(description="Number of distinct isolated poses.")
    count_with_multiplicity: int
    poses: list[Pose]
    curves: list[PoseCurve]
    polynomial: PosePolynomial
    certificate: PoseCertificate
