"""HTML pages and their files: the explorer, the interactive documentation, and the types of problems. Health,
readiness, version, limits and metrics."""

from __future__ import annotations

import html
import json
import os
import platform
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from string import Template

from anyio import to_thread
from fastapi import APIRouter, Request, Response
from prometheus_client.exposition import CONTENT_TYPE_PLAIN_0_0_4
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

import rpr_solver
from rpr_solver import EXAMPLES
from rpr_solver.contract import LENGTHS
from rpr_solver.designs.plan import NEEDED
from rpr_solver.errors import clipped
from service import __version__
from service.api.context import ContextDep
from service.api.contract import responses as doc
from service.api.forms import json_answer
from service.api.problems import ProblemError, ProblemType
from service.api.settings import RETRY_SECONDS, here
from service.commit import commit
from service.schemas.answers import json_bytes
from service.schemas.geometry import SixNumbers, schema_of_geometry
from service.schemas.limits import Limits


class Assets(StaticFiles):
    """Files that a browser asks for again each time, so that modules of two versions never meet in a page."""

    def file_response(
        self,
        full_path: str | os.PathLike[str],
        stat_result: os.stat_result,
        scope: Scope,
        status_code: int = 200,
    ) -> Response:
        """Answer with a file, or 304 if the browser has it."""
        response = super().file_response(full_path, stat_result, scope, status_code)
        response.headers["Cache-Control"] = "no-cache"
        return response


POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors {ancestors}"
)
"""Nothing inline, nothing from elsewhere."""

NOBODY = "'none'"
"""No page may frame this one."""

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
    is_absent = any(find_spec(name) is None for name in NEEDED)
    return {
        "examples": "".join(_examples()),
        "fields": "".join(_fields()),
        "preloads": "".join(_preloads()),
        "improve": " data-absent hidden" if is_absent else "",
    }


def _examples() -> Iterator[str]:
    for name, manipulator in EXAMPLES.items():
        text = html.escape(",".join(map(str, manipulator.to_json().values())))
        yield f'<option value="{text}" data-l1="{FIRST_SLICES[name]}">{html.escape(name)}</option>\n'


def _fields() -> Iterator[str]:
    meanings = {
        name: html.escape((field.description or "").rstrip(".").split(",")[0].split(";")[0])
        for name, field in SixNumbers.model_fields.items()
    }
    for triangle, letter in (("base", "A"), ("platform", "B")):
        own = [name for name in LENGTHS if name.startswith("a" if triangle == "base" else "d")]
        forms = _forms(triangle, letter)
        kind = "lengths" if triangle == "base" else "sides"
        forms[kind] = [(name, f"{name}<small>{meanings[name]}</small>", name) for name in own]
        words = {"lengths": "a2x …", "circumradius": "circle"}
        yield f'<fieldset class="choice"><legend>{triangle.capitalize()}</legend>\n'
        for form in forms:
            checked = " checked" if form == kind else ""
            yield (
                f'<label><input type="radio" name="{triangle}-form" data-triangle="{triangle}" value="{form}"'
                f"{checked}> {words.get(form, form)}</label>\n"
            )
        yield "</fieldset>\n"
        for form, numbers in forms.items():
            pairs, hidden = " pairs" if form == "points" else "", "" if form == kind else " hidden"
            yield f'<div class="fields{pairs}" data-of="{triangle}" data-form="{form}"{hidden}>\n'
            for name, label, spoken in numbers:
                yield f'<label>{label} <input id="{name}" class="exact" data-name="{spoken}"></label>\n'
            yield "</div>\n"


def _forms(triangle: str, letter: str) -> dict[str, list[tuple[str, str, str]]]:
    """The spellings of a triangle: the field, the label and the spoken name of each number."""
    one, two, three = (f"{letter}{n}" for n in (1, 2, 3))
    sides = [f"{one}{two}", f"{two}{three}", f"{three}{one}"]
    corners = [
        (f"points[{n}][{k}]", corner, axis)
        for n, corner in enumerate((one, two, three))
        for k, axis in enumerate("xy")
    ]
    return {
        **({"lengths": []} if triangle == "base" else {}),
        "points": [
            (f"{triangle}.{place}", f"{corner} {axis}", f"{axis} of {corner}")
            for place, corner, axis in corners
        ],
        "sides": [(f"{triangle}.sides[{n}]", side, side) for n, side in enumerate(sides)],
        "equilateral": [(f"{triangle}.equilateral", "side", f"the side of the {triangle}")],
        "circumradius": [
            (f"{triangle}.circumradius", "radius of the circle through the corners", "the radius")
        ],
    }


def _preloads() -> Iterator[str]:
    modules = sorted(path.name for path in (WEB / "explorer").glob("*.js"))
    for address in ("jsxgraph/jsxgraphcore.mjs", *(f"explorer/{name}" for name in modules)):
        yield f'<link rel="modulepreload" href="static/{address}">\n'


WEB = Path(__file__).parents[1] / "web"

router = APIRouter(include_in_schema=False)


@router.get("/")
async def index() -> Response:
    """The explorer."""
    return _page("explorer.html", markup=explorer_markup())


@router.get("/embed")
async def embed(context: ContextDep) -> Response:
    """One board, which pages of others may frame: it uses no key, and nothing in it changes the service."""
    return _page("embed.html", ancestors=" ".join(context.settings.embed_origins) or NOBODY)


