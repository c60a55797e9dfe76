from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import pytest

from rpr_solver import EXAMPLES, Requirement
from rpr_solver.designs.plan import Plan
from worker.answers.censuses import CENSUS, CHECK, MARGIN
from worker.answers.cost import Cost, Sizes
from worker.answers.designs import DESIGN
from worker.answers.documents import (
    ASPECTS,
    CUSP_CURVES,
    PLOT,
    POSES,
    SINGULAR_CURVES,
    VERIFICATION,
)
from worker.answers.kind import ALL_LENGTHS, JobRequest, Kind
from worker.answers.kinds import KINDS, seconds_after
from worker.answers.paths import CONNECTIONS, MODES, PATH
from worker.answers.tables import ARTICLE_TABLE, CUSP_TABLE
from worker.answers.workspaces import WORKSPACE

INNOCENTI = EXAMPLES["innocenti"].to_json()
EXTREME = {"a2x": "1" + "0" * 200, "a3x": "0", "a3y": "1", "d1": "1", "d2": f"0.{'0' * 99}1", "d3": "1"}
LONG = {name: "".join(reversed(x)) + "7" * 390 for name, x in INNOCENTI.items()} | {"a3x": "1", "d3": "2"}


def request(kind: Kind, content: Mapping[str, Any], geometry: Mapping[str, str] = INNOCENTI) -> JobRequest:
    return JobRequest(kind, {"geometry": geometry, "fixed_leg": 1, "digits": 30, **content})


def cost(request: JobRequest) -> Cost:
    return request.cost


def estimate(kind: Kind, content: Mapping[str, Any], geometry: Mapping[str, str] = INNOCENTI) -> float:
    return request(kind, content, geometry).cost.whole


WHOLE = {"range": ALL_LENGTHS}
CONTENTS: dict[Kind, Mapping[str, Any]] = {
    CUSP_TABLE: {"l1": ["14.98"]},
    ARTICLE_TABLE: {"l1": ["14.98"]},
    POSES: {"l1": "14.98", "l2": "15", "l3": "30"},
    CENSUS: WHOLE,
    CHECK: {"requirement": Requirement(1, 20, 25, 8, limits={2: (5, 20)}).to_json()},
    CUSP_CURVES: {**WHOLE, "lengths": [], "samples": None},
    PATH: {"length": "27", "cusp": 1, "samples": 101},
    SINGULAR_CURVES: {"length": "27", "tolerance": "0.001"},
    ASPECTS: {"range": {"from": "27", "to": "30"}},
    WORKSPACE: {"phi": "30", "limits": {"l1": {"min": "5", "max": "30"}}},
    MARGIN: {"length": "28.1", "tolerance": dict.fromkeys(("a2x", "a3x", "a3y", "d1", "d2", "d3"), "1")},
    CONNECTIONS: {"l1": "27", "l2": "20", "l3": "20", "limits": {"l2": {"min": "5", "max": "21"}}},
    MODES: {"range": {"from": "27", "to": "30"}},
    DESIGN: {
        **Plan.of(EXAMPLES["innocenti"], "longest-range", Requirement(1, 20, 25, 8), budget=2).to_json(),
    },
    PLOT: {"plot": "loop", "theme": "light", "length": "27", "cusp": 1},
    VERIFICATION: {"document": {"slices": []}},
}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_each_kind_has_a_cost_that_grows_with_each_size(kind: Kind) -> None:
    size = request(kind, CONTENTS[kind]).sizes
    usual = kind.cost_of(size).whole
    assert 0.001 < usual < 10
    for field in fields(Sizes):
        prices = [kind.cost_of(replace(size, **{field.name: n})).whole for n in (1, 10, 100, 1000, 10_000)]
        assert prices == sorted(prices), field.name


@pytest.mark.parametrize(
    ("kind", "content", "geometry", "low", "high"),
    [
        (CUSP_TABLE, {"l1": [str(n) for n in range(1, 2001)], "digits": 15}, INNOCENTI, 1, 9),
        (CUSP_TABLE, {"l1": [str(n) for n in range(1, 2001)], "digits": 1000}, INNOCENTI, 4, 30),
        (CUSP_TABLE, {"l1": ["1"], "digits": 15}, EXTREME, 1.2, 11),
        (CENSUS, WHOLE, INNOCENTI, 0.15, 1.4),
        (CENSUS, WHOLE, LONG, 10, 1e5),
    ],
)
def test_estimates(
    kind: Kind, content: Mapping[str, Any], geometry: Mapping[str, str], low: float, high: float
) -> None:
    assert low < estimate(kind, content, geometry) < high


