"""Questions in the words of the library: a function for each, whose arguments follow from its question."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from inspect import Parameter
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel

from rpr_solver import Manipulator, Requirement, exact_str
from rpr_solver.along.leg_poses import held_lengths
from rpr_solver.contract import LEGS
from rpr_solver.model.lengths import limits_json, read_limits
from service.client.bodies import Asked
from service.schemas.censuses import CensusRequest, CheckRequest, RequirementDocument
from service.schemas.curves import CuspCurvesRequest, MarginRequest
from service.schemas.designs import Budget, DesignRequest, VaryRange
from service.schemas.document import Source, read
from service.schemas.lengths import ENDS, Changes, JointLimits, OpenRange, SliceRange
from service.schemas.limits import Limits
from service.schemas.modes import AssemblyModesRequest, ModeRange, PoseConnectionsRequest
from service.schemas.motions import AskedMotion, AskedSampling, Path
from service.schemas.paths import AngledPose, AskedJoints, Between, NumberedPose, PathRequest
from service.schemas.plots import PlotRequest, VerificationRequest
from service.schemas.poses import (
    AspectsRequest,
    LegPoses,
    PosesRequest,
    PoseTable,
    SensedPoses,
    SingularCurvesRequest,
)
from service.schemas.questions import Question
from service.schemas.tables import CuspTableRequest
from service.schemas.workspaces import WorkspaceAt, WorkspaceRequest, WorkspaceSweep


@dataclass(frozen=True)
class Function:
    """A function that asks a question.

    Attributes:
        summary: its docstring.
        question: what it asks.
        placed: the arguments that may stand by place after the manipulator, `?` behind those that may be
            missing; all others are given by name.
        without: members of the question that it does not ask for.
        also: more arguments, with their types.
        answer: the model of the document, if its question has several.
    """

    summary: str
    question: type[Question]
    placed: str = ""
    without: str = ""
    also: Mapping[str, str] = field(default_factory=dict)
    answer: type[BaseModel] | None = None

    @property
    def model(self) -> type[BaseModel]:
        """The model of the answer."""
        return self.answer or self.question.answer

    def parameters(self) -> Iterator[Parameter]:
        """Yields its parameters, with types as text."""
        if self.question.names_geometry:
            yield Parameter("manipulator", Parameter.POSITIONAL_OR_KEYWORD, annotation="Manipulator")
        types = dict(self._types())
        for word in self.placed.split():
            name = word.removesuffix("?")
            default = Parameter.empty if name == word else None
            kind, text = Parameter.POSITIONAL_OR_KEYWORD, types.pop(name)
            yield Parameter(name, kind, annotation=_given(text, default), default=default)
        for name, text in types.items():
            yield Parameter(name, Parameter.KEYWORD_ONLY, annotation=_given(text, None), default=None)

    def _types(self) -> Iterator[tuple[str, str]]:
        """Yields the arguments and the types of their values."""
        names, legs = self._members(), self.placed.split()
        for name, annotation in names.items():
            text = _WORDS.get(name) or " | ".join(dict.fromkeys(_types_in(annotation)))
            if name == "range":
                yield from [("between", text)] if text == _ENDS else [("start", "Exact"), ("stop", "Exact")]
            elif name in LEGS and name not in legs:
                if name == LEGS[0]:
                    yield (
                        ("lengths", "Exact | Iterable[Exact]")
                        if get_origin(annotation) is tuple
                        else ("length", "Exact")
                    )
            else:
                yield _ENDS_OF_PATHS.get(name, name) if "from" in names else name, text
        yield from self.also.items()
        yield "deadline", "float"

    def _members(self) -> dict[str, Any]:
        kept = {info.alias or name: info.annotation for name, info in self.question.model_fields.items()}
        return {name: kept[name] for name in kept if name not in (*_UNASKED, *self.without.split())}

    def members(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Returns what is given as members of the question."""
        found = {word: value for word, value in given.items() if value is not None}
        names, leg = self._members(), found.get("fixed_leg", 1)
        ends = found.pop("start", None), found.pop("stop", None)
        if "angles" in self.also:
            found |= {**found.pop("lengths"), **found.pop("angles")}
        if "step" in self.also:
            found["phi"] = dict(zip(ENDS, (*ends, found.pop("step")), strict=True))
        found |= self._legs(leg, found.pop("length", None), found.pop("lengths", None), ends)
        if ends != (None, None) and "from" in names:
            found |= zip(_ENDS_OF_PATHS, ends, strict=True)
        elif ends != (None, None) and "range" in names:
            found["range"] = ends
        if "between" in found and "between" not in names:
            found["range"] = found.pop("between")
        for name in _FORMS.keys() & found.keys() & names.keys():
            found[name] = _FORMS[name](found[name])
        if "limits" in found:
            found["limits"] = limits_json(read_limits(found["limits"], "limits", held=leg))
        if "to" in found and "from" not in names:
            found["to"] = dict(zip(LEGS, found["to"], strict=True))
        return found

    def _legs(self, leg: int, length: object, lengths: Any, ends: tuple[Any, Any]) -> dict[str, Any]:
        """The lengths of legs: of the fixed one, once or several times; of all three; or of two by their
        names, and the ends of the third."""
        if length is not None:
            return {f"l{leg}": length}
        if "lengths" not in self.also:
            return {f"l{leg}": several} if (several := _several(lengths)) else {}
        if "start" in self.also:
            held = held_lengths(lengths)
            return {name: held.get(name, ends) for name in LEGS}
        return dict(zip(LEGS, lengths or (), strict=False))


