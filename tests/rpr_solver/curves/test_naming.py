"""Names of cusps through many slices, and exact poses of a slice: complete, in order, with partners."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cache

import mpmath as mp
import pytest

from rpr_solver import EXAMPLES, Manipulator, Unproved, solve_slice
from rpr_solver.contract import silent
from rpr_solver.curves.cusp_curve import Tracks, most_cusps, name_cusps, tracks
from rpr_solver.curves.follower import Tracker
from rpr_solver.model.joint_points import ExactPose
from rpr_solver.transitions.survey import Survey, survey
from tests.support.definitions import Slices, distance
from tests.support.families import family
from tests.support.places import cusps_in
from tests.support.sampling import long

MIRRORED = Manipulator(6, 3, 4, 6, 5, 5, "cw")
IRRATIONAL = Manipulator("6.77", 0, "6.77", "6.77", "13.54", "6.77")


def poses_of(whole: Survey) -> list[ExactPose]:
    return [e.pose for group in whole.groups for e in group if isinstance(e.pose, ExactPose)]


def test_it_is_the_number_of_the_slice() -> None:
    """At rational lengths, where roots of Q are multiple or leg f may be closed and stretched."""
    whole = survey(MIRRORED, 2, silent, start=Fraction("5.9"), stop=Fraction("9.7"))
    poses = poses_of(whole)
    lengths = [pose.length.rational for pose in poses]
    assert None not in lengths
    scale = whole.eliminant.slice_map.scale
    counts = [solve_slice(whole.eliminant, x / scale, 15).count for x in lengths if x is not None]
    found = [most_cusps(whole.eliminant, pose) for pose in poses]
    assert len(found) == 3
    assert any(count is not None for count in found)
    assert all(most in (None, count) for most, count in zip(found, counts, strict=True))


def test_a_cusp_is_missing_at_an_irrational_quadruple_point(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = survey(IRRATIONAL, 3, silent, start=Fraction("9.5"), stop=Fraction("9.6"))
    [pose] = poses_of(whole)
    assert [table.count for table in whole.slices] == [6, 6]
    assert most_cusps(whole.eliminant, pose) == 5
    monkeypatch.setattr("rpr_solver.curves.cusp_curve._GREATEST_DEGREE", 1)
    assert most_cusps(whole.eliminant, pose) is None


DIGITS = 25
FLAT = EXAMPLES["zein-flat"]


@pytest.fixture(autouse=True)
def _precision() -> Iterator[None]:
    with mp.workdps(20):
        yield


@cache
def surveyed() -> tuple[Survey, Tracker, Tracks, list[tuple[int, int]]]:
    """All of the flat manipulator's cusps for leg 1, and the progress that was told."""
    told: list[tuple[int, int]] = []
    whole = survey(FLAT, 1, silent, digits=DIGITS)
    tracker = Tracker(whole.eliminant, DIGITS, whole.tables)
    return whole, tracker, tracks(whole, tracker, lambda *step: told.append(step)), told


def leads_to(low: Fraction, high: Fraction, start: Fraction, index: int) -> tuple[Fraction, int]:
    """The cusp at which the curve of a cusp leaves the lengths between two, in floating point."""
    tracker = surveyed()[1]
    ends = {mp.mpf(x.numerator) / x.denominator: x for x in (low, high)}
    cusp = cusps_in(tracker.table(start))[index]
    end, point = Slices.of(FLAT).trace(cusp, *ends, upwards=start == low)
    reached = [k for k, x in enumerate(cusps_in(tracker.table(ends[end]))) if distance(x, point) < 1e-10]
    assert len(reached) == 1
    return ends[end], reached[0]


