"""Forged documents: each is consistent but for one false claim, or reads in two ways.

A forgery has a name, the document it begins with, what is changed, and the member that must be named: by a
refusal, by a refused claim, or by a claim that the first line calls not established.
"""

from __future__ import annotations

import cmath
import json
import math
from collections.abc import Callable
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
    poses,
    table_document,
    verify_document,
)
from tests.support.shared import curves_of

Document = Any
ZEIN = EXAMPLES["zein-flat"]
SMALL = Manipulator(9, 4, 11, 14, 15, 13)
FULL = "/certificate/full"


@cache
def _base(name: str) -> str:
    return json.dumps(_BASES[name]())


def base(name: str) -> Document:
    """A right document by its name."""
    return json.loads(_base(name))


def _close_to_one() -> tuple[Manipulator | Fraction, ...]:
    """A manipulator, and lengths of its legs with a pose whose B1 has the x 0.999999999999996."""
    x = 1 - Fraction(4, 10**15)
    y = x * 4 / 3
    (bx, by), (cx, cy) = (x + Fraction(9, 5), y + Fraction(12, 5)), (x - Fraction(7, 5), y + Fraction(24, 5))
    return Manipulator(bx + by * 3 / 4, cx - 3, cy - 4, 3, 4, 5), x * 5 / 3, by * 5 / 4, Fraction(5)


_BASES: dict[str, Callable[[], Document]] = {
    "table": lambda: table_document(ZEIN, 10, digits=15),
    "leg 2": lambda: table_document(Manipulator(5, 3, 4, 17, 10, 9), 5, fixed_leg=2, digits=15),
    "nodes": lambda: table_document(Manipulator(10, 4, 0, 12, 15, 9), 8, digits=15),
    "poses": lambda: poses(ZEIN, 20, 21, 22, digits=15).to_json(),
    "close to a power of ten": lambda: poses(*_close_to_one(), digits=15).to_json(),
    "two at an angle": lambda: poses(Manipulator(5, 2, -3, 5, 6, 5), 3, 3, 7, digits=15).to_json(),
    "census": lambda: census(ZEIN, digits=15, start=36, stop=38).to_json(),
    "two transitions": lambda: census(ZEIN, digits=15, start=31, stop=38).to_json(),
    "printed alike": lambda: census(
        Manipulator(10, Fraction(5) + Fraction(1, 10**17), 8, 6, 5, 5),
        digits=15,
        fixed_leg=3,
        start=Fraction(22, 5),
        stop=Fraction(9, 2),
    ).to_json(),
    "open census": lambda: census(SMALL, digits=15, start=24).to_json(),
    "curves": lambda: (
        curves_of(ZEIN, digits=15).part("0.5", "1.2", lengths=[Fraction(1), Fraction(21, 20)]).to_json()
    ),
    "full curves": lambda: (
        curves_of(ZEIN, digits=15)
        .part("0.5", "1.2", lengths=[Fraction(1), Fraction(21, 20)])
        .to_json(certificate="full")
    ),
    "report": lambda: check(
        ZEIN, Requirement(1, Fraction(36), Fraction(38), max_cusps=5), digits=15
    ).to_json(),
    "limits": lambda: check(
        ZEIN,
        Requirement(1, Fraction(36), Fraction(38), max_cusps=2, limits={2: (Fraction(10), None)}),
        digits=15,
    ).to_json(),
    "passed": lambda: check(
        ZEIN, Requirement(1, Fraction(36), Fraction(37), max_cusps=8), digits=15
    ).to_json(),
}


@dataclass(frozen=True)
class Forgery:
    """A name, the document it begins with, what is changed in it, and the member that must be named."""

    name: str
    base: str
    forge: Callable[[Document], object]
    at: str

    def document(self) -> str:
        """Its JSON; a change returns it if it is no value of JSON."""
        document = base(self.base)
        result = self.forge(document)
        return result if isinstance(result, str) else json.dumps(document)


def first_line(document: str | bytes | Document) -> str:
    """What a reader of the verdict sees first: the refusal, or the summary."""
    try:
        return verify_document(document).summary
    except InputError as error:
        return f"REFUSED: {error}"


