"""PNG and PDF show the scene that SVG shows, with the same bytes each time."""

import importlib
from collections.abc import Iterable
from io import BytesIO

import pytest

from rpr_solver.notebook.scene import Box, Disc, Group, Motion, Paint, Path, Scene, Text, colour

SCENE = Scene(
    80,
    60,
    "title",
    "text",
    (
        Path((Box(10, 10, 30, 30).corners,), Paint("poses6"), closed=True),
        Group((Path(([(0, 50), (80, 50)],), Paint(stroke="ink", width=6)),), clip=Box(0, 40, 40, 60)),
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
