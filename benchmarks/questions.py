"""Questions of every kind, made from the examples of the service and changed at random, as items of a batch.

Manipulators come from families of equal, nearly equal and very different sides; numbers become longer, lists
fuller, options take other values. Kinds and options are those of the service's operations, so a new kind is
covered at once.
"""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from random import Random
from typing import Any

from rpr_solver import exact_str
from service.schemas import all_questions, by_kind
from service.schemas.plots import VerificationRequest
from service.schemas.questions import EXAMPLE_GEOMETRY

Body = dict[str, Any]
Place = tuple[Any, Any]
"""A container, and the key or index of one of its elements."""

_NUMBER = re.compile(r"-?\d+(\.\d+)?")
_NAMES = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
_ROOT_OF_3 = Fraction("1.7320508075688772935274463415058723669428052538103806280558069794519330169088")
_DIGITS = (15, 16, 30, 90, 300, 1000)
_LEGS = ("l1", "l2", "l3", "length")
_LONGEST_LIST = 300

_SHAPES = {
    "usual": ("15.91", "0", "10", "17.04", "16.54", "20.84"),
    "round": ("10", "3", "7", "5", "6", "8"),
    "heron": ("14", "5", "12", "14", "15", "13"),
    "mirrored": ("14", "5", "12", "14", "13", "15"),
    "similar": ("14", "5", "12", "28", "30", "26"),
    "isosceles": ("6", "3", "4", "6", "5", "5"),
    "flat base": ("10", "4", "0", "5", "6", "8"),
    "flat platform": ("10", "4", "3", "5", "6", "11"),
    "both flat": ("10", "5", "0", "10", "5", "5"),
    "flat, unlike": ("10", "3", "0", "5", "6", "11"),
    "equal sides": ("2", "1", "1", "2", "1.5", "1.5"),
    "right": ("3", "0", "4", "3", "5", "4"),
}


def seeds() -> dict[str, list[Body]]:
    """Kind → the examples of its question, those that another kind would answer too."""
    found: dict[str, list[Body]] = {}
    for question in all_questions():
        head = {"geometry": EXAMPLE_GEOMETRY} if question.names_geometry else {}
        examples = [body for _, body in question.examples.values()]
        bodies = [json.loads(json.dumps({**head, **body})) for body in examples]
        for kind in question.kinds:
            found[kind.name] = copy.deepcopy(bodies)
    return found


def to_verify(document: Mapping[str, Any]) -> Body:
    """The question whether a document is right."""
    return {"document": json.loads(json.dumps(document))}


def is_verification(kind: str) -> bool:
    """Whether questions of a kind are about documents."""
    return by_kind()[kind] is VerificationRequest


def changed(kind: str, body: Body, rng: Random) -> Body:
    """Returns a body after one to three changes at random; the service may refuse it."""
    body = copy.deepcopy(body)
    for _ in range(rng.choice((1, 1, 2, 3))):
        rng.choice(_CHANGES)(kind, body, rng)
    return body


def geometry(rng: Random) -> dict[str, str]:
    """A manipulator: a shape, perhaps out of shape by very little, of long numbers, or of uneven sizes."""
    sides = [Fraction(x) for x in rng.choice(list(_SHAPES.values()))]
    if rng.random() < 0.15:
        sides = [Fraction(rng.randint(1, 300), rng.choice((1, 10, 7))) for _ in sides]
    if rng.random() < 0.1:  # an equilateral base, as far as its digits go
        sides[:3] = [Fraction(2), Fraction(1), round(_ROOT_OF_3, rng.randint(2, 70))]
    if rng.random() < 0.6:
        little = Fraction(rng.randint(1, 19), 10 ** _places(rng))
        for k in rng.sample(range(6), rng.choice((1, 1, 2, 6))):
            sides[k] += rng.choice((-1, 1, 2)) * little
    if rng.random() < 0.15:
        k = rng.randrange(6)
        sides[k] *= Fraction(10) ** rng.randint(-60, 60)
    if rng.random() < 0.15:
        places = _places(rng)
        sides = [x + Fraction(rng.randrange(10**places), 10 ** (places + 2)) for x in sides]
    texts = dict(zip(_NAMES, map(exact_str, sides), strict=True))
    return {**texts, "orientation": rng.choice(("ccw", "cw"))}


def _places(rng: Random) -> int:
    return rng.choice((rng.randint(1, 12), rng.randint(1, 40), rng.randint(1, 150)))


def _new_geometry(kind: str, body: Body, rng: Random) -> None:
    if is_verification(kind):
        body = body["document"]
    body["geometry"] = geometry(rng)


def _other_side(kind: str, body: Body, rng: Random) -> None:
    own = body["document"]["geometry"] if is_verification(kind) else body["geometry"]
    name = rng.choice(_NAMES)
    own[name] = _longer(str(own[name]), rng)


def _other_number(_kind: str, body: Body, rng: Random) -> None:
    places = [place for place in _leaves(body) if _is_number(place)]
    if places:
        container, key = rng.choice(places)
        container[key] = _longer(str(container[key]), rng)


