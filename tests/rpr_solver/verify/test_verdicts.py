"""Tables, censuses and reports: true ones are verified, false ones are refused, or their claim is open."""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import deepcopy
from fractions import Fraction
from typing import Any

import pytest

from rpr_solver import EXAMPLES, InputError, Manipulator, Requirement, census, check, table_document
from rpr_solver.verify.claims import Verdict
from rpr_solver.verify.documents import verify_document
from tests.support.families import family
from tests.support.sampling import long

Document = dict[str, Any]
INNOCENTI = EXAMPLES["innocenti"]


def plain(value: object) -> Document:
    return json.loads(json.dumps(value))  # type: ignore[no-any-return]


@pytest.fixture(scope="module")
def table() -> Document:
    return plain(table_document(INNOCENTI, ["14.98", "28.1"], digits=30))


@pytest.fixture(scope="module")
def found() -> Document:
    return plain(census(INNOCENTI, start=28, stop=31, digits=20).to_json())


@pytest.fixture(scope="module")
def report() -> Document:
    requirement = Requirement(
        1, Fraction(28), Fraction(31), max_cusps=8, limits={2: (Fraction(3), Fraction(40))}
    )
    return plain(check(INNOCENTI, requirement, digits=20).to_json())


def test_true_documents_are_verified(table: Document, found: Document, report: Document) -> None:
    for document in (table, found, report):
        assert verify_document(document).verdict is Verdict.VERIFIED, verify_document(document).summary


@pytest.mark.parametrize(("digits", "leg"), [(15, 2), (90, 3), (400, 1)])
def test_tables_of_any_digits_and_leg_are_verified(digits: int, leg: int) -> None:
    document = plain(table_document(INNOCENTI, "17.3", digits=digits, fixed_leg=leg))
    assert verify_document(document).verdict is Verdict.VERIFIED


@pytest.mark.parametrize("span", [(Fraction("30.9"), None), long((None, None)), long((None, Fraction(20)))])
def test_censuses_with_open_ends_are_verified(span: tuple[Fraction | None, Fraction | None]) -> None:
    start, stop = span
    document = plain(census(INNOCENTI, start=start or 0, stop=stop, digits=15).to_json())
    assert verify_document(document).verdict is Verdict.VERIFIED


def test_a_range_that_begins_beside_a_transition_is_verified() -> None:
    start = Fraction("28.0948944788774")
    document = plain(census(INNOCENTI, start=start, stop=Fraction("28.2"), digits=40).to_json())
    assert verify_document(document).verdict is Verdict.VERIFIED


@pytest.mark.parametrize("leg", [1, long(2)])
def test_censuses_from_where_two_legs_close_are_verified(leg: int) -> None:
    manipulator = family("d1 = a2x")
    document = plain(census(manipulator, digits=15, fixed_leg=leg).to_json())
    assert verify_document(document).verdict is Verdict.VERIFIED
    assert document["transitions"]
    forged = changed(document, lambda x: _without(x, 0))
    assert verify_document(forged).verdict is Verdict.REFUSED
    limits = {3: (Fraction(2), None)}
    requirement = Requirement(leg, Fraction(0), Fraction(3), max_cusps=24, limits=limits)
    report = plain(check(manipulator, requirement, digits=15).to_json())
    assert verify_document(report).verdict is Verdict.VERIFIED


@pytest.mark.long
def test_a_census_with_a_pose_at_which_both_free_legs_close_is_verified() -> None:
    document = plain(census(family("d1 = a2x"), digits=15, fixed_leg=3, start=4, stop=5).to_json())
    place = [row["kind"] for row in document["transitions"]].index("quadruple")
    assert verify_document(document).verdict is Verdict.VERIFIED
    forged = changed(document, lambda x: _without(x, place))
    assert verify_document(forged).verdict is Verdict.REFUSED


