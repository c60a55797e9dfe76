"""Paths: right documents are established, each false claim is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from random import Random
from typing import Any

import pytest

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    NoPath,
    Path,
    cusp_loop,
    exact_str,
    joint_path,
    pose_path,
    poses,
    verify_document,
)
from rpr_solver.contract import silent
from rpr_solver.verify import bottlenecks, clearance
from rpr_solver.verify.claims import ClaimStatus, Outcome
from rpr_solver.verify.core.reader import bounded
from rpr_solver.verify.core.schema import read_document
from rpr_solver.verify.paths import path_claims
from tests.rpr_solver.verify import motion_forger, path_forger
from tests.rpr_solver.verify.forging import Forge
from tests.support.families import family
from tests.support.sampling import long, sample
from tests.support.verified import is_refused, refusal

Document = Any
INNOCENTI = EXAMPLES["innocenti"]
HOME = Manipulator("16.1", "6.8", "12.5", "19.5", "15.1", "18.4", "cw")
GIVEN = {"alpha_deg": -40, "theta1_deg": 140, "l1": 28}
ROOMY: Document = {"speed": 10, "acceleration": {"l1": 5, "l2": 20, "l3": 30}}


def _given(**options: Any) -> Path | NoPath:
    return pose_path(INNOCENTI, {"l1": 27, "l2": 20, "l3": 20, "pose": 1}, GIVEN, **options)


def _held_at(length: int) -> dict[str, int]:
    return {"alpha_deg": -45, "theta1_deg": 44, "l1": length}


PATHS: dict[str, Callable[[], Path | NoPath]] = {
    "loop": lambda: cusp_loop(INNOCENTI, 27, "B", samples=5),
    "loop within limits": lambda: cusp_loop(
        INNOCENTI, 27, "B", limits={"l2": (8, 20), "l3": (None, 18)}, samples=5
    ),
    "loop of leg 3": lambda: cusp_loop(Manipulator(9, 4, 11, 14, 15, 13), 12, "A", fixed_leg=3, samples=5),
    "loop round twins": lambda: cusp_loop(family("congruent, mirrored"), 20, 1, samples=2),
    "many digits": lambda: cusp_loop(INNOCENTI, 27, "A", digits=60, samples=3),
    "two arcs in a range": lambda: joint_path(
        INNOCENTI, 27, "25.7", "9.2", 2, 4, between=(27, 30), samples=5
    ),
    "given pose": lambda: _given(samples=5),
    "motion": lambda: _given(motion=ROOMY, sampling={"number": 3}),
    "smooth motion": lambda: _given(motion={**ROOMY, "jerk": 50}, sampling={"step": "0.5"}),
    "motion with the leg held": lambda: joint_path(
        INNOCENTI, 27, 20, 20, 1, 2, motion=ROOMY, sampling={"chord": 4}
    ),
    "chord": lambda: _given(sampling={"chord": "0.1"}),
    "ends on a limit": lambda: joint_path(
        HOME, "22.2", "30.2", "24.88", 3, 2, fixed_leg=3, limits={"l2": ("30.2", "43.9")}, samples=5
    ),
    "a leg that shortens": lambda: pose_path(INNOCENTI, _held_at(40), _held_at(10), samples=2),
    "opposite signs": lambda: joint_path(INNOCENTI, 27, 20, 20, 1, 3),
    "two poses of one alpha": lambda: joint_path(family("congruent, mirrored"), "21.1", "29.2", "28.3", 2, 1),
    "bounded by a line of singular poses": lambda: pose_path(
        family("congruent"),
        {"l1": "19.1", "l2": "23.7", "l3": "29.5", "pose": 3},
        {"alpha_deg": "11.826", "theta1_deg": "-177.15", "l1": "19.1"},
        clearance="best",
        samples=2,
    ),
    "other aspect": lambda: joint_path(INNOCENTI, 27, "25.7", "9.2", 2, 4),
    "other aspect in a range": lambda: joint_path(INNOCENTI, 27, "25.7", "9.2", 2, 4, between=(27, "27.5")),
    "outside limits": lambda: joint_path(INNOCENTI, 27, 20, 20, 1, 2, limits={"l2": (25, 30)}),
    "a given pose outside limits": lambda: pose_path(
        INNOCENTI,
        {"l1": 27, "l2": 20, "l3": 20, "pose": 1},
        {"alpha_deg": -140, "theta1_deg": 140, "l1": 28},
        limits={"l2": (None, 21)},
    ),
    "too narrow at an end": lambda: joint_path(INNOCENTI, 27, 20, 20, 1, 2, clearance=25),
    "too narrow": lambda: joint_path(INNOCENTI, 27, "25.7", "9.2", 1, 3, clearance=9),
}
OPEN: dict[str, Callable[[], Path | NoPath]] = {
    "separated": lambda: joint_path(INNOCENTI, 27, 20, 20, 1, 2, limits={"l2": (5, 21)}),
}


WIDE = {
    "widest path": lambda: joint_path(INNOCENTI, 27, 20, 20, 1, 2, clearance="best", samples=2),
    "wide loop": lambda: cusp_loop(INNOCENTI, 27, "H", clearance="best", samples=2),
}


@pytest.mark.quick
def test_an_answer_that_is_undecided_claims_nothing_of_a_path() -> None:
    document = json.loads(_text("outside limits"))
    document.update(obstacle="undecided", connected=None)
    verification = verify_document(document)
    assert verification.established
    assert "it says neither that there is a path nor that there is none" in {
        claim.claim for claim in verification.claims
    }


@cache
def _text(name: str) -> str:
    return json.dumps((PATHS | WIDE)[name]().to_json())


OF_THE_SAME_KIND = {"many digits", "loop within limits", "motion with the leg held", "too narrow at an end"}


@pytest.mark.parametrize("name", [long(name) if name in OF_THE_SAME_KIND else name for name in PATHS])
def test_a_right_document_is_established(name: str) -> None:
    verification = verify_document(_text(name))
    assert verification.outcome is Outcome.ESTABLISHED, verification.summary


@pytest.mark.parametrize("name", OPEN)
def test_what_is_not_found_anew_is_named_as_open(name: str) -> None:
    verification = verify_document(OPEN[name]().to_json())
    assert verification.outcome is Outcome.NOT_ESTABLISHED
    assert "path" in verification.summary


@pytest.mark.parametrize("name", sample(WIDE, 0))  # the other one with a false claim, below
def test_a_clearance_is_proved_anew(name: str) -> None:
    verification = verify_document(_text(name))
    assert verification.outcome is Outcome.ESTABLISHED, verification.summary
    claims = [claim.at for claim in verification.claims if claim.at.startswith("/clearance")]
    of_all = ["bound"] if name == "widest path" else []
    assert claims == [f"/clearance/{x}" for x in ("proved", *of_all, "radius", "legs")]


def test_a_path_from_a_pose_that_is_none_is_refused() -> None:
    document = json.loads(_text("loop"))
    document["l2"] = "99"
    verification = verify_document(document)
    assert {"/from", "/to"} <= {claim.at for claim in verification.refused}
    assert "all that is left" in {claim.claim for claim in verification.open}


def test_a_given_pose_with_more_digits_than_printed_is_not_refused() -> None:
    start = {"l1": 27, "l2": 20, "l3": 20, "pose": 1}
    stop = {"alpha_deg": "-121/3", "theta1_deg": "982/7", "l1": 28}
    path = pose_path(INNOCENTI, start, stop, samples=21)
    assert verify_document(path.to_json()).accepted


def _last_digit(record: Document, name: str) -> None:
    text = record[name]
    record[name] = text[:-1] + ("1" if text[-1] != "1" else "2")


def _sample(n: int, **changes: str) -> Callable[[Document], object]:
    return lambda d: d["samples"][n].update(changes)


def _through(document: Document) -> None:
    document["certificate"]["arcs"] = [["from", "to"]]


def _exchange(document: Document) -> None:
    samples = document["samples"]
    for name in set(samples[1]) - {"time"}:
        samples[1][name], samples[2][name] = samples[2][name], samples[1][name]


def _turned(document: Document) -> None:
    sample = document["samples"][2]
    sample["alpha_deg"] = f"{float(sample['alpha_deg']) + 360:.12f}"


def _opened(document: Document) -> None:
    lengths = {name: document.pop(name) for name in ("l1", "l2", "l3")}
    document.update(closed=False, cusp=None, winding=None)
    for end in ("from", "to"):
        document[end].update(lengths)


def _faster(document: Document, factor: Fraction, duration: str | None = None) -> None:
    """All times shorter, as of a motion with shorter ticks; or another duration alone."""
    law = document["certificate"]["motion"][0]
    law["tick"] = exact_str(Fraction(law["tick"]) * factor)
    for record, name in [(document, "duration"), *((x, "time") for x in document["samples"])]:
        record[name] = exact_str(Fraction(record[name]) * factor)
    if duration is not None:
        document["duration"] = document["samples"][-1]["time"] = duration


def _with_a_corner(document: Document) -> None:
    """The last arc but one ends in the same place, from another direction."""
    document["certificate"]["arcs"][-2][-2]["alpha_deg"] += "1"


def _elsewhere(document: Document) -> None:
    speeds = document["certificate"]["motion"][0]["speeds"]
    speeds[10], speeds[60] = speeds[10] // 2, speeds[60] // 2


def _resting(document: Document, *, arcs: bool) -> None:
    """A motion that is much slower, with all rows made anew, and rests on the way: its law, or an arc."""
    certificate, ends = document["certificate"], (document["from"], document["to"])
    law = certificate["motion"][0]
    if arcs:
        names = "alpha_deg", "theta1_deg", "l1"
        middle = {name: exact_str(sum(Fraction(end[name]) for end in ends) / 2) for name in names}
        certificate.update(arcs=[["from", middle, middle], [middle, middle, "to"]])
        certificate["least_determinant"] = "0.00000100000"
        law["shares"] = ["0.5", "0.5"]
    else:
        law["speeds"][48] = law["speeds"][49] = 0
    motion_forger.times(document, Fraction(20))
    motion_forger.rows_anew(document)
    document["deviation"] = dict.fromkeys(document["deviation"], "100")


def _wide_at_first(document: Document) -> None:
    """Two arcs at the same angles, where J = 0 is 12 degrees away along the first, and 0.5 at the end."""
    middle = {"alpha_deg": "-45", "theta1_deg": "44", "l1": "30"}
    document["certificate"]["arcs"] = [["from", middle], [middle, "to"]]
    document["samples"][1]["place"] = "2"
    document["clearance"] = {"asked": "12", "proved": "12", "bound": None, "legs": "0", "radius": None}


def _renumbered(document: Document) -> None:
    document["from"]["pose"], document["to"]["pose"] = document["to"]["pose"], document["from"]["pose"]


def _just_beyond(document: Document) -> None:
    """A limit that a given pose keeps, and a length beyond it, as angles that round to the same have."""
    unit = Fraction(1, 10**13)
    length = Fraction(document["to"]["l2"])
    document["limits"]["l2"]["max"] = exact_str(length + unit * 2 / 5)
    document["to"]["l2"] = f"{float(length + unit):.13f}"


def _at_the_edge_of_a_chart(document: Document) -> None:
    """J is 3e-41 at a pose whose half tangent in the verifier's chart is 1e14, where it is less precise; a
    straight line leads away from J = 0, to another pose."""
    for name in ("l1", "l2", "l3"):
        del document[name]
    length = {"pose": None, "l1": "78.081237727767678656279850649527942526201675"}
    start = {"l2": "52.9898342187025", "l3": "87.9767777973630", "alpha_deg": "-143.130102354156"}
    stop = {"l2": "49.9674470813564", "l3": "83.8741169029418", "alpha_deg": "-148.130102354156"}
    document.update({"from": {**length, **start, "theta1_deg": "-10.0000000000000"}})
    document.update({"to": {**length, **stop, "theta1_deg": "-5.00000000000000"}})
    document["obstacle"] = "other-aspect"


FORGERIES: dict[str, tuple[str, Callable[[Document], object]]] = {
    "another digit of an end": ("loop", lambda d: _last_digit(d["from"], "alpha_deg")),
    "another number of a pose": ("loop", lambda d: d["to"].update(pose=4)),
    "another number of two with one alpha": ("two poses of one alpha", _renumbered),
    "another length": ("loop", lambda d: d.update(l2="15.6")),
    "another length of a given pose": ("given pose", lambda d: d["to"].update(l2="25.3062354887644")),
    "a gap between arcs": (
        "two arcs in a range",
        lambda d: d["certificate"]["arcs"][1][0].update(alpha_deg="-171"),
    ),
    "an arc through a singularity": ("loop", _through),
    "another sign": ("loop", lambda d: d.update(sign=-1)),
    "no sign": ("loop", lambda d: d.update(sign=0)),
    "another turn of an end": ("loop", lambda d: d["certificate"]["turns"]["to"].update(alpha=1)),
    "a start in another turn": ("loop", lambda d: d["certificate"]["turns"]["from"].update(alpha=1)),
    "a greater least determinant": (
        "loop",
        lambda d: d["certificate"].update(least_determinant="3.80000"),
    ),
    "a narrower range of the fixed leg": ("two arcs in a range", lambda d: d["between"].update(to="28.5")),
    "no range of the fixed leg": ("two arcs in a range", lambda d: d.update(between=None)),
    "a limit that is exceeded": ("loop within limits", lambda d: d["limits"]["l2"].update(min="9")),
    "a limit that an end exceeds": ("ends on a limit", lambda d: d["limits"]["l2"].update(min="30.2001")),
    "a limit of the fixed leg": (
        "loop within limits",
        lambda d: d["limits"].update(l1={"min": "27.1", "max": None}),
    ),
    "another winding": ("loop", lambda d: d.update(winding=-1)),
    "another cusp": ("loop", lambda d: d.update(cusp=3)),
    "a cusp that is none": ("loop", lambda d: d.update(cusp=20)),
    "a twin that is none": ("loop", lambda d: d.update(twins=[1])),
    "a twin that is left out": ("loop round twins", lambda d: d.pop("twins")),
    "a winding without a cusp": ("loop", lambda d: d.update(cusp=None)),
    "an open loop": ("loop", lambda d: d.update(closed=False)),
    "an open loop, by lengths given twice": ("loop", _opened),
    "a closed path of two joint vectors": ("given pose", lambda d: d.update(closed=True)),
    "another time": ("loop", _sample(1, time="0.26")),
    "samples that go back": ("loop", _exchange),
    "another place": ("loop", _sample(1, place="0.17")),
    "a place beyond the end": ("loop", _sample(4, place="1.5")),
    "another digit of a sample": ("loop", lambda d: _last_digit(d["samples"][1], "l3")),
    "another angle of a sample": ("loop", lambda d: _last_digit(d["samples"][2], "theta1_deg")),
    "another determinant": ("loop", lambda d: _last_digit(d["samples"][1], "determinant")),
    "an angle in another turn": ("loop", _turned),
    "a greater clearance": ("loop", _sample(1, clearance_deg="57.5704")),
    "a greater clearance of the path": ("widest path", lambda d: d["clearance"].update(proved="21")),
    "a much greater clearance of the path": (
        "wide loop",
        lambda d: d["clearance"].update(proved="90", legs="0"),
    ),
    "a clearance beyond all poses": (
        "wide loop",
        lambda d: d["clearance"].update(proved="1" + "0" * 400, legs="0"),
    ),
    "a clearance that the path has at first": ("a leg that shortens", _wide_at_first),
    "a clearance beyond its bound": ("widest path", lambda d: d["clearance"].update(bound="19")),
    "a clearance that is not too narrow": ("too narrow", lambda d: d["clearance"].update(asked="8.5")),
    "a path that is too narrow without a bound": (
        "too narrow",
        lambda d: d["clearance"].update(bound=None),
    ),
    "a path less bent than it is": ("widest path", lambda d: d["clearance"].update(radius="8.12")),
    "a path with a corner": ("wide loop", _with_a_corner),
    "a clearance that is less than was asked for": (
        "widest path",
        lambda d: d["clearance"].update(asked="25"),
    ),
    "limits of motion that are exceeded": ("motion", lambda d: d["motion"]["speed"].update(l3="8")),
    "an acceleration that is exceeded": ("motion", lambda d: d["motion"]["acceleration"].update(l2="17")),
    "a limit of a leg alone that is exceeded": (
        "motion",
        lambda d: d["motion"]["acceleration"].update(l1="1"),
    ),
    "a jerk that is exceeded": ("smooth motion", lambda d: d["motion"]["jerk"].update(l3="30")),
    "a motion that is too fast": ("motion", lambda d: _faster(d, Fraction(19, 20))),
    "a jump of the acceleration": ("smooth motion", lambda d: d["certificate"]["motion"][0].update(window=1)),
    "a jump of the speed": ("motion", lambda d: d["certificate"]["motion"][0]["speeds"].pop()),
    "a law that leads elsewhere": ("motion", _elsewhere),
    "shares that do not fit": (
        "motion",
        lambda d: d["certificate"]["motion"][0].update(shares=["0.5", "0.5"]),
    ),
    "a law that rests on the way": ("motion", lambda d: _resting(d, arcs=False)),
    "a stop that is none": ("motion", lambda d: d["motion"].update(stops=["0.5"])),
    "another duration": ("motion", lambda d: _faster(d, Fraction(1), "1.1746753")),
    "a row at another time": ("motion", _sample(1, time="0.5")),
    "a step that is not kept": ("smooth motion", lambda d: d["sampling"].update(step="0.25")),
    "a chord that is not kept": ("chord", lambda d: d["sampling"].update(chord="0.05")),
    "a smaller deviation": ("chord", lambda d: d["deviation"].update(l3="0.01")),
    "a smaller deviation of a motion": ("motion", lambda d: d["deviation"].update(l2="0.5")),
    "a deviation of digits that is left out": ("chord", lambda d: d["deviation"].update(l1="0")),
    "opposite signs that are alike": ("outside limits", lambda d: d.update(obstacle="opposite-signs")),
    "an aspect that is the same": ("outside limits", lambda d: d.update(obstacle="other-aspect")),
    "an aspect of a range that is the same": (
        "other aspect in a range",
        lambda d: d["between"].update(to="30"),
    ),
    "a range without a path": ("other aspect", lambda d: d["connecting_range"].update(to="27.5")),
    "a range without an end": ("other aspect", lambda d: d["connecting_range"].update({"from": "28"})),
    "limits that are kept": ("outside limits", lambda d: d["limits"]["l2"].update(min="19")),
    "a limit that is kept, up to rounding": ("a given pose outside limits", _just_beyond),
    "undecided, but not connected": ("outside limits", lambda d: d.update(obstacle="undecided")),
    "connected all the same": ("opposite signs", lambda d: d.update(connected=True)),
}


def _times(factor: str, name: str) -> Callable[[Document], object]:
    """The clearance's member, multiplied by a number."""
    return lambda d: d["clearance"].update(
        {name: exact_str(Fraction(d["clearance"][name]) * Fraction(factor))}
    )


