"""The longest questions for their price: a search for those that take far longer than estimated.

    python -m benchmarks.cost --minutes 30 --seed 1
    python -m benchmarks.cost --minutes 5 --kind verification
    python -m benchmarks.cost --again findings.ndjson

Questions of every kind are made from the service's examples and changed at random (benchmarks/questions.py);
those that took longest for their estimate (worker/answers/cost.py) are changed further, and answers become
documents to verify. Each is computed as a worker does it, in a process of its own with a limit on its
processor time. A ratio of 2 is an estimate of half of what was measured; an estimate below 20 ms counts as
20 ms. A question that does not end within its limit is at least as long.

Ends with the worst findings of each kind: the ratio, what was measured and estimated, and the question as an
item of a batch, which `--again` measures once more. For each kind follow the least, the mean (geometric) and
the greatest ratio. A seed gives the same first questions again; which are changed further depends on times.
"""

from __future__ import annotations

import argparse
import contextlib
import heapq
import json
import math
import os
import resource
import signal
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

from benchmarks.questions import Body, changed, geometry, is_verification, seeds, to_verify
from service.api.batches import read_item
from service.schemas.limits import Limits
from service.stack.embedded_valkey import EmbeddedValkey
from worker.answers import JobRequest
from worker.answers.kinds import ItemSolver, known_answer
from worker.answers.store import ResultStore
from worker.answers.tables import StoredTable
from worker.connection import connect
from worker.process.horse import load_solver
from worker.settings import WorkerSettings

LEAST = 0.02
"""Seconds; what a question costs in any case, to be told, read and answered."""
_LONG = 11  # seconds; whatever is estimated, it is told from what is longer
_KEPT = 12  # findings of a kind that are changed further
_DOCUMENTS = 60  # to verify
_LONGEST_DOCUMENT = 1 << 20  # bytes
_ENDS = ("answered", "cut", "InputError", "SolverError", "Unproved", "MemoryError")
_CUT = (signal.SIGXCPU, signal.SIGKILL, signal.SIGALRM)


@dataclass(frozen=True, order=True)
class Finding:
    """A question that was measured.

    Attributes:
        ratio: of the measured time and the estimate.
        taken, estimate: seconds.
        ended: how it ended: `answered`, `cut` at its limit, or the name of an error and its message.
        kind, body: the question.
    """

    ratio: float
    taken: float
    estimate: float
    ended: str
    kind: str
    text: str

    @property
    def body(self) -> Body:
        """The body of the question."""
        body: Body = json.loads(self.text)["request"]
        return body


def read(kind: str, body: Body) -> JobRequest | None:
    """Returns the question as the service reads it, or None if it refuses it."""
    text = json.dumps({"kind": kind, "request": body})
    if len(text) > Limits().max_body_bytes:
        return None
    return read_item(text.encode(), 0, Limits()).request


def measured(request: JobRequest, url: str, cap: float) -> tuple[float, str, dict[str, Any] | None]:
    """Returns the processor time, at most `cap` seconds, how it ended, and the answer."""
    with tempfile.TemporaryFile() as answer:
        pid = os.fork()
        if pid == 0:
            _compute(request, url, cap, answer.fileno())
        _, status, usage = os.wait4(pid, 0)
        answer.seek(0)
        text = answer.read()
    taken = usage.ru_utime + usage.ru_stime
    if not text:
        is_cut = os.WIFSIGNALED(status) and os.WTERMSIG(status) in _CUT
        return taken, "cut" if is_cut else f"status {status}", None
    taken, ended, document = json.loads(text)
    return taken, ended, document


def _compute(request: JobRequest, url: str, cap: float, answer: int) -> None:
    """Compute in a process of its own, and end it."""
    limit = math.ceil(cap + time.process_time())
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))
    resource.setrlimit(resource.RLIMIT_AS, (4096 << 20, 4096 << 20))
    signal.alarm(int(10 * cap) + 10)  # it may wait for what never comes
    ended, document = "answered", None
    begin = time.process_time()
    try:
        with connect(url) as redis:
            store = ResultStore(redis, WorkerSettings(key_prefix=f"cost-{os.getpid()}-{time.monotonic_ns()}"))
            begin = time.process_time()
            solver = ItemSolver(store)
            outcome = solver.solve(request)
            solver.keep()
            taken = time.process_time() - begin
            if not outcome.failure and not outcome.slices:
                known = known_answer(request, store)
                document = known.document() if isinstance(known, StoredTable) else known
    except BaseException as error:
        taken = time.process_time() - begin
        ended = f"{type(error).__name__}: {error}"[:200]
    text = json.dumps([taken, ended, document])
    if len(text) > _LONGEST_DOCUMENT:
        text = json.dumps([taken, ended, None])
    os.write(answer, text.encode())
    os._exit(0)


