"""Samples by number, by steps of time and by chords; what legs between them deviate from linear motion."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from random import Random
from typing import Any

import pytest

from rpr_solver import InputError, Path
from rpr_solver.paths import sampling as sampling_plans
from rpr_solver.paths.motion import Motion
from rpr_solver.paths.timing import TimedCourse
from tests.rpr_solver.paths.test_motion import USUAL, joined, random_motion, random_path, the_loop
from tests.support.replay import Replay

Legs = list[float]


def legs_at(replay: Replay, place: Fraction) -> Legs:
    return [float(x) for x in replay.legs(replay.at(place))]


def apart(path: Path, per_row: int, rows: int, first_row: int = 0) -> list[float]:
    """How far legs are from linear motion between some rows, by leg; in shares of what is proved."""
    document = path.to_json()
    replay = Replay.of(document)
    most = [float(x) for x in document["deviation"].values()]
    worst = [0.0] * 3
    pairs = list(pairwise(path.samples))[first_row:]
    for before, after in pairs[:: max(1, len(pairs) // rows)]:
        first, last = ([float(x) for x in sample.lengths] for sample in (before, after))
        for k in range(1, per_row):
            share = Fraction(k, per_row)
            if path.motion is not None:
                time = before.time + share * (after.time - before.time)
                own, s = legs_at(replay, Fraction(sum(path.motion.place(time)))), float(share)
            else:
                own = legs_at(replay, before.place + share * (after.place - before.place))
                s = nearest(own, first, last, most)
            gaps = [abs(x - y) for x, y in zip(own, linear(first, last, s), strict=True)]
            worst = [max(x, y) for x, y in zip(worst, gaps, strict=True)]
    return [x / y if y else x for x, y in zip(worst, most, strict=True)]


def linear(first: Legs, last: Legs, share: float) -> Legs:
    return [x + share * (y - x) for x, y in zip(first, last, strict=True)]


def nearest(own: Legs, first: Legs, last: Legs, most: Legs) -> float:
    """The share of the way between rows that is nearest to some legs, in units of what is proved."""

    def gap(share: float) -> float:
        parts = zip(own, linear(first, last, share), most, strict=True)
        return max(abs(x - y) / size for x, y, size in parts if size)

    low, high = 0.0, 1.0
    for _ in range(60):  # the gap is convex
        a, b = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, b) if gap(a) < gap(b) else (a, high)
    return (low + high) / 2


def deviates(random: Random, rows: int) -> float:
    """The greatest share that is found of the deviation that is proved."""
    path = random_path(random)
    chord = str(float(max(path.samples[0].lengths, key=float)) / 500)
    motion = random.choice([{}, {"motion": random_motion(random)}])
    asked = random.choice([{"sampling": {"chord": chord}}, {"samples": 40}, {"sampling": {"number": 40}}])
    if not motion:
        asked = random.choice([{"sampling": {"chord": chord}}, {"sampling": {"step": "1/30"}}])
    sampled = path.resampled(**motion, **asked)  # type: ignore[arg-type]
    if "chord" in str(asked):
        assert sampled.deviation is not None
        assert max(sampled.deviation) <= Fraction(chord)
    found = max(apart(sampled, 4, rows))
    assert found <= 1 + 1e-6, (path, motion, asked)
    return found


def test_legs_between_rows_deviate_no_more_than_is_proved() -> None:
    random = Random(4)
    assert [deviates(random, 3) > 0 for _ in range(2)] == [True, True]


@pytest.mark.long
def test_legs_between_rows_deviate_no_more_than_is_proved_on_100_paths() -> None:
    random = Random(5)
    assert max(deviates(random, 40) for _ in range(100)) > 0.3


def test_a_chord_needs_no_more_rows_than_about_twice_as_many() -> None:
    path = the_loop().resampled(sampling={"chord": "0.01"})
    by_number = the_loop().resampled(motion=USUAL, sampling={"chord": "0.01"})
    assert max(apart(path, 4, 8)) > 0.3
    assert len(path.samples) < 150 > len(by_number.samples)


def test_rows_pass_a_joint_of_arcs_within_the_chord() -> None:
    path = joined().resampled(sampling={"chord": "0.05"})
    [row] = [k for k, pair in enumerate(pairwise(path.samples)) if pair[0].place < 1 <= pair[1].place]
    assert path.deviation is not None
    assert max(path.deviation) <= Fraction("0.05")
    assert max(apart(path, 8, 1, row)) <= 1 + 1e-6


@pytest.mark.parametrize("motion", [None, USUAL])
def test_steps_of_time(motion: dict[str, int] | None) -> None:
    path = the_loop().resampled(motion=motion, sampling={"step": "0.3"})
    times = [sample.time for sample in path.samples]
    assert times[:-1] == [Fraction(3, 10) * k for k in range(len(times) - 1)]
    assert 0 < times[-1] - times[-2] <= Fraction(3, 10)
    assert times[-1] == path.duration
    assert path.to_json()["sampling"] == {"step": "0.3"}


@pytest.mark.parametrize("motion", [None, USUAL])
def test_a_chord_that_is_far_too_small_is_refused_at_once(
    motion: dict[str, int] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is refused after a few deviations, not after as many as there may be samples."""
    asked: list[object] = []
    for kind in (TimedCourse, Motion):
        real = kind.deviation
        monkeypatch.setattr(kind, "deviation", lambda *x, real=real: (asked.append(x), real(*x))[1])
    with pytest.raises(InputError) as caught:
        the_loop().resampled(motion=motion, sampling={"chord": Fraction(1, 10**30)})
    [problem] = caught.value.problems
    assert problem.field == "sampling.chord"
    assert "it needs more than 10001 samples: give about " in problem.message
    assert len(asked) < 200


BAD: list[tuple[Any, str]] = [
    ({"chord": 0}, "sampling.chord: is 0; a chord must be > 0"),
    ({"chord": "1/1000000"}, "sampling.chord: is 0.000001; it needs more than 40 samples"),
    ({"step": "0.02"}, "sampling.step: is 0.02; it gives more than 40 samples"),
    ({"step": 1, "chord": 1}, "sampling.chord: is given beside step"),
    ({"number": 1}, "sampling.number: is 1; give 2 to 10001"),
    (7, "sampling: is 7; give one of number, step, chord"),
]


@pytest.mark.parametrize(("sampling", "text"), BAD)
def test_a_sampling_that_cannot_be_is_named(
    sampling: Any, text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sampling_plans, "MOST_SAMPLES", 40)
    with pytest.raises(InputError) as caught:
        the_loop().resampled(sampling=sampling)
    assert text in str(caught.value)