TABLE = {"geometry": INNOCENTI, "fixed_leg": 1, "digits": 15, "solver_version": "7"}
CUSP = dict.fromkeys(("alpha_deg", "theta1_deg", "l2", "l3"), "12.3456789012345")
POSES = {"geometry": INNOCENTI, "digits": 15, "poses": [CUSP] * 4}


def of_one_slice(l1: str, cusps: int = 0) -> dict[str, Any]:
    return {**TABLE, "slices": [{"l1": l1, "count": cusps, "cusps": [CUSP] * cusps}]}


@pytest.mark.parametrize(
    ("document", "least", "most"),
    [
        (of_one_slice("14.98", 6), 0.1, 0.5),
        (of_one_slice("14.98", 3000), 10, 30),
        ({**POSES, "l1": "14." + "9" * 200, "l2": "15." + "8" * 200, "l3": "20." + "7" * 200}, 0.1, 0.5),
        ({**TABLE, "range": {"from": "25"}, "curves": [{}] * 10}, 8, 30),
    ],
    ids=lambda value: str(value)[-30:] if isinstance(value, dict) else "",
)
def test_all_of_a_document_to_verify_is_priced(document: dict[str, Any], least: float, most: float) -> None:
    assert least < estimate(VERIFICATION, {"document": document, "digits": 15}) < most


def test_the_digits_of_a_document_are_no_long_numbers() -> None:
    long = dict.fromkeys(CUSP, "12." + "3" * 298)
    document = {**TABLE, "digits": 300, "slices": [{"l1": "14.98", "cusps": [long] * 6}]}
    assert estimate(VERIFICATION, {"document": document, "digits": 300}) < 2


NEARLY_FLAT = {
    "a2x": "10",
    "a3x": "5",
    "a3y": f"0.{'0' * 29}1",
    "d1": "10",
    "d2": "5",
    "d3": f"5.{'0' * 28}11",
}
HERON = {"a2x": "14", "a3x": "5", "a3y": "12", "d1": "14", "d2": "15", "d3": "13", "orientation": "ccw"}
PERMUTED = {"a2x": "14", "a3x": "5", "a3y": "12", "d1": "14", "d2": "13", "d3": "15"}
"""A congruent platform, its corners in another order."""
ROUND = {"a2x": "10", "a3x": "4", "a3y": "3", "d1": "5", "d2": "6", "d3": "8", "orientation": "ccw"}


@pytest.mark.parametrize(
    ("geometry", "seconds"),
    [
        (NEARLY_FLAT, 0.7),
        ({**ROUND, "a3y": f"0.{'0' * 13}1"}, 0.2),
        ({**HERON, "a2x": f"14.{'0' * 15}1"}, 0.2),
        ({**PERMUTED, "a3x": "4.99999999999999999996", "d2": "13.00000000000000000004"}, 0.5),
    ],
)
def test_a_census_beside_a_special_shape_is_priced_as_it_takes(
    geometry: dict[str, str], seconds: float
) -> None:
    assert seconds < estimate(CENSUS, CONTENTS[CENSUS], geometry) < 7 * seconds


def test_a_tolerance_is_priced_with_the_margin() -> None:
    within = {**CONTENTS[CHECK], "tolerance": dict.fromkeys(("a2x", "d1"), "0.1")}
    plain, margin = (estimate(kind, CONTENTS[kind], INNOCENTI) for kind in (CHECK, MARGIN))
    assert plain + 0.9 * margin < estimate(CHECK, within, INNOCENTI) < 2 * (plain + margin)


@pytest.mark.parametrize("geometry", [HERON, ROUND, {**ROUND, "a3y": "0"}])
def test_special_shapes_are_not_dear(geometry: dict[str, str]) -> None:
    assert estimate(CENSUS, WHOLE, geometry) < 1


def test_the_margin_of_a_slice_of_a_flat_platform_is_not_dear() -> None:
    flat = {**HERON, "d1": "28"}
    slice_, window = {"length": "9"}, {"window": 1}
    assert estimate(MARGIN, slice_, flat) < 0.08 < 1 < estimate(MARGIN, slice_, HERON)
    assert estimate(MARGIN, window, flat) > 1


