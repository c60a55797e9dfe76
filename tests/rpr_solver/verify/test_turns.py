"""Where the length turns back along a tube: once at a swallowtail, and on no arc beside it."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.links import chain_of
from rpr_solver.verify.tubes import LENGTH, Forms, Local
from rpr_solver.verify.turns import turns
from tests.support.chains import PAST, poses, surface, tubes


def test_a_turn_is_found_once_however_the_arc_is_cut() -> None:
    forms, chain = Forms(surface()), tubes(PAST)
    found = chain_of(surface(), forms, chain, poses()["C1", Fraction(1)], poses()["C2", Fraction(1)])
    assert found.turning
    [k] = found.turning
    assert chain[k].parameter != LENGTH
    local = Local(forms, chain[k])
    ends = [chain[k].reach * n / 4 for n in range(-4, 5)]
    for parts in (ends, ends[::-1], ends[::8]):
        found_in = [
            turns(local, Interval.of(low, local.bits), Interval.of(high, local.bits))
            for low, high in pairwise(parts)
        ]
        assert sorted(map(str, found_in)) == ["0"] * (len(parts) - 2) + ["1"]


def test_where_the_length_is_the_parameter_it_never_turns() -> None:
    [tube, *_] = tubes(0)
    local = Local(Forms(surface()), tube)
    assert tube.parameter == LENGTH
    assert turns(local, Interval.of(0, local.bits), Interval.of(tube.reach, local.bits)) == 0
