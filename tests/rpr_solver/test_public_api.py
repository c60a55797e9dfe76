"""The public interface: how its functions read numbers and name the fields at fault."""

import json
from collections.abc import Callable, Iterable
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from numbers import Real
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rpr_solver import (
    EXAMPLES,
    CuspCurves,
    Exact,
    InputError,
    JointPoint,
    LengthRange,
    Manipulator,
    Requirement,
    article_table,
    census,
    check,
    cusp_curves,
    cusp_table,
    eliminate,
    exact_str,
    parse_exact,
    poses,
    poses_of_squares,
    restrict_census,
    shorten_slice,
    slice_error_json,
    slice_json,
    solve_slice,
    table_document,
    table_json,
)
from tests.support.shared import census_of, curves_of, eliminant_of

FLAT = EXAMPLES["zein-flat"]
AT_MOST_SIX = Requirement(start=30, stop=40, max_cusps=6)


@Real.register
class NumpyLikeFloat:
    """Like a float of numpy: registered, but not a ``float``."""

    def __float__(self) -> float:
        return 15.91

    def __str__(self) -> str:
        return "15.91"


def fields(call: Callable[[], object]) -> set[str]:
    """The fields that the InputError of a call names."""
    with pytest.raises(InputError) as caught:
        call()
    return {problem.field for problem in caught.value.problems}


def fields_of_each(call: Callable[[Any], object], values: Iterable[object]) -> dict[str, object]:
    """What the InputError of a call names for each value, or what the call does else."""
    named: dict[str, object] = {}
    for value in values:
        try:
            named[repr(value)] = call(value)
        except InputError as error:
            named[repr(value)] = {problem.field for problem in error.problems}
        except Exception as error:
            named[repr(value)] = error
    assert named
    return named


def curves() -> CuspCurves:
    return curves_of(FLAT, digits=15)


def counts() -> dict[str, Any]:
    return census_of(FLAT, digits=15).to_json()


# Numbers

NUMBER_TAKERS: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "cusp_table": ("l1", lambda x: cusp_table(FLAT, x, digits=15)[0].to_json()),
    "cusp_table of several": ("l1[0]", lambda x: cusp_table(FLAT, [x], digits=15)[0].to_json()),
    "solve_slice": ("l1", lambda x: solve_slice(eliminant_of(FLAT), x, 15).to_json()),
    "article_table": ("l1", lambda x: article_table(FLAT, x, digits=15).table.to_json()),
    "poses l1": ("l1", lambda x: poses(FLAT, x, 10, 10, digits=15).to_json()),
    "poses l3": ("l3", lambda x: poses(FLAT, 10, 10, x, digits=15).to_json()),
    "poses_of_squares": ("l2_squared", lambda x: poses_of_squares(FLAT, 90, x, 90, digits=15).to_json()),
    "sampled": ("l1", lambda x: curves().sampled(x, eliminant=eliminant_of(FLAT)).to_json()),
    "sampled of several": ("l1[0]", lambda x: curves().sampled([x], eliminant=eliminant_of(FLAT)).to_json()),
    "slice_json": ("l1", lambda x: slice_json(eliminant_of(FLAT), x, 15)),
    "table_document": ("l1[0]", lambda x: table_document(FLAT, [x], digits=15)),
    "part": ("start", lambda x: curves().part(x).to_json()),
    "within": ("start", lambda x: curves().within(x).to_json()),
    "spread": ("start", lambda x: curves().spread(2, x)),
    "spread stop": ("stop", lambda x: curves().spread(2, stop=x)),
    "restrict_census": ("start", lambda x: restrict_census(counts(), x, None)),
    "restrict_census stop": ("stop", lambda x: restrict_census(counts(), None, x)),
    "LengthRange": ("start", lambda x: LengthRange.of(x, None)),
    "Requirement start": ("requirement.start", lambda x: Requirement(start=x, max_cusps=1)),
    "Requirement stop": ("requirement.stop", lambda x: Requirement(stop=x, max_cusps=1)),
    "Requirement min": ("requirement.limits.l2.min", lambda x: Requirement(max_cusps=1, limits={2: (x, 99)})),
    "Manipulator": ("geometry.a2x", lambda x: Manipulator(x, 0, 10, 17, 16, 20)),
    "replace": ("geometry.d1", lambda x: replace(FLAT, d1=x)),
    "slice_error_json": ("l3", lambda x: slice_error_json(x, 3, "kind", "detail")),
    "exact_str": ("x", exact_str),
    "parse_exact": ("any", lambda x: parse_exact(x, "any")),
}  # fmt: skip

