"""Answers to questions: read, looked up or computed, and sent in the form that was asked for."""
