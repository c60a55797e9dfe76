"""Forged margins, for the list of forgeries.py: each is consistent but for one false claim."""

from __future__ import annotations

from fractions import Fraction

from rpr_solver import EXAMPLES, Manipulator, Requirement, exact_str, margin
from rpr_solver.margins import LENGTHS
from tests.rpr_solver.verify.forgeries import _BASES, FULL, SMALL, ZEIN, Document, forgery, put

INNOCENTI = EXAMPLES["innocenti"]
STRETCH = {"a2x": "0.01"}
"""A tolerance of one length, the others being exact: proofs have few variables."""

MARGINS = {
    "margin": lambda: margin(ZEIN, 10, tolerance=STRETCH, certificate="full").to_json(),
    "short margin": lambda: margin(ZEIN, 10, tolerance=STRETCH).to_json(),
    "refuted margin": lambda: margin(INNOCENTI, "28.1", tolerance={"d1": "0.004", "a3x": "0.0002"}).to_json(),
    "margin of a requirement": lambda: margin(
        ZEIN,
        requirement=Requirement(1, Fraction(10), Fraction("10.1"), max_cusps=4, limits={2: (5, None)}),
        tolerance=STRETCH,
        certificate="full",
    ).to_json(),
    "margin of an open range": lambda: margin(
        SMALL,
        requirement=Requirement(1, Fraction(1000), None, max_cusps=4),
        tolerance=STRETCH,
        certificate="full",
    ).to_json(),
    "margin of any number": lambda: margin(
        ZEIN, requirement=Requirement(1, Fraction(22), Fraction("22.5"), max_cusps=24), tolerance=STRETCH
    ).to_json(),
    "margin beside similar triangles": lambda: margin(
        Manipulator(30, "0.0005", 40, 15, 25, 20),
        requirement=Requirement(1, Fraction(30), Fraction("30.5"), max_cusps=0, limits={2: (None, 5)}),
        tolerance={"a3x": "0.001"},
        certificate="full",
    ).to_json(),
    "margin of a window": lambda: margin(ZEIN, window=10, tolerance=STRETCH, certificate="full").to_json(),
    "window at a transition": lambda: margin(
        Manipulator(-1, 2, 4, 3, 4, 5, orientation="cw"), window=5
    ).to_json(),
    "refuted window": lambda: margin(INNOCENTI, window="28.1", tolerance={"d1": "1"}).to_json(),
}
_BASES.update(MARGINS)
_BASES["margin beyond all limits"] = lambda: margin(
    ZEIN,
    requirement=Requirement(1, Fraction(1000), None, max_cusps=4, limits={2: (None, 5)}),
    tolerance=STRETCH,
    certificate="full",
).to_json()
"""Its proof has no parts: leg 2 is longer than 5 everywhere."""


def wider(document: Document, factor: int) -> None:
    """The same margin for a tolerance so many times as wide."""
    asked = document["asked"]["tolerance"]
    for g in LENGTHS:
        asked[g] = document["weights"][g] = exact_str(Fraction(asked[g]) * factor)
    if document["validity"] is not None:
        document["validity"] = exact_str(Fraction(document["validity"]) / factor)


@forgery("a wider tolerance", "margin", "/proved")
def _(document: Document) -> None:
    wider(document, 2000)


@forgery("a tolerance beyond the validity", "margin", "/proved")
def _(document: Document) -> None:
    wider(document, 3000)


@forgery("a wider tolerance without a proof", "short margin", "/proved")
def _(document: Document) -> None:
    wider(document, 500)


@forgery("a part undone", "margin", "/proved")
def _(document: Document) -> None:
    """The whole is said to need no cut."""
    document["certificate"]["full"]["cuts"] = ["."]


@forgery("a part less", "margin", "/proved")
def _(document: Document) -> None:
    [cuts] = document["certificate"]["full"]["cuts"]
    document["certificate"]["full"]["cuts"] = [cuts[:-1]]


@forgery("a part too many", "margin", "/proved")
def _(document: Document) -> None:
    [cuts] = document["certificate"]["full"]["cuts"]
    document["certificate"]["full"]["cuts"] = [cuts + "."]


@forgery("a cut of an exact length", "margin", "/proved")
def _(document: Document) -> None:
    [cuts] = document["certificate"]["full"]["cuts"]
    document["certificate"]["full"]["cuts"] = ["8" + cuts[1:]]


@forgery("a limit that legs keep beyond the turn", "margin beyond all limits", "/proved")
def _(document: Document) -> None:
    """No part is left to prove where all legs are longer."""
    document["asked"]["requirement"]["limits"]["l2"]["max"] = "2000"


