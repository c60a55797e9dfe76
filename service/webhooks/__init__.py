"""Webhooks: calls to an address when a job has ended."""

from service.webhooks.target import WebhookSettings, fits, target_of

__all__ = [
    "WebhookSettings",
    "fits",
    "target_of",
]