BAD: list[object] = [10.5, float("nan"), NumpyLikeFloat(), True, b"27", "", "ten", "1/0", "nan", {"l1": 3}]
OPEN_END = ("part", "within", "spread", "restrict", "LengthRange", "Requirement")
"""The parameters for which None is an open end."""


@pytest.mark.parametrize("name", NUMBER_TAKERS)
def test_an_inexact_number_is_refused_by_name(name: str) -> None:
    field, call = NUMBER_TAKERS[name]
    named = fields_of_each(call, BAD if name.startswith(OPEN_END) else [*BAD, None])
    assert named == {key: {field} for key in named}


def spellings(x: Fraction) -> st.SearchStrategy[Exact]:
    quotients = st.integers(1, 50).map(lambda k: f"{x.numerator * k}/{x.denominator * k}")
    plain: list[Exact] = [x, exact_str(x), f" {exact_str(x)} "]
    if x.denominator == 1:
        plain.append(int(x))
    if "/" not in exact_str(x):
        plain += [Decimal(exact_str(x)), f"{Decimal(exact_str(x)):e}"]
    return st.one_of(quotients, st.sampled_from(plain))


@given(st.data())
@settings(max_examples=25, deadline=None)
def test_all_spellings_of_a_number_are_one(data: st.DataObject) -> None:
    x = data.draw(st.fractions(min_value=Fraction(1, 100), max_value=60, max_denominator=1000))
    spelling = data.draw(spellings(x))
    assert parse_exact(spelling, "x") == x
    assert solve_slice(eliminant_of(FLAT), spelling, 15) == solve_slice(eliminant_of(FLAT), x, 15)
    assert Requirement(start=spelling, max_cusps=1) == Requirement(start=x, max_cusps=1)


def test_a_text_is_one_number_and_never_a_sequence() -> None:
    assert [table.length for table in cusp_table(FLAT, "27", digits=15)] == [27]
    assert [table.length for table in cusp_table(FLAT, iter([Decimal(2), "7/2"]), digits=15)] == [
        2,
        Fraction(7, 2),
    ]
    assert cusp_table(FLAT, [], digits=15) == []
    assert {
        p.length for c in curves().sampled("27", eliminant=eliminant_of(FLAT)).curves for p in c.points
    } == {27}


def test_every_wrong_length_is_named_with_its_place() -> None:
    assert fields(lambda: cusp_table(FLAT, [1, 0, 2.5, "x"], fixed_leg=3)) == {"l3[1]", "l3[2]", "l3[3]"}  # type: ignore[list-item]