_LIMITS = ("max_slices", "max_article_slices", "max_samples")
_NO_LIMIT = 1_000_000
_UNASKED = ("geometry", "deadline_seconds", "callback_url")

_MANY = "Exact | Iterable[Exact]"
_ENDS_OF_PATHS = {"from": "start", "to": "stop"}
_ENDS = "tuple[Exact, Exact | None]"
_WORDS = {
    "cusp": "int | str",
    "clearance": "Exact | str",
}
"""Argument → type, if it follows from no type of its member."""

_TYPES: Mapping[Any, str] = {
    **{Fraction: "Exact", OpenRange: _ENDS + " | tuple[None, Exact]", ModeRange: _ENDS},
    **{
        SliceRange: "Mapping[str, Exact]",
        Between: "tuple[Exact, Exact]",
        Changes: "Mapping[str, Exact]",
        JointLimits: "ExactLimits",
    },
    **{AskedMotion: "MotionQuestion", AskedSampling: "Sampling", RequirementDocument: "Requirement"},
    **{NumberedPose: "Mapping[str, Exact]", AngledPose: "Mapping[str, Exact]"},
    **{AskedJoints: "Sequence[Exact]", VaryRange: "Sequence[Exact]", Budget: "int"},
}
"""Type of a member → type of an argument."""


def _types_in(annotation: Any) -> Iterator[str]:
    """Yields the types of the arguments for a member."""
    if annotation is type(None):
        return
    if annotation in _TYPES:
        yield _TYPES[annotation]
    elif get_origin(annotation) is Literal:
        yield f"Literal{list(get_args(annotation))}"
    elif get_origin(annotation) is dict:
        yield f"Mapping[str, {next(_types_in(get_args(annotation)[1]))}]"
    elif get_origin(annotation) is tuple:
        yield f"Sequence[{next(_types_in(get_args(annotation)[0]))}]"
    elif parts := get_args(annotation):
        for part in parts[:1] if hasattr(annotation, "__metadata__") else parts:
            yield from _types_in(part)
    else:
        yield "Any" if annotation is Any else annotation.__name__


def _given(text: str, default: object) -> str:
    return text if default is Parameter.empty else f"{text} | None"


def _several(lengths: Any) -> list[Any]:
    """One length or several; none if it is None."""
    if isinstance(lengths, Iterable) and not isinstance(lengths, str):
        return list(lengths)
    return [] if lengths is None else [lengths]


def _varied(vary: Any) -> object:
    return {name: (*ends,) for name, ends in vary.items()} if isinstance(vary, Mapping) else vary


_FORMS: Mapping[str, Callable[[Any], object]] = {
    "between": tuple,
    "range": tuple,
    "fixed": list,
    "vary": _varied,
    "budget": lambda censuses: {"censuses": censuses},
}
"""Member → its value of an argument."""

_ANGLES = "angle1 angle2 angle3 angle_tolerance_deg"

