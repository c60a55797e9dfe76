"""Building blocks of answers, errors (RFC 9457), and the forms in which documents are written."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from pydantic import ConfigDict, Field

import rpr_solver
from rpr_solver.notebook.figure import draw
from service.schemas.limits import Detail, Model
from worker.answers import Kept

if TYPE_CHECKING:  # the command line keeps nothing
    from worker.answers.tables import StoredTable

Decimal = str
"""A decimal string with `digits` significant digits."""


def _without_null(schema: dict[str, Any]) -> None:
    """Describe a field that may be missing but is never null."""
    del schema["default"]
    [given] = [part for part in schema.pop("anyOf") if part != {"type": "null"}]
    schema.update({key: value for key, value in given.items() if key not in schema})


def optional(description: str | None = None) -> Any:
    """Returns a field that may be missing."""
    return Field(default=None, description=description, json_schema_extra=_without_null)


class GeometryText(Model):
    """The geometry in its canonical form: each number as a terminating decimal, otherwise as
    p/q."""

    model_config = ConfigDict(extra="forbid")

    a2x: str
    a3x: str
    a3y: str
    d1: str
    d2: str
    d3: str
    orientation: Literal["ccw", "cw"]


class TrianglesText(Model):
    """The canonical form of a geometry whose six numbers in the frame of the article are not all rational:
    each side as a terminating decimal or p/q, or `sqrt(…)` of one.

    Attributes:
        base: The sides A1A2, A2A3 and A3A1.
        base_orientation: Whether A1, A2, A3 run counter-clockwise or clockwise.
        platform: The sides B1B2, B2B3 and B3B1.
        platform_orientation: Whether B1, B2, B3 run counter-clockwise or clockwise.
    """

    model_config = ConfigDict(extra="forbid")

    base: list[str] = Field(min_length=3, max_length=3, examples=[["10", "10", "10"]])
    base_orientation: Literal["ccw", "cw"]
    platform: list[str] = Field(min_length=3, max_length=3, examples=[["sqrt(3)", "sqrt(3)", "sqrt(3)"]])
    platform_orientation: Literal["ccw", "cw"]


CanonicalGeometry: TypeAlias = GeometryText | TrianglesText
"""The canonical form of a geometry."""


class Point(Model):
    """A point of a slice: the platform's orientation, the angle of the fixed leg and the lengths of the
    other two legs (theta1_deg, l2, l3 with `fixed_leg` 1)."""

    alpha_deg: Decimal | None = optional("Orientation of the platform, degrees in (−180, 180].")
    theta1_deg: Decimal | None = optional("Angle of leg 1, degrees in (−180, 180].")
    theta2_deg: Decimal | None = optional("Angle of leg 2, with `fixed_leg` 2.")
    theta3_deg: Decimal | None = optional("Angle of leg 3, with `fixed_leg` 3.")
    l1: Decimal | None = optional("Length of leg 1, in the unit of the geometry.")
    l2: Decimal | None = optional("Length of leg 2, in the unit of the geometry.")
    l3: Decimal | None = optional("Length of leg 3, in the unit of the geometry.")


class FixedLength(Model):
    """The length of the fixed leg."""

    l1: Decimal | None = optional("The fixed length, with `fixed_leg` 1.")
    l2: Decimal | None = optional("The fixed length, with `fixed_leg` 2.")
    l3: Decimal | None = optional("The fixed length, with `fixed_leg` 3.")


class Cusp(Point):
    """A cusp of the slice."""


class TransitionEvent(Detail, Point):
    """A degenerate pose at the length of a transition."""

    kind: str = Field(description="For example swallowtail, lips, beak-to-beak.")


class Degeneracy(Model):
    """Degenerate poses in every slice of a range of lengths, or a whole curve of degenerate poses.

    Attributes:
        kind: The kind of the poses, such as `node` or `quadruple`; `curve` for a curve.
        start: The lower end of the interval.
        stop: Its upper end, null if it is open; equal to `from` for a single length.
        count: The number of such poses in each slice; missing for a curve.
        equation: The exact equation of a curve, unless it is at one irrational length.
    """

    kind: str
    start: str = Field(alias="from")
    stop: str | None = Field(alias="to")
    count: int | None = optional()
    equation: str | None = optional()


DEGENERATE: Any = Field(
    description="What is degenerate in every slice of a range of lengths, or along a whole curve of poses "
    "of a slice, as for flat or congruent triangles: curves, then poses by range. Usually empty."
)
"""The field of documents over a range of lengths."""


class ClosedRange(Model):
    """The requested range."""

    start: str = Field(alias="from")
    stop: str | None = Field(alias="to", description="null: no upper end.")


class NearShape(Model):
    """A special shape that a geometry nearly has.

    Attributes:
        shape: Its name.
        distance: The least fraction by which sides have to change, to two digits.
        says: What holds for the exact shape.
        spelling: The exact shape, as a geometry of a question.
        effect: `contradicts`: the answer for the exact shape is another one. `weakens`: some of its cusps or
            poses are not there, or are degenerate. `harmless`: it has the same cusps, up to small changes.
    """

    shape: Literal["similar", "congruent", "mirrored", "isosceles", "right isosceles", "equilateral", "flat"]
    distance: str
    says: str
    spelling: dict[str, Any]
    effect: Literal["contradicts", "weakens", "harmless"]


NEAR: Any = optional(
    "Special shapes within 1/1000 of the geometry that it has not got; missing if there are none."
)
"""The field of all documents about a geometry."""


class DocumentHead(Model):
    """The manipulator, the fixed leg and the precision of a document."""

    geometry: CanonicalGeometry
    geometry_hash: str
    near: list[NearShape] | None = NEAR
    fixed_leg: Literal[1, 2, 3]
    digits: int
    solver_version: str


class Interval(ClosedRange):
    """A window, an interval without transitions; all its slices have the same number of cusps."""

    count: int


class FieldError(Model):
    """An invalid field."""

    field: str = Field(description="The dotted name of the field, for example geometry.d1.")
    pointer: str | None = optional("The JSON pointer to it (RFC 6901), if it is in the body: /geometry/d1.")
    message: str = Field(description="The error, and a valid alternative.")


class LimitInfo(Model):
    """The limit that was exceeded."""

    name: str
    value: float


class ProblemDocument(Model):
    """An error (RFC 9457)."""

    model_config = ConfigDict(extra="allow", title="Problem")

    type: str = Field(description="Identifies the type of problem; the URL documents it.")
    title: str
    status: int
    detail: str
    errors: list[FieldError]
    instance: str | None = optional("The path of the request.")
    limit: LimitInfo | None = optional("Present if a limit was exceeded.")
    job: str | None = optional("The job concerned.")


_PIECE = 64 << 10
SHARED = ("geometry_hash", "near", "fixed_leg", "digits", "solver_version")
"""The members of a table that each line of NDJSON has."""


def compact(document: object) -> str:
    """Returns a document as compact JSON."""
    return json.dumps(document, separators=(",", ":"), ensure_ascii=False)


def ascii_bytes(document: object) -> bytes:
    """Returns compact JSON in ASCII, for text of a client that may not be encodable as UTF-8."""
    return json.dumps(document, separators=(",", ":")).encode("ascii")


def ndjson_line(table: Mapping[str, Any], part: Mapping[str, Any]) -> str:
    """Returns a slice as a line of NDJSON, with what identifies the table."""
    return compact({**{key: table[key] for key in SHARED if key in table}, **part}) + "\n"


def csv_header(table: Mapping[str, Any]) -> str:
    """Returns the first line of a table's CSV."""
    return rpr_solver.table_csv({**table, "slices": []})