WITH_DIGITS: dict[str, Callable[[Any], object]] = {
    "cusp_table": lambda n: cusp_table(FLAT, 10, digits=n),
    "solve_slice": lambda n: solve_slice(eliminant_of(FLAT), 10, n),
    "article_table": lambda n: article_table(FLAT, 10, digits=n),
    "poses": lambda n: poses(FLAT, 10, 10, 10, digits=n),
    "poses_of_squares": lambda n: poses_of_squares(FLAT, 10, 10, 10, digits=n),
    "census": lambda n: census(FLAT, digits=n),
    "check": lambda n: check(FLAT, AT_MOST_SIX, digits=n),
    "cusp_curves": lambda n: cusp_curves(FLAT, digits=n),
    "shorten_slice": lambda n: shorten_slice(solve_slice(eliminant_of(FLAT), 10, 15).to_json(), 15, n),
    "restrict_census": lambda n: restrict_census(counts(), None, None, n),
    "table_document": lambda n: table_document(FLAT, 10, digits=n),
    "table_json": lambda n: table_json(FLAT, 1, n, []),
}
WITH_LEG: dict[str, Callable[[Any], object]] = {
    "cusp_table": lambda leg: cusp_table(FLAT, 10, fixed_leg=leg),
    "eliminate": lambda leg: eliminate(FLAT, leg),
    "census": lambda leg: census(FLAT, fixed_leg=leg),
    "cusp_curves": lambda leg: cusp_curves(FLAT, fixed_leg=leg),
    "table_document": lambda leg: table_document(FLAT, 10, fixed_leg=leg),
    "table_json": lambda leg: table_json(FLAT, leg, 15, []),
    "slice_error_json": lambda leg: slice_error_json(10, leg, "kind", "detail"),
}
WITH_MANIPULATOR: dict[str, Callable[[Any], object]] = {
    "cusp_table": lambda m: cusp_table(m, 10),
    "eliminate": eliminate,
    "article_table": lambda m: article_table(m, 10),
    "poses": lambda m: poses(m, 10, 10, 10),
    "census": census,
    "check": lambda m: check(m, AT_MOST_SIX),
    "cusp_curves": cusp_curves,
    "table_document": lambda m: table_document(m, 10),
    "table_json": lambda m: table_json(m, 1, 15, []),
}


@pytest.mark.parametrize("name", WITH_DIGITS)
def test_digits_are_an_integer_in_range(name: str) -> None:
    named = fields_of_each(WITH_DIGITS[name], [15.0, "15", True, Fraction(15), 14, 10_001, -1])
    assert named == {key: {"digits"} for key in named}


@pytest.mark.parametrize("name", WITH_LEG)
def test_the_fixed_leg_is_a_leg(name: str) -> None:
    named = fields_of_each(WITH_LEG[name], [1.0, "1", True, None, 0, 4, Fraction(1)])
    assert named == {key: {"fixed_leg"} for key in named}


@pytest.mark.parametrize("name", WITH_MANIPULATOR)
def test_a_manipulator_is_one(name: str) -> None:
    named = fields_of_each(WITH_MANIPULATOR[name], ["innocenti", None, FLAT.to_json()])
    assert named == {key: {"manipulator"} for key in named}


def test_other_objects_are_refused_by_name() -> None:
    assert fields(lambda: solve_slice(FLAT, 10)) == {"eliminant"}  # type: ignore[arg-type]
    assert fields(lambda: curves().sampled(10, eliminant=FLAT)) == {"eliminant"}  # type: ignore[arg-type]
    assert fields(lambda: check(FLAT, {"max_cusps": 1})) == {"requirement"}  # type: ignore[arg-type]
    assert fields(lambda: curves().spread(0)) == fields(lambda: curves().spread(2.0)) == {"count"}  # type: ignore[arg-type]


def test_ranges_are_exact_everywhere() -> None:
    assert census(FLAT, start="30", stop="40.0", digits=15).range == LengthRange(Fraction(30), Fraction(40))
    assert fields(lambda: census(FLAT, start=20.0, stop="x")) == {"start", "stop"}  # type: ignore[arg-type]
    assert fields(lambda: census(FLAT, start=-1)) == {"start"}
    assert fields(lambda: curves().within(3, 3)) == fields(lambda: curves().spread(3, 3, 2)) == {"stop"}


# Requirements


