"""The clients against a real service: every kind of question, streams, retries, and withdrawal."""

from __future__ import annotations

import inspect
import json
import re
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import cache
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from itertools import islice
from typing import Any

import anyio
import pytest

import rpr_solver
from rpr_solver import EXAMPLES, InputError, Manipulator, Requirement
from rpr_solver.contract import document_head
from rpr_solver.designs.plan import Options as DesignOptions
from service.client import (
    Asked,
    AsyncServiceClient,
    ServiceClient,
    aspects,
    assembly_modes,
    census,
    check,
    conversation,
    cusp_curves,
    cusp_loop,
    cusp_table,
    design,
    joint_path,
    leg_poses,
    margin,
    plot,
    pose_connections,
    pose_path,
    poses,
    sensed_poses,
    singular_curves,
    stub,
    verify_document,
    workspace,
)
from service.errors import ServiceError
from service.schemas.plots import PlotRequest
from service.schemas.registry import all_questions
from tests.support.processes import until
from tests.support.service_server import looks
from tests.support.shared import census_of, curves_of
from worker.jobs.queue import JobQueue

FIRST = EXAMPLES["innocenti"]
MOTION = {"speed": 10, "acceleration": {"l2": "20.5", "l3": 30}, "jerk": 100}
HERE = {"l1": 27, "l2": 20, "l3": 20, "pose": 1}
ZEIN = EXAMPLES["zein-flat"]


@cache
def the_table() -> dict[str, Any]:
    return rpr_solver.table_document(ZEIN, 10, digits=15)


AT_MOST_4 = Requirement(start=1, stop=10, max_cusps=4)
NEAR_ZEIN: DesignOptions = {"vary": {"d1": (12, 13)}, "budget": 2, "loop": "excluded", "max_aspects": 4}


