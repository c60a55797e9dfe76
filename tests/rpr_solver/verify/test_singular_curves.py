"""Singular curves: right documents are accepted, each false claim is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from random import Random
from typing import Any

import pytest

from rpr_solver import EXAMPLES, InputError, Manipulator, poses, singular_curves, verify_document
from rpr_solver.exact.rationals import exact_str
from rpr_solver.verify.core.numbers import HALF_WAY
from rpr_solver.verify.core.schema import read_document
from rpr_solver.verify.poses import number_of_poses
from tests.rpr_solver.verify import singular_forger
from tests.rpr_solver.verify.forgeries import first_line
from tests.rpr_solver.verify.forging import Forge, is_fooled
from tests.support.families import FAMILIES, family
from tests.support.sampling import long, sample
from tests.support.verified import is_refused, refusal

pytestmark = pytest.mark.usefixtures("slices_are_found_once")
Document = Any
SLICES: dict[str, tuple[Manipulator, object, int]] = {
    "two components": (EXAMPLES["innocenti"], "14.98", 1),
    "three components": (EXAMPLES["innocenti"], 27, 1),
    "flat": (EXAMPLES["zein-flat"], 34, 1),
    "leg 3": (Manipulator(9, 4, 11, 14, 15, 13), 12, 3),
    "beak": (Manipulator(2, -3, -1, 4, 2, 3), "3.65164237044", 3),
}
LIPS = Manipulator(-4, -4, 3, 2, 2, 2, orientation="cw"), "0.58544942732541858823540898378", 1
"""10^-15 beside a transition: two cusps are about to enter."""


SLICES["nodes"] = family("similar"), "31.6", 1
SLICES["both flat"] = family("both flat"), 8, 3
SLICES["both flat, tips by turns"] = Manipulator(-1, -7, 0, 4, 6, 10), "1.3", 3
"""Strands end in tips that have the images of those that are known, elsewhere."""
SLICES["mirrored"] = family("congruent, mirrored"), "36.4", 1
SLICES["a bend across folds"] = Manipulator(-4, 5, 12, 4, 15, 13), "3.7", 1
"""Similar triangles, whose legs have squares of different sizes."""
SLICES["closed at a turning point"] = family("congruent"), 36, 1
SLICES["closed beside a turning point"] = Manipulator(5, 0, 12, 4, 13, 15, orientation="cw"), 10, 2
"""A leg closes in the direction of a turning point, on another arc."""
SLICES["closed where a chart ends"] = Manipulator(8, 4, 3, 13, 13, 10, orientation="cw"), 12, 3
"""A leg closes where tan(θ/2) is −2."""
SLICES["closed on lines"] = Manipulator(30, 0, 40, 30, 50, 40), "13.9", 3
"""Leg 2 closes in the directions of two nodes, on arcs that cross the lines of these."""
SLICES["closed legs alike"] = Manipulator(5, 3, 4, 4, 3, 2, orientation="cw"), 3 + Fraction(1, 10**32), 1
"""A leg closes at two poses 10^-16 apart, neighbours on a strand."""
SLICES["points alike"] = EXAMPLES["innocenti"], "14.579220635391537878132204684640393680441", 1
"""10^-40 beside a beak-to-beak: two strands have a cusp and a turning point that are printed alike."""


@cache
def _text(name: str) -> str:
    manipulator, length, leg = SLICES[name]
    return json.dumps(singular_curves(manipulator, length, fixed_leg=leg).to_json())  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "name",
    [long(name) if name in ("three components", "beak", "closed legs alike") else name for name in SLICES],
)
def test_a_right_document_is_established(name: str) -> None:
    verification = verify_document(_text(name))
    assert verification.established, verification.open


@long
def test_regions_beside_a_transition_are_all() -> None:
    manipulator, length, leg = LIPS
    document = singular_curves(manipulator, length, fixed_leg=leg).to_json()
    assert verify_document(json.loads(json.dumps(document))).established


def _first(document: Document, kind: str) -> Document:
    strands = [strand for part in document["components"] for strand in part["strands"]]
    return next(v for strand in strands for v in strand["vertices"] if v["kind"] == kind)


def _exchange(document: Document) -> None:
    vertices = document["components"][0]["strands"][0]["vertices"]
    first, second = [v for v in vertices if v["kind"] == "cusp"][:2]
    first["index"], second["index"] = second["index"], first["index"]
    vertices.sort(key=lambda v: v["index"])


def _without(kind: str) -> Callable[[Document], None]:
    def forge(document: Document) -> None:
        strand = document["components"][0]["strands"][0]
        strand["vertices"].remove(next(v for v in strand["vertices"] if v["kind"] == kind))

    return forge


def _last_digit(kind: str, name: str) -> Callable[[Document], None]:
    def forge(document: Document) -> None:
        vertex = _first(document, kind)
        text = vertex[name]
        vertex[name] = text[:-1] + ("1" if text[-1] != "1" else "2")

    return forge


def _aside(document: Document, to: int, of: int) -> None:
    """The point of a region a little beside that of another, with as many poses."""
    regions = document["regions"]
    assert regions[to]["poses"] == regions[of]["poses"]
    point = {name: str(Fraction(x) + Fraction(1, 10**9)) for name, x in regions[of]["point"].items()}
    regions[to]["point"] = {name: exact_str(Fraction(x)) for name, x in point.items()}


def _twice(document: Document) -> None:
    document["regions"].insert(2, dict(document["regions"][1]))
    _aside(document, 2, 1)


FORGERIES: dict[str, Callable[[Document], object]] = {
    "a region less": lambda d: d["regions"].pop(0),
    "a region twice, at another point": _twice,
    "a region in place of another": lambda d: _aside(d, 2, 1),
    "a cusp less": _without("cusp"),
    "a turning point less": _without("turning"),
    "a closed leg less": _without("closed-leg"),
    "another digit of a cusp": _last_digit("cusp", "alpha_deg"),
    "another digit of a turning point": _last_digit("turning", "l2"),
    "another digit of a closed leg": _last_digit("closed-leg", "theta1_deg"),
    "two cusps exchanged": _exchange,
    "other turns": lambda d: d["components"][0]["strands"][0]["turns"].update(alpha=1),
    "an open strand": lambda d: d["components"][0]["strands"][0].update(closed=False),
    "a component twice": lambda d: d["components"].append(d["components"][0]),
    "no component": lambda d: d["components"].clear(),
    "an aspect less": lambda d: d["aspects"].pop(),
    "an aspect of the other sign": lambda d: d["aspects"][0].update(sign=-1),
    "more poses in a region": lambda d: d["regions"][1].update(poses=6),
    "a bounded region as unbounded": lambda d: d["regions"][-1].update(bounded=True),
    "a cusp as a node": lambda d: (_first(d, "cusp").update(kind="node"), _first(d, "node").pop("cusp")),
    "two unbounded regions": lambda d: d["regions"][0].update(bounded=False),
}


OF_FLAT: dict[str, Callable[[Document], object]] = {
    "a region without poses as unbounded": lambda d: [
        row.update(bounded=k != 4) for k, row in enumerate(d["regions"])
    ],
    "a region less, as too thin": lambda d: (d["regions"].pop(1), d.update(thin_regions=1)),
    "the unbounded region as too thin": lambda d: (d["regions"].pop(), d.update(thin_regions=1)),
}
"""Forgeries of a slice with a bounded region without poses."""


def _elsewhere(document: Document) -> None:
    """A strand to the node at which it begins."""
    vertices = document["components"][0]["strands"][2]["vertices"]
    vertices[-1] = {**vertices[0], "index": vertices[-1]["index"]}


def _apart(document: Document) -> None:
    """Two strands of a component as another one."""
    strands = document["components"][0]["strands"]
    document["components"].append({**document["components"][0], "strands": [strands.pop(), strands.pop()]})


def _of_all(named: str, **changes: str) -> Callable[[Document], None]:
    """Other members of all vertices that are printed alike."""

    def forge(document: Document) -> None:
        first = {name: x for name, x in _first(document, named).items() if name != "index"}
        for part in document["components"]:
            for vertex in (v for strand in part["strands"] for v in strand["vertices"]):
                if {name: x for name, x in vertex.items() if name != "index"} == first:
                    vertex.update(changes)

    return forge


OF_NODES: dict[str, Callable[[Document], None]] = {
    "a strand to another node": _elsewhere,
    "the strands of a node as two components": _apart,
    "a strand between nodes as a closed one": lambda d: d["components"][0]["strands"][0].update(closed=True),
    "a node as a quadruple pose": _of_all("node", kind="quadruple"),
    "a node with another length": _of_all("node", l2="15.5307632861725"),
}
"""Forgeries of a slice with two nodes."""


def test_a_component_that_floats_do_not_tell_from_a_point_leaves_the_regions_open() -> None:
    manipulator = Manipulator(9, 4, 11, 14, 15, 13)
    curves = singular_curves(manipulator, "26.66357535880746325243329331601050", fixed_leg=3)
    verification = verify_document(json.loads(json.dumps(curves.to_json())))
    assert verification.accepted
    open_ones = {claim.at for claim in verification.open}
    assert "/regions" in open_ones
    assert all(at.startswith(("/regions", "/thin_regions")) for at in open_ones)


@pytest.mark.parametrize("name", OF_NODES)
def test_a_false_claim_about_nodes_is_refused_or_named(name: str) -> None:
    document = json.loads(_text("nodes"))
    OF_NODES[name](document)
    assert not is_fooled(first_line(document), "/components")


def _swap(document: Document, *places: tuple[int, int]) -> None:
    """Two vertices exchanged, each named by its strand and its number there."""
    rows = [document["components"][0]["strands"][strand]["vertices"][k] for strand, k in places]
    (first, one), (second, other) = ((row, dict(row)) for row in rows)
    first.update({**other, "index": one["index"]})
    second.update({**one, "index": other["index"]})


OF_LINES: dict[str, Callable[[Document], object]] = {
    "two closed legs exchanged": lambda d: _swap(d, (2, 2), (2, 3)),
    "a closed leg on another strand": lambda d: _swap(d, (2, 3), (3, 2)),
    "a closed leg on a line less": lambda d: d["components"][0]["strands"][2]["vertices"].pop(3),
}
"""Forgeries of a slice in which legs close in the directions of nodes."""


@pytest.mark.parametrize("name", OF_LINES)
def test_a_false_claim_about_points_on_lines_is_refused(name: str) -> None:
    document = json.loads(_text("closed on lines"))
    OF_LINES[name](document)
    assert first_line(document).startswith("REFUSED")


def _moved(document: Document) -> None:
    """A turning point beside the one of another strand that is printed alike."""
    first, second = (part["strands"][0]["vertices"] for part in document["components"])
    point = second.pop(5)
    assert {**point, "index": first[7]["index"]} == first[7]
    point["index"] = first[7]["index"] + 1
    first.insert(8, point)


OF_ALIKE: dict[str, Callable[[Document], object]] = {
    "one of two turning points that are printed alike less": lambda d: d["components"][1]["strands"][0][
        "vertices"
    ].pop(5),
    "a turning point on the strand of one that is printed alike": _moved,
}
"""Forgeries of a slice with points that are printed alike, on two strands."""


@pytest.mark.parametrize("name", OF_ALIKE)
def test_a_false_claim_about_points_that_are_printed_alike_is_refused(name: str) -> None:
    document = json.loads(_text("points alike"))
    OF_ALIKE[name](document)
    assert first_line(document).startswith("REFUSED")


@pytest.mark.parametrize("name", FAMILIES)
def test_the_number_of_poses_is_told_for_every_shape(name: str) -> None:
    """Also where poses share an angle, and the linear equations are dependent there."""
    draw, found = Random(45), set()
    document: Any = read_document(poses(family(name), 12, 13, 14).to_json())
    size = document.geometry.a2x
    for _ in range(12):
        lengths = [size * Fraction(draw.randint(10, 60), 30) for _ in range(3)]
        first, second, third = (length**2 for length in lengths)
        number = number_of_poses(document.geometry, (first, second, third))
        assert poses(family(name), *lengths).count == number
        found.add(number)
    assert len(found) > 1


def test_a_leg_that_is_closed_at_a_turning_point_is_listed_as_this_alone() -> None:
    document = json.loads(_text("closed at a turning point"))
    vertices = document["components"][0]["strands"][0]["vertices"]
    assert (vertices[1]["kind"], vertices[1]["l2"]) == ("turning", "0")
    vertices.insert(2, {**vertices[1], "kind": "closed-leg", "index": vertices[1]["index"] + 1})
    assert is_refused(document)
    del vertices[1]
    assert is_refused(document)


OF_FOLDS: dict[str, tuple[str, str, Callable[[Document], object]]] = {
    "a region between two folds less": ("nodes", "/thin_regions", lambda d: d["regions"].pop(1)),
    "a region beside the bend twice": ("nodes", "/regions", _twice),
    "more poses of mirrored triangles": (
        "mirrored",
        "/regions/2/poses",
        lambda d: d["regions"][2].update(poses=6),
    ),
    "the only region of flat triangles as too thin": (
        "both flat",
        "/thin_regions",
        lambda d: d["regions"].pop(0),
    ),
    "a region of flat triangles twice": (
        "both flat",
        "/regions",
        lambda d: (d["regions"].insert(1, dict(d["regions"][0])), _aside(d, 1, 0)),
    ),
    "a region of mirrored triangles less": ("mirrored", "/thin_regions", lambda d: d["regions"].pop(2)),
}
"""Forgeries of slices of similar and mirrored triangles."""


@pytest.mark.parametrize("name", OF_FOLDS)
def test_a_false_claim_about_regions_of_a_folded_slice_is_refused(name: str) -> None:
    base, at, forge = OF_FOLDS[name]
    document = json.loads(_text(base))
    forge(document)
    assert at in {claim.at for claim in verify_document(document).refused}


BESIDE = 75 - Fraction(1, 10**30), 25 - Fraction(1, 10**40)
"""Nodes of similar triangles about to vanish: two are printed alike, two arcs pass a line 10^-20 apart."""


@pytest.mark.parametrize(
    ("name", "length"),
    [("both flat", "31.6"), ("congruent, mirrored", "31.6"), *(("similar", x) for x in ("31.6", *BESIDE))],
)
def test_strands_between_nodes_are_found_anew(name: str, length: object) -> None:
    document = json.loads(json.dumps(singular_curves(family(name), length).to_json()))  # type: ignore[arg-type]
    claims = verify_document(document).claims
    assert all(claim.established for claim in claims if not claim.at.startswith(("/regions", "/thin")))
    assert len(document["components"][0]["strands"]) >= 4


OF_BEAK: dict[str, Callable[[Document], None]] = {
    "a narrow region in two parts": lambda d: d["regions"].insert(
        5, {**d["regions"][4], "point": {"l1": "2.3125943", "l2": "0.0959906"}}
    ),
}
"""Forgeries 10^-11 beside a beak-to-beak, where arcs of the image are too near to be told apart."""


def test_a_region_that_is_listed_twice_beside_a_transition_is_refused() -> None:
    document = json.loads(_text("beak"))  # 3 s: the cheapest slice where only the map's cubic part decides
    OF_BEAK["a narrow region in two parts"](document)
    reasons = [claim.reason for claim in verify_document(document).refused]
    assert reasons == ["two of the points are in one region"]


@pytest.mark.parametrize("name", sample(FORGERIES, *range(0, len(FORGERIES), 2)))
def test_a_false_claim_is_refused(name: str) -> None:
    document = json.loads(_text("two components"))
    FORGERIES[name](document)
    assert refusal(document) is not None


@pytest.mark.quick
def test_a_special_point_is_at_a_sample() -> None:
    document = json.loads(_text("two components"))
    document["components"][0]["strands"][0]["vertices"][-1]["index"] = 99_999
    with pytest.raises(InputError, match="vertices/11/index: is that of no sample"):
        verify_document(document)


@pytest.mark.parametrize("name", OF_FLAT)
def test_a_false_claim_about_regions_without_poses_or_points_is_refused(name: str) -> None:
    document = json.loads(_text("flat"))
    OF_FLAT[name](document)
    refused = {claim.at for claim in verify_document(document).refused}
    if "thin" in name:
        assert "/thin_regions" in refused
    else:
        assert refused == {"/regions/4/bounded", "/regions/5/bounded"}


def test_regions_that_are_too_thin_for_a_tolerance_are_established() -> None:
    manipulator, length, leg = SLICES["leg 3"]
    document = singular_curves(manipulator, length, fixed_leg=leg, tolerance="0.05").to_json()  # type: ignore[arg-type]
    verification = verify_document(json.loads(json.dumps(document)))
    assert document["thin_regions"] == 3
    assert verification.established
    assert "/tolerance" not in verification.unread
    [claim] = [claim for claim in verification.claims if claim.at == "/thin_regions"]
    assert (
        claim.claim == "no region without a point has room for a circle with a radius of 0.2 of the picture"
    )
    document["tolerance"] = "0.0005"  # a circle with a hundredth of this radius fits into all of them
    assert [claim.at for claim in verify_document(json.loads(json.dumps(document))).refused] == [
        "/thin_regions"
    ]


def test_a_tolerance_says_nothing_without_thin_regions_and_is_possible() -> None:
    document = json.loads(_text("flat"))
    assert "/tolerance" in verify_document(document).unread
    document["tolerance"] = "0.11"
    assert is_refused(document)


def test_a_leg_is_closed_only_if_it_is_exactly() -> None:
    # B2 is at A2 and B3 10^-30 beside A3
    manipulator = Manipulator(6, Fraction(126, 10) - Fraction(1, 10**30), Fraction(112, 10), 5, 13, 12)
    document = json.loads(json.dumps(singular_curves(manipulator, 5).to_json()))
    assert verify_document(document).accepted
    vertices = [vertex for part in document["components"] for vertex in part["strands"][0]["vertices"]]
    [nearly] = [x for x in vertices if x["l2"] == "0" and Fraction(x["l3"]) < 1]
    nearly["l3"] = "0"
    assert is_refused(document)


def test_a_number_halfway_between_two_that_are_printed_is_not_refused() -> None:
    document = json.loads(json.dumps(singular_curves(family("similar"), "25.000000000001").to_json()))
    verification = verify_document(document)  # l2 is 31.25000000000125
    assert verification.accepted
    assert {claim.reason for claim in verification.open if "vertices" in claim.at} == {HALF_WAY}
    _last_digit("closed-leg", "l3")(document)
    assert is_refused(document)


@pytest.mark.parametrize("off", [Fraction(1, 10**16), long(Fraction(-1, 10**30))], ids=str)
def test_points_that_are_nearer_than_floats_tell_are_in_their_order(off: Fraction) -> None:
    manipulator = Manipulator(6, Fraction(126, 10) + off, Fraction(112, 10), 5, 13, 12)
    verification = verify_document(json.loads(json.dumps(singular_curves(manipulator, 5).to_json())))
    assert {claim.at for claim in verification.claims if not claim.established} <= {"/regions"}


def test_numbers_of_drawings_are_floats_and_others_are_not() -> None:
    text = _text("flat")
    with pytest.raises(InputError, match="integer"):
        verify_document(text.replace('"poses": 4', '"poses": 4.0', 1))
    with pytest.raises(InputError, match="number"):
        verify_document(text.replace('"share": 0.', '"share": 1e999, "x": 0.', 1))


def test_points_in_the_direction_of_a_node_are_on_arcs_that_cross_its_line() -> None:
    curves = singular_curves(Manipulator(3, 3, 4, 3, 4, 5), 7)
    verification = verify_document(curves.to_json())
    assert verification.established, verification.open


@pytest.mark.parametrize("forge", dict.fromkeys(singular_forger.FORGES), ids=lambda forge: forge.__name__)
def test_what_the_random_forger_changes_is_refused_or_named(forge: Forge) -> None:
    random, document = Random(20), json.loads(_text("leg 3"))
    while (forged := forge(random, altered := json.loads(json.dumps(document)))) is None:
        pass
    assert is_refused(altered) or is_fooled(first_line(altered), forged[1]) is False, forged
