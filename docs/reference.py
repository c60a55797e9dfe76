"""Writes the tables of docs/reference.md from the code that they describe, and the terms of the explorer.

python docs/reference.py            rewrite the text between the markers, and the terms from docs/glossary.md
python docs/reference.py --check    write nothing; exit 1 with a diff if a file is out of date
"""

from __future__ import annotations

import argparse
import difflib
import inspect
import json
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from prometheus_client.metrics import MetricWrapperBase
from pydantic import BaseModel
from redis import Redis

import rpr_solver
from service.api import Settings
from service.api.app import create_app
from service.api.metrics import Metrics, of_installation
from service.api.problems import ProblemType
from service.cli.main import COMMANDS, command_of
from service.client import ClientSettings
from service.schemas.limits import Limits
from service.webhooks import WebhookSettings
from worker.jobs.installation import Load
from worker.jobs.queue import JobQueue
from worker.limits import is_setting
from worker.settings import ConnectionSettings, WorkerSettings, written

FILE = Path(__file__).with_name("reference.md")
GLOSSARY = FILE.with_name("glossary.md")
TERMS = FILE.parents[1] / "service/api/web/explorer/glossary.json"
GROUPS: dict[str, type[BaseModel]] = {
    "limits of requests": Limits,
    "API process": Settings,
    "webhooks": WebhookSettings,
    "jobs and workers": WorkerSettings,
    "connection to Redis": ConnectionSettings,
    "clients": ClientSettings,
}


def settings() -> Iterator[str]:
    """Yields every setting, group by group."""
    for group, model in GROUPS.items():
        rows = [
            (f"`RPR_CUSPS_{name.upper()}`", f"`{written(field.default)}`", field.description or "")
            for name, field in model.model_fields.items()
            if is_setting(field)
        ]
        yield from table((group, "default", "meaning"), rows)


def calls() -> Iterator[str]:
    """Yields every call of the HTTP API, with the forms of its answer."""
    contract = create_app(Settings(limits=Limits())).openapi()
    rows = [
        (f"`{method.upper()} {path}`", call["summary"], ", ".join(forms(call["responses"])) or "–")
        for path, methods in contract["paths"].items()
        for method, call in methods.items()
        if method != "parameters"
    ]
    return table(("call", "what it answers", "forms"), rows)


def forms(responses: Mapping[str, dict[str, Any]]) -> Iterator[str]:
    """Yields the media types of the answers to a call that succeed, in short."""
    kinds = {kind: None for status, r in responses.items() if status < "3" for kind in r.get("content", ())}
    for kind in dict.fromkeys(kind.partition(";")[0].partition("/")[2] for kind in kinds):
        yield {"event-stream": "events", "x-ndjson": "NDJSON", "plain": "text"}.get(kind, kind.upper())


def problems() -> Iterator[str]:
    """Yields every type of problem, by status."""
    kinds = sorted(ProblemType, key=lambda kind: (kind.status, kind.slug))
    rows = [(f"`{kind.slug}`", str(kind.status), kind.meaning) for kind in kinds]
    return table(("type, at `/problems/…`", "status", "meaning"), rows)


def metrics() -> Iterator[str]:
    """Yields every metric, by what it is about."""
    for group, members in families().items():
        rows = [
            (f"`{one.name}`", one.kind, ", ".join(f"`{x}`" for x in one.labels) or "–", one.meaning)
            for one in members
        ]
        yield from table((group, "type", "labels", "meaning"), rows)


class Family(NamedTuple):
    """A metric as it is in the text format."""

    name: str
    kind: str
    labels: tuple[str, ...]
    meaning: str

    @classmethod
    def of(cls, metric: Any) -> Family:
        """Returns what a metric of `prometheus_client`, or a family of its samples, says of itself."""
        [about] = metric.describe() if isinstance(metric, MetricWrapperBase) else [metric]
        name = about.name + "_total" * (about.type == "counter")
        return cls(name, about.type, tuple(metric._labelnames), about.documentation)


def families() -> dict[str, list[Family]]:
    """Returns every metric, by what it is about; nothing is connected."""
    own = vars(Metrics(JobQueue(Redis()))).values()
    return {
        "of one API process": [Family.of(one) for one in own if isinstance(one, MetricWrapperBase)],
        "of the whole installation": [Family.of(one) for one in of_installation(Load())],
    }


