"""Scenes as SVG text: the same scene gives the same bytes.

Every colour is an attribute in the light theme's (or the given theme's) value, so that a program which knows
no style sheets draws it too; the theme ``auto`` adds a style sheet with the dark colours for readers who
prefer them. Moving groups are moved by the style sheet, unless the reader prefers less motion.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from html import escape
from itertools import pairwise

from rpr_solver.notebook.scene import (
    COLOURS,
    Box,
    Disc,
    Group,
    Line,
    Motion,
    Paint,
    Path,
    Scene,
    Shape,
    Text,
    colour,
    roles,
)
from rpr_solver.notebook.tables import Theme, symbols

FONTS = (
    "system-ui, 'Segoe UI', 'Helvetica Neue', Arial, 'DejaVu Sans', sans-serif",
    "'STIX Two Text', 'Times New Roman', Times, 'DejaVu Serif', serif",
)
"""For pages, and where quantities are symbols."""
_BASELINE = 0.355


def svg_of(scene: Scene, theme: Theme = "auto") -> str:
    """The scene as an SVG document, which ends in a newline."""
    writer = _Writer(theme, has_symbols=scene.style.has_symbols)
    content = "\n".join(writer.shapes(scene.shapes))
    w, h = _n(scene.width), _n(scene.height - scene.top)
    wide, high = (f"{_n(x, 2)}mm" for x in scene.millimetres) if scene.style.is_print else (w, h)
    top = _n(scene.top)
    below = f' y="{top}"' if scene.top else ""
    font = FONTS[scene.style.has_symbols]
    paper = writer.colour("fill", "paper")
    style = writer.style(scene)
    body = "\n".join(
        [
            f'<title id="@-title">{escape(scene.title, quote=False)}</title>',
            f'<desc id="@-desc">{escape(scene.description, quote=False)}</desc>',
            *([f"<style>{style}</style>"] if style else []),
            *([f"<defs>{''.join(writer.clips)}</defs>"] if writer.clips else []),
            f'<rect{below} width="{w}" height="{h}"{paper}/>',
            content,
        ]
    )
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 {top} {w} {h}" width="{wide}" height="{high}"'
        f' role="img" aria-labelledby="@-title @-desc" font-family="{font}" fill="none">'
    )
    text = f"{head}\n{body}\n</svg>\n"
    name = "f" + hashlib.sha256(text.encode()).hexdigest()[:8]
    return text.replace('"@-', f'"{name}-').replace(" @-", f" {name}-").replace("#@-", f"#{name}-")


class _Writer:
    def __init__(self, theme: Theme, *, has_symbols: bool) -> None:
        self._theme = theme
        self._has_symbols = has_symbols
        self._motions: list[Motion] = []
        self.clips: list[str] = []

    def colour(self, kind: str, role: str) -> str:
        """The attribute of a colour, and the class that changes it."""
        if not role:
            return ""
        name = f' class="rpr-{kind}-{role}"' if self._theme == "auto" else ""
        return f'{name} {kind}="{colour(role, self._theme)}"'

    def style(self, scene: Scene) -> str:
        rules = []
        if self._theme == "auto":
            used = sorted({("fill", "paper"), *roles(scene.shapes)})
            dark = "".join(f".rpr-{kind}-{role}{{{kind}:{COLOURS[role][1]}}}" for kind, role in used)
            rules.append(f"@media (prefers-color-scheme:dark){{{dark}}}")
        for k, motion in enumerate(self._motions):
            count = len(motion.places) - 1
            frames = "".join(
                f"{_n(100 * i / count)}%{{transform:translate({_n(x)}px,{_n(y)}px)rotate({_n(turn)}deg)"
                f"scale({_n(stretch, 3)},1)}}"
                for i, (x, y, turn, stretch) in enumerate(motion.places)
            )
            rules.append(f"@keyframes rpr-motion-{k}{{{frames}}}")
            rules.append(
                f".rpr-motion-{k}{{animation:rpr-motion-{k} {_n(motion.seconds)}s linear infinite}}"
                f"svg:hover .rpr-motion-{k}{{animation-play-state:paused}}"
            )
        if self._motions:
            names = ",".join(f".rpr-motion-{k}" for k in range(len(self._motions)))
            rules.append(f"@media (prefers-reduced-motion:reduce){{{names}{{animation:none}}}}")
        return "".join(rules)

    def shapes(self, shapes: Iterable[Shape]) -> Iterator[str]:
        for shape in shapes:
            match shape:
                case Path():
                    if data := "".join(_path(line, shape.closed) for line in shape.lines):
                        yield f'<path d="{data}"{self._paint(shape.paint)}/>'
                case Disc():
                    x, y = shape.centre
                    place = f'cx="{_n(x)}" cy="{_n(y)}" r="{_n(shape.radius)}"'
                    yield f"<circle {place}{self._paint(shape.paint)}/>"
                case Text():
                    yield self._text(shape)
                case Group():
                    yield from self._group(shape)

    def _group(self, group: Group) -> Iterator[str]:
        attributes = ""
        if group.clip is not None:
            attributes += f' clip-path="url(#@-clip{len(self.clips)})"'
            self.clips.append(f'<clipPath id="@-clip{len(self.clips)}">{_rect(group.clip)}</clipPath>')
        if group.motion is not None:
            x, y, turn, stretch = group.motion.places[0]
            attributes += (
                f' class="rpr-motion-{len(self._motions)}" transform="translate({_n(x)} {_n(y)})'
                f'rotate({_n(turn)})scale({_n(stretch, 3)} 1)"'
            )
            self._motions.append(group.motion)
        yield f"<g{attributes}>"
        if group.name:
            yield f"<title>{escape(group.name, quote=False)}</title>"
        yield from self.shapes(group.shapes)
        yield "</g>"

    def _paint(self, paint: Paint) -> str:
        fill, stroke = self.colour("fill", paint.fill), self.colour("stroke", paint.stroke)
        if paint.fill and paint.stroke and self._theme == "auto":
            classes = f"rpr-fill-{paint.fill} rpr-stroke-{paint.stroke}"
            fill = f' class="{classes}" fill="{colour(paint.fill, self._theme)}"'
            stroke = f' stroke="{colour(paint.stroke, self._theme)}"'
        if paint.stroke:
            width = "" if paint.width == 1 else f' stroke-width="{_n(paint.width)}"'
            dash = f' stroke-dasharray="{" ".join(map(_n, paint.dash))}"' if paint.dash else ""
            stroke += f'{width}{dash} stroke-linejoin="round"'
        opacity = f' fill-opacity="{_n(paint.opacity, 2)}"' if paint.opacity != 1 else ""
        return fill + stroke + opacity

    def _text(self, text: Text) -> str:
        x, y = text.at
        paint = self._paint(Paint(text.role, text.halo, 4)) if text.halo else self.colour("fill", text.role)
        attributes = [
            f'x="{_n(x)}" y="{_n(y + _BASELINE * text.size)}" font-size="{_n(text.size)}"',
            f' text-anchor="{text.anchor}"' if text.anchor != "start" else "",
            ' font-weight="bold"' if text.bold else "",
            f' transform="rotate({_n(text.turn)} {_n(x)} {_n(y)})"' if text.turn else "",
            ' paint-order="stroke"' if text.halo else "",
        ]
        words = escape(text.words, quote=False)
        if self._has_symbols and text.role != "cusp":
            words = symbols(words, '<tspan font-style="italic">{}</tspan>{}')
        return f"<text {''.join(attributes)}{paint}>{words}</text>"


def _path(line: Line, closed: bool) -> str:
    """A polyline; points that round to the same place are written once."""
    points = [f"{_n(x)} {_n(y)}" for x, y in line]
    different = [points[0], *(b for a, b in pairwise(points) if b != a)] if points else []
    if len(different) < 2:
        return ""
    if closed and different[0] == different[-1]:
        different.pop()
    return "M" + "L".join(different) + ("Z" if closed else "")


def _rect(box: Box) -> str:
    place = f'x="{_n(box.x0)}" y="{_n(box.y0)}"'
    return f'<rect {place} width="{_n(box.width)}" height="{_n(box.height)}"/>'


def _n(value: float, places: int = 1) -> str:
    """A number with few decimals, without trailing zeros."""
    text = f"{value:.{places}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
