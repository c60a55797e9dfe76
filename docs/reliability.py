"""Writes the tables of docs/reliability.md from the docstrings of tests/faults.

A test's first sentence says what fails, the others what becomes of the service, its jobs and its clients.

python docs/reliability.py            rewrite the text below the marker
python docs/reliability.py --check    write nothing; exit 1 if the file is out of date
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections.abc import Iterator
from pathlib import Path

FILE = Path(__file__).with_name("reliability.md")
TESTS = Path(__file__).parents[1] / "tests" / "faults"
MARKER = "<!-- from here on written by docs/reliability.py -->\n"


def rows(path: Path) -> Iterator[tuple[str, str]]:
    """Yields what fails, and what becomes of it: a pair for each test.

    Raises:
        ValueError: a test does not say both.
    """
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.name.startswith("test_"):
            text = " ".join((ast.get_docstring(node) or "").split())
            fault, end, outcome = text.partition(". ")
            if not end:
                raise ValueError(f"{path.name}: {node.name} does not say what fails. And what happens then.")
            yield fault, outcome.rstrip(".")


def tables() -> str:
    """Returns one table for each file of tests."""
    parts = []
    for path in sorted(TESTS.glob("test_*.py")):
        title = (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").partition("\n")[0]
        lines = [f"| {fault} | {outcome} |" for fault, outcome in rows(path)]
        head = f"## {title.rstrip('.')}\n| fault | what happens |\n|---|---|"
        parts.append("\n".join([head, *lines]))
    return "\n" + "\n\n".join(parts) + "\n"


def main(arguments: list[str] | None = None) -> int:
    """Write or check the file; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--check", action="store_true", help="only compare")
    check = parser.parse_args(arguments).check
    before = FILE.read_text(encoding="utf-8")
    after = before.partition(MARKER)[0] + MARKER + tables()
    if not check:
        FILE.write_text(after, encoding="utf-8")
    elif after != before:
        print("docs/reliability.md is out of date: run `python docs/reliability.py`", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
