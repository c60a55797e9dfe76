"""The reader: each number has one text, each object each key once."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable
from copy import deepcopy
from fractions import Fraction
from functools import cache
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import (
    EXAMPLES,
    ClaimStatus,
    InputError,
    Manipulator,
    Requirement,
    census,
    check,
    table_document,
    verify_document,
)
from rpr_solver.exact.decimals import round_fraction
from rpr_solver.exact.rationals import exact_str
from rpr_solver.verify import documents
from rpr_solver.verify.claims import Outcome
from rpr_solver.verify.core.numbers import (
    decimal,
    exact,
    integer,
    polynomial,
    radicand,
    short,
    short_positive,
    square_of,
)
from rpr_solver.verify.core.reader import (
    MAX_DEPTH,
    ExhaustedError,
    bounded,
    check_texts,
    count,
    names_of_unread,
    parsed,
    record,
    rows,
    spend,
    spend_by_digits,
    told,
    truth,
    unread,
    word,
)
from rpr_solver.verify.core.schema import kind_of, read_document
from tests.rpr_solver.verify.forgeries import base

FRACTIONS = st.fractions() | st.decimals(allow_nan=False, allow_infinity=False, places=12).map(Fraction)


@given(FRACTIONS)
def test_an_exact_number_is_read_as_the_solver_writes_it(x: Fraction) -> None:
    assert exact(exact_str(x), "/x") == x


@given(FRACTIONS, st.integers(15, 40), st.integers(-60, 60))
def test_a_decimal_is_read_as_the_solver_prints_it(x: Fraction, digits: int, place: int) -> None:
    x *= Fraction(10) ** place
    text = round_fraction(x, digits)
    printed = decimal(digits)(text, "/x")
    assert abs(printed.value - x) <= printed.half
    assert printed.is_zero == (x == 0)
    for other in (digits - 1, digits + 1):
        if x:
            with pytest.raises(InputError, match="significant digits"):
                decimal(other)(text, "/x")


@given(FRACTIONS, st.sampled_from(["0", " ", "+", "e0", ".", "_1", "\u0661", "/1", "-"]), st.booleans())
def test_another_spelling_is_refused(x: Fraction, more: str, before: bool) -> None:
    text = exact_str(x)
    other = more + text if before else text + more
    try:
        y = exact(other, "/x")
    except InputError:
        return
    assert exact_str(y) == other


@pytest.mark.parametrize(
    ("read", "wrong"),
    [
        (exact, ["-0", "1.", ".5", "1e3", "2/4", "1/2", "1/0", "0/3", "--1", "1 ", 1, 1.5, True, None, "x"]),
        (integer, ["-0", "01", "1.0", "+1", 1, "1e3", ""]),
        (short, ["1.5e-3", "01e-3", "1e3", "1e-0", "1e-03"]),
        (short_positive, ["0", "-1", "-1e-3"]),
        (count(0, 9), [-1, 10, 1.0, "1", True, None]),
        (truth, [0, 1, "true", None]),
        (word("a", "b"), ["c", "A", 1, None, ["a"]]),
        (square_of, ["sqrt(4)", "sqrt(2.25)", "sqrt(-2)", "sqrt()", "sqrt(2", "0", "-1"]),
        (radicand, ["sqrt(1)", "sqrt(-3)", "sqrt(1/2)", "3"]),
        (rows(count(), 1, 2), [[], [1, 2, 3], {"0": 1}, "12", [1, "2"]]),
        (decimal(3), ["1.2", "1.234", "0.0", "00.1", "12.3e1", "1.23e5.0", "-0", 1.23, "0.00000000123"]),
        (decimal(3, 0, 180, zero=False), ["0", "-1.00", "181"]),
    ],
)
def test_what_is_refused(read: Callable[[object, str], object], wrong: list[object]) -> None:
    for value in wrong:
        with pytest.raises(InputError, match=r"^/x"):
            read(value, "/x")


def test_an_object_has_its_members_and_no_others() -> None:
    read = record({"a": count()}, {"b": told(count()), "c": unread})
    assert dict(read({"b": 2, "a": 1}, "")) | {"b": 0} == {"a": 1, "b": 0}
    assert list(read({"b": 2, "a": 1}, "")) == ["a", "b"]
    assert names_of_unread(read({"a": 1, "b": 2, "c": {"d": 1}}, "")) == {"/b", "/c"}
    for value, named in (({}, "/a"), ({"a": 1, "x/y~": 2}, "/x~1y~0"), ({"a": 1, "b": "2"}, "/b"), ([], "")):
        with pytest.raises(InputError) as caught:
            read(value, "")
        assert caught.value.problems[0].field in (named, "document")
    with pytest.raises(TypeError):
        read({"a": 1}, "")["a"] = 2


@pytest.mark.parametrize(
    "text",
    ['{"a": 1, "a": 1}', '{"a": {"b": 1, "b": 2}}', "[1e999]", "[-0]", "[NaN]", "{", "[" * 9999],
)
def test_json_that_may_be_read_in_two_ways_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        parsed(text)
    with pytest.raises(InputError):
        parsed(text.encode())


def test_bytes_and_texts_are_read_alike() -> None:
    value = {"a": [1, -2, "x\u00e9", None, True]}
    assert parsed(json.dumps(value)) == parsed(json.dumps(value).encode()) == value
    with pytest.raises(InputError):
        parsed(b"\xff")


def test_a_polynomial_has_as_many_coefficients_as_its_degree_says() -> None:
    read = polynomial("t", 1, 1)
    form = {"variable": "t", "degree": 1, "coefficients": ["1", "-2"]}
    assert read(form, "")["coefficients"] == (1, -2)
    irrational = {"omega": "sqrt(3)", "omega_coefficients": ["0", "1"]}
    assert read({**form, **irrational}, "")["omega"] == 3
    for change in ({"omega": "sqrt(3)"}, {"coefficients": ["1"]}, {"degree": 2}, {"variable": "u"}):
        with pytest.raises(InputError):
            read({**form, **change}, "")
    free = polynomial("t", 0, 4)
    assert free({**form, **irrational}, "")["degree"] == 1
    for change in ({"degree": 2}, {"degree": 0}, {**irrational, "omega_coefficients": ["0", "1", "2"]}):
        with pytest.raises(InputError):
            free({**form, **change}, "")


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("table", "cusp-table"),
        ("poses", "poses"),
        ("census", "census"),
        ("open census", "census"),
        ("full curves", "cusp-curves"),
        ("limits", "check"),
    ],
)
def test_every_kind_is_read(name: str, kind: str) -> None:
    document = base(name)
    assert kind_of(document) == read_document(document).kind == kind
    for member in document:
        if member not in ("degenerate", "certificate"):
            with pytest.raises(InputError):
                read_document({k: x for k, x in document.items() if k != member})
        with pytest.raises(InputError):
            read_document({**document, member: {"x": 1}})


@pytest.mark.parametrize(
    ("member", "name"),
    [
        ("aspects", "a document of aspects"),
        ("checks", "a list of reports of checks"),
        ("verdict", "a verification"),
    ],
)
def test_other_documents_are_named(member: str, name: str) -> None:
    with pytest.raises(
        InputError, match=f"is, {name}, of no kind that can be verified; known are cusp-table"
    ):
        kind_of({member: []})


def test_a_report_with_a_change_of_mode_is_refused_with_what_can_be_verified() -> None:
    requirement = Requirement(1, 36, Fraction("36.1"), max_cusps=8, mode_change="required")
    report = check(EXAMPLES["zein-flat"], requirement, digits=15).to_json()
    with pytest.raises(InputError, match="requirement/mode_change: is not verified: verify the path"):
        verify_document(json.loads(json.dumps(report)))
    witness = json.loads(json.dumps(report["mode_change"]["witness"]["path"]))
    assert verify_document(witness).established


@cache
def the_table() -> dict[str, Any]:
    return table_document(EXAMPLES["zein-flat"], [10], digits=15)


def nested(depth: int) -> Any:
    value: Any = "x"
    for _ in range(depth):
        value = [value]
    return value


def with_member(place: tuple[str | int, ...], value: object) -> dict[str, Any]:
    document = deepcopy(the_table())
    parent: Any = document
    for name in place[:-1]:
        parent = parent[name]
    parent[place[-1]] = value
    return document


@pytest.mark.parametrize(
    ("place", "value", "named"),
    [
        (("geometry", "d1"), "1" * 5000, "geometry.d1"),
        (("geometry", "d1"), "1/" + "3" * 15000, "geometry.d1"),
        (("geometry", "\ud800"), "1", "geometry"),
        (("geometry", "unit"), "\ud800", "geometry.unit"),
        (("slices", 0, "l1"), "14." + "9" * 1000, "slices[0].l1"),
        (("slices", 0, "l1"), "9" * 4400, "slices[0].l1"),
        (("slices", 0, "l1"), "1/" + "3" * 430, "slices[0].l1"),
        (("slices", 0, "l1"), "1e99999", "slices[0].l1"),
        (("slices", 0, "l1"), "1." + "7" * 500 + "e999999999", "slices[0].l1"),
        (("slices", 0, "l1"), 10**5000, "slices[0].l1"),
        (("slices", 0, "count"), 10**500, "slices[0].count"),
        (("slices", 0, "cusps", 1, "l2"), "1." + "7" * 5000, "slices[0].cusps[1].l2"),
        (("slices", 0, "cusps", 1, "l2"), "1." + "7" * 5000 + "x", "slices[0].cusps[1].l2"),
        (
            ("slices", 0, "certificate", "factors", 0, "origin"),
            "7" * 100_000,
            "slices[0].certificate.factors",
        ),
        (("more",), nested(5000), "more"),
        (("more",), nested(MAX_DEPTH), "more"),
        (("digits",), "9" * 5000, "digits"),
    ],
    ids=lambda value: ascii(value)[:30] if isinstance(value, str | tuple) else "",
)
def test_what_is_too_long_or_no_text_is_named(
    place: tuple[str | int, ...], value: object, named: str
) -> None:
    document = with_member(place, value)
    with pytest.raises(InputError) as caught:
        verify_document(document)
    [problem] = caught.value.problems
    assert problem.field.startswith(named)
    assert len(problem.message) < 200
    assert problem.message.encode()


def test_the_digits_of_a_document_explain_its_numbers() -> None:
    cusp = ("slices", 0, "cusps", 0, "l2")
    check_texts({**with_member(cusp, "1." + "7" * 900), "digits": 900})
    with pytest.raises(InputError, match="here at most 1310 are read, for 900 digits"):
        check_texts({**with_member(cusp, "1." + "7" * 1500), "digits": 900})
    with pytest.raises(InputError, match="for 15 digits"):
        check_texts({**with_member(cusp, "1." + "7" * 900), "digits": 900}, most_digits=500)
    check_texts(with_member(("slices", 0, "l1"), "9" * 40), number_digits=40)
    with pytest.raises(InputError, match=r"slices\[0\].l1"):
        check_texts(with_member(("slices", 0, "l1"), "9" * 70), number_digits=40)


def test_quotients_of_few_digits_may_be_decimals_of_many() -> None:
    check_texts(with_member(("slices", 0, "l1"), f"0.{5**1300:01300d}"))  # 2^-1300
    check_texts(with_member(("slices", 0, "l1"), "0." + "0" * 399 + "1"))


def test_long_sides_explain_the_certificate() -> None:
    sides = [f"{x}.{'7318526940' * 2}{k}" for k, x in enumerate((15, 1, 10, 17, 16, 20))]
    m = Manipulator(*sides)
    for document in (
        table_document(m, ["14.98"], digits=15),
        census(m, digits=15).to_json(),
    ):
        check_texts(document)
        check_texts(document, number_digits=22)


def test_longer_numbers_than_python_reads_are_read() -> None:
    digits = "7" * 6000
    assert exact(f"{digits}/19", "x") * 19 == exact(digits, "x") == (10**6000 - 1) // 9 * 7
    assert exact(f"1.{digits}", "x") == 1 + exact(digits, "x") / 10**6000
    printed = decimal(6000)(f"-0.{digits}", "x")
    assert printed.value * 10**6000 == -exact(digits, "x")


def test_products_of_long_numbers_count_more() -> None:
    with bounded(10**9) as left:
        spend(10)
        short = 10**9 - left[0]
        spend(10, 10_000)
        assert 10**9 - left[0] > 50 * short
    with bounded(10**9) as left:
        spend_by_digits(10, 5_000, 100)
        assert 10**9 - left[0] == short
        spend_by_digits(10, 5_000, 10_000)
        assert 10**9 - left[0] > 90 * short
    spend(10**12)  # nothing is counted outside
    with pytest.raises(ExhaustedError), bounded(5):
        spend(6)


def test_what_is_left_is_open_and_named(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = verify_document(base("table"))
    assert whole.established
    monkeypatch.setattr(documents, "LEAST_CHARACTERS", 1)
    monkeypatch.setattr(documents, "UNITS_OF_A_CHARACTER", 1)
    verification = verify_document(base("table"))
    assert verification.outcome is Outcome.NOT_ESTABLISHED
    names = [{(claim.at, claim.claim) for claim in x.claims} for x in (verification, whole)]
    assert names[0] == names[1]
    assert len(verification.open) == len(whole.claims) - 2  # the hash and the order take no work
    for claim in verification.open:
        assert claim.status is ClaimStatus.NOT_CHECKED
        assert re.sub(r"[0-9]", "*", claim.at) in re.sub(r"(?<=/)[0-9]", "*", verification.summary)
    assert "these 4 cusps are all (/slices/0/count)" in verification.summary
    assert verify_document(base("table"), effort=1000).established
    with pytest.raises(InputError, match="effort"):
        verify_document(base("table"), effort=0)


def _long_sides(digits: int) -> list[str]:
    draw = random.Random(digits)
    return [f"{x}.{draw.randrange(10**digits):0{digits}}1" for x in (15, 1, 10, 17, 16, 20)]


def _of_many_parts(count: int) -> dict[str, Any]:
    """A table of many slices without cusps, which takes as long as one of as many with cusps."""
    document = base("table")
    part = {"count": 0, "cusps": [], "degenerate_points": []}
    document["slices"] = [{"l1": f"{n}.5", **part} for n in range(1, count)]
    return document


@pytest.mark.slow
@pytest.mark.parametrize(
    "make",
    [
        lambda: _of_many_parts(500),
        lambda: table_document(Manipulator(*_long_sides(60)), "14.98", digits=15),
        lambda: {
            **base("report"),
            "intervals": [{"from": "36", "to": "38", "count": 4}],
            "violations": [],
            "passed": True,
            "max_cusps_found": 4,
            "min_cusps_found": 4,
        },
    ],
)
def test_no_document_takes_more_than_its_length_allows(make: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(documents, "UNITS_OF_A_CHARACTER", 4)  # a small part, to save time
    spent: list[int] = []

    def counted(units: int) -> Any:
        manager = bounded(units)

        class Counted:
            def __enter__(self) -> list[int]:
                self.left = manager.__enter__()
                return self.left

            def __exit__(self, *error: Any) -> None:
                manager.__exit__(*error)
                spent.append(units - self.left[0])

        return Counted()

    monkeypatch.setattr(documents, "bounded", counted)
    document = make()
    verify_document(document)
    allowed = 4 * max(100_000, 2 * len(json.dumps(document)))
    # a single step may overrun what is left, by no more than its own size
    assert spent[0] < 2 * allowed


def test_the_work_on_a_document_follows_from_its_length_whatever_its_structure() -> None:
    for numbers in (list(range(10, 1000)), ["12345"] * 1000, [0.5] * 1000, [{"cusp": "12.5"}] * 1000):
        document = {"certificate": {"motion": [{"speeds": numbers}]}}
        assert 0.4 < check_texts(document) / len(json.dumps(document)) < 1.2
