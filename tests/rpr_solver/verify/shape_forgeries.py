"""Forged documents of manipulators of special shapes, for the list of forgeries.py."""

from __future__ import annotations

import hashlib
from fractions import Fraction

from rpr_solver import Requirement, census, check, table_document
from tests.rpr_solver.verify.forgeries import _BASES, Document, forgery, put
from tests.rpr_solver.verify.more_forgeries import one_interval
from tests.support.families import CONGRUENT_FLAT, MIRRORED_RIGHT_BASE, family

SHAPES = {
    "similar": lambda: census(family("similar"), digits=15, fixed_leg=2).to_json(),
    "congruent": lambda: census(family("congruent"), digits=15, fixed_leg=3).to_json(),
    "similar table": lambda: table_document(family("similar"), "4.7", digits=15),
    "mirrored table": lambda: table_document(family("congruent, mirrored"), "22.8", digits=15),
    "congruent table": lambda: table_document(family("congruent"), "4.8", fixed_leg=3, digits=15),
    "mirrored nodes": lambda: table_document(family("congruent, mirrored"), "6.7", digits=15),
    "congruent flat table": lambda: table_document(CONGRUENT_FLAT, 5, digits=15),
    "congruent flat": lambda: census(CONGRUENT_FLAT, digits=15).to_json(),
    "a node at one length": lambda: census(
        family("folded flat platform"), digits=15, fixed_leg=3, start=Fraction(7, 2), stop=5
    ).to_json(),
    "mirrored": lambda: census(MIRRORED_RIGHT_BASE, digits=15, fixed_leg=2).to_json(),
    "mirrored, with limits": lambda: check(
        MIRRORED_RIGHT_BASE,
        Requirement(2, 1, 60, max_cusps=4, limits={1: (5, 45)}),
        digits=15,
    ).to_json(),
}
_BASES.update(SHAPES)


def of_geometry(document: Document, **sides: str) -> None:
    """Says that the document is of another manipulator."""
    document["geometry"].update(sides)
    text = "3-RPR;" + ";".join(f"{name}={value}" for name, value in document["geometry"].items())
    document["geometry_hash"] = "sha256:" + hashlib.sha256(text.encode()).hexdigest()


@forgery("triangles that are almost similar", "similar", "/intervals/0/count")
def _(document: Document) -> None:
    """There are cusps then."""
    of_geometry(document, d3="20.01")


@forgery("similar triangles of the other sense", "similar", "/intervals/0/count")
def _(document: Document) -> None:
    of_geometry(document, orientation="cw")


@forgery("triangles that are almost mirrored", "mirrored", "/transitions")
def _(document: Document) -> None:
    of_geometry(document, d1="7.000000000000001")


@forgery("nodes in every slice left out", "similar", "/degenerate")
def _(document: Document) -> None:
    document["degenerate"] = []


@forgery("another number of nodes", "mirrored", "/degenerate")
def _(document: Document) -> None:
    document["degenerate"][0]["count"] = 4


@forgery("nodes up to another length", "similar", "/degenerate")
def _(document: Document) -> None:
    for part, end in zip(document["degenerate"], ("to", "from"), strict=True):
        part[end] = "25.0000000000001"


put("another kind in every slice", "congruent flat", "/degenerate/1/kind", "quadruple", "/degenerate")
put("a curve at another angle", "congruent", "/degenerate/0/equation", "alpha = 180 deg", "/degenerate")
put("a curve in some slices only", "congruent", "/degenerate/0/to", "100.000000000000", "/degenerate")


@forgery("a cusp more in slices without any", "congruent", "/intervals/0/count")
def _(document: Document) -> None:
    document["intervals"][0]["count"] = 1


def _without(document: Document, n: int) -> None:
    """The census without a transition."""
    del document["transitions"][n]
    document["intervals"][n]["to"] = document["intervals"].pop(n + 1)["to"]
    if n < len(document["transitions"]):
        document["transitions"][n]["count_before"] = document["intervals"][n]["count"]


@forgery("a quadruple pose hidden beside cusps", "mirrored", "/transitions")
def _(document: Document) -> None:
    _without(document, 1)


@forgery("a birth at the wall hidden", "mirrored", "/intervals/")
def _(document: Document) -> None:
    """Four cusps throughout, where they are six at last."""
    _without(document, 2)


@forgery("a node as a quadruple pose", "mirrored", "/transitions/0/")
def _(document: Document) -> None:
    transition = document["transitions"][0]
    transition["kind"] = "quadruple"
    for event in transition["events"]:
        event["kind"] = "quadruple"


@forgery("one of two births of one length", "mirrored", "/transitions/0/events")
def _(document: Document) -> None:
    document["transitions"][0]["events"].pop()


@forgery("a birth at the other side of the wall", "mirrored", "/transitions/0/events/")
def _(document: Document) -> None:
    """θ is turned by 180°, as if X were −L."""
    for event in document["transitions"][0]["events"]:
        theta = float(event["theta2_deg"])
        event["theta2_deg"] = f"{theta - 180 if theta > 0 else theta + 180:.12f}"


put("a length of a node as 0", "mirrored", "/transitions/0/events/0/l1", "0", "/transitions/0/events")


@forgery("all cusps of a shape, whatever the limits", "mirrored, with limits", "/intervals/")
def _(document: Document) -> None:
    one_interval(document, 4)


@forgery("no limits of a shape", "mirrored, with limits", "/intervals/")
def _(document: Document) -> None:
    document["requirement"]["limits"] = None


@forgery("a cusp of mirrored triangles less", "mirrored table", "/slices/0/count")
def _(document: Document) -> None:
    [part] = document["slices"]
    part["cusps"].pop()
    part["count"] -= 1


AT = "/slices/0/degenerate_points/1"
put("another kind of a pose at an exact angle", "similar table", f"{AT}/kind", "isolated-point", AT)
put("another digit of a pose at an exact angle", "similar table", f"{AT}/l2", "10.9725354233412", AT)
put("another kind of a node of mirrored triangles", "mirrored nodes", f"{AT}/kind", "isolated-point", AT)
put("another digit of a node of mirrored triangles", "mirrored nodes", f"{AT}/l2", "20.9503199941002", AT)
AT = "/slices/0/degenerate_points/2"
put("another kind of a pose on a curve", "congruent flat table", f"{AT}/kind", "quadruple", AT)
put("another digit of a pose on a curve", "congruent flat table", f"{AT}/l2", "1.50000000000000", AT)


@forgery("a pose on a curve left out", "congruent flat table", "/slices/0/count")
def _(document: Document) -> None:
    document["slices"][0]["degenerate_points"].pop()


AT = "/slices/0/certificate"
put(
    "another factor beside a shared curve",
    "congruent table",
    f"{AT}/factors/1/multiplicity",
    2,
    f"{AT}/factors",
)
put("the whole degree beside a shared curve", "congruent table", f"{AT}/eliminant_degree", 24)
put("a root less beside a shared curve", "congruent table", f"{AT}/real_roots", 5)


@forgery("another kind of a node at one length", "a node at one length", "/transitions/0/")
def _(document: Document) -> None:
    [transition] = document["transitions"]
    transition["kind"] = transition["events"][0]["kind"] = "isolated-point"


@forgery("another digit of a node at one length", "a node at one length", "/transitions/0/")
def _(document: Document) -> None:
    document["transitions"][0]["events"][0]["l1"] = "1.00000000000001"


@forgery("a node at one length hidden", "a node at one length", "/transitions")
def _(document: Document) -> None:
    document["transitions"], document["intervals"] = [], document["intervals"][:1]
    document["intervals"][0]["to"] = document["range"]["to"]