NAMED: dict[str, tuple[str, str, Callable[[Document], object]]] = {
    "a bound that is too small": ("too narrow", "/clearance/bound", _times("0.95", "bound")),
    "a fold that is said to be farther away": ("wide loop", "/clearance/legs", _times("3", "legs")),
    "an arc that rests on the way": ("motion", "/motion/stops", lambda d: _resting(d, arcs=True)),
    "another aspect, by the edge of a chart": ("opposite signs", "/obstacle", _at_the_edge_of_a_chart),
}
"""False claims that are not refused, but stay open."""


@pytest.mark.parametrize("name", NAMED)
def test_a_false_claim_is_named(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bottlenecks, "_FINEST", 8)
    monkeypatch.setattr(clearance, "_FINEST_RING", 8)
    kind, member, forge = NAMED[name]
    document = json.loads(_text(kind))
    forge(document)
    verification = verify_document(document)
    others = [claim.at for claim in verification.claims if not claim.established]
    rests_on_it = ["/obstacle"] if member.endswith("bound") else []
    assert others == [*rests_on_it, member], "all else is established"
    assert others[-1] in verification.summary


def _work(digits: int) -> int:
    """That on two arcs which share a line and a parameter, by decimals of so many digits."""
    document, share = json.loads(_text("motion")), Fraction(f"0.5{'3' * digits}1")
    names, ends = ("alpha_deg", "theta1_deg", "l1"), (document["from"], document["to"])

    def between(low: Fraction, high: Fraction, part: Fraction) -> Fraction:
        return low + part * (high - low)

    near, far = (
        [Fraction(round(between(*(Fraction(end[name]) for end in ends), part))) for name in names]
        for part in (Fraction(1, 4), Fraction(3, 4))
    )
    joint = [between(*pair, share) for pair in zip(near, far, strict=True)]
    first, middle, last = (
        {name: exact_str(x) for name, x in zip(names, row, strict=True)} for row in (near, joint, far)
    )
    law = {"shares": [exact_str(share), exact_str(1 - share)], "tick": "1", "speeds": [0, *[1] * 300, 0]}
    document["certificate"].update(arcs=[["from", first, middle], [middle, last, "to"]])
    document["certificate"]["motion"] = [{**law, "window": 1}]
    with bounded(10**9) as left:
        statuses = {claim.at: claim.status for claim in path_claims(read_document(document), silent)}
    assert statuses["/certificate/motion"] is statuses["/motion/speed"] is ClaimStatus.PROVED
    return 10**9 - left[0]


