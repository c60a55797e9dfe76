"""A figure's ways out: text, files, notebooks; and what is said where one is closed.

PNG and PDF show the scene that SVG shows, with the same bytes each time.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterable
from io import BytesIO
from pathlib import Path

import pytest

from rpr_solver import EXAMPLES, Figure, InputError
from rpr_solver.notebook.figure import suffix_of
from rpr_solver.notebook.scene import Box, Disc, Group, Motion, Paint, Scene, Text, colour
from rpr_solver.notebook.scene import Path as Polyline

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
    with pytest.raises(
        InputError,
        match=r"^png: needs matplotlib; in your copy of the repository: pip install .* '\.\[plot\]'",
    ):
        FIGURE.png()


SCENE = Scene(
    80,
    60,
    "title",
    "text",
    (
        Polyline((Box(10, 10, 30, 30).corners,), Paint("poses6"), closed=True),
        Group((Polyline(([(0, 50), (80, 50)],), Paint(stroke="ink", width=6)),), clip=Box(0, 40, 40, 60)),
        Group((Disc((0, 0), 6, Paint("cusp")),), motion=Motion(((60, 20, 90, 1), (0, 0, 0, 1)), 1)),
        Text((40, 5), "α θ1 −180° ∞", 8, halo="paper", turn=-5),
        Text((2, 58), "L2", 3),
    ),
)


def drawn(scene: Scene, form: str, theme: str) -> bytes:
    """That of :mod:`rpr_solver.notebook.export`, which loads Matplotlib: not while tests are collected."""
    pytest.importorskip("matplotlib")
    from rpr_solver.notebook.export import drawn

    return drawn(scene, form, theme)


def code(pixel: Iterable[float]) -> str:
    return "#" + "".join(f"{round(255 * x):02x}" for x in list(pixel)[:3])


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_png_has_the_colours_of_the_scene_where_it_has_its_shapes(theme: str) -> None:
    is_dark = "dark" if theme == "dark" else "light"
    png = BytesIO(drawn(SCENE, "png", is_dark))
    picture = importlib.import_module("matplotlib.image").imread(png, format="png")
    assert picture.shape[:2] == (120, 160)
    at = {
        (40, 40): "poses6",
        (80, 40): "paper",
        (40, 100): "ink",
        (120, 100): "paper",  # clipped
        (120, 40): "cusp",  # moved to its first place
    }
    for (x, y), role in at.items():
        assert code(picture[y][x]) == colour(role, is_dark), role


def test_bytes_are_the_same_each_time() -> None:
    for form in ("png", "pdf"):
        assert drawn(SCENE, form, "light") == drawn(SCENE, form, "light")


def test_pdf_embeds_its_font() -> None:
    assert drawn(SCENE, "pdf", "light").startswith(b"%PDF")
    with importlib.import_module("matplotlib").rc_context({"pdf.compression": 0}):
        assert b"/FontFile2" in drawn(SCENE, "pdf", "light")