KINDS: dict[str, tuple[Asked[Any], Callable[[], object]]] = {
    "cusp table": (
        cusp_table(ZEIN, [10, "69/2", 0], digits=20),
        lambda: rpr_solver.table_document(ZEIN, [10, "69/2", 0], digits=20),
    ),
    "census": (
        census(ZEIN, digits=20, start=22, stop="32"),
        lambda: rpr_solver.restrict_census(census_of(ZEIN, digits=20).to_json(), 22, 32),
    ),
    "cusp curves": (
        cusp_curves(ZEIN, digits=15, start=3, stop=4, lengths=["3.5"], deadline=300),
        lambda: curves_of(ZEIN, digits=15).part(3, 4, lengths=[Fraction("3.5")]).to_json(),
    ),
    "check": (
        check(ZEIN, AT_MOST_4, digits=15),
        lambda: rpr_solver.check(ZEIN, AT_MOST_4, digits=15).to_json(),
    ),
    "leg poses": (
        leg_poses(ZEIN, {"l1": 15, "l3": 40}, 10, "30.5", digits=15),
        lambda: rpr_solver.leg_poses(ZEIN, {"l1": 15, "l3": 40}, 10, "30.5", digits=15).to_json(),
    ),
    "poses": (
        poses(ZEIN, 15, "61/2", 40, digits=15),
        lambda: rpr_solver.poses(ZEIN, 15, "61/2", 40, digits=15).to_json(),
    ),
    "poses with angles": (
        sensed_poses(ZEIN, {"l1": 15, "l2": 20}, {"angle3": 100}, digits=15),
        lambda: rpr_solver.sensed_poses(ZEIN, {"l1": 15, "l2": 20}, {"angle3": 100}, digits=15).to_json(),
    ),
    "singular curves": (
        singular_curves(ZEIN, "69/2", fixed_leg=2, tolerance="0.01"),
        lambda: rpr_solver.singular_curves(ZEIN, "69/2", fixed_leg=2, tolerance="0.01").to_json(),
    ),
    "aspects": (
        aspects(FIRST, 27, fixed_leg=3),
        lambda: {
            **document_head(FIRST, 15, 3),
            "range": {"from": "27", "to": None},
            "aspects": [x.to_json() for x in rpr_solver.aspects(FIRST, 27, fixed_leg=3)],
        },
    ),
    "workspace": (
        workspace(ZEIN, 30, {"l1": (5, 20), "l2": (None, 15)}, digits=20),
        lambda: rpr_solver.workspace(ZEIN, 30, {"l1": (5, 20), "l2": (None, 15)}, digits=20).to_json(),
    ),
    "assembly modes": (
        assembly_modes(FIRST, 27, limits={"l2": (20, 30), "l3": (20, None)}),
        lambda: rpr_solver.assembly_modes(FIRST, 27, limits={"l2": (20, 30), "l3": (20, None)}).to_json(),
    ),
    "pose connections": (
        pose_connections(FIRST, 27, 20, 20, between=(26, 28), digits=20),
        lambda: rpr_solver.pose_connections(FIRST, 27, 20, 20, between=(26, 28), digits=20).to_json(),
    ),
    "pose connections of two joint vectors": (
        pose_connections(ZEIN, 10, 30, "40", to=(10, "30.5", 40), limits={"l2": (5, 31)}, parts=True),
        lambda: rpr_solver.pose_connections(
            ZEIN, 10, 30, 40, to=(10, "30.5", 40), limits={"l2": (5, 31)}, parts=True
        ).to_json(),
    ),
    "margin": (
        margin(FIRST, "28.1", tolerance={"d1": "0.004", "a3x": 0}),
        lambda: rpr_solver.margin(FIRST, "28.1", tolerance={"d1": "0.004"}).to_json(),
    ),
    "design": (
        design(ZEIN, "least-change", AT_MOST_4, **NEAR_ZEIN),
        lambda: rpr_solver.design(ZEIN, "least-change", AT_MOST_4, **NEAR_ZEIN).to_json(),
    ),
    "verification": (
        verify_document(the_table(), deadline=60),
        lambda: {**ZEIN.identity_json(), **rpr_solver.verify_document(the_table()).to_json()},
    ),
    "path": (
        cusp_loop(ZEIN, 10, "B", samples=3, duration="2.5"),
        lambda: rpr_solver.cusp_loop(ZEIN, 10, "B", samples=3, duration="2.5").to_json(),
    ),
    "motion within limits": (
        cusp_loop(ZEIN, 10, "B", motion=MOTION, sampling={"chord": "0.5"}),
        lambda: rpr_solver.cusp_loop(ZEIN, 10, "B", motion=MOTION, sampling={"chord": "0.5"}).to_json(),
    ),
    "path between given poses": (
        pose_path(FIRST, HERE, {"alpha_deg": "-40.0", "theta1_deg": 140, "l1": 28}, samples=2),
        lambda: rpr_solver.pose_path(
            FIRST, HERE, {"alpha_deg": -40, "theta1_deg": 140, "l1": 28}, samples=2
        ).to_json(),
    ),
    "widest path": (
        joint_path(FIRST, 27, 20, 20, 1, 2, clearance="best", samples=2),
        lambda: rpr_solver.joint_path(FIRST, 27, 20, 20, 1, 2, clearance="best", samples=2).to_json(),
    ),
    "path within limits": (
        joint_path(FIRST, 27, 20, 20, 1, 2, limits={"l2": (5, 21)}),
        lambda: rpr_solver.joint_path(FIRST, 27, 20, 20, 1, 2, limits={"l2": (5, 21)}).to_json(),
    ),
}


def compact(document: object) -> bytes:
    return json.dumps(document, separators=(",", ":"), ensure_ascii=False).encode()


@pytest.mark.parametrize("kind", KINDS)
def test_an_answer_is_the_library_s_byte_for_byte(base_url: str, kind: str) -> None:
    asked, library = KINDS[kind]
    with ServiceClient(base_url) as client:
        answer = client.ask(asked)
    assert answer.content == compact(library())
    assert compact(answer.document) == answer.content
    dumped = answer.typed.model_dump(mode="json", by_alias=True, exclude_unset=True)
    assert dumped == answer.document


