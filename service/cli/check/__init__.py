"""Checks of requirements, and their reports."""
