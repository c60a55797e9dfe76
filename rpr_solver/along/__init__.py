"""Poses along a leg: two lengths given, and one in a range."""