class TestTracks:
    @pytest.mark.long
    def test_where_tracks_begin_and_end_the_curve_turns_back(self) -> None:
        whole, _, named, _ = surveyed()
        lengths = [table.length for table in whole.slices]
        for number, track in list(enumerate(named.tracks))[::6]:
            first, last = min(track.cusps), max(track.cusps)
            if track.born_with is not None and track.born_with > number:
                here, partner = lengths[first], named.tracks[track.born_with].cusps[first]
                assert leads_to(lengths[first - 1], here, here, track.cusps[first]) == (here, partner)
            if track.dies_with is not None and track.dies_with > number:
                here, partner = lengths[last], named.tracks[track.dies_with].cusps[last]
                assert leads_to(here, lengths[last + 1], here, track.cusps[last]) == (here, partner)

    @pytest.mark.parametrize("k", [long(5), 7])
    def test_between_two_slices_a_track_follows_its_curve(self, k: int) -> None:
        whole, _, named, _ = surveyed()
        low, high = (table.length for table in whole.slices[k : k + 2])
        passing = [track for track in named.tracks if {k, k + 1} <= set(track.cusps)]
        assert len(passing) == 6
        for track in passing:
            assert leads_to(low, high, low, track.cusps[k]) == (high, track.cusps[k + 1])

    @pytest.mark.long
    def test_a_cusp_that_ends_and_another_that_begins_are_two_if_the_slice_between_has_fewer(self) -> None:
        """About a quadruple pose of the flat base, of irrational length, are six cusps; with it, five."""
        whole = survey(
            family("flat base"), 1, silent, start=Fraction("9.3"), stop=Fraction("10.6"), digits=DIGITS
        )
        named = tracks(whole, Tracker(whole.eliminant, DIGITS, whole.tables), silent)
        alone = [t for t in named.tracks if len(t.cusps) == 1]
        assert [min(t.cusps) for t in alone] == [0, 1]
        assert all(t.born_with is None and t.dies_with is None for t in named.tracks)
        assert named.undecided == frozenset()
        [group] = whole.groups
        [pose] = [event.pose for event in group]
        assert isinstance(pose, ExactPose)
        assert pose.length.rational is None
        assert most_cusps(whole.eliminant, pose) == 5

    @pytest.mark.long
    def test_what_is_not_counted_may_be_one(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("rpr_solver.curves.cusp_curve._GREATEST_DEGREE", 1)
        whole = survey(
            family("flat base"), 1, silent, start=Fraction("9.3"), stop=Fraction("10.6"), digits=DIGITS
        )
        assert tracks(whole, Tracker(whole.eliminant, DIGITS, whole.tables), silent).undecided == {0}

    @pytest.mark.long
    def test_at_a_rational_length_the_slice_itself_tells_that_they_are_not(self) -> None:
        """Held at leg 2 the right-angled manipulator has six cusps about L2 = 16, and five at 16."""
        whole = survey(
            family("right angles"), 2, silent, start=Fraction("15.9"), stop=Fraction("16.1"), digits=DIGITS
        )
        named = tracks(whole, Tracker(whole.eliminant, DIGITS, whole.tables), silent)
        assert [len(t.cusps) for t in named.tracks] == [2, 2, 2, 2, 2, 1, 1]
        assert named.undecided == frozenset()


class TestNames:
    @staticmethod
    def known(k: int) -> dict[Fraction, dict[int, int]]:
        """The names in slice k of the survey."""
        whole, _, named, _ = surveyed()
        return {whole.slices[k].length: {i: t.cusps[k] for i, t in enumerate(named.tracks) if k in t.cusps}}

    def test_names_are_those_of_the_tracks(self) -> None:
        """From two slices the names of all between follow, of cusps that die or are born between as well."""
        _, tracker, named, _ = surveyed()
        starts = {**self.known(8), **self.known(9), **self.known(10)}
        inside = [Fraction("29.5"), Fraction("31.8"), Fraction("32.5")]
        names = dict(name_cusps(tracker, starts, inside))
        assert set(names) == set(inside)
        for length, of in names.items():
            assert sorted(of.values()) == list(range(tracker.table(length).count))
            for name, index in of.items():
                below = max(x for x in starts if x < length)
                above = min(x for x in starts if x > length)
                if name in starts[below]:
                    assert leads_to(below, length, length, index) == (below, starts[below][name])
                else:
                    assert leads_to(length, above, length, index) == (above, starts[above][name])
            assert all(name < len(named.tracks) for name in of)

    def test_cusps_that_nothing_known_leads_to_are_not_named(self) -> None:
        """Two of eight are born between 29 and 31.86338."""
        whole, tracker, *_ = surveyed()
        assert [whole.slices[k].count for k in (8, 9)] == [6, 8]
        with pytest.raises(Unproved, match=r"not all cusps of the slice 31\.86338"):
            list(name_cusps(tracker, self.known(8), [whole.slices[9].length]))

    def test_a_curve_that_is_cut_names_no_cusp_beyond_its_end(self) -> None:
        """Tubes lead through the cut; a slice at the cut itself has a cusp once, not under both names."""
        tracker = surveyed()[1]
        [(low, below)], [(high, above)] = self.known(7).items(), self.known(8).items()
        cut = Fraction("28.5")
        assert low < cut < high
        passing = sorted(set(below) & set(above))[:2]
        renamed = {name + 100: index for name, index in above.items() if name in passing}
        starts = {low: below, high: {**{n: i for n, i in above.items() if n not in passing}, **renamed}}

        def holds(name: int, length: Fraction) -> bool:
            return length >= cut if name >= 100 else length <= cut or name not in passing

        lengths = [cut - Fraction(1, 10**8), cut, cut + Fraction(1, 10**8)]
        for some in (lengths, *([length] for length in lengths)):
            names = dict(name_cusps(tracker, starts, some, holds))
            for length in some:
                own = {name for name in names[length] if name in passing or name >= 100}
                assert own == (set(passing) if length <= cut else set(renamed))
                assert sorted(names[length].values()) == list(range(tracker.table(length).count))
