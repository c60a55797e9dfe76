from __future__ import annotations

import signal
import sys

import pytest

from tests.support.processes import completed, environment
from worker.process.os_limits import STOP_SIGNALS, on_stop_signals


@pytest.mark.parametrize("is_ignored", [True, False])
def test_a_hangup_that_is_ignored_stays_so(is_ignored: bool) -> None:
    before = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    try:
        signal.signal(signal.SIGHUP, signal.SIG_IGN if is_ignored else signal.SIG_DFL)

        def handler(*_: object) -> None: ...

        assert (signal.SIGHUP in on_stop_signals(handler)) != is_ignored
        assert signal.getsignal(signal.SIGQUIT) == handler
        assert (signal.getsignal(signal.SIGHUP) == handler) != is_ignored
    finally:
        for number, old in before.items():
            signal.signal(number, old)


def test_as_many_files_as_the_system_allows() -> None:
    program = (
        "import resource as r; from worker.process.os_limits import raise_file_limit as f; "
        "r.setrlimit(r.RLIMIT_NOFILE, (64, 200)); f(); f(); print(r.getrlimit(r.RLIMIT_NOFILE))"
    )
    assert completed([sys.executable, "-c", program], environment()).stdout == "(200, 200)\n"