def test_changes_of_nearly_similar_triangles_are_dear_if_their_senses_agree() -> None:
    near = {**HERON, "d1": "28", "d2": "30", "d3": f"26.{'0' * 30}1"}
    agree, differ = (estimate(MODES, {"length": "9"}, {**near, "orientation": x}) for x in ("ccw", "cw"))
    assert differ < agree / 2
    congruent = {**HERON, "d3": f"13.{'0' * 30}1", "orientation": "cw"}
    assert estimate(MODES, {"length": "9"}, congruent) > 2 * differ


@pytest.mark.parametrize(
    ("kind", "content", "least"),
    [
        (CUSP_CURVES, {**WHOLE, "lengths": [], "samples": 14}, 5),
        (ARTICLE_TABLE, {"l1": ["14.98", "27", f"14.98{'1' * 250}"]}, 5),
    ],
)
def test_points_and_long_lengths_are_priced(kind: Kind, content: Mapping[str, Any], least: float) -> None:
    assert estimate(kind, content) > least


@pytest.mark.parametrize(
    ("kind", "content", "geometry", "least"),
    [
        (CUSP_TABLE, {"l1": [str(k) for k in range(1, 201)]}, HERON, 2),
        (CUSP_TABLE, {"l1": [str(k) for k in range(1, 502)]}, {**HERON, "d3": f"13.{'0' * 19}1"}, 8),
        (PATH, {"length": "27", "cusp": 2, "samples": 101, "digits": 1000}, INNOCENTI, 1),
        (ASPECTS, WHOLE, {**ROUND, "d1": "10", "d2": "5", "d3": f"5.{'0' * 39}1"}, 5),
    ],
)
def test_found_by_the_search(
    kind: Kind, content: Mapping[str, Any], geometry: Mapping[str, str], least: float
) -> None:
    assert estimate(kind, content, geometry) > least


def test_only_slices_have_a_part_in_common() -> None:
    table = cost(request(CUSP_TABLE, {"l1": ["1", "2"]}))
    assert table.once > table.each > 0
    assert table.of(2) == table.once + 2 * table.each
    assert cost(request(CENSUS, WHOLE)).once == 0


def test_the_unit_of_length_does_not_matter() -> None:
    in_km = {name: f"{x}000" if "." not in x else x.replace(".", "") + "0" for name, x in INNOCENTI.items()}
    in_km = {**in_km, "orientation": "ccw"}
    assert request(CENSUS, WHOLE, in_km).sizes.geometry == request(CENSUS, WHOLE).sizes.geometry


def test_what_is_computed_once_costs_once() -> None:
    seen: set[str] = set()
    table = request(CUSP_TABLE, {"l1": ["1", "2", "3", "4", "5"]})
    whole = cost(table)
    assert seconds_after(table, seen) == whole.of(5)
    assert seconds_after(request(CUSP_TABLE, {"l1": ["6"]}), seen) == pytest.approx(whole.each, rel=0.1)
    assert seconds_after(table, seen) < whole.of(5) / 10
    assert seconds_after(request(CUSP_TABLE, {"l1": ["3"], "fixed_leg": 2}), seen) < whole.once / 2
    census = request(CENSUS, WHOLE)
    assert seconds_after(census, seen) == cost(census).each > 100 * seconds_after(census, seen)


@pytest.mark.parametrize(
    ("geometry", "length", "low", "high"),
    [(INNOCENTI, "14.98", 0.004, 0.014), (INNOCENTI, "14." + "7" * 400, 0.07, 0.28)],
)
def test_few_slices_are_charged_at_their_lengths_alone(
    geometry: dict[str, str], length: str, low: float, high: float
) -> None:
    one = request(CUSP_TABLE, {"l1": [length], "digits": 15}, geometry)
    assert low < seconds_after(one, set()) < high
    four = one.of_slices([length, "3", "5", "7"])
    assert low < seconds_after(four, set()) / 4 < high


def test_a_manipulator_that_is_asked_about_again_is_charged_for_all_lengths_once() -> None:
    seen: set[str] = set()
    one, two, three = (request(CUSP_TABLE, {"l1": [x]}) for x in ("1", "2", "3"))
    whole = cost(one)
    assert seconds_after(one, seen) < whole.once / 2
    assert [seconds_after(x, seen) for x in (two, three)] == pytest.approx([whole.of(1), whole.each])


def test_a_long_elimination_is_charged_whole() -> None:
    one = request(CUSP_TABLE, {"l1": ["1"]}, LONG)
    assert seconds_after(one, set()) == cost(one).of(1) > 5
