"""What the pages show is what happens: commands, and calls from MATLAB, JavaScript and spreadsheets."""

from __future__ import annotations

import doctest
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import httpx
import pytest
import yaml

from service.cli.main import main
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.pages import BLOCKS, NOT_RUN, Block, blocks_of, pages
from tests.support.processes import PATIENCE, ROOT, until
from tests.support.sampling import long

SERVICE = "http://127.0.0.1:8000"
TEXTS = {path.stem: path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs").glob("*.md"))}
LONG = {
    *("docs/census.md", "docs/design.md", "docs/gate.md", "docs/margins.md", "docs/verify.md"),
    *(
        "docs/export.md",
        "docs/figures.md",
        "docs/paths.md",
        "docs/assembly-modes.md",
        "docs/drawing-to-controller.md",
    ),
    "examples/README.md",
}
"""Pages of which each time the cheapest block is run, and all of them with `--long`."""

CHEAPEST = {
    **{("docs/design.md", language): -1 for language in ("sh", "pycon")},
    ("docs/margins.md", "sh"): -1,
    ("docs/margins.md", "pycon"): 1,
}
"""Which block that is, if not the first."""

STRICT = 'set -euo pipefail; curl() { command curl --fail-with-body "$@"; }\n'
ADDRESSES = sorted(
    {
        found
        for text in TEXTS.values()
        for found in re.findall(rf"{SERVICE}(/[^\s`'\"]*a2x=15[^\s`'\"]*)", text)
    }
)
CSV_HEADS = (
    "l1,count,cusp,alpha_deg,theta1_deg,l2,l3,error,kind,equation",
    "from,to,count,transition_at_end,degenerate",
)


def sampled(language: str) -> list[Any]:
    """The blocks of a language to run, page by page."""
    cases = []
    for page in pages(language):
        blocks = blocks_of(page, language)
        if page in LONG:
            cheapest = blocks[CHEAPEST.get((page, language), 0)]
            cases += [pytest.param([cheapest], id=f"{page}, one block"), long(blocks, id=page)]
        else:
            cases.append(pytest.param(blocks, id=page))
    return cases


def code_of(page: str) -> str:
    """What a page shows in the language that it is about."""
    return "\n".join(
        block.text for block in BLOCKS if block.page == f"docs/{page}.md" and block.language == page
    )


def document(api: httpx.Client, method: str, address: str, **options: Any) -> Any:
    """The answer to a call that is repeated, as the pages say, until it is no job."""
    return until(lambda: known(api.request(method, address, **options)))


def known(answer: httpx.Response) -> httpx.Response | None:
    assert answer.status_code in (200, 202), answer.text
    return answer if answer.status_code == 200 else None


def matches(printed: str, got: str) -> bool:
    """Whether an output is what a page shows, `…` standing for anything."""
    return doctest.OutputChecker().check_output(printed.replace("…", "..."), got, doctest.ELLIPSIS)


@pytest.mark.parametrize("blocks", sampled("sh"))
def test_commands_print_what_is_below_them(
    blocks: list[Block],
    api: httpx.Client,
    valkey: EmbeddedValkey,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    monkeypatch.setenv("RPR_CUSPS_REDIS_URL", f"{valkey.url}?db=4")  # of `keys` and `store`
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    (tmp_path / "robots").symlink_to(ROOT / "examples" / "passing" / "robots")
    for block in blocks:
        lines = block.text.splitlines()
        if all(re.fullmatch(r"rpr-cusps [^|>]*", line) for line in lines):
            assert [main(shlex.split(line, comments=True)[1:]) for line in lines] == [0] * len(lines)
        elif shutil.which("curl") or "curl" not in block.text:
            script = STRICT + block.text.replace(SERVICE, str(api.base_url).rstrip("/"))
            subprocess.run(["bash", "-c", script], timeout=PATIENCE, check=True)
        else:
            continue
        got = capfd.readouterr().out
        assert not block.printed or matches(block.printed.strip(), got.strip()), f"{block.name}: {got}"


@pytest.mark.parametrize("blocks", sampled("pycon"))
def test_python(blocks: list[Block], base_url: str) -> None:
    code = "\n".join(block.text for block in blocks).replace(SERVICE, base_url)
    session = doctest.DocTestParser().get_doctest(code, {}, blocks[0].page, blocks[0].page, 0)
    assert session.examples
    assert doctest.DocTestRunner().run(session).failed == 0


def is_program(page: str) -> bool:
    """Whether the Python of a page has no prompts; `test_docs` runs what has prompts, as tutorials."""
    return not any(block.text.startswith(">>> ") for block in blocks_of(page, "python"))


@pytest.mark.parametrize("page", [page for page in pages("python") if is_program(page)])
def test_programs_in_python(page: str, base_url: str) -> None:
    names: dict[str, Any] = {}
    for block in blocks_of(page, "python"):
        exec(compile(block.text.replace(SERVICE, base_url), block.name, "exec"), names)


@pytest.mark.parametrize("block", [b for b in BLOCKS if b.language == "json"], ids=lambda block: block.name)
def test_json(block: Block) -> None:
    json.loads(re.sub(r",?\s*…(?=\s*[}\]])", "", block.text))


@pytest.mark.parametrize("block", [b for b in BLOCKS if b.language == "yaml"], ids=lambda block: block.name)
def test_yaml(block: Block) -> None:
    assert yaml.safe_load(block.text)


@pytest.mark.parametrize("block", NOT_RUN, ids=lambda block: block.name)
def test_what_is_not_run(block: Block) -> None:
    pytest.skip(f"{block.name} is not run: {block.reason}")


@pytest.mark.parametrize("address", ADDRESSES)
def test_addresses(api: httpx.Client, address: str) -> None:
    answer = document(api, "GET", address)
    if "format=csv" in address:
        assert answer.headers["content-type"].startswith("text/csv")
        assert answer.text.splitlines()[0] in CSV_HEADS


def run_matlab(api: httpx.Client, code: str) -> dict[str, Any]:
    """Runs the assignments of a program in MATLAB, calls of the service included; gives its variables."""

    def pairs(*members: Any) -> dict[str, Any]:
        return dict(zip(members[::2], members[1::2], strict=True))

    def struct(*members: Any) -> dict[str, Any]:
        return {name: v[0] if isinstance(v, list) else v for name, v in pairs(*members).items()}

    def webread(address: str, *rest: Any) -> list[str]:
        assert rest[-1].ContentType == "table"
        address = address.removeprefix(SERVICE)
        return document(api, "GET", address, params=pairs(*rest[:-1])).text.splitlines()

    def webwrite(address: str, question: dict[str, Any], options: SimpleNamespace) -> Any:
        headers = {"Content-Type": options.MediaType, **pairs(*options.HeaderFields)}
        address = address.removeprefix(SERVICE)
        return document(api, "POST", address, content=json.dumps(question), headers=headers).json()

    def weboptions(*members: Any) -> SimpleNamespace:
        return SimpleNamespace(**pairs(*members))

    names = {"struct": struct, "webread": webread, "webwrite": webwrite, "weboptions": weboptions}
    for statement in re.findall(r"^[\w.]+ = .*;$", re.sub(r" \.\.\.\n *", " ", code), re.MULTILINE):
        python = re.sub(r"(\w+)\{:\}", r"*\1", statement).translate(str.maketrans("{}", "[]"))
        exec(python.removesuffix(";"), names)
        if "webwrite" in statement:
            names["slices"] = names["answer"].get("slices", names.get("slices"))
    return names


def test_matlab(api: httpx.Client) -> None:
    code = code_of("matlab")
    found = run_matlab(api, code)
    assert (found["cusps"][0], len(found["cusps"])) == (CSV_HEADS[0], 1 + 6 + 8)
    assert (found["census"][0], len(found["census"])) == (CSV_HEADS[1], 1 + 7)
    [counts, lengths] = re.findall(r"% (\d[\d. ]*)$", code, re.MULTILINE)
    assert [part["count"] for part in found["slices"]] == [int(count) for count in counts.split()]
    assert [f"{float(cusp['l2']):.4f}" for cusp in found["slices"][0]["cusps"]] == lengths.split()


def test_javascript_calls(api: httpx.Client) -> None:
    code = code_of("javascript")
    geometry = json.loads(re.search(r"geometry = (\{.*?\});", code, re.DOTALL)[1])  # type: ignore[index]
    calls = re.findall(r'ask\("([\w-]+)", (\{.*\}), "(.+)"\)', code)
    assert [kind for kind, _, _ in calls] == ["cusp-tables", "censuses"]
    for kind, question, preference in calls:
        body = question.replace('"geometry": geometry', f'"geometry": {json.dumps(geometry)}')
        headers = {"Content-Type": "application/json", "Prefer": preference}
        answer = document(api, "POST", f"/v1/{kind}", content=body, headers=headers).json()
        counts = [part["count"] for part in answer.get("slices") or answer["intervals"]]
        assert f"// {counts!r}".replace("[", "[ ").replace("]", " ]") in code


def runs_events() -> bool:
    program = ["node", "--experimental-eventsource", "-e", "new EventSource('http://127.0.0.1:1').close()"]
    return bool(shutil.which("node")) and subprocess.run(program, capture_output=True).returncode == 0


@pytest.mark.skipif("not runs_events()", reason="needs Node with EventSource")
def test_javascript(api: httpx.Client, tmp_path: Path) -> None:
    script = tmp_path / "page.mjs"
    script.write_text(code_of("javascript").replace(SERVICE, str(api.base_url).rstrip("/")))
    command = ["node", "--experimental-eventsource", "--no-warnings", str(script)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=True)
    assert re.findall(r"\d+", done.stdout) == ["6", "8", "8", "10", "8", "6", "8", "6", "4"]


def test_power_query(api: httpx.Client) -> None:
    text = TEXTS["spreadsheets"]
    path = re.search(r'RelativePath = "(.*)"', text)[1]  # type: ignore[index]
    query = re.search(r"Query = \[(.*?)\]", text, re.DOTALL)[1]  # type: ignore[index]
    rows = document(
        api, "GET", f"/{path}", params=dict(re.findall(r'(\w+) = "(.*?)"', query))
    ).text.splitlines()
    typed = re.findall(r'\{"(\w+)", (?:type number|Int64.Type)\}', text)
    assert set(typed) | {"error", "kind", "equation"} == set(rows[0].split(","))
    assert len(rows) == 1 + 6 + 6 + 8


def test_a_formula_of_excel(api: httpx.Client) -> None:
    formula = re.search(rf'WEBSERVICE\("{SERVICE}(/v1.*)\),', TEXTS["spreadsheets"])[1]  # type: ignore[index]
    cells = dict(zip("ABCDEFG", ["15.91", "0", "10", "17.04", "16.54", "20.84", "14.98"], strict=True))
    address = re.sub(r'"&([A-G])1(?:&"|$)', lambda found: cells[found[1]], formula)
    assert len(document(api, "GET", address).text.split("\n")) == 1 + 6 + 1
