"""A figure's ways out: text, files, notebooks; and what is said where one is closed."""

import sys
from pathlib import Path

import pytest

from rpr_solver import EXAMPLES, Figure, InputError
from rpr_solver.notebook.figure import suffix_of

FIGURE = EXAMPLES["innocenti"].figure()


def test_svg_of_each_theme() -> None:
    assert isinstance(FIGURE, Figure)
    assert FIGURE._repr_svg_() == FIGURE.svg() == FIGURE.svg("auto")
    assert len({FIGURE.svg(), FIGURE.svg("light"), FIGURE.svg("dark")}) == 3
    assert Figure(FIGURE.scene, "dark").svg() == FIGURE.svg("dark")
    with pytest.raises(InputError, match=r"^theme: is 'red'; give auto, light or dark$"):
        FIGURE.svg("red")  # type: ignore[arg-type]


def test_files(tmp_path: Path) -> None:
    FIGURE.save(tmp_path / "a.SVG", "light")
    assert (tmp_path / "a.SVG").read_text(encoding="utf-8") == FIGURE.svg("light")
    with pytest.raises(InputError, match=r"^path: '.*' does not end in .svg, .png or .pdf"):
        FIGURE.save(tmp_path / "a.jpg")
    with pytest.raises(InputError, match=r"^path: '.*' cannot be written: No such file or directory$"):
        FIGURE.save(tmp_path / "none" / "a.svg")
    assert suffix_of(Path("x.PDF")) == ".pdf"


def test_what_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "rpr_solver.notebook.export", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(InputError, match=r"^png: needs matplotlib; install rpr-cusps\[plot\]"):
        FIGURE.png()
