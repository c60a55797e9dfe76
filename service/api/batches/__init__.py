"""Batches: many questions in one request."""
