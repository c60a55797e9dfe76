"""Documents whose texts are too long, or none, are refused by the name of the member before they are read."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import pytest

from rpr_solver import EXAMPLES, InputError, Manipulator, census, table_document, verify_document
from rpr_solver.verify.core.reader import decimal, exact
from rpr_solver.verify.core.texts import MAX_DEPTH, check_texts

TABLE = table_document(EXAMPLES["zein-flat"], [10], digits=15)


def nested(depth: int) -> Any:
    value: Any = "x"
    for _ in range(depth):
        value = [value]
    return value


def with_member(place: tuple[str | int, ...], value: object) -> dict[str, Any]:
    document = deepcopy(TABLE)
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
        table_document(m, ["14.98"], digits=15, certificate="full"),
        census(m, digits=15, certificate="full").to_json(),
    ):
        check_texts(document)
        check_texts(document, number_digits=22)


def test_longer_numbers_than_python_reads_are_read() -> None:
    digits = "7" * 6000
    assert exact(f"{digits}/19", "x") * 19 == exact(digits, "x") == (10**6000 - 1) // 9 * 7
    assert exact(f"1.{digits}", "x") == 1 + exact(digits, "x") / 10**6000
    printed = decimal(6000)(f"-0.{digits}", "x")
    assert printed.value * 10**6000 == -exact(digits, "x")
