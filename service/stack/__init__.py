"""The whole service on one machine."""

API = "service.stack.api_process"
"""The module of the program that answers HTTP."""
