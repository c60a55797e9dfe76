"""Webhooks: events at the end of jobs and batches, sent to the clients' URLs."""
