from __future__ import annotations

import io
import subprocess
import sys

import pytest

from service.cli.main import main
from tests.support.cli_process import Run


@pytest.fixture
def run_here(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    """A command in this process; one of its own would need longer for its start than for most answers."""

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