def test_the_client_asks_every_question() -> None:
    of_pictures = {PlotRequest}  # compared with the library by its own test
    assert {type(asked.question) for asked, _ in KINDS.values()} == set(all_questions()) - of_pictures


@pytest.mark.quick
def test_both_clients_have_the_same_methods() -> None:
    waiting, awaited = (
        {name: method for name, method in inspect.getmembers(client, callable) if name[0] != "_"}
        for client in (ServiceClient, AsyncServiceClient)
    )
    assert {*waiting} - {"close"} == {*awaited} - {"aclose"}
    for name, method in waiting.items():
        if name == "close":
            continue
        other = awaited[name]
        of_both = [inspect.signature(x) for x in (method, other)]
        assert of_both[0].parameters == of_both[1].parameters, name
        returned, by_other = (x.return_annotation for x in of_both)
        yielded = re.fullmatch(r"AsyncGenerator\[(\w+|Mapping\[str, Any\]), None\]", by_other)
        assert returned == (f"Generator[{yielded[1]}, None, None]" if yielded else by_other), name
        assert method.__doc__ == other.__doc__, name
        assert method.__qualname__ == f"ServiceClient.{name}"
        assert method.__doc__


def test_the_asynchronous_client_asks_several_questions_at_once(base_url: str) -> None:
    several, answers = dict(islice(KINDS.items(), 7)), {}

    async def ask(client: AsyncServiceClient, kind: str) -> None:
        answers[kind] = (await client.ask(KINDS[kind][0])).content

    async def main() -> None:
        async with AsyncServiceClient(base_url) as client, anyio.create_task_group() as group:
            for kind in several:
                group.start_soon(ask, client, kind)

    anyio.run(main)
    with ServiceClient(base_url) as client:
        assert answers == {kind: client.ask(asked).content for kind, (asked, _) in several.items()}


def test_slices_come_in_the_order_asked_while_the_job_runs(base_url: str, fresh: Callable[[], str]) -> None:
    lengths = [fresh() for _ in range(12)]
    with ServiceClient(base_url) as client:
        client.ask(cusp_table(ZEIN, lengths[5:7], digits=15))
        asked = cusp_table(ZEIN, [*reversed(lengths), "0"], digits=15)
        streamed = list(client.slices(asked))
        assert compact(streamed) == compact(client.ask(asked).document["slices"])
        assert list(client.slices(asked)) == streamed

    async def main() -> list[Any]:
        async with AsyncServiceClient(base_url) as client:
            return [part async for part in client.slices(asked)]

    assert anyio.run(main) == streamed


def test_the_first_slices_are_there_before_the_last(
    client_type: type[ServiceClient], base_url: str, fresh: Callable[[], str]
) -> None:
    asked = cusp_table(ZEIN, [fresh() for _ in range(300)], digits=400)
    with client_type(base_url) as client:
        slices = client.slices(asked)
        next(slices)
        job = client.job(asked.question.job_request().job_id)
        assert job["status"] == "running"
        slices.close()
        assert client.job(job["id"])["status"] in ("canceled", "succeeded")


