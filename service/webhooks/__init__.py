"""Webhooks: the news that a job or a batch has ended, sent to the callers who asked for it."""