FORGERIES: list[Forgery] = []


def forgery(name: str, base: str, at: str) -> Callable[[Callable[[Document], object]], object]:
    """Adds a forgery to the list."""

    def add(forge: Callable[[Document], object]) -> object:
        FORGERIES.append(Forgery(name, base, forge, at))
        return forge

    return add


def put(name: str, base: str, at: str, value: object, named: str = "") -> None:
    """Adds a forgery that puts a value to a member, or takes it away if the value is ...."""

    def forge(document: Document) -> None:
        *path, last = [int(step) if step.isdigit() else step for step in at[1:].split("/")]
        place = document
        for step in path:
            place = place[step]
        if value is ...:
            del place[last]
        else:
            place[last] = value

    FORGERIES.append(Forgery(name, base, forge, named or at))


def text_instead(name: str, base: str, at: str, old: str, new: str) -> None:
    """Adds a forgery that changes the text of a document, once."""

    def forge(document: Document) -> str:
        text = json.dumps(document)
        assert old in text, (name, old)
        return text.replace(old, new, 1)

    FORGERIES.append(Forgery(name, base, forge, at))


# What a reader may take in two ways
text_instead("a key twice", "table", "document", '"count": 4', '"count": 6, "count": 4')
text_instead("a count as a decimal", "table", "/slices/0/count", '"count": 4', '"count": 4.0')
text_instead("a count with an exponent", "table", "/slices/0/count", '"count": 4', '"count": 4e0')
text_instead("a count of minus 0", "census", "document", '"from": "36"', '"from": -0')
put("a count as a text", "table", "/slices/0/count", "4")
put("true for a count", "table", "/slices/0/certificate/factors/0/multiplicity", True)
put("a half of a multiplicity", "poses", "/poses/0/multiplicity", 0.5, "0.5")
put("an unknown member", "table", "/note", "certified by me")
put("an unknown member of a slice", "table", "/slices/0/cusp_free", True)
put("an unknown member of a cusp", "table", "/slices/0/cusps/0/stable", True)
put("a length with another name", "table", "/slices/0/L1", "11")
put("a null error", "table", "/slices/0/error", None, "/slices/0/count")
put("an exponent", "table", "/slices/0/l1", "1e1")
put("a plus", "table", "/slices/0/l1", "+10")
put("a leading zero", "table", "/slices/0/l1", "010")
put("a trailing zero", "table", "/slices/0/l1", "10.0")
put("a quotient that is not in lowest terms", "table", "/slices/0/l1", "20/2")
put("digits of another script", "table", "/slices/0/l1", "\u0661\u0660")
put("a negative length", "table", "/slices/0/l1", "-10")
put("a length of 0", "table", "/slices/0/l1", "0")
put("an angle beyond a turn", "table", "/slices/0/cusps/0/alpha_deg", "391.450940328114")
put("an angle of -180", "table", "/slices/0/cusps/0/alpha_deg", "-180.000000000000")
put("a negative length of a leg", "table", "/slices/0/cusps/0/l2", "-25.2233542007524")
put("fewer digits", "table", "/slices/0/cusps/0/l2", "25.22")
put("more digits", "table", "/slices/0/cusps/0/l2", "25.22335420075240")
put("a length of 0 of a leg", "table", "/slices/0/cusps/0/l2", "0")
put("another number of digits", "table", "/digits", 16, "/slices/0/cusps/0/alpha_deg")
put("half a digit", "table", "/digits", 15.5, "15.5")
put("no such leg", "table", "/fixed_leg", 4)
put("another hash", "table", "/geometry_hash", "sha256:" + "0" * 64)
put("an alias in the geometry", "table", "/geometry/d1", "13.0")
put("a side below 0", "table", "/geometry/d1", "-13")
put("a triangle that is none", "table", "/geometry/d1", "999")
put("a number in the geometry", "table", "/geometry/d1", 13)
put("an unknown orientation", "table", "/geometry/orientation", "CCW")