def csv_lines(table: Mapping[str, Any], part: Mapping[str, Any]) -> str:
    """Returns the lines of one slice in a table's CSV."""
    return rpr_solver.table_csv({**table, "slices": [part]}).partition("\n")[2]


def json_bytes(document: object) -> bytes:
    """Returns a document as compact JSON, which is how it is kept."""
    return document.text if isinstance(document, Kept) else compact(document).encode()


def ndjson_bytes(table: Mapping[str, Any]) -> bytes:
    """Returns the slices of a table, one JSON object per line, each with the head of the table."""
    return b"".join(ndjson_line(table, part).encode() for part in table["slices"])


def json_pieces(table: StoredTable) -> Iterator[bytes]:
    """Yields a table as compact JSON."""
    before = _json_start(table)
    for batch in table.batches():
        yield before + b",".join(batch)
        before = b","
    yield b"]}"


def json_size(table: StoredTable) -> int:
    """Returns the size of a table as compact JSON."""
    return len(_json_start(table)) + table.size + len(table.slices) - 1 + len(b"]}")


def ndjson_pieces(table: StoredTable) -> Iterator[bytes]:
    """Yields a table as lines of JSON."""
    start = _line_start(table)
    for batch in table.batches():
        yield b"".join(start + text[1:] + b"\n" for text in batch)