def test_work_on_long_exact_numbers_is_counted() -> None:
    assert _work(4000) > 3 * _work(40)


DEAR = {"a clearance beyond its bound", "a smaller deviation", "a much greater clearance of the path"}
"""Forgeries that take a second and more, where another of the same claim does not: with `--long` only."""


@pytest.mark.parametrize(
    "name", sample(FORGERIES, *(k for k, name in enumerate(FORGERIES) if k % 3 == 0 and name not in DEAR))
)
def test_a_false_claim_is_refused(name: str) -> None:
    kind, forge = FORGERIES[name]
    document = json.loads(_text(kind))
    forge(document)
    assert refusal(document) is not None


@pytest.mark.quick
@pytest.mark.parametrize(
    "forge",
    [
        _sample(0, place="1e-3"),
        lambda d: d["from"].update(l1="27", l2="20", l3="20"),
        lambda d: d["certificate"]["arcs"][0].__setitem__(1, "middle"),
        lambda d: d.update(connected=False),
        lambda d: d["samples"].clear(),
        lambda d: d.update(sampling={"step": "1", "chord": "1"}),
        lambda d: d.update(motion={"speed": {}, "acceleration": {}, "stops": []}),
    ],
)
def test_a_document_that_is_none_is_invalid(forge: Callable[[Document], object]) -> None:
    document = json.loads(_text("loop"))
    forge(document)
    with pytest.raises(InputError):
        verify_document(document)


