"""The group Design and check, but for checks: margins, searches for a geometry, and an atlas of many random
ones."""

from __future__ import annotations

import argparse
import json
import signal
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import islice
from math import inf
from pathlib import Path
from typing import Annotated, Any

from rpr_solver import Progress
from rpr_solver.contract import MIN_DIGITS, letter
from rpr_solver.designs.plan import CANCELED, DEADLINE
from rpr_solver.errors import InputError, NotInstalledError
from rpr_solver.notebook import counted
from service.cli import arguments, asking, output, parsers
from service.cli.check.reports import ignored_words
from service.cli.output import progress_bar
from service.cli.pages import Page, Section, about, rows_of
from service.cli.parsers import Command
from service.schemas.numbers import whole_from
from service.schemas.questions import Question
from worker.answers import Store, answer, in_groups
from worker.answers.designs import Observer
from worker.process import usable_cores
from worker.process.executor import executor

PROVED, NOT_PROVED = 0, 1


def _margin(document: Mapping[str, Any]) -> Page:
    """Prove how far the lengths of a manipulator may change before the number of cusps of a slice does,
    before a requirement is violated, or before a window with a number of cusps vanishes. With --tolerance,
    decide whether a tolerance is small enough.

    The proof covers every geometry within the radius; a counter-example is an exact geometry that you can
    check. The first-order radius is an estimate, not a bound.

    Exit status: 0 proved (without a tolerance: a radius > 0), 1 refuted or open, 2 bad input.

    Options:
        l1: the slice whose number of cusps must not change
        requirement: or the range of a requirement; either end may be omitted
        window: or a length between two transitions: some slices must keep the number of cusps found there
        tolerance: how far all lengths may be off, or single ones, as d1=0.01,a3x=0.002; the others are exact
            then
        weights: how much each length may change relative to the others, as d1=2,a2x=0 (default: 1; 0: exact)

    examples:
      rpr-cusps margin innocenti --l1 28.1
      rpr-cusps margin innocenti --l1 28.1 --tolerance 0.0005
      rpr-cusps margin innocenti --l1 28.1 --tolerance d1=0.004,a3x=0.0002
      rpr-cusps margin robot.json --l1-range 21:26 --max-cusps 6 --weights a2x=0
      rpr-cusps margin innocenti --window 28.1 --tolerance 0.01
    """
    asked, leg = document["asked"], f"l{document['fixed_leg']}"
    count = document["count"]
    cusps = "the requirement" if count is None else counted(count, "cusp")
    place = f" at {leg.upper()} = {asked[leg]}" if leg in asked else ""
    place = f" in the window at {asked['window']}" if "window" in asked else place
    values = [("verdict", document["verdict"]), ("proved within", document["proved"])]
    values += [("why not more", document["reason"]), ("flat, or no manipulator, from", document["validity"])]
    first, example = document["first_order"], document["counterexample"]
    if first is not None:
        movers = ", ".join(f"{mover['kind']} at {mover[leg]}" for mover in first["binding"])
        values.append(("first order (an estimate)", f"{first['radius']}: {movers}"))
    if example is not None:
        values.append(("refuted at", example["radius"]))
    title = f"Margin of {cusps}{place}"
    if document["verdict"] is not None:
        title += "; radii: 1 = the tolerance"
    sections = [Section(title, [["", ""], *([name, text] for name, text in values if text is not None)])]
    if first is not None:
        rows = [{"transition": mover[leg], **mover["sensitivity"]} for mover in first["binding"]]
        sections.append(Section("Sensitivities of the transitions that bind it", rows_of(rows)))
    if example is not None:
        found = (
            "no length has as many cusps" if example["count"] is None else counted(example["count"], "cusp")
        )
        at = "" if example[leg] is None else f" at {leg.upper()} = {example[leg]}"
        sections.append(Section(f"Counter-example: {found}{at}", rows_of([example["geometry"]])))
    return Page(about(document), sections, document["digits"])


