"""All lengths of one leg: the transitions at which the number of cusps changes, and proofs based on them."""