@router.get("/docs")
async def docs() -> Response:
    """The page of the API, which shows the contract."""
    return _page("docs.html")


@router.get("/openapi.json")
async def openapi_json(request: Request) -> Response:
    """The OpenAPI document."""
    contract, base = request.app.openapi(), here("")
    if base:
        contract = {**contract, "servers": [{"url": base}]}
    return json_answer(contract, "no-cache")


@router.get("/openapi.yaml")
async def openapi_yaml(request: Request) -> Response:
    """The OpenAPI document for tools that ask for YAML, which JSON is (YAML 1.2, section 1.2)."""
    contract = json.loads(bytes((await openapi_json(request)).body))
    text = json.dumps(contract, indent=2, ensure_ascii=False) + "\n"
    return Response(text, headers={"Cache-Control": "no-cache"}, media_type="application/yaml")


@router.get("/schemas/geometry.json")
async def geometry_schema(request: Request) -> Response:
    """The JSON Schema of a file with a geometry, for editors."""
    address = str(request.base_url).rstrip("/") + here("/schemas/geometry.json")
    body = json_bytes(schema_of_geometry(address))
    return Response(body, headers={"Cache-Control": "no-cache"}, media_type="application/schema+json")


@router.get("/problems")
async def problems() -> Response:
    """All types of problems."""
    rows = "".join(
        f'<tr><td>{kind.status}</td><td><a href="problems/{kind.slug}"><code>{kind.slug}</code></a></td>'
        f"<td>{html.escape(kind.title)}</td></tr>"
        for kind in sorted(ProblemType, key=lambda kind: (kind.status, kind.slug))
    )
    return _page("problems.html", markup={"rows": rows})


@router.get("/problems/{slug}")
async def problem(slug: str) -> Response:
    """The meaning of one type of problem."""
    for kind in ProblemType:
        if kind.slug == slug:
            example = ProblemError(kind, "…", errors=[("…", "…")]).document("/v1/…")
            text = {
                "slug": kind.slug,
                "title": kind.title,
                "status": str(kind.status),
                "meaning": kind.meaning,
                "example": json.dumps(example, indent=2, ensure_ascii=False),
            }
            return _page("problem.html", text=text)
    raise ProblemError(
        ProblemType.NOT_FOUND, f"There is no problem type {clipped(slug, 80)!r}; /problems lists all."
    )


def _page(
    name: str,
    *,
    text: Mapping[str, str] | None = None,
    markup: Mapping[str, str] | None = None,
    ancestors: str = NOBODY,
) -> Response:
    escaped = {key: html.escape(value) for key, value in (text or {}).items()}
    body = _template(name).substitute(version=__version__, **escaped, **(markup or {}))
    headers = {
        "Content-Security-Policy": POLICY.format(ancestors=ancestors),
        "Referrer-Policy": "no-referrer",
        "Cache-Control": "no-cache",
    }
    return Response(body, headers=headers, media_type="text/html")


@cache
def _template(name: str) -> Template:
    return Template((WEB / name).read_text(encoding="utf-8"))


status = APIRouter(tags=["operations"])

_LIBRARIES = ("python-flint", "fastapi", "rq", "redis")


@status.get("/healthz", summary="Whether this process is running", responses=doc.HEALTH_RESPONSES)
async def healthz() -> Response:
    """Answers while the process runs; independent of Redis and the workers."""
    return json_answer({"status": "ok"})


@status.get("/readyz", summary="Whether requests can be served", responses=doc.READY_RESPONSES)
async def readyz(context: ContextDep) -> Response:
    """Ready if jobs can run: Redis accepts data, and at least one worker of the same solver version is alive.
    `warnings` lists risks to jobs: settings of Redis, or a lane of the queue that stands still, such as
    small questions that have waited for more than a minute although workers are alive.
    """
    state = await context.redis(context.queue.readiness)
    if state.workers:
        return json_answer({"status": "ready", "workers": state.workers, "warnings": state.warnings})
    detail = "No workers of this solver version are running; jobs would stay queued."
    raise ProblemError(ProblemType.NO_WORKER, detail, retry_s=RETRY_SECONDS)


@status.get(
    "/v1/version",
    summary="Versions of the service, the solver and its libraries",
    responses=doc.VERSION_RESPONSES,
)
async def get_version() -> Response:
    """The software that computes the answers; `solver_version` changes whenever an answer may change."""
    return json_answer(
        {
            "service": __version__,
            "commit": await to_thread.run_sync(commit),
            "solver_version": rpr_solver.SOLVER_VERSION,
            "python": platform.python_version(),
            "libraries": {name: version(name) for name in _LIBRARIES},
        },
        "no-cache",
    )


@status.get("/v1/limits", summary="The limits on requests", responses=doc.LIMITS_RESPONSES)
async def get_limits(context: ContextDep) -> Response:
    """Returns every limit by name, with its value and meaning."""
    limits = context.settings.limits
    return json_answer(
        {
            name: {"value": getattr(limits, name), "description": field.description}
            for name, field in Limits.model_fields.items()
        },
        "no-cache",
    )


@status.get("/metrics", summary="Metrics in the Prometheus text format", responses=doc.METRICS_RESPONSES)
async def get_metrics(context: ContextDep) -> Response:
    """Counts the requests of this process, and reads the queue and the workers at each scrape."""
    return Response(
        await context.scraping(context.metrics.text),
        headers={"Cache-Control": "no-store", "Content-Type": CONTENT_TYPE_PLAIN_0_0_4},
    )
