"""Commands that a running service answers."""

from __future__ import annotations

import argparse
from collections.abc import Generator, Iterator, Mapping
from contextlib import closing, contextmanager
from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter

from rpr_solver import Progress
from rpr_solver.contract import document_head
from rpr_solver.errors import InputError
from service.cli.arguments import source
from service.cli.output import progress_bar
from service.errors import ServiceError
from service.schemas.document import named, part
from service.schemas.model import DEFERRED
from service.schemas.numbers import DeadlineSeconds
from service.schemas.questions import Question
from service.schemas.tables import CuspTableRequest
from worker.answers.requests import Store, answer

if TYPE_CHECKING:  # httpx is slow to load
    from service.client import ServiceClient

_DEADLINE: TypeAdapter[float | None] = TypeAdapter(DeadlineSeconds, config=DEFERRED)

LOCAL = "http://127.0.0.1:8000"


def add_url(
    parser: argparse.ArgumentParser,
    deadline: str = "with --url: fail if the answer is not ready after this time",
) -> None:
    """Add `--url` and `--deadline`, and what the latter does."""
    parser.add_argument("--url", help=f"compute with the service at this URL, for example {LOCAL}")
    parser.add_argument("--deadline", metavar="SECONDS", help=deadline)


def add_job(parser: argparse.ArgumentParser) -> None:
    """Add the id of a job or a batch, and the address of its service."""
    parser.add_argument("job", metavar="JOB", help="the id of a job or a batch")
    add_service(parser)


def add_service(parser: argparse.ArgumentParser) -> None:
    """Add the address of a service, without which there is nothing to do."""
    parser.add_argument("--url", default=LOCAL, help=f"URL of the service (default: {LOCAL})")


def deadline_of(args: argparse.Namespace) -> dict[str, object]:
    """Returns the deadline as a member of a question.

    Raises:
        InputError: there is no service that could keep it.
    """
    if args.deadline is not None and args.url is None:
        raise InputError.of("--deadline", "is for jobs of a service; give --url too, or leave it out")
    return {"deadline_s": args.deadline}


def seconds_of(args: argparse.Namespace) -> float | None:
    """Returns the deadline of a command that asks several questions.

    Raises:
        InputError: it is none, or there is no service that could keep it.
    """
    text = deadline_of(args)["deadline_s"]
    if text is None:
        return None
    with named("--deadline"):
        return part(_DEADLINE.validate_python, text, source())


@contextmanager
def client_of(url: str) -> Iterator[ServiceClient]:
    """A client of the service at `--url`."""
    from service.client import ServiceClient

    try:
        client = ServiceClient(url)
    except ServiceError as error:
        raise InputError.of("--url", str(error)) from None
    with client:
        yield client


def document_of(url: str, question: Question, progress: Progress) -> dict[str, Any]:
    """Returns the answer of a service.

    Raises:
        ServiceError: the service refused, failed, or cannot be reached.
    """
    from service.client import Asked

    with client_of(url) as client:
        return client.ask(Asked.of(question), progress).document


def answer_of(url: str | None, question: Question, steps: str | None = None) -> dict[str, Any]:
    """Returns the answer, which is computed here, or by the service at `--url`.

    `steps`: what the progress counts of an answer that is computed here, if that may take long.

    Raises:
        InputError: the question has no answer.
        SolverError: it could not be decided.
        ServiceError: the service refused, failed, or cannot be reached.
    """
    if url is None and steps is None:
        return answer(question.job_request(), Store())
    with progress_bar(1, "steps" if url is not None else steps or "steps") as progress:
        if url is None:
            return answer(question.job_request(), Store(), progress)
        return document_of(url, question, progress)


def slices_of(
    client: ServiceClient, question: CuspTableRequest, progress: Progress
) -> tuple[dict[str, Any], Generator[Mapping[str, Any], None, None]]:
    """Returns the head of a cusp table, and its slices as a service computes them."""
    from service.client import Asked

    head = document_head(question.geometry, question.digits, question.fixed_leg)
    head["solver_version"] = client.version()["solver_version"]
    count = len(question.content()["l1"])

    def counted() -> Generator[Mapping[str, Any], None, None]:
        with closing(client.slices(Asked.of(question))) as slices:
            for done, answered in enumerate(slices, 1):
                yield answered
                progress(done, count)

    return head, counted()