@forgery("another orientation of a margin", "refuted margin", "/counterexample")
def _(document: Document) -> None:
    document["counterexample"]["geometry"]["orientation"] = "cw"


@forgery("a proof for a range beyond its own", "margin of a requirement", "/proved")
def _(document: Document) -> None:
    """Two transitions lie in the range, at 22.3 and 26.0."""
    document["asked"]["requirement"]["range"]["to"] = "26.1"


@forgery("a limit that a cusp crosses", "margin of a requirement", "/proved")
def _(document: Document) -> None:
    document["asked"]["requirement"]["limits"]["l2"]["min"] = "29.5"


@forgery("another number of cusps of a requirement", "margin of a requirement", "/count")
def _(document: Document) -> None:
    document["count"] = 2


@forgery("a window at another length", "margin of a window", "/proved")
def _(document: Document) -> None:
    """Six cusps are there."""
    document["certificate"]["full"]["length"] = "24"


@forgery("proved in place of refuted", "refuted margin", "/proved")
def _(document: Document) -> None:
    document.update(proved="1", verdict="proved", counterexample=None)


@forgery("a counter-example that is nearer", "refuted margin", "/counterexample/count")
def _(document: Document) -> None:
    """At half the radius, where the count is still that of the margin."""
    example = document["counterexample"]
    for g in LENGTHS:
        change = Fraction(example["geometry"][g]) - Fraction(document["geometry"][g])
        example["geometry"][g] = exact_str(Fraction(document["geometry"][g]) + change / 2)
    example["radius"] = "0.5"


@forgery("a geometry that has the window", "refuted window", "/counterexample")
def _(document: Document) -> None:
    document["counterexample"].update(radius="0.1", geometry={**document["geometry"], "d1": "17.14"})


FAR = "/counterexample/geometry"
put("another count of a margin", "margin", "/count", 6)
put("no count of a margin", "margin", "/count", None)
put("a margin without its proof", "margin", "/certificate/full", ..., "/proved")
put("a proof of nothing", "margin", "/proved", None, "/verdict")
put("another validity", "margin", "/validity", "2999")
put("weights that are not the tolerance", "margin", "/weights/d1", "0.01", "/weights")
put("open in place of proved", "margin", "/verdict", "open")
put("two subjects", "margin", "/asked/window", "10", "/asked")
put("members of another proof", "margin", f"{FULL}/turn", "1000", "/proved")
put("two regions in place of one", "margin", f"{FULL}/cuts", [".", "."], "/proved")
put("a sign that is none", "margin", f"{FULL}/cuts", ["9"], f"{FULL}/cuts/0")
put("refuted in place of open", "refuted margin", "/verdict", "open")
put("a counter-example of another radius", "refuted margin", "/counterexample/radius", "0.9")
put("a change of an exact length", "refuted margin", f"{FAR}/d2", "16.541", "/counterexample/radius")
put("a counter-example of another count", "refuted margin", "/counterexample/count", 6)
put("a counter-example with the property", "refuted margin", "/counterexample/count", 10, "/counterexample")
put("a counter-example elsewhere", "refuted margin", "/counterexample/l1", "28", "/counterexample")
put("a counter-example of no length", "refuted margin", "/counterexample/l1", None, "/counterexample")
put("a bound below the count", "margin of a requirement", "/asked/requirement/max_cusps", 3, "/proved")
put("no bound of a margin", "margin of a requirement", "/asked/requirement/max_cusps", None, "/asked")
ASKED = "/asked/requirement"
put("a number that slices may exceed", "margin of any number", f"{ASKED}/max_cusps", 23, "/proved")
put("a number that slices may not have", "margin of any number", f"{ASKED}/min_cusps", 1, "/proved")
put("poses that slices may have", "margin of any number", f"{ASKED}/degenerate", "refused", "/proved")
put("a turn that is not far", "margin of an open range", f"{FULL}/turn", "20", "/proved")
put("a slice that moves beyond 0", "margin of a window", f"{FULL}/rates/a2x", "-2000", "/proved")
put("no rates", "margin of a window", f"{FULL}/rates", ..., "/proved")
put("another window", "margin of a window", "/asked/window", "24", "/count")


@forgery("the number of a slice as that of a window", "window at a transition", "/count")
def _(document: Document) -> None:
    """Beside L1 = 5 are six cusps; one is a quadruple pose there."""
    document["count"] = 5


@forgery("nodes beyond the limits that are refused", "margin beside similar triangles", "/proved")
def _(document: Document) -> None:
    """With a3x = 0 the triangles are similar: each slice has two nodes, with l2 = 17 and 65."""
    document["asked"]["requirement"]["degenerate"] = "refused"
