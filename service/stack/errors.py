"""What keeps the stack from running; each message is for the user.

RuntimeError
└── StackError          a port that is taken, no Redis, a setting that makes no sense
    └── EmbeddedError   the embedded server cannot be started
"""

from __future__ import annotations


class StackError(RuntimeError):
    """The stack cannot run."""


class EmbeddedError(StackError):
    """The embedded server cannot be started."""
