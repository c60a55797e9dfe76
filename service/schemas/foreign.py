"""Files of other programs in the place of a geometry: what one seems to be, and what to save instead."""

from __future__ import annotations

import re

_LOOKED_AT = 4096  # bytes
_JSON = (
    'write {"base": {"points": [[0, 0], [10, 0], [5, 8]]}, "platform": {"sides": [3, 4, 5]}}, or points of '
    "the platform, too, in a .json file"
)
_SHEET = f'save its sheet as "CSV UTF-8" (File > Save As), a geometry a row, for rpr-cusps submit, or {_JSON}'
_OF_MATLAB = '"base", struct("points", A), "platform", struct("points", B)'
_MATLAB = (
    f"save JSON in MATLAB, with the corners of base and platform as the rows of A and B: "
    f'writelines(jsonencode(struct({_OF_MATLAB})), "robot.json"), or many geometries as a table with columns '
    'a1x, a1y, … b3y: writetable(T, "robots.csv")'
)

_BEGINNINGS = (
    (b"\xd0\xcf\x11\xe0", "it is an Excel workbook", _SHEET),
    (b"MATLAB ", "it is a MATLAB data file", _MATLAB),
    (b"# Created by Octave", "it is an Octave data file", _JSON),
    (b"\x89HDF", "it is an HDF5 file", _JSON),
    (b"\x93NUMPY", "it is a NumPy file", _JSON),
    (b"%PDF", "it is a PDF", _JSON),
)
_YAML = re.compile(r"---|[\w .-]+:(\s.*)?|- .*")
_TABLE = re.compile(r"\ufeff?(sep=.\s+)?[\w\"' ]+([,;\t][\w\"' ]*){2,}$", re.MULTILINE | re.IGNORECASE)
_ASSIGNMENT = re.compile(r"[\w.]+\s*=[^=&]*|\[[\w.]+\]")
_OF_SCRIPT = re.compile(r"%.*|(function|clear|clc|close)\b.*|[\w.]+\s*=.*;(\s*%.*)?")


def foreign(content: bytes, *, is_table: bool = False) -> str | None:
    """Returns what a text that is no JSON seems to be, and what to save instead; None if nothing fits.

    With ``is_table`` it was to be CSV.

    >>> foreign(b"a2x: 15.91")[:21], foreign(b'{"a2x": 15.91')
    ('it looks like YAML; c', None)
    """
    beginning = content[:_LOOKED_AT].lstrip()
    for mark, what, instead in _BEGINNINGS:
        if beginning.startswith(mark):
            return f"{what}; {instead}"
    if beginning.startswith(b"PK\x03\x04"):
        is_sheet = b"spreadsheet" in beginning or b"[Content_Types].xml" in beginning or b"xl/" in beginning
        return f"it is a workbook of a spreadsheet; {_SHEET}" if is_sheet else f"it is a ZIP archive; {_JSON}"
    text = beginning.decode("utf-8", "replace")
    if text.startswith("<"):
        what = "URDF" if "<robot" in text else "SDF" if "<sdf" in text else "XML or HTML"
        return f"it is {what}; {_JSON}"
    if not is_table and _TABLE.match(text):
        return f"it looks like a CSV table, which is for rpr-cusps submit; for one geometry, {_JSON}"
    return _of_lines(text)


def _of_lines(text: str) -> str | None:
    whole = text.splitlines()[: -1 if len(text) > _LOOKED_AT // 2 else None]  # the last may be cut
    lines = [line.strip() for line in whole if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        return None
    if lines[0].startswith("%") or (any("=" in x for x in lines) and _all(_OF_SCRIPT, lines)):
        return f"it looks like a MATLAB script; run it, and {_MATLAB}"
    if _all(_YAML, lines):
        return f"it looks like YAML; convert it, as with yq -o=json . robot.yaml, or {_JSON}"
    if _all(_ASSIGNMENT, lines):
        return f"it looks like a program or settings; {_JSON}"
    return None


def _all(pattern: re.Pattern[str], lines: list[str]) -> bool:
    """Whether nearly all lines match: others may continue those before them."""
    return sum(pattern.fullmatch(line) is not None for line in lines) >= 0.7 * len(lines)