def _margin_status(document: Mapping[str, Any]) -> int:
    if document["verdict"] is None:
        return PROVED if document["proved"] not in (None, "0") else NOT_PROVED
    return PROVED if document["verdict"] == "proved" else NOT_PROVED


MET, NOT_MET = 0, 1


class _Stoppable(Observer):
    """The progress of a search that Ctrl-C or a deadline ends; a second Ctrl-C ends the command."""

    def __init__(self, report: Progress, end: float) -> None:
        super().__init__(report)
        self.end, self.is_canceled = end, False

    def cancel(self, *_: object) -> None:
        """Ask for the end."""
        self.is_canceled = True
        signal.signal(signal.SIGINT, signal.default_int_handler)
        print("proving the best found so far; Ctrl-C again ends at once", file=sys.stderr)

    def reason_to_stop(self) -> str | None:
        """Returns why the search must end, or None."""
        return CANCELED if self.is_canceled else DEADLINE if time.monotonic() > self.end else None


def _computed(question: Question) -> dict[str, Any]:
    end = inf if question.deadline_seconds is None else time.monotonic() + question.deadline_seconds
    with progress_bar(1, "censuses") as progress:
        stoppable = _Stoppable(progress, end)
        before = signal.signal(signal.SIGINT, stoppable.cancel)
        try:
            return answer(question.job_request(), Store(), stoppable)
        finally:
            signal.signal(signal.SIGINT, before)


def _design_page(document: Mapping[str, Any]) -> Page:
    """Search for a geometry whose cusps meet a goal: the longest range of lengths in which a
    requirement holds, the least change that meets it, the largest margin, or the most cusps.

    Every candidate is examined by an exact census, and the best one found is proved again, independently. A
    better one may exist. The search needs the extra design; in a copy of the repository: pip install -c
    constraints.txt '.[design]'.

    Ctrl-C, or --deadline, ends the search with the best geometry found so far, proved.

    Exit status: 0 the best geometry meets the goal, 1 it does not, 2 bad input.

    Options:
        objective: longest-range, least-change, largest-margin or most-cusps
        requirement: the range of lengths; either end may be omitted
        vary: how far lengths may change: 15% of each, or d1=16:18,a2x=15:17 alone (default: 10%)
        fixed: lengths that keep their values, as a2x,d1
        family: search symmetric geometries only: isosceles-1, isosceles-2, isosceles-3, similar, congruent or
            mirror
        seed: the seed of the random numbers (default: 1)

    examples:
      rpr-cusps design innocenti --objective longest-range --l1-range 5:30 --max-cusps 4 --vary 15% --fix a2x
      rpr-cusps design robot.json --objective least-change --l1-range 5:30 --max-cusps 6 --ignore-windows .001
      rpr-cusps design robot.json --objective most-cusps --family isosceles-1 --vary t1=0.05:3,d1=1:40,d2=1:70
    """
    best, start, asked = document["best"], document["start"], document["asked"]
    margin = best["margin"]
    values = [
        ("value", best["value"]),
        ("of the given geometry", start["value"]),
        ("met", "yes" if best["met"] else "no"),
        ("margin, proved", None if margin is None else margin["proved"]),
        *_kept(best.get("constraints"), asked["requirement"]["fixed_leg"]),
        ("geometries examined", f"{document['censuses']}; stopped: {document['stopped']}"),
    ]
    lengths = {name: x for name, x in best["geometry"].items() if name != "orientation"}
    change = {name: best["change"][name] for name in lengths}
    rows = [{"": "best found", **lengths}, {"": "change", **change}]
    trace = [{"census": one["census"], "value": one["value"], **one["geometry"]} for one in document["trace"]]
    shown = [["", ""], *([name, text] for name, text in values if text is not None)]
    leg, narrow = asked["requirement"]["fixed_leg"], best["check"].get("ignored_windows", ())
    notes = [f"ignored: {ignored_words(window, leg)}" for window in narrow]
    sections = [
        Section(f"Best found: {asked['objective']}", shown, notes),
        Section("Geometry", rows_of(rows)),
        Section("Improvements", rows_of(trace)),
    ]
    return Page(about(document), sections, document["digits"])


