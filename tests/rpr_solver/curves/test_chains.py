"""A full certificate of curves: chains join all that is to be joined, and the rest of the document stays."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import pytest
from flint import arb

from rpr_solver import EXAMPLES, CuspCurves, InputError
from rpr_solver.curves import chains
from rpr_solver.curves.chains import ProvedTube, shortened
from rpr_solver.curves.follower import Tracker
from tests.support.shared import curves_of, eliminant_of

FLAT = EXAMPLES["zein-flat"]


def test_each_pair_of_neighbours_and_each_end_in_the_range_has_a_chain() -> None:
    part = curves_of(FLAT, 1, 30).part(26, "26.5", lengths=["26.1", "26.3", "26.4"])
    document = part.to_json(certificate="full")
    listed = document["certificate"]["full"]["chains"]
    assert all(chain["tubes"] for chain in listed)
    found = [{(chain[side]["curve"], chain[side]["l1"]) for side in ("from", "to")} for chain in listed]
    lengths = {curve["name"]: [point["l1"] for point in curve["points"]] for curve in document["curves"]}
    neighbours = [{(name, a), (name, b)} for name, xs in lengths.items() for a, b in pairwise(xs)]
    turns = [
        {(curve["name"], lengths[curve["name"]][place]), (joined, lengths[joined][place])}
        for curve in document["curves"]
        for side, place in (("from", 0), ("to", -1))
        if (joined := curve[side]["joins"]) in lengths and 26 < float(curve[side]["l1"]) < 26.5
        if curve["name"] < joined
    ]
    assert len(turns) > 1
    assert sorted(map(sorted, found)) == sorted(map(sorted, neighbours + turns))
    del document["certificate"]
    assert document == part.to_json()


def test_an_end_that_is_lost_from_one_curve_is_passed_from_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    found = chains._chain

    def lost_from_the_first(tracker: Tracker, link: chains._Link) -> object:
        return None if link.start[0] < link.stop[0] else found(tracker, link)

    monkeypatch.setattr(chains, "_chain", lost_from_the_first)
    document = curves_of(FLAT, 1, 30).part("26.3", "26.5", lengths=["26.4"]).to_json(certificate="full")
    turns = document["certificate"]["full"]["chains"]
    assert turns
    assert all(chain["from"]["curve"] > chain["to"]["curve"] for chain in turns)


def test_documents_with_a_certificate_are_read() -> None:
    part = curves_of(FLAT, 1, 30).part(1, "1.1", lengths=[1])
    assert CuspCurves.from_json(part.to_json(certificate="full")) == part
    with pytest.raises(InputError, match="certificate"):
        part.to_json(certificate="long")


LOW, HIGH = Fraction(34), Fraction("34.6")


@pytest.fixture(scope="module")
def chain() -> list[tuple[ProvedTube, Tracker]]:
    tracker = Tracker(eliminant_of(EXAMPLES["zein-flat"]), 30)
    scale = tracker.eliminant.slice_map.scale
    follower = tracker.follower((LOW, 0), upwards=True)
    tubes: list[ProvedTube] = []
    while follower.walk(LOW * scale, HIGH * scale, 0) is None:
        assert follower.tube
        before = tubes[-1] if tubes else None
        start = None if tubes else tracker.place((LOW, 0), follower.bits)
        tube = shortened(follower.tube, tracker.forms, follower.bits, before, start)
        assert tube
        tubes.append(tube)
    return [(tube, tracker) for tube in tubes]


def test_the_printed_numbers_are_proved_and_short(chain: list[tuple[ProvedTube, Tracker]]) -> None:
    for proved, _ in chain:
        tube = proved.tube
        assert proved.passes()
        for narrow in (Fraction(1, 50), Fraction(1, 10**6)):
            p, q = tube.radii
            slim = replace(tube, radii=(p * narrow, q * narrow))
            assert not replace(proved, tube=slim).passes()
        other = replace(tube, slopes=(tube.slopes[0] + 1, tube.slopes[1]))
        assert not replace(proved, tube=other).passes()
        assert len(str(tube.to_json(1))) < 400


def test_they_hold_what_the_chain_joins(chain: list[tuple[ProvedTube, Tracker]]) -> None:
    tracker = chain[0][1]
    assert chain[0][0].contains(*tracker.place((LOW, 0), 128))
    assert not chain[0][0].contains(*tracker.place((LOW, 1), 128))
    for (before, _), (tube, _) in pairwise(chain):
        middle = tube.middle()
        assert middle is not None
        assert before.contains(*middle)
        place, length = middle
        assert not before.contains(place, length * arb(2))


@pytest.mark.parametrize(
    ("length", "text"),
    [(Fraction(27), "27"), (Fraction("-0.000123"), "-0.000123"), (Fraction("3e-61"), "3e-61")],
)
def test_numbers_are_exact_decimals(
    chain: list[tuple[ProvedTube, Tracker]], length: Fraction, text: str
) -> None:
    tube = replace(chain[0][0].tube, bends=(length, Fraction(0)))
    assert tube.to_json(1)["bends"] == [text, "0"]