# Cusp tables
put("another count", "table", "/slices/0/count", 6)
put("an error instead of cusps", "table", "/slices/0", {"l1": "10", "error": {"type": "x", "detail": "y"}})
put("no real roots", "table", "/slices/0/certificate/real_roots", 8)
put("another degree", "table", "/slices/0/certificate/eliminant_degree", 23)
put("another origin", "table", "/slices/0/certificate/factors/0/origin", "circular", "/certificate/factors")
put("a factor less", "table", "/slices/0/certificate/factors/0", ..., "/slices/0/certificate/factors")


@forgery("a cusp less", "table", "/slices/0/count")
def _(document: Document) -> None:
    document["slices"][0]["cusps"].pop()
    document["slices"][0]["count"] -= 1


@forgery("a cusp twice", "table", "/slices/0/cusps")
def _(document: Document) -> None:
    part = document["slices"][0]
    part["cusps"].insert(1, deepcopy(part["cusps"][0]))
    part["count"] += 1


@forgery("a cusp in place of another", "table", "/slices/0/cusps")
def _(document: Document) -> None:
    cusps = document["slices"][0]["cusps"]
    cusps[1] = deepcopy(cusps[0])


@forgery("cusps that are not sorted", "table", "/slices/0/cusps")
def _(document: Document) -> None:
    document["slices"][0]["cusps"].reverse()


@forgery("two angles exchanged", "table", "/slices/0/cusps/0")
def _(document: Document) -> None:
    cusp = document["slices"][0]["cusps"][0]
    cusp["l2"], cusp["l3"] = cusp["l3"], cusp["l2"]


def _demoted(kind: str, name: str) -> None:
    @forgery(f"a cusp demoted to {kind}, {name}", name, "/slices/0/degenerate_points/0")
    def _(document: Document) -> None:
        part = document["slices"][0]
        place = 3 if "leg 2" in name else 0
        part["degenerate_points"].append({"kind": kind, **part["cusps"].pop(place)})
        part["count"] -= 1


for _kind in ("node", "swallowtail", "higher", "quadruple", "lips", "beak-to-beak", "isolated-point"):
    _demoted(_kind, "leg 2")
_demoted("higher", "table")
put(
    "an unknown kind",
    "table",
    "/slices/0/degenerate_points",
    [
        {
            "kind": "banana",
            "alpha_deg": "1.00000000000000",
            "theta1_deg": "1.00000000000000",
            "l2": "1.00000000000000",
            "l3": "1.00000000000000",
        }
    ],
    "/slices/0/degenerate_points/0/kind",
)
put(
    "a curve that is none",
    "table",
    "/slices/0/degenerate_points",
    [{"kind": "curve", "equation": "alpha = 0 deg"}],
    "/slices/0/degenerate_points/0",
)


@forgery("an angle printed as exactly 0", "leg 2", "/slices/0/cusps/3")
def _(document: Document) -> None:
    document["slices"][0]["cusps"][3]["alpha_deg"] = "0"


def _posed(document: Document, alpha: float, theta: float) -> None:
    """Puts a pose with right lengths among the cusps of a slice."""
    g = {name: float(x) for name, x in document["geometry"].items() if name != "orientation"}
    part = document["slices"][0]
    foot = (g["d1"] ** 2 + g["d3"] ** 2 - g["d2"] ** 2) / (2 * g["d1"])
    turn = cmath.rect(1, math.radians(alpha))
    corner = cmath.rect(float(part["l1"]), math.radians(theta))
    height = math.sqrt(max(0.0, g["d3"] ** 2 - foot**2)) * (
        -1 if document["geometry"]["orientation"] == "cw" else 1
    )
    ends = (
        corner + g["d1"] * turn - g["a2x"],
        corner + complex(foot, height) * turn - complex(g["a3x"], g["a3y"]),
    )
    numbers = {"alpha_deg": alpha, "theta1_deg": theta, "l2": abs(ends[0]), "l3": abs(ends[1])}
    cusp = {name: "0" if x == 0 else f"{x:#.15g}" for name, x in numbers.items()}
    part["cusps"].append(cusp)
    part["cusps"].sort(key=lambda row: float(row["theta1_deg"]))
    part["count"] += 1


@forgery("a pose that is no cusp", "table", "/slices/0/cusps/")
def _(document: Document) -> None:
    _posed(document, 12.3456789012345, 23.4567890123456)


