"""The scripts that Redis runs, each a file of Lua with names for its keys and arguments.

The head of a file declares them, and whose functions it uses::

    -- include: jobs
    -- keys: record chunks
    -- args: run index todo...

Each name is a local variable of the script; the last key or argument may be a list (`...`). A call gives each
of them by its name, so that their order matters nowhere.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # the command line needs no server, and its import takes half of its time
    from redis import Redis

VIEW_FIELDS = (
    *("run", "status", "done", "total", "created", "started", "finished", "error", "deadline", "failed"),
    "work",
)
"""The fields of a job's record that are shown."""

DURATION_BOUNDS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
"""The upper bounds of the intervals in which durations are counted, in seconds; the last has none."""

_HERE = "worker.lua"
_CONSTANTS = f"""
local VIEW_FIELDS = {{{", ".join(f"'{name}'" for name in VIEW_FIELDS)}}}
local DURATION_BOUNDS = {{{", ".join(f"{bound:g}" for bound in DURATION_BOUNDS)}}}
"""
_HEAD = re.compile(r"^-- (include|keys|args):(.*)$", re.MULTILINE)
_NAME = re.compile(r"[a-z]\w*")
_REST = "..."


@dataclass(frozen=True)
class Source:
    """A script as Redis gets it, and the names of its keys and arguments in their order."""

    name: str
    text: str
    keys: tuple[str, ...]
    args: tuple[str, ...]

    def bound(
        self, namespaces: Iterable[Mapping[str, Any]], values: Mapping[str, Any]
    ) -> tuple[list[Any], list[Any]]:
        """Returns the keys and arguments of a call in their order.

        Raises:
            TypeError: one is missing, or the script has none of that name.
        """
        names = {name.removesuffix(_REST) for name in (*self.keys, *self.args)}
        given = {name: value for space in namespaces for name, value in space.items()} | {**values}
        for what, wrong in (("lacks", names - given.keys()), ("has no use for", values.keys() - names)):
            if wrong:
                raise TypeError(f"the call of {self.name}.lua {what} {', '.join(sorted(wrong))}")
        keys, args = (
            [value for name in declared for value in _values(name, given)]
            for declared in (self.keys, self.args)
        )
        return keys, args


class Scripts:
    """The scripts of a package, run on one connection."""

    def __init__(self, redis: Redis, package: str = _HERE) -> None:
        self._redis, self._package = redis, package
        self._registered: dict[str, Callable[..., Any]] = {}

    def __call__(self, script: str, /, *namespaces: Mapping[str, Any], **values: Any) -> Any:
        """Run a script, and return its reply.

        Args:
            script: the name of its file, without `.lua`.
            namespaces: values by name, of which it takes those that it has, such as all keys of a job.
            values: other keys and arguments, a list for a name with `...`; the script must have each.

        Raises:
            TypeError: a key or an argument is missing, or the script has none of that name.
        """
        declared = source(script, self._package)
        run = self._registered.get(script)
        if run is None:
            run = self._registered[script] = self._redis.register_script(declared.text)
        keys, args = declared.bound(namespaces, values)
        return run(keys=keys, args=args)


@cache
def source(name: str, package: str = _HERE) -> Source:
    """Reads a script, with all that it includes.

    Raises:
        ValueError: its head cannot be used.
    """
    text = _read(name, package)
    head = _head(text)
    keys, args = (tuple(head[what]) for what in ("keys", "args"))
    names = [declared.removesuffix(_REST) for declared in (*keys, *args)]
    for declared in (*keys, *args):
        is_last = declared in (keys[-1:] + args[-1:])
        if not _NAME.fullmatch(declared.removesuffix(_REST)) or (declared.endswith(_REST) and not is_last):
            raise ValueError(f"{name}.lua: {declared!r} is no name, or a list that is not the last")
    if len(names) != len({*names}):
        raise ValueError(f"{name}.lua declares a name twice")
    own = [_locals("KEYS", keys), _locals("ARGV", args), library(*head["include"], package=package), text]
    return Source(name, "\n".join(own), keys, args)


def library(*names: str, package: str = _HERE) -> str:
    """Returns the text of files with functions, and of those that they include."""
    parts: dict[str, str] = {}
    _include(names, package, parts)
    return "\n".join(parts.values())


def _include(names: Sequence[str], package: str, parts: dict[str, str]) -> None:
    """Adds files to the parts of a script, each behind those that it includes itself."""
    for name in names:
        if name == "constants":
            parts[name] = _CONSTANTS
        elif name not in parts:
            text = _read(name, package)
            _include(_head(text)["include"], package, parts)
            parts[name] = text


def _read(name: str, package: str) -> str:
    return files(package).joinpath(f"{name}.lua").read_text(encoding="utf-8")


def _head(text: str) -> dict[str, list[str]]:
    head: dict[str, list[str]] = {"include": [], "keys": [], "args": []}
    for what, names in _HEAD.findall(text):
        head[what] += names.split()
    return head


def _locals(table: str, names: Sequence[str]) -> str:
    """Returns the lines of Lua that give names to the elements of a table."""
    plain = [name for name in names if not name.endswith(_REST)]
    lines = [f"local {', '.join(plain)} = unpack({table}, 1, {len(plain)})"] if plain else []
    if len(plain) < len(names):  # `unpack` has a limit of some thousands
        rest = names[-1].removesuffix(_REST)
        lines += [f"local {rest} = {{}}"]
        lines += [f"for i = {len(plain) + 1}, #{table} do {rest}[i - {len(plain)}] = {table}[i] end"]
    return "\n".join(lines)


def _values(declared: str, given: Mapping[str, Any]) -> Sequence[Any]:
    value = given[declared.removesuffix(_REST)]
    if declared.endswith(_REST):
        return list(value)
    return [int(value) if isinstance(value, bool) else value]
