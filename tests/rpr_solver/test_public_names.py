"""Each public name of `rpr_solver` has a docstring, with an example and all arguments."""

import doctest
import inspect
import tomllib
from pathlib import Path

import rpr_solver

PUBLIC = {name: getattr(rpr_solver, name) for name in rpr_solver.__all__}
FUNCTIONS = {name for name, value in PUBLIC.items() if inspect.isfunction(value)}
CLASSES = {name for name, value in PUBLIC.items() if inspect.isclass(value)}


def test_every_public_name_is_documented() -> None:
    for name in sorted(FUNCTIONS | CLASSES):
        text = getattr(rpr_solver, name).__doc__ or ""
        assert text.strip(), name
        assert not text.startswith(f"{name}("), "a dataclass without a docstring gets its signature instead"


def test_every_public_name_has_an_example() -> None:
    for name in sorted(FUNCTIONS | CLASSES):
        text = inspect.getdoc(getattr(rpr_solver, name)) or ""
        assert doctest.DocTestParser().get_examples(text), name


def test_every_public_function_explains_its_arguments() -> None:
    for name in sorted(FUNCTIONS):
        function = getattr(rpr_solver, name)
        text, arguments = inspect.getdoc(function) or "", inspect.signature(function).parameters
        if len(arguments) > 1:
            assert [argument for argument in arguments if f"    {argument}: " not in text] == [], name
            assert "Raises:" in text, name


def test_there_is_one_version() -> None:
    import service

    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))
    assert rpr_solver.__version__ == service.__version__ == project["project"]["version"]
