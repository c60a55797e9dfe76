"""The routes of the API."""

from service.api.routes.routing import router

__all__ = [
    "router",
]
