"""Requirements on the number of cusps over a range of lengths, within joint limits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from fractions import Fraction
from typing import Any, TypeVar

from rpr_solver.contract import check_integer, check_leg
from rpr_solver.errors import FieldProblem, InputError, shown
from rpr_solver.exact.rationals import MAX_DIGITS, Exact, exact_str, parse_exact, parse_not_negative
from rpr_solver.model.lengths import Bounds, ExactLimits, LengthRange, limits_json, read_limits

ALLOWED, REFUSED = "allowed", "refused"
REQUIRED, EXCLUDED = "required", "excluded"

_T = TypeVar("_T")


@dataclass(frozen=True)
class Requirement:
    """Bounds on the number of cusps, strictly within joint limits, in every slice of a range.

    Args:
        fixed_leg: the leg whose length varies over the range, 1, 2 or 3.
        start: the lower end of the range, exact, in the user's unit like all lengths; 0 is an open end.
        stop: its upper end; None is an open end.
        max_cusps: the maximum number of cusps in any slice (0: none at all, which does not prove that the
            assembly mode cannot change), or None.
        min_cusps: the minimum number, or None. A single length at which cusps merge is not a violation.
        limits: the minimum and maximum lengths of the other legs, exact, None for an open end:
            ``{"l2": (5, "20.5"), "l3": (None, 30)}``, or with the legs' numbers as keys.
        degenerate: ``"refused"`` if nothing may be degenerate in all slices of an interval or along a whole
            curve of a slice, within the limits or not (see :class:`Degeneracy`); else ``"allowed"``.
        mode_change: ``"required"`` or ``"excluded"``: whether the assembly mode can change without a
            singularity while the fixed leg keeps the range, within the limits; the range then begins at a
            length > 0, and no number of cusps is needed. None: it does not matter.
        clearance: how far, in degrees, a change of assembly mode keeps from singular poses; 0: any does.
        ignore_windows: a width, exact: windows of slices with other numbers of cusps are ignored if they are
            narrower (:mod:`rpr_solver.transitions.windows`); 0 ignores none.

    Raises:
        InputError: naming every field at fault, such as ``requirement.max_cusps``.

    >>> Requirement(start=28, stop="31", max_cusps=8, limits={"l2": (5, None)})
    Requirement(fixed_leg=1, start='28', stop='31', max_cusps=8, limits={'l2': ('5', None)})
    >>> Requirement(max_cusps=8, min_cusps=9)
    Traceback (most recent call last):
    rpr_solver.errors.InputError: requirement.max_cusps: is 8, less than min_cusps = 9; ...
    """

    fixed_leg: int = 1
    start: Fraction = Fraction(0)
    stop: Fraction | None = None
    max_cusps: int | None = None
    min_cusps: int | None = None
    limits: Mapping[int, Bounds] = field(default_factory=dict)
    degenerate: str = ALLOWED
    mode_change: str | None = None
    ignore_windows: Fraction = Fraction(0)
    clearance: Fraction = Fraction(0)

    def __init__(
        self,
        fixed_leg: int = 1,
        start: Exact = Fraction(0),
        stop: Exact | None = None,
        max_cusps: int | None = None,
        min_cusps: int | None = None,
        limits: ExactLimits | None = None,
        degenerate: str = ALLOWED,
        mode_change: str | None = None,
        ignore_windows: Exact = Fraction(0),
        clearance: Exact = Fraction(0),
    ) -> None:
        leg = check_leg(fixed_leg, "requirement.fixed_leg")
        problems: list[FieldProblem] = []

        def read(read_one: Callable[[], _T]) -> _T | None:
            try:
                return read_one()
            except InputError as error:
                problems.extend(error.problems)
                return None

        span = read(lambda: LengthRange.of(start, stop, ("requirement.start", "requirement.stop")))
        most = read(lambda: _count(max_cusps, "requirement.max_cusps"))
        least = read(lambda: _count(min_cusps, "requirement.min_cusps"))
        bounds = read(lambda: read_limits({} if limits is None else limits, "requirement.limits", leg))
        narrow = read(lambda: parse_not_negative(ignore_windows, "requirement.ignore_windows"))
        wide = read(lambda: parse_not_negative(clearance, "requirement.clearance"))
        if wide and mode_change is None:
            text = "is for changes of assembly mode; give mode_change, too"
            problems.append(FieldProblem("requirement.clearance", text))
        if max_cusps is None and min_cusps is None and mode_change is None:
            problems.append(FieldProblem("requirement.max_cusps", "is missing; give max_cusps or min_cusps"))
        if most is not None and least is not None and most < least:
            problems += [
                FieldProblem("requirement.max_cusps", f"is {most}, less than min_cusps = {least}"),
                FieldProblem("requirement.min_cusps", f"is {least}, more than max_cusps = {most}"),
            ]
        if degenerate not in (ALLOWED, REFUSED):
            words = f"is {shown(degenerate)}; it must be {ALLOWED} or {REFUSED}"
            problems.append(FieldProblem("requirement.degenerate", words))
        problems += _of_mode_change(mode_change, span)
        if problems or span is None or bounds is None:
            raise InputError(problems)
        values = (leg, span.start, span.stop, most, least, bounds, degenerate, mode_change, narrow, wide)
        for own, value in zip(fields(self), values, strict=True):
            object.__setattr__(self, own.name, value)

    def __repr__(self) -> str:
        document = self.to_json()
        ends, limits, degenerate = (document.pop(name) for name in ("range", "limits", "degenerate"))
        arguments = {
            "fixed_leg": self.fixed_leg,
            "start": ends["from"],
            "stop": ends["to"],
            **document,
            "limits": {leg: (bounds["min"], bounds["max"]) for leg, bounds in limits.items()},
            "degenerate": None if degenerate == ALLOWED else degenerate,
        }
        values = (f"{name}={value!r}" for name, value in arguments.items() if value not in (None, {}))
        return f"Requirement({', '.join(values)})"

    @property
    def range(self) -> LengthRange:
        """The range of lengths of the fixed leg."""
        return LengthRange(self.start, self.stop)

    @classmethod
    def from_json(cls, obj: Mapping[str, Any], *, max_digits: int = MAX_DIGITS) -> Requirement:
        """The inverse of :meth:`to_json`; a part that is missing has its default.

        Raises:
            InputError: naming every field at fault, as the constructor.
        """

        def numbers(part: Mapping[str, Any], name: str, *keys: str) -> Iterator[Fraction | None]:
            for key in keys:
                text = part.get(key)
                field = f"requirement.{name}.{key}".rstrip(".")
                yield None if text is None else parse_exact(text, field, max_digits=max_digits)

        start, stop = numbers(obj.get("range") or {}, "range", "from", "to")
        limits = {
            leg: tuple(numbers(bounds, f"limits.{leg}", "min", "max"))
            for leg, bounds in (obj.get("limits") or {}).items()
        }
        counts = obj.get("max_cusps"), obj.get("min_cusps")
        [narrow] = numbers({"": obj.get("ignore_windows")}, "ignore_windows", "")
        [wide] = numbers({"": obj.get("clearance")}, "clearance", "")
        last = limits, obj.get("degenerate", ALLOWED), obj.get("mode_change"), narrow or 0, wide or 0
        return cls(obj.get("fixed_leg", 1), start or 0, stop, *counts, *last)  # type: ignore[arg-type]

    def to_json(self) -> dict[str, Any]:
        """The requirement of a check document, with numbers in canonical text."""

        return {
            "fixed_leg": self.fixed_leg,
            "range": self.range.to_json(),
            "max_cusps": self.max_cusps,
            "min_cusps": self.min_cusps,
            "limits": limits_json(self.limits),
            "degenerate": self.degenerate,
            **({} if self.mode_change is None else {"mode_change": self.mode_change}),
            **({"clearance": exact_str(self.clearance)} if self.clearance else {}),
            **({"ignore_windows": exact_str(self.ignore_windows)} if self.ignore_windows else {}),
        }

    def of_cusps_alone(self) -> Requirement:
        """The requirement itself.

        Raises:
            InputError: it is about changes of assembly mode, too.
        """
        if self.mode_change is not None:
            raise InputError.of("requirement.mode_change", "is for checks alone")
        return self

    def counts_alone(self) -> Requirement | None:
        """The same without changes of assembly mode; None if it bounds no numbers of cusps."""
        if self.max_cusps is None and self.min_cusps is None:
            return None
        kept = {name: x for name, x in self.to_json().items() if name not in ("mode_change", "clearance")}
        return Requirement.from_json(kept, max_digits=1 << 20)

    def ignoring(self, width: Fraction) -> Requirement:
        """The same requirement, which ignores windows that are narrower than a width."""
        changed = {**self.to_json(), "ignore_windows": exact_str(width)}
        return Requirement.from_json(changed, max_digits=1 << 20)

    def admits(self, count: int) -> bool:
        """Whether a slice may have this number of cusps within the limits."""
        return (self.max_cusps is None or count <= self.max_cusps) and (
            self.min_cusps is None or count >= self.min_cusps
        )


def _of_mode_change(word: str | None, span: LengthRange | None) -> Iterator[FieldProblem]:
    """What is wrong about the assembly mode."""
    if word not in (None, REQUIRED, EXCLUDED):
        yield FieldProblem(
            "requirement.mode_change", f"is {shown(word)}; it must be {REQUIRED} or {EXCLUDED}"
        )
    elif word is not None and span is not None and not span.start:
        text = "needs a range from a length > 0; it begins at 0"
        yield FieldProblem("requirement.mode_change", text)


def _count(value: int | None, field: str) -> int | None:
    return None if value is None else check_integer(value, field, "a number of cusps, at least 0", 0)