def _kept(kept: Mapping[str, Any] | None, leg: int) -> list[tuple[str, str | None]]:
    """What is proved of the constraints."""
    if kept is None:
        return []
    loop, least, most = kept["loop"], kept["min_aspects_found"], kept["max_aspects_found"]
    return [
        ("constraints kept", "yes" if kept["met"] else "no"),
        ("loop, proved", loop and f"round cusp {letter(loop['cusp'])} of L{leg} = {loop[f'l{leg}']}"),
        ("aspects", None if least is None else str(least) if least == most else f"{least} to {most}"),
    ]


_MOST, _MOST_SEED = 10_000_000, 2**63 - 1
_AT_ONCE = 200
_FEW, _AHEAD = 8, 4


def _configure_atlas(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Options:
        --count: the number of rows
        --seed: the seed of the random geometries (default: 1)
        --output: a name that ends in .ndjson or .parquet
    """
    parser.add_argument("--count", metavar="N", required=True)
    parser.add_argument("--seed", metavar="S", default="1")
    parser.add_argument("-o", "--output", metavar="FILE", required=True)
    parser.add_argument("--url", help=parsers.COMPUTED_BY)


def _run_atlas(args: argparse.Namespace) -> int:
    """Make an atlas: the censuses of many random manipulators as one row each, NDJSON or Parquet.

    The manipulator of a row depends only on the seed and the number of the row, so an atlas can be reproduced
    or extended. An interrupted command continues where it stopped when it is run again. Parquet needs the
    extra atlas; in a copy of the repository: pip install -c constraints.txt '.[atlas]'.

    examples:
      rpr-cusps atlas --count 2000 --seed 1 -o atlas.ndjson
      rpr-cusps atlas --count 2000 --seed 1 -o atlas.parquet --url http://127.0.0.1:8000
    """
    count = arguments.read_option(Annotated[int, whole_from(1, _MOST)], args.count, "--count")
    seed = arguments.read_option(Annotated[int, whole_from(0, _MOST_SEED)], args.seed, "--seed")
    target = Path(args.output)
    if target.suffix not in (".ndjson", ".parquet"):
        raise InputError.of("--output", f"{args.output!r} ends in neither .ndjson nor .parquet")
    rows_file = target if target.suffix == ".ndjson" else target.with_name(f"{target.name}.rows")
    write_parquet = None if rows_file == target else _parquet()
    done = kept_rows(rows_file, seed)
    missing = range(done, count)
    rows = _of_service(args.url, seed, missing) if args.url else _computed_rows(seed, missing)
    with rows_file.open("ab") as file, progress_bar(count, "rows") as progress:
        for number, row in enumerate(rows, done + 1):
            with output.unbroken():
                file.write(json.dumps(row, separators=(",", ":")).encode() + b"\n")
                file.flush()
            progress(number, count)
    if write_parquet is not None:
        write_parquet(rows_file, target, count)
        rows_file.unlink()
    return 0


def kept_rows(path: Path, seed: int) -> int:
    """Returns how many rows a file has; what was written of a last one only in part is cut off.

    Raises:
        InputError: a row of it is not of this atlas.
    """
    if not path.exists():
        return 0
    kept = number = 0
    with path.open("rb+") as file:
        for number, line in enumerate(file):
            if not line.endswith(b"\n"):
                file.truncate(kept)
                return number
            try:
                row = json.loads(line)
                is_own = (row["seed"], row["index"]) == (seed, number)
            except (ValueError, KeyError, TypeError):
                is_own = False
            if not is_own:
                fault = f"line {number + 1} of {str(path)!r} is not row {number} of the atlas of seed {seed}"
                raise InputError.of("--output", f"{fault}; give another name")
            kept += len(line)
    return number + 1 if kept else 0


def _computed_rows(seed: int, indices: Sequence[int]) -> Iterator[dict[str, Any]]:
    """Yields rows that are computed here, on all cores."""
    from rpr_solver.transitions.atlas import atlas_row

    if len(indices) < _FEW or usable_cores() == 1:
        yield from map(partial(atlas_row, seed), indices)
        return
    # no more at once than are soon needed, so that an interrupt has little to wait for
    with executor(usable_cores()) as pool:
        left = iter(indices)
        pending = [pool.submit(atlas_row, seed, k) for k in islice(left, _AHEAD * usable_cores())]
        while pending:
            yield pending.pop(0).result()
            pending += [pool.submit(atlas_row, seed, k) for k in islice(left, 1)]


def _of_service(url: str, seed: int, indices: Sequence[int]) -> Iterator[dict[str, Any]]:
    """Yields rows from the censuses of a service, asked for in batches."""
    from rpr_solver.transitions.atlas import atlas_geometry, failed_row, row_of
    from service.client import census

    with asking.client_of(url) as client:
        for part in in_groups(indices, _AT_ONCE):
            asked = [census(atlas_geometry(seed, k), digits=MIN_DIGITS) for k in part]
            for k, result in zip(part, client.ask_all(asked), strict=True):
                if result.answer is None:
                    yield failed_row(seed, k, result.reason)
                else:
                    yield row_of(seed, k, result.answer.document)


def _parquet() -> Any:
    """Returns what writes rows as Parquet.

    Raises:
        NotInstalledError: the extra is not installed.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise NotInstalledError("Parquet needs pyarrow", "atlas") from None
    lengths = pa.list_(pa.struct([("cusps", pa.int8()), ("length", pa.float64())]))
    texts = ("a2x", "a3x", "a3y", "d1", "d2", "d3", "orientation", "geometry_hash")
    columns = [("index", pa.int64()), *((name, pa.string()) for name in texts)]
    columns += [("most_cusps", pa.int8()), ("l1", pa.float64()), ("width", pa.float64())]
    columns += [("transitions", pa.int16()), ("aspects", pa.int16()), ("lengths", lengths)]
    schema = pa.schema([("seed", pa.int64()), *columns, ("error", pa.string())])

    def write(rows: Path, target: Path, count: int) -> None:
        part = target.with_name(f"{target.name}.part")
        with rows.open("rb") as file, pq.ParquetWriter(part, schema) as writer:
            lines = islice(file, count)
            while some := [_flat(json.loads(line)) for line in islice(lines, 10_000)]:
                writer.write_table(pa.Table.from_pylist(some, schema=schema))
        part.replace(target)

    return write


def _flat(row: dict[str, Any]) -> dict[str, Any]:
    """A row with the lengths of its geometry as columns, exact, and what was measured as floats."""
    numbers = {name: None if row.get(name) is None else float(row[name]) for name in ("l1", "width")}
    lengths = [
        {"cusps": int(cusps), "length": None if length is None else float(length)}
        for cusps, length in row.get("lengths", {}).items()
    ]
    return {**row, **row["geometry"], **numbers, "lengths": lengths}


COMMANDS = {
    "margin": partial(asking.command, page=_margin, steps="boxes", status=_margin_status),
    "design": partial(
        asking.command,
        page=_design_page,
        status=lambda document: MET if document["best"]["met"] else NOT_MET,
        compute=_computed,
        names={"fixed": "--fix", "budget.censuses": "--budget"},
        readers={"fixed": lambda text: [name.strip() for name in text.split(",")]},
        deadline="end with the best found until then; with --url, the proof of it is in this time",
    ),
    "atlas": Command.of(_run_atlas, _configure_atlas),
}
