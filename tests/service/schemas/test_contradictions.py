"""Each member of a question counts in its answer, or is refused; none is ignored."""

from __future__ import annotations

from typing import Any

import pytest

from rpr_solver import EXAMPLES, InputError, Requirement, cusp_loop, design, margin
from service.schemas.curves import MarginRequest
from service.schemas.document import JsonNumber, Source, read
from service.schemas.limits import Limits
from service.schemas.paths import PathRequest
from service.schemas.questions import EXAMPLE_GEOMETRY, Question
from service.schemas.registry import all_questions
from tests.support.sampling import long

INNOCENTI = EXAMPLES["innocenti"]
JOINTS = {"l1": 27, "l2": 20, "l3": 21}
VALUES: dict[str, list[Any]] = {
    "fixed_leg": [2, 3], "digits": [31], "l1": [13], "l2": [13], "l3": [12], "method": ["article"],
    "range": [{"from": 12, "to": 30}, {"from": 3}], "samples": [7],
    "requirement": [{"fixed_leg": leg, "range": {"from": 2, "to": 40}, "max_cusps": 7} for leg in (1, 2)],
    "window": [14], "tolerance": [0.002, {"d1": 0.01}], "weights": [{"d1": 2}], "sensitivities": [True],
    "limits": [{f"l{leg}": {"min": 1, "max": 40}} for leg in (1, 2, 3)],
    "from": [1, {**JOINTS, "pose": 1}], "to": [2, JOINTS, {**JOINTS, "pose": 1}],
    "between": [{"from": 20, "to": 30}], "clearance": ["best", 0.5], "cusp": ["B"], "timing": ["constant"],
    "others": [True], "duration": [3], "motion": [{"speed": 3, "acceleration": 4}],
    "sampling": [{"chord": 0.1}, {"number": 7}, {"step": 1}], "parts": [True],
    "objective": ["most-cusps", "longest-range"], "vary": ["5%", {"d1": {"from": 16, "to": 18}}],
    "fixed": [["d1"]], "family": ["isosceles-1"], "decimals": [2], "min_height": [1],
    "ignore_windows": [0.01], "loop": ["required"], "min_aspects": [2], "max_aspects": [9],
    "condition": [True], "length_scale": [2.5], "max_condition": [40],
    "budget": [{"censuses": 44}], "seed": [5], "plot": ["census", "mechanism", "loop"],
    "angle1": [40], "angle2": [40], "angle3": [40], "angle_tolerance_deg": [0.5], "phi": [31],
    "theme": ["dark"], "pose": [2], "width_mm": [90], "style": ["paper"], "unit": ["mm"], "labels": ["none"],
}  # fmt: skip
"""Values that are not those of a question without the member."""
IMPLIED = {"condition": {"length_scale", "max_condition"}}
"""A member that is asked for by others, too."""
APART = {"geometry", "deadline_seconds", "callback_url", "document"}


def as_sent(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: as_sent(one) for name, one in value.items()}
    if isinstance(value, list):
        return [as_sent(one) for one in value]
    return JsonNumber(str(value)) if type(value) in (int, float) else value


def asked(question: type[Question], body: dict[str, Any]) -> str | None:
    """The id of the job, or None if the question is refused."""
    try:
        return read(question, body, Source(Limits())).job_request().job_id
    except InputError:
        return None


@pytest.mark.parametrize("pairs", [False, long(True)])
@pytest.mark.parametrize("question", all_questions(), ids=lambda question: question.__name__)
def test_none_is_ignored(question: type[Question], pairs: bool) -> None:
    names = [name for name in question._names() if name not in APART]
    assert set(names) <= VALUES.keys()
    more = [(name, as_sent(value)) for name in names for value in VALUES[name]]
    bodies = [as_sent({"geometry": EXAMPLE_GEOMETRY, **body}) for _, body in question.examples.values()]
    if pairs:
        bodies += [{**body, name: value} for body in bodies for name, value in more if name not in body]
    for body in bodies:
        before = asked(question, body)
        for name, value in more:
            if before is not None and name not in body and not body.keys() & IMPLIED.get(name, set()):
                assert asked(question, {**body, name: value}) != before, (name, value, body)


def test_a_requirement_names_its_leg() -> None:
    wish = {"fixed_leg": 2, "range": {"from": 2, "to": 40}, "max_cusps": 7}
    body = as_sent({"geometry": EXAMPLE_GEOMETRY, "requirement": wish})
    for leg in (1, 3):
        with pytest.raises(InputError, match=f"fixed_leg: is {leg}, but the requirement is about leg 2"):
            read(MarginRequest, {**body, "fixed_leg": JsonNumber(leg)}, Source(Limits()))
        with pytest.raises(InputError, match=f"fixed_leg: is {leg}, but the requirement is about leg 2"):
            margin(INNOCENTI, requirement=Requirement(2, 2, 40, 7), fixed_leg=leg)
    assert asked(MarginRequest, {**body, "fixed_leg": JsonNumber(2)}) == asked(MarginRequest, body)


@pytest.mark.parametrize(
    ("options", "field"),
    [({"samples": 5, "sampling": {"chord": 1}}, "samples")],
)
def test_samples_are_asked_for_in_one_way(options: Any, field: str) -> None:
    with pytest.raises(InputError, match=f"{field}: follows from"):
        cusp_loop(INNOCENTI, 27, "B", **options)


def test_condition_numbers_are_wanted_or_not() -> None:
    body = as_sent({"geometry": EXAMPLE_GEOMETRY, **JOINTS, "from": 1, "to": 2})
    asked_for = asked(PathRequest, {**body, "max_condition": JsonNumber("40")})
    assert asked_for != asked(PathRequest, body)
    assert asked_for == asked(PathRequest, {**body, "max_condition": JsonNumber("40"), "condition": True})
    with pytest.raises(InputError, match="condition: is false, but max_condition is given"):
        read(PathRequest, {**body, "max_condition": JsonNumber("40"), "condition": False}, Source(Limits()))


def test_what_is_fixed_has_no_bounds() -> None:
    wish = Requirement(start=21, stop=26, max_cusps=4)
    with pytest.raises(InputError, match="fixed: has d1, which also has bounds in vary"):
        design(
            INNOCENTI, "longest-range", wish, vary={"d1": (16, 18), "d2": (15, 18)}, fixed=["d1"], budget=2
        )
