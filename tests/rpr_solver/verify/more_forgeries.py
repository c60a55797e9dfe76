"""Forged reports with joint limits, and of degenerate families, for the list of forgeries.py."""

from __future__ import annotations

from copy import deepcopy
from fractions import Fraction

from rpr_solver import Manipulator, Requirement, census, check, cusp_curves
from tests.rpr_solver.verify.forgeries import _BASES, FULL, SMALL, ZEIN, Document, forgery, put
from tests.support.families import family

REPORTS = {
    "a crossing": lambda: check(
        ZEIN, Requirement(1, Fraction("34.5"), Fraction(35), max_cusps=5, limits={3: (30, 60)}), digits=15
    ).to_json(),
    "a narrow window": lambda: check(
        ZEIN,
        Requirement(
            1,
            Fraction("35.375"),
            Fraction(36),
            max_cusps=3,
            limits={3: (Fraction("10.34533654"), Fraction("60.65372258"))},
        ),
        digits=15,
    ).to_json(),
    "an event beyond a limit": lambda: check(
        ZEIN, Requirement(1, Fraction(37), Fraction(38), max_cusps=4, limits={2: (40, None)}), digits=15
    ).to_json(),
    "an event at an end": lambda: check(
        family("right angles"), Requirement(1, Fraction("15.95"), 16, max_cusps=24), digits=15
    ).to_json(),
    "no crossing": lambda: check(
        SMALL, Requirement(3, Fraction(10), Fraction(11), max_cusps=24, limits={1: (None, 1000)}), digits=15
    ).to_json(),
}
DEGENERATE = {
    "always singular": lambda: census(family("flat base"), digits=15, start=10, stop="10.5").to_json(),
    "a length of 0": lambda: census(family("flat base"), digits=15, fixed_leg=2, start=6, stop=7).to_json(),
}
DEGENERATE["a kind that is not found"] = lambda: census(
    family("folded flat platform"), digits=15, fixed_leg=3, start="3.32", stop="4.1"
).to_json()
"""Two transitions, a beak-to-beak and a node."""
DEGENERATE["shared angles"] = lambda: census(
    family("right angles"), digits=15, fixed_leg=1, stop=10
).to_json()
ENDS = {
    "a quadruple pose": lambda: (
        cusp_curves(Manipulator(-2, -1, -1, 2, 3, 1), digits=15, fixed_leg=3)
        .part("1.7", "2.4", lengths=[Fraction("1.8"), Fraction("2.32")])
        .to_json(certificate="full")
    ),
}
"""C1 ends at √5, at a quadruple pose, where C11 begins; five other curves pass."""
ENDS["the last event"] = lambda: (
    cusp_curves(Manipulator(-3, 4, 3, 8, 5, 5), digits=15, fixed_leg=2)
    .part("10", None, lengths=[Fraction(10), Fraction(12)])
    .to_json(certificate="full")
)
"""C6 ends at 11, at a quadruple pose, where C14 begins; three other curves lead on to ∞."""
_BASES.update(ENDS)
_BASES.update(REPORTS)
_BASES.update(DEGENERATE)


def renamed(document: Document, old: str, new: str) -> None:
    """The same report with another length in place of a cut."""
    for row in document["intervals"]:
        for end in ("from", "to"):
            row[end] = new if row[end] == old else row[end]


def one_interval(document: Document, count: int) -> None:
    """The same report with one interval in place of all."""
    first, *_, last = document["intervals"]
    row = {"from": first["from"], "to": last["to"], "count": count}
    document.update(intervals=[row], violations=[], passed=True, max_cusps_found=count, min_cusps_found=count)


@forgery("a crossing hidden", "a crossing", "/intervals/0/count")
def _(document: Document) -> None:
    one_interval(document, 5)


@forgery("a crossing hidden, with the number beyond it", "a crossing", "/intervals/0/count")
def _(document: Document) -> None:
    one_interval(document, 4)


@forgery("an event that is just within the range", "an event at an end", "/intervals/0/count")
def _(document: Document) -> None:
    """The range ends 10^-40 beyond it."""
    document["requirement"]["range"]["to"] = document["intervals"][0]["to"] = f"16.{'0' * 39}1"


@forgery("a crossing moved", "a crossing", "/intervals/1/from")
def _(document: Document) -> None:
    renamed(document, document["intervals"][1]["from"], "34.8459032876259")


@forgery("a narrow window hidden", "a narrow window", "/intervals/0/count")
def _(document: Document) -> None:
    """The window is a millionth wide; outside it no slice has more cusps than three."""
    one_interval(document, 3)


@forgery("the end of a narrow window moved", "a narrow window", "/intervals/2/from")
def _(document: Document) -> None:
    [_, row, _], [violation] = document["intervals"], document["violations"]
    renamed(document, row["to"], "35.4999999951594")
    violation["to"] = "35.4999999951594"
    violation["example"]["l1"] = "35.49999999515935"


