"""The outcomes of checks as a JSON document and as a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Context, Decimal
from fractions import Fraction
from typing import Any

from rpr_solver import EXAMPLES
from rpr_solver.contract import LEGS
from rpr_solver.margins.options import OPEN
from rpr_solver.notebook import counted, degenerate_words, near_words
from rpr_solver.transitions.requirement import EXCLUDED, REFUSED, REQUIRED
from service.cli.arguments import Found, Geometry, listed
from service.cli.pages import Page, Section, all_legs, counted_range, tolerance_words
from service.cli.parsers import STANDARD_INPUT

_DIGITS = 6
_CHANGES = {REQUIRED: "possible", EXCLUDED: "impossible"}
_PLAIN = 15
"""The largest number of places for which numbers are written without an exponent."""


@dataclass(frozen=True)
class Outcome:
    """The report on one geometry, or the error in its place.

    Attributes:
        source: the name of the file, a built-in name, or `-`.
        report: the report; empty if there is an error.
        error: a type ("input-error", "solver-error", …) and a detail.
        seconds: how long it took.
        line: the line of the file to look at, if it is a file.
        notes: the name and the unit that the geometry gives.
        shown: the report as a reader sees it, if that differs.
    """

    source: str
    report: Mapping[str, Any] = field(default_factory=dict)
    error: Mapping[str, str] | None = None
    seconds: float = 0.0
    line: int | None = None
    notes: Mapping[str, str] = field(default_factory=dict)
    shown: Mapping[str, Any] | None = None

    @classmethod
    def of(
        cls,
        geometry: Geometry,
        report: Mapping[str, Any] | None = None,
        error: Mapping[str, str] | None = None,
        shown: Mapping[str, Any] | None = None,
        *,
        seconds: float = 0.0,
    ) -> Outcome:
        """The outcome of a geometry."""
        return cls(geometry.source, report or {}, error, seconds, geometry.line, geometry.notes, shown)

    @property
    def name(self) -> str:
        """The source as messages name it, with what the geometry says about itself."""
        source = "standard input" if self.source == STANDARD_INPUT else self.source
        words = ["".join(c if c.isprintable() else " " for c in text).split() for text in self.notes.values()]
        shown = ", ".join(" ".join(part) for part in words if part)
        return f"{source} ({shown})" if shown else source

    @property
    def is_file(self) -> bool:
        """Whether the source is a file."""
        return self.source != STANDARD_INPUT and self.source not in EXAMPLES

    @property
    def passed(self) -> bool:
        """Whether the requirement is proved."""
        return bool(self.report.get("passed"))

    @property
    def is_bad(self) -> bool:
        """Whether there is no geometry to check."""
        return self.error is not None and self.error["type"] == "input-error"

    @property
    def is_open(self) -> bool:
        """Whether the requirement is neither proved nor refuted within the tolerance."""
        return self.margin.get("verdict") == OPEN

    @property
    def counterexample(self) -> Mapping[str, Any] | None:
        """A geometry within the tolerance that does not satisfy the requirement, if one was found."""
        return self.margin.get("counterexample")

    @property
    def margin(self) -> Mapping[str, Any]:
        """What the report says of a tolerance; empty without one."""
        margin: Mapping[str, Any] = self.report.get("margin", {})
        return margin

    @property
    def verdict(self) -> str:
        """One or two words."""
        if self.passed:
            return "passed"
        if self.is_open:
            return "open"
        return "failed" if self.error is None else "bad input" if self.is_bad else "no answer"

    @property
    def message(self) -> str:
        """One line on the failure: the first offending slice and its first cusp, with six digits, or the
        error."""
        if self.error is not None:
            return " ".join(self.error["detail"].split())
        if self.passed:
            return ""
        if self.counterexample is not None:
            return f"{_fails(self.counterexample)}; {_demand(self.report['requirement'])}"
        if self.is_open:
            return f"neither proved nor refuted within the tolerance: {self.margin['reason']}"
        if not self.report["violations"] and self._mode_change:
            return self._mode_change
        if not self.report["violations"]:
            return f"degenerate, which is refused: {'; '.join(self.degenerate)}"
        first = self.report["violations"][0]
        leg = f"l{self.report['requirement']['fixed_leg']}"
        count = counted(first["count"], "cusp")
        length = inside(first["example"][leg], first.get("from"), first.get("to"))
        text = f"{count} at {leg.upper()} = {length}, {_demand(self.report['requirement'])}"
        if cusps := first["example"]["cusps"]:
            text += "; the first: " + ", ".join(f"{key} = {short(value)}" for key, value in cusps[0].items())
        return text

    @property
    def _mode_change(self) -> str:
        """What is wrong about changes of assembly mode; empty if nothing is."""
        found, demand = self.report.get("mode_change"), self.report["requirement"].get("mode_change")
        if found is None or found["change"] == _CHANGES[demand]:
            return ""
        text = f"a change of assembly mode is {found['change']}, and {demand}"
        if found["witness"] is not None:
            kept = found["witness"]["path"]["clearance"]["proved"]
            text += f", {short(kept)} degrees off singular poses"
            ends = f"from pose {found['witness']['from']} to pose {found['witness']['to']}"
            return f"{text}; {ends} of {all_legs(found['witness'])}"
        return text if found["reason"] is None else f"{text}: {found['reason']}"

    @property
    def degenerate(self) -> list[str]:
        """What is degenerate throughout, a line for each."""
        found = self.report.get("degenerate", ())
        return [degenerate_words(part, self.report["requirement"]["fixed_leg"]) for part in found]

    @property
    def ignored(self) -> list[str]:
        """The windows that are ignored, a line for each."""
        found = self.report.get("ignored_windows", ())
        return [ignored_words(window, self.report["requirement"]["fixed_leg"]) for window in found]

    @property
    def witness(self) -> list[str]:
        """How clear the change of assembly mode is that was found, if one was."""
        found = self.report.get("mode_change")
        if found is None or found["witness"] is None:
            return []
        kept = short(found["witness"]["path"]["clearance"]["proved"])
        return [f"by a path that keeps at least {kept} degrees off singular poses"]

    @property
    def near(self) -> str:
        """The line about a special shape that contradicts or weakens the report; empty without one."""
        return near_words(self.report)

    @property
    def remarks(self) -> list[str]:
        """What is degenerate throughout, although the requirement allows it."""
        is_refused = self.report.get("requirement", {}).get("degenerate") == REFUSED
        return [] if is_refused else self.degenerate

    def rows(self, *, shorten: bool = False) -> Iterator[list[str]]:
        """Yields what violates the requirement as a table, its headings first; the ends of an interval differ
        even if they are shortened."""
        if self.counterexample is not None:
            geometry = self.counterexample["geometry"]
            yield list(geometry)
            yield list(map(str, geometry.values()))
        violations = (self.shown or self.report).get("violations")
        if not violations:
            return
        leg = f"l{self.report['requirement']['fixed_leg']}"
        if leg in violations[0]:
            yield [leg.upper(), "cusps"]
            yield from ([part[leg], str(part["count"])] for part in violations)
            return
        yield ["from", "to", "cusps"]
        ends = [(part["from"], part["to"]) for part in violations]
        texts = _shortened(ends) if shorten else {}
        for (start, stop), part in zip(ends, violations, strict=True):
            yield [texts.get(start) or start, texts.get(stop) or stop or "∞", str(part["count"])]

    def to_json(self) -> dict[str, object]:
        """Returns the report, or the error, with the name of the geometry."""
        verdict = {"source": self.source, **self.notes, "passed": self.passed}
        return {**verdict, "report": self.report} if self.error is None else {**verdict, "error": self.error}


def short(text: str, digits: int = _DIGITS) -> str:
    """Returns a number with at most this number of significant digits, without an exponent unless it is long.

    >>> short("426/25"), short("-69.1293760614882"), short("10.00"), short("1e-30")
    ('17.04', '-69.1294', '10', '1e-30')
    """
    x, context = Fraction(text), Context(prec=digits)
    value = context.divide(Decimal(x.numerator), Decimal(x.denominator)).normalize(context)
    is_plain = value.is_zero() or -_PLAIN < value.adjusted() < _PLAIN
    return f"{value:f}" if is_plain else str(value).lower()


def ignored_words(window: Mapping[str, Any], fixed_leg: int) -> str:
    """Returns one line on a window that is ignored.

    >>> ends = {"from": "10.9056632492710", "to": "10.9056666270906"}
    >>> ignored_words({**ends, "width": "0.00000337782", "counts": [8]}, 1)
    '8 cusps for L1 from 10.9056632 to 10.9056666, 0.00000337782 wide'
    """
    *others, last = window["counts"]
    start, stop = apart(window["from"], window["to"])
    cusps = ", ".join([*map(str, others), counted(last, "cusp")])
    return f"{cusps} for L{fixed_leg} from {start} to {stop}, {window['width']} wide"


def apart(low: str, high: str | None) -> tuple[str, str | None]:
    """Returns the ends of an interval in as few digits as show its width to a tenth.

    >>> apart("10", "14.5792206267995"), apart("10.9056632492710", "10.9056666270906")
    (('10', '14.5792'), ('10.9056632', '10.9056666'))
    """
    if high is None:
        return short(low), None
    width = Fraction(high) - Fraction(low)
    for digits in range(_DIGITS, max(len(low), len(high), _DIGITS) + 1):
        ends = short(low, digits), short(high, digits)
        if abs(Fraction(ends[1]) - Fraction(ends[0]) - width) <= width / 10:
            return ends
    return low, high


def _shortened(ends: Sequence[tuple[str, str | None]]) -> dict[str | None, str | None]:
    """Returns the ends of intervals, each in the digits that the narrowest interval at it needs."""
    texts: dict[str | None, str | None] = {}
    for pair in ends:
        for end, text in zip(pair, apart(*pair), strict=True):
            texts[end] = max(texts.get(end) or "", text or "", key=len)
    return texts


def inside(text: str, low: str | None, high: str | None) -> str:
    """Returns a length in as few digits as keep it inside an interval, if there is one.

    >>> inside("10.905664", "10.9056632492710", "10.9056666270906"), inside("749/50", None, None)
    ('10.905664', '14.98')
    """
    for digits in range(_DIGITS, max(len(text), _DIGITS) + 1):
        number = Fraction(shown := short(text, digits))
        if (low is None or Fraction(low) < number) and (high is None or number < Fraction(high)):
            return shown
    return text


def document(outcomes: Sequence[Outcome], requirement: Mapping[str, Any], found: Found) -> dict[str, object]:
    """Returns all outcomes as one JSON document, with what was found."""
    return {
        "passed": all(outcome.passed for outcome in outcomes),
        "requirement": requirement,
        "checks": [outcome.to_json() for outcome in outcomes],
        "files": found.files,
        "ignored": list(found.ignored),
    }


def page(outcomes: Sequence[Outcome], requirement: Mapping[str, Any], found: Found) -> Page:
    """Returns all outcomes as a page."""
    sections = []
    for outcome in outcomes:
        notes = [f"ignored: {words}" for words in outcome.ignored]
        notes += [f"mode change: {words}" for words in outcome.witness]
        notes += [f"degenerate: {words}" for words in outcome.degenerate]
        if outcome.passed:
            within = ", within the tolerance too" if outcome.margin else ""
            counts = outcome.report["min_cusps_found"], outcome.report["max_cusps_found"]
            title = f"{outcome.name}: passed, {counted_range(*counts, 'cusp')}{within}"
            sections.append(Section(title, notes=notes))
            continue
        title = f"{outcome.name}: {outcome.verdict}: {outcome.message}"
        sections.append(Section(title, list(outcome.rows()), notes, failed=True))
    near = [f"{outcome.name}: {outcome.near}" for outcome in outcomes if outcome.near]
    return Page(about(requirement), sections, last=summary(outcomes, found), first=near)


def summary(outcomes: Sequence[Outcome], found: Found) -> str:
    """Returns a line such as "27 checked: 11 passed, 14 failed, 2 bad", and what was read."""
    bad = sum(outcome.is_bad for outcome in outcomes)
    without = sum(outcome.error is not None for outcome in outcomes) - bad
    passed = sum(outcome.passed for outcome in outcomes)
    undecided = sum(outcome.is_open for outcome in outcomes)
    parts = [f"{passed} passed", f"{len(outcomes) - passed - undecided - bad - without} failed"]
    others = ((undecided, "open"), (bad, "bad"), (without, "without an answer"))
    parts += [f"{count} {what}" for count, what in others if count]
    read = f"; {counted(found.files, 'file')} read" if found.files else ""
    if found.ignored:
        read += f", {len(found.ignored)} ignored without a geometry: {listed(found.ignored)}"
    return f"{len(outcomes)} checked: {', '.join(parts)}{read}"


def about(requirement: Mapping[str, Any]) -> str:
    """Returns the line that describes a requirement."""
    leg = requirement["fixed_leg"]
    last = ", nothing degenerate" if requirement.get("degenerate") == REFUSED else ""
    if (narrow := requirement.get("ignore_windows")) is not None:
        last += f", windows narrower than {narrow} ignored"
    last += f", with {tolerance_words(requirement['tolerance'])}" if "tolerance" in requirement else ""
    if "expect_cusps" in requirement:
        return f"cusps at L{leg} = {', '.join(requirement[f'l{leg}'])}: {_demand(requirement)}{last}"
    ends = requirement["range"]
    upper = "" if ends["to"] is None else f" up to {ends['to']}"
    limits = "".join(
        f", {key.upper()} within {bounds['min'] or 0}:{bounds['max'] or ''}"
        for key, bounds in requirement["limits"].items()
    )
    return f"cusps for L{leg} from {ends['from']}{upper}{limits}: {_demand(requirement)}{last}"


def _fails(example: Mapping[str, Any]) -> str:
    """What a counter-example shows."""
    at = "".join(f" at {name.upper()} = {example[name]}" for name in LEGS if name in example)
    lengths = (f"{name} = {x}" for name, x in example["geometry"].items() if name != "orientation")
    return f"{counted(example['count'], 'cusp')}{at} within the tolerance, for {', '.join(lengths)}"


def _demand(requirement: Mapping[str, Any]) -> str:
    if "expect_cusps" in requirement:
        return f"{requirement['expect_cusps']} expected"
    bounds = {"at most": requirement["max_cusps"], "at least": requirement["min_cusps"]}
    if (change := requirement.get("mode_change")) is not None:
        counts = {**requirement, "mode_change": None}
        also = "" if bounds == dict.fromkeys(bounds) else f"{_demand(counts)}, "
        wide = requirement.get("clearance")
        off = "" if wide is None else f", {wide} degrees off singular poses"
        return f"{also}change of assembly mode {change}{off}"
    if requirement["max_cusps"] == requirement["min_cusps"]:
        return f"{requirement['max_cusps']} required"
    demand = " and ".join(f"{words} {bound}" for words, bound in bounds.items() if bound is not None)
    return f"{demand} {'allowed' if requirement['min_cusps'] is None else 'required'}"
