"""Every way to an answer gives the same bytes: library, clients, HTTP, batch, and the command line."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import anyio
import httpx
import pytest

import rpr_solver
from rpr_solver import Manipulator, Requirement, SolverError, table_document
from rpr_solver.article.table import article_document
from service.client import (
    Asked,
    AsyncServiceClient,
    ServiceClient,
    census,
    check,
    cusp_curves,
    cusp_table,
    poses,
)
from tests.support.cli_process import Run
from tests.support.families import FAMILIES, family
from tests.support.reference import CASES
from tests.support.stack import running

Answers = dict[str, bytes]
"""Name of a vector → its document as compact JSON."""


@dataclass(frozen=True)
class Vector:
    """A question in the words of the clients, of the library and of the command line."""

    asked: Asked[Any]
    library: Callable[[], object]
    command: Sequence[str]

    @property
    def manipulator(self) -> Manipulator:
        return self.asked.question.geometry


def table(m: Manipulator, lengths: Sequence[str], digits: int, leg: int = 1) -> Vector:
    return Vector(
        cusp_table(m, lengths, digits=digits, fixed_leg=leg),
        lambda: table_document(m, lengths, digits=digits, fixed_leg=leg),
        ("solve", *(word for x in lengths for word in (f"--l{leg}", x)), "--digits", str(digits)),
    )


def of_reference() -> Iterator[tuple[str, Vector]]:
    """Every slice of the reference vectors, and one of each with another leg fixed."""
    for n, case in enumerate(CASES):
        m, lengths = Manipulator.from_json(case["geometry"]), [item["l1"] for item in case["slices"]]
        yield f"{case['name']}, table", table(m, lengths, 90)
        yield f"{case['name']}, table, leg {2 + n % 2}", table(m, lengths[:1], 30, 2 + n % 2)


def of_families() -> Iterator[tuple[str, Vector]]:
    """Every kind of document of the degenerate families, the longer ones of some."""
    for n, name in enumerate(FAMILIES):
        m, leg = family(name), n % 3 + 1
        at, of = ("--digits", "15"), ("--fixed-leg", str(leg))
        yield (
            f"{name}, poses",
            Vector(
                poses(m, 7, "9.5", 11, digits=15),
                lambda m=m: rpr_solver.poses(m, 7, "9.5", 11, digits=15).to_json(),  # type: ignore[misc]
                ("poses", "--l1", "7", "--l2", "9.5", "--l3", "11", *at),
            ),
        )
        yield (
            f"{name}, census",
            Vector(
                census(m, fixed_leg=leg, digits=15),
                lambda m=m, leg=leg: rpr_solver.census(m, fixed_leg=leg, digits=15).to_json(),  # type: ignore[misc]
                ("census", *of, *at),
            ),
        )
        if n % 4 == 0:
            requirement = Requirement(leg, Fraction(5), Fraction(20), max_cusps=2)
            yield (
                f"{name}, check",
                Vector(
                    check(m, requirement, digits=15),
                    lambda m=m, r=requirement: rpr_solver.check(m, r, digits=15).to_json(),  # type: ignore[misc]
                    ("check", f"--l{leg}-range", "5:20", "--max-cusps", "2", *at),
                ),
            )
            yield (
                f"{name}, article",
                Vector(
                    cusp_table(m, "7.5", digits=15, method="article"),
                    lambda m=m: article_document(m, [Fraction("7.5")], 15),  # type: ignore[misc]
                    ("solve", "--l1", "7.5", "--method", "article", *at),
                ),
            )
        if name in ("both flat", "congruent"):
            yield (
                f"{name}, cusp curves",
                Vector(
                    cusp_curves(m, fixed_leg=leg, digits=15),
                    lambda m=m, leg=leg: rpr_solver.cusp_curves(m, fixed_leg=leg, digits=15).to_json(),  # type: ignore[misc]
                    ("cusp-curves", *of, *at),
                ),
            )


def compact(document: object) -> bytes:
    return json.dumps(document, separators=(",", ":"), ensure_ascii=False).encode()


def by_library(vectors: Mapping[str, Vector]) -> Answers:
    """The documents; those that the solver refuses are left out."""
    answers = {}
    for name, vector in vectors.items():
        try:
            answers[name] = compact(vector.library())
        except SolverError:
            continue
    return answers


def by_clients(url: str, vectors: Mapping[str, Vector]) -> Iterator[Answers]:
    """Of questions alone, and of a batch; by either client."""
    async_answers: Answers = {}

    async def ask_all() -> None:
        async with AsyncServiceClient(url) as client:
            for name, vector in vectors.items():
                async_answers[name] = (await client.ask(vector.asked)).content

    with ServiceClient(url) as client:
        yield {name: client.ask(vector.asked).content for name, vector in vectors.items()}
        results = client.ask_all(vector.asked.named(name) for name, vector in vectors.items())
        yield {r.name or "": b"" if r.answer is None else r.answer.content for r in results}
    anyio.run(ask_all)
    yield async_answers


def by_http(url: str, vectors: Mapping[str, Vector]) -> Iterator[Answers]:
    """Of questions alone, and of a batch, without a client of ours."""
    alone, batched = {}, {}
    with httpx.Client(base_url=url, timeout=300) as client:
        for name, vector in vectors.items():
            asked = vector.asked
            alone[name] = client.post(
                asked.path, json=asked.question.body(), headers={"Prefer": "wait=30"}
            ).content
        sent = {"Content-Type": "application/x-ndjson"}
        batch = client.post("/v1/batches", content=lines_of(vectors), headers=sent).json()
        text = client.get(batch["links"]["results"], headers={"Prefer": "wait=280"}).content
        for line in text.splitlines():
            result = json.loads(line)
            batched[result["id"]] = cut(line)
    yield alone
    yield batched


def lines_of(vectors: Mapping[str, Vector]) -> str:
    """The vectors as the items of a batch."""
    asked = {name: vector.asked.question for name, vector in vectors.items()}
    items = ({"id": name, "kind": q.kind.name, "request": q.body()} for name, q in asked.items())
    return "".join(json.dumps(item) + "\n" for item in items)


def cut(line: bytes) -> bytes:
    """The document in a line of results, byte for byte."""
    _, found, rest = line.partition(b'"result":')
    return rest[:-1] if found else b""


def by_command_line(
    run_here: Run, url: str, vectors: Mapping[str, Vector], folder: Path
) -> Iterator[Answers]:
    """By `--url`, and by `submit`."""
    answers = {}
    for name, vector in vectors.items():
        path = folder / "geometry.json"
        path.write_text(json.dumps(vector.manipulator.to_json()))
        command, *options = vector.command
        done = run_here(command, str(path), *options, "--format", "json", "--url", url)
        document = json.loads(done.stdout)
        answers[name] = compact(document["checks"][0]["report"] if command == "check" else document)
    yield answers
    path = folder / "batch.ndjson"
    path.write_text(lines_of(vectors))
    lines = run_here("submit", str(path), "--url", url).stdout.splitlines()
    yield {json.loads(line)["id"]: cut(line.encode()) for line in lines}


def compare(run_here: Run, url: str, vectors: Mapping[str, Vector], folder: Path) -> Answers:
    expected = by_library(vectors)
    vectors = {name: vectors[name] for name in expected}
    ways = 0
    for source in (
        by_clients(url, vectors),
        by_http(url, vectors),
        by_command_line(run_here, url, vectors, folder),
    ):
        for answers in source:
            ways += 1
            assert answers.keys() == expected.keys()
            assert [name for name in expected if answers[name] != expected[name]] == []
    assert ways == 7
    return expected


def test_a_sample(run_here: Run, base_url: str, tmp_path: Path) -> None:
    [case] = [case for case in CASES if case["name"] == "integer"]
    m = Manipulator.from_json(case["geometry"])
    lengths = [item["l1"] for item in case["slices"]]
    families = dict(of_families())
    vectors = {"a table": table(m, [*lengths, "0"], 90)}
    vectors |= {name: families[name] for name in ("flat base, poses", "similar, poses")}
    compare(run_here, base_url, vectors, tmp_path)


@pytest.mark.long
@pytest.mark.timeout(480)
@pytest.mark.parametrize("vectors", [of_reference, of_families], ids=lambda vectors: vectors.__name__)
def test_all_shared_vectors(
    run_here: Run, tmp_path: Path, vectors: Callable[[], Iterator[tuple[str, Vector]]]
) -> None:
    """By a service of its own: what is known with more digits is cut from that, with its certificate."""
    asked = dict(vectors())
    with running(tmp_path / "data", log_level="WARNING") as stack:
        answered = compare(run_here, stack.base, asked, tmp_path)
    assert len(answered) >= len(asked) - 2  # the solver refuses the congruent ones some questions
