"""The pictures of the documentation are those that their command draws, byte for byte."""

import pytest

from docs import figures

QUICK = ("article-2", "article-5", "cusp", "nodes", "poses")


@pytest.mark.parametrize(
    "name",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.long) for name in figures.FIGURES],
)
def test_a_picture_is_what_its_command_draws(name: str) -> None:
    assert figures.main(["--check", name]) == 0


def test_a_picture_that_differs_is_named(
    tmp_path: figures.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(figures, "FOLDER", tmp_path)
    assert figures.main(["--check", "poses"]) == 1
    assert capsys.readouterr().err == "out of date: poses.svg; run `python docs/figures.py`\n"
    assert figures.main(["poses"]) == figures.main(["--check", "poses"]) == 0
    assert figures.main(["none"]) == 2


def test_every_file_has_its_command() -> None:
    folder = figures.Path(figures.__file__).with_name("figures")
    assert {path.stem for path in folder.iterdir()} == set(figures.FIGURES)
