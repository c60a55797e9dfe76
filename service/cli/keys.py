"""Create, list and revoke the API keys of a service. They are stored with its jobs: in the given Redis, or in
a data directory, whether or not the service is running. A change takes effect within two seconds."""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import asdict
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from rpr_solver.errors import InputError
from service.api.settings import SCOPES
from service.cli.help import Command, whole
from service.cli.options import add_source, opened
from service.cli.output import write_columns
from worker.settings import WorkerSettings

if TYPE_CHECKING:
    from service.api.access.keys import KeyStore

DESCRIPTION = __doc__
EXAMPLES = """\
examples:
  rpr-cusps keys create calibration-rig                     a key for questions; it is shown once
  rpr-cusps keys create prometheus --scope admin --days 365
  rpr-cusps keys list
  rpr-cusps keys revoke calibration-rig

Clients send the key as `Authorization: Bearer rpr_…`; `rpr-cusps solve --url` takes it from
RPR_CUSPS_API_KEY.
"""
_DAY = 86400.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the actions and their options."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    create = actions.add_parser(
        "create", help="make a key and print it", description="Create a key and print it."
    )
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
    show = actions.add_parser("list", help="list all keys", description="List all keys, never their secrets.")
    show.add_argument("--format", choices=("table", "json"), default="table", help="default: table")
    revoke = actions.add_parser("revoke", help="revoke a key", description="Revoke a key permanently.")
    revoke.add_argument("name", metavar="NAME", help="name or id of the key")
    for action in (create, show, revoke):
        add_source(action)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status.

    Raises:
        InputError: the name cannot be one, is taken, or is no key's.
        ServiceError: the keys cannot be reached.
    """
    from service.api.access.keys import KeyStore

    with opened(args) as redis:
        store = KeyStore(redis, WorkerSettings().key_prefix)
        if args.action == "create":
            _create(store, args)
        elif args.action == "revoke":
            _revoke(store, args.name)
        else:
            _list(store, args.format)
    return 0


def _create(store: KeyStore, args: argparse.Namespace) -> None:
    from service.api.access.keys import is_name, make_key

    if not is_name(args.name):
        hint = "give 1 to 64 letters, digits, or . _ @ + -, beginning with a letter or digit"
        raise InputError.of("NAME", f"{args.name[:80]!r} cannot be the name of a key; {hint}")
    now = time.time()
    expires = None if args.days is None else now + args.days * _DAY
    key, token = make_key(args.name, args.scope, now, expires)
    if not store.add(key, now):
        raise InputError.of(
            "NAME", f"{key.name!r} is the name of a key already; revoke it or take another name"
        )
    until = "does not expire" if expires is None else f"expires at {_date(expires)}"
    print(f"key {key.name} (scope {key.scope}, {until}); this is shown only once:", file=sys.stderr)
    print(token)


def _revoke(store: KeyStore, name: str) -> None:
    key = store.revoke(name, time.time())
    if key is None:
        raise InputError.of("NAME", f"{name[:80]!r} is the name or id of no valid key; keys list shows all")
    print(f"key {key.name} ({key.id}) is revoked", file=sys.stderr)


def _list(store: KeyStore, form: str) -> None:
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
    if form == "json":
        print(json.dumps(keys, indent=2))
        return
    columns = ("id", "name", "scope", "state", "created", "expires", "last_used")
    titles = [column.upper().replace("_", " ") for column in columns]
    write_columns([titles, *([key[column] or "-" for column in columns] for key in keys)])


def _date(moment: float | None) -> str | None:
    if moment is None:
        return None
    return datetime.fromtimestamp(moment, UTC).isoformat(timespec="seconds").replace("+00:00", "Z")


COMMANDS = {"keys": Command(DESCRIPTION, EXAMPLES, configure, run)}
