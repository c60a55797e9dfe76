"""Every code block of the tutorials gives what is printed below it, and the reference names all there is."""

import doctest
import re
from pathlib import Path

import pytest
from pydantic_settings import BaseSettings

import rpr_solver
from docs import reference
from service.api.problems import ProblemType

DOCS = Path(__file__).parent.parent / "docs"
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("name", ["library.md"])
def test_code_blocks(name: str) -> None:
    text = (DOCS / name).read_text(encoding="utf-8")
    blocks = BLOCK.findall(text)
    assert len(blocks) == text.count("```python")
    assert all(block.startswith(">>> ") for block in blocks)
    # one session, as in a notebook
    test = doctest.DocTestParser().get_doctest("\n".join(blocks), {}, name, name, 0)
    assert doctest.DocTestRunner().run(test).failed == 0


def test_the_reference_is_what_the_code_says(capsys: pytest.CaptureFixture[str]) -> None:
    assert reference.main(["--check"]) == 0, f"run `python docs/reference.py`:\n{capsys.readouterr().out}"


def test_every_setting_problem_option_and_public_name_is_in_the_reference() -> None:
    text = (DOCS / "reference.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert not [row for row in rows if "|  |" in row], "something is named without its meaning"
    documented = {code.split()[0] for row in rows for code in re.findall(r"`([^`]+)`", row)}
    groups = [g for g in BaseSettings.__subclasses__() if g.__module__.startswith(("worker", "service"))]
    settings = {f"RPR_CUSPS_{name.upper()}" for group in groups for name in group.model_fields}
    problems = {kind.value.slug for kind in ProblemType}
    options = {
        name
        for _, parser in reference.commands()
        for action in reference.visible(parser)
        for name in action.option_strings
    }
    assert (settings - {"RPR_CUSPS_LIMITS"}) | problems | options | set(rpr_solver.__all__) <= documented