def ndjson_size(table: StoredTable) -> int:
    """Returns the size of a table as lines of JSON."""
    return table.size + len(table.slices) * len(_line_start(table))


def csv_pieces(table: StoredTable) -> Iterator[bytes]:
    """Yields a table as CSV."""
    for number, batch in enumerate(table.batches()):
        lines = rpr_solver.table_csv({**table.head, "slices": [json.loads(text) for text in batch]})
        yield (lines.partition("\n")[2] if number else lines).encode()


def _json_start(table: StoredTable) -> bytes:
    return json_bytes(table.head)[:-1] + b',"slices":['


def _line_start(table: StoredTable) -> bytes:
    return json_bytes({key: table.head[key] for key in SHARED if key in table.head})[:-1] + b","


def joined(pieces: Iterable[bytes]) -> Iterator[bytes]:
    """Yields pieces together, in pieces of a useful size."""
    held = bytearray()
    for piece in pieces:
        held += piece
        if len(held) >= _PIECE:
            yield bytes(held)
            held.clear()
    if held:
        yield bytes(held)


JSON = "application/json"
CSV = "text/csv"
NDJSON = "application/x-ndjson"
SVG = "image/svg+xml"

FORMATS = {"json": JSON, "csv": CSV, "ndjson": NDJSON, "svg": SVG}
"""Names of forms, as queries and the command line give them."""


def _no_pieces(_table: StoredTable) -> Iterator[bytes]:
    raise TypeError("only cusp tables are sent piece by piece")


def _no_size(_table: StoredTable) -> None:
    return None


@dataclass(frozen=True)
class Form:
    """The encoding of a document in one media type.

    Attributes:
        encode: returns a document in this form.
        description: in OpenAPI.
        pieces: yields a table that is read from the store in this form.
        size: returns the size of such a table in this form, if it is known beforehand.
    """

    encode: Callable[[Any], bytes]
    description: str = ""
    pieces: Callable[[StoredTable], Iterator[bytes]] = _no_pieces
    size: Callable[[StoredTable], int | None] = _no_size


Forms = Mapping[str, Form]
"""Media type → form of a document; the first is the default."""

JSON_FORM = Form(json_bytes, pieces=json_pieces, size=json_size)


def csv_form(writer: str, line: str) -> Form:
    """The form that a function of the solver writes; it is loaded when it is first used."""

    def written(document: Any) -> bytes:
        text: str = getattr(rpr_solver, writer)(document)
        return text.encode()

    return Form(written, f"A header line, then one line per {line}.")


def _drawn(document: Any) -> bytes:
    return draw(document).svg().encode()


PICTURE_FORM = Form(_drawn, "A picture of the answer.")


class Mover(FixedLength):
    """A transition that binds the first-order radius.

    Attributes:
        sensitivity: How fast its length changes with each length of the geometry; six digits, not proved.
    """

    kind: str
    sensitivity: dict[str, str]


class FirstOrder(Detail):
    """An estimate, no bound: the radius at which transitions would break the property if they moved
    linearly."""

    radius: str
    binding: list[Mover]


class Counterexample(Detail):
    """An exact geometry that does not have the property."""

    radius: str = Field(description="The largest |change|/weight of its lengths.")
    geometry: GeometryText
    count: int | None = Field(description="The number of cusps there; null for a window.")
    l1: str | None = optional("The length of leg 1 of a slice that shows it, exact; null for a window.")
    l2: str | None = optional("The same, with `fixed_leg` 2.")
    l3: str | None = optional("The same, with `fixed_leg` 3.")


class MarginCertificate(Detail):
    """How the proved radius is proved."""

    model_config = ConfigDict(extra="allow")

    method: str
    boxes: int = Field(description="The number of boxes of poses and geometries that were examined.")
    arithmetic: str
