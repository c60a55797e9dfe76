"""What a service keeps: its store, and its API keys."""

from __future__ import annotations

import argparse
import json
import re
import sys
import time
from dataclasses import asdict
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from rpr_solver.errors import InputError, clipped
from service.api.settings import SCOPES
from service.cli import parsers
from service.cli.output import write_columns
from service.cli.parsers import Command, whole
from service.cli.serve import add_source, opened
from service.errors import ServiceError
from worker.settings import WorkerSettings

if TYPE_CHECKING:
    from redis import Redis

    from service.api.keys import KeyStore


_LONGEST_MOVE = 1e9
_SECONDS = {"s": 1, "m": 60, "h": 3600, "d": 86400}
_BYTES = {"": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9, "KiB": 2**10, "MiB": 2**20, "GiB": 2**30}


def _configure_store(parser: argparse.ArgumentParser) -> None:
    """Add the actions and their options."""
    add = parsers.actions_of(parser)
    status = add(_status, "show what is kept")
    status.add_argument("--format", choices=("table", "json"), default="table", help="default: table")
    prune = add(_prune, "remove what is old")
    prune.add_argument(
        "--older-than",
        type=_duration,
        metavar="AGE",
        help="remove what was neither computed nor asked for in this time, such as 90s, 30m, 12h or 30d",
    )
    prune.add_argument(
        "--max-bytes",
        type=_size,
        metavar="SIZE",
        help="remove the oldest until all keys together take at most this size, such as 500MB or 2GiB",
    )
    archive = add(_archive, "move answers to the archive")
    for action in (status, prune, archive):
        add_source(action)


def _run_store(args: argparse.Namespace) -> int:
    """Inspect and prune the store of a service: results, eliminants and ended jobs, in the given Redis or in
    a data directory, whether or not the service is running. Data of active jobs is never removed.

    examples:
      rpr-cusps store status                            keys and bytes by kind
      rpr-cusps store prune --older-than 30d            what was not used for 30 days
      rpr-cusps store prune --max-bytes 500MB           the oldest, until 500 MB are left
      rpr-cusps store archive                           all answers to RPR_CUSPS_ARCHIVE_URL, now

    Results are removed at the end of their lifetime (RPR_CUSPS_RESULT_TTL_SECONDS), or earlier
    when the store is nearly full (RPR_CUSPS_STORE_MAX_MB, or maxmemory of Redis).
    """
    if args.action == "prune" and args.older_than is None and args.max_bytes is None:
        raise InputError.of("--older-than", "or --max-bytes is missing; give one of them, or both")
    with opened(args) as redis:
        args.act(args, redis, WorkerSettings())
    return 0


def _status(args: argparse.Namespace, redis: Redis, settings: WorkerSettings) -> None:
    """Show the keys and bytes of each kind, and the age of the oldest."""
    from worker.jobs.inventory import Inventory, Stock

    stocks = Inventory(redis, settings).stock()
    if args.format == "json":
        print(json.dumps({kind: asdict(stock) for kind, stock in stocks.items()}, indent=2))
        return
    every = Stock(sum(x.keys for x in stocks.values()), sum(x.size for x in stocks.values()))
    rows = [
        [kind, str(x.keys), _bytes(x.size), _age(x.oldest)] for kind, x in [*stocks.items(), ("all", every)]
    ]
    write_columns([["KIND", "KEYS", "BYTES", "OLDEST"], *rows])


def _prune(args: argparse.Namespace, redis: Redis, settings: WorkerSettings) -> None:
    """Remove old results, eliminants and ended jobs."""
    from worker.jobs.inventory import Inventory

    pruned = Inventory(redis, settings).prune(args.older_than, args.max_bytes)
    needed = f"; {pruned.needed} keys are kept, since active jobs may need them" if pruned.needed else ""
    print(f"removed {pruned.keys} keys, {_bytes(pruned.size)}{needed}")


def _archive(_args: argparse.Namespace, redis: Redis, settings: WorkerSettings) -> None:
    """Move all answers to the archive (RPR_CUSPS_ARCHIVE_URL) now, whatever their age, and remove objects
    there that are no longer needed. Workers do both by themselves, later."""
    from worker.answers.archive import ArchiveAwayError, archive_of
    from worker.answers.layout import ARCHIVE_TTL
    from worker.jobs.archiving import Mover

    if settings.archive_url is None:
        raise InputError.of("RPR_CUSPS_ARCHIVE_URL", "is not set; it says where the archive is")
    try:
        mover = Mover(redis, settings, archive_of(settings))
        moved = mover.move(_LONGEST_MOVE, everything=True)
        removed = mover.collect(ARCHIVE_TTL + 86400)
    except ArchiveAwayError as error:
        raise ServiceError(f"{error}; what has not moved stays in Redis") from error
    print(f"moved {moved} answers; removed {removed} objects that are no longer needed")


def _duration(text: str) -> float:
    match = re.fullmatch(r"(\d{1,9}(?:\.\d+)?)([smhd])", text, re.ASCII)
    if match is None:
        raise argparse.ArgumentTypeError(f"{clipped(text)!r} is not an age, such as 90s, 30m, 12h or 30d")
    return float(match[1]) * _SECONDS[match[2]]


def _size(text: str) -> int:
    match = re.fullmatch(r"(\d{1,15})([kMG]B|[KMG]iB|)", text, re.ASCII)
    if match is None:
        raise argparse.ArgumentTypeError(f"{clipped(text)!r} is not a size, such as 500MB, 2GiB or 1000000")
    return int(match[1]) * _BYTES[match[2]]


