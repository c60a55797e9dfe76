"""The answers of this tree beside those of an older commit: are they the same?

    python -m tests.support.same_answers REVISION [--count 3000] [--seed 1] [--kinds poses,censuses]
                                         [--ignore MEMBER,…]

The commit is checked out into a temporary folder, and a service of each tree, under the same interpreter,
is asked the same random questions of all kinds over HTTP, by generic and by degenerate manipulators.
Compared are the status and the answer, every text and the order of members included, once `solver_version`,
`certificate` and the members named are taken out at any depth. Job ids are compared where both trees have
one solver version, which is part of the ids, and were asked the same. Prints each question with another
answer as a line of JSON, then a count by kind; exits with 1 if there is any.

Only the contract is used, so the code of either tree may be arranged in any way.
"""

from __future__ import annotations

import argparse
import cmath
import json
import math
import random
import re
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx

from tests.support.families import FAMILIES

ROOT = Path(__file__).parents[2]
NAMES = ("a2x", "a3x", "a3y", "d1", "d2", "d3", "orientation")
LEGS = ("l1", "l2", "l3")
Json = dict[str, Any]


IGNORED = frozenset({"solver_version", "certificate"})
"""Members of documents that are never compared."""


@dataclass(frozen=True)
class Answer:
    """What is compared: the status, the job id, and the document, or the type of an error.

    Attributes:
        question: what was asked; of a verification it has the document, in which the trees may differ.
    """

    status: int
    job: str
    document: object
    question: Json


def same(before: Answer, after: Answer, ignored: Collection[str], *, versions: tuple[str, str]) -> bool:
    """Whether two trees with these solver versions gave the same answer, but for members that are ignored."""
    has_one_id = len({*versions}) == 1 and before.question == after.question
    texts = {json.dumps(without(answer.document, ignored)) for answer in (before, after)}
    return before.status == after.status and len(texts) == 1 and (before.job == after.job or not has_one_id)


def without(value: Any, ignored: Collection[str]) -> Any:
    """A value of JSON without some members, at any depth."""
    if isinstance(value, Mapping):
        return {name: without(item, ignored) for name, item in value.items() if name not in ignored}
    return [without(item, ignored) for item in value] if isinstance(value, list) else value


def geometry(rng: random.Random) -> Json:
    """A manipulator, now and then of a degenerate family, or with roots."""
    if (draw := rng.random()) < 0.25:
        return dict(zip(NAMES, rng.choice(list(FAMILIES.values())), strict=True))
    if draw < 0.35:
        return with_roots(rng)
    places, size = rng.choice([(0, 12), (1, 30), (2, 30), (4, 20)])
    unit = 10**places
    a2x, a3x, a3y = (rng.randint(-size * unit, size * unit) or 1 for _ in range(3))
    d1, d2 = (rng.randint(unit, size * unit) for _ in range(2))
    d3 = rng.randint(abs(d1 - d2) + 1, d1 + d2)
    sides = [str(side / unit) for side in (a2x, a3x, a3y, d1, d2, d3)]
    return dict(zip(NAMES, [*sides, rng.choice(["ccw", "cw"])], strict=True))


def with_roots(rng: random.Random) -> Json:
    """A manipulator with irrational sides."""
    square, side, scale = rng.choice([2, 3, 5, 7, 11]), rng.randint(2, 30), rng.randint(1, 4)
    platform = {
        "sides": [
            f"{scale}*sqrt({rng.randint(2, 40)})",
            str(scale * 5),
            f"{scale}*sqrt({rng.randint(12, 60)})",
        ]
    }
    return {
        "base": {"equilateral": f"{side}*sqrt({square})"},
        "platform": rng.choice([{"equilateral": str(rng.randint(1, 300) / 10)}, platform]),
        "orientation": rng.choice(["ccw", "cw"]),
    }


def joint_vector(rng: random.Random, of: Json) -> Json:
    """Leg lengths near those of a random pose, so that there are poses."""
    if "base" in of:
        return {leg: str(rng.randint(100, 3000) / 100) for leg in LEGS}
    a2x, a3x, a3y, d1, d2, d3 = (float(of[name]) for name in NAMES[:6])
    size = max(abs(a2x), abs(a3x), abs(a3y), d1)
    b1 = complex(rng.uniform(-size, size), rng.uniform(-size, size))
    along = (d1**2 + d3**2 - d2**2) / (2 * d1)
    across = max(d3**2 - along**2, 0) ** 0.5 * (1 if of["orientation"] == "ccw" else -1)
    turn = cmath.exp(1j * rng.uniform(0, math.tau))
    legs = (b1, b1 + d1 * turn - a2x, b1 + complex(along, across) * turn - complex(a3x, a3y))
    return {f"l{n}": str(round(abs(leg), 2) + 0.01) for n, leg in enumerate(legs, 1)}


def length(rng: random.Random) -> str:
    """A leg length of usual size."""
    return str(rng.randint(1, 4000) / 100)


