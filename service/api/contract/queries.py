"""The parameters of questions that are asked by GET."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rpr_solver.contract import LEGS
from service.api.contract.responses import (
    FORM,
    REF,
    USUAL_WAIT,
    WAIT,
    parameter,
    ref,
    shared,
)
from service.schemas.columns import COLUMNS as GEOMETRY
from service.schemas.columns import ORIENTATION, POINTS, SIDES, SIX
from service.schemas.lengths import LIMIT_COLUMNS, PHI_COLUMNS, SLICE_COLUMNS
from service.schemas.numbers import NUMBER_PATTERN, POSITIVE_PATTERN, list_pattern
from service.schemas.questions import Question

_NUMBER = {"type": "string", "pattern": NUMBER_PATTERN}
_POSITIVE = {"type": "string", "pattern": POSITIVE_PATTERN}
_ROOT = ref("ExactRoot")
_SIDE = ref("Side")
_OF_GEOMETRY = (
    "Of the geometry, as in the body of POST. Give the six numbers a2x, a3x, a3y, d1, d2 and d3, or two "
    "triangles by points or by sides."
)
_OF_POINTS = "Of a geometry by points, the corners of base and platform; give all twelve."
_OF_SIDES = "Of a geometry by the sides of base and platform; give all six."
_LENGTHS = "Lengths of the fixed leg, with semicolons between them."
_QUERY: Mapping[str, tuple[str, dict[str, Any]]] = {
    **dict.fromkeys(POINTS, (_OF_POINTS, _ROOT)),
    **dict.fromkeys(SIDES, (_OF_SIDES, _SIDE)),
    **dict.fromkeys(SIX[:3], (_OF_GEOMETRY, _ROOT)),
    **dict.fromkeys(SIX[3:], (_OF_GEOMETRY, _SIDE)),
    "fixed_leg": ("The leg whose length is given, 1 if missing.", ref("FixedLeg")),
    ORIENTATION: ("Of the platform, if it has no points.", ref("Orientation")),
    **dict.fromkeys(LEGS, (_LENGTHS, {"type": "string", "pattern": list_pattern(POSITIVE_PATTERN)})),
    **dict.fromkeys(SLICE_COLUMNS, ("Of a range of lengths of the fixed leg.", _NUMBER)),
    PHI_COLUMNS[0]: ("The orientation in degrees; or `phi_from`, `phi_to` and `phi_step`.", _NUMBER),
    **dict.fromkeys(PHI_COLUMNS[1:], ("Of several orientations, in steps.", _NUMBER)),
    **dict.fromkeys(LIMIT_COLUMNS, ("A joint limit of a leg.", _NUMBER)),
    "width_mm": ("For print: the width in millimetres, 80 to 400.", _POSITIVE),
    "cusp": (
        "Of a loop, or of the mechanism: the number or the letter of a cusp.",
        {"type": "string", "pattern": "^([A-Xa-x]|[1-9]|1[0-9]|2[0-4])$"},
    ),
    "tolerance": (
        "A change of all lengths of the geometry: the answer must hold for every geometry within it.",
        _POSITIVE,
    ),
    WAIT: (
        f"Seconds to wait for an answer that is not known yet; {USUAL_WAIT} if missing.",
        {"type": "integer", "minimum": 0},
    ),
}
"""Parameters of queries that are not as the members of the body: their descriptions and schemas."""
_OF_PARAMETER = ("$ref", "type", "enum", "pattern", "minimum", "maximum")


def query_parameters(question: type[Question]) -> list[dict[str, Any]]:
    """Returns the parameters of a question that is asked by GET."""
    members = question.model_json_schema(ref_template=REF)["properties"]

    def described(name: str) -> dict[str, Any]:
        if name in SHARED:
            return shared("parameters", name)
        member = members[name]
        if "enum" in member:
            text = f"{member['description']} One of {', '.join(map(str, member['enum']))}."
            return parameter(name, text, {"type": "string"}, place="query")
        as_member = {key: member[key] for key in _OF_PARAMETER if key in member}
        return parameter(name, member["description"], as_member, place="query")

    own = [described(name) for name in (*GEOMETRY, *question.columns, WAIT)]
    return [*own, FORM, shared("parameters", "If-None-Match")]


SHARED = {name: parameter(name, text, schema, place="query") for name, (text, schema) in _QUERY.items()}
"""Parameters that several queries have."""
