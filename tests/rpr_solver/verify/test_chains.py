"""Full certificates of curves: right ones are proved without a gap, and each fault is refused."""

from __future__ import annotations

import random
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import pytest

from rpr_solver import EXAMPLES, ClaimStatus, InputError, Manipulator, cusp_curves, verify_document
from rpr_solver.verify.chains import Chains, chain_of
from rpr_solver.verify.claims import Claim, Finding, OpenError
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.schema import read_document
from rpr_solver.verify.landmarks import Event, Landmark
from rpr_solver.verify.ranges import Range
from rpr_solver.verify.tubes import Forms, Pose, moved
from tests.support.chains import PAST, cut, poses, surface, tubes, window
from tests.support.mutations import OF_CHAINS, OF_CURVES, mutated
from tests.support.shared import curves_of
from tests.support.verified import accepted_but_no_mutation, random_documents

Document = dict[str, Any]


def claims(document: Document) -> list[Claim]:
    members = read_document(document).members
    return list(Chains(surface(), members).claims(poses(), cut, unknown, lambda _: None))


def unknown(*_: object) -> Finding:
    raise OpenError("no end at which nobody is joined is known")


def faults(document: Document) -> list[str]:
    return [claim.at for claim in claims(document) if claim.status is ClaimStatus.REFUSED]


def test_every_chain_is_proved() -> None:
    found = claims(window())
    chains = [claim for claim in found if claim.at.startswith("/certificate")]
    assert len(chains) == 3
    assert all(claim.status is ClaimStatus.PROVED for claim in chains)
    assert sum("turns back once, at the pose of the end" in claim.reason for claim in chains) == 1
    assert sum("never turns back" in claim.reason for claim in chains) == 2
    beyond = [claim.at for claim in found if claim.status is ClaimStatus.NOT_CHECKED]
    assert beyond == ["/curves/1/to"]  # at a length beyond the range
    assert not faults(window())


def test_each_fault_is_refused() -> None:
    for done, wrong in mutated(window(), OF_CHAINS, len(OF_CHAINS), seed=1):
        assert faults(wrong), done


def test_a_chain_that_turns_back_is_none_between_points_of_one_curve() -> None:
    document = deepcopy(window())
    chains = document["certificate"]["full"]["chains"]
    [past] = [chain for chain in chains if chain["from"]["curve"] != chain["to"]["curve"]]
    [first] = [chain for chain in chains if chain["from"]["curve"] == chain["to"]["curve"] == "C2"]
    # C1 at 1, past the swallowtail to C2 at 1, up to 1.05: said to be one curve
    document["curves"][0]["points"][1] = document["curves"][1]["points"][1]
    past["to"] = {"curve": "C1", "l1": "1.05"}
    past["tubes"] += first["tubes"]
    known = {**poses(), ("C1", Fraction("1.05")): poses()["C2", Fraction("1.05")]}
    found = Chains(surface(), read_document(document).members).claims(known, cut, unknown, lambda _: None)
    reasons = [claim.reason for claim in found if claim.status is ClaimStatus.REFUSED]
    assert "the length turns back on the way" in reasons


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("parameter", "l2"),
        ("leg", 1),
        ("half_alpha", ["0", "0"]),
        ("half_theta", ["1/2", "1"]),
        ("slopes", ["1", "2", "3"]),
        ("reach", "-1"),
        ("radii", ["0", "1"]),
        ("radii", ["1e-9000", "1"]),
        ("l1", "0"),
        ("bends", 1),
    ],
)
def test_what_is_no_tube_is_bad_input(name: str, value: object) -> None:
    document = deepcopy(window())
    document["certificate"]["full"]["chains"][0]["tubes"][0][name] = value
    with pytest.raises(InputError):
        Chains(surface(), read_document(document).members)


@pytest.mark.long
@pytest.mark.timeout(600)
@pytest.mark.parametrize("name", ["zein-flat", "innocenti"])
def test_all_curves_of_an_example_are_proved(name: str) -> None:
    document = curves_of(EXAMPLES[name]).to_json(certificate="full")
    verification = accepted_but_no_mutation(document, OF_CHAINS + OF_CURVES, 0, seed=2)
    assert verification.established


@pytest.mark.long
@pytest.mark.timeout(900)
def test_random_certificates() -> None:
    def curves(m: Manipulator, n: int, _: random.Random) -> _Certified:
        return _Certified(m, n % 3 + 1)

    for n, document in random_documents(31, 8, curves, degenerate_every=5):
        accepted_but_no_mutation(document, OF_CHAINS, 2, n)