def _random_path(random: Random) -> Document:
    """A path of a random manipulator between poses of one joint vector; None if it has none."""
    d1, d2 = random.uniform(5, 20), random.uniform(5, 20)
    d3 = random.uniform(abs(d1 - d2) + 1, d1 + d2 - 1)
    a2x, a3x, a3y = random.uniform(5, 20), random.uniform(-10, 20), random.uniform(4, 20)
    sides = [f"{x:.1f}" for x in (a2x, a3x, a3y, d1, d2, d3)]
    manipulator = Manipulator(*sides, random.choice(("ccw", "cw")))
    lengths = [f"{random.uniform(5, 25):.1f}" for _ in range(3)]
    table = poses(manipulator, *lengths)
    if table.count < 4:
        return None
    leg = random.randint(1, 3)
    start, stop = random.sample(range(1, table.count + 1), 2)
    held = float(lengths[leg - 1])
    between = random.choice((None, (f"{held - 2:.1f}", f"{held + 3:.1f}")))
    path = joint_path(manipulator, *lengths, start, stop, between=between, fixed_leg=leg, samples=7)
    return path.to_json() if isinstance(path, Path) else None


def _other_number(random: Random, record: Document, names: list[str]) -> None:
    """Changes a digit that is not the first, nor the last."""
    name = random.choice(names)
    digits = [n for n, letter in enumerate(record[name]) if letter.isdigit()][3:-1]
    n = random.choice(digits)
    record[name] = record[name][:n] + str((int(record[name][n]) + 1) % 10) + record[name][n + 1 :]