@forgery("a pose with a leg that is stationary", "table", "/slices/0/cusps/")
def _(document: Document) -> None:
    _posed(document, 0.0, 0.0)


# Poses
@forgery("a pose dropped, another twice at an angle of two", "two at an angle", "/poses/1")
def _(document: Document) -> None:
    document["poses"][1] = deepcopy(document["poses"][0])


@forgery("a pose less", "poses", "/poses")
def _(document: Document) -> None:
    document["poses"].pop()
    document["count"] -= 1
    document["count_with_multiplicity"] -= 1


@forgery("a pose as a double one", "poses", "/poses/0")
def _(document: Document) -> None:
    document["poses"].pop()
    document["poses"][0]["multiplicity"] = 2
    document["count"] -= 1


@forgery("a pose of another joint vector", "poses", "/poses/0")
def _(document: Document) -> None:
    document["poses"][0] = poses(ZEIN, 20, 21, "22.5", digits=15).to_json()["poses"][0]


put("another leg", "poses", "/l2", "21.5", "/polynomial")
put("a root of a square", "poses", "/l2", "sqrt(441)")
put("a root of a number below 0", "poses", "/l2", "sqrt(-441)")
put("a count of poses", "poses", "/count", 4)
put("a count with multiplicity", "poses", "/count_with_multiplicity", 4)
put(
    "a curve of poses that is none",
    "poses",
    "/curves",
    [{"kind": "curve", "alpha_deg": "0", "description": ""}],
)
put("a factor of poses", "poses", "/certificate/factors", [], "/certificate/factors")
put("a coefficient less", "poses", "/polynomial/coefficients/0", ..., "/polynomial/coefficients")
put("another coefficient", "poses", "/polynomial/coefficients/0", "1", "/polynomial")
put("half of a root in a polynomial", "poses", "/polynomial/omega", "sqrt(2)", "/polynomial")


@forgery("poses that are not sorted", "poses", "/poses")
def _(document: Document) -> None:
    document["poses"].reverse()


@forgery("an angle of a leg turned by 180 degrees", "poses", "/poses/0")
def _(document: Document) -> None:
    pose = document["poses"][0]
    pose["theta2_deg"] = pose["theta3_deg"]


# Censuses
@forgery("a transition less", "census", "/intervals")
def _(document: Document) -> None:
    _hide(document, 0)


def _hide(document: Document, n: int) -> None:
    """Hides a transition, with the count below it."""
    del document["transitions"][n]
    low, high = document["intervals"][n : n + 2]
    document["intervals"][n : n + 2] = [low | {"to": high["to"]}]
    if n < len(document["transitions"]):
        document["transitions"][n]["count_before"] = low["count"]


@forgery("all transitions less", "census", "/intervals/0/count")
def _(document: Document) -> None:
    document["transitions"] = []
    document["intervals"] = [{"from": "36", "to": "38", "count": 8, "aspects": None}]


@forgery("a fake transition without a pose", "census", "/transitions/0")
def _(document: Document) -> None:
    _insert(document, "36.5000000000000", [], 0)


def _insert(document: Document, length: str, events: list[Any], change: int) -> None:
    """Inserts a transition into the first interval."""
    first = document["intervals"][0]
    number, kind = first["count"], events[0]["kind"] if events else "unclassified"
    row = {"l1": length, "kind": kind, "count_before": number, "count_after": number + change}
    document["transitions"].insert(0, {**row, "events": events})
    document["intervals"][0:1] = [first | {"to": length}, first | {"from": length}]


def _fake_event(kind: str) -> None:
    @forgery(f"a cusp as the event {kind}", "census", "/transitions/0")
    def _(document: Document) -> None:
        cusp = table_document(ZEIN, "36.5", digits=15)["slices"][0]["cusps"][0]
        _insert(document, "36.5000000000000", [{"kind": kind, **cusp}], 0)


for _kind in ("swallowtail", "node", "higher", "quadruple", "isolated-point", "lips", "beak-to-beak"):
    _fake_event(_kind)


@forgery("a transition that changes nothing", "census", "/intervals/1/count")
def _(document: Document) -> None:
    document["transitions"][0]["count_after"] = document["transitions"][0]["count_before"]
    document["intervals"][1]["count"] = document["intervals"][0]["count"]


