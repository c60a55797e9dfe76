"""The notes of a release are those of its version, and a tag that names no version is refused."""

import runpy
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
NOTES = runpy.run_path(str(ROOT / "docs" / "release_notes.py"))
CHANGELOG = """# Changelog

## [Unreleased]

## [1.2.0] - 2027-01-31

New.

### Fixed
- A.

## [1.1.0] - 2026-01-01

Old.
"""


def test_the_notes_are_the_section_of_the_version() -> None:
    assert NOTES["notes_of"]("v1.2.0", CHANGELOG) == "New.\n\n### Fixed\n- A.\n"
    assert NOTES["notes_of"]("v1.1.0", CHANGELOG) == "Old.\n"


@pytest.mark.parametrize("tag", ["v1.3.0", "v1.2", "Unreleased", "v1x2.0"])
def test_a_version_without_a_dated_section_has_no_notes(tag: str) -> None:
    with pytest.raises(ValueError, match="no dated section"):
        NOTES["notes_of"](tag, CHANGELOG)


def test_a_tag_that_is_not_the_version_of_the_package_ends_in_an_error() -> None:
    command = [sys.executable, ROOT / "docs" / "release_notes.py", "v99.0.0"]
    outcome = subprocess.run(command, capture_output=True, text=True, check=False)
    assert outcome.returncode == 1
    assert "the tag is v99.0.0, but pyproject.toml has version" in outcome.stderr
    assert outcome.stdout == ""