ALTERATIONS: tuple[Callable[[Random, Document], object], ...] = (
    lambda r, d: _other_number(r, r.choice(d["samples"]), ["l1", "l2", "l3", "alpha_deg", "determinant"]),
    lambda r, d: _other_number(r, d[r.choice(("from", "to"))], ["alpha_deg", f"theta{d['fixed_leg']}_deg"]),
    lambda _, d: d.update(sign=-d["sign"]),
    lambda _, d: d["certificate"]["turns"]["to"].update(alpha=d["certificate"]["turns"]["to"]["alpha"] + 1),
    lambda _, d: d["certificate"].update(least_determinant="98765.4"),
    lambda _, d: d["to"].update(pose=d["from"]["pose"]),
    lambda _, d: d["samples"][3].update(place=d["samples"][2]["place"]),
    lambda r, d: d["samples"][r.randint(1, 5)].update(time="0.01"),
    lambda r, d: d["samples"][r.randint(0, 6)].update(clearance_deg="179.000"),
    lambda _, d: d.update(winding=7, cusp=1),
)


@pytest.mark.parametrize("number", [1, long(100)])
def test_random_paths_are_established_and_their_alterations_refused(number: int) -> None:
    random, found = Random(25), 0
    while found < number:
        document = _random_path(random)
        if document is None:
            continue
        found += 1
        verification = verify_document(document)
        assert verification.established, (verification.summary, document)
        for alter in random.sample(ALTERATIONS, 3):
            altered = json.loads(json.dumps(document))
            alter(random, altered)
            assert refusal(altered) is not None, altered