@forgery("an event beyond a limit as a cut", "an event beyond a limit", "/intervals/")
def _(document: Document) -> None:
    """The cut is an event of two cusps that are both beyond the limit."""
    [row] = document["intervals"]
    cut = "37.3170902975635"
    before, after = {**row, "to": cut, "count": row["count"] + 2}, {**row, "from": cut}
    assert before["count"] <= 6
    document.update(intervals=[before, after], max_cusps_found=before["count"])
    document["requirement"]["max_cusps"] = before["count"]


@forgery("a cut where no cusp is at a limit", "no crossing", "/intervals/1/from")
def _(document: Document) -> None:
    [row] = document["intervals"]
    cut = "10.5000000000000"
    after = {**row, "from": cut, "count": row["count"] + 1}
    document.update(intervals=[{**row, "to": cut}, after], max_cusps_found=after["count"])


@forgery("all cusps, whatever the limits", "a crossing", "/intervals/0/count")
def _(document: Document) -> None:
    one_interval(document, 8)
    document["requirement"]["max_cusps"] = 8


@forgery("a limit that is left out", "a crossing", "/intervals/")
def _(document: Document) -> None:
    document["requirement"]["limits"]["l3"]["max"] = None


@forgery("a limit of the other leg", "a crossing", "/intervals/")
def _(document: Document) -> None:
    limits = document["requirement"]["limits"]
    limits["l2"] = limits.pop("l3")


@forgery("a limit that moves the crossing by its last digit", "a crossing", "/intervals/1/from")
def _(document: Document) -> None:
    document["requirement"]["limits"]["l3"]["max"] = "60.00000000000003"


put(
    "a least length as the greatest",
    "no crossing",
    "/requirement/limits/l1",
    {"min": "1000", "max": None},
    "/intervals/0/count",
)


def one_census_interval(document: Document) -> None:
    """The same census without its transitions."""
    first, *_, last = document["intervals"]
    document.update(transitions=[], intervals=[{**first, "to": last["to"]}])


@forgery("an event twice where a kind is not found", "a kind that is not found", "/transitions/0/events/1")
def _(document: Document) -> None:
    events = document["transitions"][0]["events"]
    events.append(deepcopy(events[0]))


@forgery("a pose that is always singular hidden", "always singular", "/transitions")
def _(document: Document) -> None:
    one_census_interval(document)


@forgery("a transition hidden beside a length of 0", "a length of 0", "/transitions")
def _(document: Document) -> None:
    """The number of cusps is the same beyond both."""
    one_census_interval(document)


@forgery("two transitions hidden beside a length of 0", "a length of 0", "/intervals/0/count")
def _(document: Document) -> None:
    one_census_interval(document)
    document["intervals"][0]["count"] = 8


@forgery("a quadruple pose as the end of cusps", "always singular", "/intervals/1/count")
def _(document: Document) -> None:
    document["transitions"][0]["count_after"] = document["intervals"][1]["count"] = 4


@forgery("a curve that passes a quadruple pose as two", "a quadruple pose", "/curves/0/to")
def _(document: Document) -> None:
    first, second = document["curves"][:2]
    after = {**second, "name": "C99", "points": second["points"][1:], "from": {**first["to"], "joins": None}}
    second.update(points=second["points"][:1], to={**first["to"], "joins": None})
    document["curves"].append(after)
    chains = document["certificate"]["full"]["chains"]
    chains[:] = [chain for chain in chains if chain["from"]["curve"] != second["name"]]


@forgery("ends exchanged at a quadruple pose", "a quadruple pose", f"{FULL}/chains/0")
def _(document: Document) -> None:
    """C1 goes on as C2 did, which ends."""
    first, second = document["curves"][:2]
    first["points"] += second["points"][1:]
    first["to"], second["to"], second["points"] = second["to"], first["to"], second["points"][:1]
    for chain in document["certificate"]["full"]["chains"]:
        for side in ("from", "to"):
            if chain[side]["curve"] == second["name"]:
                chain[side]["curve"] = first["name"]


@forgery("a curve that passes the last quadruple pose", "the last event", "/curves/0/to")
def _(document: Document) -> None:
    """All lead on, and nothing is shown beyond the pose."""
    document["curves"] = [curve for curve in document["curves"] if curve["from"]["kind"] != "quadruple"]
    for curve in document["curves"]:
        curve["points"] = curve["points"][:1]
        curve["to"] = {"l2": None, "kind": "open", "joins": None, "events": []}
    document["certificate"]["full"]["chains"] = []


@forgery("another kind at a pose that is always singular", "always singular", "/transitions/0/")
def _(document: Document) -> None:
    [transition] = document["transitions"]
    transition["kind"] = transition["events"][0]["kind"] = "node"


@forgery("all transitions hidden where angles are shared", "shared angles", "/intervals/0/count")
def _(document: Document) -> None:
    one_census_interval(document)


put(
    "another eliminant beside shared angles",
    "shared angles",
    f"{FULL}/systems/2/polynomial/coefficients/0",
    "1",
    f"{FULL}/systems/2/polynomial",
)