class Search:
    """Makes questions, measures them, and keeps the worst."""

    def __init__(
        self, url: str, seed: int, kinds: Sequence[str], cap: float, out: Path | None = None
    ) -> None:
        self.url, self.cap, self.kinds, self.out = url, cap, kinds, out
        self.rng = Random(seed)
        self.worst: dict[str, list[Finding]] = defaultdict(list)
        self.ratios: dict[str, list[float]] = defaultdict(list)
        self.faults: list[Finding] = []
        self._seeds = seeds()
        self._documents: list[Body] = []

    def step(self) -> Finding | None:
        """Make and measure one question; None if the service refuses it."""
        rng = self.rng
        kind = rng.choice(self.kinds)
        body = self._body(kind)
        request = read(kind, body)
        if request is None:
            return None
        estimate = request.cost.whole
        if estimate > self.cap / 2:
            return None
        return self.measure(kind, body, request, estimate)

    def measure(
        self, kind: str, body: Body, request: JobRequest, estimate: float, *, is_alone: bool = False
    ) -> Finding:
        """Measure a question; one that is alone may take as long as any."""
        priced = max(estimate, LEAST)
        limit = self.cap if is_alone else min(self.cap, max(_LONG, 8 * priced))
        taken, ended, document = measured(request, self.url, limit)
        text = json.dumps({"kind": kind, "request": body})
        finding = Finding(taken / priced, taken, estimate, ended, kind, text)
        self.ratios[kind].append(finding.ratio)
        worst = self.worst[kind]
        (heapq.heappush if len(worst) < _KEPT else heapq.heappushpop)(worst, finding)
        if ended.partition(":")[0] not in _ENDS:
            self.faults.append(finding)
        if self.out is not None:
            with self.out.open("a") as file:
                own = {"taken": taken, "estimate": estimate, "ended": ended}
                file.write(json.dumps({**own, **json.loads(text)}) + "\n")
        if document is not None and not is_verification(kind):
            self._documents = [*self._documents[-_DOCUMENTS:], to_verify(document)]
        return finding

    def _body(self, kind: str) -> Body:
        rng = self.rng
        known = sorted(self.worst[kind], reverse=True)
        if known and rng.random() < 0.5:
            parent = known[min(int(rng.expovariate(0.5)), len(known) - 1)].body
        elif is_verification(kind) and self._documents:
            parent = rng.choice(self._documents)
            if rng.random() < 0.3:
                return parent
        else:
            parent = dict(rng.choice(self._seeds[kind]))
            if "geometry" in parent and rng.random() < 0.7:
                parent["geometry"] = geometry(rng)
        return changed(kind, parent, rng)


def line(finding: Finding) -> str:
    """A finding as it is printed."""
    short = finding.text if len(finding.text) < 300 else f"{finding.text[:300]}… ({len(finding.text)} bytes)"
    sign = ">" if finding.ended == "cut" else " "
    times = f"{finding.ratio:8.1f} {finding.taken:9.3f} s for {finding.estimate:8.3f} s"
    return f"{sign}{times}  {finding.ended:<10} {short}"


@contextlib.contextmanager
def valkey() -> Iterator[str]:
    """An empty store; its address."""
    with tempfile.TemporaryDirectory() as data, EmbeddedValkey(Path(data)) as server:
        yield server.url


def main() -> None:
    """Search, and print what was found."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--minutes", type=float, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", action="append", help="only this kind; may be given more than once")
    parser.add_argument("--cap", type=float, default=30, help="seconds for one question (default: 30)")
    parser.add_argument("--shown", type=int, default=3, help="findings of each kind (default: 3)")
    parser.add_argument("--out", type=Path, help="a file to which each question is added, whole, a line each")
    parser.add_argument("--again", type=Path, help="measure the questions in such a file instead")
    options = parser.parse_args()
    load_solver()
    with valkey() as url:
        search = Search(url, options.seed, options.kind or sorted(seeds()), options.cap, options.out)
        if options.again is not None:
            for text in options.again.read_text().splitlines():
                item = json.loads(text)
                request = read(item["kind"], item["request"])
                if request is None:
                    print(f" refused: {text[:200]}")
                    continue
                estimate = request.cost.whole
                finding = search.measure(item["kind"], item["request"], request, estimate, is_alone=True)
                print(line(finding), flush=True)
            return
        end, count = time.monotonic() + 60 * options.minutes, 0
        while time.monotonic() < end:
            finding = search.step()
            if finding is not None:
                count += 1
                if finding.ratio > 5 or (finding.taken > 10 and finding.estimate < 1.5):
                    print(line(finding), file=sys.stderr, flush=True)
    _report(search, count, options)


def _report(search: Search, count: int, options: argparse.Namespace) -> None:
    print(f"{count} questions in {options.minutes:g} minutes, seed {options.seed}")
    for kind, findings in sorted(search.worst.items()):
        ratios = search.ratios[kind]
        if not ratios:
            continue
        mean = math.exp(sum(math.log(max(x, 1e-3)) for x in ratios) / len(ratios))
        print(f"{kind}: {len(ratios)} questions, ratios {min(ratios):.2f}, {mean:.2f}, {max(ratios):.2f}")
        for finding in sorted(findings, reverse=True)[: options.shown]:
            print(line(finding))
    for finding in search.faults:
        print(f"fault: {line(finding)}")


if __name__ == "__main__":
    main()