@pytest.mark.parametrize("forge", dict.fromkeys(path_forger.FORGES), ids=lambda forge: forge.__name__)
def test_what_the_random_forger_changes_is_refused_or_named(forge: Forge) -> None:
    random, document = Random(20), json.loads(_text("two arcs in a range"))
    while (forged := forge(random, altered := json.loads(json.dumps(document)))) is None:
        pass
    assert is_refused(altered), forged


MOVED: dict[str, tuple[str, Forge]] = {
    "a limit of motion": ("motion", motion_forger.limit_of_motion_changed),
    "a faster motion": ("smooth motion", motion_forger.motion_faster),
    "another law": ("motion", motion_forger.law_changed),
    "other times": ("smooth motion", motion_forger.times_changed),
    "another step or chord": ("chord", motion_forger.sampling_changed),
    "less deviation in time": ("motion", motion_forger.deviation_changed),
    "less deviation": ("chord", motion_forger.deviation_changed),
    "an aspect of a range that is the same": (
        "other aspect in a range",
        lambda d: d["between"].update(to="30"),
    ),
    "a range without a path": ("other aspect", lambda d: d["connecting_range"].update(to="27.5")),
    "a range without an end": ("other aspect", lambda d: d["connecting_range"].update({"from": "28"})),
    "limits that are kept": ("outside limits", motion_forger.limits_loosened),
}


@pytest.mark.parametrize("name", sample(MOVED, 1, 6))
def test_what_the_forger_of_motions_changes_is_refused(name: str) -> None:
    kind, forge = MOVED[name]
    random, document = Random(8), json.loads(_text(kind))
    while (forged := forge(random, altered := json.loads(json.dumps(document)))) is None:
        pass
    assert is_refused(altered), forged
