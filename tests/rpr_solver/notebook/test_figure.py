"""A figure's ways out: axes of your own, text, files, notebooks; and what is said where one is closed."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rpr_solver import EXAMPLES, InputError, Manipulator, cusp_curves, leg_poses, singular_curves
from rpr_solver.notebook.figure import suffix_of
from rpr_solver.notebook.style import Style
from tests.support.pictures import check, words

FLAT = EXAMPLES["zein-flat"]


@pytest.fixture(scope="module")
def figure() -> Any:
    return EXAMPLES["innocenti"].figure()


def test_the_same_bytes_for_every_asker(figure: Any) -> None:
    """Also if others draw in another style meanwhile."""
    dark = figure.styled(theme="dark")
    asked = [figure, dark] * 6
    with ThreadPoolExecutor(4) as askers:
        drawn = list(askers.map(lambda one: one.svg(), asked))
    assert set(drawn[::2]) == {figure.svg()}
    assert set(drawn[1::2]) == {dark.svg()} != set(drawn[::2])
    for form in (".png", ".pdf"):
        assert figure.encoded(form) == figure.encoded(form)


@pytest.mark.long
def test_twenty_slices_at_once() -> None:
    figures = [singular_curves(FLAT, length).figure() for length in range(1, 21)]
    with ThreadPoolExecutor(20) as askers:
        drawn = list(askers.map(lambda one: one.svg(), figures))
    assert all(text.startswith("<?xml") or text.startswith("<svg") for text in drawn)
    assert len(set(drawn)) == 20


def test_files(figure: Any, tmp_path: Path) -> None:
    for name, start in (("a.SVG", b"<"), ("a.png", b"\x89PNG"), ("a.pdf", b"%PDF")):
        figure.save(tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(start)
    assert (tmp_path / "a.SVG").read_text(encoding="utf-8") == figure.svg() == figure._repr_svg_()
    with pytest.raises(InputError, match=r"^path: '.*' does not end in .svg, .png or .pdf"):
        figure.save(tmp_path / "a.jpg")
    with pytest.raises(InputError, match=r"^path: '.*' cannot be written: No such file or directory$"):
        figure.save(tmp_path / "none" / "a.svg")
    assert suffix_of(Path("x.PDF")) == ".pdf"


def test_styles(figure: Any) -> None:
    check(figure)
    assert figure.title in words(figure)
    assert figure.title not in words(figure.styled(has_title=False))
    assert len(words(figure.styled(has_title=False, has_caption=False))) < len(words(figure)) - 1
    paper = singular_curves(FLAT, 3).figure().styled(Style(width_mm=86, has_symbols=True, unit="mm"))
    svg = paper.svg()
    assert 'width="86mm"' in svg
    assert "STIX" in svg
    assert "[mm]" in words(paper)[0] + "".join(words(paper))
    assert singular_curves(FLAT, 3).figure().svg() == paper.styled(Style()).svg()


def test_axes_of_your_own_are_changed_by_matplotlib_alone() -> None:
    from matplotlib.figure import Figure as Sheet

    sheet = Sheet(figsize=(8, 4), layout="constrained")
    left, right = sheet.subplots(1, 2)
    ax = singular_curves(FLAT, 3).plot(left)
    assert ax is left
    leg_poses(FLAT, {"l1": 17, "l3": 15}, digits=15).plot(right)
    ax.set(xlim=(0, 5), ylim=(1, 4), xlabel="x", title="mine")
    [curve] = [line for line in ax.lines if len(line.get_xdata()) > 100]
    curve.set(color="red", linewidth=3)
    ax.patches[0].set_facecolor("yellow")
    sheet.canvas.draw()
    assert (ax.get_xlim(), ax.get_ylim(), ax.get_title()) == ((0, 5), (1, 4), "mine")
    x = curve.get_xdata()
    assert 0 < np.nanmin(x) < np.nanmax(x) < 100  # data in the unit of the answer
    assert right.get_ylabel() == "poses"


def test_new_axes_are_those_of_pyplot() -> None:
    plt = pytest.importorskip("matplotlib.pyplot")
    plt.switch_backend("agg")
    ax = EXAMPLES["innocenti"].plot()
    assert ax is plt.gca()
    assert "Manipulator at α = 0" in [text.get_text() for text in plt.gcf().texts]
    plt.close("all")


def test_a_locus_needs_three_dimensions() -> None:
    from matplotlib.figure import Figure as Sheet

    curves, sheet = cusp_curves(FLAT, digits=15).part(30, 33, samples=3), Sheet()
    with pytest.raises(InputError, match=r"^ax: has two dimensions; make it with projection='3d'$"):
        curves.plot(sheet.add_subplot())
    space = curves.plot(sheet.add_subplot(projection="3d"))
    assert space.get_zlabel() == "L3"


@pytest.mark.parametrize(
    ("lengths", "said"),
    [
        (("1e399", 1, 1, "1e399", 1, "1e399"), "which no picture can show together"),
        (("1e-320", "1e-320", "1e-320", "1e-320", "1e-320", "1e-320"), ""),
        ((1, 0, 1, "1e-40", 1, 1), "which no picture can show together"),
    ],
)
def test_extreme_lengths_are_drawn_or_refused_by_name(lengths: tuple[Any, ...], said: str) -> None:
    robot = Manipulator(*lengths)
    if said:
        with pytest.raises(InputError, match=rf"^geometry: .*{said}$"):
            robot.figure()
    else:
        check(robot.figure())


@pytest.mark.parametrize(("power", "said"), [(200, "a larger unit"), (-200, "a smaller unit")])
def test_answers_in_units_that_axes_cannot_show_are_refused_by_name(power: int, said: str) -> None:
    robot = Manipulator(*(f"{x}e{power}" for x in ("15.91", 0, 10, "17.04", "16.54", "20.84")))
    answer = leg_poses(robot, {"l1": f"17e{power}", "l3": f"15e{power}"}, digits=15)
    with pytest.raises(InputError, match=rf"^geometry: .* is too (large|small) to be drawn; .*{said}$"):
        answer.figure()


def test_what_is_missing_is_named() -> None:
    program = """
import sys
sys.modules["matplotlib"] = None
from rpr_solver import EXAMPLES, InputError, singular_curves
assert EXAMPLES["innocenti"]._repr_svg_() is None
assert "15.91" in EXAMPLES["innocenti"]._repr_html_()
try:
    EXAMPLES["innocenti"].plot()
except InputError as error:
    print(error)"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.stdout.startswith("figure: needs matplotlib; in your copy of the repository: pip install -c")