class _Certified:
    def __init__(self, m: Manipulator, leg: int) -> None:
        self._curves = cusp_curves(m, digits=15, fixed_leg=leg)

    def to_json(self) -> Document:
        return self._curves.to_json(certificate="full")


BITS = 200


def test_from_one_tube_to_the_next_a_pose_has_the_coordinates_of_that() -> None:
    first, *_, last = tubes(PAST)
    pose = Pose(*(Interval.of(x, BITS) for x in (Fraction(1, 7), Fraction(-2), surface().unit)))
    box = moved(pose.about(first), first, last)
    for mine, other in zip(box, pose.about(last), strict=True):
        assert abs(mine.middle - other.middle) < Fraction(1, 10**20)
        assert mine.meets(other.at(BITS + 30))


def test_precision_is_rounded_outwards() -> None:
    x = Interval(-5, 5, 3)
    assert x.at(2) == Interval(-3, 3, 2)
    assert x.at(4) == Interval(-10, 10, 4)


def test_a_chain_has_no_gap_and_holds_its_points() -> None:
    forms, chain = Forms(surface()), tubes(PAST)
    start, stop = _ends()
    found = chain_of(surface(), forms, chain, (start, stop), cut())
    assert not found.fault
    assert [event.kind for event in found.turning or ()] == ["swallowtail"]
    # it may go back and forth
    back = chain_of(surface(), forms, chain[:2] + chain[1:], (start, stop), cut())
    assert (back.fault, len(back.turning or ())) == ("", 1)
    narrow = replace(chain[3], reach=chain[3].reach / 100)
    for wrong, ends in (
        ([], (start, stop)),
        (chain[:3] + chain[4:], (start, stop)),
        ([*chain[:3], narrow, *chain[4:]], (start, stop)),
        (chain, (stop, start)),
        (chain, (start, start)),
        (chain[:-1], (start, stop)),
    ):
        assert chain_of(surface(), forms, wrong, ends, cut()).fault


def turning(*events: Event | Landmark, opened: tuple[str, ...] = ()) -> tuple[Event, ...] | None:
    """Where the length turns back on the chain past the swallowtail, if these were all events."""
    found = SimpleNamespace(
        surface=surface(),
        open=opened,
        found=[event for event in events if isinstance(event, Event)],
        unnamed=[event for event in events if not isinstance(event, Event)],
    )
    part = Range(found, [], Fraction(1, 2), Fraction(6, 5))  # type: ignore[arg-type]
    return chain_of(surface(), Forms(surface()), tubes(PAST), _ends(), part).turning


def test_a_length_turns_back_at_events_only() -> None:
    [own] = chain_of(surface(), Forms(surface()), tubes(PAST), _ends(), cut()).turning or ()
    assert turning(*cut().events.found) == (own,)
    assert turning() == ()  # which is why the events must be all
    assert turning(own, opened=("an event may be missing",)) is None
    # a pose that is not known may be on the arc; one that is elsewhere, is not
    assert turning(Landmark(own.scaled)) is None
    assert turning(own, Landmark(own.scaled)) is None
    away = own.pose[0] + Interval.of(Fraction(1, 2), own.pose[0].bits)
    assert turning(replace(own, pose=(away, own.pose[1]))) == ()
    # it may turn back at one length and at the other, if events are not told apart
    near = own.scaled + Interval.of(Fraction(1, 1 << 30), own.scaled.bits)
    assert turning(own, Landmark(near)) is None
    wide = Interval.of(own.scaled.middle, own.scaled.bits, Fraction(1, 5))
    assert turning(replace(own, scaled=wide)) is None


def _ends() -> tuple[Pose, Pose]:
    return poses()["C1", Fraction(1)], poses()["C2", Fraction(1)]


@pytest.mark.long
def test_a_curve_through_a_node_has_no_turn_where_its_length_has_an_inflection() -> None:
    manipulator = Manipulator.from_json(
        {"a2x": 2, "a3x": -4, "a3y": 4, "d1": 1, "d2": 4, "d3": 3, "orientation": "ccw"}
    )
    part = cusp_curves(manipulator, digits=15, fixed_leg=3).part(
        "3.6", "6", lengths=[Fraction(18, 5), Fraction(6)]
    )
    verification = verify_document(part.to_json(certificate="full"))
    chains = [claim for claim in verification.claims if claim.at.startswith("/certificate")]
    assert [claim.status for claim in chains] == 6 * [ClaimStatus.PROVED]
