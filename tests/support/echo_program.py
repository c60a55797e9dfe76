"""A program that says who it is on the descriptor that it is given, and ends as it is told."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time


def main() -> int:
    """`status DESCRIPTOR`; for `orphan`, leave a child behind that ends soon."""
    what, descriptor = sys.argv[1:]
    me = {
        "pid": os.getpid(),
        "parent": os.getppid(),
        "session": os.getsid(0),
        "word": os.environ.get("RPR_WORD"),
        "path": "PATH" in os.environ,
    }
    child = subprocess.Popen(["sleep", "0.2"]).pid if what == "orphan" else None
    os.write(int(descriptor), json.dumps({**me, "child": child}).encode() + b"\n")
    if what == "sleep":
        time.sleep(600)
    return int(what) if what.isdecimal() else 0
