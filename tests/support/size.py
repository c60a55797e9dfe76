"""How much there is to hold: files and lines of code of each room.

    python -m tests.support.size

Lines of code are those with code: no blanks, comments or docstrings. The last column has those of imports.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = ("rpr_solver", "worker", "service")


@dataclass(frozen=True)
class Size:
    """The size of one file, or of several."""

    files: int = 0
    lines: int = 0
    imports: int = 0

    def __add__(self, other: Size) -> Size:
        return Size(self.files + other.files, self.lines + other.lines, self.imports + other.imports)


def size_of(path: Path) -> Size:
    """The size of one file."""
    text = path.read_text(encoding="utf-8")
    imports, documentation = set[int](), set[int]()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            imports |= _lines(node)
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            documentation |= _lines(node)  # of attributes, too
    lines = enumerate(map(str.strip, text.splitlines()), 1)
    code = {n for n, line in lines if line and not line.startswith("#")}
    return Size(1, len(code - documentation), len(imports))


def _lines(node: ast.stmt) -> set[int]:
    return set(range(node.lineno, (node.end_lineno or node.lineno) + 1))


def total(paths: Iterable[Path]) -> Size:
    """The size of several files together."""
    return sum(map(size_of, paths), Size())


def main() -> None:
    """Print a row for each room."""
    print(f"{'room':<26}{'files':>6}{'lines':>8}{'imports':>9}")
    for package in PACKAGES:
        folders = [path.parent for path in sorted((ROOT / package).glob("*/__init__.py"))]
        for name, paths in [
            (package, (ROOT / package).glob("*.py")),
            *((f"{package}.{folder.name}", folder.rglob("*.py")) for folder in folders),
        ]:
            size = total(paths)
            print(f"{name:<26}{size.files:>6}{size.lines:>8}{size.imports:>9}")
    size = total(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
    print(f"{'all':<26}{size.files:>6}{size.lines:>8}{size.imports:>9}")


if __name__ == "__main__":
    main()
