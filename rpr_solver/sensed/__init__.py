"""Poses from what sensors say: lengths of some legs, and angles of some."""