def _range(rng: random.Random) -> Json:
    low = rng.randint(0, 30)
    return {"from": str(low), "to": rng.choice([None, str(low + rng.randint(1, 12))])}


def _slice(rng: random.Random, _of: Json) -> Json:
    leg = rng.choice([1, 1, 2, 3])
    return {"fixed_leg": leg, f"l{leg}": length(rng)}


def _table(rng: random.Random, _of: Json) -> Json:
    question = _slice(rng, _of) | {"digits": rng.choice([15, 30, 90])}
    name = f"l{question['fixed_leg']}"
    question[name] = [length(rng) for _ in range(rng.randint(1, 6))]
    if question["fixed_leg"] == 1 and rng.random() < 0.05:
        question |= {"method": "article", "digits": 15, name: question[name][:1]}
    return question


def _census(rng: random.Random, _of: Json) -> Json:
    question = {"fixed_leg": rng.choice([1, 2, 3]), "range": _range(rng), "digits": rng.choice([15, 30])}
    extra = rng.choice([{}, {}, {}, {"sensitivities": True}, {"tolerance": "0.001"}])
    return question | extra


def _limits(rng: random.Random, leg: int) -> Json:
    """Limits of one of the free legs."""
    low = rng.randint(0, 15)
    free = rng.choice([k for k in (1, 2, 3) if k != leg])
    return {f"l{free}": {"min": low, "max": low + rng.randint(2, 20)}}


def _requirement(rng: random.Random) -> Json:
    leg = rng.choice([1, 2, 3])
    requirement: Json = {"fixed_leg": leg, "range": _range(rng), "max_cusps": rng.randint(0, 8)}
    return requirement | ({"limits": _limits(rng, leg)} if rng.random() < 0.2 else {})


def _check(rng: random.Random, _of: Json) -> Json:
    requirement = _requirement(rng)
    if requirement["range"]["to"] and rng.random() < 0.2:
        requirement["mode_change"] = rng.choice(["required", "excluded"])
    return {"requirement": requirement, "digits": 15}


def _margin(rng: random.Random, of: Json) -> Json:
    weights = {"weights": {"d1": 2, "a3x": 0}}
    extra = rng.choice([{}, {"tolerance": "0.001"}, weights])
    asked = {"requirement": _requirement(rng)} if rng.random() < 0.3 else _slice(rng, of)
    return asked | extra


def _curves(rng: random.Random, _of: Json) -> Json:
    return {
        "fixed_leg": rng.choice([1, 2, 3]),
        "range": _range(rng),
        "samples": rng.randint(2, 4),
        "digits": 15,
    }


def _poses(rng: random.Random, of: Json) -> Json:
    return joint_vector(rng, of) | {"digits": rng.choice([15, 40])}


def _path(rng: random.Random, of: Json) -> Json:
    motion = {"speed": dict.fromkeys(LEGS, 2), "acceleration": dict.fromkeys(LEGS, 4)}
    extra = rng.choice([{}, {}, {}, {"clearance": "best"}, {"motion": motion}])
    if rng.random() < 0.5:
        return _slice(rng, of) | {"cusp": 1, "samples": 11} | extra
    if not extra and rng.random() < 0.3:
        extra = {"limits": _limits(rng, 1)}
    return joint_vector(rng, of) | {"from": 1, "to": 2, "samples": 11} | extra


def _modes(rng: random.Random, of: Json) -> Json:
    asked = _slice(rng, of)
    return asked | ({"limits": _limits(rng, asked["fixed_leg"])} if rng.random() < 0.3 else {})


def _connections(rng: random.Random, of: Json) -> Json:
    return joint_vector(rng, of) | ({"limits": _limits(rng, 1)} if rng.random() < 0.2 else {})


def _design(rng: random.Random, _of: Json) -> Json:
    low = rng.randint(1, 20)
    return {
        "objective": rng.choice(["longest-range", "least-change", "most-cusps"]),
        "requirement": {"range": {"from": low, "to": low + 6}, "max_cusps": rng.randint(2, 6)},
        "vary": "10%",
        "decimals": 2,
        "budget": {"censuses": 2},
    }


def _aspects(rng: random.Random, _of: Json) -> Json:
    low = rng.randint(1, 20)
    return {
        "fixed_leg": rng.choice([1, 2, 3]),
        "range": {"from": str(low), "to": str(low + rng.randint(1, 4))},
    }


def _workspace(rng: random.Random, _of: Json) -> Json:
    phi = rng.randint(-180, 150)
    many = {"from": str(phi), "to": str(phi + 20), "step": rng.choice(["5", "10"])}
    limits = {
        f"l{leg}": {"min": str(rng.randint(1, 9)), "max": str(rng.randint(10, 40))} for leg in (1, 2, 3)
    }
    return {"phi": rng.choice([str(phi), many]), "limits": limits}


