"""The scripts that Redis runs, and their loader."""

from worker.lua.scripts import Scripts

__all__ = [
    "Scripts",
]