@pytest.mark.long
def test_where_more_than_four_poses_coalesce_at_closed_legs_no_quadruple_pose_is_verified() -> None:
    manipulator = Manipulator(6, 3, 7, 6, 5, 5)
    document = plain(census(manipulator, digits=15, fixed_leg=3, start=2, stop=4).to_json())
    [row] = [row for row in document["transitions"] if row["events"][0]["l1"] == "0"]
    assert row["kind"] == "higher"
    row["kind"] = row["events"][0]["kind"] = "quadruple"
    assert verify_document(document).verdict is Verdict.NOT_VERIFIED


def test_events_that_are_near_to_each_other_are_refined() -> None:
    manipulator = Manipulator("-23.252", "2.413", "13.367", "4.325", "8.111", "8.093")
    document = plain(census(manipulator, digits=15, fixed_leg=3, stop=Fraction("10.4")).to_json())
    assert verify_document(document).verdict is Verdict.VERIFIED


@pytest.mark.parametrize("name", ["similar", long("congruent"), "congruent, mirrored", long("both flat")])
def test_degenerate_families_are_not_refused(name: str) -> None:
    for document in (
        table_document(family(name), "9", digits=15),
        census(family(name), digits=15).to_json(),
        check(family(name), Requirement(1, Fraction(8), Fraction(9), max_cusps=4)).to_json(),
    ):
        assert verify_document(plain(document)).verdict is Verdict.NOT_VERIFIED


def test_similar_triangles_have_no_cusps_by_a_theorem() -> None:
    document = plain(table_document(family("similar"), "9", digits=15))
    claims = {claim.at: claim.status.value for claim in verify_document(document).claims}
    assert claims["/slices/0/count"] == "proved"
    forged = changed(document, lambda x: x["slices"][0].update(count=1, cusps=[_A_CUSP]))
    assert verify_document(forged).verdict is Verdict.REFUSED


_A_CUSP = {
    "alpha_deg": "50.6785604965135",
    "theta1_deg": "-69.1293760614883",
    "l2": "0.845282018280357",
    "l3": "3.77791580047899",
}


def changed(document: Document, change: Callable[[Document], object]) -> Document:
    result = deepcopy(document)
    change(result)
    return result


def _digit(text: str, place: int = -1) -> str:
    """A text with another digit."""
    return f"{text[:place]}{(int(text[place]) + 1) % 10}{text[len(text) + place + 1 :]}"


def _other_digit(row: Document, name: str) -> None:
    row[name] = _digit(row[name])


TABLES: dict[str, Callable[[Document], object]] = {
    "a cusp less": lambda x: (x["slices"][0]["cusps"].pop(), x["slices"][0].update(count=5)),
    "another digit of a length": lambda x: _other_digit(x["slices"][1]["cusps"][2], "l3"),
    "cusps of another slice": lambda x: x["slices"][0].update(l1="14.99"),
    "another fixed leg": lambda x: x["geometry"].update(d3="20.85"),
    "a degenerate pose more": lambda x: x["slices"][0]["degenerate_points"].append(
        {"kind": "node", **x["slices"][0]["cusps"][0]}
    ),
}


@pytest.mark.parametrize("name", TABLES)
def test_a_false_table_is_refused(table: Document, name: str) -> None:
    assert verify_document(changed(table, TABLES[name])).verdict is Verdict.REFUSED


def _recount(document: Document, n: int, count: int) -> None:
    """Another number of cusps in an interval, consistently."""
    document["intervals"][n]["count"] = count
    if n:
        document["transitions"][n - 1]["count_after"] = count
    if n < len(document["transitions"]):
        document["transitions"][n]["count_before"] = count


def _without(document: Document, n: int) -> None:
    """Without a transition, consistently."""
    rows, intervals = document["transitions"], document["intervals"]
    rows.pop(n)
    after = intervals.pop(n + 1)
    intervals[n]["to"] = after["to"]
    for k, row in enumerate(rows):
        row["count_before"], row["count_after"] = intervals[k]["count"], intervals[k + 1]["count"]


def _moved(document: Document, n: int) -> None:
    """Another length of a transition, consistently."""
    text = _digit(document["transitions"][n]["l1"])
    document["transitions"][n]["l1"] = text
    document["intervals"][n]["to"] = document["intervals"][n + 1]["from"] = text