@forgery("a transition by four", "open census", "/intervals/1/count")
def _(document: Document) -> None:
    for n, row in enumerate(document["transitions"]):
        row["count_after"] += 2
        row["count_before"] += 2 if n else 0
    for part in document["intervals"][1:]:
        part["count"] += 2


@forgery("another kind of an event", "census", "/transitions/0")
def _(document: Document) -> None:
    row = document["transitions"][0]
    row["kind"] = row["events"][0]["kind"] = "lips" if row["kind"] != "lips" else "swallowtail"


@forgery("another digit of an event", "census", "/transitions/0/events/0")
def _(document: Document) -> None:
    event = document["transitions"][0]["events"][0]
    event["l2"] = event["l2"][:-1] + str((int(event["l2"][-1]) + 1) % 10)


@forgery("an event twice", "census", "/transitions/0/events/1")
def _(document: Document) -> None:
    events = document["transitions"][0]["events"]
    events.append(deepcopy(events[0]))


@forgery("a transition twice", "two transitions", "/transitions")
def _(document: Document) -> None:
    row = deepcopy(document["transitions"][0])
    row["count_before"] = row["count_after"]
    document["transitions"].insert(1, row)
    part = {"from": row["l1"], "to": row["l1"], "count": row["count_after"]}
    document["intervals"].insert(1, document["intervals"][1] | part)


@forgery("a cut twice", "report", "/intervals/2/from")
def _(document: Document) -> None:
    cut = document["intervals"][0]["to"]
    document["intervals"].insert(1, {"from": cut, "to": cut, "count": 5})


@forgery("transitions that do not ascend", "two transitions", "/transitions")
def _(document: Document) -> None:
    rows, parts = document["transitions"], document["intervals"]
    first, second = rows[0], rows[1]
    for name in ("l1", "kind", "events"):
        first[name], second[name] = second[name], first[name]
    for n in (0, 1):
        parts[n]["to"] = parts[n + 1]["from"] = rows[n]["l1"]


@forgery("another kind of the length alone", "census", "/transitions/0/kind")
def _(document: Document) -> None:
    document["transitions"][0]["kind"] = "several"


put("an interval that begins elsewhere", "census", "/intervals/1/from", "36.5000000000000", "/intervals")


@forgery("a transition before the range, by less than its digits", "census", "/transitions")
def _(document: Document) -> None:
    text = document["transitions"][0]["l1"] + "49"  # it is less than that
    document["range"]["from"] = document["intervals"][0]["from"] = text


put("a range that is longer", "census", "/range/to", "39", "/intervals")
put("a range that begins earlier", "census", "/range/from", "35", "/intervals")
put("a number of aspects", "census", "/intervals/0/aspects", 77)
put("one aspect more", "two transitions", "/intervals/1/aspects", 3)
put("half an aspect", "census", "/intervals/0/aspects", 0.5, "0.5")
put(
    "a degenerate curve",
    "census",
    "/degenerate",
    [{"kind": "curve", "from": "36", "to": "38"}],
    "/degenerate",
)
put(
    "nodes throughout",
    "census",
    "/degenerate",
    [{"kind": "node", "from": "36", "to": "38", "count": 2}],
    "/degenerate",
)


@forgery("a transition less of an open range", "open census", "/transitions")
def _(document: Document) -> None:
    _hide(document, 0)


put("a count of an open range", "open census", "/intervals/0/count", 24, "/intervals")
put(
    "nodes throughout an open range",
    "open census",
    "/degenerate",
    [{"kind": "node", "from": "24", "to": None, "count": 2}],
    "/degenerate",
)


# Cusp curves
@forgery("a curve less", "curves", "/curves")
def _(document: Document) -> None:
    _drop(document, lambda curve: bool(curve["points"]))


def _drop(document: Document, which: Callable[[Document], bool]) -> None:
    """Drops a curve and numbers the cusps anew."""
    curve = next(curve for curve in document["curves"] if which(curve))
    document["curves"].remove(curve)
    lost = {point["l1"]: point["cusp"] for point in curve["points"]}
    for other in document["curves"]:
        for point in other["points"]:
            point["cusp"] -= point["cusp"] > lost.get(point["l1"], 99)
        for side in ("from", "to"):
            other[side]["joins"] = None if other[side]["joins"] == curve["name"] else other[side]["joins"]


