"""Forgeries of what a path claims besides its arcs: motion, rows, deviation and clearance, for the forger.

That a claim is false is shown by the motion itself, which mpmath drives from the document: a leg is faster
somewhere, farther from a chord, a fold is nearer.
"""

from __future__ import annotations

import random
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import accumulate, pairwise

from mpmath import mp, mpf

from rpr_solver import exact_str
from rpr_solver.exact.decimals import round_fraction
from tests.rpr_solver.verify.forging import Document, Forge, Forged
from tests.rpr_solver.verify.path_forger import ENDS, fraction_of, is_found, lengths_of, replay_of, theta_of
from tests.support.replay import Place, Replay, number

LEGS = ("l1", "l2", "l3")
KINDS = ("speed", "acceleration", "jerk")
_STEP = Fraction(1, 10**9)
"""Of differences in time, in ticks."""
_MOMENTS, _BETWEEN = 40, 12
_PLACES, _FINER = 32, 4
_POINTS, _RAYS, _GROWTH = 16, 16, Fraction(11, 10)
_LESS = (Fraction(9, 10), Fraction(99, 100), Fraction(999, 1000))
_CLOSE = Fraction(1, 10**9)


@dataclass(frozen=True)
class Driven:
    """A motion by the laws of its certificate: the speed of a run's parameter is in proportion to a function
    that is linear between ticks, or to its mean over the last ticks of a window.
    """

    document: Document
    replay: Replay

    @property
    def laws(self) -> list[Document]:
        laws: list[Document] = self.document["certificate"]["motion"]
        return laws

    @property
    def starts(self) -> list[Fraction]:
        """The times at which runs begin, and that at which the last one ends."""
        own = ((self._ticks(law), Fraction(law["tick"])) for law in self.laws)
        return [Fraction(0), *accumulate(n * tick for n, tick in own)]

    @staticmethod
    def _ticks(law: Document) -> int:
        window = law["window"]
        return len(law["speeds"]) - 1 + (window if window > 1 else 0)

    @staticmethod
    def _way(speeds: Sequence[int], ticks: Fraction) -> tuple[Fraction, Fraction]:
        """The first and the second integral of the speeds up to a time."""
        ticks = max(ticks, Fraction(0))
        n = min(int(ticks), len(speeds) - 1)
        (once, twice), part = _integrals(tuple(speeds))[n], ticks - n
        if n == len(speeds) - 1:
            return once, twice + once * part
        x, y = speeds[n : n + 2]
        twice += once * part + x * part**2 / 2 + (y - x) * part**3 / 6
        return once + x * part + (y - x) * part**2 / 2, twice

    def place(self, time: Fraction) -> Fraction:
        """Where it is at a time."""
        n = min(bisect_right(self.starts, time), len(self.laws)) - 1
        law = self.laws[n]
        speeds, window, ticks = law["speeds"], law["window"], (time - self.starts[n]) / Fraction(law["tick"])
        whole, _ = self._way(speeds, Fraction(len(speeds)))
        if window == 1:
            at = self._way(speeds, ticks)[0] / whole
        else:
            late, early = (self._way(speeds, x)[1] for x in (ticks, ticks - window))
            at = (late - early) / (window * whole)
        shares = [Fraction(x) for x in law["shares"]]
        marks = [Fraction(0), *accumulate(shares)]
        arc = min(bisect_right(marks, at), len(shares)) - 1
        before = sum(len(own["shares"]) for own in self.laws[:n])
        return before + arc + (at - marks[arc]) / shares[arc]

    def legs(self, time: Fraction) -> tuple[mpf, ...]:
        """The lengths at a time."""
        return self.replay.legs(self.replay.at(self.place(time)))

    def peaks(self, draw: random.Random) -> dict[tuple[str, str], Fraction]:
        """The greatest derivatives by time, by kind and leg, at times within ticks; each is reached."""
        found: dict[tuple[str, str], Fraction] = {}
        for _ in range(_MOMENTS):
            n = draw.randrange(len(self.laws))
            tick = Fraction(self.laws[n]["tick"])
            ticks = draw.randrange(self._ticks(self.laws[n])) + Fraction(draw.randint(2, 98), 100)
            time, step = self.starts[n] + ticks * tick, tick * _STEP
            rows = [self.legs(time + k * step) for k in (-3, -1, 1, 3)]
            with mp.workdps(60):
                size = 2 * number(step)
                for kind in KINDS:
                    rows = [
                        tuple((y - x) / size for x, y in zip(*pair, strict=True)) for pair in pairwise(rows)
                    ]
                    middle = rows[len(rows) // 2]
                    for leg, x in zip(LEGS, middle, strict=True):
                        own = fraction_of(abs(x))
                        found[kind, leg] = max(found.get((kind, leg), Fraction(0)), own)
        return found

    def excess(self, draw: random.Random) -> Fraction:
        """By which factor times could be shorter, or must be longer, if that is more than 1, within the
        limits; at least this."""
        ratios = [Fraction(0)]
        for (kind, leg), peak in self.peaks(draw).items():
            if (limit := self.document["motion"].get(kind, {}).get(leg)) is not None:
                share = float(peak / Fraction(limit))
                ratios.append(Fraction(share ** (1 / (1 + KINDS.index(kind)))))
        return max(ratios)


@lru_cache(maxsize=16)
def _integrals(speeds: tuple[int, ...]) -> list[tuple[Fraction, Fraction]]:
    """Both integrals at each tick."""
    result = [(Fraction(0), Fraction(0))]
    for x, y in pairwise(speeds):
        once, twice = result[-1]
        result.append((once + Fraction(x + y, 2), twice + once + Fraction(2 * x + y, 6)))
    return result


def _driven(document: Document) -> Driven | None:
    """The motion of a document; None if it has none."""
    if not is_found(document) or "motion" not in document:
        return None
    return Driven(document, replay_of(document))


def times(document: Document, factor: Fraction) -> None:
    """All times of a motion, multiplied."""
    rows: list[tuple[Document, str]] = [(row, "time") for row in document["samples"]]
    rows += [(law, "tick") for law in document["certificate"]["motion"]]
    rows += [(document["sampling"], "step")] if "step" in document.get("sampling", {}) else []
    for row, name in [(document, "duration"), *rows]:
        row[name] = exact_str(Fraction(row[name]) * factor)
    document["motion"]["stops"] = [exact_str(Fraction(x) * factor) for x in document["motion"]["stops"]]


def rows_anew(document: Document) -> None:
    """All rows where the motion is at their times, but for the bounds that they have."""
    motion = Driven(document, replay_of(document))
    for row in document["samples"]:
        place = motion.place(Fraction(row["time"]))
        at = motion.replay.at(place)
        numbers = dict(
            zip(("alpha_deg", theta_of(document), *LEGS), (*at[:2], *motion.replay.legs(at)), strict=True)
        )
        for name, x in numbers.items():
            row[name] = round_fraction(fraction_of(x), document["digits"])
        own = fraction_of(abs(motion.replay.determinant(at)))
        row["determinant"] = round_fraction(document["sign"] * own, document["digits"])
        row.update(place=exact_str(place), clearance_deg=round_fraction(_CLOSE, 6))


def limit_of_motion_changed(draw: random.Random, document: Document) -> Forged:
    """A limit of a leg's speed, acceleration or jerk that it exceeds at a time."""
    if (motion := _driven(document)) is None:
        return None
    peaks = motion.peaks(draw)
    kind = draw.choice([x for x in KINDS if x in document["motion"]])
    leg = draw.choice(sorted(document["motion"][kind]))
    if peaks[kind, leg] < _CLOSE * max(peaks[kind, x] for x in LEGS):
        return None
    document["motion"][kind][leg] = exact_str(
        Fraction(round_fraction(peaks[kind, leg] * draw.choice(_LESS), 9))
    )
    return f"a limit of {kind} that is exceeded", f"/motion/{kind}"


def motion_faster(draw: random.Random, document: Document) -> Forged:
    """The same motion in less time, so that a limit is exceeded."""
    if (motion := _driven(document)) is None or not (excess := motion.excess(draw)):
        return None
    factor = Fraction(round_fraction(excess * draw.choice(_LESS), 9))
    times(document, factor)
    return "a motion that is too fast", "/motion"


def law_changed(draw: random.Random, document: Document) -> Forged:
    """Another speed in a law: rows are elsewhere; or they are made anew, and a limit is exceeded, or the law
    rests on the way."""
    if (motion := _driven(document)) is None:
        return None
    before = [motion.place(Fraction(row["time"])) for row in document["samples"]]
    law = draw.choice(motion.laws)
    k = draw.randrange(1, len(law["speeds"]) - 1)
    if draw.random() < 0.2:
        width = 1 if law["window"] == 1 else law["window"] + 1
        law["speeds"][k : k + width] = [0] * len(law["speeds"][k : k + width])
        times(document, Fraction(draw.choice([30, 100])))
        rows_anew(document)
        document["deviation"] = dict.fromkeys(document["deviation"], "10000")
        if "chord" in document.get("sampling", {}):
            document["sampling"]["chord"] = "10000"
        return ("a law that rests on the way", "/motion/stops") if k + width < len(law["speeds"]) else None
    law["speeds"][k] = max(1, law["speeds"][k] * draw.choice([1, 9, 11, 30]) // 10)
    if draw.random() < 0.5:
        after = [motion.place(Fraction(row["time"])) for row in document["samples"]]
        far = max(abs(x - y) for x, y in zip(before, after, strict=True))
        return ("a law that leads elsewhere", "/samples") if far > _CLOSE else None
    rows_anew(document)
    return ("a law that exceeds a limit", "/motion") if motion.excess(draw) > 1 + _CLOSE else None


def times_changed(draw: random.Random, document: Document) -> Forged:
    """Another duration, tick, window or stop; or shares of arcs, or a law less."""
    if (motion := _driven(document)) is None:
        return None
    laws, stops = motion.laws, document["motion"]["stops"]
    law, later = draw.choice(laws), exact_str(Fraction(document["duration"]) * Fraction(10001, 10000))
    match draw.randrange(6):
        case 0:
            document["duration"] = document["samples"][-1]["time"] = later
        case 1:
            law["tick"] = exact_str(Fraction(law["tick"]) * draw.choice(_LESS))
        case 2:
            law["window"] += draw.choice([1, 2])
        case 3:
            if stops and draw.random() < 0.5:
                stops.pop(draw.randrange(len(stops)))
            else:
                stops.append(exact_str(motion.starts[-2] + (motion.starts[-1] - motion.starts[-2]) / 2))
            return "other stops", "/motion/stops"
        case 4 if len(law["shares"]) > 1:
            shares = [Fraction(x) for x in law["shares"]]
            off = min(shares) / 100
            law["shares"] = [exact_str(x) for x in (shares[0] + off, shares[1] - off, *shares[2:])]
            return "shares of arcs that do not fit", "/certificate/motion"
        case 5 if len(laws) > 1:
            laws.remove(law)
            return "a law less", "/certificate/motion"
        case _:
            return None
    return "another duration", "/duration"


def sampling_changed(draw: random.Random, document: Document) -> Forged:
    """Another step, or one where there is none; a chord that is not kept."""
    if not is_found(document) or "deviation" not in document:
        return None
    times = [Fraction(row["time"]) for row in document["samples"]]
    most = max(map(Fraction, document["deviation"].values()))
    if draw.random() < 0.5:
        step = (times[1] - times[0]) * draw.choice([*_LESS, Fraction(11, 10)])
        if step >= times[-1] and len(times) == 2:
            return None
        document["sampling"] = {"step": exact_str(step)}
    elif most:
        document["sampling"] = {"chord": exact_str(most * draw.choice(_LESS))}
    else:
        return None
    return "another step or chord", "/sampling"


def deviation_changed(draw: random.Random, document: Document) -> Forged:
    """A smaller deviation than there is between two rows; or a row less, so that it is greater."""
    if not is_found(document) or "deviation" not in document:
        return None
    motion, replay, rows = _driven(document), replay_of(document), document["samples"]
    n = draw.randrange(len(rows) - 1)
    what = "a smaller deviation"
    if len(rows) > 2 and draw.random() < 0.3:
        rows.pop(n := max(1, n))
        n, what = n - 1, "a row less"
    name = "time" if motion else "place"
    low, high = (Fraction(row[name]) for row in rows[n : n + 2])
    shares = [Fraction(k, _BETWEEN) for k in range(1, _BETWEEN)]
    chord = [[Fraction(row[leg]) for leg in LEGS] for row in rows[n : n + 2]]
    points = [[x + share * (y - x) for x, y in zip(*chord, strict=True)] for share in shares]
    own = {leg: Fraction(document["deviation"][leg]) for leg in LEGS}
    # what follows from the digits of rows alone, as of a leg that moves evenly, is left as it is
    own = {leg: x if x > _CLOSE * max(own.values()) else Fraction(0) for leg, x in own.items()}
    if motion:
        pairs = zip(points, shares, strict=True)
        least = max(_ratio(point, motion.legs(low + share * (high - low)), own) for point, share in pairs)
    else:  # from any point of the path between both rows
        least = max(_least_ratio(replay, point, (low, high), own) for point in points[::4])
    if what == "a smaller deviation" and least > 0:
        factor = least * draw.choice(_LESS)
        document["deviation"] |= {
            leg: exact_str(Fraction(round_fraction(x * factor, 6))) for leg, x in own.items() if x
        }
        document.pop("sampling", None) if "chord" in document.get("sampling", {}) else None
        return what, "/deviation"
    return (what, "/deviation") if least > 1 else None


def _least_ratio(
    replay: Replay, point: Sequence[Fraction], ends: tuple[Fraction, Fraction], most: dict[str, Fraction]
) -> Fraction:
    """The least of the shares at places between two, somewhat less."""

    def share(place: Fraction) -> Fraction:
        return _ratio(point, replay.legs(replay.at(place)), most)

    low, step = ends[0], (ends[1] - ends[0]) / _PLACES
    for _ in range(_FINER):
        near = min((low + step * k for k in range(_PLACES + 1)), key=share)
        low, step = max(near - step, ends[0]), 2 * step / _PLACES
    return share(near) * Fraction(49, 50)


def _ratio(point: Sequence[Fraction], legs: Sequence[mpf], most: dict[str, Fraction]) -> Fraction:
    """The greatest share of a deviation by which lengths differ, but for those that are 0."""
    return max(
        (
            abs(x - fraction_of(y)) / limit
            for x, y, limit in zip(point, legs, most.values(), strict=True)
            if limit
        ),
        default=Fraction(0),
    )


def _fold_near(draw: random.Random, document: Document) -> tuple[Fraction, Fraction] | None:
    """How far a pose with the other sign of J is from one of the path, in degrees, and by which change of the
    free legs it is reached at most on the straight way."""
    replay, count = replay_of(document), len(document["certificate"]["arcs"])
    free = [k for k in range(3) if k + 1 != document["fixed_leg"]]
    best: tuple[Fraction, Fraction] | None = None
    for n in range(_POINTS + 1):
        at = replay.at(Fraction(count * n, _POINTS))
        turn, own = draw.random(), replay.determinant(at)
        for k in range(_RAYS):
            reach = Fraction(document["clearance"]["proved"]) * Fraction(4, 5)
            most = best[0] if best else Fraction(60)
            while (reach := reach * _GROWTH) < most:
                if replay.determinant(_beside(at, (k + turn) / _RAYS, reach)) * own < 0:
                    way = [replay.legs(_beside(at, (k + turn) / _RAYS, reach * m / 20)) for m in range(21)]
                    far = max(sum((x[m] - way[0][m]) ** 2 for m in free) for x in way)
                    best = reach, fraction_of(mp.sqrt(far))
                    break
    return best


def _beside(at: Place, turn: float, reach: Fraction) -> Place:
    step = mp.expj(2 * mp.pi * turn) * number(reach)
    return at[0] + step.real, at[1] + step.imag, at[2]


def clearance_of_path_changed(draw: random.Random, document: Document) -> Forged:
    """A greater clearance, radius or change of legs than there is; an upper bound that a path exceeds."""
    clearance = document.get("clearance")
    if clearance is None:
        return None
    proved = Fraction(clearance["proved"])
    how = draw.randrange(6) if is_found(document) else draw.choice([0, 5])
    less = Fraction(round_fraction(proved * draw.choice(_LESS), 6))
    if how == 0:
        clearance["bound"] = exact_str(less)
        return "a bound that a path exceeds", "/clearance/bound"
    if how == 1:
        clearance["asked"] = exact_str(proved / draw.choice(_LESS))
        return "more clearance asked for", "/clearance/asked"
    if how == 2 and (radius := _least_radius(document)) is not None:
        clearance["radius"] = exact_str(Fraction(round_fraction(radius * Fraction(1001, 1000), 6)))
        return "a path less bent", "/clearance/radius"
    if how in (3, 4) and (fold := _fold_near(draw, document)) is not None:
        name, x = ("proved", fold[0]) if how == 3 else ("legs", fold[1])
        clearance[name] = exact_str(Fraction(round_fraction(x * Fraction(1001, 1000), 6)))
        if how == 3:
            clearance["bound"] = None
        return f"a greater clearance, {name}", f"/clearance/{name}"
    if how == 5:
        kept = (
            "geometry",
            "geometry_hash",
            "fixed_leg",
            "digits",
            "solver_version",
            "between",
            "limits",
            *LEGS,
            *ENDS,
        )
        common = {name: document[name] for name in kept if name in document}
        clearance.update(asked=exact_str(less), bound=exact_str(less * Fraction(99, 100)))
        document.clear()
        document.update(common, connected=False, obstacle="too-narrow", clearance=clearance)
        document.update(connecting_range=None, resolution=None, samples=[])
        return "too narrow, though there is room", "/clearance/bound"
    return None


def _least_radius(document: Document) -> Fraction | None:
    """The least radius of curvature at points of the arcs, in degrees; None if they are straight."""
    replay, step, best = replay_of(document), Fraction(1, 10**8), None
    for arc in range(len(document["certificate"]["arcs"])):
        for k in range(1, _POINTS):
            place = arc + Fraction(k, _POINTS)
            x, y, z = (replay.at(place + n * step) for n in (-1, 0, 1))
            with mp.workdps(60):
                h = number(step)
                v = [(c - a) / (2 * h) for a, c in zip(x[:2], z[:2], strict=True)]
                w = [(a - 2 * b + c) / h**2 for a, b, c in zip(x[:2], y[:2], z[:2], strict=True)]
                cross = abs(v[0] * w[1] - v[1] * w[0])
                speed = mp.hypot(*v)
                if speed and cross > mpf(10) ** -9 * speed**2:
                    own = fraction_of(speed**3 / cross)
                    best = own if best is None else min(best, own)
    return best


def limits_loosened(_draw: random.Random, document: Document) -> Forged:
    """An end is said to be outside limits that it keeps."""
    limits = document.get("limits")
    if document.get("obstacle") != "outside-limits" or not limits:  # another forgery may have said so
        return None
    for name, limit in limits.items():
        lengths = [Fraction(lengths_of(document, end)[name]) for end in ENDS]
        if limit["min"] is not None:
            limit["min"] = exact_str(min(lengths) * Fraction(99, 100))
        if limit["max"] is not None:
            limit["max"] = exact_str(max(lengths) * Fraction(101, 100))
    return "limits that are kept", "/obstacle"


FORGES: Sequence[Forge] = (
    limit_of_motion_changed,
    motion_faster,
    law_changed,
    times_changed,
    sampling_changed,
    deviation_changed,
    deviation_changed,
    clearance_of_path_changed,
    clearance_of_path_changed,
    clearance_of_path_changed,
    limits_loosened,
)
