"""Documents as scripts for other systems, so that anyone can compute the same with a tool of their own."""
