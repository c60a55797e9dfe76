"""Cusps followed through all lengths of one leg."""
