from __future__ import annotations

import io
import json
import subprocess
import sys
from collections.abc import Sequence

import pytest

from service.cli.main import main
from tests.support.cli_process import Run
from worker.answers.kind import Document, JobRequest, Store

_known: dict[str, str] = {}
"""The documents that commands of this process have computed, as JSON, by the hash of their question."""


def _get(_store: Store, requests: Sequence[JobRequest]) -> list[Document | None]:
    found = [_known.get(request.content_hash) for request in requests]
    return [None if text is None else json.loads(text) for text in found]


def _put(_store: Store, request: JobRequest, document: Document) -> None:
    _known[request.content_hash] = json.dumps(document)


@pytest.fixture
def run_here(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    """A command in this process; one of its own would need longer for its start than for most answers.

    The store of a command keeps nothing; this one does, so that several forms of a document are of one
    computation.
    """
    monkeypatch.setattr(Store, "get_documents", _get)
    monkeypatch.setattr(Store, "put_document", _put)

    def run(*args: str, stdin: str = "", **variables: str) -> subprocess.CompletedProcess[str]:
        with monkeypatch.context() as patch:
            patch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin.encode())))
            for name, value in variables.items():
                patch.setenv(name, value)
            try:
                status = main(args)
            except SystemExit as end:
                status = int(end.code or 0)
        out, err = capsys.readouterr()
        return subprocess.CompletedProcess(args, status, out, err)

    return run
