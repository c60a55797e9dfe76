"""The parts of the explorer that the server writes: its examples, its fields, and the list of its modules."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping
from functools import cache

from rpr_solver import EXAMPLES
from service.api.operations import WEB
from service.schemas.questions import Geometry

EXPLORER_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Nothing inline, nothing from elsewhere."""

FIRST_SLICES = {
    "innocenti": "27",
    "zein-flat": "35",
    "twelve-cusps": "8.28",
    "fourteen-cusps": "5.96",
    "sixteen-cusps": "14.46845",
    "eighteen-cusps": "15.6431",
}
"""The slice of each example that is shown first."""


@cache
def explorer_markup() -> Mapping[str, str]:
    """Returns the parts of the page by name, as HTML."""
    return {"examples": "".join(_examples()), "fields": "".join(_fields()), "preloads": "".join(_preloads())}


def _examples() -> Iterator[str]:
    for name, manipulator in EXAMPLES.items():
        text = html.escape(",".join(manipulator.to_json().values()))
        yield f'<option value="{text}" data-l1="{FIRST_SLICES[name]}">{html.escape(name)}</option>\n'


def _fields() -> Iterator[str]:
    for name, field in Geometry.model_fields.items():
        if name == "orientation":
            continue
        meaning = html.escape((field.description or "").rstrip(".").split(",")[0].split(";")[0])
        yield (
            f'<div><label for="{name}">{name}<small>{meaning}</small>\n'
            f'<input id="{name}" class="exact" inputmode="decimal" autocomplete="off" spellcheck="false" '
            f'aria-describedby="{name}-error"></label>\n<p class="error" id="{name}-error"></p></div>\n'
        )


def _preloads() -> Iterator[str]:
    modules = sorted(path.name for path in (WEB / "explorer").glob("*.js"))
    for address in ("jsxgraph/jsxgraphcore.mjs", *(f"explorer/{name}" for name in modules)):
        yield f'<link rel="modulepreload" href="static/{address}">\n'