def options() -> Iterator[str]:
    """Yields every option of every command."""
    for name, command in commands():
        yield from table((f"`rpr-cusps {name}`", "meaning"), map(option_row, visible(command)))


def names() -> Iterator[str]:
    """Yields every public name of the solver."""
    rows = []
    for name in sorted(rpr_solver.__all__, key=lambda name: (not name.isupper(), name)):
        value = getattr(rpr_solver, name)
        if inspect.isclass(value) or inspect.isfunction(value):
            summary = " ".join((inspect.getdoc(value) or "").partition("\n\n")[0].split())
            meaning = re.sub(r":\w+:`|``", "`", summary)
        else:
            meaning = f"`{', '.join(value) if isinstance(value, Mapping) else value}`"
        rows.append((f"`{name}`", meaning))
    return table(("`rpr_solver.`", "meaning"), rows)


def commands() -> list[tuple[str, argparse.ArgumentParser]]:
    """Returns the commands of `rpr-cusps` and their parsers."""
    parsers = {name: argparse.ArgumentParser() for name in COMMANDS}
    for name, parser in parsers.items():
        command_of(name).configure(parser)
    return [pair for name, parser in parsers.items() for pair in with_actions(name, parser)]


def with_actions(name: str, parser: argparse.ArgumentParser) -> list[tuple[str, argparse.ArgumentParser]]:
    """Returns a command, or in its place its actions, such as `keys create`."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            return [(f"{name} {word}", below) for word, below in action.choices.items()]
    return [(name, parser)]


def visible(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """Returns the arguments that a parser's help shows, except `--help`."""
    return [a for a in parser._actions if a.help != argparse.SUPPRESS and a.dest != "help"]


def option_row(action: argparse.Action) -> tuple[str, str]:
    """Returns an argument as it is written, and its help."""
    value = action.metavar or (f"{{{','.join(action.choices)}}}" if action.choices else action.dest.upper())
    shown = [f"{name} {value}" if action.nargs != 0 else name for name in action.option_strings] or [value]
    return ", ".join(f"`{text}`" for text in shown), (action.help or "").replace("%%", "%")


def table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> Iterator[str]:
    """Yields a table in Markdown and an empty line."""
    for row in (head, ("---",) * len(head), *rows):
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |"
    yield ""


def rewritten(text: str) -> str:
    """Returns the document with new tables."""
    for part in (settings, calls, problems, metrics, options, names):
        begin, end = f"<!-- {part.__name__} -->\n", f"<!-- end of {part.__name__} -->\n"
        before, _, rest = text.partition(begin)
        _, marker, after = rest.partition(end)
        assert marker, f"{FILE.name} has no markers for {part.__name__}"
        text = before + begin + "\n" + "\n".join(part()) + "\n" + end + after
    return text


def terms() -> str:
    """Returns the terms of the field with their definitions, without links and pictures, as JSON."""
    field = GLOSSARY.read_text(encoding="utf-8").partition("\n## The service")[0]
    entries = re.findall(r"^### (.+)\n((?:(?!#).*\n?)*)", field, re.MULTILINE)
    bare = {name: re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text) for name, text in entries}
    plain = {name: " ".join(re.sub("[*`]", "", text).split()) for name, text in bare.items()}
    return json.dumps(plain, ensure_ascii=False, indent=0) + "\n"


def main(argv: list[str] | None = None) -> int:
    """Write or check the tables."""
    parser = argparse.ArgumentParser(prog="python docs/reference.py", description=main.__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 with a diff")
    check = parser.parse_args(argv).check
    old = [FILE.read_text(encoding="utf-8"), TERMS.read_text(encoding="utf-8") if TERMS.exists() else ""]
    new = [rewritten(old[0]), terms()]
    if not check:
        FILE.write_text(new[0], encoding="utf-8")
        TERMS.write_text(new[1], encoding="utf-8")
        return 0
    for file, before, after in zip((FILE, TERMS), old, new, strict=True):
        lines = before.splitlines(True), after.splitlines(True)
        sys.stdout.writelines(difflib.unified_diff(*lines, file.name, "the code"))
    return int(old != new)


if __name__ == "__main__":
    sys.exit(main())