def _other_length(_kind: str, body: Body, rng: Random) -> None:
    sides = [Fraction(str(body.get("geometry", EXAMPLE_GEOMETRY)[name])) for name in _NAMES]
    length = abs(rng.choice(sides) + rng.choice((-1, 0, 1)) * rng.choice(sides))
    length += rng.choice((0, 0, 1)) * Fraction(rng.randint(-9, 9), 10 ** _places(rng))
    if rng.random() < 0.2:
        length = Fraction(10) ** rng.randint(-150, 150)
    for name in _LEGS:
        if name in body and length > 0:
            body[name] = exact_str(length)


def _other_digits(kind: str, body: Body, rng: Random) -> None:
    (body["document"] if is_verification(kind) else body)["digits"] = rng.choice(_DIGITS)


def _other_leg(_kind: str, body: Body, rng: Random) -> None:
    leg = rng.choice((1, 2, 3))
    own = [name for name in ("l1", "l2", "l3") if name in body]
    if "document" in body or len(own) > 1:
        return
    body["fixed_leg"] = leg
    if own:
        body[f"l{leg}"] = body.pop(own[0])


def _other_option(kind: str, body: Body, rng: Random) -> None:
    """Gives an option of the question another of the values that its schema lists."""
    properties = by_kind()[kind].model_json_schema()["properties"]
    choices: dict[str, list[Any]] = {}
    for name, schema in properties.items():
        forms = [schema, *schema.get("anyOf", ())]
        values = [value for form in forms for value in form.get("enum", ())]
        values += [True, False] if schema.get("type") == "boolean" else []
        for form in forms:
            if form.get("type") == "integer" and name not in ("digits", "fixed_leg"):
                most = form.get("maximum", 50)
                values += [form.get("minimum", 0), rng.randint(1, most), most]
        if values:
            choices[name] = values
    if choices:
        name = rng.choice(sorted(choices))
        body[name] = rng.choice(choices[name])


def _fuller_list(_kind: str, body: Body, rng: Random) -> None:
    lists = [value for value in _containers(body) if isinstance(value, list) and value]
    if lists:
        own = rng.choice(lists)
        for _ in range(rng.choice((1, 5, rng.randint(1, _LONGEST_LIST)))):
            more = [copy.deepcopy(rng.choice(own))]
            numbers = [place for place in _leaves(more) if _is_number(place)]
            for container, key in numbers[:1]:
                container[key] = _longer(str(container[key]), rng)
            own += more


def _slices(_kind: str, body: Body, rng: Random) -> None:
    """Asks for many slices or points."""
    for name in ("l1", "l2", "l3"):
        if name in body and isinstance(body[name], list | dict):
            start, step = rng.choice((0.01, 1, 13, 27)), rng.choice(("0.001", "0.1", "0.37", "5"))
            count = rng.choice((10, 100, 1000))
            step_ = Fraction(step)
            body[name] = {"from": start, "to": exact_str(Fraction(str(start)) + count * step_), "step": step}


def _other_range(_kind: str, body: Body, rng: Random) -> None:
    for own in [value for value in _containers(body) if isinstance(value, dict)]:
        if isinstance(own.get("range"), dict) and "document" not in body:
            start = Fraction(rng.choice(("0", "0.001", "10", "27", "27.9")))
            stop = start + Fraction(rng.randint(1, 99), 10 ** rng.randint(0, 30))
            own["range"] = {"from": exact_str(start), "to": rng.choice((None, exact_str(stop)))}


def _fewer_members(kind: str, body: Body, rng: Random) -> None:
    own = [name for name in body if name not in ("geometry", "document")]
    if own and not is_verification(kind):
        del body[rng.choice(own)]


def _longer(text: str, rng: Random) -> str:
    """A number with more digits, or changed by very little, or of another size."""
    if not _NUMBER.fullmatch(text):
        return text
    x = Fraction(text)
    way = rng.randrange(4)
    if way == 0:
        places = rng.choice((3, 20, 100, 300))
        x += Fraction(rng.randrange(10**places), 10 ** (places + rng.choice((1, 4, 20))))
    elif way == 1:
        x += rng.choice((-1, 1)) * Fraction(rng.randint(1, 9), 10 ** _places(rng))
    elif way == 2:
        x *= Fraction(10) ** rng.choice((rng.randint(-4, 4), rng.randint(-150, 150)))
    else:
        x = Fraction(rng.randint(1, 40), rng.choice((1, 3, 7, 997)))
    return exact_str(x)


def _is_number(place: Place) -> bool:
    value = place[0][place[1]]
    if isinstance(value, str):
        return bool(_NUMBER.fullmatch(value))
    return isinstance(value, int | float) and not isinstance(value, bool)


def _containers(value: Any) -> Iterator[Any]:
    if isinstance(value, dict | list):
        yield value
        for item in value.values() if isinstance(value, dict) else value:
            yield from _containers(item)


def _leaves(value: Any) -> Iterator[Place]:
    for own in _containers(value):
        for key, item in list(own.items() if isinstance(own, dict) else enumerate(own)):
            if not isinstance(item, dict | list):
                yield own, key


_CHANGES: tuple[Callable[[str, Body, Random], None], ...] = (
    _new_geometry,
    _new_geometry,
    _other_side,
    _other_number,
    _other_number,
    _other_length,
    _other_digits,
    _other_leg,
    _other_option,
    _fuller_list,
    _slices,
    _other_range,
    _fewer_members,
)
