"""Margins: how far the lengths of a manipulator may change before its numbers of cusps do."""