def test_progress_is_told_and_results_have_forms(
    base_url: str, fresh: Callable[[], str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(conversation, "_FIRST_WAIT", 0)  # in which most jobs of tests end
    seen: list[tuple[int, int]] = []
    with ServiceClient(base_url) as client:

        def told() -> tuple[Any, Any] | None:
            """A question and its answer, unless the answer was there before any progress."""
            asked = cusp_table(ZEIN, [fresh() for _ in range(200)], digits=60)
            document = client.ask(asked, lambda done, total: seen.append((done, total))).document
            return (asked, document) if seen else None

        asked, document = until(told)
        job_id = asked.question.job_request().job_id
        assert client.job(job_id)["status"] == client.cancel(job_id)["status"] == "succeeded"
        assert client.result(job_id, "text/csv").decode() == rpr_solver.table_csv(document)
    assert seen[-1] == (200, 200)


def test_a_canceled_task_withdraws_its_question(idle_url: str, idle_queue: JobQueue) -> None:
    asked = cusp_table(ZEIN, "77.001", digits=15)
    job_id, before = asked.question.job_request().job_id, looks(idle_url)

    async def main() -> None:
        async with AsyncServiceClient(idle_url) as client, anyio.create_task_group() as group:
            group.start_soon(client.ask, asked)
            while looks(idle_url) == before:  # until the client knows its job
                await anyio.sleep(0.05)
            group.cancel_scope.cancel()

    anyio.run(main)
    job = idle_queue.get(job_id)
    assert job is not None
    assert job.status == "canceled"


def test_an_option_that_does_not_exist_is_refused() -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument 'digit'"):
        cusp_loop(ZEIN, 10, "B", digit=15)  # type: ignore[call-arg]
    asked = plot(ZEIN, "loop", length="10", fixed_leg=2, cusp=3, deadline=9.5).question.body()
    wanted = {"plot": "loop", "fixed_leg": 2, "l2": "10", "cusp": 3, "deadline_seconds": 9.5}
    assert {name: asked[name] for name in wanted} == wanted


def test_faults_are_named_before_anything_is_sent() -> None:
    with pytest.raises(InputError, match="digits"):
        census(ZEIN, digits=9)
    with pytest.raises(InputError, match=r"l2: is -1; a leg length must be > 0"):
        poses(ZEIN, 1, -1, 1)


def test_a_refusal_has_its_problem(client_type: type[ServiceClient], idle_url: str) -> None:
    with client_type(idle_url) as client, pytest.raises(ServiceError) as refused:
        client.ask(cusp_table(ZEIN, range(1, 50), digits=15))
    assert (refused.value.is_input, refused.value.status, refused.value.problem) == (
        True,
        422,
        "limit-exceeded",
    )


class Busy(BaseHTTPRequestHandler):
    """Refuses the first two requests as a busy service does."""

    seen = 0

    def do_POST(self) -> None:
        self.rfile.read(int(self.headers["Content-Length"]))
        type(self).seen += 1
        status = {1: 503, 2: 429}.get(self.seen, 200)
        body = b'{"count":1}' if status == 200 else b"{}"
        self.send_response(status)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Retry-After", "0")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Print nothing."""


@contextmanager
def busy() -> Iterator[str]:
    Busy.seen = 0
    with ThreadingHTTPServer(("127.0.0.1", 0), Busy) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()


def test_a_busy_service_is_asked_again(client_type: type[ServiceClient]) -> None:
    with busy() as url, client_type(url) as client:
        assert client.ask(poses(ZEIN, 1, 1, 1)).content == b'{"count":1}'
    assert Busy.seen == 3


@pytest.mark.parametrize("client", [ServiceClient])
@pytest.mark.parametrize("url", ["ftp://x", "127.0.0.1:8000", "http://", "http://x:y", ""])
def test_the_client_names_the_address_that_is_none(url: str, client: Callable[[str], object]) -> None:
    with pytest.raises(ServiceError) as refused:
        client(url)
    assert str(refused.value).startswith(f"{url!r} is not an ")
    assert refused.value.is_input


def test_a_manipulator_is_asked_about_as_it_was_given(base_url: str) -> None:
    base = {"points": [[0, 2], [0, 12], ["-5*sqrt(3)", 7]]}
    manipulator = Manipulator(base=base, platform={"sides": [6, "sqrt(49)", 5]}, orientation="cw")
    with ServiceClient(base_url) as client:
        answer = client.ask(poses(manipulator, 6, 8, 7, digits=20))
    library = rpr_solver.poses(manipulator, 6, 8, 7, digits=20)
    assert answer.content == compact(library.to_json())
    assert [pose.phi_deg for pose in answer.typed.poses] == [pose.phi_deg for pose in library.poses] != []


def test_the_types_of_the_functions_are_those_of_the_questions() -> None:
    assert stub.main(["--check"]) == 0, "run python -m service.client.stub"
