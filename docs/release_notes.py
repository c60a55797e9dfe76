"""The notes of a release: what CHANGELOG.md says of it. ``python docs/release_notes.py v0.1.0``

A tag that does not name the version of ``pyproject.toml`` and ``CITATION.cff``, or a version without a dated
section, ends the command with an error.
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]


def notes_of(tag: str, changelog: str) -> str:
    """The section of a version, without its heading; :class:`ValueError` if there is none."""
    version = tag.removeprefix("v")
    sections = re.split(r"^## ", changelog, flags=re.MULTILINE)
    for section in sections[1:]:
        heading, _, text = section.partition("\n")
        if re.fullmatch(rf"\[{re.escape(version)}\] - \d{{4}}-\d\d-\d\d", heading):
            return text.strip() + "\n"
    raise ValueError(f'CHANGELOG.md has no dated section of version {version}: "## [{version}] - YYYY-MM-DD"')


def check_version(tag: str) -> None:
    """Refuse a tag that is not the version of the package and of its citation."""
    package = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    cited = re.search(r"^version: (\S+)$", citation, flags=re.MULTILINE)
    for file, version in (("pyproject.toml", package), ("CITATION.cff", cited and cited[1])):
        if tag != f"v{version}":
            raise ValueError(f"the tag is {tag}, but {file} has version {version}")


def main() -> str | None:
    """The command: the notes go to standard output."""
    [tag] = sys.argv[1:] or [""]
    try:
        check_version(tag)
        sys.stdout.write(notes_of(tag, (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")))
    except ValueError as error:
        return str(error)
    return None


if __name__ == "__main__":
    sys.exit(main())
