"""The helper of all tests with processes."""

from __future__ import annotations

import signal
import subprocess
import sys

from tests.support.processes import completed, environment, is_running, started, until

STUBBORN = """
import signal, subprocess, sys, time
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    signal.signal(number, signal.SIG_IGN)
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
print(child.pid, flush=True)
time.sleep(600)
"""


def test_a_child_receives_ctrl_c_even_if_the_tests_ignore_it() -> None:
    handler = "import signal; print(signal.getsignal(signal.SIGINT) is signal.default_int_handler)"
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        assert completed([sys.executable, "-c", handler], environment(), in_full=True).stdout == "True\n"
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


def test_no_process_of_a_child_outlives_its_block() -> None:
    with started(
        [sys.executable, "-c", STUBBORN], in_full=True, env=environment(), stdout=subprocess.PIPE
    ) as process:
        grandchild = int(process.stdout.readline())
        assert is_running(grandchild)
    assert process.returncode == -signal.SIGKILL
    until(lambda: not is_running(grandchild))