def test_limits_by_number_and_by_name_are_the_same() -> None:
    by_number = Requirement(max_cusps=1, limits={2: (5, "20.5"), 3: (None, None)})
    assert by_number == Requirement(max_cusps=1, limits={"l2": ("5", Decimal("20.5")), "l3": (None, None)})
    assert by_number.limits == {2: (Fraction(5), Fraction(41, 2)), 3: (None, None)}
    assert replace(by_number, max_cusps=2).limits == by_number.limits


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        ({"max_cusps": 8.5}, {"max_cusps"}),
        ({"max_cusps": True}, {"max_cusps"}),
        ({"min_cusps": "3"}, {"min_cusps"}),
        ({"max_cusps": 8, "min_cusps": 9}, {"max_cusps", "min_cusps"}),
        ({"max_cusps": -1, "start": -1, "stop": "x"}, {"max_cusps", "stop"}),
        ({}, {"max_cusps"}),
        ({"max_cusps": 1, "fixed_leg": "1"}, {"fixed_leg"}),
        ({"max_cusps": 1, "limits": {"l2": (5, 4)}}, {"limits.l2.max"}),
        ({"max_cusps": 1, "limits": {"l2": "12"}}, {"limits.l2"}),
        ({"max_cusps": 1, "limits": {"l2": (1, 2, 3)}}, {"limits.l2"}),
        ({"max_cusps": 1, "limits": {"l2": 5}}, {"limits.l2"}),
        ({"max_cusps": 1, "limits": {"l4": (1, 2)}}, {"limits"}),
        ({"max_cusps": 1, "limits": {True: (1, 2)}}, {"limits"}),
        ({"max_cusps": 1, "limits": {1: (1, 2)}}, {"limits.l1"}),
        ({"max_cusps": 1, "limits": [(1, 2)]}, {"limits"}),
        ({"max_cusps": 1, "limits": {2: (1.5, None), 3: (None, 2.5)}}, {"limits.l2.min", "limits.l3.max"}),
    ],
)  # fmt: skip
def test_an_invalid_requirement_is_refused_by_name(arguments: dict[str, Any], names: set[str]) -> None:
    assert fields(lambda: Requirement(**arguments)) == {f"requirement.{name}" for name in names}


# Manipulators


def test_a_manipulator_is_read_from_a_file_as_it_is_written(tmp_path: Path) -> None:
    path = tmp_path / "robot.json"
    path.write_text('{"a2x": 15.91, "a3x": 0, "a3y": 1e1, "d1": "426/25", "d2": 16.540, "d3": 20.84}')
    assert Manipulator.from_file(path) == Manipulator.from_file(str(path)) == EXAMPLES["innocenti"]


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("{", "path"),
        ("\ud800", "path"),
        ("[" * 100_000, "path"),
        ("[]", "geometry"),
        (json.dumps({**FLAT.to_json(), "d1": -1}), "geometry.d1"),
        (json.dumps({**FLAT.to_json(), "d1": float("nan")}), "geometry.d1"),
        (f'{{"a2x": 1{"0" * 5000}, "a3x": 0, "a3y": 1, "d1": 1, "d2": 1, "d3": 1}}', "geometry.a2x"),
    ],
    ids=["no JSON", "no UTF-8", "too deep", "no object", "negative", "NaN", "too long"],
)  # fmt: skip
def test_a_bad_file_is_named(tmp_path: Path, text: str, field: str) -> None:
    path = tmp_path / "robot.json"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    with pytest.raises(InputError, match=r"robot\.json") as caught:
        Manipulator.from_file(path)
    assert [problem.field for problem in caught.value.problems] == [field]


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nowhere"):
        Manipulator.from_file(tmp_path / "nowhere.json")
    assert fields(lambda: Manipulator.from_file(3.5)) == {"path"}  # type: ignore[arg-type]


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_manipulator_survives_its_forms(name: str) -> None:
    manipulator = EXAMPLES[name]
    for again in (
        Manipulator(**manipulator.to_dict()),
        Manipulator(**manipulator.to_json()),
        eval(repr(manipulator), {"Manipulator": Manipulator}),
        replace(manipulator),
    ):
        assert (again, again.geometry_hash) == (manipulator, manipulator.geometry_hash)


# Points


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_a_point_has_the_names_of_its_document(leg: int) -> None:
    [table] = cusp_table(FLAT, 10, digits=15, fixed_leg=leg)
    for cusp in table.cusps:
        document = cusp.to_json()
        assert {name: getattr(cusp, name) for name in document} == document
        assert JointPoint.from_json({**document, "kind": "cusp"}, leg) == cusp
        absent = {"theta1_deg", "theta2_deg", "theta3_deg", "l1", "l2", "l3"} - set(document)
        assert len(absent) == 3
        for name in absent:
            with pytest.raises(AttributeError, match=f"alpha_deg, theta{leg}_deg, .*, and no {name}"):
                getattr(cusp, name)
