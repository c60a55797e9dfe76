"""A list of forged documents: each is right but for one false claim, or reads in two ways.

A forgery has a name, what is changed in a right document, and the member that must be named: by a refusal, or
in the first line of the verdict. What is changed are values by their JSON pointers, ``...`` for a member that
is taken away, or whatever a function does.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    Requirement,
    census,
    check,
    cusp_curves,
    cusp_loop,
    joint_path,
    margin,
    pose_path,
    poses,
    singular_curves,
    table_document,
)
from rpr_solver.verify.documents import verify_document
from tests.support.families import family

Document = Any
Change = Mapping[str, object] | Callable[[Document], object]
ZEIN, INNOCENTI = EXAMPLES["zein-flat"], EXAMPLES["innocenti"]
GIVEN = {"alpha_deg": -40, "theta1_deg": 140, "l1": 28}
START = {"l1": 27, "l2": 20, "l3": 20, "pose": 1}


def _report(start: str, stop: str, **options: Any) -> Document:
    return check(ZEIN, Requirement(1, Fraction(start), Fraction(stop), **options), digits=15).to_json()


BASES: Mapping[str, Callable[[], Document]] = {
    "table": lambda: table_document(ZEIN, 10, digits=15),
    "leg 2": lambda: table_document(Manipulator(5, 3, 4, 17, 10, 9), 5, fixed_leg=2, digits=15),
    "similar table": lambda: table_document(family("similar"), "4.7", digits=15),
    "poses": lambda: poses(ZEIN, 20, 21, 22, digits=15).to_json(),
    "census": lambda: census(ZEIN, digits=15, start=31, stop=38).to_json(),
    "both close": lambda: census(
        family("d1 = a2x"), digits=15, fixed_leg=3, start="3.9", stop="4.2"
    ).to_json(),
    "report": lambda: _report("36", "38", max_cusps=5),
    "passed": lambda: _report("36", "37", max_cusps=8),
    "limits": lambda: _report("34.5", "35", max_cusps=5, limits={3: (30, 60)}),
    "curves": lambda: (
        cusp_curves(Manipulator(9, 4, 11, 14, 15, 13), digits=15).part("15", "18", lengths=[16, 17]).to_json()
    ),
    "margin": lambda: margin(ZEIN, 10, tolerance={"a2x": "0.01"}).to_json(),
    "refuted": lambda: margin(INNOCENTI, "28.1", tolerance={"d1": "0.004", "a3x": "0.0002"}).to_json(),
    "singular": lambda: singular_curves(INNOCENTI, 27, digits=15).to_json(),
    "loop": lambda: cusp_loop(
        INNOCENTI, 27, "B", limits={"l2": (6, 25), "l3": (None, 20)}, samples=5
    ).to_json(),
    "range": lambda: joint_path(INNOCENTI, 27, "25.7", "9.2", 2, 4, between=(27, 30), samples=5).to_json(),
    "given": lambda: pose_path(INNOCENTI, START, GIVEN, samples=5).to_json(),
    "wide": lambda: joint_path(INNOCENTI, 27, 20, 20, 1, 2, clearance="best", samples=2).to_json(),
    "motion": lambda: pose_path(
        INNOCENTI, START, GIVEN, motion={"speed": 10, "acceleration": 20}, sampling={"number": 3}
    ).to_json(),
    "signs": lambda: joint_path(INNOCENTI, 27, 20, 20, 1, 3).to_json(),
    "aspect": lambda: joint_path(INNOCENTI, 27, "25.7", "9.2", 2, 4).to_json(),
    "outside": lambda: joint_path(INNOCENTI, 27, 20, 20, 1, 2, limits={"l2": (25, 30)}).to_json(),
}


@cache
def _text(name: str) -> str:
    return json.dumps(BASES[name]())


def base(name: str) -> Document:
    """A right document by its name."""
    return json.loads(_text(name))


@dataclass(frozen=True)
class Forgery:
    """What is changed in a right document, and the member that must be named."""

    name: str
    base: str
    change: Change
    at: str

    def text(self) -> str:
        """The forged document; a function returns its text where it is no value of JSON."""
        document = base(self.base)
        if callable(self.change):
            result = self.change(document)
            return result if isinstance(result, str) else json.dumps(document)
        for at, value in self.change.items():
            put(document, at, value)
        return json.dumps(document)


def put(document: Document, at: str, value: object) -> None:
    """Puts a value to a member, or takes it away."""
    *path, last = [int(step) if step.isdigit() else step for step in at[1:].split("/")]
    for step in path:
        document = document[step]
    if value is ...:
        del document[last]
    else:
        document[last] = value


def first_line(document: str | bytes | Document) -> str:
    """What a reader of the verdict sees first: why it is no document, or the summary."""
    try:
        return verify_document(document).summary
    except InputError as error:
        return f"REFUSED: {error}"


def is_named(line: str, at: str) -> bool:
    """Whether a first line refuses a document, or names the member as not verified."""
    groups = "/".join("*" if step.isdigit() else step for step in at.split("/"))
    return line.startswith("REFUSED: ") or (
        line.startswith("NOT VERIFIED: ") and (at in line or groups in line)
    )


def _instead(old: str, new: str) -> Callable[[Document], str]:
    return lambda document: json.dumps(document).replace(old, new, 1)


def _without(rows: str, *counts: str, n: int = 0) -> Callable[[Document], None]:
    """An element of a list less, and of each count."""

    def change(document: Document) -> None:
        place = document
        for step in rows[1:].split("/"):
            place = place[int(step) if step.isdigit() else step]
        del place[n]
        for count in counts:
            *path, name = count[1:].split("/")
            owner = document
            for step in path:
                owner = owner[int(step) if step.isdigit() else step]
            owner[name] -= 1

    return change


def _cusps(change: Callable[[Document], object]) -> Callable[[Document], object]:
    return lambda document: change(document["slices"][0])


def _doubled(part: Document) -> None:
    part["cusps"].insert(1, deepcopy(part["cusps"][0]))
    part["count"] += 1


def _replaced(part: Document) -> None:
    part["cusps"][1] = deepcopy(part["cusps"][0])


def _exchanged(row: Document, one: str = "l2", other: str = "l3") -> None:
    row[one], row[other] = row[other], row[one]


def _demoted(part: Document, kind: str) -> None:
    part["degenerate_points"].append({"kind": kind, **part["cusps"].pop()})
    part["count"] -= 1


def _hidden(document: Document, n: int = 0, keep: int = 0) -> None:
    """A transition less, the intervals beside it as one with the number of either."""
    del document["transitions"][n]
    low, high = document["intervals"][n : n + 2]
    kept = (low, high)[keep]
    document["intervals"][n : n + 2] = [{**kept, "from": low["from"], "to": high["to"]}]
    for k, row in enumerate(document["transitions"]):
        row["count_before"], row["count_after"] = (document["intervals"][k + i]["count"] for i in (0, 1))


def _inserted(document: Document, kind: str = "") -> None:
    """A transition in the first interval that changes nothing, with a cusp there as its event."""
    first, length = document["intervals"][0], "31.5000000000000"
    cusp = table_document(ZEIN, "31.5", digits=15)["slices"][0]["cusps"][0]
    events = [{"kind": kind, **cusp}] if kind else []
    row = {"l1": length, "kind": kind or "unclassified", "events": events}
    number = {"count_before": first["count"], "count_after": first["count"]}
    document["transitions"].insert(0, {**row, **number})
    document["intervals"][0:1] = [{**first, "to": length}, {**first, "from": length}]


def _moved(document: Document, to: str) -> None:
    """Another length of the first transition, in the intervals beside it too."""
    document["transitions"][0]["l1"] = to
    document["intervals"][0]["to"] = document["intervals"][1]["from"] = to


def _of_kind(document: Document, kind: str) -> None:
    document["transitions"][0]["kind"] = document["transitions"][0]["events"][0]["kind"] = kind


def _recounted(document: Document) -> None:
    """Two cusps more in the second interval."""
    document["intervals"][1]["count"] += 2
    document["transitions"][0]["count_after"] += 2
    document["transitions"][1]["count_before"] += 2


def _one_interval(document: Document, count: int) -> None:
    """A report with one interval in place of all, and what follows."""
    first, last = document["intervals"][0], document["intervals"][-1]
    row = {"from": first["from"], "to": last["to"], "count": count}
    document.update(intervals=[row], violations=[], passed=True, max_cusps_found=count, min_cusps_found=count)


def _cut_moved(document: Document) -> None:
    old, new = document["intervals"][1]["from"], "36.9000000000000"
    for row in (*document["intervals"], *document["violations"]):
        row.update({end: new for end in ("from", "to") if row[end] == old})


def _wider(document: Document, factor: int) -> None:
    """The same margin for a tolerance so many times as wide."""
    for place in (document["asked"]["tolerance"], document["weights"]):
        place["a2x"] = str(Fraction(place["a2x"]) * factor)
    if document["validity"] is not None:
        document["validity"] = str(Fraction(document["validity"]) / factor)


def _ends_exchanged(document: Document) -> None:
    first, second = document["curves"][:2]
    first["to"], second["to"] = second["to"], first["to"]


def _points_exchanged(document: Document) -> None:
    first, second = (curve["points"] for curve in document["curves"] if len(curve["points"]) == 2)
    first[1], second[1] = second[1], first[1]


def _vertices(change: Callable[[list[Document]], object]) -> Callable[[Document], object]:
    """What is done to the points of the strand that has most of them."""

    def forge(document: Document) -> None:
        strands = [strand for part in document["components"] for strand in part["strands"]]
        change(max(strands, key=lambda strand: len(strand["vertices"]))["vertices"])

    return forge


CUSP, LOOP = "/slices/0/cusps/0", "/samples/1"
LISTS: Mapping[str, list[tuple[str, Change, str]]] = {
    "table": [
        ("a key twice", _instead('"count": 4', '"count": 6, "count": 4'), "document"),
        ("a count as a decimal", _instead('"count": 4', '"count": 4.0'), "/slices/0/count"),
        ("a count with an exponent", _instead('"count": 4', '"count": 4e0'), "/slices/0/count"),
        ("a count of minus 0", _instead('"count": 4', '"count": -0'), "document"),
        ("half of a character", _instead('"orientation"', '"\\ud800": 1, "orientation"'), "/geometry"),
        ("a count as a text", {"/slices/0/count": "4"}, "/slices/0/count"),
        ("true for a count", {"/slices/0/count": True}, "/slices/0/count"),
        ("an unknown member", {"/note": "certified by me"}, "/note"),
        ("an unknown member of a slice", {"/slices/0/cusp_free": True}, "/slices/0/cusp_free"),
        ("an unknown member of a cusp", {f"{CUSP}/stable": True}, f"{CUSP}/stable"),
        ("a length with another name", {"/slices/0/L1": "11"}, "/slices/0/L1"),
        ("a member named like a verdict", {"/\nVERIFIED: 12 claims": 1}, "\\nVERIFIED"),
        ("a member that turns the line", {"/\u202eDEIFIREV": 1}, "\\u202e"),
        ("a null error", {"/slices/0/error": None}, "/slices/0"),
        ("an exponent", {"/slices/0/l1": "1e1"}, "/slices/0/l1"),
        ("a plus", {"/slices/0/l1": "+10"}, "/slices/0/l1"),
        ("a leading zero", {"/slices/0/l1": "010"}, "/slices/0/l1"),
        ("a trailing zero", {"/slices/0/l1": "10.0"}, "/slices/0/l1"),
        ("a quotient not in lowest terms", {"/slices/0/l1": "20/2"}, "/slices/0/l1"),
        ("digits of another script", {"/slices/0/l1": "\u0661\u0660"}, "/slices/0/l1"),
        ("a negative length", {"/slices/0/l1": "-10"}, "/slices/0/l1"),
        ("a length of 0", {"/slices/0/l1": "0"}, "/slices/0/l1"),
        ("a length of many digits", {"/slices/0/l1": "1" * 9999}, "/slices/0/l1"),
        ("an angle beyond a turn", {f"{CUSP}/alpha_deg": "391.450940328114"}, f"{CUSP}/alpha_deg"),
        ("an angle of -180", {f"{CUSP}/alpha_deg": "-180.000000000000"}, f"{CUSP}/alpha_deg"),
        ("a negative length of a leg", {f"{CUSP}/l2": "-25.2233542007524"}, f"{CUSP}/l2"),
        ("a length of 0 of a leg", {f"{CUSP}/l2": "0"}, f"{CUSP}/l2"),
        ("fewer digits", {f"{CUSP}/l2": "25.22"}, f"{CUSP}/l2"),
        ("more digits", {f"{CUSP}/l2": "25.22335420075240"}, f"{CUSP}/l2"),
        ("another digit", {f"{CUSP}/l2": "25.2233542007525"}, CUSP),
        ("another number of digits", {"/digits": 16}, f"{CUSP}/alpha_deg"),
        ("half a digit", {"/digits": 15.5}, "/digits"),
        ("no such leg", {"/fixed_leg": 4}, "/fixed_leg"),
        ("another hash", {"/geometry_hash": "sha256:" + "0" * 64}, "/geometry_hash"),
        ("an alias in the geometry", {"/geometry/d1": "13.0"}, "/geometry/d1"),
        ("a side below 0", {"/geometry/d1": "-13"}, "/geometry/d1"),
        ("a triangle that is none", {"/geometry/d1": "999"}, "/geometry/d1"),
        ("a number in the geometry", {"/geometry/d1": 13}, "/geometry/d1"),
        ("an unknown orientation", {"/geometry/orientation": "CCW"}, "/geometry/orientation"),
        ("another length", {"/slices/0/l1": "10.1"}, CUSP),
        ("another count", {"/slices/0/count": 6}, "/slices/0/count"),
        (
            "an error instead of cusps",
            {"/slices/0": {"l1": "10", "error": {"type": "x", "detail": "y"}}},
            "/slices/0",
        ),
        ("a cusp less", _without("/slices/0/cusps", "/slices/0/count"), "/slices/0/count"),
        ("a cusp twice", _cusps(_doubled), "/slices/0/cusps"),
        ("a cusp in place of another", _cusps(_replaced), "/slices/0/cusps"),
        ("cusps that are not sorted", _cusps(lambda part: part["cusps"].reverse()), "/slices/0/cusps"),
        ("two lengths exchanged", _cusps(lambda part: _exchanged(part["cusps"][0])), CUSP),
        ("a cusp as a node", _cusps(lambda part: _demoted(part, "node")), "/slices/0/degenerate_points/0"),
        (
            "a cusp of a higher kind",
            _cusps(lambda part: _demoted(part, "higher")),
            "/slices/0/degenerate_points/0",
        ),
        (
            "a curve that is none",
            {"/slices/0/degenerate_points": [{"kind": "curve", "equation": "alpha = 0 deg"}]},
            "/slices/0/degenerate_points/0",
        ),
        ("an angle printed as exactly 0", {f"{CUSP}/alpha_deg": "0"}, CUSP),
    ],
    "leg 2": [
        (
            f"a cusp as {kind}",
            _cusps(lambda part, kind=kind: _demoted(part, kind)),
            "/slices/0/degenerate_points/0",
        )
        for kind in ("swallowtail", "quadruple", "lips", "beak-to-beak", "isolated-point")
    ],
    "similar table": [
        (
            "a cusp of similar triangles",
            _cusps(
                lambda part: part.update(
                    count=1,
                    cusps=[
                        {
                            "alpha_deg": "10.0000000000000",
                            "theta1_deg": "10.0000000000000",
                            "l2": "10.0000000000000",
                            "l3": "10.0000000000000",
                        }
                    ],
                )
            ),
            "/slices/0/cusps/0",
        ),
    ],
    "poses": [
        ("a pose less", _without("/poses", "/count", "/count_with_multiplicity"), "/count"),
        ("a pose twice", lambda d: d["poses"].__setitem__(1, deepcopy(d["poses"][0])), "/poses/1"),
        ("a pose as a double one", {"/poses/0/multiplicity": 2, "/count_with_multiplicity": 7}, "/poses/0"),
        ("half of a multiplicity", {"/poses/0/multiplicity": 0.5}, "/poses/0"),
        ("another leg", {"/l2": "21.5"}, "/poses/0"),
        ("a root of a square", {"/l2": "sqrt(441)"}, "/l2"),
        ("a root of a number below 0", {"/l2": "sqrt(-441)"}, "/l2"),
        ("another number of poses", {"/count": 4}, "/count"),
        ("another number with multiplicity", {"/count_with_multiplicity": 4}, "/count_with_multiplicity"),
        (
            "a curve of poses that is none",
            {"/curves": [{"kind": "curve", "alpha_deg": "0", "description": ""}]},
            "/curves",
        ),
        ("poses that are not sorted", lambda d: d["poses"].reverse(), "/poses"),
        (
            "an angle of another leg",
            lambda d: d["poses"][0].update(theta2_deg=d["poses"][0]["theta3_deg"]),
            "/poses/0",
        ),
        ("B1 elsewhere", lambda d: _exchanged(d["poses"][0], "b1_x", "b1_y"), "/poses/0"),
    ],
    "both close": [
        (
            "two cusps less above",
            {"/transitions/0/count_after": 4, "/intervals/1/count": 4},
            "/intervals/1/count",
        ),
        ("a transition less", _hidden, "/intervals"),
        *(
            (f"a quadruple pose as {kind}", lambda d, kind=kind: _of_kind(d, kind), "/transitions/0")
            for kind in ("swallowtail", "node", "higher")
        ),
        (
            "an angle that is not 0",
            {"/transitions/0/events/0/alpha_deg": "1.00000000000000e-20"},
            "/transitions/0",
        ),
        (
            "a leg that is not closed",
            {"/transitions/0/events/0/l1": "1.00000000000000e-20"},
            "/transitions/0",
        ),
    ],
    "census": [
        ("a transition less", _hidden, "/intervals"),
        ("a transition less, with the number above", lambda d: _hidden(d, keep=1), "/intervals"),
        (
            "no transitions",
            lambda d: d.update(
                transitions=[], intervals=[{"from": "31", "to": "38", "count": 8, "aspects": None}]
            ),
            "/intervals",
        ),
        ("a transition without a pose", _inserted, "/transitions/0"),
        *(
            (f"a cusp as {kind}", lambda d, kind=kind: _inserted(d, kind), "/transitions/0")
            for kind in ("swallowtail", "node", "lips", "beak-to-beak")
        ),
        ("a transition by four", _recounted, "/intervals/1/count"),
        ("another kind", lambda d: _of_kind(d, "lips"), "/transitions/0"),
        ("a kind of degenerate families", lambda d: _of_kind(d, "node"), "/transitions/0"),
        ("another kind of the length alone", {"/transitions/0/kind": "several"}, "/transitions/0"),
        (
            "two numbers of an event exchanged",
            lambda d: _exchanged(d["transitions"][0]["events"][0]),
            "/transitions/0",
        ),
        (
            "an event twice",
            lambda d: d["transitions"][0]["events"].append(deepcopy(d["transitions"][0]["events"][0])),
            "/transitions/0",
        ),
        ("a transition elsewhere", lambda d: _moved(d, "31.8000000000000"), "/transitions/0"),
        ("an interval that begins elsewhere", {"/intervals/1/from": "31.9000000000000"}, "/intervals"),
        ("a range that is longer", {"/range/to": "39"}, "/intervals"),
        ("a range that begins earlier", {"/range/from": "26"}, "/intervals"),
        (
            "a longer range, and a longer interval",
            {"/range/from": "26", "/intervals/0/from": "26"},
            "/intervals",
        ),
        ("another number of aspects", {"/intervals/0/aspects": 77}, "/intervals/0/aspects"),
        ("half an aspect", {"/intervals/0/aspects": 0.5}, "/intervals/0/aspects"),
        (
            "a degenerate curve",
            {"/degenerate": [{"kind": "curve", "equation": "alpha = 0 deg", "from": "31", "to": "38"}]},
            "/degenerate",
        ),
        (
            "nodes throughout",
            {"/degenerate": [{"kind": "node", "from": "31", "to": "38", "count": 2}]},
            "/degenerate",
        ),
        ("a tolerance that all keep", {"/tolerance": {"d1": "1"}, "/complete": True}, "/tolerance"),
    ],
    "report": [
        ("one interval in place of all", lambda d: _one_interval(d, 4), "/intervals"),
        ("the other verdict", {"/passed": True}, "/passed"),
        ("more cusps found", {"/max_cusps_found": 24}, "/max_cusps_found"),
        ("fewer cusps found", {"/min_cusps_found": 0}, "/min_cusps_found"),
        ("a violation less", _without("/violations"), "/violations"),
        ("no bound", {"/requirement/max_cusps": None}, "/requirement"),
        ("a bound of halves", {"/requirement/max_cusps": 5.5}, "/requirement/max_cusps"),
        ("a range of no width", {"/requirement/range/to": "36"}, "/intervals"),
        ("an example elsewhere", {"/violations/0/example/l1": "1"}, "/violations/0/example"),
        (
            "an example with a cusp twice",
            lambda d: d["violations"][0]["example"]["cusps"].__setitem__(
                1, deepcopy(d["violations"][0]["example"]["cusps"][0])
            ),
            "/violations/0/example",
        ),
        ("a cut moved", _cut_moved, "/intervals"),
        ("a mode that cannot change", {"/mode_change": "impossible"}, "/mode_change"),
    ],
    "passed": [("a bound that an interval exceeds", {"/requirement/max_cusps": 5}, "/passed")],
    "limits": [
        ("a crossing hidden", lambda d: _one_interval(d, 5), "/intervals"),
        (
            "all cusps, whatever the limits",
            lambda d: (_one_interval(d, 8), d["requirement"].update(max_cusps=8)),
            "/intervals",
        ),
        ("a limit that is left out", {"/requirement/limits/l3/max": None}, "/intervals"),
        ("a limit of the other leg", lambda d: _exchanged_limits(d), "/intervals"),
        (
            "a limit of an alias",
            {"/requirement/limits/l03": {"min": "10", "max": None}},
            "/requirement/limits/l03",
        ),
        (
            "a limit of the fixed leg",
            {"/requirement/limits/l1": {"min": "10", "max": None}},
            "/requirement/limits/l1",
        ),
    ],
    "curves": [
        ("a curve less", _without("/curves"), "/curves"),
        (
            "a curve that nobody sees",
            lambda d: d["curves"].append({**d["curves"][-1], "name": "C99", "points": []}),
            "/curves",
        ),
        ("two curves of one name", lambda d: d["curves"][1].update(name=d["curves"][0]["name"]), "/curves"),
        ("points exchanged between curves", _points_exchanged, "/curves"),
        ("ends exchanged between curves", _ends_exchanged, "/curves"),
        ("a cusp of another number", {"/curves/0/points/0/cusp": 24}, "/curves"),
        ("a cusp of number 0", {"/curves/0/points/0/cusp": 0}, "/curves/0/points/0/cusp"),
        ("another digit of a point", lambda d: _exchanged(d["curves"][0]["points"][0]), "/curves/0/points/0"),
        ("a range of curves", {"/range/to": "0.6"}, "/range"),
        ("an end elsewhere", {"/curves/0/from/l1": "0.600000000000000"}, "/curves"),
        (
            "an end of another kind",
            lambda d: [
                d["curves"][0]["from"].update(kind="lips"),
                d["curves"][0]["from"]["events"][0].update(kind="lips"),
            ],
            "/curves",
        ),
        (
            "an open end within the range",
            {"/curves/0/from": {"l1": "0", "kind": "open", "joins": None, "events": []}},
            "/curves",
        ),
        (
            "a curve that joins itself",
            lambda d: d["curves"][0]["from"].update(joins=d["curves"][0]["name"]),
            "/curves",
        ),
        (
            "an end that joins nobody",
            lambda d: [curve["from"].update(joins=None) for curve in d["curves"]],
            "/curves",
        ),
    ],
    "margin": [
        ("a wider tolerance", lambda d: _wider(d, 2000), "/proved"),
        ("another count of a margin", {"/count": 6}, "/count"),
        ("no count of a margin", {"/count": None}, "/count"),
        ("another validity", {"/validity": "2999"}, "/validity"),
        ("weights that are not the tolerance", {"/weights/d1": "0.01"}, "/weights"),
        ("open in place of proved", {"/verdict": "open"}, "/verdict"),
        ("two subjects", {"/asked/window": "10"}, "/asked"),
        ("a margin of 0 as proved", {"/proved": "0"}, "/verdict"),
    ],
    "refuted": [
        (
            "proved in place of refuted",
            {"/proved": "1", "/verdict": "proved", "/counterexample": None},
            "/proved",
        ),
        ("a counter-example of another radius", {"/counterexample/radius": "0.9"}, "/counterexample/radius"),
        ("a change of an exact length", {"/counterexample/geometry/d2": "16.541"}, "/counterexample/radius"),
        ("a counter-example of another count", {"/counterexample/count": 6}, "/counterexample/count"),
        ("a counter-example elsewhere", {"/counterexample/l1": "28"}, "/counterexample"),
    ],
    "singular": [
        (
            "a cusp less",
            _vertices(lambda rows: rows.remove(next(x for x in rows if x["kind"] == "cusp"))),
            "/components",
        ),
        (
            "a turning point less",
            _vertices(lambda rows: rows.remove(next(x for x in rows if x["kind"] == "turning"))),
            "/components",
        ),
        ("another digit of a point", _vertices(lambda rows: _exchanged(rows[0])), "/components"),
        ("two points exchanged", _vertices(lambda rows: rows.reverse()), "/components"),
        ("a component twice", lambda d: d["components"].append(deepcopy(d["components"][0])), "/components"),
        ("no components", {"/components": []}, "/components"),
        ("a region less", _without("/regions"), "/regions"),
        (
            "more poses in a region",
            lambda d: d["regions"][0].update(poses=(d["regions"][0]["poses"] + 2) % 7),
            "/regions",
        ),
        ("an aspect less", _without("/aspects"), "/aspects"),
        (
            "an aspect of the other sign",
            lambda d: d["aspects"][0].update(sign=-d["aspects"][0]["sign"]),
            "/aspects",
        ),
    ],
    "loop": [
        ("another digit of an end", {"/from/alpha_deg": "47.6056212492551"}, "/from"),
        ("another number of a pose", {"/to/pose": 4}, "/to"),
        ("a pose that is none", {"/to/pose": 6}, "/to"),
        ("another joint vector", {"/l2": "15.6"}, "/from"),
        ("an arc through a singularity", {"/certificate/arcs": [["from", "to"]]}, "/sign"),
        ("another sign", {"/sign": -1}, "/sign"),
        ("no sign", {"/sign": 0}, "/sign"),
        ("another turn of an end", {"/certificate/turns/to/alpha": 1}, "/sign"),
        ("a start in another turn", {"/certificate/turns/from/alpha": 1}, "/certificate/turns"),
        (
            "a greater least determinant",
            {"/certificate/least_determinant": "3.80000"},
            "/certificate/least_determinant",
        ),
        ("a limit that is exceeded", {"/limits/l2/min": "9"}, "/limits/l2"),
        ("a limit of the fixed leg", {"/limits/l1": {"min": "27.1", "max": None}}, "/limits/l1"),
        ("another winding", {"/winding": -1}, "/winding"),
        ("another cusp", {"/cusp": 3}, "/winding"),
        ("a cusp that is none", {"/cusp": 20}, "/winding"),
        ("a twin that is none", {"/twins": [1]}, "/winding"),
        ("a winding without a cusp", {"/cusp": None}, "/winding"),
        ("an open loop", {"/closed": False}, "/closed"),
        ("a path that is not there", {"/connected": False}, "/connected"),
        ("another time", {f"{LOOP}/time": "0.26"}, "/samples"),
        ("another place", {f"{LOOP}/place": "0.17"}, LOOP),
        ("a place beyond the end", {"/samples/4/place": "1.5"}, "/samples"),
        ("another length of a sample", lambda d: _exchanged(d["samples"][1]), LOOP),
        ("another determinant", {f"{LOOP}/determinant": "8.49870000000000"}, LOOP),
        (
            "an angle in another turn",
            lambda d: d["samples"][2].update(alpha_deg="443.503331118249"),
            "/samples/2",
        ),
        ("a greater clearance of a sample", {f"{LOOP}/clearance_deg": "57.5704"}, f"{LOOP}/clearance_deg"),
        ("another law of time", {"/timing": "constant"}, "/timing"),
        ("a law of time that is nearly right", {"/timing": "trapezoid"}, "/timing"),
        ("what becomes of others", {"/others": []}, "/others"),
    ],
    "range": [
        ("a gap between arcs", {"/certificate/arcs/1/0/alpha_deg": "-171"}, "/certificate/arcs"),
        ("a narrower range of the fixed leg", {"/between/to": "28.5"}, "/between"),
        ("no range of the fixed leg", {"/between": None}, "/between"),
    ],
    "given": [
        ("another length of a given pose", {"/to/l2": "25.3062354887644"}, "/to"),
        ("a closed path of two joint vectors", {"/closed": True}, "/closed"),
    ],
    "wide": [
        ("a greater clearance of the path", {"/clearance/proved": "21"}, "/clearance/proved"),
        ("a clearance beyond all poses", {"/clearance/proved": "1" + "0" * 400}, "/clearance/proved"),
        ("a clearance beyond its bound", {"/clearance/bound": "19"}, "/clearance/bound"),
        ("a path less bent than it is", {"/clearance/radius": "99"}, "/clearance/radius"),
        ("a fold that is farther away", {"/clearance/legs": "9"}, "/clearance/legs"),
        ("a clearance that is less than was asked for", {"/clearance/asked": "25"}, "/clearance/asked"),
    ],
    "motion": [
        ("a speed that is exceeded", {"/motion/speed/l3": "1"}, "/motion"),
        ("a smaller deviation", {"/deviation/l2": "0.0001"}, "/deviation"),
        ("a law without its certificate", {"/timing": "cosine"}, "/timing"),
    ],
    "signs": [("connected all the same", {"/connected": True}, "/connected")],
    "aspect": [
        ("opposite signs that are alike", {"/obstacle": "opposite-signs"}, "/obstacle"),
        ("an aspect of a range that is the same", {"/between": {"from": "27", "to": "30"}}, "/obstacle"),
        ("a range without a path", {"/connecting_range/to": "27.5"}, "/connecting_range"),
        ("a range without an end", {"/connecting_range/from": "28"}, "/connecting_range"),
        ("limits that separate", {"/obstacle": "separated-by-limits"}, "/obstacle"),
        ("undecided, but not connected", {"/obstacle": "undecided"}, "/connected"),
    ],
    "outside": [
        ("an aspect that is the same", {"/obstacle": "other-aspect"}, "/obstacle"),
        ("limits that are kept", {"/limits/l2/min": "19"}, "/obstacle"),
    ],
}


def _exchanged_limits(document: Document) -> None:
    limits = document["requirement"]["limits"]
    limits["l2"] = limits.pop("l3")


FORGERIES = [Forgery(name, base, change, at) for base, rows in LISTS.items() for name, change, at in rows]