def _renamed(document: Document, n: int, kind: str) -> None:
    row = document["transitions"][n]
    row["kind"] = row["events"][0]["kind"] = kind


CENSUSES: dict[str, Callable[[Document], object]] = {
    "another number of cusps": lambda x: _recount(x, 2, 6),
    "a transition less": lambda x: _without(x, 1),
    "another length": lambda x: _moved(x, 3),
    "lips for a beak-to-beak": lambda x: _renamed(x, 0, "lips"),
    "another digit of an event": lambda x: _other_digit(x["transitions"][2]["events"][0], "l2"),
    "another number of aspects": lambda x: x["intervals"][0].update(aspects=2),
    "a wider range": lambda x: (x["range"].update({"from": "26"}), x["intervals"][0].update({"from": "26"})),
    "an endless range": lambda x: (
        x["range"].update(to=None),
        _recount(x, 6, 6),
        x["intervals"][-1].update(to=None),
    ),
}


@pytest.mark.parametrize("name", CENSUSES)
def test_a_false_census_is_refused(found: Document, name: str) -> None:
    assert verify_document(changed(found, CENSUSES[name])).verdict is Verdict.REFUSED


def _fewer(document: Document) -> None:
    """A cusp less everywhere that violates."""
    for row in (*document["intervals"], *document["violations"]):
        row["count"] -= 1
    for row in document["violations"]:
        row["example"]["cusps"].pop()
    document["max_cusps_found"] -= 1
    document["min_cusps_found"] -= 1


def _example_elsewhere(document: Document) -> None:
    document["violations"][0]["example"]["l1"] = "30"


REPORTS: dict[str, Callable[[Document], object]] = {
    "that it is met": lambda x: x.update(passed=True),
    "a cusp less": _fewer,
    "another example": _example_elsewhere,
    "another limit": lambda x: x["requirement"]["limits"]["l2"].update(max="12"),
    "a bound of nothing": lambda x: x["requirement"].update(max_cusps=None),
}


@pytest.mark.parametrize("name", REPORTS)
def test_a_false_report_is_refused(report: Document, name: str) -> None:
    assert report["violations"]
    assert verify_document(changed(report, REPORTS[name])).verdict is Verdict.REFUSED


def _mode_required(document: Document) -> None:
    """A report that requires a change of assembly mode, too, and has one."""
    document["requirement"] |= {"mode_change": "required", "clearance": "0.5"}
    names = ("witness", "reason", "certificate")
    document["mode_change"] = {"change": "possible", **dict.fromkeys(names)}


def _mode_alone(document: Document) -> None:
    """A report that requires a change of assembly mode alone, and has one."""
    _mode_required(document)
    document["requirement"]["max_cusps"] = None
    document.update(passed=True, violations=[])


def test_that_the_mode_changes_is_open_beside_numbers_of_cusps(report: Document) -> None:
    met = verify_document(changed(report, _mode_alone))
    assert met.verdict is Verdict.NOT_VERIFIED
    assert {x.at for x in met.claims if x.status != "proved"} == {"/mode_change", "/passed"}
    failed = verify_document(changed(report, _mode_required))
    assert {x.at for x in failed.claims if x.status != "proved"} == {"/mode_change"}


@pytest.mark.parametrize("change", ["impossible", "undecided"])
def test_a_report_does_not_pass_without_the_mode_it_asks_for(report: Document, change: str) -> None:
    false = changed(report, _mode_alone)
    false["mode_change"]["change"] = change
    assert verify_document(false).verdict is Verdict.REFUSED


@pytest.mark.parametrize("is_asked", [True, False])
def test_what_is_said_of_modes_goes_with_what_is_asked(report: Document, is_asked: bool) -> None:
    false = changed(report, _mode_required)
    del (false if is_asked else false["requirement"])["mode_change"]
    with pytest.raises(InputError, match="/mode_change"):
        verify_document(false)