def _plot(rng: random.Random, _of: Json) -> Json:
    plot = rng.choice(["slice", "torus", "slice", "census"])
    leg = rng.choice([1, 2, 3])
    return {"plot": plot, "fixed_leg": leg} | ({f"l{leg}": length(rng)} if plot != "census" else {})


def _verification(rng: random.Random, of: Json) -> Json:
    """What is to be verified: the answer to one of these questions, which :func:`ask` asks first."""
    kind = rng.choice(["cusp-tables", "poses", "singular-curves", "censuses", "checks", "paths"])
    return {"of": kind, "question": {"geometry": of, **QUESTIONS[kind][1](rng, of)}}


QUESTIONS: Mapping[str, tuple[float, Callable[[random.Random, Json], Json]]] = {
    "cusp-tables": (12, _table),
    "poses": (6, _poses),
    "paths": (4, _path),
    "singular-curves": (3, _slice),
    "censuses": (3, _census),
    "checks": (3, _check),
    "cusp-curves": (1, _curves),
    "aspects": (1, _aspects),
    "workspaces": (1, _workspace),
    "plots": (2, _plot),
    "margins": (1, _margin),
    "assembly-modes": (2, _modes),
    "pose-connections": (2, _connections),
    "designs": (0.2, _design),
    "verifications": (3, _verification),
}
"""Path of the operation → how often it is asked, and its question about a manipulator."""


def questions(count: int, seed: int, kinds: list[str]) -> Iterator[tuple[str, Json]]:
    """Random questions, the same for equal arguments."""
    rng = random.Random(seed)
    weights = [QUESTIONS[kind][0] for kind in kinds]
    for kind in rng.choices(kinds, weights, k=count):
        of = geometry(rng)
        question = QUESTIONS[kind][1](rng, of)
        yield kind, question if "of" in question else {"geometry": of, **question}


@contextmanager
def service(tree: Path) -> Iterator[httpx.Client]:
    """A service of a tree, with a store of its own."""
    with tempfile.TemporaryDirectory() as data:
        command = [
            sys.executable,
            "-m",
            "service",
            "serve",
            "--port",
            "0",
            "--data-dir",
            data,
            "--workers",
            "1",
        ]
        process = subprocess.Popen(
            command, cwd=tree, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        try:
            assert process.stdout is not None
            url = next(
                found[0] for line in process.stdout if (found := re.search(r"http://[\d.]+:\d+", line))
            )
            with httpx.Client(base_url=url, timeout=300) as client:
                yield client
        finally:
            process.terminate()
            process.wait(60)


def ask(client: httpx.Client, kind: str, question: Json) -> Answer:
    """The answer of one service, however long it takes."""
    if kind == "verifications":
        asked = ask(client, question["of"], question["question"])
        if asked.status >= 400:
            return asked
        question = {"document": asked.document}
    response = client.post(f"/v1/{kind}", json=question, headers={"Prefer": "wait=30"})
    job = response.headers.get("Content-Location", response.headers.get("Location", ""))
    while response.status_code == 202:
        response = client.post(f"/v1/{kind}", json=question, headers={"Prefer": "wait=30"})
        job = response.headers.get("Content-Location", job)
    document = response.json()
    if response.status_code >= 400:  # texts of errors may be improved
        document = document.get("type", "")
    return Answer(response.status_code, job, document, question)


def main() -> int:
    """Compare."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.support.same_answers", description=__doc__.splitlines()[0]
    )
    parser.add_argument("revision", help="the older commit")
    parser.add_argument("--count", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", default=",".join(QUESTIONS), help="kinds of questions, by the path")
    parser.add_argument("--ignore", default="", help="members of documents that are not compared")
    options = parser.parse_args()
    ignored = IGNORED | {*options.ignore.split(",")}
    asked, different, statuses = Counter[str](), Counter[str](), Counter[str]()
    with ExitStack() as stack:
        old = stack.enter_context(tempfile.TemporaryDirectory())
        archive = subprocess.run(
            ["git", "archive", options.revision], cwd=ROOT, stdout=subprocess.PIPE, check=True
        )
        subprocess.run(["tar", "-x", "-C", old], input=archive.stdout, check=True)
        clients = [stack.enter_context(service(tree)) for tree in (Path(old), ROOT)]
        first, second = (client.get("/v1/version").json()["solver_version"] for client in clients)
        pool = stack.enter_context(ThreadPoolExecutor(2))
        for kind, question in questions(options.count, options.seed, options.kinds.split(",")):
            before, after = pool.map(lambda client, k=kind, q=question: ask(client, k, q), clients)
            asked[kind] += 1
            statuses[f"{kind} {after.status}"] += 1
            if not same(before, after, ignored, versions=(first, second)):
                different[kind] += 1
                print(
                    json.dumps({"kind": kind, "was": before.status, "is": after.status, "question": question})
                )
                sys.stdout.flush()
    for kind in asked:
        print(f"{kind}: {asked[kind]} asked, {different[kind]} different")
    print(", ".join(f"{name}: {number}" for name, number in sorted(statuses.items())))
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
