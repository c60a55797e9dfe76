"""Make an atlas: the censuses of many random manipulators as one row each, NDJSON or Parquet.

Which manipulator a row has depends on the seed and its number alone, so that an atlas can be made again, or
longer. A command that was interrupted continues where it stopped: no row is lost or doubled. Parquet needs
the extra atlas: pip install 'rpr-cusps[atlas]'."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import islice
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from rpr_solver.contract import MIN_DIGITS
from rpr_solver.errors import InputError, SolverError
from service.cli import output, remote
from service.cli.help import Command
from service.cli.output import progress_bar
from service.schemas.document import named
from service.schemas.numbers import whole_number
from worker.process.os_limits import die_with_parent, usable_cores

EXAMPLES = """\
examples:
  rpr-cusps atlas --count 2000 --seed 1 -o atlas.ndjson
  rpr-cusps atlas --count 2000 --seed 1 -o atlas.parquet --url http://127.0.0.1:8000
"""

_MOST, _MOST_SEED = 10_000_000, 2**63 - 1
_AT_ONCE = 200
_FEW, _AHEAD = 8, 4


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--count", metavar="N", required=True, help="the number of rows")
    parser.add_argument("--seed", metavar="S", default="1", help="of the random geometries (default: 1)")
    parser.add_argument(
        "-o", "--output", metavar="FILE", required=True, help="a name that ends in .ndjson or .parquet"
    )
    remote.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    count, seed = _whole(args.count, "--count", 1, _MOST), _whole(args.seed, "--seed", 0, _MOST_SEED)
    target = Path(args.output)
    if target.suffix not in (".ndjson", ".parquet"):
        raise InputError.of("--output", f"{args.output!r} ends in neither .ndjson nor .parquet")
    remote.deadline_of(args)
    rows_file = target if target.suffix == ".ndjson" else target.with_name(f"{target.name}.rows")
    write_parquet = None if rows_file == target else _parquet()
    done = kept_rows(rows_file, seed)
    missing = range(done, count)
    rows = _of_service(args.url, seed, missing) if args.url else _computed(seed, missing)
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


def _computed(seed: int, indices: Sequence[int]) -> Iterator[dict[str, Any]]:
    """Yields rows that are computed here, on all cores."""
    from rpr_solver.transitions.census_documents import atlas_row

    if len(indices) < _FEW or usable_cores() == 1:
        yield from map(partial(atlas_row, seed), indices)
        return
    # no more at once than are soon needed, so that an interrupt has little to wait for
    own = (os.getpid(),)  # without which the others would wait for ever if this process were killed
    with ProcessPoolExecutor(usable_cores(), get_context("spawn"), die_with_parent, own) as pool:
        left = iter(indices)
        pending = [pool.submit(atlas_row, seed, k) for k in islice(left, _AHEAD * usable_cores())]
        while pending:
            yield pending.pop(0).result()
            pending += [pool.submit(atlas_row, seed, k) for k in islice(left, 1)]


def _of_service(url: str, seed: int, indices: Sequence[int]) -> Iterator[dict[str, Any]]:
    """Yields rows from the censuses of a service, asked for in batches."""
    from rpr_solver.transitions.census_documents import atlas_geometry, failed_row, row_of
    from service.client import census

    with remote.client_of(url) as client:
        for first in range(0, len(indices), _AT_ONCE):
            part = indices[first : first + _AT_ONCE]
            asked = [census(atlas_geometry(seed, k), digits=MIN_DIGITS) for k in part]
            for k, result in zip(part, client.ask_all(asked), strict=True):
                if result.answer is None:
                    why = result.status if result.problem is None else result.problem.detail
                    yield failed_row(seed, k, why)
                else:
                    yield row_of(seed, k, result.answer.document)


def _parquet() -> Any:
    """Returns what writes rows as Parquet.

    Raises:
        SolverError: the extra is not installed.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        message = "Parquet needs pyarrow; install the extra: pip install 'rpr-cusps[atlas]'"
        raise SolverError(message) from None
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


def _whole(text: str, option: str, least: int, most: int) -> int:
    with named(option):
        number = whole_number(text, f"{least} to {most}", is_text=True)
    if not least <= number <= most:
        raise InputError.of(option, f"is {text[:40]}; give {least} to {most}")
    return number


COMMANDS = {"atlas": Command(__doc__ or "", EXAMPLES, configure, run)}