def _bytes(size: int) -> str:
    unit = next((name for name in ("GB", "MB", "kB") if size >= _BYTES[name]), "")
    return f"{size / _BYTES[unit]:.1f} {unit}" if unit else f"{size} B"


def _age(seconds: float | None) -> str:
    if seconds is None:
        return "–"
    unit = next((name for name in "dhm" if seconds >= _SECONDS[name]), "s")
    return f"{seconds / _SECONDS[unit]:.1f} {unit}"


_DAY = 86400.0
_WITHOUT_KEYS = (
    "`rpr-cusps serve --insecure` (or RPR_CUSPS_REQUIRE_KEYS=never) gives access without keys again"
)


def _configure_keys(parser: argparse.ArgumentParser) -> None:
    """Add the actions and their options."""
    add = parsers.actions_of(parser)
    create = add(_create, "make a key and print it")
    create.add_argument("name", metavar="NAME", help="name of the new key")
    create.add_argument(
        "--scope",
        choices=SCOPES,
        default="submit",
        help="what the key allows: read results, submit questions, or admin: metrics and every job "
        "(default: submit); each includes those before it",
    )
    create.add_argument(
        "--days",
        type=whole("a number of days", 36500, low=1),
        metavar="N",
        help="number of days after which the key expires (default: never)",
    )
    show = add(_list, "list all keys")
    show.add_argument("--format", choices=("table", "json"), default="table", help="default: table")
    revoke = add(_revoke, "revoke a key")
    revoke.add_argument("name", metavar="NAME", help="name or id of the key")
    for action in (create, show, revoke):
        add_source(action)


def _run_keys(args: argparse.Namespace) -> int:
    """Create, list and revoke the API keys of a service. They are stored with its jobs: in the given Redis,
    or in a data directory, whether or not the service is running. A change takes effect within two seconds.

    examples:
      rpr-cusps keys create calibration-rig                     a key for questions; it is shown once
      rpr-cusps keys create prometheus --scope admin --days 365
      rpr-cusps keys list
      rpr-cusps keys revoke calibration-rig

    Clients send the key as `Authorization: Bearer rpr_…`; `rpr-cusps solve --url` takes it from
    RPR_CUSPS_API_KEY.
    """
    from service.api.keys import KeyStore

    with opened(args) as redis:
        store = KeyStore(redis, WorkerSettings().key_prefix)
        args.act(store, args)
    return 0


def _create(store: KeyStore, args: argparse.Namespace) -> None:
    """Create a key and print it."""
    from service.api.keys import is_name, make_key

    if not is_name(args.name):
        hint = "give 1 to 64 letters, digits, or . _ @ + -, beginning with a letter or digit"
        raise InputError.of("NAME", f"{clipped(args.name, 80)!r} cannot be the name of a key; {hint}")
    now = time.time()
    expires = None if args.days is None else now + args.days * _DAY
    key, token = make_key(args.name, args.scope, now, expires)
    is_first = not store.all()
    if not store.add(key, now):
        raise InputError.of(
            "NAME", f"{key.name!r} is the name of a key already; revoke it or take another name"
        )
    until = "does not expire" if expires is None else f"expires at {_date(expires)}"
    print(f"key {key.name} (scope {key.scope}, {until}); this is shown only once:", file=sys.stderr)
    print(token)
    if is_first:
        print(
            "this is the first key: from now on every client needs one, also the explorer and commands on "
            f"this computer (RPR_CUSPS_API_KEY), even if it is revoked; {_WITHOUT_KEYS}",
            file=sys.stderr,
        )


def _revoke(store: KeyStore, args: argparse.Namespace) -> None:
    """Revoke a key permanently."""
    name = args.name
    key = store.revoke(name, time.time())
    if key is None:
        raise InputError.of(
            "NAME", f"{clipped(name, 80)!r} is the name or id of no valid key; keys list shows all"
        )
    print(f"key {key.name} ({key.id}) is revoked", file=sys.stderr)
    if not any(other.state(time.time()) == "valid" for other in store.all().values()):
        print(f"no valid key is left, and every client still needs one; {_WITHOUT_KEYS}", file=sys.stderr)


def _list(store: KeyStore, args: argparse.Namespace) -> None:
    """List all keys, never their secrets."""
    now, uses = time.time(), store.last_uses()
    keys = [
        {
            "id": key.id,
            "name": key.name,
            "scope": key.scope,
            "state": key.state(now),
            **{name: _date(asdict(key)[name]) for name in ("created", "expires", "revoked")},
            "last_used": _date(uses.get(key.id)),
        }
        for key in sorted(store.all().values(), key=lambda key: key.created)
    ]
    if args.format == "json":
        print(json.dumps(keys, indent=2))
        return
    columns = ("id", "name", "scope", "state", "created", "expires", "last_used")
    titles = [column.upper().replace("_", " ") for column in columns]
    write_columns([titles, *([key[column] or "-" for column in columns] for key in keys)])


def _date(moment: float | None) -> str | None:
    if moment is None:
        return None
    return datetime.fromtimestamp(moment, UTC).isoformat(timespec="seconds").replace("+00:00", "Z")


COMMANDS = {"store": Command.of(_run_store, _configure_store), "keys": Command.of(_run_keys, _configure_keys)}
