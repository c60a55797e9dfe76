"""SVG text: the same bytes for the same scene, dark by a style sheet, still where motion is not wanted."""

import re
from xml.etree import ElementTree

from rpr_solver.notebook.scene import COLOURS, Box, Disc, Group, Motion, Paint, Path, Scene, Shape, Text
from rpr_solver.notebook.svg import svg_of

SQUARE = Box(10, 10, 30, 30).corners


def scene(*shapes: Shape) -> Scene:
    return Scene(100, 50.5, "a < b", "x & y", shapes)


def test_colours_of_the_themes() -> None:
    picture = scene(Path((SQUARE,), Paint("poses2", "curve", 1.5), closed=True))
    light, dark = COLOURS["curve"]
    assert f'stroke="{light}"' in svg_of(picture, "light")
    assert f'stroke="{dark}"' in svg_of(picture, "dark")
    assert "<style>" not in svg_of(picture, "light") + svg_of(picture, "dark")
    auto = svg_of(picture)
    assert 'class="rpr-fill-poses2 rpr-stroke-curve"' in auto
    assert f'stroke="{light}"' in auto
    assert f".rpr-stroke-curve{{stroke:{dark}}}" in auto
    assert "prefers-color-scheme:dark" in auto


def test_shapes() -> None:
    text = svg_of(
        scene(
            Path(([(0, 0), (0.01, 0.01), (5, 5)], [(7, 7), (7.01, 7)]), Paint(stroke="ink", dash=(3, 2))),
            Disc((5.04, 6), 2, Paint("cusp", opacity=0.5)),
            Group((Text((1, 10), "<L2>", 10, halo="paper", turn=-90),), "name", clip=Box(0, 0, 9, 9)),
        ),
        "light",
    )
    root = ElementTree.fromstring(text)
    [path] = [e for e in root.iter() if e.tag.endswith("path")]
    assert path.attrib["d"] == "M0 0L5 5"
    assert path.attrib["stroke-dasharray"] == "3 2"
    [disc] = [e for e in root.iter() if e.tag.endswith("circle")]
    assert (disc.attrib["cx"], disc.attrib["fill-opacity"]) == ("5", "0.5")
    [label] = [e for e in root.iter() if e.tag.endswith("text")]
    assert label.text == "<L2>"
    assert label.attrib["transform"] == "rotate(-90 1 10)"
    [group] = [e for e in root.iter() if e.tag.endswith("}g")]
    assert group[0].text == "name"
    reference = re.fullmatch(r"url\(#(.+)\)", group.attrib["clip-path"])
    assert reference
    assert reference[1] in {e.attrib.get("id") for e in root.iter()}


def test_ids_differ_between_pictures_and_not_between_runs() -> None:
    first, second = svg_of(scene(Text((1, 1), "a"))), svg_of(scene(Text((1, 1), "b")))
    ids = [set(re.findall(r'id="([^"]+)"', text)) for text in (first, second)]
    assert not ids[0] & ids[1]
    assert first == svg_of(scene(Text((1, 1), "a")))


def test_motion_stops_for_those_who_do_not_want_it() -> None:
    motion = Motion(((0, 0, 0, 1), (10, 5, 90, 2), (0, 0, 0, 1)), 4)
    text = svg_of(scene(Group((Disc((0, 0), 3, Paint("cusp")),), motion=motion)))
    assert 'transform="translate(0 0)rotate(0)scale(1 1)"' in text
    assert "50%{transform:translate(10px,5px)rotate(90deg)scale(2,1)}" in text
    assert "@media (prefers-reduced-motion:reduce){.rpr-motion-0{animation:none}}" in text
    assert "<style>" in svg_of(scene(Group((), motion=motion)), "dark")
