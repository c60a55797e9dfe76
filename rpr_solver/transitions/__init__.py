"""All lengths of one leg: where the number of cusps changes, and what follows from it."""
