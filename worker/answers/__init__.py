"""Answers: slices and documents, computed and kept."""