@forgery("all points and a curve less", "curves", "/curves")
def _(document: Document) -> None:
    for curve in document["curves"]:
        curve["points"] = []
    document["curves"].pop()


@forgery("a curve that nobody sees", "curves", "/curves")
def _(document: Document) -> None:
    curve = deepcopy(document["curves"][-1])
    document["curves"].append(curve | {"name": "C99", "points": []})


@forgery("two curves of one name", "curves", "/curves")
def _(document: Document) -> None:
    document["curves"][1]["name"] = document["curves"][0]["name"]


@forgery("points exchanged between curves", "curves", "/curves")
def _(document: Document) -> None:
    first, second = [curve for curve in document["curves"] if len(curve["points"]) == 2][:2]
    first["points"][1], second["points"][1] = second["points"][1], first["points"][1]


put("a cusp of another number", "curves", "/curves/0/points/0/cusp", 24, "/curves/0/points")
put("a cusp of number 0", "curves", "/curves/0/points/0/cusp", 0)
put("a range of curves", "curves", "/range/to", "0.6", "/range")


@forgery("an end elsewhere", "curves", "/from")
def _(document: Document) -> None:
    end = next(c["from"] for c in document["curves"] if c["from"]["events"])
    end["l1"] = "0.600000000000000"


@forgery("an end of another kind", "curves", "/from")
def _(document: Document) -> None:
    end = next(c["from"] for c in document["curves"] if c["from"]["events"])
    end["kind"] = end["events"][0]["kind"] = "beak-to-beak" if end["kind"] != "beak-to-beak" else "lips"


@forgery("an open end within the range", "curves", "/curves/")
def _(document: Document) -> None:
    end = next(c["from"] for c in document["curves"] if c["from"]["events"])
    end.update(kind="open", events=[], joins=None)


@forgery("a join at the other end", "curves", "/curves")
def _(document: Document) -> None:
    first, second = document["curves"]
    assert first["from"]["joins"] == second["name"]
    second["to"]["joins"] = first["name"]


@forgery("a curve that joins itself", "curves", "/curves")
def _(document: Document) -> None:
    curve = next(c for c in document["curves"] if c["from"]["joins"])
    curve["from"]["joins"] = curve["name"]


@forgery("a chain less", "full curves", "/curves/")
def _(document: Document) -> None:
    document["certificate"]["full"]["chains"].pop(0)


@forgery("an end that is said to join nobody", "full curves", "/curves/0/from")
def _(document: Document) -> None:
    chains = document["certificate"]["full"]["chains"]
    chains[:] = [chain for chain in chains if chain["from"]["curve"] == chain["to"]["curve"]]
    for curve in document["curves"]:
        curve["from"]["joins"] = None


@forgery("ends exchanged between curves", "full curves", "/curves/0/to")
def _(document: Document) -> None:
    first, second = document["curves"][:2]
    first["to"], second["to"] = second["to"], first["to"]


@forgery("an end as open, nobody being joined", "full curves", "/curves/0/to")
def _(document: Document) -> None:
    document["curves"][1]["to"] = {"l1": None, "kind": "open", "joins": None, "events": []}


@forgery("ends exchanged in a short document", "curves", "/curves")
def _(document: Document) -> None:
    first, second = document["curves"][:2]
    first["to"], second["to"] = second["to"], first["to"]


@forgery("tubes exchanged", "full curves", f"{FULL}/chains/")
def _(document: Document) -> None:
    first, second = document["certificate"]["full"]["chains"][:2]
    first["tubes"], second["tubes"] = second["tubes"], first["tubes"]


@forgery("a wide tube", "full curves", f"{FULL}/chains/0")
def _(document: Document) -> None:
    document["certificate"]["full"]["chains"][0]["tubes"][0]["radii"] = ["10", "10"]


@forgery("a point beyond the end of its curve", "curves", "/curves/")
def _(document: Document) -> None:
    end = next(c["from"] for c in document["curves"] if c["from"]["events"] and c["points"])
    end["l1"] = "1.01000000000000"


