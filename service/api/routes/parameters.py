"""The parameters of a query: those that a call does not have are refused."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Collection, Coroutine
from typing import Any

from fastapi import Request, Response
from fastapi.dependencies.utils import get_flat_params
from fastapi.routing import APIRoute

from rpr_solver.errors import InputError, clipped
from service.api.contract.responses import FORM
from service.api.problems import ProblemError


class CheckedRoute(APIRoute):
    """A route that knows which parameters its query may have."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Returns the endpoint, behind the check of the query."""
        handle, known = self._handler(), _names(self)

        async def checked(request: Request) -> Response:
            names = [name for name, _ in request.query_params.multi_items()]
            for name in names:
                check_known(name, known)
            if len(set(names)) < len(names):
                twice = next(name for name in names if names.count(name) > 1)
                raise _refused(InputError.of(twice, "this parameter is given twice"))
            return await handle(request)

        return checked

    def _handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        return super().get_route_handler()


def _names(route: APIRoute) -> list[str]:
    """The parameters that FastAPI reads, and those that are described beside them."""
    read = [field.alias for field in get_flat_params(route.dependant)]
    extra = (route.openapi_extra or {}).get("parameters", ())
    described = [part["name"] for part in extra if part.get("in") == "query"]
    described += ["format"] if FORM in extra else []
    return [name for name in (*read, *described) if f"{{{name}}}" not in route.path_format]


def check_known(name: str, known: Collection[str]) -> None:
    """Refuse a parameter that a call does not have.

    Raises:
        ProblemError: 422, it is not known.
    """
    if name in known:
        return
    near = difflib.get_close_matches(name[:60].lower(), known, n=1)
    hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}" if known else "omit it"
    raise _refused(InputError.of(clipped(name) or "query", f"unknown parameter; {hint}"))


def _refused(error: InputError) -> ProblemError:
    problem = ProblemError.of_input(error)
    problem.in_body = False
    return problem
