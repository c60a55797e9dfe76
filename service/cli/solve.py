"""`rpr-cusps solve`: read a geometry, have its slices solved here or by a service, print the table."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import rpr_solver
from rpr_solver import EXAMPLES, Manipulator, exact_str
from rpr_solver.article.audit import article_document
from rpr_solver.errors import InputError, SolverError
from service.cli.pages import Progress, failures, write_table
from service.client import ServiceClient
from service.schemas.exact_json import JsonError, JsonNumber, parse_json
from service.schemas.lengths import check_count, distinct, parse_range
from service.schemas.limits import Limits
from service.schemas.numbers import digits_in_range, fixed_leg, geometry, number, whole
from service.schemas.table_requests import ARTICLE, METHODS, read_method

MAX_LOCAL_SLICES = 1_000_000

OnProgress = Callable[[int, int], None]


def solve(
    source: str,
    slices: Sequence[tuple[str, str]],
    digits: str | None,
    leg: str,
    form: str,
    url: str | None,
    method: str = METHODS[0],
) -> int:
    """Run the command; returns the exit status.

    Raises:
        InputError: naming the option or the field at fault.
        ServiceError: the service cannot be reached, or refused.
    """
    limits = Limits(max_slices=MAX_LOCAL_SLICES)
    chosen = fixed_leg(JsonNumber(leg))
    wanted = slice_values(slices, chosen, limits)
    read_method(method, chosen)
    count = limits.default_digits if digits is None else whole(JsonNumber(digits), "digits", "15 to 1000")
    count = digits_in_range(count, limits)
    manipulator = read_geometry(source, limits)
    with Progress(len(wanted)) as progress:
        if url is None and method == ARTICLE:
            table = article_document(manipulator, wanted, count, progress.update)
        elif url is None:
            table = solve_here(manipulator, wanted, chosen, count, progress.update)
        else:
            request = {
                "geometry": manipulator.to_json(),
                f"l{chosen}": [exact_str(x) for x in wanted],
                "digits": count,
                "fixed_leg": chosen,
                "method": method,
            }
            with ServiceClient(url) as client:
                table = client.cusp_table(request, progress.update)
    write_table(table, form)
    return report(table)


def solve_here(
    manipulator: Manipulator, wanted: Sequence[Fraction], leg: int, digits: int, on_progress: OnProgress
) -> dict[str, Any]:
    """Solve all slices in this process. A slice's failure is told in its place."""
    on_progress(0, len(wanted))
    eliminant = rpr_solver.eliminate(manipulator, leg)
    solved: list[dict[str, Any]] = []
    for value in wanted:
        try:
            found = rpr_solver.solve_slice(eliminant, value, digits).to_json()
        except InputError as error:
            found = rpr_solver.slice_error_json(value, leg, "input-error", str(error))
        except SolverError as error:
            found = rpr_solver.slice_error_json(value, leg, "solver-error", str(error))
        solved.append(found)
        on_progress(len(solved), len(wanted))
    return rpr_solver.table_json(manipulator, leg, digits, solved)


def read_geometry(source: str, limits: Limits) -> Manipulator:
    """A built-in manipulator, or the geometry in a JSON file or on standard input."""
    if source in EXAMPLES:
        return EXAMPLES[source]
    try:
        body = sys.stdin.buffer.read() if source == "-" else Path(source).read_bytes()
    except OSError as error:
        names = ", ".join(EXAMPLES)
        raise InputError.of(
            "GEOMETRY",
            f"{source!r} cannot be read ({error.strerror}); give a JSON file, -, or one of {names}",
        ) from None
    try:
        document = parse_json(body)
    except JsonError as error:
        raise InputError.of("GEOMETRY", f"in {source!r}: {error.detail}") from None
    return geometry(document, limits)


def slice_values(given: Sequence[tuple[str, str]], leg: int, limits: Limits) -> list[Fraction]:
    """The slices of the options `--l1` and `--l1-range`, in their order, each once."""
    name = f"l{leg}"
    if not given:
        raise InputError.of(f"--{name}", f"is missing; give a slice, for example --{name} 14.98")
    found: list[Fraction] = []
    for option, text in given:
        if not option.startswith(f"--{name}"):
            raise InputError.of(option, f"with --fixed-leg {leg} the slices are --{name}")
        if option.endswith("-range"):
            found += parse_range(text, option, limits.max_number_digits).values(limits.max_slices)
        else:
            found.append(number(text, option, limits))
        check_count(len(found), limits.max_slices, f"--{name}")
    return distinct(found)


def report(table: dict[str, Any]) -> int:
    """Say on stderr which slices have no answer; returns the exit status."""
    failed = failures(table)
    for where, error in failed:
        print(f"rpr-cusps solve: {where}: no answer ({error['type']}): {error['detail']}", file=sys.stderr)
    if not failed:
        return 0
    return 2 if any(error["type"] == "input-error" for _, error in failed) else 1