FUNCTIONS: Mapping[str, Function] = {
    "cusp_table": Function("The cusps of slices.", CuspTableRequest, "lengths"),
    "census": Function("Every length at which the number of cusps changes.", CensusRequest),
    "cusp_curves": Function(
        "Each cusp followed from where it appears to where it vanishes.", CuspCurvesRequest
    ),
    "check": Function(
        "Whether a manipulator satisfies a requirement on its cusps.", CheckRequest, "requirement"
    ),
    "poses": Function(
        "All poses with given lengths of the legs.", PosesRequest, "l1 l2 l3", _ANGLES, answer=PoseTable
    ),
    "leg_poses": Function(
        "The numbers of poses at all lengths of one leg; `lengths` has those of both others, by their names.",
        *(PosesRequest, "lengths start? stop?", f"l1 l2 l3 {_ANGLES} condition length_scale"),
        also={"lengths": "Mapping[str, Exact]", "start": "Exact", "stop": "Exact"},
        answer=LegPoses,
    ),
    "sensed_poses": Function(
        "All poses with lengths of some legs and angles of some, by their names; together at least three.",
        *(PosesRequest, "lengths angles", "l1 l2 l3 angle1 angle2 angle3 condition length_scale"),
        also={"lengths": "Mapping[str, Exact]", "angles": "Mapping[str, Exact]"},
        answer=SensedPoses,
    ),
    "singular_curves": Function(
        "The singular curves of a slice, the number of poses in each region, and the aspects.",
        *(SingularCurvesRequest, "length"),
    ),
    "aspects": Function(
        "The aspects while the length of one leg varies within a range; an end that is missing is open.",
        *(AspectsRequest, "start? stop?"),
    ),
    "workspace": Function(
        "The places that the limits of legs allow at an orientation, and the singular conic.",
        *(WorkspaceRequest, "phi limits"),
        answer=WorkspaceAt,
    ),
    "workspace_sweep": Function(
        "The areas and the numbers of regions of workspaces at several orientations.",
        *(WorkspaceRequest, "start stop step limits", "phi"),
        also={"start": "Exact", "stop": "Exact", "step": "Exact"},
        answer=WorkspaceSweep,
    ),
    "margin": Function(
        "How far the lengths may change before a slice, a requirement or a window loses its number of cusps.",
        *(MarginRequest, "length?"),
    ),
    "design": Function(
        "A geometry near a given one with a longer range, a smaller change, a larger margin, or more cusps.",
        *(DesignRequest, "objective requirement?"),
    ),
    "plot": Function(
        "A picture: a slice and a loop have the length of the fixed leg, the mechanism all three lengths, or "
        "a length and a cusp, the others a range.",
        *(PlotRequest, "plot?"),
        also={"lengths": "tuple[Exact, Exact, Exact]"},
    ),
    "verify_document": Function(
        "A verification of a document by independent means.", VerificationRequest, "document"
    ),
    "cusp_loop": Function(
        "A loop of the leg lengths round a cusp, without a singularity, from one pose to another.",
        *(PathRequest, "length cusp", "from to between"),
        answer=Path,
    ),
    "joint_path": Function(
        "A path without a singularity from one pose of a joint vector to another, or why there is none.",
        *(PathRequest, "l1 l2 l3 start stop", "cusp"),
        answer=Path,
    ),
    "pose_path": Function(
        "A path without a singularity from any pose to any other one, or why there is none.",
        *(PathRequest, "start stop", "l1 l2 l3 cusp"),
        answer=Path,
    ),
    "pose_connections": Function(
        "Which poses of a joint vector, or of two, are joined by paths without a singularity.",
        *(PoseConnectionsRequest, "l1 l2 l3"),
    ),
    "assembly_modes": Function(
        "Whether the assembly mode can change without a singularity, in a slice or in a range.",
        *(AssemblyModesRequest, "length?"),
    ),
}
"""Name → function."""


def _plain(value: Any) -> object:
    """A value in the words of the library as a member: exact numbers as text, two ends as a range.

    >>> _plain({"range": (27, None), "lengths": [28, "55/2"]})
    {'range': {'from': '27', 'to': None}, 'lengths': ['28', '55/2']}
    """
    if value is None or isinstance(value, bool | str | Manipulator):
        return value
    if isinstance(value, Requirement):
        return value.to_json()
    if isinstance(value, tuple) and len(value) == 2:
        return {"from": _plain(value[0]), "to": _plain(value[1])}
    if isinstance(value, Mapping):
        return {name: _plain(part) for name, part in value.items()}
    return list(map(_plain, value)) if isinstance(value, Iterable) else exact_str(value)


def made(name: str) -> Callable[..., Asked[Any]]:
    """Returns the function of this name."""
    function = FUNCTIONS[name]
    question, model = function.question, function.model
    signature = inspect.Signature([*function.parameters()], return_annotation=f"Asked[{model.__name__}]")

    def ask(*placed: object, **named: object) -> Asked[Any]:
        words = signature.bind(*placed, **named).arguments
        manipulator, seconds = words.pop("manipulator", None), words.pop("deadline", None)
        given = function.members(words)
        if question.names_geometry:
            given = {"geometry": manipulator, **{name: _plain(value) for name, value in given.items()}}
        if seconds is not None:
            given["deadline_seconds"] = str(seconds)
        # the service has the limits that count
        limits = Limits.of_environment(**dict.fromkeys(_LIMITS, _NO_LIMIT))
        return Asked(read(question, given, Source(limits, is_text=True)), model)

    ask.__name__ = ask.__qualname__ = name
    ask.__module__ = "service.client"
    ask.__doc__ = f"{function.summary}\n\nRaises:\n    InputError: naming every fault.\n"
    ask.__signature__ = signature  # type: ignore[attr-defined]
    return ask