put("a tube without width", "full curves", f"{FULL}/chains/0/tubes/0/radii", ["0", "0"])
put("a tube of a length below 0", "full curves", f"{FULL}/chains/0/tubes/0/l1", "-1")
put("a chain without tubes", "full curves", f"{FULL}/chains/0/tubes", [])
put("a tube of the fixed leg", "full curves", f"{FULL}/chains/0/tubes/0/leg", 1)
put("an origin that is none", "full curves", f"{FULL}/chains/0/tubes/0/half_alpha", ["0", "0"])


# Reports of checks
@forgery("passed, with the intervals that say so", "report", "/intervals/")
def _(document: Document) -> None:
    for row in document["intervals"]:
        row["count"] = document["intervals"].index(row) % 2
    counts = [row["count"] for row in document["intervals"]]
    document.update(passed=True, violations=[], max_cusps_found=max(counts), min_cusps_found=min(counts))


@forgery("one interval in place of all", "report", "/intervals/0/count")
def _(document: Document) -> None:
    row = {"from": "36", "to": "38", "count": 4}
    document.update(intervals=[row], passed=True, violations=[], max_cusps_found=4, min_cusps_found=4)


put("the other verdict", "report", "/passed", True)
put("more cusps found", "report", "/max_cusps_found", 24)
put("fewer cusps found", "report", "/min_cusps_found", 0)
put("a violation less", "report", "/violations/0", ..., "/violations")
put("a bound that an interval exceeds", "passed", "/requirement/max_cusps", 5, "/passed")
put(
    "a limit of an alias",
    "limits",
    "/requirement/limits",
    {"l02": {"min": "10", "max": None}},
    "/requirement/limits/l02",
)
put(
    "a limit of the fixed leg",
    "limits",
    "/requirement/limits",
    {"l1": {"min": "10", "max": None}},
    "/requirement/limits/l1",
)
put("limits that hold no length", "limits", "/requirement/limits/l2", {"min": "10", "max": "9"})
put("no bound", "report", "/requirement/max_cusps", None, "/requirement")
put("a range of no width", "report", "/requirement/range/to", "36", "/intervals")
put("a bound of halves", "report", "/requirement/max_cusps", 5.5, "5.5")
put("other limits", "limits", "/requirement/limits/l2/min", "30", "/violations/0/example")
put("an example elsewhere", "report", "/violations/0/example/l1", "1", "/violations/0/example")


@forgery("an example with a cusp twice", "report", "/violations/0/example")
def _(document: Document) -> None:
    cusps = document["violations"][0]["example"]["cusps"]
    cusps[1] = deepcopy(cusps[0])


@forgery("a cut moved", "report", "/intervals/1/from")
def _(document: Document) -> None:
    old, new = document["intervals"][1]["from"], "36.9000000000000"
    for row in (*document["intervals"], *document["violations"]):
        for end in ("from", "to"):
            row[end] = new if row[end] == old else row[end]


@forgery("a member that is named like a verdict", "table", "/\\nESTABLISHED: all 12 claims")
def _(document: Document) -> None:
    document["\nESTABLISHED: all 12 claims"] = 1


@forgery("a member that is named like a verdict and too long", "table", "\\nESTABLISHED: all 12 claims")
def _(document: Document) -> None:
    document["\nESTABLISHED: all 12 claims"] = "9" * 1000


@forgery("a member that turns the line of the verdict", "table", "/\\u202eDEHSILBATSE")
def _(document: Document) -> None:
    document["\u202eDEHSILBATSE"] = 1


@forgery("a power of ten above the number", "close to a power of ten", "/poses")
def _(document: Document) -> None:
    [pose] = [pose for pose in document["poses"] if pose["b1_x"] == "0.999999999999996"]
    pose["b1_x"] = "1.00000000000000"


@forgery("two transitions that are printed alike as one", "printed alike", "/transitions")
def _(document: Document) -> None:
    first, second = document["transitions"]
    assert first["l3"] == second["l3"]
    first["events"] += second["events"]
    first["count_after"] = second["count_after"]
    del document["transitions"][1], document["intervals"][1]
