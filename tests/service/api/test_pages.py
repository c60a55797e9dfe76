"""What the pages show is what happens: commands, and calls from MATLAB, JavaScript and spreadsheets."""

from __future__ import annotations

import doctest
import json
import re
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Any

import httpx
import pytest

from service.cli.main import main
from tests.support.processes import PATIENCE, ROOT, until

SERVICE = "http://127.0.0.1:8000"
TEXTS = {path.stem: path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs").glob("*.md"))}
LONG = {page: pytest.param(page, marks=pytest.mark.long) for page in ("census", "gate")}
ADDRESSES = sorted(
    {
        found
        for text in TEXTS.values()
        for found in re.findall(rf"{SERVICE}(/[^\s`'\"]*a2x=15[^\s`'\"]*)", text)
    }
)
CSV_HEADS = ("l1,count,cusp,alpha_deg,theta1_deg,l2,l3,error", "from,to,count,transition_at_end")


def blocks(page: str, language: str) -> str:
    return "\n".join(re.findall(rf"^```{language}\n(.*?)^```$", TEXTS[page], re.MULTILINE | re.DOTALL))


def document(api: httpx.Client, method: str, address: str, **options: Any) -> Any:
    """The answer to a call that is repeated, as the pages say, until it is no job."""
    return until(lambda: known(api.request(method, address, **options)))


def known(answer: httpx.Response) -> httpx.Response | None:
    assert answer.status_code in (200, 202), answer.text
    return answer if answer.status_code == 200 else None


def matches(printed: str, got: str) -> bool:
    """Whether an output is what a page shows, `…` standing for anything."""
    return doctest.OutputChecker().check_output(printed.replace("…", "..."), got, doctest.ELLIPSIS)


@pytest.mark.parametrize("page", ["first-table", "scan", *LONG.values()])
def test_commands_print_what_is_below_them(
    page: str,
    api: httpx.Client,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    pairs = re.findall(
        r"^```sh\n(.*?)^```\n(?:\n```text\n(.*?)^```$)?", TEXTS[page], re.MULTILINE | re.DOTALL
    )
    assert pairs
    for command, printed in pairs:
        if command.startswith("rpr-cusps"):
            assert main(shlex.split(command)[1:]) == 0
        elif "pip install" not in command and (shutil.which("curl") or "curl" not in command):
            here = command.replace(SERVICE, str(api.base_url).rstrip("/"))
            subprocess.run(["sh", "-ec", here], timeout=PATIENCE, check=True)
        else:
            continue
        got = capfd.readouterr().out
        assert matches(printed.strip(), got.strip()), got


@pytest.mark.parametrize("page", ["first-table", "scan", LONG["census"]])
def test_python(page: str) -> None:
    session = doctest.DocTestParser().get_doctest(blocks(page, "pycon"), {}, page, page, 0)
    assert session.examples
    assert doctest.DocTestRunner().run(session).failed == 0


@pytest.mark.parametrize("address", ADDRESSES)
def test_addresses(api: httpx.Client, address: str) -> None:
    answer = document(api, "GET", address)
    if "format=csv" in address:
        assert answer.headers["content-type"].startswith("text/csv")
        assert answer.text.splitlines()[0] in CSV_HEADS


def test_matlab(api: httpx.Client) -> None:
    def struct(*members: Any) -> dict[str, Any]:
        return dict(zip(members[::2], members[1::2], strict=True))

    code = blocks("matlab", "matlab")
    names: dict[str, Any] = {"struct": struct}
    questions = []
    for name, value in re.findall(r"^(geometry|question) = (.*);$", code, re.MULTILINE):
        names[name] = eval(value.replace("{{", "[").replace("}}", "]"), names)
        questions.append(names[name])
    [media, wait] = re.findall(r"'MediaType', '(.*?)'.*'HeaderFields', \{'Prefer', '(.*?)'\}", code)[0]
    paths = dict.fromkeys(re.findall(rf"{SERVICE}(/v1/\S+float)", code))
    tables, poses = [
        document(
            api, "POST", path, content=json.dumps(question), headers={"Content-Type": media, "Prefer": wait}
        )
        for path, question in zip(paths, questions[1:], strict=True)
    ]
    slices = tables.json()["slices"]
    [counts, lengths] = [
        re.findall(r"[\d.]+", line) for line in re.findall(r"% ( *\d.*)", code) if "202" not in line
    ]
    assert [part["count"] for part in slices] == [int(count) for count in counts]
    assert [f"{cusp['l2']:.4f}" for cusp in slices[0]["cusps"]] == lengths
    assert all(isinstance(pose["alpha_deg"], float) for pose in poses.json()["poses"])


def test_javascript_calls(api: httpx.Client) -> None:
    code = blocks("javascript", "javascript")
    geometry = json.loads(re.search(r"geometry = (\{.*\});", code)[1])  # type: ignore[index]
    calls = re.findall(r'ask\("([\w-]+)", (\{.*\}), "(.+)"\)', code)
    assert [kind for kind, _, _ in calls] == ["cusp-tables", "censuses"]
    for kind, question, preference in calls:
        body = question.replace('"geometry": geometry', f'"geometry": {json.dumps(geometry)}')
        headers = {"Content-Type": "application/json", "Prefer": preference}
        answer = document(api, "POST", f"/v1/{kind}?numbers=float", content=body, headers=headers).json()
        counts = [part["count"] for part in answer.get("slices") or answer["intervals"]]
        assert f"// {counts!r}".replace("[", "[ ").replace("]", " ]") in code


def runs_events() -> bool:
    program = ["node", "--experimental-eventsource", "-e", "new EventSource('http://127.0.0.1:1').close()"]
    return bool(shutil.which("node")) and subprocess.run(program, capture_output=True).returncode == 0


@pytest.mark.skipif(not runs_events(), reason="needs Node with EventSource")
def test_javascript(api: httpx.Client, tmp_path: Path) -> None:
    script = tmp_path / "page.mjs"
    script.write_text(blocks("javascript", "javascript").replace(SERVICE, str(api.base_url).rstrip("/")))
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
    assert set(typed) | {"error"} == set(rows[0].split(","))
    assert len(rows) == 1 + 6 + 6 + 8


def test_a_formula_of_excel(api: httpx.Client) -> None:
    formula = re.search(rf'WEBSERVICE\("{SERVICE}(/v1.*)\),', TEXTS["spreadsheets"])[1]  # type: ignore[index]
    cells = dict(zip("ABCDEFG", ["15.91", "0", "10", "17.04", "16.54", "20.84", "14.98"], strict=True))
    address = re.sub(r'"&([A-G])1(?:&"|$)', lambda found: cells[found[1]], formula)
    assert len(document(api, "GET", address).text.split("\n")) == 1 + 6 + 1
