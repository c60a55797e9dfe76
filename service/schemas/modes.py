"""Assembly modes: the question whether they can change, and the answer."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from rpr_solver import exact_str
from rpr_solver.contract import PATH_DIGITS
from rpr_solver.errors import InputError
from rpr_solver.model.lengths import Bounds, LengthRange, limits_json, read_limits
from service.schemas.answers import DocumentHead
from service.schemas.document import given
from service.schemas.ends import Between
from service.schemas.lengths import OF_THE_FIXED_LEG, JointLimits, SlicesOfOneLeg
from service.schemas.model import Model
from service.schemas.numbers import FixedLeg, Length, fixed_leg_field
from service.schemas.path_answers import Path
from service.schemas.questions import Examples, Question
from worker.answers.modes import MODES


class ModeWitness(Model):
    """Two poses of one joint vector, and the path that joins them."""

    l1: str
    l2: str
    l3: str
    start: int = Field(alias="from", description="The number of the first pose in the answer of /v1/poses.")
    stop: int = Field(alias="to", description="The number of the second pose.")
    path: Path = Field(description="The path, as /v1/paths gives it.")


class RegionPoint(Model):
    """A joint vector, exact."""

    l1: str
    l2: str
    l3: str


class JoinedRegion(Model):
    """A region of the plane of the free legs, with those of its poses that are in one aspect."""

    point: RegionPoint = Field(description="A joint vector in the region.")
    poses: int = Field(description="The number of its poses.")
    joined: list[list[int]] | None = Field(
        description="The numbers of its poses in /v1/poses, in groups: a path without a singularity joins "
        "the poses of one group, and none joins poses of different groups. null if the region is too narrow "
        "to tell."
    )


class ModeCertificate(Model):
    """How the answer is proved."""

    method: Literal["witness", "folds", "similar"] | None = Field(
        description="`witness`: by the path. `folds`: by pairs of boxes of poses, none of which can hold "
        "folds of one joint vector. `similar`: base and platform are similar triangles of one sense, all "
        "aspects of which map one to one. null if it is not proved."
    )
    pairs: int | None = Field(
        description="The number of pairs of boxes that were examined; null if there was no need."
    )


class ModeChange(Model):
    """Whether the assembly mode can change without a singularity, as /v1/assembly-modes says."""

    change: Literal["possible", "impossible", "undecided"]
    witness: ModeWitness | None = Field(description="null unless it is possible.")
    reason: str | None = Field(description="Why it is undecided; null if it is not.")
    certificate: ModeCertificate


class AssemblyModes(DocumentHead):
    """Whether the assembly mode can change without a singularity."""

    asked: dict[str, Any] = Field(
        description="The slice (`l1`, `l2` or `l3`) or the `range`, and the `limits`."
    )
    change: Literal["possible", "impossible", "undecided"] = Field(
        description="Whether two poses of one joint vector are joined by a path without a singularity, in "
        "the slice, or while the fixed leg keeps the range, within the limits. `possible` and `impossible` "
        "are proved."
    )
    witness: ModeWitness | None = Field(description="null unless a change is possible.")
    regions: list[JoinedRegion] | None = Field(
        description="The regions of the slice, or those of the slices at both ends of the range, with the "
        "poses that are joined in the slice or in the range. null with limits, or if the singular curves "
        "are not supported."
    )
    reason: str | None = Field(description="Why it is undecided; null if it is not.")
    certificate: ModeCertificate


class AssemblyModesRequest(SlicesOfOneLeg, Question):
    """A manipulator, a slice or a range of the fixed leg, and joint limits of the other legs."""

    model_config = ConfigDict(json_schema_extra=OF_THE_FIXED_LEG)

    expected = "send an object with geometry and one of l1 and range"
    kinds = (MODES,)
    path = "/v1/assembly-modes"
    name = "post_assembly_modes"
    tag = ("assembly modes", "Whether they can change without a singularity.")
    summary = "Whether the assembly mode can change without a singularity"
    description = """\
For a slice, or a range of lengths of the fixed leg, and joint limits of the others: whether some joint vector
has two poses that a path without a singularity joins. If so, the answer has such a path, for example round a
cusp. If not, it is proved that every aspect maps one to one; that there is no cusp does not prove it. The
regions of the joint plane tell which of their poses are joined.

The response waits for a worker, which takes a fraction of a second for a slice and some seconds for a range,
up to 10 seconds unless `Prefer` says otherwise; after that it is 202 with a job.
"""
    answer = AssemblyModes
    known = "The answer."
    implied_wait = 10
    needs_slices = False
    examples: ClassVar[Examples] = {
        "slice": ("The article's first manipulator at L1 = 27", {"l1": 27}),
        "range": ("Leg 1 between 0.05 and 0.1", {"range": {"from": "0.05", "to": "0.1"}}),
        "limits": (
            "A slice within joint limits",
            {"l1": 27, "limits": {"l2": {"min": 20, "max": 30}, "l3": {"min": 20, "max": 30}}},
        ),
    }

    fixed_leg: FixedLeg = fixed_leg_field()
    l1: Length | None = given("The length of leg 1 in a slice. With `fixed_leg` 2 or 3 use `l2` or `l3`.")
    l2: Length | None = given("The length, with `fixed_leg` 2.")
    l3: Length | None = given("The length, with `fixed_leg` 3.")
    range: Between | None = given("The lengths between which the fixed leg may vary, instead of a slice.")
    limits: JointLimits | None = given("Joint limits of the other legs, an end of which may be missing.")

    @property
    def length(self) -> Fraction | None:
        """The length of the fixed leg of a slice."""
        length: Fraction | None = getattr(self, f"l{self.fixed_leg}")
        return length

    @model_validator(mode="after")
    def _is_one_question(self) -> Self:
        if (self.length is None) == (self.range is None):
            own = f"l{self.fixed_leg}"
            raise InputError.of(own, f"give exactly one of {own} and range")
        if self.range is not None:
            LengthRange.of(self.range.start, self.range.stop, ("range.from", "range.to"))
        self._bounds()
        return self

    def _bounds(self) -> dict[int, Bounds]:
        return {} if self.limits is None else read_limits(self.limits.bounds(), "limits", self.fixed_leg)

    def content(self) -> dict[str, Any]:
        """Returns the canonical form of the question."""
        own: dict[str, Any] = {}
        if self.length is not None:
            own["length"] = exact_str(self.length)
        if self.range is not None:
            own["range"] = {"from": exact_str(self.range.start), "to": exact_str(self.range.stop)}
        return {
            "geometry": self.geometry.to_json(),
            "fixed_leg": self.fixed_leg,
            **own,
            **({"limits": limits_json(bounds)} if (bounds := self._bounds()) else {}),
            "digits": PATH_DIGITS,
        }

    def _asked(self) -> dict[str, Any]:
        content = self.content()
        del content["digits"]
        length = {f"l{self.fixed_leg}": content.pop("length")} if "length" in content else {}
        return {**length, **content}
